//! Live parameters: their values in a frame, and what follows from them.
//!
//! A plan keeps, for each live setting, its expression with everything folded that no live parameter changes
//! ([`PlannedSetting`]). When a parameter has changed, these are evaluated again, in the order of the passes, and held to
//! what loading and planning hold them to. If one is rejected, all parameters have the values again that they had before.
//!
//! Cost: linear in the live settings of the plan, in frames in which a parameter has changed; nothing in others.
//! Elements of lists are evaluated one by one, so that no list is allocated.
//!
//! Limits: nested lists, words, lists of derived values and those among the settings of CPU nodes are.

mod settings;

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::sync::Arc;

use super::cpu_passes::CpuPasses;
use super::planned::Plan;
use super::values::{PackedBlock, Packing, pack_member};
use crate::diagnostic::{Code, Diagnostic, Diagnostics, Place, codes};
use crate::expression::{self, Expression, Scope, Value};
use crate::pipeline::{LiveSettings, LiveTarget, Pipeline, rejected, whole_number};
use crate::source::Span;

pub use settings::{PlannedParameter, PlannedSetting};
pub(super) use settings::{of_block, of_dispatch, of_pass, planned};

use settings::PlannedTarget;

/// What has changed of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Changed<'a> {
    /// A block's bytes.
    Block(&'a PackedBlock),
    /// One of the three counts of a dispatch.
    Workgroups(usize, u32),
    /// The clear value of a color attachment.
    Color(usize, [f64; 4]),
    /// The clear value of the depth attachment.
    Depth(f64),
    /// The clear value of the stencil attachment.
    Stencil(u32),
    /// The stencil reference.
    Reference(u32),
    /// The blend constant.
    BlendConstant([f64; 4]),
    /// The number of vertices, or indices.
    Count(u32),
    /// The number of instances.
    Instances(u32),
    /// Settings of the CPU node, which has taken them over.
    Node,
}

/// The parameters of a plan with their values in this frame.
pub struct Parameters {
    plan: Arc<Plan>,
    values: Values,
    /// The values that passes have taken over.
    settled: Vec<Value>,
    /// Memory for values that are given.
    given: Vec<Value>,
    /// Whether each has been set since the plan was made.
    is_set: Vec<bool>,
    is_changed: bool,
    id: u64,
    /// For each pass its blocks.
    blocks: Vec<Vec<PackedBlock>>,
    /// For each pass where its live settings went, those that are members of blocks.
    packings: Vec<Vec<Packing>>,
    /// For each pass the values of its live settings.
    taken: Vec<Vec<Value>>,
    numbers: Vec<f64>,
    scratch: Value,
}

/// The names that live settings can see.
struct Values {
    names: HashMap<String, usize>,
    list: Vec<Value>,
}

impl Values {
    fn add(&mut self, name: &str, value: Value) {
        self.names.insert(name.to_owned(), self.list.len());
        self.list.push(value);
    }
}

impl Scope for Values {
    fn lookup(&self, name: &str) -> Option<Value> {
        self.borrow(name).cloned()
    }

    fn borrow(&self, name: &str) -> Option<&Value> {
        self.names.get(name).and_then(|at| self.list.get(*at))
    }

    fn names(&self) -> Vec<String> {
        self.names.keys().cloned().collect()
    }
}

impl Parameters {
    /// The parameters of a plan with the values that it was made with.
    pub fn new(plan: Arc<Plan>) -> Self {
        let pipeline = &plan.pipeline;
        let scope = pipeline.scope();
        let mut values = Values { names: HashMap::new(), list: Vec::new() };
        for (name, parameter) in &pipeline.parameters {
            values.add(name, parameter.value.clone());
        }
        let mut hasher = DefaultHasher::new();
        pipeline.parameters.keys().for_each(|name| name.hash(&mut hasher));
        let settled = values.list.clone();
        for following in &pipeline.following {
            values.add(&following.name, scope.lookup(&following.name).unwrap_or(Value::Bool(false)));
        }
        // What does not change.
        for name in pipeline.features.keys().chain(pipeline.derived.keys()) {
            if !values.names.contains_key(name)
                && let Some(value) = scope.lookup(name)
            {
                values.add(name, value);
            }
        }
        let mut parameters = Self {
            is_set: vec![false; settled.len()],
            is_changed: false,
            id: hasher.finish(),
            blocks: plan.passes.iter().map(|pass| pass.blocks.clone()).collect(),
            packings: plan.passes.iter().map(|pass| vec![Packing::default(); pass.live.len()]).collect(),
            taken: Vec::new(),
            numbers: Vec::new(),
            scratch: Value::Bool(false),
            given: settled.clone(),
            settled,
            values,
            plan,
        };
        parameters.taken = parameters.taken_first();
        parameters
    }

    /// The values of the live settings of each pass with which the plan was made.
    fn taken_first(&self) -> Vec<Vec<Value>> {
        let value = |setting: &PlannedSetting| {
            let mut value = Value::Bool(false);
            self.value(setting, &mut value, &mut Diagnostics::new());
            value
        };
        self.plan.passes.iter().map(|planned| planned.live.iter().map(value).collect()).collect()
    }

    /// The position of a live parameter.
    ///
    /// # Errors
    /// No such parameter, or one that is structural.
    pub fn find(&self, name: &str) -> Result<usize, Diagnostics> {
        let parameters = &self.plan.pipeline.parameters;
        let Some((at, (_, parameter))) = parameters.iter().enumerate().find(|(_, (known, _))| *known == name)
        else {
            let message = format!("there is no parameter \"{name}\"");
            let diagnostic = Diagnostic::error(codes::UNKNOWN_SETTING, Place::Nowhere, message);
            let known = parameters.keys().map(String::as_str);
            let diagnostic = diagnostic.suggest(name, known, None, |names| match names {
                [] => "this pipeline has no parameters".to_owned(),
                names => format!("the parameters are {}", names.join(", ")),
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

    /// The value of the parameter at a position.
    pub fn get(&self, at: usize) -> Option<&Value> {
        self.values.list.get(at).filter(|_| at < self.settled.len())
    }

    /// A number that is the same for plans with the same parameters: positions are good for these.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Sets the live parameter at a position to what `assign` makes of a value of it. Passes take it over with
    /// [`Parameters::apply`].
    ///
    /// # Errors
    /// No live parameter of this plan; a value of another type or length, or out of range.
    pub fn set(&mut self, at: usize, assign: &mut dyn FnMut(&mut Value)) -> Result<(), Diagnostics> {
        let found = self.plan.pipeline.parameters.iter().nth(at);
        let Some((name, parameter)) = found.filter(|(_, parameter)| parameter.structural.is_none()) else {
            let message = "the handle is of no live parameter of this plan";
            let diagnostic = Diagnostic::error(codes::UNKNOWN_SETTING, Place::Nowhere, message);
            return Err(diagnostic.help("ask the executor for the parameter again").into());
        };
        let (before, given) = (&mut self.values.list[at], &mut self.given[at]);
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

    /// Sets what was set in another plan's parameters, where it fits here.
    pub fn go_on_from(&mut self, before: &Self) {
        for (at, (name, parameter)) in self.plan.pipeline.parameters.iter().enumerate() {
            let Some(from) = before.plan.pipeline.parameters.keys().position(|known| known == name) else {
                continue;
            };
            let value = &before.values.list[from];
            let fits = rejected(name, &parameter.declaration, value, &self.values.list[at]).is_none();
            if before.is_set[from] && parameter.structural.is_none() && fits {
                self.is_set[at] = true;
                self.is_changed |= self.values.list[at] != *value;
                self.values.list[at] = value.clone();
            }
        }
    }

    /// Lets passes take over the parameters that have changed: CPU nodes at once, everything else through `set`, with the
    /// position of the pass.
    ///
    /// # Errors
    /// What loading and planning would say of these values; all parameters have the values before then.
    pub fn apply(
        &mut self,
        cpu_passes: &mut CpuPasses,
        set: &mut dyn FnMut(usize, Changed<'_>),
    ) -> Result<(), Diagnostics> {
        if !std::mem::take(&mut self.is_changed) {
            return Ok(());
        }
        let mut diagnostics = Diagnostics::new();
        let count = self.settled.len();
        if self.attempt(cpu_passes, set, &mut diagnostics).is_none() {
            for (value, settled) in self.values.list.iter_mut().zip(&self.settled) {
                assign(value, settled);
            }
            self.attempt(cpu_passes, set, &mut Diagnostics::new());
            return Err(diagnostics);
        }
        for (settled, value) in self.settled.iter_mut().zip(&self.values.list[..count]) {
            if settled != value {
                assign(settled, value);
            }
        }
        Ok(())
    }

    fn attempt(
        &mut self,
        cpu_passes: &mut CpuPasses,
        set: &mut dyn FnMut(usize, Changed<'_>),
        diagnostics: &mut Diagnostics,
    ) -> Option<()> {
        let plan = self.plan.clone();
        self.follow(&plan.pipeline, diagnostics)?;
        for (at, planned) in plan.passes.iter().enumerate() {
            let mut is_node = false;
            for (position, setting) in planned.live.iter().enumerate() {
                let is_list = !setting.elements.is_empty();
                let mut value = Value::Bool(false);
                if is_list {
                    std::mem::swap(&mut value, &mut self.scratch);
                }
                self.value(setting, &mut value, diagnostics)?;
                if self.taken[at][position] != value {
                    is_node |= matches!(setting.target, PlannedTarget::Node);
                    assign(&mut self.taken[at][position], &value);
                    self.take(at, (position, setting), &value, set, diagnostics)?;
                }
                if is_list {
                    self.scratch = value;
                }
            }
            if is_node {
                let settings = &plan.pipeline.pass(planned.handle).live;
                let mut settings = LiveSettings { settings, values: &self.taken[at], diagnostics };
                cpu_passes.update(at, &mut settings)?;
                set(at, Changed::Node);
            }
        }
        Some(())
    }

    /// Lets a pass take over the value of a live setting, but for those of CPU nodes, which take over all at once.
    fn take(
        &mut self,
        at: usize,
        (position, setting): (usize, &PlannedSetting),
        value: &Value,
        set: &mut dyn FnMut(usize, Changed<'_>),
        diagnostics: &mut Diagnostics,
    ) -> Option<()> {
        let mut reject = |code: Code, message: String, help: &str| {
            let diagnostic = Diagnostic::error(code, setting.place, message);
            diagnostics.push(diagnostic.pointer(&setting.pointer).help(help));
            None
        };
        match &setting.target {
            PlannedTarget::Node => {}
            PlannedTarget::Member(block, member) => {
                let block = &mut self.blocks[at][*block];
                let packing = &mut self.packings[at][position];
                if let Err(message) =
                    pack_member(member, value, (packing, &mut self.numbers), &mut block.bytes)
                {
                    let spelling = member.layout.spelling();
                    let help = format!("the shader declares \"{}\" as {spelling}", member.name);
                    return reject(codes::EXPRESSION_TYPE, message, &help);
                }
                set(at, Changed::Block(block));
            }
            PlannedTarget::Workgroups(axis, limit) => {
                let Some(count) = whole_number(value, 0..=*limit) else {
                    let help = format!("whole numbers from 0 to {limit} are possible; ceil() rounds up");
                    return reject(codes::DISPATCH, format!("{value} is not a workgroup count"), &help);
                };
                set(at, Changed::Workgroups(*axis, count));
            }
            PlannedTarget::Drawn(target, most) => {
                let Some(count) = whole_number(value, 0..=u32::MAX) else {
                    let message = format!("{value} cannot be set here");
                    return reject(codes::OUT_OF_BOUNDS, message, "write a whole number from 0");
                };
                if let Some((most, buffer)) = most.as_ref().filter(|(most, _)| u64::from(count) > *most) {
                    let message = format!("\"{buffer}\" has {most} of the {count} that are drawn of it");
                    let help = "make the buffer larger, or draw less";
                    return reject(codes::DEVICE_RULE, message, help);
                }
                let is_count = *target == LiveTarget::Count;
                set(at, if is_count { Changed::Count(count) } else { Changed::Instances(count) });
            }
            PlannedTarget::Other(target) => match changed(*target, value) {
                Ok(changed) => set(at, changed),
                Err(help) => {
                    return reject(codes::OUT_OF_BOUNDS, format!("{value} cannot be set here"), help);
                }
            },
        }
        Some(())
    }

    /// Evaluates what follows from parameters, and holds it to ranges and constraints.
    fn follow(&mut self, pipeline: &Pipeline, diagnostics: &mut Diagnostics) -> Option<()> {
        let first = self.settled.len();
        for (at, following) in pipeline.following.iter().enumerate() {
            let value = self.evaluate(&following.expression, following.place, "", diagnostics)?;
            if let Some(declaration) = &following.declaration {
                let name = following.name.rsplit('$').next().unwrap_or_default();
                let before = &self.values.list[first + at];
                if let Some((code, message, help)) = rejected(name, declaration, &value, before) {
                    diagnostics.push(Diagnostic::error(code, following.place, message).help(help));
                    return None;
                }
            }
            self.values.list[first + at] = value;
        }
        for constraint in &pipeline.constraints {
            let (place, pointer) = (constraint.place, constraint.pointer.as_str());
            let holds = self.evaluate(&constraint.holds, place, pointer, diagnostics)?;
            if holds != Value::Bool(true) {
                let diagnostic =
                    Diagnostic::error(codes::CONSTRAINT, constraint.place, constraint.message.clone());
                let help = "set other values before the next frame";
                diagnostics.push(diagnostic.pointer(&constraint.pointer).help(help));
                return None;
            }
        }
        Some(())
    }

    /// The value of a live setting, in the memory of one before.
    fn value(
        &self,
        setting: &PlannedSetting,
        value: &mut Value,
        diagnostics: &mut Diagnostics,
    ) -> Option<()> {
        let evaluate = |expression: &Expression, diagnostics: &mut Diagnostics| {
            self.evaluate(expression, setting.place, &setting.pointer, diagnostics)
        };
        if setting.elements.is_empty() {
            *value = evaluate(&setting.expression, diagnostics)?;
            return Some(());
        }
        if !matches!(value, Value::List(_)) {
            *value = Value::List(Vec::with_capacity(setting.elements.len()));
        }
        if let Value::List(list) = value {
            list.clear();
            for element in &setting.elements {
                list.push(evaluate(element, diagnostics)?);
            }
        }
        Some(())
    }

    fn evaluate(
        &self,
        expression: &Expression,
        place: Span,
        pointer: &str,
        diagnostics: &mut Diagnostics,
    ) -> Option<Value> {
        match expression::evaluate(expression, &self.values) {
            Ok(value) => Some(value),
            Err(error) => {
                let diagnostic = Diagnostic::error(codes::EXPRESSION_ARITHMETIC, place, error.message);
                let help = error.help.unwrap_or_else(|| "set another value".to_owned());
                diagnostics.push(diagnostic.pointer(pointer).help(help));
                None
            }
        }
    }
}

/// Takes over a value in the memory of one of the same shape.
fn assign(to: &mut Value, from: &Value) {
    match (to, from) {
        (Value::List(to), Value::List(from)) if to.len() == from.len() => {
            to.iter_mut().zip(from).for_each(|(to, from)| assign(to, from));
        }
        (Value::Text(to), Value::Text(from)) => to.clone_from(from),
        (to, from) => *to = from.clone(),
    }
}

fn color(value: &Value) -> Option<[f64; 4]> {
    let Value::List(list) = value else { return None };
    let [r, g, b, a] = list.as_slice() else { return None };
    Some([r.number()?, g.number()?, b.number()?, a.number()?])
}

/// What a value sets.
///
/// # Errors
/// What it has to be.
fn changed(target: LiveTarget, value: &Value) -> Result<Changed<'static>, &'static str> {
    let found = match target {
        LiveTarget::Color(at) => color(value).map(|color| Changed::Color(at, color)),
        LiveTarget::BlendConstant => color(value).map(Changed::BlendConstant),
        LiveTarget::Depth => {
            let depth = value.number().filter(|depth| (0.0..=1.0).contains(depth));
            return depth.map(Changed::Depth).ok_or("depth lies between 0 and 1");
        }
        LiveTarget::Stencil | LiveTarget::Reference => {
            let byte = whole_number(value, 0..=255).ok_or("0 to 255 are possible")?;
            let is_clear = target == LiveTarget::Stencil;
            return Ok(if is_clear { Changed::Stencil(byte) } else { Changed::Reference(byte) });
        }
        LiveTarget::Count
        | LiveTarget::Instances
        | LiveTarget::Node
        | LiveTarget::Workgroups
        | LiveTarget::Block => None,
    };
    found.ok_or("write red, green, blue and alpha: [0, 0, 0, 1]")
}
