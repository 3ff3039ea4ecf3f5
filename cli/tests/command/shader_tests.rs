//! `umbragraph test`: what passes, what fails and where, and what is no test.

use std::path::PathBuf;
use std::process::{Command, Output};

use umbragraph_test_support::command::{rejected, text};
use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;

/// A template of a function with two axes: the function doubles its argument if both are on.
const SCALED: &str = "{% if wide and sharp %}
fn scaled(x: f32) -> f32 { return 2.0 * x; }
{% elif wide %}
fn scaled(x: f32) -> f32 { return x + 0.0; }
{% else %}
fn scaled(x: f32) -> f32 { return x; }
{% endif %}
";
const AXES: &str = r#"{ "axes": {
    "sharp": { "type": "bool", "default": false },
    "wide": { "type": "bool", "default": false }
} }"#;
const TESTS: &str = "{% include \"scaled.wgsl.jinja\" %}

@test
@case(0.0, 0.0)
@case(0.25, 0.25)
@case(0.5, 0.5)
fn scale_is_one(x: f32, wanted: f32) {
    expect_near(scaled(x), wanted, 1e-6, \"the scale\");
}

@test
fn zero_stays() {
    expect_equal(scaled(0.0), 0);
}
";

fn command(folder: &ScratchFolder, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.current_dir(&**folder).args(arguments).output().expect("the command")
}

/// Creates a folder with `shaders/scaled.wgsl.jinja`, its axes, and a test file.
fn folder(name: &str, tests: &str) -> ScratchFolder {
    let folder = ScratchFolder::new(name);
    std::fs::create_dir_all(folder.join("shaders")).unwrap();
    let files = [("scaled.wgsl.jinja", SCALED), ("scaled.axes.json", AXES), ("scaled.test.wgsl", tests)];
    for (name, text) in files {
        std::fs::write(folder.join("shaders").join(name), text).unwrap();
    }
    folder
}

/// Runs the tests in a test file with this text; `None` without an adapter.
fn tested(name: &str, tests: &str, arguments: &[&str]) -> Option<Output> {
    gpu::device()?;
    let folder = folder(name, tests);
    let all = [&["test", "shaders/scaled.test.wgsl", "--templates", "shaders"], arguments].concat();
    Some(command(&folder, &all))
}

#[test]
fn tests_of_the_library_pass_in_every_variant() {
    if gpu::device().is_none() {
        return;
    }
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    let output = command.current_dir(root).args(["test", "shaders-templates"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "");
    let said = text(&output.stdout);
    assert!(said.lines().count() >= 6 && said.lines().all(|line| line.contains(" pass in ")), "{said}");
}

#[test]
fn failed_assert_says_values_row_axes_and_place() {
    let Some(output) = tested("shader-test-fails", TESTS, &[]) else { return };
    assert_eq!(output.status.code(), Some(1));
    let expected = "error[UG0823]: the test `scale_is_one` fails: the scale
  --> shaders/scaled.test.wgsl:8:5
  |
5 | @case(0.25, 0.25)
  |       ---------- row 2 of 3: @case(0.25, 0.25), and 1 more
  .
8 |     expect_near(scaled(x), wanted, 1e-6, \"the scale\");
  |     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
  |
  = found 0.5, wanted 0.25, which is off by 2.500e-1, and more than 1e-6
  = in 1 of 3 variants of \"shaders/scaled.test.wgsl\" (1 configuration), provoked by sharp=true, wide=true

1 error
";
    assert_eq!(text(&output.stderr), expected);
    let said = text(&output.stdout);
    assert!(said.starts_with("shaders/scaled.test.wgsl: 1 of 2 tests fails on "), "{said}");
}

#[test]
fn rows_of_each_test_are_its_own() {
    let tests = "@test\n@case(1)\n@case(2)\nfn first(x: i32) { expect_equal(x, 1); }\n@test\nfn second() {}\n\
        @test\n@case(3u)\n@case(4u)\n@case(5u)\nfn third(x: u32) { expect_equal(x + 1u, 6u); }\n";
    let Some(output) = tested("shader-test-rows", tests, &[]) else { return };
    let first = ["row 2 of 2: @case(2)", "found 2, wanted 1"];
    let third = ["row 1 of 3: @case(3u), and 1 more", "found 4, wanted 6", "2 errors"];
    rejected(&output, 1, &[&first[..], &third].concat());
}

#[test]
fn filter_chooses_tests_by_a_part_of_their_names() {
    let Some(output) = tested("shader-test-filter", TESTS, &["--filter", "stays"]) else { return };
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(said.starts_with("shaders/scaled.test.wgsl: 1 test with 1 row pass in 3 variants on "), "{said}");
    let Some(output) = tested("shader-test-no-filter", TESTS, &["--filter", "goes"]) else { return };
    rejected(&output, 1, &["UG0824", "no test has a name with \"goes\" in it"]);
}

#[test]
fn rejected_text_has_its_place_in_the_file_of_tests() {
    let tests =
        "{% include \"scaled.wgsl.jinja\" %}\n\n@test\nfn calls() {\n    expect(nothing(1.0) > 0.0);\n}\n";
    let Some(output) = tested("shader-test-rejected", tests, &[]) else { return };
    rejected(&output, 1, &["UG0520", "--> shaders/scaled.test.wgsl:5:12", "nothing"]);
    let row = "@test\n@case(true)\nfn takes(x: f32) { expect(x > 0.0); }\n";
    let Some(output) = tested("shader-test-row", row, &[]) else { return };
    rejected(&output, 1, &["UG0520", "--> shaders/scaled.test.wgsl:2:7", "`bool` to `f32`"]);
}

#[test]
fn what_cannot_be_a_test_is_said_where_it_stands() {
    let bound = "@group(0) @binding(1) var<uniform> tint: vec4<f32>;\nfn red() -> f32 { return tint.x; }\n";
    let cases = [
        (
            format!("{bound}@test\nfn reads() {{ expect(red() > 0.0); }}\n"),
            "4:4",
            "the test `reads` reaches the binding `tint`, which tests do not have",
        ),
        ("@test\nfn a(x: f32) {}\n".to_owned(), "2:4", "the test `a` has parameters, and no table"),
        ("@case(1.0)\nfn a(x: f32) {}\n".to_owned(), "1:7", "`a` has a table, and is no test"),
        (
            "@test\n@case(1.0)\nfn a(x: f32, y: f32) {}\n".to_owned(),
            "2:7",
            "the test `a` takes 2 in a row of its table, and this one has 1",
        ),
        ("@test\nfn a() { expect_near(1.0, 2.0); }\n".to_owned(), "2:10", "`expect_near` has 2 arguments"),
        (
            "@test\nfn a() { expect_equal(mat2x2<f32>(), mat2x2<f32>()); }\n".to_owned(),
            "2:10",
            "a matrix cannot be compared",
        ),
        (
            "@test\nfn a() { expect_near(1u, 2u, 0.5); }\n".to_owned(),
            "2:10",
            "`expect_near` compares floats, and this is u32",
        ),
    ];
    for (at, (tests, place, words)) in cases.into_iter().enumerate() {
        let Some(output) = tested(&format!("shader-test-invalid-{at}"), &tests, &[]) else { return };
        let place = format!("--> shaders/scaled.test.wgsl:{place}");
        rejected(&output, 1, &["error[UG0824]", words, &place, "help"]);
    }
}

#[test]
fn endless_loops_end_with_the_name_of_the_test() {
    let tests = "fn turns(x: f32) -> f32 { var y = x; loop { y = y * 0.5 + 1.0; if y < 0.0 { return y; } } return y; }\n\
        @test\nfn forever() { expect(turns(1.0) > 0.0); }\n";
    let Some(output) = tested("shader-test-endless", tests, &[]) else { return };
    let place = "--> shaders/scaled.test.wgsl:1:38";
    rejected(&output, 1, &["error[UG0825]: the test `forever` does not end", place, "65000 rounds"]);
}

#[test]
fn rows_that_take_too_long_end_with_the_time_limit() {
    let tests = "@test\n{% for at in range(3000) %}\n@case({{ at }})\n{% endfor %}\nfn slow(at: f32) {\n\
        \x20   var sum = at;\n\
        \x20   for (var i = 0; i < 60000; i++) { sum = sin(sum) + cos(sum * sum) + tan(sum); }\n\
        \x20   expect(sum < 1e30);\n}\n";
    let Some(output) = tested("shader-test-slow", tests, &["--timeout", "1"]) else { return };
    // A fast adapter ends in time.
    if output.status.code() != Some(0) {
        rejected(&output, 1, &["error[UG0825]: the test `slow` does not end within 1 s", "--timeout"]);
    }
}

#[test]
fn loops_below_the_limit_run_to_their_end() {
    let tests = "@test\nfn counts() { var sum = 0u; for (var i = 0u; i < 60000u; i++) { sum += 1u; } expect_equal(sum, 60000); }\n";
    let Some(output) = tested("shader-test-long", tests, &[]) else { return };
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[test]
fn junit_has_a_suite_for_each_file_and_a_case_for_each_test() {
    let Some(output) = tested("shader-test-junit", TESTS, &["--format", "junit"]) else { return };
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stdout);
    let unknown = tested("shader-test-junit-none", TESTS, &["--format", "junit", "--filter", "none"]);
    assert!(unknown.is_some_and(|output| text(&output.stdout).contains(r#"type="UG0824">"#)));
    for part in [
        r#"<testsuites name="umbragraph" tests="2" skipped="0" failures="1" errors="0">"#,
        r#"<testsuite name="shaders/scaled.test.wgsl" tests="2" skipped="0" errors="0" failures="1">"#,
        r#"<testcase name="scale_is_one" classname="shaders/scaled.test.wgsl">"#,
        r#"<failure message="the test `scale_is_one` fails: the scale" type="UG0823">"#,
        "provoked by sharp=true, wide=true",
        r#"<testcase name="zero_stays" classname="shaders/scaled.test.wgsl"/>"#,
    ] {
        assert!(said.contains(part), "{part} is missing in\n{said}");
    }
}

#[test]
fn json_has_tests_rows_and_variants() {
    let Some(output) = tested("shader-test-json", TESTS, &["--format", "json"]) else { return };
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let tests = &report["files"][0]["tests"];
    assert_eq!(
        tests[0],
        serde_json::json!({ "name": "scale_is_one", "rows": 3, "variants": 3, "passed": false })
    );
    assert_eq!(tests[1]["passed"], true);
    assert_eq!(report["diagnostics"][0]["provoked_by"]["wide"], true);
}

/// A pipeline whose pass sets the axis `wide`.
const PIPELINE: &str = r#"{ "format": 1, "name": "one",
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "fill.wgsl.jinja", "axes": { "wide": true }, "color": [{ "to": "&target" }] } } } }"#;
const FILL: &str = "{% include \"lib/fullscreen.wgsl.jinja\" %}
{% include \"scaled.wgsl.jinja\" %}
@fragment fn fragment(in: Covered) -> @location(0) vec4<f32> { return vec4<f32>(scaled(0.5)); }
";

#[test]
fn tests_of_a_pipeline_run_with_the_values_that_it_reaches() {
    if gpu::device().is_none() {
        return;
    }
    let folder = folder("shader-test-pipeline", TESTS);
    std::fs::write(folder.join("one.json"), PIPELINE).unwrap();
    std::fs::write(folder.join("shaders/fill.wgsl.jinja"), FILL).unwrap();
    let axes = r#"{ "inherits": ["scaled.wgsl.jinja"], "axes": {} }"#;
    std::fs::write(folder.join("shaders/fill.axes.json"), axes).unwrap();
    let output = command(&folder, &["test", "one.json", "--templates", "shaders"]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(
        said.starts_with("shaders/scaled.test.wgsl: 2 tests with 4 rows pass in 1 variant on "),
        "{said}"
    );
    let output = command(&folder, &["test", "one.json"]);
    rejected(&output, 1, &["--templates"]);
}

#[test]
fn overrides_have_the_values_of_every_pass() {
    if gpu::device().is_none() {
        return;
    }
    let folder = folder("shader-test-overrides", TESTS);
    let pass = |name: &str, level: u32| {
        let axes = format!(r#""axes": {{ "level": {level} }}"#);
        let color = r#""color": [{ "to": "&target", "blend": "add" }]"#;
        format!(r#""{name}": {{ "fullscreen": {{ "shader": "fill.wgsl.jinja", {axes}, {color} }} }}"#)
    };
    let (start, _) = PIPELINE.split_once(r#""passes""#).unwrap();
    let passes = format!("{start}\"passes\": {{ {}, {} }} }}", pass("one", 1), pass("two", 3));
    let axes = r#"{ "axes": { "level": { "type": "integer", "min": 0, "max": 3, "default": 0, "as": "override" } } }"#;
    let tests = "{% include \"level.wgsl.jinja\" %}\n@test\nfn level_is_low() { expect(level < 3u); }\n";
    for (name, text) in [
        ("level.wgsl.jinja", "override level: u32 = 0u;\n"),
        ("level.axes.json", axes),
        ("level.test.wgsl", tests),
        ("fill.wgsl.jinja", &FILL.replace("scaled(0.5)", "f32(level)").replace("scaled.", "level.")),
        ("fill.axes.json", r#"{ "inherits": ["level.wgsl.jinja"], "axes": {} }"#),
    ] {
        std::fs::write(folder.join("shaders").join(name), text).unwrap();
    }
    std::fs::write(folder.join("two.json"), passes).unwrap();
    // The tests of `scaled.wgsl.jinja`, which no pass uses, do not run.
    let output = command(&folder, &["test", "two.json", "--templates", "shaders"]);
    let failed = "in 1 of 2 variants of \"shaders/level.test.wgsl\" (1 configuration), provoked by level=3";
    rejected(&output, 1, &["the test `level_is_low` fails: `expect(level < 3u)`", failed, "\n1 error\n"]);
    let output = command(&folder, &["test", "shaders/level.test.wgsl", "--templates", "shaders"]);
    rejected(&output, 1, &["in 1 of 4 variants", "provoked by level=3"]);
}

#[test]
fn files_of_tests_change_nothing_that_pipelines_ship() {
    let folder = folder("shader-test-shipped", "@test\nthis is no WGSL {% if %}\n");
    std::fs::write(folder.join("one.json"), PIPELINE).unwrap();
    std::fs::write(folder.join("shaders/fill.wgsl.jinja"), FILL).unwrap();
    let axes = r#"{ "inherits": ["scaled.wgsl.jinja"], "axes": {} }"#;
    std::fs::write(folder.join("shaders/fill.axes.json"), axes).unwrap();
    let proofs = ["permutations", "one.json", "--templates", "shaders", "--no-cache", "--format", "json"];
    let with = command(&folder, &proofs);
    assert_eq!(with.status.code(), Some(0), "{}", text(&with.stderr));
    let shader = ["wgsl", "one.json", "--templates", "shaders"];
    let shader_with = command(&folder, &shader);
    std::fs::remove_file(folder.join("shaders/scaled.test.wgsl")).unwrap();
    assert_eq!(text(&with.stdout), text(&command(&folder, &proofs).stdout));
    assert_eq!(text(&shader_with.stdout), text(&command(&folder, &shader).stdout));
}

#[test]
fn what_has_no_tests_is_an_error() {
    let folder = folder("shader-test-none", "fn helper() {}\n");
    let file = |arguments: &[&str], words: &str| {
        let output = command(&folder, &[&["test"], arguments, &["--templates", "shaders"]].concat());
        rejected(&output, 1, &["has no shader tests", words]);
    };
    std::fs::create_dir_all(folder.join("empty")).unwrap();
    file(&["empty"], "no file below it ends in `.test.wgsl`");
    std::fs::write(folder.join("shaders/other.wgsl.jinja"), "").unwrap();
    file(&["shaders/other.wgsl.jinja"], "there is no \"shaders/other.test.wgsl\" beside it");
    if gpu::device().is_some() {
        file(&["shaders/scaled.wgsl.jinja"], "no function has the attribute `@test`");
    }
    let output = command(&folder, &["test", "missing.test.wgsl"]);
    rejected(&output, 1, &["missing.test.wgsl"]);
}

#[test]
fn without_an_adapter_tests_fail_as_render_does() {
    let folder = folder("shader-test-no-adapter", TESTS);
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.current_dir(&*folder).args(["test", "shaders", "--templates", "shaders"]);
    let output = command.env("UMBRAGRAPH_ADAPTER", "an adapter that no machine has").output().unwrap();
    rejected(&output, 1, &["UG0801", "an adapter that no machine has"]);
    assert_eq!(text(&output.stdout), "");
}

#[test]
fn adapter_without_compute_shaders_is_an_error() {
    let folder = folder("shader-test-no-compute", TESTS);
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.current_dir(&*folder).args(["test", "shaders", "--templates", "shaders", "--adapter", "(gl)"]);
    let output = command.env("MESA_EXTENSION_OVERRIDE", "-GL_ARB_compute_shader").output().unwrap();
    // Where there is no OpenGL of Mesa, its variable says nothing.
    let said = text(&output.stderr);
    if said.contains("UG0804") {
        rejected(&output, 1, &["has no compute shaders, in which tests run", "--adapter"]);
    }
    assert!(!said.contains("panicked"), "{said}");
}
