//! The settings that vary between configurations, and the values of each.
//!
//! Features and parameters that are booleans or enumerations are varied where anything outside of `bind` mentions them,
//! or an axis has their name. Numbers and lists are varied where they can decide about passes or axes (`when`,
//! `for_each`, `axes`, and what subgraphs are given): whole numbers in full up to a given count, lists in every length,
//! else the minimum, the default and the maximum value and those at which the expressions change
//! ([`thresholds`](super::thresholds)).

use std::collections::{BTreeMap, BTreeSet};

use crate::configurations::cover::Rules;
use crate::configurations::thresholds::Number;
use crate::configurations::varied_setting::Varied;
use crate::configurations::witness::value_of;
use crate::unused::axes_named;
use umbragraph_pipeline::document::{Document, Entry, Kind, Value};
use umbragraph_pipeline::expression::{self, Expression, ExpressionKind};
use umbragraph_pipeline::language::{FeatureDeclaration, Order, ParameterDeclaration, ParameterType};
use umbragraph_pipeline::model::{DeclarationKind, Model, Text};
use umbragraph_pipeline::pipeline::{Overrides, lacking, off};
use umbragraph_pipeline::shader::{TargetProfile, TemplateSet};

/// The reduced limit on the size of a range of whole numbers that are all tried. Lists are tried with up to this many
/// elements above their minimum length.
pub(super) const FEW_VALUES: usize = 16;

/// The JSON keys whose values can decide about passes and shader axes.
const DECIDING: &[&str] = &["when", "for_each", "axes", "with", "use", "shader"];

/// A string in a pass, a subgraph or a derived value of a document, with the settings on which it depends.
pub(super) struct Mention<'m> {
    /// The string as it is written in the document.
    pub(super) text: &'m str,
    /// The expression of the string, with derived values expanded; `None` for a string that is no expression.
    pub(super) expression: Option<Expression>,
    /// The names of the parameters and features on which the string depends.
    pub(super) settings: BTreeSet<&'m str>,
    /// The name of the pass that contains the string; `None` in a subgraph or a derived value.
    pub(super) pass: Option<&'m str>,
    /// The name of the shader axis to which the string gives a value; `None` for other strings.
    pub(super) axis: Option<&'m str>,
    /// Whether the string is the expression of a derived value that gives the axis of the same name its value.
    pub(super) is_derived: bool,
    /// The names of parameters of subgraphs and variables of loops in the string.
    pub(super) locals: BTreeSet<String>,
    pub(super) deciding: bool,
}

impl<'m> Mention<'m> {
    fn of(model: &'m Model, text: &'m Text, pass: Option<&'m str>) -> Self {
        let axis = text.keys.iter().position(|key| key == "axes").and_then(|at| text.keys.get(at + 1));
        let settings = model.settings_behind(model.named_in(text)).into_iter();
        let (expression, mut locals) = (model.closed(text), BTreeSet::new());
        let mut look = |inner: &Expression| {
            if let ExpressionKind::Name(name) = &inner.kind {
                locals.extend(name.strip_prefix('^').map(str::to_owned));
            }
        };
        expression.iter().for_each(|expression| expression.visit(&mut look));
        Self {
            text: &text.text,
            expression,
            locals,
            settings: settings.map(|id| model.declaration(id).name.as_str()).collect(),
            pass,
            axis: axis.map(String::as_str),
            is_derived: false,
            deciding: DECIDING.iter().any(|key| text.is_under(key)),
        }
    }

    /// Returns `true` if the expression takes an element of the list with this name.
    fn is_indexed(&self, name: &str) -> bool {
        let mut found = false;
        let mut look = |inner: &Expression| {
            found |= matches!(&inner.kind, ExpressionKind::Index(list, _)
                if matches!(&list.kind, ExpressionKind::Name(list) if list == name));
        };
        self.expression.iter().for_each(|expression| expression.visit(&mut look));
        found
    }
}

/// Returns the features of a document in the order of their names, each with all values that the target profile allows.
/// A feature with a value in `base` has only that value.
pub(super) fn features(document: &Document, base: &Overrides, profile: &TargetProfile) -> Vec<Varied> {
    let entries = document.root.entries_of("features");
    let mut varied: BTreeMap<&str, Varied> = BTreeMap::new();
    for entry in entries {
        let Ok(declaration) = entry.value.decode::<FeatureDeclaration>() else { continue };
        let given = base.features.iter().rev().find(|setting| setting.name == entry.key);
        let values = match given {
            Some(setting) => vec![setting.value.clone()],
            None => feature_values(&declaration, entry, entries, profile),
        };
        let name = entry.key.clone();
        varied.insert(&entry.key, Varied { name, values, feature: Some(declaration), exhaustive: true });
    }
    varied.into_values().collect()
}

/// The strings of a document that can affect its shaders and passes.
pub(super) struct Mentions<'d> {
    pub(super) document: &'d Document,
    pub(super) model: &'d Model,
    profile: &'d TargetProfile,
    /// The strings of passes and subgraphs outside of `bind`, and of derived values that have the name of an axis.
    pub(super) list: Vec<Mention<'d>>,
    /// The names of the axes of all templates that the strings name.
    pub(super) axes: BTreeSet<&'d str>,
    /// The strings that give a value to each parameter of a subgraph and variable of a loop, as indices into `list`.
    given: BTreeMap<&'d str, Vec<usize>>,
    /// The declared defaults of features and parameters.
    pub(super) defaults: BTreeMap<String, expression::Value>,
}

impl<'d> Mentions<'d> {
    pub(super) fn of(
        document: &'d Document,
        model: &'d Model,
        templates: &'d TemplateSet,
        profile: &'d TargetProfile,
    ) -> Self {
        let at_the_top =
            |kind| model.declarations().filter(move |(_, one)| one.kind == kind && one.owner.is_none());
        let mut texts: Vec<(&Text, Option<&str>)> = Vec::new();
        for (id, pass) in at_the_top(DeclarationKind::Pass) {
            texts.extend(model.texts_in(id).map(|text| (text, Some(pass.name.as_str()))));
        }
        for (id, _) in at_the_top(DeclarationKind::Subgraph) {
            texts.extend(model.texts_in(id).map(|text| (text, None)));
        }
        texts.retain(|(text, _)| !text.is_under("bind"));
        let axes = axes_named(texts.iter().map(|(text, _)| *text), templates);
        let mut given: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (at, (text, _)) in texts.iter().enumerate() {
            for keys in text.keys.windows(2).filter(|keys| ["with", "for_each"].contains(&&*keys[0])) {
                given.entry(&keys[1]).or_default().push(at);
            }
        }
        let mut list: Vec<Mention<'d>> =
            texts.into_iter().map(|(text, pass)| Mention::of(model, text, pass)).collect();
        for (id, derived) in at_the_top(DeclarationKind::Derived).filter(|(_, one)| axes.contains(&*one.name))
        {
            let of_axis = |text| Mention {
                axis: Some(derived.name.as_str()),
                is_derived: true,
                deciding: true,
                ..Mention::of(model, text, None)
            };
            list.extend(model.texts_in(id).map(of_axis));
        }
        let entries = |section: &str| document.root.entries_of(section);
        let settings = entries("features").iter().chain(entries("parameters"));
        let default = |entry: &Entry| Some((entry.key.clone(), value_of(entry.value.get("default")?)?));
        Self { document, model, profile, list, axes, given, defaults: settings.filter_map(default).collect() }
    }

    /// The `when` condition of a pass as an expression; `None` if the pass has none.
    pub(super) fn condition_of(&self, pass: &str) -> Option<Expression> {
        let pass = self.model.find(DeclarationKind::Pass, pass)?;
        let condition = self.model.texts_in(pass).find(|text| text.keys == ["when"])?;
        self.model.closed(condition)
    }

    /// The names of the document's passes that do not give the axis a value under `axes`.
    pub(super) fn passes_without(&self, axis: &str) -> impl Iterator<Item = &'d str> {
        let is_given = move |pass: &Entry| {
            let nodes = pass.value.entries().unwrap_or_default().iter();
            nodes.flat_map(|node| node.value.entries_of("axes")).any(|given| given.key == axis)
        };
        let passes = self.document.root.entries_of("passes").iter();
        passes.filter(move |pass| !is_given(pass)).map(|pass| pass.key.as_str())
    }

    /// The names of the settings on which a string depends through parameters of subgraphs and variables of loops.
    pub(super) fn behind_locals(&self, mention: &Mention<'d>) -> BTreeSet<&'d str> {
        let (mut found, mut seen) = (BTreeSet::new(), BTreeSet::new());
        let mut open: Vec<&str> = mention.locals.iter().map(String::as_str).collect();
        while let Some(name) = open.pop() {
            if seen.insert(name) {
                for given in self.given.get(name).into_iter().flatten().filter_map(|at| self.list.get(*at)) {
                    found.extend(&given.settings);
                    open.extend(given.locals.iter().map(String::as_str));
                }
            }
        }
        found
    }

    /// Returns the settings that can change shaders or passes, with the values to try. Ranges of more than `limit`
    /// whole numbers are sampled.
    pub(super) fn varied(&self, limit: usize) -> Vec<Varied> {
        let Self { document, profile, list, axes, defaults, .. } = self;
        let is_mentioned =
            |name: &str| axes.contains(name) || list.iter().any(|mention| mention.settings.contains(name));
        let mut varied = features(document, &Overrides::default(), profile);
        // What a varied feature requires or excludes, and its group, decide about it, so they vary too.
        let mentioned = (0..varied.len()).filter(|at| is_mentioned(&varied[*at].name)).collect();
        let wanted = Rules::new(&varied).with_tied(mentioned);
        let mut at = 0..;
        varied.retain(|_| at.next().is_some_and(|at| wanted.contains(&at)));
        let decides = |name: &str| {
            let deciding = |mention: &Mention<'_>| mention.deciding && mention.settings.contains(name);
            axes.contains(name) || list.iter().any(deciding)
        };
        let deciding = list.iter().filter(|mention| mention.deciding);
        let deciding: Vec<Expression> = deciding.filter_map(|mention| mention.expression.clone()).collect();
        for entry in document.root.entries_of("parameters") {
            let Ok(declaration) = entry.value.decode::<ParameterDeclaration>() else {
                continue;
            };
            let is_small = matches!(declaration.parameter_type, ParameterType::Bool | ParameterType::Enum);
            if !(if is_small { is_mentioned(&entry.key) } else { decides(&entry.key) }) {
                continue;
            }
            let is_indexed = list.iter().any(|mention| mention.is_indexed(&entry.key));
            let number = Number {
                name: &entry.key,
                default: defaults.get(&entry.key).and_then(expression::Value::number).unwrap_or_default(),
                min: declaration.min,
                max: declaration.max,
                defaults,
            };
            let (values, exhaustive) = values_of(&declaration, &entry.value, &number, &deciding, limit);
            varied.push(Varied {
                name: entry.key.clone(),
                feature: None,
                values: default_first(entry.value.get("default"), values),
                exhaustive: exhaustive && !is_indexed,
            });
        }
        varied
    }
}

/// The values that a feature can have on a target profile, the default first. Only the value for off if the profile
/// lacks a requirement of the feature.
fn feature_values(
    declaration: &FeatureDeclaration,
    entry: &Entry,
    features: &[Entry],
    profile: &TargetProfile,
) -> Vec<Value> {
    let value = &entry.value;
    if let Some(lacking) = lacking(entry, features, profile) {
        return vec![off(declaration, lacking.place)];
    }
    let words = words(&declaration.values, value);
    default_first(value.get("default"), if words.is_empty() { booleans(value) } else { words })
}

fn words(words: &[String], declaration: &Value) -> Vec<Value> {
    words.iter().map(|word| at(declaration, Kind::Text(word.clone()))).collect()
}

fn booleans(declaration: &Value) -> Vec<Value> {
    [false, true].into_iter().map(|value| at(declaration, Kind::Bool(value))).collect()
}

fn at(declaration: &Value, kind: Kind) -> Value {
    Value { span: declaration.span, kind }
}

fn default_first(default: Option<&Value>, values: Vec<Value>) -> Vec<Value> {
    let Some(default) = default else { return values };
    let json = default.to_json();
    std::iter::once(default.clone())
        .chain(values.into_iter().filter(|value| value.to_json() != json))
        .collect()
}

/// Returns the values to try for a parameter, and `true` if no other value can make a difference.
fn values_of(
    declaration: &ParameterDeclaration,
    value: &Value,
    range: &Number<'_>,
    deciding: &[Expression],
    limit: usize,
) -> (Vec<Value>, bool) {
    use ParameterType as T;
    let number = |number: f64| at(value, number_kind(number));
    match declaration.parameter_type {
        T::Bool => (booleans(value), true),
        T::Enum => (words(&declaration.values, value), true),
        T::U32 | T::I32 => match (declaration.min, declaration.max) {
            (Some(min), Some(max)) if max - min < limit as f64 && min.fract() == 0.0 => {
                let count = (max - min).max(0.0) as usize + 1;
                ((0..count).map(|step| number(min + step as f64)).collect(), true)
            }
            _ => {
                // A number without a sign has a minimum anyway.
                let lower = if declaration.parameter_type == T::U32 { Some(0.0) } else { None };
                let min = range.min.into_iter().chain(lower).reduce(f64::max);
                let range = Number { min, ..*range };
                (range.whole_values(deciding).into_iter().map(number).collect(), false)
            }
        },
        T::F32 => (range.real_values(deciding).into_iter().map(number).collect(), false),
        T::F32List | T::U32List => {
            let defaults: Vec<f64> = value
                .elements_of("default")
                .iter()
                .filter_map(|element| element.to_json().as_f64())
                .collect();
            let lower = declaration.min_length.unwrap_or(0) as usize;
            let limit = declaration.max_length.map_or(defaults.len(), |limit| limit as usize);
            let last = limit.min(lower + FEW_VALUES);
            let lists: Vec<Value> = (lower..=last)
                .filter_map(|length| list_of(length, &defaults, declaration))
                .map(|list| at(value, Kind::Array(list.into_iter().map(number).collect())))
                .collect();
            let all = declaration.max_length.is_some() && last == limit && lists.len() == limit + 1 - lower;
            (lists, all)
        }
    }
}

/// Returns the default list, cut or extended in its declared order to a length. `None` if an element is outside the
/// declared range.
fn list_of(length: usize, defaults: &[f64], declaration: &ParameterDeclaration) -> Option<Vec<f64>> {
    let mut list: Vec<f64> = defaults.iter().copied().take(length).collect();
    while list.len() < length {
        let last = list.last().copied().or(declaration.min).unwrap_or(0.0);
        list.push(match declaration.order {
            _ if list.is_empty() => last,
            None => last,
            Some(Order::StrictlyIncreasing) => last + 1.0,
            Some(Order::StrictlyDecreasing) => last - 1.0,
        });
    }
    let in_range = |number: &f64| {
        declaration.min.is_none_or(|min| *number >= min) && declaration.max.is_none_or(|max| *number <= max)
    };
    list.iter().all(in_range).then_some(list)
}

fn number_kind(number: f64) -> Kind {
    let whole =
        (number.fract() == 0.0 && number.abs() < 9.0e15).then(|| serde_json::Number::from(number as i64));
    whole.or_else(|| serde_json::Number::from_f64(number)).map_or(Kind::Null, Kind::Number)
}
