//! WebGPU's rules for creating a texture, whatever is done with it. These are the rows of its validation of
//! `createTexture` that limits (in [`crate::resources::size`]) and accesses of formats (in
//! [`crate::resources::format`]) do not cover.
//!
//! - several samples: one mip level, one layer, no volume, no storage, a format that can be an attachment;
//! - volumes: no depth or stencil, no compressed format;
//! - compressed formats: width and height in whole blocks.
//!
//! Module `format` checks that views change a format only between sRGB and linear. Module `size` checks that mip levels
//! are no more than the sides allow, and that cubes are square. One-dimensional textures and transient attachments are
//! not in the language. Source: <https://www.w3.org/TR/webgpu/#abstract-opdef-validating-gputexturedescriptor>.

use wgpu_types::{TextureFormat, TextureUsages};

use crate::request::texture_size::TextureSize;
use umbragraph_pipeline::language::{TextureDeclaration, TextureShape};

/// Returns the first WebGPU rule that a multisampled texture breaks: JSON pointer of the setting, message and help
/// text. `None` if the size is valid.
pub(crate) fn of_size(
    name: &str,
    texture: &TextureDeclaration,
    size: TextureSize,
) -> Option<(&'static str, String, &'static str)> {
    let samples = size.samples;
    if samples == 1 {
        return None;
    }
    if texture.view_dimension == Some(TextureShape::D3) {
        let message = format!("the volume \"{name}\" has {samples} samples");
        return Some(("/texture/samples", message, "a volume has one sample: remove \"samples\""));
    }
    if size.mips > 1 {
        let message = format!("\"{name}\" has {samples} samples and {} mip levels", size.mips);
        let help = "a texture with several samples has one mip level: remove \"mips\", and resolve it to one that has them";
        return Some(("/texture/mips", message, help));
    }
    if size.layers > 1 {
        let message = format!("\"{name}\" has {samples} samples and {} layers", size.layers);
        let help = "a texture with several samples has one layer: remove \"layers\", and resolve it to one that has them";
        return Some(("/texture/layers", message, help));
    }
    None
}

/// Returns the reason why WebGPU does not allow a format for a texture of this size, dimension and usages; `None` if it
/// is allowed.
pub(crate) fn of_format(
    format: TextureFormat,
    size: TextureSize,
    volume: bool,
    usages: TextureUsages,
) -> Option<String> {
    if volume && format.is_depth_stencil_format() {
        return Some("cannot be that of a volume, as it has depth or stencil".to_owned());
    }
    if volume && format.is_compressed() {
        return Some("cannot be that of a volume, as it is compressed".to_owned());
    }
    let (across, down) = format.block_dimensions();
    if !size.width.is_multiple_of(across) || !size.height.is_multiple_of(down) {
        return Some(format!(
            "has blocks of {across} by {down} texels, of which {} by {} is no multiple",
            size.width, size.height
        ));
    }
    if size.samples > 1 && usages.contains(TextureUsages::STORAGE_BINDING) {
        return Some(format!("cannot be storage with {} samples", size.samples));
    }
    None
}
