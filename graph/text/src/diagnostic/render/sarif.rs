//! Diagnostics as SARIF 2.1.0 (OASIS Standard, "Static Analysis Results Interchange Format"), the form that code
//! scanning services and editors take in.
//!
//! A run has one rule for each code that occurs. Lines and columns count from 1, columns in characters
//! (`unicodeCodePoints`). Where a diagnostic has no text to point into, it has the file alone; JSON pointers are
//! logical locations of the kind `object`.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::{Code, Diagnostic, Fix, Place, Severity};
use crate::source::{Sources, Span};

const SCHEMA: &str =
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Run {
    tool: serde_json::Value,
    column_kind: &'static str,
    results: Vec<ResultObject>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Rule {
    id: &'static str,
    name: String,
    short_description: Message,
    full_description: Message,
    help: Message,
}

#[derive(Serialize)]
struct Message {
    text: String,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct ResultObject {
    rule_id: &'static str,
    rule_index: usize,
    level: &'static str,
    message: Message,
    locations: Vec<Location>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    related_locations: Vec<Location>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    fixes: Vec<Mending>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Location {
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    physical_location: Option<Physical>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    logical_locations: Vec<Logical>,
    #[serde(skip_serializing_if = "Option::is_none")]
    message: Option<Message>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Physical {
    artifact_location: Artifact,
    #[serde(skip_serializing_if = "Option::is_none")]
    region: Option<Region>,
}

#[derive(Serialize)]
struct Artifact {
    uri: String,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Region {
    start_line: u32,
    start_column: u32,
    end_line: u32,
    end_column: u32,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Logical {
    fully_qualified_name: String,
    kind: &'static str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Mending {
    description: Message,
    artifact_changes: Vec<Change>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Change {
    artifact_location: Artifact,
    replacements: Vec<Replacement>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Replacement {
    deleted_region: Region,
    inserted_content: Message,
}

/// All diagnostics as one SARIF log.
pub fn sarif<'a>(
    diagnostics: impl IntoIterator<Item = &'a Diagnostic>,
    sources: &Sources,
) -> serde_json::Value {
    let diagnostics: Vec<&Diagnostic> = diagnostics.into_iter().collect();
    let codes: BTreeMap<&str, Code> =
        diagnostics.iter().map(|diagnostic| (diagnostic.code.id, diagnostic.code)).collect();
    let index = |id: &str| codes.keys().position(|known| *known == id).unwrap_or(0);
    let rules: Vec<Rule> = codes.values().map(rule).collect();
    let run = Run {
        tool: serde_json::json!({ "driver": {
            "name": "umbragraph",
            "version": env!("CARGO_PKG_VERSION"),
            "informationUri": env!("CARGO_PKG_REPOSITORY"),
            "rules": rules,
        } }),
        column_kind: "unicodeCodePoints",
        results: diagnostics
            .iter()
            .map(|diagnostic| result(diagnostic, index(diagnostic.code.id), sources))
            .collect(),
    };
    serde_json::json!({ "$schema": SCHEMA, "version": "2.1.0", "runs": [run] })
}

fn rule(code: &Code) -> Rule {
    let words = code.title.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let name = words.map(|word| word[..1].to_uppercase() + &word[1..]).collect();
    let text = |text: &str| Message { text: text.to_owned() };
    Rule {
        id: code.id,
        name,
        short_description: text(code.title),
        full_description: text(code.page),
        help: text(code.page),
    }
}

fn result(diagnostic: &Diagnostic, rule_index: usize, sources: &Sources) -> ResultObject {
    // What has no place of its own is a part of the message.
    let mut message = diagnostic.message.clone();
    for related in diagnostic.related.iter().filter(|related| related.place == Place::Nowhere) {
        message.push_str(&format!("\n{}", related.message));
    }
    message.extend(diagnostic.help.iter().map(|help| format!("\nhelp: {help}")));
    let primary = location(&diagnostic.place, &diagnostic.pointer, sources);
    let related = diagnostic.related.iter().filter_map(|related| {
        let place = location(&related.place, "", sources)?;
        Some(Location { message: Some(Message { text: related.message.clone() }), ..place })
    });
    ResultObject {
        rule_id: diagnostic.code.id,
        rule_index,
        level: match diagnostic.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        },
        message: Message { text: message },
        locations: primary.into_iter().collect(),
        related_locations: related
            .enumerate()
            .map(|(id, place)| Location { id: Some(id), ..place })
            .collect(),
        fixes: diagnostic.fix.iter().filter_map(|fix| mending(diagnostic, fix, sources)).collect(),
    }
}

fn location(place: &Place, pointer: &str, sources: &Sources) -> Option<Location> {
    let (artifact, region, pointer) = match place {
        Place::Span(span) => {
            let pointer = super::in_file(sources.get(span.file)?.name(), pointer);
            (artifact(*span, sources)?, region(*span, sources), pointer)
        }
        Place::File { path, locator } => (Artifact { uri: uri(path) }, None, locator.as_str()),
        Place::Nowhere => return None,
    };
    let logical =
        (!pointer.is_empty()).then(|| Logical { fully_qualified_name: pointer.to_owned(), kind: "object" });
    Some(Location {
        id: None,
        physical_location: Some(Physical { artifact_location: artifact, region }),
        logical_locations: logical.into_iter().collect(),
        message: None,
    })
}

fn artifact(span: Span, sources: &Sources) -> Option<Artifact> {
    sources.get(span.file).map(|file| Artifact { uri: uri(file.name()) })
}

fn region(span: Span, sources: &Sources) -> Option<Region> {
    let file = sources.get(span.file)?;
    let (start, end) = (file.line_column(span.start), file.line_column(span.end));
    Some(Region {
        start_line: start.line,
        start_column: start.column,
        end_line: end.line,
        end_column: end.column,
    })
}

fn mending(diagnostic: &Diagnostic, fix: &Fix, sources: &Sources) -> Option<Mending> {
    let mut changes: BTreeMap<String, Vec<Replacement>> = BTreeMap::new();
    for edit in &fix.edits {
        changes.entry(artifact(edit.span, sources)?.uri).or_default().push(Replacement {
            deleted_region: region(edit.span, sources)?,
            inserted_content: Message { text: edit.replacement.clone() },
        });
    }
    let text = diagnostic.help.clone().unwrap_or_else(|| "apply the fix".to_owned());
    let changes = changes
        .into_iter()
        .map(|(uri, replacements)| Change { artifact_location: Artifact { uri }, replacements });
    Some(Mending { description: Message { text }, artifact_changes: changes.collect() })
}

/// A path as a relative or `file:` reference of RFC 3986.
fn uri(path: &str) -> String {
    let mut text = String::with_capacity(path.len());
    for byte in path.replace('\\', "/").bytes() {
        match byte {
            b'/' | b'-' | b'.' | b'_' | b'~' => text.push(byte as char),
            _ if byte.is_ascii_alphanumeric() => text.push(byte as char),
            _ => text.push_str(&format!("%{byte:02X}")),
        }
    }
    if text.starts_with('/') { format!("file://{text}") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::codes;

    #[test]
    fn a_log_has_what_the_standard_requires() {
        let mut sources = Sources::new();
        let file = sources.add("a folder/a.json", "{\n  \"ä\": 1, \"naem\": 2 }");
        let at = Span::new(file, 13..19);
        let diagnostic = Diagnostic::error(codes::UNKNOWN_KEY, at, "unknown key \"naem\"")
            .pointer("/naem")
            .related(Span::new(file, 0..1), "the object")
            .related(Place::Nowhere, "in 1 of 2 configurations")
            .help("did you mean \"name\"?")
            .fix(at, "\"name\"");
        let other = Diagnostic::in_file(codes::FILE_UNREADABLE, "/gone.json", "/x", "gone");
        let log = sarif([&other, &diagnostic], &sources);
        assert_eq!(log["version"], "2.1.0");
        assert!(log["$schema"].as_str().is_some_and(|schema| schema.ends_with("sarif-schema-2.1.0.json")));
        let run = &log["runs"][0];
        assert_eq!(run["tool"]["driver"]["name"], "umbragraph");
        let result = &run["results"][1];
        let rule = &run["tool"]["driver"]["rules"][result["ruleIndex"].as_u64().unwrap() as usize];
        assert_eq!((&rule["id"], &result["ruleId"]), (&"UG0102".into(), &"UG0102".into()));
        assert_eq!(rule["name"], "UnknownKey");
        assert_eq!(result["level"], "error");
        let text = "unknown key \"naem\"\nin 1 of 2 configurations\nhelp: did you mean \"name\"?";
        assert_eq!(result["message"]["text"], text);
        let place = &result["locations"][0];
        assert_eq!(place["physicalLocation"]["artifactLocation"]["uri"], "a%20folder/a.json");
        let region = serde_json::json!({ "startLine": 2, "startColumn": 11, "endLine": 2, "endColumn": 17 });
        assert_eq!(place["physicalLocation"]["region"], region);
        assert_eq!(place["logicalLocations"][0]["fullyQualifiedName"], "/naem");
        assert_eq!(result["relatedLocations"].as_array().unwrap().len(), 1);
        let change = &result["fixes"][0]["artifactChanges"][0];
        assert_eq!(change["replacements"][0]["deletedRegion"], region);
        assert_eq!(change["replacements"][0]["insertedContent"]["text"], "\"name\"");
        let file = &run["results"][0]["locations"][0]["physicalLocation"];
        assert_eq!(file["artifactLocation"]["uri"], "file:///gone.json");
        assert!(file.get("region").is_none());
    }
}
