//! Whether some variant of a template declares a binding, or a member of a binding's block.
//!
//! A pass names all that its variants bind, and one of them may have less than another. What none of them has is
//! misspelt. The variants are those that the given values allow, found as for their proof, and parsed only where their
//! text has the name. Those that differ in one axis from the first come first, then those that differ in two, and the
//! search ends at the first that declares it, so a name that is right is found soon.
//!
//! Limits: a text that does not parse is taken to declare every name in it, since its own diagnostic comes first; and
//! where there are more variants than [`super::explore`] takes, the others are taken to declare it.

use std::collections::BTreeMap;
use std::sync::Arc;

use naga::{Module, TypeInner};

use super::explore::Explorer;
use crate::axes::Space;
use crate::module::wgsl;
use crate::rendering::templates::TemplateSet;
use umbragraph_text::diagnostic::AxisValues;

/// The values with which some variant of a template in which these axes are `fixed` declares a binding, with a member of
/// that name where one is given; `None` if no variant does.
pub fn declares(
    templates: &TemplateSet,
    template: &str,
    fixed: &AxisValues,
    binding: &str,
    member: Option<&str>,
) -> Option<AxisValues> {
    let axes = templates.axes(template)?;
    let allowed: BTreeMap<_, _> =
        fixed.iter().map(|(name, value)| (name.clone(), vec![value.clone()])).collect();
    wgsl::with_stack(|| {
        let space = Arc::new(Space::new(axes, &allowed));
        let mut explorer = Explorer::new(templates, template, &space, false).nearest_first();
        while let Some(text) = explorer.next_text() {
            if text.contains(member.unwrap_or(binding))
                && wgsl::parse(&text).map_or(true, |module| has(&module, binding, member))
            {
                let exploration = &explorer.exploration;
                let leaf = exploration.texts.last().and_then(|text| exploration.leaves.get(text.leaf));
                return Some(leaf.map(|leaf| AxisValues::clone(&leaf.decided)).unwrap_or_default());
            }
        }
        (!explorer.exploration.complete).then(AxisValues::new)
    })
}

fn has(module: &Module, binding: &str, member: Option<&str>) -> bool {
    module
        .global_variables
        .iter()
        .filter(|(_, variable)| variable.binding.is_some() && variable.name.as_deref() == Some(binding))
        .any(|(_, variable)| match (member, &module.types[variable.ty].inner) {
            (None, _) => true,
            (Some(name), TypeInner::Struct { members, .. }) => {
                members.iter().any(|member| member.name.as_deref() == Some(name))
            }
            (Some(_), _) => false,
        })
}
