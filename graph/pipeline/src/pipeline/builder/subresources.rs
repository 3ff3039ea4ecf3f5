//! Subresource ranges of resources as settings say them: ranges of mips and layers, faces of cubes, aspects, bytes,
//! view formats.

use schemars::JsonSchema;
use serde::Deserialize;

use super::PassBuilder;
use crate::diagnostic::codes;
use crate::language::{Expr, Word, parse_format};
use crate::pipeline::{Aspect, IndexRange, SubresourceRange};
use crate::work::Subresource;

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

/// The settings of a subresource range of a texture; each is a key of the object at the pointer.
#[derive(Clone, Copy, Debug, Default)]
pub struct SubresourceRangeSettings<'a> {
    /// `mip`: the first mip level.
    pub mip: Option<&'a Expr>,
    /// `mips`: how many from there; 1 without it.
    pub mips: Option<&'a Expr>,
    /// `layer`: the first layer; beside `face` the cube.
    pub layer: Option<&'a Expr>,
    /// `layers`: how many from there; 1 without it.
    pub layers: Option<&'a Expr>,
    /// `face`: of a cube.
    pub face: Option<&'a Word<Face>>,
    /// `aspect`: depth or stencil.
    pub aspect: Option<&'a Word<Aspect>>,
}

impl PassBuilder<'_> {
    /// The subresource range that settings name.
    pub fn subresource_range(
        &mut self,
        settings: SubresourceRangeSettings<'_>,
        at: &str,
    ) -> Option<SubresourceRange> {
        let mip = self.run(settings.mip, settings.mips, at, ["mip", "mips"])?;
        let mut layer = self.run(settings.layer, settings.layers, at, ["layer", "layers"])?;
        if let Some(face) = settings.face {
            let face = self.word(face, &format!("{at}/face"))? as u32;
            let cube = layer.map_or(0, |run| run.first);
            let Some(first) = cube.checked_mul(6).and_then(|first| first.checked_add(face)) else {
                let message = format!("there is no cube {cube}");
                self.report(codes::OUT_OF_BOUNDS, &format!("{at}/layer"), message, "count cubes from 0");
                return None;
            };
            if settings.layers.is_some() {
                let help = "remove \"layers\", or say the first layer by its number";
                self.report(codes::OUT_OF_BOUNDS, &format!("{at}/layers"), "a face is one layer", help);
                return None;
            }
            layer = Some(IndexRange::one(first));
        }
        let aspect = match settings.aspect {
            Some(word) => self.word(word, &format!("{at}/aspect"))?,
            None => Aspect::All,
        };
        Some(SubresourceRange { mip, layer, aspect, bytes: None })
    }

    fn run(
        &mut self,
        first: Option<&Expr>,
        count: Option<&Expr>,
        at: &str,
        [one, several]: [&str; 2],
    ) -> Option<Option<IndexRange<u32>>> {
        let number = |pass: &mut Self, expr: Option<&Expr>, key: &str| match expr {
            Some(expr) => pass.count(expr, &format!("{at}/{key}")).map(Some),
            None => Some(None),
        };
        let (first, count) = (number(self, first, one)?, number(self, count, several)?);
        if count == Some(0) {
            let message = format!("{several} are counted from 1");
            let help = format!("remove \"{several}\" for all, or give a positive number");
            self.report(codes::OUT_OF_BOUNDS, &format!("{at}/{several}"), message, help);
            return None;
        }
        let run = (first.is_some() || count.is_some())
            .then(|| IndexRange { first: first.unwrap_or(0), count: count.unwrap_or(1) });
        Some(run)
    }

    /// Bytes of a buffer from `offset`, as many as `size` says; `None` inside for all of it.
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
                let message = "an offset without a size says no range";
                self.report(codes::MISSING_KEY, at, message, help);
                return None;
            }
            return Some(None);
        };
        let pointer = format!("{at}/size");
        let count = u64::from(self.count(expr, &pointer)?);
        if count == 0 {
            self.report(
                codes::OUT_OF_BOUNDS,
                &pointer,
                "a range of no bytes",
                "a range has at least one byte",
            );
            return None;
        }
        Some(Some(IndexRange { first, count }))
    }

    /// Bytes of a buffer that a reference names.
    pub fn buffer_range(
        &mut self,
        reference: &str,
        bytes: Option<IndexRange<u64>>,
        pointer: &str,
    ) -> Option<Subresource> {
        self.buffer_named(reference, SubresourceRange { bytes, ..SubresourceRange::WHOLE }, pointer)
    }

    /// A texture format by its WebGPU name.
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

/// The formats that are seen as one another.
const KNOWN_VIEWS: &[&str] = &["rgba8unorm", "rgba8unorm-srgb", "bgra8unorm", "bgra8unorm-srgb"];
