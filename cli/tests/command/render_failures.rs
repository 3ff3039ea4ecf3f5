//! `umbragraph render` where something goes wrong half way, or is asked of what is not there any more.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

const FIGURE: &str = "examples/scenes/figure.glb";

/// A pipeline whose picture is a copy of a copy of `first`. The resource `third` reuses the memory of `first`; `dead`
/// has no reader.
const CHAIN: &str = r#"{
  "format": 1, "name": "chain",
  "resources": {
    "first": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },
    "second": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },
    "third": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },
    "dead": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },
    "whole": { "texture": { "format": "rgba32uint", "size": "=viewport", "lifetime": "persistent" } },
    "bytes": { "buffer": { "size": 64, "lifetime": "persistent" } },
    "smooth": { "texture": { "format": "rgba8unorm", "size": "=viewport", "samples": 4 } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "paint": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&first" }] } },
    "again": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&first" }, "color": [{ "to": "&second" }] } },
    "darker": { "fullscreen": { "shader": "black.wgsl.jinja", "color": [{ "to": "&third" }] } },
    "mixed": { "fullscreen": { "shader": "sum.wgsl.jinja", "bind": { "a": "&second", "b": "&third" }, "color": [{ "to": "&target" }] } },
    "lost": { "copy": { "from": { "name": "&first" }, "to": { "name": "&dead" } } },
    "numbers": { "compute": { "shader": "numbers.wgsl.jinja", "dispatch_over": "&whole", "bind": { "image": "&whole" } } },
    "none": { "clear": { "buffer": "&bytes" } },
    "softened": { "side_effect": true, "fullscreen": {
      "shader": "gradient.wgsl.jinja", "color": [{ "to": "&smooth", "clear": [0, 0, 0, 1] }] } }
  }
}"#;

const TEMPLATES: [(&str, &str); 3] = [
    (
        "black.wgsl.jinja",
        "{% include 'lib/fullscreen.wgsl.jinja' %}
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(0.0, 0.0, 0.0, 1.0); }",
    ),
    (
        "sum.wgsl.jinja",
        "{% include 'lib/fullscreen.wgsl.jinja' %}
@group(1) @binding(0) var a: texture_2d<f32>;
@group(1) @binding(1) var b: texture_2d<f32>;
@fragment fn add(covered: Covered) -> @location(0) vec4<f32> {
    let texel = vec2<i32>(covered.position.xy);
    return textureLoad(a, texel, 0) + textureLoad(b, texel, 0);
}",
    ),
    (
        "numbers.wgsl.jinja",
        "@group(1) @binding(0) var image: texture_storage_2d<rgba32uint, write>;
@compute @workgroup_size(8, 8) fn number(@builtin(global_invocation_id) at: vec3<u32>) {
    textureStore(image, at.xy, vec4<u32>(at.x, 7u, 7u, 1u));
}",
    ),
];

fn chain(folder: &ScratchFolder, arguments: &[String]) -> Output {
    std::fs::write(folder.join("chain.json"), CHAIN).unwrap();
    for (name, text) in TEMPLATES {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.arg("render").arg(folder.join("chain.json")).arg("--templates").arg(folder.join(""));
    command.args(["--scene", FIGURE, "--size", "16x16", "--out"]).arg(folder.join("out.png"));
    command.args(arguments).current_dir(root()).output().expect("the command")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout)
}

fn texels(path: &Path) -> Vec<u8> {
    let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    bytes.truncate(info.buffer_size());
    bytes
}

#[test]
fn aliased_memory_is_captured_in_time_and_culled_says_why_not() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-failures-capture");
    let capture = |what: &str, file: &str| {
        ["--capture".to_owned(), format!("{what}={}", folder.join(file).to_str().unwrap())]
    };
    let pairs = ["first", "second", "third", "target@mixed", "whole"];
    let arguments: Vec<String> =
        (0..).zip(pairs).flat_map(|(at, what)| capture(what, &format!("{at}.png"))).collect();
    let output = chain(&folder, &arguments);
    assert!(output.status.success(), "{}", said(&output));
    let [first, second, third, mixed] = [0, 1, 2, 3].map(|at| texels(&folder.join(format!("{at}.png"))));
    assert!(first == second && first == mixed && first != third, "each as its pass left it");
    assert!(first.chunks(4).any(|texel| texel[0] > 200) && third.chunks(4).all(|texel| texel[..3] == [0; 3]));
    assert!(
        said(&output).contains("whole, 16 by 16, red 0 to 15, green 0 to 7, blue 0 to 7")
            || said(&output).contains("whole, 16 by 16, red 0 to 15"),
        "{}",
        said(&output)
    );
    // `first` gives its memory to `third`; a picture of a version is one of before the next.
    assert!(said(&output).contains("before \"darker\" overwrites it\n"), "{}", said(&output));
    let wrong = [
        capture("dead", "a.png"),
        capture("dead@lost", "b.png"),
        capture("bytes", "c.png"),
        capture("smooth", "d.png"),
    ];
    let output = chain(&folder, &wrong.concat());
    assert_eq!(output.status.code(), Some(1));
    for words in [
        "\"dead\" is culled",
        "why PIPELINE dead",
        "\"bytes\" is a buffer, of which there is no picture",
        "\"smooth\" has 4 samples",
    ] {
        assert!(said(&output).contains(words), "{words} is missing in {}", said(&output));
    }
    assert!(!folder.join("a.png").exists() && !folder.join("d.png").exists());
}

/// Simulates a full disk by a limit on the size of files: writing beyond the limit fails half way.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_up_leaves_no_half_file_and_what_was_there() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-failures-full");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    for (out, further) in [
        ("out.png", "--fast".to_owned()),
        ("out.apng", "--frames 4".to_owned()),
        ("out.gif", "--frames 4".to_owned()),
        (
            "small.gif",
            format!("--frames 2 --size 4x4 --set resolution=256 --capture maps={}", path("maps.exr")),
        ),
        ("small.gif", format!("--frames 40 --size 4x4 --trace {}", path("trace.json"))),
    ] {
        let named = path(out);
        let before = "what was there";
        let is_small = out.starts_with("small");
        if !is_small {
            std::fs::write(&named, before).unwrap();
        }
        let size = if is_small { "" } else { "--size 256x256" };
        // In blocks of 512 bytes: small pictures fit, and what is captured and traced of them does not.
        let line = format!(
            "trap '' XFSZ; ulimit -f 16; exec '{}' render pipelines/nebula.json --scene {FIGURE} --set resolution=64 {size} --out '{}' {further}",
            env!("CARGO_BIN_EXE_umbragraph"),
            path(out),
        );
        let output = Command::new("sh")
            .args(["-c", &line])
            .current_dir(root())
            .env("MESA_SHADER_CACHE_DISABLE", "1")
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(1), "{out} {further}: {}", said(&output));
        assert!(
            said(&output).contains("UG0004") && said(&output).contains("cannot be written"),
            "{}",
            said(&output)
        );
        let mut left: Vec<PathBuf> =
            std::fs::read_dir(folder.join("")).unwrap().map(|entry| entry.unwrap().path()).collect();
        if !is_small {
            assert_eq!(std::fs::read_to_string(&named).unwrap(), before, "{out}");
            left.retain(|path| *path != Path::new(&named));
            std::fs::remove_file(&named).unwrap();
        }
        left.retain(|path| path.file_name() != Some("small.gif".as_ref()));
        assert_eq!(left, Vec::<PathBuf>::new(), "{out} {further}");
    }
}

/// Tests that frames are written as they are rendered, so memory does not grow with their number.
#[cfg(target_os = "linux")]
#[test]
fn a_million_frames_take_the_memory_of_a_few() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-failures-million");
    let mut child = Command::new(env!("CARGO_BIN_EXE_umbragraph"))
        .args(["render", "pipelines/learn/01-smallest.json", "--scene", FIGURE, "--size", "8x8"])
        .args(["--frames", "1000000", "--out"])
        .arg(folder.join("out.gif"))
        .current_dir(root())
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let kilobytes = || {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap_or_default();
        line.trim().trim_end_matches(" kB").parse::<u64>().unwrap_or(0)
    };
    let written = || {
        let entries = std::fs::read_dir(folder.join("")).unwrap().flatten();
        entries.filter_map(|entry| entry.metadata().ok()).map(|metadata| metadata.len()).sum::<u64>()
    };
    let start = std::time::Instant::now();
    let wait = |bytes: u64| {
        while written() < bytes && start.elapsed().as_secs() < 60 {
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        kilobytes()
    };
    let (early, late) = (wait(2_000), wait(20_000));
    let bytes = written();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(bytes >= 20_000, "only {bytes} bytes in 60 s");
    assert!(early > 0 && late < early + early / 10, "{early} kB after a few frames, {late} kB after many");
    assert!(!folder.join("out.gif").exists(), "nothing stands under the name before all is there");
}

#[cfg(unix)]
#[test]
fn an_interrupted_animation_leaves_nothing() {
    if gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("render-failures-interrupt");
    for (name, signal) in [("a.apng", "-INT"), ("a.gif", "-TERM")] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
        command.args(["render", "pipelines/learn/01-smallest.json", "--scene", FIGURE, "--size", "64x64"]);
        command.args(["--frames", "1000000", "--out"]).arg(folder.join(name)).current_dir(root());
        let mut child = command.stderr(std::process::Stdio::null()).spawn().expect("the command");
        let count = || std::fs::read_dir(folder.join("")).unwrap().count();
        let start = std::time::Instant::now();
        while count() == 0 && start.elapsed().as_secs() < 60 {
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        assert_eq!(count(), 1, "the file under construction");
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill");
        assert!(sent.success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{name}");
        assert_eq!(count(), 0, "{name}");
    }
}

/// The command must reject a pipe without a writer, from which a read would never return.
#[cfg(unix)]
#[test]
fn pipes_in_place_of_captures_and_times_are_rejected() {
    let folder = ScratchFolder::new("render-failures-pipe");
    let pipe = folder.join("pipe.png");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo").success());
    for arguments in
        [["--timings", pipe.to_str().unwrap()], ["--captures", folder.join("").to_str().unwrap()]]
    {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
        command.args(["graph", "pipelines/learn/01-smallest.json", "--format", "html"]).args(arguments);
        let output = command.current_dir(root()).output().expect("the command");
        assert_eq!(output.status.code(), Some(1));
        assert!(said(&output).contains("it is no regular file"), "{}", said(&output));
    }
}
