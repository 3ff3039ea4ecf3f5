//! The CPU cost of recording a frame, compared with the same frame written by hand in plain wgpu (`hand`).
//!
//! `awsm` on the courtyard, the interior, and floors of boxes with 10 to 10,000 draws in each view: the medians of 31
//! pairs of a record, taken in turn. Both run the same CPU passes, fill the same blocks and call the same draw source;
//! their pictures are equal pixel for pixel. `ratio record/SCENE VALUE` is ours divided by the one by hand.
//!
//! Then pipelines of 10 to 1,000 passes that fill one texture each (`ratio passes/slope`: the log-log slope of the time
//! per record), and `awsm` planned again, for another size and another value that is structural, beside the first check
//! (`ratio replan/…`).
//!
//! `cargo bench --bench record`

#[path = "../../tests/common/mod.rs"]
mod common;
mod hand;
#[path = "../measure.rs"]
mod measure;

use std::sync::Arc;
use std::time::{Duration, Instant};

use hand::{ByHand, Counts};
use umbragraph::draw::{DrawPass, DrawSource, HostInterface, PropertySet};
use umbragraph::frame::{Bounds, Camera, FrameInput, Light};
use umbragraph::scene::gpu::SceneResources;
use umbragraph::{Executor, Frame, Library, Options, Pipeline, Plan};
use umbragraph_test_support::gpu::{self, Gpu};
use wgpu::util::DeviceExt;

const SIZE: [u32; 2] = [128, 72];
const PAIRS: usize = 31;

fn main() {
    let Some(gpu) = gpu::device() else {
        println!("there is no graphics adapter");
        return;
    };
    println!("on {}", gpu.name);
    let mut rows = Vec::new();
    let library = Library::new();
    let start = Instant::now();
    let awsm = library.load("umbragraph:awsm.json").unwrap_or_else(|error| panic!("{error}"));
    let options = || Options::new(SIZE[0], SIZE[1]).set("cascade_side", 256).set("cube_side", 64);
    planned(&awsm, &options());
    let check = start.elapsed();
    for name in ["courtyard", "interior"] {
        let path = common::root().join(format!("examples/scenes/{name}.glb"));
        let scene = common::gpu::scene(&path);
        let source = SceneResources::new(&gpu.device, &gpu.queue, &scene, &scene.pose(0.0))
            .expect("a scene that fits");
        let input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
        rows.push(compare(&gpu, name, (&awsm, options()), &source, &input));
    }
    for count in [10, 100, 1_500, 10_000] {
        let source = Boxes::new(&gpu, count);
        let name = format!("a floor of {count} boxes");
        rows.push(compare(&gpu, &name, (&awsm, options()), &source, &source.input()));
    }
    measure::table(["scene", "draws of the host", "ours", "by hand", "ratio"], &rows);
    let slope = passes(&gpu);
    let mut rows = vec![["10 to 1,000 passes that do next to nothing, log-log slope".to_owned(), slope]];
    for (name, options) in [
        ("size", Options::new(256, 144).set("cascade_side", 256).set("cube_side", 64)),
        ("feature", options().feature("contact_shadows", true)),
    ] {
        // What a change needs for the first time is proven once; the second time everything is known.
        planned(&awsm, &options);
        planned(&awsm, &Options::new(SIZE[0], SIZE[1]));
        let start = Instant::now();
        planned(&awsm, &options);
        let ratio = start.elapsed().as_secs_f64() / check.as_secs_f64();
        println!("ratio replan/{name} {ratio:.3}");
        rows.push([
            format!("`awsm` planned for another {name}, over its first check"),
            format!("{ratio:.5}"),
        ]);
    }
    measure::table(["what", "ratio"], &rows);
    println!("first check {check:?}");
}

fn planned(pipeline: &Pipeline, options: &Options) -> Arc<Plan> {
    pipeline.plan(options).unwrap_or_else(|error| panic!("{error}"))
}

fn compare(
    gpu: &Gpu,
    name: &str,
    (pipeline, mut options): (&Pipeline, Options),
    source: &dyn DrawSource,
    input: &FrameInput,
) -> [String; 5] {
    let mut plan = planned(pipeline, &options);
    let targets = [(), ()].map(|()| common::gpu::import(gpu, &plan, "target"));
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan.clone(), Some(source))
        .unwrap_or_else(|error| panic!("{error}"));
    let ours = |executor: &mut Executor| {
        let imports = &[("target", &targets[0])];
        let frame = Frame::new(input).draws(source).imports(imports);
        timed(gpu, |encoder| executor.record(encoder, &frame).unwrap_or_else(|error| panic!("{error}")))
    };
    // Until all sizes are as they are wanted.
    for _ in 0..16 {
        ours(&mut executor);
        let Some(sizes) = executor.wanted_sizes() else { break };
        options = options.data_sizes(sizes);
        plan = planned(pipeline, &options);
        executor.set_plan(plan.clone()).unwrap_or_else(|error| panic!("{error}"));
    }
    // Both begin anew: where lights have their tiles follows from the frames before.
    let made = Executor::new(&gpu.device, &gpu.queue, plan.clone(), Some(source));
    let mut executor = made.unwrap_or_else(|error| panic!("{error}"));
    let mut by_hand = ByHand::new(gpu, &plan, source, &targets[1]);
    let theirs = |by_hand: &mut ByHand| timed(gpu, |encoder| by_hand.record(encoder, input, source));
    for _ in 0..3 {
        ours(&mut executor);
        theirs(&mut by_hand);
    }
    let pairs: Vec<(Duration, Duration)> =
        (0..PAIRS).map(|_| (ours(&mut executor), theirs(&mut by_hand))).collect();
    let [one, two] = [0, 1].map(|at| common::gpu::read(gpu, &targets[at]));
    assert_eq!(one.differing(&two, 0), 0, "{name}: the pictures differ");
    let mut ratios: Vec<f64> =
        pairs.iter().map(|(ours, theirs)| ours.as_secs_f64() / theirs.as_secs_f64()).collect();
    ratios.sort_by(f64::total_cmp);
    let (ours, theirs) = pairs.into_iter().unzip();
    let drawn: u64 = executor.pass_counts().map(|(_, counts)| counts.draws).sum();
    let Counts { passes, draws, pipelines, groups } = by_hand.counts;
    println!(
        "{name}: by hand {passes} passes, {draws} draws, beside the host's {pipelines} pipelines and {groups} bind groups set"
    );
    let ratio = ratios[ratios.len() / 2];
    println!("ratio record/{} {ratio:.3}", name.replace(' ', "_"));
    let shown = |time: Duration| format!("{:.2} ms", time.as_secs_f64() * 1e3);
    [name.to_owned(), drawn.to_string(), shown(median(ours)), shown(median(theirs)), format!("{ratio:.2}")]
}

/// Returns the time to record a frame, which is then submitted.
fn timed(gpu: &Gpu, record: impl FnOnce(&mut wgpu::CommandEncoder)) -> Duration {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let start = Instant::now();
    record(&mut encoder);
    let took = start.elapsed();
    gpu.queue.submit([encoder.finish()]);
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
    took
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}

/// Measures the time to record pipelines of many minimal passes. Returns a text with the log-log slope.
fn passes(gpu: &Gpu) -> String {
    let mut points = Vec::new();
    for count in [10_usize, 100, 1_000] {
        let resources: String = (0..count).map(|at| format!("\"t{at}\": {{ \"texture\": {{ \"format\": \"rgba8unorm\", \"size\": [4, 4], \"exposed\": true }} }},")).collect();
        let fills: Vec<String> = (0..count).map(|at| format!("\"p{at}\": {{ \"fullscreen\": {{ \"shader\": \"gradient.wgsl.jinja\", \"color\": [{{ \"to\": \"&t{at}\" }}] }} }}")).collect();
        let text = format!(
            "{{ \"format\": 1, \"name\": \"many\", \"resources\": {{ {} }}, \"passes\": {{ {} }} }}",
            resources.trim_end_matches(','),
            fills.join(", ")
        );
        let plan = planned(
            &Library::new().load_text("many.json", &text).unwrap_or_else(|error| panic!("{error}")),
            &Options::new(4, 4),
        );
        let mut executor =
            Executor::new(&gpu.device, &gpu.queue, plan, None).unwrap_or_else(|error| panic!("{error}"));
        let input = FrameInput::new(Camera::look_at([1.0; 3], [0.0; 3], 1.0, 1.0));
        let frame = Frame::new(&input);
        let mut record = |encoder: &mut wgpu::CommandEncoder| {
            executor.record(encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
        };
        let time = median((0..PAIRS).map(|_| timed(gpu, &mut record)).collect());
        println!("{count} passes: {time:?} a record");
        points.push((count as f64, time.as_secs_f64()));
    }
    let slope = (points[2].1 / points[0].1).log10() / (points[2].0 / points[0].0).log10();
    println!("ratio passes/slope {slope:.3}");
    format!("{slope:.2}")
}

/// A scene of boxes on a floor, each with its own draw call, culled against the view.
struct Boxes {
    interface: HostInterface,
    streams: [wgpu::Buffer; 3],
    objects: wgpu::Buffer,
    material: wgpu::Buffer,
    white: wgpu::TextureView,
    sampler: wgpu::Sampler,
    middles: Vec<glam::DVec3>,
}

impl Boxes {
    fn new(gpu: &Gpu, count: usize) -> Self {
        let buffer = |contents: &[u8], usage| {
            gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
        };
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        for normal in glam::Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
            let right = normal.any_orthonormal_vector();
            let up = normal.cross(right);
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                positions.push(((normal + right * x + up * y) * 0.5).to_array());
                normals.push(normal.to_array());
            }
        }
        let side = (count as f64).sqrt().ceil();
        let mut middles = Vec::new();
        let mut objects = Vec::new();
        for at in 0..count {
            let place =
                glam::DVec3::new(at as f64 % side - 0.5 * side, 0.3, (at as f64 / side).floor() - 0.5 * side);
            let (place, scale) = if at == 0 {
                (glam::DVec3::NEG_Y * 0.1, glam::DVec3::new(side + 4.0, 0.2, side + 4.0))
            } else {
                (place, glam::DVec3::splat(0.6))
            };
            let world =
                glam::DMat4::from_scale_rotation_translation(scale, glam::DQuat::IDENTITY, place).as_mat4();
            let start = objects.len();
            objects.extend_from_slice(bytemuck::bytes_of(&world));
            objects.extend_from_slice(bytemuck::bytes_of(&world.inverse().transpose()));
            objects.extend_from_slice(&1u32.to_ne_bytes());
            objects.resize(start + 256, 0);
            middles.push(place);
        }
        // Large enough for the block of what whole materials have, which no box reads.
        let mut material = [0.0; 64];
        material[..9].copy_from_slice(&[0.6, 0.6, 0.55, 1.0, 0.0, 0.0, 0.0, 0.0, f32::from_bits(1)]);
        let white = gpu.device.create_texture_with_data(
            &gpu.queue,
            &wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d::default(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::LayerMajor,
            &[255; 4],
        );
        let mut interface = umbragraph::scene::interface::any_scene();
        interface.property_sets = vec![PropertySet::default()];
        Self {
            interface,
            streams: [bytemuck::cast_slice(&positions), bytemuck::cast_slice(&normals), &[0; 8 * 36]]
                .map(|bytes| buffer(bytes, wgpu::BufferUsages::VERTEX)),
            objects: buffer(&objects, wgpu::BufferUsages::UNIFORM),
            material: buffer(bytemuck::cast_slice(&material), wgpu::BufferUsages::UNIFORM),
            white: white.create_view(&wgpu::TextureViewDescriptor::default()),
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor::default()),
            middles,
        }
    }

    fn input(&self) -> FrameInput {
        let reach = (self.middles.len() as f64).sqrt() * 0.5 + 2.0;
        let camera = Camera::look_at(
            [reach, reach * 0.7 + 2.0, reach],
            [0.0; 3],
            0.9,
            f64::from(SIZE[0]) / f64::from(SIZE[1]),
        );
        let mut sun = Light::directional("sun", [-0.6, -0.7, -0.3], [1.0; 3], 4.0);
        sun.properties.push("cast_shadow".into());
        FrameInput::new(camera)
            .lights(vec![sun])
            .scene_bounds(Bounds::between([-reach, -0.2, -reach], [reach, 0.6, reach]))
    }
}

impl DrawSource for Boxes {
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        (geometry == "scene").then_some(&self.interface)
    }
    fn material_count(&self) -> u32 {
        1
    }
    fn material(&self, _: u32, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        Some(match binding {
            "material" | "material_detail" => self.material.as_entire_binding(),
            map if map.ends_with("_texture") => wgpu::BindingResource::TextureView(&self.white),
            map if map.ends_with("_sampler") => wgpu::BindingResource::Sampler(&self.sampler),
            _ => return None,
        })
    }
    fn object(&self, _: &str) -> Option<wgpu::BindingResource<'_>> {
        Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.objects,
            offset: 0,
            size: wgpu::BufferSize::new(144),
        }))
    }
    fn draw(&self, pass: &mut dyn DrawPass) {
        if pass.filter() == "transparent" || !pass.set_properties(PropertySet::default()) {
            return;
        }
        for (slot, stream) in (0..).zip(&self.streams) {
            pass.render_pass().set_vertex_buffer(slot, stream.slice(..));
        }
        let clip = pass.view().clip_from_world;
        for (object, middle) in (0..).zip(&self.middles) {
            let seen = clip * middle.extend(1.0);
            // A box around what is seen, larger by what a box is wide.
            if object > 0 && (seen.x.abs() > seen.w + 2.0 || seen.y.abs() > seen.w + 2.0) {
                continue;
            }
            pass.set_object(object);
            pass.render_pass().draw(0..36, 0..1);
        }
    }
}
