//! Parameters and features: their values, where each comes from, and whether it is allowed.

use crate::pipeline::settings::availability;
use crate::pipeline::settings::kinds;
use crate::pipeline::settings::live::Structural;
use crate::pipeline::settings::misfit::{misfit, misplaced};
use crate::pipeline::settings::overrides::{Override, Overrides};
use std::collections::BTreeMap;
use umbragraph_shaders::TargetProfile;
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, list_of, suggested_name};
use umbragraph_text::document::{self, Document, Entry, Kind};
use umbragraph_text::expression::Value;
use umbragraph_text::language::{FeatureDeclaration, FeatureType, ParameterDeclaration, ParameterType};
use umbragraph_text::source::Span;

/// A parameter with its value in one configuration.
#[derive(Clone, Debug)]
pub struct ValuedParameter {
    /// The declaration of the parameter.
    pub declaration: ParameterDeclaration,
    /// The value in this configuration.
    pub value: Value,
    /// The place of the value: the default, a preset, or the caller's setting.
    pub place: Span,
    /// The use that makes the parameter structural: a change of its value then needs a new plan. `None` if the value can
    /// change from frame to frame.
    pub structural: Option<Structural>,
}

/// A feature with its value in one configuration.
#[derive(Clone, Debug)]
pub struct Feature {
    /// The declaration of the feature.
    pub declaration: FeatureDeclaration,
    /// The value in this configuration: a boolean, or a word of the enumeration.
    pub value: Value,
    /// The place of the default, setting or unmet requirement that decides the value.
    pub place: Span,
}

impl Feature {
    /// Returns `true` if the feature is on: true, or any word but the first of its enumeration.
    pub fn is_on(&self) -> bool {
        match &self.value {
            Value::Bool(on) => *on,
            Value::Text(word) => self.declaration.values.first() != Some(word),
            _ => false,
        }
    }
}

/// Returns the parameters that have a value: the last valid override, or else the default.
pub(crate) fn parameters(
    declarations: &BTreeMap<String, ParameterDeclaration>,
    entries: &[Entry],
    overrides: &[Override],
    diagnostics: &mut Diagnostics,
) -> BTreeMap<String, ValuedParameter> {
    let mut parameters = BTreeMap::new();
    for entry in entries {
        let Some(declaration) = declarations.get(&entry.key) else { continue };
        let pointer = document::pointer_join("/parameters", &entry.key);
        let Some(default) = entry.value.get("default") else { continue };
        let mut add = |found: Result<Value, Vec<Diagnostic>>, with: &dyn Fn(Diagnostic) -> Diagnostic| {
            found.map_err(|errors| diagnostics.extend(errors.into_iter().map(with))).ok()
        };
        let from_default = decode_parameter(&entry.key, declaration, default);
        let from_default = add(from_default, &|one| one.pointer(format!("{pointer}/default")));
        let mut chosen = None;
        for setting in overrides.iter().filter(|setting| setting.name == entry.key) {
            let found = decode_parameter(&entry.key, declaration, &setting.value);
            let found = add(found, &|one| one.related(entry.key_span, "the parameter is declared here"));
            chosen = found.map(|value| (value, setting.place)).or(chosen);
        }
        if let Some((value, place)) = chosen.or(from_default.map(|value| (value, default.span))) {
            let parameter =
                ValuedParameter { declaration: declaration.clone(), value, place, structural: None };
            parameters.insert(entry.key.clone(), parameter);
        }
    }
    parameters
}

/// Returns all features with their values. Checks the features' requirements of the profile, and of one another. A
/// preset is meant for every target, so its values do not count for features whose requirements the profile does not
/// meet.
pub(crate) fn features(
    declarations: &BTreeMap<String, FeatureDeclaration>,
    document: &Document,
    overrides: &[Override],
    profile: &TargetProfile,
    diagnostics: &mut Diagnostics,
) -> BTreeMap<String, Feature> {
    let [entries, presets] = ["features", "presets"].map(|part| document.root.entries_of(part));
    let overrides = availability::without_lacking(overrides, presets, entries, profile);
    let mut features = BTreeMap::new();
    let mut unavailable = Vec::new();
    for entry in entries {
        let Some(declaration) = declarations.get(&entry.key) else { continue };
        let Some(default) = entry.value.get("default") else { continue };
        let setting = overrides.iter().rev().find(|setting| setting.name == entry.key);
        availability::check_names(entry, diagnostics);
        let lacking = availability::lacking(entry, entries, profile);
        let off = lacking.as_ref().map(|lacking| availability::off(declaration, lacking.place));
        unavailable.extend(lacking.as_ref().map(|_| entry.key.as_str()));
        let (default, default_place) = match &off {
            Some(off) => (off, off.span),
            None => (default, default.span),
        };
        let (value, place) =
            setting.map_or((default, default_place), |setting| (&setting.value, setting.place));
        let decode = |value| decode_feature(&entry.key, declaration, value);
        let (value, place) = match decode(value) {
            Ok(value) => (value, place),
            Err(errors) => {
                let declared = |one: Diagnostic| one.related(entry.key_span, "the feature is declared here");
                diagnostics.extend(errors.into_iter().map(declared));
                let Ok(value) = decode(default) else { continue };
                (value, default_place)
            }
        };
        let mut feature = Feature { declaration: declaration.clone(), value, place };
        if let (Some(setting), Some(lacking), true) = (setting, &lacking, feature.is_on()) {
            diagnostics.push(availability::cannot_be_on(setting, lacking, profile));
            // Nothing follows from what cannot be.
            feature.value = decode(default).unwrap_or(feature.value);
        }
        features.insert(entry.key.clone(), feature);
    }
    groups(declarations, entries, &overrides, &unavailable, &mut features, diagnostics);
    for (name, feature) in &features {
        let is_on = |other: &String| features.get(other).map(Feature::is_on);
        for (others, wanted, words) in [
            (&feature.declaration.requires, true, "requires"),
            (&feature.declaration.excludes, false, "excludes"),
        ] {
            for (at, other) in others.iter().enumerate() {
                let entry = entries.iter().find(|entry| entry.key == *name);
                let place = entry.map_or(feature.place, |entry| entry.key_span);
                let written = entry.and_then(|entry| entry.value.elements_of(words).get(at));
                let written = written.map_or(place, |written| written.span);
                let pointer = || format!("{}/{words}/{at}", document::pointer_join("/features", name));
                if other == name {
                    let why = if wanted { "" } else { ", so that it can never be on" };
                    let message = format!("the feature \"{name}\" {words} itself{why}");
                    let diagnostic = Diagnostic::error(codes::FEATURE_CONFLICT, written, message);
                    let help = "name another feature, or remove it";
                    diagnostics.push(diagnostic.pointer(pointer()).help(help));
                    continue;
                }
                match is_on(other) {
                    // What is wrong with a feature that is declared has its diagnostic.
                    None if entries.iter().any(|entry| entry.key == *other) => {}
                    None => {
                        let taken = |name: &str| others.iter().any(|other| other == name);
                        let (kind, known) = (SettingKind::Feature, declared(declarations));
                        let diagnostic = not_there(kind, other, &known, document, written, taken);
                        let help = |one: Diagnostic| match kinds::kind_of(document, other) {
                            Some(_) if one.fix.is_none() => one.help(format!(
                                "a feature {words} features; \"constraints\" tie other values"
                            )),
                            _ => one,
                        };
                        diagnostics.extend(diagnostic.map(|one| help(one.pointer(pointer()))));
                    }
                    Some(on) if on != wanted && feature.is_on() => {
                        let (is, should_be) = if on { ("on", "off") } else { ("off", "on") };
                        let message = format!("the feature \"{name}\" {words} \"{other}\", which is {is}");
                        let diagnostic = Diagnostic::error(codes::FEATURE_CONFLICT, feature.place, message);
                        let help = format!("switch \"{other}\" {should_be}, or \"{name}\" off");
                        diagnostics.push(diagnostic.related(place, "declared here").help(help));
                    }
                    Some(_) => {}
                }
            }
        }
    }
    features
}

/// Ensures that exactly one feature of each group is on. A chosen feature switches off features of its group that are
/// on only by default. If the target does not support the default, the next supported feature of the group in the
/// document replaces it.
fn groups(
    declarations: &BTreeMap<String, FeatureDeclaration>,
    entries: &[Entry],
    overrides: &[Override],
    unavailable: &[&str],
    features: &mut BTreeMap<String, Feature>,
    diagnostics: &mut Diagnostics,
) {
    let mut groups: BTreeMap<&str, Vec<&String>> = BTreeMap::new();
    for (name, declaration) in declarations {
        if let Some(group) = &declaration.one_of {
            groups.entry(group).or_default().push(name);
        }
    }
    let names: Vec<&str> = groups.keys().copied().collect();
    let others = |group: &str| names.iter().copied().filter(|name| *name != group).collect::<Vec<_>>();
    // A group lacks the feature whose own is misspelt.
    let lonely = groups.iter().filter(|(_, members)| members.len() == 1);
    let lacking: Vec<&str> = lonely.filter_map(|(group, _)| suggested_name(group, others(group))).collect();
    for (group, members) in groups {
        // What is wrong with a member has its diagnostic.
        if members.iter().any(|name| !features.contains_key(*name)) {
            continue;
        }
        let is_chosen = |name: &String| overrides.iter().any(|setting| setting.name == *name);
        let on = |features: &BTreeMap<String, Feature>| -> Vec<&String> {
            let is_on = |name: &&&String| features.get(**name).is_some_and(Feature::is_on);
            members.iter().filter(is_on).copied().collect()
        };
        let chosen = on(features).into_iter().find(|name| is_chosen(name));
        if let Some(setting) = chosen.and_then(|name| overrides.iter().rev().find(|one| one.name == *name)) {
            for name in on(features).into_iter().filter(|name| !is_chosen(name)) {
                if let Some(feature) = features.get_mut(name) {
                    feature.value = match feature.declaration.values.first() {
                        Some(word) => Value::Text(word.clone()),
                        None => Value::Bool(false),
                    };
                    feature.place = setting.place;
                }
            }
        }
        if on(features).is_empty() && !members.iter().any(|name| is_chosen(name)) {
            let mut own = entries.iter().filter(|entry| members.contains(&&entry.key));
            let is_unavailable = |entry: &&Entry| unavailable.contains(&entry.key.as_str());
            let is_default = |entry: &&Entry| {
                is_unavailable(entry)
                    && entry.value.get("default").is_some_and(|value| matches!(value.kind, Kind::Bool(true)))
            };
            let default = own.find(is_default);
            let next = default.and_then(|_| own.find(|entry| !is_unavailable(entry)));
            if let Some(feature) = next.and_then(|next| features.get_mut(&next.key))
                && feature.declaration.feature_type == FeatureType::Bool
            {
                feature.value = Value::Bool(true);
            }
        }
        let on = on(features);
        let Some(place) = on.last().copied().or(members.first().copied()).and_then(|name| features.get(name))
        else {
            continue;
        };
        let message = match on.as_slice() {
            [_] if members.len() > 1 => continue,
            [] if lacking.contains(&group) => continue,
            _ if members.len() == 1 => format!("\"{}\" is alone in the group \"{group}\"", members[0]),
            [] => format!("no feature of the group \"{group}\" is on"),
            [first, .., last] => format!("\"{first}\" and \"{last}\" of the group \"{group}\" are both on"),
            [_] => continue,
        };
        let diagnostic = Diagnostic::error(codes::FEATURE_GROUP, place.place, message);
        let mut diagnostic = match members.as_slice() {
            [alone] => {
                let entry = entries.iter().find(|entry| entry.key == **alone);
                let written = entry.and_then(|entry| Some(entry.value.get("one_of")?.span));
                diagnostic.suggest(group, others(group), written, |_| {
                    "give another feature the same \"one_of\", or remove it".to_owned()
                })
            }
            _ => {
                let names: Vec<&str> = members.iter().map(|name| name.as_str()).collect();
                diagnostic.help(format!("switch on exactly one of {}", list_of(names)))
            }
        };
        for entry in entries.iter().filter(|entry| members.contains(&&entry.key)) {
            diagnostic = diagnostic.related(entry.key_span, format!("one of \"{group}\""));
        }
        diagnostics.push(diagnostic);
    }
}

/// Reports settings of parameters and features that are not declared.
pub(crate) fn unknown(
    parameters: &BTreeMap<String, ParameterDeclaration>,
    features: &BTreeMap<String, FeatureDeclaration>,
    document: &Document,
    overrides: &Overrides,
    diagnostics: &mut Diagnostics,
) {
    for kind in [SettingKind::Parameter, SettingKind::Feature] {
        let (settings, known) = match kind {
            SettingKind::Parameter => (&overrides.parameters, declared(parameters)),
            SettingKind::Feature => (&overrides.features, declared(features)),
        };
        for setting in settings.iter().filter(|setting| !known.contains(&setting.name.as_str())) {
            // Another file may set it too.
            let taken = |name: &str| {
                settings.iter().any(|other| other.name == name && other.place.file == setting.place.file)
            };
            diagnostics.extend(not_there(kind, &setting.name, &known, document, setting.place, taken));
        }
    }
}

/// The kind of a setting: a parameter or a feature.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SettingKind {
    Parameter,
    Feature,
}

impl SettingKind {
    fn name(self) -> &'static str {
        match self {
            Self::Parameter => "parameter",
            Self::Feature => "feature",
        }
    }
}

/// The names of the declarations.
pub(crate) fn declared<T>(declarations: &BTreeMap<String, T>) -> Vec<&str> {
    declarations.keys().map(String::as_str).collect()
}

/// The diagnostic for a parameter or feature that is not among the `known` names. If the name, or one like it, is of
/// another kind, the help text says so. `None` if the document declares it: its declaration has a diagnostic then.
pub(crate) fn not_there(
    kind: SettingKind,
    name: &str,
    known: &[&str],
    document: &Document,
    place: Span,
    taken: impl Fn(&str) -> bool,
) -> Option<Diagnostic> {
    let what = kind.name();
    let (own, other) = match kind {
        SettingKind::Parameter => ("parameters", "features"),
        SettingKind::Feature => ("features", "parameters"),
    };
    if document.root.entries_of(own).iter().any(|entry| entry.key == name) {
        return None;
    }
    let message = format!("there is no {what} \"{name}\"");
    let diagnostic = Diagnostic::error(codes::UNKNOWN_SETTING, place, message);
    let is_known = suggested_name(name, known.iter().copied()).is_some();
    let others = document.root.entries_of(other).iter().map(|entry| entry.key.as_str());
    let meant = suggested_name(name, others).filter(|_| !is_known);
    if let Some(help) = kinds::kind_of(document, name).or_else(|| kinds::kind_of(document, meant?)) {
        return Some(diagnostic.help(help));
    }
    Some(diagnostic.suggest_unless(name, known.iter().copied(), Some(place), taken, |names| match names {
        [] => format!("this pipeline has no {what}s"),
        names => format!("the {what}s are {}", list_of(names)),
    }))
}

pub(crate) fn decode_parameter(
    name: &str,
    declaration: &ParameterDeclaration,
    value: &document::Value,
) -> Result<Value, Vec<Diagnostic>> {
    use ParameterType as T;
    let error =
        |code, place, message: String, help: String| vec![Diagnostic::error(code, place, message).help(help)];
    let wrong = |wanted: &str, help: String| {
        let message = format!("the parameter \"{name}\" is {wanted}, this is {}", value.kind_name());
        error(codes::SETTING_TYPE, value.span, message, help)
    };
    match declaration.parameter_type {
        T::F32 => number(name, declaration, value, false).map_err(|diagnostic| vec![*diagnostic]),
        T::U32 | T::I32 => number(name, declaration, value, true).map_err(|diagnostic| vec![*diagnostic]),
        T::Bool => match value.kind {
            document::Kind::Bool(on) => Ok(Value::Bool(on)),
            _ => Err(wrong("a boolean", "write true or false".to_owned())),
        },
        T::Enum => match value.text() {
            // Of a subgraph's parameter that lists none any word will do.
            Some(word)
                if declaration.values.is_empty() || declaration.values.iter().any(|known| known == word) =>
            {
                Ok(Value::Text(word.to_owned()))
            }
            Some(_) => Err(vec![document::schema::unknown_word(value, &words(&declaration.values))]),
            None => Err(wrong("a word", format!("the words are {}", list_of(&declaration.values)))),
        },
        T::F32List | T::U32List => {
            let elements = value.elements();
            let elements = elements.ok_or_else(|| wrong("a list of numbers", as_list(value)))?;
            let whole = declaration.parameter_type == T::U32List;
            let (min, max) = (declaration.min_length.unwrap_or(0), declaration.max_length.unwrap_or(65_536));
            if !(min as usize..=max as usize).contains(&elements.len()) {
                let message = format!("the parameter \"{name}\" has {} elements", elements.len());
                let help = format!("it takes {min} to {max}");
                return Err(error(codes::SETTING_RANGE, value.span, message, help));
            }
            let (mut numbers, mut errors) = (Vec::new(), Vec::new());
            for element in elements {
                match number(name, declaration, element, whole) {
                    Ok(number) => numbers.push(number),
                    Err(diagnostic) => errors.push(*diagnostic),
                }
            }
            if !errors.is_empty() {
                return Err(errors);
            }
            match misplaced(name, declaration, &numbers) {
                Some((at, (code, message, help))) => {
                    Err(error(code, elements.get(at).unwrap_or(value).span, message, help))
                }
                None => Ok(Value::List(numbers)),
            }
        }
    }
}

/// The help text for a value that is no list: the numbers in brackets, if it has any.
fn as_list(value: &document::Value) -> String {
    let is_number = |text: &str| text.trim().parse::<f64>().is_ok_and(f64::is_finite);
    match (&value.kind, value.text()) {
        (Kind::Number(number), _) => format!("write it in brackets: [{number}]"),
        (_, Some(text)) if text.split(',').all(is_number) => format!("write it in brackets: [{text}]"),
        _ => "write it as [1, 2, 3]".to_owned(),
    }
}

/// Reads a number for a parameter, or for an element of a list parameter.
fn number(
    name: &str,
    declaration: &ParameterDeclaration,
    value: &document::Value,
    whole: bool,
) -> Result<Value, Box<Diagnostic>> {
    let error = |code, message: String, help: String| {
        Err(Box::new(Diagnostic::error(code, value.span, message).help(help)))
    };
    let document::Kind::Number(number) = &value.kind else {
        let message = format!("the parameter \"{name}\" takes numbers, this is {}", value.kind_name());
        let help = match value.text().and_then(|text| unquoted(text, whole)) {
            Some(number) if value.text().is_some_and(|text| text.contains(',')) => {
                format!("write {number}, without quotes and with a point")
            }
            Some(number) => format!("write {number}, without quotes"),
            None if whole => "write a whole number".to_owned(),
            None => "write a number".to_owned(),
        };
        return error(codes::SETTING_TYPE, message, help);
    };
    let number = number.as_f64().unwrap_or(f64::MAX);
    match misfit(name, declaration, number, whole) {
        Some((code, message, help)) => error(code, message, help),
        None => Ok(Value::Number(number)),
    }
}

/// Returns the number that a string stands for, with a decimal point in place of a comma; `None` if that is not clear.
/// A comma before exactly three digits may separate thousands, so it stays.
fn unquoted(text: &str, whole: bool) -> Option<String> {
    if whole {
        return text.parse::<i64>().ok().map(|number| number.to_string());
    }
    let number = match text.split_once(',') {
        Some((_, decimals)) if decimals.len() == 3 && decimals.parse::<u16>().is_ok() => return None,
        Some((integer, decimals)) => format!("{integer}.{decimals}"),
        None => text.to_owned(),
    };
    number.parse::<f64>().is_ok_and(f64::is_finite).then_some(number)
}

fn words(values: &[String]) -> Vec<&str> {
    values.iter().map(String::as_str).collect()
}

pub(crate) fn decode_feature(
    name: &str,
    declaration: &FeatureDeclaration,
    value: &document::Value,
) -> Result<Value, Vec<Diagnostic>> {
    match (declaration.feature_type, &value.kind) {
        (FeatureType::Bool, document::Kind::Bool(on)) => Ok(Value::Bool(*on)),
        (FeatureType::Enum, document::Kind::Text(word)) if declaration.values.contains(word) => {
            Ok(Value::Text(word.clone()))
        }
        (FeatureType::Enum, document::Kind::Text(_)) => {
            Err(vec![document::schema::unknown_word(value, &words(&declaration.values))])
        }
        (kind, _) => {
            let (wanted, help) = match kind {
                FeatureType::Bool => ("a boolean", "write true or false".to_owned()),
                FeatureType::Enum => {
                    ("a word", format!("its words are {}", list_of(words(&declaration.values))))
                }
            };
            let message = format!("the feature \"{name}\" is {wanted}, this is {}", value.kind_name());
            Err(vec![Diagnostic::error(codes::SETTING_TYPE, value.span, message).help(help)])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::unquoted;

    #[test]
    fn a_number_in_quotes_is_suggested_only_if_it_is_clear() {
        for (text, whole, expected) in [
            ("1,5", false, Some("1.5")),
            ("0.5", false, Some("0.5")),
            ("1,000", false, None),
            ("1,5", true, None),
            ("1,000", true, None),
            ("12", true, Some("12")),
            ("wide", false, None),
        ] {
            assert_eq!(unquoted(text, whole).as_deref(), expected, "{text}");
        }
    }
}
