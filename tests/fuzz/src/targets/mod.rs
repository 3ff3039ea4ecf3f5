//! All targets. Those that are functions make an input of choices and try it.

mod cameras;
mod documents;
mod expressions;
mod planted;
mod scenes;
mod templates;

use crate::target::{Kind, Target};

const TEXT: &str = "graph/text/src";
const PIPELINE: &str = "graph/pipeline/src";
const COMPILER: &str = "graph/compiler/src";
const SHADERS: &str = "graph/shaders/src";
const EXECUTOR: &str = "graph/executor/src";

/// All targets.
pub(crate) const TARGETS: &[Target] = &[
    Target {
        name: "documents",
        about: "pipelines with pieces changed: a plan or an error, each diagnostic inside a text",
        kind: Kind::Function(documents::documents),
        files: &[
            TEXT,
            PIPELINE,
            COMPILER,
            SHADERS,
            "session/src",
            "passes/src",
            "pipelines",
            "shaders-templates",
            "tests/broken",
        ],
        aim: 100_000,
    },
    Target {
        name: "overlays",
        about: "a session whose files change, close and hold bytes that are no text: as above",
        kind: Kind::Function(documents::overlays),
        files: &[TEXT, PIPELINE, COMPILER, "session/src", "pipelines/learn"],
        aim: 100_000,
    },
    Target {
        name: "edits",
        about: "values set, inserted, removed and moved in random documents: exact, and undone byte for byte; formatting twice is formatting once",
        kind: Kind::Tests {
            package: "umbragraph-text",
            filter: "test(random_edits_of_random_texts) + test(formatting_is_idempotent)",
            cases: 600 + 1500,
            most: 1_000,
        },
        files: &["graph/text/src/edit", "graph/text/src/document"],
        aim: 1_000_000,
    },
    Target {
        name: "templates",
        about: "templates and axes with pieces changed: variants or diagnostics, naga and all rules over each",
        kind: Kind::Function(templates::templates),
        files: &[SHADERS],
        aim: 100_000,
    },
    Target {
        name: "parameters",
        about: "parameter files with pieces changed, over a pipeline: a plan or an error",
        kind: Kind::Function(documents::parameters),
        files: &[TEXT, PIPELINE, COMPILER, "session/src", "pipelines/learn"],
        aim: 100_000,
    },
    Target {
        name: "cameras",
        about: "files of camera paths with pieces changed: a camera that can be used at each time, or an error",
        kind: Kind::Function(cameras::cameras),
        files: &["front/camera_keys.rs", "front/camera_path.rs"],
        aim: 100_000,
    },
    Target {
        name: "expressions",
        about: "expressions of random pieces: a value or an error inside the text",
        kind: Kind::Function(expressions::expressions),
        files: &["graph/text/src/expression"],
        aim: 8_000_000,
    },
    Target {
        name: "scenes",
        about: "glTF with values and bytes changed, posed at random times: a scene that can be drawn, or an error",
        kind: Kind::Function(scenes::scenes),
        files: &["scene/src", "examples/scenes"],
        aim: 100_000,
    },
    Target {
        name: "images",
        about: "PNG files with bytes changed, as textures of glTF: as above",
        kind: Kind::Function(scenes::images),
        files: &["scene/src", "examples/scenes"],
        aim: 100_000,
    },
    Target {
        name: "surroundings",
        about: "HDR pictures, .hdr and .exr, with bytes changed: colors that are numbers, or an error",
        kind: Kind::Tests {
            package: "umbragraph-cli",
            filter: "test(pictures_with_bytes_changed_are_numbers_or_errors)",
            cases: 200,
            most: 1_000,
        },
        files: &["cli/src/render/environment.rs", "cli/src/render/radiance.rs"],
        aim: 100_000,
    },
    Target {
        name: "plans",
        about: "random graphs with toggles and partial writes: the plan holds what its verifier, written apart, asks of it",
        kind: Kind::Tests {
            package: "umbragraph-verify",
            filter: "test(orders::) + test(toggles::) + test(uninitialised::) + test(writers::)",
            cases: 4 * 128 + 256 + 512 + 512,
            most: 1_000,
        },
        files: &[COMPILER, "graph/verify/src"],
        aim: 100_000,
    },
    Target {
        name: "noop",
        about: "valid pipelines that are recorded on wgpu's backend without a driver: nothing that wgpu refuses",
        kind: Kind::Tests {
            package: "umbragraph",
            filter: "test(random_pipelines::what_wgpu_rejects)",
            cases: 500,
            most: 1_000,
        },
        files: &[EXECUTOR, COMPILER, PIPELINE, SHADERS, "tests/random/random_pipelines"],
        aim: 20_000,
    },
    Target {
        name: "hosts",
        about: "live values, toggles, sizes and imports, right and wrong, on wgpu's backend without a driver: an error, or a frame",
        kind: Kind::Tests {
            package: "umbragraph",
            filter: "test(hosts_that_do_anything)",
            cases: 300,
            most: 100,
        },
        files: &[EXECUTOR, COMPILER, "tests/random/hosts.rs"],
        aim: 20_000,
    },
    Target {
        name: "frames",
        about: "random pipelines drawn on a device: each texel as a simulation on the processor says",
        kind: Kind::Tests {
            package: "umbragraph",
            filter: "test(random_pipelines::random_pipelines_draw)",
            cases: 40,
            most: 5,
        },
        files: &[EXECUTOR, COMPILER, PIPELINE, "tests/random/random_pipelines"],
        aim: 3_000,
    },
];

/// A target by its name.
pub(crate) fn named(name: &str) -> Result<&'static Target, String> {
    let names = || TARGETS.iter().map(|target| target.name).collect::<Vec<_>>().join(", ");
    let found = TARGETS.iter().chain([&planted::PLANTED]).find(|target| target.name == name);
    found.ok_or_else(|| format!("`{name}` is no target; there are {}", names()))
}
