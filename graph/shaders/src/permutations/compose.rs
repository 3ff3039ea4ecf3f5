//! Proving all texts by a few of them.
//!
//! ```text
//! texts ──units──▶ what nobody has proven ──cover──▶ few texts ──prove──▶ accepted and refused units, summaries ─┐
//!            ▲                                                                                                   │
//!            └──────────────────────── until every text is of proven units ◀─────────────────────────────────────┘
//! ```
//!
//! A text is valid for a profile if each of its units was accepted in some text for that profile, and invalid if one of
//! them was refused. What is said of a refused unit is said of all texts with it. A rejection that no unit can be
//! blamed for (writers of targets mostly do not say what they reject) concerns one text; its units stay unproven, so
//! that every text with them is proven by itself, until one with them is accepted. So is a text that cannot be taken
//! apart.
//!
//! All templates and profiles of a check share their units. A text is tried for every profile of the check, since what
//! it proves helps others; it is judged by those that want it. So a function of a library is proven once, whatever
//! pass, template or profile reaches it. An override is part of a unit with the values that its axis is tried with,
//! which may differ between templates.
//!
//! Limits: with more than 64 profiles in one check every text is proven by itself, and those from the 64th on are
//! judged as one. Writers name things over the whole module, and validators of others judge whole texts; both see the
//! cover. With `exhaustive` every text is proven by itself.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};

use super::Options;
use super::choose::Chosen;
use super::failure;
use super::interned::Declarations;
use super::kept::{Keep, Kept};
use super::overrides;
use super::prove::{self, Subject, Task};
use super::proven::Explored;
use super::report::Costs;
use super::units::{Overrides, Profiles, Refusal, Units, bit};
use crate::axes::Axes;
use crate::codes;
use crate::reflection::Reflection;
use crate::rendering::templates::TemplateSet;
use crate::targets::profile::TargetProfile;
use umbragraph_text::diagnostic::{AxisValues, Diagnostic, Place};
use umbragraph_text::source::Span;

/// The number of distinct modules above which a sample of them is validated first. Tests use a lower number.
const MANY_TEXTS: usize = if cfg!(test) { 320 } else { 1 << 10 };

/// A distinct generated WGSL module.
pub(super) struct Text<'a> {
    pub(super) subject: Arc<Subject<'a>>,
    /// The index of the template's overrides in [`Composition::overrides`].
    pub(super) overrides: usize,
    /// The index of the first request with this module, and the module's index within the request.
    pub(super) at: (usize, usize),
    pub(super) state: State,
}

/// The progress of validating one module.
#[derive(Default)]
pub(super) struct State {
    pub(super) units: Vec<u32>,
    /// The ids of the declarations that call a function not analysed yet.
    pub(super) open: Vec<u32>,
    pub(super) module: Option<u32>,
    /// Whether validation of the module is complete.
    pub(super) is_settled: bool,
    /// The result of validating this module directly; `None` if it follows from the module's declarations or is not
    /// known yet.
    pub(super) own: Option<Own>,
}

/// The result of validating a module directly, instead of deriving it from the module's validated declarations.
#[derive(Default)]
pub(super) struct Own {
    pub(super) refusals: Vec<Refusal>,
    pub(super) reflection: Option<Arc<Reflection>>,
    pub(super) costs: Costs,
}

/// All distinct WGSL modules and the state of their validation.
pub(super) struct Composition<'a> {
    pub(super) templates: &'a TemplateSet,
    pub(super) explored: Vec<Explored<'a>>,
    pub(super) declarations: Declarations,
    pub(super) texts: Vec<Text<'a>>,
    pub(super) profiles: Arc<[&'a TargetProfile]>,
    pub(super) units: Units,
    pub(super) overrides: Vec<Overrides>,
    /// Whether naga's reflection of a module differed from the one derived from its declarations. Every module is then
    /// validated directly.
    pub(super) is_irregular: bool,
    /// The error messages of the external validators that cannot run, keyed by the validator's index.
    pub(super) unavailable: BTreeMap<usize, String>,
    /// The number of modules that were passed to naga.
    pub(super) proven: usize,
    /// The parts of modules that were already chosen for validation, each as an id in the low 32 bits and its kind
    /// above.
    pub(super) tried: HashSet<u64>,
    /// The number of extra modules per round for parts that stayed unvalidated after an attempt.
    pub(super) more: usize,
}

/// Returns the bit set of the profiles that must accept a module; 1 if there are none.
pub(super) fn wanted_bits(subject: &Subject<'_>) -> Profiles {
    match subject.wanted.is_empty() {
        true => 1,
        false => subject.wanted.iter().fold(0, |all, at| all | bit(*at)),
    }
}

/// Collects the distinct modules of all requests, and the profiles that each is validated for.
pub(super) fn compose<'a>(
    templates: &'a TemplateSet,
    mut explored: Vec<Explored<'a>>,
    declarations: Declarations,
) -> Composition<'a> {
    let mut profiles: Vec<&TargetProfile> = Vec::new();
    for profile in explored.iter().flat_map(|each| &each.request.profiles) {
        if !profiles.contains(&profile) {
            profiles.push(profile);
        }
    }
    // Sorted, so that the name under which proofs are kept does not depend on the order of requests.
    profiles.sort_by_cached_key(|profile| format!("{profile:?}"));
    let profiles: Arc<[&TargetProfile]> = profiles.into();
    let mut kinds: Vec<(BTreeMap<&str, String>, &Axes)> = Vec::new();
    let mut known: HashMap<(usize, bool, [u8; 32]), usize> = HashMap::new();
    let mut found: Vec<(usize, (usize, usize), BTreeSet<usize>)> = Vec::new();
    for (request, each) in explored.iter_mut().enumerate() {
        let Some(axes) = templates.axes(&each.request.template) else { continue };
        let overrides = overrides::by_name(axes);
        let kind = kinds.iter().position(|(other, _)| *other == overrides).unwrap_or_else(|| {
            kinds.push((overrides, axes));
            kinds.len() - 1
        });
        let own = each.request.profiles.iter();
        let own: Vec<usize> =
            own.filter_map(|own| profiles.iter().position(|profile| *profile == own)).collect();
        for (text, each_text) in each.exploration.texts.iter().enumerate() {
            let at = *known.entry((kind, own.is_empty(), each_text.hash)).or_insert_with(|| {
                found.push((kind, (request, text), BTreeSet::new()));
                found.len() - 1
            });
            found[at].2.extend(&own);
            each.tasks.push(at);
        }
    }
    let mut subjects: HashMap<(usize, BTreeSet<usize>), Arc<Subject<'_>>> = HashMap::new();
    let texts = found.into_iter().map(|(kind, at, wanted)| {
        let subject = || Subject::new(kinds[kind].1, profiles.clone(), wanted.clone()).into();
        let subject = subjects.entry((kind, wanted.clone())).or_insert_with(subject).clone();
        Text { subject, overrides: kind, at, state: State::default() }
    });
    let texts = texts.collect();
    let mut units = Units::default();
    let overrides = kinds.iter().map(|(_, axes)| units.overrides(&declarations, axes)).collect();
    Composition {
        templates,
        explored,
        declarations,
        texts,
        profiles,
        units,
        overrides,
        is_irregular: false,
        unavailable: BTreeMap::new(),
        proven: 0,
        tried: HashSet::new(),
        more: 0,
    }
}

impl<'a> Composition<'a> {
    /// The storage key for validation results. It contains the profiles, since results refer to them by index.
    fn key(&self) -> String {
        format!("{:?}", self.profiles)
    }

    /// Loads the validation results of earlier runs from `keep`.
    pub(super) fn recall(&mut self, keep: &dyn Keep) {
        self.units.kept = Some(Kept::of(keep.get(&self.key())));
    }

    /// Stores the validation results for later runs in `keep`.
    pub(super) fn remember(&mut self, keep: &dyn Keep) {
        if let Some(kept) = self.units.kept.take().filter(|_| !self.is_irregular)
            && let Some(bytes) = kept.with(&self.units.all)
        {
            keep.put(&self.key(), &bytes);
        }
    }

    /// The name of the template that a module is generated from.
    pub(super) fn template(&self, text: &Text<'a>) -> &'a str {
        self.explored.get(text.at.0).map_or("", |each| each.request.template.as_str())
    }

    /// Validates modules until the result of every module is known. Of many modules, a sample is validated first, since
    /// its declarations cover most of the others.
    pub(super) fn prove(&mut self, options: &Options<'_>) {
        let steps: &[usize] = if self.texts.len() > MANY_TEXTS { &[64, 8, 1] } else { &[1] };
        steps.iter().for_each(|step| self.prove_each(*step, options));
    }

    /// Validates modules until the result of each module whose index is a multiple of `step` is known.
    fn prove_each(&mut self, step: usize, options: &Options<'_>) {
        loop {
            let Chosen { of_units, alone } = self.choose(options.exhaustive, step);
            let of_units = of_units.into_iter().map(|at| (at, true));
            let chosen: Vec<(usize, bool)> =
                of_units.chain(alone.into_iter().map(|at| (at, false))).collect();
            let settled = self.texts.iter().filter(|text| text.state.is_settled).count();
            let (done, count) = (AtomicUsize::new(settled), self.texts.len());
            if chosen.is_empty() {
                if step == 1 {
                    (options.progress)(count, count);
                }
                return;
            }
            let prove = |(at, is_of_units): &(usize, bool)| {
                if options.is_cancelled() {
                    return None;
                }
                let text = self.texts.get(*at)?;
                let each = self.explored.get(text.at.0)?;
                let source = each.exploration.source(self.templates, &each.request.template, text.at.1)?;
                // Parts that join to something else would be a defect; a proof of another text says nothing.
                let is_same = *blake3::hash(source.wgsl.as_bytes()).as_bytes()
                    == each.exploration.texts.get(text.at.1)?.hash;
                if !is_same {
                    return None;
                }
                let task = Task { source, subject: text.subject.clone(), is_of_units: *is_of_units };
                let proof = prove::prove(&task);
                let opinions = failure::judge(&task, &proof, options.external);
                (options.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, count);
                Some((*at, task, proof, opinions))
            };
            let found: Vec<_> = chosen.par_iter().map(prove).collect();
            self.proven += found.len();
            for (at, task, proof, opinions) in found.into_iter().flatten() {
                self.learn(at, &task, proof, &opinions, options);
            }
            for (at, _) in chosen {
                self.settle(at, options.is_cancelled());
            }
        }
    }

    /// Marks the validation of a chosen module as complete. A module that could not be rendered again identically
    /// counts as invalid.
    fn settle(&mut self, at: usize, is_cancelled: bool) {
        let Some(text) = self.texts.get(at) else { return };
        let template = self.template(text);
        let Some(text) = self.texts.get_mut(at) else { return };
        if text.state.is_settled {
            return;
        }
        text.state.is_settled = true;
        if is_cancelled {
            text.state.own.get_or_insert_default();
            return;
        }
        let place =
            self.templates.file(template).map_or(Place::Nowhere, |file| Place::Span(Span::new(file, 0..0)));
        let message =
            format!("a text of \"{template}\" could not be rendered a second time as it was at first");
        let help = "run it again: a machine that does much else can be too slow for a large text";
        let refusal = Refusal {
            diagnostic: Diagnostic::error(codes::PATHS_LIMIT, place, message).help(help),
            profiles: Profiles::MAX,
            excess: None,
            overrides: AxisValues::new(),
            is_fatal: true,
        };
        text.state.own = Some(Own { refusals: vec![refusal], ..Own::default() });
    }
}
