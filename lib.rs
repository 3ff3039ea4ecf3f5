//! A data-driven render-graph engine module for wgpu.
//!
//! A pipeline is a JSON file: named resources, and passes that say how they use them. This crate makes it a checked
//! [`Plan`] without a device, with every shader variant generated from a template and proven valid, and, with
//! the feature `gpu`, records it into the command encoder of an application of yours.
//!
//! ```
//! use umbragraph::{Library, Options};
//!
//! let text = r#"{
//!   "format": 1, "name": "smallest",
//!   "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
//!   "passes": { "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } } }
//! }"#;
//! let pipeline = Library::new().load_text("smallest.json", text)?;
//! let plan = pipeline.plan(&Options::new(640, 480))?;
//! assert_eq!(plan.passes[0].name, "fill");
//! # Ok::<(), umbragraph::Error>(())
//! ```
//!
//! [`Library`], [`Pipeline`], [`Options`], `Renderer`, `Executor` and `Frame` are the facade. Modules add to it:
//! [`draw`] and [`frame`] for a host's meshes, cameras and lights, [`node`] and [`work`] for node kinds of your own.
//! Every type has one path; the [`prelude`] repeats the common ones. [`low_level`] holds the interiors, and repeats
//! some of [`node`].
//!
//! Features: `gpu` (on by default) adds [`executor`] and re-exports wgpu; `gltf` (on by default) adds [`scene`];
//! `watch` adds `Watcher`, with which a pipeline follows its files; `environment` adds pictures of surroundings.
//! Without them nothing of wgpu-core is built.

#[path = "pipelines/bundled.rs"]
mod bundled;
mod front;

pub use bundled::{Bundled, PIPELINES};
pub use front::{DiskStorage, Library, Options, Pipeline, Setting, with_templates};
pub use umbragraph_graph::compiler::Plan;
pub use umbragraph_graph::{Error, data, diagnostic, draw, frame, glam, wgpu_types, work};
pub use umbragraph_passes as passes;
pub use umbragraph_passes::registry;
#[cfg(feature = "gltf")]
pub use umbragraph_scene as scene;

#[cfg(feature = "gpu")]
pub use front::Renderer;
#[cfg(feature = "watch")]
pub use front::{Reload, Watcher};
#[cfg(feature = "gpu")]
pub use umbragraph_graph::executor::{Executor, Frame, Parameter};
#[cfg(feature = "gpu")]
pub use umbragraph_graph::wgpu;

/// Node kinds of your own: the trait, the settings that a kind reads, and the pass that it declares.
pub mod node {
    pub use umbragraph_graph::language::{Expr, Ref};
    pub use umbragraph_graph::node::{Node, NodeKind, Registry, Settings};
    pub use umbragraph_graph::pipeline::{Evaluate, LiveSettings, PassBuilder, Produced};
}

/// Types used with an [`Executor`]: imports of a frame, texture read-backs, timings, and plans prepared on another
/// thread.
#[cfg(feature = "gpu")]
pub mod executor {
    #[cfg(feature = "noop")]
    pub use umbragraph_graph::executor::DryRun;
    pub use umbragraph_graph::executor::{
        FrameImports, Given, GpuTime, Import, ImportHandle, Importable, ParameterValue, PassCounts,
        PlanPreparer, PreparedPlan, Statistics, Texels, imported_buffer, imported_texture, read_back,
        read_buffer, read_bytes, read_sample,
    };
}

/// Internal APIs of the engine, for tools. **Unstable**: names here may change with any version.
///
/// ```text
///  text ──parse──▶ Document ──load──▶ TypedPipeline ──build──▶ Graph ──plan──▶ Plan
/// ```
///
/// Each arrow is one function: [`document::parse`](low_level::document::parse),
/// [`pipeline::load`](low_level::pipeline::load), [`compiler::build`](low_level::compiler::build),
/// [`compiler::plan`](low_level::compiler::plan). A [`Session`](low_level::session::Session) caches the result of each
/// step.
pub mod low_level {
    pub use umbragraph_graph::{
        CheckOptions, CheckReport, Coverage, Examination, Verify, capture, check, check_configurations,
        check_document, check_sharing, codes, compose, document, edit, expression, language, model, pipeline,
        read_source, report, shader, source, why,
    };
    pub use umbragraph_session as session;

    #[cfg(feature = "environment")]
    pub use crate::front::environment;
    #[cfg(all(feature = "environment", feature = "gltf"))]
    pub use crate::front::import;
    #[cfg(feature = "gpu")]
    pub use crate::front::{adapter, buffers, sheet};
    pub use crate::front::{camera_path, files, picture, starter};

    /// Compiles a typed pipeline to a plan: render graph, pass order, and memory of resources.
    pub mod compiler {
        pub use umbragraph_graph::compiler::{
            Assembly, AssemblyPass, CpuPasses, CullReason, Edge, Graph, GraphNode, Hazard, ImportDescriptor,
            InitialValue, KeepReason, Kept, MemoryOrder, Objective, OrderMethod, OrderReport, PackedBlock,
            Parameters, Physical, PhysicalBuffer, PhysicalTexture, PlanOptions, PlannedAttachment,
            PlannedCopy, PlannedHistory, PlannedParameter, PlannedPass, PlannedResource, PlannedSetting,
            ReaderName, StoreOperation, Switches, TakeOver, TexelOrigin, TexelRows, TextureSize, build, plan,
            set_aside, surviving_writers,
        };
    }
}

/// Names that most applications use: library and pipeline, frames and lights, draw sources, and the names of mesh
/// properties and filters.
///
/// ```
/// use umbragraph::prelude::*;
///
/// let sun = Light::directional("sun", [-0.8, -0.7, -0.35], [1.0, 0.9, 0.8], 4.0).casts_shadow();
/// let camera = Camera::look_at([0.0, 2.0, 5.0], [0.0; 3], 0.8, 16.0 / 9.0);
/// let input = FrameInput::new(camera).lights(vec![sun]).scene_bounds(Bounds::between([-9.0; 3], [9.0; 3]));
/// assert!(input.lights[0].has(CAST_SHADOW));
/// ```
pub mod prelude {
    pub use crate::data::ValueType;
    pub use crate::draw::{HostInterface, HostResource, HostVertexBuffer, PropertySet};
    pub use crate::frame::{Bounds, Camera, FrameInput, Light, LightKind, Projection};
    pub use crate::passes::words::{CAST_SHADOW, CONTACT_SHADOW, LightProperties, filters};
    pub use crate::{Error, Library, Options, Pipeline, Plan};

    #[cfg(feature = "gpu")]
    pub use crate::{
        Executor, Frame, Renderer,
        draw::{DrawPass, DrawSource},
        executor::{Import, Texels},
    };
}

use std::sync::Arc;

use crate::diagnostic::{Code, Diagnostics};
use crate::low_level::shader::{self, TemplateSet};
use crate::low_level::source::Sources;

/// Returns the shader templates that come with this crate, and registers their sources under `shaders-templates/`.
pub fn templates(sources: &mut Sources, diagnostics: &mut Diagnostics) -> Arc<TemplateSet> {
    let mut set = TemplateSet::new();
    for (name, text) in umbragraph_shaders_templates::FILES {
        let file = sources.add(format!("shaders-templates/{name}"), *text);
        set.add_library_file(sources, file, name, diagnostics);
    }
    set.check(diagnostics);
    Arc::new(set)
}

/// Returns every code that a diagnostic of this crate can have, sorted by id.
pub fn codes() -> Vec<Code> {
    let mut codes = diagnostic::codes::ALL.to_vec();
    codes.extend_from_slice(shader::codes::ALL);
    codes.extend_from_slice(passes::CODES);
    codes.extend_from_slice(front::codes::ALL);
    #[cfg(feature = "gltf")]
    codes.extend_from_slice(scene::codes::ALL);
    codes.sort_unstable();
    codes
}

/// The Rust examples of the guide and of the README, compiled as doc tests.
#[cfg(all(doctest, feature = "gpu"))]
mod guide {
    #[doc = include_str!("docs/guide/5-own-node-kind.md")]
    mod own_node_kind {}

    #[doc = include_str!("docs/guide/7-embedding.md")]
    mod embedding {}

    #[doc = include_str!("README.md")]
    mod readme {}
}
