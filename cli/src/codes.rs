//! The codes of diagnostics that only commands have.

#![allow(unreachable_pub)] // The macro serves libraries.

umbragraph::low_level::codes! {
    /// A file to compare that is neither a pipeline nor a report.
    NOT_A_REPORT = "UG0009", "not a report",
        "`umbragraph diff` compares pipelines and the reports that `umbragraph graph --format json` prints. This file has a list of passes, as a report has, but not the rest of one: it is another tool's, another version's, or the plan that `umbragraph plan --format json` prints.";
    /// A setting on the command line without a value.
    SETTING_FORM = "UG0005", "not a setting",
        "Settings on the command line are written NAME=VALUE; the value is JSON, a word of an enumeration, or `on` or `off` where a boolean is declared.";
    /// Shadows that cannot be compared with ray-traced ones.
    SCORE = "UG0812", "nothing to score",
        "`umbragraph score` asks a pipeline for its shadow term, a picture of how much of the lights arrives, white where all does, with alpha 1 where there is geometry: the picture that it makes where its parameter `debug_view` is `shadow_term`. So a pipeline declares `\"debug_view\": { \"type\": \"enum\", \"values\": [\"off\", \"shadow_term\"], \"default\": \"off\" }`, and its shaders write the visibility instead of the color then; what extends `umbragraph:base/forward.json` has the parameter, and the templates `forward`, `lit` and `deferred` have the axis `debug_mode` for it. The scene needs a light that casts shadows, and surfaces in view of its camera.\n\n`--of color` scores the picture instead, or the texture of linear colors that `--resource` names. The parameter `tone_map` needs a curve that is known to the command.";
    /// Limits on scores that are not met, or cannot be met.
    SCORE_LIMITS = "UG0813", "limits of a score",
        "The file of `umbragraph score --limits` is a JSON object with names of limits and numbers, such as `{ \"min_iou\": 0.99, \"max_leak_k2\": 0.001 }`; they are held to all lights together, and to all frames. Colors have limits of their own, such as `max_flip`. A score that does not exist, such as the leak where nothing is shadowed, meets no limit.";
    /// Parameters that cannot be tuned.
    TUNE = "UG0814", "nothing to tune",
        "`umbragraph tune --over NAME,…` searches the ranges of parameters: numbers, lists of them and booleans. A name that is no parameter, an enumeration, whose words have no order, a feature, a number without a range, and a parameter on which no pixel of the shadow term depends cannot be tuned.";
    /// A viewer that cannot be started.
    VIEWER = "UG0816", "no viewer",
        "`umbragraph view` starts the program `umbragraph-view`, which lies beside the command or on PATH. It is installed by itself, since a window needs much that the command does not: `cargo install --path view`.";
    /// A lock file that differs from the reachable shaders.
    LOCK_DIFFERS = "UG0818", "not as locked",
        "`umbragraph permutations PIPELINE... --locked` compares the shaders that the pipelines reach with `permutations.lock`: the values of axes, the number of texts, and their contents, for each pass and profile. The same command with `--update` writes what is reached into the lock; its difference shows in review what a change adds.";
    /// A lock file that cannot be read.
    LOCK_INVALID = "UG0819", "unreadable lock",
        "`permutations.lock` is written by `umbragraph permutations PIPELINE... --update`. A merge conflict in it, and a lock of another version, are solved by the same command, given all pipelines that the lock names.";
    /// A figure of shaders, such as bytes or registers, that exceeds its budget.
    BUDGET = "UG0826", "over budget",
        "`permutations.budgets.json` gives passes budgets: numbers of texts, bytes, bindings, registers and cost. Costs are counted over the shader by `umbragraph permutations` and are the same on every machine; `--verbose` prints them, `--format json` those of every variant.";
    /// A budget with an invalid value or name.
    BUDGET_INVALID = "UG0827", "invalid budget",
        "`permutations.budgets.json` is an object of pipelines by their paths from its folder. Each has `texts`, `bytes`, and `passes`: an object of passes, or `*` for all others, with `texts`, `bytes`, `largest`, `bindings`, `registers` and `cost`.";
    /// Measurements of an offline compiler that match no variant.
    MEASURED = "UG0828", "unusable measurements",
        "`--measured FILE` puts the figures of an offline compiler into the JSON report: `{ \"tool\": NAME, \"variants\": { HASH: { FIGURE: NUMBER } } }`, where a hash is one of the report, or its first eight digits or more.";
    /// Reports of shards that cannot be joined.
    SHARDS = "UG0822", "reports of shards",
        "`umbragraph permutations --merge REPORT.json...` joins the reports that `umbragraph permutations PIPELINE... --shard K/N --format json` prints, one for each K from 1 to N, of the same pipelines.";
    /// A shader test that fails.
    TEST_FAILS = "UG0823", "shader test fails",
        "An assert of a shader test does not hold: `expect(condition)`, `expect_equal(found, wanted)` or `expect_near(found, wanted, tolerance)`. The diagnostic has both values, the row of the table (`@case`), and the smallest set of axis values with which it fails. Of a row the first assert that fails is shown. A value that is not a number fails every comparison, unless the driver assumes that there are none.";
    /// A shader test that cannot be run.
    TEST_INVALID = "UG0824", "not a shader test",
        "A file of tests, `NAME.test.wgsl`, is a template. It includes the templates that it tests, and has functions with `@test`. A test with parameters has a table, a line `@case(…)` for each call. It reaches no bindings: a test has no textures and buffers.\n\n```wgsl\n{% include \"lib/falloff.wgsl.jinja\" %}\n\n@test\n@case(0.5, 1.0)\n@case(2.0, 0.25)\nfn light_falls_with_distance(distance: f32, wanted: f32) {\n    expect_near(falloff(distance), wanted, 1e-5, \"the falloff\");\n}\n```";
    /// A shader test that does not end within its time limit.
    TEST_ENDLESS = "UG0825", "shader test without an end",
        "The loops of one row of a table may take 65,000 rounds together; then they are left. No driver stops an endless loop with an error, and Mesa's in software leaves it after 65,535 rounds without a word. The rows of a variant run together, and have the time of `--timeout`, ten seconds without it; no further test is run after that.";
}
