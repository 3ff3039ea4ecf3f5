//! Diagnostics of a broken document: code, place, message and help, all at once.

use serde_json::{Value, json};
use umbragraph_pipeline::diagnostic::Place;
use umbragraph_scene::{NoFiles, from_slice};

use crate::document::{Document, diagnostics, glb, line};

/// Loads the triangle document after a change, and returns its diagnostics as lines.
pub(crate) fn triangle_with(change: impl FnOnce(&mut Document)) -> Vec<String> {
    let mut document = Document::triangle();
    change(&mut document);
    diagnostics(document.load())
}

pub(crate) fn of_bytes(bytes: &[u8]) -> Vec<String> {
    diagnostics(from_slice("test.glb", bytes, &NoFiles))
}

pub(crate) fn of_json(json: &Value) -> Vec<String> {
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
fn broken_json_has_a_line_and_a_wrong_type_a_pointer() {
    assert_eq!(
        of_bytes(b"{\n  \"asset\": nothing }"),
        ["UG0702 line 2, column 13: the document cannot be parsed: expected ident at line 2 column 13 \
          (the JSON is broken; export it again)"]
    );
    let obj = &of_bytes(b"v 0 0 0\nv 1 0 0\n")[0];
    assert!(obj.contains("the file is no glTF") && obj.contains("convert the file"), "{obj}");
    let parameters = &of_bytes(br#"{ "format": 1 }"#)[0];
    assert!(parameters.contains("JSON without \"asset\"") && parameters.contains("--params"), "{parameters}");
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
