//! Parses bytes into the document and its binary chunk.
//!
//! A file that begins with `glTF` is a binary glTF (GLB, glTF 2.0 specification, chapter 4): a header and chunks, all
//! lengths little-endian. Anything else has to be the JSON itself. Chunks of unknown types are skipped, as the
//! specification asks.

use gltf::json::Root;

use super::limits::{BYTES_PER_OBJECT, FREE_OBJECTS, MAX_JSON_BYTES, MAX_OBJECTS};
use super::report::Report;
use crate::codes;

const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// The parsed JSON document and the binary chunk of a scene file. `binary` is `None` for a file without a binary chunk.
pub(super) struct Container<'a> {
    pub(super) root: Root,
    pub(super) binary: Option<&'a [u8]>,
}

/// Splits a file into JSON and binary chunk, and parses the JSON. Returns `None` after reporting an error.
pub(super) fn open<'a>(bytes: &'a [u8], report: &mut Report) -> Option<Container<'a>> {
    let (json, binary) = if bytes.starts_with(b"glTF") { split(bytes, report)? } else { (bytes, None) };
    let objects = json.iter().filter(|byte| **byte == b'{').count();
    let max = MAX_OBJECTS.min(FREE_OBJECTS + json.len() / BYTES_PER_OBJECT);
    if json.len() > MAX_JSON_BYTES || objects > max {
        return report.reject(
            codes::TOO_LARGE,
            "",
            format!("the document has {} bytes of JSON with {objects} objects", json.len()),
            format!(
                "at most {} MiB and {MAX_OBJECTS} objects are read, and beyond {FREE_OBJECTS} one for each {BYTES_PER_OBJECT} bytes",
                MAX_JSON_BYTES >> 20
            ),
        );
    }
    let root = parse(json, report)?;
    check_version(&root, report).then_some(Container { root, binary })
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes)
}

fn split<'a>(bytes: &'a [u8], report: &mut Report) -> Option<(&'a [u8], Option<&'a [u8]>)> {
    let mut broken = |message: String| {
        report.reject(
            codes::BROKEN_CONTAINER,
            "",
            message,
            "export the file again, or copy it again in binary mode",
        )
    };
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return broken(format!(
            "the file ends after {} bytes, inside the header of a binary glTF",
            bytes.len()
        ));
    };
    if version != 2 {
        return report.reject(
            codes::UNSUPPORTED_VERSION,
            "",
            format!("the file is a binary glTF of version {version}"),
            "export it as glTF 2.0",
        );
    }
    let length = length as usize;
    if length > bytes.len() || length < HEADER_BYTES {
        return broken(format!("the header says {length} bytes, but the file has {}", bytes.len()));
    }
    let (mut json, mut binary) = (None, None);
    let mut rest = &bytes[HEADER_BYTES..length];
    while !rest.is_empty() {
        let at = length - rest.len();
        let (Some(size), Some(kind)) = (word(rest, 0), rest.get(4..CHUNK_HEADER_BYTES)) else {
            return broken(format!("the file ends inside the chunk header at byte {at}"));
        };
        let Some(content) = rest[CHUNK_HEADER_BYTES..].get(..size as usize) else {
            let left = rest.len() - CHUNK_HEADER_BYTES;
            return broken(format!("the chunk at byte {at} says {size} bytes, but {left} are left"));
        };
        match kind {
            b"JSON" if json.is_none() => json = Some(content),
            b"BIN\0" if binary.is_none() => binary = Some(content),
            _ => {}
        }
        rest = &rest[CHUNK_HEADER_BYTES + size as usize..];
    }
    match json {
        Some(json) => Some((json, binary)),
        None => broken("the file has no JSON chunk".to_owned()),
    }
}

fn parse(json: &[u8], report: &mut Report) -> Option<Root> {
    let mut deserializer = serde_json::Deserializer::from_slice(json);
    let parsed = serde_path_to_error::deserialize(&mut deserializer);
    let found = match parsed {
        Ok(root) => deserializer.end().map(|()| root).map_err(|error| (String::new(), error)),
        Err(error) => Err((pointer(error.path()), error.into_inner())),
    };
    match found {
        Ok(root) => Some(root),
        Err((pointer, error)) => {
            let begins = json.iter().find(|byte| !byte.is_ascii_whitespace());
            let (message, help) = match error.classify() {
                _ if begins.is_none() => {
                    (format!("the document cannot be parsed: {error}"), "the file is empty")
                }
                _ if begins != Some(&b'{') => (
                    "the file is no glTF: it is neither JSON nor a binary glTF".to_owned(),
                    "scenes are .gltf or .glb: convert the file (in Blender: File, Export, glTF 2.0)",
                ),
                serde_json::error::Category::Data
                    if error.to_string().starts_with("missing field `asset`") =>
                {
                    (
                        "the file is no glTF: it is JSON without \"asset\"".to_owned(),
                        "give a .gltf or .glb; values of parameters are given with --params",
                    )
                }
                serde_json::error::Category::Data => (
                    format!("the document cannot be parsed: {error}"),
                    "see the glTF 2.0 specification for this property",
                ),
                _ => {
                    (format!("the document cannot be parsed: {error}"), "the JSON is broken; export it again")
                }
            };
            let locator = match error.classify() {
                serde_json::error::Category::Data if !pointer.is_empty() => pointer,
                _ => format!("line {}, column {}", error.line(), error.column()),
            };
            report.reject(codes::BROKEN_JSON, &locator, message, help)
        }
    }
}

/// Converts the path of a JSON deserialization error to a JSON pointer.
fn pointer(path: &serde_path_to_error::Path) -> String {
    use serde_path_to_error::Segment;
    let segment = |segment: &Segment| match segment {
        Segment::Seq { index } => format!("/{index}"),
        Segment::Map { key } => format!("/{}", key.replace('~', "~0").replace('/', "~1")),
        Segment::Enum { .. } | Segment::Unknown => String::new(),
    };
    path.iter().map(segment).collect()
}

/// The glTF extensions that a document may list in `extensionsRequired`.
const EXTENSIONS: [&str; 8] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "MSFT_lod",
];

fn check_version(root: &Root, report: &mut Report) -> bool {
    let mut usable = true;
    let needed = root.asset.min_version.as_deref().unwrap_or(&root.asset.version);
    if needed != "2.0" && (root.asset.min_version.is_some() || !needed.starts_with("2.")) {
        report.error(
            codes::UNSUPPORTED_VERSION,
            if root.asset.min_version.is_some() { "/asset/minVersion" } else { "/asset/version" },
            format!("the document needs a reader of glTF {needed:?}"),
            "export it as glTF 2.0",
        );
        usable = false;
    }
    for (at, extension) in root.extensions_required.iter().enumerate() {
        if !EXTENSIONS.contains(&extension.as_str()) {
            report.error(
                codes::UNSUPPORTED_EXTENSION,
                &format!("/extensionsRequired/{at}"),
                format!("the document requires the extension {extension:?}"),
                "export the scene without it",
            );
            usable = false;
        }
    }
    usable
}
