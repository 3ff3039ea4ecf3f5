//! The JSON Schema of `NAME.axes.json`, for editors.

use serde_json::{Value, json};

/// Returns the JSON Schema of a file of axes.
///
/// The schema covers the structure of a single file. References between axes and the range of defaults are checked
/// when the file is read.
pub fn schema() -> Value {
    let conditions = json!({
        "type": "array",
        "description": "Conditions on axes: `name` or `!name` for boolean axes, `name=value`, `name!=value`.",
        "items": { "type": "string" }
    });
    let values = json!({ "type": "array", "description": "The words, or formats.", "minItems": 1, "uniqueItems": true, "items": { "type": "string" } });
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Axes of a shader template",
        "description": "The axes and overrides of the template beside this file.",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "$schema": { "type": "string" },
            "description": { "type": "string" },
            "inherits": {
                "description": "Included templates, whose axes and constraints hold here too.",
                "type": "array", "items": { "type": "string" }
            },
            "axes": {
                "description": "The axes by name; a name is a WGSL identifier that starts with a letter.",
                "type": "object",
                "additionalProperties": {
                    "type": "object",
                    "additionalProperties": false,
                    "required": ["type", "default"],
                    "properties": {
                        "type": {
                            "description": "The type of the values: true and false, the words under `values`, the integers from `min` to `max`, or the texture formats under `values`.",
                            "enum": ["bool", "enum", "integer", "texture_format"]
                        },
                        "default": {
                            "description": "The value where nothing gives another.",
                            "type": ["boolean", "integer", "string"]
                        },
                        "description": { "type": "string" },
                        "as": {
                            "description": "Whether the axis is a variable of the template or a pipeline-overridable constant of the WGSL.",
                            "enum": ["template", "override"]
                        },
                        "values": values,
                        "min": { "type": "integer" },
                        "max": { "type": "integer" },
                        "prove": {
                            "description": "The integers that are proven where nothing narrows them. `all` proves each; `ends` proves the minimum, the default, the maximum, and the numbers in constraints, for a number that is only a size. Pipelines are proven with the values that they reach all the same.",
                            "enum": ["all", "ends"], "default": "all"
                        },
                        "own_layout": {
                            "description": "Whether the axis is there to choose between layouts, so that variants with different values of it may mean different things by one binding. All other variants of the template have to agree.",
                            "type": "boolean", "default": false
                        },
                        "from": {
                            "description": "The source of a boolean override that nothing gives a value: `linear_target` is true if the first color attachment of a pass has a format without `-srgb`.",
                            "enum": ["linear_target"]
                        },
                        "requires": conditions,
                        "excludes": conditions
                    }
                }
            },
            "constraints": {
                "description": "Conditions on combinations of values; a combination that breaks one is no variant.",
                "type": "array",
                "items": {
                    "type": "object",
                    "additionalProperties": false,
                    "properties": {
                        "description": { "type": "string" },
                        "when": { "description": "The condition under which the others are asked; always without it.", "type": "string" },
                        "requires": conditions,
                        "excludes": conditions,
                        "one_of": conditions
                    }
                }
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::schema;
    use umbragraph_text::diagnostic::Diagnostics;
    use umbragraph_text::source::Sources;

    fn diagnostics(text: &str) -> usize {
        let mut sources = Sources::new();
        let file = sources.add("a.axes.json", text);
        let document = umbragraph_text::document::parse(&sources, file).valid().unwrap();
        let (schema, mut diagnostics) = (schema(), Diagnostics::new());
        umbragraph_text::document::schema::Schema::new(&schema).check(&document.root, "", &mut diagnostics);
        diagnostics.len()
    }

    #[test]
    fn the_schema_accepts_own_axes_and_rejects_misspelt_ones() {
        let files =
            umbragraph_shaders_templates::FILES.iter().filter(|(name, _)| name.ends_with(".axes.json"));
        for (name, text) in files {
            assert_eq!(diagnostics(text), 0, "{name}");
        }
        assert_eq!(
            diagnostics(r#"{ "axes": { "a": { "type": "bool", "default": true, "requires": ["b"] } } }"#),
            0
        );
        assert_ne!(diagnostics(r#"{ "axes": { "a": { "type": "bool", "defualt": true } } }"#), 0);
        assert_ne!(diagnostics(r#"{ "axes": { "a": { "type": "boolean", "default": true } } }"#), 0);
    }
}
