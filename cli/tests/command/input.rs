//! The files that documents may read, paths that are no regular files, and names that would control a terminal.
#![cfg(unix)]

use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use umbragraph_test_support::scratch::ScratchFolder;

const SMALLEST: &str = r#"{
  "format": 1, "name": "smallest", "profiles": ["webgpu"],
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } } }
}"#;

/// Runs the command in a folder, with a time limit that no input should exceed.
#[track_caller]
fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_umbragraph"))
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("{arguments:?} waits for ever");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.wait_with_output().unwrap()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn pipe(folder: &ScratchFolder, name: &str) -> PathBuf {
    let path = folder.join(name);
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    path
}

#[test]
fn devices_and_pipes_are_no_files_wherever_they_are_named() {
    let folder = ScratchFolder::new("input-devices");
    let here = folder.join("");
    std::fs::write(folder.join("smallest.json"), SMALLEST).unwrap();
    std::fs::create_dir(folder.join("templates")).unwrap();
    pipe(&folder, "pipe.json");
    pipe(&folder, "templates/gradient.wgsl.jinja");
    symlink("/dev/zero", folder.join("zero.json")).unwrap();
    for name in ["pipe.json", "zero.json", "/dev/zero"] {
        let with = |key: &str, value: String| {
            let text = SMALLEST.replace("\"format\": 1,", &format!("\"format\": 1, \"{key}\": {value},"));
            std::fs::write(folder.join("with.json"), text).unwrap();
            errors(&run(&here, &["check", "with.json"]))
        };
        let user = SMALLEST
            .replace("\"passes\": {", &format!("\"passes\": {{ \"part\": {{ \"use\": \"{name}\" }},"));
        std::fs::write(folder.join("uses.json"), user).unwrap();
        let named = [
            errors(&run(&here, &["check", name])),
            errors(&run(&here, &["fmt", "--check", name])),
            errors(&run(&here, &["check", "smallest.json", "--params", name])),
            errors(&run(&here, &["check", "smallest.json", "--extension", name])),
        ];
        for said in &named {
            assert!(said.contains("UG0001") && said.contains("no regular file"), "{name}: {said}");
        }
        // What lies elsewhere is not looked at at all.
        let code = if name == "pipe.json" { "UG0001" } else { "UG0010" };
        let by_documents = [
            with("include", format!("[\"{name}\"]")),
            with("extends", format!("\"{name}\"")),
            errors(&run(&here, &["check", "uses.json"])),
        ];
        for said in &by_documents {
            assert!(said.contains(code), "{name}: {said}");
        }
    }
    let said = errors(&run(&here, &["check", "smallest.json", "--templates", "templates"]));
    assert!(said.contains("UG0001") && said.contains("no regular file"), "{said}");
}

#[test]
fn documents_read_only_below_their_roots() {
    let folder = ScratchFolder::new("input-roots");
    for name in ["own", "other", "elsewhere", "templates"] {
        std::fs::create_dir(folder.join(name)).unwrap();
    }
    std::fs::write(folder.join("own/near.json"), SMALLEST).unwrap();
    std::fs::write(folder.join("other/base.json"), SMALLEST).unwrap();
    std::fs::write(folder.join("other/secret.json"), "secret words, and no JSON").unwrap();
    symlink(folder.join("other/base.json"), folder.join("own/link.json")).unwrap();
    symlink(folder.join("other/secret.json"), folder.join("templates/gradient.wgsl.jinja")).unwrap();
    let check = |from: &str, base: &str, further: &[&str]| {
        let text =
            format!("{{ \"format\": 1, \"name\": \"top\", \"extends\": \"{base}\", \"passes\": {{}} }}");
        std::fs::write(folder.join("own/top.json"), text).unwrap();
        let top = folder.join("own/top.json");
        let arguments = [&["check", top.to_str().unwrap()], further].concat();
        run(&folder.join(from), &arguments)
    };
    let root = folder.join("other");
    for (from, base, further) in [
        ("elsewhere", "near.json", &[][..]),
        ("elsewhere", "../own/near.json", &[]),
        ("other", "../other/base.json", &[]),
        ("other", "link.json", &[]),
        ("", "../other/base.json", &[]),
        ("elsewhere", "../other/base.json", &["--root", root.to_str().unwrap()]),
        ("elsewhere", "link.json", &["--root", "../other"]),
    ] {
        let output = check(from, base, further);
        assert!(output.status.success(), "{base} from {from:?}: {}", errors(&output));
    }
    for base in
        ["../other/base.json", "../other/secret.json", "../other/nothing.json", "link.json", "/etc/hostname"]
    {
        for format in ["human", "json", "github", "sarif"] {
            let output = check("elsewhere", base, &["--format", format]);
            let said = errors(&output) + &String::from_utf8_lossy(&output.stdout);
            assert_eq!(output.status.code(), Some(1), "{base}: {said}");
            assert!(said.contains("UG0010") && !said.contains("secret words"), "{base}: {said}");
            assert!(format != "human" || !said.contains("exist"), "{base}: {said}");
        }
    }
    let templates = folder.join("templates");
    let arguments = ["check", "near.json", "--templates", templates.to_str().unwrap()];
    let said = errors(&run(&folder.join("own"), &arguments));
    assert!(said.contains("UG0010") && !said.contains("secret words"), "{said}");
    let said = errors(&run(&folder.join("own"), &["check", "near.json", "--root", "nowhere"]));
    assert!(said.contains("there is no folder \"nowhere\""), "{said}");
}

#[test]
fn a_colon_in_the_name_of_a_folder_is_no_scheme() {
    let folder = ScratchFolder::new("input-colon");
    std::fs::create_dir_all(folder.join("ab:c/d:ef")).unwrap();
    std::fs::write(folder.join("ab:c/base.json"), SMALLEST).unwrap();
    let part = r#"{ "inputs": { "to": "a texture" }, "passes": { "again": { "after": [], "fullscreen": {
        "shader": "gradient.wgsl.jinja", "color": [{ "to": "&to", "blend": "add" }] } } } }"#;
    std::fs::write(folder.join("ab:c/d:ef/part.json"), part.replace("\"after\": [], ", "")).unwrap();
    let more = r#"{ "parameters": { "size": { "type": "f32", "default": 1 } } }"#;
    std::fs::write(folder.join("ab:c/d:ef/more.json"), more).unwrap();
    let main = r#"{ "format": 1, "name": "main", "extends": "base.json", "include": ["d:ef/more.json"],
        "passes": { "part": { "use": "d:ef/part.json", "after": ["fill"], "with": { "to": "&target" } } } }"#;
    std::fs::write(folder.join("ab:c/main.json"), main).unwrap();
    for (from, path) in [("", "ab:c/main.json"), ("ab:c", "main.json"), ("ab:c/d:ef", "../main.json")] {
        let output = run(&folder.join(from), &["check", path]);
        assert!(output.status.success(), "{path} from {from:?}: {}", errors(&output));
    }
    // What comes with the module still has one.
    std::fs::write(folder.join("own.json"), main.replace("base.json", "umbragraph:nebula.json")).unwrap();
    let said = errors(&run(&folder.join(""), &["check", "own.json"]));
    assert!(!said.contains("nebula.json\" cannot be read") && said.contains("d:ef/more.json"), "{said}");
}

/// Returns `true` if a text contains terminal control characters or changes the text direction.
fn commands(text: &str) -> bool {
    let is_bidirectional =
        |c: char| matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    text.chars().any(|c| c.is_control() && c != '\n' && c != '\t' || is_bidirectional(c))
}

/// Tests texts from files and arguments in the output of every command and format.
#[test]
fn names_and_excerpts_command_no_terminal() {
    let folder = ScratchFolder::new("input-escapes");
    let here = folder.join("");
    // As JSON escapes, and as they are.
    let evil = "\\u001b]0;title\\u0007\\u202e\\u009b31m";
    let raw = "\u{202e}\u{2066}\u{9b}31m\u{7f}";
    let broken = SMALLEST
        .replace("\"fill\"", &format!("\"fi{evil}{raw}ll\""))
        .replace(
            "\"target\": {",
            &format!("\"ta{evil}{raw}\": {{ \"buffer\": {{ \"size\": 4 }} }}, \"target\": {{"),
        )
        .replace("gradient", &format!("g{evil}{raw}"));
    std::fs::write(folder.join("broken.json"), broken).unwrap();
    let described = SMALLEST.replace(
        "\"fill\": {",
        &format!("\"fill\": {{ \"description\": \"{evil}{raw}\", \"when\": \"=soft\", \"toggle\": \"lit\","),
    );
    let described = described.replace(
        "\"resources\"",
        &format!(
            r#""features": {{ "soft": {{ "type": "bool", "default": true, "description": "{evil}{raw}" }} }},
               "parameters": {{ "size": {{ "type": "f32", "default": 1, "description": "{evil}{raw}" }} }},
               "toggles": {{ "lit": {{ "default": true, "description": "{evil}{raw}" }} }},
               "presets": {{ "high": {{ "description": "{evil}{raw}", "parameters": {{ "size": 2 }} }} }},
               "constraints": {{ "small": {{ "holds": "=size > 9", "message": "{evil}{raw}", "severity": "warning" }} }},
               "resources""#
        ),
    );
    let described = described.replace(
        "\"passes\": {",
        "\"passes\": { \"base\": { \"fullscreen\": { \"shader\": \
        \"gradient.wgsl.jinja\", \"color\": [{ \"to\": \"&target\", \"contents\": \"discard\" }] } },",
    );
    let described = described.replace("\"when\": \"=soft\"", "\"after\": [\"base\"], \"when\": \"=soft\"");
    std::fs::write(folder.join("fine.json"), described.replace("smallest", &format!("s{evil}{raw}")))
        .unwrap();
    let named = format!("na\u{1b}[31mme{raw}.json");
    std::fs::write(folder.join(&named), "{").unwrap();
    let scene = format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "scene": 7, "nodes": [{{ "name": "{evil}{raw}", "mesh": 5 }}] }}"#
    );
    std::fs::write(folder.join("scene.gltf"), scene).unwrap();
    let wrong = [format!("no{raw}"), format!("no{raw}=1"), format!("--no{raw}"), format!("UG{raw}")];
    let [no, set, option, code] = wrong.each_ref().map(String::as_str);
    let of = |command: &'static str| [command, "fine.json"];
    let lines: Vec<Vec<&str>> = [
        &["check", "broken.json"][..],
        &["check", "broken.json", "--format", "json"],
        &["check", "broken.json", "--format", "github"],
        &["check", "broken.json", "--format", "sarif"],
        &["check", "broken.json", "--fix", "--dry-run"],
        &of("check"),
        &["check", "fine.json", "--format", "json"],
        &["check", "fine.json", "--format", "sarif", "--verify"],
        &["permutations", "broken.json"],
        &["permutations", "broken.json", "--format", "json"],
        &["permutations", "fine.json", "--all"],
        &["permutations", "fine.json", "--format", "github", "--all"],
        &["check", &named],
        &["fmt", "--check", &named],
        &["fmt", "--strict", "fine.json"],
        &of("plan"),
        &["plan", "broken.json"],
        &["graph", "fine.json", "--format", "svg"],
        &["graph", "fine.json", "--format", "html"],
        &["graph", "fine.json", "--format", "dot"],
        &["graph", "fine.json", "--format", "mermaid"],
        &["graph", "fine.json", "--format", "json"],
        &["graph", "fine.json", "--out", no],
        &["why", "fine.json", "fill"],
        &["why", "fine.json", "fill", "--format", "json"],
        &["why", "fine.json", "soft"],
        &["why", "fine.json", "size"],
        &["why", "fine.json", "lit"],
        &["why", "fine.json", no],
        &["diff", "fine.json", "broken.json"],
        &["diff", "fine.json", "fine.json", "--after-set", set],
        &["reference", code],
        &["reference", no],
        &["schema", "--of", no],
        &["wgsl", "fine.json", "--pass", no],
        &["wgsl", "broken.json"],
        &["check", "fine.json", "--set", set],
        &["check", "fine.json", "--preset", no],
        &["check", "fine.json", "--params", no],
        &["check", "fine.json", "--extension", no],
        &["check", "fine.json", "--profile", no],
        &["check", "fine.json", "--root", no],
        &["check", "fine.json", "--templates", no],
        &["check", "fine.json", option],
        &[no],
        &["render", "fine.json", "--scene", &named, "--out", &named],
        &["render", "fine.json", "--scene", "scene.gltf", "--out", "out.png"],
        &["render", "fine.json", "--scene", "scene.gltf", "--out", "out.png", "--camera", no],
        &["score", "fine.json", "--scene", "scene.gltf"],
        &["score", "fine.json", "--scene", &named, "--limits", no],
    ]
    .iter()
    .map(|line| line.to_vec())
    .collect();
    let shows = |arguments: &Vec<&str>| {
        let output = run(&here, arguments);
        let said = errors(&output) + &String::from_utf8_lossy(&output.stdout);
        assert!(!commands(&said), "{arguments:?}: {said:?}");
        said.contains("u{202e}") || said.contains("u202e")
    };
    let shown: usize = std::thread::scope(|scope| {
        let count = |lines: &[Vec<&str>]| lines.iter().filter(|line| shows(line)).count();
        let some = lines.chunks(13).map(|lines| scope.spawn(move || count(lines))).collect::<Vec<_>>();
        some.into_iter().map(|some| some.join().expect("no raw character")).sum()
    });
    assert!(shown >= 30, "only {shown} of the commands show what they name");
}
