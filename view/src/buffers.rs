//! The contents of a buffer as a list of fields, as the shaders that bind it declare them
//! ([`umbragraph::low_level::buffers`]).

use eframe::egui::{self, Color32, RichText};
use serde_json::{Value, json};
pub(crate) use umbragraph::low_level::buffers::{Field, MAX_FIELDS, fields, layouts, size_of};

use crate::places::Places;

/// The fields that differ between two versions of a buffer, with values such as "before → after".
pub(crate) fn compared(after: Vec<Field>, before: &[Field]) -> Vec<Field> {
    let changed = |(after, before): (Field, &Field)| {
        (after.value != before.value)
            .then(|| Field { value: format!("{} → {}", before.value, after.value), ..after })
    };
    after.into_iter().zip(before).filter_map(changed).collect()
}

/// Shows fields as a list; only visible rows are laid out. `has_more` adds a note that fields are missing.
pub(crate) fn show(ui: &mut egui::Ui, fields: &[Field], has_more: bool, places: &mut Places) {
    let height = ui.text_style_height(&egui::TextStyle::Monospace);
    if has_more {
        ui.label(RichText::new(format!("The first {MAX_FIELDS} fields.")).weak());
    }
    if fields.is_empty() {
        ui.label(RichText::new("No fields.").weak());
    }
    let name_color = Color32::from_rgb(150, 160, 190);
    egui::ScrollArea::vertical().auto_shrink(false).show_rows(ui, height, fields.len(), |ui, rows| {
        for field in fields.get(rows).unwrap_or_default() {
            let row = ui.horizontal(|ui| {
                ui.monospace(RichText::new(&field.name).color(name_color));
                ui.monospace(&field.value);
            });
            places.note(&format!("field {}", field.name), &row.response);
        }
    });
}

/// The first 64 fields as JSON, for the log that tests read.
pub(crate) fn state(fields: &[Field]) -> Value {
    fields.iter().take(64).map(|field| json!([field.name, field.value])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comparison_has_the_fields_that_differ() {
        let field = |name: &str, value: &str| Field { name: name.to_owned(), value: value.to_owned() };
        let before = [field("[0].count", "7"), field("[1].count", "6")];
        let after = vec![field("[0].count", "7"), field("[1].count", "7")];
        assert_eq!(compared(after, &before), [field("[1].count", "6 → 7")]);
    }
}
