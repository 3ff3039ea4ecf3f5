//! The configurations of a pipeline, enumerated.
//!
//! A configuration gives each setting one of its values, so that `requires`, `excludes` and `one_of` hold. There are
//! two wishes, and one way to fulfil them:
//!
//! - the configurations of the features, around values that a caller gives: all up to 256, or else a pairwise cover
//!   ([`cover`](self::cover));
//! - those that can differ in their shaders or passes ([`varied`](self::varied)): all up to 4,096, or else a pairwise
//!   cover and for each pass every combination of the settings on which it depends ([`dependence`](self::dependence)),
//!   the others at their defaults. So each pass is seen in all its states, and the number of configurations is counted
//!   exactly without going through them. A pass with over 4,096 states, or over 16,384 for all passes together, is the
//!   limit: then there are, for each condition, configurations in which it holds and in which it does not
//!   ([`witness`](self::witness)), and the number is a lower bound.
//!
//! Ranges of up to 256 whole numbers are gone through (of up to 16 where there are more than 4,096 configurations
//! otherwise). Axes that depend on a number of which not all values are tried are free: they have the values that their
//! expressions yield, of which up to 4,096 are evaluated, or all of their own, whatever values the other axes have.
//!
//! Limits: where passes are sampled, an axis that follows several settings through a parameter of a subgraph or a variable
//! of a loop has the values that the tried configurations give it.
//!
//! Each preset is one configuration more, with its own parameters; of the second wish, where not everything is gone
//! through anyway.

mod cover;
mod coverage;
mod dependence;
mod free_axes;
mod reach;
mod thresholds;
mod varied;
mod varied_setting;
mod witness;

pub use cover::Cover;
pub use coverage::{Coverage, Examination, Judge, Verify, check_configurations};
pub use reach::{AxisProduct, Reached, ReachedProgram, Surveyed, reach};

use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cover::{MAX_PAIRED, Rules, picks};
use free_axes::{FreeAxis, free_axes};
use umbragraph_pipeline::diagnostic::{Count, Diagnostics, list_of};
use umbragraph_pipeline::document::{Document, Value};
use umbragraph_pipeline::expression::{BinaryOperator, Expression, ExpressionKind, UnaryOperator};
use umbragraph_pipeline::model::Model;
use umbragraph_pipeline::node::Registry;
use umbragraph_pipeline::pipeline::{self, LoadOptions, Override, Overrides, TypedPipeline, of_preset};
use umbragraph_pipeline::shader::{ShaderCache, TargetProfile, TemplateSet};
use umbragraph_pipeline::source::Sources;
use varied::{FEW_VALUES, Mentions, features};
use varied_setting::Varied;
use witness::{Settings, Witness};

/// The maximum number of configurations that are listed for the features of a document, without presets.
pub const MAX: usize = 256;

/// The maximum number of configurations that are enumerated in full: of a pipeline, or of the settings on which one
/// pass depends.
const MAX_STATES: usize = 1 << 12;

/// The maximum number of configurations that are enumerated for all passes together.
const MAX_TOGETHER: usize = 1 << 14;

/// The maximum size of a range of whole numbers whose values are all tried.
const MAX_VALUES: usize = 256;

/// A choice of values for a pipeline's parameters and features.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Configuration {
    /// The values of parameters and features, including the caller's; settings that are not listed keep their defaults.
    pub overrides: Overrides,
    /// The name of the preset that the configuration applies; `None` if it applies no preset.
    pub preset: Option<String>,
    /// The index of each varied setting's value, where 0 is the default or the caller's value; empty for a preset.
    pick: Vec<usize>,
}

/// A list of configurations of a pipeline document, to check or load each of them. The first has the caller's values,
/// or else the defaults. A full list or a pairwise cover is sorted by the number of settings that differ from the
/// first; presets come last.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Configurations {
    /// The configurations, in the order in which they are loaded.
    pub list: Vec<Configuration>,
    /// The number of configurations that the document allows, whether they are listed or not; presets are not counted.
    pub number: Count,
    /// The extent to which `list` covers all configurations of the document.
    pub cover: Cover,
    /// Whether `list` stands for all configurations that can differ in their shaders or passes; `false` for a single
    /// configuration and for those of features.
    pub(super) are_all: bool,
    /// Whether `list` shows every state that a pass can have; `false` if values of settings or states of passes were
    /// sampled.
    pub(super) exact: bool,
    /// The shader axes that can have values beyond those that the listed configurations give them.
    free: Vec<FreeAxis>,
    varied: Vec<Varied>,
}

/// The inputs for loading configurations, besides the document and its sources.
pub(super) struct Loading<'a> {
    pub(super) registry: &'a Registry,
    pub(super) shaders: &'a Arc<ShaderCache>,
    /// Whether all shader variants are validated together later, so that loading leaves shader errors to that step.
    pub(super) is_surveyed: bool,
    /// A flag that stops the loading before the next configuration once it is `true`.
    pub(super) cancelled: &'a AtomicBool,
}

impl Configurations {
    /// Creates a list of one configuration: the caller's values `base`.
    pub fn one(base: &Overrides) -> Self {
        let only = Configuration { overrides: base.clone(), preset: None, pick: Vec::new() };
        Self { list: vec![only], number: Count { number: 1, exact: true }, ..Self::default() }
    }

    /// Lists the combinations of feature values that a target profile allows, with the caller's values `base` fixed.
    /// Lists all up to 256, or else a pairwise cover; adds the presets.
    pub fn of_features(document: &Document, base: &Overrides, profile: &TargetProfile) -> Self {
        let varied = features(document, base, profile);
        let rules = Rules::new(&varied);
        let (picks, cover) = picks(&rules, MAX);
        let mut found = Self::of(document, base, varied, picks, cover);
        found.list.extend(presets(document, base));
        found
    }

    /// Lists the configurations that can differ in their shaders or passes: all up to 4,096, or else a cover of them
    /// (see [`Cover`]).
    pub fn all(
        (document, model): (&Document, &Model),
        templates: &TemplateSet,
        profile: &TargetProfile,
    ) -> Self {
        let mentions = Mentions::of(document, model, templates, profile);
        let mut varied = mentions.varied(MAX_VALUES);
        if product(&varied, &(0..varied.len()).collect()).is_none() {
            varied = mentions.varied(FEW_VALUES);
        }
        let settings = Settings::new(&varied, &mentions.defaults);
        let (mut picks, mut cover) = picks(&settings.rules, MAX_STATES);
        if cover != Cover::All {
            let groups = dependence::groups(model, varied.iter().map(|each| each.name.as_str()), templates);
            cover = add_states(&settings, groups, &mut picks);
            if cover != Cover::Passes {
                add_witnesses(&settings, &conditions(&mentions, &settings), &mut picks);
            }
        }
        let is_sampled = matches!(cover, Cover::Pairs | Cover::Some);
        let exact = !is_sampled && varied.iter().all(|each| each.exhaustive);
        let free = if exact { Vec::new() } else { free_axes(&mentions, &settings, is_sampled) };
        let mut found = Self::of(document, &Overrides::default(), varied, picks, cover);
        found.number.exact &= exact;
        if !exact {
            found.list.extend(presets(document, &Overrides::default()));
        }
        Self { exact, free, are_all: true, ..found }
    }

    /// Returns `true` if passes can have states that no configuration of the list shows.
    pub(super) fn is_sampled(&self) -> bool {
        matches!(self.cover, Cover::Pairs | Cover::Some)
    }

    /// Loads the configurations one after the other, reusing shader modules of earlier ones, until `cancelled` is set.
    /// Calls `each` with the configuration's index, its values, the loaded pipeline and its diagnostics.
    ///
    /// # Errors
    /// Returns the diagnostics of a load that fails, because the document is too broken to have passes.
    pub(super) fn load(
        &self,
        document: &Document,
        loading: Loading<'_>,
        sources: &Sources,
        mut each: impl FnMut(usize, &Overrides, TypedPipeline, Diagnostics),
    ) -> Result<(), Diagnostics> {
        let Loading { registry, shaders, is_surveyed, cancelled } = loading;
        let schema = pipeline::check_schema(document, registry);
        for (at, Configuration { overrides, .. }) in self.list.iter().enumerate() {
            if cancelled.load(Ordering::Relaxed) {
                break;
            }
            let mut own = Diagnostics::new();
            let load = LoadOptions { registry, shaders, overrides, schema: Some(&schema), is_surveyed };
            match pipeline::load(document, &load, sources, &mut own) {
                Some(pipeline) => each(at, overrides, pipeline, own),
                None => return Err(own),
            }
        }
        Ok(())
    }

    fn of(
        document: &Document,
        base: &Overrides,
        varied: Vec<Varied>,
        picks: Vec<Vec<usize>>,
        cover: Cover,
    ) -> Self {
        let configuration = |pick: Vec<usize>| Configuration {
            overrides: base.clone().under(overrides(&varied, &pick)),
            preset: None,
            pick,
        };
        let list = picks.into_iter().map(configuration).collect();
        let number = Rules::new(&varied).count(document.root.span);
        Self { list, number, cover, varied, ..Self::default() }
    }

    /// Describes the configurations at the indices `found` (increasing) in words; `None` if `found` holds all
    /// configurations or none.
    pub fn describe(&self, found: &[usize]) -> Option<String> {
        let all = self.list.len();
        let first = found.first().filter(|_| found.len() < all).and_then(|first| self.list.get(*first))?;
        let checked = if self.cover == Cover::All { "" } else { "checked " };
        let text = format!("in {} of {all} {checked}configurations", found.len());
        if let Some(preset) = &first.preset {
            return Some(format!("{text}: with --preset {preset}"));
        }
        let changes: Vec<String> = first
            .pick
            .iter()
            .enumerate()
            .filter(|(_, value)| **value > 0)
            .map(|(at, value)| self.write(at, *value))
            .collect();
        Some(match (changes.as_slice(), self.cause(found)) {
            ([], None) => format!("{text}, the default one among them"),
            ([], Some(cause)) => format!("{text}: with {cause}, which are the defaults"),
            (changes, _) => format!("{text}; the fewest choices that show it: {}", list_of(changes)),
        })
    }

    fn write(&self, at: usize, value: usize) -> String {
        let value = self.varied.get(at).and_then(|each| each.values.get(value)).map(Value::to_json);
        let text = match value {
            Some(serde_json::Value::String(word)) => word,
            Some(value) => value.to_string(),
            None => String::new(),
        };
        format!("{}={text}", self.varied.get(at).map_or("", |each| each.name.as_str()))
    }

    /// Returns as text one or two settings whose defaults occur together in exactly the configurations at the indices
    /// `found`. `None` if there are no such settings.
    fn cause(&self, found: &[usize]) -> Option<String> {
        let found: BTreeSet<usize> = found.iter().copied().collect();
        let explains = |features: &[usize]| {
            let mut picked = self.list.iter().enumerate().filter(|(_, one)| !one.pick.is_empty());
            picked.all(|(at, one)| {
                let holds = features.iter().all(|feature| one.pick.get(*feature) == Some(&0));
                holds == found.contains(&at)
            })
        };
        let count = self.varied.len().min(MAX_PAIRED);
        let single = (0..count).find(|feature| explains(&[*feature])).map(|feature| vec![feature]);
        let pair = || {
            (0..count)
                .flat_map(|one| (one + 1..count).map(move |two| vec![one, two]))
                .find(|pair| explains(pair))
        };
        let names = single.or_else(pair)?;
        Some(names.into_iter().map(|at| self.write(at, 0)).collect::<Vec<_>>().join(", "))
    }
}

/// Returns a configuration for each preset that gives at least one value. The preset's values replace the caller's
/// values `base`.
fn presets(document: &Document, base: &Overrides) -> Vec<Configuration> {
    let presets = document.root.entries_of("presets");
    let values = presets
        .iter()
        .map(|preset| (preset, of_preset(document, &preset.key, preset.key_span, &mut Diagnostics::new())));
    values
        .filter(|(_, values)| !values.parameters.is_empty() || !values.features.is_empty())
        .map(|(preset, values)| Configuration {
            overrides: values.under(base.clone()),
            preset: Some(preset.key.clone()),
            pick: Vec::new(),
        })
        .collect()
}

/// Returns `true` if a search shows that a condition is false for all values that its settings can have. `pointer` is
/// the JSON pointer of the `when` of a pass at the top level of the document.
pub(super) fn cannot_hold(
    (document, model): (&Document, &Model),
    (templates, profile): (&TemplateSet, &TargetProfile),
    pointer: &str,
) -> bool {
    let mentions = Mentions::of(document, model, templates, profile);
    let varied = mentions.varied(MAX_STATES);
    let settings = Settings::new(&varied, &mentions.defaults);
    let place = document.root.nearest(pointer).span;
    let condition = model.texts().iter().find(|text| text.place == place).and_then(|text| model.closed(text));
    let Some(condition) = condition else { return false };
    settings.named(&condition).into_iter().all(|at| varied[at].exhaustive)
        && settings.witness(&condition, true) == Witness::Nowhere
}

/// Returns the conditions on settings that decide about passes and axes. These are conditions of passes, conditions
/// within expressions, and the latter combined with the condition of their pass.
fn conditions(mentions: &Mentions<'_>, settings: &Settings<'_>) -> Vec<Expression> {
    let is_condition =
        |expression: &Expression| has_form_of_condition(expression) && !settings.named(expression).is_empty();
    let both = |a: &Expression, b: &Expression| Expression {
        range: a.range.clone(),
        kind: ExpressionKind::Binary(BinaryOperator::And, Box::new(a.clone()), Box::new(b.clone())),
    };
    let not = |a: &Expression| Expression {
        range: a.range.clone(),
        kind: ExpressionKind::Unary(UnaryOperator::Not, Box::new(a.clone())),
    };
    let mut found = Vec::new();
    for mention in mentions.list.iter().filter(|mention| mention.deciding) {
        let Some(expression) = &mention.expression else { continue };
        let when = mention.pass.and_then(|pass| mentions.condition_of(pass));
        let mut add = |condition: &Expression| {
            if let Some(when) = when.as_ref().filter(|when| *when != condition) {
                found.push(both(when, condition));
                found.push(both(when, &not(condition)));
            }
            found.push(condition.clone());
        };
        if is_condition(expression) {
            add(expression);
        }
        expression.visit(&mut |inner| {
            if let ExpressionKind::Conditional(condition, _, _) = &inner.kind
                && is_condition(condition)
            {
                add(condition);
            }
        });
    }
    found
}

/// Returns `true` if an expression can be a condition by its form: a name, a negation, a binary operation or a
/// conditional expression.
fn has_form_of_condition(expression: &Expression) -> bool {
    matches!(
        expression.kind,
        ExpressionKind::Name(_)
            | ExpressionKind::Unary(UnaryOperator::Not, _)
            | ExpressionKind::Binary(..)
            | ExpressionKind::Conditional(..)
    )
}

/// Returns the number of combinations of the values of the settings in `group`; `None` if it exceeds [`MAX_STATES`]. A
/// group holds indices into `varied`.
fn product(varied: &[Varied], group: &BTreeSet<usize>) -> Option<usize> {
    let size = |total: usize, at: &usize| total.checked_mul(varied[*at].values.len().max(1));
    group.iter().try_fold(1_usize, size).filter(|total| *total <= MAX_STATES)
}

/// Adds every combination of the settings of each group to `picks`, with all other settings at their defaults. Returns
/// [`Cover::Passes`], or [`Cover::Some`] if a group has too many combinations.
fn add_states(settings: &Settings<'_>, groups: Vec<BTreeSet<usize>>, picks: &mut Vec<Vec<usize>>) -> Cover {
    let groups: BTreeSet<BTreeSet<usize>> =
        groups.into_iter().map(|group| settings.rules.with_tied(group)).collect();
    let mut seen: HashSet<Vec<usize>> = picks.iter().cloned().collect();
    let mut cover = Cover::Passes;
    for group in &groups {
        let total = product(settings.varied, group).filter(|total| picks.len() + total <= MAX_TOGETHER);
        let Some(total) = total else {
            cover = Cover::Some;
            continue;
        };
        for number in 0..total {
            let pick: Vec<usize> = combination(settings.varied, group, number)
                .into_iter()
                .map(Option::unwrap_or_default)
                .collect();
            if settings.rules.allow(&pick) && seen.insert(pick.clone()) {
                picks.push(pick);
            }
        }
    }
    cover
}

/// Adds for each condition a configuration in which it is true and one in which it is false, unless `picks` has them
/// already.
fn add_witnesses(settings: &Settings<'_>, conditions: &[Expression], picks: &mut Vec<Vec<usize>>) {
    for (condition, wanted) in conditions.iter().flat_map(|each| [(each, true), (each, false)]) {
        let shows = |pick: &Vec<usize>| {
            let pick: Vec<Option<usize>> = pick.iter().copied().map(Some).collect();
            settings.holds(condition, &pick) == Some(wanted)
        };
        if picks.len() < MAX_TOGETHER
            && !picks.iter().any(shows)
            && let Witness::Found(pick) = settings.witness(condition, wanted)
        {
            picks.push(pick);
        }
    }
}

/// Returns the combination with the index `number` among the values of the settings in `group`. The result holds a
/// value index for each setting; `None` for a setting outside the group.
fn combination(varied: &[Varied], group: &BTreeSet<usize>, number: usize) -> Vec<Option<usize>> {
    let mut pick = vec![None; varied.len()];
    let mut rest = number;
    for at in group {
        let count = varied[*at].values.len().max(1);
        pick[*at] = Some(rest % count);
        rest /= count;
    }
    pick
}

/// Returns the values of a configuration that are not the defaults. `pick` holds the value index of each setting.
fn overrides(varied: &[Varied], pick: &[usize]) -> Overrides {
    let mut overrides = Overrides::default();
    for (each, at) in varied.iter().zip(pick).filter(|(_, at)| **at > 0) {
        let Some(value) = each.values.get(*at) else { continue };
        let setting = Override { name: each.name.clone(), value: value.clone(), place: value.span };
        match each.feature {
            Some(_) => overrides.features.push(setting),
            None => overrides.parameters.push(setting),
        }
    }
    overrides
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbragraph_pipeline::source::Sources;

    #[test]
    fn features_beyond_the_profile_are_off_with_all_dependants() {
        let features = |limit: u32| {
            format!(
                "\"big\": {{ \"type\": \"bool\", \"default\": true, \
                   \"required_limits\": {{ \"max_texture_dimension_2d\": {limit} }} }}, \
                 \"bigger\": {{ \"type\": \"enum\", \"values\": [\"x\", \"y\"], \"default\": \"y\", \"requires\": [\"big\"] }}, \
                 \"other\": {{ \"type\": \"bool\", \"default\": false }}"
            )
        };
        let there = configurations(&features(8192));
        assert_eq!((there.list.len(), there.number.number), (6, 6));
        let lacking = configurations(&features(8193));
        assert_eq!((lacking.list.len(), lacking.number.number), (2, 2));
        assert_eq!(lacking.varied[0].values.iter().map(Value::to_json).collect::<Vec<_>>(), [false]);
        assert_eq!(lacking.varied[1].values.iter().map(Value::to_json).collect::<Vec<_>>(), ["x"]);
    }

    fn configurations(features: &str) -> Configurations {
        let mut sources = Sources::new();
        let file = sources.add("t", format!("{{ \"features\": {{ {features} }} }}"));
        let document = umbragraph_pipeline::document::parse(&sources, file).valid().unwrap();
        Configurations::of_features(&document, &Overrides::default(), &TargetProfile::webgpu())
    }

    fn switches(count: usize) -> String {
        let one = |at: usize| format!("\"f{at:02}\": {{ \"type\": \"bool\", \"default\": false }}");
        (0..count).map(one).collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn few_features_are_combined_in_full_without_forbidden_ones() {
        assert_eq!(configurations(&switches(3)).list.len(), 8);
        let tied = configurations(
            "\"a\": { \"type\": \"bool\", \"default\": true }, \
             \"b\": { \"type\": \"bool\", \"default\": false, \"requires\": [\"a\"] }, \
             \"c\": { \"type\": \"enum\", \"values\": [\"x\", \"y\"], \"default\": \"x\", \"excludes\": [\"b\"] }",
        );
        assert_eq!((tied.list.len(), tied.cover), (5, Cover::All));
        assert_eq!(tied.number, Count { number: 5, exact: true });
    }

    #[test]
    fn of_a_group_exactly_one_feature_is_on() {
        let member = |name: &str, on: bool| {
            format!("\"{name}\": {{ \"type\": \"bool\", \"default\": {on}, \"one_of\": \"g\" }}")
        };
        let text = [member("a", true), member("b", false), member("c", false), switches(1)].join(", ");
        let grouped = configurations(&text);
        assert_eq!((grouped.list.len(), grouped.number), (6, Count { number: 6, exact: true }));
        let text = [text, switches(12).replace("\"f", "\"g")].join(", ");
        let grouped = configurations(&text);
        assert_eq!(grouped.cover, Cover::Pairs);
        let ons = |each: &Configuration| {
            each.pick[..3].iter().zip([1, 0, 0]).filter(|(a, b)| (**a == 0) == (*b == 1)).count()
        };
        assert!(grouped.list.iter().all(|each| ons(each) == 1));
    }

    #[test]
    fn many_features_are_covered_pair_by_pair() {
        let many = configurations(&switches(20));
        assert_eq!(many.cover, Cover::Pairs);
        assert_eq!(many.number.number, 1 << 20);
        assert!(many.list.len() <= 40, "{}", many.list.len());
        for one in 0..20 {
            for two in one + 1..20 {
                for values in [[0, 0], [0, 1], [1, 0], [1, 1]] {
                    let shown = many.list.iter().any(|each| [each.pick[one], each.pick[two]] == values);
                    assert!(shown, "features {one} and {two} are never {values:?}");
                }
            }
        }
    }

    #[test]
    fn diagnostics_of_configurations_name_the_fewest_choices() {
        let three = configurations(&switches(3));
        let with = |wanted: &dyn Fn(&[usize]) -> bool| -> Vec<usize> {
            (0..8).filter(|at| wanted(&three.list[*at].pick)).collect()
        };
        assert_eq!(three.describe(&with(&|_| true)), None);
        assert_eq!(
            three.describe(&with(&|pick| pick[0] == 1 && pick[2] == 1)).unwrap(),
            "in 2 of 8 configurations; the fewest choices that show it: f00=true, f02=true"
        );
        assert_eq!(
            three.describe(&with(&|pick| pick[1] == 0)).unwrap(),
            "in 4 of 8 configurations: with f01=false, which are the defaults"
        );
    }
}
