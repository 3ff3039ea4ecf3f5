//! The names of texture formats: the schema lists them, and a misspelt one was meant to be one of them.
//!
//! wgpu's type can be read from a name and written as one, but does not list what there is.

use std::borrow::Cow;
use std::sync::LazyLock;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use wgpu_types::TextureFormat;

use crate::diagnostic::{Diagnostic, codes};
use crate::source::Span;

/// The schema of a format's name.
pub(super) struct FormatName;

impl JsonSchema for FormatName {
    fn schema_name() -> Cow<'static, str> {
        "FormatName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A texture format of the WebGPU specification.",
            "type": "string",
            "enum": *KNOWN_FORMATS,
        })
    }
}

/// A texture format by its WebGPU name.
pub fn parse_format(name: &str) -> Option<TextureFormat> {
    serde_json::from_value(name.into()).ok()
}

/// The WebGPU name of a format.
pub fn format_name(format: TextureFormat) -> String {
    serde_json::to_value(format).ok().and_then(|name| name.as_str().map(str::to_owned)).unwrap_or_default()
}

/// The diagnostic for a name that is none of a format's, which stands at a place.
pub fn unknown_format(name: &str, place: Span, pointer: String) -> Diagnostic {
    let diagnostic =
        Diagnostic::error(codes::FORMAT_UNKNOWN, place, format!("\"{name}\" is not a texture format"));
    diagnostic.pointer(pointer).suggest(name, KNOWN_FORMATS.iter().map(String::as_str), Some(place), |_| {
        "formats have the names of the WebGPU specification".to_owned()
    })
}

/// How formats are named: each of these beginnings with each of these ends, as far as there is such a format.
const FAMILIES: [(&[&str], &[&str]); 6] = [
    (
        &["r8", "r16", "r32", "r64", "rg8", "rg16", "rg32", "rgba8", "rgba16", "rgba32", "bgra8", "rgb10a2"],
        &["float", "sint", "snorm", "uint", "unorm", "unorm-srgb"],
    ),
    (&["bc1-rgba-", "bc2-rgba-", "bc3-rgba-", "bc7-rgba-"], &["unorm", "unorm-srgb"]),
    (&["bc4-r-", "bc5-rg-", "bc6h-rgb-", "eac-r11", "eac-rg11"], &["float", "snorm", "ufloat", "unorm"]),
    (&["etc2-rgb8", "etc2-rgb8a1", "etc2-rgba8"], &["unorm", "unorm-srgb"]),
    (
        &[
            "astc-4x4-",
            "astc-5x4-",
            "astc-5x5-",
            "astc-6x5-",
            "astc-6x6-",
            "astc-8x5-",
            "astc-8x6-",
            "astc-8x8-",
            "astc-10x5-",
            "astc-10x6-",
            "astc-10x8-",
            "astc-10x10-",
            "astc-12x10-",
            "astc-12x12-",
        ],
        &["unorm", "unorm-srgb"],
    ),
    (
        &["depth16", "depth24", "depth32", "rg11b10", "rgb9e5", "stencil8"],
        &["", "float", "float-stencil8", "plus", "plus-stencil8", "ufloat", "unorm"],
    ),
];

/// The texture formats by name, sorted.
static KNOWN_FORMATS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let mut names = Vec::new();
    for (beginnings, ends) in FAMILIES {
        let of_family =
            beginnings.iter().flat_map(|start| ends.iter().map(move |end| format!("{start}{end}")));
        names.extend(of_family.filter(|name| parse_format(name).is_some()));
    }
    names.sort();
    names
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_that_of_a_texture_format() {
        assert!(KNOWN_FORMATS.is_sorted());
        assert_eq!(KNOWN_FORMATS.len(), 102);
        for name in KNOWN_FORMATS.iter() {
            assert!(parse_format(name).is_some(), "{name}");
        }
    }
}
