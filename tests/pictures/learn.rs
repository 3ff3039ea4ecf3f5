//! The teaching pipelines under `pipelines/learn/`: each is valid, and does what it teaches.

use crate::common::{Outcome, With, check_file, root};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::wgpu_types::{DownlevelFlags, Limits, TextureFormat};

fn lesson(name: &str) -> Outcome {
    check_file(&format!("pipelines/learn/{name}.json"), &With::default())
}

#[track_caller]
fn size(outcome: &Outcome, resource: &str) -> (u32, u32) {
    let size = outcome.plan().resources[resource].size.unwrap();
    (size.width, size.height)
}

fn names() -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(root().join("pipelines/learn"))
        .unwrap()
        .flatten()
        .filter_map(|entry| entry.file_name().to_string_lossy().strip_suffix(".json").map(str::to_owned))
        .collect();
    names.sort();
    names
}

#[test]
fn every_lesson_opens_with_a_comment_and_is_valid() {
    let names = names();
    assert_eq!(names.len(), 35, "a new lesson needs a test of its own here");
    for name in names {
        let text = std::fs::read_to_string(root().join(format!("pipelines/learn/{name}.json"))).unwrap();
        assert!(text.starts_with("// "), "{name}");
        lesson(&name).plan();
    }
}

#[test]
fn effects_are_uses_of_their_files() {
    let outcome = lesson("33-effects");
    let order = outcome.order();
    let at = |name: &str| {
        order.iter().position(|pass| *pass == name).unwrap_or_else(|| panic!("no {name} in {order:?}"))
    };
    assert!(at("shade") < at("find_occlusion.gather") && at("find_occlusion.enlarge") < at("occlude"));
    assert!(
        at("occlude") < at("sky") && at("sky") < at("bloom.shrink") && at("bloom.mix") < at("expose.count")
    );
    assert!(at("expose.apply") < at("present"));
    assert_eq!(size(&outcome, "find_occlusion.noisy"), (320, 240));
}

#[test]
fn motion_is_drawn_between_what_is_seen_and_the_mean() {
    let order: Vec<_> = lesson("34-motion").order().into_iter().map(str::to_owned).collect();
    let at = |name: &str| order.iter().position(|pass| pass == name).expect("a pass");
    assert!(at("shade") < at("move") && at("move") < at("gather"), "{order:?}");
}

#[test]
fn rays_need_no_pass_but_the_one_that_traces() {
    assert_eq!(lesson("35-rays").order(), ["eye", "list", "trace"]);
}

#[test]
fn the_smallest_pipeline_is_one_pass() {
    assert_eq!(lesson("01-smallest").order(), ["fill"]);
}

#[test]
fn the_order_of_passes_follows_from_what_they_use() {
    assert_eq!(lesson("02-resources").order(), ["paint", "keep", "show"]);
}

#[test]
fn toggles_are_in_one_plan_with_the_fallback() {
    let outcome = lesson("17-toggles");
    assert_eq!(outcome.order(), ["paint", "quarter", "soften", "show", "veil"]);
    let pass = |name: &str| outcome.plan().passes.iter().find(|pass| pass.name == name).unwrap();
    assert_eq!(pass("quarter").toggle.as_deref(), Some("softer"));
    assert_eq!(pass("soften").passthrough["soft"], "color");
    assert_eq!(outcome.plan().resources["color"].last, 4);
}

#[test]
fn vertices_and_how_many_there_are_come_from_a_pass() {
    let outcome = lesson("18-mesh");
    assert_eq!(outcome.order(), ["no_points", "no_arguments", "wave", "draw"]);
    assert_eq!(outcome.plan().resources["points"].bytes, 64 * 2 * 16);
}

#[test]
fn a_version_is_read_before_it_is_overwritten() {
    let outcome = lesson("03-versions");
    let order = outcome.order();
    let at = |name: &str| order.iter().position(|pass| *pass == name).unwrap();
    assert!(
        at("paint") < at("before") && at("before") < at("brighten") && at("brighten") < at("after"),
        "{order:?}"
    );
}

#[test]
fn sizes_follow_a_parameter_within_its_range() {
    let outcome = lesson("04-expressions");
    assert_eq!((size(&outcome, "small"), size(&outcome, "strip")), ((320, 240), (320, 80)));
    let with = |value| With { parameters: value, ..With::default() };
    let eighth = check_file("pipelines/learn/04-expressions.json", &with(&[("divisor", "8")]));
    assert_eq!((size(&eighth, "small"), size(&eighth, "strip")), ((80, 60), (80, 20)));
    let rejected = check_file("pipelines/learn/04-expressions.json", &with(&[("divisor", "9")]));
    assert_eq!(rejected.codes(), ["UG0204"]);
}

#[test]
fn the_first_format_that_serves_every_use_is_taken() {
    assert_eq!(lesson("05-formats").plan().resources["color"].format, Some(TextureFormat::Rgba16Float));
}

#[test]
fn extending_replaces_adds_and_deletes() {
    let outcome = lesson("06-extends");
    assert_eq!(outcome.order(), ["paint", "show"]);
    assert_eq!(size(&outcome, "painted"), (64, 64));
    assert!(!outcome.plan().resources.contains_key("kept"));
}

#[test]
fn an_include_adds_its_sections() {
    let outcome = lesson("07-include");
    assert_eq!(size(&outcome, "canvas"), (128, 128));
    assert!(outcome.plan().pipeline.parameters.contains_key("canvas_side"));
}

#[test]
fn each_use_of_a_subgraph_has_own_resources_and_parameters() {
    let outcome = lesson("08-subgraph");
    assert_eq!(
        outcome.order(),
        ["paint", "soft.down", "soft.up", "coarse.down", "coarse.up", "brighter.add"]
    );
    assert_eq!((size(&outcome, "soft.small"), size(&outcome, "coarse.small")), ((320, 240), (40, 30)));
}

#[test]
fn derived_values_follow_from_parameters() {
    let outcome = lesson("24-derived");
    assert_eq!(outcome.order(), ["paint", "shrink", "show"]);
    assert_eq!((size(&outcome, "small"), size(&outcome, "smaller")), ((320, 240), (160, 120)));
    let low = With { parameters: &[("quality", "\"low\"")], ..With::default() };
    let low = check_file("pipelines/learn/24-derived.json", &low);
    assert_eq!(low.order(), ["paint", "show_coarse"]);
    assert_eq!(size(&low, "small"), (80, 60));
    let set = With { parameters: &[("divisor", "4")], ..With::default() };
    assert_eq!(check_file("pipelines/learn/24-derived.json", &set).codes(), ["UG0202"]);
}

#[test]
fn constraints_say_which_values_go_together() {
    let with = |parameters| {
        let with = With { parameters, ..With::default() };
        check_file("pipelines/learn/31-constraints.json", &with)
    };
    assert!(with(&[]).diagnostics.is_empty());
    let wide = with(&[("high", "64")]);
    assert_eq!(wide.text().lines().next(), Some("warning[UG0223]: the strip takes 64 KiB or more"));
    let both = with(&[("high", "128")]);
    assert_eq!(both.codes(), ["UG0223", "UG0223"]);
    assert_eq!(both.diagnostics.error_count(), 1);
    assert!(
        both.text().contains("\"high\" is 128") && both.text().contains("help: change high"),
        "{}",
        both.text()
    );
}

#[test]
fn passes_are_laid_over_the_settings_that_they_share() {
    use umbragraph::work::{Address, Filter, SlotSource, Work};
    let outcome = lesson("25-shared-settings");
    assert_eq!(outcome.order(), ["paint", "show", "veil", "again"]);
    let pipeline = &outcome.plan().pipeline;
    let sampler = |name: &str| {
        let Work::Render(render) = pipeline.pass(pipeline.find_pass(name).unwrap()).work() else {
            panic!("{name}")
        };
        let (_, slots) = render.draw.bound();
        let samplers = slots.iter().filter_map(|slot| match &slot.source {
            SlotSource::Sampler(sampler) => Some((sampler.filter, sampler.address)),
            _ => None,
        });
        samplers.collect::<Vec<_>>()
    };
    assert_eq!(sampler("show"), [(Filter::Nearest, Address::Repeat)]);
    assert_eq!(sampler("veil"), [(Filter::Linear, Address::ClampToEdge)]);
    assert_eq!(sampler("again"), [(Filter::Linear, Address::Repeat)]);
}

#[test]
fn what_is_replaced_needs_nothing_before() {
    use umbragraph::low_level::compiler::StoreOperation;
    let outcome = lesson("22-contents");
    assert_eq!(outcome.order(), ["wave", "above", "draw"]);
    let depth = outcome.plan().passes[2].depth.as_ref().map(|depth| depth.store);
    assert_eq!(depth, Some(StoreOperation::Discard));
}

#[test]
fn a_subgraph_can_be_a_file() {
    let outcome = lesson("21-subgraph-file");
    assert_eq!(outcome.order(), ["paint", "soften.down", "soften.up", "softer.down", "softer.up"]);
    assert_eq!((size(&outcome, "soften.small"), size(&outcome, "softer.small")), ((320, 240), (40, 30)));
}

#[test]
fn a_loop_has_a_pass_for_each_round() {
    assert_eq!(lesson("09-loops-and-mips").order(), ["paint", "down.0", "down.1", "down.2", "show"]);
    let parameters: &[(&str, &str)] = &[("levels", "3")];
    let outcome =
        check_file("pipelines/learn/09-loops-and-mips.json", &With { parameters, ..With::default() });
    assert_eq!(outcome.order(), ["paint", "down.0", "down.1", "show"]);
}

#[test]
fn features_switch_passes_and_require_one_another() {
    assert_eq!(lesson("10-features").order(), ["paint", "show"]);
    let path = "pipelines/learn/10-features.json";
    let with = |features| check_file(path, &With { features, ..With::default() });
    assert_eq!(with(&[("glow", "true")]).order(), ["paint", "show", "glow"]);
    let both = with(&[("glow", "true"), ("strong_glow", "true")]);
    assert_eq!(both.order(), ["paint", "show", "glow", "glow_again"]);
    let conflict = with(&[("strong_glow", "true")]);
    assert!(
        conflict.diagnostics.has_errors() && conflict.text().contains("requires \"glow\""),
        "{}",
        conflict.text()
    );
}

#[test]
fn of_a_group_of_features_exactly_one_is_on() {
    assert_eq!(lesson("19-feature-groups").order(), ["paint", "show"]);
    let path = "pipelines/learn/19-feature-groups.json";
    let with = |features| check_file(path, &With { features, ..With::default() });
    assert_eq!(with(&[("bright", "true")]).order(), ["paint", "show", "again"]);
    assert_eq!(with(&[("covered", "true")]).order(), ["paint", "show", "cover"]);
    assert_eq!(with(&[("covered", "true"), ("bright", "true")]).codes(), ["UG0217", "UG0402"]);
    assert_eq!(with(&[("plain", "false")]).codes(), ["UG0217"]);
}

#[test]
fn a_feature_is_off_where_the_profile_has_less_than_it_requires() {
    let path = "pipelines/learn/23-required-limits.json";
    let on =
        |profile, features| check_file(path, &With { profile: Some(profile), features, ..With::default() });
    assert_eq!(size(&on(TargetProfile::webgpu(), &[]), "strip"), (8192, 8));
    assert_eq!(size(&on(TargetProfile::webgpu(), &[("wide", "false")]), "strip"), (4096, 8));
    assert_eq!(size(&on(TargetProfile::webgpu_compat(), &[]), "strip"), (4096, 8));
    assert_eq!(size(&on(TargetProfile::webgpu_compat(), &[("wide", "false")]), "strip"), (4096, 8));
    let rejected = on(TargetProfile::webgpu_compat(), &[("wide", "true")]);
    assert!(rejected.codes() == ["UG0219"], "{}", rejected.text());
    let text = rejected.text();
    assert!(text.contains("of at least 8192, but webgpu-compat has 4096"), "{text}");
}

#[test]
fn a_lesser_device_switches_a_feature_off_a_better_one_none() {
    let limits = |max_texture_dimension_2d| Limits { max_texture_dimension_2d, ..Limits::defaults() };
    let profile = |max| TargetProfile::webgpu().on_device(&limits(max), DownlevelFlags::all());
    assert_eq!(profile(16384), TargetProfile::webgpu());
    let path = "pipelines/learn/23-required-limits.json";
    let on = |max| check_file(path, &With { profile: Some(profile(max)), ..With::default() });
    assert_eq!(size(&on(16384), "strip"), (8192, 8));
    assert_eq!(size(&on(4096), "strip"), (4096, 8));
}

#[test]
fn of_several_entry_points_one_is_named() {
    const TWO: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@fragment fn alike(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(1.0); }
@fragment fn other(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(0.5); }
"#;
    let check = |entry_points: &str| {
        let text = format!(
            r#"{{ "format": 1, "name": "two",
  "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{ "fill": {{ "fullscreen": {{ "shader": "two.wgsl.jinja"{entry_points}, "color": [{{ "to": "&target" }}] }} }} }} }}"#
        );
        let with = With { templates: &[("two.wgsl.jinja", TWO)], ..With::default() };
        crate::common::check_with("two.json", &text, &with)
    };
    let taken = |entry_points: &str| {
        let outcome = check(entry_points);
        let variant = &outcome.plan().pipeline.programs[0].variants[0];
        variant.entry_point(umbragraph::low_level::shader::Stage::Fragment).unwrap().name.clone()
    };
    let unnamed = check("");
    assert_eq!(unnamed.codes(), ["UG0609"]);
    assert!(
        unnamed.text().contains("2 entry points of the stage @fragment: alike, other"),
        "{}",
        unnamed.text()
    );
    assert_eq!(taken(r#", "entry_points": { "fragment": "other" }"#), "other");
    let rejected = check(r#", "entry_points": { "fragment": "othre" }"#);
    assert_eq!(rejected.codes(), ["UG0609"]);
    assert!(rejected.text().contains("did you mean \"other\"?"), "{}", rejected.text());
}

#[test]
fn a_feature_of_webgpu_is_there_where_the_profile_has_it() {
    let check = |name: &str, profile: &str, features: &[(&str, &str)]| {
        let text = format!(
            r#"{{ "format": 1, "name": "filtered",
  "features": {{ "fine": {{ "type": "bool", "default": true, "required_features": ["{name}"] }} }},
  "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=fine ? [64, 64] : [32, 32]", "lifetime": "imported" }} }} }},
  "passes": {{ "fill": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target" }}] }} }} }} }}"#
        );
        let profile = TargetProfile::from_name(profile);
        crate::common::check_with("filtered.json", &text, &With { profile, features, ..With::default() })
    };
    let filterable = "float32-filterable";
    assert_eq!(size(&check(filterable, "webgpu", &[]), "target"), (32, 32));
    assert_eq!(size(&check(filterable, "webgpu+float32-filterable", &[]), "target"), (64, 64));
    let rejected = check(filterable, "webgpu", &[("fine", "true")]);
    assert_eq!(rejected.codes(), ["UG0219"]);
    let unknown = check("float32-filtrable", "webgpu", &[]);
    assert!(unknown.codes() == ["UG0218"] && unknown.text().contains(filterable), "{}", unknown.text());
    assert_eq!(TargetProfile::from_name("webgpu+filters"), None);
}

#[test]
fn a_preset_leaves_off_what_the_target_lacks() {
    const TEXT: &str = r#"{ "format": 1, "name": "preset",
  "features": {
    "coarse": { "type": "bool", "default": true, "one_of": "size" },
    "fine": { "type": "bool", "default": false, "one_of": "size", "required_features": ["compute"] },
    "finest": { "type": "bool", "default": false, "requires": ["fine"] }
  },
  "presets": { "high": { "features": { "fine": true, "finest": true } } },
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=fine && finest ? [64, 64] : [32, 32]", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } } } }"#;
    let check = |profile, preset, features| {
        let profile = Some(profile);
        crate::common::check_with("preset.json", TEXT, &With { profile, preset, features, ..With::default() })
    };
    let (whole, lesser) = (TargetProfile::webgpu, || TargetProfile::from_name("webgl2").unwrap());
    assert_eq!(size(&check(whole(), Some("high"), &[]), "target"), (64, 64));
    assert_eq!(size(&check(lesser(), Some("high"), &[]), "target"), (32, 32));
    assert_eq!(check(lesser(), Some("high"), &[("fine", "true")]).codes(), ["UG0219"]);
}

#[test]
fn each_pipeline_has_points_for_extensions() {
    let pass = |name: &str, to: &str| {
        format!(
            r#"{{ "{name}": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&{to}", "blend": "add" }}] }} }} }}"#
        )
    };
    for pipeline in ["nebula", "mantis", "caracal", "lore", "awsm", "umbra"] {
        let path = format!("pipelines/{pipeline}.json");
        let text = std::fs::read_to_string(root().join(&path)).unwrap();
        let extension = format!(
            r#"{{ "format": 1, "name": "three", "inserts": {{ "after_depth": {}, "before_tone_mapping": {}, "after_picture": {} }} }}"#,
            pass("first", "color"),
            pass("second", "color"),
            pass("third", "target")
        );
        let folder = umbragraph_test_support::scratch::ScratchFolder::new("points");
        let file = folder.join("three.json");
        std::fs::write(&file, extension).unwrap();
        let with = With { extension: Some(file.to_str().unwrap()), ..With::default() };
        let outcome = crate::common::check_with(&path, &text, &with);
        let order = outcome.order();
        let at =
            |name: &str| order.iter().position(|pass| *pass == name).unwrap_or_else(|| panic!("{order:?}"));
        let shade = order.iter().position(|pass| pass.starts_with("shade")).expect("a pass that shades");
        let expected = [shade, at("first"), at("sky"), at("second"), at("present"), at("third")];
        assert!(expected.is_sorted(), "{pipeline}: {order:?}");
    }
}

#[test]
fn the_name_of_a_loop_is_the_version_that_its_last_round_writes() {
    use umbragraph::low_level::pipeline::Version;
    let outcome = lesson("28-bloom");
    let pipeline = &outcome.plan().pipeline;
    let shine = pipeline.pass(pipeline.find_pass("shine").unwrap());
    let versions: Vec<_> = shine.accesses().iter().map(|access| access.version.clone()).collect();
    assert!(versions.contains(&Version::WrittenBy("up.3".to_owned())), "{versions:?}");
}

#[test]
fn an_extension_puts_its_passes_at_the_point() {
    assert_eq!(lesson("12-extension-point").order(), ["paint", "show"]);
    let extension = Some("pipelines/learn/parts/echo.json");
    let outcome =
        check_file("pipelines/learn/12-extension-point.json", &With { extension, ..With::default() });
    assert_eq!(outcome.order(), ["paint", "shrink", "echo", "show"]);
}

#[test]
fn a_preset_and_a_parameter_file_set_values() {
    let path = "pipelines/learn/13-presets.json";
    let (preset, file) = (Some("low"), Some("pipelines/learn/parts/wide.json"));
    assert_eq!(size(&lesson("13-presets"), "canvas"), (512, 512));
    assert_eq!(size(&check_file(path, &With { preset, ..With::default() }), "canvas"), (128, 128));
    assert_eq!(size(&check_file(path, &With { preset, file, ..With::default() }), "canvas"), (1024, 128));
}

#[test]
fn a_history_keeps_its_writers_because_of_later_frames() {
    let outcome = lesson("14-history");
    let plan = outcome.plan();
    assert_eq!(outcome.order(), ["fade", "add", "show"]);
    assert_eq!(plan.histories["trail"].places.len(), 2);
    assert_eq!(plan.textures.len(), 2);
}

#[cfg(all(feature = "gpu", feature = "gltf"))]
mod pictures;

#[test]
fn depth_stencil_and_faces_are_subresources_of_their_own() {
    let outcome = lesson("15-subresources");
    assert_eq!(outcome.order(), ["east", "mark", "show"]);
    let plan = outcome.plan();
    assert_eq!(plan.culled.len(), 1, "nothing sees the western face");
    assert!(plan.passes.iter().all(|pass| pass.depth.is_none()));
    assert_eq!(plan.textures[0].view_format, Some(TextureFormat::Rgba8UnormSrgb));
}

#[test]
fn copies_join_boxes_mips_and_aspects() {
    use umbragraph::low_level::compiler::PlannedCopy;
    let outcome = lesson("20-copies");
    let copies = |name: &str| {
        let pass = outcome.plan().passes.iter().find(|pass| pass.name == name);
        pass.map(|pass| pass.copies.clone()).unwrap_or_default()
    };
    let [PlannedCopy::Texels { from, to, extent }] = copies("window")[..] else { panic!("one box") };
    assert_eq!((from.at, to.at, extent), ([0, 16, 0], [320, 240, 0], [64, 32, 1]));
    assert_eq!(copies("keep").len(), 2, "one for each mip");
    let [PlannedCopy::Download { to, extent, .. }] = copies("download")[..] else { panic!("one picture") };
    assert_eq!((to.bytes_per_row, extent), (256, [64, 64, 1]));
}

#[test]
fn bytes_go_from_buffer_to_buffer_to_texels() {
    let outcome = lesson("16-buffers");
    assert_eq!(outcome.order(), ["empty", "half", "texels", "paint"]);
    assert!(outcome.plan().passes[3].color[0].transient_attachment);
}
