//! `permutations.lock`: written, held, compared; and the words for each kind of change.

use std::process::{Command, Output};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use umbragraph_test_support::command::text;
use umbragraph_test_support::scratch::ScratchFolder;

const PIPELINE: &str = r#"{
  "format": 1, "name": "small", "profiles": ["webgpu", "webgpu-compat"],
  "features": { "warm": { "type": "bool", "default": false } },
  "parameters": {
    "look": { "type": "enum", "values": ["plain", "deep"], "default": "plain" },
    "taps": { "type": "u32", "default": 1, "min": 1, "max": 2 }
  },
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": {
    "fill": { "fullscreen": { "shader": "fill.wgsl.jinja", "color": [{ "to": "&target" }],
      "axes": { "look": "=look", "taps": "=taps" } } },
    "veil": { "fullscreen": { "shader": "veil.wgsl.jinja", "color": [{ "to": "&target", "blend": "add" }] } }
  }
}"#;
const AXES: &str = r#"{ "axes": {
  "look": { "type": "enum", "values": ["plain", "deep", "odd"], "default": "plain" },
  "taps": { "type": "integer", "min": 1, "max": 8, "default": 1 },
  "warm": { "type": "bool", "default": false } } }"#;
const TEMPLATE: &str = "@vertex fn corner(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(at & 1u) * 4.0 - 1.0, f32(at >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn fill() -> @location(0) vec4<f32> {
  return vec4<f32>({{ 1.0 if warm else 0.0 }}, {{ taps }}.0, {% if look == 'deep' %}0.5{% else %}0.0{% endif %}, 1.0);
}
";
const VEIL: &str = "@vertex fn corner(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(at & 1u) * 4.0 - 1.0, f32(at >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn veil() -> @location(0) vec4<f32> {
  return vec4<f32>(0.0, 0.0, 0.0, 1.0);
}
";

pub(super) struct Project {
    pub(super) folder: ScratchFolder,
}

impl Project {
    /// Creates a folder with a pipeline, its templates and its lock file.
    pub(super) fn new(name: &str) -> Self {
        let project = Self { folder: ScratchFolder::new(name) };
        for (file, text) in [
            ("small.json", PIPELINE),
            ("fill.axes.json", AXES),
            ("fill.wgsl.jinja", TEMPLATE),
            ("veil.wgsl.jinja", VEIL),
            ("veil.axes.json", "{ \"axes\": {} }"),
        ] {
            project.write(file, text);
        }
        project
    }

    fn locked(name: &str) -> Self {
        let project = Self::new(name);
        project.update();
        project
    }

    /// Adds a second pipeline beside the first.
    pub(super) fn with_other(self) -> Self {
        self.write("other.json", &self.read("small.json").replace("\"small\"", "\"other\""));
        self
    }

    pub(super) fn write(&self, file: &str, text: &str) {
        std::fs::write(self.folder.join(file), text).unwrap();
    }

    pub(super) fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.folder.join(file)).unwrap()
    }

    #[track_caller]
    pub(super) fn edit(&self, file: &str, from: &str, to: &str) {
        let text = self.read(file);
        assert!(text.contains(from), "{file} has no {from}");
        self.write(file, &text.replacen(from, to, 1));
    }

    pub(super) fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
        command.args(arguments).current_dir(&*self.folder).output().expect("the command")
    }

    fn permutations(&self, further: &[&str]) -> Output {
        let first = ["permutations", "small.json", "--templates", ".", "--no-cache"];
        self.run(&[&first, further].concat())
    }

    #[track_caller]
    fn update(&self) -> String {
        let output = self.permutations(&["--update"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stdout).to_string()
    }

    /// Returns the errors of `--locked`, each as `PLACE: MESSAGE`.
    #[track_caller]
    fn differences(&self) -> Vec<String> {
        let output = self.permutations(&["--locked", "--format", "json"]);
        let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let errors =
            document["diagnostics"].as_array().unwrap().iter().filter(|one| one["severity"] == "error");
        let said: Vec<String> = errors
            .map(|one| {
                assert_eq!(one["code"], "UG0818", "{one:#}");
                let place = &one["place"];
                format!(
                    "{}:{}: {}",
                    place["file"].as_str().unwrap(),
                    place["line"],
                    one["message"].as_str().unwrap()
                )
            })
            .collect();
        assert_eq!(output.status.code(), Some(i32::from(!said.is_empty())));
        said
    }
}

/// Parses the cases of `lock.txt`: a name, edits (file, text, replacement), and the expected errors of `--locked`.
fn cases() -> Vec<(String, Vec<[String; 3]>, Vec<String>)> {
    let cases = concat!("\n", include_str!("lock.txt")).split("\n== ").skip(1);
    let case = |case: &str| {
        let (name, lines) = case.split_once('\n').unwrap();
        let (mut edits, mut said): (Vec<[String; 3]>, Vec<String>) = Default::default();
        for line in lines.lines().filter(|line| !line.is_empty()) {
            let rest = line.get(2..).unwrap_or_default().replace("\\n", "\n");
            match line.get(..1) {
                Some("@") => edits.push([rest, String::new(), String::new()]),
                Some("-") => edits.last_mut().unwrap()[1] = rest,
                Some("+") => edits.last_mut().unwrap()[2] = rest,
                Some(">") => said.push(rest),
                _ => panic!("{line}"),
            }
        }
        (name.to_owned(), edits, said)
    };
    cases.map(case).collect()
}

#[test]
fn each_kind_of_change_has_its_words() {
    let (cases, next, wrong) = (cases(), AtomicUsize::new(0), Mutex::new(Vec::new()));
    assert!(cases.len() >= 25, "{}", cases.len());
    let work = || {
        while let Some((name, edits, expected)) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            let project = Project::locked(&format!("lock-{}", name.replace([' ', ','], "-")));
            for [file, from, to] in edits {
                project.edit(file, from, to);
            }
            let found = project.differences();
            if found != *expected {
                wrong.lock().unwrap().push(format!("{name}\n> {}", found.join("\n> ")));
            }
            project.update();
            assert_eq!(project.differences(), [""; 0], "--update solves it: {name}");
        }
    };
    std::thread::scope(|scope| (0..4).for_each(|_| drop(scope.spawn(work))));
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_lock_is_the_same_with_any_cache_and_threads() {
    let project = Project::new("lock-cache");
    let mut locks = Vec::new();
    for further in [
        &["--no-cache", "--threads", "1"][..],
        &["--no-cache", "--threads", "8"],
        &["--cache", "cache"],
        &["--cache", "cache"],
        &["--cache", "cache", "--verbose"],
    ] {
        let _ = std::fs::remove_file(project.folder.join("permutations.lock"));
        let first = ["permutations", "small.json", "--templates", ".", "--update"];
        let output = project.run(&[&first, further].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let lock = project.read("permutations.lock");
        assert!(lock.lines().count() < 40, "{lock}");
        locks.push(lock);
    }
    assert!(locks.windows(2).all(|pair| pair[0] == pair[1]), "{locks:#?}");
    // From another folder, too.
    std::fs::create_dir(project.folder.join("below")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args([
        "permutations",
        "../small.json",
        "--templates",
        "..",
        "--lock",
        "../again.lock",
        "--update",
    ]);
    assert!(command.current_dir(project.folder.join("below")).output().unwrap().status.success());
    assert_eq!(project.read("again.lock"), locks[0]);
}

#[test]
fn a_warm_cache_finds_each_difference() {
    let project = Project::locked("lock-warm");
    let locked =
        || project.run(&["permutations", "small.json", "--templates", ".", "--cache", "cache", "--locked"]);
    for _ in 0..2 {
        let output = locked();
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }
    project.edit("permutations.lock", "look = \"deep\", \"plain\"", "look = \"plain\"");
    for _ in 0..2 {
        let says = ["error[UG0818]", "axis look gained \"deep\"", "small.json:10", "permutations.lock:8"];
        umbragraph_test_support::command::rejected(&locked(), 1, &says);
    }
    let update = ["permutations", "small.json", "--templates", ".", "--cache", "cache", "--update"];
    for lock in ["", "version 7\n", "version 1\n"] {
        project.write("permutations.lock", lock);
        assert!(project.run(&update).status.success());
        assert_eq!(project.differences(), [""; 0]);
    }
}

#[test]
fn update_says_what_it_changes_and_keeps_other_pipelines() {
    let project = Project::locked("lock-update").with_other();
    assert_eq!(
        project.run(&["permutations", "other.json", "--templates", ".", "--update"]).status.code(),
        Some(0)
    );
    let both = project.read("permutations.lock");
    assert!(both.contains("\npipeline other.json\n") && both.contains("\npipeline small.json\n"), "{both}");
    assert!(project.update().ends_with("permutations.lock: unchanged\n"));
    assert_eq!(project.differences(), [""; 0], "the other pipeline is not held");
    project.edit("small.json", "[\"plain\", \"deep\"]", "[\"plain\"]");
    let said = project.update();
    let change = "small.json: pass \"fill\" for all profiles: axis look lost \"deep\": 8 -> 4 texts\n";
    assert!(said.ends_with(&format!("{change}permutations.lock: written\n")), "{said}");
    std::fs::remove_file(project.folder.join("other.json")).unwrap();
    let gone = "permutations.lock:5: the pipeline is gone, with 2 passes and 9 texts";
    assert_eq!(project.differences(), [gone]);
    project.update();
    assert!(!project.read("permutations.lock").contains("other.json"));
    project.edit("veil.wgsl.jinja", "0.0, 0.0, 0.0, 1.0", "oops");
    let before = project.read("permutations.lock");
    let output = project.permutations(&["--update"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("permutations.lock is left as it is, because of errors"));
    assert_eq!(project.read("permutations.lock"), before);
}

#[test]
fn a_lock_that_cannot_be_read_is_solved_by_update() {
    let project = Project::locked("lock-conflict").with_other();
    let good = project.read("permutations.lock");
    let conflict = good.replacen("  look", "<<<<<<< HEAD\n  look", 1).replacen(
        "  taps",
        "=======\n>>>>>>> branch\n  taps",
        1,
    );
    for (lock, says) in [
        (conflict.clone(), "\"<<<<<<< HEAD\" marks a merge conflict"),
        (good.replace("version 1", "version 2"), "the lock has version 2, and this program writes version 1"),
        (good.replace("texts 8", "texts x"), "is not a valid line of a lock"),
        (String::new(), "no line says \"version 1\""),
    ] {
        project.write("permutations.lock", &lock);
        let output = project.permutations(&["--locked"]);
        umbragraph_test_support::command::rejected(&output, 1, &["error[UG0819]", says, "--update"]);
        project.update();
        assert_eq!(project.read("permutations.lock"), good);
    }
    project.write("permutations.lock", &conflict);
    let output = project.run(&["permutations", "other.json", "--templates", ".", "--update"]);
    let says = ["error[UG0819]", "marks a merge conflict", "name these pipelines too: small.json"];
    umbragraph_test_support::command::rejected(&output, 1, &says);
    assert_eq!(project.read("permutations.lock"), conflict);
    std::fs::remove_file(project.folder.join("permutations.lock")).unwrap();
    let output = project.permutations(&["--locked"]);
    umbragraph_test_support::command::rejected(
        &output,
        1,
        &["error[UG0818]", "there is no lock \"permutations.lock\""],
    );
}

#[test]
fn changes_of_two_passes_merge() {
    let project = Project::locked("lock-merge");
    let base = project.read("permutations.lock");
    let pass = |lock: &str, name: &str| -> String {
        let sections = lock.split("\n\n").find(|section| section.starts_with(name));
        sections.unwrap_or_else(|| panic!("{lock}")).to_owned()
    };
    project.edit("veil.wgsl.jinja", "0.0, 0.0, 0.0, 1.0", "0.5, 0.0, 0.0, 1.0");
    project.update();
    let theirs = project.read("permutations.lock");
    project.edit("fill.wgsl.jinja", "@fragment", "// A note.\n@fragment");
    project.update();
    let merged =
        theirs.replace(&pass(&base, "pass fill"), &pass(&project.read("permutations.lock"), "pass fill"));
    assert_eq!(project.read("permutations.lock"), merged, "each pass has lines of its own");
}

#[test]
fn diff_says_what_a_lock_gained() {
    let project = Project::locked("lock-diff");
    project.write("before.lock", &project.read("permutations.lock"));
    let diff = |after: &str| project.run(&["diff", "--lock", "before.lock", after]);
    assert_eq!(text(&diff("permutations.lock").stdout), "the locks are the same\n");
    project.edit("small.json", "\"max\": 2 }", "\"max\": 8 }");
    project.update();
    let output = diff("permutations.lock");
    assert_eq!(output.status.code(), Some(0));
    let line = "small.json: pass \"fill\" for all profiles: axis taps gained 3..8: 8 -> 32 texts\n";
    assert_eq!(text(&output.stdout), line);
    umbragraph_test_support::command::rejected(&diff("none.lock"), 1, &["there is no lock \"none.lock\""]);
    project.write("bad.lock", "<<<<<<< HEAD");
    umbragraph_test_support::command::rejected(
        &diff("bad.lock"),
        1,
        &["UG0819", "bad.lock:1", "merge conflict"],
    );
}

#[test]
fn a_lock_wants_all_that_is_reached() {
    let project = Project::new("lock-part");
    for part in [
        &["--config"][..],
        &["--all"],
        &["--feature", "warm"],
        &["--set", "taps=2"],
        &["--profile", "webgpu"],
    ] {
        for mode in ["--locked", "--update"] {
            let output = project.permutations(&[&[mode], part].concat());
            assert_eq!(output.status.code(), Some(2), "{part:?}: {}", text(&output.stderr));
        }
    }
    assert_eq!(project.permutations(&["--locked", "--update"]).status.code(), Some(2));
    assert_eq!(project.permutations(&["--lock", "other.lock"]).status.code(), Some(2));
    let missing = project.permutations(&["--locked", "--lock", "other.lock"]);
    let says = ["there is no lock \"other.lock\"", "--update --lock other.lock` writes it; commit it"];
    umbragraph_test_support::command::rejected(&missing, 1, &says);
}
