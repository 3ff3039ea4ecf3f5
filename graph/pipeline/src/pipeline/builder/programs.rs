//! The program of a template: its axes get values, its variants are rendered and reflected.

use std::collections::BTreeMap;

use crate::pipeline::builder::PassBuilder;
use crate::pipeline::program::Program;
use crate::pipeline::settings::{Evaluate, Structural};
use crate::pipeline::state::shared::Shared;
use crate::pipeline::survey::{Chosen, EntryPoints};
use crate::work::ProgramHandle;
use umbragraph_shaders::{Axes, Axis, AxisKind, AxisValue, AxisValues};
use umbragraph_text::diagnostic::{Diagnostic, codes, list_of, suggested_name};
use umbragraph_text::document::{self, Signs, Written};
use umbragraph_text::expression::{ExpressionKind, Scope as _, Value};
use umbragraph_text::language::Expr;

impl PassBuilder<'_> {
    /// Returns `true` if a full-screen pass with this program is certain to write every texel of its targets.
    pub fn covers(&self, program: ProgramHandle) -> bool {
        self.shared.programs.list[program.index()].covers()
    }

    /// Returns the program of a template, or `None` after a diagnostic. An axis takes its value from `axes`, else from
    /// the feature or parameter of the same name, else its default. Mesh properties of the geometry contract `geometry`
    /// select variants, where the template has axes of their names. `entry_points` names the entry point of each stage
    /// that has several.
    pub fn program(
        &mut self,
        template: &str,
        axes: &BTreeMap<String, Expr>,
        geometry: Option<&str>,
        entry_points: &EntryPoints,
        pointer: &str,
    ) -> Option<ProgramHandle> {
        let shader_at = [pointer, "/shader"].concat();
        let templates = self.shared.programs.shaders.templates().clone();
        let Some(known) = templates.axes(template) else {
            let diagnostic = templates.unknown(template, self.place(&shader_at));
            self.shared.diagnostics.push(diagnostic.pointer(self.absolute(&shader_at)));
            return None;
        };
        let mut values = AxisValues::new();
        let mut fine = true;
        for (name, expr) in axes {
            let at = || document::pointer_join(&format!("{pointer}/axes"), name);
            let Some(axis) = known.get(name) else {
                // A declaration that nobody can read is the diagnostic.
                if templates.has_lost_axes(template) {
                    continue;
                }
                let names: Vec<&str> = known.iter().map(|axis| axis.name.as_str()).collect();
                let message = format!("{template} has no axis \"{name}\"");
                self.report_unknown(codes::UNKNOWN_AXIS, &at(), message, name, &names, || {
                    let way = templates.way_to_axis(template, name);
                    match names[..] {
                        [] => way,
                        _ => format!("the axes of {template} are {}; {way}", list_of(&names)),
                    }
                });
                fine = false;
                continue;
            };
            let parsed = self.parse(expr);
            let result = parsed.and_then(|parsed| Ok((self.evaluate_parsed(&parsed, &at())?, parsed)));
            match result {
                Ok((value, parsed)) => match axis_value(&value) {
                    Some(value) if !axis.kind.contains(&value) => {
                        self.axis_value_error(template, axis, &value, &at());
                        fine = false;
                    }
                    Some(value) => {
                        if !matches!(parsed.kind, ExpressionKind::Literal(_)) {
                            self.open_axes.insert(name.clone());
                        }
                        values.insert(name.clone(), value);
                    }
                    None => {
                        let wanted = "a boolean, a whole number or a word";
                        self.wrong_type::<()>(&at(), wanted, value.kind_name());
                        fine = false;
                    }
                },
                Err(error) => {
                    self.expression_error(&error, &at());
                    fine = false;
                }
            }
        }
        let place = self.place(&shader_at);
        for axis in known.iter() {
            if values.contains_key(&axis.name) {
                continue;
            }
            let at = || Structural { place, pointer: [&self.pointer, &*shader_at].concat() };
            self.shared.fix_name(&axis.name, self.environment, &at);
            let value = self.environment.axis(&axis.name, &self.shared.scope);
            if let Some(value) = value.as_ref().and_then(axis_value) {
                self.open_axes.insert(axis.name.clone());
                values.insert(axis.name.clone(), value);
            }
        }
        let contract = geometry.and_then(|geometry| self.shared.geometry.get(geometry));
        let properties = contract.into_iter().flat_map(|contract| &contract.variants);
        let properties: Vec<String> = properties.filter(|name| known.get(name).is_some()).cloned().collect();
        self.open_axes.extend(properties.iter().filter(|name| !values.contains_key(*name)).cloned());
        if !fine {
            return None;
        }
        let entry_points = entry_points.clone();
        let chosen = Chosen { template: template.to_owned(), axes: values, properties, entry_points };
        if let Some(survey) = &mut self.shared.programs.survey {
            survey.want(self.name, &chosen, place);
        }
        let named = chosen.entry_points.clone();
        let at = &self.pointer;
        let Shared { programs, diagnostics, .. } = &mut *self.shared;
        let program = programs.program(chosen, place, &|| [at.as_str(), &shader_at].concat(), diagnostics)?;
        self.check_entry_points(program, &named, pointer)?;
        Some(program)
    }

    /// The axis values of a program that are the same in every configuration. These are literals in the pass, and
    /// defaults of axes that neither the pass nor the pipeline sets.
    pub(super) fn fixed_axes(&self, program: &Program) -> AxisValues {
        let known = self.shared.programs.shaders.templates().axes(&program.template);
        let mut values = known.map(Axes::defaults).unwrap_or_default();
        values.extend(program.axes.clone());
        values.retain(|name, _| !self.open_axes.contains(name));
        values
    }

    /// Reports a value that an axis does not have.
    fn axis_value_error(&mut self, template: &str, axis: &Axis, value: &AxisValue, pointer: &str) {
        let message = format!("\"{value}\" is not a value of the axis \"{}\" of {template}", axis.name);
        let known: &[String] = match &axis.kind {
            AxisKind::Enum(words) | AxisKind::TextureFormat(words) => words,
            AxisKind::Bool | AxisKind::Integer { .. } => &[],
        };
        let help = match suggested_name(&value.to_string(), known.iter().map(String::as_str)) {
            Some(word) => format!("did you mean \"{word}\"?"),
            None => format!("the values are {}", axis.kind.describe()),
        };
        let mut diagnostic =
            Diagnostic::error(umbragraph_shaders::codes::AXIS_VALUE, self.place(pointer), message)
                .pointer(self.absolute(pointer))
                .related(axis.span, "the axis is declared here")
                .help(help);
        // A name of the pipeline without its sign.
        let written = self.settings.nearest(pointer);
        let is_name = written.text().is_some_and(|text| {
            let inside = self.environment.seen(&self.shared.scope);
            Written::of(text) == Written::Plain(text) && inside.lookup(text).is_some()
        });
        if let Some(unsigned) = Signs::Expression.check(written).filter(|_| is_name) {
            (diagnostic.help, diagnostic.fix) = (unsigned.help, unsigned.fix);
        }
        self.shared.diagnostics.push(diagnostic);
    }

    /// Checks that every variant of a program has the named entry points; returns `None` after a diagnostic.
    fn check_entry_points(
        &mut self,
        program: ProgramHandle,
        named: &EntryPoints,
        pointer: &str,
    ) -> Option<()> {
        let program = self.shared.programs.list[program.index()].clone();
        for (stage, name) in named {
            let missing = program.variants.iter().find(|variant| variant.entry_point(*stage).is_none());
            let Some(variant) = missing else { continue };
            let entries = &variant.module.reflection.entry_points;
            let known = entries.iter().filter(|entry| entry.stage == *stage);
            let known: Vec<&str> = known.map(|entry| entry.name.as_str()).collect();
            let (code, stage) = (codes::UNKNOWN_ENTRY_POINT, stage.name());
            let message = format!("{} has no @{stage} entry point \"{name}\"", program.template);
            let at = format!("{pointer}/entry_points/{stage}");
            self.report_unknown(code, &at, message, name, &known, || match &known[..] {
                [] => format!("it has none of the stage @{stage}"),
                known => format!("it has {}", list_of(known)),
            });
            return None;
        }
        Some(())
    }
}

/// Converts the value of an expression to an axis value; `None` for a fraction, a list or a reference.
pub fn axis_value(value: &Value) -> Option<AxisValue> {
    match value {
        Value::Bool(value) => Some(AxisValue::Bool(*value)),
        Value::Number(number) if number.fract() == 0.0 && number.abs() < 9.0e15 => {
            Some(AxisValue::Integer(*number as i64))
        }
        Value::Text(text) => Some(AxisValue::Name(text.clone())),
        _ => None,
    }
}
