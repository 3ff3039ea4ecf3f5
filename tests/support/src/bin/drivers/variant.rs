//! Variants of a scene, whose pictures tell why two drivers differ: [`Variant::Nearest`] leaves no driver a texture to
//! filter, and [`Variant::Turned`] moves every surface by a small part of a pixel, as the rounding of a rasterizer
//! does.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use umbragraph_test_support::glb::container;

/// The code of `NEAREST` filtering in OpenGL and glTF.
const NEAREST: u32 = 9728;
/// The fraction of a pixel by which a rotated camera moves the picture's centre. It equals the vertex grid at the
/// lowest `subPixelPrecisionBits` of Vulkan, which SwiftShader has.
const STEP: f64 = 1.0 / 16.0;
/// The height of all pictures, in pixels.
const ROWS: f64 = 180.0;

/// A modification of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Variant {
    /// The unmodified scene.
    Whole,
    /// The scene with nearest-texel sampling of the largest mip level.
    Nearest,
    /// The scene with a camera that is rotated by a fraction of a pixel.
    Turned(Side),
}

/// The direction in which the camera is rotated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Up,
    Down,
    Left,
    Right,
}

/// All directions.
pub(crate) const SIDES: [Side; 4] = [Side::Up, Side::Down, Side::Left, Side::Right];

impl Variant {
    /// Returns the suffix for file names; empty for the unmodified scene.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Whole => "",
            Self::Nearest => " nearest",
            Self::Turned(Side::Up) => " up",
            Self::Turned(Side::Down) => " down",
            Self::Turned(Side::Left) => " left",
            Self::Turned(Side::Right) => " right",
        }
    }

    /// Returns the file of the modified scene, and writes it into a folder if needed.
    ///
    /// # Errors
    /// A file that cannot be read or written, or is no glTF binary.
    pub(crate) fn scene(self, path: &Path, folder: &Path) -> Result<PathBuf, String> {
        if self == Self::Whole {
            return Ok(path.to_owned());
        }
        let failed = |error: std::io::Error| format!("{}: {error}", path.display());
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let to = folder.join(format!("{name}{}.glb", self.word().replace(' ', "_")));
        if !to.exists() {
            let bytes = std::fs::read(path).map_err(failed)?;
            let bytes = self.of(&bytes).ok_or_else(|| format!("{} is no glTF binary", path.display()))?;
            // Several threads may write it: each a file of its own, and the last that is renamed stays.
            let own = folder.join(format!("{:?}.glb", std::thread::current().id()));
            std::fs::write(&own, bytes).and_then(|()| std::fs::rename(&own, &to)).map_err(failed)?;
        }
        Ok(to)
    }

    fn of(self, bytes: &[u8]) -> Option<Vec<u8>> {
        let length = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?) as usize;
        let mut document: Value = serde_json::from_slice(bytes.get(20..20 + length)?).ok()?;
        let rest = bytes.get(20 + length..)?;
        match self {
            Self::Whole => {}
            Self::Nearest => sample_nearest(&mut document),
            Self::Turned(side) => turn_cameras(&mut document, side)?,
        }
        Some(container(&document.to_string(), rest.get(8..)?))
    }
}

fn sample_nearest(document: &mut Value) {
    for sampler in document.get_mut("samplers").and_then(Value::as_array_mut).into_iter().flatten() {
        sampler["magFilter"] = json!(NEAREST);
        sampler["minFilter"] = json!(NEAREST);
    }
}

/// Moves each camera to a new, rotated child node. Returns `None` if the document has an unexpected form.
fn turn_cameras(document: &mut Value, side: Side) -> Option<()> {
    let cameras = document.get("cameras").cloned().unwrap_or_default();
    let nodes = document.get_mut("nodes")?.as_array_mut()?;
    for at in 0..nodes.len() {
        let own = nodes.len();
        let Some(node) = nodes[at].as_object_mut() else { continue };
        let Some(camera) = node.remove("camera") else { continue };
        let children = node.entry("children").or_insert_with(|| json!([]));
        children.as_array_mut()?.push(json!(own));
        let half_height = cameras.pointer(&format!("/{camera}/perspective/yfov"))?.as_f64()? / 2.0;
        let half_turn = STEP * half_height.tan() / ROWS;
        let [x, y] = match side {
            Side::Up => [half_turn, 0.0],
            Side::Down => [-half_turn, 0.0],
            Side::Left => [0.0, half_turn],
            Side::Right => [0.0, -half_turn],
        };
        nodes.push(json!({ "camera": camera, "rotation": [x, y, 0.0, 1.0] }));
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(variant: Variant, document: &Value) -> (Value, Vec<u8>) {
        let bytes = variant.of(&container(&document.to_string(), &[1, 2, 3, 4])).unwrap();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        (serde_json::from_slice(&bytes[20..20 + length]).unwrap(), bytes)
    }

    #[test]
    fn samplers_become_nearest_and_the_rest_stays() {
        let document = json!({ "samplers": [{ "minFilter": 9987 }], "textures": [] });
        let (changed, bytes) = changed(Variant::Nearest, &document);
        let sampler = json!({ "minFilter": 9728, "magFilter": 9728 });
        assert_eq!(changed, json!({ "samplers": [sampler], "textures": [] }));
        assert_eq!(bytes[8..12], (bytes.len() as u32).to_le_bytes());
        assert!(bytes.ends_with(&[1, 2, 3, 4]));
        assert_eq!(Variant::Nearest.of(b"no scene"), None);
    }

    #[test]
    fn a_turned_camera_moves_by_a_sixteenth_of_a_pixel() {
        let cameras = json!([{ "type": "perspective", "perspective": { "yfov": 0.8 } }]);
        let document = json!({ "cameras": cameras, "nodes": [{ "camera": 0, "translation": [1, 2, 3] }] });
        let (changed, _) = changed(Variant::Turned(Side::Left), &document);
        assert_eq!(changed["nodes"][0], json!({ "children": [1], "translation": [1, 2, 3] }));
        assert_eq!(changed["nodes"][1]["camera"], 0);
        let half = changed["nodes"][1]["rotation"][1].as_f64().unwrap();
        let rows = (2.0 * half).tan() / (2.0 * 0.4_f64.tan() / 180.0);
        assert!((rows - 1.0 / 16.0).abs() < 1e-6, "{rows}");
    }
}
