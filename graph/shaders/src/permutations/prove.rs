//! Proving texts: each one parsed once, validated once per set of capabilities, written once per language.
//!
//! Texts are independent of one another, so any thread can prove any of them.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::blame::{self, blame};
use super::overrides;
use crate::axes::Axes;
use crate::module::wgsl::Resolved;
use crate::module::{backend, wgsl};
use crate::reflection::{self, Reflection};
use crate::rules::limits;
use crate::rules::summary::{self, Summary};
use crate::targets::profile::{TargetLanguage, TargetProfile};
use crate::variant::compile;
use crate::written::rejection::{Rejection, Scope};
use crate::written::stages;
use crate::written::text_map::Source;
use umbragraph_text::diagnostic::AxisValues;

/// The target profiles and override values for which modules are validated.
pub(crate) struct Subject<'a> {
    axes: &'a Axes,
    /// The sets of override values to try, the defaults first.
    overrides: Vec<AxisValues>,
    /// All target profiles of the check.
    pub(crate) profiles: Arc<[&'a TargetProfile]>,
    /// The indices of the profiles that must accept the module.
    pub(crate) wanted: BTreeSet<usize>,
}

impl<'a> Subject<'a> {
    pub(crate) fn new(axes: &'a Axes, profiles: Arc<[&'a TargetProfile]>, wanted: BTreeSet<usize>) -> Self {
        Self { axes, overrides: overrides::values(axes), profiles, wanted }
    }

    /// The profiles that must accept the module, with their indices.
    pub(crate) fn wanted(&self) -> impl Iterator<Item = (usize, &'a TargetProfile)> {
        self.wanted.iter().filter_map(|at| Some((*at, *self.profiles.get(*at)?)))
    }
}

/// A WGSL module to validate, with the profiles and override values to validate it for.
pub(crate) struct Task<'a> {
    pub(crate) source: Source,
    pub(crate) subject: Arc<Subject<'a>>,
    /// Whether the result also counts for the module's declarations in other modules. If so, all profiles of the check
    /// are tried; rejections by profiles outside `Subject::wanted` are not reported.
    pub(crate) is_of_units: bool,
}

impl<'a> Task<'a> {
    /// The profiles to validate the module for, with their indices.
    pub(crate) fn profiles(&self) -> impl Iterator<Item = (usize, &'a TargetProfile)> {
        let is_tried = |at: &usize| self.is_of_units || self.subject.wanted.contains(at);
        self.subject.profiles.iter().copied().enumerate().filter(move |(at, _)| is_tried(at))
    }
}

/// The result of validating a module.
#[derive(Clone, Debug, Default)]
pub(crate) struct Proof {
    /// The rejections, each with the indices of the profiles that reject the module.
    pub(crate) rejections: Vec<(Rejection, Vec<usize>)>,
    /// Warnings about WGSL that is valid but better avoided, or that only browsers reject.
    pub(crate) advice: Vec<Rejection>,
    /// The properties of each function that affect its callers, by function name; `None` if naga's validation fails for
    /// every profile.
    pub(crate) summaries: Option<BTreeMap<String, Summary>>,
    /// The reflection of the module; `None` if naga rejects the module, or its override values, for every profile.
    pub(crate) reflection: Option<Arc<Reflection>>,
}

impl Proof {
    /// Returns `true` if at least one wanted profile accepts the module.
    pub(crate) fn is_accepted(&self, subject: &Subject<'_>) -> bool {
        let is_rejected = |at: &usize| self.rejections.iter().any(|(_, profiles)| profiles.contains(at));
        subject.wanted.iter().any(|at| !is_rejected(at))
    }

    fn reject(&mut self, rejection: Rejection, profiles: impl IntoIterator<Item = usize>) {
        match self.rejections.iter_mut().find(|(known, _)| *known == rejection) {
            Some((_, all)) => {
                all.extend(profiles);
                all.sort_unstable();
                all.dedup();
            }
            None => self.rejections.push((rejection, profiles.into_iter().collect())),
        }
    }
}

/// Validates one module for all profiles of its task. A panic of the compiler becomes a rejection of the module.
pub(crate) fn prove(task: &Task<'_>) -> Proof {
    let subject = &*task.subject;
    wgsl::guarded(|| prove_for(task, subject)).unwrap_or_else(|rejection| {
        let mut proof = Proof::default();
        proof.reject(rejection, task.profiles().map(|(at, _)| at));
        proof
    })
}

fn prove_for(task: &Task<'_>, subject: &Subject<'_>) -> Result<Proof, Rejection> {
    let mut proof = Proof::default();
    let module = wgsl::parse(&task.source.wgsl)?;
    let mut beyond = Vec::new();
    let sets = overrides::sets(subject.axes, &subject.overrides, &module)?;
    let mut by_capabilities: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    // What passes with what all profiles have in common passes with what each of them has.
    let common = task.profiles().map(|(_, profile)| profile.capabilities).reduce(|a, b| a & b);
    let mut known = common.and_then(|common| wgsl::validate(&module, common).ok());
    for (at, profile) in task.profiles() {
        let group = if known.is_some() { 0 } else { profile.capabilities.bits() };
        by_capabilities.entry(group).or_default().push(at);
    }
    for profiles in by_capabilities.values() {
        let Some(capabilities) = profiles.first().map(|at| subject.profiles[*at].capabilities) else {
            continue;
        };
        let info = match known.take().map_or_else(|| wgsl::validate(&module, capabilities), Ok) {
            Ok(info) => info,
            Err(rejection) => {
                proof.reject(rejection, profiles.iter().copied());
                continue;
            }
        };
        if proof.summaries.is_none() {
            let (summaries, found) = summary::summaries(&module, &info);
            (proof.summaries, beyond) = (Some(summaries), found);
        }
        let mut sizes = Vec::new();
        let mut defaults = None;
        let mut rejected = false;
        for (at, set) in sets.iter().enumerate() {
            match wgsl::resolve_overrides(&module, &info, &set.constants) {
                Ok(resolved) => {
                    sizes.push((at, wgsl::workgroup_sizes(&resolved)));
                    // The first values are the defaults.
                    defaults.get_or_insert(resolved);
                }
                Err(rejection) => {
                    rejected = true;
                    let text = &task.source.wgsl;
                    let rejection = blame(text, (&module, &info), subject.axes, (&sets, at), rejection);
                    // Naga evaluates nothing in functions that no entry point reaches, so no unit is to blame.
                    let rejection = Rejection { scope: Scope::Text, ..rejection };
                    proof.reject(rejection, profiles.iter().copied());
                }
            }
        }
        sizes.dedup_by(|(_, one), (_, other)| one == other);
        let Some(defaults) = defaults.filter(|_| !rejected) else { continue };
        for rejection in stages::mismatched(&task.source.wgsl, &module) {
            proof.reject(rejection, profiles.iter().copied());
        }
        for (set, sizes) in &sizes {
            let reflection = reflection::reflect(&module, &info, sizes);
            for at in profiles {
                let exceeded = |reflection: &Reflection| {
                    limits::exceeded(&task.source.wgsl, &module, reflection, subject.profiles[*at])
                };
                for mut rejection in exceeded(&reflection) {
                    if sets.len() > 1 {
                        let fails = |values: &AxisValues| {
                            let sizes = compile::constants(subject.axes, values, &module)
                                .and_then(|set| wgsl::resolve_overrides(&module, &info, &set))
                                .map(|resolved| wgsl::workgroup_sizes(&resolved));
                            let reflection = sizes.map(|sizes| reflection::reflect(&module, &info, &sizes));
                            reflection.is_ok_and(|each| {
                                exceeded(&each).iter().any(|other| {
                                    other.excess.as_ref().map(|each| &each.of)
                                        == rejection.excess.as_ref().map(|each| &each.of)
                                })
                            })
                        };
                        rejection.overrides = blame::provoking(&sets, *set, &fails);
                    }
                    proof.reject(rejection, [*at]);
                }
            }
            // The first sizes are those of the defaults.
            proof.reflection.get_or_insert_with(|| Arc::new(reflection));
        }
        check_writers(subject, profiles, &defaults, &mut proof);
    }
    if proof.reflection.is_some() {
        check_beyond_naga(task, beyond, &mut proof);
    }
    Ok(proof)
}

/// Adds violations of WGSL rules that naga does not check: rejections for browsers, warnings for other targets.
fn check_beyond_naga(task: &Task<'_>, found: Vec<Rejection>, proof: &mut Proof) {
    let browsers: Vec<usize> =
        task.profiles().filter(|(_, profile)| profile.is_browser()).map(|(at, _)| at).collect();
    let is_for_browsers = task.subject.wanted().any(|(_, profile)| profile.is_browser());
    for rejection in found {
        if rejection.warning || !is_for_browsers {
            proof.advice.push(Rejection { warning: true, ..rejection.clone() });
        }
        if !rejection.warning && !browsers.is_empty() {
            proof.reject(rejection, browsers.iter().copied());
        }
    }
}

fn check_writers(
    subject: &Subject<'_>,
    profiles: &[usize],
    (module, info): &Resolved<'_>,
    proof: &mut Proof,
) {
    // What the front end has read, a browser reads too; there is no writer to run.
    for language in TargetLanguage::ALL.into_iter().filter(|language| *language != TargetLanguage::Wgsl) {
        let of_language = |at: &usize| subject.profiles[*at].language == language;
        let mut profiles = profiles.iter().copied().filter(of_language).peekable();
        if profiles.peek().is_some()
            && let Err(rejection) = backend::emit(module, info, language)
        {
            proof.reject(rejection, profiles);
        }
    }
}
