//! Shadows traced on the GPU, held against rays on the CPU.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use umbragraph::draw::{DrawPass, DrawSource, HostInterface};
use umbragraph::frame::FrameInput;
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::passes::words::CAST_SHADOW;
use umbragraph::scene::Scene;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::scene::interface::RAYS;
use umbragraph::scene::material::{AlphaMode, Map};
use umbragraph::scene::morph::MorphTarget;
use umbragraph::scene::texture::{Image, Sampler, Texture};
use umbragraph::{Executor, Frame};
use umbragraph_score::{Rays, Rendered, Scores, Truth};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::truth::TruthScene;

use crate::common::gpu::{executor, import, read, scene};
use crate::common::{Outcome, With, check_file, root};

/// The pixels that may differ, of a million.
const DIFFERENT: u64 = 25;

/// The number of lights of a scene that are drawn.
const LIGHTS: usize = 3;

fn outcome(features: &[(&str, &str)], parameters: &[(&str, &str)], size: [u32; 2]) -> Outcome {
    let all: Vec<_> = parameters.iter().copied().chain([("debug_view", "\"shadow_term\"")]).collect();
    let with = With { parameters: &all, features, size: Some(size), ..With::default() };
    check_file("pipelines/umbra.json", &with)
}

fn hard(size: [u32; 2]) -> Outcome {
    outcome(&[("light_filter", "\"rays\"")], &[("ray_samples", "1")], size)
}

/// The picture of the lights of a frame, one by one, by a host that moves the scene there.
fn pictures<'a>(
    gpu: &'a Gpu,
    outcome: &'a Outcome,
    scene: &'a Scene,
    input: &'a FrameInput,
) -> impl Iterator<Item = (FrameInput, Picture)> + 'a {
    let mut resources =
        SceneResources::new(&gpu.device, &gpu.queue, scene, &scene.pose(0.0)).expect("a scene");
    let target = import(gpu, outcome.plan(), "target");
    let mut executor = executor(gpu, outcome.plan(), Some(&resources));
    let casting = input.lights.iter().filter(|light| light.has(CAST_SHADOW)).take(LIGHTS);
    let mut draw = move |input: &FrameInput| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("target", &target)];
        let frame = Frame::new(input).draws(&resources).imports(&imports);
        executor.record(&mut encoder, &frame).expect("a record");
        gpu.queue.submit([encoder.finish()]);
        resources.update(&gpu.queue, scene, &scene.pose(input.time));
        read(gpu, &target)
    };
    // The buffer is made in the pose at rest, and then follows.
    draw(input);
    casting.map(move |light| {
        let alone = input.clone().lights(vec![light.clone()]);
        let picture = draw(&alone);
        (alone, picture)
    })
}

/// Counts the pixels of a scene at a time whose hard shadows differ from rays on the CPU, and all pixels.
fn differing(gpu: &Gpu, outcome: &Outcome, scene: &Scene, time: f64) -> [u64; 2] {
    let size @ [width, height] = outcome.plan().viewport;
    let input = scene.frame_input(f64::from(width) / f64::from(height), time);
    let rays = Rays::new(scene, &scene.pose(time));
    let truth = Truth::new(&rays, &input.camera, size);
    let mut counts = [0, 0];
    for (alone, picture) in pictures(gpu, outcome, scene, &input) {
        // The light's extent does not matter to a hard mask.
        let point = alone.lights[0].clone().angular_diameter(0.0).radius(0.0);
        let traced = truth.light(&point).expect("a light that can be used");
        let scores = Scores::of(&truth, &traced, Rendered::new(picture.bytes()));
        let all = scores.band(0);
        assert!(all.shadowed_in_both > 0, "{} shadows something", point.name);
        counts[0] += all.leaking + all.acne;
        counts[1] += all.pixels();
    }
    counts
}

#[track_caller]
fn assert_few([different, all]: [u64; 2]) {
    println!("{different} of {all} pixels differ");
    assert!(different * 1_000_000 <= DIFFERENT * all, "{different} of {all} pixels");
}

#[test]
fn rays_draw_the_masks_of_the_projects_scenes() {
    let Some(gpu) = gpu::device() else { return };
    let outcome = hard([256, 144]);
    let mut counts = [0, 0];
    for name in ["courtyard", "figure", "foliage", "interior"] {
        let scene = scene(&root().join(format!("examples/scenes/{name}.glb")));
        let found = differing(&gpu, &outcome, &scene, 0.0);
        println!("{name}: {found:?}");
        counts = [counts[0] + found[0], counts[1] + found[1]];
    }
    assert_few(counts);
}

#[test]
fn rays_draw_the_masks_of_the_other_tracers_scenes() {
    let names = ["contact_sun", "terrain_dem_sun", "room_point"];
    let scenes = names.map(TruthScene::find);
    let Some(gpu) = gpu::device() else { return };
    let outcome = hard([256, 256]);
    let mut counts = [0, 0];
    for (name, truth) in names.into_iter().zip(scenes) {
        let Some(truth) = truth else { continue };
        let found = differing(&gpu, &outcome, &scene(&truth.glb_path()), 0.0);
        println!("{name}: {found:?}");
        counts = [counts[0] + found[0], counts[1] + found[1]];
    }
    assert_few(counts);
}

/// The figure, whose materials have holes and whose meshes bulge.
fn bulging_net() -> Scene {
    let mut scene = scene(&root().join("examples/scenes/figure.glb"));
    let side = 16;
    let texel =
        |at: u32| [200, 180, 90, if (at % side / 4 + at / side / 4).is_multiple_of(2) { 255 } else { 0 }];
    let rgba = (0..side * side).flat_map(texel).collect();
    Arc::make_mut(&mut scene.images).push(Image { name: String::new(), width: side, height: side, rgba });
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler: Sampler::default() });
    let map = Map { texture: scene.textures.len() - 1, set: 0, transform: Map::IDENTITY };
    for material in &mut scene.materials {
        material.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
        material.base_color_map = Some(map);
    }
    for primitive in Arc::make_mut(&mut scene.meshes).iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        primitive.texcoords =
            primitive.positions.iter().map(|[x, y, z]| [x + 0.3 * z, y + 0.2 * z]).collect();
        let out = primitive.normals.iter().map(|normal| normal.map(|part| 0.05 * part)).collect();
        let bounds = primitive.bounds;
        primitive.targets = vec![MorphTarget { positions: out, normals: Vec::new(), bounds }];
    }
    for node in scene.nodes.iter_mut().filter(|node| node.mesh.is_some()) {
        node.weights = vec![1.0];
    }
    scene
}

#[test]
fn rays_follow_joints_and_morphs_and_pass_through_holes() {
    let Some(gpu) = gpu::device() else { return };
    assert_few(differing(&gpu, &hard([384, 216]), &bulging_net(), 0.7));
}

#[test]
fn rays_pass_by_triangles_without_area_or_finite_corners() {
    let Some(gpu) = gpu::device() else { return };
    let mut scene = scene(&root().join("examples/scenes/courtyard.glb"));
    for primitive in Arc::make_mut(&mut scene.meshes).iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        let faces = primitive.indices.chunks_exact_mut(3).enumerate();
        faces.filter(|(at, _)| at % 5 == 0).for_each(|(_, face)| face[1] = face[0]);
        // A vertex of its own, so that few triangles vanish.
        if let Some(last) = primitive.indices.last().copied() {
            primitive.positions[last as usize] = [f32::NAN, 0.0, f32::INFINITY];
        }
    }
    assert_few(differing(&gpu, &hard([256, 144]), &scene, 0.0));
}

#[test]
fn a_scene_of_blended_surfaces_alone_is_lit() {
    let Some(gpu) = gpu::device() else { return };
    let mut scene = scene(&root().join("examples/scenes/courtyard.glb"));
    scene.materials.iter_mut().for_each(|material| material.alpha_mode = AlphaMode::Blend);
    let outcome = hard([64, 36]);
    let input = scene.frame_input(16.0 / 9.0, 0.0);
    for (_, picture) in pictures(&gpu, &outcome, &scene, &input) {
        assert!(picture.rgba_pixels().all(|pixel| pixel[0] == 255 || pixel[3] == 0));
    }
}

/// The mean error of the penumbrae of the trees, with some filter.
fn error(gpu: &Gpu, filter: &str, parameters: &[(&str, &str)]) -> (f64, f64) {
    let outcome = outcome(&[("light_filter", filter)], parameters, [160, 90]);
    let scene = scene(&root().join("examples/scenes/foliage.glb"));
    let input = scene.frame_input(16.0 / 9.0, 0.0);
    let rays = Rays::new(&scene, &scene.pose(0.0));
    let truth = Truth::new(&rays, &input.camera, [160, 90]);
    let mut scores = Scores::default();
    for (alone, picture) in pictures(gpu, &outcome, &scene, &input) {
        let traced = truth.light(&alone.lights[0]).expect("a light that can be used");
        scores.add(&Scores::of(&truth, &traced, Rendered::new(picture.bytes())));
    }
    (scores.mean_error.mean().expect("an extent"), scores.iou().expect("shadows"))
}

#[test]
fn rays_where_maps_are_coarse_are_nearly_rays_everywhere() {
    let Some(gpu) = gpu::device() else { return };
    let coarse = [("cascade_side", "320")];
    let [maps, hybrid, all] =
        ["\"pcss\"", "\"hybrid\"", "\"rays\""].map(|filter| error(&gpu, filter, &coarse));
    println!("maps {maps:?}, hybrid {hybrid:?}, rays {all:?}");
    assert!(all.0 < 0.01 && hybrid.0 < 0.01 && hybrid.0 < 0.5 * maps.0, "{maps:?} {hybrid:?} {all:?}");
    assert!(hybrid.1 > maps.1, "{maps:?} {hybrid:?} {all:?}");
}

/// A scene that counts how often it is asked for a buffer, or has none to give.
struct Counting<'s> {
    scene: &'s SceneResources,
    asked: AtomicU32,
    fails: bool,
}

impl DrawSource for Counting<'_> {
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        self.scene.interface(geometry)
    }
    fn material_count(&self) -> u32 {
        self.scene.material_count()
    }
    fn material(&self, material: u32, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        self.scene.material(material, binding)
    }
    fn object(&self, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        self.scene.object(binding)
    }
    fn buffer(&self, name: &str) -> Option<Result<&wgpu::Buffer, String>> {
        self.asked.fetch_add(1, Ordering::Relaxed);
        if self.fails { Some(Err("it is too large".to_owned())) } else { self.scene.buffer(name) }
    }
    fn draw(&self, pass: &mut dyn DrawPass) {
        self.scene.draw(pass);
    }
}

/// Records a frame of the courtyard: how often the buffer was asked for, and what the record said.
fn record(gpu: &Gpu, filter: &str, fails: bool) -> (u32, Result<(), String>) {
    let outcome = outcome(&[("light_filter", filter)], &[], [64, 36]);
    let scene = scene(&root().join("examples/scenes/courtyard.glb"));
    let resources = SceneResources::new(&gpu.device, &gpu.queue, &scene, &scene.pose(0.0)).expect("a scene");
    let counting = Counting { scene: &resources, asked: AtomicU32::new(0), fails };
    let plan = Arc::new(outcome.plan().clone());
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, Some(&counting)).expect("an executor");
    let target = import(gpu, outcome.plan(), "target");
    let input = scene.frame_input(16.0 / 9.0, 0.0);
    let imports = [("target", &target)];
    let frame = Frame::new(&input).draws(&counting).imports(&imports);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let recorded = executor.record(&mut encoder, &frame).map_err(|error| error.to_string());
    gpu.queue.submit([encoder.finish()]);
    (counting.asked.into_inner(), recorded)
}

#[test]
fn triangles_are_packed_for_plans_with_rays_alone() {
    let Some(gpu) = gpu::device() else { return };
    assert_eq!(record(&gpu, "\"pcss\"", true), (0, Ok(())));
    assert_eq!(record(&gpu, "\"rays\"", false), (1, Ok(())));
    let (_, failed) = record(&gpu, "\"rays\"", true);
    let message = failed.expect_err("no buffer");
    let expected = format!("the host cannot make the buffer for \"{RAYS}\": it is too large");
    assert!(message.contains(&expected), "{message}");
}

#[test]
fn without_storage_buffers_rays_are_maps() {
    let limits = wgpu::Limits { max_storage_buffers_per_shader_stage: 0, ..wgpu::Limits::defaults() };
    let profile = TargetProfile::webgpu().on_device(&limits, wgpu::DownlevelFlags::all());
    let with = With { features: &[("light_filter", "\"rays\"")], profile: Some(profile), ..With::default() };
    let order = check_file("pipelines/awsm.json", &with);
    let order = order.order();
    assert!(order.contains(&"directional_casters") && !order.contains(&"gather.0"), "{order:?}");
}
