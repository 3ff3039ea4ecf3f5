//! Errors of the template engine as diagnostics.
//!
//! An error inside an include arrives wrapped once per level; the innermost one with a place is the diagnostic, and
//! each level above it a related place. The engine's offsets are those of the guarded text, and are mapped back.

use std::error::Error as _;

use minijinja::{Error, ErrorKind};

use super::templates::TemplateSet;
use super::undeclared;
use crate::codes;
use crate::jinja::scan::WordKind;
use crate::jinja::structure::Call;
use crate::jinja::template::Template;
use crate::jinja::{filters, guard, syntax_help};
use umbragraph_text::diagnostic::{Code, Diagnostic, Place, list_of};
use umbragraph_text::source::Span;

/// Returns the diagnostic for a failed rendering of the template `root`. `last` is the place of the last literal text
/// that was written; it is used for errors without a place.
pub(crate) fn explain(set: &TemplateSet, root: &str, error: &Error, last: Option<Span>) -> Diagnostic {
    let chain = chain(error);
    let placed: Vec<(&Error, Span)> =
        chain.iter().filter_map(|error| Some((*error, span(set, error)?))).collect();
    let innermost = chain.last().copied().unwrap_or(error);
    // A template with broken syntax was reported when it was added; including it is no diagnostic of its own.
    let included = missing(innermost).and_then(|name| set.templates.get(name));
    if let Some(broken) = included.and_then(|included| included.broken.clone()) {
        return broken;
    }
    let too_large = chain.iter().any(|error| {
        error
            .source()
            .and_then(|source| source.downcast_ref::<std::io::Error>())
            .is_some_and(|source| source.kind() == std::io::ErrorKind::FileTooLarge)
    });
    let recursion =
        chain.iter().any(|error| error.detail().is_some_and(|text| text.contains("recursion limit")));
    let place = placed.last().map(|(_, span)| *span).or(last);
    let place = place
        .or_else(|| set.file(root).map(|file| Span::new(file, 0..0)))
        .map_or(Place::Nowhere, Place::Span);
    let (code, message, help) = if too_large {
        (
            codes::TEMPLATE_LIMIT,
            "the template writes more than 4 MiB of WGSL".to_owned(),
            Some(LIMIT_HELP.to_owned()),
        )
    } else if recursion {
        let (message, place, help) = recursive(&placed, place);
        return Diagnostic::error(codes::INCLUDE_RECURSIVE, place, message).help(help);
    } else {
        describe(innermost)
    };
    let mut diagnostic = Diagnostic::error(code, place, message);
    diagnostic.help = help;
    let written = |kind: WordKind, name: &str| {
        let (error, span) = placed.last()?;
        word(set.templates.get(error.name()?)?, *span, kind, name)
    };
    if let Some(name) = missing(innermost) {
        let written = written(WordKind::Text, name);
        diagnostic = diagnostic
            .suggest(name, set.names(), written, |names| format!("the templates are {}", list_of(names)));
    }
    if let Some((name, known)) = unknown_function(innermost) {
        let written = written(WordKind::Identifier, name);
        let import = undeclared::importable(set, name);
        diagnostic = diagnostic.suggest(name, known.iter().copied(), written, |names| {
            import.unwrap_or_else(|| format!("there are {}", list_of(names)))
        });
    }
    if let (ErrorKind::UndefinedError, Some((_, span))) = (innermost.kind(), placed.last()) {
        diagnostic = missing_argument(set, *span).unwrap_or(diagnostic);
    }
    if diagnostic.message == "number is not iterable"
        && let Some(help) = placed.last().and_then(|(_, span)| range_of(set, *span))
    {
        diagnostic.help = Some(help);
    }
    for (_, span) in placed.iter().rev().skip(1).take(8) {
        diagnostic = diagnostic.related(*span, "included from here");
    }
    diagnostic
}

/// The diagnostic for a call of a macro without an argument that the macro reads at a place; `None` if nothing there is
/// such an argument.
fn missing_argument(set: &TemplateSet, span: Span) -> Option<Diagnostic> {
    let templates = || set.templates.values();
    let template = templates().find(|template| template.file == span.file)?;
    let read = template.text.get(span.range())?;
    let macros = template.prepared.structure.macros.iter();
    let is_inside =
        |range: &std::ops::Range<usize>| range.start <= span.range().start && span.range().end <= range.end;
    let defined = macros.filter(|one| is_inside(&one.range)).max_by_key(|one| one.range.start)?;
    let at = defined.arguments.iter().take(defined.required).position(|argument| argument == read)?;
    let calls = templates()
        .flat_map(|template| template.prepared.structure.calls.iter().map(move |call| (template.file, call)));
    let lacks = |call: &Call| call.positional <= at && !call.named.iter().any(|name| name == read);
    let (file, call) = { calls }.find(|(_, call)| call.name == defined.name && lacks(call))?;
    let message =
        format!("the macro {}({}) is called without \"{read}\"", defined.name, defined.arguments.join(", "));
    let place = Span::new(file, call.range.clone());
    let help = format!("give it a value for \"{read}\"");
    let diagnostic = Diagnostic::error(codes::TEMPLATE_EVALUATION, place, message).help(help);
    Some(diagnostic.related(span, "read here"))
}

/// The help for a `for` tag at a place that loops over a number; `None` for other tags.
fn range_of(set: &TemplateSet, span: Span) -> Option<String> {
    let template = set.templates.values().find(|template| template.file == span.file)?;
    let text = &template.text;
    let mut tags = template.scan.tags.iter();
    let tag = tags.find(|tag| tag.range.start <= span.range().start && span.range().start < tag.range.end)?;
    tag.keyword(text).filter(|keyword| *keyword == "for")?;
    let word = |at: usize| tag.word(text, at);
    // `for NAME in NUMBER`
    let is_plain = tag.words.len() == 4 && word(2) == Some("in");
    let (name, number) = (word(1)?, word(3)?);
    is_plain.then(|| format!("write {{% for {name} in range({number}) %}}, which counts from 0"))
}

fn chain(error: &Error) -> Vec<&Error> {
    let mut chain = vec![error];
    let mut next = error.source();
    while let Some(source) = next {
        chain.extend(source.downcast_ref::<Error>());
        next = source.source();
    }
    chain
}

fn span(set: &TemplateSet, error: &Error) -> Option<Span> {
    let template = set.templates.get(error.name()?)?;
    Some(Span::new(template.file, syntax_help::range(template, error)?))
}

/// The name of the missing template that an error reports; `None` for other errors.
fn missing(error: &Error) -> Option<&str> {
    let is_missing = error.kind() == ErrorKind::TemplateNotFound;
    error.detail().filter(|_| is_missing)?.split(['"', '\'']).nth(1)
}

/// The name of the unknown filter, test or function that an error reports, with the names that exist; `None` for other
/// errors.
fn unknown_function(error: &Error) -> Option<(&str, &'static [&'static str])> {
    let known = match error.kind() {
        ErrorKind::UnknownFilter => filters::FILTERS,
        ErrorKind::UnknownTest => filters::TESTS,
        ErrorKind::UnknownFunction => &guard::PLAIN_FUNCTIONS,
        _ => return None,
    };
    // "filter abss is unknown"
    let detail = error.detail()?.strip_suffix(" is unknown")?;
    Some((detail.rsplit(' ').next()?, known))
}

/// The span of the only token with this kind and content in the template tags at a place; `None` if there is none or
/// several.
fn word(template: &Template, place: Span, kind: WordKind, text: &str) -> Option<Span> {
    let at = place.range();
    let tags = template.scan.tags.iter().filter(|tag| tag.range.start <= at.end && at.start < tag.range.end);
    let words = tags.flat_map(|tag| &tag.words).filter(|word| word.kind == kind);
    let quote = usize::from(kind == WordKind::Text);
    let inside = words.map(|word| word.range.start + quote..word.range.end - quote);
    let mut found = inside.filter(|range| template.text.get(range.clone()) == Some(text));
    let first = found.next()?;
    found.next().is_none().then(|| Span::new(template.file, first))
}

fn recursive(placed: &[(&Error, Span)], place: Place) -> (String, Place, &'static str) {
    let mut names: Vec<&str> = Vec::new();
    for (error, span) in placed {
        let Some(name) = error.name() else { continue };
        if let Some(first) = names.iter().position(|known| *known == name) {
            let cycle = [&names[first..], &[name]].concat().join("\" includes \"");
            let from = placed.get(first).map_or(*span, |(_, span)| *span);
            let message = format!("the template includes itself: \"{cycle}\"");
            return (message, Place::Span(from), "include it under a condition that ends, or not at all");
        }
        names.push(name);
    }
    let message = "a macro or a loop calls itself without end".to_owned();
    (message, place, "call it under a condition that ends, or not at all")
}

/// The help text for templates that exceed a limit.
const LIMIT_HELP: &str = "shorten its loops and texts; large tables belong in buffers or textures";

fn describe(error: &Error) -> (Code, String, Option<String>) {
    let detail = error.detail().map(str::to_owned);
    match error.kind() {
        _ if guard::is_limit(error) => {
            let what = detail.unwrap_or_else(|| "it takes more steps than allowed".to_owned());
            (
                codes::TEMPLATE_LIMIT,
                format!("the template exceeds a limit: {what}"),
                Some(LIMIT_HELP.to_owned()),
            )
        }
        ErrorKind::TemplateNotFound => {
            let name = missing(error).unwrap_or_default();
            let message = format!("\"{name}\" is included, but there is no such template");
            (codes::INCLUDE_MISSING, message, None)
        }
        ErrorKind::UndefinedError => {
            let what = detail.unwrap_or_else(|| "a value is undefined".to_owned());
            (codes::UNDECLARED_NAME, what, None)
        }
        kind => (codes::TEMPLATE_EVALUATION, detail.unwrap_or_else(|| kind.to_string()), None),
    }
}
