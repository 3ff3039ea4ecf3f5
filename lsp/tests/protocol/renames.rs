//! Renames keep plans, generated WGSL and diagnostics: the values of shader axes, which have the names of features,
//! parameters and derived values, among them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};
use umbragraph::diagnostic::{Diagnostic, Diagnostics};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::compose::{Files, Memory, Roots};
use umbragraph::low_level::document::{Kind, Value};
use umbragraph::low_level::edit::Edits;
use umbragraph::low_level::model::{Declaration, DeclarationKind};
use umbragraph::low_level::pipeline::{Override, Overrides, claimed_profiles};
use umbragraph::low_level::session::{
    Choice, Cursor, Planned, RenameError, Session, Storage, Survey, Target, Template, TemplateText,
};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::low_level::source::{FileId, Sources};
use umbragraph::with_templates;
use umbragraph_test_support::edits::documents;
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use crate::editor::{root, session};

/// Renamed declarations of each pipeline in ordinary tests; soak renames all.
const RENAMES: usize = 3;

/// A declaration that a test renames.
struct Renamed {
    declaration: Declaration,
    /// The path of the file that declares it.
    file: PathBuf,
    /// A value other than the default, as JSON; `None` if the test knows none.
    other: Option<Json>,
}

impl Renamed {
    fn edits(
        &self,
        session: &mut Session,
        target: &Target,
        name: &str,
    ) -> Result<BTreeMap<String, Edits>, RenameError> {
        let (choice, offset) = (choice(session, target), self.declaration.place.start as usize + 1);
        let cursor = Cursor { target, choice: &choice, path: &self.file, offset };
        session.rename(&cursor, name).expect("nothing cancels").expect("a declaration")
    }
}

pub(crate) fn choice(session: &mut Session, target: &Target) -> Choice {
    let loaded = session.load(target).expect("nothing cancels");
    let document = loaded.document().expect("a document");
    let profile = claimed_profiles(document, &mut Diagnostics::new()).into_iter().next();
    Choice::new(profile.unwrap_or_else(TargetProfile::webgpu), PlanOptions::new(640, 480))
}

/// The features, parameters and derived values of a pipeline and its subgraphs.
fn declared(session: &mut Session, target: &Target) -> Vec<Renamed> {
    use DeclarationKind as K;
    let loaded = session.load_exactly(target).expect("nothing cancels");
    let (model, document) = (loaded.model().expect("a model"), loaded.document().expect("a document"));
    let mut found = Vec::new();
    for (_, one) in model.declarations() {
        if !matches!(one.kind, K::Parameter | K::Feature | K::Derived) {
            continue;
        }
        let file = PathBuf::from(loaded.sources().get(one.place.file).expect("a file").name());
        let value = one
            .pointer
            .split('/')
            .skip(1)
            .try_fold(&document.root, |value, key| value.get(&key.replace("~1", "/").replace("~0", "~")));
        let other = value.and_then(other).filter(|_| one.owner.is_none());
        found.push(Renamed { declaration: one.clone(), file, other });
    }
    found
}

/// Another value than the default of a boolean or an enumeration.
fn other(declared: &Value) -> Option<Json> {
    let default = declared.get("default")?.to_json();
    match declared.get("type")?.text()? {
        "bool" => Some(json!(!default.as_bool()?)),
        "enum" => {
            let mut words = declared.elements_of("values").iter().map(Value::to_json);
            words.find(|word| *word != default)
        }
        _ => None,
    }
}

fn with_value(
    session: &mut Session,
    choice: Choice,
    kind: DeclarationKind,
    name: &str,
    value: &Json,
) -> Choice {
    let place = session.text("test", &value.to_string());
    let kind_of_value = match value {
        Json::Bool(value) => Kind::Bool(*value),
        other => Kind::Text(other.as_str().expect("a word").to_owned()),
    };
    let list =
        vec![Override { name: name.to_owned(), value: Value { span: place, kind: kind_of_value }, place }];
    let overrides = match kind {
        DeclarationKind::Feature => Overrides { features: list, ..Overrides::default() },
        _ => Overrides { parameters: list, ..Overrides::default() },
    };
    choice.overrides(overrides)
}

/// Replaces a name in a text, where it is a word of its own.
pub(crate) fn replaced(text: &str, name: &str, by: &str) -> String {
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let (mut found, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(name) {
        let (before, behind) = (&rest[..at], &rest[at + name.len()..]);
        let is_word = !before.ends_with(is_of_name) && !behind.starts_with(is_of_name);
        found += before;
        found += if is_word { by } else { name };
        rest = behind;
    }
    found + rest
}

/// Plan, programs and diagnostics of one configuration, with the name `new` given back as `old`.
pub(crate) fn shown(
    planned: &Planned,
    diagnostics: &Diagnostics,
    new: &str,
    old: &str,
) -> (Json, Json, Vec<String>) {
    let plan = planned.report.plan.as_deref().map(|plan| {
        let text = serde_json::to_string(plan).expect("JSON");
        serde_json::from_str(&replaced(&text, new, old)).expect("JSON")
    });
    let programs: Vec<Json> = planned
        .report
        .pipeline
        .iter()
        .flat_map(|pipeline| {
            pipeline.passes.iter().filter_map(|pass| {
                let program = pipeline.program(pass.work().program()?);
                let variants = program.variants.iter().map(|variant| {
                    json!([variant.properties, &*variant.module.wgsl, variant.module.constants])
                });
                let axes = format!("{:?}", program.axes);
                Some(json!([pass.name, program.template, axes, variants.collect::<Vec<_>>()]))
            })
        })
        .collect();
    let line = |one: &Diagnostic| replaced(&format!("{} {}", one.code.id, one.message), new, old);
    let mut lines: Vec<String> = diagnostics.iter().map(line).collect();
    lines.sort();
    (plan.unwrap_or_default(), programs.into(), lines)
}

/// Applies edits as unsaved texts of a session.
pub(crate) fn overlay(session: &mut Session, edits: &BTreeMap<String, Edits>) {
    for (file, edits) in edits {
        let text = std::fs::read_to_string(file).expect("a text");
        session.overlay(file, edits.apply(&text).expect("edits of the text").into_bytes());
    }
}

/// Renames declarations of the pipelines whose number has this remainder. Returns the numbers of renames, of those that
/// keep the old name as a derived value, and of refusals.
fn renames_keep_plans(remainder: usize, of: usize) -> [usize; 3] {
    let folder = root().join("pipelines");
    let mut session = session();
    session.set_roots(std::slice::from_ref(&folder));
    let all: std::collections::BTreeSet<String> =
        session.templates().axes_of(|_| true).into_iter().map(str::to_owned).collect();
    let (mut renamed, mut kept, mut refused) = (0, 0, 0);
    for (number, path) in documents(&folder).into_iter().enumerate().filter(|(at, _)| at % of == remainder) {
        let target = Target::new(&path);
        let loaded = session.load(&target).expect("nothing cancels");
        if loaded.document().is_none_or(|document| document.root.get("passes").is_none()) {
            continue;
        }
        let usual = choice(&mut session, &target);
        if session.plan(&target, &usual).expect("nothing cancels").0.report.plan.is_none() {
            continue;
        }
        let mut random = Random(property::seed().wrapping_mul(7_000).wrapping_add(number as u64));
        let mut cases = declared(&mut session, &target);
        random.shuffle(&mut cases);
        // Those that an axis can have the name of come first.
        cases.sort_by_key(|case| !all.contains(&case.declaration.name));
        if property::times() == 1 {
            let plain = cases.iter().position(|case| !all.contains(&case.declaration.name));
            let plain = plain.map(|at| cases.swap_remove(at));
            cases.truncate(RENAMES - 1);
            cases.extend(plain);
        }
        for case in cases {
            let Declaration { name: old, kind, .. } = &case.declaration;
            let new = random.one_of(&["a_fresh_name", "zz_fresh_name"]);
            let of = || format!("{}: {old} to {new}", path.display());
            let edits = match case.edits(&mut session, &target, new) {
                Ok(edits) => edits,
                Err(error) => {
                    assert!(error.to_string().contains(old.as_str()), "{}: {error}", of());
                    refused += 1;
                    continue;
                }
            };
            // The server refuses to change files that come with the module.
            if edits.keys().any(|file| !Path::new(file).is_absolute()) {
                refused += 1;
                continue;
            }
            let states: Vec<Option<&Json>> = [None].into_iter().chain(case.other.iter().map(Some)).collect();
            let all_shown = |session: &mut Session, name: &str| -> Vec<_> {
                let usual = choice(session, &target);
                states
                    .iter()
                    .map(|state| {
                        let choice = match state {
                            Some(value) => with_value(session, usual.clone(), *kind, name, value),
                            None => usual.clone(),
                        };
                        let (planned, diagnostics) = session.plan(&target, &choice).expect("nothing cancels");
                        shown(&planned, &diagnostics, name, old)
                    })
                    .collect()
            };
            let before = all_shown(&mut session, old);
            overlay(&mut session, &edits);
            let after = all_shown(&mut session, new);
            for (before, after) in before.iter().zip(&after) {
                assert_eq!(after.2, before.2, "diagnostics, {}", of());
                assert_eq!(after.1, before.1, "programs, {}", of());
                assert_eq!(after.0, before.0, "plan, {}", of());
            }
            let model = session.load(&target).expect("nothing cancels");
            let model = model.model().expect("a model");
            kept += usize::from(model.find(DeclarationKind::Derived, old).is_some());
            edits.keys().for_each(|file| session.close(file));
            renamed += 1;
        }
    }
    [renamed, kept, refused]
}

#[test]
fn renames_keep_plans_and_programs_in_part_1() {
    let [renamed, kept, refused] = renames_keep_plans(0, 2);
    assert!(renamed > 20 && kept > 2, "{renamed} renamed, {kept} kept, {refused} refused");
}

#[test]
fn renames_keep_plans_and_programs_in_part_2() {
    let [renamed, kept, refused] = renames_keep_plans(1, 2);
    assert!(renamed > 20 && kept > 2, "{renamed} renamed, {kept} kept, {refused} refused");
}

const TEMPLATE: &str = "{% include \"lib/fullscreen.wgsl.jinja\" %}
@fragment
fn main() -> @location(0) vec4<f32> {
    return vec4<f32>({{ '1.0' if warm else '0.0' }}, {{ taps }}.0, {{ '1.0' if night else '0.0' }}, 1.0);
}
";
const BOUND: &str = "{% include \"lib/fullscreen.wgsl.jinja\" %}
@group(0) @binding(0) var image: texture_2d<f32>;
@fragment
fn main() -> @location(0) vec4<f32> {
    return textureLoad(image, vec2<u32>(0u), 0);
}
";
const AXES: &str = r#"{ "axes": {
  "warm": { "type": "bool", "default": false, "description": "." },
  "night": { "type": "bool", "default": false, "description": "." },
  "taps": { "type": "integer", "min": 0, "max": 8, "default": 1, "description": "." }
} }"#;

/// Files in memory.
struct InMemory(Memory);

impl Storage for InMemory {
    fn read(&mut self, path: &Path, _: Option<&Roots>, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        Files::read(&mut self.0, path, sources)
    }
}

/// A session with a template of three axes, over texts by path.
fn with_texts(texts: &[(&str, &str)]) -> Session {
    let own =
        |name: &str, text: &str| Template { name: name.to_owned(), text: TemplateText::Text(text.into()) };
    let templates = with_templates([
        own("own.wgsl.jinja", TEMPLATE),
        own("own.axes.json", AXES),
        own("bound.wgsl.jinja", BOUND),
    ]);
    let files = texts.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned()));
    Session::new(InMemory(Memory(files.collect())), umbragraph::registry(), templates)
}

/// The texts after a rename of the name behind `at` in the first text, by file; or the refusal.
#[track_caller]
fn rename(texts: &[(&str, &str)], at: &str, new: &str) -> Result<Vec<String>, String> {
    let mut session = with_texts(texts);
    let (file, text) = texts[0];
    let (path, target) = (Path::new(file), Target::new(texts.last().expect("a text").0));
    let (choice, offset) = (choice(&mut session, &target), text.find(at).expect("the name") + at.len());
    let (_, diagnostics) = session.plan(&target, &choice).expect("nothing cancels");
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let before = check(&mut session, &target);
    let cursor = Cursor { target: &target, choice: &choice, path, offset };
    let edits = session.rename(&cursor, new).expect("nothing cancels").expect("a name");
    let edits = edits.map_err(|error| error.to_string())?;
    let changed: Vec<String> = texts
        .iter()
        .map(|(name, text)| {
            let edits = edits.get(*name).cloned().unwrap_or_default();
            edits.apply(text).expect("edits of the text")
        })
        .collect();
    for ((name, _), text) in texts.iter().zip(&changed) {
        session.overlay(name, text.as_bytes());
    }
    let (_, diagnostics) = session.plan(&target, &choice).expect("nothing cancels");
    assert!(diagnostics.is_empty(), "{diagnostics:?}: {changed:?}");
    assert_eq!(check(&mut session, &target), before, "{changed:?}");
    Ok(changed)
}

/// The codes of diagnostics in all configurations, and the number of shader variants.
fn check(session: &mut Session, target: &Target) -> (Vec<&'static str>, String) {
    let choice = choice(session, target);
    let survey = Survey::new(vec![choice.profile], choice.plan);
    type Judge = Box<dyn FnMut(&std::sync::Arc<umbragraph::Plan>) -> Diagnostics>;
    let mut judges = |_: &TargetProfile| -> Judge { Box::new(|_| Diagnostics::new()) };
    let (surveyed, diagnostics) = session.check(target, &survey, &mut judges).expect("nothing cancels");
    let counts = surveyed
        .map(|surveyed| format!("{:?} {}", surveyed.reachable, surveyed.configurations.list.len()))
        .unwrap_or_default();
    (diagnostics.iter().map(|one| one.code.id).collect(), counts)
}

/// A pipeline with one pass, which uses the template of three axes.
fn one_pass(sections: &str, settings: &str) -> String {
    format!(
        r#"{{
  "format": 1, "name": "one",
  {sections}
  "resources": {{
    "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}
  }},
  "passes": {{
    "fill": {{ "fullscreen": {{ "shader": "own.wgsl.jinja", {settings}"color": [{{ "to": "&target" }}] }} }}
  }}
}}
"#
    )
}

const WARM: &str = r#""features": { "warm": { "type": "bool", "default": true, "description": "." } },"#;

#[test]
fn axis_keeps_the_old_name_of_its_feature_as_derived() {
    let text = one_pass(WARM, "");
    let changed = rename(&[("one.json", &text)], "\"wa", "hot").expect("a rename");
    let kept = format!("{}\n  \"derived\": {{ \"warm\": \"=hot\" }},", WARM.replace("warm", "hot"));
    assert_eq!(changed, [text.replace(WARM, &kept)]);
    // A second rename follows the first, and leaves the derived value as it is.
    let again = rename(&[("one.json", &changed[0])], "\"ho", "hotter").expect("a rename");
    assert_eq!(again, [changed[0].replace("\"hot\"", "\"hotter\"").replace("=hot", "=hotter")]);
}

#[test]
fn derived_value_of_an_axis_is_renamed_and_kept() {
    for others in ["", r#", "z": "=1""#] {
        let derived = format!(r#""derived": {{ "warm": "=true"{others} }},"#);
        let text = one_pass(&derived, "");
        let changed = rename(&[("one.json", &text)], "\"wa", "hot").expect("a rename");
        let kept = format!(r#""derived": {{ "hot": "=true"{others}, "warm": "=hot" }},"#);
        assert_eq!(changed, [text.replace(&derived, &kept)]);
    }
}

#[test]
fn axis_that_the_pass_sets_needs_no_derived_value() {
    let text = one_pass(WARM, r#""axes": { "warm": "=warm" }, "#);
    let changed = rename(&[("one.json", &text)], "\"wa", "hot").expect("a rename");
    let expected = text.replace("\"warm\": { \"type", "\"hot\": { \"type").replace("=warm", "=hot");
    assert_eq!(changed, [expected]);
}

#[test]
fn feature_is_not_renamed_to_an_axis_by_accident() {
    let text = one_pass(WARM, "");
    let refused = rename(&[("one.json", &text)], "\"wa", "night").expect_err("a name of an axis");
    for part in ["\"night\"", "own.wgsl.jinja", "\"fill\"", "\"axes\": { \"night\": false }"] {
        assert!(refused.contains(part), "{refused}");
    }
    let set = one_pass(WARM, r#""axes": { "night": false }, "#);
    assert!(rename(&[("one.json", &set)], "\"wa", "night").is_ok());
    let refused = rename(&[("one.json", &text)], "\"wa", "viewport").expect_err("a word");
    assert!(refused.contains("viewport"), "{refused}");
}

#[test]
fn only_subgraph_files_give_axes_their_parameters() {
    let inside = |head: &str, loops: &str, body: &str| {
        format!(
            r#"{{ {head} "inputs": {{ "to": "." }},
  "parameters": {{ "taps": {{ "type": "u32", "default": 4, "description": "." }} }},
  "passes": {{
    "fill": {{ {loops} "fullscreen": {{ "shader": "own.wgsl.jinja", "color": [{{ "to": "&to" {body} }}] }} }}
  }}
}}"#
        )
    };
    let pipeline = |subgraphs: &str, used: &str, with: &str| {
        format!(
            r#"{{
  "format": 1, "name": "whole", {subgraphs}
  "resources": {{
    "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}
  }},
  "passes": {{ "part": {{ "use": "{used}", "with": {{ "to": "&target"{with} }} }} }}
}}
"#
        )
    };
    let guarded = inside("\"format\": 1,", "\"when\": \"=taps > 1\",", "");
    let whole = pipeline("", "part.json", ", \"taps\": 2");
    let changed =
        rename(&[("part.json", &guarded), ("whole.json", &whole)], "\"ta", "points").expect("a rename");
    assert!(changed[0].contains(r#""taps": "=points""#), "{}", changed[0]);
    assert_eq!(changed[1], whole.replace("taps", "points"));
    let subgraphs = format!("\"subgraphs\": {{ \"part\": {} }},", inside("", "\"when\": \"=taps > 1\",", ""));
    let whole = pipeline(&subgraphs, "part", ", \"taps\": 2");
    let changed = rename(&[("whole.json", &whole)], "\"ta", "points").expect("a rename");
    assert_eq!(changed, [whole.replace("taps", "points")]);
    // The variable of a loop stands before a parameter of its name.
    let looped = inside(
        "\"format\": 1,",
        "\"for_each\": { \"night\": [false] }, \"when\": \"=taps > 1 || night\",",
        "",
    );
    let whole = pipeline("", "part.json", "");
    let texts = [("part.json", looped.as_str()), ("whole.json", &whole)];
    let refused = rename(&texts, "\"ni", "dark").expect_err("a loop");
    assert!(refused.contains("loop") && refused.contains("\"axes\": { \"night\": \"=night\" }"), "{refused}");
    let refused = rename(&texts, "\"ta", "night").expect_err("a name that is taken");
    assert!(refused.contains("\"night\""), "{refused}");
}

#[test]
fn values_that_another_file_replaces_are_renamed_with_it() {
    let base = one_pass(
        &format!("{WARM} \"presets\": {{ \"low\": {{ \"features\": {{ \"warm\": false }} }} }},"),
        "",
    );
    let over = r#"{
  "format": 1, "name": "over", "extends": "base.json",
  "features": { "warm": { "default": false } },
  "presets": { "low": { "features": { "warm": true } } }
}
"#;
    let texts = [("base.json", base.as_str()), ("over.json", over)];
    let changed = rename(&texts, "\"wa", "hot").expect("a rename");
    assert_eq!(changed[1], over.replace("warm", "hot"));
    assert_eq!(changed[0].matches("\"hot\"").count(), 2, "{}", changed[0]);
    assert!(changed[0].contains(r#""derived": { "warm": "=hot" }"#), "{}", changed[0]);
    // The same from the file above, at the value of a preset.
    let mut session = with_texts(&texts);
    let target = Target::new("over.json");
    let choice = choice(&mut session, &target);
    let offset = over.rfind("warm").expect("the name") + 1;
    let cursor = Cursor { target: &target, choice: &choice, path: &target.path, offset };
    let (_, name) = session.renamable(&cursor).expect("nothing cancels").expect("a name");
    let edits = session.rename(&cursor, "hot").expect("nothing cancels").expect("a name").expect("a rename");
    assert_eq!((name.as_str(), edits.len()), ("warm", 2));
}

#[test]
fn derived_value_stays_in_each_file_that_declares_it() {
    let base = one_pass(r#""derived": { "warm": "=true" },"#, "");
    let over = r#"{
  "format": 1, "name": "over", "extends": "base.json",
  "derived": { "warm": "=false" }
}
"#;
    let changed = rename(&[("base.json", &base), ("over.json", over)], "\"wa", "hot").expect("a rename");
    assert!(changed[0].contains(r#""derived": { "hot": "=true", "warm": "=hot" }"#), "{}", changed[0]);
    assert!(changed[1].contains(r#""derived": { "hot": "=false", "warm": "=hot" }"#), "{}", changed[1]);
}

#[test]
fn references_of_a_binding_lead_to_wgsl_and_to_passes() {
    let pass = |to: &str| {
        format!(
            r#""fullscreen": {{
      "shader": "bound.wgsl.jinja", "bind": {{ "image": "&one" }}, "color": [{{ "to": "{to}" }}]
    }}"#
        )
    };
    let text = format!(
        r#"{{
  "format": 1, "name": "bound",
  "resources": {{
    "one": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }},
    "two": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }},
    "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}
  }},
  "passes": {{
    "paint": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&one" }}] }} }},
    "first": {{ {} }},
    "second": {{ {} }},
    "third": {{
      "fullscreen": {{
        "shader": "resample.wgsl.jinja", "bind": {{ "source": "&two" }},
        "color": [{{ "to": "&target", "blend": "add" }}]
      }}
    }}
  }}
}}
"#,
        pass("&two"),
        pass("&target")
    );
    let mut session = with_texts(&[("bound.json", &text)]);
    let target = Target::new("bound.json");
    let choice = choice(&mut session, &target);
    let offset = text.find("\"image\"").expect("a key") + 2;
    let cursor = Cursor { target: &target, choice: &choice, path: &target.path, offset };
    let places = session.references(&cursor).expect("nothing cancels");
    let shown: Vec<(String, usize)> = places
        .iter()
        .map(|place| {
            (session.sources().get(place.file).expect("a file").name().to_owned(), place.start as usize)
        })
        .collect();
    let mut expected = vec![("bound.wgsl.jinja".to_owned(), BOUND.find("image").expect("a declaration"))];
    expected.extend(text.match_indices("\"image\"").map(|(at, _)| ("bound.json".to_owned(), at)));
    assert_eq!(shown, expected);
    assert_eq!(session.definition(&cursor).expect("nothing cancels"), places[..1]);
}
