//! Document to pipeline, in steps:
//!
//! - `sections`, `sound`: what the schema says, and what of the document fits it, decoded;
//! - `settings`, `constraints`: parameters and features with their values, and which go together;
//! - `declare`: every instance of every resource and pass, declared; `programs`, with what they share (`shared`);
//! - `after`, `connect`, `versions`, `extension_points`: what passes say of one another.

mod after;
mod connect;
mod constraints;
mod declare;
mod declared;
mod extension_points;
pub(super) mod hosts;
pub(super) mod passthroughs;
pub(super) mod profiles;
pub(super) mod sections;
mod settings;
mod sound;
mod toggles;
mod versions;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::draw::HostFilters;
use crate::node::Registry;
use crate::pipeline::configuration::TypedPipeline;
use crate::pipeline::load::connect::connect;
use crate::pipeline::load::declare::{Passes, declare};
use crate::pipeline::load::extension_points::check_extension_points;
use crate::pipeline::load::hosts::{check_host, misspelt_hosts};
use crate::pipeline::load::profiles::claimed_profiles;
use crate::pipeline::load::sections::{as_meant, check_schema, is_of_incomplete};
use crate::pipeline::load::settings::Settings;
use crate::pipeline::load::sound::{Broken, Sound};
use crate::pipeline::load::versions::{check_versions, name_last_writers, uncertain};
use crate::pipeline::pass::Pass;
use crate::pipeline::settings::kinds;
use crate::pipeline::settings::overrides::Overrides;
use crate::pipeline::state::programs::Programs;
use crate::pipeline::state::shared::Shared;
use crate::pipeline::survey::Survey;
use crate::pipeline::toggle::{Passthrough, Toggle};
use crate::work::ResourceHandle;
use umbragraph_shaders::ShaderCache;
use umbragraph_text::diagnostic::{Diagnostics, MAX_DIAGNOSTICS};
use umbragraph_text::document::{self, Document};
use umbragraph_text::source::Sources;

/// The options for loading a document.
#[derive(Clone, Copy, Debug)]
pub struct LoadOptions<'a> {
    /// The node kinds that passes can name.
    pub registry: &'a Registry,
    /// The templates and the target profile, with the cache of shader modules from earlier loads.
    pub shaders: &'a Arc<ShaderCache>,
    /// The caller's values of parameters and features.
    pub overrides: &'a Overrides,
    /// The result of [`check_schema`] for the document; `None` to compute it.
    pub schema: Option<&'a Diagnostics>,
    /// Whether all variants are validated together later. Errors of shaders are then left to that step, and
    /// [`TypedPipeline::survey`] is recorded for it.
    pub is_surveyed: bool,
}

impl<'a> LoadOptions<'a> {
    /// Creates options for a single load, without survey and schema diagnostics.
    pub fn new(registry: &'a Registry, shaders: &'a Arc<ShaderCache>, overrides: &'a Overrides) -> Self {
        Self { registry, shaders, overrides, schema: None, is_surveyed: false }
    }
}

/// Loads the pipeline that a document describes, in the configuration that `overrides` selects.
///
/// Diagnostics go to `diagnostics`. The result is `None` only if the document is too broken to have passes, or has
/// [`MAX_DIAGNOSTICS`] errors or more. A pipeline with errors may be checked further, but not used.
pub fn load(
    document: &Document,
    options: &LoadOptions<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Option<TypedPipeline> {
    let LoadOptions { registry, shaders, overrides, schema, is_surveyed } = *options;
    let profile = shaders.profile();
    let schema_diagnostics = schema.cloned().unwrap_or_else(|| check_schema(document, registry));
    let read = as_meant(document, &schema_diagnostics);
    let (document, corrected) = match &read {
        Some(read) => (&read.document, Some(&read.corrected)),
        None => (document, None),
    };
    let broken = Broken::new(&schema_diagnostics, corrected);
    let is_hopeless = schema_diagnostics.len() >= MAX_DIAGNOSTICS;
    diagnostics
        .extend(schema_diagnostics.into_iter().filter(|diagnostic| !is_of_incomplete(document, diagnostic)));
    if is_hopeless {
        return None;
    }
    let mut sound = Sound::decode(document, &broken)?;
    claimed_profiles(document, diagnostics);
    let (parameters, features) = (&mut sound.parameters, &mut sound.features);
    kinds::remove_contradictions(document, parameters, features, diagnostics);
    let settings = Settings::choose(document, &sound, &broken, overrides, profile, diagnostics);
    let constraints = constraints::check(document, &sound, &settings, diagnostics);
    let toggles = toggles::toggles(document, &sound.toggles, diagnostics);
    let programs = Programs::new(shaders, is_surveyed.then(Survey::default));
    let names = toggles.iter().map(|toggle| toggle.name.clone()).collect();
    let mut shared =
        Shared::new(settings.scope(), settings.dependence(), names, sound.geometry, programs, sources);
    let stated = registry.hosts().iter().filter_map(|(geometry, interface)| match &interface.filters {
        HostFilters::Words(words) => Some((geometry.clone(), words.clone())),
        HostFilters::Any | HostFilters::Unstated => None,
    });
    shared.filters = stated.collect();
    let connected = declare(document, registry, &broken, &toggles, &mut shared)
        .map(|passes| Connected::new(document, passes, &toggles, &mut shared));
    diagnostics.extend(shared.diagnostics);
    let Connected { passes, uncertain, passthroughs, gaps } = connected?;
    diagnostics.extend(shared.argument_errors);
    let mut parameters = settings.parameters;
    for (name, structural) in shared.dependence.structural {
        if let Some(parameter) = parameters.get_mut(&name) {
            parameter.structural = Some(structural);
        }
    }
    let pipeline = TypedPipeline {
        name: document.root.get("name").and_then(document::Value::text).unwrap_or_default().to_owned(),
        profile: profile.clone(),
        parameters,
        features: settings.features,
        derived: settings.derived,
        following: shared.dependence.following,
        given: shared.given,
        constraints,
        toggles,
        passthroughs,
        geometry: shared.geometry,
        hosts: registry.hosts().clone(),
        resources: shared.resources,
        passes,
        rejected: shared.programs.rejected,
        survey: shared.programs.survey,
        programs: shared.programs.list.into_iter().map(Arc::unwrap_or_clone).collect(),
        uncertain,
        broken_settings: settings.broken,
        gaps,
        sources: sources.clone(),
    };
    for (geometry, interface) in &pipeline.hosts {
        diagnostics.extend(check_host(&pipeline, geometry, interface));
    }
    diagnostics.extend(misspelt_hosts(&pipeline));
    Some(pipeline)
}

/// The declared passes after their references to one another are resolved.
struct Connected {
    passes: Vec<Pass>,
    uncertain: BTreeSet<ResourceHandle>,
    passthroughs: BTreeMap<ResourceHandle, Passthrough>,
    gaps: Vec<String>,
}

impl Connected {
    fn new(document: &Document, declared: Passes<'_>, toggles: &[Toggle], shared: &mut Shared) -> Self {
        let Passes { mut list, instances, absent, gaps, is_unreadable, waiting, passthroughs } = declared;
        after::connect(&waiting, &mut list, &instances, &absent, &gaps, shared);
        check_extension_points(document, &mut shared.diagnostics);
        settings::check_data(document, shared);
        let mut uncertain = uncertain(&gaps, &instances, is_unreadable, shared);
        connect(&list, &uncertain, shared);
        let mut passthroughs =
            passthroughs::connect(&passthroughs, &mut list, toggles, &mut uncertain, shared);
        name_last_writers(&mut list, &mut passthroughs, shared);
        check_versions(&list, &absent, &gaps, &mut uncertain, shared);
        let gaps = gaps.into_iter().map(|(name, _)| name).collect();
        Self { passes: list, uncertain, passthroughs, gaps }
    }
}
