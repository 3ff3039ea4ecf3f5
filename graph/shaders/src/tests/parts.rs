//! Texts that are joined from parts against those that the engine renders as a whole.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use proptest::prelude::*;
use umbragraph_test_support::property;

use super::Fixture;
use crate::axes::Space;
use crate::permutations::Explorer;
use crate::rendering::parts::Parts;
use crate::written::declarations::{self, Split};

/// Compares the first `max` modules joined from parts with ordinary renderings. Returns their number; `None` if the
/// template cannot be divided.
fn compare(fixture: &Fixture, root: &str, max: usize) -> Option<usize> {
    let parts = OnceLock::from(Parts::of(&fixture.set, root));
    parts.get().and_then(Option::as_ref)?;
    let space = Arc::new(Space::new(fixture.set.axes(root)?, &BTreeMap::new()));
    let mut explorer =
        Explorer::new(&fixture.set, root, &space, false).nearest_first().of_parts(Some(&parts));
    let mut count = 0;
    while let Some(text) = explorer.next_text().filter(|_| count < max) {
        let whole = explorer.exploration.source(&fixture.set, root, count).map(|source| source.wgsl);
        assert_eq!(Some(text), whole, "{root}");
        count += 1;
    }
    if count > 0 && !explorer.exploration.is_joined {
        return None;
    }
    let mut plain = Explorer::new(&fixture.set, root, &space, false);
    if count < max && plain.take_all(4 * max) {
        let hashes = |explorer: &Explorer<'_>| -> std::collections::BTreeSet<[u8; 32]> {
            explorer.exploration.texts.iter().map(|text| text.hash).collect()
        };
        assert_eq!(hashes(&explorer), hashes(&plain), "{root}");
        let failed = |explorer: &Explorer<'_>| explorer.exploration.failures.is_empty();
        assert_eq!(failed(&explorer), failed(&plain), "{root}");
    }
    Some(count)
}

#[test]
fn parts_of_the_library_join_to_the_whole_texts() {
    let fixture = Fixture::sound(umbragraph_shaders_templates::FILES);
    let max = if property::times() > 1 { 5_000 } else { 200 };
    let mut whole = Vec::new();
    for root in fixture.set.names().filter(|name| !name.starts_with("lib/")) {
        match compare(&fixture, root, max) {
            Some(count) => println!("{root}: {count} texts"),
            None => whole.push(root),
        }
    }
    assert!(whole.is_empty(), "not taken apart: {whole:?}");
}

/// Generates templates of correctly nested tags with few names, so that tags often use names that other tags assign.
fn template() -> impl Strategy<Value = String> {
    let name = prop::sample::select(&["a", "b", "n", "c", "d", "m"][..]);
    let value = prop_oneof![
        name.clone().prop_map(str::to_owned),
        Just("n + 1".to_owned()),
        Just("a and n > 1".to_owned()),
        Just("m(n)".to_owned()),
        Just("'x'".to_owned()),
        (name.clone(), name.clone()).prop_map(|(one, other)| format!("{one} == {other}")),
    ];
    let leaf = prop_oneof![
        Just("text\n".to_owned()),
        value.clone().prop_map(|value| format!("{{{{ {value} }}}}\n")),
        (name.clone(), value.clone()).prop_map(|(name, value)| format!("{{% set {name} = {value} %}}")),
        Just("{% include 'lib.wgsl.jinja' %}\n".to_owned()),
        Just("{% include b %}\n".to_owned()),
        Just("{% from 'lib.wgsl.jinja' import c %}".to_owned()),
        Just("{% import 'lib.wgsl.jinja' as d %}".to_owned()),
    ];
    let nested = leaf.prop_recursive(3, 24, 5, move |inner| {
        let body = prop::collection::vec(inner, 0..4).prop_map(|all| all.concat());
        let two = (value.clone(), body.clone(), body.clone());
        prop_oneof![
            two.clone().prop_map(|(value, one, _)| format!("{{% if {value} %}}\n{one}{{% endif %}}\n")),
            two.prop_map(|(value, one, other)| {
                format!("{{% if a -%}} {one}{{% elif {value} %}}{other}{{%- else %}}{one}{{% endif %}}")
            }),
            body.clone().prop_map(|body| format!("{{% for n in [1, 2] %}}{body}{{% endfor %}}")),
            body.clone().prop_map(|body| format!("{{% with c = n %}}{body}{{% endwith %}}")),
            body.clone().prop_map(|body| format!("{{% set c %}}{body}{{% endset %}}")),
            body.clone().prop_map(|body| format!("{{% macro m(a) %}}{body}{{% endmacro %}}")),
            body.prop_map(|body| format!("{{% filter upper %}}{body}{{% endfilter %}}")),
        ]
    });
    prop::collection::vec(nested, 0..6).prop_map(|all| all.concat())
}

proptest! {
    #![proptest_config(property::config(256))]

    #[test]
    fn a_text_is_split_as_without_the_one_before(
        texts in prop::collection::vec("(fn a\\{\\}|[{};/*\\n a]|var a;|// ;\\n|/\\*\\*/|\u{e9}){0,12}(\n{80})?[};a]{0,3}", 1..6)
    ) {
        let mut split = Split::default();
        for text in texts {
            let before = split.clone();
            let plain = declarations::split(&text);
            let common = split.go_on(text.clone());
            prop_assert_eq!(common.map(|_| &split.ranges), plain.as_ref());
            let Some(common) = common else { continue };
            let texts = |split: &Split| -> Vec<String> {
                split.ranges.iter().map(|range| split.text[range.clone()].to_owned()).collect()
            };
            let (old, new) = (texts(&before), texts(&split));
            prop_assert_eq!(&old[..common.first], &new[..common.first]);
            prop_assert_eq!(&old[old.len() - common.last..], &new[new.len() - common.last..]);
        }
    }

    #[test]
    fn parts_of_random_templates_join_to_the_whole_texts(text in template(), library in template()) {
        let axes = r#"{ "axes": { "a": { "type": "bool", "default": false },
            "b": { "type": "enum", "values": ["x", "lib.wgsl.jinja"], "default": "x" },
            "n": { "type": "integer", "min": 1, "max": 3, "default": 1 } } }"#;
        // The library includes nothing: it would include itself.
        let library = library.replace("{% include 'lib.wgsl.jinja' %}", "").replace("{% include b %}", "");
        let fixture =
            Fixture::new(&[("t.wgsl.jinja", &text), ("t.axes.json", axes), ("lib.wgsl.jinja", &library)]);
        compare(&fixture, "t.wgsl.jinja", 64);
    }
}
