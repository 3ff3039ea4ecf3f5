//! Cascaded shadow maps: the part on the CPU.
//!
//! The problem: a directional light needs shadow texels that are small near the camera and may be large far away. So
//! the view frustum is cut into slices along the view axis, and each slice gets an orthographic light view of its own.
//!
//! The algorithm, one step to a file:
//!
//! 1. [`splits`]: the far distance of every slice, given or by a formula, and where it begins to blend into the next;
//! 2. [`light`]: which light, and the rotation from world space to light space;
//! 3. [`fit`]: the box of a slice in light space, as a tight box or around a bounding sphere;
//! 4. [`snap`]: the rectangle of whole texels that holds the box, laid on a grid;
//! 5. [`depth`]: the near and far planes, so that casters between slice and light are drawn;
//! 6. [`layout`]: the layer or tile of the map that the light view draws into.
//!
//! [`configuration`] puts the steps together, without a GPU and without a pipeline; [`node`] is the node kind, `placed`
//! its form for several directional lights, and `declare` checks its settings.
//!
//! Stability: a shadow edge crawls when the texels move relative to the world. All sizes are computed from the slice
//! *relative to the camera*, so that they are bit-identical wherever the camera stands; with the snap "world" the
//! rectangle's corner is a whole multiple of the texel's size in light space, so a translation of the camera moves
//! every static point by whole texels. With the fit "sphere" sizes do not depend on the camera's rotation either.
//! Everything is `f64` up to the rounding of the final matrices to 32 bits. That moves a cascade of 2048 texels by less
//! than 1/100 texel as long as it is at least 1/100 as wide as it is far from the world's origin.
//!
//! Limits: at most [`MAX_CASCADES`] cascades for a light; the visible depth range is known on the GPU alone, where
//! templates fit cascades to it (`shaders-templates/fit_cascades.wgsl.jinja`, with the split scheme "whole" here).
//!
//! Sources: Zhang et al., "Parallel-Split Shadow Maps" (2006) for the practical split; Valient, "Stable Rendering of
//! Cascaded Shadow Maps", ShaderX6 (2008) for the sphere and the snap.

pub mod configuration;
mod declare;
pub mod depth;
pub mod fit;
pub mod layout;
pub mod light;
pub mod node;
mod placed;
pub mod snap;
pub mod splits;

#[cfg(test)]
mod tests;

pub use configuration::{Cascade, CascadeSet, Configuration};
pub use node::Cascades;

/// The maximum number of cascades of one fit.
pub const MAX_CASCADES: usize = 8;
