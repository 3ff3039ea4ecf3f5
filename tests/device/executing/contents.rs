//! Declared contents: storage that replaces or keeps, attachments that load or discard.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{Squares, square};
use crate::executing::stage::{color, draw, executor, fill, plan, show, target, texels};
use crate::executing::views::frame;

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];

/// A pass that makes the left half of an image green.
fn half(contents: &str) -> String {
    format!(
        r#""half": {{ "compute": {{ "shader": "half.wgsl.jinja", "workgroups": [1, 1, 1],
             "bind": {{ "image": {{ "texture": {{ "name": "&image" {contents} }} }} }} }} }}"#
    )
}

/// The names of the passes that run, and the picture.
fn picture(resources: &str, passes: &str) -> Option<(Vec<String>, Vec<[u8; 4]>)> {
    let gpu = gpu::device()?;
    let plan = plan(&format!("{}, {resources}", target(1)), passes);
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, None, &picture, &frame(&[]));
    let names = plan.passes.iter().map(|pass| pass.name.clone()).collect();
    Some((names, texels(&gpu, &picture, 0)))
}

const IMAGE: &str =
    r#""image": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "persistent" } }"#;
const SHOWN: &str = r#""shown": { "copy": { "from": { "name": "&image" }, "to": { "name": "&target" } } }"#;

#[test]
fn storage_that_loads_keeps_what_it_does_not_write() {
    let red = fill("red", r#"{ "to": "&image" }"#, "[1, 0, 0, 1]");
    let passes = format!("{red}, {}, {SHOWN}", half(r#", "contents": "load""#));
    let Some((names, found)) = picture(IMAGE, &passes) else { return };
    assert_eq!(names, ["red", "half", "shown"]);
    let wanted: Vec<_> = (0..64).map(|at| if at % 8 < 4 { GREEN } else { RED }).collect();
    assert_eq!(found, wanted);
}

#[test]
fn storage_that_replaces_lets_passes_before_it_be_left_out() {
    let red = fill("red", r#"{ "to": "&image" }"#, "[1, 0, 0, 1]");
    for (contents, kept) in
        [(r#", "contents": "discard""#, &["half", "shown"][..]), ("", &["red", "half", "shown"])]
    {
        let half = half(contents).replace(r#""half": {"#, r#""half": { "after": ["red"], "#);
        let Some((names, found)) = picture(IMAGE, &format!("{red}, {half}, {SHOWN}")) else { return };
        assert_eq!(names, kept, "{contents}");
        assert!(found.iter().enumerate().all(|(at, texel)| at % 8 >= 4 || *texel == GREEN));
    }
}

#[test]
fn storage_of_one_frame_keeps_what_no_invocation_writes() {
    let image = r#""image": { "texture": { "format": "rgba8unorm", "size": "=viewport" } }"#;
    let red = fill("red", r#"{ "to": "&image" }"#, "[1, 0, 0, 1]");
    let again = half("").replace(r#""half": {"#, r#""again": { "after": ["half"], "#);
    let passes = format!("{}, {again}, {red}, {SHOWN}", half(""));
    let Some((names, found)) = picture(image, &passes) else { return };
    assert_eq!(names, ["red", "half", "again", "shown"]);
    let wanted: Vec<_> = (0..64).map(|at| if at % 8 < 4 { GREEN } else { RED }).collect();
    assert_eq!(found, wanted);
}

#[test]
fn a_buffer_that_is_replaced_needs_no_clear_before() {
    let resources = r#""words": { "buffer": { "size": 12 } }, "sum": { "buffer": { "size": 2048 } }"#;
    let passes = r#""none": { "clear": { "buffer": "&sum" } },
        "say": { "compute": { "shader": "counts.wgsl.jinja", "workgroups": [1, 1, 1],
          "bind": { "words": { "buffer": { "name": "&words", "contents": "discard" } } } } },
        "count": { "compute": { "shader": "count.wgsl.jinja", "bind": { "sum": "&sum" }, "indirect": { "buffer": "&words" } } },
        "shown": { "copy": { "from": { "name": "&sum" }, "to": { "name": "&target" } } }"#;
    let Some((_, found)) = picture(resources, passes) else { return };
    assert_eq!(found[0], [24, 0, 0, 0]);
}

#[test]
fn bytes_around_a_copy_stay_unless_it_discards() {
    let resources = r#""bytes": { "buffer": { "size": 2048 } },
        "small": { "texture": { "format": "rgba8unorm", "size": [1, 1] } }"#;
    let green = fill("green", r#"{ "to": "&small" }"#, "[0, 1, 0, 1]");
    let cases = [(r#", "contents": "load""#, true), ("", true), (r#", "contents": "discard""#, false)];
    for (contents, kept) in cases {
        let passes = format!(
            r#"{green}, "none": {{ "clear": {{ "buffer": "&bytes" }} }},
               "texel": {{ "after": ["none"], "copy": {{ "from": {{ "name": "&small" }}, "to": {{ "name": "&bytes" {contents} }} }} }},
               "shown": {{ "copy": {{ "from": {{ "name": "&bytes" }}, "to": {{ "name": "&target" }} }} }}"#
        );
        let Some((names, found)) = picture(resources, &passes) else { return };
        assert_eq!(names.contains(&"none".to_owned()), kept, "{names:?}");
        assert_eq!(found[0], GREEN);
        assert!(!kept || found[1..].iter().all(|texel| *texel == [0; 4]));
    }
}

#[test]
fn a_copy_to_rows_replaces_a_buffer_only_if_the_rows_fill_it() {
    let passes = |to: &str| {
        let big = fill("green", r#"{ "to": "&big" }"#, "[0, 1, 0, 1]");
        format!(
            r#""none": {{ "clear": {{ "buffer": "&bytes" }} }}, {big},
               "rows": {{ "after": ["none"], "copy": {{ "from": {{ "name": "&big" }}, "to": {{ "name": "&bytes" {to} }} }} }},
               "shown": {{ "copy": {{ "from": {{ "name": "&bytes" }}, "to": {{ "name": "&target" }} }} }}"#
        )
    };
    // Rows of 256 bytes, 16 of them: 4,096 bytes.
    for (size, bytes, to, kept) in [
        ("[64, 16]", 4096, "", false),
        ("[64, 16]", 8192, r#", "bytes_per_row": 512"#, true),
        ("[64, 16]", 4352, "", true),
        ("[63, 16]", 4096, "", true),
        (r#""=viewport""#, 4096, "", true),
    ] {
        let resources = format!(
            r#""bytes": {{ "buffer": {{ "size": {bytes} }} }},
               "big": {{ "texture": {{ "format": "rgba8unorm", "size": {size} }} }}"#
        );
        let Some((names, _)) = picture(&resources, &passes(to)) else { return };
        assert_eq!(names.contains(&"none".to_owned()), kept, "{size} {bytes} {to}: {names:?}");
    }
    // Nothing has to be there.
    let resources = r#""bytes": { "buffer": { "size": 4096 } },
        "big": { "texture": { "format": "rgba8unorm", "size": [8, 8] } }"#;
    let alone = passes("")
        .replace(r#""none": { "clear": { "buffer": "&bytes" } }, "#, "")
        .replace(r#""after": ["none"], "#, "");
    let Some((names, found)) = picture(resources, &alone) else { return };
    assert_eq!((names.len(), found[0]), (3, GREEN));
}

#[test]
fn attachments_load_or_discard_as_is_said() {
    let red = fill("red", r#"{ "to": "&target", "layer": 0 }"#, "[1, 0, 0, 1]");
    let veil = |contents: &str| {
        let to = format!(r#"{{ "to": "&target", "layer": 0 {contents} }}"#);
        fill("veil", &to, "[0, 1, 0, 1]").replace("fill.wgsl.jinja", "left.wgsl.jinja")
    };
    for (contents, names, right) in [
        (r#", "contents": "load""#, &["red", "veil"][..], RED),
        (r#", "contents": "discard""#, &["veil"], [0; 4]),
    ] {
        let veil = veil(contents).replace(r#""veil": {"#, r#""veil": { "after": ["red"], "#);
        let Some((found, texels)) = picture(IMAGE, &format!("{red}, {veil}")) else { return };
        assert_eq!(found, names, "{contents}");
        assert_eq!((texels[0], texels[7]), (GREEN, right), "{contents}");
    }
}

#[test]
fn what_is_discarded_is_not_stored_and_no_output() {
    use umbragraph::low_level::compiler::StoreOperation;
    let Some(gpu) = gpu::device() else { return };
    let depth = r#""depth": { "texture": { "format": "depth32float", "size": "=viewport", "lifetime": "persistent" } }"#;
    let masked = |store: &str| {
        let to = r#"{ "to": "&target", "clear": [0, 0, 1, 1] }"#;
        let depth =
            format!(r#""depth": {{ "to": "&depth", "clear": 1, "compare": "less" {store} }}, "color":"#);
        draw(1, to).replace(r#""color":"#, &depth)
    };
    for (store, planned) in
        [("", StoreOperation::Store), (r#", "store": "discard""#, StoreOperation::Discard)]
    {
        let plan = plan(&format!("{}, {depth}", target(1)), &masked(store));
        assert_eq!(plan.passes[1].depth.as_ref().map(|depth| depth.store), Some(planned));
        let squares =
            Squares::new(&gpu.device, &gpu.queue, &[square(crate::executing::squares::RED)], &[[1.0; 4]]);
        let mut executor = executor(&gpu, &plan, Some(&squares));
        let picture = import(&gpu, &plan, "target");
        for _ in 0..2 {
            show(&gpu, &mut executor, Some(&squares), &picture, &frame(&["0"]));
            assert_eq!(color(&gpu, &picture, 0), RED);
        }
    }
    // Nothing is left of it for the host.
    let flat =
        r#""flat": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "persistent" } }"#;
    for (store, left) in [("", RED), (r#", "store": "discard""#, [0; 4])] {
        let to = format!(
            r#"{{ "to": "&flat", "clear": [0, 0, 1, 1] }}, {{ "to": "&target", "clear": [0, 0, 1, 1]{store} }}"#
        );
        let twice = draw(1, &to).replace("square.wgsl.jinja", "square_twice.wgsl.jinja");
        let plan = plan(&format!("{}, {flat}", target(1)), &twice);
        let squares =
            Squares::new(&gpu.device, &gpu.queue, &[square(crate::executing::squares::RED)], &[[1.0; 4]]);
        let mut executor = executor(&gpu, &plan, Some(&squares));
        let picture = import(&gpu, &plan, "target");
        show(&gpu, &mut executor, Some(&squares), &picture, &frame(&["0"]));
        assert_eq!(color(&gpu, &picture, 0), left, "{store}");
    }
    let red = fill("red", r#"{ "to": "&image", "store": "discard" }"#, "[1, 0, 0, 1]");
    let other = fill("other", r#"{ "to": "&target" }"#, "[1, 0, 0, 1]");
    let plan = plan(&format!("{}, {IMAGE}", target(1)), &format!("{red}, {other}"));
    assert!(plan.culled.contains_key("red"), "{:?}", plan.culled);
}
