//! Files of tests, and the templates that they become.
//!
//! A file of tests ends in `.test.wgsl`, so that no set of templates takes it up: what a pipeline ships does not change
//! by it. Here it is a template under the name of its path, and inherits the axes of the templates that it names in
//! quotes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use umbragraph::diagnostic::{Diagnostic, Diagnostics};
use umbragraph::low_level::compose::files_below;
use umbragraph::low_level::read_source;
use umbragraph::low_level::session::{Template, TemplateText};
use umbragraph::low_level::source::Sources;

use crate::arguments::TestArguments;
use crate::codes;

/// The suffix of the name of a test file.
const END: &str = ".test.wgsl";

/// A shader test file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TestFile {
    /// The name of the file's template, which is its path.
    pub(super) name: String,
    text: Arc<str>,
    /// Set if the command line names the file, its template or a folder with the file. Otherwise the tests run only for
    /// pipelines that use their templates.
    pub(super) is_named: bool,
}

/// The test files and pipelines that the command line selects.
#[derive(Default)]
pub(super) struct Found {
    pub(super) files: Vec<TestFile>,
    pub(super) pipelines: Vec<PathBuf>,
    pub(super) diagnostics: Diagnostics,
}

/// Finds the test files and pipelines that the command line selects.
pub(super) fn find(arguments: &TestArguments) -> Found {
    let mut found = Found::default();
    for path in &arguments.paths {
        let name = path.to_string_lossy();
        if path.is_dir() {
            let before = found.files.len();
            found.add_folder(path, true);
            if found.files.len() == before && !found.diagnostics.has_errors() {
                found.diagnostics.push(nothing(&name, &format!("no file below it ends in `{END}`")));
            }
        } else if name.ends_with(END) {
            found.add(path, true);
        } else if let Some(stem) = name.strip_suffix(".jinja") {
            let beside = format!("{}{END}", stem.strip_suffix(".wgsl").unwrap_or(stem));
            if Path::new(&beside).exists() {
                found.add(Path::new(&beside), true);
            } else {
                found.diagnostics.push(nothing(&name, &format!("there is no \"{beside}\" beside it")));
            }
        } else {
            found.pipelines.push(path.clone());
        }
    }
    if let Some(folder) = arguments.files.templates.as_deref().filter(|_| !found.pipelines.is_empty()) {
        found.add_folder(folder, false);
    }
    found
}

/// Creates the diagnostic for a file or folder without tests.
pub(super) fn nothing(name: &str, why: &str) -> Diagnostic {
    let message = format!("\"{name}\" has no shader tests: {why}");
    Diagnostic::in_file(codes::TEST_INVALID, name, "", message)
        .help(format!("write them in NAME{END}, next to the template NAME.wgsl.jinja"))
}

impl Found {
    fn add_folder(&mut self, folder: &Path, is_named: bool) {
        match files_below(folder, &[END]) {
            Ok(files) => files.iter().for_each(|(_, path)| self.add(path, is_named)),
            Err(diagnostic) => self.diagnostics.push(diagnostic),
        }
    }

    fn add(&mut self, path: &Path, is_named: bool) {
        let name = path.display().to_string();
        if let Some(known) = self.files.iter_mut().find(|known| known.name == name) {
            known.is_named |= is_named;
            return;
        }
        let mut sources = Sources::new();
        match read_source(path, &mut sources) {
            Ok(file) => {
                let text = sources.get(file).map(|source| source.text().clone()).unwrap_or_default();
                self.files.push(TestFile { name, text, is_named });
            }
            Err(diagnostic) => self.diagnostics.push(diagnostic),
        }
    }
}

/// Creates templates from test files. Each inherits the axes of the `known` templates that it names.
pub(super) fn templates(files: &[TestFile], known: &[Template]) -> Vec<Template> {
    let known: BTreeSet<&str> = known.iter().map(|one| one.name.as_str()).collect();
    let text = |name: String, text: Arc<str>| Template { name, text: TemplateText::Text(text) };
    let both = |file: &TestFile| {
        let inherits: Vec<&str> = named_in(&file.text).filter(|name| known.contains(name)).collect();
        let axes = serde_json::json!({ "inherits": inherits, "axes": {} }).to_string();
        let stem = file.name.trim_end_matches(".wgsl");
        [text(file.name.clone(), file.text.clone()), text(format!("{stem}.axes.json"), axes.into())]
    };
    files.iter().flat_map(both).collect()
}

/// Returns the quoted texts that could name a template, each once.
fn named_in(text: &str) -> impl Iterator<Item = &str> {
    let quoted = text.split(['"', '\'']).filter(|part| part.ends_with(".jinja") && !part.contains('\n'));
    quoted.collect::<BTreeSet<_>>().into_iter()
}

/// Returns the names of the given templates and of all templates that they include, directly or indirectly.
pub(super) fn reached(
    names: impl IntoIterator<Item = String>,
    text: impl Fn(&str) -> Arc<str>,
) -> BTreeSet<String> {
    let mut open: Vec<String> = names.into_iter().collect();
    let mut found = BTreeSet::new();
    while let Some(name) = open.pop() {
        if found.contains(&name) {
            continue;
        }
        open.extend(named_in(&text(&name)).map(str::to_owned));
        found.insert(name);
    }
    found
}

impl TestFile {
    /// Returns the names of the templates that the file includes directly.
    pub(super) fn includes(&self) -> impl Iterator<Item = &str> {
        named_in(&self.text)
    }
}
