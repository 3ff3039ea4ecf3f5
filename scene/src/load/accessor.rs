//! Typed reading of accessors.
//!
//! An accessor is a typed, strided look into a view, which is a range of a buffer; all of them are numbers from the
//! file. Every bound is checked once, with arithmetic that cannot overflow, before the first element is read, and what
//! will be decoded is charged to the budget before it is allocated. Any component type is widened to the wanted one;
//! normalized integers become fractions. Sparse accessors replace elements afterwards (glTF 2.0, section 3.6.2).

use gltf::json::accessor::{ComponentType, sparse};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Index, Root, buffer};

use super::report::Report;
use crate::codes;

/// A number type to which accessor components are decoded.
pub(super) trait Component: Copy + Default + Into<f64> {
    /// A description, for diagnostics, of the component types in the file that can be decoded to `Self`.
    const ACCEPTED: &'static str;
    /// Returns `true` if components of type `kind` in the file can be decoded to `Self`.
    fn accepts(kind: ComponentType) -> bool;
    /// Decodes the component at the start of `bytes`. Returns zero for too few bytes or for a type that is not
    /// accepted.
    fn decode(kind: ComponentType, normalized: bool, bytes: &[u8]) -> Self;
}

impl Component for f32 {
    const ACCEPTED: &'static str = "floats or small integers";

    fn accepts(kind: ComponentType) -> bool {
        kind != ComponentType::U32
    }

    fn decode(kind: ComponentType, normalized: bool, bytes: &[u8]) -> Self {
        let scaled = |value: f32, max: f32| if normalized { (value / max).max(-1.0) } else { value };
        match (kind, bytes) {
            (ComponentType::F32, [a, b, c, d, ..]) => f32::from_le_bytes([*a, *b, *c, *d]),
            (ComponentType::I8, [a, ..]) => scaled(f32::from(i8::from_le_bytes([*a])), 127.0),
            (ComponentType::U8, [a, ..]) => scaled(f32::from(*a), 255.0),
            (ComponentType::I16, [a, b, ..]) => scaled(f32::from(i16::from_le_bytes([*a, *b])), 32_767.0),
            (ComponentType::U16, [a, b, ..]) => scaled(f32::from(u16::from_le_bytes([*a, *b])), 65_535.0),
            _ => 0.0,
        }
    }
}

impl Component for u32 {
    const ACCEPTED: &'static str = "unsigned integers";

    fn accepts(kind: ComponentType) -> bool {
        matches!(kind, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
    }

    fn decode(kind: ComponentType, _: bool, bytes: &[u8]) -> Self {
        match (kind, bytes) {
            (ComponentType::U8, [a, ..]) => u32::from(*a),
            (ComponentType::U16, [a, b, ..]) => u32::from(u16::from_le_bytes([*a, *b])),
            (ComponentType::U32, [a, b, c, d, ..]) => u32::from_le_bytes([*a, *b, *c, *d]),
            _ => 0,
        }
    }
}

/// The accessors of a document, with the bytes of the buffers that accessors refer to.
pub(super) struct Accessors<'a> {
    pub(super) root: &'a Root,
    /// The bytes of each buffer; `None` for a buffer that is missing or too short.
    pub(super) buffers: &'a [Option<Vec<u8>>],
}

/// The bytes from the first element of an accessor on, and the stride in bytes. All elements lie inside the buffer
/// view.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl Accessors<'_> {
    /// Reads the elements of an accessor, with `N` components each. `at` is the JSON pointer of the property that
    /// references the accessor. Returns `None` after reporting an error.
    pub(super) fn read<T: Component, const N: usize>(
        &self,
        index: usize,
        at: &str,
        report: &mut Report,
    ) -> Option<Vec<[T; N]>> {
        let accessor = report.lookup(&self.root.accessors, index, "accessor", at)?;
        let (Checked::Valid(dimensions), Checked::Valid(component)) =
            (accessor.type_.as_ref(), accessor.component_type.as_ref())
        else {
            let message = format!("accessor {index} has a type or component type that glTF does not know");
            return report.reject(
                codes::WRONG_TYPE,
                at,
                message,
                "see the glTF 2.0 specification, section 3.6.2",
            );
        };
        let (dimensions, kind) = (*dimensions, component.0);
        let count = accessor.count.0;
        if dimensions.multiplicity() != N || !T::accepts(kind) || count == 0 {
            let name = serde_json::json!(dimensions);
            let name = name.as_str().unwrap_or_default();
            let message = format!("accessor {index} has {count} × {name} of {}", component_name(kind));
            let help = format!("wanted here: at least one element of {N} {}", T::ACCEPTED);
            return report.reject(codes::WRONG_TYPE, at, message, help);
        }
        if !report.charge(count.saturating_mul(4 * N as u64), at) {
            return None;
        }
        let size = N * kind.size();
        let decode = |bytes: &[u8]| -> [T; N] {
            std::array::from_fn(|part| T::decode(kind, accessor.normalized, &bytes[part * kind.size()..]))
        };
        let count = count as usize;
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default();
                let elements = self.elements(view, offset, count, size, true, at, report)?;
                (0..count).map(|element| decode(&elements.bytes[element * elements.stride..])).collect()
            }
            None => vec![[T::default(); N]; count],
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace(sparse, &mut values, size, decode, at, report)?;
        }
        Some(values)
    }

    fn replace<V>(
        &self,
        sparse: &sparse::Sparse,
        values: &mut [V],
        size: usize,
        decode: impl Fn(&[u8]) -> V,
        at: &str,
        report: &mut Report,
    ) -> Option<()> {
        let Checked::Valid(kind) = sparse.indices.component_type.as_ref() else {
            return report.reject(
                codes::WRONG_TYPE,
                at,
                "the sparse indices have an unknown component type",
                "use unsigned integers",
            );
        };
        let kind = kind.0;
        let count = sparse.count.0.min(values.len() as u64 + 1) as usize;
        let (at_indices, at_values) = (sparse.indices.byte_offset, sparse.values.byte_offset);
        let indices =
            self.elements(sparse.indices.buffer_view, at_indices, count, kind.size(), false, at, report)?;
        let replaced = self.elements(sparse.values.buffer_view, at_values, count, size, false, at, report)?;
        for element in 0..count {
            let index = u32::decode(kind, false, &indices.bytes[element * indices.stride..]);
            let Some(value) = values.get_mut(index as usize) else {
                let message =
                    format!("sparse index {index} is beyond the accessor's {} elements", values.len());
                return report.reject(codes::OUT_OF_BOUNDS, at, message, "export the file again");
            };
            *value = decode(&replaced.bytes[element * replaced.stride..]);
        }
        Some(())
    }

    /// The bytes of `count` elements of `size` bytes each in a buffer view, from byte `offset` on. With `strided`
    /// false, the stride of the view is ignored. Returns `None` after reporting an error.
    #[allow(clippy::too_many_arguments)]
    fn elements(
        &self,
        view: Index<buffer::View>,
        offset: USize64,
        count: usize,
        size: usize,
        strided: bool,
        at: &str,
        report: &mut Report,
    ) -> Option<Elements<'_>> {
        let bytes = self.view(view.value(), at, report)?;
        let stride = self.root.buffer_views[view.value()].byte_stride.as_ref().map_or(0, |stride| stride.0);
        let stride = if strided && stride != 0 { stride } else { size };
        let last = (count as u64).saturating_sub(1);
        let needed = last.saturating_mul(stride as u64).saturating_add(size as u64).saturating_add(offset.0);
        if stride < size || (count > 0 && needed > bytes.len() as u64) {
            let message = format!(
                "{count} elements of {size} bytes, {stride} bytes apart, from byte {} on do not fit buffer view {} of {} bytes",
                offset.0,
                view.value(),
                bytes.len(),
            );
            return report.reject(codes::OUT_OF_BOUNDS, at, message, "export the file again");
        }
        let bytes = if count == 0 { &[] } else { &bytes[offset.0 as usize..] };
        Some(Elements { bytes, stride })
    }

    /// The bytes of a buffer view. Returns `None` after reporting an error, or if the buffer itself could not be read.
    pub(super) fn view(&self, index: usize, at: &str, report: &mut Report) -> Option<&[u8]> {
        let view = report.lookup(&self.root.buffer_views, index, "bufferView", at)?;
        report.lookup(
            self.buffers,
            view.buffer.value(),
            "buffer",
            &format!("/bufferViews/{index}/buffer"),
        )?;
        // A buffer that is missing has been reported where it is declared.
        let bytes = self.buffers[view.buffer.value()].as_deref()?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.saturating_add(view.byte_length.0);
        let range = usize::try_from(start).ok()?..usize::try_from(end).ok()?;
        let found = bytes.get(range);
        if found.is_none() {
            report.error(
                codes::OUT_OF_BOUNDS,
                &format!("/bufferViews/{index}"),
                format!(
                    "bytes {start} to {end} are not inside buffer {} of {} bytes",
                    view.buffer.value(),
                    bytes.len()
                ),
                "export the file again",
            );
        }
        found
    }
}

fn component_name(kind: ComponentType) -> &'static str {
    match kind {
        ComponentType::I8 => "BYTE",
        ComponentType::U8 => "UNSIGNED_BYTE",
        ComponentType::I16 => "SHORT",
        ComponentType::U16 => "UNSIGNED_SHORT",
        ComponentType::U32 => "UNSIGNED_INT",
        ComponentType::F32 => "FLOAT",
    }
}
