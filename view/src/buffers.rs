//! The contents of a buffer, field by field, as the shaders that bind it declare it.
//!
//! Shaders may declare one buffer in several ways; each is a choice. A buffer that no shader binds is shown as words of
//! 32 bits. At most [`MAX_FIELDS`] fields are shown.

use eframe::egui::{self, Color32, RichText};
use half::f16;
use serde_json::{Value, json};
use umbragraph::Plan;
use umbragraph::low_level::pipeline;
use umbragraph::low_level::shader::{Scalar, ScalarKind, TypeLayout};
use umbragraph::work::SlotSource;

use crate::places::Places;

/// The maximum number of fields that are decoded and shown.
const MAX_FIELDS: usize = 4096;

/// A memory layout with which a shader declares a buffer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layout {
    /// The type in WGSL, followed by the byte offset of the binding if it is not 0.
    pub(crate) label: String,
    offset: u32,
    layout: TypeLayout,
}

/// A scalar, vector or matrix in a buffer: the path to it, such as `[0].count`, and its value as text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) value: String,
}

/// The size of a buffer in bytes; `None` if the resource is not a buffer or does not exist.
pub(crate) fn size_of(plan: &Plan, name: &str) -> Option<u64> {
    let resource = plan.resources.get(name)?;
    let is_buffer = matches!(plan.pipeline.resource(resource.handle).kind, pipeline::ResourceKind::Buffer(_));
    is_buffer.then_some(resource.bytes)
}

/// The layouts with which shaders declare a buffer. An array of `u32` if no shader binds the buffer; empty if the plan
/// has no such resource.
pub(crate) fn layouts(plan: &Plan, name: &str) -> Vec<Layout> {
    let mut layouts: Vec<Layout> = Vec::new();
    let Some(resource) = plan.resources.get(name) else { return layouts };
    for pass in &plan.passes {
        let Some((program, slots)) = plan.pipeline.pass(pass.handle).work().bound() else { continue };
        let bindings = &plan.pipeline.program(program).bindings;
        for slot in slots {
            let SlotSource::Buffer { buffer, .. } = &slot.source else { continue };
            let binding =
                bindings.iter().find(|one| (one.group, one.entry.binding) == (slot.group, slot.binding));
            let (true, Some(layout)) =
                (buffer.resource == resource.handle, binding.and_then(|one| one.block.clone()))
            else {
                continue;
            };
            let offset = u32::try_from(buffer.offset()).unwrap_or(u32::MAX);
            let from = if offset == 0 { String::new() } else { format!(" from byte {offset}") };
            let found = Layout { label: layout.spelling() + &from, offset, layout };
            if !layouts.contains(&found) {
                layouts.push(found);
            }
        }
    }
    if layouts.is_empty() {
        let word = TypeLayout::Scalar { scalar: Scalar { kind: ScalarKind::Uint, width: 4 }, atomic: false };
        let layout = TypeLayout::Array { element: Box::new(word), count: None, stride: 4 };
        layouts.push(Layout { label: layout.spelling(), offset: 0, layout });
    }
    layouts
}

/// Decodes the bytes of a buffer into fields. The flag is `true` if there are more than [`MAX_FIELDS`].
pub(crate) fn fields(layout: &Layout, bytes: &[u8]) -> (Vec<Field>, bool) {
    let mut fields = Vec::new();
    let has_more = add(&layout.layout, "", layout.offset as usize, bytes, &mut fields);
    (fields, has_more)
}

/// Adds the fields of a type at the byte offset `at`. Returns `true` if some are left out because of [`MAX_FIELDS`].
fn add(layout: &TypeLayout, path: &str, at: usize, bytes: &[u8], fields: &mut Vec<Field>) -> bool {
    if fields.len() >= MAX_FIELDS {
        return true;
    }
    let vector = |at: usize, components: u32, scalar: &Scalar| {
        let numbers = (0..components).map(|one| number(bytes, at + (one * scalar.width) as usize, scalar));
        format!("({})", numbers.collect::<Vec<_>>().join(", "))
    };
    let value = match layout {
        TypeLayout::Scalar { scalar, .. } => number(bytes, at, scalar),
        TypeLayout::Vector { components, scalar } => vector(at, *components, scalar),
        TypeLayout::Matrix { columns, rows, scalar, stride } => {
            let columns = (0..*columns).map(|column| vector(at + (column * stride) as usize, *rows, scalar));
            columns.collect::<Vec<_>>().join(" ")
        }
        TypeLayout::Array { element, count, stride } => {
            let rest = bytes.len().saturating_sub(at) / (*stride).max(1) as usize;
            return (0..count.map_or(rest, |count| count as usize)).any(|index| {
                add(element, &format!("{path}[{index}]"), at + index * *stride as usize, bytes, fields)
            });
        }
        TypeLayout::Struct { members, .. } => {
            return members.iter().any(|member| {
                let dot = if path.is_empty() { "" } else { "." };
                let path = format!("{path}{dot}{}", member.name);
                add(&member.layout, &path, at + member.offset as usize, bytes, fields)
            });
        }
    };
    fields.push(Field { name: path.to_owned(), value });
    false
}

/// The number at the byte offset `at` as text; "–" beyond the end of the bytes.
fn number(bytes: &[u8], at: usize, scalar: &Scalar) -> String {
    let Some(bytes) = bytes.get(at..at + scalar.width as usize) else { return "–".to_owned() };
    let two = || <[u8; 2]>::try_from(bytes).unwrap_or_default();
    let four = || <[u8; 4]>::try_from(bytes).unwrap_or_default();
    let eight = || <[u8; 8]>::try_from(bytes).unwrap_or_default();
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 2) => f16::from_le_bytes(two()).to_string(),
        (ScalarKind::Float, 4) => f32::from_le_bytes(four()).to_string(),
        (ScalarKind::Float, _) => f64::from_le_bytes(eight()).to_string(),
        (ScalarKind::Sint, 4) => i32::from_le_bytes(four()).to_string(),
        (ScalarKind::Sint, _) => i64::from_le_bytes(eight()).to_string(),
        (ScalarKind::Uint, 4) => u32::from_le_bytes(four()).to_string(),
        (ScalarKind::Uint, _) => u64::from_le_bytes(eight()).to_string(),
        (ScalarKind::Bool, _) => (bytes.iter().any(|byte| *byte != 0)).to_string(),
    }
}

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
    fn fields_have_names_and_values_at_their_offsets() {
        let scalar = |kind| Scalar { kind, width: 4 };
        let member = |name: &str, offset, layout| umbragraph::low_level::shader::Member {
            name: name.to_owned(),
            offset,
            layout,
        };
        let vector = TypeLayout::Vector { components: 3, scalar: scalar(ScalarKind::Float) };
        let count = TypeLayout::Scalar { scalar: scalar(ScalarKind::Uint), atomic: false };
        let element = TypeLayout::Struct {
            name: "Entry".to_owned(),
            members: vec![member("place", 0, vector), member("count", 12, count.clone())],
            size: 16,
            align: 16,
        };
        let array = TypeLayout::Array { element: Box::new(element), count: None, stride: 16 };
        let layout = Layout { label: String::new(), offset: 4, layout: array };
        let mut bytes = vec![0; 4];
        for at in 0..2 {
            bytes.extend([1.5_f32, -2.0, at as f32].iter().flat_map(|one| one.to_le_bytes()));
            bytes.extend(7_u32.to_le_bytes());
        }
        let (found, has_more) = fields(&layout, &bytes);
        let words: Vec<_> = found.iter().map(|one| format!("{} {}", one.name, one.value)).collect();
        assert_eq!(words, ["[0].place (1.5, -2, 0)", "[0].count 7", "[1].place (1.5, -2, 1)", "[1].count 7"]);
        assert!(!has_more);
        let mut other = found.clone();
        other[3].value = "6".to_owned();
        assert_eq!(
            compared(found, &other),
            [Field { name: "[1].count".to_owned(), value: "6 → 7".to_owned() }]
        );
        let many = Layout { offset: 0, ..layout };
        assert!(fields(&many, &vec![0; 16 * MAX_FIELDS]).1);
        let short = Layout { layout: count, ..many };
        assert_eq!(fields(&short, &[0; 3]).0[0].value, "–");
    }
}
