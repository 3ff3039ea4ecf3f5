use proptest::prelude::*;
use umbragraph_test_support::property;

use super::*;
use crate::document::Document;

fn parsed(text: &str) -> Document {
    let mut sources = Sources::new();
    let file = sources.add("t.json", text);
    parse(&sources, file).valid().unwrap_or_else(|diagnostics| panic!("{diagnostics:?}\n{text}"))
}

fn formatted(text: &str) -> String {
    let mut sources = Sources::new();
    let file = sources.add("t.json", text);
    let edits = format(&sources, file).unwrap_or_else(|diagnostics| panic!("{diagnostics:?}\n{text}"));
    let formatted = edits.apply(text).unwrap();
    assert_eq!(edits.inverse(text).unwrap().apply(&formatted).unwrap(), text, "and back");
    formatted
}

/// Returns the comments of a text in order, with runs of white space reduced to one space.
pub(crate) fn comments(text: &str) -> Vec<String> {
    let mut scanner = jsonc_parser::Scanner::new(text, &jsonc_parser::ScannerOptions::default());
    let mut comments = Vec::new();
    while let Ok(Some(token)) = scanner.scan() {
        if let jsonc_parser::tokens::Token::CommentLine(comment)
        | jsonc_parser::tokens::Token::CommentBlock(comment) = token
        {
            comments.push(comment.split_whitespace().collect::<Vec<_>>().join(" "));
        }
    }
    comments
}

#[track_caller]
fn becomes(text: &str, expected: &str) {
    assert_eq!(formatted(text), expected);
    assert_eq!(formatted(expected), expected, "twice");
    assert_eq!(comments(text), comments(expected));
}

#[test]
fn one_line_stays_one_line_and_broken_lines_stay_broken() {
    becomes("{\"a\":1,\"b\":[1,2 ,3],\"c\":{ }}", "{ \"a\": 1, \"b\": [1, 2, 3], \"c\": {} }\n");
    becomes("{\n\"a\":1,\"b\":2\n,\n\n\n\"c\":3}", "{\n  \"a\": 1, \"b\": 2,\n\n  \"c\": 3\n}\n");
    becomes("[\r\n1\r\n]", "[\n  1\n]\n");
    becomes("[1\n]", "[1]\n");
    // Nothing stands beside what takes several lines.
    becomes(
        "{\"a\":1,\"b\":{\n\"c\":2},\"d\":3}",
        "{\n  \"a\": 1,\n  \"b\": {\n    \"c\": 2\n  },\n  \"d\": 3\n}\n",
    );
}

#[test]
fn one_member_opens_and_closes_with_its_container() {
    becomes("{\"a\":[{\n\"b\":{}\n}\n]}", "{ \"a\": [{\n  \"b\": {}\n}] }\n");
    becomes("{\n\"a\":[\n{ \"b\":1 }]}", "{\n  \"a\": [\n    { \"b\": 1 }\n  ]\n}\n");
}

#[test]
fn long_lines_break_by_member_and_lists_fill() {
    let word = "\"".to_owned() + &"x".repeat(60) + "\"";
    becomes(
        &format!("{{\"a\":{word},\"b\":{word},\"c\":1}}"),
        &format!("{{\n  \"a\": {word},\n  \"b\": {word},\n  \"c\": 1\n}}\n"),
    );
    becomes(&format!("[{word},{word},1,2]"), &format!("[{word}, {word}, 1, 2]\n"));
    becomes(&format!("[{word},{word},{word},2]"), &format!("[\n  {word}, {word},\n  {word}, 2\n]\n"));
    becomes(
        &format!("{{\n\"a\": {word}, \"b\": {word}, \"c\": {word}, \"d\": 1\n}}"),
        &format!("{{\n  \"a\": {word}, \"b\": {word},\n  \"c\": {word}, \"d\": 1\n}}\n"),
    );
    becomes(
        &format!("{{\"a\":{{\"b\":{word},\"c\":{word}, \"d\":{word}}}}}"),
        &format!("{{ \"a\": {{\n  \"b\": {word},\n  \"c\": {word},\n  \"d\": {word}\n}} }}\n"),
    );
}

#[test]
fn the_width_counts_characters_and_the_comma() {
    let list = |letters: usize| format!("{{\n  \"a\": [1, \"{}\"],\n  \"b\": 2\n}}\n", "ä".repeat(letters));
    let fits = list(WIDTH - "  \"a\": [1, \"\"],".len());
    assert_eq!(formatted(&fits), fits);
    let letters = WIDTH - "  \"a\": [1, \"\"],".len() + 1;
    let broken = format!("{{\n  \"a\": [\n    1, \"{}\"\n  ],\n  \"b\": 2\n}}\n", "ä".repeat(letters));
    becomes(&list(letters), &broken);
}

#[test]
fn comments_stay_with_what_they_are_about() {
    becomes(
        "// top\n\n{ // of the object\n\"a\":1,// of a\n// of b\n\"b\":2 /* before */, /* behind */\n\n/* c */\"c\":3 // last\n// end\n}\n// bottom",
        "// top\n\n{ // of the object\n  \"a\": 1, // of a\n  // of b\n  \"b\": 2 /* before */, /* behind */\n\n  /* c */ \"c\": 3 // last\n  // end\n} // bottom\n"
            .replace("} // bottom", "}\n// bottom")
            .as_str(),
    );
    becomes("[1,/* of 2 */2/* after */]", "[1, /* of 2 */ 2 /* after */]\n");
    becomes("[/* nothing */]", "[ /* nothing */ ]\n");
    becomes("{\n// nothing\n}", "{\n  // nothing\n}\n");
    becomes("[1 // one\n,2]", "[\n  1, // one\n  2\n]\n");
}

#[test]
fn comments_between_key_and_value_move_before_the_key() {
    becomes("{\"a\":1,\"b\" /* x */ : // y\n2}", "{\n  \"a\": 1,\n  /* x */ // y\n  \"b\": 2\n}\n");
    becomes("{\"a\"/* x */:1}", "{ /* x */ \"a\": 1 }\n");
}

#[test]
fn the_lines_of_a_comment_move_together() {
    becomes(
        "{\n      /* one\n         two   \n\n    three */\n\"a\":1}",
        "{\n  /* one\n     two\n\nthree */\n  \"a\": 1\n}\n",
    );
    becomes("{\n/* one\n   two */\n\"a\":1}", "{\n  /* one\n     two */\n  \"a\": 1\n}\n");
}

#[test]
fn scalars_are_copied_letter_by_letter() {
    for scalar in ["1.50", "-0", "1e3", "0.1E+2", "\"\\u0041\\/\"", "\"// no /* comment */\""] {
        assert_eq!(formatted(scalar), format!("{scalar}\n"));
    }
}

#[test]
fn strict_text_has_no_comments_and_one_layout() {
    let a = "{ // c\n\"a\": [\n1.5,\n2], \"b\": \"\\u0041\\n\" }";
    let b = "{\"a\":[1.50,2],\n\n\"b\":\"A\\u000a\"}";
    assert_eq!(strict(&parsed(a)), "{ \"a\": [1.5, 2], \"b\": \"A\\n\" }\n");
    assert_eq!(strict(&parsed(b)), strict(&parsed(a)));
}

#[test]
fn what_is_not_json_is_a_diagnostic() {
    let mut sources = Sources::new();
    for text in ["", "{\"a\":1,}", "[1", "{\"a\":1,\"a\":2}"] {
        let file = sources.add("t.json", text);
        assert!(format(&sources, file).is_err(), "{text}");
    }
}

#[test]
fn deep_nesting_and_long_lines_take_no_time_worth_mentioning() {
    let deep = "[".repeat(500) + &"]".repeat(500);
    assert_eq!(formatted(&formatted(&deep)), formatted(&deep));
    let deep = "{\"a\":[1,".repeat(150) + "2" + &"]}".repeat(150);
    assert_eq!(formatted(&formatted(&deep)), formatted(&deep));
    let long = format!("[{}1]", "/* c */ 1 /* d */, ".repeat(50_000));
    assert_eq!(formatted(&formatted(&long)), formatted(&long));
}

pub(crate) const SPACES: [&str; 18] = [
    "",
    "",
    " ",
    "\n",
    "\n\n\n",
    "\t",
    "\r\n",
    "\r",
    " // line\n",
    "// line\r\n",
    "\n  // own line\n",
    "/* block */",
    " /* block */ ",
    "\n/* own block */\n",
    "\n\n    /* two\n       lines */\n",
    "/* two\r\n lines */",
    "// one\n/* two */ // three\n\n",
    "\n  \t /* three\n\n \t  more\n lines\n*/ /* next */\n",
];

pub(crate) fn values() -> impl Strategy<Value = serde_json::Value> {
    let scalar = prop_oneof![
        Just(serde_json::Value::Null),
        any::<bool>().prop_map(Into::into),
        any::<i16>().prop_map(Into::into),
        (-1e3..1e3f64).prop_map(Into::into),
        "[a-z/*\"\\\\äß ]{0,40}".prop_map(Into::into),
        "[a-z]{60,150}".prop_map(Into::into),
    ];
    scalar.prop_recursive(5, 60, 8, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..8).prop_map(Into::into),
            prop::collection::vec(("[a-zä]{1,12}", inner), 0..6)
                .prop_map(|members| serde_json::Value::Object(members.into_iter().collect())),
        ]
    })
}

/// Appends a JSON value to `out`, with the results of `space` (white space or comments) wherever the grammar allows
/// them.
pub(crate) fn write(value: &serde_json::Value, space: &mut impl FnMut() -> &'static str, out: &mut String) {
    let mut comma = "";
    match value {
        serde_json::Value::Array(elements) => {
            out.push('[');
            for element in elements {
                out.extend([comma, space()]);
                write(element, space, out);
                out.push_str(space());
                comma = ",";
            }
            out.extend([space(), "]"]);
        }
        serde_json::Value::Object(members) => {
            out.push('{');
            for (key, member) in members {
                out.extend([
                    comma,
                    space(),
                    &serde_json::Value::from(key.as_str()).to_string(),
                    space(),
                    ":",
                    space(),
                ]);
                write(member, space, out);
                out.push_str(space());
                comma = ",";
            }
            out.extend([space(), "}"]);
        }
        scalar => out.push_str(&scalar.to_string()),
    }
}

proptest! {
    #![proptest_config(property::config(1500))]

    #[test]
    fn formatting_is_idempotent_and_keeps_values_and_comments(
        value in values(),
        choices in prop::collection::vec(0..SPACES.len(), 1..120),
        // The share of places that have more than nothing.
        share in 1usize..12,
    ) {
        let mut at = 0;
        let mut space = || {
            at += 1;
            if at % share == 0 { SPACES[choices[at / share % choices.len()]] } else { "" }
        };
        let mut text = space().to_owned();
        write(&value, &mut space, &mut text);
        text.push_str(space());
        let once = formatted(&text);
        prop_assert_eq!(&formatted(&once), &once, "twice, from\n{}", text);
        prop_assert_eq!(parsed(&once).root.to_json(), parsed(&text).root.to_json());
        prop_assert_eq!(comments(&once), comments(&text));
        prop_assert!(once.ends_with('\n') && !once.ends_with("\n\n") && !once.contains("\n\n\n"));
        let strict = strict(&parsed(&text));
        prop_assert_eq!(serde_json::from_str::<serde_json::Value>(&strict).unwrap(), parsed(&text).root.to_json());
        prop_assert_eq!(&formatted(&strict), &strict, "strict text is a fixed point");
    }
}
