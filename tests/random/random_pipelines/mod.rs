//! Random pipelines with random small shaders, judged by `check` and by wgpu.
//!
//! A grammar draws textures, buffers and passes whose shaders bind and write them; most choices fit together, some do
//! not. What wgpu rejects `check` has to reject. What `check` rejects and wgpu's backend without a driver takes is
//! counted by code, and each such code has a reason in `STRICTER`. Some of what passes is drawn where there is a
//! device: without an error of the device, and with the texels that a CPU says ([`simulation`]).

mod grammar;
mod simulation;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::common::gpu::{empty_frame, executor};
use crate::common::{Outcome, read};
use grammar::{Drawn, pipeline};
use simulation::simulate;
use umbragraph::Frame;
use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostics, Severity};
use umbragraph::executor::{DryRun, imported_texture, read_back};
use umbragraph::low_level::CheckOptions;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::pipeline::{Overrides, TypedPipeline};
use umbragraph::low_level::shader::permutations::{self, Request};
use umbragraph::low_level::shader::{TargetProfile, TemplateSet};
use umbragraph::low_level::source::Sources;
use umbragraph_test_support::gpu;
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

/// Codes of what `check` rejects and wgpu takes, with the reason.
const STRICTER: &[(&str, &str)] = &[
    ("UG0401", "wgpu clears what nobody has written: it is valid, and hardly meant"),
    ("UG0403", "the same, where \"after\" keeps a pass behind the one that reads what it writes"),
];

/// Checks a drawn pipeline: the plan, and each shader for the profile.
fn check(drawn: &Drawn) -> Outcome {
    let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
    let mut templates = TemplateSet::new();
    let covering = "lib/fullscreen.wgsl.jinja";
    let text = read(&format!("shaders-templates/{covering}"));
    let all = drawn.templates.iter().map(|(name, text)| (name.as_str(), text.as_str()));
    for (name, text) in all.chain([(covering, text.as_str())]) {
        templates.add(&mut sources, name, text, &mut diagnostics);
    }
    templates.check(&mut diagnostics);
    let templates = Arc::new(templates);
    let file = sources.add("random.json", drawn.document.as_str());
    let profile = TargetProfile::webgpu();
    let options = CheckOptions {
        registry: &umbragraph::registry(),
        templates: &templates,
        profile: &profile,
        overrides: &Overrides::default(),
        plan: &PlanOptions::new(64, 64),
    };
    let checked = umbragraph::low_level::check(file, &options, &sources, &mut diagnostics);
    let programs = checked.pipeline.iter().flat_map(|pipeline| &pipeline.programs);
    let variants = programs.flat_map(|program| program.variants.iter().map(move |one| (program, one)));
    let requests: Vec<Request> = variants
        .map(|(program, variant)| {
            let profiles = std::slice::from_ref(&profile);
            Request::one(&templates, &program.template, &variant.module.axes, profiles)
        })
        .collect();
    let options = permutations::Options { threads: 1, ..permutations::Options::default() };
    diagnostics.extend(permutations::check(&templates, &requests, &options).diagnostics);
    Outcome { sources, diagnostics, checked }
}

fn describe(drawn: &Drawn) -> String {
    let shaders: Vec<String> =
        drawn.templates.iter().map(|(name, text)| format!("--- {name}\n{text}")).collect();
    format!("{}\n{}", drawn.document, shaders.join(""))
}

/// Pipelines in ordinary tests; forty times as many make 20,000.
const PIPELINES: u32 = 500;

#[test]
fn what_wgpu_rejects_of_random_pipelines_check_rejects() {
    let mut dry_run = pollster::block_on(DryRun::new(&TargetProfile::webgpu())).expect("a device");
    let mut random = Random(property::seed());
    let (mut passed, mut rejected, mut wrong) = (0, 0, Vec::new());
    let mut said_of: BTreeMap<&'static str, usize> = BTreeMap::new();
    let mut stricter: BTreeMap<&'static str, (usize, String)> = BTreeMap::new();
    for _ in 0..PIPELINES * property::times() {
        let drawn = pipeline(&mut random);
        let outcome = check(&drawn);
        let is_sound = !outcome.diagnostics.has_errors();
        let errors = outcome.diagnostics.iter().filter(|one| one.severity == Severity::Error);
        let codes: Vec<&'static str> = errors.map(|one| one.code.id).collect();
        passed += usize::from(is_sound);
        rejected += usize::from(!is_sound);
        codes.iter().for_each(|code| *said_of.entry(code).or_default() += 1);
        let text = outcome.text();
        let is_whole =
            |pipeline: &Arc<TypedPipeline>| pipeline.gaps.is_empty() && pipeline.rejected.is_empty();
        let pipeline = outcome.checked.pipeline.filter(is_whole);
        let Some(plan) = outcome.checked.plan.filter(|_| pipeline.is_some()) else { continue };
        let said = pollster::block_on(dry_run.run(&plan));
        match (is_sound, said.has_errors()) {
            (true, true) => wrong.push(format!("{:?}\n{}", said, describe(&drawn))),
            (false, false) => {
                for code in codes {
                    let (count, _) = stricter.entry(code).or_insert((0, text.clone()));
                    *count += 1;
                }
            }
            _ => {}
        }
    }
    println!("{passed} pass, {rejected} are rejected: {said_of:?}");
    for (code, (count, _)) in &stricter {
        println!("{code}: rejected {count} times where wgpu takes the plan");
    }
    assert!(passed > 50 && rejected > 20, "{passed} pass, {rejected} are rejected");
    wrong.sort_by_key(String::len);
    assert!(wrong.is_empty(), "{} of {passed}, the shortest:\n{}", wrong.len(), wrong[0]);
    let unargued = stricter.iter().filter(|(code, _)| STRICTER.iter().all(|(known, _)| known != *code));
    let unargued: Vec<String> =
        unargued.map(|(code, (count, text))| format!("{code} ({count})\n{text}")).collect();
    assert!(unargued.is_empty(), "{}", unargued.join("\n"));
}

/// A texture for each of the host's own.
pub(crate) fn imports(device: &wgpu::Device, plan: &Plan) -> Vec<(String, wgpu::Texture)> {
    let more = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = |name| imported_texture(device, plan, name, more);
    plan.resources.keys().filter_map(|name| Some((name.clone(), texture(name)?))).collect()
}

#[test]
fn random_pipelines_draw_as_the_simulation_says() {
    let Some(gpu) = gpu::device() else { return };
    let mut random = Random(property::seed() ^ 0x5eed);
    let (mut drawn, mut read, mut known) = (0, 0, 0);
    while drawn < 40 * property::times().min(5) {
        let case = pipeline(&mut random);
        let outcome = check(&case);
        if outcome.diagnostics.has_errors() {
            continue;
        }
        drawn += 1;
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let plan = outcome.checked.plan.as_ref().expect("a plan");
        let mut executor = executor(&gpu, plan, None);
        let textures = imports(&gpu.device, plan);
        let imports: Vec<_> = textures.iter().map(|(name, texture)| (name.as_str(), texture)).collect();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor
            .record(&mut encoder, &Frame::new(&empty_frame()).imports(&imports))
            .unwrap_or_else(|said| panic!("{said:?}\n{}", describe(&case)));
        gpu.queue.submit([encoder.finish()]);
        let error = pollster::block_on(scope.pop());
        assert!(error.is_none(), "{error:?}\n{}", describe(&case));
        let expected = simulate(&case);
        for (name, texture) in &textures {
            let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, texture)).expect("numbers");
            let Some(image) = expected.get(name) else { continue };
            assert_eq!(texels.values.len(), image.len(), "{name}");
            for (at, (seen, said)) in texels.values.iter().zip(image).enumerate() {
                let fits = seen.iter().zip(said).all(|(seen, said)| said.holds(f64::from(*seen)));
                let is_known = said.iter().all(|one| one.is_known());
                assert!(fits, "{name}, texel {at}: {seen:?} is not in {said:?}\n{}", describe(&case));
                known += usize::from(is_known);
                read += 1;
            }
        }
    }
    println!("{drawn} pipelines drawn, {read} texels read, {known} of them simulated");
    assert!(known > read * 3 / 4, "{known} of {read}");
}
