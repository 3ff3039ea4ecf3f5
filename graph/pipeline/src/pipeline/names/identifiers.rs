//! Names: what can be one, and what to say of one that is not known.

use umbragraph_text::diagnostic::{Diagnostic, codes};
use umbragraph_text::document::Entry;
use umbragraph_text::source::Span;

/// Names that parameters and features cannot have, because the expression language uses them.
const RESERVED: &[&str] = &["viewport", "true", "false"];

/// The names by which expressions refer to the viewport, and to its width and height in pixels.
pub(crate) const VIEWPORT: &[&str] = &["viewport", "viewport.width", "viewport.height"];

/// Returns `true` if `name` is the name of the pass, or of a loop or use of a subgraph that contains the pass.
pub fn is_of(pass: &str, name: &str) -> bool {
    pass.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Returns `true` for a part of a pass name that is the round of a loop: `2` of `down.2`.
pub fn is_round(part: &str) -> bool {
    part.starts_with(|first: char| first.is_ascii_digit())
}

/// Returns `true` for a valid name: a letter, then letters, digits and underscores (ASCII).
fn is_name(name: &str) -> bool {
    name.chars().next().is_some_and(|first| first.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// The diagnostic for a declaration whose name is invalid or reserved; `None` for a valid name.
pub(crate) fn name_diagnostic(entry: &Entry) -> Option<Diagnostic> {
    let is_bad = !is_name(&entry.key) || RESERVED.contains(&entry.key.as_str());
    is_bad.then(|| {
        Diagnostic::error(codes::BAD_NAME, entry.key_span, format!("\"{}\" cannot be a name here", entry.key))
            .help("a name starts with a letter, goes on with letters, digits and underscores, and is no word of the expression language")
    })
}

/// The diagnostic for a name that two kinds of declarations have, such as a parameter and a feature.
pub(crate) fn twin_diagnostic(entry: &Entry, what: &str, (twin, other): (Span, &str)) -> Diagnostic {
    let article = if other.starts_with('i') { "an" } else { "a" };
    let message = format!("\"{}\" is a {what} and {article} {other}", entry.key);
    let diagnostic = Diagnostic::error(codes::BAD_NAME, entry.key_span, message);
    diagnostic.related(twin, format!("the {other}")).help("give one of the two another name")
}
