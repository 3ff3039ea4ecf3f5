//! Shadows filtered by moments in `pipelines/awsm.json`: agreement with ray-traced masks, memory, tiles, and which
//! exponents a format has.

use crate::common::gpu::{Host, scene};
use crate::common::{Outcome, With, check_file, check_with, root, with_small_maps};
use glam::{DVec3, Vec3};
use umbragraph::frame::{Light, LightKind};
use umbragraph_test_support::gpu;
use umbragraph_test_support::property;
use umbragraph_test_support::truth::{self, BandScore, TruthScene};

const AWSM: &str = "pipelines/awsm.json";

/// Every kind of moments: the filter and the precision, with the bytes of a texel.
const KINDS: [(&str, &str, u64); 5] = [
    ("\"evsm2\"", "\"fp32\"", 8),
    ("\"evsm4\"", "\"fp32\"", 16),
    ("\"evsm2\"", "\"fp16\"", 4),
    ("\"evsm4\"", "\"fp16\"", 8),
    ("\"msm\"", "\"fp16\"", 8),
];

fn awsm(parameters: &[(&str, &str)], features: &[(&str, &str)], size: [u32; 2]) -> Outcome {
    let all = with_small_maps(parameters);
    check_file(AWSM, &With { parameters: &all, features, size: Some(size), ..With::default() })
}

#[test]
fn shadows_of_moments_agree_with_ray_traced_ones() {
    let Some(gpu) = gpu::device() else { return };
    for name in ["contact_sun", "terrain_dem_sun"] {
        let Some(truth) = TruthScene::find(name) else { return };
        let (width, height) = truth.size();
        let scene = scene(&truth.glb_path());
        for (filter, precision, bytes) in KINDS {
            let file = format!("pipelines/params/awsm_{name}.json");
            let with = With {
                file: Some(&file),
                parameters: &[("debug_view", "\"shadow_term\""), ("moment_cascades", "\"all\"")],
                features: &[("moment_filter", filter), ("moment_precision", precision)],
                size: Some([width, height]),
                ..With::default()
            };
            let outcome = check_file(AWSM, &with);
            let input = scene.frame_input(f64::from(width) / f64::from(height), 0.0);
            let picture = Host::new(&gpu, &outcome, &scene).picture(&input);
            let scores = truth::evaluate(&truth, &picture).expect("a picture of the scene's size");
            let iou =
                |band: u8| scores.band(band).and_then(BandScore::intersection_over_union).unwrap_or(0.0);
            let leak = scores.band(4).and_then(BandScore::leak).unwrap_or(1.0);
            let contact = scores.contact_leak().map_or("-".to_owned(), |leak| format!("{leak:.4}"));
            let filter = filter.trim_matches('"');
            let precision = if filter == "msm" { "unorm16" } else { precision.trim_matches('"') };
            println!(
                "| {name} | {filter} {precision} | {bytes} | {:.4} | {:.4} | {leak:.4} | {contact} |",
                iou(0),
                iou(2)
            );
            let (min_iou, max_leak) = if bytes == 16 { (0.999, 0.001) } else { (0.985, 0.03) };
            assert!(iou(2) >= min_iou, "{filter} {precision} on {name}: {}", iou(2));
            assert!(leak <= max_leak, "{filter} {precision} on {name} leaks {leak}");
        }
    }
}

#[test]
fn moments_take_memory_where_they_are_asked_for_alone() {
    let none = awsm(&[], &[], [160, 120]);
    let is_of_moments =
        |name: &str| name.contains("moments") || name.ends_with("_tiles") || name.starts_with("blur_");
    assert!(!none.plan().resources.keys().any(|name| is_of_moments(name)));
    assert!(!none.plan().passes.iter().any(|pass| is_of_moments(&pass.name)));
    let bytes = |outcome: &Outcome| outcome.plan().bytes;
    let with = |kind: (&str, &str), parameter| {
        awsm(&[parameter], &[("moment_filter", kind.0), ("moment_precision", kind.1)], [160, 120])
    };
    for (filter, precision, texel) in KINDS {
        let kind = (filter, precision);
        let all = with(kind, ("moment_cascades", "\"all\""));
        // Two textures that are written in turn: the third one has the memory of the first.
        let tiles = 16 * 16 * 16;
        assert_eq!(bytes(&all), bytes(&none) + 4 * (2 * 256 * 256 * texel + tiles), "{kind:?}");
        let spots = with(kind, ("moment_spots", "true"));
        assert_eq!(bytes(&spots), bytes(&none) + 2 * 256 * 256 * texel + tiles, "{kind:?}");
    }
    let (filter, precision, texel) = KINDS[1];
    assert_eq!(bytes(&none), bytes(&with((filter, precision), ("moment_cascades", "\"none\""))));
    // Four more levels, each a quarter of the one above; without moments none.
    let levels = |parameters: &[(&'static str, &'static str)]| {
        awsm(parameters, &[("moment_filter", filter), ("moment_precision", precision)], [160, 120])
    };
    let mips = levels(&[("moment_levels", "5"), ("moment_cascades", "\"last\"")]);
    let count = mips.plan().passes.iter().filter(|pass| pass.name.starts_with("reduce_")).count();
    assert_eq!((count, mips.plan().resources["soft_cascade_moments"].size.expect("a texture").mips), (4, 5));
    assert_eq!(bytes(&levels(&[("moment_levels", "5")])), bytes(&none));
    for (which, layers) in [("\"last\"", 1), ("\"last_two\"", 2)] {
        let some = with((filter, precision), ("moment_cascades", which));
        assert_eq!(bytes(&some), bytes(&none) + layers * (2 * 256 * 256 * texel + 16 * 16 * 16), "{which}");
    }
    for (shadows, moments) in
        [("directional_shadows", ("moment_cascades", "\"all\"")), ("spot_shadows", ("moment_spots", "true"))]
    {
        let without = awsm(&[moments], &[(shadows, "false")], [160, 120]);
        assert!(!without.plan().resources.keys().any(|name| is_of_moments(name)), "{shadows}");
    }
}

#[test]
fn moments_take_the_first_writable_format_or_are_an_error() {
    let formats = ["rg32float", "rgba32float", "r32uint", "rgba16float", "rg32uint"];
    for ((filter, precision, bytes), format) in KINDS.into_iter().zip(formats) {
        let features = [("moment_filter", filter), ("moment_precision", precision)];
        let outcome = awsm(&[("moment_cascades", "\"all\"")], &features, [160, 120]);
        for name in ["cascade_moments", "soft_cascade_moments", "blur_cascades.rows"] {
            let found = outcome.plan().resources[name].format.expect("a texture");
            assert_eq!(format!("{found:?}").to_lowercase(), format, "{filter} {precision}");
            assert_eq!(found.block_copy_size(None).map(u64::from), Some(bytes));
        }
    }
    // No device has to be able to write the formats of one or two channels of 16 bits.
    let with = |formats: &str| {
        let moments = format!(r#""cascade_moments": {{ "texture": {{ "format": {formats} }} }}"#);
        let text = format!(
            r#"{{ "format": 1, "name": "other", "extends": "{AWSM}", "resources": {{ {moments} }} }}"#
        );
        let parameters = [("moment_cascades", "\"last\"")];
        check_with("other.json", &text, &With { parameters: &parameters, ..With::default() })
    };
    let next = with(r#"["rg16float", "rgba16float"]"#);
    assert_eq!(next.plan().resources["cascade_moments"].format, Some(wgpu::TextureFormat::Rgba16Float));
    let none = with(r#"["rg16float", "r16float"]"#);
    assert_eq!(none.codes(), ["UG0323"], "{}", none.text());
    assert!(
        none.text().contains("\"cascade_moments\"") && none.text().contains("rg16float"),
        "{}",
        none.text()
    );
}

fn spot(name: &str, position: [f64; 3]) -> Light {
    Light::new(name.to_owned(), LightKind::Spot { inner_angle: 0.5, outer_angle: 0.7 })
        .position(DVec3::from(position))
        .intensity(60.0)
        .range(14.0)
        .property("cast_shadow")
}

#[test]
fn the_widest_blur_brings_nothing_from_the_next_tile() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/interior.glb"));
    for (filter, precision, bytes) in KINDS {
        for radius in if bytes == 16 { &["0", "6", "64"][..] } else { &["64"] } {
            let parameters = [("moment_spots", "true"), ("blur_radius", *radius)];
            let features = [("moment_filter", filter), ("moment_precision", precision)];
            let outcome = awsm(&parameters, &features, [160, 120]);
            // The neighbour shines on nothing, since it has no color; its tile is full of blockers, or empty.
            let picture = |direction: DVec3| {
                let dark = |name| spot(name, [-0.3, 1.6, -0.6]).color(Vec3::ZERO).direction(direction);
                let lights = vec![spot("a", [0.6, 2.6, 0.6]), dark("dark"), dark("z")];
                let input = scene.frame_input(160.0 / 120.0, 0.0).lights(lights);
                Host::new(&gpu, &outcome, &scene).picture(&input)
            };
            let (full, empty) = (picture(DVec3::NEG_Y), picture(DVec3::Y));
            assert_eq!(full.differing(&empty, 0), 0, "{filter} {precision}, radius {radius}");
        }
    }
}

#[test]
fn forward_and_reverse_depth_give_the_same_shadows_of_moments() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/interior.glb"));
    for (filter, precision, _) in property::part(KINDS, 3) {
        let picture = |reverse| {
            let parameters = [
                ("moment_cascades", "\"all\""),
                ("moment_spots", "true"),
                ("cascade_side", "1024"),
                ("tile_max_side", "512"),
            ];
            let features =
                [("moment_filter", filter), ("moment_precision", precision), ("reverse_z", reverse)];
            let outcome = awsm(&parameters, &features, [640, 360]);
            Host::new(&gpu, &outcome, &scene).picture(&scene.frame_input(640.0 / 360.0, 0.0))
        };
        let differing = picture("true").differing(&picture("false"), 2);
        println!("{filter} {precision}: {differing} of {} pixels differ", 640 * 360);
        // Of 16 bits the last one may fall the other way, where depths differ in the last of theirs.
        let bound = if precision == "\"fp32\"" { 640 * 360 / 10_000 } else { 640 * 360 / 2000 };
        assert!(differing <= bound, "{filter} {precision}: {differing} pixels differ");
    }
}

/// Compares shadows in a small picture with a picture four times as large that is then scaled down.
#[test]
fn mips_of_moments_bring_a_small_picture_closer_to_a_large_one() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/figure.glb"));
    let [width, height] = [80_usize, 45];
    let picture = |levels, scale: u32| {
        let parameters = [
            ("moment_cascades", "\"all\""),
            ("moment_spots", "true"),
            ("moment_levels", levels),
            ("blur_radius", "1"),
            ("cascade_side", "2048"),
            ("debug_view", "\"shadow_term\""),
        ];
        let outcome = awsm(&parameters, &[("moment_filter", "\"msm\"")], [80 * scale, 45 * scale]);
        Host::new(&gpu, &outcome, &scene).picture(&scene.frame_input(80.0 / 45.0, 0.0))
    };
    let large: Vec<f64> = picture("1", 4).rgba_pixels().map(|pixel| f64::from(pixel[0])).collect();
    let error = |levels| {
        let small = picture(levels, 1);
        let errors = small.rgba_pixels().enumerate().map(|(at, pixel)| {
            let (x, y) = (at % width * 4, at / width * 4);
            let mean = (0..16).map(|at| large[(y + at / 4) * width * 4 + x + at % 4]).sum::<f64>() / 16.0;
            (f64::from(pixel[0]) - mean).abs()
        });
        errors.sum::<f64>() / (width * height) as f64
    };
    let (with, without) = (error("5"), error("1"));
    println!("{with:.2} levels of 255 with mips, {without:.2} without");
    assert!(with < 0.8 * without, "{with} and {without}");
}

#[test]
fn an_exponent_has_to_fit_the_moment_format() {
    let codes = |exponent: &str, filter: &str, precision: &str, cascades: &str| {
        let parameters = [("exponent", exponent), ("moment_cascades", cascades)];
        let features = [("moment_filter", filter), ("moment_precision", precision)];
        let outcome = awsm(&parameters, &features, [160, 120]);
        let severity = outcome.diagnostics.error_count();
        (outcome.codes(), severity)
    };
    let (error, warning, fine) = ((vec!["UG0223"], 1), (vec!["UG0223"], 0), (vec![], 0));
    for filter in ["\"evsm2\"", "\"evsm4\""] {
        for (exponent, wanted) in [
            ("0", &fine),
            ("4.85", &fine),
            ("4.86", &warning),
            ("5.54", &warning),
            ("5.55", &error),
            ("10", &error),
        ] {
            assert_eq!(&codes(exponent, filter, "\"fp16\"", "\"last\""), wanted, "{exponent}");
        }
        for (exponent, wanted) in [("0", &fine), ("42", &fine), ("42.1", &error)] {
            assert_eq!(&codes(exponent, filter, "\"fp32\"", "\"last\""), wanted, "{exponent}");
        }
    }
    assert_eq!(codes("10", "\"evsm4\"", "\"fp16\"", "\"none\""), fine);
    assert_eq!(codes("60", "\"msm\"", "\"fp16\"", "\"all\""), fine);
}

#[test]
fn moment_cascades_are_tinted_warm_and_others_cool() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/courtyard.glb"));
    // All that is seen lies in the first cascade, or in the last.
    for (far, which, is_warm) in [
        ("[900, 1000]", "\"none\"", false),
        ("[900, 1000]", "\"last\"", false),
        ("[900, 1000]", "\"all\"", true),
        ("[0.2, 1000]", "\"last\"", true),
        ("[0.2, 1000]", "\"none\"", false),
    ] {
        let parameters = [
            ("debug_view", "\"cascades\""),
            ("splits", "\"explicit\""),
            ("blend", "0"),
            ("far", far),
            ("moment_cascades", which),
        ];
        let outcome = awsm(&parameters, &[], [160, 90]);
        let picture = Host::new(&gpu, &outcome, &scene).picture(&scene.frame_input(160.0 / 90.0, 0.0));
        // The lower half is ground.
        let ground = picture.rgba_pixels().skip(160 * 45);
        let (red, blue) = ground.fold((0_u32, 0_u32), |(red, blue), pixel| {
            (red + u32::from(pixel[0]), blue + u32::from(pixel[2]))
        });
        println!("{far} {which}: red over blue {:.2}", f64::from(red) / f64::from(blue));
        assert_eq!(f64::from(red) > 1.3 * f64::from(blue), is_warm, "{far} {which}: {red} and {blue}");
    }
}
