//! The executor: what it records, what it creates, and what it rejects.

use crate::common::gpu::{empty_frame, executor, import, picture, read, render, scene};
use crate::common::{With, check_file, check_with, root};
use umbragraph::scene::gpu::SceneResources;
use umbragraph::{Executor, Frame};
use umbragraph_test_support::gpu;
use umbragraph_test_support::random::Random;

const FILL: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Settings { color: vec4<f32> }
@group(1) @binding(0) var<uniform> settings: Settings;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return settings.color; }
"#;

const CLOCK: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Eye { time: f32 }
@group(0) @binding(0) var<uniform> eye: Eye;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(eye.time, 0.0, 0.0, 1.0); }
"#;

const REACH: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Sun { count: u32, far: array<f32> }
@group(0) @binding(0) var<storage, read> sun: Sun;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(sun.far[2] / 100.0, f32(arrayLength(&sun.far)) / 255.0, 0.0, 1.0); }
"#;

const DOUBLE: &str = "@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var result: texture_storage_2d<rgba8unorm, write>;
@compute @workgroup_size(8, 8) fn double(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id.xy < textureDimensions(result)) { textureStore(result, id.xy, 2.0 * textureLoad(source, id.xy, 0)); }
}
";

const TARGET: &str =
    r#""target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }"#;

fn fill(name: &str, to: &str, color: &str, more: &str) -> String {
    format!(
        r#""{name}": {{ "fullscreen": {{ "shader": "fill.wgsl.jinja", "bind": {{ "settings": {{ "values": {{ "color": {color} }} }} }},
            "color": [{{ "to": "&{to}" {more} }}] }} }}"#
    )
}

fn templates() -> Vec<(&'static str, &'static str)> {
    vec![
        ("fill.wgsl.jinja", FILL),
        ("clock.wgsl.jinja", CLOCK),
        ("double.wgsl.jinja", DOUBLE),
        ("reach.wgsl.jinja", REACH),
    ]
}

#[track_caller]
fn outcome(resources: &str, passes: &[String], without_aliasing: bool) -> crate::common::Outcome {
    let text = format!(
        r#"{{ "format": 1, "name": "test", "resources": {{ {resources} {TARGET} }}, "passes": {{ {} }} }}"#,
        passes.join(",")
    );
    let own = templates();
    let with = With { templates: &own, size: Some([20, 12]), without_aliasing, ..With::default() };
    check_with("test.json", &text, &with)
}

#[test]
fn a_full_screen_pass_writes_every_texel_with_its_values() {
    let Some(gpu) = gpu::device() else { return };
    let picture = picture(&gpu, &outcome("", &[fill("one", "target", "[1, 0.2, 0.4, 1]", "")], false));
    assert!(picture.rgba_pixels().all(|pixel| pixel == [255, 51, 102, 255]));
}

#[test]
fn a_compute_pass_reads_and_writes_its_shader_s_textures() {
    let Some(gpu) = gpu::device() else { return };
    let texture = r#"{ "texture": { "format": "rgba8unorm", "size": "=viewport" } }"#;
    let passes = [
        fill("one", "a", "[0.1, 0.2, 0.3, 0.5]", ""),
        r#""twice": { "compute": { "shader": "double.wgsl.jinja", "bind": { "source": "&a", "result": "&b" }, "dispatch_over": "&b" } }"#.to_owned(),
        r#""show": { "fullscreen": { "shader": "tonemap.wgsl.jinja", "axes": { "debug_view": "shadow_term" },
            "bind": { "source": "&b" }, "color": [{ "to": "&target" }] } }"#
            .to_owned(),
    ];
    let picture = picture(&gpu, &outcome(&format!("\"a\": {texture}, \"b\": {texture},"), &passes, false));
    for pixel in picture.rgba_pixels() {
        for (value, wanted) in pixel.into_iter().zip([52, 102, 152, 255]) {
            assert!(value.abs_diff(wanted) <= 2, "{pixel:?}");
        }
    }
}

#[test]
fn a_cleared_attachment_is_blended_onto() {
    let Some(gpu) = gpu::device() else { return };
    let passes = [fill("one", "target", "[0.2, 0.2, 0, 1]", r#", "clear": [0, 0.2, 0, 0], "blend": "add""#)];
    let picture = picture(&gpu, &outcome("", &passes, false));
    assert!(picture.rgba_pixels().all(|pixel| pixel == [51, 102, 0, 255]));
}

#[test]
fn a_copy_copies() {
    let Some(gpu) = gpu::device() else { return };
    let texture = r#"{ "texture": { "format": "rgba8unorm", "size": "=viewport" } }"#;
    let passes = [
        fill("one", "a", "[0, 1, 0, 1]", ""),
        r#""two": { "copy": { "from": { "name": "&a" }, "to": { "name": "&target" } } }"#.to_owned(),
    ];
    let picture = picture(&gpu, &outcome(&format!("\"a\": {texture},"), &passes, false));
    assert!(picture.rgba_pixels().all(|pixel| pixel == [0, 255, 0, 255]));
}

#[test]
fn records_of_one_submission_do_not_disturb_one_another() {
    let Some(gpu) = gpu::device() else { return };
    let passes = [
        r#""eye": { "camera": { "to": "&eye" } }"#.to_owned(),
        r#""show": { "fullscreen": { "shader": "clock.wgsl.jinja", "bind": { "eye": "&eye" }, "color": [{ "to": "&target" }] } }"#.to_owned(),
    ];
    let outcome = outcome("", &passes, false);
    let plan = outcome.plan();
    let mut executor = executor(&gpu, plan, None);
    let targets = [import(&gpu, plan, "target"), import(&gpu, plan, "target")];
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    for (target, time) in targets.iter().zip([0.2, 0.6]) {
        let mut input = empty_frame();
        input.time = time;
        executor.record(&mut encoder, &Frame::new(&input).imports(&[("target", target)])).unwrap();
    }
    gpu.queue.submit([encoder.finish()]);
    let red = |texture| read(&gpu, texture).rgba_pixels().next().unwrap()[0];
    assert_eq!((red(&targets[0]), red(&targets[1])), (51, 153));
}

#[test]
fn an_array_without_a_count_is_as_long_as_what_is_published() {
    let Some(gpu) = gpu::device() else { return };
    let passes = [
        r#""fit": { "cascades": { "to": "&sun", "far": [10, 20, 40, 80], "resolution": 64 } }"#.to_owned(),
        r#""show": { "fullscreen": { "shader": "reach.wgsl.jinja", "bind": { "sun": "&sun" }, "color": [{ "to": "&target" }] } }"#.to_owned(),
    ];
    let outcome = outcome("", &passes, false);
    let mut input = empty_frame();
    input.lights.push(
        umbragraph::frame::Light::new("sun", umbragraph::frame::LightKind::Directional)
            .property("cast_shadow"),
    );
    let target = import(&gpu, outcome.plan(), "target");
    let mut executor = executor(&gpu, outcome.plan(), None);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    executor.record(&mut encoder, &Frame::new(&input).imports(&[("target", &target)])).unwrap();
    gpu.queue.submit([encoder.finish()]);
    assert_eq!(read(&gpu, &target).rgba_pixels().next(), Some([102, 4, 0, 255]));
}

#[test]
fn a_steady_frame_creates_nothing() {
    let Some(gpu) = gpu::device() else { return };
    let outcome = check_file("pipelines/nebula.json", &With { size: Some([64, 64]), ..With::default() });
    let scene = scene(&root().join("examples/scenes/courtyard.glb"));
    let resources = SceneResources::new(&gpu.device, &gpu.queue, &scene, &scene.pose(0.0)).unwrap();
    let target = import(&gpu, outcome.plan(), "target");
    let mut executor = executor(&gpu, outcome.plan(), Some(&resources));
    let input = scene.frame_input(1.0, 0.0);
    let mut after = Vec::new();
    for _ in 0..4 {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor
            .record(&mut encoder, &Frame::new(&input).draws(&resources).imports(&[("target", &target)]))
            .unwrap();
        gpu.queue.submit([encoder.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        after.push(executor.statistics());
    }
    assert_eq!(after[0], after[3]);
    assert!(after[0].pipelines > 0 && after[0].bind_groups > 0);
}

#[test]
fn a_pass_samples_this_frame_s_host_texture() {
    let Some(gpu) = gpu::device() else { return };
    let resources =
        r#""given": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } },"#;
    let passes = [
        r#""show": { "fullscreen": { "shader": "tonemap.wgsl.jinja", "axes": { "debug_view": "shadow_term" },
        "bind": { "source": "&given" }, "color": [{ "to": "&target" }] } }"#
            .to_owned(),
    ];
    let outcome = outcome(resources, &passes, false);
    let target = import(&gpu, outcome.plan(), "target");
    let given = [import(&gpu, outcome.plan(), "given"), import(&gpu, outcome.plan(), "given")];
    for (texture, value) in given.iter().zip([40u8, 200]) {
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(20 * 4), rows_per_image: None };
        gpu.queue.write_texture(texture.as_image_copy(), &vec![value; 20 * 12 * 4], layout, texture.size());
    }
    let mut executor = executor(&gpu, outcome.plan(), None);
    let mut seen = Vec::new();
    for at in [0, 1, 0, 1] {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("target", &target), ("given", &given[at])];
        executor.record(&mut encoder, &Frame::new(&empty_frame()).imports(&imports)).unwrap();
        gpu.queue.submit([encoder.finish()]);
        seen.push(read(&gpu, &target).rgba_pixels().next().unwrap()[0]);
    }
    assert_eq!(seen, [40, 200, 40, 200]);
}

#[test]
fn what_a_device_would_reject_is_found_in_the_plan() {
    let texture =
        |more: &str| format!(r#"{{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" {more} }} }}"#);
    let copy = |from: &str| {
        format!(
            r#""copy": {{ "copy": {{ "from": {{ "name": "&{from}" }}, "to": {{ "name": "&target" }} }} }}"#
        )
    };
    let cases = [
        (texture(r#", "layers": 2"#), vec![fill("one", "a", "[0, 0, 0, 0]", ""), copy("a")]),
        (
            texture("").replace("\"=viewport\"", "[40, 40]"),
            vec![fill("one", "a", "[0, 0, 0, 0]", ""), copy("a")],
        ),
        (
            texture("").replace("rgba8unorm", "rgba16float"),
            vec![fill("one", "a", "[0, 0, 0, 0]", ""), copy("a")],
        ),
    ];
    for (a, passes) in cases {
        let outcome = outcome(&format!("\"a\": {a},"), &passes, false);
        assert!(
            !outcome.codes().is_empty() && outcome.codes().iter().all(|code| *code == "UG0409"),
            "{}",
            outcome.text()
        );
    }
}

#[test]
fn an_encoder_that_is_dropped_gives_its_buffers_back() {
    let Some(gpu) = gpu::device() else { return };
    let outcome = outcome("", &[fill("one", "target", "[1, 1, 1, 1]", "")], false);
    let target = import(&gpu, outcome.plan(), "target");
    let mut executor = executor(&gpu, outcome.plan(), None);
    for _ in 0..8 {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor.record(&mut encoder, &Frame::new(&empty_frame()).imports(&[("target", &target)])).unwrap();
    }
    assert_eq!(executor.statistics().buffers, 1);
}

#[test]
fn sharing_memory_changes_no_picture() {
    let Some(gpu) = gpu::device() else { return };
    let texture = r#"{ "texture": { "format": "rgba8unorm", "size": "=viewport" } }"#;
    let show = |name: &str, from: &str, to: &str, more: &str| {
        format!(
            r#""{name}": {{ "fullscreen": {{ "shader": "tonemap.wgsl.jinja", "axes": {{ "debug_view": "shadow_term" }},
                "bind": {{ "source": "&{from}" }}, "color": [{{ "to": "&{to}" {more} }}] }} }}"#
        )
    };
    let passes = [
        fill("one", "a", "[0.1, 0.3, 0.5, 1]", ""),
        show("two", "a", "b", ""),
        show("three", "b", "c", ""),
        fill("four", "c@three", "[0.2, 0, 0, 0]", r#", "blend": "add""#),
        show("five", "c", "target", ""),
    ];
    let resources = format!("\"a\": {texture}, \"b\": {texture}, \"c\": {texture},");
    let (shared, alone) = (outcome(&resources, &passes, false), outcome(&resources, &passes, true));
    assert!(shared.plan().textures.len() < alone.plan().textures.len());
    assert_eq!(picture(&gpu, &shared).bytes(), picture(&gpu, &alone).bytes());
}

/// Passes that fill new textures, copy and double older ones, and add to them, and a picture that is the sum of some.
fn random_passes(seed: u64) -> (String, Vec<String>) {
    let mut random = Random(seed);
    let mut next = move |end: usize| random.below(end);
    let show = |name: &str, from: &str, to: &str, more: &str| {
        format!(
            r#""{name}": {{ "fullscreen": {{ "shader": "tonemap.wgsl.jinja", "axes": {{ "debug_view": "shadow_term" }},
                "bind": {{ "source": "&{from}" }}, "color": [{{ "to": "&{to}" {more} }}] }} }}"#
        )
    };
    let mut passes = Vec::new();
    // The passes that wrote each texture last.
    let mut writers: Vec<String> = Vec::new();
    for at in 0..10 + next(10) {
        let name = format!("p{at}");
        let (new, old) = (format!("t{}", writers.len()), writers.len().saturating_sub(1 + next(2)));
        let color = format!("[0.0{}, 0.0{}, 0.0{}, 0.1]", next(10), next(10), next(10));
        match next(4) {
            1 if !writers.is_empty() => passes.push(show(&name, &format!("t{old}"), &new, "")),
            2 if !writers.is_empty() => passes.push(format!(
                r#""{name}": {{ "compute": {{ "shader": "double.wgsl.jinja", "bind": {{ "source": "&t{old}", "result": "&{new}" }}, "dispatch_over": "&{new}" }} }}"#
            )),
            3 if !writers.is_empty() => {
                passes.push(fill(&name, &format!("t{old}@{}", writers[old]), &color, r#", "blend": "add""#));
                writers[old] = name;
                continue;
            }
            _ => passes.push(fill(&name, &new, &color, "")),
        }
        writers.push(name);
    }
    let mut target = "target".to_owned();
    for at in (0..writers.len()).filter(|at| *at == 0 || next(4) == 0).collect::<Vec<_>>() {
        let (name, more) = (format!("show{at}"), if at == 0 { "" } else { r#", "blend": "add""# });
        passes.push(show(&name, &format!("t{at}"), &target, more));
        target = format!("target@{name}");
    }
    let texture = r#"{ "texture": { "format": "rgba8unorm", "size": "=viewport" } }"#;
    ((0..writers.len()).map(|at| format!("\"t{at}\": {texture}, ")).collect(), passes)
}

#[test]
fn sharing_memory_changes_no_random_picture() {
    let Some(gpu) = gpu::device() else { return };
    let (mut shared_textures, mut pictures) = (0, std::collections::BTreeSet::new());
    for seed in 1..=24 {
        let (resources, passes) = random_passes(seed);
        let (shared, alone) = (outcome(&resources, &passes, false), outcome(&resources, &passes, true));
        shared_textures += alone.plan().textures.len() - shared.plan().textures.len();
        let (one, other) = (picture(&gpu, &shared), picture(&gpu, &alone));
        assert_eq!(one.bytes(), other.bytes(), "seed {seed}: {passes:#?}");
        pictures.insert(one.bytes().to_vec());
    }
    assert!(shared_textures >= 12 && pictures.len() > 12, "{shared_textures} {}", pictures.len());
}

#[test]
fn bad_imports_are_rejected_and_the_next_frame_is_fine() {
    let Some(gpu) = gpu::device() else { return };
    let outcome = outcome("", &[fill("one", "target", "[1, 1, 1, 1]", "")], false);
    let mut executor = executor(&gpu, outcome.plan(), None);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let input = empty_frame();
    let mut record = |imports: &[(&str, &wgpu::Texture)]| {
        let result = executor.record(&mut encoder, &Frame::new(&input).imports(imports));
        result.err().map(|diagnostics| {
            diagnostics
                .iter()
                .map(|diagnostic| (diagnostic.code.id, diagnostic.message.clone()))
                .collect::<Vec<_>>()
        })
    };
    assert_eq!(record(&[]), Some(vec![("UG0802", "the host gave no texture for \"target\"".to_owned())]));
    let other = check_file("pipelines/nebula.json", &With { size: Some([64, 64]), ..With::default() });
    let wrong = import(&gpu, other.plan(), "target");
    assert!(
        record(&[("target", &wrong)]).unwrap()[0].1.starts_with("the texture for \"target\" is 64 by 64")
    );
    let right = import(&gpu, outcome.plan(), "target");
    assert_eq!(record(&[("target", &right)]), None);
}

#[test]
fn imports_of_other_resources_are_rejected_unused_ones_not() {
    let Some(gpu) = gpu::device() else { return };
    let texture = r#""texture": { "format": "rgba8unorm", "size": "=viewport""#;
    let resources =
        format!(r#""inner": {{ {texture} }} }}, "spare": {{ {texture}, "lifetime": "imported" }} }},"#);
    let passes = [
        fill("one", "inner", "[1, 1, 1, 1]", ""),
        r#""two": { "copy": { "from": { "name": "&inner" }, "to": { "name": "&target" } } }"#.to_owned(),
    ];
    let outcome = outcome(&resources, &passes, false);
    let mut executor = executor(&gpu, outcome.plan(), None);
    let (input, target) = (empty_frame(), import(&gpu, outcome.plan(), "target"));
    let mut record = |name: &str| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("target", &target), (name, &target)];
        let recorded = executor.record(&mut encoder, &Frame::new(&input).imports(&imports));
        recorded.err().map(|error| error.to_string())
    };
    assert_eq!(record("spare"), None);
    for (name, way_out) in [("inner", "it imports target"), ("targets", "did you mean \"target\"?")] {
        let said = record(name).expect("a diagnostic");
        let reason = format!("a texture for \"{name}\", which is none of its own in this pipeline");
        assert!(said.contains("UG0802") && said.contains(&reason) && said.contains(way_out), "{said}");
    }
}

#[test]
fn an_import_has_at_least_the_mips_that_are_planned() {
    let Some(gpu) = gpu::device() else { return };
    let texture = |mips: u32| {
        let size = r#""format": "rgba8unorm", "size": "=viewport""#;
        let chain =
            format!(r#""chain": {{ "texture": {{ {size}, "mips": {mips}, "lifetime": "imported" }} }},"#);
        let fills = [fill("one", "chain", "[1, 1, 1, 1]", ""), fill("two", "target", "[1, 1, 1, 1]", "")];
        outcome(&chain, &fills, false)
    };
    let planned = texture(2);
    let mut executor = executor(&gpu, planned.plan(), None);
    let (input, target) = (empty_frame(), import(&gpu, planned.plan(), "target"));
    let mut record = |mips: u32| {
        let chain = import(&gpu, texture(mips).plan(), "chain");
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("target", &target), ("chain", &chain)];
        let recorded = executor.record(&mut encoder, &Frame::new(&input).imports(&imports));
        recorded.err().map(|error| error.to_string())
    };
    let said = record(1).expect("a diagnostic");
    assert!(said.contains("has 1 mips and 1 samples; the plan needs 2 and 1"), "{said}");
    assert_eq!([2, 3].map(record), [None, None]);
}

#[test]
fn a_pipeline_that_draws_meshes_wants_a_source_of_them() {
    let Some(gpu) = gpu::device() else { return };
    let outcome = check_file("pipelines/nebula.json", &With::default());
    let plan = std::sync::Arc::new(outcome.plan().clone());
    let result = umbragraph::Executor::new(&gpu.device, &gpu.queue, plan, None);
    let diagnostics = result.err().expect("a rejection");
    assert!(diagnostics.iter().all(|diagnostic| diagnostic.code.id == "UG0608"), "{diagnostics:?}");
}

#[test]
fn the_picture_does_not_depend_on_the_run() {
    let Some(gpu) = gpu::device() else { return };
    let outcome = check_file("pipelines/nebula.json", &With { size: Some([96, 64]), ..With::default() });
    let scene = scene(&root().join("examples/scenes/courtyard.glb"));
    assert_eq!(render(&gpu, &outcome, &scene).bytes(), render(&gpu, &outcome, &scene).bytes());
}

/// A buffer of the host's: missing, too small, of another usage and of no import it is an error value, and the next
/// frame is possible; another one takes its place.
#[test]
fn a_buffer_of_the_hosts_is_read_by_passes() {
    let Some(gpu) = gpu::device() else { return };
    let text = r#"{
        "format": 1, "name": "own buffer",
        "resources": {
            "colors": { "buffer": { "size": 16, "lifetime": "imported" } },
            "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
        },
        "passes": { "fill": { "fullscreen": {
            "shader": "colors.wgsl.jinja", "bind": { "colors": "&colors" }, "color": [{ "to": "&target" }]
        } } }
    }"#;
    let shader = "{% include 'lib/fullscreen.wgsl.jinja' %}
@group(1) @binding(0) var<storage, read> colors: array<f32, 4>;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> {
    return vec4<f32>(colors[0], colors[1], colors[2], colors[3]);
}
";
    let with = With { templates: &[("colors.wgsl.jinja", shader)], size: Some([4, 4]), ..With::default() };
    let outcome = crate::common::check_with("own_buffer.json", text, &with);
    let plan = outcome.plan();
    let mut executor = crate::common::gpu::executor(&gpu, plan, None);
    let target = crate::common::gpu::import(&gpu, plan, "target");
    let input = crate::common::gpu::empty_frame();
    let record = |executor: &mut Executor| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let result = executor
            .record(&mut encoder, &Frame::new(&input).imports(&[("target", &target)]))
            .map_err(|error| error.to_string());
        gpu.queue.submit([encoder.finish()]);
        result.map(|()| crate::common::gpu::read(&gpu, &target).bytes()[..4].to_vec())
    };
    let buffer = |colors: &[f32], usage| {
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("colors"),
            size: 4 * colors.len() as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bytes: Vec<u8> = colors.iter().flat_map(|number| number.to_le_bytes()).collect();
        gpu.queue.write_buffer(&buffer, 0, &bytes);
        buffer
    };
    let rejected = record(&mut executor).unwrap_err();
    assert!(
        rejected.contains("no buffer for \"colors\"") && rejected.contains("own_buffer.json:"),
        "{rejected}"
    );
    let storage = wgpu::BufferUsages::STORAGE;
    for (name, colors, usage, why) in [
        ("colors", &[1.0; 3][..], storage, "12 bytes; the plan needs 16"),
        ("colors", &[1.0; 4], wgpu::BufferUsages::VERTEX, "without the usage"),
        ("target", &[1.0; 4], storage, "imports no buffer"),
        ("others", &[1.0; 4], storage, "imports no buffer"),
    ] {
        let import = executor.import::<wgpu::Buffer>(name);
        let given = import.and_then(|import| executor.give(import, &buffer(colors, usage)));
        let rejected = given.unwrap_err().to_string();
        assert!(rejected.contains(why), "{rejected}");
    }
    let import = executor.import("colors").unwrap();
    executor.give::<wgpu::Buffer>(import, &buffer(&[1.0, 0.0, 0.0, 1.0], storage)).unwrap();
    assert_eq!(record(&mut executor), Ok(vec![255, 0, 0, 255]));
    executor.give(import, &buffer(&[0.0, 1.0, 0.0, 1.0], storage)).unwrap();
    assert_eq!(record(&mut executor), Ok(vec![0, 255, 0, 255]));
    executor.set_plan(std::sync::Arc::new(plan.clone())).unwrap();
    assert_eq!(record(&mut executor), Ok(vec![0, 255, 0, 255]));
}
