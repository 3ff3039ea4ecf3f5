//! Parts of WebGPU's core mode that a target lacks are found in a plan, and features do without them.

use crate::common::{Outcome, With, check_with};
use umbragraph::low_level::shader::TargetProfile;

/// A pass in the middle of a pipeline, with its resources.
fn check(profile: &str, feature: &str, resources: &str, passes: &str) -> Outcome {
    let text = format!(
        r#"{{ "format": 1, "name": "test", "features": {{ {feature} }},
             "resources": {{ {resources} "target": {{ "texture": {{ "format": "rgba8unorm", "size": [64, 64], "lifetime": "imported" }} }} }},
             "passes": {{ {passes} }} }}"#
    );
    let templates = [
        ("blank.wgsl.jinja", BLANK),
        ("two.wgsl.jinja", TWO),
        ("read.wgsl.jinja", READ),
        ("array.wgsl.jinja", ARRAY),
    ];
    check_with(
        "test.json",
        &text,
        &With { profile: TargetProfile::from_name(profile), templates: &templates, ..With::default() },
    )
}

const BLANK: &str = "{% include 'lib/fullscreen.wgsl.jinja' %}
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(covered.uv, 0.0, 1.0); }";

const TWO: &str = "{% include 'lib/fullscreen.wgsl.jinja' %}
struct Colors { @location(0) a: vec4<f32>, @location(1) b: vec4<f32> }
@fragment fn fill(covered: Covered) -> Colors { return Colors(vec4<f32>(1.0), vec4<f32>(covered.uv, 0.0, 1.0)); }";

const READ: &str = "{% include 'lib/fullscreen.wgsl.jinja' %}
@group(1) @binding(0) var depth: texture_2d<f32>;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> {
    return vec4<f32>(textureLoad(depth, vec2<i32>(covered.position.xy), 0).r);
}";

const ARRAY: &str = "{% include 'lib/fullscreen.wgsl.jinja' %}
@group(1) @binding(0) var maps: texture_2d_array<f32>;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return textureLoad(maps, vec2<i32>(0), 0, 0); }";

/// An array, of which one layer is written, and a pass that samples it.
fn array(layers: u32, side: u32, show: &str) -> (String, String) {
    let maps = format!(
        r#""maps": {{ "texture": {{ "format": "rgba8unorm", "size": [64, {side}], "layers": {layers}, "view_dimension": "2d-array", "lifetime": "persistent" }} }},"#
    );
    let passes = format!(
        r#""paint": {{ "fullscreen": {{ "shader": "blank.wgsl.jinja", "color": [{{ "to": "&maps", "layer": 0 }}] }} }},
           "show": {{ "fullscreen": {{ {show}, "color": [{{ "to": "&target" }}] }} }}"#
    );
    (maps, passes)
}

const IMAGE: &str = r#""image": { "texture": { "format": "rgba8unorm", "size": [64, 64] } },"#;
const DEPTH: &str = r#""depth": { "texture": { "format": "depth32float", "size": [64, 64] } },
    "bytes": { "buffer": { "size": 65536, "lifetime": "persistent" } },"#;
const PAINT: &str =
    r#""paint": { "fullscreen": { "shader": "blank.wgsl.jinja", "color": [{ "to": "&image" }] } },"#;
const FAR: &str = r#""far": { "fullscreen": { "shader": "blank.wgsl.jinja", "color": [{ "to": "&target" }],
    "depth": { "to": "&depth", "clear": 1, "compare": "always" } } }"#;

/// The one diagnostic on a target that lacks a part, and none where it is there.
#[track_caller]
fn lacks(resources: &str, passes: &str, part: &str, words: &str) {
    let fine = check("webgpu", "", resources, passes);
    assert_eq!(fine.text(), "");
    for profile in ["gles", "webgl2"] {
        let outcome = check(profile, "", resources, passes);
        let text = outcome.text();
        assert_eq!(outcome.codes(), ["UG0409"], "{text}");
        assert!(text.contains(words) && text.contains(&format!("{profile} lacks \"{part}\"")), "{text}");
    }
}

#[test]
fn views_in_another_format_are_a_part() {
    let show = r#""show": { "fullscreen": { "shader": "resample.wgsl.jinja",
        "bind": { "source": { "texture": { "name": "&image", "format": "rgba8unorm-srgb" } } }, "color": [{ "to": "&target" }] } }"#;
    let words = "\"show\" sees \"image\", which is rgba8unorm, as rgba8unorm-srgb";
    lacks(IMAGE, &format!("{PAINT} {show}"), "view-formats", words);
}

#[test]
fn a_layer_seen_as_a_texture_of_its_own_is_a_part() {
    let show = r#""shader": "resample.wgsl.jinja", "bind": { "source": { "texture": { "name": "&maps", "layer": 0 } } }"#;
    let (maps, passes) = array(4, 64, show);
    lacks(
        &maps,
        &passes,
        "view-formats",
        "\"show\" samples \"maps\" as 2d, which is bound as 2d-array alone",
    );
}

/// On OpenGL an array that wgpu takes for cubes, or for a single texture, gets one more layer.
#[test]
fn arrays_that_look_like_something_else_have_a_spare_layer() {
    let show = r#""shader": "array.wgsl.jinja", "bind": { "maps": "&maps" }"#;
    for (layers, side, has_spare) in
        [(1, 64, true), (6, 64, true), (12, 64, true), (4, 64, false), (6, 32, false)]
    {
        let (maps, passes) = array(layers, side, show);
        let spare = |profile| {
            let outcome = check(profile, "", &maps, &passes);
            // A warning about layers that nothing writes is beside the point.
            let plan = outcome.checked.plan.as_ref().expect("a plan");
            (plan.textures[0].spare_layer, plan.textures[0].size.layers, plan.resources["maps"].bytes)
        };
        let bytes = u64::from(64 * side * layers * 4);
        assert_eq!(spare("gles"), (has_spare, layers, bytes));
        assert_eq!(spare("vulkan"), (false, layers, bytes));
    }
}

#[test]
fn reading_depth_that_is_tested_is_a_part() {
    let read = r#""read": { "fullscreen": { "shader": "read.wgsl.jinja", "bind": { "depth": "&depth" },
        "color": [{ "to": "&target" }], "depth": { "to": "&depth", "write": false, "compare": "less-equal" } } }"#;
    lacks(DEPTH, &format!("{FAR}, {read}"), "read-only-depth", "\"read\" reads \"depth\" while it is tested");
}

#[test]
fn copies_of_depth_to_buffers_are_a_part() {
    let copy = r#""keep": { "copy": { "from": { "name": "&depth" }, "to": { "name": "&bytes" } } }"#;
    let words = "\"keep\" copies \"depth\" to or from a buffer";
    lacks(DEPTH, &format!("{FAR}, {copy}"), "depth-buffer-copies", words);
}

#[test]
fn blend_states_of_their_own_are_a_part() {
    let pass = r#""both": { "fullscreen": { "shader": "two.wgsl.jinja",
        "color": [{ "to": "&target" }, { "to": "&image", "blend": "add", "clear": [0, 0, 0, 0] }] } },
        "show": { "side_effect": true, "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&image" },
        "color": [{ "to": "&target", "blend": "add" }] } }"#;
    lacks(IMAGE, pass, "independent-blend", "\"target\" and \"image\" have blend states");
}

#[test]
fn a_feature_that_requires_a_part_is_off_where_it_lacks() {
    let feature = r#""linear": { "type": "bool", "default": true, "required_features": ["view-formats"] }"#;
    let show = r#""show": { "when": "=linear", "fullscreen": { "shader": "resample.wgsl.jinja",
        "bind": { "source": { "texture": { "name": "&image", "format": "rgba8unorm-srgb" } } }, "color": [{ "to": "&target" }] } },
        "plain": { "when": "=!linear", "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&image" }, "color": [{ "to": "&target" }] } }"#;
    let passes = |profile| {
        let outcome = check(profile, feature, IMAGE, &format!("{PAINT} {show}"));
        assert_eq!(outcome.text(), "");
        outcome.plan().passes.last().map(|pass| pass.name.clone()).unwrap()
    };
    assert_eq!((passes("vulkan").as_str(), passes("gles").as_str()), ("show", "plain"));
}

#[test]
fn the_next_of_a_group_stands_in_for_what_is_lacking() {
    let feature = r#""cached": { "type": "bool", "default": false, "one_of": "fit" },
        "exact": { "type": "bool", "default": true, "one_of": "fit", "required_features": ["compute"] },
        "rough": { "type": "bool", "default": false, "one_of": "fit" }"#;
    let pass = r#""fill": { "when": "=exact || rough || cached", "fullscreen": { "shader": "blank.wgsl.jinja", "color": [{ "to": "&target" }] } }"#;
    let on = |profile| {
        let outcome = check(profile, feature, "", pass);
        assert!(!outcome.codes().contains(&"UG0217"), "{}", outcome.text());
        let features = outcome.plan().pipeline.features.clone();
        features.into_iter().filter(|(_, one)| one.is_on()).map(|(name, _)| name).collect::<Vec<_>>()
    };
    assert_eq!(on("gles"), ["exact"]);
    assert_eq!(on("webgl2"), ["rough"]);
}
