//! What several loads of one document share: shader modules, and what those loads ask for.
//!
//! Configurations of one pipeline mostly want the same shaders. [`Modules`] keeps each that was made, or rejected, and
//! writes down which pass wanted which program, so that all of them can be proven together.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::document::{Entry, Kind, Value, pointer_join};
use crate::shader::{self, AxisValues, ShaderModule, Stage, TargetProfile, TemplateSet};
use crate::source::Span;

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

/// Modules by template and values, and what was asked for.
#[derive(Debug, Default)]
pub struct Modules {
    known: BTreeMap<(String, AxisValues), Result<Arc<ShaderModule>, Vec<Diagnostic>>>,
    /// The programs that passes want, in the order of the loads.
    pub wanted: Vec<Wanted>,
    /// The passes of the document, and uses of subgraphs, that the last load had.
    pub present: BTreeSet<Span>,
    /// Those that some load did not have.
    pub absent: BTreeMap<Span, Absent>,
    proven_elsewhere: bool,
    /// Variants of a template that declare a binding and a member of it, by what was asked.
    declared: BTreeMap<(String, AxisValues, String, Option<String>), Option<AxisValues>>,
    /// The diagnostics of the schema, which are the same for every configuration.
    of_schema: Option<Diagnostics>,
}

impl Modules {
    /// Modules of which a proof of all variants will say what is wrong with the shaders themselves.
    pub fn proven_elsewhere() -> Self {
        Self { proven_elsewhere: true, ..Self::default() }
    }

    /// Exchanges the diagnostics of the schema for those of another document, which are kept elsewhere.
    pub fn swap_schema(&mut self, other: &mut Option<Diagnostics>) {
        std::mem::swap(&mut self.of_schema, other);
    }

    /// The diagnostics of the schema, from the first load.
    pub(super) fn of_schema(&mut self, check: impl FnOnce() -> Diagnostics) -> Diagnostics {
        self.of_schema.get_or_insert_with(check).clone()
    }

    /// Writes down that a pass wants a program, where all variants are proven together.
    pub(super) fn want(&mut self, pass: &str, chosen: &Chosen, place: Span) {
        if self.proven_elsewhere {
            self.wanted.push(Wanted { pass: pass.to_owned(), chosen: chosen.clone(), place });
        }
    }

    /// Writes down that a configuration has a pass, or use of a subgraph.
    pub(super) fn has(&mut self, entry: &Entry) {
        if self.proven_elsewhere {
            self.present.insert(entry.key_span);
        }
    }

    /// Writes down that a configuration does not have one, because of its `key`; a plain `false` is meant.
    pub(super) fn lacks(&mut self, entry: &Entry, pointer: &str, key: &str, is_top: bool) {
        if self.proven_elsewhere && !self.absent.contains_key(&entry.key_span) {
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

    /// The values with which some variant of a template in which these axes are fixed declares a binding, with a member
    /// where one is given.
    pub(super) fn declares(
        &mut self,
        templates: &TemplateSet,
        template: &str,
        fixed: &AxisValues,
        binding: &str,
        member: Option<&str>,
    ) -> Option<AxisValues> {
        let key = (template.to_owned(), fixed.clone(), binding.to_owned(), member.map(str::to_owned));
        let search = || shader::permutations::declares(templates, template, fixed, binding, member);
        self.declared.entry(key).or_insert_with(search).clone()
    }

    /// The module, or what is wrong with it; nothing is said of what the proof of all variants will say.
    pub(super) fn get(
        &mut self,
        templates: &TemplateSet,
        template: &str,
        values: AxisValues,
        profile: &TargetProfile,
    ) -> Result<Arc<ShaderModule>, Vec<Diagnostic>> {
        let key = (template.to_owned(), values);
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let made = shader::compile(templates, template, &key.1, profile).map_err(|diagnostics| {
            let is_proven = self.proven_elsewhere && shader::complete(templates, template, &key.1).is_ok();
            if is_proven { Vec::new() } else { diagnostics }
        });
        let made = made.map(|mut module| {
            if self.proven_elsewhere {
                module.warnings.clear();
            }
            Arc::new(module)
        });
        self.known.insert(key, made.clone());
        made
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
