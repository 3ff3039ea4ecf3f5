//! Sessions: their answers while files change are those of a fresh start, and what did not change is not done again.

mod assist;
mod bad_input;
mod changes;
mod edits;
mod reuse;

use std::collections::BTreeMap;
use std::path::Path;

use umbragraph::diagnostic::{Diagnostic, Diagnostics, render};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::compose::{Memory, Roots};
use umbragraph::low_level::session::{Choice, Session, Storage, Target};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::low_level::source::{FileId, Sources};

/// Files in memory.
struct InMemory(Memory);

impl Storage for InMemory {
    fn read(&mut self, path: &Path, _: Option<&Roots>, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        umbragraph::low_level::compose::Files::read(&mut self.0, path, sources)
    }
}

/// A session over texts by path.
fn session(files: &[(&str, &str)]) -> Session {
    let files: BTreeMap<String, String> =
        files.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned())).collect();
    let templates = umbragraph::with_templates([]);
    Session::new(InMemory(Memory(files)), umbragraph::registry(), templates)
}

fn choice() -> Choice {
    Choice::new(TargetProfile::webgpu(), PlanOptions::new(640, 480))
}

/// The diagnostics of a plan for people.
fn plan(session: &mut Session, path: &str) -> String {
    let (_, diagnostics) = session.plan(&Target::new(path), &choice()).expect("nothing cancels");
    shown(&diagnostics, session.sources())
}

fn shown(diagnostics: &Diagnostics, sources: &Sources) -> String {
    render::human_all(diagnostics, sources)
}

/// A pipeline of one pass, with a part of it in another file.
const WHOLE: &str = r#"{
  "format": 1, "name": "whole", "include": ["part.json"],
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } } }
}
"#;
const PART: &str = "{ \"parameters\": { \"side\": { \"type\": \"u32\", \"default\": 4 } } }\n";

fn two_files() -> Session {
    session(&[("whole.json", WHOLE), ("part.json", PART)])
}
