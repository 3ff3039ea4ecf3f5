//! `umbragraph check --fix`: applies fixes until none is left, and writes what changed.
//!
//! All rounds go over texts in memory; files are written once, at the end, each as a whole: to a temporary file beside
//! it, which is then renamed. A file that somebody else changed meanwhile is left alone.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use similar::TextDiff;
use umbragraph::diagnostic::Diagnostic;
use umbragraph::low_level::edit::{self, Edit, Edits};
use umbragraph::low_level::source::SourceFile;

use crate::arguments::CheckArguments;
use crate::replace::replace_if;
use crate::session::Session;
use crate::streams::{complain, print_contents};

/// The maximum number of rounds; each round fixes at least one diagnostic.
const MAX_ROUNDS: usize = 64;

/// The files that fixes have changed.
#[derive(Default)]
pub(crate) struct Mended {
    files: BTreeMap<String, File>,
}

/// The contents of a changed file.
struct File {
    /// The text before the changes.
    original: String,
    text: String,
    /// One line of output for each edit.
    lines: Vec<String>,
}

/// Applies, in memory only, all fixes that diagnostics of the pipelines and their files offer. Returns the changed
/// files.
pub(crate) fn mend(arguments: &CheckArguments) -> Mended {
    let mut mended = Mended::default();
    // Texts that were there before: no fix leads back to one.
    let mut seen = BTreeSet::new();
    let mut session = Session::new(&arguments.choices.files);
    let of_templates = session.diagnostics.clone();
    for _ in 0..MAX_ROUNDS {
        session.diagnostics.clone_from(&of_templates);
        for path in &arguments.pipelines {
            session.check_all(path, &arguments.choices, arguments.config, false);
        }
        session.arrange();
        let made = edit::mend(&session.diagnostics, session.sources(), |name| session.has_read(name));
        let sources = session.sources().clone();
        let source = |name: &str| sources.get(sources.find(name)?);
        let with_text = |(name, edits): (String, Edits)| {
            let text = edits.apply(source(&name)?.text()).ok()?;
            Some((name, (edits, text)))
        };
        let made: BTreeMap<String, (Edits, String)> = made.into_iter().filter_map(with_text).collect();
        let texts: Vec<_> = made.iter().map(|(name, (_, text))| (name.clone(), text.clone())).collect();
        if made.is_empty() || !seen.insert(texts) {
            break;
        }
        for (name, (edits, text)) in made {
            let Some(source) = source(&name) else { continue };
            session.overlay(&name, &text);
            let file = mended.files.entry(name).or_insert_with(|| File {
                original: source.text().to_string(),
                text: String::new(),
                lines: Vec::new(),
            });
            file.lines.extend(edits.iter().map(|edit| line(source, edit)));
            file.text = text;
        }
    }
    mended
}

/// Describes one edit in a line for people.
fn line(source: &SourceFile, edit: &Edit) -> String {
    let at = source.line_column(u32::try_from(edit.range.start).unwrap_or(u32::MAX));
    let old = source.text().get(edit.range.clone()).unwrap_or_default().trim();
    let new = edit.replacement.as_str();
    let what = if new.is_empty() { "removed".to_owned() } else { format!("now {new}") };
    format!("fixed {}:{}:{}: {old} {what}\n", source.name(), at.line, at.column)
}

impl Mended {
    /// Returns `true` if no file changes.
    pub(crate) fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Prints the changes as a unified diff.
    pub(crate) fn print_difference(&self) {
        for (name, File { original, text, .. }) in &self.files {
            let difference = TextDiff::from_lines(original.as_str(), text.as_str());
            print_contents(difference.unified_diff().header(name, name).to_string().as_bytes());
        }
    }

    /// Writes the changed files and prints the edits. Returns diagnostics for files that cannot be written.
    pub(crate) fn write(&self) -> Vec<Diagnostic> {
        let mut diagnostics = Vec::new();
        for (name, file) in &self.files {
            match replace_if(Path::new(name), &file.original, &file.text) {
                Ok(()) => file.lines.iter().for_each(|line| complain(line)),
                Err(diagnostic) => diagnostics.push(diagnostic),
            }
        }
        diagnostics
    }
}
