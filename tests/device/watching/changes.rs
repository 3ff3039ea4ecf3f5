//! Each kind of file, each way of writing it, and what frames keep.

use super::stage::{FILES, SIZE, Stage, WAYS, Way, texts};

/// An edit of every kind of file changes the picture to that of a fresh start, however it is written.
#[test]
fn edits_of_every_kind_of_file_are_shown() {
    let Some(mut stage) = Stage::new("edits_of_every_kind", FILES) else { return };
    let mut shown = stage.until("begun", |_, _| true);
    let edits = [
        ("frame.json", "=level * 0.5", "=level * 0.25"),
        ("values.json", "\"max\": 1.0", "\"max\": 0.9"),
        ("tint.json", "\"bind\"", "\"wide\": true, \"bind\""),
        ("look.json", "0.75", "0.25"),
        ("shaders/fill.wgsl.jinja", "0.25, 1.0", "0.5, 1.0"),
        ("shaders/fill.axes.json", "false", "true"),
        ("shaders/corner.wgsl.jinja", "0.0, 1.0", "0.5, 1.0"),
        ("shaders/tint.wgsl.jinja", "0.75", "0.5"),
    ];
    for (at, (name, from, to)) in edits.into_iter().enumerate() {
        let text = texts()[name];
        assert!(text.contains(from), "{name}");
        stage.write(name, &text.replace(from, to), WAYS[at % WAYS.len()]);
        match stage.fresh() {
            Ok(fresh) => {
                stage.until(name, |watcher, one| watcher.error().is_none() && *one == fresh);
            }
            Err(said) => {
                // The edit of a subgraph has a key that is not there.
                let error = stage.until(name, |watcher, _| watcher.error().is_some());
                assert_eq!(error, shown, "{said}");
            }
        }
        stage.write(name, text, WAYS[(at + 1) % WAYS.len()]);
        let fresh = stage.fresh().unwrap();
        shown = stage.until(name, |watcher, one| watcher.error().is_none() && *one == fresh);
    }
}

#[test]
fn folder_of_templates_may_come_later() {
    let Some(mut stage) = Stage::new("folder_may_come_later", FILES) else { return };
    let [there, away] = ["shaders", "away"].map(|name| stage.folder.join(name));
    let fresh = stage.fresh().unwrap();
    std::fs::rename(&there, &away).unwrap();
    let library = umbragraph::Library::new().templates(&there);
    let watcher = umbragraph::Watcher::new(library, stage.folder.join("frame.json")).unwrap();
    stage.watcher = watcher.parameters([stage.folder.join("look.json")]);
    let said = (0..2000).find_map(|_| {
        assert_eq!(stage.frame(), None, "nothing is drawn without templates");
        std::thread::sleep(std::time::Duration::from_millis(4));
        stage.watcher.error().map(ToString::to_string)
    });
    assert!(said.as_ref().is_some_and(|said| said.contains("shaders")), "{said:?}");
    std::fs::rename(&away, &there).unwrap();
    assert_eq!(stage.until("mended", |watcher, _| watcher.error().is_none()), fresh);
}

#[test]
fn broken_edit_keeps_the_last_good_frame_and_says_why() {
    let Some(mut stage) = Stage::new("broken_edit_keeps", FILES) else { return };
    let good = stage.until("begun", |_, _| true);
    let broken = texts()["frame.json"].replace("\"&color\" }]", "\"&colour\" }]");
    stage.write("frame.json", &broken, Way::Rename);
    assert_eq!(stage.until("told", |watcher, _| watcher.error().is_some()), good);
    let said = stage.watcher.error().unwrap().to_string();
    assert!(said.contains("frame.json:10:") && said.contains("colour"), "{said}");
    // Another size is drawn with the last good pipeline.
    stage.resize([SIZE[0] * 2, SIZE[1]]);
    let wide = stage.frame().expect("a frame");
    assert_eq!([wide.width(), wide.height()], [SIZE[0] * 2, SIZE[1]]);
    assert!(stage.watcher.error().is_some());
    stage.resize(SIZE);
    assert_eq!(stage.frame(), Some(good.clone()));
    stage.write("frame.json", texts()["frame.json"], Way::Again);
    assert_eq!(stage.until("mended", |watcher, _| watcher.error().is_none()), good);
}

#[test]
fn broken_beginning_is_drawn_once_it_is_mended() {
    let broken: Vec<(&str, &str)> =
        FILES.iter().map(|(name, text)| (*name, if *name == "values.json" { "{" } else { *text })).collect();
    let Some(mut stage) = Stage::new("broken_beginning", &broken) else { return };
    while stage.watcher.error().is_none() {
        assert_eq!(stage.frame(), None);
    }
    stage.write("values.json", texts()["values.json"], Way::InPlace);
    let fresh = stage.fresh().unwrap();
    assert_eq!(stage.until("mended", |_, _| true), fresh);
}

#[test]
fn new_template_in_the_folder_is_found() {
    let Some(mut stage) = Stage::new("new_template", FILES) else { return };
    stage.until("begun", |_, _| true);
    let other = texts()["shaders/fill.wgsl.jinja"].replace("0.25, 1.0", "0.75, 1.0");
    std::fs::create_dir(stage.folder.join("shaders/more")).unwrap();
    std::fs::write(stage.folder.join("shaders/more/other.wgsl.jinja"), other).unwrap();
    let axes = texts()["shaders/fill.axes.json"];
    std::fs::write(stage.folder.join("shaders/more/other.axes.json"), axes).unwrap();
    let frame = texts()["frame.json"].replace("fill.wgsl", "more/other.wgsl");
    stage.write("frame.json", &frame, Way::InPlace);
    let fresh = stage.fresh().unwrap();
    stage.until("the other template", |_, one| *one == fresh);
}

/// A count of frames in a history, shown as it is, and a value that is set live.
const COUNTING: &[(&str, &str)] = &[
    (
        "frame.json",
        r#"{
  "format": 1,
  "name": "counting",
  "parameters": { "blue": { "type": "f32", "default": 0.25, "min": 0.0, "max": 1.0, "unit": "1" }, "green": { "type": "f32", "default": 0.5, "min": 0.0, "max": 1.0, "unit": "1" } },
  "resources": {
    "count": { "texture": { "format": "rgba8unorm", "size": [1, 1], "lifetime": "history", "initial": [0, 0, 0, 1] } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "add": { "fullscreen": { "shader": "add.wgsl.jinja", "bind": { "source": "&count@-1" }, "color": [{ "to": "&count" }] } },
    "show": { "fullscreen": { "shader": "show.wgsl.jinja", "color": [{ "to": "&target" }],
      "bind": { "source": "&count", "params": { "values": { "blue": "=blue", "green": "=green" } } } } }
  }
}
"#,
    ),
    ("shaders/corner.wgsl.jinja", FILES[6].1),
    (
        "shaders/add.wgsl.jinja",
        r#"{% include "corner.wgsl.jinja" %}
@group(0) @binding(0) var source: texture_2d<f32>;

@fragment fn add() -> @location(0) vec4<f32> {
    return textureLoad(source, vec2<i32>(0), 0) + vec4<f32>(1.0 / 255.0, 0.0, 0.0, 0.0);
}
"#,
    ),
    (
        "shaders/show.wgsl.jinja",
        r#"{% include "corner.wgsl.jinja" %}
struct Params { @align(16) blue: f32, green: f32 }
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var<uniform> params: Params;

@fragment fn show() -> @location(0) vec4<f32> {
    return vec4<f32>(textureLoad(source, vec2<i32>(0), 0).x, params.green, params.blue, 1.0);
}
"#,
    ),
];

#[test]
fn histories_and_live_values_go_on_across_edits() {
    let Some(mut stage) = Stage::new("histories_and_live_values", COUNTING) else { return };
    let first = stage.until("begun", |_, _| true).rgba_pixels().next().unwrap();
    assert_eq!(&first[1..3], &[128, 64]);
    let executor = stage.renderer.executor().unwrap();
    let blue = executor.parameter::<f32>("blue").unwrap();
    executor.set(blue, 1.0).unwrap();
    let second = stage.frame().unwrap().rgba_pixels().next().unwrap();
    assert_eq!((second[0], second[2]), (first[0] + 1, 255));
    let edited = COUNTING[0].1.replace("\"default\": 0.5", "\"default\": 1.0");
    stage.write("frame.json", &edited, Way::Rename);
    let mut count = second[0];
    for _ in 0..240 {
        let pixel = stage.frame().unwrap().rgba_pixels().next().unwrap();
        count += 1;
        assert_eq!((pixel[0], pixel[2]), (count, 255), "no frame is lost, and the value that was set stays");
        if pixel[1] == 255 {
            assert!(stage.watcher.take_reload().is_some());
            return;
        }
        // Frames beside the planning first; then a minute for a machine that is busy.
        let pause = if count < 200 { 8 } else { 1500 };
        std::thread::sleep(std::time::Duration::from_millis(pause));
    }
    panic!("the edit is not shown: {:?}", stage.watcher.error());
}
