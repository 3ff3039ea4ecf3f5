//! The configurations of a pipeline that can differ in their shaders or passes.
//!
//! Features and parameters that are booleans or enumerations are varied where anything outside of `bind` mentions them,
//! or an axis has their name. Numbers and lists are varied where they can decide about passes or axes (`when`,
//! `for_each`, `axes`, and what subgraphs are given): a small range in full, lists in every length, else the least, the
//! default and the greatest value; then the axes that depend on them count as open, with all of their own values.
//! Configurations that the features' `requires` and `excludes` forbid are left out.
//!
//! Up to 4,096 configurations are enumerated. Beyond, the default, every single change and every pair of changes
//! are, as far as they fit, and the number is a lower bound.

use std::collections::{BTreeMap, BTreeSet};

use super::load::has_word;
use super::setting::{Choice, Setting};
use crate::document::{Document, Kind, Value};
use crate::language::{FeatureDeclaration, Order, ParameterDeclaration, ParameterType};
use crate::shader::TemplateSet;

/// The most configurations that are enumerated.
const MAXIMUM: usize = 4096;

/// The most values of a number, or lengths of a list, that are tried one by one.
const MAXIMUM_VALUES: usize = 16;

/// Keys under which a value decides about passes and axes.
const DECIDING: &[&str] = &["when", "for_each", "axes", "with", "use", "shader"];

/// The configurations, the default first.
#[derive(Debug, Default)]
pub(super) struct Configurations {
    pub(super) choices: Vec<Choice>,
    /// Whether these are all.
    pub(super) exact: bool,
    /// Whether there were too many to enumerate.
    pub(super) sampled: bool,
    /// Axes that can have values which no configuration here gives them.
    pub(super) open_axes: BTreeSet<String>,
}

/// A feature or parameter with the values that are tried, the default first.
struct Varied {
    name: String,
    feature: Option<FeatureDeclaration>,
    values: Vec<Value>,
    exhaustive: bool,
}

/// Where a text stands among passes.
struct Mention<'a> {
    text: &'a str,
    /// The key of the axis that the text is about.
    axis: Option<&'a str>,
    deciding: bool,
}

/// Enumerates the configurations of a document.
pub(super) fn enumerate(document: &Document, templates: &TemplateSet) -> Configurations {
    let mut mentions = Vec::new();
    for section in ["passes", "subgraphs"] {
        if let Some(value) = document.root.get(section) {
            collect(value, None, false, &mut mentions);
        }
    }
    let is_named = |template: &&str| {
        let computed = |text: &str| text.contains('{');
        mentions
            .iter()
            .any(|mention| mention.text == *template || (mention.deciding && computed(mention.text)))
    };
    let axes: BTreeSet<&str> = templates
        .names()
        .filter(is_named)
        .filter_map(|name| templates.axes(name))
        .flat_map(crate::shader::Axes::names)
        .collect();
    let varied = varied(document, &mentions, &axes);
    let open_settings: Vec<&str> =
        varied.iter().filter(|each| !each.exhaustive).map(|each| each.name.as_str()).collect();
    let by_expression = mentions
        .iter()
        .filter(|mention| open_settings.iter().any(|name| has_word(mention.text, name)))
        .filter_map(|mention| mention.axis);
    let open_axes = by_expression.chain(open_settings.iter().copied()).map(str::to_owned).collect();
    let (choices, sampled) = choose(&varied);
    let exact = !sampled && varied.iter().all(|each| each.exhaustive);
    Configurations { choices, exact, sampled, open_axes }
}

fn collect<'a>(value: &'a Value, axis: Option<&'a str>, deciding: bool, mentions: &mut Vec<Mention<'a>>) {
    match &value.kind {
        Kind::Text(text) => mentions.push(Mention { text, axis, deciding }),
        Kind::Array(elements) => {
            elements.iter().for_each(|element| collect(element, axis, deciding, mentions));
        }
        Kind::Object(entries) => {
            for entry in entries.iter().filter(|entry| entry.key != "bind") {
                let deciding = deciding || DECIDING.contains(&entry.key.as_str());
                if entry.key == "axes" {
                    for axis in entry.value.entries().unwrap_or_default() {
                        collect(&axis.value, Some(&axis.key), true, mentions);
                    }
                } else {
                    collect(&entry.value, axis, deciding, mentions);
                }
            }
        }
        Kind::Null | Kind::Bool(_) | Kind::Number(_) => {}
    }
}

fn varied(document: &Document, mentions: &[Mention<'_>], axes: &BTreeSet<&str>) -> Vec<Varied> {
    let entries = |name: &str| document.root.get(name).and_then(Value::entries).unwrap_or_default();
    let mut features: BTreeMap<&str, (FeatureDeclaration, &Value)> = BTreeMap::new();
    for entry in entries("features") {
        if let Ok(declaration) = serde_json::from_value(entry.value.to_json()) {
            features.insert(&entry.key, (declaration, &entry.value));
        }
    }
    let is_mentioned =
        |name: &str| axes.contains(name) || mentions.iter().any(|mention| has_word(mention.text, name));
    // What a varied feature requires or excludes decides about it, so it varies too.
    let mut wanted: BTreeSet<&str> = features.keys().copied().filter(|name| is_mentioned(name)).collect();
    loop {
        let before = wanted.len();
        for (name, (declaration, _)) in &features {
            let others = || declaration.requires.iter().chain(&declaration.excludes).map(String::as_str);
            if wanted.contains(name) || others().any(|other| wanted.contains(other)) {
                wanted.insert(name);
                wanted.extend(others().filter(|other| features.contains_key(other)));
            }
        }
        if wanted.len() == before {
            break;
        }
    }
    let mut varied = Vec::new();
    for (name, (declaration, value)) in features.iter().filter(|(name, _)| wanted.contains(**name)) {
        let words = words(&declaration.values, value);
        varied.push(Varied {
            name: (*name).to_owned(),
            values: default_first(
                value.get("default"),
                if words.is_empty() { booleans(value) } else { words },
            ),
            feature: Some(declaration.clone()),
            exhaustive: true,
        });
    }
    let decides = |name: &str| {
        axes.contains(name) || mentions.iter().any(|mention| mention.deciding && has_word(mention.text, name))
    };
    for entry in entries("parameters") {
        let Ok(declaration) = serde_json::from_value::<ParameterDeclaration>(entry.value.to_json()) else {
            continue;
        };
        let is_small = matches!(declaration.parameter_type, ParameterType::Bool | ParameterType::Enum);
        if !(if is_small { is_mentioned(&entry.key) } else { decides(&entry.key) }) {
            continue;
        }
        let is_indexed = mentions.iter().any(|mention| mention.text.contains(&format!("{}[", entry.key)));
        let (values, exhaustive) = values_of(&declaration, &entry.value);
        varied.push(Varied {
            name: entry.key.clone(),
            feature: None,
            values: default_first(entry.value.get("default"), values),
            exhaustive: exhaustive && !is_indexed,
        });
    }
    varied
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
fn values_of(declaration: &ParameterDeclaration, value: &Value) -> (Vec<Value>, bool) {
    use ParameterType as T;
    let number = |number: f64| at(value, number_kind(number));
    match declaration.parameter_type {
        T::Bool => (booleans(value), true),
        T::Enum => (words(&declaration.values, value), true),
        T::U32 | T::I32 => match (declaration.min, declaration.max) {
            (Some(min), Some(max)) if max - min < MAXIMUM_VALUES as f64 && min.fract() == 0.0 => {
                let count = (max - min).max(0.0) as usize + 1;
                ((0..count).map(|step| number(min + step as f64)).collect(), true)
            }
            ends => ([ends.0, ends.1].into_iter().flatten().map(number).collect(), false),
        },
        T::F32 => ([declaration.min, declaration.max].into_iter().flatten().map(number).collect(), false),
        T::F32List | T::U32List => {
            let defaults: Vec<f64> = value
                .get("default")
                .and_then(Value::elements)
                .unwrap_or_default()
                .iter()
                .filter_map(|element| element.to_json().as_f64())
                .collect();
            let least = declaration.min_length.unwrap_or(0) as usize;
            let most = declaration.max_length.map_or(defaults.len(), |most| most as usize);
            let last = most.min(least + MAXIMUM_VALUES);
            let lists: Vec<Value> = (least..=last)
                .filter_map(|length| list_of(length, &defaults, declaration))
                .map(|list| at(value, Kind::Array(list.into_iter().map(number).collect())))
                .collect();
            let all = declaration.max_length.is_some() && last == most && lists.len() == most + 1 - least;
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

/// The choices, and whether they are a part only.
fn choose(varied: &[Varied]) -> (Vec<Choice>, bool) {
    let total = varied.iter().try_fold(1_usize, |total, each| total.checked_mul(each.values.len().max(1)));
    let all = total.filter(|total| *total <= MAXIMUM);
    let mut picks: Vec<Vec<usize>> = Vec::new();
    match all {
        Some(total) => {
            for number in 0..total {
                let mut rest = number;
                picks.push(
                    varied
                        .iter()
                        .map(|each| {
                            let count = each.values.len().max(1);
                            let pick = rest % count;
                            rest /= count;
                            pick
                        })
                        .collect(),
                );
            }
        }
        None => {
            let plain = vec![0; varied.len()];
            let changes: Vec<(usize, usize)> = varied
                .iter()
                .enumerate()
                .flat_map(|(at, each)| (1..each.values.len()).map(move |pick| (at, pick)))
                .collect();
            picks.push(plain.clone());
            let pairs = changes
                .iter()
                .enumerate()
                .flat_map(|(at, one)| changes[at + 1..].iter().map(move |two| (one, two)));
            for (one, two) in changes.iter().map(|one| (one, one)).chain(pairs) {
                // Two values of one setting are no pair of changes.
                if picks.len() >= MAXIMUM || (one.0 == two.0 && one.1 != two.1) {
                    continue;
                }
                let mut pick = plain.clone();
                pick[one.0] = one.1;
                pick[two.0] = two.1;
                picks.push(pick);
            }
        }
    }
    let choices =
        picks.iter().filter(|pick| is_allowed(varied, pick)).map(|pick| choice(varied, pick)).collect();
    (choices, all.is_none())
}

/// Whether the features agree with what they require and exclude of one another.
fn is_allowed(varied: &[Varied], pick: &[usize]) -> bool {
    let is_on = |name: &str| {
        varied.iter().zip(pick).find(|(each, _)| each.feature.is_some() && each.name == name).is_some_and(
            |(each, at)| {
                let first = each.feature.as_ref().and_then(|declaration| declaration.values.first());
                match each.values.get(*at).map(|value| &value.kind) {
                    Some(Kind::Bool(on)) => *on,
                    Some(Kind::Text(word)) => first != Some(word),
                    _ => false,
                }
            },
        )
    };
    varied.iter().filter_map(|each| Some((&each.name, each.feature.as_ref()?))).all(|(name, declaration)| {
        !is_on(name)
            || (declaration.requires.iter().all(|other| is_on(other))
                && !declaration.excludes.iter().any(|other| is_on(other)))
    })
}

fn choice(varied: &[Varied], pick: &[usize]) -> Choice {
    let mut choice = Choice::default();
    for (each, at) in varied.iter().zip(pick).filter(|(_, at)| **at > 0) {
        let Some(value) = each.values.get(*at) else { continue };
        let setting = Setting { name: each.name.clone(), value: value.clone(), place: value.span };
        match each.feature {
            Some(_) => choice.features.push(setting),
            None => choice.parameters.push(setting),
        }
    }
    choice
}
