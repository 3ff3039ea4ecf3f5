//! Document to pipeline.

mod after;
mod connect;
mod declared;
mod extension_points;
mod names;
mod sections;
mod shared;
mod versions;

pub(super) use after::Waiting;
pub(super) use names::{RESERVED, VIEWPORT, bad_name};
pub use names::{has_word, is_name};
pub use sections::as_written;
pub(super) use shared::{Expected, Shared};

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use super::builder::PassBuilder;
use super::expand::Expander;
use super::modules::Modules;
use super::profiles::claimed_profiles;
use super::{Choice, Pass, Pipeline, Resource, StaticScope, history, preset, setting, toggle};
use crate::diagnostic::{Diagnostic, Diagnostics, MAXIMUM_FINDINGS, codes};
use crate::document::{self, Document, pointer_join};
use crate::draw::check_host;
use crate::language::{GeometryDeclaration, PipelineDeclaration};
use crate::node::Registry;
use crate::shader::{TargetProfile, TemplateSet};
use crate::source::Sources;
use connect::connect;
use declared::{Declarations, Declared};
use extension_points::check_extension_points;
use sections::{as_meant, check_schema};
use versions::{check_versions, uncertain};

/// Makes the pipeline that a document describes, in the configuration that `choice` names.
///
/// Findings go to `diagnostics`; the result is `None` only where the document is too broken to have passes at all, or has
/// more faults than are looked for ([`MAXIMUM_FINDINGS`]). A
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
pub fn load_sharing(
    document: &Document,
    registry: &Registry,
    templates: &Arc<TemplateSet>,
    profile: &TargetProfile,
    choice: &Choice,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
    modules: &mut Modules,
) -> Option<Pipeline> {
    let schema_findings = modules.of_schema(|| check_schema(document, registry));
    let read = as_meant(document, &schema_findings);
    let document = read.as_ref().unwrap_or(document);
    // A texture in an unknown format is a texture all the same, with faults of its own.
    let is_breaking = |finding: &&Diagnostic| finding.code != codes::FORMAT_UNKNOWN;
    let broken: BTreeSet<String> =
        schema_findings.iter().filter(is_breaking).map(|finding| finding.pointer.clone()).collect();
    let is_hopeless = schema_findings.len() >= MAXIMUM_FINDINGS;
    diagnostics.extend(schema_findings);
    if is_hopeless {
        return None;
    }
    let is_broken = |pointer: &str| {
        if broken.is_empty() {
            return false;
        }
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
    let features =
        setting::features(&decoded.features, section("features"), &choice.features, profile, diagnostics);
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

    let toggles = toggle::toggles(document, &decoded.toggles, diagnostics);
    let broken_settings: BTreeSet<String> = section("parameters")
        .iter()
        .chain(section("features"))
        .map(|entry| entry.key.clone())
        .filter(|name| !parameters.contains_key(name) && !features.contains_key(name))
        .collect();
    let mut shared = Shared {
        toggles: toggles.iter().map(|toggle| toggle.name.clone()).collect(),
        scope: StaticScope::new(&parameters, &features).with_broken(broken_settings.clone()),
        resources: Vec::new(),
        resource_index: HashMap::new(),
        geometry: decoded.geometry,
        programs: Vec::new(),
        program_keys: BTreeMap::new(),
        modules: std::mem::take(modules),
        refused: BTreeSet::new(),
        expected: Vec::new(),
        misgiven: Diagnostics::new(),
        expressions: HashMap::new(),
        withheld: 0,
        templates: templates.clone(),
        profile: profile.clone(),
        diagnostics: Diagnostics::new(),
        sources: sources.clone(),
    };
    let mut expander = Expander::new(document, registry, &is_broken, &mut shared);
    expander.top();
    let Expander {
        resources, instances, bypasses, mut waiting, mut gaps, mut unreadable, mut absent, ..
    } = expander;
    let mut said: Vec<toggle::Said<'_>> = bypasses
        .into_iter()
        .map(|(name, entry, pointer, environment)| toggle::Said { name, entry, pointer, environment })
        .collect();
    let mut declarations = Declarations::new(registry);
    shared.resource_index.reserve(resources.len());
    shared.resources.reserve(resources.len());
    for instance in resources {
        let kind = declarations.resource(&instance);
        let resource = Resource {
            name: instance.name,
            place: instance.entry.key_span,
            pointer: instance.pointer,
            value: instance.entry.value.clone(),
            environment: instance.environment,
            kind,
            history: None,
        };
        history::add(&mut shared, resource);
    }
    let mut passes: Vec<Pass> = Vec::with_capacity(instances.len());
    for instance in &instances {
        if shared.diagnostics.len() >= MAXIMUM_FINDINGS {
            diagnostics.extend(shared.diagnostics);
            *modules = shared.modules;
            return None;
        }
        let (entry, pointer, environment) = (instance.entry, &instance.pointer, &instance.environment);
        if instance.is_broken {
            unreadable = true;
            gaps.push((instance.name.clone(), entry));
            continue;
        }
        let Some(declared) = declarations.pass(instance) else {
            gaps.push((instance.name.clone(), entry));
            continue;
        };
        let Declared { kind, common, settings } = &*declared;
        // Findings of an instance carry the places where it is used; those of its pass alone are collected first.
        let outer = std::mem::take(&mut shared.diagnostics);
        let withheld = shared.withheld;
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
            Some(true) => match settings {
                Ok(settings) => settings.declare(&mut builder),
                Err(error) => {
                    builder.settings_do_not_decode(error);
                    None
                }
            },
            _ => None,
        };
        let uses = std::mem::take(&mut builder.uses);
        if present != Some(false) {
            shared.modules.has(entry);
        }
        let own = std::mem::replace(&mut shared.diagnostics, outer);
        let sound = !own.has_errors() && shared.withheld == withheld;
        shared.report_from(own, environment);
        match (present, produced) {
            (Some(false), _) => {
                absent.insert(instance.name.clone());
                shared.modules.lacks(entry, pointer, "when", environment.is_top());
            }
            (_, Some(produced)) if sound => {
                if !common.after.is_empty() {
                    waiting.push(after::Waiting {
                        name: instance.name.clone(),
                        entry,
                        pointer: pointer.clone(),
                        environment: environment.clone(),
                    });
                }
                let mut findings = Diagnostics::new();
                let condition = toggle::condition(entry, pointer, environment, &toggles, &mut findings);
                shared.report_from(findings, environment);
                if !common.bypass.is_empty() {
                    said.push(toggle::Said {
                        name: instance.name.clone(),
                        entry,
                        pointer: pointer.clone(),
                        environment: environment.clone(),
                    });
                }
                passes.push(Pass {
                    name: instance.name.clone(),
                    kind: kind.key.clone(),
                    place: entry.key_span,
                    pointer: pointer.clone(),
                    environment: environment.clone(),
                    uses,
                    after: Vec::new(),
                    is_misplaced: false,
                    side_effect: common.side_effect || environment.side_effect,
                    condition,
                    work: produced.0,
                });
            }
            _ => gaps.push((instance.name.clone(), entry)),
        }
    }
    after::connect(&waiting, &mut passes, &instances, &absent, &gaps, &mut shared);
    check_extension_points(document, &mut shared.diagnostics);
    let mut uncertain = uncertain(&gaps, &instances, unreadable, &shared);
    connect(&mut passes, &uncertain, &mut shared);
    let bypasses = toggle::connect(&said, &mut passes, &toggles, &mut uncertain, &mut shared);
    check_versions(&passes, &absent, &gaps, &mut shared);
    diagnostics.extend(shared.diagnostics);
    diagnostics.extend(shared.misgiven);
    *modules = shared.modules;
    let pipeline = Pipeline {
        name: document.root.get("name").and_then(document::Value::text).unwrap_or_default().to_owned(),
        profile: profile.clone(),
        parameters,
        features,
        toggles,
        bypasses,
        geometry: shared.geometry,
        resources: shared.resources,
        passes,
        programs: shared.programs.into_iter().map(Arc::unwrap_or_clone).collect(),
        uncertain,
        broken_settings,
        gaps: gaps.into_iter().map(|(name, _)| name).collect(),
    };
    for (geometry, interface) in registry.hosts() {
        diagnostics.extend(check_host(&pipeline, geometry, interface));
    }
    Some(pipeline)
}

/// The parts of a document that fit the schema, decoded; what does not fit has its findings already.
struct Decoded {
    parameters: BTreeMap<String, crate::language::ParameterDeclaration>,
    features: BTreeMap<String, crate::language::FeatureDeclaration>,
    toggles: BTreeMap<String, crate::language::ToggleDeclaration>,
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
            .filter_map(|entry| Some((entry.key.clone(), entry.value.decode().ok()?)))
            .collect()
    }
    Some(Decoded {
        parameters: section(document, "parameters", is_broken),
        features: section(document, "features", is_broken),
        toggles: section(document, "toggles", is_broken),
        geometry: section(document, "geometry", is_broken),
    })
}
