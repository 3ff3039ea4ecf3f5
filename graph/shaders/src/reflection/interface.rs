//! The interface of a pass: the union over its variants.
//!
//! A pass has one bind-group layout for all of its variants, so that switching a feature changes a pipeline and nothing
//! else. Two variants may use different bindings; where both use one, they have to mean the same: name, type and
//! access. Visibility and minimum sizes are united, and a texture that one variant filters is filterable.

use std::collections::BTreeMap;

use wgpu_types::{BindingType, TextureSampleType};

use super::{Binding, Reflection};

/// A disagreement between two shader variants of a pass that declare one binding differently.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InterfaceConflict {
    /// The index of the variant that declared the binding first, in the order passed to [`unite`].
    pub first: usize,
    /// The index of the variant that contradicts the first one, in the order passed to [`unite`].
    pub second: usize,
    /// The name of the WGSL variable in the first variant.
    pub first_name: String,
    /// The name of the WGSL variable in the second variant.
    pub name: String,
    /// The message about the difference: name, group and index, type, or access of the binding.
    pub message: String,
}

/// Merges the bindings of all variants into one list, sorted by group and binding. Also returns all disagreements
/// between variants.
pub fn unite<'a>(
    variants: impl IntoIterator<Item = &'a Reflection>,
) -> (Vec<Binding>, Vec<InterfaceConflict>) {
    let mut united: BTreeMap<(u32, u32), (usize, Binding)> = BTreeMap::new();
    let mut names: BTreeMap<&str, (usize, (u32, u32))> = BTreeMap::new();
    let mut conflicts = Vec::new();
    for (variant, reflection) in variants.into_iter().enumerate() {
        for binding in &reflection.bindings {
            let place = (binding.group, binding.binding);
            let mut disagree = |first: usize, first_name: &str, message: String| {
                conflicts.push(InterfaceConflict {
                    first,
                    second: variant,
                    first_name: first_name.to_owned(),
                    name: binding.name.clone(),
                    message,
                });
            };
            let (known_variant, known_place) = *names.entry(&binding.name).or_insert((variant, place));
            if known_place != place {
                disagree(
                    known_variant,
                    &binding.name,
                    format!(
                        "\"{}\" is @group({}) @binding({}) in one and @group({}) @binding({}) in the other",
                        binding.name, known_place.0, known_place.1, place.0, place.1
                    ),
                );
                continue;
            }
            match united.get_mut(&place) {
                None => {
                    united.insert(place, (variant, binding.clone()));
                }
                Some((first, known)) => {
                    if let Err(message) = merge(known, binding) {
                        disagree(*first, &known.name, message);
                    }
                }
            }
        }
    }
    (united.into_values().map(|(_, binding)| binding).collect(), conflicts)
}

/// Returns `true` if two bindings have the same group, index and name, and compatible types.
pub(crate) fn agree(one: &Binding, other: &Binding) -> bool {
    (one.group, one.binding) == (other.group, other.binding) && merge(&mut one.clone(), other).is_ok()
}

/// Returns the type name without array lengths, since buffers of different lengths have compatible layouts.
fn of_any_length(name: &str) -> String {
    let is_length = |part: &str| part.starts_with(|first: char| first.is_ascii_digit());
    name.split(", ").filter(|part| !is_length(part)).collect::<Vec<_>>().join(", ")
}

fn merge(known: &mut Binding, other: &Binding) -> Result<(), String> {
    let place = format!("@group({}) @binding({})", other.group, other.binding);
    if known.name != other.name {
        return Err(format!("{place} is \"{}\" in one and \"{}\" in the other", known.name, other.name));
    }
    let (one, two) = (&known.type_name, &other.type_name);
    let is_buffer = known.block.is_some() && other.block.is_some();
    let alike = if is_buffer { of_any_length(one) == of_any_length(two) } else { one == two };
    if !alike || known.entry.count != other.entry.count {
        return Err(format!("\"{}\" is a {one} in one and a {two} in the other", other.name));
    }
    match (&mut known.entry.ty, &other.entry.ty) {
        (
            BindingType::Buffer { ty: one, min_binding_size: size, .. },
            BindingType::Buffer { ty: two, min_binding_size: other_size, .. },
        ) if one == two => *size = (*size).max(*other_size),
        (
            BindingType::Texture { sample_type: TextureSampleType::Float { filterable }, .. },
            BindingType::Texture { sample_type: TextureSampleType::Float { filterable: too }, .. },
        ) => *filterable |= too,
        (one, two) if one == two => {}
        _ => return Err(format!("\"{}\" is accessed in different ways", other.name)),
    }
    known.entry.visibility |= other.entry.visibility;
    Ok(())
}
