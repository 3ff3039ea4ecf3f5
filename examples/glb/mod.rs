//! Modelling and writing of the project's own scenes.
//!
//! An example program builds [`Shape`]s from a few solids, gives them materials, places them in a tree of nodes and
//! writes everything as one binary glTF ([`Document::glb`]). The same program always writes the same bytes: random
//! numbers come from a hash of integers ([`noise`]), sines and powers from additions and multiplications
//! ([`functions`]), and every coordinate is rounded to a grid.
//!
//! Conventions are glTF's: right-handed, metres, Y up; faces are counter-clockwise seen from outside.
#![allow(dead_code, unused_imports, reason = "each example uses its own part of it")]

pub(crate) mod document;
pub(crate) mod functions;
pub(crate) mod json;
pub(crate) mod noise;
pub(crate) mod png;
pub(crate) mod shape;
pub(crate) mod solids;
pub(crate) mod streams;
pub(crate) mod vector;

pub(crate) use document::{Document, Light, Material};
pub(crate) use shape::Shape;
pub(crate) use vector::{Placement, Vec3, vec3};

/// Writes a document to the path of the first argument or under `examples/scenes/`, and prints its size.
pub(crate) fn save(name: &str, document: &Document) -> std::io::Result<()> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/scenes");
    let path = std::env::args_os().nth(1).map_or_else(|| folder.join(name), std::path::PathBuf::from);
    let bytes = document.glb();
    std::fs::write(&path, &bytes)?;
    println!("{}: {} bytes, {} triangles drawn", path.display(), bytes.len(), document.drawn_triangles());
    Ok(())
}
