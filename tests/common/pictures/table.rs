//! The cases of reference pictures: pipelines, scenes and settings.
//!
//! Maps are small and cascades end within the scene, so that seams, borders and filters are some pixels wide in
//! pictures that are cheap to render and to keep.

use glam::dcamera::rh::proj::directx;
use glam::{DMat4, DVec2, DVec3, Vec3};
use umbragraph::frame::{LightKind, Projection};
use umbragraph::passes::words::{CONTACT_SHADOW, HARDNESS};
use umbragraph::scene::Scene;
use umbragraph::scene::node::LocalTransform;

use crate::common::SMALL_MAPS;

pub type Settings = &'static [(&'static str, &'static str)];

/// A pipeline, the number of its cascades, and parameters on all scenes.
pub const PIPELINES: &[(&str, usize, Settings)] = &[
    ("nebula", 4, &[("resolution", "256"), ("blend", "0.4")]),
    ("mantis", 3, &[("resolution", "256"), ("blend", "0.4")]),
    ("caracal", 3, &[("resolution", "256")]),
    (
        "lore",
        4,
        &[
            ("resolutions", "[256,256,128,128]"),
            ("blend", "0.4"),
            ("depth_bias", "0.001"),
            ("normal_bias", "0.25"),
            ("filter_radius", "1"),
        ],
    ),
    ("awsm", 4, SMALL_MAPS),
    ("umbra", 4, SMALL_MAPS),
];

/// A scene, and the distances at which cascades end on it.
pub const SCENES: &[(&str, [&str; 4])] = &[
    ("courtyard", ["7", "14", "30", "60"]),
    ("figure", ["4.5", "6", "8", "12"]),
    ("foliage", ["5", "9", "15", "30"]),
    ("interior", ["2.5", "4", "6", "9"]),
];

/// A pipeline on a scene in other settings than its usual ones.
pub struct Variant {
    pub name: &'static str,
    pub pipeline: &'static str,
    pub scene: &'static str,
    pub parameters: Settings,
    pub features: Settings,
    pub change: Option<Change>,
}

impl Variant {
    /// The same of a scene that is changed first.
    const fn of(self, change: Change) -> Self {
        Self { change: Some(change), ..self }
    }
}

/// A change to a scene before it is drawn.
pub type Change = fn(&mut Scene);

fn every_other_material_unshadowed(scene: &mut Scene) {
    scene.materials.iter_mut().step_by(2).for_each(|material| material.receive_shadow = false);
}

fn every_other_light_green(scene: &mut Scene) {
    scene.lights.iter_mut().step_by(2).for_each(|light| light.light.color = Vec3::Y);
}

fn every_other_light_without_contact(scene: &mut Scene) {
    let others = scene.lights.iter_mut().step_by(2);
    others.for_each(|light| light.light.properties.retain(|word| word != CONTACT_SHADOW));
}

/// Hard, soft and as wide as the penumbra in turn.
fn edges_in_turn(scene: &mut Scene) {
    let words = HARDNESS.into_iter().cycle();
    scene.lights.iter_mut().zip(words).for_each(|(light, word)| light.light.properties.push(word.into()));
}

fn hard_shadows(scene: &mut Scene) {
    scene.lights.iter_mut().for_each(|light| light.light.properties.push(HARDNESS[0].into()));
}

/// Another sun behind the camera.
fn two_suns(scene: &mut Scene) {
    let is_sun = |kind| matches!(kind, LightKind::Directional);
    let Some(mut sun) = scene.lights.iter().find(|light| is_sun(light.light.kind)).cloned() else { return };
    sun.node = scene.cameras[0].node;
    scene.lights.push(sun);
}

fn without_sun(scene: &mut Scene) {
    scene.lights.retain(|light| !matches!(light.light.kind, LightKind::Directional));
}

fn unlimited(scene: &mut Scene) {
    scene.lights.iter_mut().for_each(|light| light.light.range = f32::INFINITY);
}

pub fn glowing(scene: &mut Scene) {
    scene.materials.iter_mut().for_each(|material| material.emissive = [0.05, 0.1, 0.2]);
}

pub fn orthographic(scene: &mut Scene) {
    scene.cameras[0].projection = Projection::Orthographic { half_height: 3.0, near: 0.1, far: 60.0 };
}

/// So far from the origin that positions have steps of millimetres.
fn far_away(scene: &mut Scene) {
    let by = DVec3::new(30_000.0, 0.0, 20_000.0);
    for node in scene.nodes.iter_mut().filter(|node| node.parent.is_none()) {
        match &mut node.local {
            LocalTransform::Matrix(matrix) => *matrix = DMat4::from_translation(by) * *matrix,
            LocalTransform::Parts { translation, .. } => *translation += by,
        }
    }
}

/// A part to the right of a picture of twice the width and height, with the horizon above its middle.
fn off_center(scene: &mut Scene) {
    let clip_from_view = directx::frustum(0.0, 0.09, -0.03, 0.02, 0.1, 60.0);
    scene.cameras[0].projection = Projection::Matrix { clip_from_view, jitter: DVec2::ZERO };
}

const fn variant(
    [pipeline, scene, name]: [&'static str; 3],
    parameters: Settings,
    features: Settings,
) -> Variant {
    Variant { name, pipeline, scene, parameters, features, change: None }
}

pub const VARIANTS: &[Variant] = &[
    variant(["nebula", "courtyard", "forward_z"], &[("tone_map", "\"reinhard\"")], &[("reverse_z", "false")]),
    variant(["nebula", "courtyard", "one_cascade"], &[("far", "[40]"), ("tone_map", "\"none\"")], &[]),
    variant(["nebula", "figure", "glowing"], &[], &[]).of(glowing),
    variant(["nebula", "courtyard", "unshadowed"], &[], &[]).of(every_other_material_unshadowed),
    variant(["mantis", "courtyard", "one_tap"], &[("shadow_filter", "\"hard\"")], &[]),
    variant(
        ["mantis", "courtyard", "wide_filter"],
        &[("shadow_filter", "\"poisson16\""), ("filter_radius", "8"), ("border", "0"), ("resolution", "64")],
        &[("reverse_z", "true")],
    ),
    variant(
        ["mantis", "courtyard", "constant_bias"],
        &[("bias_form", "\"constant\""), ("cascades", "2")],
        &[],
    ),
    variant(["caracal", "courtyard", "one_tap"], &[("shadow_filter", "\"hard\"")], &[]),
    variant(
        ["caracal", "courtyard", "wide_filter"],
        &[
            ("shadow_filter", "\"poisson9\""),
            ("filter_radius", "8"),
            ("border", "0"),
            ("resolution", "64"),
            ("rotate_taps", "false"),
        ],
        &[("reverse_z", "true")],
    ),
    variant(["caracal", "courtyard", "without_shadows"], &[("shadows", "false")], &[]),
    variant(["lore", "courtyard", "array"], &[("shadow_filter", "\"grid3\"")], &[("map_array", "true")]),
    variant(
        ["lore", "courtyard", "one_tap"],
        &[("shadow_filter", "\"hard\""), ("caster_cull", "\"none\"")],
        &[("reverse_z", "false")],
    ),
    variant(
        ["lore", "courtyard", "wide_filter"],
        &[("shadow_filter", "\"grid7\""), ("filter_radius", "2"), ("border", "0")],
        &[],
    ),
    variant(
        ["lore", "figure", "poisson64"],
        &[("shadow_filter", "\"poisson64\""), ("filter_radius", "4")],
        &[],
    ),
    variant(["lore", "courtyard", "faded"], &[("max_distance", "20"), ("fade_range", "15")], &[]),
    variant(
        ["umbra", "courtyard", "whole_range_penumbra"],
        &[("debug_view", "\"penumbra\"")],
        &[("whole_range", "true")],
    ),
    variant(["umbra", "courtyard", "whole_range"], &[], &[("whole_range", "true")]),
    variant(["umbra", "interior", "hard"], &[], &[("light_filter", "\"hard\"")]),
    variant(["umbra", "interior", "deferred"], &[], &[("deferred", "true")]),
    variant(["umbra", "figure", "spheres"], &[("fit", "\"sphere\"")], &[("msaa", "true")]),
    variant(
        ["umbra", "courtyard", "spheres_texels"],
        &[("fit", "\"sphere\""), ("lambda", "0.6"), ("debug_view", "\"texels\"")],
        &[("reverse_z", "false")],
    ),
    variant(["umbra", "interior", "unlimited_lights"], &[], &[("light_filter", "\"hard\"")]).of(unlimited),
    variant(["umbra", "interior", "hard_lights"], &[("hard_below", "1000000")], &[]),
    variant(["umbra", "courtyard", "deferred"], &[], &[("deferred", "true")]).of(glowing),
    variant(["umbra", "courtyard", "orthographic"], &[("fit", "\"sphere\"")], &[("deferred", "true")])
        .of(orthographic),
    variant(
        ["umbra", "courtyard", "off_center"],
        &[("fit", "\"sphere\""), ("debug_view", "\"texels\"")],
        &[],
    )
    .of(off_center),
    variant(
        ["awsm", "courtyard", "off_center"],
        &[("contact_strength", "1")],
        &[("contact_shadows", "true"), ("visibility_first", "true")],
    )
    .of(off_center),
    variant(["awsm", "courtyard", "unshadowed"], &[], &[]).of(every_other_material_unshadowed),
    variant(["awsm", "figure", "hard"], &[], &[("light_filter", "\"hard\"")]),
    variant(
        ["awsm", "figure", "grid_pcf"],
        &[("filter_radius", "0.4"), ("max_radius", "40"), ("grid_pcf_side", "5")],
        &[("light_filter", "\"grid_pcf\"")],
    ),
    variant(["awsm", "figure", "poisson9"], &[], &[("light_filter", "\"poisson9\""), ("msaa", "true")]),
    variant(
        ["awsm", "figure", "poisson64"],
        &[],
        &[("light_filter", "\"poisson64\""), ("reverse_z", "false")],
    ),
    variant(
        ["awsm", "figure", "vogel"],
        &[],
        &[("light_filter", "\"vogel\""), ("storage_descriptors", "false")],
    ),
    variant(
        ["awsm", "figure", "hard_lights"],
        &[("hard_below", "1000000"), ("debug_view", "\"penumbra\"")],
        &[("light_filter", "\"pcss\"")],
    ),
    variant(["awsm", "figure", "fixed_taps"], &[("filter_radius", "0.4")], &[("rotate_taps", "false")]),
    variant(["awsm", "figure", "pcss"], &[("local_light_radius", "0.1")], &[("light_filter", "\"pcss\"")]),
    variant(
        ["awsm", "courtyard", "pcss"],
        &[("sun_angle", "0.087266"), ("local_light_radius", "0.4"), ("search_taps", "12")],
        &[("light_filter", "\"pcss\""), ("msaa", "true"), ("reverse_z", "false")],
    ),
    variant(
        ["awsm", "interior", "pcss"],
        &[
            ("sun_angle", "0.20944"),
            ("local_light_radius", "0.5"),
            ("max_penumbra", "12"),
            ("max_search", "24"),
        ],
        &[("light_filter", "\"pcss\""), ("reverse_z", "false")],
    ),
    variant(
        ["awsm", "figure", "biased"],
        &[("normal_offset", "3"), ("constant_bias", "0.02"), ("slope_bias", "2"), ("max_slope", "2")],
        &[],
    ),
    variant(
        ["awsm", "figure", "msaa_shadow_term"],
        &[("debug_view", "\"shadow_term\"")],
        &[("msaa", "true"), ("reverse_z", "false")],
    ),
    variant(
        ["awsm", "courtyard", "contact_proportional"],
        &[("contact_strength", "1"), ("contact_steps", "8")],
        &[("contact_shadows", "true"), ("msaa", "true"), ("storage_descriptors", "false")],
    ),
    variant(
        ["awsm", "figure", "contact_first_hit"],
        &[
            ("contact_form", "\"first_hit\""),
            ("contact_strength", "1"),
            ("contact_thickness", "0.3"),
            ("noise_cell", "3"),
        ],
        &[("contact_shadows", "true"), ("reverse_z", "false")],
    ),
    variant(
        ["awsm", "courtyard", "evsm4"],
        &[("moment_cascades", "\"last\""), ("blur_radius", "2")],
        &[("moment_precision", "\"fp32\""), ("light_filter", "\"hard\"")],
    ),
    variant(
        ["awsm", "figure", "evsm2"],
        &[("moment_cascades", "\"all\""), ("moment_spots", "true"), ("blur_radius", "4")],
        &[("moment_filter", "\"evsm2\""), ("reverse_z", "false")],
    ),
    variant(
        ["awsm", "interior", "msm"],
        &[
            ("moment_spots", "true"),
            ("moment_levels", "3"),
            ("light_bleed", "0.05"),
            ("moment_bias", "0.0002"),
        ],
        &[("moment_filter", "\"msm\"")],
    ),
    variant(
        ["awsm", "interior", "msm_depths"],
        &[("moment_spots", "true"), ("debug_view", "\"moments\"")],
        &[("moment_filter", "\"msm\"")],
    ),
    variant(
        ["awsm", "figure", "evsm2_depths"],
        &[("moment_cascades", "\"all\""), ("debug_view", "\"moments\"")],
        &[("moment_filter", "\"evsm2\"")],
    ),
    variant(
        ["awsm", "courtyard", "tints_of_moments"],
        &[
            ("splits", "\"explicit\""),
            ("far", "[12,20,35,60]"),
            ("moment_cascades", "\"all\""),
            ("debug_view", "\"cascades\""),
        ],
        &[],
    ),
    variant(
        ["awsm", "courtyard", "coarse_noise"],
        &[("noise_cell", "3"), ("debug_view", "\"penumbra\"")],
        &[("light_filter", "\"pcss\"")],
    ),
    variant(
        ["awsm", "interior", "biased"],
        &[("normal_offset", "8"), ("constant_bias", "0.02"), ("slope_bias", "2"), ("max_slope", "2")],
        &[("light_filter", "\"hard\"")],
    ),
    variant(["awsm", "interior", "forward_atlas"], &[("debug_view", "\"atlas\"")], &[("reverse_z", "false")]),
    variant(
        ["awsm", "interior", "green_lights"],
        &[("debug_view", "\"penumbra\"")],
        &[("light_filter", "\"pcss\"")],
    )
    .of(every_other_light_green),
    variant(
        ["awsm", "interior", "edges_in_turn"],
        &[("filter_radius", "0.1"), ("max_radius", "40"), ("local_light_radius", "0.3")],
        &[("light_filter", "\"pcss\"")],
    )
    .of(edges_in_turn),
    variant(
        ["awsm", "courtyard", "hard_shadows"],
        &[("moment_cascades", "\"all\""), ("debug_view", "\"cascades\"")],
        &[],
    )
    .of(hard_shadows),
    variant(
        ["awsm", "courtyard", "orthographic"],
        &[("contact_strength", "1")],
        &[("contact_shadows", "true")],
    )
    .of(orthographic),
    variant(["awsm", "interior", "without_sun"], &[("debug_view", "\"cascades\"")], &[]).of(without_sun),
    variant(["awsm", "interior", "without_sun_term"], &[("debug_view", "\"shadow_term\"")], &[])
        .of(without_sun),
    variant(["awsm", "interior", "far_away"], &[("moment_spots", "true")], &[]).of(far_away),
    variant(
        ["awsm", "interior", "far_away_pcss"],
        &[("debug_view", "\"shadow_term\"")],
        &[("light_filter", "\"pcss\""), ("visibility_first", "true"), ("reverse_z", "false")],
    )
    .of(far_away),
    variant(["awsm", "courtyard", "two_suns"], &[("moment_cascades", "\"last_two\"")], &[]).of(two_suns),
    variant(
        ["awsm", "interior", "few_slots"],
        &[("slot_capacity", "2"), ("moment_cascades", "\"all\"")],
        &[("visibility_first", "true"), ("reverse_z", "false")],
    ),
    // Receivers at the far end of the map's depth, which is 1, and near its edges.
    variant(
        ["awsm", "courtyard", "one_forward_cascade"],
        &[("far", "[30]"), ("blend", "0"), ("fit", "\"tight\""), ("splits", "\"explicit\"")],
        &[("reverse_z", "false"), ("light_filter", "\"hard\"")],
    ),
    variant(
        ["awsm", "interior", "evsm2_wide_blur"],
        &[
            ("moment_spots", "true"),
            ("blur_radius", "40"),
            ("exponent", "8"),
            ("min_deviation", "0.03"),
            ("light_bleed", "0"),
        ],
        &[("moment_filter", "\"evsm2\""), ("moment_precision", "\"fp32\"")],
    ),
    variant(
        ["awsm", "courtyard", "msm_biased"],
        &[
            ("moment_cascades", "\"all\""),
            ("moment_bias", "0.1"),
            ("blur_radius", "3"),
            ("light_bleed", "0"),
            ("cascade_side", "250"),
        ],
        &[("moment_filter", "\"msm\"")],
    ),
    variant(
        ["awsm", "courtyard", "moment_mips"],
        &[
            ("moment_cascades", "\"all\""),
            ("moment_spots", "true"),
            ("moment_levels", "3"),
            ("blur_radius", "1"),
            ("cascade_side", "1022"),
        ],
        &[("moment_precision", "\"fp32\"")],
    ),
    variant(
        ["awsm", "figure", "evsm4_fp16"],
        &[
            ("moment_cascades", "\"last_two\""),
            ("moment_spots", "true"),
            ("exponent", "2"),
            ("min_deviation", "0.05"),
            ("light_bleed", "0.5"),
        ],
        &[],
    ),
    variant(
        ["awsm", "figure", "contact_faded"],
        &[
            ("contact_form", "\"first_hit\""),
            ("contact_strength", "0.9"),
            ("contact_fade", "0.8"),
            ("contact_steps", "9"),
            ("contact_jitter", "0.5"),
            ("contact_thickness", "0.3"),
        ],
        &[("contact_shadows", "true"), ("denoise", "true")],
    ),
    variant(
        ["awsm", "interior", "visibility_first"],
        &[("local_light_radius", "0.1"), ("denoise_radius", "2")],
        &[
            ("light_filter", "\"pcss\""),
            ("visibility_first", "true"),
            ("denoise", "true"),
            ("contact_shadows", "true"),
        ],
    )
    .of(every_other_light_without_contact),
    variant(
        ["awsm", "interior", "wide_filter"],
        &[("filter_radius", "1"), ("max_radius", "40"), ("atlas_max_side", "256")],
        &[("point_shadows", "false")],
    )
    .of(every_other_light_green),
];

/// Lessons that draw with templates of their own; the later ones a scene; and the number of frames drawn.
pub const LESSONS: &[(&str, Option<&str>, u64)] = &[
    ("01-smallest", None, 1),
    ("09-loops-and-mips", None, 1),
    ("18-mesh", None, 1),
    ("26-depth-prepass", Some("courtyard"), 1),
    ("27-ssao", Some("courtyard"), 1),
    ("28-bloom", Some("courtyard"), 1),
    ("29-temporal", Some("courtyard"), 3),
    ("30-deferred", Some("courtyard"), 1),
    ("32-own-lighting", Some("courtyard"), 1),
];

/// A pipeline, a scene, a map that is shown in place of the picture, and parameters and features.
pub const MAPS: &[([&str; 3], Settings, Settings)] = &[
    (["umbra", "courtyard", "layers"], &[], &[]),
    (["umbra", "figure", "layers"], &[("fit", "\"sphere\"")], &[("reverse_z", "false")]),
    (["umbra", "interior", "cubes"], &[], &[]),
    (
        ["awsm", "figure", "soft_spot_moments"],
        &[("moment_spots", "true"), ("blur_radius", "6")],
        &[("moment_filter", "\"msm\"")],
    ),
    (["awsm", "interior", "soft_spot_moments"], &[("moment_spots", "true"), ("blur_radius", "40")], &[]),
    (
        ["awsm", "courtyard", "soft_cascade_moments"],
        &[("moment_cascades", "\"last_two\""), ("blur_radius", "5"), ("cascade_side", "250")],
        &[("moment_filter", "\"evsm2\""), ("reverse_z", "false")],
    ),
    (
        ["awsm", "foliage", "soft_cascade_moments"],
        &[("moment_cascades", "\"all\""), ("blur_radius", "64")],
        &[("moment_precision", "\"fp32\"")],
    ),
    (["extended/lore_evsm", "courtyard", "soft_moments"], &[], &[("reverse_z", "false")]),
];

/// Systems that a file extends: the file, the system, a scene that shows the difference, the number of frames,
/// parameters and features.
pub const EXTENDED: &[(&str, &str, &str, u64, Settings, Settings)] = &[
    ("lore_pcss", "lore", "courtyard", 1, &[("resolutions", "[1024,1024,512,512]")], &[]),
    ("lore_evsm", "lore", "courtyard", 1, &[], &[]),
    ("lore_vsm", "lore", "courtyard", 1, &[("min_deviation", "0.02")], &[("reverse_z", "false")]),
    ("lore_local_lights", "lore", "interior", 1, &[], &[]),
    ("lore_temporal", "lore", "courtyard", 8, &[], &[]),
    ("awsm_deferred", "awsm", "interior", 1, &[], &[]),
];
