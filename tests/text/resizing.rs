//! A plan for another size is the plan made from scratch for that size, in every pipeline of the workspace.

use crate::common::{With, check_file, root};
use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::{Objective, PlanOptions, plan};
use umbragraph::low_level::pipeline::ResourceKind;
use umbragraph_verify::verify;

#[test]
fn another_size_yields_what_planning_from_scratch_yields() {
    let mut compared = 0;
    for folder in ["pipelines", "pipelines/learn"] {
        let mut entries: Vec<_> = std::fs::read_dir(root().join(folder)).unwrap().flatten().collect();
        entries.sort_by_key(std::fs::DirEntry::file_name);
        for entry in entries.iter().filter(|entry| entry.path().extension().is_some_and(|end| end == "json"))
        {
            let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
            compared += compare(&name);
        }
    }
    assert!(compared >= 100, "{compared}");
}

/// Compares plans of one pipeline; how many.
fn compare(name: &str) -> usize {
    let outcome = check_file(name, &With::default());
    let (Some(pipeline), Some(graph)) = (&outcome.checked.pipeline, &outcome.checked.graph) else {
        panic!("{name}: {}", outcome.text());
    };
    let initial = pipeline.resources.iter().filter_map(|resource| match &resource.kind {
        ResourceKind::Data(Some(shape)) => Some((resource, shape)),
        _ => None,
    });
    let sizes: Vec<(String, u32)> = initial
        .flat_map(|(resource, shape)| {
            shape.sizes.iter().map(|(size, initial)| (format!("{}.{size}", resource.name), *initial))
        })
        .collect();
    let data =
        |change: fn(u32) -> u32| sizes.iter().map(|(name, size)| (name.clone(), change(*size))).collect();
    let mut compared = 0;
    for objective in Objective::ALL {
        let options = PlanOptions::new(640, 480).objective(objective);
        let scratch = |options: &PlanOptions| {
            let mut diagnostics = Diagnostics::new();
            plan(pipeline, graph, options, &outcome.sources, &mut diagnostics).ok_or(diagnostics)
        };
        let first = scratch(&options).unwrap_or_else(|diagnostics| panic!("{name}: {diagnostics:#?}"));
        let others = [
            options.clone().viewport([641, 479]),
            options.clone().viewport([1, 1]),
            options.clone().viewport([1920, 1080]).data_sizes(data(|size| size * 2)),
            options.clone().data_sizes(data(|size| size + 1)),
            options.clone().data_sizes(data(|_| 0)),
            options.clone().aliasing(false),
        ];
        assert_eq!(others[0].viewport, [641, 479]);
        for options in &others {
            match (first.resized(graph, options, &outcome.sources), scratch(options)) {
                (Ok(resized), Ok(scratch)) => {
                    let json = |plan| serde_json::to_string(plan).unwrap();
                    assert!(json(&resized) == json(&scratch), "{name}: {options:?}");
                    assert_eq!(verify(&resized, options), Vec::new(), "{name}");
                }
                (resized, scratch) => {
                    let words = |diagnostics: Option<Diagnostics>| {
                        diagnostics.map(|diagnostics| {
                            diagnostics.iter().map(|one| format!("{one:?}")).collect::<Vec<_>>()
                        })
                    };
                    assert_eq!(words(resized.err()), words(scratch.err()), "{name}: {options:?}");
                }
            }
            compared += 1;
        }
    }
    compared
}
