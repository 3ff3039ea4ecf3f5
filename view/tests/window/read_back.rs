//! Numbers of the inspector against a read-back of the same frame by the module alone.

use std::collections::BTreeSet;
use std::path::Path;

use umbragraph::data::View;
use umbragraph::executor::{Texels, imported_texture, read_back, read_bytes};
use umbragraph::frame::{Light, LightKind};
use umbragraph::glam::DVec3;
use umbragraph::low_level::capture::{Capture, Wanted, document};
use umbragraph::scene::gpu::SceneResources;
use umbragraph::{Executor, Frame, Library, Options, wgpu};

use crate::{PIPELINE, start};

/// The size and the RGB pixels of a PNG file.
pub(crate) fn pixels(path: &Path) -> ([u32; 2], Vec<[u8; 3]>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let channels = reader.info().color_type.samples();
    let pixels = bytes.chunks_exact(channels).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    ([reader.info().width, reader.info().height], pixels)
}

/// The number of different colours in a PNG file.
pub(crate) fn colors(path: &Path) -> usize {
    pixels(path).1.into_iter().collect::<BTreeSet<_>>().len()
}

#[test]
fn numbers_of_the_inspector_are_those_of_a_read_back() {
    let Some(mut hand) = start("read_back", &["--scale", "0.25"]) else { return };
    hand.settle();
    hand.type_into("search graph");
    hand.display.write("color");
    hand.click("resource color");
    hand.wait("contents", |state| state["contents"]["of"][0] == "color@sky");
    hand.settle();
    let at = hand.point("contents", [0.37, 0.61]);
    hand.move_to(at);
    let state = hand.wait("value", |state| state["contents"]["cursor"].is_array() && state["busy"] == false);
    let contents = &state["contents"];
    let size: [u32; 2] = serde_json::from_value(state["size"].clone()).unwrap();
    let fresh = Fresh::new();
    // The camera of the window has not been moved, so that it is the scene's own.
    let own = fresh.scene.frame_input_of(&fresh.scene.pose(0.0), 1.0, 0.0).camera.position;
    let shown: [f64; 3] = serde_json::from_value(state["camera"]["position"].clone()).unwrap();
    assert!(own.distance(DVec3::from(shown)) < 1e-3);
    let texels = captured(&fresh, PIPELINE, size, "color@sky");
    assert_eq!(contents["size"], serde_json::json!([texels.width, texels.height, texels.layers]));
    let channels = contents["channels"].as_array().unwrap();
    assert_eq!(channels.len(), texels.channels);
    for (at, channel) in channels.iter().enumerate() {
        // As naive as can be: sorted, and counted bar by bar.
        let mut values: Vec<f32> =
            texels.values.iter().map(|value| value[at]).filter(|one| one.is_finite()).collect();
        values.sort_unstable_by(f32::total_cmp);
        let (min, max) = (values[0], values[values.len() - 1]);
        assert_eq!(channel["not_finite"], texels.values.len() - values.len());
        let bars: Vec<u64> =
            channel["bars"].as_array().unwrap().iter().map(|bar| bar.as_u64().unwrap()).collect();
        let mut expected = vec![0_u64; bars.len()];
        for value in &values {
            let part = (f64::from(*value) - f64::from(min)) / (f64::from(max) - f64::from(min));
            let bar = if max > min { (part * bars.len() as f64) as usize } else { 0 };
            expected[bar.min(bars.len() - 1)] += 1;
        }
        assert_eq!(
            serde_json::from_value::<[f32; 2]>(serde_json::json!([channel["min"], channel["max"]])).unwrap(),
            [min, max]
        );
        assert_eq!(bars, expected, "channel {at}");
    }
    let ([x, y], value): ([u32; 2], [f32; 4]) = serde_json::from_value(contents["cursor"].clone()).unwrap();
    assert_eq!(value, texels.values[(y * texels.width + x) as usize], "({x}, {y})");
}

/// The captured texture of a frame of a pipeline, drawn without a window.
pub(crate) fn captured(fresh: &Fresh, text: &str, size: [u32; 2], reference: &str) -> Texels {
    let plan = Library::new().load_text("own.json", text).unwrap();
    let plan = plan.plan(&Options::new(size[0], size[1])).unwrap();
    let captures = [Capture { reference: reference.to_owned(), mip: 0 }];
    let document = document(&plan, &captures, Wanted::Pictures).unwrap();
    // The same copies, written into the pipeline itself.
    let more: serde_json::Value = serde_json::from_str(&document.text).unwrap();
    let [subgraphs, passes] = ["subgraphs", "passes"].map(|section| more[section].to_string());
    let text = match text.contains("\"passes\": {") {
        true => text.replace(
            "\"passes\": {",
            &format!("\"subgraphs\": {subgraphs},\n\"passes\": {{ {},", &passes[1..passes.len() - 1]),
        ),
        false => text.replacen('{', &format!("{{ \"subgraphs\": {subgraphs}, \"passes\": {passes},"), 1),
    };
    let pipeline = Library::new().load_text("own.json", &text).unwrap();
    let texture = fresh.draw(&pipeline, size, &document.imports[0]);
    pollster::block_on(read_back(&fresh.device, &fresh.queue, &texture)).unwrap()
}

/// A device and a scene, to draw reference frames without a window.
pub(crate) struct Fresh {
    device: wgpu::Device,
    queue: wgpu::Queue,
    scene: umbragraph::scene::Scene,
}

impl Fresh {
    pub(crate) fn new() -> Self {
        Self::of(&crate::hand::module().join("examples/scenes/courtyard.glb"))
    }

    pub(crate) fn of(scene: &Path) -> Self {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle().with_env());
        let adapter = pollster::block_on(instance.request_adapter(&Default::default())).expect("an adapter");
        let descriptor = wgpu::DeviceDescriptor {
            required_features: adapter.features() & wgpu::Features::all_webgpu_mask(),
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("a device");
        Self { device, queue, scene: umbragraph::scene::load(scene).unwrap() }
    }

    /// The name of the spot that is nearest to a place.
    pub(crate) fn nearest_spot(&self, place: DVec3) -> String {
        let input = self.scene.frame_input_of(&self.scene.pose(0.0), 1.0, 0.0);
        let spots = input.lights.iter().filter(|light| matches!(light.kind, LightKind::Spot { .. }));
        let distance = |light: &&Light| light.position.distance(place);
        spots.min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a spot").name.to_string()
    }

    /// The views that a CPU pass publishes in the first frame of a pipeline, by the name of their data.
    pub(crate) fn views(&self, pipeline: &umbragraph::Pipeline, size: [u32; 2], name: &str) -> Vec<View> {
        self.frame(pipeline, size, |executor, _| executor.data(name).expect("data").views().to_vec())
    }

    /// Draws the first frame of a pipeline, and returns the import `wanted`.
    fn draw(&self, pipeline: &umbragraph::Pipeline, size: [u32; 2], wanted: &str) -> wgpu::Texture {
        self.frame(pipeline, size, |_, textures| {
            textures.iter().find(|(name, _)| name == wanted).expect("the texture").1.clone()
        })
    }

    /// Draws the first frame of a pipeline, and asks for what is left of it.
    fn frame<T>(
        &self,
        pipeline: &umbragraph::Pipeline,
        [width, height]: [u32; 2],
        left: impl FnOnce(&Executor, &[(String, wgpu::Texture)]) -> T,
    ) -> T {
        let Self { device, queue, scene } = self;
        let plan = pipeline.plan(&Options::new(width, height)).unwrap();
        let pose = scene.pose(0.0);
        let meshes = SceneResources::new(device, queue, scene, &pose).unwrap();
        let more = wgpu::TextureUsages::COPY_SRC;
        let textures: Vec<_> = plan
            .imports()
            .filter_map(|(name, _)| Some((name.to_owned(), imported_texture(device, &plan, name, more)?)))
            .collect();
        let imports: Vec<_> = textures.iter().map(|(name, texture)| (name.as_str(), texture)).collect();
        let mut input = scene.frame_input_of(&pose, f64::from(width) / f64::from(height), 0.0);
        input.index = 0;
        let mut executor = Executor::new(device, queue, plan.clone(), Some(&meshes)).unwrap();
        let mut encoder = device.create_command_encoder(&Default::default());
        executor.record(&mut encoder, &Frame::new(&input).draws(&meshes).imports(&imports)).unwrap();
        queue.submit([encoder.finish()]);
        left(&executor, &textures)
    }

    /// The RGB pixels of the first frame of a pipeline, drawn without a window.
    pub(crate) fn picture(&self, library: &Library, path: &Path, size: [u32; 2]) -> Vec<[u8; 3]> {
        let texture = self.draw(&library.load(path).unwrap(), size, "target");
        let bytes = pollster::block_on(read_bytes(&self.device, &self.queue, &texture)).unwrap();
        bytes.chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2]]).collect()
    }
}
