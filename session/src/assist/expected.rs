//! The keys, words and names that can stand at a place.

use std::collections::BTreeSet;
use std::ops::Range;

use super::context::{Context, Position};
use super::rules::Rules;
use super::site::{Site, Spot};
use super::{Candidate, CandidateKind, Expected};
use crate::graph::document::{Signs, Value};
use crate::graph::expression::FUNCTIONS;
use crate::graph::language::node_kind;
use crate::graph::model::{Declaration, DeclarationKind as K};
use crate::graph::pipeline::FileKind;
use crate::graph::shader::{AxisKind, ShaderModule, TypeLayout};
use crate::tokens;

/// The kinds of declarations that an expression can name.
const VALUES: [K; 7] = [K::Parameter, K::Feature, K::Derived, K::Input, K::Variable, K::Resource, K::Data];
/// The kinds of declarations that a reference, such as `&color`, can name.
const RESOURCES: [K; 3] = [K::Resource, K::Input, K::Data];

/// Returns the completion candidates at the cursor.
pub(super) fn expected(context: &Context<'_>) -> Expected {
    let site = context.site();
    let position = context.position(&site);
    let mut found = Found {
        context,
        site: &site,
        position: &position,
        replaced: site.replaced.clone(),
        list: Vec::new(),
    };
    match site.spot {
        Spot::Key { object, entry } => found.keys(object, entry.map(|entry| entry.key.as_str())),
        Spot::Value(_) => match site.string(context.text, context.offset) {
            Some((value, within)) => found.in_string(value, within),
            None => found.values(),
        },
    }
    Expected { replaced: context.span(found.replaced), candidates: found.list }
}

/// Returns an object key with the quotes, comma and colon that the text around it lacks.
pub(super) fn key_text(text: &str, replaced: &Range<usize>, key: &str) -> String {
    let before = text.get(..replaced.start).unwrap_or_default();
    let after = text.get(replaced.end..).unwrap_or_default().trim_start();
    let quoted = serde_json::Value::from(key).to_string();
    if after.starts_with(':') {
        return quoted;
    }
    let last = tokens::last(before).unwrap_or(before.trim_end());
    let comma = if last.ends_with(['{', ',']) { "" } else { ", " };
    format!("{comma}{quoted}: ")
}

struct Found<'c, 'a> {
    context: &'c Context<'a>,
    site: &'c Site<'a>,
    position: &'c Position<'c>,
    replaced: Range<usize>,
    list: Vec<Candidate>,
}

impl<'a> Found<'_, 'a> {
    fn push(&mut self, kind: CandidateKind, label: &str, text: String) -> &mut Candidate {
        let new = Candidate { kind, label: label.to_owned(), text, detail: None, description: None };
        self.list.push(new);
        let last = self.list.len() - 1;
        &mut self.list[last]
    }

    /// Adds an object key, with the quotes, comma and colon that the text around it lacks.
    fn key(&mut self, kind: CandidateKind, key: &str, detail: Option<String>, description: Option<String>) {
        let text = key_text(self.context.text, &self.replaced, key);
        let candidate = self.push(kind, key, text);
        (candidate.detail, candidate.description) = (detail, description);
    }

    fn keys(&mut self, object: &Value, present: Option<&str>) {
        let taken: BTreeSet<&str> =
            object.entries().unwrap_or_default().iter().map(|entry| entry.key.as_str()).collect();
        let is_free = |key: &str| !taken.contains(key) || present == Some(key);
        let rules = self.context.rules(self.site);
        // A pass has one node kind.
        let kind = node_kind(object).map(|entry| entry.key.as_str()).filter(|kind| present != Some(*kind));
        let is_pass = matches!(self.position.way.as_slice(), ["passes", _]);
        let registry = self.context.loaded.registry();
        let is_kind = |key: &str| key == "use" || registry.iter().any(|one| one.name() == key);
        for (key, rules) in rules.keys() {
            if is_free(key) && !(is_pass && kind.is_some() && is_kind(key)) {
                self.key(CandidateKind::Key, key, None, rules.description().map(str::to_owned));
            }
        }
        for (kind, name, detail, description) in self.named_keys() {
            if is_free(&name) {
                self.key(kind, &name, detail, description);
            }
        }
    }

    /// Returns the names that can be keys at the cursor, such as bindings and passes. Each has a kind, a short detail
    /// and a description.
    fn named_keys(&self) -> Vec<(CandidateKind, String, Option<String>, Option<String>)> {
        let context = self.context;
        let pass = || context.pass(self.position);
        match self.position.way.as_slice() {
            ["passes" | "shared_settings", .., "bind"] => {
                let modules = pass().map(|pass| context.modules(&pass)).unwrap_or_default();
                let bindings = modules.iter().flat_map(|module| &module.reflection.bindings);
                let found = bindings
                    .map(|one| (CandidateKind::Binding, one.name.clone(), Some(one.type_name.clone()), None));
                let unique: std::collections::BTreeMap<String, _> =
                    found.map(|one| (one.1.clone(), one)).collect();
                unique.into_values().collect()
            }
            ["passes" | "shared_settings", .., "bind", binding, "values"] => {
                let modules = pass().map(|pass| context.modules(&pass)).unwrap_or_default();
                let bindings = modules.iter().flat_map(|module| &module.reflection.bindings);
                let blocks = bindings.filter(|one| one.name == *binding).filter_map(|one| one.block.as_ref());
                let members = blocks.flat_map(|block| match block {
                    TypeLayout::Struct { members, .. } => members.as_slice(),
                    _ => &[],
                });
                let found = members
                    .map(|one| (CandidateKind::Binding, one.name.clone(), Some(one.layout.spelling()), None));
                let mut known = BTreeSet::new();
                found.filter(|(_, name, ..)| known.insert(name.clone())).collect()
            }
            ["passes" | "shared_settings", .., "axes"] => {
                let template = pass().and_then(|pass| context.template(&pass));
                let axes = template.and_then(|name| context.loaded.templates().axes(name));
                let axes = axes.into_iter().flat_map(crate::graph::shader::Axes::iter);
                axes.map(|axis| {
                    let detail = format!("{} ({})", axis.kind.describe(), axis.default);
                    (CandidateKind::Axis, axis.name.clone(), Some(detail), Some(axis.description.clone()))
                })
                .collect()
            }
            ["passes", _, "with"] => {
                let used = pass().and_then(|pass| pass.value.get("use")?.text());
                let id = used.and_then(|name| context.model.find(K::Subgraph, name));
                let is_given = |one: &Declaration| {
                    one.owner.is_some() && one.owner == id && matches!(one.kind, K::Input | K::Parameter)
                };
                let given = context.model.declarations().filter(|(_, one)| is_given(one));
                given.map(|(_, one)| self.described(one)).collect()
            }
            ["passes", _, "passthrough"] => self.all_described(&RESOURCES),
            ["presets", _, "parameters"] => self.all_described(&[K::Parameter]),
            ["presets", _, "features"] => self.all_described(&[K::Feature]),
            ["inserts"] => self.all_described(&[K::ExtensionPoint]),
            [section] if self.lies_over_others() => match *section {
                "parameters" => self.all_described(&[K::Parameter]),
                "features" => self.all_described(&[K::Feature]),
                "derived" => self.all_described(&[K::Derived]),
                "resources" => self.all_described(&[K::Resource]),
                "passes" => self.all_described(&[K::Pass]),
                _ => Vec::new(),
            },
            _ => Vec::new(),
        }
    }

    /// Returns `true` if the file gives values to declarations of other files.
    fn lies_over_others(&self) -> bool {
        self.context.kind == FileKind::Parameters || self.context.document.root.get("extends").is_some()
    }

    fn all_described(&self, kinds: &[K]) -> Vec<(CandidateKind, String, Option<String>, Option<String>)> {
        let found = self.context.visible(self.position, kinds);
        found.into_iter().map(|(_, one)| self.described(one)).collect()
    }

    fn described(&self, one: &Declaration) -> (CandidateKind, String, Option<String>, Option<String>) {
        let value = self.context.value_of(one);
        let description = value.and_then(|value| value.get("description")?.text()).map(str::to_owned);
        (CandidateKind::Name(one.kind), one.name.clone(), detail(one, value), description)
    }

    /// Adds the candidates inside of a string, `within` bytes after its opening quote.
    fn in_string(&mut self, value: &Value, within: usize) {
        let text = value.text().unwrap_or_default();
        let is_verbatim = value.span.range().len() == text.len() + 2;
        let Some(before) = text.get(..within).filter(|_| is_verbatim || !text.contains('\\')) else { return };
        let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let word = before.trim_end_matches(is_of_name);
        match (before.chars().next(), word.chars().next_back()) {
            (Some('='), sign) => {
                let start = value.span.start as usize + 1 + word.len();
                let rest = &text[within..];
                let length =
                    before.len() - word.len() + rest.len() - rest.trim_start_matches(is_of_name).len();
                self.replaced = start..start + length;
                match sign {
                    Some('&') => self.names(&RESOURCES, ["", ""]),
                    Some('@') => self.names(&[K::Pass], ["", ""]),
                    // Within a text of its own nothing is known.
                    _ if word.matches('\'').count() % 2 == 1 => self.words_in_quotes(word),
                    _ => self.expression(["", ""]),
                }
            }
            (Some('&'), _) => match before.split_once('@') {
                Some((resource, _)) => self.names(&[K::Pass], [&format!("\"{resource}@"), "\""]),
                None => self.names(&RESOURCES, ["\"&", "\""]),
            },
            _ => self.values(),
        }
    }

    /// Adds the names and functions of the expression language, each with a prefix and a suffix.
    fn expression(&mut self, around: [&str; 2]) {
        self.names(&VALUES, around);
        let [before, behind] = around;
        self.push(CandidateKind::Function, "viewport", format!("{before}viewport{behind}")).description =
            Some("The size of the picture.".to_owned());
        for function in FUNCTIONS {
            let candidate = self.push(
                CandidateKind::Function,
                function.name,
                format!("{before}{}{behind}", function.name),
            );
            candidate.detail = Some(function.usage.to_owned());
            candidate.description = Some(function.description.to_owned());
        }
    }

    /// Adds the words of the enumeration that a quoted text in an expression is compared with. `before` is the
    /// expression before the word at the cursor.
    fn words_in_quotes(&mut self, before: &str) {
        let named = before.trim_end_matches(['\'', ' ', '=', '!']);
        let name = &named[named.trim_end_matches(|c: char| c.is_ascii_alphanumeric() || c == '_').len()..];
        let found = self.context.visible(self.position, &[K::Parameter, K::Feature]);
        let declared = found.into_iter().find(|(_, one)| one.name == name);
        let value = declared.and_then(|(_, one)| self.context.value_of(one));
        for word in value.map(|value| value.elements_of("values")).unwrap_or_default() {
            let word = word.text().unwrap_or_default();
            self.push(CandidateKind::Word, word, word.to_owned());
        }
    }

    /// Adds the names of visible declarations, each with a prefix and a suffix.
    fn names(&mut self, kinds: &[K], [before, behind]: [&str; 2]) {
        for (kind, name, detail, description) in self.all_described(kinds) {
            let candidate = self.push(kind, &name, format!("{before}{name}{behind}"));
            (candidate.detail, candidate.description) = (detail, description);
        }
    }

    /// Adds the candidates for a value that is not yet a reference or an expression.
    fn values(&mut self) {
        let rules = self.context.rules(self.site);
        for (word, description) in rules.words() {
            self.push(CandidateKind::Word, word, format!("\"{word}\"")).description =
                description.map(str::to_owned);
        }
        match self.position.way.as_slice() {
            ["passes" | "shared_settings", _, "after", ..]
            | ["extension_points", _, "after" | "before", ..] => {
                self.names(&[K::Pass], ["\"", "\""]);
            }
            ["passes", _, "toggle"] => self.names(&[K::Toggle], ["\"", "\""]),
            ["passes", _, "use"] => self.names(&[K::Subgraph], ["\"", "\""]),
            ["passes" | "shared_settings", _, "extends", ..] => {
                self.names(&[K::SharedSettings], ["\"", "\""]);
            }
            ["features", _, "requires" | "excludes" | "one_of", ..] => {
                self.names(&[K::Feature], ["\"", "\""]);
            }
            ["preset"] => self.names(&[K::Preset], ["\"", "\""]),
            ["passes" | "shared_settings", .., "geometry"] => self.names(&[K::Geometry], ["\"", "\""]),
            ["passes" | "shared_settings", .., "shader"] => self.templates(),
            ["passes" | "shared_settings", .., "axes", axis] => self.axis_values(axis),
            ["parameters" | "features", name, "values", _] => self.words_of_axes(name),
            ["parameters" | "features", name] | ["presets", _, "parameters" | "features", name] => {
                self.setting_values(name);
            }
            _ => {}
        }
        self.with_signs(&rules);
    }

    fn with_signs(&mut self, rules: &Rules<'_>) {
        let signs: Vec<Signs> = rules.signs().collect();
        if signs.contains(&Signs::Reference) {
            self.names(&RESOURCES, ["\"&", "\""]);
        } else if signs.contains(&Signs::Expression) {
            self.expression(["\"=", "\""]);
        }
        if rules.takes("boolean") {
            self.booleans();
        }
    }

    fn booleans(&mut self) {
        self.push(CandidateKind::Word, "true", "true".to_owned());
        self.push(CandidateKind::Word, "false", "false".to_owned());
    }

    fn templates(&mut self) {
        let templates = self.context.loaded.templates().clone();
        for name in templates.names() {
            self.push(CandidateKind::Template, name, format!("\"{name}\""));
        }
    }

    fn axis_values(&mut self, axis: &str) {
        let pass = self.context.pass(self.position);
        let template = pass.and_then(|pass| self.context.template(&pass));
        let axes = template.and_then(|name| self.context.loaded.templates().axes(name));
        match axes.and_then(|axes| axes.get(axis)).map(|axis| axis.kind.clone()) {
            Some(AxisKind::Enum(words) | AxisKind::TextureFormat(words)) => {
                for word in words {
                    self.push(CandidateKind::Word, &word, format!("\"{word}\""));
                }
            }
            Some(AxisKind::Bool) => self.booleans(),
            Some(AxisKind::Integer { .. }) | None => {}
        }
    }

    /// Adds the words that an axis of a template takes, for the list of words of a value of its name.
    fn words_of_axes(&mut self, name: &str) {
        let passes = self.context.visible(self.position, &[K::Pass]);
        let templates = passes.iter().filter_map(|(_, one)| {
            node_kind(self.context.value_of(one)?)?.value.get("shader").and_then(Value::text)
        });
        let templates: BTreeSet<&str> = templates.collect();
        let set = self.context.loaded.templates();
        let axes = templates.into_iter().filter_map(|template| set.axes(template)?.get(name));
        let words: BTreeSet<String> = axes
            .flat_map(|axis| match &axis.kind {
                AxisKind::Enum(words) | AxisKind::TextureFormat(words) => words.clone(),
                AxisKind::Bool | AxisKind::Integer { .. } => Vec::new(),
            })
            .collect();
        for word in words {
            self.push(CandidateKind::Word, &word, format!("\"{word}\""));
        }
    }

    /// Adds the values of a parameter or feature, in a place that sets its value.
    fn setting_values(&mut self, name: &str) {
        let found = self.context.visible(self.position, &[K::Parameter, K::Feature]);
        let declared = found.into_iter().find(|(_, one)| one.name == name);
        let Some(value) = declared.and_then(|(_, one)| self.context.value_of(one)) else { return };
        for word in value.elements_of("values") {
            let word = word.text().unwrap_or_default();
            self.push(CandidateKind::Word, word, format!("\"{word}\""));
        }
        if value.get("type").and_then(Value::text) == Some("bool") {
            self.booleans();
        }
    }
}

/// Returns a short summary of a declaration: type and default, format, or node kind. Returns `None` if it has none.
fn detail(one: &Declaration, value: Option<&Value>) -> Option<String> {
    let value = value?;
    let word = |value: &Value, key: &str| {
        let found = value.get(key)?;
        Some(found.text().map_or_else(|| found.to_json().to_string(), str::to_owned))
    };
    let parts: Vec<String> = match one.kind {
        K::Parameter | K::Feature => {
            let default = word(value, "default").map(|default| format!("= {default}"));
            [word(value, "type"), default, word(value, "unit")].into_iter().flatten().collect()
        }
        K::Resource => ["texture", "buffer"]
            .into_iter()
            .filter_map(|kind| Some((kind, value.get(kind)?)))
            .flat_map(|(kind, inner)| [Some(kind.to_owned()), word(inner, "format")])
            .flatten()
            .collect(),
        K::Derived => vec![value.text().map_or_else(|| value.to_json().to_string(), str::to_owned)],
        K::Pass => {
            node_kind(value).map(|kind| kind.key.clone()).or_else(|| word(value, "use")).into_iter().collect()
        }
        _ => Vec::new(),
    };
    (!parts.is_empty()).then(|| parts.join(" "))
}

/// Returns the place in a template of the declaration of a binding; `None` if the module does not declare it.
pub(super) fn declared_in(module: &ShaderModule, binding: &str) -> Option<crate::graph::source::Span> {
    let text = &*module.wgsl;
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let found = text.match_indices(binding).map(|(at, _)| at).find(|at| {
        let (before, behind) = (&text[..*at], &text[at + binding.len()..]);
        let statement = before.rsplit([';', '}']).next().unwrap_or_default();
        !before.ends_with(is_of_name)
            && behind.trim_start().starts_with(':')
            && statement.contains("@binding")
    })?;
    module.map.span(found..found + binding.len())
}
