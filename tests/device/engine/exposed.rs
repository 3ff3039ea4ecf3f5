//! Resources that the host looks at between frames.

use umbragraph::executor::read_back;
use umbragraph::{Executor, Frame, Library, Options};
use umbragraph_test_support::gpu;

use super::meshes::{Meshes, frame, plan};

const SIZE: [u32; 2] = [64, 36];

#[test]
fn an_exposed_map_is_what_the_frame_left_and_costs_its_memory() {
    let Some(gpu) = gpu::device() else { return };
    let options = Options::new(SIZE[0], SIZE[1]).set("cascade_side", 256);
    let bytes = |options: &Options| -> u64 {
        let plan = plan(false, options);
        plan.textures.iter().map(|texture| texture.bytes).sum()
    };
    let exposed = options.clone().expose("layers").expose("color");
    assert!(bytes(&exposed) >= bytes(&options));
    let plan = plan(false, &exposed);
    let meshes = Meshes::new(&gpu, false);
    let target = crate::common::gpu::import(&gpu, &plan, "target");
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, Some(&meshes)).unwrap();
    let input = frame(SIZE);
    let mut seen = Vec::new();
    for _ in 0..2 {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor
            .record(&mut encoder, &Frame::new(&input).draws(&meshes).imports(&[("target", &target)]))
            .unwrap_or_else(|error| panic!("{error}"));
        gpu.queue.submit([encoder.finish()]);
        let texture = executor.texture("layers").expect("the map");
        assert!(
            texture.usage().contains(wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING)
        );
        let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, texture)).unwrap();
        let near = texels.values.iter().filter(|depth| depth[0] > 0.0 && depth[0] < 1.0).count();
        assert!(near > 1000, "{near} texels with casters in them");
        seen.push(texels);
    }
    assert!(seen[0] == seen[1]);
    let color = pollster::block_on(executor.read("color")).unwrap_or_else(|error| panic!("{error}"));
    assert!(color.values.iter().any(|color| color[0] > 0.2));
    // What cannot be read says how it could.
    let cannot = |name: &str| pollster::block_on(executor.read(name)).unwrap_err().to_string();
    for (name, why, way) in [
        ("depth", "\"depth\" is not exposed", "Options::expose"),
        ("target", "\"target\" is the application's own", "read_back"),
        ("colour", "no texture \"colour\"", "did you mean \"color\"?"),
    ] {
        let error = cannot(name);
        assert!(error.contains(why) && error.contains(way), "{error}");
    }
    let depth = executor.texture("depth").unwrap();
    let error = pollster::block_on(read_back(&gpu.device, &gpu.queue, depth)).unwrap_err();
    assert!(error.message.contains("without the usage TextureUsages(COPY_SRC)"), "{error:?}");
}

#[test]
fn the_pipeline_can_expose_too_and_a_bad_name_is_an_error() {
    let text = |exposed: &str| {
        format!(
            r#"{{ "format": 1, "name": "two",
              "resources": {{
                "a": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport"{exposed} }} }},
                "b": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }},
                "c": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }},
                "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}
              }},
              "passes": {{
                "one": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&a" }}] }} }},
                "two": {{ "fullscreen": {{ "shader": "resample.wgsl.jinja", "bind": {{ "source": "&a" }}, "color": [{{ "to": "&b" }}] }} }},
                "three": {{ "fullscreen": {{ "shader": "resample.wgsl.jinja", "bind": {{ "source": "&b" }}, "color": [{{ "to": "&c" }}] }} }},
                "four": {{ "fullscreen": {{ "shader": "resample.wgsl.jinja", "bind": {{ "source": "&c" }}, "color": [{{ "to": "&target" }}] }} }}
              }} }}"#
        )
    };
    let library = Library::new();
    let textures = |text: &str, options: &Options| {
        let plan = library.load_text("two.json", text).unwrap().plan(options);
        plan.unwrap_or_else(|error| panic!("{error}")).textures.len()
    };
    let options = Options::new(16, 16);
    // "a" and "c" share one without it.
    assert_eq!(textures(&text(""), &options), 2);
    assert_eq!(textures(&text(", \"exposed\": true"), &options), 3);
    assert_eq!(textures(&text(""), &options.clone().expose("a")), 3);
    let pipeline = library.load_text("two.json", &text("")).unwrap();
    let error = pipeline.plan(&options.expose("tarte")).expect_err("no such resource");
    assert!(error.to_string().contains("no resource \"tarte\" to expose"), "{error}");
}
