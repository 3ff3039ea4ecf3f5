//! Subresource ranges of resources as settings say them: ranges of mips and layers, faces of cubes, aspects, bytes,
//! view formats.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::access::subresource_range::{Aspect, IndexRange, SubresourceRange};
use crate::pipeline::builder::PassBuilder;
use crate::pipeline::settings::evaluate::Evaluate;
use crate::work::Subresource;
use umbragraph_text::diagnostic::codes;
use umbragraph_text::language::{Expr, Ref, Word, parse_format};

/// A face of a cube, by its direction: layers 0 to 5 in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
pub enum Face {
    /// Layer 0.
    #[serde(rename = "+x")]
    PositiveX,
    /// Layer 1.
    #[serde(rename = "-x")]
    NegativeX,
    /// Layer 2.
    #[serde(rename = "+y")]
    PositiveY,
    /// Layer 3.
    #[serde(rename = "-y")]
    NegativeY,
    /// Layer 4.
    #[serde(rename = "+z")]
    PositiveZ,
    /// Layer 5.
    #[serde(rename = "-z")]
    NegativeZ,
}

/// The settings of a subresource range of a texture.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub struct SubresourceRangeSettings {
    /// The first mip level of a texture. By default, a binding has all levels, and a copy has the first level.
    pub mip: Option<Expr>,
    /// The number of mip levels from "mip" on; 1 by default.
    pub mips: Option<Expr>,
    /// The first layer of a texture, or the first slice of a volume; with "face", the index of the cube. By default the
    /// range has all layers or slices.
    pub layer: Option<Expr>,
    /// The number of layers or slices from "layer" on; 1 by default, if "layer" is set.
    pub layers: Option<Expr>,
    /// One face of a cube texture.
    pub face: Option<Word<Face>>,
    /// The aspect of a texture that has depth and stencil; by default, a shader reads the depth.
    pub aspect: Option<Word<Aspect>>,
}

impl PassBuilder<'_> {
    /// Evaluates the settings of a subresource range; returns `None` after a diagnostic.
    pub fn subresource_range(
        &mut self,
        settings: &SubresourceRangeSettings,
        at: &str,
    ) -> Option<SubresourceRange> {
        let mip = self.run(&settings.mip, &settings.mips, at, ["mip", "mips"])?;
        let mut layer = self.run(&settings.layer, &settings.layers, at, ["layer", "layers"])?;
        if let Some(face) = &settings.face {
            let face = self.word(face, &format!("{at}/face"))? as u32;
            let cube = layer.map_or(0, |run| run.first);
            let Some(first) = cube.checked_mul(6).and_then(|first| first.checked_add(face)) else {
                let message = format!("there is no cube {cube}");
                let help = "count cubes from 0";
                return self.reject(codes::OUT_OF_BOUNDS, &format!("{at}/layer"), message, help);
            };
            if settings.layers.is_some() {
                let help = "remove \"layers\", or say the first layer by its number";
                let message = "a face is one layer";
                return self.reject(codes::OUT_OF_BOUNDS, &format!("{at}/layers"), message, help);
            }
            layer = Some(IndexRange::one(first));
        }
        let aspect = self.word_or(&settings.aspect, format_args!("{at}/aspect"), Aspect::All)?;
        Some(SubresourceRange { mip, layer, aspect, bytes: None })
    }

    fn run(
        &mut self,
        first: &Option<Expr>,
        count: &Option<Expr>,
        at: &str,
        [one, several]: [&str; 2],
    ) -> Option<Option<IndexRange<u32>>> {
        let first = self.count_if(first, format_args!("{at}/{one}"))?;
        let count = self.count_if(count, format_args!("{at}/{several}"))?;
        if count == Some(0) {
            let message = format!("\"{several}\" is 0, the minimum is 1");
            let help = format!("remove \"{several}\" for all, or give a positive number");
            return self.reject(codes::OUT_OF_BOUNDS, &format!("{at}/{several}"), message, help);
        }
        let run = (first.is_some() || count.is_some())
            .then(|| IndexRange { first: first.unwrap_or(0), count: count.unwrap_or(1) });
        Some(run)
    }

    /// Evaluates a range of `size` bytes from `offset`. The outer `None` follows a diagnostic; the inner `None` means
    /// the whole buffer.
    pub fn bytes(
        &mut self,
        offset: Option<&Expr>,
        size: Option<&Expr>,
        at: &str,
    ) -> Option<Option<IndexRange<u64>>> {
        let first = match offset {
            Some(expr) => u64::from(self.count(expr, &format!("{at}/offset"))?),
            None => 0,
        };
        let Some(expr) = size else {
            if first > 0 {
                let help = "add \"size\", the number of bytes";
                let message = format!("\"offset\" is {first}, but \"size\" is missing");
                return self.reject(codes::MISSING_KEY, at, message, help);
            }
            return Some(None);
        };
        let pointer = format!("{at}/size");
        let count = u64::from(self.count(expr, &pointer)?);
        if count == 0 {
            let message = "a range of no bytes";
            let help = "a range has at least one byte";
            return self.reject(codes::OUT_OF_BOUNDS, &pointer, message, help);
        }
        Some(Some(IndexRange { first, count }))
    }

    /// Resolves a reference to bytes of a buffer, or to all of it if `bytes` is `None`; returns `None` after a
    /// diagnostic.
    pub fn buffer_range(
        &mut self,
        reference: &Ref,
        bytes: Option<IndexRange<u64>>,
        pointer: &str,
    ) -> Option<Subresource> {
        self.buffer_named(reference, SubresourceRange { bytes, ..SubresourceRange::WHOLE }, pointer)
    }

    /// Parses a texture format by its WebGPU name; returns `None` after a diagnostic.
    pub fn format(&mut self, name: &str, pointer: &str) -> Option<wgpu_types::TextureFormat> {
        let found = parse_format(name);
        if found.is_none() {
            let message = format!("\"{name}\" is not a texture format");
            self.report_unknown(codes::FORMAT_UNKNOWN, pointer, message, name, KNOWN_VIEWS, || {
                "formats have the names of the WebGPU specification".to_owned()
            });
        }
        found
    }
}

/// Texture formats that can be viewed as one another, for suggestions where a name is misspelt.
const KNOWN_VIEWS: &[&str] = &["rgba8unorm", "rgba8unorm-srgb", "bgra8unorm", "bgra8unorm-srgb"];
