//! WGSL's shader-creation errors: texts that break one rule each, with twins that keep it.
//!
//! The texts are in `wgsl/`, one on a line, under the section of the specification and the rule:
//!
//! - `-` begins a text that has to be refused, `+` one that has to pass: statements of a function with the parameters of
//!   [`WITHIN`]. `--` and `++` begin whole modules.
//! - `~` and `~~` begin what WGSL takes and naga does not: refused here, and no rule of ours.
//! - `⟦9|a#, ⟧` stands for its text nine times, with the numbers from 0 for `#` and from 1 for `#+`; `\0` for a null character.
//!
//! Where `tint`, Chrome's compiler, is installed, it has to say the same of each text.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use umbragraph_test_support::scratch::ScratchFolder;
use umbragraph_test_support::skip;

use naga::valid::Capabilities;

use crate::TargetProfile;
use crate::module::wgsl;

const WITHIN: &str =
    "const HIGH = 3.0;\nfn f(x: u32, y: u32, z: f32, i: i32, b: bool, v: vec4<f32>, m: mat4x4<f32>) {";

/// What a text is expected to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Expected {
    Refused,
    Valid,
    /// Valid, but naga does not know it.
    Newer,
}

pub(super) struct Case {
    /// The file and the line.
    place: String,
    /// The section and the rule.
    rule: String,
    pub(super) expected: Expected,
    pub(super) text: String,
}

pub(super) fn cases() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/tests/wgsl");
    let mut files: Vec<_> =
        std::fs::read_dir(&folder).expect("the corpus").map(|entry| entry.expect("a file").path()).collect();
    let number = |name: &str| name.split('-').next().and_then(|first| first.parse::<u32>().ok());
    files.sort_by_key(|path| path.file_name().and_then(|name| number(name.to_str()?)));
    let mut cases = Vec::new();
    for file in files {
        let name = file.file_name().expect("a name").to_string_lossy().into_owned();
        let mut rule = String::new();
        for (at, line) in std::fs::read_to_string(&file).expect("a text").lines().enumerate() {
            let place = format!("{name}:{}", at + 1);
            let (mark, text) = line.split_once(' ').unwrap_or_else(|| panic!("{place} is empty"));
            let text = expanded(text);
            let statements = || format!("{WITHIN} {text} }}\n");
            let (expected, text) = match mark {
                "#" => {
                    rule = text;
                    continue;
                }
                "-" => (Expected::Refused, statements()),
                "--" => (Expected::Refused, text),
                "+" => (Expected::Valid, statements()),
                "++" => (Expected::Valid, text),
                "~" => (Expected::Newer, statements()),
                "~~" => (Expected::Newer, text),
                _ => panic!("{place} has no mark"),
            };
            cases.push(Case { place, rule: rule.clone(), expected, text });
        }
    }
    cases
}

fn expanded(text: &str) -> String {
    let mut parts = text.split('⟦');
    let mut all = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (repeated, rest) = part.split_once('⟧').expect("an end");
        let (count, repeated) = repeated.split_once('|').expect("a count");
        for at in 0..count.parse::<u32>().expect("a count") {
            all.push_str(&repeated.replace("#+", &(at + 1).to_string()).replace('#', &at.to_string()));
        }
        all.push_str(rest);
    }
    all.replace("\\0", "\0").replace("\\u{feff}", "\u{feff}")
}

/// What `enable` switches on in the texts, besides what every browser has.
fn capabilities() -> Capabilities {
    TargetProfile::webgpu().capabilities | Capabilities::SHADER_FLOAT16 | Capabilities::DUAL_SOURCE_BLENDING
}

/// The reason to reject a text, and whether it is naga's.
pub(super) fn rejected(text: &str) -> Option<(String, bool)> {
    let naga = wgsl::guarded(|| Ok(wgsl::is_valid_for_naga(text, capabilities())));
    let is_naga = !naga.unwrap_or_default();
    let rejection = wgsl::with_stack(|| {
        let module = wgsl::parse(text)?;
        let info = wgsl::validate(&module, capabilities())?;
        wgsl::resolve_overrides(&module, &info, &naga::back::PipelineConstants::default()).map(drop)?;
        let beyond = wgsl::beyond_naga(&module).into_iter().find(|found| !found.warning);
        beyond.map_or(Ok(()), Err)
    });
    rejection.err().map(|rejection| (rejection.message, is_naga))
}

#[test]
fn texts_that_break_a_rule_are_refused_and_twins_pass() {
    let mut wrong = String::new();
    for Case { place, rule, expected, text } in cases() {
        let found = rejected(&text);
        if found.is_some() != (expected != Expected::Valid) {
            let text: String = text.strip_prefix(WITHIN).unwrap_or(&text).chars().take(200).collect();
            let _ = writeln!(wrong, "{place} ({rule}) {expected:?}, but {found:?}: {text}");
        }
    }
    assert!(wrong.is_empty(), "{}\n{wrong}", wrong.lines().count());
}

#[test]
fn chromes_compiler_says_the_same_of_the_texts() {
    if Command::new("tint").arg("--help").output().is_err() {
        skip::skipped("tint is not installed");
        return;
    }
    let folder = ScratchFolder::new("wgsl-rules");
    let path = folder.join("one.wgsl");
    let mut wrong = String::new();
    for Case { place, rule, expected, text } in cases() {
        std::fs::write(&path, text).expect("a file");
        let output = Command::new("tint")
            .args(["--format", "wgsl", "-o", "/dev/null"])
            .arg(&path)
            .output()
            .expect("a process");
        if output.status.success() != (expected != Expected::Refused) {
            let said = String::from_utf8_lossy(&output.stderr);
            let _ = writeln!(wrong, "{place} ({rule}) {expected:?}: {said}");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
