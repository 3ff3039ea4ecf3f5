//! `umbragraph tune`: the values of parameters with which shadows agree best with ray-traced ones.
//!
//! The search minimises the mean of a loss over the scenes. The loss of a scene is one minus the intersection
//! over union, over all its lights and camera positions. For soft shadows it is the mean error. With `--of color` it is
//! the mean error, or FLIP, of the picture; its reference is traced once, with the values at the start.
//!
//! The method is CMA-ES (Hansen and Ostermeier; the crate `cmaes`) over coordinates between 0 and 1 (`space`), from the
//! values at the start. After it has converged, it begins again around the best with twice as many candidates. It ends
//! when as many sets of values were tried as the budget allows. Values that the pipeline rejects lose against all
//! others. The same seed finds the same values on the same adapter.
//!
//! A parameter that changes no pixel at the start, whatever its value, is left out until half of the budget is spent,
//! and tried again around the best then; one that changes none there either is a finding.
//!
//! Limits: the loss has steps, since pixels are counted, and many local minima; a larger budget, or narrower ranges,
//! find better values. Enumerations and features are not searched: they have no order.

mod file;
pub(crate) mod space;
mod table;
mod trial;

use std::cell::Cell;
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cmaes::{CMAESOptions, DVector};
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place};
use umbragraph::low_level::expression::Value;
use umbragraph_score::Rays;

use self::space::Tuned;
use self::table::Found;
use self::trial::{Outcome, REJECTED, Reference, Subject, Trials};
use crate::answer::answer;
use crate::arguments::{Of, TuneArguments};
use crate::codes;
use crate::device;
use crate::progress::Progress;
use crate::render::files;
use crate::render::{Drawing, Given};
use crate::replace::replace;
use crate::score::color_view::{self, ColorView, Look};
use crate::score::nothing;
use crate::score::view::View;
use crate::session::Session;
use crate::shadow_term;

/// The initial step size of CMA-ES: the standard deviation of the first candidates, in coordinates from 0 to 1.
const SPREAD: f64 = 0.15;

/// The coordinates that are tried to find out whether a parameter has any effect.
const PROBES: [f64; 3] = [0.9, 0.1, 0.5];

/// Searches for the best parameter values. Returns `true` if there were no errors.
pub(crate) fn run(arguments: &TuneArguments) -> bool {
    answer(&arguments.choices, arguments.format, |session, progress| tune(arguments, session, progress))
}

fn tune(
    arguments: &TuneArguments,
    session: &mut Session,
    progress: &mut Progress,
) -> Result<Found, Diagnostics> {
    files::check_folder(&arguments.out)?;
    let measure = arguments.measure()?;
    let colors = &arguments.colors;
    let settings = colors.settings(arguments.seed)?;
    let is_stopped = stopped_by_the_user();
    let path = session.camera(arguments.shots.film.camera.as_ref())?;
    let choices = match colors.of {
        Of::Shadows => shadow_term::choices(&arguments.choices),
        Of::Color => color_view::choices(&arguments.choices, colors),
    };
    let loaded = session.open(&arguments.pipeline, &choices.files.extension).ok_or_else(Diagnostics::new)?;
    let Some(document) = loaded.document() else { return Err(Diagnostics::new()) };
    if colors.of == Of::Shadows {
        shadow_term::required(&document.root)?;
    }
    let checked = progress.stage("check", || session.check(&arguments.pipeline, &choices));
    let mut tuned = Vec::new();
    if let Some(pipeline) = &checked.pipeline {
        for over in &arguments.over {
            match Tuned::of(over, pipeline, session.on_command_line(&over.name)) {
                Ok(one) => tuned.push(one),
                Err(diagnostic) => session.diagnostics.push(diagnostic),
            }
        }
    }
    let mut scenes = Vec::new();
    for file in &arguments.scene {
        scenes.push(progress.stage("load scene", || session.scene(file))?);
    }
    session.ensure_fine(&checked)?;
    let chosen = (&*arguments.pipeline, &choices);
    let (checked, given) = match colors.of {
        Of::Shadows => (checked, Given::default()),
        Of::Color => color_view::with_resource(checked, chosen, colors, session)?,
    };
    let graphics = progress.stage("open device", || device::open(arguments.drawn.adapter.as_deref()))?;
    let checked = session.check_on(&graphics, checked, &arguments.pipeline, &choices);
    session.ensure_fine(&checked)?;
    let mut drawings = Vec::new();
    let mut shots = Vec::new();
    for (at, scene) in scenes.iter().enumerate() {
        let options = Session::options(&choices);
        let mut drawing = Drawing::new(&graphics, scene, checked.clone(), options, session, given.clone())?;
        for shot in arguments.shots.all() {
            let input = drawing.input(&path, shot);
            shots.push((at, input, drawing.pose().clone()));
        }
        drawings.push(drawing);
    }
    let rays: Vec<Rays<'_>> = progress.stage("boxes around triangles", || {
        shots.iter().map(|(scene, _, pose)| Rays::new(&scenes[*scene], pose)).collect()
    });
    let plan = checked.plan.clone().ok_or_else(Diagnostics::new)?;
    let look = if colors.of == Of::Color { Some(Look::of(&plan, &given, session)?) } else { None };
    let mut subjects = Vec::new();
    for ((scene, input, pose), rays) in shots.iter().zip(&rays) {
        let reference = match &look {
            None => View::new(rays, input, choices.size, (None, progress))?.map(Reference::Shadows),
            Some(look) => {
                let posed = (rays, &scenes[*scene], pose);
                ColorView::new(posed, input, choices.size, (look, settings), progress)
                    .map(|view| Reference::Color(Box::new(view)))
            }
        };
        if let Some(reference) = reference {
            subjects.push(Subject { scene: *scene, input: input.clone(), reference });
        }
    }
    if subjects.is_empty() {
        return Err(nothing("the camera sees no surface", "move it, or give another with --camera").into());
    }
    let values: Vec<_> = tuned.iter().map(|one| (one.name.clone(), one.start.clone())).collect();
    let trials = Trials {
        arguments,
        measure,
        choices,
        graphics: &graphics,
        session,
        drawings,
        subjects: &subjects,
        planned: values.clone(),
        taps: checked.pipeline.as_deref().map_or(0, trial::taps),
    };
    let mut search = Search {
        trials,
        tuned: Vec::new(),
        left_out: tuned,
        has_looked: false,
        limit: arguments.budget as usize,
        known: HashMap::new(),
        tried: Vec::new(),
        rejected: 0,
        is_stopped,
    };
    progress.begin("tune", u64::from(arguments.budget));
    let before = search.trials.run(&values, progress)?;
    progress.advance();
    if before.scenes.iter().all(|scores| trial::loss(scores, measure).is_none()) {
        let help = "let something cast a shadow in view; mean-error needs lights with an extent";
        return Err(nothing("no scene has what the score is about", help).into());
    }
    search.keep(&values, Ok(before));
    search.run(progress);
    let findings = search.findings();
    search.trials.session.diagnostics.extend(findings);
    if search.trials.session.diagnostics.has_errors() {
        return Err(Diagnostics::new());
    }
    let names = search.tuned.iter().map(|one| one.name.clone()).collect();
    let found = Found::new((arguments, measure), &graphics.name, names, search.tried, search.rejected);
    let found = found.ok_or_else(Diagnostics::new)?;
    let text = file::text(&found, arguments, session, document)?;
    replace(&arguments.out, text)?;
    Ok(found)
}

/// Returns a flag that the first interrupt of the user sets; the second interrupt ends the process.
fn stopped_by_the_user() -> Arc<AtomicBool> {
    let stopped = Arc::new(AtomicBool::new(false));
    let set = stopped.clone();
    // Where no handler can be set an interrupt ends the process, as it does elsewhere.
    let _ = ctrlc::set_handler(move || {
        if set.swap(true, Ordering::SeqCst) {
            crate::interrupt::end();
        }
    });
    stopped
}

/// A set of parameter values with its outcome.
#[derive(Clone, Debug)]
struct Tried {
    values: Vec<(String, Value)>,
    outcome: Outcome,
}

struct Search<'a> {
    trials: Trials<'a>,
    tuned: Vec<Tuned>,
    /// The parameters that are not searched, since no effect on the picture is known yet.
    left_out: Vec<Tuned>,
    /// Set once the effect of each parameter has been tested.
    has_looked: bool,
    /// The number of value sets after which this part of the search ends.
    limit: usize,
    /// The loss of each set of values tried so far, by the set written as text.
    known: HashMap<String, f64>,
    tried: Vec<Tried>,
    rejected: u32,
    is_stopped: Arc<AtomicBool>,
}

impl Search<'_> {
    fn is_over(&self) -> bool {
        let count = self.tried.len() + self.rejected as usize;
        count >= self.limit || self.is_stopped.load(Ordering::SeqCst)
    }

    fn keep(&mut self, values: &[(String, Value)], outcome: Result<Outcome, Diagnostics>) -> f64 {
        let loss = match outcome {
            Ok(outcome) => {
                let loss = outcome.loss;
                self.tried.push(Tried { values: values.to_vec(), outcome });
                loss
            }
            Err(_) => {
                self.rejected += 1;
                REJECTED
            }
        };
        self.known.insert(written(values), loss);
        loss
    }

    /// Returns the loss of a set of values, rendering it only if it has not been tried.
    fn loss(&mut self, values: &[(String, Value)], progress: &mut Progress) -> f64 {
        if let Some(known) = self.known.get(&written(values)) {
            return *known;
        }
        if self.is_over() {
            return REJECTED;
        }
        let outcome = self.trials.run(values, progress);
        let loss = self.keep(values, outcome);
        progress.advance();
        loss
    }

    /// Adds the parameters that change a pixel near the given values to the search.
    fn take_in(&mut self, around: &Tried, progress: &mut Progress) {
        self.has_looked = true;
        for one in std::mem::take(&mut self.left_out) {
            if self.changes_something(&one, around, progress) {
                self.tuned.push(one);
            } else {
                self.left_out.push(one);
            }
        }
        let over = &self.trials.arguments.over;
        self.tuned.sort_by_key(|one| over.iter().position(|over| over.name == one.name));
    }

    fn changes_something(&mut self, one: &Tuned, around: &Tried, progress: &mut Progress) -> bool {
        for place in PROBES {
            let mut values = around.values.clone();
            let own = values.iter_mut().filter(|(name, _)| *name == one.name);
            own.for_each(|(_, value)| *value = one.value(&vec![place; one.width()]));
            if self.known.contains_key(&written(&values)) {
                continue;
            }
            let outcome = self.trials.run(&values, progress);
            progress.advance();
            let changes =
                outcome.as_ref().map_or(true, |outcome| outcome.pictures != around.outcome.pictures);
            self.keep(&values, outcome);
            // Where there is no time left to see, nothing is said.
            if changes || self.is_over() {
                return true;
            }
        }
        false
    }

    /// Searches until the budget is used up, or the user interrupts.
    fn run(&mut self, progress: &mut Progress) {
        let (mut round, mut fruitless) = (0_u64, 0);
        while !self.is_over() {
            let Some(best) = best(&self.tried).cloned() else { return };
            self.take_in(&best, progress);
            self.limit = match (round, self.left_out.is_empty()) {
                (0, false) => self.trials.arguments.budget as usize / 2,
                _ => self.trials.arguments.budget as usize,
            };
            if self.tuned.is_empty() {
                return;
            }
            let mut center = Vec::new();
            for one in &self.tuned {
                let value = best.values.iter().find(|(name, _)| *name == one.name);
                center.extend(value.map(|(_, value)| one.coordinates(value)).unwrap_or_default());
            }
            let options = CMAESOptions::new(center, SPREAD);
            let population = options.population_size << round.min(4);
            let options = options
                .population_size(population)
                // Steps below the digits that values are rounded to find nothing new.
                .tol_x(5e-4)
                .max_generations(1000)
                .seed(self.trials.arguments.seed.wrapping_add(round));
            let known = self.known.len();
            let is_over = Cell::new(false);
            let objective = |at: &DVector<f64>| {
                let values = self.values(at.as_slice());
                let loss = self.loss(&values, progress);
                is_over.set(self.is_over());
                loss
            };
            let Ok(mut state) = options.build(objective) else { return };
            while state.next().is_none() && !is_over.get() {}
            drop(state);
            self.limit = self.trials.arguments.budget as usize;
            // Where nothing new is tried any more, nothing is left to be found.
            fruitless = if self.known.len() == known { fruitless + 1 } else { 0 };
            if fruitless == 3 {
                return;
            }
            round += 1;
        }
    }

    /// Returns a warning for each parameter without any effect, and an error if no other parameter is left.
    fn findings(&self) -> Vec<Diagnostic> {
        let what = match self.trials.arguments.colors.of {
            Of::Shadows => "shadow term",
            Of::Color => "picture",
        };
        let of = |one: &Tuned| {
            let message = format!("the parameter \"{}\" changes no pixel of the {what}", one.name);
            let help = format!(
                "it keeps {}; what it takes effect with is to be given with --set, --feature or --preset",
                one.start
            );
            Diagnostic::warning(codes::TUNE, Place::Nowhere, message).help(help)
        };
        if !self.has_looked {
            return Vec::new();
        }
        let mut findings: Vec<Diagnostic> = self.left_out.iter().map(of).collect();
        if self.tuned.is_empty() {
            let error = Diagnostic::error(codes::TUNE, Place::Nowhere, "no parameter is left to be tuned");
            findings.push(error.help(format!("name one that changes the {what}")));
        }
        findings
    }

    fn values(&self, coordinates: &[f64]) -> Vec<(String, Value)> {
        let mut rest = coordinates;
        let mut values = Vec::new();
        for one in &self.tuned {
            let (own, others) = rest.split_at(one.width().min(rest.len()));
            values.push((one.name.clone(), one.value(own)));
            rest = others;
        }
        values.extend(self.left_out.iter().map(|one| (one.name.clone(), one.start.clone())));
        values
    }
}

/// Returns the trial with the lowest loss; on a tie the cheapest, then the first. `None` if there is no trial.
fn best(tried: &[Tried]) -> Option<&Tried> {
    tried.iter().min_by(|one, other| {
        let loss = one.outcome.loss.total_cmp(&other.outcome.loss);
        loss.then_with(|| one.outcome.cost.cmp(&other.outcome.cost))
    })
}

fn written(values: &[(String, Value)]) -> String {
    let mut parts: Vec<String> = values.iter().map(|(name, value)| format!("{name}={value};")).collect();
    parts.sort();
    parts.concat()
}
