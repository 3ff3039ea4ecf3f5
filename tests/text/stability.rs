//! Names of the root, of its public modules and of the prelude: what goes makes this file fail to compile.
//!
//! docs/stability.md says which names these are. Types, not their members: `cargo semver-checks` compares members.

/// Imports alone: a name that is used nowhere else is still a promise.
#[allow(unused_imports)]
mod names {
    use umbragraph::prelude::*;
    use umbragraph::{
        Bundled, DiskStorage, Error, Library, Options, PIPELINES, Pipeline, Plan, Setting, codes, data, diagnostic, draw,
        frame, glam, node, passes, registry, wgpu_types, with_templates, work,
    };

    #[cfg(feature = "gpu")]
    use umbragraph::executor::{
        FrameImports, Given, GpuTime, Import, ImportHandle, Importable, ParameterValue, PassCounts, PlanPreparer,
        PreparedPlan, Statistics, Texels, imported_texture, read_back, read_bytes,
    };
    #[cfg(feature = "gltf")]
    use umbragraph::scene;
    #[cfg(feature = "gpu")]
    use umbragraph::{Executor, Frame, Parameter, Renderer, wgpu};
    #[cfg(feature = "watch")]
    use umbragraph::{Reload, Watcher};

    use umbragraph::data::ValueType;
    use umbragraph::draw::{HostInterface, HostResource, HostVertexBuffer, PropertySet};
    use umbragraph::frame::{Bounds, Camera, FrameInput, Light, LightKind, Projection};
    use umbragraph::passes::words::{CAST_SHADOW, CONTACT_SHADOW, LightProperties, filters};
}

#[test]
fn a_format_of_the_future_is_an_error_with_both_numbers() {
    let text = r#"{ "format": 2, "name": "later" }"#;
    let outcome = crate::common::check(text);
    let shown = outcome.text();
    assert_eq!(outcome.diagnostics.iter().count(), 1, "{shown}");
    assert!(shown.contains('2') && shown.contains("format 1") && shown.contains("umbragraph"), "{shown}");
}
