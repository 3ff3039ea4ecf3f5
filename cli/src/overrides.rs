//! The values that the command line gives to parameters and features.
//!
//! A preset, parameter files over it, and `--set` and `--feature` over both. A value of the command line is JSON, or
//! else a word; diagnostics about it show the argument as the text that they are about.

use std::path::Path;

use umbragraph::diagnostic::{Diagnostic, codes};
use umbragraph::low_level::document::{self, Document, Value};
use umbragraph::low_level::pipeline::{self, Override, Overrides, ParameterFile};
use umbragraph::low_level::source::{Sources, Span};

use crate::arguments::Settings;
use crate::session::Session;

impl Session {
    /// Combines the values of the preset, the parameter files and the command line; later ones override earlier ones.
    pub(crate) fn overrides(&mut self, settings: &Settings, document: &Document) -> Overrides {
        let files: Vec<ParameterFile> =
            settings.params.iter().filter_map(|path| self.parameter_file(path)).collect();
        let preset = match &settings.preset {
            Some(name) => Some((name.clone(), self.on_command_line(name))),
            None => files.iter().rev().find_map(|file| file.preset.clone()),
        };
        let preset =
            preset.map(|(name, place)| pipeline::of_preset(document, &name, place, &mut self.diagnostics));
        let below =
            files.into_iter().fold(preset.unwrap_or_default(), |below, file| below.under(file.overrides));
        let mut given = |texts: &[String], without_value, section| {
            let settings = texts.iter().filter_map(|text| self.setting(text, without_value));
            let settings: Vec<Override> = settings.collect();
            settings.into_iter().filter_map(|one| self.switched(one, section, document)).collect()
        };
        let parameters = given(&settings.set, None, "parameters");
        let features = given(&settings.feature, Some("true"), "features");
        below.under(Overrides { parameters, features })
    }

    /// Converts `on` and `off` to booleans in a command-line setting whose declared type is `bool`. Any other word adds
    /// a diagnostic and returns `None`.
    fn switched(&mut self, mut setting: Override, section: &str, document: &Document) -> Option<Override> {
        let declared = document.root.entries_of(section);
        let entry = declared.iter().find(|entry| entry.key == setting.name);
        let Some(entry) = entry.filter(|one| one.value.get("type").and_then(Value::text) == Some("bool"))
        else {
            return Some(setting);
        };
        setting.value.kind = match (&setting.value.kind, setting.value.text()) {
            (document::Kind::Bool(on), _) => document::Kind::Bool(*on),
            (_, Some("on")) => document::Kind::Bool(true),
            (_, Some("off")) => document::Kind::Bool(false),
            _ => {
                let (name, what) = (&setting.name, section.trim_end_matches('s'));
                let message = format!("the {what} \"{name}\" is a boolean: on, off, true or false");
                let diagnostic = Diagnostic::error(codes::SETTING_TYPE, setting.place, message)
                    .related(entry.key_span, format!("the {what} is declared here"))
                    .help(format!("write {name}=on or {name}=off; true and false say the same"));
                self.diagnostics.push(diagnostic);
                return None;
            }
        };
        Some(setting)
    }

    fn parameter_file(&mut self, path: &Path) -> Option<ParameterFile> {
        match self.read(path) {
            Ok(document) => Some(ParameterFile::read(&document, &mut self.diagnostics)),
            Err(diagnostics) => {
                self.diagnostics.extend(diagnostics);
                None
            }
        }
    }

    /// Parses `NAME=VALUE`, where the value is JSON, or else a word. `without_value` is the value of a bare `NAME`.
    /// `None` if the form is invalid; the session records the error.
    fn setting(&mut self, text: &str, without_value: Option<&str>) -> Option<Override> {
        let whole = self.on_command_line(text);
        let (name, value) = match (text.split_once('='), without_value) {
            (Some((name, value)), _) => (name, value),
            (None, Some(value)) => (text, value),
            (None, None) => {
                let diagnostic = Diagnostic::error(
                    crate::codes::SETTING_FORM,
                    whole,
                    format!("\"{text}\" gives no value"),
                );
                self.diagnostics.push(diagnostic.help("write NAME=VALUE, such as --set resolution=1024"));
                return None;
            }
        };
        let mut scratch = Sources::new();
        let scratch_file = scratch.add("", value);
        let place = whole.inside(name.len() + 1..text.len());
        let value = match document::parse(&scratch, scratch_file).valid() {
            Ok(document) => relocate(document.root, place),
            Err(_) => Value { span: place, kind: document::Kind::Text(value.to_owned()) },
        };
        Some(Override { name: name.to_owned(), value, place: whole })
    }
}

/// Returns a value with its source spans moved to `place`, which lies in another source.
fn relocate(value: Value, place: Span) -> Value {
    let span = place.inside(value.span.range());
    let kind = match value.kind {
        document::Kind::Array(elements) => {
            document::Kind::Array(elements.into_iter().map(|element| relocate(element, place)).collect())
        }
        document::Kind::Object(entries) => document::Kind::Object(
            entries
                .into_iter()
                .map(|entry| document::Entry {
                    key_span: place.inside(entry.key_span.range()),
                    key: entry.key,
                    value: relocate(entry.value, place),
                })
                .collect(),
        ),
        other => other,
    };
    Value { span, kind }
}
