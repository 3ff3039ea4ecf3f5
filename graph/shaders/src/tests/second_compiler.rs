//! Uniformity and aliasing checks compared with `tint`, Chrome's compiler, where it is installed.
//!
//! The modules are random (`random_wgsl`) and the texts of the project's templates, as they are and mutated. A module
//! that `tint` rejects for one of the two rules must not pass here. Modules that only this crate rejects are counted
//! and must be rare. Modules that one side rejects for another reason are skipped, and must be rare too.

use std::collections::BTreeSet;

use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;
use umbragraph_test_support::scratch::ScratchFolder;

use super::random_wgsl::{self, Kind};
use super::{Fixture, tint};
use crate::codes;
use crate::module::wgsl;
use crate::permutations::{Options, Request, check};
use crate::{AxisKind, TargetProfile};

/// The names of the rules that a module violates.
type Broken = BTreeSet<&'static str>;

fn ours(text: &str) -> Option<Broken> {
    // naga knows the operations, and not the word that `tint` wants before them.
    let text = text.strip_prefix("enable subgroups;\n").unwrap_or(text);
    let module = wgsl::parse(text).ok()?;
    let errors = wgsl::beyond_naga(&module).into_iter().filter(|found| !found.warning);
    let rule = |code| if code == codes::POINTER_ALIAS { "aliasing" } else { "uniformity" };
    Some(errors.map(|found| rule(found.code)).collect())
}

/// The rules that a module violates according to `tint`; `None` if `tint` rejects it for another reason.
fn theirs(text: &str, folder: &ScratchFolder) -> Option<Broken> {
    let Err(said) = tint::judge(text, folder) else { return Some(Broken::new()) };
    let errors: Vec<&str> = said.lines().filter(|line| line.contains(" error: ")).collect();
    let rule = |error: &&str| match () {
        () if error.contains("must only be called from uniform control flow") => Some("uniformity"),
        () if error.contains("uniform") => Some("uniformity"),
        () if error.contains("aliased pointer") => Some("aliasing"),
        () => None,
    };
    errors.iter().map(rule).collect()
}

#[derive(Debug, Default)]
struct Tally {
    compared: usize,
    rejected: usize,
    left_out: usize,
    missed: Vec<String>,
    too_strict: Vec<String>,
}

impl Tally {
    fn compare(&mut self, text: &str, folder: &ScratchFolder) {
        let (Some(ours), Some(theirs)) = (ours(text), theirs(text, folder)) else {
            self.left_out += 1;
            return;
        };
        self.compared += 1;
        self.rejected += usize::from(!theirs.is_empty());
        // It looks for aliases first, and goes no further where it finds some.
        let missed = theirs.difference(&ours).next().is_some();
        if missed {
            self.missed.push(text.to_owned());
        } else if theirs.is_empty() && !ours.is_empty() {
            self.too_strict.push(format!("{ours:?}\n{text}"));
        }
    }

    fn report(&self, what: &str) {
        println!(
            "{what}: {} compared, {} rejected by tint, {} too strict here, {} left out",
            self.compared,
            self.rejected,
            self.too_strict.len(),
            self.left_out
        );
        for text in self.too_strict.iter().take(3) {
            println!("too strict:\n{text}");
        }
        let missed = self.missed.iter().min_by_key(|text| text.len());
        assert!(self.missed.is_empty(), "{} missed, the shortest:\n{}", self.missed.len(), missed.unwrap());
    }
}

/// The number of random modules; `cargo xtask soak` multiplies it.
const MODULES: u32 = 330;

#[test]
fn what_chrome_s_compiler_rejects_of_random_modules_is_rejected() {
    if !tint::is_installed() {
        return;
    }
    let folder = ScratchFolder::new("second-compiler-random");
    let mut random = Random(0x2545_F491_4F6C_DD1D ^ property::seed());
    let mut tally = Tally::default();
    for at in 0..MODULES * property::times() {
        let kind = [Kind::Fragment, Kind::Compute, Kind::Fragment, Kind::Subgroups][at as usize % 4];
        let text = random_wgsl::module(&mut random, kind, at % 5 == 0);
        tally.compare(&text, &folder);
    }
    tally.report("random modules");
    assert!(tally.left_out * 20 < tally.compared, "{} left out", tally.left_out);
    assert!(
        tally.rejected * 5 > tally.compared && tally.rejected * 5 < tally.compared * 4,
        "{}",
        tally.rejected
    );
    assert!(tally.too_strict.len() * 50 < tally.compared, "{} too strict", tally.too_strict.len());
}

/// Inserts an operation that needs uniform control flow at a random place, or removes the explicit level of a sample.
fn mutated(text: &str, random: &mut Random) -> String {
    let stage = if text.contains("@compute") { "storageBarrier();" } else { "_ = fwidth(0.5);" };
    let levels: Vec<usize> = text.match_indices("textureSampleCompareLevel(").map(|(at, _)| at).collect();
    if !levels.is_empty() && random.below(3) == 0 {
        let at = levels[random.below(levels.len())] + "textureSampleCompare".len();
        return format!("{}{}", &text[..at], &text[at + "Level".len()..]);
    }
    let mut is_within = false;
    let mut ends = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let indented = line.starts_with(' ');
        is_within = if indented { is_within } else { line.starts_with("fn ") || line.contains(" fn ") };
        start += line.len();
        if is_within && indented && [";", "{", "}"].iter().any(|end| line.trim_end().ends_with(end)) {
            ends.push(start);
        }
    }
    if ends.is_empty() {
        return text.to_owned();
    }
    let at = ends[random.below(ends.len())];
    format!("{}{stage}\n{}", &text[..at], &text[at..])
}

#[test]
fn mutations_that_chrome_s_compiler_rejects_are_rejected() {
    if !tint::is_installed() {
        return;
    }
    let sound = Fixture::sound(umbragraph_shaders_templates::FILES);
    let roots = super::roots(&sound.set);
    let folder = ScratchFolder::new("second-compiler-templates");
    let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ property::seed());
    let (mut tally, mut mutations) = (Tally::default(), Tally::default());
    for root in property::part(roots, 4) {
        let axes = sound.set.axes(root).into_iter().flat_map(crate::Axes::iter);
        let integers = axes.filter(|axis| matches!(axis.kind, AxisKind::Integer { .. }));
        let allowed = integers.map(|axis| (axis.name.clone(), vec![axis.default.clone()])).collect();
        let request = Request { allowed, ..Request::all(root, &[TargetProfile::webgpu()]) };
        let outcome = check(&sound.set, std::slice::from_ref(&request), &Options::default());
        let report = &outcome.templates[0];
        let most = 4 * property::times() as usize;
        for _ in 0..most.min(report.variants.len()) {
            let variant = &report.variants[random.below(report.variants.len())];
            let Some(text) = report.text(&sound.set, variant) else { continue };
            tally.compare(&text, &folder);
            for _ in 0..8 {
                mutations.compare(&mutated(&text, &mut random), &folder);
            }
        }
    }
    tally.report("texts of templates");
    mutations.report("mutations of texts");
    assert_eq!(tally.rejected, 0, "a text is rejected");
    assert!(tally.left_out * 20 <= tally.compared, "{} left out", tally.left_out);
    assert!(
        mutations.compared > 60 && mutations.rejected * 10 > mutations.compared,
        "{}",
        mutations.rejected
    );
}
