//! Changes of a graph as edits of its texts: exact where one example shows them, and on the documents of `pipelines/`
//! at random, where comments stay, texts parse, and the inverse gives every text back.

use std::collections::BTreeMap;
use std::path::Path;

use umbragraph::low_level::document::{self, Kind, Value};
use umbragraph::low_level::edit::Edits;
use umbragraph::low_level::session::{Change, Changes, Session, Target};
use umbragraph::low_level::source::Sources;
use umbragraph::{DiskStorage, with_templates};
use umbragraph_test_support::edits::documents;
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use crate::session::{choice, plan, session, shown};

/// Random changes of all documents together.
const CHANGES: usize = 300;

const TWO: &str = r#"{
  "format": 1, "name": "two",
  "resources": {
    "sharp": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "shared_settings": {
    "copying": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&sharp" }, "color": [{ "to": "&target" }] } }
  },
  "passes": {
    // The first.
    "paint": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&sharp" }] } },
    // The second.
    "show": { "extends": "copying", "after": ["paint"] }, // Behind it.
    "veil": {
      "extends": "copying", "after": ["show"],
      "fullscreen": { "color": [{ "to": "&target", "blend": "add" }] }
    }
  }
}
"#;

fn two() -> Session {
    session(&[("two.json", TWO)])
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn change(session: &mut Session, path: &str, change: &Change) -> Changes {
    session.change(&Target::new(path), &choice(), change).expect("nothing cancels").expect("a document")
}

/// The text after a change, which the inverse takes back.
#[track_caller]
fn changed(text: &str, one: &Change) -> String {
    let edits = change(&mut session(&[("two.json", text)]), "two.json", one)
        .unwrap_or_else(|error| panic!("{error}"));
    let edits = edits.get("two.json").cloned().unwrap_or_default();
    let changed = edits.apply(text).expect("edits of the text");
    assert_eq!(edits.inverse(text).and_then(|inverse| inverse.apply(&changed)).as_deref(), Ok(text));
    changed
}

fn connect(pass: &str, slot: &[&str], to: &str) -> Change {
    Change::Connect { pass: pass.to_owned(), slot: names(slot), to: to.to_owned() }
}

#[test]
fn slots_are_what_a_pass_refers_to_or_could() {
    let mut session = two();
    let mut slots = |pass: &str| -> Vec<(String, Option<String>)> {
        let slots = session.slots(&Target::new("two.json"), &choice(), pass).expect("nothing cancels");
        slots.into_iter().map(|slot| (slot.label, slot.value)).collect()
    };
    let some = |label: &str, value: &str| (label.to_owned(), Some(value.to_owned()));
    assert_eq!(slots("paint"), [some("color 0", "&sharp"), ("color 1".to_owned(), None)]);
    assert_eq!(slots("veil")[..2], [some("source", "&sharp"), some("color 0", "&target")]);
    assert_eq!(slots("nothing"), []);
}

#[test]
fn connected_slot_is_written_where_it_stands() {
    let written = changed(TWO, &connect("paint", &["fullscreen", "color", "0", "to"], "&target"));
    assert_eq!(written, TWO.replacen("[{ \"to\": \"&sharp\" }]", "[{ \"to\": \"&target\" }]", 1));
    let more = changed(TWO, &connect("paint", &["fullscreen", "color", "1", "to"], "&target"));
    assert_eq!(
        more,
        TWO.replacen("[{ \"to\": \"&sharp\" }]", "[{ \"to\": \"&sharp\" }, { \"to\": \"&target\" }]", 1)
    );
}

#[test]
fn shared_slot_is_written_over_in_the_pass_alone() {
    let written = changed(TWO, &connect("show", &["fullscreen", "bind", "source"], "&target"));
    let over = "\"after\": [\"paint\"], \"fullscreen\": { \"bind\": { \"source\": \"&target\" } } },";
    assert_eq!(written, TWO.replacen("\"after\": [\"paint\"] },", over, 1));
    let refused =
        change(&mut two(), "two.json", &connect("show", &["fullscreen", "color", "0", "to"], "&sharp"));
    assert!(
        refused.unwrap_err().to_string().contains("\"color 0\" is part of a list"),
        "others take it over, too"
    );
}

#[test]
fn pass_is_switched_off_and_on_again() {
    let switch = |on| Change::Switch { pass: "paint".to_owned(), on };
    let off = changed(TWO, &switch(false));
    assert_eq!(off, TWO.replacen("\"paint\": { ", "\"paint\": { \"when\": false, ", 1));
    assert_eq!(changed(&off, &switch(true)), TWO);
    let when = TWO.replacen("\"paint\": { ", "\"paint\": { \"when\": \"=viewport.width > 4\", ", 1);
    let off = changed(&when, &switch(false));
    assert!(off.contains("\"when\": \"=false && (viewport.width > 4)\""), "{off}");
    assert_eq!(changed(&off, &switch(true)), when);
}

#[test]
fn removed_pass_goes_with_its_comments_and_its_name() {
    let written = changed(TWO, &Change::Remove { pass: "show".to_owned() });
    let without = TWO
        .replacen("    // The second.\n    \"show\": { \"extends\": \"copying\", \"after\": [\"paint\"] }, // Behind it.\n", "", 1)
        .replacen("\"extends\": \"copying\", \"after\": [\"show\"],\n", "\"extends\": \"copying\",\n", 1);
    assert_eq!(written, without);
}

#[test]
fn moved_pass_takes_its_comments_along() {
    let moved = changed(TWO, &Change::Move { pass: "show".to_owned(), before: Some("paint".to_owned()) });
    let lines = |text: &str| text.lines().map(str::trim).map(str::to_owned).collect::<Vec<_>>();
    let at = |text: &str, line: &str| lines(text).iter().position(|one| one == line).expect("a line");
    assert!(at(&moved, "// The second.") < at(&moved, "// The first."), "{moved}");
    let back = changed(&moved, &Change::Move { pass: "show".to_owned(), before: Some("veil".to_owned()) });
    assert_eq!(lines(&back), lines(TWO));
}

#[test]
fn added_pass_has_the_settings_that_its_kind_requires() {
    let add = |kind: &str| Change::Add { kind: kind.to_owned(), after: Some("paint".to_owned()) };
    let copy = changed(TWO, &add("copy"));
    let new = "\n    \"copy\": { \"copy\": { \"from\": { \"name\": \"&sharp\" }, \"to\": { \"name\": \"&sharp\" } } },\n";
    assert!(copy.contains(new), "{copy}");
    let mut registry = umbragraph::registry();
    registry.host("anything", Default::default());
    for kind in registry.iter() {
        let text = changed(TWO, &add(kind.name()));
        let found = plan(&mut session(&[("two.json", &text)]), "two.json");
        assert!(
            !found.contains("is missing") && !found.contains("no JSON"),
            "{}: {found}\n{text}",
            kind.name()
        );
    }
    let error = change(&mut two(), "two.json", &add("nothing")).unwrap_err();
    assert_eq!(error.to_string(), "\"nothing\" is neither a node kind nor a subgraph");
}

#[test]
fn added_resource_is_like_the_chosen_one() {
    let declare = |like: Option<&str>| changed(TWO, &Change::Declare { like: like.map(str::to_owned) });
    let line = "\"texture\": { \"texture\": { \"format\": \"rgba8unorm\", \"size\": \"=viewport\" } }";
    for text in [declare(None), declare(Some("target"))] {
        assert!(text.contains(line), "{text}");
        assert_eq!(text.matches("imported").count(), 1, "{text}");
    }
    let bare = "{ \"format\": 1, \"name\": \"two\", \"passes\": {} }";
    let text = changed(bare, &Change::Declare { like: None });
    assert!(text.contains(&format!("\"resources\": {{ {line} }}")), "{text}");
}

#[test]
fn removed_resource_is_one_that_nothing_uses() {
    let forget = |name: &str| Change::Forget { resource: name.to_owned() };
    let more = TWO.replacen("    \"target\":", "    // Of no use.\n    \"spare\": { \"texture\": { \"format\": \"r8unorm\", \"size\": 4 } },\n    \"target\":", 1);
    assert_eq!(changed(&more, &forget("spare")), TWO);
    let refused = change(&mut two(), "two.json", &forget("sharp")).unwrap_err().to_string();
    assert!(refused.contains("\"sharp\" is used by ") && refused.contains("paint"), "{refused}");
    let unknown = change(&mut two(), "two.json", &forget("nothing")).unwrap_err().to_string();
    assert_eq!(unknown, "the pipeline's text has no \"nothing\"");
}

#[test]
fn group_is_a_subgraph_with_a_use_in_its_place() {
    let text = changed(TWO, &Change::Group { passes: names(&["veil", "show"]), name: "both".to_owned() });
    for part in [
        "\"both\": { \"use\": \"both\", \"with\": { \"sharp\": \"&sharp\", \"target\": \"&target\" }, \"after\": [\"paint\"] }",
        "// The second.\n    \"show\": { \"extends\": \"copying\" }, // Behind it.",
        "\"after\": [\"show\"]",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert_eq!(plan(&mut session(&[("two.json", &text)]), "two.json"), "");
}

#[test]
fn change_that_cannot_be_made_says_why() {
    let refused = |text: &str, one: &Change| {
        change(&mut session(&[("two.json", text)]), "two.json", one).unwrap_err().to_string()
    };
    let remove = |pass: &str| Change::Remove { pass: pass.to_owned() };
    assert_eq!(refused(TWO, &remove("x")), "the pipeline's text has no \"x\"");
    assert_eq!(
        refused(&TWO.replace("\"format\": 1,", "\"format\": 1"), &remove("show")),
        "two.json has a syntax error; mend it first"
    );
    let rename = Change::Rename { from: "show".to_owned(), to: "paint".to_owned() };
    assert_eq!(refused(TWO, &rename), "\"paint\" is there already");
}

fn root(text: &str) -> Value {
    let mut sources = Sources::new();
    let file = sources.add("t.json", text);
    document::parse(&sources, file)
        .valid()
        .unwrap_or_else(|found| panic!("{}\n{text}", shown(&found, &sources)))
        .root
}

/// The comments of a document, with spaces where they have space.
fn comments(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(['"', '/']) {
        let (here, end) = (&rest[at..], |behind: &str, from: usize| {
            rest[at..]
                .get(from..)
                .and_then(|part| part.find(behind))
                .map_or(rest.len() - at, |end| from + end + behind.len())
        });
        let length = match here.as_bytes() {
            [b'"', ..] => {
                let mut bytes = here.bytes().enumerate().skip(1);
                let mut length = here.len();
                while let Some((at, byte)) = bytes.next() {
                    match byte {
                        b'\\' => drop(bytes.next()),
                        b'"' => {
                            length = at + 1;
                            break;
                        }
                        _ => {}
                    }
                }
                length
            }
            [b'/', b'*', ..] => end("*/", 2),
            _ => here.find('\n').unwrap_or(here.len()),
        };
        if !here.starts_with('"') {
            found.push(here[..length].split_whitespace().collect::<Vec<_>>().join(" "));
        }
        rest = &here[length..];
    }
    found.sort();
    found
}

/// A random change of a pipeline.
fn random_change(session: &mut Session, target: &Target, random: &mut Random) -> Option<Change> {
    let passes = session.written(target, &choice()).expect("nothing cancels");
    let [pass, other] = [passes.get(random.below(passes.len())), passes.get(random.below(passes.len()))];
    let (pass, other) = (pass?.name.clone(), other?.name.clone());
    let loaded = session.load_exactly(target).expect("nothing cancels");
    let root = &loaded.document()?.root;
    let resources: Vec<&str> = root.entries_of("resources").iter().map(|one| one.key.as_str()).collect();
    let name = format!("new_{}", random.below(1000));
    Some(match random.below(10) {
        8 => Change::Declare {
            like: random.one_in(2).then(|| resources.first().copied().unwrap_or_default().to_owned()),
        },
        9 => Change::Forget { resource: (*resources.get(random.below(resources.len()))?).to_owned() },
        0 | 1 => {
            let slots = session.slots(target, &choice(), &pass).expect("nothing cancels");
            let slot = slots.get(random.below(slots.len()))?.keys.clone();
            Change::Connect { pass, slot, to: format!("&{}", resources.get(random.below(resources.len()))?) }
        }
        2 => Change::Rename {
            from: if random.one_in(2) { pass } else { (*resources.first()?).to_owned() },
            to: name,
        },
        3 => Change::Switch { pass, on: random.one_in(2) },
        4 => Change::Remove { pass },
        5 => Change::Move { pass, before: (!random.one_in(4)).then_some(other) },
        6 => {
            let kinds =
                ["fullscreen", "compute", "copy", "clear", "camera", "draw", "pipelines/effects/bloom.json"];
            Change::Add { kind: random.one_of(&kinds).to_owned(), after: random.one_in(2).then_some(pass) }
        }
        _ => Change::Group { passes: vec![pass, other], name },
    })
}

/// Makes a change in a session's files, and holds what every change has to keep.
fn make(
    session: &mut Session,
    texts: &mut BTreeMap<String, String>,
    one: &Change,
    edits: &BTreeMap<String, Edits>,
) {
    for (file, edits) in edits {
        let old = texts.entry(file.clone()).or_insert_with(|| std::fs::read_to_string(file).expect("a text"));
        let new = edits.apply(old).expect("edits of the text");
        assert_eq!(
            edits.inverse(old).and_then(|inverse| inverse.apply(&new)).as_deref(),
            Ok(old.as_str()),
            "{one:?}"
        );
        root(&new);
        let mut left = comments(&new);
        let removed: String = edits.iter().map(|edit| old[edit.range.clone()].to_owned() + "\n").collect();
        let removed = removed.split_whitespace().collect::<Vec<_>>().join(" ");
        for comment in comments(old) {
            match left.iter().position(|kept| *kept == comment) {
                Some(at) => drop(left.remove(at)),
                None => assert!(
                    matches!(one, Change::Remove { .. } | Change::Forget { .. })
                        && removed.contains(&comment),
                    "{one:?} lost \"{comment}\" of {file}\n{new}"
                ),
            }
        }
        assert_eq!(left, Vec::<String>::new(), "{one:?}");
        session.overlay(file, new.as_bytes());
        *old = new;
    }
}

#[test]
fn random_changes_keep_comments_and_are_undone() {
    let pipelines: Vec<_> = documents("pipelines")
        .into_iter()
        .filter(|path| {
            let root = root(&std::fs::read_to_string(path).expect("a text"));
            let is_pipeline = root.get("format").is_some() && root.get("passes").is_some();
            is_pipeline && root.get("inputs").is_none_or(|inputs| !matches!(inputs.kind, Kind::Object(_)))
        })
        .collect();
    let mut random = Random(property::seed());
    let (mut made, mut refused) = (0, 0);
    let each = CHANGES * property::times() as usize / pipelines.len() + 1;
    for path in &pipelines {
        let mut session = Session::new(DiskStorage, umbragraph::registry(), with_templates([]));
        let target = Target::new(path);
        let mut texts = BTreeMap::new();
        let mut undo: Vec<(String, Edits, String)> = Vec::new();
        for _ in 0..each {
            let Some(one) = random_change(&mut session, &target, &mut random) else { continue };
            let Ok(edits) = change(&mut session, &path.to_string_lossy(), &one) else {
                refused += 1;
                continue;
            };
            made += 1;
            for (file, edits) in &edits {
                let old = texts
                    .get(file)
                    .cloned()
                    .unwrap_or_else(|| std::fs::read_to_string(file).expect("a text"));
                undo.push((file.clone(), edits.inverse(&old).expect("edits of the text"), old));
            }
            make(&mut session, &mut texts, &one, &edits);
        }
        for (file, inverse, old) in undo.into_iter().rev() {
            let text = texts.get_mut(&file).expect("a changed text");
            *text = inverse.apply(text).expect("the text that it was");
            assert_eq!(*text, old);
        }
        for (file, text) in &texts {
            assert_eq!(*text, std::fs::read_to_string(Path::new(file)).expect("a text"));
        }
    }
    assert!(made > CHANGES / 2, "{made} were made, {refused} refused");
}
