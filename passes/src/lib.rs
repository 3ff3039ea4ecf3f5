//! The node kinds that come with umbragraph, written against the graph's public interface only, as yours would be.
//!
//! | kind | what a pass of it does |
//! |---|---|
//! | [`camera`] | publishes the frame's camera as a view |
//! | [`cascades`] | fits cascades of a directional light to the camera |
//! | [`draw`] | draws the host's meshes, once for each view |
//! | [`fullscreen`] | runs a fragment shader over its attachments |
//! | [`mesh`] | draws vertices from the pipeline's own buffers |
//! | [`compute`] | dispatches a compute shader |
//! | [`copy`] | copies a texture or a buffer, clears a buffer |
//! | [`view`] | publishes one view of a set, for a texture of its own |
//! | [`lights`] | places the shadows of all lights, and publishes lights and shadow descriptors |
//!
//! [`words`] are the properties of lights and the filters of draws that they know.

pub mod atlas;
pub mod attachment;
mod blend;
pub mod camera;
pub mod cascades;
mod codes;
pub mod compute;
pub mod copy;
pub mod draw;
pub mod fullscreen;
mod if_said;
pub mod importance;
pub mod lights;
pub mod mesh;
pub mod shader;
pub mod view;
pub mod views;
pub mod words;

pub use codes::ALL as CODES;

use umbragraph_pipeline::node::Registry;

/// All node kinds of this crate.
pub fn registry() -> Registry {
    let mut registry = Registry::new();
    registry
        .register::<camera::Camera>()
        .register::<cascades::Cascades>()
        .register::<compute::Compute>()
        .register::<copy::Clear>()
        .register::<copy::Copy>()
        .register::<draw::Draw>()
        .register::<fullscreen::Fullscreen>()
        .register::<lights::cubes::CubeShadows>()
        .register::<lights::list::LightList>()
        .register::<lights::placement::ShadowAtlas>()
        .register::<lights::spots::SpotShadows>()
        .register::<mesh::Mesh>()
        .register::<view::View>();
    registry
}
