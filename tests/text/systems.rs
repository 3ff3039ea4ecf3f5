//! The systems that are data only: what their tables say holds of their plans, blocks and shaders.

use std::collections::BTreeSet;

use crate::common::host::{floats, packed, published, sunny_frame};
use crate::common::{Outcome, With, check_file, check_with, root};
use umbragraph::low_level::shader::TypeLayout;
use umbragraph::work::{Draw, DrawOrder, Work};

const MANTIS: &str = "pipelines/mantis.json";
const CARACAL: &str = "pipelines/caracal.json";

fn with<'a>(parameters: &'a [(&'a str, &'a str)]) -> With<'a> {
    With { parameters, ..With::default() }
}

fn forward_wgsl(outcome: &Outcome) -> String {
    let programs = &outcome.plan().pipeline.programs;
    let forward = programs.iter().find(|program| program.template == "forward.wgsl.jinja").unwrap();
    forward.variants[0].module.wgsl.to_string()
}

#[track_caller]
fn assert_near(found: &[f32], wanted: &[f32], tolerance: f32) {
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= tolerance), "{found:?} is not {wanted:?}");
}

#[test]
fn three_tiles_lie_side_by_side_in_one_depth_texture() {
    let outcome = check_file(MANTIS, &With::default());
    let atlas = &outcome.plan().resources["atlas"];
    let size = atlas.size.unwrap();
    assert_eq!((size.width, size.height, size.layers), (3072, 1024, 1));
    assert_eq!(atlas.format, Some(wgpu_format("depth24plus")));
    let data = published(outcome.plan(), "fit", &sunny_frame());
    let viewports: Vec<_> = data.views().iter().map(|view| (view.layer, view.viewport.unwrap())).collect();
    assert_eq!(viewports, [(0, [0, 0, 1024, 1024]), (0, [1024, 0, 1024, 1024]), (0, [2048, 0, 1024, 1024])]);
}

fn wgpu_format(name: &str) -> umbragraph::wgpu_types::TextureFormat {
    serde_json::from_value(name.into()).unwrap()
}

#[test]
fn three_tiles_fill_three_quarters_of_a_square() {
    let outcome = check_file(CARACAL, &With::default());
    let size = outcome.plan().resources["atlas"].size.unwrap();
    assert_eq!((size.width, size.height, size.layers), (2048, 2048, 1));
    let data = published(outcome.plan(), "fit", &sunny_frame());
    let viewports: Vec<_> = data.views().iter().map(|view| view.viewport.unwrap()).collect();
    assert_eq!(viewports, [[0, 0, 1024, 1024], [1024, 0, 1024, 1024], [0, 1024, 1024, 1024]]);
}

#[test]
fn splits_are_the_listed_ones_and_a_preset_computes_them() {
    for (pipeline, listed, computed) in [
        (MANTIS, [8.0, 40.0, 200.0], [20.9, 51.1, 200.0]),
        (CARACAL, [15.0, 60.0, 200.0], [34.0, 74.6, 200.0]),
    ] {
        for (preset, wanted) in
            [(None, listed), (Some("explicit_splits"), listed), (Some("practical_splits"), computed)]
        {
            let outcome = check_file(pipeline, &With { preset, ..With::default() });
            assert_near(&floats(&published(outcome.plan(), "fit", &sunny_frame()), "far"), &wanted, 0.06);
        }
    }
}

#[test]
fn no_tap_leaves_its_tile() {
    for pipeline in [MANTIS, CARACAL] {
        for filter in ["\"hard\"", "\"poisson9\"", "\"poisson16\""] {
            let wgsl = forward_wgsl(&check_file(pipeline, &with(&[("shadow_filter", filter)])));
            let of_materials = wgsl.matches("textureSampleBias(base").count();
            assert_eq!(wgsl.matches("textureSample").count() - of_materials, 1);
            let clamped =
                "clamp(lookup.uv + (offset + shift) * lookup.texel_uv, lookup.bounds.xy, lookup.bounds.zw)";
            assert!(wgsl.contains(&format!("let uv = {clamped};")));
            assert!(wgsl.contains("textureSampleCompareLevel(shadow_maps, shadow_sampler, uv, reference)"));
        }
        let outcome = check_file(pipeline, &With::default());
        let data = published(outcome.plan(), "fit", &sunny_frame());
        let map = floats(&data, "map_size");
        for (bounds, view) in floats(&data, "uv_bounds").chunks(4).zip(data.views()) {
            let [x, y, width, height] = view.viewport.unwrap().map(|texel| texel as f32);
            let wanted = [x + 0.5, y + 0.5, x + width - 0.5, y + height - 0.5];
            let texels = [bounds[0] * map[0], bounds[1] * map[1], bounds[2] * map[0], bounds[3] * map[1]];
            assert_near(&texels, &wanted, 0.001);
        }
    }
}

#[test]
fn the_end_of_each_range_blends_by_a_tenth_of_it_or_not_at_all() {
    let outcome = check_file(MANTIS, &With::default());
    let data = published(outcome.plan(), "fit", &sunny_frame());
    assert_near(&floats(&data, "blend_start")[1..], &[40.0 - 3.2, 200.0 - 16.0], 0.001);
    let unblended = forward_wgsl(&check_file(CARACAL, &With::default()));
    assert!(!unblended.contains("let fade ="));
}

#[test]
fn the_bias_is_a_constant_or_grows_with_the_slope() {
    let slope = forward_wgsl(&check_file(MANTIS, &With::default()));
    assert!(slope.contains("max(shadow_settings.slope_bias * slope, shadow_settings.min_bias)"));
    let constant =
        forward_wgsl(&check_file(MANTIS, &With { preset: Some("constant_bias"), ..With::default() }));
    assert!(constant.contains("return shadow_settings.depth_bias;") && !constant.contains("slope_bias"));
}

#[test]
fn casters_are_drawn_front_to_back_without_fragment_stage() {
    let outcome = check_file(MANTIS, &With::default());
    let pipeline = &outcome.plan().pipeline;
    let casters = pipeline.pass(pipeline.find_pass("casters").unwrap());
    let Work::Render(render) = casters.work() else { panic!("a render pass") };
    let Draw::Scene(scene) = &render.draw else { panic!("a scene") };
    assert_eq!((scene.filter.as_str(), scene.order), ("casters", DrawOrder::FrontToBack));
    assert!(!pipeline.program(scene.program).variants[0].module.wgsl.contains("@fragment"));
}

#[test]
fn the_lighting_block_has_320_bytes_and_every_member_its_offset() {
    let outcome = check_file(CARACAL, &With::default());
    let programs = &outcome.plan().pipeline.programs;
    let forward = programs.iter().find(|program| program.template == "forward.wgsl.jinja").unwrap();
    let block = forward.binding("lighting").unwrap().block.as_ref().unwrap();
    let TypeLayout::Struct { members, .. } = block else { panic!("a struct") };
    let offsets: Vec<_> = members.iter().map(|member| (member.name.as_str(), member.offset)).collect();
    assert_eq!(
        offsets,
        [
            ("direction_to_light", 0),
            ("light_color", 16),
            ("light_intensity", 28),
            ("ambient", 32),
            ("ambient_intensity", 44),
            ("clip_from_world", 48),
            ("far", 240),
            ("last_far", 252),
            ("texture_scale_offset", 256),
            ("depth_bias", 304),
            ("normal_offset", 308),
            ("map_side", 312),
            ("enabled", 316),
        ]
    );
    assert_eq!(block.size(), 320);
}

#[test]
fn the_lighting_block_is_filled_from_fit_and_parameters() {
    let outcome =
        check_file(CARACAL, &with(&[("ambient_color", "[1, 0.5, 0.25]"), ("ambient_intensity", "2")]));
    let frame = sunny_frame();
    let data = published(outcome.plan(), "fit", &frame);
    let bytes = packed(outcome.plan(), "shade", "lighting", &data);
    let at = |offset: usize, count: usize| -> Vec<f32> {
        bytes[offset..offset + 4 * count]
            .chunks(4)
            .map(|word| f32::from_le_bytes(word.try_into().unwrap()))
            .collect()
    };
    let to_light = -frame.lights[0].direction.as_vec3();
    assert_near(&at(0, 3), &to_light.to_array(), 1e-6);
    assert_near(&at(16, 4), &[4.0, 3.0, 2.0, 4.0], 1e-6);
    assert_near(&at(32, 4), &[2.0, 1.0, 0.5, 2.0], 1e-6);
    for (index, view) in data.views().iter().enumerate() {
        assert_near(&at(48 + 64 * index, 16), &view.clip_from_world.as_mat4().to_cols_array(), 1e-6);
    }
    assert_near(&at(240, 4), &[15.0, 60.0, 200.0, 200.0], 1e-5);
    assert_near(&at(256, 12), &[0.5, 0.5, 0.0, 0.0, 0.5, 0.5, 0.5, 0.0, 0.5, 0.5, 0.0, 0.5], 1e-6);
    assert_near(&at(304, 4), &[0.001, 0.02, 2048.0, 1.0], 1e-6);
    let off = check_file(CARACAL, &with(&[("shadows", "false")]));
    assert_eq!(packed(off.plan(), "shade", "lighting", &data)[316..], [0; 4]);
}

#[test]
fn a_value_overrides_data_and_a_missing_member_is_an_error() {
    let text = std::fs::read_to_string(root().join(CARACAL)).unwrap();
    let doubled = text.replace("\"map_side\": \"=2 * resolution\",", "\"map_side\": 5, \"last_far\": 7,");
    let outcome = check_with(CARACAL, &doubled, &With::default());
    let data = published(outcome.plan(), "fit", &sunny_frame());
    assert_eq!(packed(outcome.plan(), "shade", "lighting", &data)[252..256], 7.0_f32.to_le_bytes());
    let missing =
        check_with(CARACAL, &text.replace("\"map_side\": \"=2 * resolution\",", ""), &With::default());
    assert!(missing.diagnostics.has_errors() && missing.text().contains("map_side"), "{}", missing.text());
    let misspelt = check_with(CARACAL, &text.replace("\"map_side\"", "\"map_sides\""), &With::default());
    assert!(misspelt.text().contains("did you mean \"map_side\"?"), "{}", misspelt.text());
}

#[test]
fn a_block_has_its_declared_offsets_or_a_diagnostic() {
    let check = |members: &str, offsets: &str| {
        let template = format!(
            "{{% include \"lib/fullscreen.wgsl.jinja\" %}}
             struct Constants {{ {members} }}
             @group(1) @binding(0) var<uniform> constants: Constants;
             @fragment fn fill() -> @location(0) vec4<f32> {{
                 return constants.tint * constants.bias * f32(constants.cascade);
             }}"
        );
        let text = format!(
            r#"{{
                "format": 1, "name": "offsets",
                "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
                "passes": {{ "fill": {{ "fullscreen": {{
                    "shader": "constants.wgsl.jinja", "color": [{{ "to": "&target" }}],
                    "bind": {{ "constants": {{ "block": {{
                        "values": {{ "bias": 0.5, "tint": [1, 0.5, 0.25, 1], "cascade": 2 }}, "offsets": {offsets}
                    }} }} }}
                }} }} }}
            }}"#
        );
        let templates = [("constants.wgsl.jinja", template.as_str())];
        check_with("offsets.json", &text, &With { templates: &templates, ..With::default() })
    };
    // As far apart as constants that were pushed: 132 bytes.
    let spread = "@size(64) bias: f32, @size(64) tint: vec4<f32>, cascade: u32";
    let outcome = check(spread, r#"{ "bias": 0, "tint": 64, "cascade": 128 }"#);
    let block = &outcome.plan().passes[0].blocks[0];
    let at = |offset: usize| <[u8; 4]>::try_from(&block.bytes[offset..offset + 4]).unwrap();
    assert_eq!([at(0), at(68), at(128)], [0.5_f32.to_le_bytes(), 0.5_f32.to_le_bytes(), 2_u32.to_le_bytes()]);
    let close = "bias: f32, tint: vec4<f32>, cascade: u32";
    // What the diagnostic writes is laid out as it should be, whatever is to lie where.
    for offsets in [
        r#"{ "bias": 0, "tint": 64, "cascade": 128 }"#,
        r#"{ "cascade": 4, "tint": 16, "bias": 32 }"#,
        r#"{ "bias": 0, "tint": 32 }"#,
    ] {
        let said = check(close, offsets).text();
        let (_, said) = said.split_once("struct Constants { ").unwrap_or_else(|| panic!("{said}"));
        let (members, _) = said.split_once(" }").unwrap();
        let text = check(members, offsets).text();
        assert!(!text.contains(" lies at byte "), "{members}: {text}");
    }
    for (members, offsets, said) in [
        (
            close,
            r#"{ "bias": 0, "tint": 64 }"#,
            [
                "\"tint\" lies at byte 16 in constants.wgsl.jinja, not at byte 64",
                "struct Constants { @size(64) bias: f32, tint: vec4<f32>, cascade: u32 }",
            ],
        ),
        (
            spread,
            r#"{ "tint": 8 }"#,
            ["\"tint\" cannot lie at byte 8: of vec4<f32> it is a multiple of 16", "write 0 or 16"],
        ),
        (
            spread,
            r#"{ "tint": 64, "cascade": 76 }"#,
            ["\"cascade\" is to begin at byte 76, and \"tint\" ends at byte 80", "write 80 or more"],
        ),
        (spread, r#"{ "tints": 64 }"#, ["the block has no member \"tints\"", "did you mean \"tint\"?"]),
    ] {
        let outcome = check(members, offsets);
        assert_eq!(outcome.codes(), ["UG0605"], "{}", outcome.text());
        assert!(said.iter().all(|part| outcome.text().contains(part)), "{}", outcome.text());
    }
}

#[test]
fn settings_override_files_presets_and_defaults() {
    let far =
        |with: &With<'_>| check_file(MANTIS, with).plan().pipeline.parameters["splits"].value.to_string();
    let file = Some("tests/settings/uniform.json");
    let preset = Some("practical_splits");
    assert_eq!(far(&With::default()), "explicit");
    assert_eq!(far(&With { preset, ..With::default() }), "practical");
    assert_eq!(far(&With { preset, file, ..With::default() }), "uniform");
    let parameters: &[(&str, &str)] = &[("splits", "\"logarithmic\"")];
    assert_eq!(far(&With { preset, file, parameters, ..With::default() }), "logarithmic");
}

#[test]
fn unknown_presets_and_wrong_values_in_any_are_errors() {
    let outcome = check_file(MANTIS, &With { preset: Some("practical_split"), ..With::default() });
    assert_eq!(outcome.codes(), ["UG0213"]);
    assert!(outcome.text().contains("did you mean \"practical_splits\"?"));
    let text = std::fs::read_to_string(root().join(MANTIS)).unwrap();
    let wrong = text.replace("\"lambda\": 0.7 }", "\"lambda\": 7, \"gamma\": 1 }");
    for preset in [None, Some("practical_splits")] {
        let outcome = check_with(MANTIS, &wrong, &With { preset, ..With::default() });
        assert_eq!(outcome.codes(), ["UG0202", "UG0204"], "{}", outcome.text());
    }
}

#[test]
fn mixed_view_sizes_in_an_array_are_an_error_with_help() {
    let text = std::fs::read_to_string(root().join("pipelines/lore.json")).unwrap();
    let smaller = text.replace(
        "[\"=max(resolutions)\", \"=max(resolutions)\"]",
        "[\"=min(resolutions)\", \"=min(resolutions)\"]",
    );
    assert_ne!(smaller, text);
    for cached in ["false", "true"] {
        let features: &[_] = &[("map_array", "true"), ("cached", cached)];
        let outcome = check_with("pipelines/lore.json", &smaller, &With { features, ..With::default() });
        let said = outcome.text();
        assert!(
            outcome.codes().iter().all(|code| *code == "UG0405") && outcome.diagnostics.has_errors(),
            "{said}"
        );
        assert!(said.contains("is 1024 by 1024, but the views of"), "{said}");
        assert!(
            said.contains("are made for 2048 by 2048") && said.contains("a texture of its own"),
            "{said}"
        );
    }
}

#[test]
fn no_code_and_no_template_names_a_system() {
    let names: Vec<String> = std::fs::read_dir(root().join("pipelines"))
        .unwrap()
        .flatten()
        .filter_map(|entry| entry.file_name().to_string_lossy().strip_suffix(".json").map(str::to_owned))
        .collect();
    assert!(names.len() >= 3, "{names:?}");
    for folder in ["graph", "passes/src", "scene/src", "shaders-templates"] {
        let mut files = Vec::new();
        crate::common::files(&root().join(folder), &mut files);
        assert!(files.len() > 5, "{folder}");
        for file in files {
            let text = std::fs::read_to_string(&file).unwrap().to_lowercase();
            let words: BTreeSet<&str> = text.split(|letter: char| !letter.is_ascii_alphabetic()).collect();
            for name in &names {
                assert!(!words.contains(name.as_str()), "{} names {name}", file.display());
            }
        }
    }
}
