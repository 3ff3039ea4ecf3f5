//! Pipelines and parameter files, taken to their plans.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use umbragraph::Bundled;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, render};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::compose::{Files as _, Named, Roots};
use umbragraph::low_level::document;
use umbragraph::low_level::pipeline::{ParameterFile, of_preset};
use umbragraph::low_level::session::{Choice, Planned, Session, Storage, Target, Template, TemplateText};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::low_level::source::{FileId, Sources};

use crate::mutation::{self, Choices};
use crate::worker::note;

/// The files of the workspace, in which a worker runs.
struct Workspace;

impl Storage for Workspace {
    fn read(&mut self, path: &Path, _: Option<&Roots>, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        Bundled(Named).read(path, sources)
    }
}

/// Inputs that share a session: what it keeps of each is little, but not nothing.
const SHARED: usize = 200;

/// Lends a session to an input.
fn with_session(work: impl FnOnce(&mut Session)) {
    thread_local!(static KNOWN: RefCell<(usize, Option<Session>)> = const { RefCell::new((0, None)) });
    // One that a panic has gone through is not put back.
    let (used, known) = KNOWN.take();
    let own = [
        ("display.wgsl.jinja", include_str!("../../../broken/display.wgsl.jinja")),
        ("display.axes.json", include_str!("../../../broken/display.axes.json")),
    ];
    let own =
        own.map(|(name, text)| Template { name: name.to_owned(), text: TemplateText::Text(text.into()) });
    let new = || Session::new(Workspace, umbragraph::registry(), umbragraph::with_templates(own));
    let mut session = known.filter(|_| used < SHARED).unwrap_or_else(new);
    work(&mut session);
    KNOWN.set((used % SHARED + 1, Some(session)));
}

/// Texts of the workspace by their paths.
struct Corpus(Vec<(PathBuf, String)>);

impl Corpus {
    fn of(files: &[&str], folders: &[&str]) -> Self {
        let below = folders.iter().flat_map(|folder| {
            let entries = std::fs::read_dir(folder).expect("a folder of the workspace");
            let mut found: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
            found.sort();
            found
        });
        let all = files.iter().map(PathBuf::from).chain(below).filter(|path| path.is_file());
        let read = |path: PathBuf| {
            let text = std::fs::read_to_string(&path).expect("a file of the workspace");
            (path, text)
        };
        Self(all.map(read).collect())
    }
}

/// Small documents that together use all of the language.
fn small() -> Corpus {
    Corpus::of(
        &["tests/broken/chain.json", "tests/broken/chain.json", "tests/broken/chain.json"],
        &["pipelines/learn", "pipelines/learn/parts", "pipelines/effects", "pipelines/parts"],
    )
}

/// Asserts that diagnostics stand inside their texts, and that there is one where there is no plan.
fn judge(planned: &Planned, diagnostics: &Diagnostics, sources: &Sources) {
    for diagnostic in diagnostics {
        // A panic of naga's is caught, and told of with this code.
        assert_ne!(diagnostic.code.id, "UG0523", "{}", diagnostic.message);
        let related = diagnostic.related.iter().map(|related| &related.place);
        for place in related.chain([&diagnostic.place]) {
            let Place::Span(span) = place else { continue };
            let length = sources.get(span.file).map_or(0, |file| file.text().len());
            let is_inside = span.start <= span.end && span.end as usize <= length;
            assert!(is_inside, "\"{}\" at {span:?} of {length} bytes", diagnostic.message);
        }
    }
    assert!(planned.report.plan.is_some() || diagnostics.has_errors(), "no plan, and no word of it");
    let said = render::human_all(diagnostics, sources);
    assert_eq!(said.is_empty(), diagnostics.is_empty(), "{said}");
    assert!(said.len() < 1 << 20, "{} bytes of diagnostics", said.len());
}

fn choice() -> Choice {
    Choice::new(TargetProfile::webgpu(), PlanOptions::new(640, 480))
}

fn plan(session: &mut Session, target: &Target, choice: &Choice, mut found: Diagnostics) {
    let (planned, more) = session.plan(target, choice).unwrap_or_else(|_| panic!("nothing cancels it"));
    found.extend(more);
    judge(&planned, &found, session.sources());
}

/// A plan, or an error inside a text.
pub(crate) fn documents(choices: &mut Choices<'_>) {
    thread_local!(static CORPUS: Corpus = small());
    CORPUS.with(|Corpus(all)| {
        let ((path, text), (_, other)) = (choices.one_of(all), choices.one_of(all));
        let text = mutation::changed(text, other, choices);
        note(text.as_bytes());
        with_session(|session| {
            session.overlay(path, text.as_bytes());
            plan(session, &Target::new(path), &choice(), Diagnostics::new());
            session.close(path);
        });
    });
}

/// A session over files that change, with a plan or an error after each step.
pub(crate) fn overlays(choices: &mut Choices<'_>) {
    // Files that name one another.
    thread_local! {
        static CORPUS: Corpus = Corpus::of(
            &["pipelines/learn/06-extends.json", "pipelines/learn/07-include.json", "pipelines/learn/21-subgraph-file.json"],
            &["pipelines/learn/parts"],
        );
    }
    CORPUS.with(|Corpus(all)| {
        let mut said = Vec::new();
        with_session(|session| {
            let roots: Vec<&PathBuf> = all.iter().map(|(path, _)| path).take(3).collect();
            for _ in 0..=choices.below(3) {
                let (path, text) = choices.one_of(all);
                let mut bytes = mutation::changed(text, &all[0].1, choices).into_bytes();
                match choices.below(6) {
                    0 => session.close(path),
                    1 => session.changed(path),
                    2 => {
                        mutation::changed_bytes(&mut bytes, choices);
                        session.overlay(path, bytes.as_slice());
                    }
                    _ => session.overlay(path, bytes.as_slice()),
                }
                said.extend(format!("\n== {}\n", path.display()).into_bytes());
                said.extend(bytes);
                note(said.clone());
                plan(session, &Target::new(*choices.one_of(&roots)), &choice(), Diagnostics::new());
            }
            all.iter().for_each(|(path, _)| session.close(path));
        });
    });
}

/// Pipelines, each with a parameter file that fits it.
const FITTING: [(&str, &str); 3] = [
    (
        "pipelines/learn/13-presets.json",
        r#"{ "preset": "high", "parameters": { "width": 300, "height": 20 } }"#,
    ),
    ("pipelines/learn/10-features.json", r#"{ "features": { "glow": true, "strong_glow": false } }"#),
    ("pipelines/learn/31-constraints.json", r#"{ "parameters": { "wide": 128, "high": 8 } }"#),
];

/// A parameter file over a pipeline: a plan, or an error inside a text.
pub(crate) fn parameters(choices: &mut Choices<'_>) {
    let (path, text) = choices.one_of(&FITTING);
    let other = std::fs::read_to_string(path).unwrap_or_default();
    let text = mutation::changed(text, &other, choices);
    note(text.as_bytes());
    with_session(|session| with_parameters(session, path, &text));
}

fn with_parameters(session: &mut Session, path: &str, text: &str) {
    let target = Target::new(path);
    let file = session.text("parameters.json", text).file;
    let mut found = Diagnostics::new();
    let values = match document::parse(session.sources(), file).valid() {
        Ok(values) => values,
        Err(errors) => return assert!(errors.has_errors()),
    };
    let ParameterFile { preset, overrides, .. } = ParameterFile::read(&values, &mut found);
    let loaded = session.load_exactly(&target).unwrap_or_else(|_| panic!("nothing cancels it"));
    let below = preset
        .zip(loaded.document())
        .map(|((name, place), document)| of_preset(document, &name, place, &mut found));
    let overrides = below.map_or(overrides.clone(), |below| below.under(overrides));
    plan(session, &target, &choice().overrides(overrides), found);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_planned(session: &mut Session, path: &str, choice: &Choice) {
        let (planned, found) = session.plan(&Target::new(path), choice).unwrap();
        assert!(planned.report.plan.is_some() && !found.has_errors(), "{path}: {found:?}");
    }

    #[test]
    fn seeds_are_planned_as_they_are() {
        std::env::set_current_dir(crate::counts::root()).unwrap();
        with_session(|session| {
            for (path, text) in small().0 {
                // Parts are no pipelines.
                if !["parts", "effects"].iter().any(|part| path.to_string_lossy().contains(part)) {
                    session.overlay(&path, text.as_bytes());
                    is_planned(session, &path.to_string_lossy(), &choice());
                }
            }
            FITTING.iter().for_each(|(path, text)| {
                with_parameters(session, path, text);
                is_planned(session, path, &choice());
            });
        });
    }
}
