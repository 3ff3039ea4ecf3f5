//! What the documents for contributors name is there.

mod common;

use common::root;

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
