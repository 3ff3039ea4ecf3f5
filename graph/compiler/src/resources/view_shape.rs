//! The one shape in which OpenGL binds a texture.
//!
//! WebGPU chooses the dimension with each view. OpenGL fixes it when a texture is created, wgpu's `gles` guesses it
//! then from the size alone ([`of`]), and a view of another dimension reads nothing; of an array it reads all layers
//! whatever the view. A texture that is declared as an array, but whose size looks like something else, is created with
//! a spare layer ([`is_only_array`]). Other views are diagnostics ([`crate::plan`]). Views in another format need the
//! same part of OpenGL, which is why `view-formats` stands for both.
//!
//! Limits: a host's own texture has the layers that the host gives it.

use umbragraph_pipeline::language::{TextureDeclaration, TextureShape};
use umbragraph_pipeline::pipeline::TypedPipeline;
use wgpu_types::{DownlevelFlags, TextureViewDimension};

use crate::request::texture_size::TextureSize;

/// Returns the view dimension that wgpu's OpenGL backend (`gles`) gives a texture that is not 3D.
pub(crate) fn of(size: TextureSize) -> TextureViewDimension {
    let is_cubes = size.width == size.height && size.samples == 1 && size.layers.is_multiple_of(6);
    match (is_cubes, size.layers) {
        (false, 1) => TextureViewDimension::D2,
        (false, _) => TextureViewDimension::D2Array,
        (true, 6) => TextureViewDimension::Cube,
        (true, _) => TextureViewDimension::CubeArray,
    }
}

/// Returns `true` if a texture must be bound as an array, because the target (OpenGL) gives each texture one fixed view
/// dimension.
pub(crate) fn is_only_array(pipeline: &TypedPipeline, texture: &TextureDeclaration) -> bool {
    texture.view_dimension == Some(TextureShape::D2Array)
        && !pipeline.profile.downlevel.contains(DownlevelFlags::VIEW_FORMATS)
}

/// The WebGPU name of a view dimension, such as `2d-array`.
pub(crate) fn name(dimension: TextureViewDimension) -> &'static str {
    match dimension {
        TextureViewDimension::D1 => "1d",
        TextureViewDimension::D2 => "2d",
        TextureViewDimension::D2Array => "2d-array",
        TextureViewDimension::Cube => "cube",
        TextureViewDimension::CubeArray => "cube-array",
        TextureViewDimension::D3 => "3d",
    }
}
