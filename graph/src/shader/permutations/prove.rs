//! Proving texts: each one parsed once, validated once per set of capabilities, written once per language.
//!
//! Texts are independent, so threads take them from a common counter and put the outcome at the text's own index: what
//! comes out does not depend on their number or order.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use naga::back::PipelineConstants;
use naga::back::pipeline_constants::process_overrides;

use super::explore::Source;
use crate::shader::axes::{Axes, AxisKind, AxisMode};
use crate::shader::compile;
use crate::shader::profile::{TargetLanguage, TargetProfile};
use crate::shader::reflection::{self, Reflection};
use crate::shader::value::{AxisValue, AxisValues};
use crate::shader::wgsl_error::Refusal;
use crate::shader::{backend, limits, wgsl};

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

/// Runs `work` for each index below `count` on `threads` threads; the answers are in the order of the indices.
pub(crate) fn in_parallel<T: Send>(
    count: usize,
    threads: usize,
    progress: &(dyn Fn(usize) + Sync),
    work: &(dyn Fn(usize) -> T + Sync),
) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let done = AtomicUsize::new(0);
    let answers: Mutex<BTreeMap<usize, T>> = Mutex::new(BTreeMap::new());
    let run = || {
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            if at >= count {
                break;
            }
            let answer = work(at);
            answers.lock().unwrap_or_else(std::sync::PoisonError::into_inner).insert(at, answer);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
        }
    };
    let threads = threads.clamp(1, count.max(1));
    if cfg!(target_family = "wasm") {
        run();
    } else {
        std::thread::scope(|scope| {
            let started = (0..threads)
                .filter(|_| {
                    std::thread::Builder::new().stack_size(wgsl::STACK_BYTES).spawn_scoped(scope, run).is_ok()
                })
                .count();
            if started == 0 {
                run();
            }
        });
    }
    answers.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).into_values().collect()
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
    let constants: Vec<PipelineConstants> = match override_values(task.axes)
        .iter()
        .map(|values| compile::constants(task.axes, values, &module))
        .collect::<Result<_, _>>()
    {
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
        let mut refused = false;
        for constants in &constants {
            match wgsl::resolve_overrides(&module, &info, constants) {
                Ok(found) => sizes.push(found),
                Err(refusal) => {
                    refused = true;
                    proof.refuse(refusal, profiles.iter().copied());
                }
            }
        }
        sizes.dedup();
        if refused {
            continue;
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
        check_writers(task, profiles, &module, &info, constants.first(), &mut proof);
    }
    proof
}

fn check_writers(
    task: &Task<'_>,
    profiles: &[usize],
    module: &naga::Module,
    info: &naga::valid::ModuleInfo,
    constants: Option<&PipelineConstants>,
    proof: &mut Proof,
) {
    let mut by_language: BTreeMap<TargetLanguage, Vec<usize>> = BTreeMap::new();
    for at in profiles {
        // What the front end has read, a browser reads too; there is no writer to run.
        let language = task.profiles[*at].language;
        if language != TargetLanguage::Wgsl {
            by_language.entry(language).or_default().push(*at);
        }
    }
    if by_language.is_empty() {
        return;
    }
    let none = PipelineConstants::default();
    let Ok((module, info)) = process_overrides(module, info, None, constants.unwrap_or(&none)) else {
        return;
    };
    for (language, profiles) in by_language {
        if let Err(refusal) = backend::emit(&module, &info, language) {
            proof.refuse(refusal, profiles);
        }
    }
}

/// The values with which overrides are tried: all defaults, all least, all largest.
fn override_values(axes: &Axes) -> Vec<AxisValues> {
    let overrides: Vec<_> = axes.iter().filter(|axis| axis.mode == AxisMode::Override).collect();
    let defaults: AxisValues =
        overrides.iter().map(|axis| (axis.name.clone(), axis.default.clone())).collect();
    if overrides.is_empty() {
        return vec![defaults];
    }
    let ends = |largest: bool| -> AxisValues {
        overrides
            .iter()
            .map(|axis| {
                let value = match axis.kind {
                    AxisKind::Integer { min, max } => AxisValue::Integer(if largest { max } else { min }),
                    _ => AxisValue::Bool(largest),
                };
                (axis.name.clone(), value)
            })
            .collect()
    };
    let mut values = vec![defaults, ends(false), ends(true)];
    values.dedup();
    values
}
