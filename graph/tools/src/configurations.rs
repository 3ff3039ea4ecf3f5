//! The configurations of a pipeline that can differ in their shaders or passes.
//!
//! Features and parameters that are booleans or enumerations are varied where anything outside of `bind` mentions them,
//! or an axis has their name. Numbers and lists are varied where they can decide about passes or axes (`when`,
//! `for_each`, `axes`, and what subgraphs are given): a range of up to 256 whole numbers in full (of up to 16 where there
//! are more than 4,096 configurations otherwise), lists in every length, else the least, the default and the greatest
//! value and those at which the expressions change ([`thresholds`](super::thresholds)). Axes that depend on a number of
//! which not all values are tried are free: they have the values that their expressions yield, of which up to 4,096
//! are evaluated, or all of their own, whatever values the other axes have.
//! Configurations that the features' `requires` and `excludes` forbid are left out.
//!
//! Up to 4,096 configurations are enumerated in full. Of more, those settings that no pass depends on together factor
//! out: for each pass, every combination of the settings on which it depends ([`dependence`](super::dependence)), the
//! others at their defaults, and every single change and pair of changes besides. So each pass is seen in all its states,
//! and the number of configurations is counted exactly without going through them. A pass with over 4,096 states, or
//! over 16,384 for all passes together, is the limit: then it is single changes and pairs alone, as far as they fit, and
//! for each condition configurations in which it holds and in which it does not ([`witness`](super::witness)); the
//! number is a lower bound. Where not everything is gone through, the presets are configurations too.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use super::dependence;
use super::thresholds::{Number, visit};
use super::witness::{Settings, Witness, value_of};
use crate::diagnostic::Diagnostics;
use crate::document::{Document, Entry, Kind, Value};
use crate::expression::{self, BinaryOperator, Expression, ExpressionKind, UnaryOperator};
use crate::language::{FeatureDeclaration, Order, ParameterDeclaration, ParameterType};
use crate::pipeline::{Choice, Setting, axis_value, has_word, lacking, of_preset, off};
use crate::shader::axes::{Condition, Constraint, Rule};
use crate::shader::permutations::{Count, Space};
use crate::shader::{AxisValue, AxisValues, TargetProfile, TemplateSet};

/// The most configurations that are enumerated in full: of a pipeline, or of the settings of one of its passes.
const MAXIMUM: usize = 1 << 12;

/// The most configurations that are enumerated for all passes together.
const MAXIMUM_TOGETHER: usize = 1 << 14;

/// The most whole numbers of a range that are tried one by one.
const MAXIMUM_VALUES: usize = 256;

/// The same where there are too many configurations otherwise, and the most lengths of a list.
const FEW_VALUES: usize = 16;

/// Keys under which a value decides about passes and axes.
const DECIDING: &[&str] = &["when", "for_each", "axes", "with", "use", "shader"];

/// The configurations, the default first.
#[derive(Debug, Default)]
pub(super) struct Configurations {
    pub(super) choices: Vec<Choice>,
    /// How many there are.
    pub(super) number: Count,
    /// Whether passes have states that none of these shows.
    pub(super) sampled: bool,
    /// Whether there is no configuration of which these do not show everything.
    pub(super) exact: bool,
    /// Axes that can have values which no configuration here gives them.
    pub(super) free: Vec<FreeAxis>,
}

/// An axis that can have values which no tried configuration gives it.
#[derive(Debug)]
pub(super) struct FreeAxis {
    pub(super) name: String,
    /// The pass that says so, by its name in the document; all where it is said in a subgraph, or by a name alone.
    pub(super) pass: Option<String>,
    /// All values that its expression yields; `None` if these are not known, and every value of the axis counts.
    pub(super) values: Option<BTreeSet<AxisValue>>,
    /// On what it depends.
    pub(super) reason: String,
}

/// A feature or parameter with the values that are tried, the default first.
pub(super) struct Varied {
    pub(super) name: String,
    pub(super) feature: Option<FeatureDeclaration>,
    pub(super) values: Vec<Value>,
    pub(super) exhaustive: bool,
}

/// Where a text stands among passes.
struct Mention<'a> {
    text: &'a str,
    /// The pass of the document in which it stands.
    pass: Option<&'a str>,
    /// The key of the axis that the text is about.
    axis: Option<&'a str>,
    deciding: bool,
}

/// Enumerates the configurations of a document.
pub(super) fn enumerate(
    document: &Document,
    templates: &TemplateSet,
    profile: &TargetProfile,
) -> Configurations {
    let mentions = mentions_of(document);
    let axes = axes_of(&mentions, templates);
    let defaults = defaults(document);
    let with = |most: usize| varied(document, &mentions, &axes, profile, &defaults, most);
    let mut varied = with(MAXIMUM_VALUES);
    let everything: BTreeSet<usize> = (0..varied.len()).collect();
    if product(&varied, &everything).is_none() {
        varied = with(FEW_VALUES);
    }
    let groups = || dependence::groups(document, varied.iter().map(|each| each.name.as_str()), templates);
    let settings = Settings { varied: &varied, defaults: &defaults };
    let (picks, sampled) = choose(&varied, groups, &settings, || conditions(document, &mentions, &settings));
    let mut choices: Vec<Choice> = picks.iter().map(|pick| choice(&varied, pick)).collect();
    let exact = !sampled && varied.iter().all(|each| each.exhaustive);
    let mut free = Vec::new();
    if !exact {
        let wide = with(MAXIMUM);
        let wide = Settings { varied: &wide, defaults: &defaults };
        free = free_axes(document, &mentions, &axes, &settings, &wide, sampled);
        choices.extend(presets(document));
    }
    let number = count(&varied);
    let number = Count { exact: exact && number.exact, ..number };
    Configurations { choices, number, sampled, exact, free }
}

/// Whether a condition at the top of a document holds with no values that its settings can have.
pub(super) fn cannot_hold(
    document: &Document,
    templates: &TemplateSet,
    profile: &TargetProfile,
    condition: &str,
) -> bool {
    let mentions = mentions_of(document);
    let axes = axes_of(&mentions, templates);
    let defaults = defaults(document);
    let varied = varied(document, &mentions, &axes, profile, &defaults, MAXIMUM);
    let settings = Settings { varied: &varied, defaults: &defaults };
    let Some(condition) = parse(condition) else { return false };
    settings.named(&condition).into_iter().all(|at| varied[at].exhaustive)
        && settings.witness(&condition, true) == Witness::Nowhere
}

fn mentions_of(document: &Document) -> Vec<Mention<'_>> {
    let mut mentions = Vec::new();
    let entries = |section: &str| document.root.get(section).and_then(Value::entries).unwrap_or_default();
    for entry in entries("passes") {
        collect(&entry.value, Some(&entry.key), None, false, &mut mentions);
    }
    for entry in entries("subgraphs") {
        collect(&entry.value, None, None, false, &mut mentions);
    }
    mentions
}

/// The axes of all templates that are named.
fn axes_of<'t>(mentions: &[Mention<'_>], templates: &'t TemplateSet) -> BTreeSet<&'t str> {
    let is_named = |template: &&str| {
        let computed = |text: &str| text.contains('{');
        mentions
            .iter()
            .any(|mention| mention.text == *template || (mention.deciding && computed(mention.text)))
    };
    templates
        .names()
        .filter(is_named)
        .filter_map(|name| templates.axes(name))
        .flat_map(crate::shader::Axes::names)
        .collect()
}

/// The declared defaults of features and parameters.
fn defaults(document: &Document) -> BTreeMap<String, expression::Value> {
    let sections = ["features", "parameters"].into_iter();
    let entries =
        sections.flat_map(|name| document.root.get(name).and_then(Value::entries).unwrap_or_default());
    entries.filter_map(|entry| Some((entry.key.clone(), value_of(entry.value.get("default")?)?))).collect()
}

/// The expression of a text; an equals sign in front of a computed word is not part of it.
fn parse(text: &str) -> Option<Expression> {
    expression::parse(text.strip_prefix('=').unwrap_or(text)).ok()
}

/// The conditions that decide about passes and axes: those of passes, those within expressions, and the latter together
/// with those of their pass.
fn conditions(document: &Document, mentions: &[Mention<'_>], settings: &Settings<'_>) -> Vec<Expression> {
    let is_condition =
        |expression: &Expression| has_form_of_condition(expression) && !settings.named(expression).is_empty();
    let both = |a: &Expression, b: &Expression| Expression {
        range: a.range.clone(),
        kind: ExpressionKind::Binary(BinaryOperator::And, Box::new(a.clone()), Box::new(b.clone())),
    };
    let not = |a: &Expression| Expression {
        range: a.range.clone(),
        kind: ExpressionKind::Unary(UnaryOperator::Not, Box::new(a.clone())),
    };
    let mut found = Vec::new();
    for mention in mentions.iter().filter(|mention| mention.deciding) {
        let Some(expression) = parse(mention.text) else { continue };
        let when = mention.pass.and_then(|pass| condition_of(document, pass));
        let mut add = |condition: &Expression| {
            if let Some(when) = when.as_ref().filter(|when| *when != condition) {
                found.push(both(when, condition));
                found.push(both(when, &not(condition)));
            }
            found.push(condition.clone());
        };
        if is_condition(&expression) {
            add(&expression);
        }
        visit(&expression, &mut |inner| {
            if let ExpressionKind::Conditional(condition, _, _) = &inner.kind
                && is_condition(condition)
            {
                add(condition);
            }
        });
    }
    found
}

/// Whether an expression has the form of a condition.
fn has_form_of_condition(expression: &Expression) -> bool {
    matches!(
        expression.kind,
        ExpressionKind::Name(_)
            | ExpressionKind::Unary(UnaryOperator::Not, _)
            | ExpressionKind::Binary(..)
            | ExpressionKind::Conditional(..)
    )
}

/// The condition of a pass of the document.
fn condition_of(document: &Document, pass: &str) -> Option<Expression> {
    parse(document.root.get("passes")?.get(pass)?.get("when")?.text()?)
}

/// The axes of which configurations that are left out can give values. `wide` are the same settings, with all whole
/// numbers of larger ranges.
fn free_axes(
    document: &Document,
    mentions: &[Mention<'_>],
    axes: &BTreeSet<&str>,
    settings: &Settings<'_>,
    wide: &Settings<'_>,
    sampled: bool,
) -> Vec<FreeAxis> {
    let open = |at: &usize| !settings.varied[*at].exhaustive;
    let mut free = Vec::new();
    for mention in mentions {
        let Some(axis) = mention.axis else { continue };
        let expression = parse(mention.text);
        let named = expression.as_ref().map(|each| settings.named(each)).unwrap_or_default();
        let is_tried = !sampled || named.len() <= 1;
        if is_tried && !named.iter().any(open) {
            continue;
        }
        let condition = mention.pass.and_then(|pass| condition_of(document, pass));
        free.push(FreeAxis {
            name: axis.to_owned(),
            pass: mention.pass.map(str::to_owned),
            values: expression.and_then(|each| values_yielded(wide, &each, condition.as_ref())),
            reason: format!("\"{}\"", mention.text),
        });
    }
    for each in settings.varied.iter().filter(|each| !each.exhaustive && axes.contains(each.name.as_str())) {
        free.push(FreeAxis {
            name: each.name.clone(),
            pass: None,
            values: parse(&each.name).and_then(|name| values_yielded(wide, &name, None)),
            reason: format!("\"{}\"", each.name),
        });
    }
    free
}

/// All values that an expression yields where a condition may hold, if they can be gone through.
fn values_yielded(
    settings: &Settings<'_>,
    expression: &Expression,
    condition: Option<&Expression>,
) -> Option<BTreeSet<AxisValue>> {
    let named = settings.named(expression);
    if named.is_empty() || !named.iter().all(|at| settings.varied[*at].exhaustive) {
        return None;
    }
    let total = product(settings.varied, &named)?;
    let mut found = BTreeSet::new();
    for number in 0..total {
        let mut pick = vec![None; settings.varied.len()];
        let mut rest = number;
        for at in &named {
            let count = settings.varied[*at].values.len().max(1);
            pick[*at] = Some(rest % count);
            rest /= count;
        }
        if condition.is_none_or(|condition| settings.holds(condition, &pick) != Some(false)) {
            found.extend(settings.value(expression, &pick).as_ref().and_then(axis_value));
        }
    }
    // An expression over names of a subgraph yields nothing here.
    (!found.is_empty()).then_some(found)
}

/// The values of each preset.
fn presets(document: &Document) -> Vec<Choice> {
    let presets = document.root.get("presets").and_then(Value::entries).unwrap_or_default();
    let of = |preset: &Entry| of_preset(document, &preset.key, preset.key_span, &mut Diagnostics::new());
    presets.iter().map(of).collect()
}

/// The number of combinations of the values of a group, unless it is too large.
fn product(varied: &[Varied], group: &BTreeSet<usize>) -> Option<usize> {
    let size = |total: usize, at: &usize| total.checked_mul(varied[*at].values.len().max(1));
    group.iter().try_fold(1_usize, size).filter(|total| *total <= MAXIMUM)
}

/// The number of all combinations of values that the features allow.
pub(super) fn count(varied: &[Varied]) -> Count {
    let name_of = |at: usize| AxisValue::Integer(at as i64);
    let values = varied
        .iter()
        .map(|each| (each.name.clone(), (0..each.values.len().max(1)).map(name_of).collect::<Vec<_>>()));
    let mut constraints = Vec::new();
    for (each, declaration) in varied.iter().filter_map(|each| Some((each, each.feature.as_ref()?))) {
        let is_on = |name: &str, equal: bool| {
            let other = varied.iter().find(|other| other.feature.is_some() && other.name == name)?;
            let off = other.values.iter().position(|value| !other.is_on(value))?;
            Some(Condition { axis: name.to_owned(), value: name_of(off), equal: !equal })
        };
        let Some(span) = each.values.first().map(|value| value.span) else { continue };
        let when = is_on(&each.name, true);
        let never = is_on(&each.name, false);
        // What is not declared is never on.
        let all = declaration.requires.iter().map(|other| is_on(other, true).or_else(|| never.clone()));
        let none = declaration.excludes.iter().filter_map(|other| is_on(other, true)).collect();
        constraints.push(Constraint {
            rule: Rule::Requires { when: when.clone(), all: all.flatten().collect() },
            span,
        });
        constraints.push(Constraint { rule: Rule::Excludes { when, none }, span });
    }
    let mut groups: BTreeMap<&str, Vec<&Varied>> = BTreeMap::new();
    for each in varied {
        if let Some(group) = each.group() {
            groups.entry(group).or_default().push(each);
        }
    }
    for members in groups.into_values() {
        let on = |each: &&Varied| {
            let off = each.values.iter().position(|value| !each.is_on(value));
            // What has no value with which it is off is on.
            let value = name_of(off.unwrap_or(each.values.len()));
            Condition { axis: each.name.clone(), value, equal: false }
        };
        let span = members.first().and_then(|each| each.values.first()).map(|value| value.span);
        let Some(span) = span else { continue };
        constraints.push(Constraint { rule: Rule::OneOf(members.iter().map(on).collect()), span });
    }
    Space::of(values.collect(), constraints).count(&AxisValues::new())
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
        Kind::Null | Kind::Bool(_) | Kind::Number(_) => {}
    }
}

fn varied(
    document: &Document,
    mentions: &[Mention<'_>],
    axes: &BTreeSet<&str>,
    profile: &TargetProfile,
    defaults: &BTreeMap<String, expression::Value>,
    most: usize,
) -> Vec<Varied> {
    let entries = |name: &str| document.root.get(name).and_then(Value::entries).unwrap_or_default();
    let mut features: BTreeMap<&str, (FeatureDeclaration, &Entry)> = BTreeMap::new();
    for entry in entries("features") {
        if let Ok(declaration) = entry.value.decode() {
            features.insert(&entry.key, (declaration, entry));
        }
    }
    let is_mentioned =
        |name: &str| axes.contains(name) || mentions.iter().any(|mention| has_word(mention.text, name));
    let mut groups: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for (name, (declaration, _)) in &features {
        if let Some(group) = &declaration.one_of {
            groups.entry(group.clone()).or_default().push(name);
        }
    }
    // What a varied feature requires or excludes, and its group, decide about it, so they vary too.
    let mut wanted: BTreeSet<&str> = features.keys().copied().filter(|name| is_mentioned(name)).collect();
    loop {
        let before = wanted.len();
        for (name, (declaration, _)) in &features {
            let group =
                declaration.one_of.as_ref().map(|group| groups.get(group).into_iter().flatten().copied());
            let others = || {
                let named = declaration.requires.iter().chain(&declaration.excludes).map(String::as_str);
                named.chain(group.clone().into_iter().flatten())
            };
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
    for (name, (declaration, entry)) in features.iter().filter(|(name, _)| wanted.contains(**name)) {
        varied.push(Varied {
            name: (*name).to_owned(),
            values: feature_values(declaration, entry, entries("features"), profile),
            feature: Some(declaration.clone()),
            exhaustive: true,
        });
    }
    let decides = |name: &str| {
        axes.contains(name) || mentions.iter().any(|mention| mention.deciding && has_word(mention.text, name))
    };
    let deciding: Vec<Expression> = mentions
        .iter()
        .filter(|mention| mention.deciding)
        .filter_map(|mention| parse(mention.text))
        .collect();
    for entry in entries("parameters") {
        let Ok(declaration) = entry.value.decode::<ParameterDeclaration>() else {
            continue;
        };
        let is_small = matches!(declaration.parameter_type, ParameterType::Bool | ParameterType::Enum);
        if !(if is_small { is_mentioned(&entry.key) } else { decides(&entry.key) }) {
            continue;
        }
        let is_indexed = mentions.iter().any(|mention| mention.text.contains(&format!("{}[", entry.key)));
        let number = Number {
            name: &entry.key,
            default: defaults.get(&entry.key).and_then(expression::Value::number).unwrap_or_default(),
            min: declaration.min,
            max: declaration.max,
            defaults,
        };
        let (values, exhaustive) = values_of(&declaration, &entry.value, &number, &deciding, most);
        varied.push(Varied {
            name: entry.key.clone(),
            feature: None,
            values: default_first(entry.value.get("default"), values),
            exhaustive: exhaustive && !is_indexed,
        });
    }
    varied
}

/// The values that a feature can have on a profile, the default first.
pub(super) fn feature_values(
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
    most: usize,
) -> (Vec<Value>, bool) {
    use ParameterType as T;
    let number = |number: f64| at(value, number_kind(number));
    match declaration.parameter_type {
        T::Bool => (booleans(value), true),
        T::Enum => (words(&declaration.values, value), true),
        T::U32 | T::I32 => match (declaration.min, declaration.max) {
            (Some(min), Some(max)) if max - min < most as f64 && min.fract() == 0.0 => {
                let count = (max - min).max(0.0) as usize + 1;
                ((0..count).map(|step| number(min + step as f64)).collect(), true)
            }
            _ => {
                // A number without a sign has a least value anyway.
                let least = if declaration.parameter_type == T::U32 { Some(0.0) } else { None };
                let min = range.min.into_iter().chain(least).reduce(f64::max);
                let range = Number { min, ..*range };
                (range.whole_values(deciding).into_iter().map(number).collect(), false)
            }
        },
        T::F32 => (range.real_values(deciding).into_iter().map(number).collect(), false),
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
            let last = most.min(least + FEW_VALUES);
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

/// The configurations as the index of each setting's value, and whether they leave out states of passes.
fn choose(
    varied: &[Varied],
    groups: impl Fn() -> Vec<BTreeSet<usize>>,
    settings: &Settings<'_>,
    conditions: impl Fn() -> Vec<Expression>,
) -> (Vec<Vec<usize>>, bool) {
    let plain = vec![0; varied.len()];
    let everything: BTreeSet<usize> = (0..varied.len()).collect();
    let mut picks = Picks { varied, seen: HashSet::new(), list: Vec::new() };
    if let Some(total) = product(varied, &everything) {
        picks.add_product(&plain, &everything, total);
        return (picks.list, false);
    }
    let changes: Vec<(usize, usize)> = varied
        .iter()
        .enumerate()
        .flat_map(|(at, each)| (1..each.values.len()).map(move |pick| (at, pick)))
        .collect();
    picks.add(plain.clone());
    let pairs =
        changes.iter().enumerate().flat_map(|(at, one)| changes[at + 1..].iter().map(move |two| (one, two)));
    for (one, two) in changes.iter().map(|one| (one, one)).chain(pairs) {
        if picks.list.len() >= MAXIMUM {
            break;
        }
        // Two values of one setting are no pair of changes.
        if one.0 != two.0 || one.1 == two.1 {
            let mut pick = plain.clone();
            pick[one.0] = one.1;
            pick[two.0] = two.1;
            picks.add(pick);
        }
    }
    let mut groups: Vec<BTreeSet<usize>> =
        groups().into_iter().map(|group| with_constraints(varied, group)).collect();
    groups.sort();
    groups.dedup();
    let mut sampled = false;
    for group in &groups {
        match product(varied, group).filter(|total| picks.list.len() + total <= MAXIMUM_TOGETHER) {
            Some(total) => picks.add_product(&plain, group, total),
            None => sampled = true,
        }
    }
    if sampled {
        for condition in conditions() {
            picks.add_witnesses(settings, &condition);
        }
    }
    (picks.list, sampled)
}

/// Distinct configurations that the features allow.
struct Picks<'v> {
    varied: &'v [Varied],
    seen: HashSet<Vec<usize>>,
    list: Vec<Vec<usize>>,
}

impl Picks<'_> {
    fn add(&mut self, pick: Vec<usize>) {
        if is_allowed(self.varied, &pick) && self.seen.insert(pick.clone()) {
            self.list.push(pick);
        }
    }

    /// Configurations in which a condition holds and in which it does not, where none is there.
    fn add_witnesses(&mut self, settings: &Settings<'_>, condition: &Expression) {
        for wanted in [true, false] {
            let shows = |pick: &Vec<usize>| {
                let pick: Vec<Option<usize>> = pick.iter().copied().map(Some).collect();
                settings.holds(condition, &pick) == Some(wanted)
            };
            if self.list.len() < MAXIMUM_TOGETHER
                && !self.list.iter().any(shows)
                && let Witness::Found(pick) = settings.witness(condition, wanted)
            {
                self.add(pick);
            }
        }
    }

    /// Every combination of the values of a group, which are `total`; the other settings as in `plain`.
    fn add_product(&mut self, plain: &[usize], group: &BTreeSet<usize>, total: usize) {
        for number in 0..total {
            let mut pick = plain.to_vec();
            let mut rest = number;
            for at in group {
                let count = self.varied[*at].values.len().max(1);
                pick[*at] = rest % count;
                rest /= count;
            }
            self.add(pick);
        }
    }
}

/// A group of settings with every feature that its features require or exclude, and so on.
pub(super) fn with_constraints(varied: &[Varied], mut group: BTreeSet<usize>) -> BTreeSet<usize> {
    let others = |at: usize| {
        let declaration = varied[at].feature.as_ref();
        declaration.into_iter().flat_map(|each| each.requires.iter().chain(&each.excludes))
    };
    let tied = |one: usize, two: usize| {
        others(one).any(|name| *name == varied[two].name)
            || (varied[one].group().is_some() && varied[one].group() == varied[two].group())
    };
    loop {
        let more: Vec<usize> = (0..varied.len())
            .filter(|at| {
                !group.contains(at) && group.iter().any(|member| tied(*member, *at) || tied(*at, *member))
            })
            .collect();
        if more.is_empty() {
            return group;
        }
        group.extend(more);
    }
}

impl Varied {
    /// The group of features to which it belongs.
    pub(super) fn group(&self) -> Option<&str> {
        self.feature.as_ref()?.one_of.as_deref()
    }

    /// Whether a feature is on with this value; an enumeration is off with its first word.
    pub(super) fn is_on(&self, value: &Value) -> bool {
        let first = self.feature.as_ref().and_then(|declaration| declaration.values.first());
        match &value.kind {
            Kind::Bool(on) => *on,
            Kind::Text(word) => first != Some(word),
            _ => false,
        }
    }
}

/// Whether the features agree with what they require and exclude of one another.
pub(super) fn is_allowed(varied: &[Varied], pick: &[usize]) -> bool {
    let is_on = |name: &str| {
        varied
            .iter()
            .zip(pick)
            .find(|(each, _)| each.feature.is_some() && each.name == name)
            .is_some_and(|(each, at)| each.values.get(*at).is_some_and(|value| each.is_on(value)))
    };
    let mut groups: BTreeMap<&str, usize> = BTreeMap::new();
    for each in varied {
        if let Some(group) = each.group() {
            *groups.entry(group).or_default() += usize::from(is_on(&each.name));
        }
    }
    if groups.into_values().any(|on| on != 1) {
        return false;
    }
    varied.iter().filter_map(|each| Some((&each.name, each.feature.as_ref()?))).all(|(name, declaration)| {
        !is_on(name)
            || (declaration.requires.iter().all(|other| is_on(other))
                && !declaration.excludes.iter().any(|other| is_on(other)))
    })
}

pub(super) fn choice(varied: &[Varied], pick: &[usize]) -> Choice {
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
