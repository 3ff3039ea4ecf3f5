//! glTF 2.0 scenes as a source of draws, lights and cameras.
//!
//! A scene file is decoded once into plain data on the CPU ([`Scene`]): triangles with their attributes, materials,
//! decoded images, a node hierarchy with transforms in `f64`, cameras, lights, skins and animations. Everything that
//! varies over time is computed from that data into a [`Pose`]. A frame's other inputs, apart from its draws, are a
//! [`FrameInput`](umbragraph_pipeline::frame::FrameInput), made by [`Scene::frame_input`].
//!
//! ```no_run
//! let scene = umbragraph_scene::load("courtyard.glb".as_ref()).expect("a readable scene");
//! let frame = scene.frame_input(16.0 / 9.0, 0.0);
//! for draw in scene.draws() {
//!     let primitive = scene.primitive(draw);
//!     println!("{} triangles of {}", primitive.indices.len() / 3, scene.node(draw.node).name);
//! }
//! # let _ = frame;
//! ```
//!
//! With the feature `gpu`, `gpu::SceneResources` puts a scene on a device and draws it through the engine's draw
//! contract; [`interface`] describes its layout for shaders without a device.
//!
//! Conventions are glTF's, which are also the engine's: right-handed, Y up, metres, radians, front faces
//! counter-clockwise, cameras and lights look along −Z of their own space, texture v points down.
//!
//! A file is not trusted. Loading collects all diagnostics of a file as
//! [`Diagnostics`](umbragraph_pipeline::diagnostic::Diagnostics) (codes UG0700 to UG0799, see [`codes`]), each placed
//! by a JSON pointer into the document; it never panics, follows no cycle, and stays within the limits of
//! [`load::limits`].
//!
//! Not read: texture coordinates beyond the second set; points and lines are left out with a warning. Extensions that
//! are understood: `KHR_lights_punctual`, `KHR_materials_emissive_strength`, `KHR_materials_ior`,
//! `KHR_materials_specular` (its factors), `KHR_materials_unlit`, `KHR_mesh_quantization`, `KHR_texture_transform` and
//! `MSFT_lod`; a document that *requires* another one is rejected.

pub mod animation;
pub mod codes;
#[cfg(test)]
mod contract;
pub mod default_view;
pub mod filter;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod interface;
pub mod light;
pub mod load;
pub mod material;
pub mod mesh;
pub mod mipmap;
pub mod morph;
pub mod node;
pub mod pose;
pub mod scene;
pub mod skin;
pub mod texture;
pub mod trace;
pub mod view;
pub mod visibility;

pub use load::{
    Folder, MAX_FILE_BYTES, NoFiles, ResolveError, Resolver, from_slice, image_from_slice, load, load_below,
};
pub use pose::Pose;
pub use scene::{Draw, Scene};
