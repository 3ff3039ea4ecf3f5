//! Why naga rejects a text, as a diagnostic in the template.
//!
//! naga's errors carry several spans and a chain of causes. The last cause says what is wrong; the first says where in
//! the module. Of the spans, the first is the place for parse errors; validation errors list the enclosing function first,
//! so there the shortest is. Numbers of handles are cut out of messages: they differ from variant to variant, and one
//! mistake has to read the same in all of them.

use std::error::Error;
use std::ops::Range;

use naga::back::pipeline_constants::PipelineConstantError;
use naga::common::wgsl::TypeContext as _;
use naga::front::wgsl::ParseError;
use naga::valid::{EntryPointError, FunctionError, ValidationError};
use naga::{GlobalVariable, Handle, Module, Span, Type, WithSpan};

use super::codes;
use super::text_map::TextMap;
use super::uniformity;
use crate::diagnostic::{AxisValues, Code, Diagnostic, Place};
use crate::source::{self, FileId};

/// Why a text was rejected, in terms of that text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rejection {
    pub(crate) code: Code,
    pub(crate) message: String,
    /// Where, as bytes of the generated text.
    pub(crate) range: Option<Range<usize>>,
    /// Further places with what is to be seen there.
    pub(crate) labels: Vec<(Range<usize>, String)>,
    pub(crate) help: Option<String>,
    /// Whether it is no reason to reject the text, but better avoided.
    pub(crate) warning: bool,
    /// The limit that is exceeded, where it is one.
    pub(crate) excess: Option<Excess>,
    /// The values of overrides with which it shows, where others do not show it.
    pub(crate) overrides: AxisValues,
}

/// More of something than a profile guarantees.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Excess {
    /// Of what: two excesses of one thing at one place have one cause, however large each is.
    pub(crate) of: String,
    pub(crate) found: u64,
}

impl Rejection {
    pub(crate) fn new(code: Code, message: impl Into<String>, span: Span) -> Self {
        Self {
            code,
            message: message.into(),
            range: span.to_range(),
            labels: Vec::new(),
            help: None,
            warning: code == codes::UNIFORM_BRANCH,
            excess: None,
            overrides: AxisValues::new(),
        }
    }

    pub(crate) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// The diagnostic in the template. `template` is where it falls if the text cannot be mapped.
    pub(crate) fn to_diagnostic(&self, text: &str, map: &TextMap, template: FileId) -> Diagnostic {
        let span = self.range.clone().and_then(|range| map.span(range));
        let span = span.unwrap_or(source::Span::new(template, 0..0));
        let make = if self.warning { Diagnostic::warning } else { Diagnostic::error };
        let mut diagnostic = make(self.code, span, self.message.clone());
        for (range, label) in &self.labels {
            if let Some(span) = map.span(range.clone()) {
                diagnostic = diagnostic.related(span, label.clone());
            }
        }
        if let Some(range) = &self.range {
            diagnostic = diagnostic.related(Place::Nowhere, generated_line(text, range.start));
        }
        diagnostic.help = self.help.clone();
        diagnostic
    }
}

/// `generated line 12: let x = 1;`
pub(crate) fn generated_line(text: &str, offset: usize) -> String {
    let bytes = text.as_bytes();
    let offset = offset.min(bytes.len());
    let start = bytes[..offset].iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
    let end = bytes[offset..].iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |at| at + offset);
    let number = bytes[..start].iter().filter(|byte| **byte == b'\n').count() + 1;
    let line: String = text.get(start..end).unwrap_or_default().trim().chars().take(160).collect();
    format!("generated line {number}: {line}")
}

pub(crate) fn parse(text: &str, error: &ParseError) -> Rejection {
    let mut labels: Vec<(Range<usize>, String)> =
        error.labels().filter_map(|(span, label)| Some((span.to_range()?, label.to_owned()))).collect();
    let notes: Vec<&str> = error.notes().collect();
    let first = if labels.is_empty() { None } else { Some(labels.remove(0)) };
    let mut message = one_line(error.message());
    if let Some((_, label)) = &first
        && !label.is_empty()
        && !message.contains(label.as_str())
    {
        message = format!("{message} ({})", one_line(label));
    }
    labels.iter_mut().for_each(|(_, label)| *label = one_line(label));
    let range = first.map(|(range, _)| range);
    let range =
        if message.starts_with("expected `;`") { range.map(|range| end_before(text, range)) } else { range };
    let help = (!notes.is_empty()).then(|| one_line(&notes.join("; ")));
    Rejection { range, labels, help, ..Rejection::new(codes::WGSL_SYNTAX, message, Span::UNDEFINED) }
}

/// What is missing before a range belongs to the end of the text before it, not to the next line.
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
    let mut cause = error.as_inner().to_string();
    let mut next = error.as_inner().source();
    while let Some(source) = next {
        cause = source.to_string();
        next = source.source();
    }
    let cause = one_line(&cause)
        .replace("Capability Capabilities(", "the capability ")
        .replace(") is required", " is required");
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
    Rejection { range, ..Rejection::new(code, format!("{cause}{context}"), Span::UNDEFINED) }
}

/// Control flow that naga itself finds not to be uniform: the analysis of WGSL knows the reasons.
fn non_uniform(module: &Module, error: &ValidationError) -> Option<Rejection> {
    let (ValidationError::Function { source: error, .. }
    | ValidationError::EntryPoint { source: EntryPointError::Function(error), .. }) = error
    else {
        return None;
    };
    let is_it = matches!(error, FunctionError::NonUniformControlFlow(..));
    is_it.then(|| uniformity::found(module)).into_iter().flatten().find(|found| !found.warning)
}

/// Two variables at one binding, as where an author's template includes one that takes the same number.
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
    let mut rejection = Rejection::new(code, message, span(handle)).help(help);
    rejection.labels.extend(span(other).to_range().map(|range| (range, "taken here".to_owned())));
    Some(rejection)
}

/// Types that are written in place (textures, samplers) have no span; the first variable of the type has.
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

/// One line without numbers of handles: `Expression [12] is invalid` reads `Expression is invalid`.
pub(crate) fn one_line(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('[') {
        let (before, after) = rest.split_at(at);
        let digits = after[1..].bytes().take_while(u8::is_ascii_digit).count();
        let is_handle = digits > 0 && after[1 + digits..].starts_with(']');
        if is_handle && before.ends_with(" Some(") {
            line.push_str(before.trim_end_matches(" Some("));
            rest = after[digits + 2..].trim_start_matches(')');
        } else if is_handle && before.ends_with(' ') {
            line.push_str(before.trim_end());
            rest = &after[digits + 2..];
        } else {
            line.push_str(before);
            line.push('[');
            rest = &after[1..];
        }
    }
    line.push_str(rest);
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}
