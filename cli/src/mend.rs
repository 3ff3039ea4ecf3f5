//! `umbragraph check --fix`: applies fixes until none is left, and writes what changed.
//!
//! All rounds go over texts in memory; files are written once, at the end, each as a whole: to a temporary file beside it,
//! which is then renamed. A file that somebody else changed meanwhile is left alone.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use similar::TextDiff;
use umbragraph::diagnostic::{Diagnostic, fix};

use crate::arguments::CheckArguments;
use crate::replace::{replace, unwritable};
use crate::session::Session;
use crate::streams::{complain, print_contents};

/// The maximum number of rounds; each mends at least one diagnostic.
const MAX_ROUNDS: usize = 64;

/// What was mended.
#[derive(Default)]
pub(crate) struct Mended {
    /// The new texts by file.
    pub(crate) texts: BTreeMap<String, String>,
    /// The texts as they were read.
    originals: BTreeMap<String, String>,
    /// One line for each edit.
    edits: Vec<String>,
}

/// Applies the fixes of pipelines and of the files that they are made of, in memory.
pub(crate) fn mend(arguments: &CheckArguments) -> Mended {
    let mut mended = Mended::default();
    // Texts that were there before: no fix leads back to one.
    let mut seen = BTreeSet::new();
    for _ in 0..MAX_ROUNDS {
        let mut session = Session::new(&arguments.choices.files);
        session.texts.clone_from(&mended.texts);
        for path in &arguments.pipelines {
            session.check_all(path, &arguments.choices, arguments.config, false);
        }
        session.arrange();
        let fixed = fix::apply(&session.diagnostics, &session.sources, |name| session.files.contains(name));
        let texts: BTreeMap<&String, &String> = fixed.iter().map(|one| (&one.name, &one.text)).collect();
        if fixed.is_empty() || !seen.insert(format!("{texts:?}")) {
            break;
        }
        for one in fixed {
            let Some(file) = session.sources.get(one.file) else { continue };
            for edit in &one.edits {
                let at = file.line_column(edit.span.start);
                let (old, new) = (session.sources.text(edit.span).trim(), edit.replacement.as_str());
                let what = if new.is_empty() { "removed".to_owned() } else { format!("now {new}") };
                mended.edits.push(format!("{}:{}:{}: {old} {what}\n", one.name, at.line, at.column));
            }
            mended.originals.entry(one.name.clone()).or_insert_with(|| file.text().to_string());
            mended.texts.insert(one.name, one.text);
        }
    }
    mended
}

impl Mended {
    /// Whether there is nothing to change.
    pub(crate) fn is_empty(&self) -> bool {
        self.edits.is_empty()
    }

    /// Prints what would change, as a unified diff.
    pub(crate) fn print_difference(&self) {
        for (name, original) in &self.originals {
            let Some(text) = self.texts.get(name) else { continue };
            let difference = TextDiff::from_lines(original.as_str(), text.as_str());
            print_contents(difference.unified_diff().header(name, name).to_string().as_bytes());
        }
    }

    /// Writes the files and says what changed in them; diagnostics for those that cannot be written.
    pub(crate) fn write(&self) -> Vec<Diagnostic> {
        let mut diagnostics = Vec::new();
        for (name, original) in &self.originals {
            let Some(text) = self.texts.get(name) else { continue };
            match write(Path::new(name), original, text) {
                Ok(()) => {
                    let of_file = |line: &&String| line.starts_with(&format!("{name}:"));
                    self.edits.iter().filter(of_file).for_each(|line| complain(&format!("fixed {line}")));
                }
                Err(diagnostic) => diagnostics.push(diagnostic),
            }
        }
        diagnostics
    }
}

fn write(path: &Path, original: &str, text: &str) -> Result<(), Diagnostic> {
    let present = std::fs::read(path).map_err(|error| unwritable(path, &error))?;
    let (mark, rest) = match present.strip_prefix("\u{feff}".as_bytes()) {
        Some(rest) => ("\u{feff}", rest),
        None => ("", present.as_slice()),
    };
    if rest != original.as_bytes() {
        return Err(unwritable(path, &"it was changed meanwhile"));
    }
    replace(path, format!("{mark}{text}"))
}
