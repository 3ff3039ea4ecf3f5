//! The results of a permutation check, as data to print, compare and serialise.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::reflection::{Binding, Reflection};
use crate::rendering::render;
use crate::rendering::templates::TemplateSet;
use crate::rules::cost::Cost;
use umbragraph_text::diagnostic::{AxisValue, AxisValues, Count, Diagnostics};

/// The outcome of a check.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Permutations {
    /// Every diagnostic, once per root cause, by place.
    pub diagnostics: Diagnostics,
    /// The templates that were checked, in the order of the requests.
    pub templates: Vec<TemplateReport>,
    /// The number of distinct texts of which there is a verdict.
    pub texts: usize,
    /// The number of them that were proven by themselves; the verdicts of all others follow.
    pub proven: usize,
    /// The number of declarations with what they see of others, and of interfaces of modules, that the texts consist
    /// of.
    pub declarations: usize,
}

/// The result of one request.
#[derive(Clone, Debug, serde::Serialize)]
#[non_exhaustive]
pub struct TemplateReport {
    /// The index of the request.
    #[serde(skip)]
    pub request: usize,
    /// The pass, or what else the request calls itself.
    pub name: String,
    /// The profiles that it is about where others reach something else under its name.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub group: String,
    /// The template.
    pub template: String,
    /// The names of the profiles.
    pub profiles: Vec<String>,
    /// The number of configurations that the constraints allow.
    pub configurations: Count,
    /// The number of configurations that the checked variants represent; fewer only where a limit was met.
    pub covered: Count,
    /// The number of paths through the template, each one rendering.
    pub paths: usize,
    /// The axes that paths read, with the values that they took.
    pub values: BTreeMap<String, BTreeSet<AxisValue>>,
    /// The distinct texts.
    pub variants: Vec<VariantReport>,
    /// Hashes of the distinct declarations of the texts.
    #[serde(skip)]
    pub declarations: BTreeSet<u64>,
    /// The axes on which nothing depends.
    pub dead_axes: Vec<String>,
    /// The size that each value adds to the text.
    pub bytes_of_values: Vec<ValueBytes>,
    /// The bindings of all variants together, as far as they agree; the layout of the pass.
    #[serde(skip)]
    pub interface: Vec<Binding>,
}

/// The costs of the entry points of a text by name.
pub type Costs = BTreeMap<String, Cost>;

/// One distinct text.
#[derive(Clone, Debug, serde::Serialize)]
#[non_exhaustive]
pub struct VariantReport {
    /// The values that lead to it, on the first of its paths.
    #[serde(serialize_with = "shared")]
    pub axes: Arc<AxisValues>,
    /// The number of paths that lead to it.
    pub paths: usize,
    /// The number of configurations that have this text.
    pub configurations: Count,
    /// Its size.
    pub bytes: usize,
    /// The BLAKE3 hash of it, in hexadecimal digits.
    pub hash: String,
    /// Whether every profile accepts it.
    pub valid: bool,
    /// The cost of each entry point; none for a text that no profile accepts.
    #[serde(serialize_with = "shared")]
    pub costs: Arc<Costs>,
    /// The reflection of the module; `None` for a text that no profile accepts.
    #[serde(skip)]
    pub reflection: Option<Arc<Reflection>>,
}

/// The size that a value adds to the text of all defaults.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ValueBytes {
    /// The axis.
    pub axis: String,
    /// The value.
    pub value: AxisValue,
    /// The bytes more, or fewer.
    pub bytes: i64,
}

fn shared<T: serde::Serialize, S: serde::Serializer>(
    values: &Arc<T>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serde::Serialize::serialize(values.as_ref(), serializer)
}

impl VariantReport {
    /// The entry point that costs most, with its cost.
    pub fn worst(&self) -> Option<(&str, &Cost)> {
        let all = self.costs.iter().map(|(name, cost)| (name.as_str(), cost));
        // The first of equals.
        all.rev().max_by_key(|(_, cost)| cost.total)
    }

    /// A file name that says which variant of which pass it is: `forward.sscs=true.taps=16.1f2e3d4c.wgsl`. Long lists
    /// of values are cut; the first digits of the hash keep names apart.
    pub fn file_name(&self, name: &str) -> String {
        let clean = |text: &str| -> String {
            let keep = |each: char| each.is_ascii_alphanumeric() || matches!(each, '_' | '-' | '=' | '.');
            text.chars().map(|each| if keep(each) { each } else { '_' }).collect()
        };
        let mut file = clean(name).trim_start_matches('.').chars().take(80).collect::<String>();
        for (axis, value) in self.axes.iter() {
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
    /// The text of one of the variants, rendered again: reports of thousands of them do not keep their texts.
    pub fn text(&self, templates: &TemplateSet, variant: &VariantReport) -> Option<String> {
        render::render_fixed(templates, &self.template, &variant.axes).map(|source| source.wgsl)
    }

    /// The largest text.
    pub fn max(&self) -> Option<&VariantReport> {
        self.variants.iter().max_by_key(|variant| variant.bytes)
    }
}
