//! A control for each live parameter of a plan, as its declaration says: sliders within its range, a box to be checked,
//! a list of words.

use std::ops::RangeInclusive;

use eframe::egui;
use umbragraph::Plan;
use umbragraph::low_level::expression::Value;
use umbragraph::low_level::language::ParameterType;

/// The width of a slider's rail, in points.
pub(crate) const RAIL: f32 = 220.0;

/// A live parameter with its value, description, range and type.
pub(crate) struct Control {
    pub(crate) name: String,
    pub(crate) value: Value,
    description: String,
    range: RangeInclusive<f64>,
    is_whole: bool,
    words: Vec<String>,
}

/// Creates a control for each live parameter of a plan.
pub(crate) fn controls(plan: &Plan) -> Vec<Control> {
    let live = plan.pipeline.parameters.iter().filter(|(_, parameter)| parameter.structural.is_none());
    let control = |(name, parameter): (&String, &umbragraph::low_level::pipeline::ValuedParameter)| {
        let declaration = &parameter.declaration;
        let whole = [ParameterType::U32, ParameterType::I32, ParameterType::U32List];
        Control {
            name: name.clone(),
            value: parameter.value.clone(),
            description: format!(
                "{} [{}]",
                declaration.description.as_deref().unwrap_or_default(),
                declaration.unit.as_deref().unwrap_or("1"),
            ),
            range: declaration.min.unwrap_or(0.0)..=declaration.max.unwrap_or(1.0),
            is_whole: whole.contains(&declaration.parameter_type),
            words: declaration.values.clone(),
        }
    };
    live.map(control).collect()
}

impl Control {
    /// Shows the control. Returns `true` if the value has changed, and the rectangle of its first part.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui) -> (bool, egui::Rect) {
        ui.spacing_mut().slider_width = RAIL;
        ui.label(&self.name).on_hover_text(&self.description);
        let slider = |ui: &mut egui::Ui, number: &mut f64| {
            let is_wide = *self.range.end() > 1000.0 * self.range.start().max(0.01);
            let mut slider = egui::Slider::new(number, self.range.clone()).logarithmic(is_wide);
            if self.is_whole {
                slider = slider.integer();
            }
            ui.add(slider)
        };
        let response = match &mut self.value {
            Value::Number(number) => slider(ui, number),
            Value::List(list) => {
                let numbers = list.iter_mut().filter_map(|value| match value {
                    Value::Number(number) => Some(number),
                    _ => None,
                });
                let all = numbers.map(|number| slider(ui, number)).reduce(|all, one| {
                    let rect = all.rect;
                    all.union(one).with_new_rect(rect)
                });
                all.unwrap_or_else(|| ui.label("an empty list"))
            }
            Value::Bool(on) => ui.checkbox(on, ""),
            Value::Text(text) => {
                let before = text.clone();
                let list = egui::ComboBox::from_id_salt(&self.name).selected_text(&before);
                let mut response = list.show_ui(ui, |ui| {
                    for word in &self.words {
                        ui.selectable_value(text, word.clone(), word);
                    }
                });
                if *text != before {
                    response.response.mark_changed();
                }
                response.response
            }
            // No parameter refers to a resource.
            Value::Reference(reference) => ui.label(reference.to_string()),
        };
        (response.changed(), response.rect)
    }
}
