//! The graph of a pipeline as a page draws and changes it: methods of [`Project`].
//!
//! A change is a value of JSON, `{ "change": "connect", "pass": "show", "slot": ["fullscreen", "bind", "source"], "to":
//! "&kept" }`, and its answer edits of texts. The page makes them in its editor and writes the texts again.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde_json::{Map, Value, json};
use umbragraph::diagnostic::{Diagnostics, Severity};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::edit::Edits;
use umbragraph::low_level::pipeline::{FileKind, schema_of};
use umbragraph::low_level::report::{GraphFormat, draw};
use umbragraph::low_level::session::{Change, kind_of};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::project::Project;

#[wasm_bindgen]
impl Project {
    /// The picture of a plan that `umbragraph graph --format svg` draws, as `svg`, and the passes of the text as
    /// `written`; without a plan nothing but these.
    pub fn graph(&mut self, path: &str, values: &str, width: u32, height: u32) -> String {
        let (planned, _) = self.planned(path, values, None, PlanOptions::new(width, height));
        let report = planned.as_ref().and_then(|planned| self.report(planned));
        let svg = report.map(|report| draw(&report, GraphFormat::Svg, None));
        let (target, choice) = self.chosen(path, values, width, height);
        let written = self.session.written(&target, &choice).unwrap_or_default();
        let sources = self.session.sources();
        let written: Vec<Value> = written
            .iter()
            .map(|pass| {
                let file = sources.get(pass.place.file);
                json!({
                    "name": pass.name,
                    "kind": pass.kind,
                    "description": pass.description,
                    "is_on": pass.is_on,
                    "declared": file.map(|file| format!("{}:{}", file.name(), file.line_column(pass.place.start).line)),
                })
            })
            .collect();
        json!({ "svg": svg, "written": written }).to_string()
    }

    /// The places of a pass to which resources can be connected.
    pub fn slots(&mut self, path: &str, values: &str, width: u32, height: u32, pass: &str) -> String {
        let (target, choice) = self.chosen(path, values, width, height);
        let slots = self.session.slots(&target, &choice, pass).unwrap_or_default();
        let slot = |slot: umbragraph::low_level::session::Slot| json!({ "keys": slot.keys, "label": slot.label, "value": slot.value, "refused": slot.refused });
        Value::from(slots.into_iter().map(slot).collect::<Vec<_>>()).to_string()
    }

    /// The edits of a change, by file: `from` and `to` count UTF-16 code units, as editors in browsers do. With
    /// `is_tried` the edited texts are planned, and the first error that they bring is `refused`, as is what cannot be
    /// changed at all.
    pub fn change(
        &mut self,
        path: &str,
        values: &str,
        width: u32,
        height: u32,
        change: &str,
        is_tried: bool,
    ) -> String {
        let asked = serde_json::from_str(change).ok().and_then(|change: Value| read(&change));
        let Some(asked) = asked else {
            return json!({ "refused": "this is no change of a graph" }).to_string();
        };
        let (target, choice) = self.chosen(path, values, width, height);
        let edits = match self.session.change(&target, &choice, &asked) {
            Ok(Some(Ok(edits))) => edits,
            Ok(Some(Err(error))) => return json!({ "refused": error.to_string() }).to_string(),
            _ => return json!({ "refused": "the pipeline cannot be read" }).to_string(),
        };
        if is_tried && let Some(refused) = self.tried((path, values), PlanOptions::new(width, height), &edits)
        {
            return json!({ "refused": refused }).to_string();
        }
        let files =
            edits.iter().filter_map(|(file, edits)| Some((file.clone(), written(&self.text(file)?, edits))));
        json!({ "edits": files.collect::<Map<_, _>>() }).to_string()
    }

    /// The node kinds, and the files of the page that are subgraphs, each with a description.
    pub fn palette(&mut self) -> String {
        let schema = schema_of(FileKind::Pipeline, self.session.registry());
        let described = |kind: &str| {
            let member = schema.pointer("/$defs/Pass/properties")?.get(kind)?;
            let target =
                member.get("$ref").and_then(Value::as_str).and_then(|target| target.strip_prefix('#'));
            let words =
                target.and_then(|target| schema.pointer(target)).unwrap_or(member).get("description")?;
            words.as_str()?.split("\n\n").next().map(|first| first.replace('\n', " "))
        };
        let kinds = self.session.registry().iter().map(|kind| kind.name());
        let kinds: Vec<Value> =
            kinds.map(|kind| json!({ "kind": kind, "description": described(kind) })).collect();
        let mut files = Vec::new();
        for path in self.paths() {
            let Some((_, document)) = self.session.parsed(Path::new(&path)) else { continue };
            if kind_of(&document) == Some(FileKind::Subgraph) {
                let description = document.root.get("description").and_then(|words| words.text());
                files.push(json!({ "kind": path, "description": description }));
            }
        }
        json!({ "kinds": kinds, "files": files }).to_string()
    }
}

impl Project {
    fn chosen(
        &mut self,
        path: &str,
        values: &str,
        width: u32,
        height: u32,
    ) -> (umbragraph::low_level::session::Target, umbragraph::low_level::session::Choice) {
        self.choice((path, values), None, PlanOptions::new(width, height), &mut Diagnostics::new())
    }

    /// The first error that edits bring to a pipeline.
    fn tried(
        &mut self,
        (path, values): (&str, &str),
        options: PlanOptions,
        edits: &BTreeMap<String, Edits>,
    ) -> Option<String> {
        let (_, before) = self.planned(path, values, None, options.clone());
        let known: BTreeSet<String> = before.iter().map(|one| one.message.clone()).collect();
        for (file, edits) in edits {
            let edited = self.text(file).and_then(|text| edits.apply(&text).ok());
            self.session.overlay(file, edited?.into_bytes());
        }
        let (_, after) = self.planned(path, values, None, options);
        for file in edits.keys() {
            self.session.close(file);
        }
        let is_new = |one: &&umbragraph::diagnostic::Diagnostic| {
            one.severity == Severity::Error && !known.contains(&one.message)
        };
        let first = after.iter().find(is_new)?;
        let help = first.help.as_ref().map(|help| format!("\n{help}")).unwrap_or_default();
        Some(format!("{}{help}", first.message))
    }
}

/// A change as JSON says it.
fn read(change: &Value) -> Option<Change> {
    let text = |key: &str| change.get(key).and_then(Value::as_str).map(str::to_owned);
    let texts = |key: &str| {
        let list = change.get(key)?.as_array()?.iter();
        list.map(|one| one.as_str().map(str::to_owned)).collect::<Option<Vec<String>>>()
    };
    Some(match change.get("change")?.as_str()? {
        "connect" => Change::Connect { pass: text("pass")?, slot: texts("slot")?, to: text("to")? },
        "rename" => Change::Rename { from: text("from")?, to: text("to")? },
        "switch" => Change::Switch { pass: text("pass")?, on: change.get("on")?.as_bool()? },
        "remove" => Change::Remove { pass: text("pass")? },
        "move" => Change::Move { pass: text("pass")?, before: text("before") },
        "add" => Change::Add { kind: text("kind")?, after: text("after") },
        "declare" => Change::Declare { like: text("like") },
        "forget" => Change::Forget { resource: text("resource")? },
        "group" => Change::Group { passes: texts("passes")?, name: text("name")? },
        _ => return None,
    })
}

/// Edits as a browser's editor makes them.
fn written(text: &str, edits: &Edits) -> Value {
    let offset = |byte: usize| text.get(..byte).map_or(0, |before| before.encode_utf16().count());
    let edit = |edit: &umbragraph::low_level::edit::Edit| json!({ "from": offset(edit.range.start), "to": offset(edit.range.end), "insert": edit.replacement });
    edits.iter().map(edit).collect()
}
