//! The appearance of scenes on a device, and the draws that are issued.

use serde_json::{Value, json};
use umbragraph_executor::DrawSource;
use umbragraph_scene::gpu::SceneResources;
use umbragraph_scene::{Folder, Scene};
use umbragraph_test_support::gpu::{self, Gpu};

use crate::device::stand_in::{Drawn, draw};
use crate::document::Document;

const NOTHING: [u8; 3] = [0, 0, 0];

fn upload(gpu: &Gpu, scene: &Scene) -> SceneResources {
    SceneResources::new(&gpu.device, &gpu.queue, scene, &scene.rest_pose()).unwrap()
}

fn picture(gpu: &Gpu, document: &Document, filter: &str) -> Drawn {
    draw(gpu, &upload(gpu, &document.load().unwrap()), filter)
}

/// The JSON of a material with a base colour of these red and green factors.
fn color(red: f64, green: f64) -> Value {
    json!({ "pbrMetallicRoughness": { "baseColorFactor": [red, green, 0, 1] } })
}

/// A document with the red triangle (0,0), (1,0), (0,1) in the plane z = 0.
fn red_triangle() -> Document {
    let mut document = Document::triangle();
    document.push("materials", color(1.0, 0.0));
    document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    document
}

#[test]
fn a_triangle_appears_where_it_is_with_its_color_and_its_normal() {
    let Some(gpu) = gpu::device() else { return };
    let drawn = picture(&gpu, &red_triangle(), "opaque");
    assert_eq!(drawn.at(0.25, 0.25), [255, 0, 255]);
    assert_eq!(drawn.at(-0.25, 0.25), NOTHING);
    assert_eq!(drawn.at(0.8, 0.8), NOTHING);
}

#[test]
fn back_faces_are_culled_unless_the_material_has_two_sides() {
    let Some(gpu) = gpu::device() else { return };
    let mut document = red_triangle();
    document.json["nodes"][0]["rotation"] = json!([0, 1, 0, 0]);
    assert_eq!(picture(&gpu, &document, "opaque").at(-0.25, 0.25), NOTHING);
    document.json["materials"][0]["doubleSided"] = json!(true);
    assert_eq!(picture(&gpu, &document, "opaque").at(-0.25, 0.25), [255, 0, 255]);
}

#[test]
fn a_mirroring_node_keeps_fronts_in_front_and_normals_outward() {
    let Some(gpu) = gpu::device() else { return };
    let mut document = red_triangle();
    document.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    let drawn = picture(&gpu, &document, "opaque");
    assert_eq!(drawn.at(-0.25, 0.25), [255, 0, 255]);
    assert_eq!(drawn.at(0.25, 0.25), NOTHING);
}

#[test]
fn draws_out_of_view_are_not_issued() {
    let Some(gpu) = gpu::device() else { return };
    let mut document = red_triangle();
    document.node(json!({ "mesh": 0, "translation": [3, 0, 0] }));
    document.node(json!({ "mesh": 0, "translation": [-1, -1, 0] }));
    let drawn = picture(&gpu, &document, "opaque");
    assert_eq!(drawn.objects, [0, 2]);
    assert_eq!(drawn.at(-0.75, -0.75), [255, 0, 255]);
}

#[test]
fn filters_choose_casters_and_transparent_draws_come_far_first() {
    let Some(gpu) = gpu::device() else { return };
    let mut document = red_triangle();
    document.push("materials", json!({ "alphaMode": "BLEND" }));
    let mut mesh = document.json["meshes"][0].clone();
    mesh["primitives"][0]["material"] = json!(1);
    document.push("meshes", mesh);
    document.node(json!({ "mesh": 0, "extras": { "castShadow": false } }));
    for z in [5, -5, 0] {
        document.node(json!({ "mesh": 1, "translation": [0, 0, z] }));
    }
    let resources = upload(&gpu, &document.load().unwrap());
    let objects = |filter: &str| draw(&gpu, &resources, filter).objects;
    assert_eq!(objects("opaque"), [0, 1]);
    assert_eq!(objects("casters"), [0]);
    assert_eq!(objects("static_casters"), [0]);
    assert_eq!(objects("dynamic_casters"), [0; 0]);
    assert_eq!(objects("transparent"), [3, 4, 2]);
    assert_eq!(objects("all"), [0, 1, 3, 4, 2]);
}

#[test]
fn masked_texels_are_holes_and_textures_are_sampled() {
    let Some(gpu) = gpu::device() else { return };
    let mut document = red_triangle();
    let mut png = Vec::new();
    // Green on the left, a hole on the right.
    let texels =
        image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba([0, 255, 0, if x == 0 { 255 } else { 0 }]));
    texels.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    let view = document.view(&png);
    document.push("images", json!({ "bufferView": view }));
    document.push("samplers", json!({ "magFilter": 9728, "minFilter": 9728 }));
    document.push("textures", json!({ "source": 0, "sampler": 0 }));
    document.json["materials"][0] =
        json!({ "alphaMode": "MASK", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } });
    let texcoords = document.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    document.attribute("TEXCOORD_0", texcoords);
    let drawn = picture(&gpu, &document, "opaque");
    assert_eq!(drawn.at(0.2, 0.2), [0, 255, 255]);
    assert_eq!(drawn.at(0.7, 0.1), NOTHING);
}

#[test]
fn an_update_moves_what_is_animated() {
    let Some(gpu) = gpu::device() else { return };
    let mut document = red_triangle();
    let times = document.floats("SCALAR", &[0.0, 2.0]);
    let moves = document.floats("VEC3", &[0.0, 0.0, 0.0, -2.0, 0.0, 0.0]);
    document.push(
        "animations",
        json!({
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
            "samplers": [{ "input": times, "output": moves }],
        }),
    );
    let scene = document.load().unwrap();
    let mut resources = upload(&gpu, &scene);
    resources.update(&gpu.queue, &scene, &scene.pose(1.0));
    let drawn = draw(&gpu, &resources, "opaque");
    assert_eq!(drawn.at(-0.75, 0.25), [255, 0, 255]);
    assert_eq!(drawn.at(0.25, 0.25), NOTHING);
}

#[test]
fn a_skinned_mesh_is_drawn_where_its_joints_are() {
    let Some(gpu) = gpu::device() else { return };
    let mut document = red_triangle();
    let joints = document.shorts("VEC4", &[0; 12]);
    let weights = document.floats("VEC4", &[1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.]);
    document.attribute("JOINTS_0", joints);
    document.attribute("WEIGHTS_0", weights);
    let joint = document.node(json!({ "translation": [-1, -1, 0] }));
    document.push("skins", json!({ "joints": [joint] }));
    document.json["nodes"][0]["skin"] = json!(0);
    document.json["nodes"][0]["translation"] = json!([50, 0, 0]);
    let drawn = picture(&gpu, &document, "casters");
    assert_eq!(drawn.at(-0.75, -0.75), [255, 0, 255]);
    assert_eq!(drawn.at(0.25, 0.25), NOTHING);
}

/// Asserts for the points of a grid that they are drawn exactly if they lie inside the triangle computed by the CPU.
#[test]
fn a_morphed_mesh_is_drawn_where_the_cpu_puts_its_vertices() {
    let Some(gpu) = gpu::device() else { return };
    let mut document = red_triangle();
    let targets = [[-0.5, -0.5, 0., 0., 0., 0., 0., 0., 0.], [0., 0., 0., 0., 0.75, 0., -1., -0.5, 0.]]
        .map(|moves: [f32; 9]| json!({ "POSITION": document.floats("VEC3", &moves) }));
    document.json["meshes"][0]["primitives"][0]["targets"] = json!(targets);
    let (times, weights) =
        (document.floats("SCALAR", &[0.0, 2.0]), document.floats("SCALAR", &[0.0, 0.0, 1.5, 1.0]));
    document.push(
        "animations",
        json!({
            "samplers": [{ "input": times, "output": weights }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        }),
    );
    let scene = document.load().unwrap();
    let mut resources = upload(&gpu, &scene);
    let mesh = scene.draws().next().unwrap();
    let mut pictures = Vec::new();
    for time in [0.0, 0.5, 1.0, 1.75] {
        let pose = scene.pose(time);
        resources.update(&gpu.queue, &scene, &pose);
        let drawn = draw(&gpu, &resources, "opaque");
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        scene.primitive(mesh).morph(pose.weights(mesh.node), &mut positions, &mut normals);
        let edge = |a: [f32; 3], b: [f32; 3], x: f64, y: f64| {
            let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(f64::from);
            ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / (bx - ax).hypot(by - ay)
        };
        let (mut inside, mut seen) = (0, Vec::new());
        for (x, y) in (0..400).map(|at| (f64::from(at % 20) / 10.0 - 0.95, f64::from(at / 20) / 10.0 - 0.95))
        {
            let [a, b, c] = [0, 1, 2].map(|at| edge(positions[at], positions[(at + 1) % 3], x, y));
            let depth = a.min(b).min(c);
            // What is closer to an edge than a texel may be drawn or not.
            if depth.abs() > 0.06 {
                assert_eq!(drawn.at(x, y) != NOTHING, depth > 0.0, "({x}, {y}) at {time} s, {positions:?}");
                inside += usize::from(depth > 0.0);
            }
            seen.push(drawn.at(x, y));
        }
        assert!(inside > 10 && !pictures.contains(&seen), "{inside} inside at {time} s");
        pictures.push(seen);
    }
}

#[test]
fn a_scene_with_nothing_in_it_uploads_and_draws_nothing() {
    let Some(gpu) = gpu::device() else { return };
    let scene =
        umbragraph_scene::from_slice("empty", br#"{"asset":{"version":"2.0"}}"#, &Folder::new("")).unwrap();
    let resources = upload(&gpu, &scene);
    assert_eq!(draw(&gpu, &resources, "all").objects, [0; 0]);
}

#[test]
fn the_own_scene_uploads_within_default_limits() {
    let Some(gpu) = gpu::device() else { return };
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/courtyard.glb");
    let scene = umbragraph_scene::load(&path).unwrap();
    let resources = upload(&gpu, &scene);
    let interface = resources.interface("scene").unwrap();
    let sets: Vec<Vec<&str>> =
        interface.property_sets.iter().map(|set| interface.property_names(*set)).collect();
    assert_eq!(sets, [vec![], vec!["double_sided"], vec!["alpha_masked", "double_sided"]]);
    assert!(resources.interface("terrain").is_none());
}
