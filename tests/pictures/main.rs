//! Pictures of systems, lessons and filters, held against references, numbers and rays.

#![cfg(all(feature = "gpu", feature = "gltf"))]

#[path = "../common/mod.rs"]
mod common;

mod brdf;
mod clustered_lights;
mod contact;
mod coverage;
mod depth_bounds;
mod depth_of_field;
mod details;
mod effects;
mod environment;
mod extended;
mod film;
mod fog;
mod golden;
mod learn;
mod lights;
mod materials;
mod moment_shadows;
mod moments;
mod motion;
mod nebula;
mod penumbrae;
mod picture_effects;
mod rays;
mod scores;
mod second_compiler;
mod systems_pictures;
mod truth;
mod umbra;
mod visibility_first;
