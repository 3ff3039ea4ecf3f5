//! Questions of editors, in whole and broken files: completions, declarations and uses at a place.

use std::path::Path;

use umbragraph::low_level::session::{Candidate, Cursor, Session, Target};

use crate::session::{PART, WHOLE, choice, session};

/// Text with a cursor at `|` over one of two files, and what is asked there.
fn at<T>(path: &str, marked: &str, ask: impl FnOnce(&mut Session, &Cursor<'_>) -> T) -> T {
    let mut session = session(&[("whole.json", WHOLE), ("part.json", PART)]);
    let offset = marked.find('|').expect("a cursor");
    session.overlay(path, marked.replacen('|', "", 1).into_bytes());
    let (target, choice) = (Target::new("whole.json"), choice());
    let cursor = Cursor { target: &target, choice: &choice, path: Path::new(path), offset };
    ask(&mut session, &cursor)
}

/// The completions at the cursor, and the text that they replace.
fn expected(path: &str, marked: &str) -> (String, Vec<Candidate>) {
    at(path, marked, |session, cursor| {
        let found = session.expected_at(cursor).expect("nothing cancels").expect("a file");
        (session.sources().text(found.replaced).to_owned(), found.candidates)
    })
}

fn texts(path: &str, marked: &str) -> Vec<String> {
    expected(path, marked).1.into_iter().map(|one| one.text).collect()
}

/// The whole pipeline with another text in place of a part of it.
fn whole(part: &str, marked: &str) -> String {
    assert!(WHOLE.contains(part), "{part}");
    WHOLE.replacen(part, marked, 1)
}

#[test]
fn keys_are_those_of_the_schema_with_their_descriptions() {
    let (replaced, found) = expected("whole.json", &whole("\"fill\": { ", "\"fill\": { |"));
    let after = found.iter().find(|one| one.label == "after").expect("a key of passes");
    assert_eq!((replaced.as_str(), after.text.as_str()), ("", "\"after\": "));
    assert!(after.description.as_ref().is_some_and(|text| text.starts_with("Passes that must run before")));
    assert!(!found.iter().any(|one| one.label == "compute"), "it has a node kind already");
    let empty = texts("whole.json", &whole("\"passes\": { ", "\"passes\": { \"new\": { | }, "));
    assert!(
        empty.contains(&"\"compute\": ".to_owned()) && empty.contains(&"\"use\": ".to_owned()),
        "{empty:?}"
    );
    let broken = texts("whole.json", &WHOLE.replace("}] } } }\n}\n", "}], |"));
    assert!(broken.iter().any(|text| text == "\"bind\": "), "{broken:?}");
}

#[test]
fn key_after_a_comment_gets_the_comma_that_is_missing() {
    for (before, comma) in [("\"a\": 1, // note\n", ""), ("\"a\": 1 // note,\n", ", "), ("/* a } */", "")] {
        let found = texts("whole.json", &format!("{{ {before} | }}"));
        assert!(found.contains(&format!("{comma}\"passes\": ")), "{before}: {found:?}");
    }
}

#[test]
fn references_and_expressions_name_what_all_files_declare() {
    let references = expected("whole.json", &whole("\"&target\"", "\"&ta|rget\""));
    assert_eq!(references.0, "\"&target\"");
    assert!(references.1.iter().any(|one| one.text == "\"&target\""));
    let (replaced, found) = expected("whole.json", &whole("\"=viewport\"", "\"=view|port / 2\""));
    assert_eq!(replaced, "viewport");
    for name in ["side", "target", "viewport", "ceil"] {
        assert!(found.iter().any(|one| one.text == name), "{name}: {found:?}");
    }
    let side = found.iter().find(|one| one.label == "side").expect("the parameter");
    assert_eq!(side.detail.as_deref(), Some("u32 = 4"));
    let versions = texts("whole.json", &whole("\"&target\"", "\"&target@|\""));
    assert_eq!(versions, ["\"&target@fill\""]);
}

#[test]
fn bindings_axes_and_templates_are_those_of_the_pass() {
    let pass = |inner: &str| {
        let shader = "\"shader\": \"tonemap.wgsl.jinja\"";
        whole("\"shader\": \"gradient.wgsl.jinja\"", &format!("{shader}, {inner}"))
    };
    assert_eq!(texts("whole.json", &pass("\"bind\": { | }")), ["\"settings\": ", "\"source\": "]);
    assert!(texts("whole.json", &pass("\"axes\": { | }")).contains(&"\"debug_view\": ".to_owned()));
    let values = texts("whole.json", &pass("\"axes\": { \"debug_view\": \"|\" }"));
    assert!(values.contains(&"\"shadow_term\"".to_owned()), "{values:?}");
    let templates = texts("whole.json", &whole("\"gradient.wgsl.jinja\"", "\"gra|\""));
    assert!(templates.contains(&"\"gradient.wgsl.jinja\"".to_owned()));
    let formats = texts("whole.json", &whole("\"rgba8unorm\"", "\"|\""));
    assert!(formats.contains(&"\"rgba16float\"".to_owned()));
    let passes = texts("whole.json", &whole("\"fill\": { ", "\"fill\": { \"after\": [\"|\"], "));
    assert_eq!(passes, ["\"fill\""]);
}

#[test]
fn names_lead_to_their_declaration_and_uses_in_other_files() {
    let used = whole("\"=viewport\"", "[\"=si|de\", \"=side * 2\"]");
    let places = at("whole.json", &used, |session, cursor| {
        let declared = session.definition(cursor).expect("nothing cancels");
        let all = session.references(cursor).expect("nothing cancels");
        let shown = |span: &umbragraph::low_level::source::Span| {
            let file = session.sources().get(span.file).expect("a file");
            format!("{}:{}", file.name(), session.sources().text(*span))
        };
        (declared.iter().map(shown).collect::<Vec<_>>(), all.iter().map(shown).collect::<Vec<_>>())
    });
    assert_eq!(places.0, ["part.json:\"side\""]);
    assert_eq!(places.1, ["part.json:\"side\"", "whole.json:side", "whole.json:side"]);
    let file = |marked: &str| {
        at("whole.json", marked, |session, cursor| {
            let places = session.definition(cursor).expect("nothing cancels");
            let file = session.sources().get(places.first().expect("a place").file).expect("a file");
            file.name().to_owned()
        })
    };
    assert_eq!(file(&whole("[\"part.json\"]", "[\"par|t.json\"]")), "part.json");
    assert_eq!(file(&whole("gradient.wgsl", "gradi|ent.wgsl")), "shaders-templates/gradient.wgsl.jinja");
    let binding = whole(
        "\"shader\": \"gradient.wgsl.jinja\"",
        "\"shader\": \"tonemap.wgsl.jinja\", \"bind\": { \"sou|rce\": \"&target\" }",
    );
    let declared = at("whole.json", &binding, |session, cursor| {
        let places = session.definition(cursor).expect("nothing cancels");
        session.sources().text(*places.first().expect("a place")).to_owned()
    });
    assert_eq!(declared, "source");
}

#[test]
fn name_is_changed_in_all_files_of_a_pipeline() {
    let used = whole("\"=viewport\"", "[\"=si|de\", \"=side * 2\"]");
    let edits = at("whole.json", &used, |session, cursor| {
        let edits = session.rename(cursor, "width").expect("nothing cancels").expect("a name");
        let edits = edits.expect("a name that can be given");
        let text = |name: &str| {
            let sources = session.sources();
            let file = sources.get(sources.find(name).expect("a file")).expect("a file");
            edits[name].apply(file.text()).expect("its edits")
        };
        [text("whole.json"), text("part.json")]
    });
    assert!(edits[0].contains("[\"=width\", \"=width * 2\"]"), "{}", edits[0]);
    assert_eq!(edits[1], PART.replace("side", "width"));
}

#[test]
fn hover_tells_values_of_names_and_descriptions_of_keys() {
    let hover = |marked: &str| {
        at("whole.json", marked, |session, cursor| {
            session.hover(cursor).expect("nothing cancels").map(|found| found.text).unwrap_or_default()
        })
    };
    let side = hover(&whole("\"=viewport\"", "[\"=si|de\", \"=side\"]"));
    assert!(side.contains("side") && side.contains("part.json:1:"), "{side}");
    let key = hover(&whole("\"size\": ", "\"si|ze\": "));
    assert!(!key.is_empty() && !key.contains("part.json"), "{key}");
    // The pass is told of while another part is broken.
    let broken =
        whole("\"fill\"", "\"fi|ll\"").replace("\"side\"", "").replace("[\"part.json\"],", "[\"part.json\"]");
    assert!(hover(&broken).contains("fill"), "{}", hover(&broken));
}
