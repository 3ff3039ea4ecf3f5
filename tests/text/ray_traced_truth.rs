//! The scores on real ray-traced masks, where this machine has them.

use umbragraph_test_support::image::{Channels, Picture};
use umbragraph_test_support::truth::{TruthScene, check, evaluate};

const SCENES: [&str; 3] = ["contact_sun", "room_point", "terrain_dem_sun"];

/// The ray tracer's own mask as a renderer would write it: grey with alpha.
fn as_rendered(scene: &TruthScene) -> Picture {
    let mask = |kind: &str| {
        let path = scene.glb_path().with_extension(format!("{kind}.png"));
        Picture::load(&path).unwrap()
    };
    let (hard, hit) = (mask("hard"), mask("hit"));
    let bytes = hard.bytes().iter().zip(hit.bytes()).flat_map(|(&hard, &hit)| [hard, hit]).collect();
    Picture::new(scene.size().0, scene.size().1, Channels::GreyAlpha, bytes).unwrap()
}

#[test]
fn the_ray_tracers_own_mask_meets_the_limits() {
    for name in SCENES {
        let Some(scene) = TruthScene::find(name) else { return };
        let scores = evaluate(&scene, &as_rendered(&scene)).unwrap();
        check(&scores, &scene.hard_limits().unwrap()).unwrap();
    }
}

#[test]
fn a_picture_without_shadows_breaks_the_limits() {
    for name in SCENES {
        let Some(scene) = TruthScene::find(name) else { return };
        let (width, height) = scene.size();
        let lit = Picture::filled(width, height, Channels::Grey, &[255]);
        let message = check(&evaluate(&scene, &lit).unwrap(), &scene.hard_limits().unwrap()).unwrap_err();
        assert!(message.contains("min_iou") && message.contains("max_leak_k2"), "{name}: {message}");
        assert!(!message.contains("max_acne_k2"), "{name}: {message}");
    }
}

#[test]
fn a_mask_that_is_off_by_one_pixel_breaks_a_limit() {
    for name in SCENES {
        let Some(scene) = TruthScene::find(name) else { return };
        let right = as_rendered(&scene);
        let mut bytes = right.bytes().to_vec();
        // One row and one column on.
        bytes.rotate_right((scene.size().0 as usize + 1) * 2);
        let shifted = Picture::new(scene.size().0, scene.size().1, Channels::GreyAlpha, bytes).unwrap();
        let scores = evaluate(&scene, &shifted).unwrap();
        assert!(check(&scores, &scene.hard_limits().unwrap()).is_err(), "{name}");
    }
}
