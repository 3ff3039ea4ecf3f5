//! Requests and contents of one configuration, for those who look at all configurations together.

use std::collections::{BTreeMap, BTreeSet};

use umbragraph_shaders::{AxisValues, Stage};
use umbragraph_text::document::{Entry, Kind, Value, pointer_join};
use umbragraph_text::source::Span;

/// A shader template with chosen axis values, mesh properties and entry points.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Chosen {
    /// The name of the template.
    pub template: String,
    /// The chosen values of the axes.
    pub axes: AxisValues,
    /// The mesh properties that are axes of the template too; each combination of them is a variant.
    pub properties: Vec<String>,
    /// The chosen entry points, for stages in which the template has several.
    pub entry_points: EntryPoints,
}

/// The names of entry points by their stages; a stage with one entry point needs no name.
pub type EntryPoints = BTreeMap<Stage, String>;

/// A shader program that a pass requires.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The name of the pass.
    pub pass: String,
    /// The template with its chosen axis values.
    pub chosen: Chosen,
    /// The place where the pass names the template.
    pub place: Span,
}

/// A pass, loop or use of a subgraph that a configuration does not have.
#[derive(Clone, Debug)]
pub struct Absent {
    /// The name of the pass, loop or use of a subgraph in the document.
    pub name: String,
    /// The place of the `when` condition or the `for_each` value that decides the absence.
    pub decided_by: Span,
    /// Whether a `when` expression of a pass at the top level of the document decides the absence.
    pub is_top: bool,
    /// The JSON pointer of the deciding `when` condition or `for_each` value.
    pub pointer: String,
}

/// The programs that one configuration requires, and the passes that it has and lacks, for validating all variants
/// together.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// The required programs, in the order of the passes.
    pub wanted: Vec<Wanted>,
    /// The places of the keys of passes and uses of subgraphs that the configuration has.
    pub present: BTreeSet<Span>,
    /// The passes, loops and uses of subgraphs that the configuration lacks, by the places of their keys.
    pub absent: BTreeMap<Span, Absent>,
}

impl Survey {
    /// Records that a pass requires a program.
    pub(super) fn want(&mut self, pass: &str, chosen: &Chosen, place: Span) {
        self.wanted.push(Wanted { pass: pass.to_owned(), chosen: chosen.clone(), place });
    }

    /// Records that the configuration has a pass or a use of a subgraph.
    pub(super) fn has(&mut self, entry: &Entry) {
        self.present.insert(entry.key_span);
    }

    /// Records that the configuration lacks an entry because of the value under `key`. A literal `false` is intended
    /// and not recorded.
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
    /// The axis values of each variant: one variant for each combination of the mesh properties.
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
