//! The results of a permutation check, as data to print, compare and serialise.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::choices::Choices;
use crate::reflection::{Binding, Reflection};
use crate::rendering::render;
use crate::rendering::templates::TemplateSet;
use crate::rules::cost::Cost;
use umbragraph_text::diagnostic::{AxisValue, Count, Diagnostics};

/// The results of a permutation check.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Permutations {
    /// The diagnostics, one per root cause, sorted by place.
    pub diagnostics: Diagnostics,
    /// The reports, in the order of the requests; a request that cannot be explored has none.
    pub templates: Vec<TemplateReport>,
    /// The number of distinct generated WGSL modules.
    pub texts: usize,
    /// The number of modules that naga validated as a whole; the others follow from their declarations.
    pub proven: usize,
    /// The number of distinct validation units: declarations with their dependencies, and interfaces of modules.
    pub declarations: usize,
}

/// The report on one request: the variants of a template with their sizes, costs and coverage.
#[derive(Clone, Debug, serde::Serialize)]
#[non_exhaustive]
pub struct TemplateReport {
    /// The index of the request among all requests of the check.
    #[serde(skip)]
    pub request: usize,
    /// The name of the request, usually that of a pass.
    pub name: String,
    /// The target profiles of the request, if requests with the same name differ by profile; otherwise empty.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub group: String,
    /// The name of the template.
    pub template: String,
    /// The names of the target profiles.
    pub profiles: Vec<String>,
    /// The number of axis-value combinations that the constraints allow.
    pub configurations: Count,
    /// The number of combinations that the checked variants represent. It is lower than `configurations` if a limit
    /// was reached or a rendering failed.
    pub covered: Count,
    /// The number of paths through the template's branches; each path is one rendering.
    pub paths: usize,
    /// The explored values of each axis that a path reads.
    pub values: BTreeMap<String, BTreeSet<AxisValue>>,
    /// The distinct generated modules.
    pub variants: Vec<VariantReport>,
    /// The hashes of the distinct WGSL declarations in the generated modules.
    #[serde(skip)]
    pub declarations: BTreeSet<u64>,
    /// The names of the axes without effect on any module.
    pub dead_axes: Vec<String>,
    /// The change of the module's size, in bytes, for each non-default value of axes with at most 16 values.
    pub bytes_of_values: Vec<ValueBytes>,
    /// The union of the variants' bindings, except for those in conflict: the layout of the pass.
    #[serde(skip)]
    pub interface: Vec<Binding>,
}

/// The costs of a module's entry points, by name.
pub type Costs = BTreeMap<String, Cost>;

/// The report on one distinct generated module.
#[derive(Clone, Debug, serde::Serialize)]
#[non_exhaustive]
pub struct VariantReport {
    /// The axis values on the first template path that generates the module.
    pub axes: Choices,
    /// The number of template paths that generate the module.
    pub paths: usize,
    /// The number of axis-value combinations that generate the module.
    pub configurations: Count,
    /// The size of the WGSL in bytes.
    pub bytes: usize,
    /// The BLAKE3 hash of the WGSL in hexadecimal digits.
    pub hash: String,
    /// Whether every target profile accepts the module.
    pub valid: bool,
    /// The cost of each entry point; empty if no profile accepts the module.
    #[serde(serialize_with = "shared")]
    pub costs: Arc<Costs>,
    /// The reflection of the module; `None` if no profile accepts it.
    #[serde(skip)]
    pub reflection: Option<Arc<Reflection>>,
}

/// The change in size that one axis value causes, compared to the module with all defaults.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ValueBytes {
    /// The name of the axis whose value is changed.
    pub axis: String,
    /// The value of the axis.
    pub value: AxisValue,
    /// The change of the WGSL's size in bytes; negative if the module becomes smaller.
    pub bytes: i64,
}

fn shared<T: serde::Serialize, S: serde::Serializer>(
    values: &Arc<T>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(values.as_ref(), serializer)
}

impl VariantReport {
    /// Returns the entry point with the highest cost, or `None` if there are no costs.
    pub fn worst(&self) -> Option<(&str, &Cost)> {
        let all = self.costs.iter().map(|(name, cost)| (name.as_str(), cost));
        // The first of equals.
        all.rev().max_by_key(|(_, cost)| cost.total)
    }

    /// Returns a file name for the variant: `forward.sscs=true.taps=16.1f2e3d4c.wgsl`. Long lists of values are
    /// truncated; the first digits of the hash keep names unique.
    pub fn file_name(&self, name: &str) -> String {
        let clean = |text: &str| -> String {
            let keep = |each: char| each.is_ascii_alphanumeric() || matches!(each, '_' | '-' | '=' | '.');
            text.chars().map(|each| if keep(each) { each } else { '_' }).collect()
        };
        let mut file = clean(name).trim_start_matches('.').chars().take(80).collect::<String>();
        for (axis, value) in &self.axes.values() {
            let part = clean(&format!(".{axis}={value}"));
            if file.len() + part.len() > 160 {
                file.push_str(".etc");
                break;
            }
            file.push_str(&part);
        }
        format!("{file}.{}.wgsl", self.hash.get(..8).unwrap_or_default())
    }
}

impl TemplateReport {
    /// Renders the WGSL of a variant again, since reports do not store it; `None` if rendering fails.
    pub fn text(&self, templates: &TemplateSet, variant: &VariantReport) -> Option<String> {
        render::render_fixed(templates, &self.template, &variant.axes.values()).map(|source| source.wgsl)
    }

    /// Returns the variant with the largest WGSL, or `None` if there are no variants.
    pub fn max(&self) -> Option<&VariantReport> {
        self.variants.iter().max_by_key(|variant| variant.bytes)
    }
}
