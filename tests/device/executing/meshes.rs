//! Vertices, indices and counts from the pipeline's own buffers.

use umbragraph_test_support::gpu;

use crate::common::gpu::picture;
use crate::common::{With, check_with};

/// The lesson's pipeline with another draw.
fn ribbon(draw: &str) -> crate::common::Outcome {
    let text = format!(
        r#"{{
          "format": 1, "name": "ribbon",
          "parameters": {{ "many": {{ "type": "u32", "default": 6, "min": 0, "max": 4294967295 }} }},
          "resources": {{
            "points": {{ "buffer": {{ "size": 1024 }} }},
            "arguments": {{ "buffer": {{ "size": 16 }} }},
            "order": {{ "buffer": {{ "size": 24 }} }},
            "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}
          }},
          "passes": {{
            "none": {{ "clear": {{ "buffer": "&points" }} }},
            "nothing": {{ "clear": {{ "buffer": "&arguments" }} }},
            "unordered": {{ "clear": {{ "buffer": "&order" }} }},
            "wave": {{ "compute": {{
              "shader": "ribbon_points.wgsl.jinja", "bind": {{ "points": "&points", "arguments": "&arguments" }},
              "workgroups": [1, 1, 1]
            }} }},
            "number": {{ "compute": {{ "shader": "numbers.wgsl.jinja", "bind": {{ "numbers": "&order" }}, "workgroups": [1, 1, 1] }} }},
            "draw": {{ "mesh": {{ "shader": "ribbon.wgsl.jinja", {draw}, "color": [{{ "to": "&target", "clear": [0, 0, 1, 1] }}] }} }}
          }}
        }}"#
    );
    // Two triangles over the left half: columns 0 and 16 of 32.
    let numbers = "@group(1) @binding(0) var<storage, read_write> numbers: array<u32, 6>;
        @compute @workgroup_size(1) fn number() { numbers = array<u32, 6>(0u, 1u, 32u, 32u, 1u, 33u); }";
    check_with(
        "ribbon.json",
        &text,
        &With { templates: &[("numbers.wgsl.jinja", numbers)], size: Some([64, 16]), ..With::default() },
    )
}

const POINTS: &str = r#""vertices": [{ "buffer": "&points", "attributes": [
    { "name": "position", "format": "float32x2" }, { "name": "color", "format": "float32x2" }] }]"#;

/// The pixels of the middle row.
fn row(draw: &str) -> Vec<[u8; 4]> {
    let Some(gpu) = gpu::device() else { return Vec::new() };
    picture(&gpu, &ribbon(&format!("{POINTS}, {draw}"))).rgba_pixels().skip(64 * 8).take(64).collect()
}

#[test]
fn vertices_are_drawn_as_often_as_numbers_or_a_buffer_say() {
    let direct = row(r#""topology": "triangle-strip", "count": 64"#);
    let indirect = row(r#""topology": "triangle-strip", "indirect": { "buffer": "&arguments" }"#);
    assert_eq!(direct, indirect);
    if let [first, .., last] = direct.as_slice() {
        assert!(first[0] < 10 && last[0] > 240 && last[2] == 128, "{first:?} {last:?}");
    }
    // Half of the columns cover the left half only.
    let half = row(r#""topology": "triangle-strip", "count": 34"#);
    assert!(half.is_empty() || (half[20][2] == 128 && half[50] == [0, 0, 255, 255]), "{half:?}");
    let none = row(r#""topology": "triangle-strip", "count": 64, "instances": 0"#);
    assert!(none.iter().all(|pixel| *pixel == [0, 0, 255, 255]));
}

#[test]
fn indices_choose_the_vertices() {
    let found = row(r#""count": 6, "indices": { "buffer": "&order" }"#);
    assert!(found.is_empty() || (found[10][2] == 128 && found[50] == [0, 0, 255, 255]), "{found:?}");
    assert_eq!(row(r#""count": 6, "indices": { "buffer": "&order" }, "topology": "triangle-strip""#), found);
}

#[test]
fn what_does_not_fit_the_shader_or_the_buffers_is_found() {
    let codes = |draw: &str| ribbon(draw).codes();
    let with = |draw: &str| codes(&format!("{POINTS}, {draw}"));
    assert!(with(r#""count": 64"#).is_empty());
    assert_eq!(with(r#""count": 65"#), ["UG0409"], "the buffer has 64 vertices");
    assert_eq!(
        with(r#""count": 8, "indices": { "buffer": "&order" }"#),
        ["UG0409"],
        "the buffer has six indices"
    );
    assert_eq!(with(r#""indices": { "buffer": "&order" }"#), ["UG0106"], "nothing says how many");
    assert_eq!(with(r#""count": 3, "indirect": { "buffer": "&arguments" }"#), ["UG0102"]);
    assert_eq!(codes(r#""count": 3"#), ["UG0604", "UG0604"], "both attributes are missing");
    let one = |attribute: &str| {
        codes(&format!(
            r#""count": 3, "vertices": [{{ "buffer": "&points", "attributes": [{{ "name": "color", "format": "float32x2" }}, {attribute}] }}]"#
        ))
    };
    assert_eq!(one(r#"{ "name": "positon", "format": "float32x2" }"#), ["UG0603"]);
    assert_eq!(one(r#"{ "name": "position", "format": "uint32x2" }"#), ["UG0607"]);
    assert_eq!(one(r#"{ "name": "position", "format": "float31" }"#), ["UG0607"]);
    assert_eq!(one(r#"{ "name": "position", "format": "float32x2", "offset": 3 }"#), ["UG0409"]);
}

#[test]
fn a_live_count_beyond_the_buffers_is_rejected_for_one_frame() {
    let Some(gpu) = gpu::device() else { return };
    let instanced = POINTS.replace(r#""buffer": "&points","#, r#""buffer": "&points", "step": "instance","#);
    for (draw, most, buffer) in [
        (format!(r#"{POINTS}, "count": "=many""#), 64, "points"),
        (format!(r#"{POINTS}, "count": "=many", "indices": {{ "buffer": "&order" }}"#), 6, "order"),
        (format!(r#"{instanced}, "count": 3, "instances": "=many""#), 64, "points"),
    ] {
        let outcome = ribbon(&draw);
        let plan = outcome.plan();
        let mut executor = crate::common::gpu::executor(&gpu, plan, None);
        let target = crate::common::gpu::import(&gpu, plan, "target");
        let many = executor.parameter::<u32>("many").expect("a live parameter");
        let mut play = |many_now: u32| {
            executor.set(many, many_now).expect("within the parameter's own range");
            crate::executing::stage::play(
                &gpu,
                &mut executor,
                None,
                &target,
                &crate::executing::views::frame(&[]),
            )
        };
        assert!(play(most).is_ok(), "{draw}");
        for beyond in [most + 1, u32::MAX] {
            let rejected = format!("{:?}", play(beyond).expect_err("a diagnostic"));
            let wanted = format!("\\\"{buffer}\\\" has {most} of the {beyond} that are drawn of it");
            assert!(rejected.contains("UG0409") && rejected.contains(&wanted), "{rejected}");
        }
        let mut shown = |count: u32| {
            assert!(play(count).is_ok(), "{draw}");
            crate::executing::stage::texels(&gpu, &target, 0)
        };
        let (none, all, three) = (shown(0), shown(most), shown(3));
        let outcome = ribbon(&draw.replace(r#""=many""#, "3"));
        let mut fixed = crate::common::gpu::executor(&gpu, outcome.plan(), None);
        assert!(
            crate::executing::stage::play(
                &gpu,
                &mut fixed,
                None,
                &target,
                &crate::executing::views::frame(&[])
            )
            .is_ok(),
            "{draw}"
        );
        assert_eq!(three, crate::executing::stage::texels(&gpu, &target, 0), "{draw}");
        // Three vertices of one instance lie in one place, where nothing is seen of them.
        assert!(none != all || draw.contains("instances"), "{draw}");
    }
}
