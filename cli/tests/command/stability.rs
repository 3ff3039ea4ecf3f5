//! Names that users write down stay: `tests/stable/names.txt` lists them, and documents of `tests/stable/` go on working.
//!
//! A name is a key of a file (`texture.format`: a key below another), a word of a key, a code, a subcommand or an option.
//! The list only grows: a new name is added with `UMBRAGRAPH_BLESS=1`; one that is gone has to be given back, or the
//! number of the format rises (docs/stability.md).

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::Command;

use serde_json::{Map, Value};

/// The kinds of files that have a schema, each with its language; a key has the same meaning throughout a language.
const KINDS: [(&str, &str); 5] = [
    ("pipeline", "document"),
    ("extension", "document"),
    ("subgraph", "document"),
    ("parameters", "parameters"),
    ("axes", "axes"),
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Runs the command. Returns the exit status, and standard output followed by standard error.
fn run(arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    let output = command.args(arguments).current_dir(root()).output().expect("the command");
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("UTF-8");
    (output.status.code(), text(&output.stdout) + &text(&output.stderr))
}

/// The keys and words that a schema allows, each below its parent key.
struct Words<'a> {
    definitions: &'a Map<String, Value>,
    seen: BTreeSet<(&'a str, String)>,
    found: BTreeSet<String>,
}

impl<'a> Words<'a> {
    fn walk(&mut self, schema: &'a Value, below: &str) {
        let Value::Object(rules) = schema else {
            return schema.as_array().into_iter().flatten().for_each(|one| self.walk(one, below));
        };
        for (keyword, rule) in rules {
            match keyword.as_str() {
                "$ref" => {
                    let name =
                        rule.as_str().and_then(|text| text.strip_prefix("#/$defs/")).expect("a definition");
                    if self.seen.insert((name, below.to_owned())) {
                        self.walk(&self.definitions[name], below);
                    }
                }
                "properties" => {
                    for (key, value) in rule.as_object().expect("keys") {
                        self.found.insert(format!("{below}.{key}"));
                        self.walk(value, key);
                    }
                }
                "patternProperties" => {
                    rule.as_object().expect("patterns").values().for_each(|value| self.walk(value, below));
                }
                "enum" => self
                    .found
                    .extend(rule.as_array().expect("words").iter().map(|word| format!("{below} = {word}"))),
                "const" => _ = self.found.insert(format!("{below} = {rule}")),
                // A name of the user's own stands between.
                "additionalProperties" => self.walk(rule, &format!("{}.*", below.trim_end_matches(".*"))),
                "allOf" | "anyOf" | "oneOf" | "items" | "prefixItems" | "then" | "else" => {
                    self.walk(rule, below);
                }
                _ => {}
            }
        }
    }
}

fn words_of_files(kind: &str, language: &str) -> BTreeSet<String> {
    let schema: Value = serde_json::from_str(&run(&["schema", "--of", kind]).1).expect("a schema");
    let none = Map::new();
    let definitions = schema.get("$defs").and_then(Value::as_object).unwrap_or(&none);
    let mut words = Words { definitions, seen: BTreeSet::new(), found: BTreeSet::new() };
    words.walk(&schema, "");
    words.found.iter().map(|word| format!("{language}: {word}")).collect()
}

/// Returns the diagnostic codes that the reference lists.
fn codes() -> BTreeSet<String> {
    let page = std::fs::read_to_string(root().join("docs/reference/diagnostics.md")).unwrap();
    let starts = page.match_indices("UG").filter_map(|(at, _)| page.get(at..at + 6));
    starts
        .filter(|code| code[2..].bytes().all(|byte| byte.is_ascii_digit()))
        .map(|code| format!("code: {code}"))
        .collect()
}

/// Returns the subcommands and their long options.
fn options() -> BTreeSet<String> {
    let (_, help) = run(&["--help"]);
    let list = help
        .split("Commands:")
        .nth(1)
        .expect("the list of commands")
        .split("\n\n")
        .next()
        .unwrap_or_default();
    let names = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names: Vec<&str> =
        names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect();
    assert!(names.len() > 10, "{help}");
    let mut found = BTreeSet::new();
    for name in names {
        found.insert(format!("command: {name}"));
        for line in run(&[name, "--help"]).1.lines().map(str::trim_start).filter(|line| line.starts_with('-'))
        {
            let option = line.split([' ', ',', '[', '=']).find(|word| word.starts_with("--"));
            let option = option.filter(|option| *option != "--help");
            found.extend(option.map(|option| format!("command: {name} {option}")));
        }
    }
    found
}

#[test]
fn names_of_the_first_format_are_still_there() {
    let path = root().join("tests/stable/names.txt");
    let stable: BTreeSet<String> =
        std::fs::read_to_string(&path).unwrap_or_default().lines().map(str::to_owned).collect();
    let mut current: BTreeSet<String> =
        KINDS.iter().flat_map(|(kind, language)| words_of_files(kind, language)).collect();
    current.extend(codes());
    current.extend(options());
    let gone: Vec<&String> = stable.difference(&current).collect();
    assert!(gone.is_empty(), "stable names are gone (docs/stability.md): {gone:#?}");
    if std::env::var_os("UMBRAGRAPH_BLESS").is_some() {
        let lines: Vec<String> = current.iter().map(|name| format!("{name}\n")).collect();
        return std::fs::write(&path, lines.concat()).unwrap();
    }
    let new: Vec<&String> = current.difference(&stable).collect();
    assert!(
        new.is_empty(),
        "new names: UMBRAGRAPH_BLESS=1 cargo nextest run -p umbragraph-cli stability promises to keep them: {new:#?}"
    );
}

#[test]
fn documents_of_the_first_format_are_still_valid() {
    let folder = root().join("tests/stable/format-1");
    let mut files: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .map(|path| path.to_string_lossy().into_owned())
        .collect();
    files.sort();
    assert!(files.len() >= 27, "{files:?}");
    let arguments: Vec<&str> = ["check"].into_iter().chain(files.iter().map(String::as_str)).collect();
    let (status, text) = run(&arguments);
    assert_eq!(status, Some(0), "{text}");
    assert!(!text.contains("error") && !text.contains("warning"), "{text}");
}
