//! Errors of naga as diagnostics in the template.
//!
//! naga's errors carry several spans and a chain of causes. The last cause is the error, the first is its context in
//! the module. The place of a parse error is its first span. Validation errors list the enclosing function first, so
//! their place is the shortest span. Handle numbers are cut from messages: they differ between variants, and one
//! mistake must read the same in all of them.

use std::error::Error;
use std::ops::Range;

use naga::back::pipeline_constants::PipelineConstantError;
use naga::common::wgsl::TypeContext as _;
use naga::front::wgsl::ParseError;
use naga::valid::{EntryPointError, FunctionError, ValidationError};
use naga::{GlobalVariable, Handle, Module, Span, Type, WithSpan};

use super::invalid;
use crate::codes;
use crate::rules::uniformity;
use crate::written::rejection::{Rejection, Scope, one_line};
use umbragraph_text::diagnostic::Code;

pub(crate) fn parse(text: &str, error: &ParseError) -> Rejection {
    let mut labels: Vec<(Range<usize>, String)> =
        error.labels().filter_map(|(span, label)| Some((span.to_range()?, label.to_owned()))).collect();
    let notes: Vec<&str> = error.notes().collect();
    let first = if labels.is_empty() { None } else { Some(labels.remove(0)) };
    let mut message = one_line(error.message()).replace("found \"\"", "found the end of the text");
    if let Some((_, label)) = &first
        && !label.is_empty()
        && label != "see msg"
        && !message.contains(label.as_str())
    {
        message = format!("{message} ({})", one_line(label));
    }
    labels.iter_mut().for_each(|(_, label)| *label = one_line(label));
    let range = first.map(|(range, _)| range);
    let is_missing = message.starts_with("expected `;`") || message.ends_with("found the end of the text");
    let range = if is_missing { range.map(|range| end_before(text, range)) } else { range };
    let help = (!notes.is_empty()).then(|| one_line(&notes.join("; ")));
    Rejection { range, labels, help, ..Rejection::new(codes::WGSL_SYNTAX, message, Span::UNDEFINED) }
}

/// Moves the range of a missing token to the end of the preceding code, so that the range is not on the next line.
fn end_before(text: &str, range: Range<usize>) -> Range<usize> {
    let mut before = text.get(..range.start).unwrap_or_default();
    loop {
        let trimmed = before.trim_end();
        let line = trimmed.rfind('\n').map_or(0, |at| at + 1);
        match trimmed[line..].find("//") {
            Some(comment) => before = &trimmed[..line + comment],
            None => break before = trimmed,
        }
    }
    let line = text.get(..range.start).and_then(|before| before.rfind('\n')).map_or(0, |at| at + 1);
    match before.char_indices().next_back() {
        Some((at, last)) if at < line => at..at + last.len_utf8(),
        _ => range,
    }
}

pub(crate) fn validation(code: Code, module: &Module, error: &WithSpan<ValidationError>) -> Rejection {
    if let ValidationError::EntryPoint { source: EntryPointError::BindingCollision(handle), .. } =
        error.as_inner()
        && let Some(rejection) = collision(code, module, *handle)
    {
        return rejection;
    }
    if let Some(rejection) = non_uniform(module, error.as_inner()) {
        return rejection;
    }
    let explained = invalid::explain(module, error.as_inner());
    let mut cause = error.as_inner().to_string();
    let mut next = error.as_inner().source();
    while let Some(source) = next {
        cause = source.to_string();
        next = source.source();
    }
    let cause = one_line(&cause)
        .replace("Capability Capabilities(", "the capability ")
        .replace(") is required", " is required")
        .replace("Storage { access: StorageAccess(LOAD | STORE) }", "storage")
        .replace("Storage { access: StorageAccess(LOAD) }", "storage");
    let context = match error.as_inner() {
        ValidationError::Function { name, .. } => format!(" (in the function \"{name}\")"),
        ValidationError::EntryPoint { name, .. } => format!(" (in the entry point \"{name}\")"),
        ValidationError::GlobalVariable { name, .. } => format!(" (the variable \"{name}\")"),
        ValidationError::Constant { name, .. } => format!(" (the constant \"{name}\")"),
        ValidationError::Override { name, .. } => format!(" (the override \"{name}\")"),
        ValidationError::Type { handle, .. } => {
            format!(" (the type {})", module.to_ctx().type_to_string(*handle))
        }
        _ => String::new(),
    };
    let shortest =
        error.spans().filter_map(|(span, _)| span.to_range()).min_by_key(|range| (range.len(), range.start));
    let range = shortest.or_else(|| match error.as_inner() {
        ValidationError::Type { handle, .. } => use_of_type(module, *handle),
        _ => None,
    });
    let scope = match error.as_inner() {
        ValidationError::EntryPoint { source: EntryPointError::Function(_), .. } => Scope::Declaration,
        ValidationError::EntryPoint {
            name,
            source:
                EntryPointError::ForbiddenStageOperations
                | EntryPointError::Argument(..)
                | EntryPointError::Result(_)
                | EntryPointError::MissingVertexOutputPosition
                | EntryPointError::OutOfRangeWorkgroupSize,
            ..
        } => Scope::EntryPoint(name.clone()),
        ValidationError::EntryPoint { .. } => Scope::Interface,
        _ => Scope::Declaration,
    };
    let rejection = Rejection { range, scope, ..Rejection::new(code, String::new(), Span::UNDEFINED) };
    match explained {
        Some(invalid::Explained { message, range, labels, help, member }) => {
            Rejection { message, range: range.or(rejection.range), labels, help, member, ..rejection }
        }
        None => Rejection { message: format!("{cause}{context}"), ..rejection },
    }
}

/// Replaces naga's error about non-uniform control flow by the rejection from this crate's analysis, which names the
/// reasons. `None` for other errors.
fn non_uniform(module: &Module, error: &ValidationError) -> Option<Rejection> {
    let (ValidationError::Function { source: error, .. }
    | ValidationError::EntryPoint { source: EntryPointError::Function(error), .. }) = error
    else {
        return None;
    };
    let is_it = matches!(error, FunctionError::NonUniformControlFlow(..));
    is_it.then(|| uniformity::found(module)).into_iter().flatten().find(|found| !found.warning)
}

/// The rejection of two variables with the same binding; it suggests the first free number of the group.
fn collision(code: Code, module: &Module, handle: Handle<GlobalVariable>) -> Option<Rejection> {
    let binding = module.global_variables[handle].binding?;
    let name =
        |handle: Handle<GlobalVariable>| module.global_variables[handle].name.as_deref().unwrap_or_default();
    let mut others = module.global_variables.iter();
    let (other, _) =
        others.find(|(other, variable)| *other != handle && variable.binding == Some(binding))?;
    let (group, number) = (binding.group, binding.binding);
    let message = format!(
        "\"{}\" takes @group({group}) @binding({number}), which \"{}\" has",
        name(handle),
        name(other)
    );
    let taken = |number: u32| {
        let mut bindings = module.global_variables.iter().filter_map(|(_, variable)| variable.binding);
        bindings.any(|known| (known.group, known.binding) == (group, number))
    };
    let free = (0..).find(|number| !taken(*number))?;
    let span = |handle| module.global_variables.get_span(handle);
    let help = format!("@binding({free}) is the first of the group that is free here");
    let mut rejection = Rejection::new(code, message, span(handle)).help(help).of(Scope::Interface);
    rejection.labels.extend(span(other).to_range().map(|range| (range, "taken here".to_owned())));
    Some(rejection)
}

/// The byte range of the first global variable with this type. Types without a declaration, such as textures, have no
/// span of their own.
fn use_of_type(module: &Module, ty: Handle<Type>) -> Option<Range<usize>> {
    let (handle, _) = module.global_variables.iter().find(|(_, variable)| variable.ty == ty)?;
    module.global_variables.get_span(handle).to_range()
}

pub(crate) fn overrides(module: &Module, error: &PipelineConstantError) -> Rejection {
    match error {
        PipelineConstantError::ValidationError(error) => {
            let rejection = validation(codes::WGSL_OVERRIDES, module, error);
            let help = "with its overrides set the module fails though it is valid: a local `let` of a constant vector \
                        has to be a `const`";
            let help = rejection.message.contains("already in scope").then(|| help.to_owned());
            Rejection { help, ..rejection }
        }
        PipelineConstantError::MissingValue(name) => {
            let mut overrides = module.overrides.iter();
            let found = overrides.find(|(_, constant)| constant.name.as_deref() == Some(name.as_str()));
            let span = found.map(|(handle, _)| module.overrides.get_span(handle)).unwrap_or_default();
            let message =
                format!("the override \"{name}\" has no value: it has no initializer and is no axis");
            Rejection::new(codes::WGSL_OVERRIDES, message, span)
        }
        error => Rejection::new(codes::WGSL_OVERRIDES, one_line(&error.to_string()), Span::UNDEFINED),
    }
}
