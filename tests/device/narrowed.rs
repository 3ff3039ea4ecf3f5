//! Devices with less: what a pipeline draws on one it draws on another, or says why not.
//!
//! Each system is drawn on a device with all that the adapter has, and on devices of the same adapter that are
//! narrowed: to WebGPU's defaults, to compatibility mode, to smaller textures, to fewer storage buffers, without an
//! optional feature. The picture is the same to a level, or a feature of the pipeline is off by itself, or a diagnostic
//! says what is lacking.

use std::sync::Arc;

use crate::common::gpu::{Host, read, scene};
use crate::common::{Outcome, With, check_file, root};
use umbragraph::Frame;
use umbragraph::frame::FrameInput;
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;
use wgpu::{DownlevelFlags, Features, Limits};

/// A device with some limits, and the profile of its pipelines.
struct Narrow {
    name: &'static str,
    limits: Limits,
    flags: DownlevelFlags,
    features: Features,
}

fn narrowed(gpu: &Gpu) -> Vec<Narrow> {
    let compat = TargetProfile::webgpu_compat();
    let usual = Limits::defaults().or_worse_values_from(&gpu.adapter.limits());
    let features = gpu.adapter.features() & Features::all_webgpu_mask();
    let flags = DownlevelFlags::all();
    let with = |name, limits| Narrow { name, limits, flags, features };
    let without = |name, feature| Narrow { name, limits: usual.clone(), flags, features: features - feature };
    vec![
        with("WebGPU's defaults", usual.clone()),
        with("2048 texels", Limits { max_texture_dimension_2d: 2048, ..usual.clone() }),
        with("4 storage buffers", Limits { max_storage_buffers_per_shader_stage: 4, ..usual.clone() }),
        with("no storage buffers", Limits { max_storage_buffers_per_shader_stage: 0, ..usual.clone() }),
        Narrow {
            name: "compatibility mode",
            limits: usual.clone().or_worse_values_from(&compat.limits),
            flags: compat.downlevel,
            features: Features::empty(),
        },
        without("no timestamps", Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS),
        without("no float32-filterable", Features::FLOAT32_FILTERABLE),
        without("no bgra storage", Features::BGRA8UNORM_STORAGE),
    ]
}

/// Checks a pipeline for a device, with the optional features of the device that it can use.
fn check(pipeline: &str, Narrow { limits, flags, features, .. }: &Narrow) -> Outcome {
    let file = format!("pipelines/{pipeline}.json");
    let with = |profile| With { profile: Some(profile), size: Some([160, 90]), ..With::default() };
    let profile = TargetProfile::webgpu().on_device(limits, *flags);
    let usual = check_file(&file, &with(TargetProfile::webgpu()));
    let features = usual.plan().pipeline.device_features() & *features;
    check_file(&file, &with(if features.is_empty() { profile } else { profile.with_features(features) }))
}

fn features(outcome: &Outcome) -> Vec<(String, bool)> {
    let features = &outcome.plan().pipeline.features;
    features.iter().map(|(name, feature)| (name.clone(), feature.is_on())).collect()
}

/// The picture of a pipeline, or what is said where CPU passes want sizes that the device has not.
fn picture(gpu: &Gpu, outcome: &Outcome, scene: &Scene, input: &FrameInput) -> Result<Picture, String> {
    let mut host = Host::new(gpu, outcome, scene);
    for _ in 0..16 {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("target", &host.target)];
        let frame = Frame::new(input).draws(&host.scene).imports(&imports);
        host.executor.record(&mut encoder, &frame).map_err(|error| error.to_string())?;
        let Some(sizes) = host.executor.wanted_sizes() else {
            gpu.queue.submit([encoder.finish()]);
            return Ok(read(gpu, &host.target));
        };
        host.options.data_sizes = sizes;
        let plan = outcome.checked.plan_again(&host.options, &outcome.sources);
        let plan = plan.map_err(|diagnostics| format!("{diagnostics:?}"))?;
        host.executor.set_plan(Arc::new(plan)).map_err(|error| error.to_string())?;
    }
    Err("sizes that never settle".to_owned())
}

/// Draws a system on all devices; those that it is not drawn on.
fn not_drawn(pipeline: &str) -> Vec<&'static str> {
    let Some(gpu) = gpu::device() else { return Vec::new() };
    let scene = scene(&root().join("examples/scenes/interior.glb"));
    let input = scene.frame_input(160.0 / 90.0, 0.0);
    let all = Narrow {
        name: "all",
        limits: gpu.adapter.limits(),
        flags: DownlevelFlags::all(),
        features: gpu.adapter.features() & Features::all_webgpu_mask(),
    };
    let whole = check(pipeline, &all);
    let reference =
        picture(&gpu.with(all.limits.clone(), all.features), &whole, &scene, &input).expect("a picture");
    let mut not_drawn = Vec::new();
    for narrow in narrowed(&gpu) {
        let name = narrow.name;
        let outcome = check(pipeline, &narrow);
        if !outcome.codes().is_empty() {
            let text = outcome.text();
            assert!(text.contains("on this device"), "{pipeline}, {name}: {text}");
            not_drawn.push(name);
            continue;
        }
        match picture(&gpu.with(narrow.limits, narrow.features), &outcome, &scene, &input) {
            Ok(own) if features(&outcome) == features(&whole) => {
                assert_eq!(reference.differing(&own, 1), 0, "{pipeline}, {name}");
            }
            Ok(_) => {}
            Err(said) => {
                assert!(said.contains("on this device"), "{pipeline}, {name}: {said}");
                not_drawn.push(name);
            }
        }
    }
    not_drawn
}

macro_rules! narrow_devices_draw_the_same_or_say_why_not {
    ($($pipeline:ident: $not_drawn:expr;)*) => {$(
        #[test]
        fn $pipeline() {
            let not_drawn = not_drawn(stringify!($pipeline));
            assert!(gpu::device().is_none() || not_drawn == $not_drawn, "{not_drawn:?}");
        }
    )*};
}

// Atlases of several maps side by side, and those that grow with the lights of a frame, are wider than 2048.
narrow_devices_draw_the_same_or_say_why_not! {
    mantis: ["2048 texels"];
    nebula: [""; 0];
    caracal: [""; 0];
    lore: [""; 0];
    awsm: [""; 0];
    umbra: ["2048 texels"];
}
