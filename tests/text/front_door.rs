//! The front door as an application meets it.

use umbragraph::low_level::expression::Value;
use umbragraph::{Error, Library, Options};

const TEXT: &str = r#"{
  "format": 1, "name": "small",
  "parameters": { "red": { "type": "f32", "default": 0.5, "min": 0, "max": 1 } },
  "features": { "wide": { "type": "bool", "default": false } },
  "presets": { "bright": { "parameters": { "red": 1 } } },
  "resources": { "target": { "texture": {
    "format": "rgba8unorm", "size": ["=wide ? 32 : 16", 16], "lifetime": "imported"
  } } },
  "passes": { "fill": { "fullscreen": {
    "shader": "fill.wgsl.jinja", "bind": { "settings": { "values": { "red": "=red" } } }, "color": [{ "to": "&target" }]
  } } }
}"#;

const SHADER: &str = "{% include 'lib/fullscreen.wgsl.jinja' %}
struct Settings { red: f32 }
@group(1) @binding(0) var<uniform> settings: Settings;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(settings.red, 0.0, 0.0, 1.0); }
";

fn library() -> Library {
    Library::new().template("fill.wgsl.jinja", SHADER)
}

fn shown(error: &Error) -> String {
    fn is_error<T: std::error::Error + Send + Sync + 'static>(_: &T) {}
    is_error(error);
    error.to_string()
}

#[test]
fn options_choose_presets_values_and_features() {
    let pipeline = library().load_text("small.json", TEXT).unwrap();
    let red = |options: Options| {
        let plan = pipeline.plan(&options).unwrap_or_else(|error| panic!("{error}"));
        let width = plan.resources["target"].size.unwrap().width;
        (plan.pipeline.parameters["red"].value.clone(), width)
    };
    let options = Options::new(16, 16);
    assert_eq!(red(options.clone()), (Value::Number(0.5), 16));
    assert_eq!(red(options.clone().preset("bright")), (Value::Number(1.0), 16));
    assert_eq!(red(options.clone().preset("bright").set("red", 0.25)), (Value::Number(0.25), 16));
    assert_eq!(red(options.feature("wide", true)), (Value::Number(0.5), 32));
}

#[test]
fn an_error_shows_every_diagnostic_and_gives_it_as_data() {
    let broken =
        TEXT.replace("\"rgba8unorm\"", "\"rgba8unrom\"").replace("fill.wgsl.jinja", "fil.wgsl.jinja");
    // Nothing but the error is kept.
    let error = library().load_text("small.json", &broken).unwrap().plan(&Options::new(16, 16)).unwrap_err();
    let text = shown(&error);
    assert!(
        text.contains("small.json:7:") && text.contains("rgba8unrom") && text.contains("fil.wgsl"),
        "{text}"
    );
    let codes: Vec<_> = error.diagnostics().iter().map(|finding| finding.code.id).collect();
    assert!(codes.len() >= 2 && codes.iter().all(|code| text.contains(code)), "{codes:?}");
    let json = error.json(error.diagnostics().iter().next().unwrap());
    assert!(json.to_string().contains("small.json"), "{json}");
    let error = library().load_text("small.json", "{ \"format\": ").unwrap_err();
    assert!(shown(&error).contains("small.json:1:"), "{error}");
    let error = Library::new().load("no such file.json").unwrap_err();
    assert!(shown(&error).contains("no such file.json"), "{error}");
    let error = Library::new().templates("no such folder").load_text("small.json", TEXT).unwrap_err();
    assert!(shown(&error).contains("no such folder"), "{error}");
    let pipeline = library().load_text("small.json", TEXT).unwrap();
    let error = pipeline.plan(&Options::new(16, 16).set("red", 7)).unwrap_err();
    assert!(
        shown(&error).contains("tests/text/front_door.rs at line") && shown(&error).contains("0 to 1"),
        "{error}"
    );
    let error = pipeline.plan(&Options::new(16, 16).preset("brihgt")).unwrap_err();
    assert!(shown(&error).contains("bright"), "{error}");
    // Neither of them has spoilt the pipeline.
    assert!(pipeline.plan(&Options::new(16, 16)).is_ok());
}

#[test]
fn documents_of_a_library_share_modules_not_diagnostics() {
    let library = library();
    let broken = TEXT.replace("\"size\"", "\"sise\"");
    assert!(library.load_text("a.json", &broken).unwrap().plan(&Options::new(16, 16)).is_err());
    assert!(library.load_text("b.json", TEXT).unwrap().plan(&Options::new(16, 16)).is_ok());
    assert!(library.load_text("c.json", &broken).unwrap().plan(&Options::new(16, 16)).is_err());
}

/// The names that `use umbragraph::…` can be followed by are few, and none of them stands in a module as well, but
/// for the prelude.
#[test]
fn every_type_has_one_path() {
    let text = include_str!("../../lib.rs");
    let (before, after) = text.split_once("pub mod prelude {").unwrap();
    let after = after.split_once("\n}\n").unwrap().1;
    let root = exported(before, "").into_iter().chain(exported(after, "")).collect::<Vec<_>>();
    assert!(root.len() <= 40 && root.contains(&"Library"), "{}: {root:?}", root.len());
    let mut all: Vec<&str> =
        ["", "    ", "        "].iter().flat_map(|indent| exported(before, indent)).collect();
    all.sort_unstable();
    let twice: Vec<&str> = all.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    assert!(twice.is_empty() && !all.contains(&"*"), "{twice:?}");
}

/// The names that items of this indentation export.
fn exported<'a>(text: &'a str, indent: &str) -> Vec<&'a str> {
    let starts = ["use ", "mod ", "fn "].map(|kind| format!("\n{indent}pub {kind}"));
    let mut names = Vec::new();
    for start in &starts {
        for (at, _) in text.match_indices(start.as_str()) {
            let rest = &text[at + start.len()..];
            let item = &rest[..rest.find([';', '(']).unwrap_or(rest.len())];
            let item =
                if start.ends_with("mod ") { item.split(' ').next().unwrap_or_default() } else { item };
            let list = item.split_once('{').map_or_else(
                || item.rsplit([':', ' ']).next().unwrap_or_default(),
                |(_, list)| list.trim_end_matches('}'),
            );
            names.extend(list.split(',').map(str::trim).filter(|name| !name.is_empty()));
        }
    }
    names
}
