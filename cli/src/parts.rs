//! Files that are no pipelines, given to `check`: extensions, subgraphs and parameter files.
//!
//! The keys of a file tell its kind. Each file is held to the schema of its kind. Its fit with a pipeline is checked in
//! that pipeline.

use std::path::Path;

use umbragraph::low_level::pipeline::FileKind;

/// Returns one line about a valid file that is no pipeline; empty for a pipeline.
pub(crate) fn summary(path: &Path, kind: FileKind) -> String {
    let path = path.display();
    let (what, how) = match kind {
        FileKind::Pipeline => return String::new(),
        FileKind::Extension => ("an extension", format!("check PIPELINE --extension {path}")),
        FileKind::Subgraph => {
            return format!(
                "{path}: a subgraph of the form that its schema wants; check a pipeline that uses it, too: \
                 `umbragraph check PIPELINE`\n"
            );
        }
        FileKind::Parameters => ("a parameter file", format!("check PIPELINE --params {path}")),
    };
    format!("{path}: {what} of the form that its schema wants; `umbragraph {how}` checks it in a pipeline\n")
}
