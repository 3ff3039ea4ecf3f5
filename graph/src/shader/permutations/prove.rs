//! Proving texts: each one parsed once, validated once per set of capabilities, written once per language.
//!
//! Texts are independent of one another, so any thread can prove any of them.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::explore::Source;
use super::overrides;
use crate::shader::axes::Axes;
use crate::shader::profile::{TargetLanguage, TargetProfile};
use crate::shader::reflection::{self, Reflection};
use crate::shader::wgsl::Resolved;
use crate::shader::wgsl_error::Refusal;
use crate::shader::{backend, limits, stages, wgsl};

/// A text to be proven.
pub(crate) struct Task<'a> {
    pub(crate) source: Source,
    pub(crate) axes: &'a Axes,
    pub(crate) profiles: &'a [TargetProfile],
}

/// What became of a text.
#[derive(Clone, Debug, Default)]
pub(crate) struct Proof {
    /// Why it is refused, and by which of the profiles, by index.
    pub(crate) refusals: Vec<(Refusal, Vec<usize>)>,
    /// What it says of itself, where some profile accepts it.
    pub(crate) reflection: Option<Arc<Reflection>>,
}

impl Proof {
    fn refuse(&mut self, refusal: Refusal, profiles: impl IntoIterator<Item = usize>) {
        match self.refusals.iter_mut().find(|(known, _)| *known == refusal) {
            Some((_, all)) => {
                all.extend(profiles);
                all.sort_unstable();
                all.dedup();
            }
            None => self.refusals.push((refusal, profiles.into_iter().collect())),
        }
    }
}

/// Proves one text for all profiles of its task.
pub(crate) fn prove(task: &Task<'_>) -> Proof {
    let mut proof = Proof::default();
    let all = 0..task.profiles.len();
    let module = match wgsl::parse(&task.source.wgsl) {
        Ok(module) => module,
        Err(refusal) => {
            proof.refuse(refusal, all);
            return proof;
        }
    };
    let constants = match overrides::sets(task.axes, &module) {
        Ok(constants) => constants,
        Err(refusal) => {
            proof.refuse(refusal, all);
            return proof;
        }
    };
    let mut by_capabilities: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    // What passes with what all profiles have in common passes with what each of them has.
    let common = task.profiles.iter().map(|profile| profile.capabilities).reduce(|a, b| a & b);
    let mut known = common.and_then(|common| wgsl::validate(&module, common).ok());
    for (at, profile) in task.profiles.iter().enumerate() {
        let group = if known.is_some() { 0 } else { profile.capabilities.bits() };
        by_capabilities.entry(group).or_default().push(at);
    }
    for profiles in by_capabilities.values() {
        let Some(capabilities) = profiles.first().map(|at| task.profiles[*at].capabilities) else { continue };
        let info = match known.take().map_or_else(|| wgsl::validate(&module, capabilities), Ok) {
            Ok(info) => info,
            Err(refusal) => {
                proof.refuse(refusal, profiles.iter().copied());
                continue;
            }
        };
        let mut sizes = Vec::new();
        let mut defaults = None;
        let mut refused = false;
        for constants in &constants {
            match wgsl::resolve_overrides(&module, &info, constants) {
                Ok(resolved) => {
                    sizes.push(wgsl::workgroup_sizes(&resolved));
                    // The first values are the defaults.
                    defaults.get_or_insert(resolved);
                }
                Err(refusal) => {
                    refused = true;
                    proof.refuse(refusal, profiles.iter().copied());
                }
            }
        }
        sizes.dedup();
        let Some(defaults) = defaults.filter(|_| !refused) else { continue };
        for refusal in stages::mismatched(&task.source.wgsl, &module) {
            proof.refuse(refusal, profiles.iter().copied());
        }
        for sizes in &sizes {
            let reflection = reflection::reflect(&module, &info, sizes);
            for at in profiles {
                for refusal in limits::exceeded(&task.source.wgsl, &module, &reflection, &task.profiles[*at])
                {
                    proof.refuse(refusal, [*at]);
                }
            }
            // The first sizes are those of the defaults.
            proof.reflection.get_or_insert_with(|| Arc::new(reflection));
        }
        check_writers(task, profiles, &defaults, &mut proof);
    }
    proof
}

fn check_writers(task: &Task<'_>, profiles: &[usize], (module, info): &Resolved<'_>, proof: &mut Proof) {
    let mut by_language: BTreeMap<TargetLanguage, Vec<usize>> = BTreeMap::new();
    for at in profiles {
        // What the front end has read, a browser reads too; there is no writer to run.
        let language = task.profiles[*at].language;
        if language != TargetLanguage::Wgsl {
            by_language.entry(language).or_default().push(*at);
        }
    }
    for (language, profiles) in by_language {
        if let Err(refusal) = backend::emit(module, info, language) {
            proof.refuse(refusal, profiles);
        }
    }
}
