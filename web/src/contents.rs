//! [`Contents`]: the texels of a texture, as one frame left them after a pass.
//!
//! A capture is an ordinary copy after the pass that is looked at, in a document that extends the pipeline
//! ([`umbragraph::low_level::capture`]). One frame is recorded with the plan of that document; then the plan before goes
//! on.

use serde_json::{Value, json};
use umbragraph::Plan;
use umbragraph::diagnostic::Diagnostics;
use umbragraph::executor::Texels;
use umbragraph::low_level::capture::{self, Capture, Wanted};
use umbragraph::low_level::sheet::{Content, Range, Sheet, sheet};
use wasm_bindgen::prelude::wasm_bindgen;

/// A picture of the texels of one mip level of a texture, and their channel values. Layers lie side by side.
#[wasm_bindgen]
pub struct Contents {
    sheet: Sheet,
    content: Content,
    ranges: Vec<Range>,
    mips: u32,
}

#[wasm_bindgen]
impl Contents {
    /// The width of the picture, in texels.
    #[wasm_bindgen(getter)]
    pub fn width(&self) -> u32 {
        self.sheet.width
    }

    /// The height of the picture, in texels.
    #[wasm_bindgen(getter)]
    pub fn height(&self) -> u32 {
        self.sheet.height
    }

    /// The number of mip levels of the texture.
    #[wasm_bindgen(getter)]
    pub fn mips(&self) -> u32 {
        self.mips
    }

    /// Returns the pixels of the picture, four bytes each (red, green, blue, alpha), row by row from the top.
    pub fn rgba(&self) -> Vec<u8> {
        self.sheet.rgba(self.content, &self.ranges)
    }

    /// Returns two values for each channel: the value shown as black, and the value shown as white. Empty if values are
    /// shown unscaled.
    pub fn ranges(&self) -> Vec<f32> {
        self.ranges.iter().flat_map(|range| [range.min, range.max]).collect()
    }

    /// Returns the channel values of the texel at column `x` and row `y` of the picture; empty for a position outside
    /// of the picture.
    pub fn texel(&self, x: u32, y: u32) -> Vec<f32> {
        let is_inside = x < self.sheet.width && y < self.sheet.height;
        let at = y as usize * self.sheet.width as usize + x as usize;
        let texel = self.sheet.values.get(at).filter(|_| is_inside);
        texel.map(|texel| texel[..self.sheet.channels].to_vec()).unwrap_or_default()
    }
}

impl Contents {
    /// Arranges captured texels as a picture. `reference` names the captured texture of `plan`, as `NAME` or
    /// `NAME@PASS`.
    pub(crate) fn new(plan: &Plan, reference: &str, texels: &Texels) -> Self {
        let name = reference.split('@').next().unwrap_or_default();
        let content = Content::of(plan, name).unwrap_or_default();
        let sheet = sheet(texels, content, None);
        let ranges = sheet.ranges(content);
        let mips = plan.resources.get(name).and_then(|one| one.size).map_or(1, |size| size.mips);
        Self { sheet, content, ranges, mips }
    }
}

/// A generated pipeline document that extends a pipeline with a pass that copies a texture.
pub(crate) struct Extended {
    /// The path of the document, in the same folder as the pipeline's document.
    pub(crate) path: String,
    pub(crate) text: String,
    /// The name of the imported texture that receives the copy.
    pub(crate) import: String,
}

impl Extended {
    /// Generates the document that copies mip level `mip` of a texture of `plan`. `reference` is `NAME` for the texture
    /// at the end of the frame, or `NAME@PASS` for the texture after a pass. `path` is the path of the pipeline.
    ///
    /// # Errors
    /// Diagnostics if the texture cannot be captured.
    pub(crate) fn new(plan: &Plan, path: &str, reference: &str, mip: u32) -> Result<Self, Diagnostics> {
        let capture = Capture { reference: reference.to_owned(), mip };
        let document = capture::document(plan, &[capture], Wanted::Pictures)?;
        let mut text: Value = serde_json::from_str(&document.text).unwrap_or_default();
        let (folder, file) = path.rsplit_once('/').map_or(("", path), |(folder, file)| (folder, file));
        text["format"] = json!(1);
        text["name"] = json!(plan.name);
        text["extends"] = json!(file);
        let beside = if folder.is_empty() { String::new() } else { format!("{folder}/") };
        let import = document.imports.into_iter().next().unwrap_or_default();
        Ok(Self { path: format!("{beside}page.captures.json"), text: text.to_string(), import })
    }
}
