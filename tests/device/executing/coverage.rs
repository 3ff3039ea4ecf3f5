//! Coverage of full-screen passes: known full coverage culls the pass before, partial coverage keeps its pixels.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::stage::{executor, fill, plan, show, target, texels};
use crate::executing::views::frame;

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];

/// A red picture, and a pass over it: which passes run, and the picture.
fn over_red(shader: &str, attachment: &str) -> Option<(Vec<String>, Vec<[u8; 4]>)> {
    let gpu = gpu::device()?;
    let red = fill("red", r#"{ "to": "&target", "layer": 0 }"#, "[1, 0, 0, 1]");
    let to = format!(r#"{{ "to": "&target", "layer": 0 {attachment} }}"#);
    let veil = fill("veil", &to, "[0, 1, 0, 1]").replace("fill.wgsl.jinja", shader);
    let veil = veil.replace(r#""veil": {"#, r#""veil": { "after": ["red"], "#);
    let plan = plan(&target(1), &format!("{red}, {veil}"));
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, None, &picture, &frame(&[]));
    Some((plan.passes.iter().map(|pass| pass.name.clone()).collect(), texels(&gpu, &picture, 0)))
}

#[test]
fn pixels_that_no_fragment_covers_stay() {
    for shader in ["left.wgsl.jinja", "masked.wgsl.jinja", "left_triangles.wgsl.jinja", "clipped.wgsl.jinja"]
    {
        let Some((names, found)) = over_red(shader, "") else { return };
        assert_eq!(names, ["red", "veil"], "{shader}");
        assert_eq!((found[0], found[7]), (GREEN, RED), "{shader}");
    }
}

#[test]
fn a_pass_that_covers_everything_culls_the_pass_before() {
    for (shader, attachment) in [
        ("fill.wgsl.jinja", ""),
        ("own_triangle.wgsl.jinja", ""),
        ("left.wgsl.jinja", r#", "contents": "discard""#),
        ("left.wgsl.jinja", r#", "clear": [0, 0, 1, 1]"#),
    ] {
        let Some((names, found)) = over_red(shader, attachment) else { return };
        assert_eq!(names, ["veil"], "{shader} {attachment}");
        assert_eq!(found[0], GREEN);
        assert!(!shader.starts_with("left") || found[7] != RED);
        assert!(shader.starts_with("left") || found[7] == GREEN);
    }
    let Some((names, _)) = over_red("fill.wgsl.jinja", r#", "blend": "add""#) else { return };
    assert_eq!(names, ["red", "veil"]);
}
