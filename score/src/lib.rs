//! Scores of rendered shadows and colors against ray-traced ones.
//!
//! A pipeline's *shadow term* is an image of the visibility of lights: white for lit, alpha for geometry. This crate
//! traces rays for the same pixels ([`Truth`]): one from the camera, one to the light, and many to a light with an
//! extent. Both are compared pixel by pixel ([`Scores`]), in counts and sums that add up over lights, frames and
//! scenes. [`limits`] bound the scores in CI, and [`difference`] paints the errors.
//!
//! | step | module |
//! |---|---|
//! | triangles of a scene in a pose, skinned on the CPU, with the holes of alpha masks | [`triangles`] |
//! | a bounding volume hierarchy of the triangles, and rays through it | [`rays`] |
//! | the rays from a point to a light | [`light`] |
//! | the surface that each pixel shows, and its visibility from a light | [`truth`] |
//! | the scores of a picture | [`scores`] |
//! | changes from frame to frame that the truth does not have | [`changes`] |
//! | visibility as bytes, to be kept | [`LightTruth::to_bytes`] |
//! | the light of a whole picture against a path tracer | [`color`] |
//!
//! The crate does not depend on the shadow technique and needs no device. Limits: blended surfaces neither cast shadows
//! nor count; alpha masks are sampled in their base level, where a renderer may use smaller ones.

pub mod changes;
pub mod color;
pub mod difference;
mod kept;
pub mod light;
pub mod limits;
pub mod rays;
pub mod scores;
pub mod triangles;
pub mod truth;

pub use changes::{Changes, Seen};
pub use limits::{Limited, Limits};
pub use rays::Rays;
pub use scores::{BANDS, Counts, Rendered, Scores};
pub use truth::{LightTruth, Truth};
