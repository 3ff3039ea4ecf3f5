//! Names of declarations: the kind of thing that a name stands for, and contradictions within a declaration.

use std::collections::BTreeMap;

use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, list_of};
use umbragraph_text::document::{Document, Entry, Value, pointer_join};
use umbragraph_text::expression::Expression;
use umbragraph_text::language::{Expr, FeatureDeclaration, FeatureType, ParameterDeclaration, ParameterType};

/// Says of which kind a name of a document is, and how it gets its value; `None` if nothing declares it.
///
/// This is the one place that tells kinds of names apart: whoever misses a name of one kind asks here for the others.
pub(crate) fn kind_of(document: &Document, name: &str) -> Option<String> {
    let section = |part: &str| document.root.entries_of(part).iter();
    let find = |part: &str| section(part).find(|entry| entry.key == name);
    for (part, option) in [("parameters", "--set"), ("features", "--feature")] {
        if find(part).is_some() {
            let what = part.trim_end_matches('s');
            return Some(format!("\"{name}\" is a {what}: it stands under \"{part}\", or behind {option}"));
        }
    }
    if find("toggles").is_some() {
        return Some(format!("\"{name}\" is a toggle, which frames switch: --toggle {name}=off of `render`"));
    }
    if find("presets").is_some() {
        return Some(format!("\"{name}\" is a preset: --preset {name}"));
    }
    if let Some(entry) = find("derived") {
        let expression = Expr(entry.value.to_json()).parse().ok();
        let names = expression.as_ref().map(Expression::names).filter(|names| !names.is_empty());
        let from = names.map(|names| format!(" from {}", list_of(names))).unwrap_or_default();
        return Some(format!("\"{name}\" is a derived value, which follows{from}: set what it follows from"));
    }
    let parameter = |owner: &Entry| owner.value.get("parameters")?.get(name).cloned();
    let (owner, declared) = section("subgraphs").find_map(|owner| Some((owner, parameter(owner)?)))?;
    let example = declared.get("default");
    let example = example.map_or_else(|| "…".to_owned(), |value| value.to_json().to_string());
    Some(format!(
        "\"{name}\" is a parameter of the subgraph \"{}\", which each use gives: \"with\": {{ \"{name}\": {example} }}",
        owner.key
    ))
}

/// Removes the parameters and features whose declarations contradict themselves, and reports each. Values are held
/// to none of them, since any would be wrong.
pub(crate) fn remove_contradictions(
    document: &Document,
    parameters: &mut BTreeMap<String, ParameterDeclaration>,
    features: &mut BTreeMap<String, FeatureDeclaration>,
    diagnostics: &mut Diagnostics,
) {
    for entry in document.root.entries_of("parameters") {
        let Some(declaration) = parameters.get(&entry.key) else { continue };
        if let Some((at, diagnostic)) = parameter_contradiction(entry, declaration) {
            let pointer = pointer_join("/parameters", &entry.key);
            diagnostics.push(diagnostic.pointer(pointer + at));
            parameters.remove(&entry.key);
        }
    }
    for entry in document.root.entries_of("features") {
        let Some(declaration) = features.get(&entry.key) else { continue };
        let pointer = pointer_join("/features", &entry.key);
        if declaration.feature_type == FeatureType::Enum && declaration.values.is_empty() {
            diagnostics.push(without_words(entry).pointer(&pointer));
            features.remove(&entry.key);
            continue;
        }
        let excludes = entry.value.elements_of("excludes").iter().enumerate();
        for (at, other) in excludes {
            let Some(name) = other.text().filter(|name| *name != entry.key) else { continue };
            let mut requires = entry.value.elements_of("requires").iter();
            if let Some(twin) = requires.find(|twin| twin.text() == Some(name)) {
                let message = format!(
                    "\"{}\" requires \"{name}\" and excludes it, so that it can never be on",
                    entry.key
                );
                let diagnostic = Diagnostic::error(codes::FEATURE_CONFLICT, other.span, message);
                let diagnostic = diagnostic.related(twin.span, "required here").help("remove one of the two");
                diagnostics.push(diagnostic.pointer(format!("{pointer}/excludes/{at}")));
            }
        }
    }
}

fn without_words(entry: &Entry) -> Diagnostic {
    let message = "the key \"values\" is missing here";
    let help = match entry.value.get("default").and_then(Value::text) {
        Some(word) => format!("an enumeration lists its words: \"values\": [\"{word}\", …]"),
        None => "an enumeration lists its words under \"values\"".to_owned(),
    };
    Diagnostic::error(codes::MISSING_KEY, entry.value.span, message).help(help)
}

/// The first contradiction of a parameter's declaration, with the JSON pointer of its place below the declaration.
fn parameter_contradiction(
    entry: &Entry,
    declaration: &ParameterDeclaration,
) -> Option<(&'static str, Diagnostic)> {
    use ParameterType as T;
    let written = |key: &str| entry.value.entry(key);
    let kind = declaration.parameter_type;
    if kind == T::Enum && declaration.values.is_empty() {
        return Some(("", without_words(entry)));
    }
    for (key, at) in [("min", "/min"), ("max", "/max")] {
        if let (T::Bool | T::Enum, Some(member)) = (kind, written(key)) {
            let message =
                format!("the parameter \"{}\" is {}, which has no \"{key}\"", entry.key, kind.name());
            let diagnostic = Diagnostic::error(codes::UNKNOWN_KEY, member.key_span, message);
            let help = format!("remove \"{key}\"; f32, u32, i32, f32[] and u32[] have one");
            return Some((at, diagnostic.help(help)));
        }
    }
    let lengths = (declaration.min_length.map(f64::from), declaration.max_length.map(f64::from));
    for (low, high, at, (min, max)) in [
        ("min", "max", "/max", (declaration.min, declaration.max)),
        ("min_length", "max_length", "/max_length", lengths),
    ] {
        if let (Some(min), Some(max), Some(member)) = (min, max, written(high))
            && min > max
        {
            let message = format!("\"{low}\" ({min}) of \"{}\" is larger than \"{high}\" ({max})", entry.key);
            let mut diagnostic = Diagnostic::error(codes::SETTING_RANGE, member.value.span, message);
            if let Some(other) = written(low) {
                diagnostic = diagnostic.related(other.value.span, format!("\"{low}\""));
            }
            let help = format!("swap them: \"{low}\": {max}, \"{high}\": {min}");
            return Some((at, diagnostic.help(help)));
        }
    }
    None
}
