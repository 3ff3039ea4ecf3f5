//! Requests and contents of one configuration, for those who look at all configurations together.

use std::collections::{BTreeMap, BTreeSet};

use umbragraph_shaders::{AxisValues, Stage};
use umbragraph_text::document::{Entry, Kind, Value, pointer_join};
use umbragraph_text::source::Span;

/// A template with chosen axes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Chosen {
    /// Its name.
    pub template: String,
    /// The values of its axes.
    pub axes: AxisValues,
    /// The mesh properties that are axes too, in every combination.
    pub properties: Vec<String>,
    /// The entry points of stages of which the template has several.
    pub entry_points: EntryPoints,
}

/// The names of entry points by their stages; a stage with one entry point needs no name.
pub type EntryPoints = BTreeMap<Stage, String>;

/// A program that a pass wants.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The name of the pass.
    pub pass: String,
    /// The template, with its axes.
    pub chosen: Chosen,
    /// The place where the pass names the template.
    pub place: Span,
}

/// A pass that a configuration does not have.
#[derive(Clone, Debug)]
pub struct Absent {
    /// Its name in the document.
    pub name: String,
    /// The condition, or the rounds of the loop.
    pub decided_by: Span,
    /// Whether that is the condition of a pass at the top of the document.
    pub is_top: bool,
    /// The JSON pointer of what decides.
    pub pointer: String,
}

/// The programs and passes that one configuration wants, has and lacks, for the proof of all variants together.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// The programs that passes want, in their order.
    pub wanted: Vec<Wanted>,
    /// The passes of the document, and uses of subgraphs, that it has.
    pub present: BTreeSet<Span>,
    /// The passes and uses of subgraphs that it does not have.
    pub absent: BTreeMap<Span, Absent>,
}

impl Survey {
    /// Writes down that a pass wants a program.
    pub(super) fn want(&mut self, pass: &str, chosen: &Chosen, place: Span) {
        self.wanted.push(Wanted { pass: pass.to_owned(), chosen: chosen.clone(), place });
    }

    /// Writes down that a configuration has a pass, or use of a subgraph.
    pub(super) fn has(&mut self, entry: &Entry) {
        self.present.insert(entry.key_span);
    }

    /// Writes down that a configuration does not have one, because of its `key`; a plain `false` is meant.
    pub(super) fn lacks(&mut self, entry: &Entry, pointer: &str, key: &str, is_top: bool) {
        if self.absent.contains_key(&entry.key_span) {
            return;
        }
        let value = entry.value.get(key);
        if value.is_some_and(|value| matches!(value.kind, Kind::Bool(false))) {
            return;
        }
        let absent = Absent {
            name: entry.key.clone(),
            decided_by: value.map_or(entry.key_span, |value| value.span),
            is_top: is_top && value.and_then(Value::text).is_some(),
            pointer: pointer_join(pointer, key),
        };
        self.absent.insert(entry.key_span, absent);
    }
}

impl Chosen {
    /// The values of each variant.
    pub fn variants(&self) -> impl Iterator<Item = AxisValues> {
        (0..1_u32 << self.properties.len().min(8)).map(|mask| {
            let mut values = self.axes.clone();
            for (bit, name) in self.properties.iter().enumerate() {
                values.insert(name.clone(), (mask & (1 << bit) != 0).into());
            }
            values
        })
    }
}
