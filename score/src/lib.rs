//! How well rendered shadows agree with ray-traced ones.
//!
//! A pipeline's *shadow term* is a picture of the visibility of lights: white where light arrives, alpha where there is
//! geometry. Here the same pixels are asked of rays: one from the camera, one to the light, and many to a light that has
//! an extent ([`Truth`]). Both are compared pixel by pixel ([`Scores`]), in counts and sums that add up over lights,
//! frames and scenes; [`limits`] on the result are what CI asks for, and [`difference`] paints where and how they differ.
//!
//! | step | module |
//! |---|---|
//! | triangles of a scene in a pose, skinned on the CPU, with the holes of alpha masks | [`triangles`] |
//! | the hierarchy of boxes around them, and rays through it | [`rays`] |
//! | which rays lead to a light | [`light`] |
//! | what each pixel of a camera shows, and what of a light arrives there | [`truth`] |
//! | how a picture answers | [`scores`] |
//! | how much of it changes from frame to frame though the truth does not | [`changes`] |
//!
//! Nothing here knows how shadows are rendered, and no device is needed. Limits: surfaces that are blended neither cast
//! shadows nor count; alpha masks are sampled in their base level, where a renderer may take smaller ones.

pub mod changes;
pub mod difference;
pub mod light;
pub mod limits;
pub mod rays;
pub mod scores;
pub mod triangles;
pub mod truth;

pub use changes::{Changes, Seen};
pub use limits::Limits;
pub use rays::Rays;
pub use scores::{BANDS, Counts, Rendered, Scores};
pub use truth::{LightTruth, Truth};
