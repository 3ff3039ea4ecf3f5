//! Contents of a buffer, as the shaders that bind it declare them: fields, rows of a table, and JSON.
//!
//! Shaders may declare one buffer in several ways; each is a [`Layout`]. A buffer that no shader binds is shown as
//! numbers of 32 bits: `f32` if a pass reads it as vertices, otherwise `u32`.

mod decode;

pub use decode::{Contents, Field, MAX_FIELDS, Table, contents, fields, table};

use crate::Plan;
use crate::low_level::pipeline::{IndexRange, ResourceKind, Usage, is_of};
use crate::low_level::shader::{Scalar, ScalarKind, TypeLayout};
use crate::work::SlotSource;

/// A memory layout with which a shader declares a buffer.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// The type in WGSL, followed by the byte offset of the binding if it is not 0.
    pub label: String,
    /// The names of the passes whose shaders declare the buffer so, in the order of the plan; empty if no shader binds
    /// the buffer.
    pub passes: Vec<String>,
    /// The offset of the first byte that is bound, and of the first byte after it; `None` for the end of the buffer.
    bytes: (u64, Option<u64>),
    layout: TypeLayout,
}

/// The size of a buffer in bytes; `None` if the resource is not a buffer or no live pass uses it.
pub fn size_of(plan: &Plan, name: &str) -> Option<u64> {
    let resource = plan.resources.get(name)?;
    matches!(plan.pipeline.resource(resource.handle).kind, ResourceKind::Buffer(_)).then_some(resource.bytes)
}

/// The layouts with which shaders declare a buffer, in the order of the plan. One array of `f32` or `u32` if no shader
/// binds the buffer; empty if the plan has no such resource.
pub fn layouts(plan: &Plan, name: &str) -> Vec<Layout> {
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
            let bytes = (buffer.offset(), buffer.range.bytes.map(IndexRange::end));
            match layouts.iter_mut().find(|known| known.bytes == bytes && known.layout == layout) {
                Some(known) if known.passes.contains(&pass.name) => {}
                Some(known) => known.passes.push(pass.name.clone()),
                None => layouts.push(Layout::new(layout, bytes, vec![pass.name.clone()])),
            }
        }
    }
    if layouts.is_empty() {
        let mut accesses =
            plan.passes.iter().flat_map(|pass| plan.pipeline.pass(pass.handle).accesses().iter());
        let has_vertices =
            accesses.any(|one| one.resource == resource.handle && matches!(one.usage, Usage::Vertex));
        let kind = if has_vertices { ScalarKind::Float } else { ScalarKind::Uint };
        let word = TypeLayout::Scalar { scalar: Scalar { kind, width: 4 }, atomic: false };
        let layout = TypeLayout::Array { element: Box::new(word), count: None, stride: 4 };
        layouts.push(Layout::new(layout, (0, None), Vec::new()));
    }
    layouts
}

/// Chooses the layout in which the contents of a buffer are written: that of the pass `by` if its shader binds the
/// buffer, otherwise the first with a structure, otherwise the first. `None` for an empty list.
pub fn choose<'l>(layouts: &'l [Layout], by: Option<&str>) -> Option<&'l Layout> {
    let is_by = |layout: &&Layout| by.is_some_and(|by| layout.passes.iter().any(|pass| is_of(pass, by)));
    let is_structured = |layout: &&Layout| has_structure(&layout.layout);
    layouts.iter().find(is_by).or_else(|| layouts.iter().find(is_structured)).or_else(|| layouts.first())
}

/// Returns `true` if the type is a structure, or an array of them.
fn has_structure(layout: &TypeLayout) -> bool {
    match layout {
        TypeLayout::Struct { .. } => true,
        TypeLayout::Array { element, .. } => has_structure(element),
        _ => false,
    }
}

impl Layout {
    fn new(layout: TypeLayout, bytes: (u64, Option<u64>), passes: Vec<String>) -> Self {
        let from = if bytes.0 == 0 { String::new() } else { format!(" from byte {}", bytes.0) };
        Self { label: layout.spelling() + &from, passes, bytes, layout }
    }

    /// The bytes that are bound.
    fn bound<'b>(&self, bytes: &'b [u8]) -> &'b [u8] {
        let at = |offset: u64| usize::try_from(offset).unwrap_or(usize::MAX).min(bytes.len());
        let (first, end) = (at(self.bytes.0), self.bytes.1.map_or(bytes.len(), at));
        bytes.get(first..end).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pass_of_a_version_chooses_the_layout() {
        let word = TypeLayout::Scalar { scalar: Scalar { kind: ScalarKind::Uint, width: 4 }, atomic: false };
        let entry = TypeLayout::Struct { name: "Entry".to_owned(), members: Vec::new(), size: 4, align: 4 };
        let array = |element| TypeLayout::Array { element: Box::new(element), count: None, stride: 4 };
        let layouts = [
            Layout::new(array(word), (0, None), vec!["clear".to_owned()]),
            Layout::new(array(entry), (4, None), vec!["fill".to_owned()]),
        ];
        let label = |by| choose(&layouts, by).map(|layout| layout.label.as_str());
        assert_eq!(label(Some("clear")), Some("array<u32>"));
        assert_eq!(label(None), Some("array<Entry> from byte 4"));
        assert_eq!(label(Some("other")), Some("array<Entry> from byte 4"));
        assert_eq!(choose(&[], None), None);
    }
}
