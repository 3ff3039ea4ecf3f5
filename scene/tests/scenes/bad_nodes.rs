//! Diagnostics of nodes, cameras, lights, materials and animations that cannot be used.

use serde_json::json;

use crate::bad_input::triangle_with;
use crate::document::{Document, diagnostics, line};

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
fn a_cyclic_hierarchy_and_a_second_parent_are_named() {
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
fn factors_and_extensions_of_materials_have_a_range() {
    let mut document = Document::triangle();
    document.push("textures", json!({ "source": 0 }));
    document.push("materials", json!({
        "pbrMetallicRoughness": { "metallicFactor": -1, "roughnessFactor": 1.5 },
        "normalTexture": { "index": 0, "texCoord": 2 },
        "extensions": {
            "KHR_materials_ior": { "ior": 0.5 }, "KHR_materials_emissive_strength": { "emissiveStrength": "much" },
            "KHR_materials_specular": { "specularColorFactor": [1, -1, 1] },
        },
    }));
    let mut found = diagnostics(document.load());
    found.retain(|line| line.starts_with("UG0719"));
    assert_eq!(
        found,
        [
            "UG0719 /materials/0/pbrMetallicRoughness/metallicFactor: a factor of material 0 is negative or not finite: [-1.0] (set it between 0 and 1)",
            "UG0719 /materials/0/pbrMetallicRoughness/roughnessFactor: a factor of material 0 is above 1: [1.5] (set it between 0 and 1)",
            "UG0719 /materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength: emissiveStrength is \"much\" (it is a number)",
            "UG0719 /materials/0/extensions/KHR_materials_ior/ior: the index of refraction is 0.5 (it is 0, or at least 1; glass has 1.5)",
            "UG0719 /materials/0/extensions/KHR_materials_specular/specularColorFactor: specularColorFactor is negative: [1.0, -1.0, 1.0] (set it to 0 or more)",
            "UG0719 /materials/0/normalTexture/texCoord: a texture uses the texture coordinates TEXCOORD_2 (use the sets 0 and 1; others are not read)",
        ]
    );
}

#[test]
fn maps_without_texture_coordinates_are_a_warning() {
    let mut document = Document::triangle();
    let mut png = Vec::new();
    let texels = image::RgbaImage::from_pixel(1, 1, image::Rgba([128, 128, 255, 255]));
    texels.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    let view = document.view(&png);
    document.push("images", json!({ "bufferView": view }));
    document.push("textures", json!({ "source": 0 }));
    document.push("materials", json!({ "normalTexture": { "index": 0, "texCoord": 1 } }));
    document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let scene = document.load().unwrap();
    let warnings: Vec<&str> = scene.warnings.iter().map(|warning| warning.message.as_str()).collect();
    assert_eq!(warnings, ["the normal texture wants TEXCOORD_1, which the primitive does not have"]);
    assert_eq!(scene.primitive(scene.draws().next().unwrap()).details.as_ref().map(Vec::len), Some(3));
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
            "UG0718 /images/0: image 0 cannot be decoded: its first bytes are those of neither PNG nor JPEG (use a PNG or JPEG image)",
            "UG0705 /textures/1/sampler: sampler 4 does not exist (the document has one sampler, number 0)",
            "UG0718 /images/1: image 1 has neither a URI nor a buffer view (export the scene with its textures)",
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
fn animations_without_channels_or_with_bad_times_are_found() {
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

#[test]
fn rotations_of_length_zero_are_found() {
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
