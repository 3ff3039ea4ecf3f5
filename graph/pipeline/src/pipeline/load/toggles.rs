//! The toggles of a document, and those of its passes.

use std::collections::{BTreeMap, BTreeSet};

use crate::pipeline::names::{Environment, name_diagnostic, twin_diagnostic};
use crate::pipeline::settings::kinds;
use crate::pipeline::toggle::{Condition, Toggle};
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, list_of, suggested_name};
use umbragraph_text::document::{Document, Entry, Value, pointer_join};
use umbragraph_text::expression::parse;
use umbragraph_text::language::ToggleDeclaration;

/// Returns the valid toggles of a document, sorted by name. Reports invalid names, names that a feature or parameter
/// has, and toggles that no pass uses.
pub(super) fn toggles(
    document: &Document,
    sound: &BTreeMap<String, ToggleDeclaration>,
    diagnostics: &mut Diagnostics,
) -> Vec<Toggle> {
    let section = |name: &str| document.root.entries_of(name);
    let mentions = mentions(document);
    let mentioned: BTreeSet<&str> = mentions.iter().map(|mention| mention.name).collect();
    let mut toggles = Vec::new();
    for entry in section("toggles") {
        let pointer = pointer_join("/toggles", &entry.key);
        if let Some(diagnostic) = name_diagnostic(entry) {
            diagnostics.push(diagnostic);
            continue;
        }
        let mut fine = true;
        for (what, other) in [("feature", "features"), ("parameter", "parameters")] {
            if let Some(twin) = section(other).iter().find(|other| other.key == entry.key) {
                let diagnostic = twin_diagnostic(entry, "toggle", (twin.key_span, what));
                diagnostics.push(diagnostic.pointer(&pointer));
                fine = false;
            }
        }
        let Some(declaration) = sound.get(&entry.key) else { continue };
        // A misspelt mention has a diagnostic of its own.
        let declared = |name: &str| section("toggles").iter().any(|other| other.key == name);
        let suggested = mentioned.iter().any(|name| {
            *name == entry.key || !declared(name) && suggested_name(name, [entry.key.as_str()]).is_some()
        });
        // A name of another kind in place of a toggle, or a toggle in a condition, has a diagnostic of its own.
        let is_explained =
            mentioned.iter().any(|name| !declared(name)) || is_in_condition(document, &entry.key);
        if fine && !suggested && !is_explained {
            let message = format!("no pass has the toggle \"{}\"", entry.key);
            let diagnostic = Diagnostic::warning(codes::UNUSED_TOGGLE, entry.key_span, message);
            let help = format!("give a pass \"toggle\": \"{}\", or remove it", entry.key);
            diagnostics.push(diagnostic.pointer(&pointer).help(help));
        }
        toggles.push(Toggle {
            name: entry.key.clone(),
            default: declaration.default,
            description: declaration.description.clone(),
            place: entry.key_span,
            pointer,
        });
    }
    toggles.sort_by(|a, b| a.name.cmp(&b.name));
    unknown(document, &mentions, diagnostics);
    toggles
}

/// A use of a toggle by a pass.
struct Mention<'a> {
    pointer: String,
    value: &'a Value,
    text: &'a str,
    name: &'a str,
}

/// The uses of toggles by all passes, including those of subgraphs, whether or not the passes exist in this
/// configuration.
fn mentions(document: &Document) -> Vec<Mention<'_>> {
    let subgraphs = document.root.entries_of("subgraphs");
    let subgraphs = subgraphs.iter().map(|entry| (pointer_join("/subgraphs", &entry.key), &entry.value));
    let owners = std::iter::once((String::new(), &document.root)).chain(subgraphs);
    let mentions = owners.flat_map(|(owner, value)| {
        value.entries_of("passes").iter().filter_map(move |entry| {
            let value = entry.value.get("toggle")?;
            let text = value.text()?;
            let pointer = pointer_join(&format!("{owner}/passes"), &entry.key) + "/toggle";
            Some(Mention { pointer, value, text, name: text.strip_prefix('!').unwrap_or(text) })
        })
    });
    mentions.collect()
}

/// Returns `true` if the condition of a pass, under "when", names the toggle.
fn is_in_condition(document: &Document, name: &str) -> bool {
    let subgraphs = document.root.entries_of("subgraphs").iter().map(|entry| &entry.value);
    let passes =
        std::iter::once(&document.root).chain(subgraphs).flat_map(|owner| owner.entries_of("passes"));
    let mut conditions = passes.filter_map(|entry| entry.value.get("when")?.text()?.strip_prefix('='));
    conditions.any(|text| parse(text).is_ok_and(|condition| condition.names().contains(&name)))
}

/// Reports toggles that are used but not declared; each use is reported once, however often its subgraph is used.
fn unknown(document: &Document, mentions: &[Mention<'_>], diagnostics: &mut Diagnostics) {
    let declared = document.root.entries_of("toggles");
    let names: Vec<&str> = declared.iter().map(|entry| entry.key.as_str()).collect();
    for Mention { pointer, value, text, name } in mentions {
        if names.contains(name) {
            continue;
        }
        let message = format!("there is no toggle \"{name}\"");
        let diagnostic = Diagnostic::error(codes::UNKNOWN_TOGGLE, value.span, message);
        let (is_feature, sign) = (
            document.root.get("features").and_then(|features| features.get(name)),
            if text.starts_with('!') { "!" } else { "" },
        );
        let is_bool = is_feature.and_then(|one| one.get("type")?.text()) == Some("bool");
        let other = is_bool.then(|| format!("\"{name}\" is a feature: write \"when\": \"={sign}{name}\""));
        if let Some(help) = other.or_else(|| kinds::kind_of(document, name)) {
            diagnostics.push(diagnostic.pointer(pointer).help(help));
            continue;
        }
        let written = value.span_within(text.len() - name.len()..text.len());
        let diagnostic = diagnostic.suggest(name, names.iter().copied(), written, |names| match names {
            [] => "declare it under \"toggles\"".to_owned(),
            names => format!("the toggles are {}", list_of(names.iter().copied())),
        });
        diagnostics.push(diagnostic.pointer(pointer));
    }
}

/// Returns the toggle condition of a pass, from the pass or from an enclosing use of a subgraph; `None` if there is
/// none. Reports two different conditions, unless one has an undeclared toggle.
pub(super) fn condition(
    entry: &Entry,
    pointer: &str,
    environment: &Environment,
    toggles: &[Toggle],
    diagnostics: &mut Diagnostics,
) -> Option<Condition> {
    let own = entry.value.get("toggle").and_then(Value::text);
    let switched = |text: &str| {
        let (on, name) = text.strip_prefix('!').map_or((true, text), |name| (false, name));
        let toggle = toggles.iter().position(|toggle| toggle.name == name)?;
        Some(Condition { toggle, on })
    };
    let all = environment.toggles.iter().map(String::as_str).chain(own);
    let mut all: Vec<(&str, Condition)> = all.filter_map(|text| Some((text, switched(text)?))).collect();
    all.dedup();
    if let [(first, _), (second, _), ..] = all[..] {
        let place = entry.value.get("toggle").map_or(entry.key_span, |value| value.span);
        let message = format!("the pass has the toggles \"{first}\" and \"{second}\"");
        let diagnostic = Diagnostic::error(codes::UNKNOWN_TOGGLE, place, message)
            .pointer(format!("{pointer}/toggle"))
            .help("a pass has one toggle; the toggle of a \"use\" is that of all passes of the subgraph");
        diagnostics.push(diagnostic);
    }
    all.first().map(|(_, condition)| *condition)
}
