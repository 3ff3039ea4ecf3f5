//! The JSON Schemas of pipelines, and of the other files that people write, composed of the language and the registered
//! node kinds.

mod overlays;

use schemars::{JsonSchema as _, SchemaGenerator};
use serde_json::{Value as Json, json};

use crate::node::Registry;
use crate::pipeline::schema::overlays::{PASS, for_overlays};
use umbragraph_text::language::{
    ExtensionDeclaration, ParameterFileDeclaration, PassCommon, PipelineDeclaration, SubgraphDeclaration,
};

/// The kinds of JSON files that people write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A pipeline file.
    Pipeline,
    /// An extension file: passes for the extension points of a pipeline.
    Extension,
    /// A parameter file: values of parameters and features.
    Parameters,
    /// A subgraph file, which pipelines use by its path.
    Subgraph,
}

/// The JSON Schema of pipeline files whose passes use the node kinds of a registry.
///
/// A pass is an object with the common keys and exactly one key that names a node kind.
pub fn schema(registry: &Registry) -> Json {
    schema_of(FileKind::Pipeline, registry)
}

/// The JSON Schema of a kind of file whose passes use the node kinds of a registry. A file that extends others needs no
/// required keys, and may contain null for an entry that it deletes.
pub fn schema_of(kind: FileKind, registry: &Registry) -> Json {
    let composed = schema_of_composed(kind, registry);
    match kind {
        FileKind::Pipeline | FileKind::Extension | FileKind::Subgraph => for_overlays(&composed),
        FileKind::Parameters => composed,
    }
}

/// The JSON Schema of a kind of file after it is composed with all files that it extends and includes.
pub fn schema_of_composed(kind: FileKind, registry: &Registry) -> Json {
    let settings = schemars::generate::SchemaSettings::draft2020_12();
    if kind == FileKind::Parameters {
        let generator = SchemaGenerator::new(settings);
        return generator.into_root_schema_for::<ParameterFileDeclaration>().to_value();
    }
    let mut generator = SchemaGenerator::new(settings);
    let mut properties = serde_json::Map::new();
    let common = PassCommon::json_schema(&mut generator).to_value();
    if let Some(Json::Object(common)) = common.get("properties") {
        properties.extend(common.clone());
    }
    let mut kinds = vec![json!({ "required": ["use"] })];
    for kind in registry.iter() {
        let mut settings = kind.schema(&mut generator).to_value();
        if let Json::Object(rules) = &mut settings
            && !rules.contains_key("$ref")
        {
            rules.insert("description".to_owned(), kind.summary().into());
        }
        properties.insert(kind.name().to_owned(), settings);
        kinds.push(json!({ "required": [kind.name()] }));
    }
    let pass = json!({
        "description": "A pass: one key that names its node kind, and the keys that every pass can have.",
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
        "oneOf": kinds,
    });
    let root = match kind {
        FileKind::Extension => generator.into_root_schema_for::<ExtensionDeclaration>(),
        FileKind::Subgraph => generator.into_root_schema_for::<SubgraphDeclaration>(),
        FileKind::Pipeline | FileKind::Parameters => generator.into_root_schema_for::<PipelineDeclaration>(),
    };
    let mut root = root.to_value();
    // What a group lacks, the passes have that take it over.
    for pointer in
        ["", "/$defs/SubgraphDeclaration"].map(|owner| format!("{owner}/properties/shared_settings"))
    {
        if let Some(Json::Object(groups)) = root.pointer_mut(&pointer) {
            groups.insert("additionalProperties".to_owned(), json!({ "type": "object" }));
        }
    }
    let passes = ["/properties/passes", "/$defs/SubgraphDeclaration/properties/passes"];
    for pointer in passes.into_iter().chain(["/properties/inserts/additionalProperties"]) {
        if let Some(passes) = root.pointer_mut(pointer) {
            *passes = json!({
                "description": "The passes by name.",
                "type": "object",
                "additionalProperties": { "$ref": "#/$defs/Pass" },
            });
        }
    }
    if let Some(Json::Object(definitions)) = root.get_mut("$defs") {
        definitions.insert(PASS.to_owned(), pass);
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(kind: FileKind) -> Vec<String> {
        let schema = schema_of(kind, &Registry::new());
        schema["properties"].as_object().expect("an object").keys().cloned().collect()
    }

    #[test]
    fn the_schemas_of_files_know_the_keys_that_are_read() {
        let mut known: Vec<&str> = crate::pipeline::settings::preset::KEYS.to_vec();
        known.sort_unstable();
        let mut keys_of_parameters = keys(FileKind::Parameters);
        keys_of_parameters.sort_unstable();
        assert_eq!(keys_of_parameters, known);

        let common = ["$schema", "format", "name", "description", "extends", "include", "inserts"];
        let sections =
            umbragraph_text::compose::SECTIONS.iter().copied().filter(|section| *section != "passes");
        let mut known: Vec<&str> = common.into_iter().chain(sections).collect();
        known.sort_unstable();
        let mut keys_of_extension = keys(FileKind::Extension);
        keys_of_extension.sort_unstable();
        assert_eq!(keys_of_extension, known);
    }
}
