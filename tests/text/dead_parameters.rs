//! No parameter and no feature of any pipeline is dead: for each there is a setting of the others under which another
//! value changes a texture, an attachment, a shader, the bytes of a block, or what a CPU pass publishes.
//!
//! The settings tried are the defaults, each preset, and each other value of one boolean or enumeration.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

use crate::common::host::{crowded_frame, published, quiet_frame, sunny_frame};
use crate::common::settings::others;
use crate::common::{With, check_with, presets, root};
use serde_json::{Value as Json, json};
use umbragraph::Plan;
use umbragraph::low_level::expression::Value;
use umbragraph::low_level::language::{FeatureType, ParameterType};
use umbragraph::low_level::pipeline::TypedPipeline;
use umbragraph::work::{Draw, Work};
use umbragraph_test_support::property;

/// All that a plan makes of its parameters, as text.
fn effect(plan: &Plan) -> String {
    let mut text = String::new();
    for (name, resource) in &plan.resources {
        let _ = writeln!(text, "{name} {:?} {:?}", resource.format, resource.size);
    }
    for planned in &plan.passes {
        let work = plan.pipeline.pass(planned.handle).work();
        let _ = writeln!(
            text,
            "{} {:?} {:?} {:?}",
            planned.name, planned.variants, planned.blocks, planned.workgroups
        );
        match work {
            Work::Render(render) => {
                let _ = writeln!(text, "{:?} {:?}", render.color, render.depth);
                if let Draw::Scene(scene) = &render.draw {
                    let _ = writeln!(
                        text,
                        "{:?} {:?} {:?} {:?}",
                        scene.cull, scene.order, scene.detail, scene.redraw
                    );
                }
            }
            Work::Cpu(_) => {
                for frame in [sunny_frame(), quiet_frame(), crowded_frame()] {
                    let data = published(plan, &planned.name, &frame);
                    for name in data.shape().values.iter().map(|value| &value.name) {
                        let _ = writeln!(text, "{name} {:?}", data.words(name));
                    }
                    let sizes: Vec<_> = data.sizes().collect();
                    let _ = writeln!(text, "{:?} {:?} {sizes:?}", data.views(), data.cadences());
                }
            }
            Work::Nothing | Work::Compute(_) | Work::Transfer(_) => {}
        }
    }
    text
}

fn to_json(value: &Value) -> Json {
    serde_json::to_value(value).unwrap()
}

/// A value for one name, beside or instead of the defaults.
#[derive(Clone, Debug, Default)]
struct Context {
    preset: Option<String>,
    parameter: Option<(String, String)>,
    feature: Option<(String, String)>,
}

/// A plan, and its effect as text.
type Planned = Rc<(Arc<Plan>, String)>;

/// A context, and once it has been tried the plan there, if it is not rejected.
struct Tried {
    context: Context,
    before: Option<Option<Planned>>,
}

impl Tried {
    fn before(&mut self, subject: &Subject<'_>) -> Option<Planned> {
        let plan = || subject.plan(&self.context, None, None);
        let made = || {
            plan().map(|plan| {
                let effect = effect(&plan);
                Rc::new((plan, effect))
            })
        };
        self.before.get_or_insert_with(made).clone()
    }
}

/// Whether something holds in one of the contexts. That one is the next to be tried first: its neighbours mostly show
/// there, too.
fn first_of(contexts: &mut [Tried], holds: impl FnMut(&mut Tried) -> bool) -> bool {
    let found = contexts.iter_mut().position(holds);
    if let Some(at) = found {
        contexts[..=at].rotate_right(1);
    }
    found.is_some()
}

struct Subject<'a> {
    name: &'a str,
    text: &'a str,
}

impl Subject<'_> {
    /// The plan with these values, or `None` if they are rejected.
    fn plan(
        &self,
        context: &Context,
        parameter: Option<(&str, &str)>,
        feature: Option<(&str, &str)>,
    ) -> Option<Arc<Plan>> {
        fn pair(pair: &(String, String)) -> (&str, &str) {
            (&pair.0, &pair.1)
        }
        let parameters: Vec<(&str, &str)> = context.parameter.iter().map(pair).chain(parameter).collect();
        let features: Vec<(&str, &str)> = context.feature.iter().map(pair).chain(feature).collect();
        let with = With {
            preset: context.preset.as_deref(),
            parameters: &parameters,
            features: &features,
            ..With::default()
        };
        let outcome = check_with(self.name, self.text, &with);
        if outcome.diagnostics.has_errors() { None } else { outcome.checked.plan }
    }

    fn contexts(&self, pipeline: &TypedPipeline) -> Vec<Context> {
        let presets = presets(self.name, self.text);
        let mut contexts = vec![Context::default()];
        contexts.extend(presets.into_iter().map(|name| Context { preset: Some(name), ..Context::default() }));
        for (name, parameter) in &pipeline.parameters {
            if matches!(parameter.declaration.parameter_type, ParameterType::Enum | ParameterType::Bool) {
                contexts.extend(others(&parameter.declaration, &parameter.value).into_iter().map(|value| {
                    Context { parameter: Some((name.clone(), value.to_string())), ..Context::default() }
                }));
            }
        }
        for (name, value) in feature_values(pipeline) {
            contexts.push(Context { feature: Some((name, value)), ..Context::default() });
        }
        contexts
    }

    /// The settings that change nothing, of one out of so many of them; of all where more cases are asked for.
    fn dead(&self, out_of: u64) -> Vec<String> {
        let base = self
            .plan(&Context::default(), None, None)
            .unwrap_or_else(|| panic!("{} is not valid", self.name));
        let mut contexts: Vec<Tried> = self
            .contexts(&base.pipeline)
            .into_iter()
            .map(|context| Tried { context, before: None })
            .collect();
        let mut dead = Vec::new();
        for (name, parameter) in property::part(&base.pipeline.parameters, out_of) {
            let alive = first_of(&mut contexts, |tried| {
                let Some(known) = tried.before(self) else { return false };
                let (plan, before) = &*known;
                let now = &plan.pipeline.parameters[name].value;
                others(&parameter.declaration, now).iter().any(|value| {
                    self.plan(&tried.context, Some((name, &value.to_string())), None)
                        .is_some_and(|plan| effect(&plan) != *before)
                })
            });
            if !alive {
                dead.push(name.clone());
            }
        }
        let values = feature_values(&base.pipeline);
        let out_of = if values.len() as u64 >= out_of { out_of } else { 1 };
        for (name, value) in property::part(values, out_of) {
            let alive = first_of(&mut contexts, |tried| {
                let Some(known) = tried.before(self) else { return false };
                self.plan(&tried.context, None, Some((&name, &value)))
                    .is_some_and(|plan| effect(&plan) != known.1)
            });
            if !alive {
                dead.push(format!("{name}={value}"));
            }
        }
        dead
    }
}

/// Each feature with each value that it does not have.
fn feature_values(pipeline: &TypedPipeline) -> Vec<(String, String)> {
    let mut values = Vec::new();
    for (name, feature) in &pipeline.features {
        match (feature.declaration.feature_type, &feature.value) {
            // One of a group is switched off by another of it.
            (FeatureType::Bool, Value::Bool(true)) if feature.declaration.one_of.is_some() => {}
            (FeatureType::Bool, Value::Bool(now)) => values.push((name.clone(), (!now).to_string())),
            (_, now) => {
                let words = feature.declaration.values.iter().map(|word| json!(word));
                values.extend(
                    words.filter(|word| *word != to_json(now)).map(|word| (name.clone(), word.to_string())),
                );
            }
        }
    }
    values
}

#[test]
fn every_setting_of_every_pipeline_changes_something() {
    assert!(checked("pipelines", [1, 3]) >= 3);
}

#[test]
fn every_setting_of_the_extensions_changes_something() {
    assert!(checked("pipelines/extended", [5, 9]) >= 1);
}

/// Checks the pipelines of a folder, one out of `files`, and one out of `settings` of its settings; returns their
/// number.
fn checked(folder: &str, [files, settings]: [u64; 2]) -> usize {
    let entries = std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> =
        entries.filter(|file| file.extension().is_some_and(|end| end == "json")).collect();
    paths.sort();
    let read = |file: &PathBuf| {
        let name = format!("{folder}/{}", file.file_name().unwrap().to_string_lossy());
        (name, std::fs::read_to_string(file).unwrap())
    };
    let mut texts: Vec<_> = paths.iter().map(read).collect();
    // Those of a pipeline with very many settings take minutes: they are tried where more cases are asked for.
    if property::times() == 1 {
        texts.retain(|(name, text)| {
            let plan = Subject { name, text }.plan(&Context::default(), None, None);
            plan.map_or(0, |plan| plan.pipeline.parameters.len()) <= 40
        });
    }
    let texts = property::part(texts, files);
    let dead = texts.iter().flat_map(|(name, text)| {
        let dead = Subject { name, text }.dead(settings);
        dead.into_iter().map(move |setting| format!("{name}: {setting}"))
    });
    assert_eq!(dead.collect::<Vec<_>>(), Vec::<String>::new(), "dead settings");
    texts.len()
}

#[test]
fn a_parameter_or_feature_that_changes_nothing_is_found() {
    let text = std::fs::read_to_string(root().join("pipelines/nebula.json")).unwrap();
    let text = text
        .replacen(
            "\"far\": {",
            "\"idle\": { \"type\": \"f32\", \"default\": 1, \"min\": 0, \"max\": 9 }, \"far\": {",
            1,
        )
        .replacen(
            "\"reverse_z\": {",
            "\"idle_too\": { \"type\": \"bool\", \"default\": true }, \"reverse_z\": {",
            1,
        );
    assert_eq!(Subject { name: "pipelines/nebula.json", text: &text }.dead(1), ["idle", "idle_too=false"]);
}
