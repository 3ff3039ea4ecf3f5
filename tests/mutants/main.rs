//! Faults planted in the project's templates, one at a time, and the reference pictures that have to show them.
//!
//! A fault is found if a picture of the table lies outside of its tolerance. What no longer is valid WGSL is rejected
//! before anything is drawn, and counts neither way. Faults that no picture can show are listed in `survivors.txt` with
//! the reason; an entry that fits no fault any more is an error.
#![cfg(all(feature = "gpu", feature = "gltf"))]

#[path = "../common/mod.rs"]
mod common;
mod rules;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::pictures::{self, Case};
use common::{files, root};
use rules::Fault;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::{Picture, compare};
use umbragraph_test_support::property;

/// The part of the planted faults, in hundredths, that has to be found.
const WANTED: usize = 90;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    Found,
    Survived,
    /// It is no valid shader any more.
    Rejected,
}

/// A case with its reference, the shaders that draw it, and the templates of which these are made.
struct Baseline {
    case: Case,
    reference: Picture,
    shaders: Vec<String>,
}

fn shaders(case: &Case, templates: &[(&str, &str)]) -> Option<(common::Outcome, Vec<String>)> {
    let outcome = case.check(templates);
    if outcome.findings.has_errors() || outcome.checked.plan.is_none() {
        return None;
    }
    let programs = &outcome.checked.pipeline.as_ref()?.programs;
    let variants = programs.iter().flat_map(|program| &program.variants);
    let texts = variants.map(|variant| variant.module.wgsl.to_string()).collect();
    Some((outcome, texts))
}

/// What becomes of a fault: cases of which no shader changes are not drawn.
fn verdict(gpu: &Gpu, baselines: &[Baseline], template: &str, fault: &Fault) -> Verdict {
    for baseline in baselines {
        let case = &baseline.case;
        let Some((outcome, texts)) = shaders(case, &[(template, &fault.text)]) else {
            return Verdict::Rejected;
        };
        if texts == baseline.shaders {
            continue;
        }
        let picture = case.render(gpu, &outcome);
        if !compare(&baseline.reference, &picture, &pictures::tolerance(gpu)).matches() {
            return Verdict::Found;
        }
    }
    Verdict::Survived
}

/// The templates of the tree, by name.
fn templates() -> BTreeMap<String, String> {
    let folder = root().join("shaders-templates");
    let mut paths = Vec::new();
    files(&folder, &mut paths);
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "jinja"));
    let text = |path: &std::path::Path| std::fs::read_to_string(path).expect("a template");
    let name = |path: &std::path::Path| {
        path.strip_prefix(&folder).expect("within").to_string_lossy().replace('\\', "/")
    };
    paths.iter().map(|path| (name(path), text(path))).collect()
}

/// The faults that are known to survive: template, line as it reads, and why.
fn known() -> Vec<(String, String, String)> {
    let text = include_str!("survivors.txt");
    let entries = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    entries
        .map(|line| match line.split(" | ").collect::<Vec<_>>()[..] {
            [template, reads, reason] => (template.to_owned(), reads.to_owned(), reason.to_owned()),
            _ => panic!("a line of survivors.txt is TEMPLATE | LINE | REASON: {line}"),
        })
        .collect()
}

#[test]
fn each_known_survivor_is_a_fault_that_is_planted() {
    let planted: BTreeSet<(String, String)> = templates()
        .iter()
        .flat_map(|(name, text)| rules::faults(text).into_iter().map(|fault| (name.clone(), fault.reads)))
        .collect();
    for (template, reads, reason) in known() {
        assert!(!reason.is_empty(), "{template}: {reads}: there is no reason");
        assert!(planted.contains(&(template.clone(), reads.clone())), "{template}: nothing plants `{reads}`");
    }
}

#[test]
fn a_template_in_place_of_the_same_one_changes_no_shader() {
    let case = pictures::of_scene("nebula", "interior").remove(0);
    let (_, before) = shaders(&case, &[]).expect("a plan");
    for (name, text) in templates() {
        let (_, after) = shaders(&case, &[(&name, &text)]).unwrap_or_else(|| panic!("{name} is rejected"));
        assert!(before == after, "{name}");
    }
}

#[test]
#[ignore = "takes minutes; `cargo xtask mutants` runs it"]
fn nine_of_ten_faults_in_templates_show_in_a_picture() {
    let Some(gpu) = gpu::device() else { return };
    let variable = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let wanted = variable("UMBRAGRAPH_MUTANTS_IN").unwrap_or_default();
    let sample: usize =
        variable("UMBRAGRAPH_MUTANTS_SAMPLE").map_or(usize::MAX, |text| text.parse().expect("a number"));
    let known = known();
    let mut planted: Vec<(String, Fault)> = Vec::new();
    for (name, text) in templates().into_iter().filter(|(name, _)| name.contains(&wanted)) {
        planted.extend(rules::faults(&text).into_iter().map(|fault| (name.clone(), fault)));
    }
    let is_known =
        |template: &str, fault: &Fault| known.iter().any(|one| one.0 == template && one.1 == fault.reads);
    let all = planted.len();
    planted.retain(|(template, fault)| !is_known(template, fault));
    println!("{all} faults can be planted, of which {} are listed in survivors.txt", all - planted.len());
    shuffle(&mut planted);
    planted.truncate(sample);
    let baselines: Vec<Baseline> = pictures::all().into_iter().map(|case| baseline(&gpu, case)).collect();
    let next = AtomicUsize::new(0);
    let verdicts: Mutex<Vec<(usize, Verdict)>> = Mutex::new(Vec::new());
    let workers = std::thread::available_parallelism().map_or(1, |count| count.get().div_ceil(2));
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some((template, fault)) = planted.get(at) else { break };
                    let verdict = verdict(&gpu, &baselines, template, fault);
                    let Fault { line, rule, reads, .. } = fault;
                    println!("{verdict:?}: {template}:{line}: {rule}: `{reads}`");
                    verdicts.lock().expect("no panic").push((at, verdict));
                }
            });
        }
    });
    let verdicts = verdicts.into_inner().expect("no panic");
    let count = |wanted: Verdict| verdicts.iter().filter(|(_, verdict)| *verdict == wanted).count();
    let (found, survived) = (count(Verdict::Found), count(Verdict::Survived));
    println!(
        "\n{found} found, {survived} survived, {} rejected as no valid shader",
        count(Verdict::Rejected)
    );
    let mut survivors: Vec<String> = verdicts
        .iter()
        .filter(|(_, verdict)| *verdict == Verdict::Survived)
        .map(|(at, _)| format!("{}:{} | {}", planted[*at].0, planted[*at].1.line, planted[*at].1.reads))
        .collect();
    survivors.sort();
    println!("survivors:\n{}", survivors.join("\n"));
    assert!(found > 0, "nothing is drawn, and so nothing is tested");
    assert!(found * 100 >= WANTED * (found + survived), "too few are found");
}

/// The picture of a case, which has to match its reference to begin with.
fn baseline(gpu: &Gpu, case: Case) -> Baseline {
    let reference =
        Picture::load(&pictures::folder().join(format!("{}.png", case.name))).expect("a reference");
    let (outcome, shaders) = shaders(&case, &[]).expect("a plan");
    let picture = case.render(gpu, &outcome);
    let comparison = compare(&reference, &picture, &pictures::tolerance(gpu));
    assert!(comparison.matches(), "{}: {}", case.name, comparison.message());
    Baseline { case, reference, shaders }
}

fn shuffle<T>(list: &mut [T]) {
    let mut state = property::seed();
    for end in (1..list.len()).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        list.swap(end, ((state >> 33) % (end as u64 + 1)) as usize);
    }
}
