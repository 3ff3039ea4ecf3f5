//! Several views in one frame from one plan: what is kept of the maps of lamps is drawn once for all of them.

use umbragraph::draw::{DrawPass, DrawSource, HostInterface};
use umbragraph::frame::{Camera, Light, LightKind};
use umbragraph::{Executor, Frame, Options};
use umbragraph_test_support::gpu;

use super::meshes::{Meshes, frame, plan};

const SIZE: [u32; 2] = [96, 54];

/// Meshes that stand still between frames.
struct Still<'a>(&'a Meshes);

impl DrawSource for Still<'_> {
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        self.0.interface(geometry)
    }
    fn revision(&self, _: &str) -> Option<u64> {
        Some(0)
    }
    fn material_count(&self) -> u32 {
        self.0.material_count()
    }
    fn material(&self, material: u32, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        self.0.material(material, binding)
    }
    fn object(&self, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        self.0.object(binding)
    }
    fn draw(&self, pass: &mut dyn DrawPass) {
        self.0.draw(pass);
    }
}

#[test]
fn maps_that_do_not_depend_on_the_view_are_drawn_once() {
    let Some(gpu) = gpu::device() else { return };
    let options = Options::new(SIZE[0], SIZE[1]).set("cascade_side", 256).set("cube_side", 128);
    let aspect = f64::from(SIZE[0]) / f64::from(SIZE[1]);
    let cameras = [[9.0, 7.0, 11.0], [-9.0, 7.0, 11.0], [9.0, 7.0, -11.0]]
        .map(|eye| Camera::look_at(eye, [0.0, 0.5, 0.0], 0.8, aspect));
    let inputs = cameras.map(|camera| {
        let lamp = Light::point("lamp", [1.0, 4.0, 0.5], [1.0, 0.9, 0.8], 60.0);
        let spot = Light::new("spot", LightKind::Spot { inner_angle: 0.4, outer_angle: 0.6 });
        let spot = spot.position([-2.0, 5.0, 1.0]).color([1.0, 0.9, 0.8]).intensity(60.0);
        let lights = [lamp, spot].map(|light| light.property("cast_shadow"));
        frame(SIZE).camera(camera).lights(lights.into())
    });
    let meshes = Meshes::new(&gpu, false);
    let source = Still(&meshes);
    // How many draws each view of a frame takes, and the pictures.
    let run = |options: &Options| {
        let plan = plan(false, options);
        let targets = [(); 3].map(|()| crate::common::gpu::import(&gpu, &plan, "target"));
        let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, Some(&source)).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut draws = Vec::new();
        for (input, target) in inputs.iter().zip(&targets) {
            executor
                .record(&mut encoder, &Frame::new(input).draws(&source).imports(&[("target", target)]))
                .unwrap_or_else(|error| panic!("{error}"));
            draws.push(
                executor
                    .pass_counts()
                    .filter(|(name, _)| *name != "shade")
                    .map(|(_, counts)| counts.draws)
                    .sum::<u64>(),
            );
        }
        gpu.queue.submit([encoder.finish()]);
        (draws, targets.map(|target| crate::common::gpu::read(&gpu, &target)))
    };
    let (all, wanted) = run(&options);
    let (kept, found) = run(&options.clone().feature("cached", true));
    println!("draws of casters in three views: {all:?}, with maps that are kept {kept:?}");
    for (wanted, found) in wanted.iter().zip(&found) {
        assert_eq!(wanted.differing(found, 0), 0);
    }
    assert!(kept[0] > 0 && kept[1..].iter().all(|draws| *draws == 0), "{kept:?}");
    assert!(all.iter().all(|draws| *draws > 0), "{all:?}");
}
