//! Names in the documents for contributors exist, and node kinds describe themselves correctly.

use crate::common::{With, check_file, root};
use umbragraph::data::{DataShape, ValueType};
use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compose;
use umbragraph::low_level::pipeline::ResourceKind;
use umbragraph::low_level::source::Sources;
use umbragraph::work::Work;

/// The texts in backquotes that look like paths: a folder of the root, or a file of it, comes first.
fn paths(document: &str) -> Vec<&str> {
    document
        .split('`')
        .skip(1)
        .step_by(2)
        .filter(|text| !text.contains([' ', '\n', '…', '<']))
        .filter(|text| {
            let first = text.split('/').next().unwrap_or_default();
            let is_folder = text.contains('/') && first != "target" && !first.is_empty();
            is_folder || [".rs", ".md", ".json", ".toml"].iter().any(|end| text.ends_with(end))
        })
        .collect()
}

#[test]
fn files_that_documents_name_are_there() {
    for (document, min) in [("ARCHITECTURE.md", 40), ("CONTRIBUTING.md", 3)] {
        let text = std::fs::read_to_string(root().join(document)).unwrap();
        // Fenced blocks hold commands, and three backquotes would shift what is inside and what is outside.
        let prose: String = text.split("```").step_by(2).collect();
        let paths = paths(&prose);
        assert!(paths.len() >= min, "{document} names {} files", paths.len());
        for path in paths {
            assert!(root().join(path).exists(), "{document} names {path}, which is not there");
        }
    }
}

#[test]
fn node_kinds_publish_what_they_say() {
    let mut seen = std::collections::BTreeSet::new();
    let pipelines = ["awsm", "caracal", "lore", "mantis", "nebula", "umbra"];
    for path in pipelines.map(|name| format!("pipelines/{name}.json")) {
        let outcome = check_file(&path, &With::default());
        let plan = outcome.plan();
        for pass in &plan.pipeline.passes {
            let Work::Cpu(cpu) = pass.work() else { continue };
            let ResourceKind::Data(Some(shape)) = &plan.pipeline.resource(cpu.output.resource).kind else {
                panic!("{path}: {} publishes nothing", pass.name);
            };
            let kind = umbragraph::registry().get(&pass.kind).expect("a kind").published();
            let of = |shape: &DataShape| {
                let values = shape
                    .values
                    .iter()
                    .map(|one| (one.name.clone(), ValueType { count: None, ..one.value_type }));
                (
                    values.collect::<Vec<_>>(),
                    shape.sizes.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>(),
                )
            };
            let said: Vec<_> = kind.iter().map(|(_, shape)| of(shape)).collect();
            assert!(said.contains(&of(shape)) || shape.values.is_empty(), "{path}: {}", pass.name);
            assert!(shape.values.iter().all(|value| !value.description.is_empty()), "{path}: {}", pass.name);
            seen.insert(pass.kind.clone());
        }
    }
    assert!(seen.len() >= 7, "{seen:?}");
}

/// The text at a JSON pointer of a pipeline with all that it extends.
fn written(pipeline: &str, pointer: &str) -> Option<String> {
    let path = root().join(format!("pipelines/{pipeline}.json"));
    let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
    let file = umbragraph::low_level::read_source(&path, &mut sources).ok()?;
    let mut files = compose::Disk(compose::Roots::of(&path));
    let composed = compose::compose(file, &path, &mut files, &mut sources, &mut diagnostics)?;
    let value = pointer.split('/').skip(1).try_fold(&composed.document.root, |value, key| value.get(key))?;
    let text = sources.get(value.span.file)?.text().get(value.span.range())?.to_owned();
    Some(text.split_whitespace().collect::<Vec<_>>().join(" ").trim_matches('"').to_owned())
}

#[test]
fn rows_of_systems_stand_where_they_say() {
    let text = std::fs::read_to_string(root().join("docs/systems.md")).unwrap();
    let mut rows = 0;
    for line in text.lines().filter(|line| line.starts_with("| ") && line.contains('#')) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, what, value, place, _] = cells[..] else { panic!("{line}") };
        let (pipeline, pointer) = place.trim_matches('`').split_once('#').expect("PIPELINE#/POINTER");
        let found = written(pipeline, pointer).unwrap_or_else(|| panic!("{place} is not there"));
        assert!(value.contains(&found), "{what}: {place} is {found}, the document says {value}");
        rows += 1;
    }
    assert!(rows > 60, "{rows} rows");
}

#[test]
fn readme_has_at_most_ten_kilobytes() {
    let bytes = std::fs::read(root().join("README.md")).unwrap().len();
    assert!(bytes <= 10_000, "README.md has {bytes} bytes: move what is more to docs/");
}

#[test]
fn links_of_the_pages_lead_somewhere() {
    for page in ["README.md", "docs/command.md", "docs/shadows.md", "docs/accuracy.md", "docs/performance.md"]
    {
        let text = std::fs::read_to_string(root().join(page)).unwrap();
        let folder = root().join(page).parent().unwrap().to_path_buf();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let is_web = link.starts_with("https://");
            let there = folder.join(link.split('#').next().unwrap());
            assert!(is_web || there.exists(), "{page} links to {link}, which is not there");
        }
    }
}
