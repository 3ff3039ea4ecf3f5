//! A table of all that each driver of the machine draws: `cargo xtask drivers`.
//!
//! Every pipeline is rendered with each preset, debug view and scene of the project ([`case`]), and so is every lesson,
//! with each driver ([`driver`]). A picture that differs from lavapipe's is taken apart by cause ([`difference`]);
//! shadows are scored against rays. The table is written to a file, from the pictures that there are: they are kept,
//! and a run goes on where the one before ended. The status is 1 if a driver fails, has shadows of another score, or
//! pictures that differ in more than a share of pixels that nothing explains.
//!
//! usage: drivers COMMAND FOLDER TABLE [--quick] [--only PIPELINE] [--minutes N]

mod case;
mod difference;
mod drawing;
mod driver;
mod table;
mod variant;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use case::{Case, LESSONS, PIPELINES, SCENES};
use difference::{Difference, Pair};
use drawing::{Drawings, Drawn, Job, parallel};
use driver::{Adapter, Driver};
use variant::{SIDES, Variant};

/// The maximum percentage of pixels with an unexplained difference.
pub(crate) const MAX_UNEXPLAINED: f64 = 0.05;
/// The maximum change of a shadow score from the reference driver.
pub(crate) const MAX_SCORE_CHANGE: f64 = 0.001;

/// Error codes for features or limits that a driver lacks: of plans, limits, sizes and required features.
const LACKING: [&str; 4] = ["error[UG0219]", "error[UG0321]", "error[UG0406]", "error[UG0409]"];
/// Features whose absence does not change the picture.
const WITHOUT_TRACE: [&str; 1] = ["storage_descriptors"];

/// A row of the table: the results of a pipeline, or of all lessons, on one driver.
#[derive(Default)]
pub(crate) struct Row {
    pub(crate) name: &'static str,
    /// The number of pictures in the row.
    pub(crate) pictures: usize,
    pub(crate) drawn: usize,
    /// The difference over all pictures with all features on.
    pub(crate) difference: Difference,
    /// The name of the picture with the most unexplained pixels, and their percentage.
    pub(crate) worst: Option<(String, f64)>,
    /// The score of the sun's shadows on the courtyard scene; `None` without scores.
    pub(crate) score: Option<f64>,
    /// The largest change of a score from the reference, over all lights and scenes, with the light and scene.
    pub(crate) change: Option<(String, f64)>,
    /// Pictures rejected by a diagnostic, since the driver lacks a feature or limit.
    pub(crate) rejected: Vec<NotDrawn>,
    /// Pictures that failed for another reason.
    pub(crate) failures: Vec<NotDrawn>,
    /// The number of pictures with unexplained differences that have no rendering with nearest-texel sampling.
    pub(crate) without_nearest: usize,
    /// Features that the command reported as off, with the number of pictures.
    pub(crate) off: BTreeMap<String, usize>,
}

/// A picture that was not rendered, and the reason.
pub(crate) struct NotDrawn {
    pub(crate) picture: String,
    pub(crate) reason: String,
}

/// The results of a driver, with all rows of its table.
pub(crate) struct Section {
    pub(crate) name: String,
    pub(crate) adapter: Adapter,
    pub(crate) rows: Vec<Row>,
}

/// Returns `true` if every disabled feature leaves the picture unchanged.
fn is_whole<'a>(off: impl IntoIterator<Item = &'a String>) -> bool {
    off.into_iter().all(|feature| WITHOUT_TRACE.contains(&feature.as_str()))
}

struct Arguments {
    is_quick: bool,
    only: Option<String>,
    minutes: Option<u64>,
}

impl Arguments {
    fn parse(options: &[String]) -> Option<Self> {
        let mut arguments = Self { is_quick: false, only: None, minutes: None };
        let mut options = options.iter();
        while let Some(option) = options.next() {
            match option.as_str() {
                "--quick" => arguments.is_quick = true,
                "--only" => arguments.only = Some(options.next()?.clone()),
                "--minutes" => arguments.minutes = Some(options.next()?.parse().ok()?),
                _ => return None,
            }
        }
        Some(arguments)
    }
}

struct Run {
    drawings: Drawings,
    drivers: Vec<(Driver, Adapter)>,
    /// The cases to render in this run; `all` has every case of the table.
    drawn: Vec<Case>,
    all: Vec<Case>,
    scenes: &'static [&'static str],
    creases: BTreeMap<&'static str, Vec<bool>>,
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let parsed = match words.as_slice() {
        [program, folder, file, options @ ..] => {
            Arguments::parse(options).map(|arguments| (program, folder, file, arguments))
        }
        _ => None,
    };
    let Some((program, folder, file, arguments)) = parsed else {
        eprintln!("usage: drivers COMMAND FOLDER TABLE [--quick] [--only PIPELINE] [--minutes N]");
        return ExitCode::from(2);
    };
    match run(Path::new(program), Path::new(folder), Path::new(file), &arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}

/// Renders the pictures and writes the table. Returns `true` if there are no complaints.
fn run(program: &Path, folder: &Path, file: &Path, arguments: &Arguments) -> Result<bool, String> {
    let mut run = Run::new(program, folder, arguments)?;
    let until = || arguments.minutes.map(|minutes| Instant::now() + Duration::from_secs(60 * minutes));
    run.drawings.draw(run.jobs(), until());
    for scene in run.scenes {
        let depth = run.drawings.depth(&run.drivers[0].0, scene);
        run.creases.extend(depth.map(|depth| (*scene, difference::creases(&depth, 320))));
    }
    run.drawings.draw(run.nearest_jobs(), until());
    run.drawings.draw(run.turned_jobs(), until());
    let sections = run.sections();
    let text = table::markdown(&sections, arguments.is_quick, &run.drawings.commit());
    print!("{text}");
    std::fs::write(file, &text).map_err(|error| format!("{}: {error}", file.display()))?;
    let complaints = table::complaints(&sections);
    for complaint in &complaints {
        eprintln!("{complaint}");
    }
    Ok(complaints.is_empty())
}

impl Run {
    fn new(program: &Path, folder: &Path, arguments: &Arguments) -> Result<Self, String> {
        let drawings = Drawings::open(program, folder)?;
        let mut drivers = Vec::new();
        for driver in Driver::all(program, &drawings.folder) {
            match driver.adapter(program, &drawings.folder) {
                Some(adapter) => drivers.push((driver, adapter)),
                None => eprintln!("{}: no adapter", driver.name),
            }
        }
        if drivers.first().is_none_or(|(first, _)| first.name != "lavapipe") {
            let help = "install mesa-vulkan-drivers";
            return Err(format!("lavapipe, which all others are compared with, gives no adapter: {help}"));
        }
        let quick = arguments.is_quick;
        let drawn = case::all(program, arguments.only.as_deref(), quick);
        if drawn.is_empty() {
            let names = PIPELINES.join(", ");
            return Err(format!("there is nothing of that name to draw: {names}, {LESSONS}"));
        }
        let all = case::all(program, None, quick);
        let scenes = if quick { &SCENES[..1] } else { &SCENES[..] };
        Ok(Self { drawings, drivers, drawn, all, scenes, creases: BTreeMap::new() })
    }

    /// Returns the jobs by priority: default pictures, scores on the first scene, other pictures, other scores.
    fn jobs(&self) -> Vec<Job<'_>> {
        let drivers = || self.drivers.iter().map(|(driver, _)| driver);
        let pictures = |case: &Case| {
            let case = case.clone();
            drivers().map(move |driver| Job::Picture { driver, case: case.clone(), variant: Variant::Whole })
        };
        let drawn: Vec<&'static str> =
            PIPELINES.into_iter().filter(|name| self.drawn.iter().any(|case| case.row == *name)).collect();
        let scores = |scene: &'static str| {
            drawn
                .iter()
                .flat_map(move |pipeline| drivers().map(move |driver| Job::Score { driver, pipeline, scene }))
        };
        let (first, others) = self.scenes.split_at(1);
        let defaults = self.drawn.iter().take_while(|case| case.is_default()).count();
        let (defaults, rest) = self.drawn.split_at(defaults);
        let mut jobs: Vec<Job<'_>> = defaults.iter().flat_map(pictures).collect();
        jobs.extend(first.iter().flat_map(|scene| scores(scene)));
        jobs.extend(rest.iter().flat_map(pictures));
        jobs.extend(others.iter().flat_map(|scene| scores(scene)));
        jobs
    }

    /// Returns the jobs for pictures with nearest-texel sampling, for cases with unexplained differences.
    fn nearest_jobs(&self) -> Vec<Job<'_>> {
        let (lavapipe, _) = &self.drivers[0];
        let mut jobs = Vec::new();
        for (case, others) in self.drawn.iter().zip(self.all_unexplained()) {
            let first = (!others.is_empty()).then_some(lavapipe);
            let job = |driver| Job::Picture { driver, case: case.clone(), variant: Variant::Nearest };
            jobs.extend(first.into_iter().chain(others).map(job));
        }
        jobs
    }

    /// Returns the jobs for pictures with a rotated camera on the reference driver, for cases still unexplained.
    fn turned_jobs(&self) -> Vec<Job<'_>> {
        let (driver, _) = &self.drivers[0];
        let found = self.drawn.iter().zip(self.all_unexplained());
        let cases = found.filter(|(_, others)| !others.is_empty()).map(|(case, _)| case);
        let jobs = |case: &Case| {
            let case = case.clone();
            SIDES.map(|side| Job::Picture { driver, case: case.clone(), variant: Variant::Turned(side) })
        };
        cases.flat_map(jobs).collect()
    }

    /// Returns [`Self::unexplained`] for each case to render.
    fn all_unexplained(&self) -> Vec<Vec<&Driver>> {
        parallel(&self.drawn, |case| self.unexplained(case))
    }

    /// Returns the drivers whose picture has pixels that are not yet explained.
    fn unexplained(&self, case: &Case) -> Vec<&Driver> {
        let others = self.drivers[1..].iter().map(|(driver, _)| driver);
        let is_unexplained = |driver: &&Driver| {
            self.difference(driver, case).is_some_and(|difference| difference.unexplained > 0)
        };
        others.filter(is_unexplained).collect()
    }

    /// Returns the difference of a driver's picture from the reference's; `None` if either is missing.
    fn difference(&self, driver: &Driver, case: &Case) -> Option<Difference> {
        let (lavapipe, _) = &self.drivers[0];
        let load = |driver, case: &Case, variant| self.drawings.picture(driver, case, variant);
        let whole = Variant::Whole;
        let [reference, picture] = [load(lavapipe, case, whole)?, load(driver, case, whole)?];
        let shadow = case.shadow_term().and_then(|case| load(lavapipe, &case, whole));
        let nearest = [lavapipe, driver].map(|driver| load(driver, case, Variant::Nearest));
        let turned = SIDES.map(|side| load(lavapipe, case, Variant::Turned(side)));
        // Those of one side alone would not do.
        let turned = turned.iter().map(Option::as_ref).collect::<Option<Vec<_>>>().unwrap_or_default();
        let nearest = match &nearest {
            [Some(one), Some(other)] => Some([one, other]),
            _ => None,
        };
        let shows_itself = case.view.is_some() || case.row == LESSONS;
        let jumps = shadow.iter().chain(shows_itself.then_some(&reference)).collect();
        let creases = self.creases.get(case.scene).map(Vec::as_slice);
        let (reference, picture) = (&reference, &picture);
        Some(Difference::of(&Pair { reference, picture, jumps, creases, nearest, turned }))
    }

    fn sections(&self) -> Vec<Section> {
        let rows: Vec<&'static str> = PIPELINES
            .into_iter()
            .chain([LESSONS])
            .filter(|row| self.all.iter().any(|case| case.row == *row))
            .collect();
        let section = |(driver, adapter): &(Driver, Adapter)| Section {
            name: driver.name.clone(),
            adapter: adapter.clone(),
            rows: rows.iter().map(|row| self.row(driver, row)).collect(),
        };
        self.drivers.iter().map(section).collect()
    }

    fn row(&self, driver: &Driver, name: &'static str) -> Row {
        let mut row = Row { name, ..Row::default() };
        let cases: Vec<&Case> = self.all.iter().filter(|case| case.row == name).collect();
        for (case, found) in cases.iter().zip(parallel(&cases, |case| self.difference(driver, case))) {
            row.pictures += 1;
            let off = match self.drawings.drawn(driver, case, Variant::Whole) {
                Drawn::Not => continue,
                Drawn::Failed(reason) => {
                    let is_said = LACKING.iter().any(|code| reason.starts_with(code));
                    let list = if is_said { &mut row.rejected } else { &mut row.failures };
                    list.push(NotDrawn { picture: case.name(), reason });
                    continue;
                }
                Drawn::Picture(_, off) => off,
            };
            row.drawn += 1;
            for feature in &off {
                *row.off.entry(feature.clone()).or_default() += 1;
            }
            // A picture without a feature is another one.
            if !is_whole(&off) {
                continue;
            }
            let Some(found) = found else { continue };
            row.difference = row.difference.and(found);
            let nearest = self.drawings.drawn(driver, case, Variant::Nearest);
            row.without_nearest +=
                usize::from(found.unexplained > 0 && !matches!(nearest, Drawn::Picture(..)));
            let percent = found.percent(found.unexplained);
            if row.worst.as_ref().map_or(percent > 0.0, |(_, most)| percent > *most) {
                row.worst = Some((case.name(), percent));
            }
        }
        if name != LESSONS {
            self.scores(driver, &mut row);
        }
        row
    }

    fn scores(&self, driver: &Driver, row: &mut Row) {
        let (lavapipe, _) = &self.drivers[0];
        for scene in self.scenes {
            let of = |driver| self.drawings.scores(driver, row.name, scene);
            let (Some(own), Some(reference)) = (of(driver), of(lavapipe)) else { continue };
            if *scene == SCENES[0] {
                row.score = own.first().map(|(_, score)| *score);
            }
            for ((light, own), (_, reference)) in own.iter().zip(&reference) {
                let change = own - reference;
                if row.change.as_ref().is_none_or(|(_, most)| change.abs() > most.abs()) {
                    row.change = Some((format!("{light} of the {scene}"), change));
                }
            }
        }
    }
}
