//! A small writer of glTF documents for tests: JSON values beside a growing binary chunk.

use serde_json::{Value, json};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place};
use umbragraph_scene::{NoFiles, Scene, from_slice};

/// A glTF document under construction. Tests change `json` directly.
pub(crate) struct Document {
    pub(crate) json: Value,
    pub(crate) binary: Vec<u8>,
}

impl Document {
    /// Creates a document with an empty scene and no other objects.
    pub(crate) fn new() -> Self {
        let json = json!({
            "asset": { "version": "2.0" },
            "scenes": [{ "nodes": [] }],
            "nodes": [], "meshes": [], "materials": [], "accessors": [], "bufferViews": [], "buffers": [{}],
        });
        Self { json, binary: Vec::new() }
    }

    /// Creates a document with one triangle in the plane z = 0, facing +Z, shown by node 0.
    pub(crate) fn triangle() -> Self {
        let mut document = Self::new();
        let positions = document.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let mesh =
            document.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }));
        document.node(json!({ "mesh": mesh }));
        document
    }

    /// Adds an object to a list of the document, and returns its index.
    pub(crate) fn push(&mut self, list: &str, object: Value) -> usize {
        if self.json.get(list).is_none() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(object);
        list.len() - 1
    }

    /// Adds a node to the scene, and returns its index.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("a list").push(json!(index));
        index
    }

    /// Adds bytes to the binary chunk, and returns the index of their buffer view.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// Adds an accessor of floats of the type `kind`, such as `VEC3`, and returns its index.
    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let parts = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let count = values.len() / parts;
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind }),
        )
    }

    /// Adds an accessor of 16-bit integers of the type `kind`, `VEC4` or `SCALAR`, and returns its index.
    pub(crate) fn shorts(&mut self, kind: &str, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = values.len() / if kind == "VEC4" { 4 } else { 1 };
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5123, "count": count, "type": kind }),
        )
    }

    /// Sets an attribute of the first primitive to an accessor.
    pub(crate) fn attribute(&mut self, name: &str, accessor: usize) {
        self.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    }

    /// Creates a triangle document whose material has a texture with this image file.
    pub(crate) fn pictured(bytes: &[u8]) -> Self {
        let mut document = Self::triangle();
        let view = document.view(bytes);
        document.push("images", json!({ "bufferView": view }));
        document.push("textures", json!({ "source": 0 }));
        document.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
        document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let texcoords = document.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        document.attribute("TEXCOORD_0", texcoords);
        document
    }

    /// Writes the document as a binary glTF.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = json!(self.binary.len());
        glb(&json, &self.binary)
    }

    pub(crate) fn load(&self) -> Result<Scene, Diagnostics> {
        from_slice("test.glb", &self.glb(), &NoFiles)
    }
}

pub(crate) fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    umbragraph_test_support::glb::container(&json.to_string(), binary)
}

/// Formats a diagnostic as one line: `UG0712 /meshes/0: message (help)`.
pub(crate) fn line(diagnostic: &Diagnostic) -> String {
    let Place::File { path, locator } = &diagnostic.place else {
        panic!("a diagnostic without a file: {diagnostic:?}")
    };
    assert_eq!(path, "test.glb");
    format!(
        "{} {locator}: {} ({})",
        diagnostic.code,
        diagnostic.message,
        diagnostic.help.as_deref().expect("a help line")
    )
}

/// The diagnostics of a document that cannot be loaded, one line each.
pub(crate) fn diagnostics(loaded: Result<Scene, Diagnostics>) -> Vec<String> {
    loaded.expect_err("diagnostics").iter().map(line).collect()
}
