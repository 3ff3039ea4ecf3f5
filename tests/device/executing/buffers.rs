//! Buffers: counts for dispatches, copies and clears, and samples that are resolved.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::squares::{RED, Squares, square};
use crate::executing::stage::{color, draw, executor, plan, show, target, texels};
use crate::executing::views::frame;

/// The picture of a buffer's bytes after a dispatch whose counts a buffer says.
fn counted(name: &str) -> Vec<[u8; 4]> {
    let Some(gpu) = gpu::device() else { return Vec::new() };
    let resources = format!(
        r#"{}, "words": {{ "buffer": {{ "size": 16 }} }}, "moved": {{ "buffer": {{ "size": 32 }} }},
           "sum": {{ "buffer": {{ "size": 2048 }} }}"#,
        target(1)
    );
    let passes = format!(
        r#""empty": {{ "clear": {{ "buffer": "&words" }} }},
           "say": {{ "compute": {{ "shader": "counts.wgsl.jinja", "bind": {{ "words": "&words" }}, "workgroups": [1, 1, 1] }} }},
           "move": {{ "copy": {{ "from": {{ "name": "&words", "offset": 0, "size": 12 }}, "to": {{ "name": "&moved", "offset": 8, "size": 12 }} }} }},
           "none": {{ "clear": {{ "buffer": "&sum" }} }},
           "count": {{ "compute": {{ "shader": "count.wgsl.jinja", "bind": {{ "sum": "&sum" }}, "indirect": {name} }} }},
           "shown": {{ "copy": {{ "from": {{ "name": "&sum" }}, "to": {{ "name": "&target" }} }} }}"#
    );
    let plan = plan(&resources, &passes);
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    // The second frame begins as the first did, since the sum is cleared.
    show(&gpu, &mut executor, None, &picture, &frame(&[]));
    show(&gpu, &mut executor, None, &picture, &frame(&[]));
    texels(&gpu, &picture, 0)
}

#[test]
fn a_dispatch_runs_as_many_workgroups_as_a_buffer_says() {
    for name in [r#"{ "buffer": "&words" }"#, r#"{ "buffer": "&moved", "offset": 8 }"#] {
        let found = counted(name);
        // Three by two workgroups of four invocations each; the rest of the buffer is cleared.
        let mut expected = vec![[0; 4]; 64];
        expected[0] = [24, 0, 0, 0];
        assert!(found.is_empty() || found == expected, "{name}: {found:?}");
    }
}

#[test]
fn samples_are_resolved_to_one_for_each_texel() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "samples": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "samples": 4 }} }}"#,
        target(1)
    );
    let to = r#"{ "to": "&samples", "clear": [0, 0, 1, 1], "resolve": { "to": "&target" } }"#;
    let plan = plan(&resources, &draw(1, to));
    let attachment = &plan.passes[1].color[0];
    assert!(attachment.transient_attachment, "only what the samples are resolved to leaves the pass");
    let squares = Squares::new(&gpu.device, &gpu.queue, &[square(RED)], &[[1.0; 4]]);
    let mut executor = executor(&gpu, &plan, Some(&squares));
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, Some(&squares), &picture, &frame(&["0"]));
    assert_eq!(color(&gpu, &picture, 0), [255, 0, 0, 255]);
}

#[test]
fn an_aliased_buffer_has_its_own_length_in_the_shader() {
    let Some(gpu) = gpu::device() else { return };
    let resources = format!(
        r#"{}, "short": {{ "buffer": {{ "size": 900 }} }}, "long": {{ "buffer": {{ "size": 1000 }} }},
           "lengths": {{ "buffer": {{ "size": 2048 }} }}"#,
        target(1)
    );
    let tell = |name: &str, after: &str| {
        format!(
            r#""{name}_begins": {{ {after} "clear": {{ "buffer": "&{name}" }} }},
               "tell_{name}": {{ {after} "compute": {{ "shader": "length.wgsl.jinja",
                   "bind": {{ "words": "&{name}", "lengths": "&lengths" }}, "workgroups": [1, 1, 1] }} }}"#
        )
    };
    let passes = format!(
        r#""none": {{ "clear": {{ "buffer": "&lengths" }} }}, {}, {},
           "shown": {{ "copy": {{ "from": {{ "name": "&lengths" }}, "to": {{ "name": "&target" }} }} }}"#,
        tell("short", ""),
        tell("long", r#""after": ["tell_short"],"#)
    );
    let plan = plan(&resources, &passes);
    assert_eq!(plan.resources["short"].physical, plan.resources["long"].physical);
    let mut bytes: Vec<u64> = plan.buffers.iter().map(|buffer| buffer.bytes).collect();
    bytes.sort_unstable();
    assert_eq!(bytes, [1000, 2048]);
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    show(&gpu, &mut executor, None, &picture, &frame(&[]));
    let words = texels(&gpu, &picture, 0).into_iter().map(u32::from_le_bytes);
    assert_eq!(words.take(4).collect::<Vec<_>>(), [2, 900 / 4, 1000 / 4, 0]);
    // The host sees them, too.
    let sizes = ["short", "long", "lengths"].map(|name| executor.buffer(name).map(wgpu::Buffer::size));
    assert_eq!(sizes, [Some(1000), Some(1000), Some(2048)]);
    assert!(executor.buffer("target").is_none() && executor.texture("lengths").is_none());
}
