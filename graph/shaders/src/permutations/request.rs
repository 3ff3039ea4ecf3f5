//! A template that is to be proven, and the space of its configurations.

use std::collections::BTreeMap;

use crate::axes::Space;
use crate::codes;
use crate::rendering::templates::TemplateSet;
use crate::rendering::templates::contradiction;
use crate::targets::profile::TargetProfile;
use crate::variant::compile::unknown_axis;
use umbragraph_text::diagnostic::{AxisValue, AxisValues, Diagnostic, Place, describe};

/// A template to validate, with its allowed axis values and target profiles.
#[derive(Clone, Debug)]
pub struct Request {
    /// The name in reports, such as that of a pass.
    pub name: String,
    /// The target profiles, if requests with the same name differ by profile; otherwise empty.
    pub group: String,
    /// The name of the template.
    pub template: String,
    /// The allowed values by axis name; an axis without an entry can have all of its values.
    pub allowed: BTreeMap<String, Vec<AxisValue>>,
    /// Axes whose values are combined with all others, though some combinations may never occur. Maps each axis to the
    /// source of its values. A diagnostic caused by such an axis mentions this source.
    pub assumed: BTreeMap<String, String>,
    /// The target profiles that must accept every variant.
    pub profiles: Vec<TargetProfile>,
    /// The place to which diagnostics about the request refer.
    pub place: Place,
}

impl Request {
    /// Creates a request for every variant of a template.
    pub fn all(template: &str, profiles: &[TargetProfile]) -> Self {
        Self {
            name: template.to_owned(),
            group: String::new(),
            template: template.to_owned(),
            allowed: BTreeMap::new(),
            assumed: BTreeMap::new(),
            profiles: profiles.to_vec(),
            place: Place::Nowhere,
        }
    }

    /// Creates a request for one combination of values. Axes missing in `values` have their defaults, or any value if
    /// the constraints forbid the defaults.
    pub fn one(
        templates: &TemplateSet,
        template: &str,
        values: &AxisValues,
        profiles: &[TargetProfile],
    ) -> Self {
        let only = |values: &AxisValues| -> BTreeMap<String, Vec<AxisValue>> {
            values.iter().map(|(name, value)| (name.clone(), vec![value.clone()])).collect()
        };
        let mut allowed = only(values);
        if let Some(axes) = templates.axes(template) {
            let mut with_defaults = only(&axes.defaults());
            with_defaults.extend(allowed.clone());
            if Space::new(axes, &with_defaults).possible(&AxisValues::new()) {
                allowed = with_defaults;
            }
        }
        Self { allowed, ..Self::all(template, profiles) }
    }
}

pub(super) fn space_of(templates: &TemplateSet, request: &Request) -> Result<Space, Vec<Diagnostic>> {
    let template = &request.template;
    let Some(axes) = templates.axes(template) else {
        return Err(vec![templates.unknown(template, request.place.clone())]);
    };
    if let Some(broken) = templates.templates.get(template).and_then(|template| template.broken.clone()) {
        return Err(vec![broken]);
    }
    let mut diagnostics = templates.axes_diagnostics(template);
    if templates.has_lost_axes(template) {
        return Err(diagnostics);
    }
    for (name, values) in &request.allowed {
        match axes.get(name) {
            None => diagnostics.push(unknown_axis(axes, template, name, request.place.clone())),
            Some(axis) => {
                diagnostics.extend(values.iter().filter(|value| !axis.kind.contains(value)).map(|value| {
                    let message = format!("\"{value}\" is not a value of the axis \"{name}\"");
                    Diagnostic::error(codes::AXIS_VALUE, request.place.clone(), message)
                        .help(format!("the values are {}", axis.kind.describe()))
                        .related(axis.span, "declared here")
                }));
            }
        }
    }
    if !diagnostics.is_empty() {
        return Err(diagnostics);
    }
    let space = Space::new(axes, &request.allowed);
    if space.possible(&AxisValues::new()) {
        return Ok(space);
    }
    let clash = space.clash();
    let place = match clash.first() {
        Some(constraint) => Place::Span(constraint.span),
        None => request.place.clone(),
    };
    let fixed: AxisValues = request
        .allowed
        .iter()
        .filter_map(|(name, values)| match values.as_slice() {
            [value] if clash.iter().any(|constraint| constraint.axes().contains(name.as_str())) => {
                Some((name.clone(), value.clone()))
            }
            _ => None,
        })
        .collect();
    let mut message = format!("the constraints of \"{template}\" leave no configuration");
    if !fixed.is_empty() {
        message.push_str(&format!(" with {}", describe(&fixed)));
    }
    Err(vec![contradiction(&clash, place, message)])
}
