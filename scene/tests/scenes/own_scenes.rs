//! The project's own scenes, as they are in the tree.

use glam::Vec3;
use std::path::{Path, PathBuf};
use umbragraph_scene::Scene;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes")
}

fn scenes() -> Vec<(PathBuf, Scene)> {
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "glb"));
    paths.sort();
    assert!(!paths.is_empty(), "no scenes in {}", folder().display());
    paths.into_iter().map(|path| (path.clone(), umbragraph_scene::load(&path).unwrap())).collect()
}

#[test]
fn every_own_scene_is_small_and_loads_without_a_diagnostic() {
    for (path, scene) in scenes() {
        assert!(path.metadata().unwrap().len() < 1_000_000, "{} is too large", path.display());
        assert!(scene.warnings.is_empty(), "{}: {:?}", path.display(), scene.warnings);
    }
}

#[test]
fn every_own_scene_has_camera_lights_and_things_in_view() {
    for (path, scene) in scenes() {
        assert!(!scene.cameras.is_empty() && !scene.lights.is_empty(), "{}", path.display());
        let frame = scene.frame_input(16.0 / 9.0, 0.0);
        let clip = frame.camera.clip(false) * frame.camera.view();
        let pose = scene.pose(0.0);
        let in_view = scene.draws().filter(|draw| {
            let seen = clip.project_point3(scene.draw_bounds(*draw, &pose).center());
            seen.x.abs() < 1.0 && seen.y.abs() < 1.0 && (0.0..1.0).contains(&seen.z)
        });
        assert!(
            in_view.count() * 4 > scene.draws().len(),
            "{}: most of the scene is out of view",
            path.display()
        );
    }
}

#[test]
fn faces_of_own_scenes_turn_the_way_their_normals_point() {
    for (path, scene) in scenes() {
        for mesh in scene.meshes.iter() {
            for primitive in &mesh.primitives {
                let corner = |index: u32| Vec3::from(primitive.positions[index as usize]);
                let normal = |index: u32| Vec3::from(primitive.normals[index as usize]);
                let wrong = primitive.indices.chunks(3).filter(|face| {
                    let (a, b, c) = (corner(face[0]), corner(face[1]), corner(face[2]));
                    let face_normal = (b - a).cross(c - a).normalize_or_zero();
                    face_normal.dot(normal(face[0]) + normal(face[1]) + normal(face[2])) < -0.1
                });
                assert_eq!(wrong.count(), 0, "{}: faces of {} are inside out", path.display(), mesh.name);
            }
        }
    }
}
