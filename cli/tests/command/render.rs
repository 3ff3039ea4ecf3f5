//! `umbragraph render` as a user meets it: several frames, moving cameras, and looking inside.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use umbragraph_test_support::command::{rejected, text};
use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;
use umbragraph_test_support::skip;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Runs `render` with a size of 64 by 36 pixels.
fn render(pipeline: &str, scene: &str, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(["render", pipeline, "--scene", scene, "--size", "64x36"]).args(arguments);
    command.current_dir(root()).output().expect("the command")
}

#[track_caller]
fn fine(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    text(&output.stdout)
}

/// Reads a PNG file. Returns width, height and the bytes of the pixels.
fn png(path: &Path) -> (u32, u32, Vec<u8>) {
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    (reader.info().width, reader.info().height, pixels)
}

const COURTYARD: &str = "examples/scenes/courtyard.glb";
const FIGURE: &str = "examples/scenes/figure.glb";

#[test]
fn a_capture_shows_the_version_that_a_pass_wrote() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-capture");
    let pipeline = folder.join("twice.json");
    let fill = |color: &str| {
        format!(
            r#"{{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target", "clear": {color} }}] }} }}"#
        )
    };
    // The second pass adds; the plan must keep the first version for the capture.
    let document = format!(
        r#"{{ "format": 1, "name": "twice",
            "resources": {{
              "image": {{ "texture": {{ "format": "rgba8unorm", "size": [8, 4] }} }},
              "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
            "passes": {{
              "paint": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&image" }}] }} }},
              "add": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&image", "blend": "add" }}] }} }},
              "show": {{ "fullscreen": {{ "shader": "resample.wgsl.jinja", "bind": {{ "source": "&image" }}, "color": [{{ "to": "&target" }}] }} }},
              "unused": {} }} }}"#,
        fill("[0, 0, 0, 0]").replace("target", "nothing")
    )
    .replace(r#""target": {"#, r#""nothing": { "texture": { "format": "rgba8unorm", "size": [1, 1] } }, "target": {"#);
    std::fs::write(&pipeline, document).unwrap();
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let captures = [format!("image@paint={}", file("one.png")), format!("image={}", file("two.png"))];
    let arguments = ["--out", &file("x.png"), "--capture", &captures[0], "--capture", &captures[1]];
    let said = fine(&render(pipeline.to_str().unwrap(), FIGURE, &arguments));
    assert!(said.contains("image@paint, 8 by 4, before \"add\" overwrites it\n"), "{said}");
    let (one, two) = (png(&folder.join("one.png")), png(&folder.join("two.png")));
    assert_eq!((one.0, one.1), (8, 4));
    assert_ne!(one.2, two.2);
    for (one, two) in one.2.chunks(4).zip(two.2.chunks(4)) {
        let doubled = |at: usize| (i32::from(one[at]) * 2).min(255);
        assert!((0..3).all(|at| (doubled(at) - i32::from(two[at])).abs() <= 1), "{one:?} {two:?}");
    }
    let capture = format!("nothing={}", file("no.png"));
    let output =
        render(pipeline.to_str().unwrap(), FIGURE, &["--out", &file("x.png"), "--capture", &capture]);
    rejected(&output, 1, &["UG0809", "\"nothing\" is culled"]);
}

#[test]
fn the_page_of_a_graph_shows_captures_and_times() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-page");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (out, all, trace, page) = (file("x.png"), file("out/all"), file("trace.json"), file("page.html"));
    let pipeline = "pipelines/nebula.json";
    let arguments = ["--out", &out, "--capture-all", &all, "--trace", &trace, "--set", "resolution=64"];
    fine(&render(pipeline, FIGURE, &arguments));
    let graph = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
        command.args(["graph", pipeline]).args(arguments).current_dir(root()).output().expect("the command")
    };
    fine(&graph(&["--out", &page, "--captures", &all, "--timings", &trace]));
    let text = std::fs::read_to_string(&page).unwrap();
    let observed =
        text.split("id=\"observed\">").nth(1).and_then(|rest| rest.split("</script>").next()).unwrap();
    let observed: serde_json::Value = serde_json::from_str(observed).unwrap();
    let picture = observed["pictures"]["depth"].as_str().unwrap_or_default();
    assert!(picture.starts_with("data:image/png;base64,iVBORw0KGgo"), "{picture:.60}");
    assert!(observed["times"]["shade"][0].as_f64() > Some(0.0), "{}", observed["times"]);
    // A pass over layers has many events, which count together.
    let trace_text: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&trace).unwrap()).unwrap();
    let events = trace_text["traceEvents"].as_array().unwrap().iter();
    let of_casters = events.filter(|event| event["name"] == "casters" && event["tid"] == 2);
    let sum: f64 = of_casters.map(|event| event["dur"].as_f64().unwrap() / 1000.0).sum();
    let shown = observed["times"]["casters"][1].as_f64().unwrap();
    assert!((sum - shown).abs() < 1e-6, "{sum} {shown}");
    // The form is that of the extension, and what is of the page alone is rejected elsewhere.
    rejected(&graph(&["--out", &file("x.svg"), "--timings", &trace]), 2, &["--format html"]);
    rejected(&graph(&["--out", &file("x.png")]), 1, &["UG0808", ".svg"]);
    rejected(&graph(&["--out", &file("x.svg"), "--format", "dot"]), 1, &["UG0808", "is not the form dot"]);
    rejected(&graph(&["--out", &page, "--captures", &file("missing")]), 1, &["UG0001", "--capture-all"]);
}

#[test]
fn lights_that_no_pass_reads_are_named() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-lights");
    let out = folder.join("x.png");
    let arguments = ["--out", out.to_str().unwrap(), "--set", "resolution=64"];
    let interior = "examples/scenes/interior.glb";
    let said = text(&render("pipelines/nebula.json", interior, &arguments).stderr);
    assert!(
        said.contains("warning[UG0811]") && said.contains("no pass of the pipeline reads the lights"),
        "{said}"
    );
    let said = text(&render("pipelines/awsm.json", interior, &arguments[..2]).stderr);
    assert!(!said.contains("UG0811"), "{said}");
    let said = text(&render("pipelines/nebula.json", COURTYARD, &arguments).stderr);
    assert!(!said.contains("UG0811"), "{said}");
}

#[test]
fn times_of_each_pass_are_told_and_traced() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-timings");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (out, trace) = (file("x-#.png"), file("trace.json"));
    let arguments =
        ["--out", &out, "--timings", "--trace", &trace, "--frames", "3", "--set", "resolution=64"];
    let said = fine(&render("pipelines/nebula.json", FIGURE, &arguments));
    let has_gpu = !said.contains("timestamp-query");
    for pass in ["eye", "casters", "shade", "sky", "present"] {
        let line = said.lines().find(|line| line.trim_start().starts_with(pass));
        let times = line.map_or(0, |line| line.matches(" ms").count());
        // What the GPU has no part in has one time.
        assert_eq!(times, if pass == "eye" || !has_gpu { 1 } else { 2 }, "{pass} in\n{said}");
    }
    let text = std::fs::read_to_string(folder.join("trace.json")).unwrap();
    let trace: serde_json::Value = serde_json::from_str(&text).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();
    let of = |name: &str, row: u64| {
        events
            .iter()
            .filter(|event| event["name"] == name && event["tid"] == row && event["ph"] == "X")
            .count()
    };
    assert_eq!((of("frame 2", 1), of("shade", 1), of("shade", 2)), (1, 3, if has_gpu { 3 } else { 0 }));
    let missing = folder.join("missing/trace.json");
    let arguments = ["--out", &out, "--frames", "2", "--trace", missing.to_str().unwrap()];
    rejected(&render("pipelines/learn/01-smallest.json", FIGURE, &arguments), 1, &["cannot be written"]);
}

#[test]
fn every_texture_of_a_pipeline_is_captured_and_its_range_told() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-capture-all");
    let out = folder.join("x.png");
    let inside = folder.join("all");
    std::fs::create_dir(&inside).unwrap();
    for (pipeline, scene, small, names) in [
        (
            "pipelines/mantis.json",
            COURTYARD,
            vec!["resolution=64"],
            vec!["atlas", "color", "depth", "target"],
        ),
        (
            "pipelines/awsm.json",
            "examples/scenes/interior.glb",
            vec!["cube_side=64", "cascade_side=64", "tile_max_side=64"],
            vec!["atlas", "color", "cubes", "depth", "layers", "target"],
        ),
    ] {
        let mut arguments = vec!["--out", out.to_str().unwrap(), "--capture-all", inside.to_str().unwrap()];
        arguments.extend(small.iter().flat_map(|setting| ["--set", setting]));
        let said = fine(&render(pipeline, scene, &arguments));
        for name in names {
            let path = inside.join(format!("{name}.png"));
            let (_, _, pixels) = png(&path);
            let (min, max) = (pixels.iter().step_by(4).min(), pixels.iter().step_by(4).max());
            assert!(min < max || name == "layers", "{pipeline}: {name} shows nothing");
            std::fs::remove_file(path).unwrap();
        }
        assert!(said.contains("depth, 64 by 36, range "), "{said}");
    }
    assert_eq!(std::fs::read_dir(&inside).unwrap().count(), 0, "nothing else is captured");
    // What a subgraph makes is captured as large as it is once the atlas has the size that its lights ask for.
    let capture = format!("blur_spots.rows={}", inside.join("rows.png").to_str().unwrap());
    let arguments = ["--out", out.to_str().unwrap(), "--capture", &capture, "--set", "moment_spots=true"];
    let said = fine(&render("pipelines/awsm.json", "examples/scenes/interior.glb", &arguments));
    assert!(said.contains("rows.png: blur_spots.rows, 2048 by 2048, red "), "{said}");
}

#[test]
fn a_part_of_a_capture_and_floats_as_exr() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-capture-part");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let captures =
        [format!("cubes:0,2={}", file("layer.png")), format!("cubes@point_casters={}", file("all.exr"))];
    let arguments = ["--out", &file("x.png"), "--set", "cube_side=64"];
    let arguments: Vec<&str> =
        arguments.into_iter().chain(captures.iter().flat_map(|one| ["--capture", one.as_str()])).collect();
    fine(&render("pipelines/awsm.json", "examples/scenes/interior.glb", &arguments));
    assert_eq!(png(&folder.join("layer.png")).0, 64);
    let exr = std::fs::read(folder.join("all.exr")).unwrap();
    assert_eq!(exr[..4], [0x76, 0x2f, 0x31, 0x01]);
    let faces = ["+x", "-x", "+y", "-y", "+z", "-z"];
    let passes: Vec<String> = (0..)
        .zip(faces)
        .map(|(at, face)| {
            format!(r#""face_{at}": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&sky", "face": "{face}" }}] }} }}"#)
        })
        .collect();
    let document = format!(
        r#"{{ "format": 1, "name": "sky",
            "resources": {{
              "sky": {{ "texture": {{ "format": "rgba8unorm", "size": [8, 8], "layers": 6, "view_dimension": "cube", "lifetime": "persistent" }} }},
              "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
            "passes": {{ {},
              "show": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target" }}] }} }} }} }}"#,
        passes.join(", ")
    );
    let pipeline = folder.join("sky.json");
    std::fs::write(&pipeline, document).unwrap();
    let captures = [format!("sky:0,,+x={}", file("face.png")), format!("sky={}", file("faces.png"))];
    let arguments = ["--out", &file("x.png"), "--capture", &captures[0], "--capture", &captures[1]];
    fine(&render(pipeline.to_str().unwrap(), FIGURE, &arguments));
    assert_eq!((png(&folder.join("face.png")).0, png(&folder.join("faces.png")).0), (8, 6 * 8 + 5 * 2));
}

#[test]
fn impossible_captures_are_told_at_once_and_nothing_is_written() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-capture-wrong");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let wrong = ["laiers", "eye", "color@directional_casters", "depth:3", "color", "layers:0,0,+x"]
        .map(|what| format!("{what}={}", file("c.png")));
    let missing = format!("target={}", file("missing/c.png"));
    let jpeg = format!("target={}", file("c.jpeg"));
    let mut arguments = vec!["--out".to_owned(), file("x.png"), "--feature".to_owned(), "msaa".to_owned()];
    arguments
        .extend(wrong.iter().chain([&missing, &jpeg]).flat_map(|one| ["--capture".to_owned(), one.clone()]));
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let output = render("pipelines/awsm.json", COURTYARD, &arguments);
    let says = [
        "did you mean \"layers\"?",
        "\"eye\" is ",
        "no pass \"directional_casters\" writes \"color\"",
        "\"color\" has 4 samples",
        "\"layers\" is no cube",
        "missing\" does not exist",
        ".png, .exr",
    ];
    rejected(&output, 1, &says);
    assert_eq!(std::fs::read_dir(folder.join("")).unwrap().count(), 0);
    let output = render("pipelines/awsm.json", COURTYARD, &["--out", &file("x.png"), "--capture", "depth"]);
    rejected(&output, 2, &["RESOURCE[@PASS]"]);
}

#[test]
fn frames_become_pictures_an_apng_or_a_gif_and_the_camera_moves() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-frames");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    for (name, camera) in [("a-##.png", "orbit"), ("a.apng", "walk"), ("a.gif", "orbit")] {
        let arguments = ["--frames", "3", "--fps", "2", "--camera", camera, "--out", &file(name)];
        let said = fine(&render("pipelines/nebula.json", FIGURE, &arguments));
        assert!(said.contains("3 frames of 64 by 36"), "{said}");
    }
    let frames = ["a-00.png", "a-01.png", "a-02.png"].map(|name| png(&folder.join(name)).2);
    assert!(frames[0] != frames[1] && frames[1] != frames[2]);
    let apng = std::fs::File::open(folder.join("a.apng")).unwrap();
    let reader = png::Decoder::new(std::io::BufReader::new(apng)).read_info().unwrap();
    assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
    assert_eq!(&std::fs::read(folder.join("a.gif")).unwrap()[..6], b"GIF89a");
    assert_eq!(std::fs::read_dir(folder.join("")).unwrap().count(), 5);
}

#[test]
fn one_frame_alone_has_the_format_of_its_file_as_many_have() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-one-frame");
    let begins = |name: &str| {
        let file = folder.join(name);
        fine(&render("pipelines/nebula.json", FIGURE, &["--out", file.to_str().unwrap()]));
        std::fs::read(file).unwrap()
    };
    assert!(begins("one.gif").starts_with(b"GIF89a"));
    let apng = begins("one.apng");
    assert!(apng.windows(4).any(|chunk| chunk == b"acTL"));
}

#[test]
fn a_camera_path_is_followed_or_what_is_wrong_with_it_told() {
    let folder = ScratchFolder::new("render-camera");
    let (keys, out) = (folder.join("path.json"), folder.join("x.png"));
    let run = |text: &str| {
        std::fs::write(&keys, text).unwrap();
        render(
            "pipelines/nebula.json",
            FIGURE,
            &["--camera", keys.to_str().unwrap(), "--out", out.to_str().unwrap()],
        )
    };
    for (text, says) in [
        (r#"{ "keys": [] }"#, "no keys"),
        (r#"{ "keys": [{ "time": 0, "position": [0, 1, 2], "target": [0, 1, 2] }] }"#, "looks nowhere"),
        (r#"{ "keys": [{ "time": 0, "position": [0, NaN, 2], "target": [0, 1, 2] }] }"#, "no camera path"),
        (
            r#"{ "keys": [{ "time": 0, "position": [0, 1e300, 2], "target": [0, 1, 2] }] }"#,
            "no camera can use",
        ),
        (r#"{ "keys": [{ "time": 0, "positoin": [0, 1, 2], "target": [0, 1, 2] }] }"#, "positoin"),
    ] {
        rejected(&run(text), 1, &[says, "UG0810"]);
        assert!(!out.exists());
    }
    if gpu::device().is_some() {
        fine(&run(r#"{ "keys": [{ "time": 0, "position": [0, 1, 4], "target": [0, 1, 0] }] }"#));
    }
}

#[test]
fn options_without_sense_are_named() {
    let folder = ScratchFolder::new("render-options");
    let out = folder.join("x.png");
    let out = out.to_str().unwrap();
    let run = |arguments: &[&str]| render("pipelines/nebula.json", FIGURE, arguments);
    rejected(&run(&["--out", out, "--at", "nan"]), 2, &["--at"]);
    rejected(&run(&["--out", out, "--time", "nan"]), 2, &["--at"]);
    rejected(&run(&["--out", out, "--fps", "0"]), 2, &["--fps"]);
    rejected(&run(&["--out", out, "--frames", "0"]), 2, &["--frames"]);
    rejected(&run(&["--out", out, "--frames", "2"]), 1, &["--frames", "frame-####.png"]);
    rejected(&run(&["--out", &out.replace(".png", ".bmp")]), 1, &["--out", ".png, .exr, .apng, .gif"]);
    assert_eq!(std::fs::read_dir(folder.join("")).unwrap().count(), 0);
}

/// Tests a lesson's own lighting, with a binding number that the template it extends also uses.
#[test]
fn bindings_of_the_library_move_aside_for_those_of_an_author() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-own-bindings");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let toon = std::fs::read_to_string(root().join("shaders-templates/toon.wgsl.jinja")).unwrap();
    let document = std::fs::read_to_string(root().join("pipelines/learn/32-own-lighting.json")).unwrap();
    let document =
        document.replace("../nebula.json", "umbragraph:nebula.json").replace("toon.wgsl", "own.wgsl");
    std::fs::write(folder.join("own.json"), document).unwrap();
    let axes = root().join("shaders-templates/toon.axes.json");
    std::fs::copy(axes, folder.join("own.axes.json")).unwrap();
    let (own, out, templates) = (file("own.json"), file("out.png"), file(""));
    let arguments = ["--out", &out, "--set", "resolution=64", "--templates", &templates];
    let picture = |attributes: &str| {
        let text = toon.replace("@group(1) @binding(20)", attributes);
        assert_ne!(text, toon.replace("@group(1) @binding(20)", ""));
        std::fs::write(folder.join("own.wgsl.jinja"), text).unwrap();
        fine(&render(&own, COURTYARD, &arguments));
        png(&folder.join("out.png"))
    };
    let wanted = picture("@group(1) @binding(20)");
    for attributes in [
        "@group(1) @binding(0)",
        "@binding(3) @group(1)",
        "@group( 1u )\n@binding( 4 )",
        "@group(0) @binding(0)",
    ] {
        assert!(picture(attributes) == wanted, "{attributes}");
    }
    // Places in the texts stay what they are.
    let text = toon.replace("binding(20)", "binding(0)").replace("* ceil(", "* cell(");
    let line = 1 + text.lines().position(|line| line.contains("cell(")).unwrap();
    std::fs::write(folder.join("own.wgsl.jinja"), text).unwrap();
    let said = text_of_check(&own, &templates);
    assert!(said.contains(&format!("own.wgsl.jinja:{line}:")) && said.contains("cell"), "{said}");
}

fn text_of_check(pipeline: &str, templates: &str) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    let output = command.args(["check", pipeline, "--templates", templates]).output().expect("the command");
    text(&output.stderr)
}

#[test]
fn nothing_but_diagnostics_stands_on_standard_error() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-quiet");
    let output =
        render("pipelines/nebula.json", COURTYARD, &["--out", folder.join("x.png").to_str().unwrap()]);
    fine(&output);
    assert_eq!(text(&output.stderr), "");
}

/// Writes a scene of `count` triangles over a floor, each with its own material, and a light of each kind. Returns its
/// path.
fn of_materials(folder: &Path, count: usize) -> String {
    let positions: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = positions.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
    std::fs::write(folder.join("triangle.bin"), &bytes).unwrap();
    let each = |one: &dyn Fn(usize) -> String| (0..count).map(one).collect::<Vec<_>>().join(", ");
    let light = |index: usize| {
        format!(
            r#"{{ "extensions": {{ "KHR_lights_punctual": {{ "light": {index} }} }}, "translation": [0, 3, 2], "rotation": [-0.6, 0, 0, 0.8] }}"#
        )
    };
    let document = format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "scene": 0, "scenes": [{{ "nodes": [{}] }}],
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {{ "KHR_lights_punctual": {{ "lights": [
                {{ "type": "directional", "intensity": 3 }},
                {{ "type": "spot", "intensity": 30, "spot": {{ "outerConeAngle": 0.7 }} }},
                {{ "type": "point", "intensity": 30 }} ] }} }},
            "buffers": [{{ "byteLength": {}, "uri": "triangle.bin" }}],
            "bufferViews": [{{ "buffer": 0, "byteLength": {} }}],
            "accessors": [{{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }}],
            "materials": [{}], "meshes": [{}], "nodes": [{}, {}, {}, {}] }}"#,
        (0..count + 3).map(|node| node.to_string()).collect::<Vec<_>>().join(", "),
        bytes.len(),
        bytes.len(),
        each(&|at| format!(
            r#"{{ "pbrMetallicRoughness": {{ "baseColorFactor": [0.{at}, 0.5, 0.5, 1] }}, "extras": {{ "receiveShadow": {} }} }}"#,
            at % 2 == 0
        )),
        each(&|at| format!(
            r#"{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "material": {at} }}] }}"#
        )),
        each(&|at| format!(
            r#"{{ "mesh": {at}, "translation": [{}, 0, {}] }}"#,
            at as f64 * 0.4 - 1.5,
            at as f64 * -0.3
        )),
        light(0),
        light(1),
        light(2),
    );
    let path = folder.join(format!("{count}.gltf"));
    std::fs::write(&path, document).unwrap();
    path.to_str().unwrap().to_owned()
}

fn files_below(folder: &Path) -> usize {
    let Ok(entries) = std::fs::read_dir(folder) else { return 0 };
    entries.flatten().map(|entry| if entry.path().is_dir() { files_below(&entry.path()) } else { 1 }).sum()
}

#[test]
fn nine_materials_need_no_more_shaders_than_one() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-materials");
    let compiled = |count: usize| {
        let scene = of_materials(&folder, count);
        let cache = folder.join(format!("cache-{count}"));
        let out = folder.join(format!("{count}.png"));
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
        command.args(["render", "pipelines/awsm.json", "--scene", &scene, "--size", "64x36"]);
        command.args(["--feature", "light_filter=pcss", "--feature", "contact_shadows"]);
        command.args([
            "--set",
            "moment_cascades=last",
            "--set",
            "local_light_radius=0.1",
            "--set",
            "sun_angle=0.01",
        ]);
        command.args(["--out", out.to_str().unwrap()]);
        // Mesa's own name for where compiled shaders are kept, a file for each.
        command.env("MESA_SHADER_CACHE_DIR", &cache).env_remove("MESA_SHADER_CACHE_DISABLE");
        fine(&command.current_dir(root()).output().expect("the command"));
        files_below(&cache)
    };
    let (one, nine) = (compiled(1), compiled(9));
    println!("{one} files for one material, {nine} for nine");
    if one == 0 {
        skip::skipped("a driver that keeps no compiled shaders");
        return;
    }
    assert_eq!(one, nine);
}
