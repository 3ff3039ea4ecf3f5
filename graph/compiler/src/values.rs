//! Blocks of expression values, packed to the bytes that a shader expects.

use serde::Serialize;

use super::size::Sizes;
use crate::data::{Component, ValueType};
use crate::diagnostic::{Diagnostic, codes};
use crate::expression::Value;
use crate::pipeline::{Located as _, element_type, member_runs, whole_number};
use crate::shader::{Member, TypeLayout};
use crate::work::Deferred;

/// The bytes of one block.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PackedBlock {
    /// The bind group.
    pub group: u32,
    /// The binding in it.
    pub binding: u32,
    /// The bytes.
    pub bytes: Vec<u8>,
}

/// Packs the values of a block's members.
pub(super) fn pack(
    layout: &TypeLayout,
    values: &[(String, Deferred)],
    sizes: &Sizes<'_>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Vec<u8>> {
    let TypeLayout::Struct { members, .. } = layout else { return None };
    let mut bytes = vec![0; layout.size() as usize];
    let mut fine = true;
    for member in members {
        let Some((_, deferred)) = values.iter().find(|(name, _)| *name == member.name) else { continue };
        let Some(value) = sizes.value(deferred) else {
            fine = false;
            continue;
        };
        if let Err(message) =
            pack_member(member, &value, (&mut Packing::default(), &mut Vec::new()), &mut bytes)
        {
            fine = false;
            let help = format!("the shader declares \"{}\" as {}", member.name, member.layout.spelling());
            diagnostics.push(deferred.error(codes::EXPRESSION_TYPE, message).help(help));
        }
    }
    fine.then_some(bytes)
}

/// Packs the value of one member; `packing` is where the value before went, and `numbers` memory that is used again.
pub(super) fn pack_member(
    member: &Member,
    value: &Value,
    (packing, numbers): (&mut Packing, &mut Vec<f64>),
    bytes: &mut [u8],
) -> Result<(), String> {
    numbers.clear();
    flatten(value, numbers)?;
    if packing.count != numbers.len() || packing.runs.is_empty() {
        *packing = Packing::new(member, numbers.len())?;
    }
    let end = packing.runs.iter().map(|(_, length, offset)| offset + length * 4).max().unwrap_or(0);
    if end as usize > bytes.len() {
        return Err(format!("\"{}\" has no room for {} numbers", member.name, numbers.len()));
    }
    for (word, length, offset) in &packing.runs {
        for at in 0..*length {
            let number = numbers[(word + at) as usize];
            let bits = to_word(number, packing.component)
                .ok_or_else(|| format!("{number} is no {} for \"{}\"", packing.component, member.name))?;
            let start = (offset + at * 4) as usize;
            bytes[start..start + 4].copy_from_slice(&bits.to_le_bytes());
        }
    }
    Ok(())
}

/// Where the numbers of a member go in its block.
#[derive(Clone, Debug)]
pub(super) struct Packing {
    /// The number of numbers.
    count: usize,
    component: Component,
    /// The first number, how many, and the byte of the first.
    runs: Vec<(u32, u32, u32)>,
}

impl Default for Packing {
    fn default() -> Self {
        Self { count: 0, component: Component::F32, runs: Vec::new() }
    }
}

impl Packing {
    fn new(member: &Member, count: usize) -> Result<Self, String> {
        let element = match &member.layout {
            TypeLayout::Array { element, .. } => element_type(element),
            other => element_type(other),
        };
        let Some(element) = element else {
            return Err(format!("\"{}\" is of a type that values cannot fill", member.name));
        };
        let per_element = element.element_words();
        let whole = match &member.layout {
            TypeLayout::Array { .. } => {
                count.is_multiple_of(per_element).then(|| element.array((count / per_element) as u32))
            }
            _ => (count == per_element).then_some(element),
        };
        let scalars = ValueType::vector(element.component, 1).array(count as u32);
        let runs = whole
            .and_then(|own| member_runs(&member.layout, own, member.offset))
            .or_else(|| member_runs(&member.layout, scalars, member.offset))
            .ok_or_else(|| format!("\"{}\" is given {count} numbers", member.name))?;
        Ok(Self { count, component: element.component, runs })
    }
}

/// The bits of a number, if it is one of the component's.
pub(super) fn to_word(number: f64, component: Component) -> Option<u32> {
    match component {
        Component::F32 => (number.abs() <= f64::from(f32::MAX)).then(|| (number as f32).to_bits()),
        Component::U32 => whole_number(&Value::Number(number), 0..=u32::MAX),
        Component::I32 => {
            let range = f64::from(i32::MIN)..=f64::from(i32::MAX);
            (number.fract() == 0.0 && range.contains(&number)).then(|| (number as i32).cast_unsigned())
        }
    }
}

fn flatten(value: &Value, numbers: &mut Vec<f64>) -> Result<(), String> {
    match value {
        Value::Number(number) => numbers.push(*number),
        Value::Bool(value) => numbers.push(f64::from(u8::from(*value))),
        Value::List(list) => list.iter().try_for_each(|value| flatten(value, numbers))?,
        Value::Text(text) => return Err(format!("a number is wanted here, this is the text \"{text}\"")),
        Value::Reference(_) => return Err(format!("a number is wanted here, this is {}", value.kind_name())),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_component_holds_whole_numbers_of_its_range_or_any_that_a_float_reaches() {
        let words = |component, numbers: [f64; 5]| numbers.map(|number| to_word(number, component));
        let min = f64::from(i32::MIN);
        assert_eq!(
            words(Component::I32, [-3.0, 1.5, min, min - 1.0, -min]),
            [Some((-3i32).cast_unsigned()), None, Some(1 << 31), None, None]
        );
        let max = f64::from(u32::MAX);
        assert_eq!(
            words(Component::U32, [3.0, 1.5, -1.0, max, max + 1.0]),
            [Some(3), None, None, Some(u32::MAX), None]
        );
        let max = f64::from(f32::MAX);
        assert_eq!(
            words(Component::F32, [1.5, -max, max, 2.0 * max, f64::NAN]),
            [Some(1.5f32.to_bits()), Some(f32::MIN.to_bits()), Some(f32::MAX.to_bits()), None, None]
        );
    }
}
