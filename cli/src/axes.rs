//! The axes of templates, listed.

use std::fmt::Write as _;

use umbragraph::low_level::shader::{AxisMode, TemplateSet};

/// Returns the axes of the named templates as text: values, defaults, purposes and constraints.
pub(crate) fn human<'n>(templates: &TemplateSet, names: impl IntoIterator<Item = &'n String>) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for name in names {
        let Some(axes) = templates.axes(name) else { continue };
        let _ = writeln!(text, "{name}{}", if axes.is_empty() { ": no axes" } else { "" });
        for axis in axes.iter() {
            let mode = if axis.mode == AxisMode::Override { ", an override of the module" } else { "" };
            let ends = if axis.ends { ", proven by its ends and the default" } else { "" };
            let layout = if axis.own_layout { ", with layouts of their own" } else { "" };
            let from = if axis.from_target { ", true where the target has no -srgb" } else { "" };
            let values = axis.kind.describe();
            let (name, default) = (&axis.name, &axis.default);
            let _ = writeln!(text, "  {name}: {values} (default {default}){mode}{from}{ends}{layout}");
            if !axis.description.is_empty() {
                let _ = writeln!(text, "      {}", axis.description);
            }
        }
        for constraint in axes.constraints() {
            let _ = writeln!(text, "  constraint: {constraint}");
        }
    }
    text
}

/// Returns the axes of the named templates as JSON.
pub(crate) fn json<'n>(
    templates: &TemplateSet,
    names: impl IntoIterator<Item = &'n String>,
) -> serde_json::Value {
    let template = |name: &String| {
        let axes = templates.axes(name)?;
        let list: Vec<serde_json::Value> = axes
            .iter()
            .map(|axis| {
                serde_json::json!({
                    "name": axis.name,
                    "values": axis.kind.describe(),
                    "count": axis.kind.count(),
                    "default": axis.default,
                    "override": axis.mode == AxisMode::Override,
                    "ends": axis.ends,
                    "own_layout": axis.own_layout,
                    "from_target": axis.from_target,
                    "description": axis.description,
                })
            })
            .collect();
        let constraints: Vec<String> = axes.constraints().iter().map(ToString::to_string).collect();
        Some(serde_json::json!({ "template": name, "axes": list, "constraints": constraints }))
    };
    names.into_iter().filter_map(template).collect()
}
