//! Hosts that do anything: random live values, toggles, sizes and imports, on wgpu's backend without a driver.
//!
//! A host may give something wrong, and gets an error value then. A frame with all that is right succeeds, whatever came
//! before it, and wgpu has nothing to say.

use std::sync::{Arc, Mutex};

use umbragraph::low_level::expression::Value;
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::scene::Scene;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::{Executor, Frame, Library, Options, Pipeline};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use crate::common::gpu::scene;
use crate::common::root;
use crate::random_pipelines::imports;

/// Steps in ordinary tests.
const STEPS: usize = 300;
/// A host is replaced by another after so many steps.
const LIFE: usize = 30;

const PIPELINES: [&str; 7] = [
    "learn/04-expressions.json",
    "learn/11-persistent.json",
    "learn/14-history.json",
    "learn/16-buffers.json",
    "learn/17-toggles.json",
    "learn/29-temporal.json",
    "awsm.json",
];

/// A device without a driver, and what wgpu says of it.
struct Device {
    device: wgpu::Device,
    queue: wgpu::Queue,
    said: Arc<Mutex<Vec<String>>>,
}

impl Device {
    fn new() -> Self {
        let profile = TargetProfile::webgpu();
        let noop = wgpu::NoopBackendOptions {
            limits: Some(profile.limits.clone()),
            ..wgpu::NoopBackendOptions::enabled()
        };
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::NOOP,
            backend_options: wgpu::BackendOptions { noop, ..wgpu::BackendOptions::default() },
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        let descriptor =
            wgpu::DeviceDescriptor { required_limits: profile.limits, ..wgpu::DeviceDescriptor::default() };
        let opened = pollster::block_on(adapter.expect("the backend").request_device(&descriptor));
        let (device, queue) = opened.expect("a device");
        let said: Arc<Mutex<Vec<String>>> = Arc::default();
        let heard = said.clone();
        device.on_uncaptured_error(Arc::new(move |error| heard.lock().unwrap().push(error.to_string())));
        Self { device, queue, said }
    }
}

struct Host<'a> {
    device: &'a Device,
    pipeline: &'a Pipeline,
    scene: &'a Scene,
    meshes: SceneResources,
    executor: Executor,
    /// The imports of the plan, by name.
    imports: Vec<(String, wgpu::Texture)>,
}

impl<'a> Host<'a> {
    fn new(device: &'a Device, pipeline: &'a Pipeline, scene: &'a Scene) -> Self {
        let meshes = SceneResources::new(&device.device, &device.queue, scene, &scene.pose(0.0));
        let meshes = meshes.expect("a scene that fits");
        let plan = pipeline.plan(&Options::new(64, 36)).unwrap_or_else(|error| panic!("{error}"));
        let imports = imports(&device.device, &plan);
        let executor = Executor::new(&device.device, &device.queue, plan, Some(&meshes));
        let executor = executor.unwrap_or_else(|error| panic!("{error}"));
        Self { device, pipeline, scene, meshes, executor, imports }
    }

    /// Plans another size, or what is none.
    fn resize(&mut self, random: &mut Random) {
        let side = |random: &mut Random| random.one_of(&[0, 1, 2, 64, 65, 200, 8192, u32::MAX]);
        let size = [side(random), side(random)];
        let Ok(plan) = self.pipeline.plan(&Options::new(size[0], size[1])) else { return };
        // Large textures are created on no device for nothing.
        if size.iter().any(|side| *side > 200) {
            return;
        }
        self.executor.set_plan(plan.clone()).unwrap_or_else(|error| panic!("{size:?}: {error}"));
        self.imports = imports(&self.device.device, &plan);
    }

    /// Gives a live parameter a value of any type.
    fn set(&mut self, random: &mut Random) {
        let names: Vec<String> = self.executor.plan().pipeline.parameters.keys().cloned().collect();
        let name =
            if names.is_empty() || random.one_in(8) { "nothing".to_owned() } else { random.one_of(&names) };
        let number = |random: &mut Random| {
            random.one_of(&[0.0, 1.0, -1.0, 0.5, 1e30, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE])
        };
        let value = match random.below(4) {
            0 => Value::Bool(random.one_in(2)),
            1 => Value::List((0..random.below(5)).map(|_| Value::Number(number(random))).collect()),
            _ => Value::Number(number(random)),
        };
        let Ok(parameter) = self.executor.parameter::<Value>(&name) else { return };
        if let Err(error) = self.executor.set(parameter, value.clone()) {
            assert!(error.to_string().contains(&name), "{name}, {value:?}: {error}");
        }
    }

    /// Records a frame; imports and toggles are wrong in some way, or as they should be.
    fn frame(&mut self, random: &mut Random, is_right: bool) {
        let mut imports: Vec<(&str, wgpu::Texture)> =
            self.imports.iter().map(|(name, texture)| (name.as_str(), texture.clone())).collect();
        let known: Vec<String> =
            self.executor.plan().toggles.keys().filter(|_| random.one_in(2)).cloned().collect();
        let mut toggles: Vec<(&str, bool)> =
            known.iter().map(|name| (name.as_str(), random.one_in(2))).collect();
        if !is_right {
            wrong(&self.device.device, random, &mut imports, &mut toggles);
        }
        let given: Vec<(&str, &wgpu::Texture)> =
            imports.iter().map(|(name, texture)| (*name, texture)).collect();
        let input = self.scene.frame_input(64.0 / 36.0, random.one_of(&[0.0, 0.5, -1.0, 1e12]));
        let frame = Frame::new(&input).imports(&given).toggles(&toggles).draws(&self.meshes);
        let mut encoder =
            self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        match self.executor.record(&mut encoder, &frame) {
            Ok(()) => drop(self.device.queue.submit([encoder.finish()])),
            Err(error) => assert!(!is_right, "all that is given is right: {error}"),
        }
    }
}

/// Spoils what a host gives.
fn wrong(
    device: &wgpu::Device,
    random: &mut Random,
    imports: &mut Vec<(&str, wgpu::Texture)>,
    toggles: &mut Vec<(&str, bool)>,
) {
    let texture = |size: [u32; 2], format, sample_count| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        })
    };
    let at = random.below(imports.len());
    match random.below(7) {
        0 => imports.clear(),
        1 => toggles.push(("no_such_toggle", true)),
        2 => imports.push(("no_such_import", texture([1, 1], wgpu::TextureFormat::Rgba8Unorm, 1))),
        _ if imports.is_empty() => {}
        3 => imports[at].1 = texture([7, 5], wgpu::TextureFormat::Rgba8Unorm, 1),
        4 => imports[at].1 = texture([64, 36], wgpu::TextureFormat::R16Float, 1),
        5 => imports[at].1 = texture([64, 36], wgpu::TextureFormat::Rgba8Unorm, 4),
        _ => {
            let gone = texture([64, 36], wgpu::TextureFormat::Rgba8Unorm, 1);
            gone.destroy();
            imports[at].1 = gone;
        }
    }
}

#[test]
fn hosts_that_do_anything_get_errors_and_then_a_frame() {
    let device = Device::new();
    let scene = scene(&root().join("examples/scenes/figure.glb"));
    let library = Library::new();
    let pipelines = PIPELINES.map(|path| {
        let pipeline = library.load(root().join("pipelines").join(path));
        pipeline.unwrap_or_else(|error| panic!("{path}: {error}"))
    });
    let mut random = Random(property::seed());
    let mut host = Host::new(&device, &pipelines[0], &scene);
    for step in 0..STEPS * property::times() as usize {
        if step % LIFE == LIFE - 1 {
            host = Host::new(&device, &pipelines[random.below(pipelines.len())], &scene);
        }
        match random.below(4) {
            0 => host.resize(&mut random),
            1 => host.set(&mut random),
            2 => host.frame(&mut random, false),
            _ => {}
        }
        host.frame(&mut random, true);
        let said = std::mem::take(&mut *device.said.lock().unwrap());
        assert!(said.is_empty(), "step {step}: {said:?}");
    }
}
