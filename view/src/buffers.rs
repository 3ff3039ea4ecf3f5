//! The contents of a buffer as a list of fields, as the shaders that bind it declare them
//! ([`umbragraph::low_level::buffers`]).

use std::ops::Range;

use eframe::egui::{self, Color32, Key, RichText};
use serde_json::{Value, json};
pub(crate) use umbragraph::low_level::buffers::{Field, MAX_FIELDS, fields, layouts, size_of};

use crate::dock::FOCUS;
use crate::places::Places;

/// The fields that differ between two versions of a buffer, with values such as "before → after".
pub(crate) fn compared(after: Vec<Field>, before: &[Field]) -> Vec<Field> {
    let changed = |(after, before): (Field, &Field)| {
        (after.value != before.value)
            .then(|| Field { value: format!("{} → {}", before.value, after.value), ..after })
    };
    after.into_iter().zip(before).filter_map(changed).collect()
}

/// The list of fields: the row that the keyboard has chosen, and the part in view.
#[derive(Default)]
pub(crate) struct List {
    /// The chosen row; `None` before one is chosen.
    row: Option<usize>,
    /// The rows in view in the last frame.
    shown: Range<usize>,
    /// The distance that the list is scrolled, and the height of its view, in points.
    view: [f32; 2],
}

impl List {
    /// The id of the list, which has the keyboard as a whole.
    pub(crate) fn id() -> egui::Id {
        egui::Id::unique("fields")
    }

    /// Shows fields as a list; only visible rows are laid out. `has_more` adds a note that fields are missing.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui, fields: &[Field], has_more: bool, places: &mut Places) {
        let height = ui.text_style_height(&egui::TextStyle::Monospace);
        if has_more {
            ui.label(RichText::new(format!("The first {MAX_FIELDS} fields.")).weak());
        }
        if fields.is_empty() {
            ui.label(RichText::new("No fields.").weak());
        }
        let area = ui.available_rect_before_wrap();
        let list = ui.interact(area, Self::id(), egui::Sense::focusable_noninteractive());
        places.note("fields", &list);
        let step = height + ui.spacing().item_spacing.y;
        self.row = self.row.filter(|row| *row < fields.len());
        let mut scroll = egui::ScrollArea::vertical().auto_shrink(false);
        if list.has_focus()
            && let Some(row) = chosen(ui, self.row, fields.len(), (self.view[1] / step) as usize)
        {
            self.row = Some(row);
            // The row is in view as a whole.
            let [offset, view] = self.view;
            let top = row as f32 * step;
            scroll = scroll.vertical_scroll_offset(offset.min(top).max(top + height - view));
        }
        let row = &mut self.row;
        let shown = scroll.show_rows(ui, height, fields.len(), |ui, rows| {
            // A row is as high as its text, and not as a button.
            ui.spacing_mut().interact_size.y = height;
            for (at, field) in rows.clone().zip(fields.get(rows).unwrap_or_default()) {
                let behind = ui.painter().add(egui::Shape::Noop);
                let response = ui
                    .horizontal(|ui| {
                        ui.monospace(RichText::new(&field.name).color(NAME));
                        ui.monospace(&field.value);
                    })
                    .response;
                places.note(&format!("field {}", field.name), &response);
                let line = response.rect.with_max_x(ui.max_rect().right());
                if ui.rect_contains_pointer(line) && ui.input(|input| input.pointer.primary_clicked()) {
                    *row = Some(at);
                    list.request_focus();
                }
                if *row == Some(at) {
                    let fill = ui.visuals().selection.bg_fill.gamma_multiply(0.6);
                    ui.painter().set(behind, egui::Shape::rect_filled(line.expand(1.0), 2.0, fill));
                }
            }
        });
        if list.has_focus() {
            ui.painter().rect_stroke(area, 0.0, egui::Stroke::new(1.0, FOCUS), egui::StrokeKind::Outside);
        }
        self.view = [shown.state.clamped_offset().y, shown.inner_rect.height()];
        // Rows in view as a whole, but for a rounding.
        let begin = (self.view[0] / step - 0.01).ceil() as usize;
        let end = ((self.view[0] + self.view[1] - height) / step + 1.01) as usize;
        self.shown = begin..end.min(fields.len());
    }

    /// The chosen row, the rows in view and the first 64 fields as JSON, for the log that tests read.
    pub(crate) fn state(&self, fields: &[Field]) -> [(&'static str, Value); 3] {
        let first = fields.iter().take(64).map(|field| json!([field.name, field.value])).collect();
        [("fields", first), ("row", json!(self.row)), ("rows", json!([self.shown.start, self.shown.end]))]
    }
}

/// The row that the keys choose next in a list of `count` rows, of which `page` are in view; `None` without such a key.
/// The list keeps the arrow keys.
fn chosen(ui: &egui::Ui, row: Option<usize>, count: usize, page: usize) -> Option<usize> {
    let arrows = egui::EventFilter { vertical_arrows: true, ..Default::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(List::id(), arrows));
    let last = count.checked_sub(1)?;
    let page = page.saturating_sub(1).max(1);
    // Keys of one frame count in their order.
    let pressed = |event: &egui::Event| match event {
        egui::Event::Key { key, pressed: true, .. } if OF_LISTS.contains(key) => Some(*key),
        _ => None,
    };
    let keys: Vec<Key> = ui.input(|input| input.events.iter().filter_map(pressed).collect());
    let mut chosen = None;
    for key in keys {
        let next = match (key, chosen.or(row)) {
            (Key::End, _) => last,
            (Key::Home, _) | (_, None) => 0,
            (Key::ArrowUp, Some(row)) => row.saturating_sub(1),
            (Key::ArrowDown, Some(row)) => row + 1,
            (Key::PageUp, Some(row)) => row.saturating_sub(page),
            (_, Some(row)) => row + page,
        };
        chosen = Some(next.min(last));
    }
    chosen
}

/// The keys that belong to the list while it has the keyboard.
pub(crate) const OF_LISTS: [Key; 6] =
    [Key::ArrowUp, Key::ArrowDown, Key::PageUp, Key::PageDown, Key::Home, Key::End];

const NAME: Color32 = Color32::from_rgb(150, 160, 190);

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
