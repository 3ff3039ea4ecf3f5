//! The panel of values: preset, features, toggles and parameters, each with what a change of it costs.
//!
//! A control shows the value that runs. A value that was given in the window is marked, and a click on its mark resets
//! it. `live` values change the next frame and nothing else; `plan` values make a new plan on the watcher's thread,
//! while the frame before goes on.

use eframe::egui::{self, Color32, RichText};
use serde_json::{Value, json};
use umbragraph::Plan;
use umbragraph::low_level::document::Document;
use umbragraph::low_level::language::{ParameterDeclaration, ParameterType};
use umbragraph::low_level::session::is_about_color;

use crate::places::Places;
use crate::values::{Values, number_of, to_json};

/// The colour that marks values changed in the window.
const GIVEN: Color32 = Color32::from_rgb(255, 190, 92);
const LIVE: Color32 = Color32::from_rgb(126, 200, 140);
const PLAN: Color32 = Color32::from_rgb(150, 160, 190);

/// The state of the panel of values.
#[derive(Default)]
pub(crate) struct Panel {
    pub(crate) search: String,
    /// Whether only values changed in the window are shown.
    pub(crate) only_given: bool,
}

/// A row of the panel: one parameter, feature or toggle.
struct Row<'a> {
    name: &'a str,
    description: String,
    cost: &'static str,
    is_given: bool,
}

impl Panel {
    /// Shows the panel for a plan, and stores the user's changes in `values`. `is_searched` moves the focus to the
    /// search field.
    pub(crate) fn show(
        &mut self,
        ui: &mut egui::Ui,
        plan: &Plan,
        document: Option<&Document>,
        values: &mut Values,
        places: &mut Places,
        is_searched: bool,
    ) {
        ui.horizontal(|ui| {
            let search =
                egui::TextEdit::singleline(&mut self.search).hint_text("Search values").desired_width(170.0);
            let search = ui.add(search);
            places.note("search", &search);
            if is_searched {
                search.request_focus();
            }
            places.note("only given", &ui.checkbox(&mut self.only_given, "changed"));
            let reset = ui.add_enabled(!values.is_empty(), egui::Button::new("Reset all"));
            places.note("reset all", &reset);
            if reset.clicked() {
                *values = Values::default();
            }
        });
        ui.separator();
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            preset(ui, document, values, places);
            self.features(ui, plan, values, places);
            self.toggles(ui, plan, values, places);
            self.parameters(ui, plan, values, places);
        });
    }

    fn shows(&self, row: &Row<'_>) -> bool {
        let wanted = self.search.to_lowercase();
        let has = |text: &str| text.to_lowercase().contains(&wanted);
        (has(row.name) || has(&row.description)) && (row.is_given || !self.only_given)
    }

    fn features(&self, ui: &mut egui::Ui, plan: &Plan, values: &mut Values, places: &mut Places) {
        let rows = plan.pipeline.features.iter().filter_map(|(name, feature)| {
            let description = feature.declaration.description.clone().unwrap_or_default();
            let is_given = values.features.contains_key(name);
            let row = Row { name, description, cost: "plan", is_given };
            self.shows(&row).then_some((row, feature))
        });
        let rows: Vec<_> = rows.collect();
        section(ui, "Features", rows.len());
        for (row, feature) in rows {
            let mut value = to_json(&feature.value);
            if let Some(given) = values.features.get(row.name) {
                value = given.clone();
            }
            let before = value.clone();
            let is_reset = head(ui, &row, places, |ui| match &mut value {
                Value::Bool(on) => Some(ui.checkbox(on, "")),
                Value::String(word) => Some(words(ui, row.name, word, &feature.declaration.values)),
                _ => None,
            });
            if is_reset {
                values.features.remove(row.name);
            } else if value != before {
                values.features.insert(row.name.to_owned(), value);
            }
        }
    }

    fn toggles(&self, ui: &mut egui::Ui, plan: &Plan, values: &mut Values, places: &mut Places) {
        let rows = plan.pipeline.toggles.iter().filter_map(|toggle| {
            let description = toggle.description.clone().unwrap_or_default();
            let is_given = values.toggles.contains_key(&toggle.name);
            let row = Row { name: &toggle.name, description, cost: "live", is_given };
            self.shows(&row).then_some((row, toggle))
        });
        let rows: Vec<_> = rows.collect();
        section(ui, "Toggles", rows.len());
        for (row, toggle) in rows {
            let before = values.toggles.get(row.name).copied().unwrap_or(toggle.default);
            let mut on = before;
            let is_reset = head(ui, &row, places, |ui| Some(ui.checkbox(&mut on, "")));
            if is_reset {
                values.toggles.remove(row.name);
            } else if on != before {
                values.toggles.insert(row.name.to_owned(), on);
            }
        }
    }

    fn parameters(&self, ui: &mut egui::Ui, plan: &Plan, values: &mut Values, places: &mut Places) {
        let rows = plan.pipeline.parameters.iter().filter_map(|(name, parameter)| {
            let cost = if parameter.structural.is_none() { "live" } else { "plan" };
            let description = described(&parameter.declaration);
            let row = Row { name, description, cost, is_given: values.parameters.contains_key(name) };
            self.shows(&row).then_some((row, parameter))
        });
        let rows: Vec<_> = rows.collect();
        section(ui, "Parameters", rows.len());
        for (row, parameter) in rows {
            let given = values.parameters.get(row.name).cloned();
            let before = given.unwrap_or_else(|| to_json(&parameter.value));
            let mut value = before.clone();
            let is_reset =
                head(ui, &row, places, |ui| control(ui, row.name, &parameter.declaration, &mut value));
            if is_reset {
                values.parameters.remove(row.name);
            } else if value != before {
                values.parameters.insert(row.name.to_owned(), value);
            }
        }
    }
}

fn section(ui: &mut egui::Ui, name: &str, rows: usize) {
    if rows > 0 {
        ui.add_space(8.0);
        ui.label(RichText::new(name.to_uppercase()).small().strong().color(PLAN));
        ui.add_space(2.0);
    }
}

/// Shows the list of presets, if the document has any.
fn preset(ui: &mut egui::Ui, document: Option<&Document>, values: &mut Values, places: &mut Places) {
    let presets = document.map(|document| document.root.entries_of("presets")).unwrap_or_default();
    if presets.is_empty() {
        return;
    }
    ui.horizontal(|ui| {
        ui.label("Preset");
        let shown = values.preset.clone().unwrap_or_else(|| "none".to_owned());
        let list = egui::ComboBox::from_id_salt("preset").width(180.0).selected_text(shown);
        let response = list.show_ui(ui, |ui| {
            let mut note = |name: &str, response: egui::Response| {
                places.note(&format!("preset={name}"), &response);
            };
            note("none", ui.selectable_value(&mut values.preset, None, "none"));
            for entry in presets {
                note(
                    &entry.key,
                    ui.selectable_value(&mut values.preset, Some(entry.key.clone()), &entry.key),
                );
            }
        });
        places.note("preset", &response.response);
    });
}

/// Shows a row: name, cost, control, and a reset button for a changed value. Returns `true` if the button was clicked.
fn head(
    ui: &mut egui::Ui,
    row: &Row<'_>,
    places: &mut Places,
    control: impl FnOnce(&mut egui::Ui) -> Option<egui::Response>,
) -> bool {
    let mut is_reset = false;
    ui.horizontal(|ui| {
        let color = if row.is_given { GIVEN } else { ui.visuals().text_color() };
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(egui::vec2(142.0, 18.0), layout, |ui| {
            ui.set_min_width(142.0);
            let name = egui::Label::new(RichText::new(row.name).color(color)).truncate();
            ui.add(name).on_hover_text(&row.description);
        });
        let cost = if row.cost == "live" { LIVE } else { PLAN };
        let cost = egui::Label::new(RichText::new(row.cost).small().color(cost));
        ui.add_sized([26.0, 18.0], cost).on_hover_text(match row.cost {
            "live" => "live: holds from the next frame on, nothing is planned",
            _ => "structural: a new plan is made beside the running frame",
        });
        if let Some(response) = control(ui) {
            places.note(row.name, &response);
        }
        if row.is_given {
            let reset = ui
                .small_button(RichText::new("reset").color(GIVEN))
                .on_hover_text("Reset to the pipeline's value");
            places.note(&format!("reset {}", row.name), &reset);
            is_reset = reset.clicked();
        }
    });
    is_reset
}

/// The description, range and unit of a parameter, as text for a tooltip.
fn described(declaration: &ParameterDeclaration) -> String {
    let mut text = declaration.description.clone().unwrap_or_default();
    let range = [declaration.min, declaration.max].map(|end| end.map(|end| number_of(end).to_string()));
    if let [Some(min), Some(max)] = range {
        text += &format!("\nfrom {min} to {max}");
    }
    if let Some(unit) = declaration.unit.as_deref().filter(|unit| *unit != "1") {
        text += &format!(" {unit}");
    }
    text.trim().to_owned()
}

/// Shows the control for a parameter and updates `value`; `None` if its type has no control.
fn control(
    ui: &mut egui::Ui,
    name: &str,
    declaration: &ParameterDeclaration,
    value: &mut Value,
) -> Option<egui::Response> {
    match value {
        Value::Bool(on) => Some(ui.checkbox(on, "")),
        Value::String(word) => Some(words(ui, name, word, &declaration.values)),
        Value::Number(_) => {
            let before = value.as_f64()?;
            let mut number = before;
            let response = slider(ui, declaration, &mut number);
            if response.changed() && number != before {
                *value = number_of(number);
            }
            Some(response)
        }
        Value::Array(list) => {
            let mut numbers: Vec<f64> = list.iter().filter_map(Value::as_f64).collect();
            let before = numbers.clone();
            let response = ui
                .vertical(|ui| {
                    if is_color(name, declaration, &numbers) {
                        color(ui, &mut numbers);
                    }
                    let sliders: Vec<_> =
                        numbers.iter_mut().map(|number| slider(ui, declaration, number)).collect();
                    sliders.into_iter().next()
                })
                .inner;
            if numbers != before {
                *value = numbers.into_iter().map(number_of).collect();
            }
            response
        }
        Value::Null | Value::Object(_) => None,
    }
}

fn slider(ui: &mut egui::Ui, declaration: &ParameterDeclaration, number: &mut f64) -> egui::Response {
    let is_whole = matches!(
        declaration.parameter_type,
        ParameterType::U32 | ParameterType::I32 | ParameterType::U32List
    );
    match (declaration.min, declaration.max) {
        (Some(min), Some(max)) if min < max => {
            ui.spacing_mut().slider_width = 118.0;
            let is_wide = min >= 0.0 && max > 1000.0 * min.max(0.01);
            let before = *number;
            let slider = egui::Slider::new(number, min..=max).logarithmic(is_wide).max_decimals(4);
            let response = ui.add(if is_whole { slider.integer() } else { slider });
            // It rounds what it shows; that is no change.
            if !(response.dragged()
                || response.drag_stopped()
                || response.clicked()
                || response.has_focus()
                || response.lost_focus())
                && (*number - before).abs() <= 1e-4
            {
                *number = before;
            }
            response
        }
        (min, max) => {
            let range = min.unwrap_or(f64::MIN)..=max.unwrap_or(f64::MAX);
            let speed = if is_whole { 1.0 } else { 0.01 * number.abs().max(0.1) };
            let drag = egui::DragValue::new(number).range(range).speed(speed);
            ui.add(if is_whole { drag.max_decimals(0) } else { drag })
        }
    }
}

fn words(ui: &mut egui::Ui, name: &str, word: &mut String, all: &[String]) -> egui::Response {
    let list = egui::ComboBox::from_id_salt(("words", name)).width(150.0).selected_text(word.clone());
    let shown = list.show_ui(ui, |ui| {
        for one in all {
            ui.selectable_value(word, one.clone(), one);
        }
    });
    shown.response
}

/// Returns `true` if three numbers are a colour, as the color picker of editors knows it.
fn is_color(name: &str, declaration: &ParameterDeclaration, numbers: &[f64]) -> bool {
    let texts = [Some(name), declaration.description.as_deref(), declaration.unit.as_deref()];
    numbers.len() == 3 && is_about_color(texts.into_iter().flatten())
}

/// Shows a button that edits a colour. A colour brighter than 1 keeps its brightness.
fn color(ui: &mut egui::Ui, numbers: &mut [f64]) {
    let brightest = numbers.iter().fold(1.0, |max: f64, one| max.max(*one));
    let Ok(mut rgb) =
        <[f32; 3]>::try_from(numbers.iter().map(|one| (one / brightest) as f32).collect::<Vec<_>>())
    else {
        return;
    };
    if ui.color_edit_button_rgb(&mut rgb).changed() {
        numbers.iter_mut().zip(rgb).for_each(|(number, one)| *number = f64::from(one) * brightest);
    }
}

/// The parameter values of the running plan as JSON, for the log that tests read.
pub(crate) fn state(plan: &Plan) -> Value {
    let values = plan.pipeline.parameters.iter().map(|(name, one)| (name.clone(), to_json(&one.value)));
    json!(values.collect::<serde_json::Map<_, _>>())
}

/// The feature values of the running plan as JSON, for the log that tests read.
pub(crate) fn features(plan: &Plan) -> Value {
    let values = plan.pipeline.features.iter().map(|(name, one)| (name.clone(), to_json(&one.value)));
    json!(values.collect::<serde_json::Map<_, _>>())
}
