//! The names of texture formats: the schema lists them, and a misspelt one was meant to be one of them.
//!
//! wgpu's type can be read from a name and written as one, but does not list what there is. Planar formats of video are
//! none here: no pass can sample them.

use std::borrow::Cow;
use std::sync::LazyLock;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize as _;
use serde::de::value::{Error as ValueError, StrDeserializer};
use wgpu_types::TextureFormat;

use crate::diagnostic::{Diagnostic, begun, codes};
use crate::source::Span;

/// The JSON Schema of the name of a texture format.
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

/// Parses the WebGPU name of a texture format; `None` for an unknown name.
pub fn parse_format(name: &str) -> Option<TextureFormat> {
    TextureFormat::deserialize(StrDeserializer::<ValueError>::new(name)).ok()
}

/// The WebGPU name of a texture format, such as `rgba16float`.
pub fn format_name(format: TextureFormat) -> String {
    serde_json::to_value(format).ok().and_then(|name| name.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Creates the diagnostic for a string at `place` that is not the name of a texture format.
pub fn unknown_format(name: &str, place: Span, pointer: String) -> Diagnostic {
    let diagnostic =
        Diagnostic::error(codes::FORMAT_UNKNOWN, place, format!("\"{name}\" is not a texture format"));
    let wide = name.strip_prefix("rgb").filter(|rest| rest.starts_with(|each: char| each.is_ascii_digit()));
    let wide = wide.map(|rest| format!("rgba{rest}"));
    let known: Vec<&str> = KNOWN_FORMATS.iter().map(String::as_str).collect();
    let four = wide
        .and_then(|wide| known.iter().copied().find(|known| *known == wide).or_else(|| begun(&wide, &known)));
    if let Some(four) = four {
        let help = format!("WebGPU has no format of three channels: use \"{four}\"");
        return diagnostic.pointer(pointer).help(help).fix(place, format!("\"{four}\""));
    }
    diagnostic.pointer(pointer).suggest(name, KNOWN_FORMATS.iter().map(String::as_str), Some(place), |_| {
        "formats have the names of the WebGPU specification".to_owned()
    })
}

/// The names of the texture formats, sorted. All combinations of channels and types are generated, and those that wgpu
/// does not know are dropped.
static KNOWN_FORMATS: LazyLock<Vec<String>> = LazyLock::new(|| {
    const CHANNELS: &str = "r8 rg8 rgba8 bgra8 r16 rg16 rgba16 r32 rg32 rgba32 r64 rgb10a2 rg11b10 rgb9e5 depth16 depth32 \
        eac-r11 eac-rg11 etc2-rgb8 etc2-rgb8a1 etc2-rgba8 bc1-rgba- bc2-rgba- bc3-rgba- bc4-r- bc5-rg- bc6h-rgb- bc7-rgba- \
        astc-4x4- astc-5x4- astc-5x5- astc-6x5- astc-6x6- astc-8x5- astc-8x6- astc-8x8- astc-10x5- astc-10x6- astc-10x8- \
        astc-10x10- astc-12x10- astc-12x12-";
    const TYPES: [&str; 7] = ["unorm", "unorm-srgb", "snorm", "uint", "sint", "float", "ufloat"];
    let regular = CHANNELS.split_whitespace().flat_map(|one| TYPES.map(|kind| format!("{one}{kind}")));
    let others = ["depth24plus", "depth24plus-stencil8", "depth32float-stencil8", "stencil8"];
    let all = regular.chain(others.map(str::to_owned));
    let mut known: Vec<String> = all.filter(|name| parse_format(name).is_some()).collect();
    known.sort();
    known
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planar_formats_alone_are_not_listed() {
        assert_eq!(KNOWN_FORMATS.len(), 102);
        for name in ["nv12", "p010"] {
            assert!(parse_format(name).is_some() && !KNOWN_FORMATS.iter().any(|known| known == name));
        }
    }
}
