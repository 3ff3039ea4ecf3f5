//! Document to pipeline.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use super::builder::{PassBuilder, expression_finding};
use super::environment::Environment;
use super::expand::Expander;
use super::modules::Modules;
use super::profiles::claimed_profiles;
use super::{
    Choice, Pass, Pipeline, Program, ProgramVariant, Resource, ResourceKind, StaticScope, binding, preset,
    schema, setting,
};
use crate::diagnostic::{Diagnostic, Diagnostics, codes, did_you_mean, list_of};
use crate::document::{self, Document, Entry, pointer_join};
use crate::draw::check_host;
use crate::expression::{Expression, ExpressionError, ExpressionKind, Fault, Scope as _, Value};
use crate::language::{GeometryDeclaration, PassCommon, PipelineDeclaration, ResourceDeclaration};
use crate::node::Registry;
use crate::shader::{AxisValue, AxisValues, ShaderModule, TargetProfile, TemplateSet};
use crate::source::{Sources, Span};
use crate::work::{BoundSlot, Draw, PassHandle, ProgramHandle, ResourceHandle, SlotSource, Work};

/// Names that are no parameters or features, because expressions know them already.
pub(super) const RESERVED: &[&str] = &["viewport", "true", "false"];

/// Makes the pipeline that a document describes, in the configuration that `choice` names.
///
/// Findings go to `diagnostics`; the result is `None` only where the document is too broken to have passes at all. A
/// pipeline with errors is good for further checks, not for use.
pub fn load(
    document: &Document,
    registry: &Registry,
    templates: &Arc<TemplateSet>,
    profile: &TargetProfile,
    choice: &Choice,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Option<Pipeline> {
    let mut modules = Modules::default();
    load_sharing(document, registry, templates, profile, choice, sources, diagnostics, &mut modules)
}

/// The same, with shader modules that earlier loads have made.
#[allow(clippy::too_many_arguments)]
pub(super) fn load_sharing(
    document: &Document,
    registry: &Registry,
    templates: &Arc<TemplateSet>,
    profile: &TargetProfile,
    choice: &Choice,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
    modules: &mut Modules,
) -> Option<Pipeline> {
    let schema_findings = modules.of_schema(|| {
        let schema = schema(registry);
        let mut findings = Diagnostics::new();
        document::schema::check(&document.root, &schema, &schema, "", &mut findings);
        findings
    });
    let broken: BTreeSet<String> = schema_findings.iter().map(|finding| finding.pointer.clone()).collect();
    diagnostics.extend(schema_findings);
    let is_broken = |pointer: &str| {
        let below = format!("{pointer}/");
        broken.contains(pointer)
            || broken.range(below.clone()..).next().is_some_and(|known| known.starts_with(&below))
    };

    let section = |name: &str| document.root.get(name).and_then(document::Value::entries).unwrap_or_default();
    let decoded = decode_sound_parts(document, &is_broken)?;
    claimed_profiles(document, diagnostics);

    for entry in section("parameters").iter().chain(section("features")) {
        if RESERVED.contains(&entry.key.as_str()) || !is_name(&entry.key) {
            diagnostics.push(bad_name(entry));
        }
    }
    let parameters =
        setting::parameters(&decoded.parameters, section("parameters"), &choice.parameters, diagnostics);
    let features = setting::features(&decoded.features, section("features"), &choice.features, diagnostics);
    preset::check(section("presets"), &decoded.parameters, &decoded.features, choice, diagnostics);
    for entry in section("features") {
        if let Some(twin) = section("parameters").iter().find(|other| other.key == entry.key) {
            diagnostics.push(
                Diagnostic::error(
                    codes::BAD_NAME,
                    entry.key_span,
                    format!("\"{}\" is a feature and a parameter", entry.key),
                )
                .related(twin.key_span, "the parameter")
                .help("give one of the two another name"),
            );
        }
    }

    let mut shared = Shared {
        scope: StaticScope::new(&parameters, &features),
        resources: Vec::new(),
        resource_index: HashMap::new(),
        geometry: decoded.geometry,
        programs: Vec::new(),
        program_keys: BTreeMap::new(),
        modules: std::mem::take(modules),
        refused: BTreeSet::new(),
        templates: templates.clone(),
        profile: profile.clone(),
        diagnostics: Diagnostics::new(),
        sources: sources.clone(),
        broken_settings: decoded
            .parameters
            .keys()
            .filter(|name| !parameters.contains_key(*name))
            .chain(decoded.features.keys().filter(|name| !features.contains_key(*name)))
            .cloned()
            .chain(section("parameters").iter().chain(section("features")).map(|entry| entry.key.clone()))
            .filter(|name| !parameters.contains_key(name) && !features.contains_key(name))
            .collect(),
    };
    let mut expander = Expander::new(document, registry, &is_broken, &mut shared);
    expander.top();
    let Expander { resources, instances, mut gaps, mut unreadable, mut absent, .. } = expander;
    for instance in resources {
        let declaration: Option<ResourceDeclaration> = if instance.is_broken {
            None
        } else {
            serde_json::from_value(instance.entry.value.to_json()).ok()
        };
        let kind = match declaration {
            Some(ResourceDeclaration::Texture(texture)) => ResourceKind::Texture(texture),
            Some(ResourceDeclaration::Buffer(buffer)) => ResourceKind::Buffer(buffer),
            None => ResourceKind::Broken,
        };
        shared.add_resource(Resource {
            name: instance.name,
            place: instance.entry.key_span,
            pointer: instance.pointer,
            value: instance.entry.value.clone(),
            environment: instance.environment,
            kind,
        });
    }
    let mut passes: Vec<Pass> = Vec::new();
    let mut after: Vec<(usize, Vec<String>, &Entry)> = Vec::new();
    for instance in &instances {
        let (entry, pointer, environment) = (instance.entry, &instance.pointer, &instance.environment);
        if instance.is_broken {
            unreadable = true;
            gaps.push((instance.name.clone(), entry));
            continue;
        }
        let Some((kind, common)) = take_apart(entry, registry) else {
            gaps.push((instance.name.clone(), entry));
            continue;
        };
        let Some(node) = registry.get(&kind.key) else { continue };
        // Findings of an instance carry the places where it is used; those of its pass alone are collected first.
        let outer = std::mem::take(&mut shared.diagnostics);
        let mut builder = PassBuilder {
            name: &instance.name,
            settings: &entry.value,
            pointer: pointer.clone(),
            uses: Vec::new(),
            environment,
            shared: &mut shared,
        };
        let present = common.when.as_ref().map_or(Some(true), |when| builder.boolean(when, "/when"));
        builder.settings = &kind.value;
        builder.pointer = pointer_join(pointer, &kind.key);
        let produced = match present {
            Some(true) => node.declare(kind.value.to_json(), &mut builder),
            _ => None,
        };
        let uses = std::mem::take(&mut builder.uses);
        let own = std::mem::replace(&mut shared.diagnostics, outer);
        let sound = !own.has_errors();
        shared.report_from(own, environment);
        match (present, produced) {
            (Some(false), _) => {
                absent.insert(instance.name.clone());
            }
            (_, Some(produced)) if sound => {
                after.push((passes.len(), common.after, entry));
                passes.push(Pass {
                    name: instance.name.clone(),
                    kind: kind.key.clone(),
                    place: entry.key_span,
                    pointer: pointer.clone(),
                    environment: environment.clone(),
                    uses,
                    after: Vec::new(),
                    side_effect: common.side_effect,
                    work: produced.0,
                });
            }
            _ => gaps.push((instance.name.clone(), entry)),
        }
    }
    let positions: BTreeMap<String, usize> =
        passes.iter().enumerate().map(|(at, pass)| (pass.name.clone(), at)).collect();
    for (at, wanted, entry) in after {
        for (position, written) in wanted.iter().enumerate() {
            let environment = passes[at].environment.clone();
            let pointer = format!("{}/after/{position}", passes[at].pointer);
            let value = entry.value.nearest(&format!("/after/{position}"));
            let name = match environment.interpolate(written, &shared.scope) {
                Ok(name) => environment.pass(&name),
                Err(error) => {
                    let raw = shared.sources_text(value.span);
                    shared.diagnostics.push(expression_finding(&error, value, &raw).pointer(pointer));
                    continue;
                }
            };
            let members: Vec<usize> = match positions.get(&name) {
                Some(index) => vec![*index],
                // The name of a loop or subgraph means all of its passes.
                None => positions
                    .range(format!("{name}.")..)
                    .take_while(|(other, _)| other.starts_with(&format!("{name}.")))
                    .map(|(_, index)| *index)
                    .collect(),
            };
            if members.is_empty() && !is_absent(&absent, &name) && !is_gap(&gaps, &name) {
                let all: Vec<String> = instances.iter().map(|instance| instance.name.clone()).collect();
                shared.diagnostics.push(unknown_pass(&name, &all, value.span).pointer(pointer));
            }
            passes[at].after.extend(members.into_iter().map(|index| PassHandle(index as u32)));
        }
    }
    let uncertain = uncertain(&gaps, unreadable, &shared);
    connect(&mut passes, &uncertain, &mut shared);
    check_versions(&passes, &absent, &gaps, &mut shared);
    diagnostics.extend(shared.diagnostics);
    *modules = shared.modules;
    let pipeline = Pipeline {
        name: document.root.get("name").and_then(document::Value::text).unwrap_or_default().to_owned(),
        profile: profile.clone(),
        parameters,
        features,
        geometry: shared.geometry,
        resources: shared.resources,
        passes,
        programs: shared.programs,
        uncertain,
    };
    for (geometry, interface) in registry.hosts() {
        diagnostics.extend(check_host(&pipeline, geometry, interface));
    }
    Some(pipeline)
}

/// What all passes of one pipeline share while they are declared.
pub(super) struct Shared {
    pub(super) scope: StaticScope,
    pub(super) resources: Vec<Resource>,
    resource_index: HashMap<String, ResourceHandle>,
    pub(super) geometry: BTreeMap<String, GeometryDeclaration>,
    pub(super) programs: Vec<Program>,
    program_keys: BTreeMap<(String, AxisValues, Vec<String>), Option<ProgramHandle>>,
    pub(super) modules: Modules,
    /// The variants whose findings are reported.
    refused: BTreeSet<(String, AxisValues)>,
    pub(super) templates: Arc<TemplateSet>,
    pub(super) profile: TargetProfile,
    pub(super) diagnostics: Diagnostics,
    sources: Sources,
    /// Declared settings that have no value because of findings of their own.
    broken_settings: BTreeSet<String>,
}

impl Shared {
    pub(super) fn find(&self, name: &str) -> Option<ResourceHandle> {
        self.resource_index.get(name).copied()
    }

    fn add_resource(&mut self, resource: Resource) -> ResourceHandle {
        let handle = ResourceHandle(self.resources.len() as u32);
        self.resource_index.entry(resource.name.clone()).or_insert(handle);
        self.resources.push(resource);
        handle
    }

    pub(super) fn intern_data(&mut self, name: &str, place: Span, pointer: &str) -> ResourceHandle {
        self.find(name).unwrap_or_else(|| {
            self.add_resource(Resource {
                name: name.to_owned(),
                place,
                pointer: pointer.to_owned(),
                value: document::Value { span: place, kind: document::Kind::Null },
                environment: Arc::default(),
                kind: ResourceKind::Data(None),
            })
        })
    }

    /// Reports the findings of one instance: with the places where it is used, and each fault of a subgraph once.
    pub(super) fn report_from(&mut self, findings: Diagnostics, environment: &Environment) {
        for mut finding in findings {
            if environment.used_at.is_empty() {
                self.diagnostics.push(finding);
                continue;
            }
            let known = self.diagnostics.iter().any(|known| {
                (known.code, &known.place, &known.message) == (finding.code, &finding.place, &finding.message)
            });
            if !known {
                for place in &environment.used_at {
                    finding = finding.related(*place, "used here");
                }
                self.diagnostics.push(finding);
            }
        }
    }

    pub(super) fn sources_text(&self, span: Span) -> String {
        self.sources.text(span).to_owned()
    }

    /// Whether the text of a template, or of any that it could include, has the word: a binding that this variant does
    /// not have, another may.
    pub(super) fn is_mentioned(&self, template: &str, word: &str) -> bool {
        let text_of = |name: &str| {
            let file = self.templates.file(name).and_then(|file| self.sources.get(file));
            file.map(|file| file.text().clone()).unwrap_or_else(|| "".into())
        };
        let mut reached = vec![template.to_owned()];
        let mut at = 0;
        while let Some(name) = reached.get(at) {
            let text = text_of(name);
            if has_word(&text, word) {
                return true;
            }
            let quoted =
                |name: &str| text.contains(&format!("\"{name}\"")) || text.contains(&format!("'{name}'"));
            let included: Vec<String> =
                self.templates.names().filter(|name| quoted(name)).map(str::to_owned).collect();
            reached.extend(included.into_iter().filter(|name| !reached.contains(name)).collect::<Vec<_>>());
            at += 1;
        }
        false
    }

    /// The first name of a deferred expression that nothing will ever define.
    pub(super) fn unknown_name(&self, expression: &Expression) -> Option<ExpressionError> {
        match &expression.kind {
            ExpressionKind::Name(name) => {
                let head = name.rsplit_once('.').map_or(name.as_str(), |(head, _)| head);
                let known = self.scope.lookup(name).is_some()
                    || matches!(name.as_str(), "viewport" | "viewport.width" | "viewport.height")
                    || self.find(name).is_some()
                    || self.find(head).is_some()
                    || self.broken_settings.contains(name);
                (!known).then(|| {
                    let mut names = self.scope.names();
                    names.extend(self.resources.iter().map(|resource| resource.name.clone()));
                    names.push("viewport".to_owned());
                    ExpressionError {
                        range: expression.range.clone(),
                        fault: Fault::UnknownName,
                        message: format!("there is no \"{name}\""),
                        help: did_you_mean(name, names.iter().map(String::as_str))
                            .map(|meant| format!("did you mean \"{meant}\"?")),
                    }
                })
            }
            ExpressionKind::Unary(_, a) => self.unknown_name(a),
            ExpressionKind::Binary(_, a, b) | ExpressionKind::Index(a, b) => {
                self.unknown_name(a).or_else(|| self.unknown_name(b))
            }
            ExpressionKind::Conditional(a, b, c) => {
                self.unknown_name(a).or_else(|| self.unknown_name(b)).or_else(|| self.unknown_name(c))
            }
            ExpressionKind::Call(_, list) | ExpressionKind::List(list) => {
                list.iter().find_map(|item| self.unknown_name(item))
            }
            ExpressionKind::Literal(_) => None,
        }
    }

    /// The program of a template with chosen axes, in every combination of the mesh properties.
    pub(super) fn program(
        &mut self,
        template: &str,
        axes: AxisValues,
        properties: Vec<String>,
        place: Span,
        pointer: &str,
    ) -> Option<ProgramHandle> {
        let key = (template.to_owned(), axes.clone(), properties.clone());
        if let Some(known) = self.program_keys.get(&key) {
            return *known;
        }
        let handle = self.new_program(template, axes, &properties, place, pointer);
        self.program_keys.insert(key, handle);
        handle
    }

    fn new_program(
        &mut self,
        template: &str,
        axes: AxisValues,
        properties: &[String],
        place: Span,
        pointer: &str,
    ) -> Option<ProgramHandle> {
        let mut variants = Vec::new();
        for mask in 0..1u32 << properties.len().min(8) {
            let mut active: Vec<String> = Vec::new();
            let mut values = axes.clone();
            for (bit, name) in properties.iter().enumerate() {
                let on = mask & (1 << bit) != 0;
                values.insert(name.clone(), AxisValue::Bool(on));
                if on {
                    active.push(name.clone());
                }
            }
            active.sort();
            let module = self.module(template, values, place, pointer)?;
            variants.push(ProgramVariant { properties: active, module });
        }
        match Program::new(template.to_owned(), axes, variants, place) {
            Ok(program) if program.bindings.iter().any(|binding| self.is_beyond(binding)) => {
                let beyond: Vec<_> =
                    program.bindings.iter().filter(|binding| self.is_beyond(binding)).collect();
                for binding in beyond {
                    let message = format!(
                        "{template} declares \"{}\" at @group({}) @binding({})",
                        binding.name, binding.group, binding.entry.binding
                    );
                    let limits = &self.profile.limits;
                    let help = format!(
                        "groups are below {}, bindings below {}",
                        limits.max_bind_groups, limits.max_bindings_per_bind_group
                    );
                    self.diagnostics.push(
                        Diagnostic::error(codes::DEVICE_RULE, place, message).pointer(pointer).help(help),
                    );
                }
                None
            }
            Ok(program) => {
                self.programs.push(program);
                Some(ProgramHandle(self.programs.len() as u32 - 1))
            }
            Err(findings) => {
                self.diagnostics.extend(findings.into_iter().map(|finding| finding.pointer(pointer)));
                None
            }
        }
    }

    /// Whether a binding has a number that no device of the profile allows.
    fn is_beyond(&self, binding: &super::ProgramBinding) -> bool {
        let limits = &self.profile.limits;
        binding.group >= limits.max_bind_groups || binding.entry.binding >= limits.max_bindings_per_bind_group
    }

    fn module(
        &mut self,
        template: &str,
        values: AxisValues,
        place: Span,
        pointer: &str,
    ) -> Option<Arc<ShaderModule>> {
        let key = (template.to_owned(), values.clone());
        match self.modules.get(&self.templates, template, values, &self.profile) {
            Ok(module) => Some(module),
            Err(_) if !self.refused.insert(key) => None,
            Err(findings) => {
                for mut finding in findings {
                    if finding.place == crate::diagnostic::Place::Nowhere {
                        finding.place = place.into();
                        finding.pointer = pointer.to_owned();
                    } else {
                        finding = finding.related(place, "used by this pass");
                    }
                    // The same fault in a second variant, or a second pass, is the same fault.
                    let known = self.diagnostics.iter().any(|known| {
                        (known.code, &known.place, &known.message)
                            == (finding.code, &finding.place, &finding.message)
                    });
                    if !known {
                        self.diagnostics.push(finding);
                    }
                }
                None
            }
        }
    }
}

/// The parts of a document that fit the schema, decoded; what does not fit has its findings already.
struct Decoded {
    parameters: BTreeMap<String, crate::language::ParameterDeclaration>,
    features: BTreeMap<String, crate::language::FeatureDeclaration>,
    geometry: BTreeMap<String, GeometryDeclaration>,
}

fn decode_sound_parts(document: &Document, is_broken: &dyn Fn(&str) -> bool) -> Option<Decoded> {
    // Assures that the sections decoded one by one below are those of the declared type.
    let _: fn(&PipelineDeclaration) -> &BTreeMap<String, serde_json::Value> = |pipeline| &pipeline.passes;
    document.root.entries()?;
    fn section<T: serde::de::DeserializeOwned>(
        document: &Document,
        name: &str,
        is_broken: &dyn Fn(&str) -> bool,
    ) -> BTreeMap<String, T> {
        let entries = document.root.get(name).and_then(document::Value::entries).unwrap_or_default();
        entries
            .iter()
            .filter(|entry| !is_broken(&pointer_join(&format!("/{name}"), &entry.key)))
            .filter_map(|entry| {
                Some((entry.key.clone(), serde_json::from_value(entry.value.to_json()).ok()?))
            })
            .collect()
    }
    Some(Decoded {
        parameters: section(document, "parameters", is_broken),
        features: section(document, "features", is_broken),
        geometry: section(document, "geometry", is_broken),
    })
}

pub(super) fn has_word(text: &str, word: &str) -> bool {
    let boundary = |c: Option<char>| !c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    text.match_indices(word).any(|(at, _)| {
        boundary(text[..at].chars().next_back()) && boundary(text[at + word.len()..].chars().next())
    })
}

/// A name starts with a letter and goes on with letters, digits and underscores.
pub(super) fn is_name(name: &str) -> bool {
    name.chars().next().is_some_and(|first| first.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

pub(super) fn bad_name(entry: &Entry) -> Diagnostic {
    Diagnostic::error(codes::BAD_NAME, entry.key_span, format!("\"{}\" cannot be a name here", entry.key))
        .help("a name starts with a letter, goes on with letters, digits and underscores, and is no word of the expression language")
}

/// The node kind's entry of a pass, and what the pass says beside it.
fn take_apart<'a>(entry: &'a Entry, registry: &Registry) -> Option<(&'a Entry, PassCommon)> {
    let entries = entry.value.entries()?;
    let kind = entries.iter().find(|member| registry.get(&member.key).is_some())?;
    let common: serde_json::Map<String, serde_json::Value> = entries
        .iter()
        .filter(|member| registry.get(&member.key).is_none())
        .map(|member| (member.key.clone(), member.value.to_json()))
        .collect();
    Some((kind, serde_json::from_value(common.into()).ok()?))
}

fn unknown_pass(name: &str, names: &[String], place: Span) -> Diagnostic {
    let finding = Diagnostic::error(codes::UNKNOWN_PASS, place, format!("there is no pass \"{name}\""));
    match did_you_mean(name, names.iter().map(String::as_str)) {
        Some(meant) => finding.help(format!("did you mean \"{meant}\"?")),
        None => finding.help(format!("the passes are {}", list_of(names.iter().map(String::as_str)))),
    }
}

/// The resources of which nothing is known: broken ones, and those that passes with findings mention (any string that
/// is a reference to one). A pass that does not fit the schema may lack the very key that names a resource; then no
/// resource is certain.
fn uncertain(gaps: &[(String, &Entry)], unreadable: bool, shared: &Shared) -> BTreeSet<ResourceHandle> {
    let all = (0..shared.resources.len() as u32).map(ResourceHandle);
    let broken =
        |handle: &ResourceHandle| matches!(shared.resources[handle.index()].kind, ResourceKind::Broken);
    let mut found: BTreeSet<ResourceHandle> = all.filter(|handle| unreadable || broken(handle)).collect();
    for (_, gap) in gaps {
        gap.value.for_each_text(&mut |text| {
            let name = text.split('@').next().unwrap_or(text);
            found.extend(shared.find(name));
        });
    }
    found
}

/// Lays host data out in the blocks that it is bound to, now that all of it is published.
fn connect(passes: &mut [Pass], uncertain: &BTreeSet<ResourceHandle>, shared: &mut Shared) {
    let mut unpublished: BTreeMap<ResourceHandle, (Span, String)> = BTreeMap::new();
    for pass in passes.iter_mut() {
        for one in &pass.uses {
            if matches!(shared.resources[one.resource.index()].kind, ResourceKind::Data(None))
                && !uncertain.contains(&one.resource)
            {
                unpublished.entry(one.resource).or_insert((one.place, one.pointer.clone()));
            }
        }
        let Some((program, slots)) = slots_mut(&mut pass.work) else { continue };
        let program = &shared.programs[program.index()];
        for slot in slots {
            let Some(block) =
                program.binding_at(slot.group, slot.binding).and_then(|binding| binding.block.as_ref())
            else {
                continue;
            };
            let (shape, data_name, target, values) = match &mut slot.source {
                SlotSource::View(layout) => (crate::data::View::shape(), "view".to_owned(), layout, None),
                SlotSource::Data { resource, layout, values } => {
                    let known = &shared.resources[resource.index()];
                    let ResourceKind::Data(Some(shape)) = &known.kind else { continue };
                    (shape.clone(), known.name.clone(), layout, values.as_ref())
                }
                _ => continue,
            };
            match binding::match_block(block, &shape, &data_name, values) {
                Ok(layout) => *target = layout,
                Err(faults) => {
                    for fault in faults {
                        shared.diagnostics.push(
                            Diagnostic::error(
                                codes::BLOCK_MISMATCH,
                                slot.place,
                                format!("in \"{}\" of {}: {fault}", slot.name, program.template),
                            )
                            .pointer(&slot.pointer)
                            .help("members of a block take the published value of the same name and type"),
                        );
                    }
                }
            }
        }
    }
    for (resource, (place, pointer)) in unpublished {
        let name = shared.resources[resource.index()].name.clone();
        let published: Vec<&str> = shared
            .resources
            .iter()
            .filter(|resource| !matches!(resource.kind, ResourceKind::Data(None)))
            .map(|resource| resource.name.as_str())
            .collect();
        let help = match did_you_mean(&name, published.iter().copied()) {
            Some(meant) => format!("did you mean \"{meant}\"?"),
            None => "a host pass, such as a cascade fit, has to publish it".to_owned(),
        };
        shared.diagnostics.push(
            Diagnostic::error(codes::NOT_PUBLISHED, place, format!("no pass publishes the data \"{name}\""))
                .help(help)
                .pointer(pointer),
        );
    }
}

fn slots_mut(work: &mut Work) -> Option<(ProgramHandle, &mut Vec<BoundSlot>)> {
    match work {
        Work::Render(render) => match &mut render.draw {
            Draw::Fullscreen { program, bindings } => Some((*program, bindings)),
            Draw::Scene(scene) => Some((scene.program, &mut scene.bindings)),
        },
        Work::Compute(compute) => Some((compute.program, &mut compute.bindings)),
        Work::Host(_) | Work::Copy(_) => None,
    }
}

/// Whether a pass is, or comes of, one that is switched off.
fn is_absent(absent: &BTreeSet<String>, name: &str) -> bool {
    let mut name = name;
    loop {
        if absent.contains(name) {
            return true;
        }
        match name.rsplit_once('.') {
            Some((head, _)) => name = head,
            None => return false,
        }
    }
}

/// Whether a pass is, or comes of, one that could not be declared.
fn is_gap(gaps: &[(String, &Entry)], name: &str) -> bool {
    gaps.iter().any(|(gap, _)| {
        name.strip_prefix(gap.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    })
}

/// Finds versions that no pass writes.
fn check_versions(
    passes: &[Pass],
    absent: &BTreeSet<String>,
    gaps: &[(String, &Entry)],
    shared: &mut Shared,
) {
    let mut writers_of: HashMap<ResourceHandle, BTreeSet<&str>> = HashMap::new();
    for pass in passes {
        for one in pass.uses.iter().filter(|one| one.usage.writes()) {
            writers_of.entry(one.resource).or_default().insert(&pass.name);
        }
    }
    let nobody = BTreeSet::new();
    for pass in passes {
        for one in &pass.uses {
            let super::Version::WrittenBy(writer) = &one.version else { continue };
            let resource = &shared.resources[one.resource.index()].name;
            let writers = writers_of.get(&one.resource).unwrap_or(&nobody);
            if writers.contains(writer.as_str()) || is_gap(gaps, writer) {
                continue;
            }
            let why = if is_absent(absent, writer) { ", which is switched off here" } else { "" };
            let message = format!("no pass \"{writer}\" writes \"{resource}\"{why}");
            let help = match did_you_mean(writer, writers.iter().copied()) {
                Some(meant) => format!("did you mean \"{resource}@{meant}\"?"),
                None if writers.is_empty() => format!("nothing writes \"{resource}\""),
                None => format!("it is written by {}", list_of(writers.iter().copied())),
            };
            shared.diagnostics.push(
                Diagnostic::error(codes::UNKNOWN_PASS, one.place, message).help(help).pointer(&one.pointer),
            );
        }
    }
}

/// Evaluates an expression in any scope and reports what is wrong with it.
pub(crate) fn evaluate_at(
    expression: &Expression,
    scope: &dyn crate::expression::Scope,
    place: Span,
    pointer: &str,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Option<Value> {
    match crate::expression::evaluate(expression, scope) {
        Ok(value) => Some(value),
        Err(error) => {
            let raw = sources.text(place);
            let text = raw.trim_matches('"').to_owned();
            let value = document::Value { span: place, kind: document::Kind::Text(text) };
            diagnostics.push(expression_finding(&error, &value, raw).pointer(pointer));
            None
        }
    }
}
