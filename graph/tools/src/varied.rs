//! The settings that vary between configurations, and the values of each.
//!
//! Features and parameters that are booleans or enumerations are varied where anything outside of `bind` mentions them,
//! or an axis has their name. Numbers and lists are varied where they can decide about passes or axes (`when`,
//! `for_each`, `axes`, and what subgraphs are given): whole numbers in full up to a given count, lists in every length,
//! else the minimum, the default and the maximum value and those at which the expressions change
//! ([`thresholds`](super::thresholds)).

use std::collections::{BTreeMap, BTreeSet};

use crate::cover::Rules;
use crate::thresholds::Number;
use crate::varied_setting::Varied;
use crate::witness::value_of;
use umbragraph_pipeline::document::{Document, Entry, Kind, Value};
use umbragraph_pipeline::expression::{self, Expression};
use umbragraph_pipeline::language::{FeatureDeclaration, Order, ParameterDeclaration, ParameterType};
use umbragraph_pipeline::pipeline::{Overrides, has_word, lacking, off};
use umbragraph_pipeline::shader::{TargetProfile, TemplateSet};

/// The maximum number of lengths of a list.
pub(super) const FEW_VALUES: usize = 16;

/// Keys under which a value decides about passes and axes.
const DECIDING: &[&str] = &["when", "for_each", "axes", "with", "use", "shader"];

/// The place of a text among passes.
pub(super) struct Mention<'a> {
    pub(super) text: &'a str,
    /// The pass of the document in which it stands.
    pub(super) pass: Option<&'a str>,
    /// The key of the axis that the text is about.
    pub(super) axis: Option<&'a str>,
    pub(super) deciding: bool,
}

/// The features of a document, each with the value that `base` gives it or all that it can have, by name.
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

/// What decides about the shaders and passes of a document.
pub(super) struct Mentions<'d> {
    pub(super) document: &'d Document,
    profile: &'d TargetProfile,
    /// The texts of passes and subgraphs, outside of `bind`. A derived value with the name of an axis is what the axis
    /// follows.
    pub(super) list: Vec<Mention<'d>>,
    /// The axes of all templates that they name.
    pub(super) axes: BTreeSet<&'d str>,
    /// The declared defaults of features and parameters.
    pub(super) defaults: BTreeMap<String, expression::Value>,
}

impl<'d> Mentions<'d> {
    pub(super) fn of(document: &'d Document, templates: &'d TemplateSet, profile: &'d TargetProfile) -> Self {
        let mut list = Vec::new();
        let entries = |section: &str| document.root.entries_of(section);
        for entry in entries("passes") {
            collect(&entry.value, Some(&entry.key), None, false, &mut list);
        }
        for entry in entries("subgraphs") {
            collect(&entry.value, None, None, false, &mut list);
        }
        let axes = templates.axes_of(|template| list.iter().any(|mention| mention.text == template));
        for entry in entries("derived").iter().filter(|entry| axes.contains(entry.key.as_str())) {
            collect(&entry.value, None, Some(&entry.key), true, &mut list);
        }
        let settings = entries("features").iter().chain(entries("parameters"));
        let default = |entry: &Entry| Some((entry.key.clone(), value_of(entry.value.get("default")?)?));
        Self { document, profile, list, axes, defaults: settings.filter_map(default).collect() }
    }

    /// The settings that decide about shaders and passes; a range of over `limit` whole numbers is not gone through.
    pub(super) fn varied(&self, limit: usize) -> Vec<Varied> {
        let Self { document, profile, list, axes, defaults } = self;
        let is_mentioned =
            |name: &str| axes.contains(name) || list.iter().any(|mention| has_word(mention.text, name));
        let mut varied = features(document, &Overrides::default(), profile);
        // What a varied feature requires or excludes, and its group, decide about it, so they vary too.
        let mentioned = (0..varied.len()).filter(|at| is_mentioned(&varied[*at].name)).collect();
        let wanted = Rules::new(&varied).with_tied(mentioned);
        let mut at = 0..;
        varied.retain(|_| at.next().is_some_and(|at| wanted.contains(&at)));
        let decides = |name: &str| {
            axes.contains(name) || list.iter().any(|mention| mention.deciding && has_word(mention.text, name))
        };
        let deciding = list.iter().filter(|mention| mention.deciding);
        let deciding: Vec<Expression> = deciding.filter_map(|mention| parse(mention.text)).collect();
        for entry in document.root.entries_of("parameters") {
            let Ok(declaration) = entry.value.decode::<ParameterDeclaration>() else {
                continue;
            };
            let is_small = matches!(declaration.parameter_type, ParameterType::Bool | ParameterType::Enum);
            if !(if is_small { is_mentioned(&entry.key) } else { decides(&entry.key) }) {
                continue;
            }
            let is_indexed = list.iter().any(|mention| mention.text.contains(&format!("{}[", entry.key)));
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

/// The expression of a text; an equals sign in front of a computed word is not part of it.
pub(super) fn parse(text: &str) -> Option<Expression> {
    expression::parse(text.strip_prefix('=').unwrap_or(text)).ok()
}

fn collect<'a>(
    value: &'a Value,
    pass: Option<&'a str>,
    axis: Option<&'a str>,
    deciding: bool,
    mentions: &mut Vec<Mention<'a>>,
) {
    match &value.kind {
        Kind::Text(text) => mentions.push(Mention { text, pass, axis, deciding }),
        Kind::Array(elements) => {
            elements.iter().for_each(|element| collect(element, pass, axis, deciding, mentions));
        }
        Kind::Object(entries) => {
            for entry in entries.iter().filter(|entry| entry.key != "bind") {
                let deciding = deciding || DECIDING.contains(&entry.key.as_str());
                if entry.key == "axes" {
                    for axis in entry.value.entries().unwrap_or_default() {
                        collect(&axis.value, pass, Some(&axis.key), true, mentions);
                    }
                } else {
                    collect(&entry.value, pass, axis, deciding, mentions);
                }
            }
        }
        Kind::Null | Kind::Bool(_) | Kind::Number(_) | Kind::Missing => {}
    }
}

/// The values that a feature can have on a profile, the default first.
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

/// The values that are tried, and whether these are all that can make a difference.
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

/// The default cut, or continued within the declared range and order, to a length.
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
