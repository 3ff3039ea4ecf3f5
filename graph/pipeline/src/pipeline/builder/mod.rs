//! [`PassBuilder`]: what a node kind sees while a pass is declared.
//!
//! Everything that a node kind says goes through here: expressions are evaluated, references looked up, shaders
//! compiled and their bindings matched by name. Each method takes the JSON pointer of the setting (relative to the node
//! kind's settings), so that a diagnostic stands at its place; it reports the diagnostic itself and returns `None`.

pub(super) mod binding;
mod blackboard;
mod blocks;
mod expressions;
mod host_contract;
mod offsets;
pub(super) mod programs;
mod references;
mod samplers;
mod slots;
pub(super) mod subresources;
mod vertices;

use std::collections::BTreeSet;

use crate::pipeline::located::Located as _;
use crate::pipeline::names::environment::{Environment, reference_in};
use crate::pipeline::settings::{Evaluate as _, LiveSetting};
use crate::pipeline::state::shared::Shared;
use crate::work::Work;
use umbragraph_text::diagnostic::{Code, Diagnostic, codes, list_of};
use umbragraph_text::document;
use umbragraph_text::source::Span;

/// Declares one pass: a node kind reads its settings through this builder.
pub struct PassBuilder<'a> {
    pub(crate) shared: &'a mut Shared,
    pub(crate) name: &'a str,
    pub(crate) settings: &'a document::Value,
    /// The JSON pointer of the settings in the document.
    pub(crate) pointer: String,
    pub(crate) environment: &'a Environment,
    /// The axes of the pass's template that may have another value in another configuration.
    pub(crate) open_axes: BTreeSet<String>,
    /// Whether the settings that are evaluated now are live settings of a CPU node.
    pub(crate) is_live: bool,
    /// The settings evaluated so far that are evaluated again when a live parameter changes.
    pub(crate) live: Vec<LiveSetting>,
}

/// The finished declaration of a pass; made by [`PassBuilder::produce`].
#[derive(Debug)]
pub struct Produced(pub(crate) Work);

impl PassBuilder<'_> {
    /// The name of the pass.
    pub fn name(&self) -> &str {
        self.name
    }

    /// The place of a setting in the document; for a missing setting, the place of the object that lacks it.
    pub fn place(&self, pointer: &str) -> Span {
        self.settings.nearest(pointer).span
    }

    /// Reports a name that is not among `known`, as the value of a setting or as a key of an object. The help text
    /// suggests a similar name, or else is the result of `otherwise`. A suggestion is also a fix if the name is written
    /// literally.
    pub(crate) fn report_unknown(
        &mut self,
        code: Code,
        pointer: &str,
        message: impl Into<String>,
        name: &str,
        known: &[&str],
        otherwise: impl FnOnce() -> String,
    ) {
        let (place, at) = (self.place(pointer), self.absolute(pointer));
        let above = pointer.rsplit_once('/').map_or("", |(above, _)| above);
        let object = self.settings.nearest(above);
        let key = object.entry(name).filter(|_| document::pointer_join(above, name) == pointer);
        let value = self.settings.nearest(pointer);
        let written = match (key, value.text()) {
            (Some(entry), _) => Some(entry.key_span),
            (None, Some(text)) if text == name => Some(value.span),
            (None, Some(text)) => reference_in(text, name).and_then(|range| value.span_within(range)),
            _ => None,
        };
        let taken = |known: &str| {
            let twin = object.entry(known).zip(key);
            twin.is_some_and(|(other, key)| other.key_span.file == key.key_span.file)
        };
        // Where a key is unknown, what stands under it is not at fault.
        let place = key.map_or(place, |entry| entry.key_span);
        let diagnostic = Diagnostic::error(code, place, message).pointer(at);
        let diagnostic =
            diagnostic.suggest_unless(name, known.iter().copied(), written, taken, |_| otherwise());
        self.shared.diagnostics.push(diagnostic);
    }

    /// Finishes the declaration with the work of the pass. Returns `None` after a diagnostic if the work writes an
    /// earlier frame of a history.
    pub fn produce(&mut self, work: Work) -> Option<Produced> {
        for (named, usage) in work.accesses() {
            let name = match self.shared.resources.get(named.resource.index()) {
                Some(resource) if usage.writes() && resource.is_earlier_frame() => &resource.name,
                _ => continue,
            };
            let this = name.split('@').next().unwrap_or(name);
            let message =
                format!("\"{name}\" is used as {}, but an earlier frame is only read", usage.name());
            let help = format!("write \"{this}\", which is this frame's");
            self.shared.diagnostics.push(named.error(codes::HISTORY_WRITE, message).help(help));
            return None;
        }
        Some(Produced(work))
    }

    /// Checks that there is a geometry contract with this name; returns `None` after a diagnostic.
    pub fn geometry(&mut self, name: &str, pointer: &str) -> Option<()> {
        if self.shared.geometry.contains_key(name) {
            return Some(());
        }
        let names: Vec<String> = self.shared.geometry.keys().cloned().collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let message = format!("there is no geometry \"{name}\"");
        self.report_unknown(codes::UNKNOWN_GEOMETRY, pointer, message, name, &names, || {
            format!(
                "\"geometry\" declares {}",
                if names.is_empty() { "nothing".to_owned() } else { list_of(&names) }
            )
        });
        None
    }

    /// Reports a draw filter that is not in the list of filters of the geometry's host. Does nothing if the host has no
    /// list.
    pub fn filter(&mut self, geometry: &str, name: &str, pointer: &str) {
        let Some(known) = self.shared.filters.get(geometry).cloned() else { return };
        if known.iter().any(|filter| filter == name) {
            return;
        }
        let names: Vec<&str> = known.iter().map(String::as_str).collect();
        let message = format!("the host of \"{geometry}\" knows no filter \"{name}\"");
        self.report_unknown(codes::UNKNOWN_FILTER, pointer, message, name, &names, || {
            format!("it knows {}", list_of(&names))
        });
    }

    pub(crate) fn settings_do_not_decode(&mut self, error: &serde_json::Error) {
        let message = format!("the settings do not decode: {error}");
        let help = "compare them with the schema";
        self.report(codes::WRONG_TYPE, "", message, help);
    }

    pub(crate) fn absolute(&self, pointer: &str) -> String {
        [self.pointer.as_str(), pointer].concat()
    }
}
