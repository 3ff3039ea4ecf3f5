//! Programs that the configurations of a pipeline reach: every program of every pass, with all values that its axes can
//! have.
//!
//! Each configuration is loaded in full, so what a load checks (bindings, blocks and their members, contracts with the
//! host, the union of a pass's variants) holds for every one of them. Their shader variants are kept apart as a list of
//! products: a value of one axis is only combined with a value of another where some configuration does so.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::free_axes::FreeAxis;
use super::{Configurations, Loading, cannot_hold};
use crate::check::{CheckOptions, compiled};
use crate::configurations::coverage::Judge;
use umbragraph_pipeline::compose::as_written;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, Severity, codes};
use umbragraph_pipeline::document::Document;
use umbragraph_pipeline::model::Model;
use umbragraph_pipeline::pipeline::{Absent, Overrides, Survey, TypedPipeline, lacking};
use umbragraph_pipeline::shader::permutations::Count;
use umbragraph_pipeline::shader::{self, AxisValue, AxisValues, ShaderCache};
use umbragraph_pipeline::source::{Sources, Span};

/// The values of shader axes, by the names of the axes. The product stands for all combinations of one value of each
/// axis.
pub type AxisProduct = BTreeMap<String, Vec<AxisValue>>;

/// The shader programs and variants that occur in the configurations of a pipeline.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Reached {
    /// The programs, in the order in which passes first require them.
    pub programs: Vec<ReachedProgram>,
    /// The number of configurations that the programs cover. It is a lower bound if only some values of numbers and
    /// lists were tried, or if passes have too many states.
    pub configurations: Count,
    /// The number of loaded configurations: all of them, or a selection that stands for all.
    pub loaded: usize,
    /// The number of loaded configurations that nobody can use, because their parameter values are incompatible.
    pub rejected: usize,
}

/// A shader program with the variants of it that occur in the configurations of a pipeline.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReachedProgram {
    /// The names of the passes that require the program.
    pub passes: Vec<String>,
    /// The name of the WGSL template.
    pub template: String,
    /// The axis values of all variants, as products; no two products have a variant in common. An axis that a product
    /// does not name can have any value.
    pub products: Vec<AxisProduct>,
    /// The axes whose values are combined with all values of the other axes, each with the expression that yields its
    /// values. The settings in the expression have too many values to try each, so some combinations may occur in no
    /// configuration.
    pub assumed: BTreeMap<String, String>,
    /// The place where the first pass names the template.
    pub place: Span,
}

/// The inputs of [`reach`], besides the document and the check options.
pub struct Surveyed<'a> {
    /// The configurations to load.
    pub configurations: &'a Configurations,
    /// The cache of shader modules, created by [`ShaderCache::of_survey`].
    pub shaders: &'a Arc<ShaderCache>,
    /// A further check of plans, such as a dry run, whose diagnostics are added.
    pub judge: Judge<'a>,
}

/// Loads the configurations of a document one after the other, and returns the shader programs and variants that occur
/// in them.
///
/// Errors in shaders are left to the validation of all variants ([`umbragraph_pipeline::shader::permutations`]). Each
/// other diagnostic is added once, with the settings that show it.
///
/// A node kind or an expression can reject a combination of values that are each within their range, such as four
/// levels with three distances. In a configuration that changes features only, the rejection is an error, since
/// features can declare what they require and exclude. In one that changes a parameter, it is a note: the configuration
/// reaches no shader, and [`Reached::rejected`] counts it. A constraint of the pipeline that warns about values of
/// parameters becomes a note, too.
///
/// The caller's `judge` checks the plan of each configuration that has a pass with other work or other shaders than in
/// all configurations before. Its diagnostics are added.
pub fn reach(
    (document, model): (&Document, &Model),
    options: &CheckOptions<'_>,
    Surveyed { configurations, shaders, judge }: Surveyed<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Reached {
    let mut survey = Survey::default();
    let mut known = BTreeSet::new();
    let mut rejected = Rejected::default();
    let mut realized = Realized { judge, works: HashSet::new() };
    let loaded = configurations.load(
        document,
        Loading {
            registry: options.registry,
            shaders,
            is_surveyed: true,
            cancelled: &AtomicBool::new(false),
        },
        sources,
        |at, overrides, mut pipeline, mut own| {
            let here = pipeline.survey.take().unwrap_or_default();
            if !own.has_errors() {
                own.extend(realized.judge(pipeline, options, sources));
            }
            // What is known already is no matter of these values.
            let own = as_written(document, own);
            let new: Vec<Diagnostic> =
                own.into_iter().filter(|diagnostic| !known.contains(&diagnostic.key())).collect();
            let do_not_fit = new.iter().any(is_about_values);
            let Survey { wanted, mut present, absent } = here;
            for (entry, absent) in absent {
                survey.absent.entry(entry).or_insert(absent);
            }
            if !do_not_fit {
                survey.wanted.extend(wanted);
            }
            // The first is the default, or what the caller asked for: that has to work.
            if do_not_fit && at > 0 && !overrides.parameters.is_empty() {
                rejected.add(new, overrides);
                return;
            }
            survey.present.append(&mut present);
            for mut diagnostic in new {
                if known.insert(diagnostic.key()) {
                    // Such values are not the default: the warning concerns only whoever chooses them.
                    if diagnostic.code.id == codes::CONSTRAINT.id
                        && at > 0
                        && !overrides.parameters.is_empty()
                    {
                        diagnostic = diagnostic.severity(Severity::Note);
                    }
                    if let Some(settings) = describe(overrides).filter(|_| configurations.are_all) {
                        diagnostic = diagnostic.related(Place::Nowhere, format!("with {settings}"));
                    }
                    diagnostics.push(diagnostic);
                }
            }
        },
    );
    if let Err(own_diagnostics) = loaded {
        diagnostics.extend(as_written(document, own_diagnostics));
        return Reached::default();
    }
    let Survey { present, absent, .. } = &mut survey;
    absent.retain(|entry, _| !present.contains(entry));
    if configurations.are_all {
        diagnostics.extend(unproven((document, model), options, &survey, configurations.exact));
    }
    let programs = programs(options, &survey, &configurations.free, configurations.is_sampled());
    let number_rejected = rejected.configurations;
    diagnostics.extend(rejected.notes());
    let (number, loaded) = (configurations.number, configurations.list.len());
    Reached { programs, configurations: number, loaded, rejected: number_rejected }
}

/// A further check of plans that skips each plan whose passes were all checked in earlier plans.
struct Realized<'j> {
    judge: Judge<'j>,
    works: HashSet<u64>,
}

impl Realized<'_> {
    fn judge(
        &mut self,
        pipeline: TypedPipeline,
        options: &CheckOptions<'_>,
        sources: &Sources,
    ) -> Diagnostics {
        let mut is_new = false;
        for pass in &pipeline.passes {
            let mut hasher = DefaultHasher::new();
            (&pass.name, format!("{:?}", pass.work())).hash(&mut hasher);
            let variants = pass.work().program().map(|program| &pipeline.program(program).variants);
            variants.into_iter().flatten().for_each(|variant| variant.module.hash.hash(&mut hasher));
            is_new |= self.works.insert(hasher.finish());
        }
        let mut own = Diagnostics::new();
        if !is_new || !pipeline.gaps.is_empty() || !pipeline.rejected.is_empty() {
            return own;
        }
        let plan = compiled(pipeline, options.plan, sources, &mut own).plan;
        // Values of parameters may ask for what no device has: whoever gives them is told so then.
        let plan = plan.filter(|_| !own.has_errors());
        plan.map(|plan| (self.judge)(&plan)).unwrap_or_default()
    }
}

/// Returns the diagnostics about passes that occur in no loaded configuration. A pass whose condition can never hold
/// gets a warning, unless the target profile lacks a feature. Any other pass gets an error, since its shaders are not
/// validated. `exact` is `true` if the configurations show every state of every pass.
fn unproven<'a>(
    (document, model): (&'a Document, &'a Model),
    options: &'a CheckOptions<'_>,
    survey: &'a Survey,
    exact: bool,
) -> impl Iterator<Item = Diagnostic> + 'a {
    let features = document.root.entries_of("features");
    // What one profile has no room for, another may have.
    let is_less = features.iter().any(|entry| lacking(entry, features, options.profile).is_some());
    survey.absent.values().filter_map(move |absent| {
        let Absent { name, decided_by, is_top, pointer } = absent;
        let never = exact || *is_top && cannot_hold((document, model), (options.templates, options.profile), pointer);
        let code = shader::codes::PASS_UNPROVEN;
        let diagnostic = if never {
            let message = format!("no configuration has the pass \"{name}\"");
            let help = "the declared features and parameters never make its condition hold: correct the condition or the \
                        declarations, or remove the pass";
            Diagnostic::warning(code, *decided_by, message).help(help)
        } else {
            let message = format!(
                "the pass \"{name}\" is in none of the configurations that were tried, so its shaders are not proven"
            );
            let help = "name a configuration that has it: a preset is always tried; or declare smaller ranges and fewer \
                        features for its condition; --set NAME=VALUE proves one configuration";
            Diagnostic::error(code, *decided_by, message).help(help)
        };
        (!never || !is_less).then(|| diagnostic.pointer(pointer.as_str()))
    })
}

/// The configurations with incompatible values: their number, and the first diagnostic of each code and place with its
/// number of occurrences.
#[derive(Default)]
struct Rejected {
    configurations: usize,
    found: BTreeMap<(&'static str, Place), (Diagnostic, usize)>,
}

impl Rejected {
    fn add(&mut self, diagnostics: Vec<Diagnostic>, overrides: &Overrides) {
        self.configurations += 1;
        for diagnostic in diagnostics.into_iter().filter(is_about_values) {
            let key = (diagnostic.code.id, diagnostic.place.clone());
            let with = || match describe(overrides) {
                Some(settings) => diagnostic.related(Place::Nowhere, format!("with {settings}")),
                None => diagnostic,
            };
            self.found.entry(key).or_insert_with(|| (with(), 0)).1 += 1;
        }
    }

    fn notes(self) -> impl Iterator<Item = Diagnostic> {
        self.found.into_values().map(|(diagnostic, number)| {
            let note = diagnostic.severity(Severity::Note);
            match number {
                0 | 1 => note,
                2 => note.related(Place::Nowhere, "the same in one further configuration"),
                _ => {
                    note.related(Place::Nowhere, format!("the same in {} further configurations", number - 1))
                }
            }
        })
    }
}

/// Returns `true` if a diagnostic is an error about incompatible values of settings, found by a node kind or in an
/// expression. A user who chooses the values gets the error, and no shader is reached.
fn is_about_values(diagnostic: &Diagnostic) -> bool {
    let id = diagnostic.code.id;
    let of_engine = codes::ALL.iter().chain(shader::codes::ALL).any(|code| code.id == id);
    let of_values = [
        codes::EXPRESSION_ARITHMETIC,
        codes::SETTING_RANGE,
        codes::SETTING_ORDER,
        codes::FEATURE_CONFLICT,
        codes::FEATURE_GROUP,
    ];
    diagnostic.severity == Severity::Error && (!of_engine || of_values.iter().any(|code| code.id == id))
}

fn describe(overrides: &Overrides) -> Option<String> {
    let settings: Vec<String> = overrides
        .features
        .iter()
        .chain(&overrides.parameters)
        .map(|setting| format!("{}={}", setting.name, setting.value.to_json()))
        .collect();
    (!settings.is_empty()).then(|| settings.join(", "))
}

/// Returns the programs that the loaded configurations require. `spread` combines all values of all axes, for a list of
/// configurations that is a sample.
fn programs(
    options: &CheckOptions<'_>,
    survey: &Survey,
    free: &[FreeAxis],
    spread: bool,
) -> Vec<ReachedProgram> {
    let mut order: Vec<(&str, &str)> = Vec::new();
    let mut reached: BTreeMap<(&str, &str), (BTreeSet<AxisValues>, Span)> = BTreeMap::new();
    for wanted in &survey.wanted {
        let key = (wanted.pass.as_str(), wanted.chosen.template.as_str());
        let entry = reached.entry(key).or_insert_with(|| {
            order.push(key);
            (BTreeSet::new(), wanted.place)
        });
        for values in wanted.chosen.variants() {
            // What breaks a constraint has its diagnostic from the load.
            if let Ok(mut values) = shader::complete(options.templates, &wanted.chosen.template, &values) {
                values.retain(|name, _| !free_in(free, &wanted.pass).any(|axis| axis.name == *name));
                entry.0.insert(values);
            }
        }
    }
    let mut programs: Vec<ReachedProgram> = Vec::new();
    for key in order {
        let Some((variants, place)) = reached.remove(&key).filter(|(variants, _)| !variants.is_empty())
        else {
            continue;
        };
        let free: Vec<&FreeAxis> = free_in(free, key.0).collect();
        let mut products = products(&variants, spread);
        let mut assumed = BTreeMap::new();
        for axis in options.templates.axes(key.1).into_iter().flat_map(shader::Axes::iter) {
            let of_axis: Vec<&&FreeAxis> = free.iter().filter(|each| each.name == axis.name).collect();
            // Of a number that is only a size the ends are proven, whatever it follows.
            let Some(first) = of_axis.first().filter(|_| !axis.ends) else { continue };
            assumed.insert(axis.name.clone(), first.reason.clone());
            let Some(values) = of_axis.iter().map(|each| each.values.as_ref()).collect::<Option<Vec<_>>>()
            else {
                continue;
            };
            // A value that the axis does not have is an error of the configuration, and no variant.
            let values: BTreeSet<AxisValue> =
                values.into_iter().flatten().filter(|value| axis.kind.contains(value)).cloned().collect();
            for product in &mut products {
                product.insert(axis.name.clone(), values.iter().cloned().collect());
            }
        }
        let alike = programs.iter_mut().find(|program| {
            program.template == key.1 && program.products == products && program.assumed == assumed
        });
        match alike {
            Some(program) => program.passes.push(key.0.to_owned()),
            None => programs.push(ReachedProgram {
                passes: vec![key.0.to_owned()],
                template: key.1.to_owned(),
                products,
                assumed,
                place,
            }),
        }
    }
    programs
}

/// Returns the axes of `free` that apply to a pass. A pass made by a loop or a subgraph has those of the document's
/// pass that made it.
fn free_in<'f>(free: &'f [FreeAxis], pass: &'f str) -> impl Iterator<Item = &'f FreeAxis> {
    let outermost = pass.split('.').next().unwrap_or(pass);
    free.iter().filter(move |axis| axis.pass.as_deref().is_none_or(|owner| owner == outermost))
}

/// Merges variants into disjoint products of axis values. With `spread`, the result is one product of all values.
fn products(variants: &BTreeSet<AxisValues>, spread: bool) -> Vec<AxisProduct> {
    type Product = BTreeMap<String, BTreeSet<AxisValue>>;
    let single = |values: &AxisValues| -> Product {
        values.iter().map(|(name, value)| (name.clone(), [value.clone()].into())).collect()
    };
    let mut products: BTreeSet<Product> = variants.iter().map(single).collect();
    let names: BTreeSet<&String> = variants.iter().flat_map(BTreeMap::keys).collect();
    if spread {
        let mut all = Product::new();
        for (name, values) in products.into_iter().flatten() {
            all.entry(name).or_default().extend(values);
        }
        products = [all].into();
    } else {
        for name in names {
            let mut alike: BTreeMap<Product, BTreeSet<AxisValue>> = BTreeMap::new();
            for mut product in products {
                let values = product.remove(name).unwrap_or_default();
                alike.entry(product).or_default().extend(values);
            }
            products = alike
                .into_iter()
                .map(|(mut product, values)| {
                    product.insert(name.clone(), values);
                    product
                })
                .collect();
        }
    }
    products
        .into_iter()
        .map(|product| {
            product.into_iter().map(|(name, values)| (name, values.into_iter().collect())).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variants(list: &[(bool, i64)]) -> BTreeSet<AxisValues> {
        list.iter()
            .map(|(a, b)| [("a".to_owned(), (*a).into()), ("b".to_owned(), (*b).into())].into())
            .collect()
    }

    #[test]
    fn variants_that_form_a_product_are_one_and_others_stay_apart() {
        assert_eq!(products(&variants(&[(false, 1), (false, 2), (true, 1), (true, 2)]), false).len(), 1);
        let three = products(&variants(&[(false, 1), (false, 2), (true, 1)]), false);
        let size = |product: &AxisProduct| product.values().map(Vec::len).product::<usize>();
        assert_eq!(three.iter().map(size).sum::<usize>(), 3, "{three:?}");
        assert_eq!(products(&variants(&[(false, 1), (true, 2)]), true).iter().map(size).sum::<usize>(), 4);
    }
}
