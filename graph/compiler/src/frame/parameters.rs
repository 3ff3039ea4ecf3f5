//! Live parameters: their values in a frame, and what follows from them.
//!
//! A plan keeps, for each live setting, its expression with everything folded that no live parameter changes
//! ([`PlannedSetting`]). When a parameter has changed, these are evaluated again, in the order of the passes, and held
//! to what loading and planning hold them to. If one is rejected, all parameters have the values again that they had
//! before.
//!
//! Cost: linear in the live settings of the plan, in frames in which a parameter has changed; nothing in others. Lists
//! that are written out or named are evaluated in the memory of those before.
//!
//! Limits: other lists, words, and the values of derived ones are allocated in frames in which a parameter has changed.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::sync::Arc;

use crate::frame::cpu_passes::CpuPasses;
use crate::plan::planned::Plan;
use crate::values::packed::PackedBlock;
use crate::work::dispatch;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, codes, list_of};
use umbragraph_pipeline::expression::{self, Expression, Scope as _, Value};
use umbragraph_pipeline::pipeline::{
    Constraint, Following, LiveSettings, StaticScope, TypedPipeline, rejected,
};
use umbragraph_pipeline::source::Span;
use umbragraph_pipeline::work::Deferred;

use crate::values::settings::{Bound, PlannedSetting};

/// A callback for each pass with changed live settings. It receives the position of the pass in the plan, the values of
/// its live settings, and its constant blocks.
pub type TakeOver<'a> = dyn FnMut(usize, &[Value], &[PackedBlock]) + 'a;

/// The parameters of a plan with their values in the current frame.
pub struct Parameters {
    plan: Arc<Plan>,
    /// The values of all names that the expressions of live settings can use.
    scope: StaticScope,
    /// The last value of each parameter that was applied to the passes.
    settled: Vec<Value>,
    /// A scratch value for each parameter, into which a new value is written before validation.
    given: Vec<Value>,
    /// For each parameter, whether a value was set, in this plan or a previous one.
    is_set: Vec<bool>,
    /// The values that were set in previous plans, by name.
    kept: BTreeMap<String, Value>,
    is_changed: bool,
    id: u64,
    /// The constant blocks of each pass, by position in the plan.
    blocks: Vec<Vec<PackedBlock>>,
    /// The values of the live settings of each pass, by position in the plan.
    taken: Vec<Vec<Value>>,
    numbers: Vec<f64>,
}

impl Parameters {
    /// Creates the parameters of a plan with the values that the plan was made with.
    pub fn new(plan: Arc<Plan>) -> Self {
        let pipeline = &plan.pipeline;
        let scope = pipeline.scope();
        let settled: Vec<Value> = pipeline.parameters.values().map(|one| one.value.clone()).collect();
        let mut hasher = DefaultHasher::new();
        pipeline.parameters.keys().for_each(|name| name.hash(&mut hasher));
        let taken = |setting: &PlannedSetting| {
            // A value that cannot be evaluated is a diagnostic of the plan.
            expression::evaluate(&setting.expression, &scope).unwrap_or(Value::Bool(false))
        };
        let taken = plan.passes.iter().map(|planned| planned.live.iter().map(taken).collect()).collect();
        Self {
            is_set: vec![false; settled.len()],
            is_changed: false,
            kept: BTreeMap::new(),
            id: hasher.finish(),
            blocks: plan.passes.iter().map(|pass| pass.blocks.clone()).collect(),
            taken,
            numbers: Vec::new(),
            given: settled.clone(),
            settled,
            scope,
            plan,
        }
    }

    /// Returns the position of a live parameter by name.
    ///
    /// # Errors
    /// Fails if there is no parameter with this name, or if it is structural (a change needs a new plan).
    pub fn find(&self, name: &str) -> Result<usize, Diagnostics> {
        let parameters = &self.plan.pipeline.parameters;
        let Some((at, (_, parameter))) = parameters.iter().enumerate().find(|(_, (known, _))| *known == name)
        else {
            let message = format!("there is no parameter \"{name}\"");
            let diagnostic = Diagnostic::error(codes::UNKNOWN_SETTING, Place::Nowhere, message);
            let known = parameters.keys().map(String::as_str);
            let diagnostic = diagnostic.suggest(name, known, None, |names| match names {
                [] => "this pipeline has no parameters".to_owned(),
                names => format!("the parameters are {}", list_of(names)),
            });
            return Err(diagnostic.into());
        };
        match &parameter.structural {
            None => Ok(at),
            Some(structural) => {
                let message = format!("the parameter \"{name}\" is structural: {}", structural.pointer);
                let diagnostic = Diagnostic::error(codes::STRUCTURAL_PARAMETER, structural.place, message);
                let help = "plan again with another value";
                Err(diagnostic.pointer(&structural.pointer).help(help).into())
            }
        }
    }

    /// Returns the value of the parameter at a position; `None` if there is none.
    pub fn get(&self, at: usize) -> Option<&Value> {
        self.scope.borrow(self.plan.pipeline.parameters.keys().nth(at)?)
    }

    /// The identifier of the parameter layout: positions are valid only for plans with the same identifier.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Sets the live parameter at a position: `assign` writes the new value. [`Parameters::apply`] then applies it to
    /// the passes.
    ///
    /// # Errors
    /// Fails if there is no live parameter at the position, or if the value has another type or length or is out of
    /// range. The parameter then keeps its value.
    pub fn set(&mut self, at: usize, assign: &mut dyn FnMut(&mut Value)) -> Result<(), Diagnostics> {
        let found = self.plan.pipeline.parameters.iter().nth(at);
        let Some((name, parameter)) = found.filter(|(_, parameter)| parameter.structural.is_none()) else {
            let message = "the handle is of no live parameter of this plan";
            let diagnostic = Diagnostic::error(codes::UNKNOWN_SETTING, Place::Nowhere, message);
            return Err(diagnostic.help("ask the executor for the parameter again").into());
        };
        let Some((before, given)) = self.scope.get_mut(name).zip(self.given.get_mut(at)) else {
            return Ok(());
        };
        assign(given);
        if let Some((code, message, help)) = rejected(name, &parameter.declaration, given, before) {
            given.clone_from(before);
            return Err(Diagnostic::error(code, parameter.place, message).help(help).into());
        }
        self.is_set[at] = true;
        if before != given {
            std::mem::swap(before, given);
            self.is_changed = true;
        }
        Ok(())
    }

    /// Copies the values that were set on another plan's parameters, where they are valid for this plan.
    pub fn go_on_from(&mut self, before: &mut Self) {
        self.kept = std::mem::take(&mut before.kept);
        let set = before.plan.pipeline.parameters.keys().zip(&before.is_set).filter(|(_, is_set)| **is_set);
        let set = set.filter_map(|(name, _)| Some((name.clone(), before.scope.borrow(name)?.clone())));
        self.kept.extend(set);
        for (at, (name, parameter)) in self.plan.pipeline.parameters.iter().enumerate() {
            let (Some(value), Some(own)) = (self.kept.get(name), self.scope.get_mut(name)) else { continue };
            if parameter.structural.is_none() && rejected(name, &parameter.declaration, value, own).is_none()
            {
                self.is_set[at] = true;
                self.is_changed |= own != value;
                own.clone_from(value);
            }
        }
    }

    /// Applies changed parameters to the passes: updates CPU nodes directly, and calls `set` for each pass with changed
    /// live settings.
    ///
    /// # Errors
    /// Fails with the diagnostics that loading or planning with these values would give. All parameters then have their
    /// last applied values again.
    pub fn apply(&mut self, cpu_passes: &mut CpuPasses, set: &mut TakeOver<'_>) -> Result<(), Diagnostics> {
        if !std::mem::take(&mut self.is_changed) {
            return Ok(());
        }
        let plan = self.plan.clone();
        let attempted = self.attempt(&plan, cpu_passes, set);
        for (name, settled) in plan.pipeline.parameters.keys().zip(&mut self.settled) {
            match self.scope.get_mut(name) {
                Some(value) if attempted.is_err() => value.assign(settled),
                Some(value) if settled != value => settled.assign(value),
                _ => {}
            }
        }
        if attempted.is_err() {
            // What was taken over before holds again.
            drop(self.attempt(&plan, cpu_passes, set));
        }
        attempted
    }

    fn attempt(
        &mut self,
        plan: &Plan,
        cpu_passes: &mut CpuPasses,
        set: &mut TakeOver<'_>,
    ) -> Result<(), Diagnostics> {
        self.follow(&plan.pipeline)?;
        for (at, planned) in plan.passes.iter().enumerate() {
            let (settings, mut is_changed) = (&plan.pipeline.pass(planned.handle).live, false);
            for (position, (setting, declared)) in planned.live.iter().zip(settings).enumerate() {
                let Deferred { place, pointer, .. } = &declared.value;
                let value = &mut self.taken[at][position];
                if evaluate(&self.scope, &setting.expression, *place, pointer, value)? {
                    is_changed = true;
                    (declared.check)(value)
                        .and_then(|()| self.hold(at, position, setting))
                        .map_err(|rejected| rejected.at(*place, pointer))?;
                }
            }
            if is_changed {
                let mut diagnostics = Diagnostics::new();
                let (values, diagnostics_of) = (&self.taken[at], &mut diagnostics);
                let mut settings = LiveSettings { settings, values, diagnostics: diagnostics_of };
                if cpu_passes.update(at, &mut settings).is_none() {
                    return Err(diagnostics);
                }
                set(at, values, &self.blocks[at]);
            }
        }
        Ok(())
    }

    /// Checks the value of a live setting against its bound; packs the value into its constant block if it is a member
    /// of one.
    fn hold(&mut self, at: usize, position: usize, setting: &PlannedSetting) -> Result<(), Diagnostic> {
        let value = &self.taken[at][position];
        match &setting.bound {
            Bound::Member(block, packing) => {
                packing.pack(value, &mut self.numbers, &mut self.blocks[at][*block].bytes)
            }
            Bound::Workgroups(limit) => dispatch::count(value, *limit).map(drop),
            Bound::Drawn(most, buffer) if value.number().is_some_and(|count| count > *most as f64) => {
                let message = format!("\"{buffer}\" has {most} of the {value} that are drawn of it");
                let diagnostic = Diagnostic::error(codes::DEVICE_RULE, Place::Nowhere, message);
                Err(diagnostic.help("make the buffer larger, or draw less"))
            }
            Bound::Free | Bound::Drawn(..) => Ok(()),
        }
    }

    /// Evaluates the values derived from parameters, and checks ranges and constraints.
    fn follow(&mut self, pipeline: &TypedPipeline) -> Result<(), Diagnostic> {
        for Following { name, expression, declaration, place } in &pipeline.following {
            let mut value = Value::Bool(false);
            evaluate(&self.scope, expression, *place, "", &mut value)?;
            if let (Some(declaration), Some(before)) = (declaration, self.scope.borrow(name)) {
                let inner = name.rsplit('$').next().unwrap_or_default();
                if let Some((code, message, help)) = rejected(inner, declaration, &value, before) {
                    return Err(Diagnostic::error(code, *place, message).help(help));
                }
            }
            self.scope.set(name, value);
        }
        for Constraint { holds, message, place, pointer } in &pipeline.constraints {
            let mut value = Value::Bool(true);
            if evaluate(&self.scope, holds, *place, pointer, &mut value)? {
                let diagnostic = Diagnostic::error(codes::CONSTRAINT, *place, message);
                return Err(diagnostic.pointer(pointer).help("set other values before the next frame"));
            }
        }
        Ok(())
    }
}

/// Evaluates an expression into `to`; returns `true` if the value changed.
fn evaluate(
    scope: &StaticScope,
    expression: &Expression,
    place: Span,
    pointer: &str,
    to: &mut Value,
) -> Result<bool, Diagnostic> {
    expression::evaluate_into(expression, scope, to).map_err(|error| {
        let help = error.help.unwrap_or_else(|| "set another value".to_owned());
        Diagnostic::error(codes::EXPRESSION_ARITHMETIC, place, error.message).pointer(pointer).help(help)
    })
}
