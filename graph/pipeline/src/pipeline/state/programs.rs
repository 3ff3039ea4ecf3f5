//! The programs that passes ask for: one for each template with chosen axes, with all its variants.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::pipeline::program::{Program, ProgramBinding, ProgramVariant};
use crate::pipeline::survey::{Chosen, Survey};
use crate::work::ProgramHandle;
use umbragraph_shaders::{Axes, AxisValue, AxisValues, ShaderCache, ShaderModule, exceeded_by_layout};
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_text::source::Span;

/// The programs of one pipeline.
pub(crate) struct Programs {
    /// The programs; a [`ProgramHandle`] is an index into this list.
    pub(crate) list: Vec<Arc<Program>>,
    known: BTreeMap<Chosen, Option<ProgramHandle>>,
    /// The record for validating all variants together; `None` unless the load options request it.
    pub(crate) survey: Option<Survey>,
    /// The shader variants whose diagnostics were already reported, as template name and axis values.
    pub(crate) rejected: BTreeSet<(String, AxisValues)>,
    pub(crate) shaders: Arc<ShaderCache>,
}

impl Programs {
    pub(crate) fn new(shaders: &Arc<ShaderCache>, survey: Option<Survey>) -> Self {
        Self {
            list: Vec::new(),
            known: BTreeMap::new(),
            survey,
            rejected: BTreeSet::new(),
            shaders: shaders.clone(),
        }
    }

    /// Returns the program of a template with chosen axes, in every combination of the mesh properties; `None` after a
    /// diagnostic.
    pub(crate) fn program(
        &mut self,
        chosen: Chosen,
        place: Span,
        pointer: &dyn Fn() -> String,
        diagnostics: &mut Diagnostics,
    ) -> Option<ProgramHandle> {
        if let Some(known) = self.known.get(&chosen) {
            return *known;
        }
        let handle = self.new_program(&chosen, place, &pointer(), diagnostics);
        self.known.insert(chosen, handle);
        handle
    }

    fn new_program(
        &mut self,
        chosen: &Chosen,
        place: Span,
        pointer: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<ProgramHandle> {
        let Chosen { template, axes, properties, entry_points } = chosen;
        let mut variants = Vec::new();
        for values in chosen.variants() {
            let is_on = |name: &&String| values.get(*name) == Some(&AxisValue::Bool(true));
            let mut active: Vec<String> = properties.iter().filter(is_on).cloned().collect();
            active.sort();
            let module = self.module(template, values, place, pointer, diagnostics)?;
            variants.push(ProgramVariant { properties: active, module, entry_points: entry_points.clone() });
        }
        let program = Program::new(template.clone(), axes.clone(), variants, place);
        let program = program.and_then(|program| {
            let beyond = self.beyond(&program, place);
            if beyond.is_empty() { Ok(program) } else { Err(beyond) }
        });
        let program = match program {
            Ok(mut program) => {
                let known = self.shaders.templates().axes(template);
                let follows = known.into_iter().flat_map(Axes::iter).filter(|axis| axis.from_target);
                let follows = follows.map(|axis| axis.name.clone());
                program.from_target = follows.filter(|name| !axes.contains_key(name)).collect();
                program
            }
            Err(own) => {
                diagnostics.extend(own.into_iter().map(|diagnostic| diagnostic.pointer(pointer)));
                return None;
            }
        };
        for excess in self.excess(&program) {
            let message = format!("the variants of {template} together bind {excess} in a stage");
            let help =
                "variants share one layout: let them share bindings, or draw them in passes of their own";
            let diagnostic = Diagnostic::error(codes::DEVICE_RULE, place, message);
            diagnostics.push(diagnostic.pointer(pointer).help(help));
        }
        self.list.push(Arc::new(program));
        Some(ProgramHandle(self.list.len() as u32 - 1))
    }

    /// The limits of the profile that a program's layout exceeds. Empty if a single variant exceeds them, because the
    /// diagnostics of its shader report this.
    fn excess(&self, program: &Program) -> Vec<String> {
        let is_own = |variant: &ProgramVariant| {
            let bindings = variant.module.reflection.bindings.iter();
            !exceeded_by_layout(bindings.map(|binding| &binding.entry), self.shaders.profile()).is_empty()
        };
        if program.variants.len() < 2 || program.variants.iter().any(is_own) {
            return Vec::new();
        }
        exceeded_by_layout(program.bindings.iter().map(|binding| &binding.entry), self.shaders.profile())
    }

    /// Diagnostics for bindings whose group or binding number is above the limits of the profile.
    fn beyond(&self, program: &Program, place: Span) -> Vec<Diagnostic> {
        let (groups, bindings) = (
            self.shaders.profile().limits.max_bind_groups,
            self.shaders.profile().limits.max_bindings_per_bind_group,
        );
        let is_beyond = |one: &&ProgramBinding| one.group >= groups || one.entry.binding >= bindings;
        let diagnostic = |one: &ProgramBinding| {
            let (name, group, binding) = (&one.name, one.group, one.entry.binding);
            let message =
                format!("{} declares \"{name}\" at @group({group}) @binding({binding})", program.template);
            let help = format!("groups are below {groups}, bindings below {bindings}");
            Diagnostic::error(codes::DEVICE_RULE, place, message).help(help)
        };
        program.bindings.iter().filter(is_beyond).map(diagnostic).collect()
    }

    fn is_complete(&self, template: &str, values: &AxisValues) -> bool {
        umbragraph_shaders::complete(self.shaders.templates(), template, values).is_ok()
    }

    fn module(
        &mut self,
        template: &str,
        values: AxisValues,
        place: Span,
        pointer: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<Arc<ShaderModule>> {
        let key = (template.to_owned(), values.clone());
        let (module, own_diagnostics) = match self.shaders.module(template, values) {
            Ok(module) if self.survey.is_some() || module.warnings.is_empty() => return Some(module),
            Ok(module) => (Some(module.clone()), module.warnings.clone()),
            // What is wrong with a variant that can be rendered, its proof will say.
            Err(_) if self.survey.is_some() && self.is_complete(template, &key.1) => (None, Vec::new()),
            Err(own_diagnostics) => (None, own_diagnostics),
        };
        if !self.rejected.insert(key) {
            return module;
        }
        for mut diagnostic in own_diagnostics {
            if diagnostic.place == umbragraph_text::diagnostic::Place::Nowhere {
                diagnostic.place = place.into();
                diagnostic.pointer = pointer.to_owned();
            } else {
                diagnostic = diagnostic.related(place, "used by this pass");
            }
            // The same error in a second variant, or a second pass, is the same error.
            diagnostics.push_new(diagnostic);
        }
        module
    }
}
