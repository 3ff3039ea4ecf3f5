//! A data-driven render-graph engine module for wgpu.
//!
//! A pipeline is a JSON file: named resources, and passes that say how they use them. This crate makes it a checked
//! [`compiler::Plan`] without a device, with every shader variant generated from a template and proven valid, and, with
//! the feature `gpu`, records it into the command encoder of an application of yours.
//!
//! ```
//! use umbragraph::compiler::PlanOptions;
//! use umbragraph::diagnostic::{Diagnostics, render};
//! use umbragraph::pipeline::Overrides;
//! use umbragraph::shader::TargetProfile;
//! use umbragraph::source::Sources;
//!
//! let text = r#"{
//!   "format": 1, "name": "smallest",
//!   "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "viewport", "lifetime": "imported" } } },
//!   "passes": { "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "target" }] } } }
//! }"#;
//! let mut sources = Sources::new();
//! let mut diagnostics = Diagnostics::new();
//! let templates = umbragraph::templates(&mut sources, &mut diagnostics);
//! let file = sources.add("smallest.json", text);
//! let options = umbragraph::CheckOptions {
//!     registry: &umbragraph::registry(),
//!     templates: &templates,
//!     profile: &TargetProfile::webgpu(),
//!     overrides: &Overrides::default(),
//!     plan: &PlanOptions::new(640, 480),
//! };
//! let checked = umbragraph::check(file, &options, &sources, &mut diagnostics);
//! assert!(diagnostics.is_empty(), "{}", render::human_all(&diagnostics, &sources));
//! assert_eq!(checked.plan.unwrap().passes[0].name, "fill");
//! ```
//!
//! Features: `gpu` (on by default) adds [`executor`] and re-exports wgpu; `gltf` (on by default) adds [`scene`].
//! Without them nothing of wgpu-core is built.

#[path = "pipelines/bundled.rs"]
mod bundled;

pub use bundled::{Bundled, PIPELINES};
pub use umbragraph_graph::*;
pub use umbragraph_passes as passes;
pub use umbragraph_passes::registry;
#[cfg(feature = "gltf")]
pub use umbragraph_scene as scene;

use std::path::Path;
use std::sync::Arc;

use crate::diagnostic::{Code, Diagnostics};
use crate::shader::TemplateSet;
use crate::source::Sources;

/// The templates that come with this crate, registered under `shaders-templates/`.
pub fn templates(sources: &mut Sources, diagnostics: &mut Diagnostics) -> Arc<TemplateSet> {
    templates_with(&[], &mut compose::Memory::default(), sources, diagnostics)
}

/// The templates that come with this crate together with files of your own, each with its name and the path by which
/// `reader` reads it; one of the same name replaces the embedded one.
pub fn templates_with(
    files: &[(String, std::path::PathBuf)],
    reader: &mut dyn compose::Files,
    sources: &mut Sources,
    diagnostics: &mut Diagnostics,
) -> Arc<TemplateSet> {
    let mut set = TemplateSet::new();
    for (name, path) in files {
        match reader.read(path, sources) {
            Ok(file) => set.add_file(sources, file, name, diagnostics),
            Err(diagnostic) => set.add_unreadable(sources, name, diagnostic, diagnostics),
        }
    }
    for (name, text) in umbragraph_shaders_templates::FILES
        .iter()
        .filter(|(name, _)| files.iter().all(|(own, _)| own != name))
    {
        let file = sources.add(format!("shaders-templates/{name}"), *text);
        set.add_file(sources, file, name, diagnostics);
    }
    set.check(diagnostics);
    Arc::new(set)
}

/// Takes a pipeline file, with the files that it extends, includes and uses, all the way to a plan. Every diagnostic
/// goes to `diagnostics`. What it names lies below the working folder or its own, or comes with this crate
/// (`umbragraph:nebula.json`); further folders, or files that are not on a disk: [`compose::compose`], then
/// [`check_document`].
pub fn check_path(
    path: &Path,
    options: &CheckOptions<'_>,
    sources: &mut Sources,
    diagnostics: &mut Diagnostics,
) -> CheckReport {
    let file = match compose::read_source(path, sources) {
        Ok(file) => file,
        Err(diagnostic) => {
            diagnostics.push(diagnostic);
            return CheckReport::default();
        }
    };
    let mut files = Bundled(compose::Disk(compose::Roots::of(path)));
    compose::compose(file, path, &mut files, sources, diagnostics)
        .map(|composed| check_document(&composed.document, options, sources, diagnostics))
        .unwrap_or_default()
}

/// Every code that a diagnostic of this crate can have, by its id.
pub fn codes() -> Vec<Code> {
    let mut codes = diagnostic::codes::ALL.to_vec();
    codes.extend_from_slice(shader::codes::ALL);
    codes.extend_from_slice(passes::CODES);
    #[cfg(feature = "gltf")]
    codes.extend_from_slice(scene::codes::ALL);
    codes.sort_unstable();
    codes
}

/// The Rust of the guide.
#[cfg(all(doctest, feature = "gpu"))]
mod guide {
    #[doc = include_str!("docs/guide/5-own-node-kind.md")]
    mod own_node_kind {}

    #[doc = include_str!("docs/guide/7-embedding.md")]
    mod embedding {}
}
