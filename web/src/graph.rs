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
    /// Returns a JSON object: `svg` is the drawing of the plan as made by `umbragraph graph --format svg`, or `null` if
    /// planning fails. `written` lists the passes in the pipeline's source. The parameters are those of
    /// [`Project::plan`].
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

    /// Returns the slots of a pass as a JSON array: the places that refer to a resource or can be connected to one.
    /// `refused` of a slot is the reason why no other resource can be connected; `null` if one can.
    pub fn slots(&mut self, path: &str, values: &str, width: u32, height: u32, pass: &str) -> String {
        let (target, choice) = self.chosen(path, values, width, height);
        let slots = self.session.slots(&target, &choice, pass).unwrap_or_default();
        let slot = |slot: umbragraph::low_level::session::Slot| json!({ "keys": slot.keys, "label": slot.label, "value": slot.value, "refused": slot.refused });
        Value::from(slots.into_iter().map(slot).collect::<Vec<_>>()).to_string()
    }

    /// Returns the text edits that make a change of the graph, as the member `edits` of a JSON object. Each file has a
    /// list of edits; `from` and `to` are offsets in UTF-16 code units. If the change is impossible, the object has the
    /// member `refused` with the reason instead. If `is_tried`, the edited files are also planned, and a new error
    /// refuses the change.
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

    /// Returns a JSON object with all node kinds (`kinds`) and the page's files that are subgraphs (`files`), each with
    /// a description; `null` where there is none.
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
            let Some((_, parsed)) = self.session.parsed(Path::new(&path)) else { continue };
            let document = &parsed.document;
            if kind_of(document) == Some(FileKind::Subgraph) {
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

    /// Plans a pipeline with edited files, without writing the files. Returns the first error that the original does
    /// not have, with its help; `None` if there is none.
    fn tried(
        &mut self,
        (path, values): (&str, &str),
        options: PlanOptions,
        edits: &BTreeMap<String, Edits>,
    ) -> Option<String> {
        let (_, before) = self.planned(path, values, None, options.clone());
        let known: BTreeSet<String> = before.iter().map(|one| one.message.clone()).collect();
        let edited =
            |(file, edits): (&String, &Edits)| Some((file.clone(), edits.apply(&self.text(file)?).ok()?));
        let texts: Vec<(String, String)> = edits.iter().map(edited).collect::<Option<_>>()?;
        for (file, text) in texts {
            self.session.overlay(file, text.into_bytes());
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

/// Parses a change of the graph from JSON; `None` if the JSON is not a valid change.
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

/// Converts edits of `text` to JSON for the page's editor: byte offsets become offsets in UTF-16 code units.
fn written(text: &str, edits: &Edits) -> Value {
    let offset = |byte: usize| text.get(..byte).map_or(0, |before| before.encode_utf16().count());
    let edit = |edit: &umbragraph::low_level::edit::Edit| json!({ "from": offset(edit.range.start), "to": offset(edit.range.end), "insert": edit.replacement });
    edits.iter().map(edit).collect()
}
