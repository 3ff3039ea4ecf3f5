//! The configurations that a pipeline reaches, those that stand for all, and the report of those that it does not
//! reach.

use super::*;

/// Creates a pipeline of passes with three features each, of which the first requires the second.
fn passes_with_features(passes: usize, template: &str) -> Project {
    let (mut features, mut resources, mut list) = (Vec::new(), Vec::new(), Vec::new());
    for at in 0..passes {
        features.push(format!(r#""a{at}": {{ "type": "bool", "default": false, "requires": ["b{at}"] }}"#));
        features.extend(
            ["b", "c"].map(|name| format!(r#""{name}{at}": {{ "type": "bool", "default": false }}"#)),
        );
        resources.push(format!(
            r#""t{at}": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}"#
        ));
        list.push(format!(
            r#""p{at}": {{ "fullscreen": {{ "shader": "fill.wgsl.jinja", "color": [{{ "to": "&t{at}" }}],
               "axes": {{ "a": "=a{at}", "b": "=b{at}", "c": "=c{at}" }} }} }}"#
        ));
    }
    let pipeline = format!(
        r#"{{ "format": 1, "name": "many", "features": {{ {} }}, "resources": {{ {} }}, "passes": {{ {} }} }}"#,
        features.join(", "),
        resources.join(", "),
        list.join(", ")
    );
    let axes = ["a", "b", "c"].map(|name| format!(r#""{name}": {{ "type": "bool", "default": false }}"#));
    let axes = format!(r#"{{ "axes": {{ {} }} }}"#, axes.join(", "));
    Project::new(&format!("permutations-many-{passes}"), &pipeline, &axes, template)
}

#[test]
fn settings_that_no_pass_mixes_factor_out() {
    let template =
        TEMPLATE.replace("0.0, 0.0, 1.0)", "f32({{ b }}), f32({{ c }}), 1.0)").replace("warm", "a");
    let covered = |passes: usize| {
        let project = passes_with_features(passes, &template);
        let output = project.run("permutations", &[]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let enumerated = covered(3);
    assert!(enumerated.contains("small.json: 216 configurations; 1 program, "), "{enumerated}");
    let factored = covered(12);
    assert!(factored.contains("small.json: 2,176,782,336 configurations, every pass in all its states in "));
    // Six of the eight values of three features, whichever way they are counted.
    for said in [enumerated, factored] {
        assert!(said.contains("(fill.wgsl.jinja): 6 combinations, 6 distinct texts"), "{said}");
    }
    // What it takes three features to show is found among them.
    let broken = format!("{{% if a and b and c %}}oops{{% endif %}}{template}");
    passes_with_features(12, &broken).rejected(&[], &["UG0520", "fill.wgsl.jinja:1:", "a=true, c=true"]);
}

/// Runs `permutations` on a bundled pipeline in which a setting selects the number of cascades; four are too many.
fn cascades_by(section: &str) -> Output {
    let folder = ScratchFolder::new(&format!("permutations-rejected-{section}"));
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../pipelines").canonicalize().unwrap();
    let base = ["scene_geometry", "forward", "hemisphere", "cascades", "fitted_cascades", "tiled_cascades"]
        .map(|name| format!("base/{name}.json"));
    for name in base.into_iter().chain(["mantis.json".to_owned()]) {
        let path = folder.join(&name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::copy(root.join(&name), path).unwrap();
    }
    let pipeline = folder.join("wide.json");
    let text = format!(
        r#"{{ "format": 1, "name": "wide", "extends": "mantis.json",
  "{section}": {{ "wide": {{ "type": "bool", "default": false }} }},
  "parameters": {{ "cascades": {{ "max": 3 }} }},
  "passes": {{ "fit": {{ "cascades": {{ "splits": {{ "count": "=wide ? 4 : cascades" }} }} }} }} }}"#
    );
    let text = if section == "parameters" {
        text.replace(
            r#"} },
  "parameters": {"#,
            r#"},"#,
        )
    } else {
        text
    };
    std::fs::write(&pipeline, text).unwrap();
    umbragraph(&["permutations", pipeline.to_str().unwrap(), "--verbose"])
}

#[test]
fn rejected_features_are_errors_and_rejected_parameters_notes() {
    let output = cascades_by("features");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("error[UG0611]: 4 cascades are wanted") && said.contains("with wide=true"),
        "{said}"
    );
    let output = cascades_by("parameters");
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(
        said.contains("note[UG0611]: 4 cascades are wanted") && said.contains("with wide=true"),
        "{said}"
    );
    let counted = text(&output.stdout);
    assert!(counted.contains(" with values that do not go together"), "{counted}");
}

#[test]
fn an_axis_of_all_32_bit_numbers_is_counted_and_not_enumerated() {
    let axes = AXES.replace(
        r#""warm":"#,
        r#""seed": { "type": "integer", "min": 0, "max": 4294967295, "default": 0 }, "warm":"#,
    );
    let project = Project::new("permutations-wide", PIPELINE, &axes, TEMPLATE);
    let output = project.run("permutations", &["--all"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).contains("fill.wgsl.jinja: 17,179,869,184 combinations, 2 distinct texts"),
        "{}",
        text(&output.stdout)
    );
    let read = TEMPLATE.replace("0.0, 0.0, 1.0);\n}\n", "f32({{ seed }}u), 0.0, 1.0);\n}\n");
    let project = Project::new("permutations-wide-read", PIPELINE, &axes, &read);
    project.rejected(&["--all"], &["UG0552", "\"prove\": \"ends\"", "\"as\": \"override\"", "--set"]);
    let said = text(&project.run("permutations", &["--all"]).stdout);
    assert!(said.contains(": at least 8 combinations, 4 distinct texts"), "{said}");
    assert!(said.contains("without effect: late\n"), "{said}");
}

/// Creates a pipeline whose conditional pass `fill` has a template that fails with `n` = 22, beside an unconditional
/// pass.
fn conditional(name: &str, settings: &str, when: &str, n: &str) -> Project {
    let pipeline = format!(
        r#"{{ "format": 1, "name": "small", {settings},
          "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
          "subgraphs": {{ "part": {{ "parameters": {{ "level": {{ "type": "u32", "default": 0 }} }}, "inputs": {{ "to": "where it draws" }}, "passes": {{
            "inner": {{ "when": "=level == 1234568", "fullscreen": {{ "shader": "fill.wgsl.jinja", "color": [{{ "to": "&to" }}], "axes": {{ "n": 22 }} }} }} }} }} }},
          "passes": {{
            "always": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target" }}] }} }},
            "fill": {{ {when} "fullscreen": {{ "shader": "fill.wgsl.jinja", "color": [{{ "to": "&target" }}], "axes": {{ "n": {n} }} }} }} }} }}"#
    );
    let axes = r#"{ "axes": { "n": { "type": "integer", "min": 0, "max": 10000, "default": 1 } } }"#;
    let template = TEMPLATE.replace("{{ 1.0 if warm else 0.0 }}", "{{ 'oops' if n == 22 else 0.0 }}");
    Project::new(name, &pipeline, axes, &template)
}

fn number(kind: &str, max: u32) -> String {
    format!(
        r#""parameters": {{ "k": {{ "type": "{kind}", "default": 1, "min": 0, "max": {max}, "unit": "1" }} }}"#
    )
}

#[test]
fn a_pass_that_few_configurations_have_is_proven() {
    let features: Vec<String> =
        (0..24).map(|at| format!("\"a{at}\": {{ \"type\": \"bool\", \"default\": false }}")).collect();
    let features = format!("\"features\": {{ {} }}", features.join(", "));
    let alternating: Vec<String> =
        (0..24).map(|at| format!("{}a{at}", if at % 2 == 0 { "" } else { "!" })).collect();
    for (name, settings, when) in [
        ("small-range", number("u32", 16), "k == 3"),
        ("wide-range", number("u32", 4_000_000_000), "k == 1234567 && k % 2 == 1"),
        ("real", number("f32", 4), "k > 1.0 && k < 2.0"),
        ("features", features, &alternating.join(" && ")),
    ] {
        let project = conditional(
            &format!("permutations-few-{name}"),
            &settings,
            &format!("\"when\": \"={when}\","),
            "22",
        );
        project.rejected(&[], &["`oops`", "fill.wgsl.jinja:5"]);
    }
}

#[test]
fn a_pass_that_no_configuration_has_is_told() {
    let of_preset = format!(
        "{}, \"presets\": {{ \"rare\": {{ \"parameters\": {{ \"k\": 1234567 }} }} }}",
        number("u32", 4_000_000_000)
    );
    // What a subgraph is given hides the condition.
    let used = |settings: &str, name: &str| {
        let project = conditional(name, settings, "", "1");
        let path = project.folder.join("small.json");
        let pipeline = std::fs::read_to_string(&path).unwrap().replace(
            "\"always\":",
            "\"use\": { \"use\": \"part\", \"with\": { \"level\": \"=k + 1\", \"to\": \"&target\" } }, \"always\":",
        );
        std::fs::write(path, pipeline).unwrap();
        project
    };
    let project = used(&number("u32", 4_000_000_000), "permutations-untried");
    let errors = project.rejected(&[], &["UG0553", "\"inner\"", "small.json:4:", "preset", "--set"]);
    assert!(!errors.contains("oops"), "{errors}");
    project.rejected(&["--set", "k=1234567"], &["`oops`"]);
    used(&of_preset, "permutations-untried-preset").rejected(&[], &["`oops`"]);

    let never = conditional("permutations-never", &number("u32", 16), "\"when\": \"=k == 30\",", "22");
    let output = never.run("permutations", &[]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("warning[UG0553]: no configuration has the pass \"fill\""), "{said}");
    let off = conditional("permutations-off", &number("u32", 16), "\"when\": false,", "22");
    let output = off.run("permutations", &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(!text(&output.stderr).contains("UG0553"), "{}", text(&output.stderr));
    // The same where there are further configurations that are not gone through.
    let mixed = number("u32", 16)
        .replace("{ \"k\"", "{ \"x\": { \"type\": \"f32\", \"default\": 0, \"unit\": \"1\" }, \"k\"");
    let never = conditional("permutations-never-too", &mixed, "\"when\": \"=k == 30\",", "\"x > 1 ? 1 : 0\"");
    let output = never.run("permutations", &[]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("warning[UG0553]"), "{}", text(&output.stderr));
}

#[test]
fn an_axis_has_only_the_values_that_its_expression_yields() {
    // No k yields 22: the values are tried one by one, or yielded by the expression alone.
    for (max, combinations) in [(40, "41"), (300, "301")] {
        let name = format!("permutations-yielded-{max}");
        let project = conditional(&name, &number("u32", max), "", "\"=k * 2 + 1\"");
        let output = project.run("permutations", &[]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let said = text(&output.stdout);
        assert!(
            said.contains(&format!("small.fill (fill.wgsl.jinja): {combinations} combinations")),
            "{said}"
        );
        let project = conditional(&name, &number("u32", max), "", "\"=k * 2\"");
        project.rejected(&[], &["`oops`", "n=22"]);
        let project = conditional(&name, &number("u32", max), "\"when\": \"=k != 11\",", "\"=k * 2\"");
        let output = project.run("permutations", &[]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }
    // Beyond, every value of the axis counts, and the diagnostic says so.
    let project = conditional("permutations-assumed", &number("u32", 5000), "", "\"=k * 2 + 1\"");
    project.rejected(&[], &["`oops`", "n=22", "\"n\" follows \"=k * 2 + 1\", which has too many values"]);
    // Of a number that is only a size the ends are proven, whatever it follows.
    for max in [300, 5000] {
        let project = conditional("permutations-size", &number("u32", max), "", "\"=k * 2\"");
        let axes = project.folder.join("fill.axes.json");
        let ends = std::fs::read_to_string(&axes).unwrap().replace("1 } }", "1, \"prove\": \"ends\" } }");
        std::fs::write(&axes, ends).unwrap();
        let output = project.run("permutations", &[]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(
            text(&output.stdout).contains("fill.wgsl.jinja): 3 combinations"),
            "{}",
            text(&output.stdout)
        );
    }
}

/// Creates a pipeline with one pass and a template that fails with `n` = 22. The axis `k` has more values than are
/// tried.
fn one_pass(name: &str, derived: &str, subgraphs: &str, pass: &str) -> Project {
    let pipeline = format!(
        r#"{{ "format": 1, "name": "small", {}, {derived}
          "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
          {subgraphs} "passes": {{ "fill": {{ {pass} }} }} }}"#,
        number("u32", 300)
    );
    let axes = r#"{ "axes": { "n": { "type": "integer", "min": 0, "max": 1000, "default": 1 } } }"#;
    Project::new(
        name,
        &pipeline,
        axes,
        &TEMPLATE.replace("{{ 1.0 if warm else 0.0 }}", "{{ 'oops' if n == 22 else 0.0 }}"),
    )
}

const FILL: &str = r#""shader": "fill.wgsl.jinja", "color": [{ "to": "&target" }]"#;

#[test]
fn a_derived_value_reaches_passes_that_say_nothing_themselves() {
    let derived = r#""derived": { "n": "=k * 1" },"#;
    let by_name = format!("\"fullscreen\": {{ {FILL} }}");
    one_pass("permutations-by-name", derived, "", &by_name).rejected(&[], &["`oops`", "n=22"]);
    let own = format!("\"fullscreen\": {{ {FILL}, \"axes\": {{ \"n\": 3 }} }}");
    let never = format!("\"when\": \"=k != 22\", {by_name}");
    for (name, pass, combinations) in
        [("own", &own, "1 combination,"), ("never", &never, "300 combinations,")]
    {
        let output =
            one_pass(&format!("permutations-by-name-{name}"), derived, "", pass).run("permutations", &[]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let said = text(&output.stdout);
        assert!(said.contains(&format!("small.fill (fill.wgsl.jinja): {combinations}")), "{said}");
    }
    // The condition says nothing of the values that the axis has.
    let undecided = format!("\"when\": \"=k != 23\", {by_name}");
    one_pass("permutations-by-name-undecided", derived, "", &undecided).rejected(&[], &["`oops`", "n=22"]);
}

#[test]
fn an_axis_follows_numbers_through_loops_and_subgraphs() {
    let looped = format!(
        "\"for_each\": {{ \"i\": \"=[k, 7]\" }}, \"fullscreen\": {{ {}, \"axes\": {{ \"n\": \"=i\" }} }}",
        FILL.replace("&target\"", "&target\", \"blend\": \"add\"")
    );
    let part = format!(
        r#""subgraphs": {{ "part": {{ "parameters": {{ "level": {{ "type": "u32", "default": 0 }} }}, "inputs": {{ "to": "where it draws" }},
           "passes": {{ "inner": {{ "fullscreen": {{ {}, "axes": {{ "n": "=level + 0" }} }} }} }} }} }},"#,
        FILL.replace("&target", "&to")
    );
    let used = r#""use": "part", "with": { "level": "=k", "to": "&target" }"#;
    for derived in ["", "\"derived\": { \"n\": \"=k * 1\" },"] {
        one_pass("permutations-through-loop", derived, "", &looped).rejected(&[], &["`oops`", "n=22"]);
        one_pass("permutations-through-subgraph", derived, &part, used).rejected(&[], &["`oops`", "n=22"]);
    }
}
