//! The committed schema as an editor reads it: every file of the tree conforms as it is written, and broken ones do
//! not.
//!
//! The validator here is the plain one of the specification, every keyword on its own, and shares no code with the
//! loader's. A keyword that it does not know fails the test instead of passing for satisfied.

use std::path::{Path, PathBuf};

use crate::common::root;
use serde_json::{Value, json};
use umbragraph::low_level::document;
use umbragraph::low_level::pipeline::{FileKind, schema_of};
use umbragraph::low_level::source::Sources;

/// Says nothing of what is valid.
const SILENT: &[&str] = &["$schema", "$defs", "title", "description", "default", "format"];

struct Validator<'a> {
    root: &'a Value,
}

impl Validator<'_> {
    /// The rules that a value breaks, each with its pointer.
    fn violations(&self, value: &Value, schema: &Value, at: &str) -> Vec<String> {
        let Value::Object(rules) = schema else {
            assert!(schema.is_boolean(), "{schema}");
            return if schema == &json!(true) { Vec::new() } else { vec![format!("{at}: nothing fits")] };
        };
        let fits = |schema: &Value| self.violations(value, schema, at).is_empty();
        let list = |words: &Value| words.as_array().expect("a list").clone();
        let mut violations = Vec::new();
        let mut want = |holds: bool, what: &str| {
            if !holds {
                violations.push(format!("{at}: {what}"));
            }
        };
        let mut below: Vec<String> = Vec::new();
        for (keyword, rule) in rules {
            match keyword.as_str() {
                "$ref" => {
                    let pointer =
                        rule.as_str().and_then(|text| text.strip_prefix('#')).expect("a local reference");
                    let target =
                        self.root.pointer(pointer).unwrap_or_else(|| panic!("{pointer} leads nowhere"));
                    below.extend(self.violations(value, target, at));
                }
                "type" => {
                    let types = if rule.is_array() { list(rule) } else { vec![rule.clone()] };
                    want(
                        types.iter().any(|one| is_of_type(value, one.as_str().unwrap_or_default())),
                        &format!("is no {rule}"),
                    );
                }
                "enum" => want(list(rule).contains(value), "is none of the words"),
                "const" => want(rule == value, &format!("is not {rule}")),
                "not" => want(!fits(rule), "is what it must not be"),
                "allOf" => below.extend(list(rule).iter().flat_map(|one| self.violations(value, one, at))),
                "anyOf" => want(list(rule).iter().any(fits), "fits none of the alternatives"),
                "oneOf" => {
                    want(list(rule).iter().filter(|one| fits(one)).count() == 1, "does not fit exactly one");
                }
                "if" => {
                    let then = rules.get(if fits(rule) { "then" } else { "else" });
                    below.extend(then.into_iter().flat_map(|then| self.violations(value, then, at)));
                }
                "then" | "else" => assert!(rules.contains_key("if")),
                "required" => {
                    if let Some(object) = value.as_object() {
                        for key in list(rule) {
                            want(object.contains_key(key.as_str().unwrap()), &format!("{key} is required"));
                        }
                    }
                }
                "properties" => {
                    for (key, rule) in rule.as_object().expect("an object") {
                        let Some(member) = value.as_object().and_then(|object| object.get(key)) else {
                            continue;
                        };
                        below.extend(self.violations(member, rule, &format!("{at}/{key}")));
                    }
                }
                "additionalProperties" => {
                    let known = rules.get("properties").and_then(Value::as_object);
                    for (key, member) in value.as_object().into_iter().flatten() {
                        if known.is_none_or(|known| !known.contains_key(key)) {
                            below.extend(self.violations(member, rule, &format!("{at}/{key}")));
                        }
                    }
                }
                "items" => {
                    let before = rules.get("prefixItems").and_then(Value::as_array).map_or(0, Vec::len);
                    for (index, element) in value.as_array().into_iter().flatten().enumerate().skip(before) {
                        below.extend(self.violations(element, rule, &format!("{at}/{index}")));
                    }
                }
                "prefixItems" => {
                    let elements = value.as_array().into_iter().flatten().zip(list(rule));
                    for (index, (element, rule)) in elements.enumerate() {
                        below.extend(self.violations(element, &rule, &format!("{at}/{index}")));
                    }
                }
                "minItems" => want(
                    value.as_array().is_none_or(|list| list.len() as u64 >= rule.as_u64().unwrap()),
                    "is too short",
                ),
                "maxItems" => want(
                    value.as_array().is_none_or(|list| list.len() as u64 <= rule.as_u64().unwrap()),
                    "is too long",
                ),
                "minimum" => {
                    want(
                        value.as_f64().is_none_or(|number| number >= rule.as_f64().unwrap()),
                        "is too small",
                    );
                }
                "maximum" => {
                    want(
                        value.as_f64().is_none_or(|number| number <= rule.as_f64().unwrap()),
                        "is too great",
                    );
                }
                "pattern" => {
                    let signs: &[char] = match rule.as_str() {
                        Some("^=") => &['='],
                        Some("^[&=]") => &['&', '='],
                        other => panic!("the pattern {other:?} is not known here"),
                    };
                    want(value.as_str().is_none_or(|text| text.starts_with(signs)), "does not match");
                }
                silent => assert!(SILENT.contains(&silent), "the keyword {silent} is not known here"),
            }
        }
        violations.extend(below);
        violations
    }
}

fn is_of_type(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        _ => panic!("{name} is no type"),
    }
}

fn committed() -> Value {
    serde_json::from_str(&std::fs::read_to_string(root().join("pipeline.schema.json")).unwrap()).unwrap()
}

fn violations(schema: &Value, value: &Value) -> Vec<String> {
    Validator { root: schema }.violations(value, schema, "")
}

/// A file as it is written, not composed, without its comments.
fn read(path: &Path) -> Value {
    let mut sources = Sources::new();
    let file = sources.add(path.to_string_lossy(), std::fs::read_to_string(path).unwrap());
    document::parse(&sources, file).valid().unwrap_or_else(|_| panic!("{}", path.display())).root.to_json()
}

/// The JSON files in a folder and below.
fn files(folder: &str) -> Vec<PathBuf> {
    let mut waiting = vec![root().join(folder)];
    let mut files = Vec::new();
    while let Some(folder) = waiting.pop() {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            match entry.path() {
                path if path.is_dir() => waiting.push(path),
                path if path.extension().is_some_and(|extension| extension == "json") => files.push(path),
                _ => {}
            }
        }
    }
    files.sort();
    files
}

#[test]
fn every_file_that_names_the_schema_conforms_to_it() {
    let schema = committed();
    let mut count = 0;
    for path in files("pipelines").into_iter().chain(files("examples")) {
        let value = read(&path);
        let Some(named) = value["$schema"].as_str() else { continue };
        let named = path.parent().unwrap().join(named).canonicalize().unwrap();
        assert_eq!(named, root().join("pipeline.schema.json").canonicalize().unwrap(), "{}", path.display());
        assert_eq!(violations(&schema, &value), Vec::<String>::new(), "{}", path.display());
        count += 1;
    }
    assert!(count >= 29, "{count} files");
}

#[test]
fn files_of_the_other_kinds_conform_to_theirs() {
    let kinds = [
        (FileKind::Extension, vec![root().join("pipelines/learn/parts/echo.json")]),
        (FileKind::Subgraph, {
            let own = [
                "pipelines/learn/parts/through_small.json",
                "pipelines/parts/blur.json",
                "pipelines/parts/blur_tiles.json",
                "pipelines/parts/mips.json",
            ];
            own.map(|path| root().join(path)).to_vec()
        }),
        (FileKind::Parameters, files("pipelines/params")),
        (FileKind::Parameters, vec![root().join("pipelines/learn/parts/wide.json")]),
    ];
    for (kind, paths) in kinds {
        let schema = schema_of(kind, &umbragraph::registry());
        for path in paths {
            assert_eq!(violations(&schema, &read(&path)), Vec::<String>::new(), "{}", path.display());
        }
    }
    let schema = |kind| schema_of(kind, &umbragraph::registry());
    let settings =
        json!({ "format": 1, "name": "x", "inserts": { "point": { "a": { "copy": { "form": 1 } } } } });
    assert!(!violations(&schema(FileKind::Extension), &settings).is_empty(), "settings of passes too");
    let subgraph = json!({ "inputs": {}, "passes": { "a": { "fullscreen": 1 } } });
    assert!(!violations(&schema(FileKind::Subgraph), &subgraph).is_empty());
    assert!(!violations(&schema(FileKind::Parameters), &json!({ "parametres": {} })).is_empty());
}

/// A sound document, and one that is laid over it.
fn whole() -> Value {
    read(&root().join("pipelines/learn/22-contents.json"))
}

#[test]
fn missing_keys_are_errors_unless_the_file_extends_another() {
    let schema = committed();
    let required = [
        "/passes",
        "/name",
        "/resources/target/texture/format",
        "/passes/wave/compute/shader",
        "/passes/draw/mesh/shader",
    ];
    for pointer in required {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let mut lacking = whole();
        let Some(object) = lacking.pointer_mut(parent).and_then(Value::as_object_mut) else {
            panic!("{pointer}")
        };
        assert!(object.remove(key).is_some(), "{pointer}");
        assert!(!violations(&schema, &lacking).is_empty(), "{pointer} is missing");
        lacking["extends"] = "base.json".into();
        assert_eq!(
            violations(&schema, &lacking),
            Vec::<String>::new(),
            "{pointer} may stand in the file below"
        );
        let mut deleted = whole();
        *deleted.pointer_mut(pointer).unwrap() = Value::Null;
        assert!(!violations(&schema, &deleted).is_empty(), "{pointer} is null");
        deleted["extends"] = "base.json".into();
        assert_eq!(violations(&schema, &deleted), Vec::<String>::new(), "{pointer} may be deleted");
    }
}

#[test]
fn what_is_wrong_is_an_error_in_a_file_that_extends_another_too() {
    let schema = committed();
    let over = |value: Value| {
        let mut document = json!({ "format": 1, "name": "x", "extends": "base.json" });
        document.as_object_mut().unwrap().extend(value.as_object().unwrap().clone());
        violations(&schema, &document)
    };
    assert_eq!(
        over(json!({ "passes": { "a": null, "b": { "fullscreen": { "shader": "s" } } } })),
        Vec::<String>::new()
    );
    let wrong = [
        json!({ "pases": {} }),
        json!({ "resources": { "a": { "texture": { "formt": "r8unorm" } } } }),
        json!({ "resources": { "a": { "texture": { "lifetime": "for ever" } } } }),
        json!({ "resources": { "a": { "sampler": {} } } }),
        json!({ "passes": { "a": { "fullscreen": { "shader": 1 } } } }),
        json!({ "passes": { "a": { "fullscrean": {} } } }),
        // Lists are replaced as a whole.
        json!({ "passes": { "a": { "fullscreen": { "color": [{ "clear": [0, 0, 0, 1] }] } } } }),
        json!({ "parameters": { "a": { "type": "f23" } } }),
    ];
    for document in wrong {
        assert!(!over(document.clone()).is_empty(), "{document}");
    }
}

#[test]
fn every_key_is_explained() {
    let schema = committed();
    let mut unexplained = Vec::new();
    for (name, definition) in schema["$defs"].as_object().unwrap() {
        let demands = name.starts_with("Whole");
        for (key, property) in definition["properties"].as_object().into_iter().flatten().filter(|_| !demands)
        {
            let referred =
                property["$ref"].as_str().and_then(|to| schema.pointer(to.trim_start_matches('#')));
            let told = |one: &Value| one["description"].is_string();
            if !told(property) && !referred.is_some_and(told) {
                unexplained.push(format!("{name}.{key}"));
            }
        }
    }
    assert_eq!(unexplained, Vec::<String>::new());
}
