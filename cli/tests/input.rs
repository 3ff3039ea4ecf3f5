//! What documents may read, what is no regular file, and what names say to a terminal.
#![cfg(unix)]

use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use umbragraph_test_support::scratch::ScratchFolder;

const SMALLEST: &str = r#"{
  "format": 1, "name": "smallest", "profiles": ["webgpu"],
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "viewport", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "target" }] } } }
}"#;

/// Runs the command in a folder, for so long as nothing should take.
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
fn documents_read_below_the_working_folder_their_own_and_the_roots_given() {
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

/// Whether a text commands a terminal, or turns the order of its letters.
fn commands(text: &str) -> bool {
    let is_bidirectional =
        |c: char| matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    text.chars().any(|c| c.is_control() && c != '\n' && c != '\t' || is_bidirectional(c))
}

#[test]
fn names_and_excerpts_command_no_terminal() {
    let folder = ScratchFolder::new("input-escapes");
    let here = folder.join("");
    // As JSON escapes, and as they are.
    let evil = "\\u001b]0;title\\u0007\\u202e\\u009b31m";
    let raw = "\u{202e}\u{2066}\u{9b}31m\u{7f}";
    let broken = SMALLEST
        .replace("\"fill\"", &format!("\"fi{evil}{raw}ll\""))
        .replace("gradient", &format!("g{evil}{raw}"));
    std::fs::write(folder.join("broken.json"), broken).unwrap();
    let described = SMALLEST.replace(
        "\"fill\": {",
        &format!("\"fill\": {{ \"description\": \"{evil}{raw}\", \"when\": \"soft\","),
    );
    let described = described.replace(
        "\"resources\"",
        &format!(
            "\"features\": {{ \"soft\": {{ \"type\": \"bool\", \"default\": true, \"description\": \"{evil}{raw}\" }} }}, \"resources\""
        ),
    );
    std::fs::write(folder.join("fine.json"), described.replace("smallest", &format!("s{evil}{raw}")))
        .unwrap();
    let named = format!("na\u{1b}[31mme{raw}.json");
    std::fs::write(folder.join(&named), "{").unwrap();
    let mut shown = 0;
    for arguments in [
        &["check", "broken.json"][..],
        &["check", "broken.json", "--format", "json"],
        &["check", "broken.json", "--format", "github"],
        &["check", "broken.json", "--format", "sarif"],
        &["permutations", "broken.json"],
        &["permutations", "broken.json", "--format", "json"],
        &["check", &named],
        &["fmt", "--check", &named],
        &["plan", "fine.json"],
        &["graph", "fine.json", "--format", "json"],
        &["why", "fine.json", "fill"],
        &["why", "fine.json", "fill", "--format", "json"],
        &["why", "fine.json", "soft"],
        &["why", "fine.json", &format!("no{raw}")],
        &["diff", "fine.json", "broken.json"],
        &["reference", &format!("UG{raw}")],
        &["check", "fine.json", "--set", &format!("no{raw}=1")],
        &["check", "fine.json", &format!("--no{raw}")],
        &["render", "fine.json", "--scene", &named, "--out", &named],
    ] {
        let output = run(&here, arguments);
        let said = errors(&output) + &String::from_utf8_lossy(&output.stdout);
        assert!(!commands(&said), "{arguments:?}: {said:?}");
        shown += usize::from(said.contains("u{202e}") || said.contains("u202e"));
    }
    assert!(shown >= 12, "only {shown} of the commands show what they name");
}
