//! `umbragraph score` as a user meets it.

use std::path::PathBuf;
use std::process::{Command, Output};

use umbragraph_test_support::command::rejected;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::scratch::ScratchFolder;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn score(pipeline: &str, scene: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(["score", pipeline, "--scene", scene, "--size", "160x90"]).args(arguments);
    command.current_dir(root()).output().expect("the command")
}

const FIGURE: &str = "examples/scenes/figure.glb";
const FOLIAGE: &str = "examples/scenes/foliage.glb";

#[test]
fn a_light_is_scored_alone_and_all_lights_are_together() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("a_light_is_scored_alone");
    let picture = folder.join("difference.png");
    let arguments =
        ["--format", "json", "--out", picture.to_str().unwrap(), "--feature", "light_filter=hard"];
    let output = score("pipelines/awsm.json", FIGURE, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let lights = json["lights"].as_array().unwrap();
    let names: Vec<&str> = lights.iter().map(|light| light["light"].as_str().unwrap()).collect();
    assert_eq!(names, ["sun", "stage spot"]);
    let pixels = |scores: &serde_json::Value| scores["bands"]["0"]["pixels"].as_u64().unwrap();
    assert_eq!(lights.iter().map(|light| pixels(&light["scores"])).sum::<u64>(), pixels(&json["together"]));
    for light in lights {
        let iou = light["scores"]["bands"]["1"]["iou"].as_f64().unwrap();
        assert!(iou > 0.98, "{light}");
    }
    let picture = Picture::load(&picture).unwrap();
    assert_eq!((picture.width(), picture.height()), (160, 180), "one light below the other");
}

#[test]
fn rays_are_kept_and_an_answer_is_the_same_with_them() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("rays_are_kept");
    let cache = folder.join("cache");
    let kept = || -> Vec<PathBuf> {
        let entries = std::fs::read_dir(&cache).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).collect()
    };
    let said = |more: &[&str]| {
        let of_cache = ["--format", "json", "--cache", cache.to_str().unwrap()];
        let output = score("pipelines/awsm.json", FIGURE, &[&of_cache[..], more].concat());
        String::from_utf8(output.stdout).unwrap()
    };
    let first = said(&[]);
    assert_eq!(kept().len(), 2, "one file for each light");
    assert_eq!(said(&[]), first);
    // Other filters, the same rays.
    assert_ne!(said(&["--preset", "clean"]), first);
    assert_eq!(kept().len(), 2);
    // What is broken is traced again.
    kept().iter().for_each(|path| std::fs::write(path, "broken").unwrap());
    assert_eq!(said(&[]), first);
    assert!(kept().iter().all(|path| std::fs::metadata(path).unwrap().len() > 1000));
    // Another time of an animation has other rays.
    said(&["--at", "0.5"]);
    assert_eq!(kept().len(), 4);
    // So has another camera.
    said(&["--camera", "random:3"]);
    assert!(kept().len() > 4);
}

/// The default filter of `awsm` is wider than posts and limbs, so their shadows blur away; the preset's filter is
/// narrower.
#[test]
fn the_preset_clean_of_awsm_keeps_the_shadows_of_what_is_thin() {
    if gpu::device().is_none() {
        return;
    }
    let sun = |arguments: &[&str]| {
        let output = score("pipelines/awsm.json", FIGURE, &[&["--format", "json"], arguments].concat());
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let scores = &json["lights"][0]["scores"];
        let [iou, leak] = ["iou", "leak"].map(|name| scores["bands"]["1"][name].as_f64().unwrap());
        (iou, leak, scores["contact_leak"].as_f64().unwrap_or(0.0))
    };
    let (usual, clean) = (sun(&[]), sun(&["--preset", "clean"]));
    println!("{usual:?} {clean:?}");
    assert!(usual.0 < 0.5 && usual.1 > 0.5, "{usual:?}");
    assert!(clean.0 > 0.98 && clean.1 < 0.01 && clean.2 < 0.1, "{clean:?}");
}

#[test]
fn what_a_pipeline_does_not_shadow_is_said_and_counts() {
    if gpu::device().is_none() {
        return;
    }
    let output = score("pipelines/nebula.json", FIGURE, &[]);
    assert_eq!(output.status.code(), Some(0));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("UG0812") && errors.contains("\"stage spot\" no shadows"), "{errors}");
}

#[test]
fn figures_that_do_not_suit_a_filter_are_named() {
    if gpu::device().is_none() {
        return;
    }
    let notes = |pipeline: &str, arguments: &[&str]| {
        let output = score(pipeline, FIGURE, arguments);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        ["soft: IoU, leak and acne", "hard: the mean error"].map(|words| text.contains(words))
    };
    assert_eq!(notes("pipelines/awsm.json", &[]), [true, false], "a wide filter");
    let hard = ["--feature", "light_filter=hard"];
    assert_eq!(notes("pipelines/umbra.json", &hard), [false, true], "one comparison");
    assert_eq!(notes("pipelines/umbra.json", &[]), [false, false], "a filter as wide as the light");
}

/// A terminal shows progress, which `script` gives to the command; a pipe gets none.
#[cfg(target_os = "linux")]
#[test]
fn rows_of_rays_are_counted_on_a_terminal_alone() {
    if gpu::device().is_none() || Command::new("script").arg("--version").output().is_err() {
        return;
    }
    let program = env!("CARGO_BIN_EXE_umbragraph");
    let line = format!(
        "'{program}' score pipelines/nebula.json --scene {FIGURE} --size 320x180 --set resolution=256 --no-cache"
    );
    let output =
        Command::new("script").args(["-qec", &line, "/dev/null"]).current_dir(root()).output().unwrap();
    let shown = String::from_utf8_lossy(&output.stdout);
    assert!(shown.contains("tracing rays, row ") && shown.contains(" of 360, "), "{shown}");
    assert!(shown.contains(" to go"), "the time left: {shown}");
    let piped = score("pipelines/nebula.json", FIGURE, &["--no-cache"]);
    assert!(!String::from_utf8_lossy(&piped.stderr).contains("tracing rays"));
}

#[test]
fn a_light_without_shadows_in_one_frame_is_none_without_any() {
    if gpu::device().is_none() {
        return;
    }
    let near = ["--camera", "random:3", "--set", "far=[6,9,12]", "--frames"];
    let of_frames = |frames: &str| {
        let output = score(
            "pipelines/caracal.json",
            "examples/scenes/courtyard.glb",
            &[&near[..], &[frames]].concat(),
        );
        assert_eq!(output.status.code(), Some(0));
        String::from_utf8_lossy(&output.stderr).contains("no shadows at all")
    };
    assert_eq!(["1", "3"].map(of_frames), [true, false]);
}

#[test]
fn limits_decide_the_exit_status() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("limits_decide_the_exit_status");
    let limits = |text: &str| {
        let path = folder.join("limits.json");
        std::fs::write(&path, text).unwrap();
        score("pipelines/nebula.json", FOLIAGE, &["--limits", path.to_str().unwrap()])
    };
    assert_eq!(limits(r#"{ "min_iou": 0.3, "max_acne_k2": 0.05 }"#).status.code(), Some(0));
    rejected(&limits(r#"{ "min_iou": 0.999 }"#), 1, &["UG0813", "min_iou is 0.999", "--out"]);
    rejected(&limits(r#"{ "min_beauty": 1 }"#), 1, &["UG0813", "\"min_beauty\"", "min_iou_k2"]);
    rejected(&limits("[]"), 1, &["UG0813", "no limits of scores"]);
}

#[test]
fn a_pipeline_without_a_shadow_term_is_told_how_to_get_one() {
    let output = score("pipelines/learn/01-smallest.json", FIGURE, &[]);
    rejected(&output, 1, &["UG0812", "shows no shadow term", "\"debug_view\"", "alpha 1"]);
}

#[test]
fn a_scene_without_scores_is_told_what_is_missing() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("a_scene_in_which_nothing_can_be_scored");
    let camera = folder.join("up.json");
    // Into the sky.
    std::fs::write(&camera, r#"{ "keys": [ { "time": 0, "position": [0, 90, 0], "target": [1, 95, 0] } ] }"#)
        .unwrap();
    let output = score("pipelines/nebula.json", FOLIAGE, &["--camera", camera.to_str().unwrap()]);
    rejected(&output, 1, &["UG0812", "no surface"]);
    // A triangle without a light: the default one is scored. One whose only light casts no shadows: nothing is.
    let scene = |lights: &str, nodes: &str| {
        let path = folder.join("scene.gltf");
        let positions = [-1.0_f32, 0.0, -1.0, 1.0, 0.0, -1.0, 0.0, 0.0, 1.0];
        let bytes: Vec<u8> = positions.iter().flat_map(|number| number.to_le_bytes()).collect();
        std::fs::write(folder.join("positions.bin"), bytes).unwrap();
        let text = format!(
            r#"{{ "asset": {{ "version": "2.0" }}, "scene": 0, "scenes": [{{ "nodes": [0{nodes}] }}],
              "extensionsUsed": ["KHR_lights_punctual"], {lights}
              "nodes": [{{ "mesh": 0 }}, {{ "rotation": [-0.7071068, 0, 0, 0.7071068], "extensions": {{ "KHR_lights_punctual": {{ "light": 0 }} }} }}],
              "materials": [{{ "doubleSided": true }}],
              "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "material": 0 }}] }}],
              "accessors": [{{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 0, 1] }}],
              "bufferViews": [{{ "buffer": 0, "byteLength": 36 }}], "buffers": [{{ "uri": "positions.bin", "byteLength": 36 }}] }}"#
        );
        std::fs::write(&path, text).unwrap();
        score("pipelines/nebula.json", path.to_str().unwrap(), &[])
    };
    let dark = r#""extensions": { "KHR_lights_punctual": { "lights": [{ "type": "directional", "extras": { "castShadow": false } }] } },"#;
    rejected(&scene(dark, ", 1"), 1, &["UG0812", "no light of the scene casts shadows"]);
    let sun = r#""extensions": { "KHR_lights_punctual": { "lights": [{ "type": "directional" }] } },"#;
    let alone = scene(sun, "");
    assert_eq!(alone.status.code(), Some(0), "{}", String::from_utf8_lossy(&alone.stderr));
    assert!(String::from_utf8_lossy(&alone.stdout).contains("1 triangles"));
}

#[test]
fn where_nothing_casts_shadows_there_is_no_score_of_any() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("where_nothing_casts_shadows");
    let path = folder.join("scene.gltf");
    let [positions, indices] = ground(1, 1);
    std::fs::write(folder.join("ground.bin"), [positions, indices].concat()).unwrap();
    std::fs::write(&path, scene_of(4, 2, r#", "extras": { "castShadow": false }"#)).unwrap();
    let output = score("pipelines/nebula.json", path.to_str().unwrap(), &["--format", "json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["together"]["bands"]["0"]["iou"], serde_json::Value::Null);
    assert_eq!(json["together"]["bands"]["0"]["acne_pixels"], 0);
    assert_eq!(json["worst"], serde_json::Value::Null);
}

/// Returns the bytes of positions and of indices of a hilly ground with `columns` by `rows` quads.
fn ground(columns: u32, rows: u32) -> [Vec<u8>; 2] {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for z in 0..=rows {
        for x in 0..=columns {
            let [across, along] =
                [(x, columns), (z, rows)].map(|(at, of)| at as f32 / of as f32 * 20.0 - 10.0);
            let height = (3.0 * across).sin() * (2.0 * along).cos() * 0.5;
            positions.extend([across, height, along].into_iter().flat_map(f32::to_le_bytes));
        }
    }
    for z in 0..rows {
        for x in 0..columns {
            let at = z * (columns + 1) + x;
            let below = at + columns + 1;
            indices
                .extend([at, below, at + 1, at + 1, below, below + 1].into_iter().flat_map(u32::to_le_bytes));
        }
    }
    [positions, indices]
}

/// Returns a glTF scene of the ground in `ground.bin`, with one sun and without a camera.
fn scene_of(vertices: u32, triangles: u32, extras: &str) -> String {
    let (positions, indices) = (12 * vertices, 12 * triangles);
    format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "scene": 0, "scenes": [{{ "nodes": [0, 1] }}],
          "extensionsUsed": ["KHR_lights_punctual"],
          "extensions": {{ "KHR_lights_punctual": {{ "lights": [{{ "type": "directional", "intensity": 3 }}] }} }},
          "nodes": [{{ "mesh": 0{extras} }}, {{ "rotation": [-0.6, 0, 0, 0.8], "extensions": {{ "KHR_lights_punctual": {{ "light": 0 }} }} }}],
          "materials": [{{ "doubleSided": true }}],
          "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "indices": 1, "material": 0 }}] }}],
          "accessors": [
            {{ "bufferView": 0, "componentType": 5126, "count": {vertices}, "type": "VEC3", "min": [-10, -0.5, -10], "max": [10, 0.5, 10] }},
            {{ "bufferView": 1, "componentType": 5125, "count": {}, "type": "SCALAR" }} ],
          "bufferViews": [
            {{ "buffer": 0, "byteLength": {positions} }},
            {{ "buffer": 0, "byteOffset": {positions}, "byteLength": {indices} }} ],
          "buffers": [{{ "uri": "ground.bin", "byteLength": {} }}] }}"#,
        3 * triangles,
        positions + indices,
    )
}

#[test]
fn a_million_triangles_are_scored_and_their_memory_is_stated() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("a_million_triangles");
    let path = folder.join("scene.gltf");
    let [positions, indices] = ground(1000, 500);
    std::fs::write(folder.join("ground.bin"), [positions, indices].concat()).unwrap();
    std::fs::write(&path, scene_of(1001 * 501, 1_000_000, "")).unwrap();
    let output = score("pipelines/nebula.json", path.to_str().unwrap(), &["--set", "resolution=256"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout);
    let (_, said) = text.split_once("1000000 triangles, ").expect("the number of triangles");
    let megabytes: f64 = said.split(' ').next().unwrap().parse().unwrap();
    assert!((100.0..300.0).contains(&megabytes), "{text}");
    assert!(text.contains("boxes around triangles"), "how long it took: {text}");
}
