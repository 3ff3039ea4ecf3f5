//! Blocks of expression values, packed to the bytes that a shader expects.

use serde::Serialize;

use crate::resources::size::Sizes;
use crate::values::settings::{Bound, PlannedSetting};
use umbragraph_pipeline::data::{Component, ValueType};
use umbragraph_pipeline::diagnostic::{Diagnostic, Place, codes};
use umbragraph_pipeline::expression::Value;
use umbragraph_pipeline::pipeline::{element_type, member_runs, whole_number};
use umbragraph_pipeline::shader::{Member, TypeLayout};
use umbragraph_pipeline::work::{BlockValues, Live};

/// The contents of one constant block (a uniform buffer of expression values) that a pass binds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PackedBlock {
    /// The bind group index of the block.
    pub group: u32,
    /// The binding index of the block within the bind group.
    pub binding: u32,
    /// The contents of the block, in the memory layout that the shader declares.
    pub bytes: Vec<u8>,
}

/// Packs the values of a block's members into bytes; `None` after a diagnostic. Each live setting that feeds a member
/// is bound to it; `position` is the index of the block in its pass.
pub(crate) fn pack(
    block: &BlockValues,
    position: usize,
    sizes: &Sizes<'_>,
    live: &mut [PlannedSetting],
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Vec<u8>> {
    let TypeLayout::Struct { members, .. } = &block.layout else { return None };
    let (mut bytes, mut numbers) = (vec![0; block.layout.size() as usize], Vec::new());
    let mut fine = true;
    for member in members {
        let mut expressions = block.expressions.iter();
        let Some((_, Live { value: deferred, setting })) = expressions.find(|(name, _)| *name == member.name)
        else {
            continue;
        };
        let Some(value) = sizes.value(deferred) else {
            fine = false;
            continue;
        };
        let packed = Packing::new(member, 0).pack(&value, &mut numbers, &mut bytes);
        if let Err(diagnostic) = packed {
            fine = false;
            diagnostics.push(diagnostic.at(deferred.place, &deferred.pointer));
        } else if let Some(setting) = setting.and_then(|at| live.get_mut(at)) {
            setting.bound = Bound::Member(position, Packing::new(member, numbers.len()));
        }
    }
    fine.then_some(bytes)
}

/// The byte layout by which `count` numbers are packed into one member of a block.
#[derive(Clone, Debug)]
pub(crate) struct Packing {
    member: Member,
    count: usize,
    runs: Result<Runs, String>,
}

/// The component type, and runs of consecutive numbers: index of the first number, count, and byte offset in the block.
type Runs = (Component, Vec<(u32, u32, u32)>);

impl Packing {
    fn new(member: &Member, count: usize) -> Self {
        Self { member: member.clone(), count, runs: runs(member, count) }
    }

    /// Packs a value into the bytes of a block. `numbers` is scratch memory, which avoids an allocation for each value.
    pub(crate) fn pack(
        &self,
        value: &Value,
        numbers: &mut Vec<f64>,
        bytes: &mut [u8],
    ) -> Result<(), Diagnostic> {
        numbers.clear();
        let member = &self.member;
        let packed = flatten(value, numbers).and_then(|()| {
            if self.count == numbers.len() {
                return self.write(numbers, bytes);
            }
            Self::new(member, numbers.len()).write(numbers, bytes)
        });
        packed.map_err(|message| {
            let help = format!("the shader declares \"{}\" as {}", member.name, member.layout.spelling());
            Diagnostic::error(codes::EXPRESSION_TYPE, Place::Nowhere, message).help(help)
        })
    }

    fn write(&self, numbers: &[f64], bytes: &mut [u8]) -> Result<(), String> {
        let (component, runs) = self.runs.as_ref().map_err(String::clone)?;
        let name = &self.member.name;
        let end = runs.iter().map(|(_, length, offset)| offset + length * 4).max().unwrap_or(0);
        if end as usize > bytes.len() {
            return Err(format!("\"{name}\" has no room for {} numbers", numbers.len()));
        }
        for (word, length, offset) in runs {
            for at in 0..*length {
                let number = numbers[(word + at) as usize];
                let bits = to_word(number, *component)
                    .ok_or_else(|| format!("{number} is no {component} for \"{name}\""))?;
                let start = (offset + at * 4) as usize;
                bytes[start..start + 4].copy_from_slice(&bits.to_le_bytes());
            }
        }
        Ok(())
    }
}

/// Returns the component type of a member and the runs that place `count` numbers in it. The error is a message for the
/// user.
fn runs(member: &Member, count: usize) -> Result<Runs, String> {
    let (array, element) = match &member.layout {
        TypeLayout::Array { element, .. } => (true, element_type(element)),
        other => (false, element_type(other)),
    };
    let Some(element) = element else {
        return Err(format!("\"{}\" is of a type that values cannot fill", member.name));
    };
    let per_element = element.element_words();
    let whole = match array {
        true => count.is_multiple_of(per_element).then(|| element.array((count / per_element) as u32)),
        false => (count == per_element).then_some(element),
    };
    let scalars = ValueType::vector(element.component, 1).array(count as u32);
    let runs = whole
        .and_then(|own| member_runs(&member.layout, own, member.offset))
        .or_else(|| member_runs(&member.layout, scalars, member.offset))
        .ok_or_else(|| format!("\"{}\" is given {count} numbers", member.name))?;
    Ok((element.component, runs))
}

/// Returns the 32-bit pattern of a number as `component`. `None` if it is out of range, or not whole for an integer
/// component.
pub(crate) fn to_word(number: f64, component: Component) -> Option<u32> {
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
    fn integers_take_their_range_and_floats_any_finite_number() {
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
