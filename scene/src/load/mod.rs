//! Loading: bytes to a checked [`Scene`].
//!
//! The document is parsed by the `gltf` crate into its plain JSON types; everything beyond parsing happens here,
//! because the crate's own readers stop at the first diagnostic, or panic on a reference to nothing. Each step below
//! turns one part of the document into its part of the scene and reports what it finds on the way; a part that cannot
//! be read becomes a gap, and the next step goes on, so that all diagnostics of a file come at once. What is reachable
//! from a mesh, a node, a skin or an animation is checked; accessors and images that nothing uses are not even looked
//! at.
//!
//! Order: container, buffers, images and materials, geometry, hierarchy, cameras and
//! lights, skins, animations, draws.
//!
//! Normals that cannot be read are computed as if they were missing, with a warning; everything else that is broken is
//! an error.
//!
//! Limits: parsing stops at the first value of a wrong JSON type (as opposed to a wrong value), and a document whose
//! container or JSON is broken has no further diagnostics.

mod accessor;
mod animations;
mod buffers;
mod container;
mod decode;
mod details;
mod draws;
mod extensions;
mod extras;
mod geometry;
mod hierarchy;
mod images;
mod jpeg;
pub mod limits;
mod materials;
mod morph;
mod placement;
mod report;
mod resource;
mod skins;
mod tangents;

pub use images::image_from_slice;
pub use limits::MAX_FILE_BYTES;
pub use resource::{Folder, NoFiles, ResolveError, Resolver};

use std::path::{Path, PathBuf};
use std::sync::Arc;
use umbragraph_pipeline::compose::{Roots, meant_beside};
use umbragraph_pipeline::diagnostic::Diagnostics;

use crate::codes;
use crate::scene::Scene;
use accessor::Accessors;
use report::Report;

/// Loads a `.glb` or `.gltf` file. Buffers and images in files of their own must lie below the folder of the file or
/// below the working folder.
///
/// # Errors
/// All diagnostics of the file, if at least one of them is an error.
pub fn load(path: &Path) -> Result<Scene, Diagnostics> {
    load_below(path, Roots::of(path))
}

/// Loads a `.glb` or `.gltf` file. Buffers and images in files of their own must lie below one of the folders in
/// `roots`.
///
/// # Errors
/// All diagnostics of the file, if at least one of them is an error.
pub fn load_below(path: &Path, roots: Roots) -> Result<Scene, Diagnostics> {
    let name = path.display().to_string();
    match resource::read_file(path, &name) {
        Ok(bytes) => {
            let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
            from_slice(&name, &bytes, &Folder::new(folder).below(roots))
        }
        Err(error) => {
            let mut report = Report::new(&name);
            let meant = || meant_beside(path, &[".glb", ".gltf"]);
            let (code, help) = match &error {
                ResolveError::TooLarge(_) => (codes::TOO_LARGE, "at most 1 GiB is read".to_owned()),
                ResolveError::NotFound(_) => (
                    codes::SCENE_UNREADABLE,
                    meant().unwrap_or_else(|| "paths are relative to the current folder".to_owned()),
                ),
                _ => (codes::SCENE_UNREADABLE, "name a .glb or .gltf file that may be read".to_owned()),
            };
            report.error(code, "", format!("the scene {error}"), help);
            Err(report.finish().err().unwrap_or_default())
        }
    }
}

/// Loads a scene from the bytes of a `.glb` or `.gltf` file. `name` is the name of the scene in diagnostics. `resolver`
/// reads buffers and images that the document references by a relative URI.
///
/// # Errors
/// All diagnostics of the file, if at least one of them is an error.
pub fn from_slice(name: &str, bytes: &[u8], resolver: &dyn Resolver) -> Result<Scene, Diagnostics> {
    let mut report = Report::new(name);
    let scene = read(name, bytes, resolver, &mut report);
    let warnings = report.finish()?;
    // A scene is missing only after an error.
    scene.map(|scene| Scene { warnings, ..scene }).ok_or_else(Diagnostics::new)
}

fn read(name: &str, bytes: &[u8], resolver: &dyn Resolver, report: &mut Report) -> Option<Scene> {
    report.allow(bytes.len(), limits::DECODED_PER_BYTE);
    let container = container::open(bytes, report)?;
    let root = &container.root;
    let buffers = buffers::read(root, container.binary, resolver, report);
    let accessors = Accessors { root, buffers: &buffers };
    let (materials, textures) = materials::read(root, report);
    let (images, textures) = images::read(&accessors, &textures, resolver, report);
    let meshes = geometry::read(&accessors, &materials, report);
    let hierarchy = hierarchy::read(root, report)?;
    let skins = skins::read(&accessors, report);
    let animations = animations::read(&accessors, &hierarchy, report);
    let mut scene = Scene {
        name: name.to_owned(),
        meshes: Arc::new(meshes),
        materials,
        textures,
        images: Arc::new(images),
        nodes: hierarchy.nodes,
        cameras: Vec::new(),
        lights: Vec::new(),
        skins,
        animations,
        warnings: Diagnostics::new(),
        order: hierarchy.order,
        draws: Vec::new(),
        finest: 0,
        joint_bounds: Vec::new(),
    };
    hierarchy::mark_animated(&mut scene);
    let pose = scene.rest_pose();
    placement::cameras(root, &mut scene, &pose, report);
    placement::lights(root, &mut scene, &pose, report);
    if !report.has_errors() {
        draws::collect(&mut scene, &pose, report);
    }
    Some(scene)
}
