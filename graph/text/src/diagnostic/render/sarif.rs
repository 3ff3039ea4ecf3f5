//! Diagnostics as SARIF 2.1.0 (OASIS Standard, "Static Analysis Results Interchange Format"), the form that code
//! scanning services and editors take in.
//!
//! A run has one rule for each code that occurs. Lines and columns count from 1, columns in characters
//! (`unicodeCodePoints`). Where a diagnostic has no text to point into, it has the file alone; JSON pointers are
//! logical locations of the kind `object`.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};

use super::super::{Code, Diagnostic, Fix, Place};
use crate::source::{Sources, Span};

const SCHEMA: &str =
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";

/// Returns the diagnostics as one SARIF 2.1.0 log.
pub fn sarif<'a>(diagnostics: impl IntoIterator<Item = &'a Diagnostic>, sources: &Sources) -> Json {
    let diagnostics: Vec<&Diagnostic> = diagnostics.into_iter().collect();
    let codes: BTreeMap<&str, Code> =
        diagnostics.iter().map(|diagnostic| (diagnostic.code.id, diagnostic.code)).collect();
    let index = |id: &str| codes.keys().position(|known| *known == id).unwrap_or(0);
    let rules: Vec<Json> = codes.values().map(rule).collect();
    let results: Vec<Json> = diagnostics.iter().map(|one| result(one, index(one.code.id), sources)).collect();
    let driver = json!({
        "name": "umbragraph",
        "version": env!("CARGO_PKG_VERSION"),
        "informationUri": env!("CARGO_PKG_REPOSITORY"),
        "rules": rules,
    });
    let run = json!({ "tool": { "driver": driver }, "columnKind": "unicodeCodePoints", "results": results });
    json!({ "$schema": SCHEMA, "version": "2.1.0", "runs": [run] })
}

fn rule(code: &Code) -> Json {
    let words = code.title.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let name: String = words.map(|word| word[..1].to_uppercase() + &word[1..]).collect();
    json!({
        "id": code.id,
        "name": name,
        "shortDescription": { "text": code.title },
        "fullDescription": { "text": code.page },
        "help": { "text": code.page },
    })
}

fn result(diagnostic: &Diagnostic, rule_index: usize, sources: &Sources) -> Json {
    // What has no place of its own is a part of the message.
    let mut message = diagnostic.message.clone();
    for related in diagnostic.related.iter().filter(|related| related.place == Place::Nowhere) {
        message.push_str(&format!("\n{}", related.message));
    }
    message.extend(diagnostic.help.iter().map(|help| format!("\nhelp: {help}")));
    let primary = location(&diagnostic.place, &diagnostic.pointer, None, sources);
    let mut related: Vec<Json> = Vec::new();
    for one in &diagnostic.related {
        if let Some(mut place) = location(&one.place, "", Some(related.len()), sources) {
            place["message"] = json!({ "text": one.message });
            related.push(place);
        }
    }
    let mut result = json!({
        "ruleId": diagnostic.code.id,
        "ruleIndex": rule_index,
        "level": diagnostic.severity.name(),
        "message": { "text": message },
        "locations": primary.into_iter().collect::<Vec<Json>>(),
    });
    if !related.is_empty() {
        result["relatedLocations"] = related.into();
    }
    if let Some(fix) = diagnostic.fix.as_ref().and_then(|fix| mending(diagnostic, fix, sources)) {
        result["fixes"] = json!([fix]);
    }
    result
}

fn location(place: &Place, pointer: &str, id: Option<usize>, sources: &Sources) -> Option<Json> {
    let (artifact, region, pointer) = match place {
        Place::Span(span) => {
            let name = sources.get(span.file)?.name();
            (uri(name), region(*span, sources), super::in_file(name, pointer))
        }
        Place::File { path, locator } => (uri(path), None, locator.as_str()),
        Place::Nowhere => return None,
    };
    let mut location = id.map_or_else(|| json!({}), |id| json!({ "id": id }));
    location["physicalLocation"] = json!({ "artifactLocation": { "uri": artifact } });
    if let Some(region) = region {
        location["physicalLocation"]["region"] = region;
    }
    if !pointer.is_empty() {
        location["logicalLocations"] = json!([{ "fullyQualifiedName": pointer, "kind": "object" }]);
    }
    Some(location)
}

fn region(span: Span, sources: &Sources) -> Option<Json> {
    let file = sources.get(span.file)?;
    let (start, end) = (file.line_column(span.start), file.line_column(span.end));
    Some(json!({
        "startLine": start.line, "startColumn": start.column, "endLine": end.line, "endColumn": end.column,
    }))
}

fn mending(diagnostic: &Diagnostic, fix: &Fix, sources: &Sources) -> Option<Json> {
    let mut changes: BTreeMap<String, Vec<Json>> = BTreeMap::new();
    for edit in &fix.edits {
        let artifact = uri(sources.get(edit.span.file)?.name());
        changes.entry(artifact).or_default().push(json!({
            "deletedRegion": region(edit.span, sources)?,
            "insertedContent": { "text": edit.replacement },
        }));
    }
    let change = |(uri, list)| json!({ "artifactLocation": { "uri": uri }, "replacements": list });
    let changes: Vec<Json> = changes.into_iter().map(change).collect();
    let text = diagnostic.help.as_deref().unwrap_or("apply the fix");
    Some(json!({ "description": { "text": text }, "artifactChanges": changes }))
}

/// Returns a path as a URI reference (RFC 3986): a `file:` URI if it is absolute, otherwise a relative reference.
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
