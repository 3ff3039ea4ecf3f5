//! WGSL to a validated naga module.
//!
//! Three steps, each of which can reject: parse, validate with the capabilities of a profile, and, if the module has
//! pipeline-overridable constants, substitute their values and validate again. Backends do the same, and naga can fail
//! only there. naga does not expect hostile input: a panic inside it becomes a diagnostic. It runs on a thread with its
//! own stack, because it recurses into nested text.
//!
//! Limits: in a browser a panic ends the module, since nothing unwinds there, and no thread has a deeper stack. Texts
//! that nest too deeply or are too large are rejected before naga, everywhere; only defects of naga remain. So check a
//! pipeline for a browser where you build it (`umbragraph check`), which runs naga on each of its texts.

use std::borrow::Cow;
use std::panic::{AssertUnwindSafe, catch_unwind};

use naga::back::PipelineConstants;
use naga::back::pipeline_constants::process_overrides;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, Span};

use super::wgsl_error;
use crate::codes;
use crate::reflection::WorkgroupSizes;
use crate::rules::aliasing;
use crate::rules::behaviors;
use crate::rules::constant_arguments;
use crate::rules::empty_vectors;
use crate::rules::spelled;
use crate::rules::stage_variables;
use crate::rules::texture_arguments;
use crate::rules::types;
use crate::rules::uniformity;
use crate::written::attributes;
use crate::written::complexity;
use crate::written::constructors;
use crate::written::hint;
use crate::written::letters;
use crate::written::nesting;
use crate::written::newer;
use crate::written::operators;
use crate::written::rejection::Rejection;
use crate::written::scopes;
use crate::written::stricter;
use crate::written::tokens::Tokens;

/// The stack size, in bytes, of the thread that parses and validates deeply nested WGSL.
pub(crate) const STACK_BYTES: usize = 32 << 20;

/// Parses WGSL to a naga module.
///
/// # Errors
/// The rejection by naga, or by a check of WGSL rules that naga omits.
pub(crate) fn parse(text: &str) -> Result<Module, Rejection> {
    complexity::check(text)?;
    let module = guarded(|| {
        naga::front::wgsl::parse_str(text)
            .map_err(|error| hint::improve(text, wgsl_error::parse(text, &error)))
            .map_err(|rejection| stricter::explain(text, newer::explain(text, rejection)))
    })?;
    let tokens = Tokens::new(text);
    letters::check(&tokens)?;
    nesting::check(&tokens)?;
    operators::check(&tokens)?;
    attributes::check(&tokens, &module)?;
    constructors::check(&tokens, &module)?;
    scopes::check(&tokens)?;
    spelled::check(&tokens, &module)?;
    Ok(module)
}

/// Validates a parsed module with naga and with additional checks of WGSL rules.
///
/// # Errors
/// The rejection by naga, or by a check of WGSL rules that naga omits.
pub(crate) fn validate(module: &Module, capabilities: Capabilities) -> Result<ModuleInfo, Rejection> {
    let info = guarded(|| {
        Validator::new(ValidationFlags::all(), capabilities)
            .validate(module)
            .map_err(|error| newer::explain("", wgsl_error::validation(codes::WGSL_INVALID, module, &error)))
            .map_err(|rejection| stricter::explain_module(module, rejection))
    })?;
    let rules = [
        behaviors::found,
        types::found,
        stage_variables::found,
        constant_arguments::found,
        empty_vectors::found,
        texture_arguments::found,
    ];
    let beyond = rules.into_iter().find_map(|found| found(module).into_iter().next());
    beyond.map_or(Ok(info), Err)
}

/// Returns `true` if naga accepts the WGSL, without this crate's additional checks.
#[cfg(test)]
pub(crate) fn is_valid_for_naga(text: &str, capabilities: Capabilities) -> bool {
    naga::front::wgsl::parse_str(text)
        .is_ok_and(|module| Validator::new(ValidationFlags::all(), capabilities).validate(&module).is_ok())
}

/// Violations of WGSL rules that naga does not check; browsers reject such modules.
pub(crate) fn beyond_naga(module: &Module) -> Vec<Rejection> {
    let mut found = uniformity::found(module);
    found.extend(aliasing::analysis(module).1);
    found
}

/// A module whose overrides are replaced by values, and the validator's information about the module.
pub(crate) type Resolved<'m> = (Cow<'m, Module>, Cow<'m, ModuleInfo>);

/// Replaces all overrides by values and validates the resulting module.
///
/// # Errors
/// The rejection by naga, or by the check of constant arguments.
pub(crate) fn resolve_overrides<'m>(
    module: &'m Module,
    info: &'m ModuleInfo,
    constants: &PipelineConstants,
) -> Result<Resolved<'m>, Rejection> {
    if module.overrides.is_empty() {
        return Ok((Cow::Borrowed(module), Cow::Borrowed(info)));
    }
    let resolved = guarded(|| {
        process_overrides(module, info, None, constants)
            .map_err(|error| wgsl_error::overrides(module, &error))
    })?;
    let rules = [constant_arguments::found, empty_vectors::found];
    let beyond = rules.into_iter().find_map(|found| found(&resolved.0).into_iter().next());
    beyond.map_or(Ok(resolved), Err)
}

/// The workgroup sizes by entry point, in invocations; empty for a module without overrides.
pub(crate) fn workgroup_sizes(resolved: &Resolved<'_>) -> WorkgroupSizes {
    let (Cow::Owned(module), _) = resolved else { return WorkgroupSizes::new() };
    module.entry_points.iter().map(|entry| (entry.name.clone(), entry.workgroup_size)).collect()
}

/// Runs `work` on a thread with a stack deep enough for naga. In a browser, or if no thread can be started, it runs on
/// the current thread.
pub(crate) fn with_stack<T: Send>(work: impl Fn() -> T + Sync) -> T {
    if cfg!(target_family = "wasm") {
        return work();
    }
    std::thread::scope(|scope| {
        match std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, &work) {
            Ok(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
            Err(_) => work(),
        }
    })
}

pub(crate) fn guarded<T>(work: impl FnOnce() -> Result<T, Rejection>) -> Result<T, Rejection> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let message = panic
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("no message");
        Err(Rejection::new(
            codes::WGSL_COMPILER,
            format!("the shader compiler failed: {message}"),
            Span::UNDEFINED,
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::guarded;

    #[test]
    fn a_defect_of_the_shader_compiler_is_a_diagnostic() {
        let rejection = guarded(|| -> Result<(), _> { panic!("a handle out of range") }).unwrap_err();
        assert_eq!(rejection.code.id, "UG0523");
        assert_eq!(rejection.message, "the shader compiler failed: a handle out of range");
    }
}
