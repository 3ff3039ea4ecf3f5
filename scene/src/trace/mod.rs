//! Triangles of a scene for rays, and the boxes around them, on the CPU.
//!
//! | module | content |
//! |---|---|
//! | [`places`] | the world-space vertices of a draw in a pose: rigid, skinned and morphed |
//! | [`hierarchy`] | a bounding volume hierarchy: built once, refitted when triangles move |
//! | [`packed`] | both as one array of words, which shaders trace rays through |
//!
//! The tracer of shadow scores (crate `umbragraph-score`) and the shaders of `lib/shadow/rays` walk the same hierarchy.

pub mod hierarchy;
pub mod packed;
pub mod places;

pub use hierarchy::{Hierarchy, Node};
pub use packed::{PackedScene, TooLarge};
pub use places::place;
