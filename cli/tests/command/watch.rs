//! `umbragraph watch` beside an editor.

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use umbragraph_test_support::scratch::ScratchFolder;

const PIPELINE: &str = r#"{
  "format": 1,
  "name": "watched",
  "resources": {
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } }
  }
}
"#;

struct Watch {
    child: Child,
    lines: Receiver<String>,
}

impl Watch {
    fn begin(folder: &ScratchFolder, more: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
        command.current_dir(folder).args(["watch", "frame.json"]).args(more);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("the command");
        let output = BufReader::new(child.stdout.take().expect("piped"));
        let (send, lines) = channel();
        std::thread::spawn(move || output.lines().map_while(Result::ok).try_for_each(|line| send.send(line)));
        Self { child, lines }
    }

    /// Returns the output lines up to the next summary.
    #[track_caller]
    fn said(&self) -> Vec<String> {
        let mut said = Vec::new();
        loop {
            let line = self.lines.recv_timeout(Duration::from_secs(60)).expect("a line");
            let is_end = line.starts_with("checked: ");
            said.push(line);
            if is_end {
                return said;
            }
        }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn watch_prints_only_files_with_other_diagnostics() {
    let folder = ScratchFolder::new("watch_prints_only");
    let file = folder.join("frame.json");
    std::fs::write(&file, PIPELINE).unwrap();
    let watch = Watch::begin(&folder, &["--config"]);
    let first = watch.said();
    assert!(first.len() == 1 && first[0].starts_with("checked: 0 errors, 0 warnings in "), "{first:?}");
    std::fs::write(&file, PIPELINE.replace("&target", "&tagret")).unwrap();
    let broken = watch.said();
    assert_eq!(broken[0], "watch: frame.json");
    assert!(broken[1].starts_with("frame.json:8:82: error[UG"), "{broken:?}");
    assert!(broken[1].contains("tagret") && broken[1].contains("did you mean"), "{broken:?}");
    // A comment moves the error, so that its file is printed again; one behind it says nothing new.
    std::fs::write(&file, format!("// moved\n{}", PIPELINE.replace("&target", "&tagret"))).unwrap();
    let moved = watch.said();
    assert!(moved[1].starts_with("frame.json:9:82: error[UG"), "{moved:?}");
    std::fs::write(&file, format!("// moved\n{}\n// behind\n", PIPELINE.replace("&target", "&tagret")))
        .unwrap();
    let same = watch.lines.recv_timeout(Duration::from_secs(2));
    assert!(same.is_err(), "{same:?}");
    let other = folder.join("frame.tmp");
    std::fs::write(&other, PIPELINE).unwrap();
    std::fs::rename(other, &file).unwrap();
    let mended = watch.said();
    assert_eq!(mended[0], "watch: frame.json is fine");
    assert!(mended.len() == 2 && mended[1].starts_with("checked: 0 errors"), "{mended:?}");
}

#[test]
fn watch_writes_the_picture_after_each_good_change() {
    if umbragraph_test_support::gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("watch_writes_the_picture");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/scenes/courtyard.glb");
    std::fs::write(folder.join("frame.json"), PIPELINE).unwrap();
    let watch =
        Watch::begin(&folder, &["--config", "--render", "out.png", "--scene", scene, "--size", "32x24"]);
    watch.said();
    let picture = || std::fs::read(folder.join("out.png")).unwrap();
    let first = picture();
    std::fs::write(folder.join("frame.json"), PIPELINE.replace("&target", "&tagret")).unwrap();
    watch.said();
    assert!(picture() == first, "a broken pipeline leaves the picture");
    let twice = PIPELINE.replace(
        "\"&target\" }] } }",
        "\"&target\" }] } },\n    \"add\": { \"fullscreen\": { \"shader\": \"gradient.wgsl.jinja\", \"color\": [{ \"to\": \"&target\", \"blend\": \"add\" }] } }",
    );
    std::fs::write(folder.join("frame.json"), twice).unwrap();
    let said = watch.said();
    assert!(picture() != first, "{said:?}");
}

#[test]
fn watch_draws_again_when_a_buffer_of_the_scene_changes() {
    if umbragraph_test_support::gpu::device().is_none() {
        return;
    }
    let folder = ScratchFolder::new("watch_draws_again");
    std::fs::write(folder.join("frame.json"), PIPELINE).unwrap();
    let scene = r#"{ "asset": { "version": "2.0" }, "buffers": [{ "uri": "mesh.bin", "byteLength": 12 }] }"#;
    std::fs::write(folder.join("scene.gltf"), scene).unwrap();
    let watch = Watch::begin(
        &folder,
        &["--config", "--render", "out.png", "--scene", "scene.gltf", "--size", "32x24"],
    );
    let missing = watch.said();
    assert!(missing.iter().any(|line| line.contains("mesh.bin")), "{missing:?}");
    std::fs::write(folder.join("mesh.bin"), [0; 12]).unwrap();
    let fine = watch.said();
    assert!(fine.last().unwrap().starts_with("checked: 0 errors"), "{fine:?}");
    assert!(folder.join("out.png").is_file());
    std::fs::write(folder.join("mesh.bin"), [0; 4]).unwrap();
    let short = watch.said();
    assert!(short.iter().any(|line| line.contains("error[UG")), "{short:?}");
}
