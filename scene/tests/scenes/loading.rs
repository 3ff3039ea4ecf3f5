//! Scenes loaded from valid documents.

use crate::document::{Document, line};
use glam::{DVec3, Vec3};
use serde_json::json;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};
use umbragraph_pipeline::compose::Roots;
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::frame::{LightKind, Projection};
use umbragraph_pipeline::wgpu_types::{AddressMode, FilterMode, MipmapFilterMode};
use umbragraph_scene::material::AlphaMode;
use umbragraph_scene::{Folder, NoFiles, Scene, from_slice};

fn close(a: DVec3, b: DVec3) -> bool {
    a.abs_diff_eq(b, 1e-6)
}

#[test]
fn a_bare_triangle_gets_flat_normals_and_indices() {
    let scene = Document::triangle().load().unwrap();
    let draw = scene.draws().next().unwrap();
    let primitive = scene.primitive(draw);
    assert_eq!(primitive.indices, [0, 1, 2]);
    assert_eq!(primitive.normals, [[0.0, 0.0, 1.0]; 3]);
    assert_eq!(primitive.texcoords, [[0.0; 2]; 3]);
    assert!(draw.cast_shadow && draw.receive_shadow && !draw.dynamic);
    assert_eq!(scene.material(draw).base_color, [1.0; 4]);
    assert!(scene.warnings.is_empty());
}

#[test]
fn missing_normals_are_flat_also_where_triangles_share_vertices() {
    let mut document = Document::new();
    // A ridge: two triangles that share an edge, facing different ways.
    let positions = document.floats("VEC3", &[-1., 0., 0., 0., 1., 1., 0., 1., -1., 1., 0., 0.]);
    let indices = document.shorts("SCALAR", &[0, 1, 2, 2, 1, 3]);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    document.push("meshes", json!({ "primitives": [primitive] }));
    document.node(json!({ "mesh": 0 }));
    let scene = document.load().unwrap();
    let primitive = scene.primitive(scene.draws().next().unwrap());
    assert_eq!((primitive.positions.len(), primitive.indices.len()), (6, 6));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert!(Vec3::from_array(primitive.normals[0]).abs_diff_eq(Vec3::new(-half, half, 0.0), 1e-6));
    assert!(Vec3::from_array(primitive.normals[3]).abs_diff_eq(Vec3::new(half, half, 0.0), 1e-6));
}

#[test]
fn strips_keep_their_winding_and_points_are_a_warning() {
    let mut document = Document::triangle();
    let quad = document.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0.]);
    let primitives = json!([
        { "attributes": { "POSITION": quad }, "mode": 5 },
        { "attributes": { "POSITION": quad }, "mode": 0 },
    ]);
    document.json["meshes"][0]["primitives"] = primitives;
    let scene = document.load().unwrap();
    assert_eq!(scene.draws().len(), 1);
    let primitive = scene.primitive(scene.draws().next().unwrap());
    assert_eq!(primitive.normals, [[0.0, 0.0, 1.0]; 6]);
    let warnings: Vec<String> = scene.warnings.iter().map(line).collect();
    assert_eq!(
        warnings,
        ["UG0722 /meshes/0/primitives/1: points and lines are not drawn (make thin triangles of them)"]
    );
}

#[test]
fn transforms_multiply_along_the_hierarchy_in_f64() {
    let mut document = Document::triangle();
    document.json["nodes"][0]["translation"] = json!([0, 1, 0]);
    let parent = document.push("nodes", json!({
        "children": [0], "translation": [1000000, 0, 0], "rotation": [0, FRAC_1_SQRT_2, 0, FRAC_1_SQRT_2], "scale": [2, 2, 2],
    }));
    document.json["scenes"][0]["nodes"] = json!([parent]);
    let scene = document.load().unwrap();
    let draw = scene.draws().next().unwrap();
    let world = scene.rest_pose().world(draw.node);
    assert!(close(world.transform_point3(DVec3::new(0.25, 0.0, 0.0)), DVec3::new(1e6, 2.0, -0.5)));
    let bounds = scene.bounds(&scene.rest_pose());
    assert!(close(bounds.min, DVec3::new(1e6, 2.0, -2.0)), "{bounds:?}");
    assert!(close(bounds.max, DVec3::new(1e6, 4.0, 0.0)), "{bounds:?}");
}

#[test]
fn only_the_default_scene_is_drawn() {
    let mut document = Document::triangle();
    document.push("nodes", json!({ "mesh": 0, "translation": [5, 0, 0] }));
    document.push("scenes", json!({ "nodes": [1] }));
    document.json["scene"] = json!(1);
    let scene = document.load().unwrap();
    assert_eq!(scene.draws().map(|draw| draw.node.index()).collect::<Vec<_>>(), [1]);
}

#[test]
fn shadow_switches_of_node_mesh_and_material_are_combined() {
    for place in ["node", "mesh", "material"] {
        let mut document = Document::triangle();
        document.push("materials", json!({}));
        document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let list = match place {
            "node" => "nodes",
            "mesh" => "meshes",
            _ => "materials",
        };
        document.json[list][0]["extras"] = json!({ "castShadow": false, "note": "free text" });
        let scene = document.load().unwrap();
        let draw = scene.draws().next().unwrap();
        assert!(!draw.cast_shadow && draw.receive_shadow, "{place}");
        assert!(scene.frame_input(1.0, 0.0).bounds_of("casters").is_empty());
        assert!(!scene.bounds(&scene.rest_pose()).is_empty());
        document.json[list][0]["extras"] = json!({ "receiveShadow": false });
        let scene = document.load().unwrap();
        let draw = scene.draws().next().unwrap();
        assert!(draw.cast_shadow && !draw.receive_shadow, "{place}");
    }
}

#[test]
fn materials_are_read_and_unused_images_are_not_decoded() {
    let mut document = Document::triangle();
    let mut png = Vec::new();
    let texels = image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba([x as u8 * 200, 10, 20, 128]));
    texels.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    let view = document.view(&png);
    document.push("images", json!({ "uri": "missing-but-unused.png" }));
    document.push("images", json!({ "bufferView": view, "mimeType": "image/png", "name": "two texels" }));
    document
        .push("samplers", json!({ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9985 }));
    document.push("textures", json!({ "source": 0 }));
    document.push("textures", json!({ "source": 1, "sampler": 0 }));
    document.push("materials", json!({
        "name": "leaf", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25, "emissiveFactor": [0, 0.5, 0],
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.6, 0.7, 1], "baseColorTexture": { "index": 1, "texCoord": 1 } },
    }));
    document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let texcoords = document.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    document.attribute("TEXCOORD_1", texcoords);
    let scene = document.load().unwrap();
    let draw = scene.draws().next().unwrap();
    let material = scene.material(draw);
    assert_eq!(material.name, "leaf");
    assert_eq!(material.base_color, [0.5, 0.6, 0.7, 1.0]);
    assert_eq!(material.emissive, [0.0, 0.5, 0.0]);
    assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.25 });
    assert!(material.double_sided && scene.is_alpha_masked(draw));
    let texture = scene.textures[material.base_color_map.unwrap().texture];
    assert_eq!(
        (texture.sampler.wrap_u, texture.sampler.wrap_v),
        (AddressMode::ClampToEdge, AddressMode::MirrorRepeat)
    );
    assert_eq!((texture.sampler.magnify, texture.sampler.minify), (FilterMode::Nearest, FilterMode::Linear));
    assert_eq!(texture.sampler.mipmap, Some(MipmapFilterMode::Nearest));
    let image = &scene.images[texture.image];
    assert_eq!((image.width, image.height, scene.images.len()), (2, 1, 1));
    assert_eq!(image.rgba, [0, 10, 20, 128, 200, 10, 20, 128]);
    assert_eq!(scene.primitive(draw).texcoords[1], [1.0, 0.0], "the set that the texture names");
}

#[test]
fn normalized_integers_and_sparse_accessors_are_decoded() {
    let mut document = Document::triangle();
    let texcoords = document.shorts("SCALAR", &[0, 0, 65535, 0, 0, 32768]);
    document.json["accessors"][texcoords]["type"] = json!("VEC2");
    document.json["accessors"][texcoords]["count"] = json!(3);
    document.json["accessors"][texcoords]["normalized"] = json!(true);
    document.attribute("TEXCOORD_0", texcoords);
    let (indices, values) = (document.view(&[1]), document.view(&[0, 0, 0, 64, 0, 0, 0, 0, 0, 0, 0, 0]));
    document.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": indices, "componentType": 5121 }, "values": { "bufferView": values },
    });
    let scene = document.load().unwrap();
    let primitive = scene.primitive(scene.draws().next().unwrap());
    assert_eq!(primitive.texcoords[1], [1.0, 0.0]);
    assert!((primitive.texcoords[2][1] - 0.5).abs() < 1e-4);
    assert_eq!(primitive.positions[1], [2.0, 0.0, 0.0]);
    assert_eq!(primitive.positions[2], [0.0, 1.0, 0.0]);
}

#[test]
fn all_three_kinds_of_light_are_placed_by_their_nodes() {
    let mut document = Document::triangle();
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = json!([
        { "type": "directional", "name": "sun", "color": [1, 0.5, 0], "intensity": 3, "extras": { "angular_diameter_deg": 4 } },
        { "type": "spot", "range": 9, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.6 } },
        { "type": "point", "intensity": 60, "extras": { "radius": 0.15, "castShadow": true } },
    ]);
    let light = |index: usize| json!({ "KHR_lights_punctual": { "light": index } });
    let down = json!([-FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2]);
    document.node(json!({ "extensions": light(0), "rotation": down, "scale": [2, 3, 4] }));
    document
        .node(json!({ "extensions": light(1), "rotation": down, "translation": [0, 5, 0], "name": "lamp" }));
    document
        .node(json!({ "extensions": light(2), "translation": [1, 2, 3], "extras": { "castShadow": false } }));
    let lights = document.load().unwrap().frame_input(1.0, 0.0).lights;
    assert!(lights.iter().all(|light| light.check().is_none()));
    assert_eq!(lights.iter().map(|light| &*light.name).collect::<Vec<_>>(), ["sun", "lamp", "light 2"]);
    assert_eq!(lights[0].kind, LightKind::Directional);
    assert!(close(lights[0].direction, DVec3::NEG_Y));
    assert_eq!((lights[0].intensity, lights[0].angular_diameter), (3.0, 4_f32.to_radians()));
    assert_eq!(lights[0].color, Vec3::new(1.0, 0.5, 0.0));
    assert_eq!(lights[1].kind, LightKind::Spot { inner_angle: 0.2, outer_angle: 0.6 });
    assert!(close(lights[1].position, DVec3::new(0.0, 5.0, 0.0)) && close(lights[1].direction, DVec3::NEG_Y));
    assert_eq!((lights[1].range, lights[2].range), (9.0, f32::INFINITY));
    assert_eq!(
        (lights[2].kind, lights[2].radius, lights[2].has("cast_shadow")),
        (LightKind::Point, 0.15, false)
    );
    assert!(close(lights[2].position, DVec3::new(1.0, 2.0, 3.0)));
}

#[test]
fn extras_of_lights_give_their_size_and_shadows() {
    let mut document = Document::triangle();
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = json!([
        { "type": "directional", "extras": { "angular_diameter_deg": 0, "radius": 0.5 } },
        // The sun is never more than the sky.
        { "type": "directional", "extras": { "angular_diameter_deg": 3e38 } },
        { "type": "point", "extras": { "radius": 0, "shadowHardness": "hard", "contactShadow": false } },
        { "type": "point", "extras": { "radius": 3e38, "shadowHardness": "soft", "priority": 7 } },
        { "type": "point", "extras": { "shadowHardness": "pcss", "contactShadow": true } },
        { "type": "point" },
    ]);
    for light in 0..6 {
        let extras = if light == 5 { json!({ "radius": 0.25, "contactShadow": false }) } else { json!({}) };
        document
            .node(json!({ "extensions": { "KHR_lights_punctual": { "light": light } }, "extras": extras }));
    }
    let lights = document.load().unwrap().frame_input(1.0, 0.0).lights;
    assert!(lights.iter().all(|light| light.check().is_none()));
    let sizes: Vec<_> = lights.iter().map(|light| [light.angular_diameter, light.radius]).collect();
    let half_turn = std::f32::consts::PI;
    assert_eq!(sizes, [[0.0, 0.5], [half_turn, 0.0], [0.0, 0.0], [0.0, 3e38], [0.0, 0.0], [0.0, 0.25]]);
    let words = ["contact_shadow", "hard_shadow", "soft_shadow", "pcss_shadow"];
    let said: Vec<_> = lights.iter().map(|light| words.map(|word| light.has(word))).collect();
    let (yes, no) = (true, false);
    assert_eq!(
        said,
        [
            [yes, no, no, no],
            [yes, no, no, no],
            [no, yes, no, no],
            [yes, no, yes, no],
            [yes, no, no, yes],
            [no, no, no, no],
        ]
    );
    assert_eq!(lights[3].priority, 7.0);
}

#[test]
fn a_camera_takes_its_node_s_place_and_the_picture_s_aspect() {
    let mut document = Document::triangle();
    document.push("cameras", json!({
        "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.05, "zfar": 30, "aspectRatio": 9 },
    }));
    document.push(
        "cameras",
        json!({
            "type": "orthographic", "orthographic": { "xmag": 4, "ymag": 3, "znear": 0, "zfar": 10 },
        }),
    );
    let quarter = json!([0, FRAC_1_SQRT_2, 0, FRAC_1_SQRT_2]);
    document.node(json!({ "camera": 0, "translation": [4, 1, 0], "rotation": quarter }));
    document.node(json!({ "camera": 1 }));
    let mut scene = document.load().unwrap();
    let camera = scene.frame_input(1.5, 0.0).camera;
    assert_eq!(camera.check(), None);
    assert_eq!(camera.aspect, 1.5);
    assert_eq!(camera.position, DVec3::new(4.0, 1.0, 0.0));
    assert!(close(camera.forward(), DVec3::NEG_X));
    let far = f64::from(30.0_f32);
    assert_eq!(
        camera.projection,
        Projection::Perspective { vertical_fov: f64::from(0.7_f32), near: f64::from(0.05_f32), far }
    );
    scene.cameras.remove(0);
    let camera = scene.frame_input(1.5, 0.0).camera;
    assert_eq!(camera.check(), None);
    assert_eq!(camera.projection, Projection::Orthographic { half_height: 3.0, near: 0.0, far: 10.0 });
}

#[test]
fn a_scene_without_camera_and_light_gets_both() {
    let frame = Document::triangle().load().unwrap().frame_input(2.0, 0.0);
    assert_eq!(frame.camera.check(), None);
    let clip = frame.camera.clip(false) * frame.camera.view();
    for corner in frame.scene_bounds.corners() {
        let seen = clip.project_point3(corner);
        assert!(
            seen.x.abs() <= 1.0 && seen.y.abs() <= 1.0 && (0.0..=1.0).contains(&seen.z),
            "{corner} at {seen}"
        );
    }
    assert_eq!(frame.lights.len(), 1);
    assert_eq!((&*frame.lights[0].name, frame.lights[0].kind), ("sun", LightKind::Directional));
    assert_eq!(frame.lights[0].check(), None);
}

#[test]
fn an_empty_document_is_a_warning_and_has_a_usable_frame() {
    let document = serde_json::to_vec(&json!({ "asset": { "version": "2.0" } })).unwrap();
    let scene = from_slice("test.glb", &document, &NoFiles).unwrap();
    let warnings: Vec<String> = scene.warnings.iter().map(line).collect();
    assert_eq!(
        warnings,
        [
            "UG0723 : the scene has no triangles (check which scene the document shows by default, and that its nodes have meshes)"
        ]
    );
    let frame = scene.frame_input(1.0, f64::NAN);
    assert_eq!(frame.camera.check(), None);
    assert!(frame.bounds_of("casters").is_empty());
}

#[test]
fn text_documents_find_buffers_in_files_and_data_uris() {
    let document = Document::triangle();
    let folder = std::env::temp_dir().join(format!("umbragraph-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("a b.bin"), &document.binary).unwrap();
    let mut json = document.json.clone();
    json["buffers"] = json!([{ "uri": "a%20b.bin", "byteLength": document.binary.len() }]);
    std::fs::write(folder.join("scene.gltf"), json.to_string()).unwrap();
    let beside = umbragraph_scene::load(&folder.join("scene.gltf"));
    let nowhere =
        from_slice("scene.gltf", json.to_string().as_bytes(), &Folder::new(folder.join("elsewhere")));
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(beside.unwrap().draws().len(), 1);
    assert!(nowhere.is_err());
    let data = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    json["buffers"][0]["uri"] = json!(data);
    let scene = from_slice("scene.gltf", json.to_string().as_bytes(), &NoFiles).unwrap();
    assert_eq!(scene.bounds(&scene.rest_pose()).max, DVec3::new(1.0, 1.0, 0.0));
}

#[cfg(unix)]
#[test]
fn documents_read_regular_files_below_their_roots() {
    use umbragraph_scene::load_below;
    let document = Document::triangle();
    let folder = std::env::temp_dir().join(format!("umbragraph-scene-roots-{}", std::process::id()));
    for name in ["own", "other"] {
        std::fs::create_dir_all(folder.join(name)).unwrap();
    }
    std::fs::write(folder.join("other/a.bin"), &document.binary).unwrap();
    std::os::unix::fs::symlink(folder.join("other/a.bin"), folder.join("own/link.bin")).unwrap();
    let pipe = folder.join("own/pipe.bin");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let scene = folder.join("own/scene.gltf");
    let with = |uri: &str| {
        let mut json = document.json.clone();
        json["buffers"] = json!([{ "uri": uri, "byteLength": document.binary.len() }]);
        std::fs::write(&scene, json.to_string()).unwrap();
    };
    let found = |result: Result<Scene, Diagnostics>| {
        let found = result.map(|_| ()).unwrap_err();
        found.iter().map(|diagnostic| diagnostic.message.as_str()).collect::<Vec<_>>().join("\n")
    };
    for uri in ["../other/a.bin", "../other/nothing.bin", "link.bin", "../../../../../../../../dev/zero"] {
        with(uri);
        let said = found(umbragraph_scene::load(&scene));
        assert!(said.contains("is outside of the folders that may be read"), "{uri}: {said}");
    }
    with("link.bin");
    assert!(load_below(&scene, Roots::of(&scene).and(&folder)).is_ok());
    with("pipe.bin");
    let said = found(umbragraph_scene::load(&scene));
    assert!(said.contains("it is no regular file"), "{said}");
    for path in [pipe.as_path(), "/dev/zero".as_ref()] {
        let said = found(umbragraph_scene::load(path));
        assert!(said.contains("it is no regular file"), "{said}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn an_animation_moves_nodes_cameras_and_bounds_and_loops() {
    let mut document = Document::triangle();
    let times = document.floats("SCALAR", &[0.0, 2.0]);
    let moves = document.floats("VEC3", &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
    let half = (FRAC_PI_2 / 2.0).sin() as f32;
    let turns = document.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]);
    document.push(
        "animations",
        json!({
            "channels": [
                { "sampler": 0, "target": { "node": 0, "path": "translation" } },
                { "sampler": 1, "target": { "node": 0, "path": "rotation" } },
            ],
            "samplers": [{ "input": times, "output": moves }, { "input": times, "output": turns }],
        }),
    );
    let scene = document.load().unwrap();
    let draw = scene.draws().next().unwrap();
    assert!(draw.dynamic);
    for time in [1.0, 3.0, -1.0] {
        let world = scene.pose(time).world(draw.node);
        assert!(close(world.w_axis.truncate(), DVec3::new(2.0, 0.0, 0.0)), "at {time}");
        assert!(
            close(world.transform_vector3(DVec3::X), DVec3::new(1.0, 0.0, -1.0).normalize()),
            "at {time}"
        );
    }
    assert!(scene.frame_input(1.0, 1.0).bounds_of("casters").min.x > 1.5);
    let mut pose = scene.rest_pose();
    scene.pose_into(1.0, &mut pose);
    assert_eq!(pose, scene.pose(1.0));
    let mut of_another = Document::new().load().unwrap().rest_pose();
    scene.pose_into(1.0, &mut of_another);
    assert_eq!(of_another, scene.pose(1.0));
}

#[test]
fn a_skinned_mesh_follows_its_joints_and_not_its_node() {
    let mut document = Document::triangle();
    let joints = document.shorts("VEC4", &[0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0]);
    let weights = document.floats("VEC4", &[1., 0., 0., 0., 1., 1., 0., 0., 2., 0., 0., 0.]);
    document.attribute("JOINTS_0", joints);
    document.attribute("WEIGHTS_0", weights);
    document.json["nodes"][0]["translation"] = json!([100, 0, 0]);
    document.json["nodes"][0]["skin"] = json!(0);
    let root = document.node(json!({}));
    let tip = document.node(json!({ "translation": [0, 0, 3] }));
    document.push("skins", json!({ "joints": [root, tip] }));
    let scene = document.load().unwrap();
    let draw = scene.draws().next().unwrap();
    assert_eq!(draw.skin, Some(0));
    assert!(draw.dynamic);
    let primitive = scene.primitive(draw);
    assert_eq!(primitive.joints.as_ref().unwrap().weights[1..], [[0.5, 0.5, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]);
    let pose = scene.rest_pose();
    let matrices: Vec<_> = scene.joint_transforms(draw.node, &pose).collect();
    assert_eq!(matrices.len(), 2);
    assert_eq!(matrices[1].transform_point3(DVec3::ZERO), DVec3::new(0.0, 0.0, 3.0));
    let bounds = scene.draw_bounds(draw, &pose);
    assert_eq!((bounds.min, bounds.max), (DVec3::ZERO, DVec3::new(1.0, 1.0, 3.0)));
}

/// The triangle document with two morph targets: the first moves vertex 0 by 2 m along +Z. The second moves all
/// vertices by 1 m along +X and turns their normals.
fn morphing() -> Document {
    let mut document = Document::triangle();
    let up = document.floats("VEC3", &[0., 0., 2., 0., 0., 0., 0., 0., 0.]);
    let right = document.floats("VEC3", &[1., 0., 0., 1., 0., 0., 1., 0., 0.]);
    let turned = document.floats("VEC3", &[1., 0., 0., 1., 0., 0., 1., 0., 0.]);
    document.json["meshes"][0]["primitives"][0]["targets"] =
        json!([{ "POSITION": up }, { "POSITION": right, "NORMAL": turned }]);
    document
}

/// The morphed position and normal of the first vertex of the first draw, at a time in seconds.
fn first_vertex(scene: &Scene, time: f64) -> ([f32; 3], [f32; 3]) {
    let draw = scene.draws().next().unwrap();
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    scene.primitive(draw).morph(scene.pose(time).weights(draw.node), &mut positions, &mut normals);
    (positions[0], normals[0])
}

#[test]
fn morph_weights_are_of_the_node_or_else_of_the_mesh() {
    let mut document = morphing();
    assert_eq!(first_vertex(&document.load().unwrap(), 0.0).0, [0.0; 3]);
    document.json["meshes"][0]["weights"] = json!([0.5, 0.25]);
    let scene = document.load().unwrap();
    let (position, normal) = first_vertex(&scene, 0.0);
    assert_eq!(position, [0.25, 0.0, 1.0]);
    // The normals are those of the morphed triangle: its first corner is up.
    assert!(normal[0] > 0.5 && normal[1] > 0.5, "{normal:?}");
    let bounds = scene.bounds(&scene.rest_pose());
    assert!(close(bounds.min, DVec3::ZERO) && close(bounds.max, DVec3::new(1.25, 1.0, 1.0)), "{bounds:?}");
    document.json["nodes"][0]["weights"] = json!([-0.5, 3.0]);
    let back = document.load().unwrap();
    let bounds = back.bounds(&back.rest_pose());
    assert!(close(bounds.min, DVec3::NEG_Z) && close(bounds.max, DVec3::new(4.0, 1.0, 0.0)), "{bounds:?}");
    document.json["nodes"][0]["weights"] = json!([1.0, 0.0]);
    let normals = document.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    document.attribute("NORMAL", normals);
    assert_eq!(first_vertex(&document.load().unwrap(), 0.0), ([0.0, 0.0, 2.0], [0.0, 0.0, 1.0]));
    document.json["nodes"][0]["weights"] = json!([0.0, 1.0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let (position, normal) = first_vertex(&document.load().unwrap(), 0.0);
    assert_eq!(position, [1.0, 0.0, 0.0]);
    assert!(Vec3::from_array(normal).abs_diff_eq(Vec3::new(half, 0.0, half), 1e-6));
}

#[test]
fn weights_of_morph_targets_follow_their_keys() {
    let animated = |interpolation: &str, values: &[f32]| {
        let mut document = morphing();
        let (times, values) = (document.floats("SCALAR", &[0.0, 2.0]), document.floats("SCALAR", values));
        let sampler = json!({ "input": times, "output": values, "interpolation": interpolation });
        let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "weights" } });
        // A node with a matrix may morph as well.
        document.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]);
        document.push("animations", json!({ "samplers": [sampler], "channels": [channel] }));
        document.load().unwrap()
    };
    let linear = animated("LINEAR", &[0.0, 1.0, 1.0, 0.0]);
    let draw = linear.draws().next().unwrap();
    assert!(draw.dynamic && linear.warnings.is_empty());
    assert_eq!(linear.pose(0.5).weights(draw.node), [0.25, 0.75]);
    assert!(linear.moves(draw, &linear.pose(0.5), &linear.pose(1.0)));
    assert!(!linear.moves(draw, &linear.pose(0.5), &linear.pose(0.5)));
    assert_eq!(animated("STEP", &[0.0, 1.0, 1.0, 0.0]).pose(1.9).weights(draw.node), [0.0, 1.0]);
    // Tangents in, values and tangents out of the first key, and the same of the second.
    let spline = animated("CUBICSPLINE", &[9.0, 9.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 2.0, 1.0, 9.0, 9.0]);
    assert_eq!(spline.pose(1.0).weights(draw.node), [1.0, 1.0]);
    assert_eq!(spline.pose(0.5).weights(draw.node), [0.5, 1.0]);
    // What a spline makes of them stays a number.
    let wild = animated("CUBICSPLINE", &[3e38, 0.0, 0.0, 1.0, 3e38, 0.0, -3e38, 0.0, 2.0, 1.0, 0.0, 0.0]);
    let bounds = wild.bounds(&wild.pose(1.0));
    assert!(bounds.max.is_finite() && !bounds.is_empty());
}

/// Decodes an image file through a scene: width, height and RGBA bytes.
fn texels(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
    let image = Document::pictured(bytes).load().unwrap().images[0].clone();
    (image.width, image.height, image.rgba)
}

#[test]
fn images_of_every_layout_match_another_decoder() {
    use image::ImageFormat::{Jpeg, Png};
    let color = image::DynamicImage::from(image::RgbaImage::from_fn(17, 13, |x, y| {
        image::Rgba([x as u8 * 15, y as u8 * 19, 255 - x as u8 * 7, 255 - y as u8 * 9])
    }));
    let cases = [
        (Png, image::DynamicImage::from(color.to_luma8()), 0),
        (Png, color.to_luma_alpha8().into(), 0),
        (Png, color.to_rgb8().into(), 0),
        (Png, color.clone(), 0),
        // The other decoder rounds.
        (Png, color.to_luma16().into(), 1),
        (Png, color.to_luma_alpha16().into(), 1),
        (Png, color.to_rgb16().into(), 1),
        (Png, color.to_rgba16().into(), 1),
        (Jpeg, color.to_luma8().into(), 0),
        (Jpeg, color.to_rgb8().into(), 0),
    ];
    for (format, picture, difference) in cases {
        let mut bytes = Vec::new();
        picture.write_to(&mut std::io::Cursor::new(&mut bytes), format).unwrap();
        let expected = image::load_from_memory(&bytes).unwrap().into_rgba8();
        let (width, height, rgba) = texels(&bytes);
        assert_eq!((width, height, rgba.len()), (17, 13, expected.len()), "{format:?} {:?}", picture.color());
        let worst = rgba.iter().zip(expected.iter()).map(|(own, other)| own.abs_diff(*other)).max();
        assert!(worst <= Some(difference), "{format:?} {:?}: {worst:?}", picture.color());
    }
}

#[test]
fn palettes_have_the_alpha_of_their_entries() {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 3, 1);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Two);
    encoder.set_palette(vec![10, 20, 30, 40, 50, 60, 70, 80, 90]);
    encoder.set_trns(vec![255, 128]);
    let mut writer = encoder.write_header().unwrap();
    // Entries 0, 1 and 2.
    writer.write_image_data(&[0b0001_1000]).unwrap();
    writer.finish().unwrap();
    assert_eq!(texels(&bytes), (3, 1, vec![10, 20, 30, 255, 40, 50, 60, 128, 70, 80, 90, 255]));
}
