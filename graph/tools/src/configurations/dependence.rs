//! On which settings each pass depends.
//!
//! A pass depends on the features and parameters that its strings name outside of `bind`, through derived values too,
//! or for which a template that it names has an axis; and on those of what it refers to: of resources and subgraphs,
//! and of these of theirs; of a pass that it names, or that names the same published data. Data passes through CPU
//! passes, those without a shader, however many.
//!
//! Limits: data that passes on from a pass with a shader to a second and a third is followed one step only.

use std::collections::{BTreeMap, BTreeSet};

use crate::unused::axes_named;
use umbragraph_pipeline::model::{DeclarationKind as Kind, Id, Model, Text};
use umbragraph_pipeline::shader::TemplateSet;

/// One entry of `passes`, `resources` or `subgraphs` in the document, with its direct dependencies.
struct Node {
    own: BTreeSet<usize>,
    /// The declarations that the entry names.
    named: BTreeSet<Id>,
    /// Whether entries that name this one also depend on everything that this one names; `false` for a pass with a
    /// shader.
    transparent: bool,
}

/// Returns for each pass the settings on which it depends, as indices into `settings`.
pub(super) fn groups<'a>(
    model: &Model,
    settings: impl Iterator<Item = &'a str>,
    templates: &TemplateSet,
) -> Vec<BTreeSet<usize>> {
    let settings: Vec<&str> = settings.collect();
    let at_the_top =
        |kind| model.declarations().filter(move |(_, one)| one.kind == kind && one.owner.is_none());
    let mut nodes = Vec::new();
    let mut places: BTreeMap<Id, BTreeSet<usize>> = BTreeMap::new();
    let passes = at_the_top(Kind::Pass).count();
    for kind in [Kind::Pass, Kind::Resource, Kind::Subgraph] {
        for (id, _) in at_the_top(kind) {
            places.entry(id).or_default().insert(nodes.len());
            nodes.push(node(model, id, &settings, templates));
        }
    }
    for (at, node) in nodes.iter().enumerate() {
        for named in node.named.iter().filter(|named| model.declaration(**named).kind == Kind::Data) {
            places.entry(*named).or_default().insert(at);
        }
    }
    let follows = |at: usize| nodes[at].named.iter().filter_map(|named| places.get(named)).flatten().copied();
    (0..passes)
        .map(|pass| {
            let mut seen = BTreeSet::from([pass]);
            let mut open = vec![pass];
            let mut found = BTreeSet::new();
            while let Some(at) = open.pop() {
                found.extend(&nodes[at].own);
                if at == pass || nodes[at].transparent {
                    open.extend(follows(at).filter(|next| seen.insert(*next)));
                }
            }
            found
        })
        .collect()
}

fn node(model: &Model, id: Id, settings: &[&str], templates: &TemplateSet) -> Node {
    let texts: Vec<&Text> = model.texts_in(id).collect();
    let axes = axes_named(texts.iter().copied(), templates);
    let deciding = texts.iter().filter(|text| !text.is_under("bind")).flat_map(|text| model.named_in(text));
    let derived = axes.iter().filter_map(|name| model.find(Kind::Derived, name));
    let behind = model.settings_behind(deciding.chain(derived));
    let behind: BTreeSet<&str> = behind.iter().map(|id| model.declaration(*id).name.as_str()).collect();
    let depends = |name: &str| axes.contains(name) || behind.contains(name);
    let own = settings.iter().enumerate().filter(|(_, name)| depends(name)).map(|(at, _)| at).collect();
    let is_shader = |text: &&Text| templates.file(&text.text).is_some();
    let is_pass = model.declaration(id).kind == Kind::Pass;
    let transparent = !is_pass || !texts.iter().any(is_shader);
    let named = model.parts_of(id).flat_map(|part| model.uses_in(part)).map(|one| one.declaration).collect();
    Node { own, named, transparent }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbragraph_pipeline::diagnostic::Diagnostics;
    use umbragraph_pipeline::source::Sources;

    #[test]
    fn passes_depend_on_what_they_mention_and_on_what_they_refer_to() {
        let text = r#"{
          "features": { "f": {}, "g": {}, "h": {}, "i": {}, "j": {}, "k": {}, "l": {}, "m": {} },
          "derived": { "both": "=h && f", "sun": "=l" },
          "resources": {
            "wide": { "texture": { "format": "=f ? 'a' : 'b'" } },
            "narrow": { "texture": { "size": "=wide" } } },
          "subgraphs": { "blur": {
            "parameters": { "m": {} },
            "passes": { "x": { "when": "=g && m", "compute": { "shader": "axes.wgsl.jinja" } } } } },
          "passes": {
            "fit": { "cpu": { "to": "&sun_data", "count": "=both", "word": "k" } },
            "draw": { "draw": {
              "shader": "plain.wgsl.jinja", "bind": { "sun": "&sun_data", "s": { "values": { "x": "=i" } } } } },
            "read": { "draw": { "shader": "plain.wgsl.jinja", "bind": { "image": "&narrow" } } },
            "smooth": { "use": "blur", "with": { "a": "=j" } },
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
        let model = Model::new(&umbragraph_pipeline::document::parse(&sources, file).valid().unwrap());
        let names = ["f", "g", "h", "i", "j", "k", "l", "m"];
        let found: Vec<String> = groups(&model, names.into_iter(), &templates)
            .into_iter()
            .map(|group| group.into_iter().map(|at| names[at]).collect())
            .collect();
        assert_eq!(found, ["fh", "fh", "f", "gjl", "k"]);
    }
}
