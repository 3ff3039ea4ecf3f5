//! Diagnostics of meshes that cannot be drawn: accessors, attributes, skins, morph targets, levels of detail.

use serde_json::json;

use crate::bad_input::triangle_with;
use crate::document::{Document, line};

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

/// A triangle document whose node lists `ids` as coarser levels of detail, after a change.
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
fn levels_of_detail_replace_a_node_and_are_not_shown_twice() {
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
