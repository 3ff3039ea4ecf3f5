//! Numbers in accessors, and vertices in triangles.

use serde_json::json;

use crate::document::Document;

#[test]
fn signed_integers_are_decoded_plain_or_normalised() {
    let bytes: Vec<u8> = [0_i8, 0, 127, -64, -128, -127].iter().map(|value| *value as u8).collect();
    let shorts: Vec<u8> =
        [0_i16, 0, 32767, -300, -32768, -32767].iter().flat_map(|value| value.to_le_bytes()).collect();
    for (kind, bytes, plain, scaled) in [
        (5120, bytes, [[0.0, 0.0], [127.0, -64.0], [-128.0, -127.0]], -64.0 / 127.0),
        (5122, shorts, [[0.0, 0.0], [32767.0, -300.0], [-32768.0, -32767.0]], -300.0 / 32767.0),
    ] {
        for normalized in [false, true] {
            let mut document = Document::triangle();
            let view = document.view(&bytes);
            let accessor = json!({ "bufferView": view, "componentType": kind, "count": 3, "type": "VEC2", "normalized": normalized });
            let texcoords = document.push("accessors", accessor);
            document.attribute("TEXCOORD_0", texcoords);
            let scene = document.load().unwrap();
            let found = &scene.primitive(scene.draws().next().unwrap()).texcoords;
            let wanted = if normalized { [[0.0, 0.0], [1.0, scaled], [-1.0, -1.0]] } else { plain };
            assert_eq!(*found, wanted, "{kind} {normalized}");
        }
    }
}

#[test]
fn a_sparse_accessor_can_replace_every_element() {
    let mut document = Document::triangle();
    let indices: Vec<u8> = [0_u16, 2, 1].iter().flat_map(|index| index.to_le_bytes()).collect();
    let places: Vec<u8> = (1..10).flat_map(|value| (value as f32).to_le_bytes()).collect();
    let (indices, values) = (document.view(&indices), document.view(&places));
    document.json["accessors"][0]["sparse"] = json!({
        "count": 3, "indices": { "bufferView": indices, "componentType": 5123 }, "values": { "bufferView": values },
    });
    let scene = document.load().unwrap();
    let primitive = scene.primitive(scene.draws().next().unwrap());
    assert_eq!(primitive.positions, [[1.0, 2.0, 3.0], [7.0, 8.0, 9.0], [4.0, 5.0, 6.0]]);
}

#[test]
fn triangles_of_a_fan_share_its_first_vertex() {
    let mut document = Document::triangle();
    let corners = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    let quad = document.floats("VEC3", corners.as_flattened());
    document.json["meshes"][0]["primitives"] = json!([{ "attributes": { "POSITION": quad }, "mode": 6 }]);
    let scene = document.load().unwrap();
    let primitive = scene.primitive(scene.draws().next().unwrap());
    assert_eq!(primitive.positions, [1, 2, 0, 2, 3, 0].map(|at| corners[at]));
    assert_eq!(primitive.normals, [[0.0, 0.0, 1.0]; 6]);
}
