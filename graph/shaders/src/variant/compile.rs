//! One variant of a template, from values to a reflected module.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use naga::back::PipelineConstants;
use naga::{Module, Scalar, Span, TypeInner};

use crate::axes::{Axes, AxisMode};
use crate::codes;
use crate::module::wgsl;
use crate::reflection;
use crate::reflection::{EntryPoint, Reflection, Stage};
use crate::rendering::markers;
use crate::rendering::render;
use crate::rendering::templates::TemplateSet;
use crate::targets::profile::TargetProfile;
use crate::written::rejection::{Rejection, declaration};
use crate::written::stages;
use crate::written::text_map::{Source, TextMap};
use umbragraph_text::diagnostic::{
    AxisValue, AxisValues, Diagnostic, Place, Severity, describe, list_of, select_axes,
};
use umbragraph_text::source::Span as SourceSpan;

/// One variant of a shader template: a WGSL module, validated for a target profile.
#[derive(Clone, Debug, PartialEq)]
pub struct ShaderModule {
    /// The name of the template from which the module is generated.
    pub template: String,
    /// The values of the axes that the generated WGSL depends on; other axes have no effect on it.
    pub axes: AxisValues,
    /// The values of the module's pipeline-overridable constants, keyed by name or `@id`.
    pub constants: BTreeMap<String, f64>,
    /// The generated WGSL.
    pub wgsl: Arc<str>,
    /// The BLAKE3 hash of the WGSL.
    pub hash: [u8; 32],
    /// The interface of the module: bindings, entry points and overrides.
    pub reflection: Reflection,
    /// The map from byte offsets in the WGSL to places in the templates.
    pub map: TextMap,
    /// The warnings about the module; empty if there are none.
    pub warnings: Vec<Diagnostic>,
}

impl ShaderModule {
    /// The place in a template where a variable of the module is declared: its name with its type.
    pub fn variable(&self, name: &str) -> Option<SourceSpan> {
        let is_declared = |range: &std::ops::Range<usize>| {
            let before = self.wgsl[..range.start].trim_end();
            before.ends_with('>') || before.ends_with("var")
        };
        let at = stages::words(&self.wgsl, name).find(is_declared)?.start;
        self.map.span(declaration(&self.wgsl, at, name)?)
    }

    /// The place in a template where a member of a structure is declared: its name with its type.
    pub fn member(&self, structure: &str, name: &str) -> Option<SourceSpan> {
        self.map.span(declaration(&self.wgsl, self.structure(structure)?, name)?)
    }

    /// The byte offset behind the name of a structure, where it is declared.
    fn structure(&self, name: &str) -> Option<usize> {
        let is_declared = |before: &str| before.trim_end().ends_with("struct");
        let mut found = stages::words(&self.wgsl, name);
        found.find(|range| is_declared(&self.wgsl[..range.start])).map(|range| range.end)
    }

    /// The place in a template where an entry point declares its output or input at a location: the attribute and what
    /// follows it on the line.
    pub fn location(&self, entry_point: &str, location: u32) -> Option<SourceSpan> {
        let attribute = format!("@location({location})");
        let start = stages::entry_point(&self.wgsl, entry_point)?.end;
        let head = &self.wgsl[start..start + self.wgsl[start..].find('{')?];
        let (from, result) = head.rfind("->").map(|at| (start + at, head[at + 2..].trim()))?;
        let from = match result.starts_with('@') {
            true => from,
            false => self.structure(result)?,
        };
        let at = from + self.wgsl[from..].find(&attribute)?;
        let end = self.wgsl[at + attribute.len()..].find([',', '{', '}', '\n'])?;
        let length = self.wgsl[at..at + attribute.len() + end].trim_end().len();
        self.map.span(at..at + length)
    }
}

/// Generated WGSL with its map, and the names of the axes that were read during rendering.
pub(crate) type Rendered = (Source, BTreeSet<String>);

/// Generates, parses, validates and reflects one variant of a template.
///
/// `values` may name any of the template's axes; all other axes have their defaults.
///
/// # Errors
/// All detectable errors: unknown axes and values, violated constraints, errors of the template, and the first error
/// of the WGSL. Errors are placed in the templates; the generated line is shown with them.
pub fn compile(
    templates: &TemplateSet,
    template: &str,
    values: &AxisValues,
    profile: &TargetProfile,
) -> Result<ShaderModule, Vec<Diagnostic>> {
    let values = complete(templates, template, values)?;
    let rendered = render::render(templates, template, &template_values(templates, template, &values))?;
    of_rendered(templates, template, &values, &rendered, profile)
}

/// Validates and reflects a rendered variant. `values` must contain every axis of the template.
pub(crate) fn of_rendered(
    templates: &TemplateSet,
    template: &str,
    values: &AxisValues,
    rendered: &Rendered,
    profile: &TargetProfile,
) -> Result<ShaderModule, Vec<Diagnostic>> {
    wgsl::with_stack(|| check(templates, template, values, rendered, profile))
}

/// Copies a module with other override values, without validating it again. `None` if the module has overrides and a
/// compute stage, since the workgroup size may depend on them. Also `None` if an override has an `@id`.
pub(crate) fn with_values(
    known: &ShaderModule,
    values: &AxisValues,
    (source, read): &Rendered,
) -> Option<ShaderModule> {
    let is_compute = |entry: &EntryPoint| entry.stage == Stage::Compute;
    if !known.constants.is_empty() && known.reflection.entry_points.iter().any(is_compute) {
        return None;
    }
    let constant = |name: &String| match values.get(name)? {
        AxisValue::Bool(value) => Some((name.clone(), f64::from(u8::from(*value)))),
        AxisValue::Integer(value) => Some((name.clone(), *value as f64)),
        _ => None,
    };
    let constants = known.constants.keys().map(constant).collect::<Option<BTreeMap<_, _>>>()?;
    let (axes, map) = (select_axes(values, |name| read.contains(name)), source.map.clone());
    Some(ShaderModule { axes, constants, map, ..known.clone() })
}

/// Returns the WGSL of one variant, even if naga rejects it; `None` if a value is invalid or the template does not
/// render.
pub fn generate(templates: &TemplateSet, template: &str, values: &AxisValues) -> Option<String> {
    let values = complete(templates, template, values).ok()?;
    let (source, _) =
        render::render(templates, template, &template_values(templates, template, &values)).ok()?;
    Some(source.wgsl)
}

/// Checks the given axis values, and adds the defaults of all other axes. Fails if values are invalid or violate a
/// constraint.
pub fn complete(
    templates: &TemplateSet,
    template: &str,
    given: &AxisValues,
) -> Result<AxisValues, Vec<Diagnostic>> {
    let Some(axes) = templates.axes(template) else {
        return Err(vec![templates.unknown(template, Place::Nowhere)]);
    };
    let mut diagnostics = templates.axes_diagnostics(template);
    if templates.has_lost_axes(template) {
        return Err(diagnostics);
    }
    let place = templates.file(template).map_or(Place::Nowhere, |file| SourceSpan::new(file, 0..0).into());
    let mut values = axes.defaults();
    for (name, value) in given {
        match axes.get(name) {
            None => diagnostics.push(unknown_axis(axes, template, name, place.clone())),
            Some(axis) if !axis.kind.contains(value) => diagnostics.push(
                Diagnostic::error(
                    codes::AXIS_VALUE,
                    axis.span,
                    format!("\"{value}\" is not a value of the axis \"{name}\""),
                )
                .help(format!("the values are {}", axis.kind.describe())),
            ),
            Some(_) => {
                values.insert(name.clone(), value.clone());
            }
        }
    }
    if diagnostics.is_empty() {
        diagnostics.extend(axes.violated(&values).map(|constraint| {
            let named = constraint.axes();
            let involved = select_axes(&values, |name| named.contains(name));
            let message =
                format!("{} breaks a constraint of \"{template}\": {constraint}", describe(&involved));
            let set = list_of(involved.keys().map(String::as_str));
            Diagnostic::error(codes::CONSTRAINT_VIOLATED, constraint.span, message)
                .help(format!("change {set} where the pass has \"axes\", or what their expressions read"))
        }));
    }
    if diagnostics.is_empty() { Ok(values) } else { Err(diagnostics) }
}

/// The diagnostic for a name that is not an axis of the template.
pub(crate) fn unknown_axis(axes: &Axes, template: &str, name: &str, place: Place) -> Diagnostic {
    let diagnostic =
        Diagnostic::error(codes::AXIS_UNKNOWN, place, format!("\"{template}\" has no axis \"{name}\""));
    let written = diagnostic.span();
    diagnostic.suggest(name, axes.names(), written, |names| match names {
        [] => "it has no axes at all".to_owned(),
        names => format!("its axes are {}", list_of(names)),
    })
}

/// Selects the values of the axes that are template variables; values of override axes are left out.
pub(crate) fn template_values(templates: &TemplateSet, template: &str, values: &AxisValues) -> AxisValues {
    select_axes(values, |name| {
        let axis = templates.axes(template).and_then(|axes| axes.get(name));
        axis.is_some_and(|axis| axis.mode == AxisMode::Template)
    })
}

pub(crate) fn check(
    templates: &TemplateSet,
    template: &str,
    values: &AxisValues,
    (source, read): &Rendered,
    profile: &TargetProfile,
) -> Result<ShaderModule, Vec<Diagnostic>> {
    let (Some(axes), Some(file)) = (templates.axes(template), templates.file(template)) else {
        return Err(vec![templates.unknown(template, Place::Nowhere)]);
    };
    let place = |rejection: &Rejection| {
        markers::place(templates, rejection, &source.wgsl, &source.map, file, || {
            let values = template_values(templates, template, values);
            templates.marked().map(template, &values, &source.wgsl)
        })
    };
    let proven = || {
        let module = wgsl::parse(&source.wgsl)?;
        let constants = constants(axes, values, &module)?;
        let info = wgsl::validate(&module, profile.capabilities)?;
        let sizes = wgsl::workgroup_sizes(&wgsl::resolve_overrides(&module, &info, &constants)?);
        let reflection = reflection::reflect(&module, &info, &sizes);
        Ok((module, constants, reflection))
    };
    let (module, constants, reflection) = proven().map_err(|rejection| vec![place(&rejection)])?;
    let mut warnings = Vec::new();
    for mut rejection in wgsl::beyond_naga(&module) {
        rejection.warning |= !profile.is_browser();
        warnings.push(place(&rejection));
    }
    if warnings.iter().any(|one| one.severity == Severity::Error) {
        return Err(warnings);
    }
    Ok(ShaderModule {
        template: template.to_owned(),
        axes: select_axes(values, |name| read.contains(name)),
        constants: constants.into_iter().collect(),
        hash: *blake3::hash(source.wgsl.as_bytes()).as_bytes(),
        wgsl: source.wgsl.as_str().into(),
        reflection,
        map: source.map.clone(),
        warnings,
    })
}

/// Returns the values of the override axes for which the module declares a constant, keyed by the constant's name or
/// `@id`.
///
/// # Errors
/// A rejection if the type of an override does not fit its axis.
pub(crate) fn constants(
    axes: &Axes,
    values: &AxisValues,
    module: &Module,
) -> Result<PipelineConstants, Rejection> {
    let mut constants = PipelineConstants::default();
    for (handle, constant) in module.overrides.iter() {
        let Some(name) = constant.name.as_deref() else { continue };
        let Some(axis) = axes.get(name).filter(|axis| axis.mode == AxisMode::Override) else { continue };
        let scalar = match module.types[constant.ty].inner {
            TypeInner::Scalar(scalar) => Some(scalar),
            _ => None,
        };
        let value = match (values.get(name), scalar) {
            (Some(AxisValue::Bool(value)), Some(Scalar::BOOL)) => f64::from(u8::from(*value)),
            (Some(AxisValue::Integer(value)), Some(Scalar::I32)) if i32::try_from(*value).is_ok() => {
                *value as f64
            }
            (Some(AxisValue::Integer(value)), Some(Scalar::U32)) if u32::try_from(*value).is_ok() => {
                *value as f64
            }
            _ => {
                let message =
                    format!("the override \"{name}\" does not fit its axis ({})", axis.kind.describe());
                let span: Span = module.overrides.get_span(handle);
                let help =
                    "a boolean axis is a `bool`, an integer axis an `i32` or `u32` that holds all its values";
                return Err(Rejection::new(codes::AXIS_OVERRIDE, message, span).help(help));
            }
        };
        // An override with an `@id` is set by that number, any other by its name.
        let key = constant.id.map_or_else(|| name.to_owned(), |id| id.to_string());
        constants.insert(key, value);
    }
    Ok(constants)
}
