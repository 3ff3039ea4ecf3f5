//! The JSON Schema of pipelines, composed of the language and the registered node kinds.

use schemars::SchemaGenerator;
use serde_json::{Value as Json, json};

use crate::language::{PassCommon, PipelineDeclaration};
use crate::node::Registry;

/// The schema of pipelines that use the node kinds of a registry.
///
/// A pass is an object with the common keys and exactly one key that names a node kind.
pub fn schema(registry: &Registry) -> Json {
    let mut generator = SchemaGenerator::new(schemars::generate::SchemaSettings::draft2020_12());
    let mut properties = serde_json::Map::new();
    let common = PassCommon::inline_schema(&mut generator);
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
    let mut root = generator.into_root_schema_for::<PipelineDeclaration>().to_value();
    for pointer in ["/properties/passes", "/$defs/SubgraphDeclaration/properties/passes"] {
        if let Some(passes) = root.pointer_mut(pointer) {
            *passes = json!({
                "description": "The passes by name.",
                "type": "object",
                "additionalProperties": { "$ref": "#/$defs/Pass" },
            });
        }
    }
    if let Some(Json::Object(definitions)) = root.get_mut("$defs") {
        definitions.insert("Pass".to_owned(), pass);
    }
    root
}

trait InlineSchema {
    fn inline_schema(generator: &mut SchemaGenerator) -> Json;
}

impl<T: schemars::JsonSchema> InlineSchema for T {
    fn inline_schema(generator: &mut SchemaGenerator) -> Json {
        T::json_schema(generator).to_value()
    }
}
