//! Faults planted in the project's templates, one at a time, and the reference pictures that have to show them.
//!
//! A fault is found if a picture of the table lies outside of its tolerance, or if it leaves no valid shader. Only
//! pictures whose shaders contain the faulty text are drawn, first those that are cheap and showed faults of the same
//! template before, until one differs. Faults that no picture can show are listed in `survivors.txt` with the reason
//! and are not drawn; an entry that fits no fault any more is an error.

mod rules;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::common::pictures::{self, Case};
use crate::common::{files, root};
use rules::Violation;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::{Picture, compare};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

/// The part of the faults that a picture could show, in hundredths, that has to be found.
const WANTED: usize = 90;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Verdict {
    Found,
    /// It is no valid shader any more.
    Rejected,
    Survived,
    /// It is in `survivors.txt`.
    Listed,
}

/// A case with its reference, the shaders that draw it, and the bytes of templates that are in these.
struct Baseline {
    case: Case,
    reference: Picture,
    shaders: Vec<String>,
    places: BTreeMap<String, Vec<Range<usize>>>,
    cost: Duration,
}

impl Baseline {
    fn contains(&self, template: &str, place: &Range<usize>) -> bool {
        let places = self.places.get(template).into_iter().flatten();
        places.into_iter().any(|own| own.start < place.end && place.start < own.end)
    }
}

fn shaders(case: &Case, templates: &[(&str, &str)]) -> Option<(crate::common::Outcome, Vec<String>)> {
    let outcome = case.check(templates);
    if outcome.diagnostics.has_errors() || outcome.checked.plan.is_none() {
        return None;
    }
    let programs = &outcome.checked.pipeline.as_ref()?.programs;
    let variants = programs.iter().flat_map(|program| &program.variants);
    let texts = variants.map(|variant| variant.module.wgsl.to_string()).collect();
    Some((outcome, texts))
}

/// The number of faults of a template that each case has shown.
type Hits = Mutex<BTreeMap<(String, usize), u32>>;

/// The verdict on a fault. Cases are drawn only if one of their shaders changes.
fn verdict(baselines: &[Baseline], hits: &Hits, template: &str, fault: &Violation) -> Verdict {
    let mut order: Vec<usize> =
        (0..baselines.len()).filter(|at| baselines[*at].contains(template, &fault.place)).collect();
    if order.is_empty() {
        // Text that a macro or a block captured has its place elsewhere.
        order.extend(0..baselines.len());
    }
    let key = |at: usize| (template.to_owned(), at);
    let hit = |at: usize| hits.lock().expect("no panic").get(&key(at)).copied().unwrap_or(0);
    order.sort_by_cached_key(|at| baselines[*at].cost / (hit(*at) + 1));
    let gpu = gpu::device().expect("the device of before");
    for at in order {
        let Baseline { case, reference, shaders: before, .. } = &baselines[at];
        let Some((outcome, texts)) = shaders(case, &[(template, &fault.text)]) else {
            return Verdict::Rejected;
        };
        if texts == *before {
            continue;
        }
        // What cannot be drawn fails the tests of pictures as well.
        let picture = catch_unwind(AssertUnwindSafe(|| case.render(&gpu, &outcome)));
        if !picture.is_ok_and(|picture| compare(reference, &picture, &pictures::tolerance(&gpu)).matches()) {
            *hits.lock().expect("no panic").entry(key(at)).or_default() += 1;
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
        .map(|line| {
            // Lines of templates may have the separator in them.
            let parts = line
                .split_once(" | ")
                .and_then(|(template, rest)| Some((template, rest.rsplit_once(" | ")?)));
            let Some((template, (reads, reason))) = parts else {
                panic!("a line of survivors.txt is TEMPLATE | LINE | REASON: {line}");
            };
            (template.to_owned(), reads.to_owned(), reason.to_owned())
        })
        .collect()
}

#[test]
fn each_known_survivor_is_a_fault_that_is_planted() {
    let planted: BTreeSet<(String, String)> = templates()
        .iter()
        .flat_map(|(name, text)| rules::violations(text).into_iter().map(|fault| (name.clone(), fault.reads)))
        .collect();
    let mut strays = Vec::new();
    for (template, reads, reason) in known() {
        assert!(!reason.is_empty(), "{template}: {reads}: there is no reason");
        if !planted.contains(&(template.clone(), reads.clone())) {
            strays.push(format!("{template}: nothing plants `{reads}`"));
        }
    }
    assert!(strays.is_empty(), "{}", strays.join("\n"));
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
    if gpu::device().is_none() {
        return;
    }
    let variable = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let number = |name: &str| variable(name).map(|text| text.parse::<usize>().expect("a number"));
    let jobs = number("UMBRAGRAPH_MUTANTS_JOBS")
        .unwrap_or_else(|| std::thread::available_parallelism().map_or(1, std::num::NonZero::get));
    let wanted = variable("UMBRAGRAPH_MUTANTS_IN").unwrap_or_default();
    let known = known();
    let mut planted: Vec<(String, Violation)> = Vec::new();
    for (name, text) in templates() {
        let faults =
            rules::violations(&text).into_iter().filter(|fault| is_wanted(&wanted, &name, fault.line));
        planted.extend(faults.map(|fault| (name.clone(), fault)));
    }
    let all = planted.len();
    Random(property::seed()).shuffle(&mut planted);
    planted.truncate(number("UMBRAGRAPH_MUTANTS_SAMPLE").unwrap_or(usize::MAX));
    println!("{} of {all} faults, by {jobs} at once", planted.len());
    let baselines = in_parallel(jobs, &pictures::all(), baseline);
    let hits = Hits::default();
    let verdicts = in_parallel(jobs, &planted, |(template, fault)| {
        let start = Instant::now();
        let is_known = known.iter().any(|one| one.0 == *template && one.1 == fault.reads);
        let verdict = if is_known { Verdict::Listed } else { verdict(&baselines, &hits, template, fault) };
        let Violation { line, rule, reads, .. } = fault;
        let took = start.elapsed().as_secs_f32();
        println!("{verdict:?}: {template}:{line}: {rule}: `{reads}` ({took:.1} s)");
        verdict
    });
    let count = |wanted: Verdict| verdicts.iter().filter(|verdict| **verdict == wanted).count();
    let [found, rejected, survived, listed] =
        [Verdict::Found, Verdict::Rejected, Verdict::Survived, Verdict::Listed].map(count);
    println!(
        "\n{found} found in pictures, {rejected} rejected as no valid shader, {listed} listed in survivors.txt, \
         {survived} survived"
    );
    let mut survivors: Vec<String> = (planted.iter().zip(&verdicts))
        .filter(|(_, verdict)| **verdict == Verdict::Survived)
        .map(|((template, fault), _)| format!("{template} | {} | line {}", fault.reads, fault.line))
        .collect();
    survivors.sort();
    assert!(found > 0, "nothing is drawn, and so nothing is tested");
    println!(
        "{:.1} % of all are found, {:.1} % of those that are not listed",
        percent(found + rejected, verdicts.len()),
        percent(found + rejected, verdicts.len() - listed)
    );
    assert!((found + rejected) * 100 >= WANTED * (verdicts.len() - listed), "too few are found");
    assert!(survivors.is_empty(), "neither found nor listed:\n{}", survivors.join("\n"));
}

fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

/// Whether a fault is among those that are asked for: parts of names of templates, or `NAME:LINE`, with commas between.
fn is_wanted(wanted: &str, template: &str, line: usize) -> bool {
    wanted.split(',').any(|one| match one.rsplit_once(':') {
        Some((name, of_line)) => template.contains(name) && of_line.parse() == Ok(line),
        None => template.contains(one),
    })
}

/// The results of a function for a list, by so many threads.
fn in_parallel<T: Sync, R: Send>(jobs: usize, list: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(BTreeMap::new());
    std::thread::scope(|scope| {
        for _ in 0..jobs.max(1) {
            scope.spawn(|| {
                while let at = next.fetch_add(1, Ordering::Relaxed)
                    && let Some(one) = list.get(at)
                {
                    let result = work(one);
                    results.lock().expect("no panic").insert(at, result);
                }
            });
        }
    });
    results.into_inner().expect("no panic").into_values().collect()
}

/// The baseline of a case without faults; it has to match its reference.
fn baseline(case: &Case) -> Baseline {
    let gpu = gpu::device().expect("the device of before");
    let start = Instant::now();
    let reference =
        Picture::load(&pictures::folder().join(format!("{}.png", case.name))).expect("a reference");
    let (outcome, shaders) = shaders(case, &[]).expect("a plan");
    let picture = case.render(&gpu, &outcome);
    let comparison = compare(&reference, &picture, &pictures::tolerance(&gpu));
    assert!(comparison.matches(), "{}: {}", case.name, comparison.message());
    let mut places: BTreeMap<String, Vec<Range<usize>>> = BTreeMap::new();
    let programs = outcome.checked.pipeline.iter().flat_map(|pipeline| &pipeline.programs);
    for variant in programs.flat_map(|program| &program.variants) {
        for span in variant.module.map.pieces().filter_map(|(_, span)| span) {
            let source = outcome.sources.get(span.file).expect("a template");
            places.entry(source.name().to_owned()).or_default().push(span.range());
        }
    }
    Baseline { case: case.clone(), reference, shaders, places, cost: start.elapsed() }
}
