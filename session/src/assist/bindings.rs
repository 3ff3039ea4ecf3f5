//! Bindings of passes: keys under `bind`, and the declarations in WGSL that they mean.
//!
//! Two keys mean the same binding if the shaders of their passes declare it at the same place of a template.
//!
//! Limits: a pass without a plan has the variant of default values; what only other variants declare is not found.

use super::context::{Context, PassAt};
use super::expected::declared_in;
use super::site::Spot;
use crate::graph::document::Value;
use crate::graph::language::node_kind;
use crate::graph::model::DeclarationKind;
use crate::graph::source::Span;

/// Returns the name of the binding whose key is at the cursor, and the place of its declaration in a template. `None`
/// if no such key is there, or if the shader of the pass does not declare it.
pub(super) fn declared_at<'a>(context: &Context<'a>) -> Option<(&'a str, Span)> {
    let site = context.site();
    let position = context.position(&site);
    match (site.spot, position.way.as_slice()) {
        (Spot::Key { entry: Some(entry), .. }, ["passes" | "shared_settings", .., "bind"]) => {
            let place = declared_by(context, &context.pass(&position)?, &entry.key)?;
            Some((&entry.key, place))
        }
        _ => None,
    }
}

/// Returns the declaration of the binding at the cursor, and the keys of all passes that bind it. Empty if no binding
/// is there.
pub(super) fn references<'a>(context: &Context<'a>) -> Vec<Span> {
    let Some((name, declared)) = declared_at(context) else { return Vec::new() };
    let passes = context.model.declarations().filter(|(_, one)| one.kind == DeclarationKind::Pass);
    let keys = passes.filter_map(|(id, one)| {
        let pass = PassAt { id, pointer: &one.pointer, value: context.value_of(one)? };
        let bound = node_kind(pass.value)?.value.get("bind").and_then(|bind: &Value| bind.entry(name))?;
        (declared_by(context, &pass, name)? == declared).then_some(bound.key_span)
    });
    // Passes that take over shared settings have one key.
    let keys: std::collections::BTreeSet<Span> = keys.collect();
    [declared].into_iter().chain(keys).collect()
}

/// Returns the place in a template of the declaration of a binding of a pass.
fn declared_by<'a>(context: &Context<'a>, pass: &PassAt<'a>, name: &str) -> Option<Span> {
    context.modules(pass).iter().find_map(|module| declared_in(module, name))
}
