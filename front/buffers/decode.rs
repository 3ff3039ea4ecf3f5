//! Bytes of a buffer, decoded by the layout of a type.

use half::f16;
use serde_json::{Map, Value};

use super::Layout;
use crate::low_level::shader::{Member, Scalar, ScalarKind, TypeLayout};

/// The maximum number of fields that [`fields`] returns.
pub const MAX_FIELDS: usize = 4096;

/// A scalar, vector or matrix in a buffer: the path to it, such as `[0].count`, and its value as text.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The path to the field, such as `[0].count`.
    pub name: String,
    /// The value as text; a dash beyond the end of the bytes.
    pub value: String,
}

/// The contents of a buffer as JSON.
#[derive(Clone, Debug, PartialEq)]
pub struct Contents {
    /// Structures as objects; arrays, vectors and the columns of matrices as lists. Numbers that JSON lacks are the
    /// strings `NaN`, `inf` and `-inf`; what lies beyond the end of the bytes is null.
    pub value: Value,
    /// The number of elements of arrays that were left out.
    pub left_out: usize,
}

/// An array as a table: a row for each element, and a column for each scalar of an element.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The names of the columns, such as `position.x`.
    pub columns: Vec<String>,
    /// The values as text, row by row.
    pub rows: Vec<Vec<String>>,
    /// The number of elements that were left out.
    pub left_out: usize,
}

/// Decodes the bytes of a buffer into fields. The flag is `true` if there are more than [`MAX_FIELDS`].
pub fn fields(layout: &Layout, bytes: &[u8]) -> (Vec<Field>, bool) {
    let mut fields = Vec::new();
    let has_more = add(&layout.layout, "", 0, layout.bound(bytes), &mut fields);
    (fields, has_more)
}

/// Decodes the bytes of a buffer as JSON, at most about `max_numbers` scalars of them: elements of arrays that come
/// after as many are left out.
pub fn contents(layout: &Layout, bytes: &[u8], max_numbers: usize) -> Contents {
    let mut decoder = Decoder { bytes: layout.bound(bytes), numbers: max_numbers, left_out: 0 };
    let value = decoder.value(&layout.layout, 0);
    Contents { value, left_out: decoder.left_out }
}

/// Decodes the bytes of a buffer as a table, at most `max_numbers` scalars of them. `None` unless the type is an
/// array, or a structure with an array alone, whose elements all have the same fixed size.
pub fn table(layout: &Layout, bytes: &[u8], max_numbers: usize) -> Option<Table> {
    let bytes = layout.bound(bytes);
    let (mut layout, mut start) = (&layout.layout, 0);
    while let TypeLayout::Struct { members, .. } = layout {
        let [member] = members.as_slice() else { return None };
        (layout, start) = (&member.layout, start + member.offset as usize);
    }
    let TypeLayout::Array { element, count, stride } = layout else { return None };
    let mut columns = Vec::new();
    add_columns(element, "", 0, &mut columns)?;
    let stride = *stride as usize;
    let all = count.map_or(bytes.len().saturating_sub(start) / stride.max(1), |count| count as usize);
    let shown = all.min(max_numbers / columns.len().max(1));
    let row = |index: usize| {
        let at = start + index * stride;
        columns.iter().map(|(_, offset, scalar)| number(bytes, at + offset, scalar)).collect()
    };
    let rows = (0..shown).map(row).collect();
    let columns = columns.iter().map(|(name, ..)| name.clone()).collect();
    Some(Table { columns, rows, left_out: all - shown })
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
            return (0..length(*count, *stride, at, bytes)).any(|index| {
                add(element, &format!("{path}[{index}]"), at + index * *stride as usize, bytes, fields)
            });
        }
        TypeLayout::Struct { members, .. } => {
            return members.iter().any(|member| {
                let path = joined(path, &member.name);
                add(&member.layout, &path, at + member.offset as usize, bytes, fields)
            });
        }
    };
    fields.push(Field { name: path.to_owned(), value });
    false
}

/// Adds the scalars of a type with their names and byte offsets; `None` if the type has an array without a fixed
/// length, or too many scalars for columns.
fn add_columns(
    layout: &TypeLayout,
    path: &str,
    at: usize,
    columns: &mut Vec<(String, usize, Scalar)>,
) -> Option<()> {
    if columns.len() > MAX_FIELDS {
        return None;
    }
    let name = if path.is_empty() { "value" } else { path };
    let mut vector = |name: &str, at: usize, components: u32, scalar: &Scalar| {
        let named = ["x", "y", "z", "w"].into_iter().zip(0..components);
        columns.extend(
            named.map(|(one, index)| (joined(name, one), at + (index * scalar.width) as usize, *scalar)),
        );
    };
    match layout {
        TypeLayout::Scalar { scalar, .. } => columns.push((name.to_owned(), at, *scalar)),
        TypeLayout::Vector { components, scalar } => vector(path, at, *components, scalar),
        TypeLayout::Matrix { columns: count, rows, scalar, stride } => (0..*count).for_each(|column| {
            vector(&format!("{path}[{column}]"), at + (column * stride) as usize, *rows, scalar);
        }),
        TypeLayout::Array { element, count, stride } => {
            for index in 0..(*count)? {
                add_columns(element, &format!("{path}[{index}]"), at + (index * stride) as usize, columns)?;
            }
        }
        TypeLayout::Struct { members, .. } => {
            for member in members {
                let path = joined(path, &member.name);
                add_columns(&member.layout, &path, at + member.offset as usize, columns)?;
            }
        }
    }
    Some(())
}

/// The path to a member of the structure or vector at `path`.
fn joined(path: &str, member: &str) -> String {
    let dot = if path.is_empty() { "" } else { "." };
    format!("{path}{dot}{member}")
}

/// The number of elements of an array at the byte offset `at`; without a fixed length, as many as are left.
fn length(count: Option<u32>, stride: u32, at: usize, bytes: &[u8]) -> usize {
    count.map_or(bytes.len().saturating_sub(at) / stride.max(1) as usize, |count| count as usize)
}

struct Decoder<'b> {
    bytes: &'b [u8],
    /// The number of scalars that may still be decoded.
    numbers: usize,
    left_out: usize,
}

impl Decoder<'_> {
    fn value(&mut self, layout: &TypeLayout, at: usize) -> Value {
        match layout {
            TypeLayout::Scalar { scalar, .. } => self.number(at, scalar),
            TypeLayout::Vector { components, scalar } => self.vector(at, *components, scalar),
            TypeLayout::Matrix { columns, rows, scalar, stride } => (0..*columns)
                .map(|column| self.vector(at + (column * stride) as usize, *rows, scalar))
                .collect(),
            TypeLayout::Array { element, count, stride } => {
                let length = length(*count, *stride, at, self.bytes);
                let mut values = Vec::new();
                while values.len() < length && self.numbers > 0 {
                    values.push(self.value(element, at + values.len() * *stride as usize));
                }
                self.left_out += length - values.len();
                Value::Array(values)
            }
            TypeLayout::Struct { members, .. } => {
                let member = |member: &Member| {
                    (member.name.clone(), self.value(&member.layout, at + member.offset as usize))
                };
                Value::Object(members.iter().map(member).collect::<Map<_, _>>())
            }
        }
    }

    fn vector(&mut self, at: usize, components: u32, scalar: &Scalar) -> Value {
        (0..components).map(|one| self.number(at + (one * scalar.width) as usize, scalar)).collect()
    }

    fn number(&mut self, at: usize, scalar: &Scalar) -> Value {
        self.numbers = self.numbers.saturating_sub(1);
        match number(self.bytes, at, scalar) {
            text if text == BEYOND => Value::Null,
            // The shortest decimal of a number, as it is printed; words are no JSON.
            text => serde_json::from_str(&text).unwrap_or(Value::String(text)),
        }
    }
}

/// The text in place of a number beyond the end of the bytes.
const BEYOND: &str = "–";

/// The number at the byte offset `at` as text; [`BEYOND`] beyond the end of the bytes.
fn number(bytes: &[u8], at: usize, scalar: &Scalar) -> String {
    let Some(bytes) = bytes.get(at..at + scalar.width as usize) else { return BEYOND.to_owned() };
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

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn scalar(kind: ScalarKind) -> Scalar {
        Scalar { kind, width: 4 }
    }

    /// An array of a structure with a vector `place` and a number `count`, from byte 4 on.
    fn entries() -> Layout {
        let member = |name: &str, offset, layout| Member { name: name.to_owned(), offset, layout };
        let vector = TypeLayout::Vector { components: 3, scalar: scalar(ScalarKind::Float) };
        let count = TypeLayout::Scalar { scalar: scalar(ScalarKind::Uint), atomic: false };
        let element = TypeLayout::Struct {
            name: "Entry".to_owned(),
            members: vec![member("place", 0, vector), member("count", 12, count)],
            size: 16,
            align: 16,
        };
        let array = TypeLayout::Array { element: Box::new(element), count: None, stride: 16 };
        Layout::new(array, (4, None), vec!["fill".to_owned()])
    }

    fn bytes(last: f32) -> Vec<u8> {
        let mut bytes = vec![0; 4];
        for at in [0.0, last] {
            bytes.extend([1.5_f32, -2.0, at].iter().flat_map(|one| one.to_le_bytes()));
            bytes.extend(7_u32.to_le_bytes());
        }
        bytes
    }

    #[test]
    fn fields_have_names_and_values_at_their_offsets() {
        let (found, has_more) = fields(&entries(), &bytes(1.0));
        let words: Vec<_> = found.iter().map(|one| format!("{} {}", one.name, one.value)).collect();
        assert_eq!(words, ["[0].place (1.5, -2, 0)", "[0].count 7", "[1].place (1.5, -2, 1)", "[1].count 7"]);
        assert!(!has_more);
        let many = Layout { bytes: (0, None), ..entries() };
        assert!(fields(&many, &vec![0; 16 * MAX_FIELDS]).1);
        let count = TypeLayout::Scalar { scalar: scalar(ScalarKind::Uint), atomic: false };
        let short = Layout::new(count, (0, None), Vec::new());
        assert_eq!(fields(&short, &[0; 3]).0[0].value, "–");
        assert_eq!(contents(&short, &[0; 3], 8).value, Value::Null);
    }

    #[test]
    fn json_keeps_the_structure_and_names_what_is_left_out() {
        let found = contents(&entries(), &bytes(f32::NAN), 100);
        let expected = json!([
            { "place": [1.5, -2, 0], "count": 7 }, { "place": [1.5, -2, "NaN"], "count": 7 }
        ]);
        assert_eq!(found, Contents { value: expected, left_out: 0 });
        let found = contents(&entries(), &bytes(1.0), 4);
        assert_eq!((found.value.as_array().map(Vec::len), found.left_out), (Some(1), 1));
        assert_eq!(contents(&entries(), &[0; 4], 4).value, json!([]));
    }

    #[test]
    fn a_table_has_a_column_for_each_number() {
        let found = table(&entries(), &bytes(0.1), 100).unwrap();
        assert_eq!(found.columns, ["place.x", "place.y", "place.z", "count"]);
        assert_eq!(found.rows, [["1.5", "-2", "0", "7"], ["1.5", "-2", "0.1", "7"]]);
        assert_eq!(table(&entries(), &bytes(0.1), 4).map(|table| table.left_out), Some(1));
        let end = Layout { bytes: (4, Some(20)), ..entries() };
        assert_eq!(
            table(&end, &bytes(0.1), 100).map(|table| table.rows.len()),
            Some(1),
            "one element is bound"
        );
    }
}
