//! What is said about a broken document: code, place, message and help, all diagnostics at once.

use serde_json::{Value, json};
use umbragraph_pipeline::diagnostic::Place;
use umbragraph_scene::{NoFiles, from_slice};

use crate::document::{Document, diagnostics, glb, line};

/// The diagnostics of the triangle after a change.
fn triangle_with(change: impl FnOnce(&mut Document)) -> Vec<String> {
    let mut document = Document::triangle();
    change(&mut document);
    diagnostics(document.load())
}

fn of_bytes(bytes: &[u8]) -> Vec<String> {
    diagnostics(from_slice("test.glb", bytes, &NoFiles))
}

fn of_json(json: &Value) -> Vec<String> {
    of_bytes(json.to_string().as_bytes())
}

#[test]
fn a_missing_file_is_named() {
    let found = umbragraph_scene::load("no/such/scene.glb".as_ref()).unwrap_err();
    let [diagnostic] = found.iter().as_slice() else { panic!("{found:?}") };
    assert_eq!(diagnostic.code.id, "UG0700");
    assert_eq!(diagnostic.message, "the scene \"no/such/scene.glb\" does not exist");
    assert_eq!(
        diagnostic.place,
        Place::File { path: "no/such/scene.glb".to_owned(), locator: String::new() }
    );
    assert_eq!(diagnostic.help.as_deref(), Some("paths are relative to the current folder"));
}

#[test]
fn a_folder_is_no_scene() {
    let found = umbragraph_scene::load(&std::env::temp_dir()).unwrap_err();
    assert_eq!(found.iter().map(|diagnostic| diagnostic.code.id).collect::<Vec<_>>(), ["UG0700"]);
}

#[test]
fn a_truncated_binary_says_how_much_is_left() {
    let whole = Document::triangle().glb();
    let length = whole.len();
    let help = "(export the file again, or copy it again in binary mode)";
    assert_eq!(
        of_bytes(&whole[..length - 1]),
        [format!("UG0701 : the header says {length} bytes, but the file has {} {help}", length - 1)]
    );
    assert_eq!(
        of_bytes(&whole[..9]),
        [format!("UG0701 : the file ends after 9 bytes, inside the header of a binary glTF {help}")]
    );
    let mut short = whole[..20].to_vec();
    short[8..12].copy_from_slice(&20_u32.to_le_bytes());
    short[12..16].copy_from_slice(&400_u32.to_le_bytes());
    assert_eq!(
        of_bytes(&short),
        [format!("UG0701 : the chunk at byte 12 says 400 bytes, but 0 are left {help}")]
    );
    short[8..12].copy_from_slice(&12_u32.to_le_bytes());
    assert_eq!(of_bytes(&short), [format!("UG0701 : the file has no JSON chunk {help}")]);
    short[8..12].copy_from_slice(&3_u32.to_le_bytes());
    assert_eq!(of_bytes(&short), [format!("UG0701 : the header says 3 bytes, but the file has 20 {help}")]);
    short[4] = 1;
    assert_eq!(of_bytes(&short), ["UG0703 : the file is a binary glTF of version 1 (export it as glTF 2.0)"]);
}

#[test]
fn no_prefix_of_a_binary_panics_or_loads() {
    let whole = Document::triangle().glb();
    for length in 0..whole.len() {
        assert!(from_slice("test.glb", &whole[..length], &NoFiles).is_err(), "{length} bytes");
    }
}

#[test]
fn broken_json_has_a_line_and_a_column_and_a_wrong_type_has_a_pointer() {
    assert_eq!(
        of_bytes(b"{\n  \"asset\": nothing }"),
        ["UG0702 line 2, column 13: the document cannot be parsed: expected ident at line 2 column 13 \
          (the file is neither JSON nor a binary glTF; export it again)"]
    );
    assert_eq!(
        of_bytes(b""),
        [
            "UG0702 line 1, column 0: the document cannot be parsed: EOF while parsing a value at line 1 column 0 \
          (the file is empty)"
        ]
    );
    let found = triangle_with(|document| document.json["meshes"][0]["primitives"][0]["mode"] = json!("fan"));
    assert_eq!(found.len(), 1);
    assert!(
        found[0].starts_with("UG0702 /meshes/0/primitives/0/mode: the document cannot be parsed"),
        "{}",
        found[0]
    );
}

#[test]
fn other_versions_and_required_extensions_are_rejected() {
    let found = triangle_with(|document| {
        document.json["asset"]["version"] = json!("1.0");
        document.json["extensionsRequired"] = json!(["KHR_lights_punctual", "KHR_draco_mesh_compression"]);
    });
    assert_eq!(
        found,
        [
            "UG0703 /asset/version: the document needs a reader of glTF \"1.0\" (export it as glTF 2.0)",
            "UG0704 /extensionsRequired/1: the document requires the extension \"KHR_draco_mesh_compression\" \
             (export the scene without it)",
        ]
    );
}

#[test]
fn missing_and_short_buffers_are_found_together() {
    let mut json = Document::triangle().json;
    json["buffers"] = json!([
        { "byteLength": 36 },
        { "byteLength": 4, "uri": "geometry.bin" },
        { "byteLength": 9, "uri": "data:;base64,AAAA" },
        { "byteLength": 9, "uri": "https://example.org/a.bin" },
    ]);
    let help = "(put the file beside the document, or export the scene as one .glb file)";
    assert_eq!(
        of_json(&json),
        [
            "UG0706 /buffers/0: buffer 0 has no URI, and there is no binary chunk for it (export the scene as one .glb file)".to_owned(),
            format!("UG0706 /buffers/1/uri: buffer 1: \"geometry.bin\" is a file of its own, and this scene is read from memory alone {help}"),
            "UG0707 /buffers/2: buffer 2 should have 9 bytes, but has 3 (the file was probably cut off; copy or export it again)".to_owned(),
            format!("UG0706 /buffers/3/uri: buffer 3: \"https://example.org/a.bin\" is not a relative path {help}"),
        ]
    );
}

#[test]
fn a_binary_chunk_shorter_than_its_buffer_is_found() {
    let document = Document::triangle();
    let mut json = document.json.clone();
    json["buffers"][0]["byteLength"] = json!(4000);
    assert_eq!(
        of_bytes(&glb(&json, &document.binary)),
        [
            "UG0707 /buffers/0: buffer 0 should have 4000 bytes, but has 36 (the file was probably cut off; copy or export it again)"
        ]
    );
}

#[test]
fn positions_that_are_not_finite_are_counted() {
    for value in [f32::NAN, f32::INFINITY] {
        let found = triangle_with(|document| document.binary[16..20].copy_from_slice(&value.to_le_bytes()));
        assert_eq!(
            found,
            [
                "UG0712 /meshes/0/primitives/0/attributes/POSITION: the position of vertex 1 is not finite (1 of 3 are not) \
              (mend the mesh in the program that made it, and export it again)"
            ]
        );
    }
}

#[test]
fn indices_beyond_the_vertices_are_found() {
    let found = triangle_with(|document| {
        let indices = document.shorts("SCALAR", &[0, 1, 3]);
        document.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    });
    assert_eq!(
        found,
        [
            "UG0711 /meshes/0/primitives/0/indices: index 3 (at place 2) is beyond the 3 vertices (export the mesh again)"
        ]
    );
}

#[test]
fn accessors_and_views_stay_inside_their_bytes() {
    let found = triangle_with(|document| document.json["accessors"][0]["count"] = json!(4));
    assert_eq!(
        found,
        [
            "UG0708 /meshes/0/primitives/0/attributes/POSITION: 4 elements of 12 bytes, 12 bytes apart, from byte 0 on \
          do not fit buffer view 0 of 36 bytes (export the file again)"
        ]
    );
    let found = triangle_with(|document| document.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX));
    assert_eq!(
        found,
        [
            "UG0708 /bufferViews/0: bytes 18446744073709551615 to 18446744073709551615 are not inside buffer 0 of 36 bytes \
          (export the file again)"
        ]
    );
    let found = triangle_with(|document| document.json["bufferViews"][0]["byteStride"] = json!(4));
    assert!(found[0].starts_with(
        "UG0708 /meshes/0/primitives/0/attributes/POSITION: 3 elements of 12 bytes, 4 bytes apart"
    ));
}

#[test]
fn accessors_of_a_wrong_type_or_without_elements_are_found() {
    let found = triangle_with(|document| {
        let flat = document.floats("VEC2", &[0.0; 6]);
        document.attribute("POSITION", flat);
        let weights = document.floats("SCALAR", &[0.0, 1.0, 2.0]);
        document.json["meshes"][0]["primitives"][0]["indices"] = json!(weights);
        document.json["accessors"][0]["count"] = json!(0);
        document.attribute("TEXCOORD_0", 0);
    });
    assert_eq!(
        found,
        [
            "UG0709 /meshes/0/primitives/0/attributes/POSITION: accessor 1 has 3 × VEC2 of FLOAT \
             (wanted here: at least one element of 3 floats or small integers)",
            "UG0709 /meshes/0/primitives/0/attributes/TEXCOORD_0: accessor 0 has 0 × VEC3 of FLOAT \
             (wanted here: at least one element of 2 floats or small integers)",
            "UG0709 /meshes/0/primitives/0/indices: accessor 2 has 3 × SCALAR of FLOAT \
             (wanted here: at least one element of 1 unsigned integers)",
        ]
    );
}

#[test]
fn attributes_need_positions_and_equal_lengths() {
    let found = triangle_with(|document| {
        let texcoords = document.floats("VEC2", &[0.0; 4]);
        document.attribute("TEXCOORD_0", texcoords);
        document.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(json!({ "attributes": {} }));
    });
    assert_eq!(
        found,
        [
            "UG0710 /meshes/0/primitives/0/attributes/TEXCOORD_0: TEXCOORD_0 has 2 elements, but POSITION has 3 \
             (export the mesh again: all attributes have one element for each vertex)",
            "UG0710 /meshes/0/primitives/1: the primitive has no POSITION (export the mesh with positions)",
        ]
    );
}

#[test]
fn normals_that_cannot_be_used_are_computed_with_a_warning() {
    let at = "/meshes/0/primitives/0/attributes/NORMAL";
    let warning_of = |change: &dyn Fn(&mut Document)| {
        let mut document = Document::triangle();
        let normals = document.floats("VEC3", &[0., 1., 0., 0., 1., 0., 0., 1., 0.]);
        document.attribute("NORMAL", normals);
        change(&mut document);
        let scene = document.load().unwrap();
        let primitive = scene.primitive(scene.draws().next().unwrap());
        assert_eq!(primitive.normals, [[0.0, 0.0, 1.0]; 3]);
        assert_eq!(scene.warnings.error_count(), 0);
        scene.warnings.iter().map(line).collect::<Vec<String>>()
    };
    assert_eq!(
        warning_of(&|document| document.json["bufferViews"][1]["byteLength"] = json!(24)),
        [format!(
            "UG0708 {at}: 3 elements of 12 bytes, 12 bytes apart, from byte 0 on do not fit buffer view 1 of 24 bytes; \
             flat normals are computed (export the file again)"
        )]
    );
    assert_eq!(
        warning_of(&|document| document.json["accessors"][1]["count"] = json!(2)),
        [format!(
            "UG0710 {at}: NORMAL has 2 elements, but POSITION has 3; flat normals are computed \
             (export the mesh again: all attributes have one element for each vertex)"
        )]
    );
    let found = warning_of(&|document| document.binary[36..40].copy_from_slice(&f32::NAN.to_le_bytes()));
    assert!(found[0].starts_with(&format!("UG0712 {at}: the normal of vertex 0 is not finite")), "{found:?}");
}

#[test]
fn references_to_nothing_are_found_everywhere_at_once() {
    let found = triangle_with(|document| {
        document.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9);
        document.json["meshes"][0]["primitives"][0]["material"] = json!(2);
        document.json["nodes"][0]["mesh"] = json!(5);
        document.json["nodes"][0]["camera"] = json!(0);
        document.json["nodes"][0]["children"] = json!([7]);
        document.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = json!(3);
        document.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
        document.json["scenes"][0]["nodes"] = json!([0, 4]);
    });
    assert_eq!(
        found,
        [
            "UG0705 /materials/0/pbrMetallicRoughness/baseColorTexture/index: texture 0 does not exist (the document has no textures)",
            "UG0705 /meshes/0/primitives/0/material: material 2 does not exist (the document has one material, number 0)",
            "UG0705 /meshes/0/primitives/0/attributes/POSITION: accessor 9 does not exist (the document has one accessor, number 0)",
            "UG0705 /nodes/0/mesh: mesh 5 does not exist (the document has one mesh, number 0)",
            "UG0705 /nodes/0/children/0: node 7 does not exist (the document has one node, number 0)",
            "UG0705 /scenes/0/nodes/1: node 4 does not exist (the document has one node, number 0)",
            "UG0705 /nodes/0/camera: camera 0 does not exist (the document has no cameras)",
            "UG0705 /nodes/0/extensions/KHR_lights_punctual/light: light 3 does not exist (the document has no lights)",
        ]
    );
}

#[test]
fn transforms_that_are_not_finite_affine_or_rotations_are_found() {
    let found = triangle_with(|document| {
        document.json["nodes"][0]["translation"] = json!([1e39, 0, 0]);
        document.node(json!({ "rotation": [0, 0, 0, 0] }));
        document.node(json!({ "scale": [1, -1e39, 1] }));
        let mut matrix = [0.0; 16];
        matrix[15] = 1.0;
        matrix[3] = 2.0;
        document.node(json!({ "matrix": matrix }));
        matrix[0] = 1e39;
        document.node(json!({ "matrix": matrix }));
    });
    let help = "(mend the transform in the program that made it, and export the scene again)";
    assert_eq!(
        found,
        [
            format!("UG0713 /nodes/0/translation: the translation of node 0 is not finite {help}"),
            "UG0713 /nodes/1/rotation: the rotation of node 1 has length zero (it has to be a unit quaternion)".to_owned(),
            format!("UG0713 /nodes/2/scale: the scale of node 2 is not finite {help}"),
            "UG0713 /nodes/3/matrix: the matrix of node 3 is not affine (its last row has to be 0, 0, 0, 1)".to_owned(),
            format!("UG0713 /nodes/4/matrix: the matrix of node 4 is not finite {help}"),
        ]
    );
}

#[test]
fn geometry_out_of_all_proportion_is_found() {
    let found = triangle_with(|document| document.json["nodes"][0]["scale"] = json!([1e38, 1, 1]));
    assert_eq!(
        found,
        [
            "UG0713 /nodes/0: mesh 0 reaches farther than 1000000000 metres from the origin (check the units: glTF is in metres)"
        ]
    );
}

#[test]
fn a_cyclic_hierarchy_names_its_members_and_a_second_parent_is_found() {
    let found = triangle_with(|document| {
        document.push("nodes", json!({ "children": [2] }));
        document.push("nodes", json!({ "children": [3] }));
        document.push("nodes", json!({ "children": [1, 4] }));
        document.push("nodes", json!({}));
        document.push("nodes", json!({ "children": [5] }));
    });
    assert_eq!(
        found,
        [
            "UG0714 /nodes/2/children: nodes are their own ancestors: 2 → 3 → 1 → 2 \
             (take one of them out of the children of the other)",
            "UG0714 /nodes/5/children: nodes are their own ancestors: 5 → 5 \
             (take one of them out of the children of the other)",
        ]
    );
    let found = triangle_with(|document| {
        document.push("nodes", json!({ "children": [0] }));
        document.push("nodes", json!({ "children": [0] }));
    });
    assert_eq!(
        found,
        [
            "UG0714 /nodes/2/children/0: node 0 is a child of node 1 and of node 2 (give each of them its own copy of the node)"
        ]
    );
}

#[test]
fn degenerate_cameras_are_found() {
    let views = [
        json!({ "type": "perspective", "perspective": { "yfov": 0, "znear": 0.1 } }),
        json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0 } }),
        json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 5, "zfar": 5 } }),
        json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 0, "znear": 0, "zfar": 5 } }),
        json!({ "type": "orthographic", "perspective": { "yfov": 1, "znear": 5 } }),
        json!({ "type": "fisheye" }),
        json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 1e39 } }),
    ];
    let found = triangle_with(|document| {
        for (index, view) in views.into_iter().enumerate() {
            document.push("cameras", view);
            document.node(json!({ "camera": index }));
        }
        document
            .push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
        document.node(json!({ "camera": 7, "scale": [1, 1, 0] }));
    });
    let help = "(a camera needs a field of view above 0 and below π, 0 < near < far, and a node without a scale of 0)";
    assert_eq!(
        found,
        [
            format!("UG0716 /cameras/0: camera 0 cannot be used: its vertical field of view is not between 0 and π {help}"),
            format!("UG0716 /cameras/1: camera 1 cannot be used: its far plane is not beyond its near plane {help}"),
            format!("UG0716 /cameras/2: camera 2 cannot be used: its far plane is not beyond its near plane {help}"),
            format!("UG0716 /cameras/3: camera 3 cannot be used: its half height is not above zero {help}"),
            "UG0716 /cameras/4: the camera lacks the properties of its type (add the object perspective or orthographic)".to_owned(),
            "UG0724 /cameras/5/type: the camera has an unknown type (it is perspective or orthographic)".to_owned(),
            format!("UG0716 /cameras/6: camera 6 cannot be used: it has a value that is not finite {help}"),
            format!("UG0716 /nodes/8: camera 7 cannot be used: the transform of its node leaves it no direction {help}"),
        ]
    );
}

#[test]
fn unusable_lights_are_found() {
    let found = triangle_with(|document| {
        document.json["extensions"]["KHR_lights_punctual"]["lights"] = json!([
            { "type": "point", "range": 0, "intensity": -1 },
            { "type": "spot", "spot": { "innerConeAngle": 0, "outerConeAngle": 0 } },
            { "type": "spot", "spot": { "outerConeAngle": 3.1 } },
            { "type": "directional", "color": [1e39, 0, 0] },
            { "type": "directional", "extras": { "castShadow": "no", "angular_diameter_deg": -1 } },
            { "type": "area" },
            { "type": "directional" },
            { "type": "point", "color": [1e30, 0, 0], "intensity": 1e30 },
            { "type": "spot", "spot": { "innerConeAngle": 1e39, "outerConeAngle": 1e39 }, "range": 1e39 },
        ]);
        for light in 0..9 {
            let scale = if light == 6 { 0 } else { 1 };
            document.node(json!({ "extensions": { "KHR_lights_punctual": { "light": light } }, "scale": [scale, scale, scale] }));
        }
    });
    let at = "/extensions/KHR_lights_punctual/lights";
    let cone = "its cone is empty or wider than a half space (0 ≤ innerConeAngle < outerConeAngle ≤ π/2)";
    assert_eq!(
        found,
        [
            format!("UG0717 {at}/0/intensity: light \"light 0\": its intensity is negative or not finite (use candela, or lux for a directional light)"),
            format!("UG0717 {at}/0/range: light \"light 0\": its range is not above zero (leave the range out where there is no limit)"),
            format!("UG0717 {at}/1/spot: light \"light 1\": {cone}"),
            format!("UG0717 {at}/2/spot: light \"light 2\": {cone}"),
            format!("UG0717 {at}/3/color: light \"light 3\": its colour is negative or not finite (use values from 0 to 1)"),
            format!("UG0724 {at}/4/extras/angular_diameter_deg: angular_diameter_deg has an unusable value (it is a number that is not negative)"),
            format!("UG0724 {at}/4/extras/castShadow: castShadow has an unusable value (it is true or false)"),
            format!("UG0717 {at}/5/type: light \"light 5\": its type is unknown (it is directional, point or spot)"),
            "UG0717 /nodes/7: light \"light 6\" has no direction: its node is scaled to nothing (give the node a scale that is not 0)".to_owned(),
            format!("UG0717 {at}/7/intensity: light \"light 7\": its intensity times its colour is beyond what numbers of 32 bits hold (use candela, or lux for a directional light)"),
            format!("UG0717 {at}/8/range: light \"light 8\": its range is not above zero (leave the range out where there is no limit)"),
            format!("UG0717 {at}/8/spot: light \"light 8\": {cone}"),
        ]
    );
}

#[test]
fn unusable_extras_of_lights_are_found() {
    // What is no number in JSON, what 32 bits do not hold, and what is below zero.
    let unusable = [json!(-0.5), json!(1e39), json!("NaN"), json!(null), json!([1]), json!(true)];
    let found = triangle_with(|document| {
        let mut lights = Vec::new();
        for value in &unusable {
            lights.push(json!({ "type": "directional", "extras": { "angular_diameter_deg": value } }));
            lights.push(json!({ "type": "point", "extras": { "radius": value } }));
            lights.push(json!({ "type": "point", "extras": { "priority": value } }));
        }
        for extras in [
            json!({ "shadowHardness": "harder" }),
            json!({ "shadowHardness": 1 }),
            json!({ "contactShadow": 0 }),
            json!({ "contactShadow": "false" }),
        ] {
            lights.push(json!({ "type": "point", "extras": extras }));
        }
        for light in 0..lights.len() {
            document.node(json!({ "extensions": { "KHR_lights_punctual": { "light": light } } }));
        }
        document.json["extensions"]["KHR_lights_punctual"]["lights"] = json!(lights);
    });
    let at = "/extensions/KHR_lights_punctual/lights";
    let mut wanted = Vec::new();
    for light in 0..3 * unusable.len() {
        let key = ["angular_diameter_deg", "radius", "priority"][light % 3];
        wanted.push(format!(
            "UG0724 {at}/{light}/extras/{key}: {key} has an unusable value (it is a number that is not negative)"
        ));
    }
    for (light, key, what) in [
        (18, "shadowHardness", "one of hard, soft, pcss"),
        (19, "shadowHardness", "one of hard, soft, pcss"),
        (20, "contactShadow", "true or false"),
        (21, "contactShadow", "true or false"),
    ] {
        wanted.push(format!("UG0724 {at}/{light}/extras/{key}: {key} has an unusable value (it is {what})"));
    }
    let mut found = found;
    found.sort();
    wanted.sort();
    assert_eq!(found, wanted);
}

#[test]
fn lights_and_cameras_out_of_all_proportion_are_found() {
    let found = triangle_with(|document| {
        document.json["extensions"]["KHR_lights_punctual"]["lights"] =
            json!([{ "type": "point", "name": "star" }]);
        document
            .push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
        let lamp = document.push(
            "nodes",
            json!({
                "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [0, 3e38, 0],
            }),
        );
        // Each of the two is finite; their product is not, in 32 bits.
        document.node(json!({ "scale": [3e38, 3e38, 3e38], "children": [lamp] }));
        document.node(json!({ "camera": 0, "translation": [2e9, 0, 0] }));
    });
    let far = "stands farther than 1000000000 metres from the origin (check the units: glTF is in metres)";
    assert_eq!(
        found,
        [format!("UG0713 /nodes/3: camera 0 {far}"), format!("UG0713 /nodes/1: light \"star\" {far}"),]
    );
}

#[test]
fn broken_images_and_samplers_and_material_values_are_found() {
    let found = triangle_with(|document| {
        let view = document.view(b"this is no picture");
        document.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        document.push("images", json!({}));
        document.push("samplers", json!({ "wrapS": 1, "magFilter": 2, "minFilter": 3 }));
        for (index, sampler) in [json!(0), json!(4)].into_iter().enumerate() {
            document.push("textures", json!({ "source": index, "sampler": sampler }));
            document.push(
                "materials",
                json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": index } } }),
            );
        }
        document.push(
            "materials",
            json!({ "emissiveFactor": [0, -1, 0], "alphaMode": "mask", "alphaCutoff": -0.5 }),
        );
    });
    assert_eq!(
        found,
        [
            "UG0719 /materials/2/emissiveFactor: a factor of material 2 is negative or not finite: [0.0, -1.0, 0.0] (set it between 0 and 1)",
            "UG0719 /materials/2/alphaCutoff: a factor of material 2 is negative or not finite: [-0.5] (set it between 0 and 1)",
            "UG0724 /materials/2/alphaMode: material 2 has an unknown alpha mode (it is OPAQUE, MASK or BLEND)",
            "UG0724 /samplers/0/wrapS: sampler 0 has an unknown wrapS (see the glTF 2.0 specification, section 5.26)",
            "UG0724 /samplers/0/magFilter: sampler 0 has an unknown magFilter (see the glTF 2.0 specification, section 5.26)",
            "UG0724 /samplers/0/minFilter: sampler 0 has an unknown minFilter (see the glTF 2.0 specification, section 5.26)",
            "UG0718 /images/0: image 0 cannot be decoded: The image format could not be determined (use a PNG or JPEG image)",
            "UG0705 /textures/1/sampler: sampler 4 does not exist (the document has one sampler, number 0)",
            "UG0718 /images/1: image 1 has neither a URI nor a buffer view (export the scene with its textures)",
        ]
    );
}

#[test]
fn skins_have_to_fit_their_meshes() {
    let found = triangle_with(|document| {
        document.push("skins", json!({ "joints": [0, 8] }));
        document.push("skins", json!({ "joints": [] }));
        let matrices = document.floats("MAT4", &[f32::NAN; 16]);
        document.push("skins", json!({ "joints": [0, 0], "inverseBindMatrices": matrices }));
        let mut projection = [0.0; 16];
        for at in [0, 5, 10, 11, 15] {
            projection[at] = 1.0;
        }
        let matrices = document.floats("MAT4", &projection);
        document.push("skins", json!({ "joints": [0], "inverseBindMatrices": matrices }));
    });
    assert_eq!(
        found,
        [
            "UG0705 /skins/0/joints/1: node 8 does not exist (the document has one node, number 0)",
            "UG0720 /skins/1/joints: skin 1 has 0 joints (a skin has 1 to 65535 joints)",
            "UG0720 /skins/2/inverseBindMatrices: skin 2 has 2 joints, but 1 inverse bind matrices \
             (there is one matrix for each joint, or none at all)",
            "UG0712 /skins/2/inverseBindMatrices: the inverse bind matrix of joint 0 of skin 2 is not finite \
             (mend the skin in the program that made it, and export it again)",
            "UG0720 /skins/3/inverseBindMatrices: the inverse bind matrix of joint 0 of skin 3 is not affine \
             (its last row has to be 0, 0, 0, 1)",
        ]
    );
    let found = triangle_with(|document| {
        document.push("skins", json!({ "joints": [0] }));
        document.json["nodes"][0]["skin"] = json!(0);
    });
    assert_eq!(
        found,
        [
            "UG0720 /meshes/0/primitives/0/attributes: node 0 gives the mesh skin 0, but a primitive has no JOINTS_0 \
          (export the mesh with its weights, or the node without a skin)"
        ]
    );
    let found = triangle_with(|document| {
        document.push("skins", json!({ "joints": [0] }));
        document.json["nodes"][0]["skin"] = json!(0);
        let joints = document.shorts("VEC4", &[0, 0, 0, 0, 0, 3, 0, 0, 0, 9, 0, 0]);
        let weights = document.floats("VEC4", &[1., 0., 0., 0., 0.5, 0.5, 0., 0., 1., 0., 0., 0.]);
        document.attribute("JOINTS_0", joints);
        document.attribute("WEIGHTS_0", weights);
    });
    assert_eq!(
        found,
        [
            "UG0720 /meshes/0/primitives/0/attributes/JOINTS_0: joint 3 moves a vertex, but skin 0 of node 0 has 1 joints \
          (export the mesh and its skin again)"
        ]
    );
}

#[test]
fn animations_need_increasing_times_and_matching_values() {
    let found = triangle_with(|document| {
        let still = document.floats("SCALAR", &[0.0, 0.0]);
        let times = document.floats("SCALAR", &[0.0, 1.0]);
        let moves = document.floats("VEC3", &[0.0; 6]);
        let broken = document.floats("VEC3", &[0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0]);
        document.node(json!({ "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }));
        let channel = |sampler: usize, node: usize, path: &str| json!({ "sampler": sampler, "target": { "node": node, "path": path } });
        document.push("animations", json!({
            "samplers": [
                { "input": still, "output": moves },
                { "input": times, "output": moves, "interpolation": "CUBICSPLINE" },
                { "input": times, "output": broken },
                { "input": times, "output": moves, "interpolation": "WILD" },
            ],
            "channels": [
                channel(0, 0, "translation"), channel(1, 0, "scale"), channel(2, 0, "translation"), channel(3, 0, "scale"),
                channel(0, 1, "scale"), channel(0, 2, "scale"), channel(9, 0, "scale"), channel(0, 0, "color"),
            ],
        }));
    });
    assert_eq!(
        found,
        [
            "UG0721 /animations/0/samplers/0/input: the key times do not increase from zero on (export the animation again)",
            "UG0721 /animations/0/samplers/1/output: 2 values stand for 2 keys, where 6 are needed (export the animation again)",
            "UG0712 /animations/0/samplers/2/output: value 1 is not finite (export the animation again)",
            "UG0724 /animations/0/samplers/3/interpolation: the interpolation is unknown (it is STEP, LINEAR or CUBICSPLINE)",
            "UG0721 /animations/0/channels/4: node 1 has a matrix, so its Scale cannot be animated \
             (give the node translation, rotation and scale instead)",
            "UG0705 /animations/0/channels/5/target/node: node 2 does not exist (the document has 2 nodes, numbered 0 to 1)",
            "UG0705 /animations/0/channels/6/sampler: sampler 9 does not exist (the document has 4 samplers, numbered 0 to 3)",
            "UG0724 /animations/0/channels/7/target/path: the channel moves an unknown property \
             (it is translation, rotation, scale or weights)",
        ]
    );
}

#[test]
fn an_animation_without_channels_moves_nothing_and_times_that_are_no_numbers_are_found() {
    let mut document = Document::triangle();
    document.push("animations", json!({ "samplers": [], "channels": [] }));
    let scene = document.load().expect("a scene");
    let warnings: Vec<String> = scene.warnings.iter().map(line).collect();
    assert_eq!(
        warnings,
        [
            "UG0722 /animations/0/channels: the animation has no channels, so nothing moves (give it channels, or remove it)"
        ]
    );
    assert!(scene.draws().all(|draw| !draw.dynamic));
    assert_eq!(scene.pose(3.0), scene.rest_pose());
    let found = triangle_with(|document| {
        let times = document.floats("SCALAR", &[0.0, f32::NAN]);
        let moves = document.floats("VEC3", &[0.0; 6]);
        let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
        document.push(
            "animations",
            json!({ "samplers": [{ "input": times, "output": moves }], "channels": [channel] }),
        );
    });
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].starts_with("UG0712 /animations/0/samplers/0/input")
            || found[0].starts_with("UG0721 /animations/0/samplers/0/input"),
        "{found:?}"
    );
}

/// A triangle with a coarser level of detail, as a document says it.
fn with_details(ids: serde_json::Value, change: impl Fn(&mut Document)) -> Document {
    let mut document = Document::triangle();
    let coarse = document.push("nodes", json!({ "mesh": 0 }));
    assert_eq!(coarse, 1);
    document.json["nodes"][0]["extensions"] = json!({ "MSFT_lod": { "ids": ids } });
    document.json["extensionsUsed"] = json!(["MSFT_lod"]);
    change(&mut document);
    document
}

#[test]
fn levels_of_detail_stand_for_a_node_and_are_not_shown_beside_it() {
    let scene = with_details(json!([1, 1]), |document| {
        // A file that shows the coarse node as well.
        document.json["scenes"][0]["nodes"] = json!([0, 1]);
    });
    let scene = scene.load().expect("a scene");
    assert!(scene.warnings.is_empty());
    let of = |draw: umbragraph_scene::Draw| (draw.node.index(), draw.detail, draw.last_detail);
    assert_eq!(scene.draws().map(of).collect::<Vec<_>>(), [(0, 0, 2)]);
    assert_eq!(scene.draws_of_all_details().map(of).collect::<Vec<_>>(), [(0, 0, 2), (0, 1, 2), (0, 2, 2)]);
}

#[test]
fn levels_of_detail_that_do_not_exist_or_correspond_are_found() {
    let missing = with_details(json!([1, 7, "x"]), |_| {}).load().expect_err("no node 7");
    let found: Vec<String> = missing.iter().map(line).collect();
    assert_eq!(
        found,
        [
            "UG0705 /nodes/0/extensions/MSFT_lod/ids/1: node 7 does not exist (the document has 2 nodes, numbered 0 to 1)",
            "UG0724 /nodes/0/extensions/MSFT_lod/ids/2: a level of detail is the number of a node (list the nodes that stand for this one)",
        ]
    );
    let scene =
        with_details(json!([1]), |document| document.json["nodes"][1] = json!({})).load().expect("a scene");
    let warnings: Vec<String> = scene.warnings.iter().map(line).collect();
    assert_eq!(
        warnings,
        [
            "UG0722 /nodes/0/extensions/MSFT_lod/ids/0: node 1 cannot stand for node 0: their meshes do not correspond \
          (give both nodes a mesh, with as many morph targets)"
        ]
    );
    assert_eq!(scene.draws_of_all_details().len(), 1);
}

#[test]
fn rotations_of_length_zero_between_which_nothing_can_be_turned_are_found() {
    let keys = |interpolation: &str, values: &[f32]| {
        let values = values.to_vec();
        triangle_with(move |document| {
            let times = document.floats("SCALAR", &[0.0, 1.0]);
            let turns = document.floats("VEC4", &values);
            document.push(
                "animations",
                json!({
                    "samplers": [{ "input": times, "output": turns, "interpolation": interpolation }],
                    "channels": [{ "sampler": 0, "target": { "node": 0, "path": "rotation" } }],
                }),
            );
        })
    };
    let line = |value: usize| {
        format!(
            "UG0721 /animations/0/samplers/0/output: value {value} is a rotation of length zero (it has to be a unit quaternion)"
        )
    };
    assert_eq!(keys("LINEAR", &[0., 0., 0., 1., 0., 0., 0., 0.]), [line(1)]);
    // Tangents may be zero, keys may not.
    let mut spline = [0.0; 24];
    spline[7] = 1.0;
    assert_eq!(keys("CUBICSPLINE", &spline), [line(4)]);
}

#[test]
fn only_so_many_diagnostics_are_listed_and_the_rest_is_counted() {
    let found = triangle_with(|document| {
        for _ in 0..1000 {
            document.push("nodes", json!({ "mesh": 77 }));
        }
    });
    assert_eq!(found.len(), 201);
    assert_eq!(
        found[200],
        "UG0725 : 800 further errors are not listed (mend the listed ones first; the others are often of the same kind)"
    );
}

#[test]
fn warnings_come_with_the_errors() {
    let mut document = Document::triangle();
    document.json["nodes"][0]["mesh"] = json!(3);
    document.json["meshes"][0]["primitives"][0]["mode"] = json!(1);
    let found = document.load().unwrap_err();
    let lines: Vec<String> = found.iter().map(line).collect();
    assert_eq!(found.error_count(), 1);
    assert!(lines[1].starts_with("UG0722 /meshes/0/primitives/0: points and lines"), "{lines:?}");
}

#[test]
fn morph_targets_that_do_not_fit_their_mesh_are_found() {
    let found = triangle_with(|document| {
        let (short, broken) = (
            document.floats("VEC3", &[0.0; 6]),
            document.floats("VEC3", &[0., 0., 0., f32::NAN, 0., 0., 0., 0., 0.]),
        );
        let times = document.floats("SCALAR", &[0.0, 1.0]);
        let values = document.floats("SCALAR", &[0.0, 1.0, 2.0]);
        let second = document.json["meshes"][0]["primitives"][0].clone();
        document.json["meshes"][0]["primitives"][0]["targets"] =
            json!([{ "POSITION": short }, { "NORMAL": broken }, { "POSITION": 99 }]);
        document.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(second);
        document.json["meshes"][0]["weights"] = json!([1.0]);
        document.json["nodes"][0]["weights"] = json!([0.0, 1e30, 0.0]);
        document.node(json!({}));
        let channel = |node: usize| json!({ "sampler": 0, "target": { "node": node, "path": "weights" } });
        document.push(
            "animations",
            json!({ "samplers": [{ "input": times, "output": values }], "channels": [channel(0), channel(1)] }),
        );
    });
    let at = "/meshes/0/primitives";
    assert_eq!(
        found,
        [
            format!("UG0726 {at}/1/targets: primitives of mesh 0 have different numbers of morph targets (give each of them as many)"),
            "UG0726 /meshes/0/weights: mesh 0 has 1 weights, but its mesh has 3 morph targets (give one weight for each target, or none at all)".to_owned(),
            format!("UG0726 {at}/0/targets/0/POSITION: POSITION of target 0 has 2 elements, but POSITION has 3 (export the mesh again: a target has one element for each vertex)"),
            format!("UG0712 {at}/0/targets/1/NORMAL: target 1 moves vertex 1 by [NaN, 0.0, 0.0] (mend the mesh in the program that made it, and export it again)"),
            format!("UG0705 {at}/0/targets/2/POSITION: accessor 99 does not exist (the document has 5 accessors, numbered 0 to 4)"),
            "UG0726 /nodes/0/weights: weight 1 of node 0 is 1000000000000000000000000000000 (weights are mostly between 0 and 1)".to_owned(),
            "UG0721 /animations/0/samplers/0/output: 3 values stand for 2 keys, where 6 are needed (export the animation again)".to_owned(),
            "UG0721 /animations/0/channels/1: node 1 has no mesh with morph targets, so it has no weights to animate (remove the channel, or give the mesh its targets)".to_owned(),
        ]
    );
}
