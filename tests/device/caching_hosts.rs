//! Cached shadow maps as hosts meet them: casters that come to rest and set out again, and what a record allocates.

use crate::common::gpu::{executor, import, read, scene};
use crate::common::{Outcome, With, check_file, root};
use allocation_counter::measure;
use umbragraph::Frame;
use umbragraph::data::View;
use umbragraph::draw::{DrawPass, DrawSource, HostInterface, PropertySet};
use umbragraph::scene::gpu::SceneResources;
use umbragraph::work::DrawOrder;
use umbragraph_test_support::gpu;

/// A host whose movers are static casters while they rest.
struct Resting<'a> {
    scene: &'a SceneResources,
    rests: bool,
    /// Whether what stays where it is is away.
    is_bare: bool,
    /// Counts up when they come to rest or set out.
    changes: u64,
    /// Counts up when what stays where it is vanishes or appears.
    static_changes: u64,
}

/// A pass with another filter.
struct Renamed<'a> {
    pass: &'a mut dyn DrawPass,
    filter: &'a str,
}

impl DrawPass for Renamed<'_> {
    fn geometry(&self) -> &str {
        self.pass.geometry()
    }
    fn filter(&self) -> &str {
        self.filter
    }
    fn view(&self) -> &View {
        self.pass.view()
    }
    fn order(&self) -> DrawOrder {
        self.pass.order()
    }
    fn detail(&self) -> u32 {
        self.pass.detail()
    }
    fn set_properties(&mut self, properties: PropertySet) -> bool {
        self.pass.set_properties(properties)
    }
    fn set_material(&mut self, material: u32) {
        self.pass.set_material(material);
    }
    fn set_object(&mut self, object: u32) {
        self.pass.set_object(object);
    }
    fn render_pass(&mut self) -> &mut wgpu::RenderPass<'static> {
        self.pass.render_pass()
    }
}

impl DrawSource for Resting<'_> {
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        self.scene.interface(geometry)
    }
    fn revision(&self, filter: &str) -> Option<u64> {
        let moves = self.scene.revision(filter)?;
        Some(if filter == "static_casters" {
            self.changes + self.static_changes
        } else {
            self.changes + moves
        })
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
    fn draw(&self, pass: &mut dyn DrawPass) {
        match pass.filter() {
            "static_casters" if self.is_bare => {}
            "casters" if self.is_bare => self.scene.draw(&mut Renamed { pass, filter: "dynamic_casters" }),
            "static_casters" if self.rests => self.scene.draw(&mut Renamed { pass, filter: "casters" }),
            "dynamic_casters" if self.rests => {}
            _ => self.scene.draw(pass),
        }
    }
}

fn outcome(cached: &str) -> Outcome {
    let parameters = [("far", "[4, 10, 40]"), ("resolution", "128"), ("fit", "\"sphere\"")];
    let features = [("cached", cached)];
    let with = With { parameters: &parameters, features: &features, size: Some([96, 64]), ..With::default() };
    check_file("pipelines/nebula.json", &with)
}

#[test]
fn casters_that_rest_and_move_again_are_seen_in_place() {
    let Some(gpu) = gpu::device() else { return };
    let figure = scene(&root().join("examples/scenes/figure.glb"));
    let mut resources =
        SceneResources::new(&gpu.device, &gpu.queue, &figure, &figure.pose(0.0)).expect("a scene that fits");
    let outcomes = ["false", "true"].map(outcome);
    let mut hosts = outcomes.each_ref().map(|outcome| {
        (executor(&gpu, outcome.plan(), Some(&resources)), import(&gpu, outcome.plan(), "target"))
    });
    let (mut rested, mut changes, mut shown) = (false, 0, Vec::new());
    let (mut was_bare, mut static_changes) = (false, 0);
    for at in 0..36_u32 {
        // Four frames of motion, five of rest.
        let rests = at % 9 >= 4;
        let time = f64::from((at / 9 * 4 + (at % 9).min(4)).min(9)) / 10.0;
        changes += u64::from(rests != rested);
        rested = rests;
        // At last what moves holds still, and the rest vanishes and comes back.
        let is_bare = at >= 18 && at % 9 < 4 && at % 2 == 1;
        static_changes += u64::from(is_bare != was_bare);
        was_bare = is_bare;
        let pose = figure.pose(time);
        resources.update(&gpu.queue, &figure, &pose);
        let mut input = figure.frame_input(1.5, time).index(u64::from(at));
        if rests {
            // Nothing moves, and everything may be among what rests.
            input.filter_bounds.retain(|(filter, _)| filter == "casters");
        }
        let source = Resting { scene: &resources, rests, is_bare, changes, static_changes };
        let pictures = hosts.each_mut().map(|(executor, target)| {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let imports = [("target", &*target)];
            let frame = Frame::new(&input).draws(&source).imports(&imports);
            executor.record(&mut encoder, &frame).expect("a record");
            gpu.queue.submit([encoder.finish()]);
            read(&gpu, target).rgba_pixels().collect::<Vec<_>>()
        });
        assert!(pictures[0] == pictures[1], "frame {at}");
        let [picture, _] = pictures;
        shown.push(picture);
        let drawn: u64 = hosts[1]
            .0
            .pass_counts()
            .filter(|(name, _)| name.contains("cached"))
            .map(|(_, counts)| counts.draws)
            .sum();
        assert!(at >= 18 || (drawn > 0) == (at % 9 <= 4), "frame {at}: {drawn} draws");
    }
    shown.dedup();
    assert!(shown.len() > 6, "{} pictures", shown.len());
}

#[test]
fn kept_maps_add_no_allocation_to_a_steady_record() {
    let Some(gpu) = gpu::device() else { return };
    let figure = scene(&root().join("examples/scenes/figure.glb"));
    let resources =
        SceneResources::new(&gpu.device, &gpu.queue, &figure, &figure.pose(0.0)).expect("a scene that fits");
    let input = figure.frame_input(1.5, 0.0);
    let counts = ["false", "true"].map(|cached| {
        let outcome = outcome(cached);
        let mut executor = executor(&gpu, outcome.plan(), Some(&resources));
        let target = import(&gpu, outcome.plan(), "target");
        let mut counts = Vec::new();
        for round in 0..12 {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let imports = [("target", &target)];
            let frame = Frame::new(&input).draws(&resources).imports(&imports);
            let counted = measure(|| executor.record(&mut encoder, &frame).expect("a record"));
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
            if round >= 8 {
                counts.push(counted.count_total);
            }
        }
        counts
    });
    println!("allocations of a record without kept maps, and with: {counts:?}");
    let [without, with] = counts.map(|counts| counts.into_iter().max().unwrap_or_default());
    assert!(without > 0 && with <= without, "{with} with kept maps, {without} without");
}
