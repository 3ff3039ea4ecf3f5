//! Every resource and every pass of a document, declared: each instance of a loop or a subgraph by itself.

use std::collections::BTreeSet;

use crate::node::Registry;
use crate::pipeline::builder::PassBuilder;
use crate::pipeline::builder::Produced;
use crate::pipeline::expand::Expander;
use crate::pipeline::load::declared::{Declarations, Declared};
use crate::pipeline::load::sound::Broken;
use crate::pipeline::load::toggles;
use crate::pipeline::names::instance::Instance;
use crate::pipeline::pass::Pass;
use crate::pipeline::resource::Resource;
use crate::pipeline::resources::{history, value};
use crate::pipeline::settings::{Evaluate, LiveSetting};
use crate::pipeline::state::shared::Shared;
use crate::pipeline::toggle::Toggle;
use umbragraph_text::diagnostic::{Diagnostics, MAX_DIAGNOSTICS};
use umbragraph_text::document::{Document, Entry, Pointer, pointer_join};

/// The passes of a document that could be declared, and records about all others.
pub(super) struct Passes<'a> {
    pub(super) list: Vec<Pass>,
    /// The instances of passes after loops and subgraphs are expanded.
    pub(super) instances: Vec<Instance<'a>>,
    /// The names of passes and uses of subgraphs that are switched off, and of loops with zero iterations.
    pub(super) absent: BTreeSet<String>,
    /// The instances that could not be declared, with their names.
    pub(super) gaps: Vec<(String, &'a Entry)>,
    /// Whether a pass does not fit the schema, so that it may lack a key that names a resource.
    pub(super) is_unreadable: bool,
    pub(super) waiting: Vec<Instance<'a>>,
    pub(super) passthroughs: Vec<Instance<'a>>,
}

/// The outcome of declaring a pass.
enum Outcome {
    /// The `when` condition of the pass does not hold.
    Absent,
    /// The pass has errors, or depends on a part of the document that has errors.
    Gap,
    Sound(Produced, Vec<LiveSetting>),
}

/// Declares all resources, then all passes. Returns `None` at the maximum number of errors.
pub(super) fn declare<'a>(
    document: &'a Document,
    registry: &Registry,
    broken: &Broken,
    toggles: &[Toggle],
    shared: &mut Shared,
) -> Option<Passes<'a>> {
    let is_broken = |pointer: &str| broken.has(pointer);
    let mut expander = Expander::new(document, registry, &is_broken, shared);
    expander.top();
    let Expander { resources, instances, passthroughs, waiting, gaps, absent, .. } = expander;
    let list = Vec::with_capacity(instances.len());
    let mut passes =
        Passes { list, absent, gaps, is_unreadable: false, waiting, passthroughs, instances: Vec::new() };
    let mut declarations = Declarations::new(registry);
    declare_resources(resources, &mut declarations, shared);
    for instance in &instances {
        if shared.diagnostics.len() >= MAX_DIAGNOSTICS {
            return None;
        }
        passes.declare(instance, &mut declarations, toggles, shared);
    }
    passes.instances = instances;
    Some(passes)
}

fn declare_resources<'a>(
    resources: Vec<Instance<'a>>,
    declarations: &mut Declarations<'a, '_>,
    shared: &mut Shared,
) {
    shared.resource_index.reserve(resources.len());
    shared.resources.reserve(resources.len());
    for instance in resources {
        let kind = declarations.resource(&instance);
        shared.fix_all(&instance.entry.value, &instance.environment, &Pointer::Text(&instance.pointer));
        let mut resource = Resource {
            name: instance.name,
            place: instance.entry.key_span,
            pointer: instance.pointer,
            value: instance.entry.value.clone(),
            environment: instance.environment,
            kind,
            history: None,
        };
        value::compute_format(shared, &mut resource);
        history::add(shared, resource);
    }
}

impl<'a> Passes<'a> {
    fn declare(
        &mut self,
        instance: &Instance<'a>,
        declarations: &mut Declarations<'a, '_>,
        toggles: &[Toggle],
        shared: &mut Shared,
    ) {
        let gap = (instance.name.clone(), instance.entry);
        if instance.is_broken {
            self.is_unreadable = true;
            self.gaps.push(gap);
            return;
        }
        shared.fix_order(instance);
        let Some(declared) = declarations.pass(instance) else {
            self.gaps.push(gap);
            return;
        };
        match produce(instance, &declared, shared) {
            Outcome::Absent => {
                self.absent.insert(instance.name.clone());
                self.wait(instance, &declared);
                let is_top = instance.environment.is_top();
                if let Some(survey) = &mut shared.programs.survey {
                    survey.lacks(instance.entry, &instance.pointer, "when", is_top);
                }
            }
            Outcome::Gap => self.gaps.push(gap),
            Outcome::Sound(produced, live) => {
                self.add(instance, &declared, (produced, live), toggles, shared);
            }
        }
    }

    /// Records a pass whose `after` names passes that it must follow.
    fn wait(&mut self, instance: &Instance<'a>, declared: &Declared<'_>) {
        if !declared.common.after.is_empty() {
            self.waiting.push(instance.clone());
        }
    }

    fn add(
        &mut self,
        instance: &Instance<'a>,
        declared: &Declared<'a>,
        (produced, live): (Produced, Vec<LiveSetting>),
        toggles: &[Toggle],
        shared: &mut Shared,
    ) {
        let Instance { name, entry, pointer, environment, .. } = instance;
        let Declared { kind, common, .. } = declared;
        self.wait(instance, declared);
        let mut diagnostics = Diagnostics::new();
        let condition = toggles::condition(entry, pointer, environment, toggles, &mut diagnostics);
        shared.report_from(diagnostics, environment);
        if !common.passthrough.is_empty() {
            self.passthroughs.push(instance.clone());
        }
        let (kind, environment) = (kind.key.clone(), environment.clone());
        let mut pass = Pass::new(name.clone(), kind, entry.key_span, pointer.clone(), environment);
        pass.side_effect = common.side_effect || pass.environment.side_effect;
        pass.condition = condition;
        pass.live = live;
        pass.set_work(produced.0, Vec::new(), &shared.resources);
        self.list.push(pass);
    }
}

/// Lets the node kind of a pass declare its work, if the `when` condition of the pass holds.
fn produce(instance: &Instance<'_>, declared: &Declared<'_>, shared: &mut Shared) -> Outcome {
    let Instance { entry, pointer, environment, .. } = instance;
    let Declared { kind, common, settings } = declared;
    // Diagnostics of an instance carry the places where it is used; those of its pass alone are collected first.
    let outer = std::mem::take(&mut shared.diagnostics);
    let withheld = shared.withheld;
    let mut builder = PassBuilder {
        name: &instance.name,
        settings: &entry.value,
        pointer: pointer.clone(),
        environment,
        shared,
        open_axes: BTreeSet::new(),
        is_live: false,
        live: Vec::new(),
    };
    let present = common.when.as_ref().map_or(Some(true), |when| builder.boolean(when, "/when"));
    builder.settings = &kind.value;
    builder.pointer = pointer_join(pointer, &kind.key);
    let produced = match (present, settings) {
        (Some(true), Ok(settings)) => settings.declare(&mut builder),
        (Some(true), Err(error)) => {
            builder.settings_do_not_decode(error);
            None
        }
        _ => None,
    };
    let live = std::mem::take(&mut builder.live);
    if present != Some(false)
        && let Some(survey) = &mut shared.programs.survey
    {
        survey.has(entry);
    }
    let own = std::mem::replace(&mut shared.diagnostics, outer);
    let is_sound = !own.has_errors() && shared.withheld == withheld;
    shared.report_from(own, environment);
    match (present, produced) {
        (Some(false), _) => Outcome::Absent,
        (_, Some(produced)) if is_sound => Outcome::Sound(produced, live),
        _ => Outcome::Gap,
    }
}
