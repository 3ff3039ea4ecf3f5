//! Work is not repeated for parts that did not change.

use std::sync::Arc;

use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::compose::{Memory, Roots};
use umbragraph::low_level::model::DeclarationKind;
use umbragraph::low_level::session::{
    Cancelled, Choice, Done, Session, Survey, Target, Template, TemplateText,
};
use umbragraph::low_level::shader::TargetProfile;

use crate::session::{InMemory, PART, WHOLE, choice, plan, session, shown, two_files};

/// The counts of work since the last call, without those of templates.
fn done(session: &mut Session) -> [usize; 5] {
    let Done { read, parsed, composed, loaded, planned, .. } = session.take_done();
    [read, parsed, composed, loaded, planned]
}

#[test]
fn sessions_can_be_moved_to_a_thread() {
    fn is_send<T: Send>() {}
    is_send::<Session>();
    let mut session = two_files();
    let answer = std::thread::spawn(move || plan(&mut session, "whole.json")).join().expect("no panic");
    assert_eq!(answer, "");
}

#[test]
fn second_answer_of_nothing_changed_does_nothing() {
    let mut session = two_files();
    assert_eq!(plan(&mut session, "whole.json"), "");
    assert_eq!(done(&mut session), [2, 2, 1, 1, 1]);
    assert_eq!(plan(&mut session, "whole.json"), "");
    assert_eq!(session.take_done(), Done::default());
    session.refresh();
    assert_eq!(plan(&mut session, "whole.json"), "");
    assert_eq!(done(&mut session), [2, 0, 0, 0, 0], "files are read, and say the same");
}

#[test]
fn another_size_plans_again_and_loads_nothing() {
    let mut session = two_files();
    assert_eq!(plan(&mut session, "whole.json"), "");
    session.take_done();
    let larger = Choice::new(TargetProfile::webgpu(), PlanOptions::new(1280, 720));
    assert!(session.plan(&Target::new("whole.json"), &larger).is_ok());
    let done = session.take_done();
    assert_eq!((done.parsed, done.composed, done.loaded, done.planned, done.proven), (0, 0, 0, 1, 0));
}

#[test]
fn second_check_of_nothing_changed_does_nothing() {
    let mut session = two_files();
    let survey = Survey::new(vec![TargetProfile::webgpu()], choice().plan);
    let mut check = || {
        let mut judges = |_: &TargetProfile| -> Box<dyn FnMut(&Arc<_>) -> Diagnostics> {
            Box::new(|_| Diagnostics::new())
        };
        let (found, diagnostics) =
            session.check(&Target::new("whole.json"), &survey, &mut judges).expect("nothing cancels");
        assert!(found.is_some() && !diagnostics.has_errors());
        session.take_done()
    };
    assert!(check().loaded == 1 && check() == Done::default());
}

/// A feature is off where a profile lacks what it requires, so no variant of it is proven for that profile.
#[test]
fn variants_are_proven_for_profiles_that_reach_them() {
    const DOCUMENT: &str = r#"{ "format": 1, "name": "x", "features": { "stored": { "type": "bool", "default": true REQUIRED } },
  "resources": { "list": { "buffer": { "size": 64, "lifetime": "imported" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "fill.wgsl.jinja", "color": [{ "to": "&target" }],
    "bind": { "list": "=stored ? &list : null" } } } } }"#;
    const FILL: &str = "{% if stored %}@group(0) @binding(0) var<storage, read> list: array<f32>;{% endif %}
@vertex fn corner(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(at & 1u) * 4.0 - 1.0, f32(at >> 1u) * 4.0 - 1.0, 0.0, {{ 'list[0]' if stored else '1.0' }});
}
@fragment fn fill() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }";
    const AXES: &str =
        r#"{ "axes": { "stored": { "type": "bool", "default": false, "own_layout": true } } }"#;
    let errors = |required: &str| {
        let text = DOCUMENT.replace("REQUIRED", required);
        let template = |name: &str, text: &str| Template {
            name: name.to_owned(),
            text: TemplateText::Text(text.into()),
        };
        let own = [template("fill.wgsl.jinja", FILL), template("fill.axes.json", AXES)];
        let files = Memory([("x.json".to_owned(), text)].into());
        let mut session =
            Session::new(InMemory(files), umbragraph::registry(), umbragraph::with_templates(own));
        let profiles = ["vulkan", "gles"].map(|name| TargetProfile::from_name(name).expect("a profile"));
        let mut judges = |_: &TargetProfile| -> Box<dyn FnMut(&Arc<_>) -> Diagnostics> {
            Box::new(|_| Diagnostics::new())
        };
        let survey = Survey::new(profiles.into(), choice().plan);
        let (_, diagnostics) =
            session.check(&Target::new("x.json"), &survey, &mut judges).expect("nothing cancels");
        shown(&diagnostics, session.sources())
    };
    assert_eq!(errors(r#", "required_limits": { "max_storage_buffers_in_vertex_stage": 1 }"#), "");
    let unstated = errors("");
    assert!(unstated.contains("UG0530") && unstated.contains("only for gles"), "{unstated}");
}

#[test]
fn comments_and_layout_load_nothing_again_and_places_move() {
    let broken = WHOLE.replace("\"&target\" }]", "\"&tagret\" }]");
    let mut session = session(&[("whole.json", &broken), ("part.json", PART)]);
    let before = plan(&mut session, "whole.json");
    assert!(before.contains("whole.json:4:") && before.contains("tagret"), "{before}");
    done(&mut session);
    session.overlay("whole.json", format!("// two\n// lines\n{}", broken.replace(": ", ":")).into_bytes());
    let after = plan(&mut session, "whole.json");
    assert!(after.contains("whole.json:6:") && after.contains("tagret"), "{after}");
    assert_eq!(done(&mut session), [1, 0, 0, 0, 0]);
    // Back to the text before.
    session.close("whole.json");
    assert_eq!(plan(&mut session, "whole.json"), before);
    assert_eq!(done(&mut session), [1, 0, 0, 0, 0]);
}

#[test]
fn edit_of_one_file_parses_that_file_alone() {
    let mut session = two_files();
    plan(&mut session, "whole.json");
    done(&mut session);
    session.overlay("part.json", PART.replace('4', "8").into_bytes());
    assert_eq!(plan(&mut session, "whole.json"), "");
    assert_eq!(done(&mut session), [1, 1, 1, 1, 1]);
}

#[test]
fn reasons_name_the_lines_that_comments_moved() {
    let mut session = two_files();
    plan(&mut session, "whole.json");
    session.overlay("whole.json", format!("// one\n{WHOLE}").into_bytes());
    let place = session.text("<name>", "fill");
    let things = session.why(&Target::new("whole.json"), &choice(), ("fill", place));
    let things = things.expect("nothing cancels").expect("a pass of this name");
    assert_eq!(things[0].declared.line, 5);
}

#[test]
fn cancelled_answer_is_none_and_the_next_is_whole() {
    let mut session = two_files();
    session.cancel().set();
    let target = Target::new("whole.json");
    assert_eq!(session.plan(&target, &choice()).err(), Some(Cancelled));
    session.cancel().clear();
    assert_eq!(plan(&mut session, "whole.json"), "");
}

#[test]
fn edited_template_renders_only_what_names_it() {
    edit_of_a_template_renders("{% include \"color.wgsl.jinja\" %}", 1);
}

#[test]
fn template_in_a_list_is_rendered_after_each_edit() {
    let list = "{% set name = \"color.wgsl.jinja\" %}{% include [name, \"lib/fullscreen.wgsl.jinja\"] %}";
    edit_of_a_template_renders(list, 2);
    let choice = "{% set name = 1 %}{% include \"lib/fullscreen.wgsl.jinja\" if name == 2 else \"color.wgsl.jinja\" %}";
    edit_of_a_template_renders(choice, 2);
}

/// Edits templates of which one includes another by a tag; the count of those rendered after an edit of a third.
fn edit_of_a_template_renders(include: &str, count_of_other: usize) {
    let shader = |color: &str| {
        format!(
            "{{% include \"lib/fullscreen.wgsl.jinja\" %}}\n\
             @fragment\nfn fill() -> @location(0) vec4<f32> {{ return vec4<f32>({color}); }}\n"
        )
    };
    let pass = |name: &str, after: &str| {
        let to = "\"color\": [{ \"to\": \"&target\", \"blend\": \"add\" }]";
        format!("\"{name}\": {{ {after}\"fullscreen\": {{ \"shader\": \"{name}.wgsl.jinja\", {to} }} }}")
    };
    let passes = [pass("one", ""), pass("two", "\"after\": [\"one\"], ")].join(", ");
    let passes = format!("\"passes\": {{ {passes} }}\n}}");
    let (before, _) = WHOLE.split_once("\"passes\"").expect("passes");
    let files = [
        ("whole.json", before.to_owned() + &passes),
        ("part.json", PART.to_owned()),
        ("one.wgsl.jinja", shader("1.0")),
        ("two.wgsl.jinja", shader(include)),
        ("color.wgsl.jinja", "0.5".to_owned()),
    ];
    let own = ["one", "two", "color"].map(|name| format!("{name}.wgsl.jinja")).map(|name| Template {
        text: TemplateText::File { path: name.clone().into(), roots: Roots::default() },
        name,
    });
    let files = files.map(|(path, text)| (path.to_owned(), text)).into_iter().collect();
    let storage = InMemory(Memory(files));
    let mut session = Session::new(storage, umbragraph::registry(), umbragraph::with_templates(own));
    let mut rendered = |path: &str, text: &str| {
        session.overlay(path, text.as_bytes());
        let found = plan(&mut session, "whole.json");
        (session.take_done().rendered, found)
    };
    assert_eq!(rendered("color.wgsl.jinja", "0.5"), (2, String::new()));
    assert_eq!(rendered("one.wgsl.jinja", &shader("0.25")), (count_of_other, String::new()));
    assert_eq!(rendered("color.wgsl.jinja", "0.75"), (1, String::new()));
    let (count, found) = rendered("color.wgsl.jinja", "missing");
    assert!(count == 1 && found.contains("missing") && found.contains("color.wgsl.jinja"), "{found}");
    assert_eq!(rendered("color.wgsl.jinja", "0.75"), (1, String::new()));
}

#[test]
fn broken_and_missing_files_leave_the_names_of_the_others() {
    let mut session = session(&[("whole.json", WHOLE)]);
    let target = Target::new("whole.json");
    let named = |session: &mut Session| -> Vec<String> {
        let loaded = session.load(&target).expect("nothing cancels");
        assert!(loaded.document().is_none(), "it is no whole document");
        let model = loaded.model().expect("a model");
        let named = [(DeclarationKind::Parameter, "side"), (DeclarationKind::Pass, "fill")];
        let known = named.into_iter().filter(|(kind, name)| model.find(*kind, name).is_some());
        known.map(|(_, name)| name.to_owned()).collect()
    };
    assert_eq!(named(&mut session), ["fill"]);
    session.overlay("part.json", PART.replace('4', "").into_bytes());
    assert_eq!(named(&mut session), ["side", "fill"]);
    session.overlay("whole.json", WHOLE.replace("\"fullscreen\": {", "\"fullscreen\": ").into_bytes());
    assert_eq!(named(&mut session), ["side", "fill"]);
}

#[test]
fn broken_file_reports_nothing_of_what_is_included_besides() {
    let mut session = session(&[("whole.json", WHOLE)]);
    let again = r#"{ "format": 1, "resources": { "target": { "buffer": { "size": 4 } } }, "passes": { "fill": {} } }"#;
    let target = Target::new("whole.json").include("captures", again);
    let (_, found) = session.plan(&target, &choice()).expect("nothing cancels");
    let found = crate::session::shown(&found, session.sources());
    assert!(found.contains("part.json") && !found.contains("captures"), "{found}");
}
