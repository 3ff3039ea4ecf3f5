//! Names of the root, of its public modules and of the prelude: what goes makes this file fail to compile.
//!
//! docs/stability.md says which names these are. Types, not their members: `cargo semver-checks` compares members.

use umbragraph::diagnostic::{Diagnostics, render};
use umbragraph::low_level::compose::{Files as _, Memory, compose};
use umbragraph::low_level::document;
use umbragraph::low_level::pipeline::ParameterFile;
use umbragraph::low_level::source::Sources;

/// Imports alone: a name that is used nowhere else is still a promise.
#[allow(unused_imports)]
mod names {
    use umbragraph::prelude::*;
    use umbragraph::{
        Bundled, DiskStorage, Error, Library, Options, PIPELINES, Pipeline, Plan, Setting, codes, data,
        diagnostic, draw, frame, glam, node, passes, registry, wgpu_types, with_templates, work,
    };

    #[cfg(feature = "gpu")]
    use umbragraph::executor::{
        FrameImports, Given, GpuTime, Import, ImportHandle, Importable, ParameterValue, PassCounts,
        PlanPreparer, PreparedPlan, Statistics, Texels, imported_texture, read_back, read_bytes,
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
    use umbragraph::node::{Evaluate, Expr, LiveSettings, Node, PassBuilder, Produced, Ref};
    use umbragraph::passes::words::{CAST_SHADOW, CONTACT_SHADOW, LightProperties, filters};
}

#[test]
fn a_part_in_a_later_format_is_an_error_too() {
    let whole = r#"{ "format": 1, "name": "whole", "include": ["part.json"], "passes": {} }"#;
    for part in [r#"{ "format": 7, "parameters": {} }"#, r#"{ "format": 0 }"#] {
        let files = [("whole.json", whole), ("part.json", part)];
        let mut memory = Memory(files.map(|(name, text)| (name.to_owned(), text.to_owned())).into());
        let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
        let file = memory.read("whole.json".as_ref(), &mut sources).unwrap();
        assert!(compose(file, "whole.json".as_ref(), &mut memory, &mut sources, &mut diagnostics).is_none());
        let shown = render::human_all(&diagnostics, &sources);
        assert!(shown.contains("UG0110") && shown.contains("part.json:1:13"), "{shown}");
    }
}

#[test]
fn a_parameter_file_in_a_later_format_is_an_error() {
    let mut sources = Sources::new();
    let file = sources.add("values.json", r#"{ "format": 3, "preset": 7 }"#);
    let document = document::parse(&sources, file).valid().unwrap();
    let mut diagnostics = Diagnostics::new();
    _ = ParameterFile::read(&document, &mut diagnostics);
    let shown = render::human_all(&diagnostics, &sources);
    assert!(shown.contains("format 3") && shown.contains("1 error"), "{shown}");
}
