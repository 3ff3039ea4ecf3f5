//! `umbragraph schema`: prints the JSON Schema of pipelines.

use umbragraph::low_level::compose::read_bytes;
use umbragraph::low_level::pipeline::{self, FileKind};
use umbragraph::low_level::source::MAX_FILE_BYTES;

use crate::arguments::{SchemaArguments, SchemaKind};
use crate::streams::{complain, print_json};

/// Prints the JSON Schema, or compares it with a file. Returns `true` if they are equal, or if it was printed.
pub(crate) fn run(arguments: &SchemaArguments) -> bool {
    let of = |kind| pipeline::schema_of(kind, &umbragraph::registry());
    let (schema, said) = match arguments.of {
        SchemaKind::Pipeline => (of(FileKind::Pipeline), ""),
        SchemaKind::Extension => (of(FileKind::Extension), " --of extension"),
        SchemaKind::Parameters => (of(FileKind::Parameters), " --of parameters"),
        SchemaKind::Subgraph => (of(FileKind::Subgraph), " --of subgraph"),
        SchemaKind::Axes => (umbragraph::low_level::shader::axes_schema(), " --of axes"),
    };
    let Ok(text) = serde_json::to_string_pretty(&schema) else { return false };
    let Some(path) = &arguments.check else {
        print_json(&(text + "\n"));
        return true;
    };
    let committed = read_bytes(path, MAX_FILE_BYTES as u64);
    match committed {
        Ok(Some(committed)) if committed.trim_ascii_end() == text.as_bytes() => true,
        Ok(_) => {
            complain(&format!(
                "{} is not the schema of this version; write it again: umbragraph schema{said} > {0}\n",
                path.display()
            ));
            false
        }
        Err(error) => {
            complain(&format!("{} cannot be read: {error}\n", path.display()));
            false
        }
    }
}
