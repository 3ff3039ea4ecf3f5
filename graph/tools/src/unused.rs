//! Parameters, features, derived values and shared settings that nothing uses.
//!
//! A setting is used if the model of the document knows a use of it, or if a template that some pass names has an axis
//! of its name. What presets give values is not used for that.
//!
//! A host may read settings in its own code, which is not known here: so the diagnostic is a note.

use std::collections::BTreeSet;

use umbragraph_pipeline::compose::is_path;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Severity, codes};
use umbragraph_pipeline::document::Document;
use umbragraph_pipeline::expression::{ExpressionKind, Value};
use umbragraph_pipeline::model::{Content, Declaration, DeclarationKind as Kind, Id, Model, Text};
use umbragraph_pipeline::shader::TemplateSet;

/// Returns the template axes (shader variant dimensions) that strings name.
pub(crate) fn axes_named<'t, 'm>(
    texts: impl Iterator<Item = &'m Text>,
    templates: &'t TemplateSet,
) -> BTreeSet<&'t str> {
    let mut names = BTreeSet::new();
    for text in texts {
        match &text.content {
            Content::Word => drop(names.insert(text.text.clone())),
            Content::Expression(expression) => expression.visit(&mut |inner| {
                if let ExpressionKind::Literal(Value::Text(word)) = &inner.kind {
                    names.insert(word.clone());
                }
            }),
            Content::Invalid => {}
        }
    }
    templates.axes_of(|name| names.contains(name))
}

/// Adds a diagnostic for each unused parameter, feature, derived value and group of shared settings.
pub(crate) fn unused(
    document: &Document,
    model: &Model,
    templates: &TemplateSet,
    diagnostics: &mut Diagnostics,
) {
    let of_kind = |kind, owner: Option<Id>| {
        model.declarations().filter(move |(_, one)| one.kind == kind && one.owner == owner)
    };
    let subgraphs: Vec<(Id, &Declaration)> = of_kind(Kind::Subgraph, None).collect();
    for (id, subgraph) in &subgraphs {
        let axes = match is_path(&subgraph.name) {
            true => axes_named(model.texts_in(*id), templates),
            false => BTreeSet::new(),
        };
        for (kind, what) in [(Kind::Parameter, "parameter"), (Kind::Derived, "derived value")] {
            for (setting, one) in of_kind(kind, Some(*id)) {
                if model.uses_of(setting).next().is_none() && !axes.contains(one.name.as_str()) {
                    diagnostics.push(unused_setting(what, one));
                }
            }
        }
    }
    for owner in subgraphs.iter().map(|(id, _)| Some(*id)).chain([None]) {
        for (id, group) in of_kind(Kind::SharedSettings, owner) {
            if model.uses_of(id).next().is_none() {
                let name = &group.name;
                let message =
                    format!("the shared settings \"{name}\" are declared, but no pass extends them");
                diagnostics.push(note(group, message, "let a pass say \"extends\", or remove them"));
            }
        }
    }
    let is_of_file = |text: &&Text| {
        let mut files = subgraphs.iter().filter(|(_, subgraph)| is_path(&subgraph.name));
        files.any(|(id, _)| model.declaration(text.within).owner == Some(*id))
    };
    let axes = axes_named(model.texts().iter().filter(|text| !is_of_file(text)), templates);
    // A feature that requires others, or is one of several, decides about those that are used.
    let is_tied = |name: &str| {
        let feature = document.root.get("features").and_then(|features| features.get(name));
        ["requires", "excludes", "one_of"].iter().any(|tie| feature.is_some_and(|one| one.get(tie).is_some()))
    };
    for (kind, what) in
        [(Kind::Parameter, "parameter"), (Kind::Feature, "feature"), (Kind::Derived, "derived value")]
    {
        for (id, one) in of_kind(kind, None) {
            let is_used = model.uses_of(id).any(|used| model.declaration(used.within).kind != Kind::Preset);
            let decides = kind == Kind::Feature && is_tied(&one.name);
            if !is_used && !decides && !axes.contains(one.name.as_str()) {
                diagnostics.push(unused_setting(what, one));
            }
        }
    }
}

fn unused_setting(what: &str, one: &Declaration) -> Diagnostic {
    let message = format!("the {what} \"{}\" is declared, but nothing uses it", one.name);
    note(one, message, "use it in an expression, let a template have an axis of its name, or remove it")
}

fn note(one: &Declaration, message: String, help: &str) -> Diagnostic {
    let diagnostic = Diagnostic::error(codes::UNUSED_SETTING, one.place, message).help(help);
    diagnostic.pointer(one.pointer.as_str()).severity(Severity::Note)
}
