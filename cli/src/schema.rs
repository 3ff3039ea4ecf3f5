//! `umbragraph schema`

use umbragraph::pipeline;

use crate::arguments::SchemaArguments;

/// Prints the schema, or compares it with a file; whether they are alike.
pub(crate) fn run(arguments: &SchemaArguments) -> bool {
    let schema = pipeline::schema(&umbragraph::registry());
    let Ok(text) = serde_json::to_string_pretty(&schema) else { return false };
    let Some(path) = &arguments.check else {
        println!("{text}");
        return true;
    };
    match std::fs::read_to_string(path) {
        Ok(committed) if committed.trim_end() == text => true,
        Ok(_) => {
            eprintln!(
                "{} is not the schema of this version; write it anew: umbragraph schema > {0}",
                path.display()
            );
            false
        }
        Err(error) => {
            eprintln!("{} cannot be read: {error}", path.display());
            false
        }
    }
}
