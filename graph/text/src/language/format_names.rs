//! The names of texture formats: the schema lists them, and a misspelt one was meant to be one of them.
//!
//! wgpu's type can be read from a name and written as one, but does not list what there is.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize as _;
use serde::de::value::{Error as ValueError, StrDeserializer};
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
            "enum": KNOWN_FORMATS,
        })
    }
}

/// A texture format by its WebGPU name.
pub fn parse_format(name: &str) -> Option<TextureFormat> {
    TextureFormat::deserialize(StrDeserializer::<ValueError>::new(name)).ok()
}

/// The WebGPU name of a format.
pub fn format_name(format: TextureFormat) -> String {
    serde_json::to_value(format).ok().and_then(|name| name.as_str().map(str::to_owned)).unwrap_or_default()
}

/// The diagnostic for a name that is none of a format's, which stands at a place.
pub fn unknown_format(name: &str, place: Span, pointer: String) -> Diagnostic {
    let diagnostic =
        Diagnostic::error(codes::FORMAT_UNKNOWN, place, format!("\"{name}\" is not a texture format"));
    diagnostic.pointer(pointer).suggest(name, KNOWN_FORMATS.iter().copied(), Some(place), |_| {
        "formats have the names of the WebGPU specification".to_owned()
    })
}

/// The texture formats by name, sorted.
const KNOWN_FORMATS: &[&str] = &[
    "astc-10x10-unorm",
    "astc-10x10-unorm-srgb",
    "astc-10x5-unorm",
    "astc-10x5-unorm-srgb",
    "astc-10x6-unorm",
    "astc-10x6-unorm-srgb",
    "astc-10x8-unorm",
    "astc-10x8-unorm-srgb",
    "astc-12x10-unorm",
    "astc-12x10-unorm-srgb",
    "astc-12x12-unorm",
    "astc-12x12-unorm-srgb",
    "astc-4x4-unorm",
    "astc-4x4-unorm-srgb",
    "astc-5x4-unorm",
    "astc-5x4-unorm-srgb",
    "astc-5x5-unorm",
    "astc-5x5-unorm-srgb",
    "astc-6x5-unorm",
    "astc-6x5-unorm-srgb",
    "astc-6x6-unorm",
    "astc-6x6-unorm-srgb",
    "astc-8x5-unorm",
    "astc-8x5-unorm-srgb",
    "astc-8x6-unorm",
    "astc-8x6-unorm-srgb",
    "astc-8x8-unorm",
    "astc-8x8-unorm-srgb",
    "bc1-rgba-unorm",
    "bc1-rgba-unorm-srgb",
    "bc2-rgba-unorm",
    "bc2-rgba-unorm-srgb",
    "bc3-rgba-unorm",
    "bc3-rgba-unorm-srgb",
    "bc4-r-snorm",
    "bc4-r-unorm",
    "bc5-rg-snorm",
    "bc5-rg-unorm",
    "bc6h-rgb-float",
    "bc6h-rgb-ufloat",
    "bc7-rgba-unorm",
    "bc7-rgba-unorm-srgb",
    "bgra8unorm",
    "bgra8unorm-srgb",
    "depth16unorm",
    "depth24plus",
    "depth24plus-stencil8",
    "depth32float",
    "depth32float-stencil8",
    "eac-r11snorm",
    "eac-r11unorm",
    "eac-rg11snorm",
    "eac-rg11unorm",
    "etc2-rgb8a1unorm",
    "etc2-rgb8a1unorm-srgb",
    "etc2-rgb8unorm",
    "etc2-rgb8unorm-srgb",
    "etc2-rgba8unorm",
    "etc2-rgba8unorm-srgb",
    "r16float",
    "r16sint",
    "r16snorm",
    "r16uint",
    "r16unorm",
    "r32float",
    "r32sint",
    "r32uint",
    "r64uint",
    "r8sint",
    "r8snorm",
    "r8uint",
    "r8unorm",
    "rg11b10ufloat",
    "rg16float",
    "rg16sint",
    "rg16snorm",
    "rg16uint",
    "rg16unorm",
    "rg32float",
    "rg32sint",
    "rg32uint",
    "rg8sint",
    "rg8snorm",
    "rg8uint",
    "rg8unorm",
    "rgb10a2uint",
    "rgb10a2unorm",
    "rgb9e5ufloat",
    "rgba16float",
    "rgba16sint",
    "rgba16snorm",
    "rgba16uint",
    "rgba16unorm",
    "rgba32float",
    "rgba32sint",
    "rgba32uint",
    "rgba8sint",
    "rgba8snorm",
    "rgba8uint",
    "rgba8unorm",
    "rgba8unorm-srgb",
    "stencil8",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_that_of_a_texture_format() {
        assert!(KNOWN_FORMATS.is_sorted());
        for name in KNOWN_FORMATS {
            assert!(parse_format(name).is_some(), "{name}");
        }
    }
}
