//! WGSL's shader-creation errors: texts that break one rule each, with twins that keep it.
//!
//! The texts are in `wgsl/`, one on a line, under the chapter of the specification and the rule:
//!
//! - `-` begins a text that has to be refused, `+` one that has to pass: statements of a function with the parameters
//!   of [`WITHIN`]. `--` and `++` begin whole modules.
//! - `~` and `~~` begin what WGSL takes and naga does not: refused here, and no rule of ours.
//! - `⟦9|a#, ⟧` stands for its text nine times, with the numbers from 0 for `#` and from 1 for `#+`; `\0` for a
//!   null character, `\u{200d}` for any other.
//!
//! If `tint`, Chrome's compiler, is installed, it has to say the same of each text.

use std::fmt::Write as _;
use std::path::Path;

use umbragraph_test_support::scratch::ScratchFolder;

use naga::valid::Capabilities;

use super::tint;
use crate::TargetProfile;
use crate::module::wgsl;
use crate::written::rejection::Rejection;

const WITHIN: &str =
    "const HIGH = 3.0;\nfn f(x: u32, y: u32, z: f32, i: i32, b: bool, v: vec4<f32>, m: mat4x4<f32>) {";

/// The expected result for a WGSL module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Expected {
    Refused,
    Valid,
    /// The module is valid, but naga does not support a feature that it uses.
    Newer,
}

pub(super) struct Case {
    /// The file name and line number of the case.
    place: String,
    /// The chapter of the WGSL specification and the rule.
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
    let mut parts = all.split("\\u{");
    let mut text = parts.next().unwrap_or_default().replace("\\0", "\0");
    for part in parts {
        let (code, rest) = part.split_once('}').expect("an end");
        let code = u32::from_str_radix(code, 16).expect("a number");
        text.push(char::from_u32(code).expect("a character"));
        text.push_str(&rest.replace("\\0", "\0"));
    }
    text
}

/// The capabilities of the `webgpu` profile, and those that the cases enable with `enable`.
fn capabilities() -> Capabilities {
    TargetProfile::webgpu().capabilities | Capabilities::SHADER_FLOAT16 | Capabilities::DUAL_SOURCE_BLENDING
}

/// Returns the reason to reject a module, and whether naga itself rejects it. `None` if the module is valid.
pub(super) fn rejected(text: &str) -> Option<(Rejection, bool)> {
    let naga = wgsl::guarded(|| Ok(wgsl::is_valid_for_naga(text, capabilities())));
    let is_naga = !naga.unwrap_or_default();
    let rejection = wgsl::with_stack(|| {
        let module = wgsl::parse(text)?;
        let info = wgsl::validate(&module, capabilities())?;
        wgsl::resolve_overrides(&module, &info, &naga::back::PipelineConstants::default()).map(drop)?;
        let beyond = wgsl::beyond_naga(&module).into_iter().find(|found| !found.warning);
        beyond.map_or(Ok(()), Err)
    });
    rejection.err().map(|rejection| (rejection, is_naga))
}

#[test]
fn texts_that_break_a_rule_are_refused_and_twins_pass() {
    let mut wrong = String::new();
    for Case { place, rule, expected, text } in cases() {
        let found = rejected(&text);
        let (is_rejected, by_naga) = (found.is_some(), found.as_ref().is_some_and(|(_, by_naga)| *by_naga));
        let help = found.as_ref().and_then(|(rejection, _)| rejection.help.as_deref()).unwrap_or_default();
        let is_right = match expected {
            Expected::Valid => !is_rejected,
            Expected::Refused => is_rejected,
            // The help names what naga does not know, or what it does otherwise.
            Expected::Newer => {
                is_rejected
                    && (by_naga || rule.contains("Stricter"))
                    && (!rule.contains("Newer") || help.contains("naga does not know"))
                    && (!rule.contains("Stricter") || help.starts_with("WGSL allows this"))
            }
        };
        let found = found.map(|(rejection, by_naga)| (rejection.message, by_naga));
        if !is_right {
            let text: String = text.strip_prefix(WITHIN).unwrap_or(&text).chars().take(200).collect();
            let _ = writeln!(wrong, "{place} ({rule}) {expected:?}, but {found:?}: {text}");
        }
    }
    assert!(wrong.is_empty(), "{}\n{wrong}", wrong.lines().count());
}

#[test]
fn chromes_compiler_says_the_same_of_the_texts() {
    if !tint::is_installed() {
        return;
    }
    let folder = ScratchFolder::new("wgsl-rules");
    let mut wrong = String::new();
    for Case { place, rule, expected, text } in cases() {
        let verdict = tint::judge(&text, &folder);
        if verdict.is_ok() != (expected != Expected::Refused) {
            let said = verdict.err().unwrap_or_default();
            let _ = writeln!(wrong, "{place} ({rule}) {expected:?}: {said}");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Generates the documentation page about the rules, with counts by the part that finds the violations.
fn page() -> String {
    let mut rules: Vec<(String, [usize; 5])> = Vec::new();
    for case in cases() {
        if rules.last().is_none_or(|(rule, _)| *rule != case.rule) {
            rules.push((case.rule.clone(), [0; 5]));
        }
        let at = match (case.expected, rejected(&case.text)) {
            (Expected::Valid, _) => 0,
            (Expected::Newer, _) => 1,
            (Expected::Refused, Some((_, true))) => 2,
            (Expected::Refused, Some((_, false))) => 3,
            (Expected::Refused, None) => 4,
        };
        rules.last_mut().into_iter().for_each(|(_, counts)| counts[at] += 1);
    }
    let sum = |at: usize| rules.iter().map(|(_, counts)| counts[at]).sum::<usize>();
    let mut page = String::from(
        "# WGSL\n\n\
        Browsers refuse a shader module that breaks one of WGSL's rules, before anything runs. naga, which wgpu uses \
        elsewhere, takes some of them. So umbragraph checks what naga does not, and `check` and `permutations` refuse \
        the same modules as browsers.\n\n\
        The table has each rule that a text can break when a module is created, with the chapter of the specification \
        (*WebGPU Shading Language*), the number of texts that hold it, and who refuses those that break it. Rules that \
        say \"newer\", and texts in the last column, are WGSL that browsers take and naga does not know: they are \
        refused with the name of what naga lacks, and a way without it. Rules that say \"stricter\" are WGSL that naga \
        refuses although it knows it: the message says that WGSL allows the text.\n\n\
        | | chapter | rule | texts that break it | of them by naga | by umbragraph | by nobody | that keep it | valid, unknown to naga |\n\
        |---|---|---|---|---|---|---|---|---|\n",
    );
    for (number, (rule, [valid, newer, naga, ours, nobody])) in (1..).zip(&rules) {
        let (section, rule) = rule.split_once(": ").unwrap_or(("", rule));
        let refused = naga + ours + nobody;
        let _ = writeln!(
            page,
            "| {number} | {section} | {rule} | {refused} | {naga} | {ours} | {nobody} | {valid} | {newer} |"
        );
    }
    let (refused, all) = (sum(2) + sum(3) + sum(4), sum(0) + sum(1) + sum(2) + sum(3) + sum(4));
    let _ = write!(
        page,
        "\n{all} texts: {refused} that break a rule, of which naga refuses {}, umbragraph {} and nobody {}; {} that keep \
        it, and {} of newer WGSL. Chrome's compiler, `tint`, says the same of each.\n\n\
        The texts are in `graph/shaders/src/tests/wgsl/`. This page is written from them by \
        `UMBRAGRAPH_BLESS=1 cargo nextest run -p umbragraph-shaders wgsl_rules`, and the test fails if it is of another \
        version. `UMBRAGRAPH_TIMES=50 cargo nextest run -p umbragraph-shaders wgsl_mutants` compares 20,000 mutants of \
        the texts, and some of the templates', with `tint` where it is installed (`UMBRAGRAPH_SEED` chooses others).\n\n\
        ## Not checked\n\n\
        Limits of a device are [another check](reference/diagnostics.md#ug0530). Arrays and structures are held to the \
        limits of Chrome's compiler, which are above those that the specification asks of every browser; so is nesting. \
        A value that follows from numbers without a type by functions, by shifts of vectors, or by bit operations beyond \
        32 bits, is not compared with the type that it gets. Of what naga computes while it parses (`fma`, `%`, \
        `inverseSqrt` of vectors), the result alone is looked at, not the steps on the way.\n",
        sum(2),
        sum(3),
        sum(4),
        sum(0),
        sum(1),
    );
    page
}

#[test]
fn the_page_of_rules_is_that_of_the_texts() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/wgsl.md");
    let page = page();
    if std::env::var_os("UMBRAGRAPH_BLESS").is_some() {
        std::fs::write(&path, &page).expect("the page");
    }
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(known == page, "docs/wgsl.md is not that of the texts: UMBRAGRAPH_BLESS=1 writes it");
}
