//! Reference pictures: every pipeline on every scene in each of its debug views, variants of them, lessons, and maps
//! themselves.

mod table;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::Gpu;
use umbragraph_test_support::image::{Picture, Tolerance};

use table::{Change, EXTENDED, LESSONS, MAPS, Settings, VARIANTS};
pub use table::{PIPELINES, SCENES};

use super::gpu::{Host, picture, scene};
use super::{Outcome, With, check_file, check_with, root};

/// Width and height of all pictures.
const SIZE: [u32; 2] = [240, 136];

const MAPS_TEMPLATE: &str = include_str!("pictures/maps.wgsl.jinja");
const MAPS_AXES: &str = include_str!("pictures/maps.axes.json");

/// One reference picture.
#[derive(Clone)]
pub struct Case {
    /// The name of its file.
    pub name: String,
    scene: Option<&'static str>,
    pipeline: String,
    /// A texture that is shown in place of the picture.
    map: Option<&'static str>,
    /// A file that extends the pipeline.
    extension: Option<&'static str>,
    parameters: Vec<(&'static str, String)>,
    features: Settings,
    change: Option<Change>,
    /// The number of frames that are drawn; the last one is the picture.
    frames: u64,
}

/// The pictures of a pipeline on a scene: one for each debug view.
pub fn of_scene(pipeline: &'static str, scene: &'static str) -> Vec<Case> {
    let views = debug_views(pipeline);
    views
        .iter()
        .map(|view| case(&format!("{pipeline}_{scene}_{view}"), pipeline, scene, view, &[], &[]))
        .collect()
}

/// The pictures of lessons, of some in settings that show more, and of the one that extends a pipeline from outside.
pub fn of_lessons() -> Vec<Case> {
    let lesson = |name: String, lesson: &str, scene, parameters: &[(&'static str, &str)]| Case {
        pipeline: format!("pipelines/learn/{lesson}.json"),
        scene,
        parameters: parameters.iter().map(|(name, value)| (*name, (*value).to_owned())).collect(),
        ..case(&name, "nebula", "courtyard", "off", &[], &[])
    };
    let map = [("resolution", "1024")];
    let usual = LESSONS.iter().map(|(name, scene, frames)| {
        let parameters = scene.map_or(&[][..], |_| &map);
        Case { frames: *frames, ..lesson(format!("learn_{name}"), name, *scene, parameters) }
    });
    let dark = [("resolution", "1024"), ("occlusion_strength", "8")];
    let dark = lesson("learn_27-ssao_strong".to_owned(), "27-ssao", Some("courtyard"), &dark);
    let dark = Case { change: Some(table::orthographic), ..dark };
    let overlay = case("learn_overlay", "nebula", "courtyard", "off", &[("line_opacity", "1")], &[]);
    let overlay = Case { extension: Some("pipelines/learn/parts/overlay.json"), ..overlay };
    let glowing = ["30-deferred", "32-own-lighting"].map(|name| Case {
        change: Some(table::glowing),
        ..lesson(format!("learn_{name}_glowing"), name, Some("courtyard"), &map)
    });
    let rays = lesson("learn_35-rays".to_owned(), "35-rays", Some("courtyard"), &[("ray_samples", "8")]);
    usual.chain(glowing).chain([dark, overlay, rays]).collect()
}

/// The pictures of pipelines that extend a system.
pub fn of_extended() -> Vec<Case> {
    let of = |row: &(&str, &'static str, &'static str, u64, Settings, Settings)| {
        let (name, system, scene, frames, parameters, features) = *row;
        Case {
            pipeline: format!("pipelines/extended/{name}.json"),
            frames,
            ..case(&format!("extended_{name}"), system, scene, "off", parameters, features)
        }
    };
    EXTENDED.iter().map(of).collect()
}

/// The pictures of maps.
pub fn of_maps() -> Vec<Case> {
    let of = |([pipeline, scene, map], parameters, features): &([&'static str; 3], Settings, Settings)| {
        let system = pipeline.rsplit('/').next().and_then(|name| name.split('_').next()).expect("a name");
        let name = format!("maps_{}_{scene}_{map}", pipeline.replace("extended/", ""));
        Case {
            pipeline: format!("pipelines/{pipeline}.json"),
            map: Some(map),
            ..case(&name, system, scene, "off", parameters, features)
        }
    };
    MAPS.iter().map(of).collect()
}

/// The pictures of a pipeline's variants.
pub fn of_variants(pipeline: &str) -> Vec<Case> {
    let own = VARIANTS.iter().filter(|variant| variant.pipeline == pipeline);
    own.map(|variant| {
        let name = format!("{}_{}_{}", variant.pipeline, variant.scene, variant.name);
        let case = case(&name, variant.pipeline, variant.scene, "off", variant.parameters, variant.features);
        Case { change: variant.change, ..case }
    })
    .collect()
}

fn case(
    name: &str,
    pipeline: &'static str,
    scene: &'static str,
    view: &str,
    own: Settings,
    features: Settings,
) -> Case {
    let (_, cascades, usual) =
        PIPELINES.iter().find(|row| row.0 == pipeline).expect("a pipeline of the table");
    let (_, far) = SCENES.iter().find(|row| row.0 == scene).expect("a scene of the table");
    let mut parameters: Vec<(&str, String)> = vec![("debug_view", format!("{view:?}"))];
    if *cascades > 0 {
        parameters.push(("far", format!("[{}]", far[..*cascades].join(","))));
    }
    for (name, value) in usual.iter().chain(own) {
        parameters.retain(|(other, _)| other != name);
        parameters.push((*name, (*value).to_owned()));
    }
    Case {
        name: name.to_owned(),
        scene: Some(scene),
        pipeline: format!("pipelines/{pipeline}.json"),
        parameters,
        features,
        map: None,
        extension: None,
        change: None,
        frames: 1,
    }
}

/// The values of a pipeline's parameter `debug_view`.
fn debug_views(pipeline: &str) -> Vec<String> {
    let outcome = check_file(&format!("pipelines/{pipeline}.json"), &With::default());
    let pipeline = outcome.checked.pipeline.as_ref().unwrap_or_else(|| panic!("{}", outcome.text()));
    pipeline
        .parameters
        .get("debug_view")
        .map_or(vec!["off".to_owned()], |view| view.declaration.values.clone())
}

/// All pictures.
pub fn all() -> Vec<Case> {
    let of = |row: &(&'static str, usize, Settings)| {
        let scenes = SCENES.iter().flat_map(|scene| of_scene(row.0, scene.0));
        scenes.chain(of_variants(row.0)).collect::<Vec<_>>()
    };
    PIPELINES.iter().flat_map(of).chain(of_lessons()).chain(of_extended()).chain(of_maps()).collect()
}

impl Case {
    /// The case as it is drawn with some templates in place of the project's.
    pub fn check(&self, templates: &[(&str, &str)]) -> Outcome {
        let parameters: Vec<_> =
            self.parameters.iter().map(|(name, value)| (*name, value.as_str())).collect();
        let shows = [("maps.wgsl.jinja", MAPS_TEMPLATE), ("maps.axes.json", MAPS_AXES)];
        let own = if self.map.is_some() { &shows[..] } else { &[] };
        let with = With {
            parameters: &parameters,
            features: self.features,
            templates: &[own, templates].concat(),
            extension: self.extension,
            size: Some(SIZE),
            ..With::default()
        };
        let Some(map) = self.map else { return check_file(&self.pipeline, &with) };
        let has_formats = self.pipeline.contains("awsm") && map.contains("moments");
        let axes = if has_formats { r#""texel_format": "=texel_format""# } else { "" };
        let text = format!(
            r#"{{
                "format": 1, "name": "maps", "extends": "{}",
                "passes": {{ "show_map": {{ "after": ["present"], "fullscreen": {{
                    "shader": "maps.wgsl.jinja", "axes": {{ {axes} }},
                    "bind": {{ "map": "&{map}" }}, "color": [{{ "to": "&target" }}]
                }} }} }}
            }}"#,
            self.pipeline
        );
        check_with("maps.json", &text, &with)
    }

    /// The picture of what was checked.
    #[track_caller]
    pub fn render(&self, gpu: &Gpu, outcome: &Outcome) -> Picture {
        let Some(name) = self.scene else { return picture(gpu, outcome) };
        let mut scene = loaded(name);
        if let Some(change) = self.change {
            change(Arc::make_mut(&mut scene));
        }
        let input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
        // Several frames are seen on the way.
        let frame = |index: u64| {
            let mut input = input.clone().index(index);
            input.camera.position.x += 0.02 * index as f64;
            input
        };
        let mut host = Host::new(gpu, outcome, &scene);
        let last = self.frames.saturating_sub(1);
        (0..last).for_each(|index| {
            host.frame(&frame(index));
        });
        host.picture(&frame(last))
    }
}

/// A scene of the table, which is read once in a process.
fn loaded(name: &'static str) -> Arc<Scene> {
    static LOADED: Mutex<BTreeMap<&str, Arc<Scene>>> = Mutex::new(BTreeMap::new());
    let path = || root().join("examples/scenes").join(name).with_extension("glb");
    LOADED.lock().expect("no panic").entry(name).or_insert_with(|| Arc::new(scene(&path()))).clone()
}

/// The folder of the references.
pub fn folder() -> PathBuf {
    root().join("tests/golden")
}

/// The adapter that drew the references.
const DRAWN_BY: &str = "llvmpipe (LLVM 15.0.6, 256 bits) on vulkan";

/// The tolerance between a picture and its reference on an adapter.
pub fn tolerance(gpu: &Gpu) -> Tolerance {
    if gpu.name == DRAWN_BY {
        // Processors round differently: with and without AVX-512 some 30 pixels of `lore` differ by two levels.
        Tolerance { per_channel: 2, failed_pixels: 2 }
    } else if gpu.name.contains("llvmpipe") {
        Tolerance { per_channel: 2, failed_pixels: 8 }
    } else if gpu.name.contains("SwiftShader") {
        // Edges of surfaces and shadows are up to 5 % of the pixels of so small a picture (docs/drivers.md has the
        // causes). The views of texels and blockers are edges everywhere, and not held to this.
        Tolerance { per_channel: 8, failed_pixels: (SIZE[0] * SIZE[1] / 20) as usize }
    } else {
        // Others filter and rasterise a little differently along edges.
        Tolerance { per_channel: 6, failed_pixels: (SIZE[0] * SIZE[1] / 100) as usize }
    }
}
