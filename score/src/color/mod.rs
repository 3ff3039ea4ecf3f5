//! Scores of a rendered picture's light against a path tracer on the CPU.
//!
//! | step | module |
//! |---|---|
//! | well distributed random numbers, by seed | [`sequence`] |
//! | glTF's reflection of a surface point, in 64 bits: values and samples | [`brdf`], [`albedo`] |
//! | vertices, textures and factors of a hit as a surface point | [`surface`], [`texture`], [`vertices`] |
//! | the sky or an equirectangular picture as a light | [`sky`] |
//! | lights of the scene, with their extents | [`lamp`] |
//! | the radiance of each pixel | [`tracer`] |
//! | from radiance to a display: exposure and tone curve | [`display`] |
//! | mean error, bias and FLIP of a picture | [`scores`], [`flip`] |
//!
//! Formulas are those of the glTF 2.0 specification, its extensions and the papers named at each function. No shader of
//! the engine is a source. Limits: emissive surfaces light others only with bounces; there is no refraction; alpha
//! masks are sampled in their base level.

pub mod albedo;
pub mod brdf;
pub mod display;
pub mod flip;
pub mod lamp;
pub mod scores;
pub mod sequence;
pub mod sky;
pub mod surface;
pub mod texture;
pub mod tracer;
pub mod vertices;

#[cfg(test)]
mod tests;

pub use display::{Display, ToneMap};
pub use scores::{ColorLimits, ColorScores};
pub use sky::Sky;
pub use tracer::{Ambient, ColorTracer, PixelArea, Settings};
