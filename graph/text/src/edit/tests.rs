use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use serde_json::{Value as Json, json};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use super::*;
use crate::compose::{self, Files as _};
use crate::diagnostic::Diagnostics;
use crate::document::format::tests::{SPACES, comments, values, write};
use crate::document::{Kind, Value, parse};
use crate::model::{DeclarationKind, Id, Model};
use crate::source::{Sources, Span};

fn root(text: &str) -> Value {
    let mut sources = Sources::new();
    let file = sources.add("t.json", text);
    parse(&sources, file).valid().unwrap_or_else(|diagnostics| panic!("{diagnostics:?}\n{text}")).root
}

/// Applies an edit to the value at a JSON pointer, and returns the resulting text. Asserts that the result is valid
/// JSON, and that the inverse edit restores the original.
#[track_caller]
fn edited(text: &str, pointer: &str, edit: impl Fn(&str, &Value) -> Result<Edits, EditError>) -> String {
    let root = root(text);
    let edits = edit(text, root.nearest(pointer)).unwrap();
    let edited = edits.apply(text).unwrap();
    assert_eq!(edits.inverse(text).unwrap().apply(&edited).unwrap(), text);
    self::root(&edited);
    edited
}

#[track_caller]
fn inserts(text: &str, pointer: &str, at: usize, item: Item, expected: &str) {
    assert_eq!(edited(text, pointer, |text, value| insert(text, value, at, &item)), expected);
}

#[track_caller]
fn removes(text: &str, pointer: &str, at: usize, expected: &str) {
    assert_eq!(edited(text, pointer, |text, value| remove(text, value, at)), expected);
}

#[track_caller]
fn moves(text: &str, from: usize, to: usize, expected: &str) {
    assert_eq!(edited(text, "", |text, value| reorder(text, value, from, to)), expected);
}

const ROOMS: &str =
    "{ // all\n    \"a\": 1, // of a\n\n    // of b\n    \"b\": {},\n    \"c\": [1, 2 /* two */]\n}\n";

#[test]
fn new_members_are_laid_out_as_their_neighbours() {
    let item = || Item::member("x", json!([1, "y"]));
    inserts(ROOMS, "", 0, item(), &ROOMS.replace("    \"a\"", "    \"x\": [1, \"y\"],\n    \"a\""));
    inserts(ROOMS, "", 1, item(), &ROOMS.replace("of a\n", "of a\n    \"x\": [1, \"y\"],\n"));
    inserts(ROOMS, "", 2, item(), &ROOMS.replace("{},\n", "{},\n    \"x\": [1, \"y\"],\n"));
    inserts(ROOMS, "", 3, item(), &ROOMS.replace("*/]", "*/],\n    \"x\": [1, \"y\"]"));
    inserts(ROOMS, "/b", 0, item(), &ROOMS.replace("{}", "{ \"x\": [1, \"y\"] }"));
    inserts(ROOMS, "/c", 2, Item::element(json!(3)), &ROOMS.replace("2 /* two */", "2, /* two */ 3"));
    inserts("[]", "", 0, Item::element(json!({})), "[{}]");
    inserts("{ \"a\": 1 }", "", 1, item(), "{ \"a\": 1, \"x\": [1, \"y\"] }");
    inserts("{\n\t// none\n}", "", 0, item(), "{\n\t// none\n  \"x\": [1, \"y\"]\n}");
    inserts(
        "[\r\n\t1,\r\n\r\n\t2\r\n]",
        "",
        1,
        Item::element(json!(0)),
        "[\r\n\t1,\r\n\r\n\t0,\r\n\r\n\t2\r\n]",
    );
    inserts("[\n\n  1,\n\n  2\n]", "", 1, Item::element(json!(0)), "[\n\n  1,\n\n  0,\n\n  2\n]");
    inserts("[1, 2 // two\n]", "", 2, Item::element(json!(3)), "[1, 2, // two\n  3\n]");
}

#[test]
fn long_values_take_lines_with_the_text_s_indentation() {
    let word = "x".repeat(80);
    let item = Item::member("b", json!({ "c": word, "d": [word] }));
    inserts(
        "{\r\n\t\"a\": 1\r\n}",
        "",
        1,
        item.clone(),
        &format!(
            "{{\r\n\t\"a\": 1,\r\n\t\"b\": {{\r\n\t\t\"c\": \"{word}\",\r\n\t\t\"d\": [\"{word}\"]\r\n\t}}\r\n}}"
        ),
    );
    let set = |text: &str, value: &Value| set(text, value, &json!([word, word]));
    assert_eq!(
        edited("{\n    \"a\": null\n}", "/a", set),
        format!("{{\n    \"a\": [\n        \"{word}\",\n        \"{word}\"\n    ]\n}}")
            .replace(",\n        ", ",\n        ")
    );
}

#[test]
fn members_are_removed_with_their_comma_and_their_comments() {
    removes(ROOMS, "", 0, "{ // all\n    // of b\n    \"b\": {},\n    \"c\": [1, 2 /* two */]\n}\n");
    removes(ROOMS, "", 1, "{ // all\n    \"a\": 1, // of a\n\n    \"c\": [1, 2 /* two */]\n}\n");
    removes(ROOMS, "", 2, "{ // all\n    \"a\": 1, // of a\n\n    // of b\n    \"b\": {}\n}\n");
    removes(ROOMS, "/c", 0, &ROOMS.replace("[1, 2", "[2"));
    removes(ROOMS, "/c", 1, &ROOMS.replace("[1, 2 /* two */]", "[1]"));
    removes("{\n  \"a\": 1\n}", "", 0, "{}");
    removes("{ // all\n  \"a\": 1\n}", "", 0, "{ // all\n}");
    removes("{ // all\n  \"a\": 1 }", "", 0, "{ // all\n}");
    removes("[1, // one\n2, 3]", "", 1, "[1, // one\n3]");
    removes("[1, // one\n2]", "", 1, "[1 // one\n]");
    removes("[\n  // title\n\n  // one\n  1,\n  2\n]", "", 0, "[\n  // title\n\n  2\n]");
    removes("[1 // one\n, 2]", "", 1, "[1 // one\n]");
}

#[test]
fn members_move_with_their_comments() {
    moves("[1, 2, 3]", 0, 2, "[2, 3, 1]");
    moves("[1, 2, 3]", 2, 0, "[3, 1, 2]");
    moves("[1, 2]", 1, 1, "[1, 2]");
    moves(
        ROOMS,
        0,
        2,
        "{ // all\n    // of b\n    \"b\": {},\n    \"c\": [1, 2 /* two */],\n    \"a\": 1 // of a\n}\n",
    );
    moves(
        ROOMS,
        2,
        0,
        "{ // all\n    \"c\": [1, 2 /* two */],\n    \"a\": 1, // of a\n\n    // of b\n    \"b\": {}\n}\n",
    );
    moves("[1, // one\n 2]", 0, 1, "[2,\n 1 // one\n]");
    moves("[1 /* a */, 2, 3]", 0, 1, "[2, 1, /* a */ 3]");
}

#[test]
fn only_what_differs_is_set() {
    let text =
        "{\n  \"a\": [1, /* two */ 2, 3.50], // a\n  \"b\": { \"c\": \"\\u0041\", \"d\": null } // b\n}";
    let set_to = |new: Json| edited(text, "", |text, root| set(text, root, &new));
    assert_eq!(set_to(json!({ "a": [1, 2, 3.5], "b": { "c": "A", "d": null } })), text);
    assert_eq!(
        set_to(json!({ "a": [1, 7, 3.5], "b": { "c": "A" } })),
        text.replace(" 2,", " 7,").replace(", \"d\": null", "")
    );
    assert_eq!(
        set_to(json!({ "a": [1, 2, 5, 3.5], "x": 0, "b": { "c": "B", "d": 1 } })),
        text.replace(" 2,", " 2, 5,")
            .replace("// a\n", "// a\n  \"x\": 0,\n")
            .replace("\\u0041", "B")
            .replace("null", "1")
    );
    assert_eq!(set_to(json!([])), "[]");
}

#[test]
fn values_of_parameters_are_saved_as_defaults() {
    let text = "{\n  // What is lit.\n  \"parameters\": {\n    \"far\": { \"default\": [8, 25] }, // m\n    \"near\": { \"unit\": \"m\" }\n  }\n}\n";
    let save = |text: &str, root: &Value| {
        let values = [("far", json!([9, 25.5])), ("near", json!(0.1)), ("side", json!(64))];
        save(text, root, "parameters", values)
    };
    assert_eq!(
        edited(text, "", save),
        text.replace("[8, 25]", "[9, 25.5]")
            .replace("\"m\" }", "\"m\", \"default\": 0.1 },\n    \"side\": { \"default\": 64 }")
    );
    assert!(edited("{ \"name\": \"a\" }", "", save).starts_with("{ \"name\": \"a\", \"parameters\": {"));
    assert_eq!(super::save("[]", &root("[]"), "parameters", [("a", json!(1))]), Err(EditError::NoContainer));
}

#[test]
fn a_name_is_written_anew_wherever_it_stands() {
    let mut sources = Sources::new();
    let (a, b) = ("{ \"sun\": \"\\ud83d\\ude00 \\u0073un + \\\"ä\\\" sun\" }", "[\"sun\"]");
    let (first, second) = (sources.add("a", a), sources.add("b", b));
    let string = Span::new(first, 9..a.len() - 2);
    let place = |string: Span, range: Range<usize>| written(&sources, string, range).unwrap();
    let said = parse(&sources, first).valid().unwrap().root.get("sun").unwrap().text().unwrap().to_owned();
    let places: Vec<Span> = said.match_indices("sun").map(|(at, _)| place(string, at..at + 3)).collect();
    assert_eq!(places.iter().map(|one| sources.text(*one)).collect::<Vec<_>>(), ["\\u0073un", "sun"]);
    let all =
        places.into_iter().chain([place(Span::new(first, 2..7), 0..3), place(Span::new(second, 1..6), 0..3)]);
    let edits = rename(&sources, all, "\"x\"\n").unwrap();
    assert_eq!(edits["b"].apply(b).unwrap(), "[\"\\\"x\\\"\\n\"]");
    let renamed = "{ \"\\\"x\\\"\\n\": \"\\ud83d\\ude00 \\\"x\\\"\\n + \\\"ä\\\" \\\"x\\\"\\n\" }";
    assert_eq!(edits["a"].apply(a).unwrap(), renamed);
    assert_eq!(written(&sources, string, 1..3), None, "half a character");
    assert_eq!(written(&sources, string, 0..99), None, "beyond its end");
    assert!(rename(&sources, [Span::new(first, 0..999)], "x").is_err());
}

#[test]
fn edits_that_cannot_be_made_are_errors() {
    let text = "{ \"a\": [1, 2], \"b\": 3 }";
    let root = root(text);
    let (array, scalar) = (root.get("a").unwrap(), root.get("b").unwrap());
    assert_eq!(remove(text, scalar, 0), Err(EditError::NoContainer));
    assert_eq!(remove(text, array, 2), Err(EditError::NoPosition { at: 2, count: 2 }));
    assert_eq!(
        insert(text, &root, 3, &Item::member("c", json!(1))),
        Err(EditError::NoPosition { at: 3, count: 3 })
    );
    assert_eq!(
        insert(text, &root, 0, &Item::member("a", json!(1))),
        Err(EditError::KeyTaken("a".to_owned()))
    );
    assert_eq!(insert(text, array, 0, &Item::member("a", json!(1))), Err(EditError::Key));
    assert_eq!(reorder(text, array, 0, 2), Err(EditError::NoPosition { at: 2, count: 2 }));
    assert!(matches!(remove("{}", array, 0), Err(EditError::Outside(_))));
    let [first, second] = [0, 1].map(|at| remove(text, array, at).unwrap());
    assert!(matches!(first.and(&second), Err(EditError::Overlap(..))), "both would remove the comma");
    assert!(first.and(&first).is_err(), "it can be removed once");
    assert!(first.apply("{ \"ä\"").is_err());
}

#[test]
fn a_text_that_is_broken_elsewhere_can_be_edited() {
    let (whole, broken) = ("{ \"a\": [1, 2], \"b\": 3 }", "{ \"a\": [1, 2], \"b\": } }");
    let edits = remove(broken, root(whole).get("a").unwrap(), 0).unwrap();
    assert_eq!(edits.apply(broken).unwrap(), "{ \"a\": [2], \"b\": } }");
}

/// Composes the document at `path` from files in memory, and builds its model.
fn model(files: &compose::Memory, path: &str) -> Option<(Sources, compose::Composed, Model)> {
    let (mut files, mut sources, mut diagnostics) = (files.clone(), Sources::new(), Diagnostics::new());
    let file = files.read(Path::new(path), &mut sources).unwrap();
    let composed = compose::compose(file, Path::new(path), &mut files, &mut sources, &mut diagnostics);
    assert!(!diagnostics.has_errors(), "{path}: {diagnostics:?}");
    let composed = composed?;
    let model = Model::new(&composed.document);
    Some((sources, composed, model))
}

/// Returns the kind, name and number of uses of every declaration, sorted. In the result, the name `old` is replaced by
/// `new`.
fn declared(model: &Model, old: &str, new: &str) -> Vec<(DeclarationKind, String, usize)> {
    let name = |name: &str| if name == old { new.to_owned() } else { name.to_owned() };
    let mut all: Vec<_> = model
        .declarations()
        .map(|(id, one)| (one.kind, name(&one.name), model.uses_of(id).count()))
        .collect();
    all.sort();
    all
}

/// Applies edits to files in memory.
fn change(files: &compose::Memory, edits: &BTreeMap<String, Edits>) -> compose::Memory {
    let mut changed = files.clone();
    for (name, edits) in edits {
        let text = changed.0.get_mut(name).unwrap();
        let edited = edits.apply(text).unwrap();
        assert_eq!(edits.inverse(text).unwrap().apply(&edited).unwrap(), *text);
        *text = edited;
    }
    changed
}

#[test]
fn a_declaration_is_renamed_in_every_file_that_names_it() {
    let base = r#"{ "parameters": { "far": { "type": "f32", "default": 1 } },
  "derived": { "near": "= far / 2 + \u0066ar_away" /* far */ },
  "resources": { "target": { "texture": { "size": ["=far", "=target.far"] } } },
  "passes": { "far": { "draw": { "bind": { "far": "&target@far", "x": "=far * 2" } } } } }"#;
    let main = r#"{ "extends": "base.json", "parameters": { "far": { "default": 2 } },
  "derived": { "far_away": "=\u0066ar" },
  "presets": { "low": { "parameters": { "far": 3 } } } }"#;
    let files =
        [("base.json", base), ("main.json", main)].map(|(name, text)| (name.to_owned(), text.to_owned()));
    let files = compose::Memory(files.into_iter().collect());
    let (sources, composed, model) = model(&files, "main.json").unwrap();
    let id = model.find(DeclarationKind::Parameter, "far").unwrap();
    let renamed = |name: &str| rename_declaration(&sources, &composed, &model, id, name);
    let changed = change(&files, &renamed("reach").unwrap());
    assert_eq!(
        changed.0["main.json"],
        main.replace("\"far\"", "\"reach\"").replace("\\u0066ar\"", "reach\"")
    );
    assert_eq!(
        changed.0["base.json"],
        base.replacen("\"far\"", "\"reach\"", 1).replace("=far", "=reach").replace("= far", "= reach")
    );
    assert_eq!(renamed("near"), Err(EditError::KeyTaken("near".to_owned())));
    assert_eq!(renamed("a b"), Err(EditError::NoName("a b".to_owned())));
}

#[test]
fn renamed_declarations_of_pipelines_keep_their_uses() {
    let mut found = Vec::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines");
    documents(&folder, &mut found);
    found.sort();
    let name = |path: &PathBuf| path.strip_prefix(&folder).unwrap().to_string_lossy().replace('\\', "/");
    let text = |path: &PathBuf| (name(path), std::fs::read_to_string(path).unwrap());
    let files = compose::Memory(found.iter().map(text).collect());
    let (mut random, mut renamed) = (Random(property::seed()), 0);
    for path in files.0.keys().filter(|path| !["params", "parts"].iter().any(|part| path.contains(part))) {
        let Some((sources, composed, before)) = model(&files, path) else { continue };
        let all: Vec<Id> = before.declarations().map(|(id, _)| id).collect();
        for _ in 0..3 * property::times() {
            let id = random.one_of(&all);
            let declaration = before.declaration(id);
            let edits = match rename_declaration(&sources, &composed, &before, id, "renamed") {
                Err(EditError::NotWritten { .. } | EditError::NoName(_)) => continue,
                edits => edits.unwrap_or_else(|error| panic!("{path}: {}: {error}", declaration.name)),
            };
            let changed = change(&files, &edits);
            let (_, _, after) = model(&changed, path).unwrap();
            let (old, new) = (declaration.name.as_str(), "renamed");
            let mut expected = declared(&before, old, old);
            let uses = before.uses_of(id).count();
            let is_it =
                |one: &(DeclarationKind, String, usize)| *one == (declaration.kind, old.to_owned(), uses);
            expected.iter_mut().find(|one| is_it(one)).unwrap().1 = new.to_owned();
            expected.sort();
            assert_eq!(declared(&after, new, new), expected, "{path}: {old}");
            renamed += 1;
        }
    }
    assert!(renamed > 50, "{renamed}");
}

/// A random edit of a text, with its expected result.
struct RandomEdit {
    edits: Edits,
    /// The JSON value that the edited text should have.
    expected: Json,
    /// Whether the edit removes values, and perhaps comments with them.
    removes: bool,
}

fn random_edit(text: &str, random: &mut Random) -> RandomEdit {
    fn containers(value: &Value, pointer: String, found: &mut Vec<String>) {
        match &value.kind {
            Kind::Array(elements) => {
                let inside = elements.iter().enumerate();
                inside.for_each(|(at, one)| containers(one, format!("{pointer}/{at}"), found));
            }
            Kind::Object(entries) => entries.iter().for_each(|entry| {
                containers(&entry.value, crate::document::pointer_join(&pointer, &entry.key), found);
            }),
            _ => return,
        }
        found.push(pointer);
    }
    let root = root(text);
    let mut expected = root.to_json();
    let mut pointers = Vec::new();
    containers(&root, String::new(), &mut pointers);
    if pointers.is_empty() {
        let new = json!({ "now": [text.len()] });
        return RandomEdit { edits: set(text, &root, &new).unwrap(), expected: new, removes: false };
    }
    let pointer = random.one_of(&pointers);
    let (value, json) = (root.nearest(&pointer), expected.pointer_mut(&pointer).unwrap());
    let count = value.elements().map_or_else(|| value.entries().unwrap().len(), <[Value]>::len);
    let new = random.one_of(&[json!(null), json!("ä\n\""), json!([1, { "n": -0.5 }]), json!("y".repeat(90))]);
    let (at, to) = (random.below(count), random.below(count));
    let kind = random.below(if count == 0 { 2 } else { 5 });
    let edits = match (kind, json) {
        (0, json @ (Json::Array(_) | Json::Object(_))) => {
            *json = new.clone();
            set(text, value, &new)
        }
        (1, Json::Array(list)) => {
            let at = random.below(count + 1);
            list.insert(at, new.clone());
            insert(text, value, at, &Item::element(new))
        }
        (1, Json::Object(map)) => {
            let (at, key) = (random.below(count + 1), format!("new {}", random.next()));
            map.shift_insert(at, key.clone(), new.clone());
            insert(text, value, at, &Item::member(key, new))
        }
        (2, Json::Array(list)) => {
            list.remove(at);
            remove(text, value, at)
        }
        (2, Json::Object(map)) => {
            let key = map.keys().nth(at).unwrap().clone();
            map.shift_remove(&key);
            remove(text, value, at)
        }
        (3, Json::Array(list)) => {
            let one = list.remove(at);
            list.insert(to, one);
            reorder(text, value, at, to)
        }
        (3, Json::Object(map)) => {
            let key = map.keys().nth(at).unwrap().clone();
            let one = map.shift_remove(&key).unwrap();
            map.shift_insert(to, key, one);
            reorder(text, value, at, to)
        }
        (_, json) => {
            *json = match json.take() {
                Json::Array(mut list) => {
                    list.truncate(at);
                    list.into()
                }
                whole => json!({ "first": new, "rest": whole }),
            };
            let new = json.clone();
            set(text, value, &new)
        }
    };
    let edits = edits.unwrap_or_else(|error| panic!("{error} in\n{text}"));
    RandomEdit { edits, expected, removes: kind != 1 && kind != 3 }
}

/// Applies `count` random edits to a text one after the other, and undoes them. Asserts that edits, inverses and
/// combined edits give the expected texts.
fn edit_and_undo(first: &str, count: usize, random: &mut Random) {
    let (mut text, mut all) = (first.to_owned(), Edits::default());
    let mut undo = Vec::new();
    for _ in 0..count {
        let RandomEdit { edits, expected, removes } = random_edit(&text, random);
        let edited = edits.apply(&text).unwrap();
        // As `Map`s are equal in any order, and the order of members counts.
        assert_eq!(root(&edited).to_json().to_string(), expected.to_string(), "{text}\n-- became\n{edited}");
        let inverse = edits.inverse(&text).unwrap();
        assert_eq!(inverse.apply(&edited).unwrap(), text);
        assert_eq!(inverse.inverse(&edited).unwrap().apply(&text).unwrap(), edited);
        keeps_comments(&text, &edits, &edited, removes);
        let others = random_edit(&text, random).edits;
        if let Ok(both) = edits.and(&others) {
            // From behind, no edit moves those that are still to be made.
            let one_by_one = both
                .iter()
                .rev()
                .fold(text.clone(), |text, edit| Edits::new([edit.clone()]).unwrap().apply(&text).unwrap());
            assert_eq!(both.apply(&text).unwrap(), one_by_one);
            root(&one_by_one);
        }
        all = all.then(&edits);
        assert_eq!(all.apply(first).unwrap(), edited);
        undo.push(inverse);
        text = edited;
    }
    assert_eq!(all.inverse(first).unwrap().apply(&text).unwrap(), first);
    let undone = undo.iter().rev().fold(text, |text, inverse| inverse.apply(&text).unwrap());
    assert_eq!(undone, first);
}

/// Asserts that all comments are kept, except those in removed ranges.
fn keeps_comments(text: &str, edits: &Edits, edited: &str, removes: bool) {
    let mut left = comments(edited);
    let removed: String = edits.iter().map(|edit| text[edit.range.clone()].to_owned() + "\n").collect();
    for comment in comments(text) {
        match left.iter().position(|one| *one == comment) {
            Some(at) => _ = left.remove(at),
            None => assert!(
                removes && removed.split_whitespace().collect::<Vec<_>>().join(" ").contains(&comment),
                "\"{comment}\" is lost\n{text}\n-- became\n{edited}"
            ),
        }
    }
    assert!(left.is_empty(), "new comments: {left:?}\n{text}\n-- became\n{edited}");
}

fn documents(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            documents(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "json") {
            found.push(path);
        }
    }
}

#[test]
fn random_edits_of_every_pipeline_are_exact_and_undone() {
    let mut found = Vec::new();
    documents(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines"), &mut found);
    found.sort();
    assert!(found.len() > 20);
    let mut random = Random(property::seed());
    for path in found {
        let text = std::fs::read_to_string(path).unwrap();
        let windows = text.replace('\n', "\r\n");
        edit_and_undo(&text, 6, &mut random);
        edit_and_undo(&windows, 6, &mut random);
        let edited = random_edit(&windows, &mut random).edits.apply(&windows).unwrap();
        assert!(!edited.replace("\r\n", "").contains(['\n', '\r']), "one kind of line end: {edited}");
    }
}

proptest! {
    #![proptest_config(property::config(600))]

    #[test]
    fn random_edits_of_random_texts_are_exact_and_undone(
        value in values(),
        choices in prop::collection::vec(0..SPACES.len(), 1..120),
        share in 1usize..12,
        seed in any::<u64>(),
    ) {
        let mut at = 0;
        let mut space = || {
            at += 1;
            if at % share == 0 { SPACES[choices[at / share % choices.len()]] } else { "" }
        };
        let mut text = space().to_owned();
        write(&value, &mut space, &mut text);
        text.push_str(space());
        edit_and_undo(&text, 4, &mut Random(seed));
    }
}
