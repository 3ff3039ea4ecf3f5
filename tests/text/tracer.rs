//! The tracer against another one, where its masks are at hand (`../shared/truth`, or `UMBRAGRAPH_TRUTH`).

use std::path::Path;

use umbragraph_score::{Rays, Truth};
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::truth::TruthScene;

fn mask(folder: &Path, name: &str, kind: &str) -> Vec<u8> {
    let path = folder.with_file_name(format!("{name}.{kind}.png"));
    let picture = Picture::load(&path).expect("a mask");
    picture.rgba_pixels().map(|pixel| pixel[0]).collect()
}

/// The share of pixels for which something holds.
fn share(pixels: usize, holds: impl Fn(usize) -> bool) -> f64 {
    (0..pixels).filter(|at| holds(*at)).count() as f64 / pixels as f64
}

#[test]
fn hard_and_soft_masks_match_those_of_another_tracer() {
    for name in ["contact_sun", "terrain_dem_sun", "room_point"] {
        let Some(other) = TruthScene::find(name) else { return };
        let path = other.glb_path();
        let scene = umbragraph::scene::load(&path).expect("a scene");
        let input = scene.frame_input(1.0, 0.0);
        let rays = Rays::new(&scene, &scene.pose(0.0));
        let (width, height) = other.size();
        let truth = Truth::new(&rays, &input.camera, [width, height]);
        let light = truth.light(&input.lights[0]).expect("a usable light");
        let [hit, hard, evaluated, edge] =
            ["hit", "hard", "eval", "edge"].map(|kind| mask(&path, name, kind));
        let soft = mask(&path, name, "soft");
        let pixels = hit.len();
        let both = |at: usize| evaluated[at] != 0 && truth.points()[at].is_some();
        let counted: Vec<usize> = (0..pixels).filter(|at| both(*at)).collect();
        let of = |holds: &dyn Fn(usize) -> bool| share(counted.len(), |at| holds(counted[at]));
        let differ = of(&|at| light.lit[at] != (hard[at] != 0));
        let hits = share(pixels, |at| truth.points()[at].is_some() != (hit[at] != 0));
        let counts = share(pixels, |at| light.evaluated[at] != (evaluated[at] != 0));
        let bands = of(&|at| (light.edge[at] > 1.0) != (edge[at] >= 2));
        let visible = light.visible.as_ref().expect("a light with an extent");
        let error = |at: &usize| (f64::from(visible[*at]) - f64::from(soft[*at]) / 255.0).abs();
        let error = counted.iter().map(error).sum::<f64>() / counted.len() as f64;
        println!(
            "{name}: of {} pixels {differ:.6} differ in the hard mask, {hits:.6} in what is hit, {counts:.6} in what \
             counts, {bands:.6} in the band; the soft mask by {error:.5}",
            counted.len()
        );
        assert!(differ <= 1e-4 && hits <= 1e-4 && counts <= 1e-3 && bands <= 1e-3, "{name}");
        assert!(error < 0.0025, "{name}");
    }
}
