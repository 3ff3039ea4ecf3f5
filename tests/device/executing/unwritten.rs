//! Parts that are not written, or not in every state of the toggles, and bytes beside rows of texels.

use umbragraph_test_support::gpu;

use crate::common::gpu::import;
use crate::executing::stage::{SIDE, color, executor, fill, show, target, try_plan_of_text};
use crate::executing::views::frame;

const RED: [u8; 4] = [255, 0, 0, 255];

fn text(layers: u32, resources: &str, passes: &[&str]) -> String {
    let toggles = if passes.iter().any(|pass| pass.contains("\"toggle\"")) {
        r#""s": { "default": true }"#
    } else {
        ""
    };
    format!(
        r#"{{ "format": 1, "name": "test", "toggles": {{ {toggles} }}, "resources": {{ {}, {resources} }}, "passes": {{ {} }} }}"#,
        target(layers),
        passes.join(", ")
    )
}

/// The first line of what is wrong.
#[track_caller]
fn rejected(layers: u32, resources: &str, passes: &[&str]) -> String {
    match try_plan_of_text(text(layers, resources, passes), SIDE) {
        Ok(plan) => panic!("{:?}", plan.passes.iter().map(|pass| &pass.name).collect::<Vec<_>>()),
        Err(diagnostics) => diagnostics.lines().next().unwrap_or_default().to_owned(),
    }
}

/// The names of the passes, and the first layer of the second picture.
#[track_caller]
fn shown(layers: u32, resources: &str, passes: &[&str]) -> Option<(Vec<String>, [u8; 4])> {
    let gpu = gpu::device()?;
    let plan =
        try_plan_of_text(text(layers, resources, passes), SIDE).unwrap_or_else(|said| panic!("{said}"));
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    for _ in 0..2 {
        show(&gpu, &mut executor, None, &picture, &frame(&[]));
    }
    Some((plan.passes.iter().map(|pass| pass.name.clone()).collect(), color(&gpu, &picture, 0)))
}

fn red(name: &str, to: &str, common: &str) -> String {
    fill(name, to, "[1, 0, 0, 1]").replacen(r#"": {"#, &format!(r#"": {{ {common}"#), 1)
}

fn texture(name: &str, more: &str) -> String {
    format!(r#""{name}": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" {more} }} }}"#)
}

fn copy(name: &str, common: &str, from: &str, to: &str) -> String {
    format!(
        r#""{name}": {{ {common} "copy": {{ "from": {{ "name": "&{from}" }}, "to": {{ "name": "&{to}" }} }} }}"#
    )
}

#[test]
fn existing_layers_that_a_toggle_leaves_unwritten_are_errors() {
    let first = red("first", r#"{ "to": "&all", "layer": 0 }"#, "");
    let rest = copy("rest", r#""toggle": "s", "after": ["first"],"#, "source", "all");
    let reads = copy("shown", "", "all", "target");
    for layers in [1, 3] {
        let more = format!(r#", "layers": {layers}"#);
        let resources = [texture("all", &more), texture("source", &more)].join(", ");
        let sources: Vec<String> = (0..layers)
            .map(|at| red(&format!("source{at}"), &format!(r#"{{ "to": "&source", "layer": {at} }}"#), ""))
            .collect();
        let mut passes: Vec<&str> = vec![&first, &rest, &reads];
        passes.extend(sources.iter().map(String::as_str));
        if layers == 1 {
            let Some((_, seen)) = shown(1, &resources, &passes) else { return };
            assert_eq!(seen, RED);
            continue;
        }
        let said = rejected(layers, &resources, &passes);
        let wanted = r#""shown" reads layers 1 to 2 of "all", which nothing writes while "s" is off"#;
        assert!(said.contains(wanted), "{said}");
    }
}

#[test]
fn history_layers_that_a_toggle_leaves_stale_are_errors() {
    let past = texture("past", r#", "layers": 2, "lifetime": "history", "initial": [0, 0, 0, 1]"#);
    let first = red("first", r#"{ "to": "&past", "layer": 0 }"#, "");
    let reads = copy("shown", "", "past@-1", "target");
    let second = |common: &str| red("second", r#"{ "to": "&past", "layer": 1 }"#, common);
    let said = rejected(2, &past, &[&first, &second(r#""toggle": "s","#), &reads]);
    assert!(
        said.contains(r#""shown" reads layer 1 of "past@-1", which nothing writes while "s" is off"#),
        "{said}"
    );
    let Some((_, seen)) = shown(2, &past, &[&first, &second(""), &reads]) else { return };
    assert_eq!(seen, RED);
    // Of one layer all of it is written in both states.
    let one = reads
        .replace(r#""&past@-1""#, r#""&past@-1", "layer": 0"#)
        .replace(r#""&target""#, r#""&target", "layer": 0"#);
    let other = red("other", r#"{ "to": "&target", "layer": 1 }"#, "");
    let Some((_, seen)) = shown(2, &past, &[&first, &second(r#""toggle": "s","#), &one, &other]) else {
        return;
    };
    assert_eq!(seen, RED);
}

#[test]
fn picture_layers_that_a_toggle_leaves_unwritten_are_errors() {
    let resources = texture("source", r#", "layers": 3"#);
    let sources: Vec<String> = (0..3)
        .map(|at| red(&format!("source{at}"), &format!(r#"{{ "to": "&source", "layer": {at} }}"#), ""))
        .collect();
    let first = red("first", r#"{ "to": "&target", "layer": 0 }"#, "");
    let rest = copy("rest", r#""toggle": "s", "after": ["first"],"#, "source", "target");
    let mut passes: Vec<&str> = vec![&first, &rest];
    passes.extend(sources.iter().map(String::as_str));
    let said = rejected(3, &resources, &passes);
    assert!(said.contains(r#"nothing writes "target" while "s" is off"#), "{said}");
}

#[test]
fn reads_of_bytes_beside_texel_rows_are_errors() {
    let resources = format!(r#"{}, "bytes": {{ "buffer": {{ "size": 2048 }} }}"#, texture("small", ""));
    let small = red("small", r#"{ "to": "&small" }"#, "");
    let rows = copy("rows", "", "small", "bytes");
    let reads = |part: &str| {
        format!(
            r#""shown": {{ "fullscreen": {{ "shader": "word.wgsl.jinja",
                "bind": {{ "words": {{ "buffer": {{ "name": "&bytes" {part} }} }} }}, "color": [{{ "to": "&target" }}] }} }}"#
        )
    };
    let said = rejected(1, &resources, &[&small, &rows, &reads("")]);
    let wanted = r#"of "bytes", which "rows" leaves beside its rows of texels"#;
    assert!(said.contains(r#""shown" reads bytes 32 to 255,"#) && said.contains(wanted), "{said}");
    // The rows of a second layer are filled, too.
    let pair = resources
        .replace(r#""size": "=viewport" "#, r#""size": "=viewport", "layers": 2"#)
        .replace("2048", "4096");
    let layers =
        [0, 1].map(|at| red(&format!("small{at}"), &format!(r#"{{ "to": "&small", "layer": {at} }}"#), ""));
    let after = reads(r#", "offset": 2304, "size": 256"#);
    let said = rejected(1, &pair, &[&layers[0], &layers[1], &rows, &after]);
    assert!(said.contains(r#""shown" reads bytes 2336 to 2559 of"#), "{said}");
    // A row alone is read, or the gaps are filled, or the other end has the same rows.
    let Some((names, _)) = shown(1, &resources, &[&small, &rows, &reads(r#", "offset": 0, "size": 32"#)])
    else {
        return;
    };
    assert_eq!(names, ["small", "rows", "shown"]);
    let none = r#""none": { "clear": { "buffer": "&bytes" } }"#;
    let after = copy("rows", r#""after": ["none"],"#, "small", "bytes");
    let Some((names, seen)) = shown(1, &resources, &[&small, none, &after, &reads("")]) else { return };
    assert_eq!((names.len(), seen), (4, [0, 0, 0, 255]));
    let Some((_, seen)) = shown(1, &resources, &[&small, &rows, &copy("shown", "", "bytes", "target")])
    else {
        return;
    };
    assert_eq!(seen, RED);
}

#[test]
fn missing_bytes_and_slices_are_named_with_a_way_out() {
    let said = |resources: &str, passes: &[&str]| {
        try_plan_of_text(text(1, resources, passes), SIDE).map(drop).expect_err("a diagnostic")
    };
    let bytes = r#""bytes": { "buffer": { "size": 2048 } }"#;
    let half = r#""half": { "clear": { "buffer": "&bytes", "offset": 0, "size": 1024 } }"#;
    let counted = r#""counted": { "compute": { "shader": "count.wgsl.jinja", "bind": { "sum": "&bytes" },
        "workgroups": [1, 1, 1] }, "side_effect": true }"#;
    let found = said(bytes, &[half, counted]);
    assert!(found.contains(r#""counted" loads bytes 1024 to 2047 of "bytes""#), "{found}");
    assert!(found.contains(r#"or say that nothing of it is needed: "contents": "discard""#), "{found}");
    let read = r#""read": { "fullscreen": { "shader": "word.wgsl.jinja", "bind": { "words": "&bytes" },
        "color": [{ "to": "&target" }] } }"#;
    let found = said(bytes, &[half, read]);
    assert!(found.contains(r#"or read fewer bytes with "offset" and "size""#), "{found}");
    let volumes =
        ["volume", "other"].map(|name| texture(name, r#", "layers": 4, "view_dimension": "3d""#)).join(", ");
    let volumes = format!("{volumes}, {}", texture("small", ""));
    let small = red("small", r#"{ "to": "&small" }"#, "");
    let first =
        r#""first": { "copy": { "from": { "name": "&small" }, "to": { "name": "&volume", "layer": 0 } } }"#;
    let all = copy("all", r#""side_effect": true,"#, "volume", "other");
    let found = said(&volumes, &[&small, first, &all]);
    assert!(found.contains(r#""all" reads slices 1 to 3 of "volume""#), "{found}");
}

#[test]
fn a_storage_write_without_a_mip_writes_the_first() {
    let resources = texture("image", r#", "mips": 2"#);
    let second = red("second", r#"{ "to": "&image", "mip": 1 }"#, "");
    let half = r#""half": { "after": ["second"], "compute": { "shader": "half.wgsl.jinja", "workgroups": [1, 1, 1],
        "bind": { "image": "&image" } } }"#;
    let reads = r#""shown": { "fullscreen": { "shader": "enlarge.wgsl.jinja",
        "bind": { "picture": { "texture": { "name": "&image", "mip": 1 } } }, "color": [{ "to": "&target" }] } }"#;
    let Some((names, seen)) = shown(1, &resources, &[&second, half, reads]) else { return };
    assert_eq!((names, seen), (vec!["second".to_owned(), "shown".to_owned()], RED));
}

#[test]
fn storage_of_several_mips_is_rejected() {
    let resources = texture("image", r#", "mips": 2"#);
    let half = r#""half": { "compute": { "shader": "half.wgsl.jinja", "workgroups": [1, 1, 1],
        "bind": { "image": { "texture": { "name": "&image", "mips": 2 } } } } }"#;
    let said = rejected(1, &resources, &[half, &copy("shown", "", "image", "target")]);
    assert!(said.contains("UG0302") && said.contains("storage is one mip level, these are 2"), "{said}");
}

#[test]
fn a_culled_pass_reports_unwritten_but_not_partial_reads() {
    let resources = [texture("dead", ""), texture("pair", r#", "layers": 2"#)].join(", ");
    let first = red("first", r#"{ "to": "&pair", "layer": 0 }"#, "");
    let whole = red("whole", r#"{ "to": "&target" }"#, "");
    let dead =
        r#""dead": { "copy": { "from": { "name": "&pair", "layer": 1 }, "to": { "name": "&dead" } } }"#;
    let said = rejected(1, &resources, &[&whole, dead]);
    assert!(said.contains(r#""dead" reads "pair", which nothing writes before"#), "{said}");
    let pair = [texture("dead", r#", "layers": 2"#), texture("pair", r#", "layers": 2"#)].join(", ");
    let Some((names, _)) = shown(1, &pair, &[&whole, &first, &copy("dead", "", "pair", "dead")]) else {
        return;
    };
    assert_eq!(names, ["whole"]);
    let explained =
        umbragraph::diagnostic::codes::ALL.iter().find(|code| code.id == "UG0401").expect("a code");
    assert!(explained.page.contains("only a read of which nothing at all is written is told"));
}

#[test]
fn never_written_persistent_reads_are_a_warning() {
    use crate::common::{With, check_with};
    let reads = r#""{% include 'lib/fullscreen.wgsl.jinja' %}"#;
    let shader = format!(
        "{}\n@group(1) @binding(0) var image: texture_2d_array<f32>;\n@fragment fn show(covered: Covered) -> @location(0) \
         vec4<f32> {{ return textureLoad(image, vec2<i32>(covered.position.xy), 1, 0); }}\n",
        &reads[1..]
    );
    let half = "@group(1) @binding(0) var image: texture_storage_2d<rgba8unorm, write>;
        @compute @workgroup_size(8, 8) fn half(@builtin(global_invocation_id) at: vec3<u32>) {
            textureStore(image, at.xy, vec4<f32>(0.0, 1.0, 0.0, 1.0));
        }";
    let templates = [("shown.wgsl.jinja", shader.as_str()), ("half.wgsl.jinja", half)];
    let warnings = |lifetime: &str, written: &str, bound: &str| {
        let text = format!(
            r#"{{ "format": 1, "name": "test", "resources": {{ {}, "image": {{ "texture": {{ "format": "rgba8unorm",
              "size": "=viewport", "layers": 2, {lifetime} }} }} }}, "passes": {{ {written}
              "shown": {{ "fullscreen": {{ "shader": "shown.wgsl.jinja", "bind": {{ "image": {bound} }},
                "color": [{{ "to": "&target" }}] }} }} }} }}"#,
            target(1)
        );
        let with = With { templates: &templates, size: Some([8, 8]), ..With::default() };
        let outcome = check_with("lasting.json", &text, &with);
        assert!(!outcome.diagnostics.has_errors(), "{:?}", outcome.diagnostics);
        outcome.diagnostics.iter().map(|one| format!("{} {}", one.code.id, one.message)).collect::<Vec<_>>()
    };
    let (persistent, history) =
        (r#""lifetime": "persistent""#, r#""lifetime": "history", "initial": [0, 0, 0, 1]"#);
    let half = r#""half": { "compute": { "shader": "half.wgsl.jinja", "workgroups": [1, 1, 1],
        "bind": { "image": { "texture": { "name": "&image", "layer": 0 } } } } },"#;
    let never =
        |what: &str| vec![format!("UG0401 \"shown\" reads {what}, which no pass writes in any frame")];
    assert_eq!(warnings(persistent, "", r#""&image""#), never(r#""image""#));
    assert_eq!(warnings(persistent, half, r#""&image""#), never(r#"layer 1 of "image""#));
    assert_eq!(warnings(history, half, r#""&image@-1""#), never(r#"layer 1 of "image@-1""#));
    let one = |name: &str| format!(r#"{{ "texture": {{ "name": "&{name}", "layer": 0, "layers": 1 }} }}"#);
    assert_eq!(warnings(persistent, half, &one("image")), Vec::<String>::new());
    assert_eq!(warnings(history, half, &one("image@-1")), Vec::<String>::new());
    assert_eq!(warnings(r#""lifetime": "imported""#, "", r#""&image""#), Vec::<String>::new());
}
