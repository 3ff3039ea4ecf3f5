//! Diagnostics as text: for people (with the source line and a mark under the place) and as JSON.
//!
//! The layout for people is codespan's. Output has no colours here; a caller that writes to a terminal adds them. What
//! would command a terminal is [written out](visible()) in all texts; [`json`] and [`sarif`] are values, whose texts
//! [`visible_json`] makes fit for one.

mod sarif;
mod visible;

pub use sarif::sarif;
pub use visible::{visible, visible_json};

use codespan_reporting::diagnostic as report;
use codespan_reporting::files::{Error, Files};
use codespan_reporting::term;
use std::collections::BTreeSet;
use std::ops::Range;

use super::{Count, Diagnostic, Extent, Place, Severity, counted};
use crate::document::pointer_join;
use crate::source::{FileId, Sources};

/// Renders one diagnostic as plain text: message, source line with a mark, related places and help.
///
/// ```
/// use umbragraph_text::diagnostic::{codes, render, Diagnostic};
/// use umbragraph_text::source::{Sources, Span};
///
/// let mut sources = Sources::new();
/// let file = sources.add("a.json", "{ \"naem\": 1 }");
/// let diagnostic = Diagnostic::error(codes::UNKNOWN_KEY, Span::new(file, 2..8), "unknown key \"naem\"")
///     .help("did you mean \"name\"?");
/// let text = render::human(&diagnostic, &sources);
/// assert!(text.contains("a.json:1:3"));
/// ```
pub fn human(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let severity = match diagnostic.severity {
        Severity::Error => report::Severity::Error,
        Severity::Warning => report::Severity::Warning,
        Severity::Note => report::Severity::Note,
    };
    let mut labels = Vec::new();
    let mut notes = Vec::new();
    match &diagnostic.place {
        Place::Span(span) => labels.push(report::Label::primary(span.file, span.range())),
        Place::File { path, locator } if locator.is_empty() => notes.push(format!("in {path}")),
        Place::File { path, locator } => notes.push(format!("in {path} at {locator}")),
        Place::Nowhere => {}
    }
    for related in &diagnostic.related {
        match &related.place {
            Place::Span(span) => {
                labels.push(report::Label::secondary(span.file, span.range()).with_message(&related.message));
            }
            Place::File { path, locator } => notes.push(format!("{}: {path} {locator}", related.message)),
            Place::Nowhere => notes.push(related.message.clone()),
        }
    }
    notes.extend(diagnostic.help.iter().map(|help| format!("help: {help}")));
    if labels.iter().any(|label| is_long(sources, label.file_id, label.range.start)) {
        return visible(&compact(diagnostic, sources, &notes)).into_owned();
    }
    let report = report::Diagnostic::new(severity)
        .with_code(diagnostic.code.id)
        .with_message(&diagnostic.message)
        .with_labels(labels)
        .with_notes(notes);
    let config = term::Config { chars: term::Chars::ascii(), ..term::Config::default() };
    let text = term::emit_into_string(&config, &View(sources), &report)
        .unwrap_or_else(|_| format!("{}: {}\n", diagnostic.code, diagnostic.message));
    visible(&text).into_owned()
}

/// The maximum length, in bytes, of a source line that is shown in full.
const MAX_LINE: usize = 300;

fn is_long(sources: &Sources, file: FileId, start: usize) -> bool {
    let Some(file) = sources.get(file) else { return false };
    let position = file.line_column(u32::try_from(start).unwrap_or(u32::MAX));
    file.line(position.line).len() > MAX_LINE
}

/// Renders a diagnostic with an excerpt of the source line around its place, for lines longer than [`MAX_LINE`].
fn compact(diagnostic: &Diagnostic, sources: &Sources, notes: &[String]) -> String {
    let severity = diagnostic.severity.name();
    let mut text = format!("{severity}[{}]: {}\n", diagnostic.code, super::shorten(&diagnostic.message));
    let places = std::iter::once((&diagnostic.place, ""))
        .chain(diagnostic.related.iter().map(|one| (&one.place, one.message.as_str())));
    for (place, message) in places {
        let Place::Span(span) = place else { continue };
        let Some(file) = sources.get(span.file) else { continue };
        let position = file.line_column(span.start);
        let line = file.line(position.line);
        let column = position.column as usize - 1;
        let excerpt: String = line.chars().skip(column.saturating_sub(40)).take(120).collect();
        text.push_str(&format!("  --> {}:{}:{}\n", file.name(), position.line, position.column));
        text.push_str(&format!("   | …{excerpt}…\n   |  {}^ {message}\n", " ".repeat(column.min(40))));
    }
    for note in notes {
        text.push_str(&format!("   = {note}\n"));
    }
    text.push('\n');
    text
}

/// The maximum number of diagnostics that are rendered; the others are only counted.
const MAX_SHOWN: usize = 200;

/// Renders up to 200 diagnostics as plain text, followed by a line with the numbers of errors and warnings.
pub fn human_all<'a>(diagnostics: impl IntoIterator<Item = &'a Diagnostic>, sources: &Sources) -> String {
    let mut text = String::new();
    let (mut errors, mut warnings) = (0, 0);
    let mut shown = 0;
    for diagnostic in diagnostics {
        if shown < MAX_SHOWN {
            text.push_str(&human(diagnostic, sources));
        }
        shown += 1;
        match diagnostic.severity {
            Severity::Error => errors += 1,
            Severity::Warning => warnings += 1,
            Severity::Note => {}
        }
    }
    if shown > MAX_SHOWN {
        text.push_str(&format!("{} more diagnostics are not shown\n", shown - MAX_SHOWN));
    }
    let counts = [(errors, "error"), (warnings, "warning")].into_iter().filter(|(number, _)| *number > 0);
    let counts: Vec<String> = counts.map(|(number, noun)| counted(number, noun)).collect();
    if !counts.is_empty() {
        text.push_str(&format!("{}\n", counts.join(", ")));
    }
    text
}

/// Renders one diagnostic as a GitHub Actions annotation on one line, such as `::error file=…::message`.
pub fn github(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let level = match diagnostic.severity {
        Severity::Note => "notice",
        severity => severity.name(),
    };
    let escape = |text: &str| visible(text).replace('%', "%25").replace('\n', "%0A");
    let property = |text: &str| escape(text).replace(':', "%3A").replace(',', "%2C");
    let place = match &diagnostic.place {
        Place::Span(span) => sources.get(span.file).map(|file| {
            let (start, end) = (file.line_column(span.start), file.line_column(span.end));
            let name = property(file.name());
            let lines = format!("file={name},line={},endLine={}", start.line, end.line.max(start.line));
            // Columns are only understood within one line.
            if start.line == end.line {
                format!("{lines},col={},endColumn={},", start.column, end.column)
            } else {
                format!("{lines},")
            }
        }),
        Place::File { path, .. } => Some(format!("file={},", property(path))),
        Place::Nowhere => None,
    };
    let title = property(&format!("{}: {}", diagnostic.code.id, diagnostic.code.title));
    let mut message = diagnostic.message.clone();
    for related in &diagnostic.related {
        message.push_str(&format!("\n{}", related.message));
        if let Place::Span(span) = related.place
            && let Some(file) = sources.get(span.file)
        {
            message.push_str(&format!(" ({}:{})", file.name(), file.line_column(span.start).line));
        }
    }
    message.extend(diagnostic.help.iter().map(|help| format!("\nhelp: {help}")));
    format!("::{level} {}title={title}::{}\n", place.unwrap_or_default(), escape(&message))
}

/// Returns one diagnostic as a JSON object: `code`, `title`, `severity`, `message`, `place` (`file`, `line`, `column`,
/// `end_line`, `end_column`, `pointer`), `related`, `help`, `fix` (a list of edits, each with `place` and
/// `replacement`).
///
/// A diagnostic about shader variants has four further members. `variants` is the number of affected variants.
/// `provoked_by` is a minimal set of axis values that causes the diagnostic in the first template. `profiles` lists the
/// names of the affected target profiles. `templates` has one object for each template: `template`, `variants`,
/// `of_variants`, `configurations` (`number` and `exact`), `provoked_by` and `profiles`.
pub fn json(diagnostic: &Diagnostic, sources: &Sources) -> serde_json::Value {
    let mut value = serde_json::json!({
        "code": diagnostic.code.id,
        "title": diagnostic.code.title,
        "severity": diagnostic.severity,
        "message": diagnostic.message,
        "place": json_place(&diagnostic.place, &diagnostic.pointer, sources),
        "related": diagnostic.related.iter().map(|related| serde_json::json!({
            "place": json_place(&related.place, "", sources),
            "message": related.message,
        })).collect::<Vec<_>>(),
        "help": diagnostic.help,
        "fix": diagnostic.fix.as_ref().map(|fix| fix.edits.iter().map(|edit| serde_json::json!({
            "place": json_place(&Place::Span(edit.span), "", sources),
            "replacement": edit.replacement,
        })).collect::<Vec<_>>()),
    });
    if let (Some(first), Some(members)) = (diagnostic.extent.first(), value.as_object_mut()) {
        let extents = &diagnostic.extent;
        let variants: usize = extents.iter().map(|extent| extent.variants).sum();
        let profiles: BTreeSet<&String> = extents.iter().flat_map(|extent| &extent.profiles).collect();
        let templates: Vec<serde_json::Value> = extents.iter().map(json_extent).collect();
        members.insert("variants".to_owned(), variants.into());
        members.insert("provoked_by".to_owned(), serde_json::json!(first.provoked_by));
        members.insert("profiles".to_owned(), serde_json::json!(profiles));
        members.insert("templates".to_owned(), templates.into());
    }
    value
}

fn json_extent(extent: &Extent) -> serde_json::Value {
    // A number beyond 64 bits is a lower bound there.
    let Count { number, exact } = extent.configurations;
    let fits = u64::try_from(number);
    serde_json::json!({
        "template": extent.template,
        "variants": extent.variants,
        "of_variants": extent.of_variants,
        "configurations": { "number": fits.unwrap_or(u64::MAX), "exact": exact && fits.is_ok() },
        "provoked_by": extent.provoked_by,
        "profiles": extent.profiles,
    })
}

fn json_place(place: &Place, pointer: &str, sources: &Sources) -> serde_json::Value {
    match place {
        Place::Span(span) => {
            let Some(file) = sources.get(span.file) else { return serde_json::Value::Null };
            let (start, end) = (file.line_column(span.start), file.line_column(span.end));
            let pointer = in_file(file.name(), pointer);
            serde_json::json!({
                "file": file.name(), "line": start.line, "column": start.column,
                "end_line": end.line, "end_column": end.column, "pointer": pointer,
            })
        }
        Place::File { path, locator } => serde_json::json!({ "file": path, "pointer": locator }),
        Place::Nowhere => serde_json::Value::Null,
    }
}

/// Converts a JSON pointer in the composed document to the pointer of the same value in the file `name`. The composed
/// document has a subgraph file under `/subgraphs`, with the file's path as the key.
fn in_file<'a>(name: &str, pointer: &'a str) -> &'a str {
    let below = pointer.strip_prefix(pointer_join("/subgraphs", name).as_str());
    below.filter(|below| below.is_empty() || below.starts_with('/')).unwrap_or(pointer)
}

/// Adapts [`Sources`] to codespan's [`Files`] trait. Offsets are clamped, so that an invalid span cannot make rendering
/// fail.
struct View<'a>(&'a Sources);

impl<'a> Files<'a> for View<'a> {
    type FileId = FileId;
    type Name = &'a str;
    type Source = &'a str;

    fn name(&'a self, id: FileId) -> Result<&'a str, Error> {
        self.0.get(id).map(|file| file.name()).ok_or(Error::FileMissing)
    }

    fn source(&'a self, id: FileId) -> Result<&'a str, Error> {
        self.0.get(id).map(|file| &**file.text()).ok_or(Error::FileMissing)
    }

    fn line_index(&'a self, id: FileId, byte_index: usize) -> Result<usize, Error> {
        let file = self.0.get(id).ok_or(Error::FileMissing)?;
        Ok(file.line_column(u32::try_from(byte_index).unwrap_or(u32::MAX)).line as usize - 1)
    }

    fn line_range(&'a self, id: FileId, line_index: usize) -> Result<Range<usize>, Error> {
        self.0.get(id).and_then(|file| file.line_range(line_index)).ok_or(Error::FileMissing)
    }
}
