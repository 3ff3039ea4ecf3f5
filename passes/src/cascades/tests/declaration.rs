//! The node kind as pipelines see it: settings, diagnostics, published values.

use std::sync::Arc;

use umbragraph_pipeline::data::BlackboardData;
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::pipeline::{LoadOptions, Overrides, TypedPipeline, load};
use umbragraph_pipeline::shader::{ShaderCache, TargetProfile, TemplateSet};
use umbragraph_pipeline::source::Sources;
use umbragraph_pipeline::work::{CpuContext, Work};
use umbragraph_pipeline::{document, node::Registry};

use super::*;
use crate::cascades::{Cascades, node};

fn declare(settings: &str, parameters: &str) -> (Option<TypedPipeline>, Diagnostics, Sources) {
    let settings = settings.replacen('{', r#"{ "to": "&sun_views", "#, 1);
    let text = format!(
        r#"{{ "format": 1, "name": "test", "parameters": {{ {parameters} }}, "passes": {{ "fit": {{ "cascades": {settings} }} }} }}"#
    );
    let mut sources = Sources::new();
    let file = sources.add("test.json", text);
    let document = document::parse(&sources, file).valid().expect("the test's own document is JSON");
    let mut registry = Registry::new();
    registry.register::<Cascades>();
    let mut diagnostics = Diagnostics::new();
    let templates = Arc::new(TemplateSet::new());
    let overrides = Overrides::default();
    let shaders = Arc::new(ShaderCache::new(&templates, &TargetProfile::webgpu()));
    let options = LoadOptions::new(&registry, &shaders, &overrides);
    let pipeline = load(&document, &options, &sources, &mut diagnostics);
    (pipeline, diagnostics, sources)
}

/// The blackboard data that a `cascades` pass with these settings publishes for a frame.
pub(super) fn run(settings: &str, frame: &FrameInput) -> BlackboardData {
    let (pipeline, diagnostics, _) = declare(settings, "");
    assert!(!diagnostics.has_errors(), "{diagnostics:?}");
    let pipeline = pipeline.expect("a pipeline without diagnostics is there");
    let Some(Work::Cpu(work)) = pipeline.passes.first().map(umbragraph_pipeline::pipeline::Pass::work) else {
        panic!("CPU work")
    };
    let mut data = BlackboardData::new(node::shape(declared(&pipeline)));
    work.node.start().run(&CpuContext { frame, viewport: [1, 1], inputs: &[] }, &mut data);
    assert_eq!(data.rejected(), None);
    data
}

fn declared(pipeline: &TypedPipeline) -> u32 {
    let umbragraph_pipeline::pipeline::ResourceKind::Data(Some(shape)) = &pipeline.resources[0].kind else {
        panic!("data")
    };
    let extent = shape.view_extent.expect("views of one map");
    assert_eq!(*shape, node::shape(shape.max_views).view_extent(extent));
    shape.max_views
}

fn floats(data: &BlackboardData, name: &str) -> Vec<f32> {
    data.words(name).unwrap().iter().map(|word| f32::from_bits(*word)).collect()
}

#[test]
fn a_camera_that_sees_nothing_leaves_the_light() {
    let mut frame = frame(identity_camera(), DVec3::NEG_Y);
    frame.camera.position.x = f64::NAN;
    let data = run(r#"{ "far": [10, 30, 80, 200], "resolution": 1024 }"#, &frame);
    assert_eq!(data.words("count"), Some([0].as_slice()));
    assert_eq!(floats(&data, "direction_to_light"), [0.0, 1.0, 0.0]);
    assert_eq!(floats(&data, "light_intensity"), [3.0]);
}

#[test]
fn the_shortest_settings_publish_views_and_values() {
    let frame = frame(identity_camera(), DVec3::NEG_Y);
    let data = run(r#"{ "far": [10, 30, 80, 200], "resolution": 1024 }"#, &frame);
    assert_eq!(data.views().len(), 4);
    assert_eq!(data.views().iter().map(|view| view.layer).collect::<Vec<_>>(), [0, 1, 2, 3]);
    assert!(data.views().iter().all(|view| view.viewport.is_none() && !view.reverse));
    assert_eq!(data.words("count"), Some([4].as_slice()));
    assert_eq!(floats(&data, "far"), [10.0, 30.0, 80.0, 200.0]);
    assert_eq!(floats(&data, "blend_start"), floats(&data, "far"));
    assert_eq!(floats(&data, "last_far"), [200.0]);
    assert_eq!(floats(&data, "near"), [0.1]);
    assert_eq!(floats(&data, "resolution"), [1024.0; 4]);
    assert_eq!(floats(&data, "map_size"), [1024.0; 2]);
    assert_eq!(floats(&data, "direction_to_light"), [0.0, 1.0, 0.0]);
    assert_eq!(floats(&data, "light_color"), (frame.lights[0].color * 3.0).to_array());
    assert_eq!(floats(&data, "light_intensity"), [3.0]);
    let texels = floats(&data, "texel_size");
    assert!(texels.windows(2).all(|pair| pair[0] < pair[1]), "{texels:?}");
    assert!(floats(&data, "depth_range").iter().all(|range| *range > 0.0));
}

#[test]
fn without_a_light_nothing_is_published_but_zeros() {
    let mut frame = frame(identity_camera(), DVec3::NEG_Y);
    frame.lights.clear();
    let data = run(r#"{ "far": [10, 30], "resolution": 1024 }"#, &frame);
    assert!(data.views().is_empty());
    for name in data.shape().values.iter().map(|value| &value.name) {
        if !["near", "map_size"].contains(&name.as_str()) {
            assert!(data.words(name).unwrap().iter().all(|word| *word == 0), "{name}");
        }
    }
}

#[test]
fn every_setting_can_be_said() {
    let frame = frame(identity_camera(), DVec3::NEG_Z);
    let data = run(
        r#"{ "light": "sun", "far": 200, "splits": { "scheme": "practical", "count": 3, "near": 0.1, "lambda": 0.7 },
             "resolution": [1024, 1024, 512], "tiles": [[0, 0], ["=512 * 2", 0], [2048, 0]], "map": [3072, 1024],
             "reverse": true, "fit": "tight", "snap": "projection", "square_texels": false, "border": 1, "up": [0, 0, 1],
             "near_pull": 100, "far_extension": 5, "clip_to_scene": true, "blend": { "fraction": 0.1, "of": "range" } }"#,
        &frame,
    );
    let far = floats(&data, "far");
    assert!((far[0] - 20.9).abs() < 0.05 && (far[1] - 51.1).abs() < 0.05 && far[2] == 200.0, "{far:?}");
    assert!((floats(&data, "blend_start")[1] - (far[1] - 0.1 * (far[1] - far[0]))).abs() < 1e-4);
    assert_eq!(data.views()[2].viewport, Some([2048, 0, 512, 512]));
    assert!(data.views().iter().all(|view| view.reverse && view.layer == 0));
    // The scene is 42 m high and 120 m long; the near plane stands 100 m off.
    assert!(floats(&data, "depth_range").iter().all(|range| (100.0..340.0).contains(range)));
}

#[test]
fn every_setting_changes_what_is_published() {
    let mut camera = identity_camera();
    camera.position = DVec3::new(1.3, 2.1, 0.7);
    camera.rotation = DQuat::from_rotation_y(0.4);
    let mut frame = frame(camera, DVec3::new(0.3, -0.8, 0.5));
    let mut moon = sun(DVec3::new(-0.4, -0.8, 0.1)).intensity(0.1);
    moon.name = "moon".into();
    frame.lights.push(moon);
    let published = |settings: &str| {
        let data = run(&format!(r#"{{ "far": [10, 90], "resolution": 256 {settings} }}"#), &frame);
        let words: Vec<u32> =
            (0..data.shape().values.len()).flat_map(|at| data.words_at(at).unwrap().to_vec()).collect();
        (words, data.views().to_vec())
    };
    let plain = published("");
    for settings in [
        r#""light": "moon""#,
        r#""splits": { "scheme": "uniform" }"#,
        r#""splits": { "count": 1 }"#,
        r#""tiles": [[0, 0], [256, 0]]"#,
        r#""tiles": [0, 0, 256, 0]"#,
        r#""map": [512, 256]"#,
        r#""reverse": true"#,
        r#""fit": "tight""#,
        r#""snap": "none""#,
        r#""snap": "projection""#,
        r#""fit": "tight", "square_texels": false"#,
        r#""border": 5"#,
        r#""up": [0, 0, 1]"#,
        r#""near_pull": 7"#,
        r#""far_extension": 11"#,
        r#""clip_to_scene": true"#,
        r#""blend": { "fraction": 0.2 }"#,
    ] {
        assert_ne!(published(&format!(", {settings}")), plain, "{settings}");
    }
    let tight = published(r#", "fit": "tight""#);
    assert_ne!(published(r#", "fit": "tight", "square_texels": false"#), tight);
    assert_ne!(published(r#", "fit": "tight", "snap": "origin""#), tight);
}

#[test]
fn schemes_and_counts_choose_the_far_distances() {
    let frame = frame(identity_camera(), DVec3::NEG_Y);
    let far = |splits: &str| {
        floats(
            &run(&format!(r#"{{ "far": [1, 10, 100], "resolution": 64, "splits": {splits} }}"#), &frame),
            "far",
        )
    };
    assert_eq!(far(r#"{ "count": 2 }"#), [1.0, 10.0]);
    assert_eq!(far(r#"{ "scheme": "explicit" }"#), [1.0, 10.0, 100.0]);
    assert_eq!(far(r#"{ "scheme": "uniform", "count": 2, "near": 2 }"#), [51.0, 100.0]);
    let logarithmic = far(r#"{ "scheme": "logarithmic", "count": 4, "near": 0.01 }"#);
    let wanted = [0.1, 1.0, 10.0, 100.0];
    assert!(
        logarithmic.iter().zip(wanted).all(|(found, wanted)| (found / wanted - 1.0).abs() < 1e-6),
        "{logarithmic:?}"
    );
    // Without a near distance, from the camera's near plane at 0.1 m; half of each formula without a lambda.
    let practical = far(r#"{ "scheme": "practical", "count": 3 }"#);
    assert!((practical[0] - 0.5 * (1.0 + 33.4)).abs() < 1e-4 && practical[2] == 100.0, "{practical:?}");
}

#[test]
fn near_pull_and_words_can_be_parameters() {
    let parameters = r#""pull": { "type": "enum", "values": ["casters", "sky"], "default": "casters" },
        "snap_to": { "type": "enum", "values": ["world", "none"], "default": "none" },
        "ends": { "type": "f32[]", "default": [5, 50] }"#;
    let settings = r#"{ "far": "=ends", "resolution": 64, "near_pull": "=pull", "snap": "=snap_to" }"#;
    let (pipeline, diagnostics, _) = declare(settings, parameters);
    assert!(pipeline.is_some() && diagnostics.is_empty(), "{diagnostics:?}");
    let (_, diagnostics, _) =
        declare(settings, &parameters.replace(r#""default": "casters""#, r#""default": "sky""#));
    assert_eq!(diagnostics.iter().map(|diagnostic| diagnostic.code.id).collect::<Vec<_>>(), ["UG0617"]);
}

#[test]
fn settings_that_make_no_sense_are_found_at_their_place() {
    for (settings, code, pointer, text) in [
        (r#"{ "far": [10, 5], "resolution": 64 }"#, "UG0610", "/far/1", "5"),
        (r#"{ "far": [0], "resolution": 64 }"#, "UG0610", "/far/0", "0"),
        (r#"{ "far": [100000000, 100000001], "resolution": 64 }"#, "UG0610", "/far/1", "100000001"),
        (r#"{ "far": "=1e300 * [1]", "resolution": 64 }"#, "UG0610", "/far", r#""=1e300 * [1]""#),
        (r#"{ "far": [1,2,3,4,5,6,7,8,9], "resolution": 64 }"#, "UG0611", "/far", "[1,2,3,4,5,6,7,8,9]"),
        (r#"{ "far": [], "resolution": 64 }"#, "UG0611", "/far", "[]"),
        (r#"{ "far": [9], "splits": { "count": 0 }, "resolution": 64 }"#, "UG0611", "/splits/count", "0"),
        (r#"{ "far": [9], "splits": { "count": 2 }, "resolution": 64 }"#, "UG0611", "/splits/count", "2"),
        (r#"{ "far": [9], "splits": { "near": 9 }, "resolution": 64 }"#, "UG0612", "/splits/near", "9"),
        (r#"{ "far": [9], "splits": { "near": 0 }, "resolution": 64 }"#, "UG0612", "/splits/near", "0"),
        (
            r#"{ "far": [9], "splits": { "lambda": 1.5 }, "resolution": 64 }"#,
            "UG0612",
            "/splits/lambda",
            "1.5",
        ),
        (r#"{ "far": [9], "resolution": 0 }"#, "UG0613", "/resolution", "0"),
        (r#"{ "far": [9], "resolution": 9, "border": 4 }"#, "UG0613", "/resolution", "9"),
        (r#"{ "far": [9, 10, 11], "resolution": [64, 64] }"#, "UG0613", "/resolution", "[64, 64]"),
        (r#"{ "far": [9, 10], "resolution": [64, 0.5] }"#, "UG0613", "/resolution/1", "0.5"),
        (r#"{ "far": [9, 10], "resolution": 64, "tiles": [[0, 0]] }"#, "UG0614", "/tiles", "[[0, 0]]"),
        (
            r#"{ "far": [9, 10], "resolution": 64, "tiles": [[0, 0], [64, -1]] }"#,
            "UG0614",
            "/tiles",
            "[[0, 0], [64, -1]]",
        ),
        (
            r#"{ "far": [9, 10], "resolution": 64, "tiles": [[0, 0], [63, 0]] }"#,
            "UG0614",
            "/tiles/1",
            "[63, 0]",
        ),
        (
            r#"{ "far": [9], "resolution": 64, "tiles": [[1, 0]], "map": [64, 64] }"#,
            "UG0614",
            "/tiles/0",
            "[1, 0]",
        ),
        (r#"{ "far": [9], "resolution": 64, "map": [32, 64] }"#, "UG0614", "/map", "[32, 64]"),
        (r#"{ "far": [9], "resolution": 64, "map": 64 }"#, "UG0614", "/map", "64"),
        (
            r#"{ "far": [9], "resolution": 64, "blend": { "fraction": -0.1 } }"#,
            "UG0615",
            "/blend/fraction",
            "-0.1",
        ),
        (r#"{ "far": [9], "resolution": 64, "up": [0, 0, 0] }"#, "UG0616", "/up", "[0, 0, 0]"),
        (r#"{ "far": [9], "resolution": 64, "up": [0, 1] }"#, "UG0616", "/up", "[0, 1]"),
        (r#"{ "far": [9], "resolution": 64, "near_pull": -1 }"#, "UG0617", "/near_pull", "-1"),
        (r#"{ "far": [9], "resolution": 64, "far_extension": -1 }"#, "UG0617", "/far_extension", "-1"),
        (r#"{ "far": [9], "resolution": 64, "snap": "wolrd" }"#, "UG0107", "/snap", r#""wolrd""#),
    ] {
        let (_, diagnostics, sources) = declare(settings, "");
        let found: Vec<_> = diagnostics
            .iter()
            .map(|diagnostic| {
                let umbragraph_pipeline::diagnostic::Place::Span(span) = diagnostic.place else {
                    panic!("a place in the text")
                };
                assert!(diagnostic.help.is_some(), "{settings}");
                (diagnostic.code.id, diagnostic.pointer.as_str(), sources.text(span))
            })
            .collect();
        let pointer = format!("/passes/fit/cascades{pointer}");
        assert_eq!(found, [(code, pointer.as_str(), text)], "{settings}");
    }
}

#[test]
fn all_diagnostics_come_at_once() {
    let settings = r#"{ "far": [10, 5], "resolution": 64, "up": [0, 0, 0], "near_pull": -1, "blend": { "fraction": 2 } }"#;
    let (_, diagnostics, _) = declare(settings, "");
    let mut codes: Vec<_> = diagnostics.iter().map(|diagnostic| diagnostic.code.id).collect();
    codes.sort_unstable();
    assert_eq!(codes, ["UG0610", "UG0615", "UG0616", "UG0617"]);
}

#[test]
fn every_code_of_the_cascades_has_a_page() {
    for code in crate::codes::ALL {
        assert!(code.id.starts_with("UG06") && !code.page.is_empty() && !code.title.is_empty());
    }
}
