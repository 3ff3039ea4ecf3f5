//! `permutations.budgets.json`: figures that are more than their budgets, and budgets that name nothing.

use std::process::Output;

use umbragraph_test_support::command::{rejected, text};

use super::lock::Project;

/// The source of a template that samples a texture as many times as an axis says.
const TAPS: &str = "@vertex fn corner(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(f32(at & 1u) * 4.0 - 1.0, f32(at >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
@fragment fn fill(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  var sum = {{ 1.0 if warm else 0.0 }};
  for (var i = 0u; i < {{ taps }}u; i++) {
    sum += sin(at.x) * sin(at.y){% if look == 'deep' %} + 0.5{% endif %};
  }
  return vec4<f32>(sum);
}
";

fn project(name: &str, budgets: &str) -> Project {
    let project = Project::new(name);
    project.write("fill.wgsl.jinja", TAPS);
    project.write("permutations.budgets.json", budgets);
    project
}

fn run(project: &Project, further: &[&str]) -> Output {
    project.run(&[&["permutations", "small.json", "--templates", ".", "--no-cache"], further].concat())
}

#[test]
fn a_figure_above_its_budget_is_an_error_at_the_budget() {
    let budgets = r#"{ "small.json": { "texts": 8, "passes": {
  "fill": { "cost": 30, "texts": 8 },
  "*": { "bindings": 0, "largest": 100 }
} } }"#;
    let project = project("budget-over", budgets);
    let errors = rejected(
        &run(&project, &[]),
        1,
        &[
            "error[UG0826]",
            "permutations.budgets.json:1:28",
            "the pipeline has 9 texts; its budget is 8",
            "permutations.budgets.json:2:21",
            "\"fill\" costs 34 with taps = 2 for webgpu, webgpu-compat; the budget is 30",
            "7 |     sum += ",
            "22 of the cost is here",
            "small.json:10",
            "\"fill\" has a text of 371 bytes for webgpu, webgpu-compat; the budget is 100",
            "\"veil\" has a text of 259 bytes for webgpu, webgpu-compat; the budget is 100",
            "4 errors",
        ],
    );
    assert!(!errors.contains("bindings for"), "{errors}");
    // Part of what is reached is not held to budgets, and reports of shards are where they come together.
    assert_eq!(run(&project, &["--config"]).status.code(), Some(0));
    let report = run(&project, &["--shard", "1/1", "--format", "json"]);
    assert_eq!(report.status.code(), Some(0));
    project.write("one.json", &text(&report.stdout));
    let merged = project.run(&["permutations", "--merge", "one.json"]);
    rejected(&merged, 1, &["\"fill\" costs 34 with taps = 2", "4 errors"]);
    let cached = ["permutations", "small.json", "--templates", ".", "--cache", "cache"];
    project.write("permutations.budgets.json", "{}");
    assert_eq!(project.run(&cached).status.code(), Some(0));
    project.write("permutations.budgets.json", budgets);
    rejected(&project.run(&cached), 1, &["4 errors"]);
}

#[test]
fn a_budget_that_names_nothing_is_an_error() {
    for (budgets, says) in [
        (r#"{ "small.json": { "passes": { "fil": {} } } }"#, "no pass \"fil\" is reached by small.json"),
        (r#"{ "small.json": { "passes": { "fill": { "costs": 1 } } } }"#, "did you mean \"cost\"?"),
        (r#"{ "small.json": { "cost": 1 } }"#, "there is no figure \"cost\""),
        (r#"{ "small.json": { "texts": -1 } }"#, "a whole number from 0 on"),
        (r#"{ "small.json": { "texts": "9" } }"#, "a whole number from 0 on"),
        (r#"{ "small.json": 9 }"#, "a budget is an object of figures, not a number"),
        (r#"{ "smal.json": {} }"#, "there is no pipeline \"smal.json\""),
        (r#"{ "./small.json": {} }"#, "the pipeline \"small.json\" is written as \"./small.json\""),
        ("[]", "budgets are an object of pipelines, not an array"),
    ] {
        let project = project("budget-invalid", budgets);
        rejected(&run(&project, &[]), 1, &["error[UG0827]", "permutations.budgets.json:1", says]);
    }
    let project = project("budget-syntax", "{");
    rejected(&run(&project, &[]), 1, &["permutations.budgets.json:1"]);
    rejected(&run(&project, &["--budgets", "none.json"]), 1, &["\"none.json\" cannot be read"]);
    assert_eq!(run(&project, &["--budgets", "none.json", "--config"]).status.code(), Some(2));
}

#[test]
fn figures_of_an_offline_compiler_are_put_into_the_report() {
    let project = project("budget-measured", "{}");
    let json = |further: &[&str]| -> serde_json::Value {
        serde_json::from_slice(&run(&project, &[&["--format", "json"], further].concat()).stdout).unwrap()
    };
    let report = json(&[]);
    let variant = &report["templates"][0]["variants"][1];
    assert!(variant["costs"]["fill"]["total"].as_u64().unwrap() > 0, "{variant:#}");
    let hash = variant["hash"].as_str().unwrap();
    let figures =
        |hash: &str| format!(r#"{{ "tool": "x 1", "variants": {{ "{hash}": {{ "cycles": 12.5 }} }} }}"#);
    project.write("measured.json", &figures(&hash[..8]));
    let measured = json(&["--measured", "measured.json"])["measured"].clone();
    assert_eq!(measured, serde_json::json!({ "tool": "x 1", "variants": { hash: { "cycles": 12.5 } } }));
    for (text, says) in [
        (figures("00000000"), "no variant of this run has the hash \"00000000\""),
        (figures(&hash[..7]), "has fewer than 8 digits"),
        (figures(hash).replace("12.5", "\"12\""), "\"cycles\" is a number"),
        ("{}".to_owned(), "\"tool\" names the compiler"),
    ] {
        project.write("measured.json", &text);
        let said = json(&["--measured", "measured.json"])["diagnostics"][0].clone();
        assert_eq!((&said["code"], &said["place"]["line"]), (&"UG0828".into(), &1.into()), "{said:#}");
        assert!(said["message"].as_str().unwrap().contains(says), "{said:#}");
    }
    rejected(&run(&project, &["--measured", "measured.json"]), 1, &["error[UG0828]", "add --format json"]);
}

#[test]
fn a_lock_shows_where_a_pass_costs_more() {
    let project = project("budget-lock", "{}");
    assert_eq!(run(&project, &["--update"]).status.code(), Some(0));
    let lock = project.read("permutations.lock");
    assert!(lock.contains("; cost 34 of fill with taps = 2\n"), "{lock}");
    project.edit("fill.wgsl.jinja", "sum += sin(at.x)", "sum += sin(at.x) * cos(at.x)");
    rejected(
        &run(&project, &["--locked"]),
        1,
        &[
            "pass \"fill\" for all profiles: cost 34 -> 44 with taps = 2: 8 texts as before",
            "7 |     sum += ",
            "32 of the cost is here",
        ],
    );
}
