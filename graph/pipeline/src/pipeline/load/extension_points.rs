//! The passes that extension points name, against those that are there, whether or not an extension uses the point.
//!
//! Limits: of `NAME.ROUND` only the pass `NAME` is looked for; an extension that uses the point has the rest found.

use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, list_of};
use umbragraph_text::document::{Document, pointer_join};

/// Reports passes under "after" and "before" of extension points that the document does not have. Names that already
/// have a diagnostic are left out.
pub(super) fn check_extension_points(document: &Document, diagnostics: &mut Diagnostics) {
    let section = |name: &str| document.root.entries_of(name);
    let passes = || section("passes").iter().map(|entry| entry.key.as_str());
    for point in section("extension_points") {
        for side in ["after", "before"] {
            let named = point.value.elements_of(side);
            for (at, value) in named.iter().enumerate() {
                let Some(name) = value.text() else { continue };
                let head = name.split('.').next().unwrap_or(name);
                let is_known = passes().any(|pass| pass == head);
                let is_found = diagnostics.iter().any(|diagnostic| diagnostic.span() == Some(value.span));
                if is_known || is_found {
                    continue;
                }
                let message = format!("there is no pass \"{name}\"");
                let pointer = pointer_join("/extension_points", &point.key);
                let mut diagnostic = Diagnostic::error(codes::UNKNOWN_PASS, value.span, message)
                    .pointer(format!("{pointer}/{side}/{at}"));
                if value.span.file != document.root.span.file {
                    let with = format!(
                        "where the pass was deleted, delete the point too: \"extension_points\": {{ \"{}\": null }}",
                        point.key
                    );
                    diagnostic = diagnostic.related(point.key_span, with);
                }
                diagnostics.push(diagnostic.suggest(name, passes(), Some(value.span), |names| {
                    format!("the passes are {}", list_of(names.iter().copied()))
                }));
            }
        }
    }
}
