//! Parameters, features, derived values and shared settings that nothing uses.
//!
//! A setting is used if an expression mentions it, or if a template that some pass names has an axis of its name. Names
//! are looked for as words, without asking what they mean, so that one that is only spelt like something else counts as
//! used. A subgraph in a file of its own uses its own parameters alone; one that the pipeline declares uses those of the
//! pipeline too, but for the names that its own parameters and inputs have.
//!
//! What a host reads of a pipeline in its own code is not known here: so it is a note.

use std::collections::BTreeSet;

use umbragraph_pipeline::compose::is_path;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Severity, codes};
use umbragraph_pipeline::document::{Document, Entry, Kind, Value, pointer_join};
use umbragraph_pipeline::shader::TemplateSet;

/// The names that a part of a document mentions.
#[derive(Default)]
pub(crate) struct Mentioned<'a> {
    pub(crate) words: BTreeSet<&'a str>,
    texts: BTreeSet<&'a str>,
}

impl<'a> Mentioned<'a> {
    pub(crate) fn read(&mut self, value: &'a Value) {
        match &value.kind {
            Kind::Text(text) => self.text(text),
            Kind::Array(elements) => elements.iter().for_each(|element| self.read(element)),
            Kind::Object(entries) => {
                for entry in entries.iter().filter(|entry| entry.key != "description") {
                    // Keys name the resource with a passthrough.
                    self.text(&entry.key);
                    self.read(&entry.value);
                }
            }
            Kind::Null | Kind::Bool(_) | Kind::Number(_) | Kind::Missing => {}
        }
    }

    fn text(&mut self, text: &'a str) {
        self.texts.insert(text);
        self.words.extend(text.split(|c: char| !c.is_alphanumeric() && c != '_'));
    }

    /// The names of the axes of the templates that are mentioned.
    fn axes<'t>(&self, templates: &'t TemplateSet) -> BTreeSet<&'t str> {
        templates.axes_of(|name| self.texts.contains(name))
    }
}

/// Finds the parameters, features, derived values and shared settings that nothing uses.
pub(crate) fn unused(document: &Document, templates: &TemplateSet, diagnostics: &mut Diagnostics) {
    let root = &document.root;
    let mut all = Mentioned::default();
    for name in ["resources", "passes", "derived", "constraints", "geometry", "profiles"] {
        root.get(name).into_iter().for_each(|section| all.read(section));
    }
    for subgraph in root.entries_of("subgraphs") {
        let mut own = Mentioned::default();
        for name in ["resources", "passes", "derived"] {
            subgraph.value.get(name).into_iter().for_each(|section| own.read(section));
        }
        let is_file = is_path(&subgraph.key);
        let axes = if is_file { own.axes(templates) } else { BTreeSet::new() };
        let above = pointer_join("/subgraphs", &subgraph.key);
        for (section, what) in [("parameters", "parameter"), ("derived", "derived value")] {
            for entry in subgraph.value.entries_of(section) {
                let name = entry.key.as_str();
                if !own.words.contains(name) && !axes.contains(name) {
                    diagnostics.push(unused_setting(what, entry, &format!("{above}/{section}")));
                }
            }
        }
        if is_file {
            continue;
        }
        let of_its_own =
            ["inputs", "parameters", "derived"].into_iter().flat_map(|name| subgraph.value.entries_of(name));
        let of_its_own: BTreeSet<&str> = of_its_own.map(|entry| entry.key.as_str()).collect();
        all.words.extend(own.words.difference(&of_its_own));
        all.texts.extend(own.texts);
    }
    for owner in root.entries_of("subgraphs").iter().map(|subgraph| &subgraph.value).chain([root]) {
        unused_groups(root, owner, diagnostics);
    }
    let axes = all.axes(templates);
    for (section, what) in
        [("parameters", "parameter"), ("features", "feature"), ("derived", "derived value")]
    {
        for entry in root.entries_of(section) {
            let name = entry.key.as_str();
            // What a feature requires of others, or others of it, decides about those that are used.
            let decides = section == "features" && is_tied(entry, root.entries_of(section));
            if !all.words.contains(name) && !axes.contains(name) && !decides {
                diagnostics.push(unused_setting(what, entry, &format!("/{section}")));
            }
        }
    }
}

/// Finds the shared settings of a pipeline, or of a subgraph, that no pass and no other group extends.
fn unused_groups(root: &Value, owner: &Value, diagnostics: &mut Diagnostics) {
    let groups = owner.entries_of("shared_settings");
    if groups.is_empty() {
        return;
    }
    let mut named = BTreeSet::new();
    for user in root.entries_of("subgraphs").iter().map(|subgraph| &subgraph.value).chain([root]) {
        for entry in ["passes", "shared_settings"].into_iter().flat_map(|section| user.entries_of(section)) {
            entry.value.get("extends").into_iter().for_each(|names| {
                names.for_each_text(&mut |name| {
                    named.insert(name);
                });
            });
        }
    }
    for group in groups.iter().filter(|group| !named.contains(group.key.as_str())) {
        let message = format!("the shared settings \"{}\" are declared, but no pass extends them", group.key);
        let help = "let a pass say \"extends\", or remove them";
        diagnostics.push(note(group, "/shared_settings", message, help));
    }
}

/// Whether a feature is tied to others, so that its value decides about theirs.
fn is_tied(entry: &Entry, features: &[Entry]) -> bool {
    const TIES: [&str; 3] = ["requires", "excludes", "one_of"];
    let names = |entry: &Entry, name: &str| {
        let lists = TIES[..2].iter().filter_map(|tie| entry.value.get(tie)?.elements()).flatten();
        lists.filter_map(Value::text).any(|other| other == name)
    };
    TIES.iter().any(|tie| entry.value.get(tie).is_some())
        || features.iter().any(|other| names(other, &entry.key))
}

fn unused_setting(what: &str, entry: &Entry, section: &str) -> Diagnostic {
    let message = format!("the {what} \"{}\" is declared, but nothing uses it", entry.key);
    let help = "use it in an expression, let a template have an axis of its name, or remove it";
    note(entry, section, message, help)
}

fn note(entry: &Entry, section: &str, message: String, help: &str) -> Diagnostic {
    let diagnostic = Diagnostic::error(codes::UNUSED_SETTING, entry.key_span, message).help(help);
    diagnostic.pointer(pointer_join(section, &entry.key)).severity(Severity::Note)
}
