//! Live parameters: whatever one is set to from frame to frame, the picture is that of a new plan, bit for bit.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use crate::common::gpu::{executor, import, read, scene};
use crate::common::settings::others;
use crate::common::{Outcome, SMALL_MAPS, With, check, check_file, root};
use umbragraph::frame::FrameInput;
use umbragraph::low_level::compiler::{CpuPasses, Parameters};
use umbragraph::low_level::expression::Value;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::{Executor, Frame};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::property;

const SIZE: [u32; 2] = [96, 64];

/// The systems, with the scene that each is drawn with.
const SYSTEMS: &[(&str, &str)] = &[
    ("awsm", "interior"),
    ("caracal", "courtyard"),
    ("lore", "courtyard"),
    ("mantis", "courtyard"),
    ("nebula", "courtyard"),
];

/// A pipeline on a scene.
struct Subject {
    path: String,
    scene: String,
}

fn subjects() -> Vec<Subject> {
    let mut files = Vec::new();
    crate::common::files(&root().join("pipelines/learn"), &mut files);
    let is_lesson = |file: &&PathBuf| {
        file.parent() == Some(&root().join("pipelines/learn"))
            && file.extension().is_some_and(|end| end == "json")
    };
    let lesson = |file: &PathBuf| Subject {
        path: format!("pipelines/learn/{}", file.file_name().unwrap().to_string_lossy()),
        scene: "courtyard".to_owned(),
    };
    let systems = SYSTEMS
        .iter()
        .map(|(name, scene)| Subject { path: format!("pipelines/{name}.json"), scene: (*scene).to_owned() });
    systems.chain(files.iter().filter(is_lesson).map(lesson)).collect()
}

impl Subject {
    fn check(&self, parameter: Option<(&str, &str)>) -> Outcome {
        let is_awsm = self.path.contains("awsm");
        let small = SMALL_MAPS.iter().copied().filter(|_| is_awsm);
        let parameters: Vec<_> =
            small.filter(|one| parameter.is_none_or(|other| other.0 != one.0)).chain(parameter).collect();
        check_file(&self.path, &With { parameters: &parameters, size: Some(SIZE), ..With::default() })
    }
}

struct Drawn<'a> {
    gpu: &'a Gpu,
    scene: &'a SceneResources,
    input: &'a FrameInput,
}

impl Drawn<'_> {
    /// The picture of a first frame.
    fn picture(&self, executor: &mut Executor) -> Picture {
        let plan = executor.plan().clone();
        let imported = plan
            .resources
            .iter()
            .filter(|(_, one)| one.physical == umbragraph::low_level::compiler::Physical::Imported);
        let textures: BTreeMap<&str, wgpu::Texture> =
            imported.map(|(name, _)| (name.as_str(), import(self.gpu, &plan, name))).collect();
        let imports: Vec<_> = textures.iter().map(|(name, texture)| (*name, texture)).collect();
        executor.reset_history();
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let frame = Frame::new(self.input).draws(self.scene).imports(&imports);
        executor.record(&mut encoder, &frame).unwrap_or_else(|diagnostics| panic!("{diagnostics:?}"));
        self.gpu.queue.submit([encoder.finish()]);
        read(self.gpu, &textures["target"])
    }
}

#[test]
fn the_picture_with_a_live_parameter_set_is_that_of_a_new_plan() {
    let Some(gpu) = gpu::device() else { return };
    let (mut compared, mut moved) = (0, 0);
    for (at, subject) in subjects().iter().enumerate() {
        let before = subject.check(None);
        let Some(plan) = before.checked.plan.as_ref() else { continue };
        if !plan.resources.contains_key("target")
            || plan.resources["target"].format.is_none_or(|format| format.block_copy_size(None) != Some(4))
        {
            continue;
        }
        let pipeline = plan.pipeline.clone();
        let live = pipeline.parameters.iter().filter(|(_, parameter)| parameter.structural.is_none());
        // Each with the first other value that the pipeline takes.
        let live: Vec<_> = live.collect();
        // Of lessons ordinary tests try one in some, of systems one parameter in many.
        let out_of = if at < SYSTEMS.len() { 20 } else { 12 };
        let seed = property::seed() as usize + at;
        let part = live
            .iter()
            .enumerate()
            .filter(|(one, _)| property::times() > 1 || (one + seed).is_multiple_of(out_of));
        let mut drawn = None;
        for (_, (name, parameter)) in part {
            let mut values = others(&parameter.declaration, &parameter.value).into_iter();
            let Some((value, after)) = values.find_map(|value| {
                let after = subject.check(Some((name, &value.to_string())));
                after.diagnostics.is_empty().then_some((value, after))
            }) else {
                continue;
            };
            let (resources, input, live) = drawn.get_or_insert_with(|| {
                let scene = scene(&root().join("examples/scenes").join(&subject.scene).with_extension("glb"));
                let input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
                let resources =
                    SceneResources::new(&gpu.device, &gpu.queue, &scene, &scene.pose(0.0)).unwrap();
                let live = executor(&gpu, plan, Some(&resources));
                (resources, input, live)
            });
            let drawn = Drawn { gpu: &gpu, scene: resources, input };
            let base = drawn.picture(live);
            let handle = live.parameter::<Value>(name).unwrap_or_else(|error| panic!("{error:?}"));
            let given: Value = after.checked.pipeline.as_ref().unwrap().parameters[*name].value.clone();
            live.set(handle, given).unwrap_or_else(|error| panic!("{name}: {error:?}"));
            let picture = drawn.picture(live);
            let wanted = drawn.picture(&mut executor(&gpu, after.plan(), Some(resources)));
            assert!(
                picture == wanted,
                "{}: {name} set to {value} draws another picture than a new plan",
                subject.path
            );
            compared += 1;
            moved += usize::from(picture != base);
            live.set(handle, parameter.value.clone()).unwrap();
            assert!(drawn.picture(live) == base, "{}: {name} set back", subject.path);
        }
    }
    assert!(compared >= 8 && moved >= 2, "{compared} pictures compared, {moved} other than before");
}

/// Counts live and structural parameters of each system; the figures change as the systems do.
#[test]
fn of_the_systems_parameters_most_are_live() {
    let mut counts = [0, 0];
    for (name, _) in SYSTEMS {
        let outcome = check_file(&format!("pipelines/{name}.json"), &With::default());
        for (name, parameter) in &outcome.plan().pipeline.parameters {
            counts[usize::from(parameter.structural.is_some())] += 1;
            if let Some(structural) = &parameter.structural {
                println!("{name}: {}", structural.pointer);
            }
        }
    }
    println!("{counts:?}");
    assert!(counts[0] > counts[1], "{counts:?}");
}

const TEXT: &str = r#"{
    "format": 1, "name": "live",
    "parameters": {
        "red": { "type": "f32", "default": 0.5, "min": 0, "max": 1 },
        "low": { "type": "f32", "default": 0.25, "min": 0, "max": 1 },
        "high": { "type": "f32", "default": 0.75, "min": 0, "max": 1 },
        "side": { "type": "u32", "default": 8, "min": 1, "max": 64 },
        "tint": { "type": "f32[]", "default": [0, 0, 0, 1], "min": 0, "max": 1, "min_length": 4, "max_length": 4 }
    },
    "derived": { "twice": "=red * 2" },
    "constraints": { "order": { "holds": "=low < high", "message": "low is below high" } },
    "resources": {
        "target": { "texture": { "format": "rgba8unorm", "size": ["=side", 4], "lifetime": "imported" } }
    },
    "passes": { "fill": { "fullscreen": {
        "shader": "live.wgsl.jinja",
        "bind": { "settings": { "values": { "color": "=[twice / 2, low, high, 1]", "tint": "=tint" } } },
        "color": [{ "to": "&target" }]
    } } }
}"#;

const SHADER: &str = "{% include 'lib/fullscreen.wgsl.jinja' %}
struct Settings { color: vec4<f32>, tint: vec4<f32> }
@group(1) @binding(0) var<uniform> settings: Settings;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return settings.color + settings.tint; }
";

fn checked() -> Outcome {
    crate::common::check_with(
        "live.json",
        TEXT,
        &With { templates: &[("live.wgsl.jinja", SHADER)], ..With::default() },
    )
}

#[test]
fn what_makes_a_parameter_structural_is_said_with_its_place() {
    let outcome = checked();
    let plan = outcome.plan();
    let json = serde_json::to_value(plan).unwrap();
    assert_eq!(json["parameters"]["red"], serde_json::json!({ "live": true }));
    let side = serde_json::json!({ "live": false, "structural_at": "/resources/target/texture/size/0" });
    assert_eq!(json["parameters"]["side"], side);
    let Some(gpu) = gpu::device() else { return };
    let executor = executor(&gpu, plan, None);
    let rejected = executor.parameter::<u32>("side").unwrap_err();
    let text = format!("{rejected:?}");
    assert!(text.contains("UG0230") && text.contains("/resources/target/texture/size/0"), "{text}");
    assert!(format!("{:?}", executor.parameter::<f32>("rad").unwrap_err()).contains("red"));
    assert!(executor.parameter::<bool>("red").is_err());
}

#[test]
fn rejected_values_leave_the_ones_before() {
    let Some(gpu) = gpu::device() else { return };
    let outcome = checked();
    let mut executor = executor(&gpu, outcome.plan(), None);
    let target = import(&gpu, outcome.plan(), "target");
    let input = crate::common::gpu::empty_frame();
    let record = |executor: &mut Executor| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let result = executor
            .record(&mut encoder, &Frame::new(&input).imports(&[("target", &target)]))
            .map_err(|diagnostics| format!("{diagnostics:?}"));
        gpu.queue.submit([encoder.finish()]);
        result.map(|()| read(&gpu, &target).bytes()[..4].to_vec())
    };
    let red = executor.parameter::<f32>("red").unwrap();
    let (low, high) = (executor.parameter::<f64>("low").unwrap(), executor.parameter::<f64>("high").unwrap());
    let tint = executor.parameter::<[f32; 4]>("tint").unwrap();
    assert_eq!(record(&mut executor), Ok(vec![128, 64, 191, 255]));
    executor.set(red, 1.0).unwrap();
    executor.set(low, 0.5).unwrap();
    assert_eq!(record(&mut executor), Ok(vec![255, 128, 191, 255]));
    for beyond in [1.5, -0.5, f32::NAN, f32::INFINITY] {
        assert!(format!("{:?}", executor.set(red, beyond).unwrap_err()).contains("UG0204"), "{beyond}");
    }
    executor.set(low, 0.8).unwrap();
    let rejected = record(&mut executor).unwrap_err();
    assert!(rejected.contains("UG0223") && rejected.contains("low is below high"), "{rejected}");
    assert_eq!(record(&mut executor), Ok(vec![255, 128, 191, 255]), "the values before");
    // Both together are right.
    executor.set(low, 0.8).unwrap();
    executor.set(high, 1.0).unwrap();
    executor.set(tint, [-0.0, 0.0, 0.0, 0.0]).unwrap();
    assert_eq!(record(&mut executor), Ok(vec![255, 204, 255, 255]));
    // Values outlive another plan; a handle of another pipeline is an error.
    let plan = outcome
        .checked
        .plan_again(&umbragraph::low_level::compiler::PlanOptions::new(64, 64), &outcome.sources)
        .unwrap();
    executor.set_plan(std::sync::Arc::new(plan)).unwrap();
    assert_eq!(record(&mut executor), Ok(vec![255, 204, 255, 255]));
    let other = check(&TEXT.replace("live.wgsl.jinja", "gradient.wgsl.jinja").replace("\"red\"", "\"blue\"").replace(
        "\"bind\": { \"settings\": { \"values\": { \"color\": \"=[twice / 2, low, high, 1]\", \"tint\": \"=tint\" } } },",
        "",
    ).replace("red * 2", "blue * 2"));
    let mut other = crate::common::gpu::executor(&gpu, other.plan(), None);
    assert!(other.set(red, 0.5).is_err());
}

#[test]
fn lists_of_every_form_follow_a_live_parameter() {
    let Some(gpu) = gpu::device() else { return };
    let input = crate::common::gpu::empty_frame();
    for list in [
        "warm * red",
        "-warm * -red",
        "red > 0.6 ? warm * red : cold",
        "[warm, cold][red > 0.6 ? 0 : 1]",
        "floor(warm * red * 4) / 4",
        "min(tint) + min(warm * red) + cold",
        "[red, max(warm * red), len(warm) / 8, 1]",
        "tint * red + cold",
    ] {
        let plan = |red: &str| {
            let text = TEXT.replace("[twice / 2, low, high, 1]", list);
            let text = text.replace(
                "\"derived\": {",
                "\"derived\": { \"warm\": \"=[1, 0.5, 0.25, 1]\", \"cold\": \"=[0, 0.25, 0.5, 0]\",",
            );
            let with = With {
                templates: &[("live.wgsl.jinja", SHADER)],
                parameters: &[("red", red), ("tint", "[0.25, 0, 0.125, 0]")],
                ..With::default()
            };
            crate::common::check_with("lists.json", &text, &with)
        };
        let target = import(&gpu, plan("0.5").plan(), "target");
        let picture = |executor: &mut Executor| {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            executor
                .record(&mut encoder, &Frame::new(&input).imports(&[("target", &target)]))
                .unwrap_or_else(|said| panic!("{list}: {said:?}"));
            gpu.queue.submit([encoder.finish()]);
            read(&gpu, &target).bytes()[..4].to_vec()
        };
        let wanted = picture(&mut executor(&gpu, plan("0.75").plan(), None));
        let mut live = executor(&gpu, plan("0.5").plan(), None);
        let before = picture(&mut live);
        live.set(live.parameter::<f32>("red").unwrap(), 0.75).unwrap();
        assert_eq!(picture(&mut live), wanted, "{list}");
        assert!(before != wanted, "{list}");
    }
}

#[test]
fn a_number_that_takes_the_place_of_a_list_is_rejected() {
    let Some(gpu) = gpu::device() else { return };
    let text = TEXT.replace("[twice / 2, low, high, 1]", "red < 0.75 ? [red, red, red, 1] : 0");
    let with = With { templates: &[("live.wgsl.jinja", SHADER)], ..With::default() };
    let outcome = crate::common::check_with("number.json", &text, &with);
    let mut executor = executor(&gpu, outcome.plan(), None);
    let target = import(&gpu, outcome.plan(), "target");
    let input = crate::common::gpu::empty_frame();
    for (red, is_fine) in [(0.5, true), (0.8, false), (0.25, true)] {
        executor.set(executor.parameter::<f32>("red").unwrap(), red).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let frame = Frame::new(&input);
        let recorded = executor.record(&mut encoder, &frame.imports(&[("target", &target)]));
        let said = recorded.map_err(|said| format!("{said:?}"));
        assert_eq!(said.is_ok(), is_fine, "{red}: {said:?}");
        let said = said.err().unwrap_or_default();
        assert!(is_fine || said.contains("\\\"color\\\" is given 1 numbers"), "{said}");
    }
}

#[test]
fn cpu_passes_take_live_settings_and_reject_as_loading_does() {
    let text = r#"{
        "format": 1, "name": "cpu",
        "parameters": {
            "points": { "type": "u32", "default": 0 },
            "index": { "type": "u32", "default": 0 },
            "hard": { "type": "f32", "default": 0 },
            "border": { "type": "u32", "default": 2 },
            "size": { "type": "f32", "default": 0 },
            "far": { "type": "f32[]", "default": [10, 20] }
        },
        "passes": {
            "eye": { "camera": { "to": "&eye", "jitter": "=points" }, "side_effect": true },
            "fit": { "cascades": { "to": "&sun", "light": "sun", "far": "=far", "splits": { "count": 2 }, "resolution": 64, "border": "=border" }, "side_effect": true },
            "one": { "view": { "to": "&one", "from": "&sun", "index": "=index" }, "side_effect": true },
            "place": { "shadow_atlas": {
                "to": "&placement", "spots": { "min_side": 256, "max_side": 256, "min_tile": 16, "max_tile": 64 },
                "directional": { "capacity": 2, "cascades": 2 }, "descriptors": 8
            }, "side_effect": true },
            "spots": { "spot_shadows": { "to": "&tiles", "placement": "&placement", "capacity": 4, "light_size": "=size" }, "side_effect": true },
            "suns": { "cascades": { "to": "&layers", "placement": "&placement", "far": "=far", "splits": { "count": 2 }, "resolution": 64 }, "side_effect": true },
            "list": { "light_list": { "to": "&lights", "lights": 4, "hard_below": "=hard" }, "side_effect": true }
        }
    }"#;
    let plan = |parameters: &[(&str, &str)]| {
        let outcome = crate::common::check_with("cpu.json", text, &With { parameters, ..With::default() });
        Arc::new(outcome.plan().clone())
    };
    let mut frame = crate::common::host::quiet_frame();
    let mut brighter = frame.lights[0].clone().intensity(50.0).direction(glam::DVec3::NEG_Y);
    brighter.name = "another".into();
    frame.lights.push(brighter);
    let published = |passes: &mut CpuPasses| {
        passes.run(&frame, &[]).expect("data as declared");
        ["eye", "sun", "one", "lights", "tiles", "layers"].map(|name| {
            let data = passes.data(name).expect("published data");
            let words = (0..data.shape().values.len()).map(|at| data.words_at(at).map(<[u32]>::to_vec));
            (words.collect::<Vec<_>>(), data.views().to_vec())
        })
    };
    let base = plan(&[]);
    let mut passes = CpuPasses::new(base.clone());
    let mut live = Parameters::new(base.clone());
    let first = published(&mut passes);
    let mut set = |passes: &mut CpuPasses, name: &str, value: &Value| {
        let at = live.find(name).expect("a live parameter");
        live.set(at, &mut |given| given.clone_from(value)).expect("a value of its type");
        live.apply(passes, &mut |_, _, _| {})
    };
    for (name, text) in [
        ("points", "1024"),
        ("index", "1"),
        ("hard", "2"),
        ("border", "31"),
        ("size", "0.25"),
        ("far", "[5, 50]"),
    ] {
        let again = plan(&[(name, text)]);
        let wanted = published(&mut CpuPasses::new(again.clone()));
        set(&mut passes, name, &again.pipeline.parameters[name].value).expect("what loading takes");
        let found = published(&mut passes);
        assert!(found == wanted && found != first, "{name} set to {text}");
        set(&mut passes, name, &base.pipeline.parameters[name].value).expect("what loading takes");
        assert!(published(&mut passes) == first, "{name} set back");
    }
    for (name, value, code) in [("points", 1025.0, "UG0108"), ("border", 32.0, "UG0613")] {
        let rejected = format!("{:?}", set(&mut passes, name, &Value::Number(value)).unwrap_err());
        assert!(rejected.contains(code), "{rejected}");
        assert!(published(&mut passes) == first, "{name}: the values before");
    }
}

#[test]
fn a_live_parameter_reaches_a_pass_of_a_subgraph() {
    let Some(gpu) = gpu::device() else { return };
    let text = r#"{
        "format": 1, "name": "inner",
        "parameters": { "red": { "type": "f32", "default": 0.5, "min": 0, "max": 1 } },
        "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
        "subgraphs": { "paint": {
            "inputs": { "to": "what is painted" },
            "parameters": { "amount": { "type": "f32", "default": 1, "min": 0, "max": 0.8 },
                "fade": { "type": "f32[]", "default": [0, 0, 0, 0], "min": 0, "max": 1, "min_length": 4, "max_length": 4 } },
            "derived": { "half": "=amount / 2", "none": "=fade * 0" },
            "passes": { "fill": { "fullscreen": {
                "shader": "live.wgsl.jinja",
                "bind": { "settings": { "values": { "color": "=[half, amount, 0, 1]", "tint": "=none" } } },
                "color": [{ "to": "&to" }]
            } } }
        } },
        "passes": { "paint": { "use": "paint", "with": { "to": "&target", "amount": "=red", "fade": "=[red, red, 0, 1]" } } }
    }"#;
    let with = With { templates: &[("live.wgsl.jinja", SHADER)], size: Some([4, 4]), ..With::default() };
    let outcome = crate::common::check_with("inner.json", text, &with);
    let mut executor = executor(&gpu, outcome.plan(), None);
    let target = import(&gpu, outcome.plan(), "target");
    let input = crate::common::gpu::empty_frame();
    let record = |executor: &mut Executor| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let result = executor
            .record(&mut encoder, &Frame::new(&input).imports(&[("target", &target)]))
            .map_err(|diagnostics| format!("{diagnostics:?}"));
        gpu.queue.submit([encoder.finish()]);
        result.map(|()| read(&gpu, &target).bytes()[..4].to_vec())
    };
    let red = executor.parameter::<f64>("red").unwrap();
    assert_eq!(record(&mut executor), Ok(vec![64, 128, 0, 255]));
    executor.set(red, 0.4).unwrap();
    assert_eq!(record(&mut executor), Ok(vec![51, 102, 0, 255]));
    executor.set(red, 0.9).unwrap();
    assert!(record(&mut executor).unwrap_err().contains("is 0.9, above its maximum of 0.8"));
    assert_eq!(record(&mut executor), Ok(vec![51, 102, 0, 255]));
}
