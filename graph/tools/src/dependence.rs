//! On which settings each pass depends.
//!
//! A pass depends on the features and parameters that its text mentions outside of `bind`, or for which a template that
//! it names has an axis; and on those of what it refers to: of resources and subgraphs, and of these of theirs; of a
//! pass that it names, or with which it shares the name of data that one of them publishes. Data passes through CPU
//! passes, those without a shader, however many.
//!
//! The document is one in which derived values are inlined ([`umbragraph_pipeline::pipeline::inlined`]): a template with an axis of the
//! name of one makes the pass depend on what that follows from.
//!
//! Names are looked for as words, without asking what they mean, so a pass may count as depending on more than it does.
//! Limits: data that passes on from a pass with a shader to a second and a third is followed one step only.

use std::collections::{BTreeMap, BTreeSet};

use umbragraph_pipeline::document::{Document, Entry, Kind, Value};
use umbragraph_pipeline::pipeline::{has_word, is_name};
use umbragraph_pipeline::shader::TemplateSet;

/// One entry of `passes`, `resources` or `subgraphs`.
struct Node<'a> {
    texts: Vec<&'a str>,
    own: BTreeSet<usize>,
    /// Whether its dependencies are also those of the texts that refer to it.
    transparent: bool,
}

/// For each pass, the settings (indices of `settings`) on which it depends.
pub(super) fn groups<'a>(
    document: &Document,
    settings: impl Iterator<Item = &'a str>,
    templates: &TemplateSet,
) -> Vec<BTreeSet<usize>> {
    let settings: Vec<&str> = settings.collect();
    let entries = |section: &str| document.root.entries_of(section);
    let mut nodes = Vec::new();
    let mut names: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    let mut data: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    let passes = entries("passes").len();
    for section in ["passes", "resources", "subgraphs"] {
        for entry in entries(section) {
            names.entry(&entry.key).or_default().push(nodes.len());
            let node = node(entry, &settings, templates, entries("derived"), section != "passes");
            if section == "passes" {
                let bare = node.texts.iter().map(|text| text.strip_prefix('&').unwrap_or(text));
                for text in bare.filter(|text| is_name(text)) {
                    data.entry(text).or_default().push(nodes.len());
                }
            }
            nodes.push(node);
        }
    }
    // These names mean something else.
    for entry in ["resources", "geometry", "parameters", "features"].into_iter().flat_map(entries) {
        data.remove(entry.key.as_str());
    }
    for (name, users) in data {
        names.entry(name).or_default().extend(users);
    }
    let follows: Vec<BTreeSet<usize>> = nodes
        .iter()
        .map(|node| {
            let mentioned = |name: &str| node.texts.iter().any(|text| has_word(text, name));
            names.iter().filter(|(name, _)| mentioned(name)).flat_map(|(_, at)| at).copied().collect()
        })
        .collect();
    (0..passes)
        .map(|pass| {
            let mut seen = BTreeSet::from([pass]);
            let mut open = vec![pass];
            let mut found = BTreeSet::new();
            while let Some(at) = open.pop() {
                found.extend(&nodes[at].own);
                if at == pass || nodes[at].transparent {
                    open.extend(follows[at].iter().copied().filter(|next| seen.insert(*next)));
                }
            }
            found
        })
        .collect()
}

fn node<'a>(
    entry: &'a Entry,
    settings: &[&str],
    templates: &TemplateSet,
    derived: &'a [Entry],
    is_definition: bool,
) -> Node<'a> {
    let mut texts = Vec::new();
    entry.value.for_each_text(&mut |text| texts.push(text));
    let mut deciding = Vec::new();
    collect(&entry.value, &mut deciding);
    let axes = templates.axes_of(|template| texts.contains(&template));
    let axes_derived = derived.iter().filter(|entry| axes.contains(entry.key.as_str()));
    axes_derived.for_each(|entry| collect(&entry.value, &mut deciding));
    let depends = |name: &str| axes.contains(name) || deciding.iter().any(|text| has_word(text, name));
    let own = settings.iter().enumerate().filter(|(_, name)| depends(name)).map(|(at, _)| at).collect();
    let has_shader = texts.iter().any(|text| text.contains(".jinja"));
    Node { texts, own, transparent: is_definition || !has_shader }
}

/// The texts outside of `bind`.
fn collect<'a>(value: &'a Value, texts: &mut Vec<&'a str>) {
    match &value.kind {
        Kind::Text(text) => texts.push(text),
        Kind::Array(elements) => elements.iter().for_each(|element| collect(element, texts)),
        Kind::Object(entries) => {
            entries.iter().filter(|entry| entry.key != "bind").for_each(|entry| collect(&entry.value, texts));
        }
        Kind::Null | Kind::Bool(_) | Kind::Number(_) | Kind::Missing => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbragraph_pipeline::diagnostic::Diagnostics;
    use umbragraph_pipeline::source::Sources;

    #[test]
    fn passes_depend_on_what_they_mention_and_on_what_they_refer_to() {
        let text = r#"{
          "resources": { "wide": { "texture": { "format": "f ? 'a' : 'b'" } }, "narrow": { "texture": { "size": "=wide" } } },
          "subgraphs": { "blur": { "passes": { "x": { "compute": { "shader": "axes.wgsl.jinja", "when": "=g" } } } } },
          "passes": {
            "fit": { "cpu": { "to": "&sun", "count": "=h" } },
            "draw": { "draw": { "shader": "plain.wgsl.jinja", "bind": { "sun": "&sun", "s": { "values": { "x": "=i" } } } } },
            "read": { "draw": { "shader": "plain.wgsl.jinja", "bind": { "image": "&narrow" } } },
            "smooth": { "use": "blur", "with": { "a": "j" } },
            "late": { "after": ["read"], "compute": { "shader": "plain.wgsl.jinja", "when": "=k" } } } }"#;
        let (mut sources, mut templates) = (Sources::new(), TemplateSet::new());
        let mut diagnostics = Diagnostics::new();
        for (name, text) in [
            ("plain.wgsl.jinja", ""),
            ("axes.wgsl.jinja", ""),
            ("axes.axes.json", r#"{ "axes": { "l": { "type": "bool", "default": false } } }"#),
        ] {
            templates.add(&mut sources, name, text, &mut diagnostics);
        }
        let file = sources.add("p.json", text);
        let document = umbragraph_pipeline::document::parse(&sources, file).valid().unwrap();
        let names = ["f", "g", "h", "i", "j", "k", "l"];
        let found: Vec<String> = groups(&document, names.into_iter(), &templates)
            .into_iter()
            .map(|group| group.into_iter().map(|at| names[at]).collect())
            .collect();
        assert_eq!(found, ["h", "h", "f", "gjl", "k"]);
    }
}
