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

use super::{Configurations, FreeAxis, Loading, cannot_hold};
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

/// Values that axes can have together: each value of one with each of the others.
pub type AxisProduct = BTreeMap<String, Vec<AxisValue>>;

/// The programs and variants that the configurations reach.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Reached {
    /// The programs, in the order of the first pass that wants each.
    pub programs: Vec<ReachedProgram>,
    /// The number of configurations for which the programs stand. It is a lower bound where numbers and lists were
    /// tried with some of their values, or passes have too many states.
    pub configurations: Count,
    /// The number of loaded configurations: all, or as many as show every pass in all its states.
    pub loaded: usize,
    /// The number of loaded ones in which values of parameters do not go together, so that nobody can use them.
    pub rejected: usize,
}

/// A program with the variants that configurations reach.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReachedProgram {
    /// The passes.
    pub passes: Vec<String>,
    /// The template.
    pub template: String,
    /// The values; no two products have a variant in common. An axis that a product does not name can have any value.
    pub products: Vec<AxisProduct>,
    /// Axes that have these values together with any others, whether or not a configuration gives them together, since
    /// what they depend on has too many values to try each; with the expression that yields them.
    pub assumed: BTreeMap<String, String>,
    /// The place where the first pass names the template.
    pub place: Span,
}

/// The configurations that are loaded, and what they are loaded with.
pub struct Surveyed<'a> {
    /// The configurations.
    pub configurations: &'a Configurations,
    /// The modules, of [`ShaderCache::of_survey`].
    pub shaders: &'a Arc<ShaderCache>,
    /// The judge of plans.
    pub judge: Judge<'a>,
}

/// Loads the configurations of a document one after the other.
///
/// Diagnostics of shaders themselves are left to the proof of all variants
/// ([`umbragraph_pipeline::shader::permutations`]); each other diagnostic is reported once, with the settings that show
/// it.
///
/// A node kind or an expression can reject values that are each within their range: four levels with three distances.
/// If only features are switched, that is an error, since features can say what they require and exclude. If a
/// parameter is involved, it is a note: whoever chooses such values gets an error then, and no shader is reached. These
/// configurations are counted apart. A constraint of the pipeline that warns about such values becomes a note, too.
///
/// The diagnostics of `judge` on a plan are added: those of a dry run, for one. It judges each configuration that has a
/// pass with other work, or other shaders, than all before.
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

/// A judge of plans that skips those whose passes were all judged before.
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

/// The diagnostics about passes that no configuration has. Where it is shown that there is none, the pass is of no use;
/// else it may be there for somebody, and nothing of it is proven.
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

/// Configurations whose values do not go together: what is said of each place, and how often.
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

/// Whether a diagnostic says that values do not go together: one of a node kind, or of an expression over them. A user
/// who chooses them is told so; no shader is reached.
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

/// The programs that loads asked for; `spread` combines all values, where configurations were left out.
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

/// The free axes of a pass.
fn free_in<'f>(free: &'f [FreeAxis], pass: &'f str) -> impl Iterator<Item = &'f FreeAxis> {
    let outermost = pass.split('.').next().unwrap_or(pass);
    free.iter().filter(move |axis| axis.pass.as_deref().is_none_or(|owner| owner == outermost))
}

/// The variants as disjoint products.
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
