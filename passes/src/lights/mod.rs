//! Every kind of light through one interface: the part on the CPU.
//!
//! The problem: directional lights need cascades, spots one map each, point lights six; a device has limited memory,
//! and a frame a limited number of views. A shader should treat all lights alike.
//!
//! The algorithm, one node kind to a step:
//!
//! 1. [`placement`] (`shadow_atlas`): which lights cast shadows in this frame, and where: a tile of an atlas for a
//!    spot, a slot of a cube array for a point light, layers of an array for the cascades of a directional light. The
//!    most important lights come first; one that has to do with less, or with nothing, is reported by name;
//! 2. [`spots`] (`spot_shadows`), [`cubes`] (`cube_shadows`) and [`crate::cascades`] with a placement: a view for each
//!    map to draw, and a [`descriptor`] for shaders;
//! 3. [`list`] (`light_list`): all lights by kind, and all descriptors by backing, in one block; and which lights have
//!    [`slots`] of textures as large as the picture.
//!
//! A shader loops over the lights, and computes the visibility of each from its first descriptor, whose position
//! determines its backing: no constant is duplicated between host and shader.
//!
//! Determinism: lights are identified by their names, and lights with equal names by their properties. Their order in
//! the frame changes neither their placement nor the order in which shaders add them up.

pub mod cubes;
pub(crate) mod described;
pub mod descriptor;
pub mod filter;
pub mod list;
pub(crate) mod missing;
pub mod placement;
pub mod slots;
pub mod spots;

use umbragraph_pipeline::data::BlackboardData;

/// The first 32-bit word of the published value `name`; 0 if there is none.
fn word(data: &BlackboardData, name: &str) -> u32 {
    data.words(name).and_then(|words| words.first().copied()).unwrap_or(0)
}
