//! [`Ref`]: the place of a reference in a document.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use super::Written;

/// A reference to a resource or published data: `&` and the name, such as `"&maps"` or `"&maps@blur"`. It may also be
/// `=` and an expression that yields a reference: `"=soft ? &blurred : &maps"`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(transparent)]
pub struct Ref(pub String);

/// Prints the name without `&`, or the expression with its `=`.
impl std::fmt::Display for Ref {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match Written::of(&self.0) {
            Written::Reference(name) => name.fmt(f),
            _ => self.0.fmt(f),
        }
    }
}

impl JsonSchema for Ref {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Reference".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A reference: \"&maps\", \"&maps@blur\" for the version that a pass wrote, \"&maps@0\" for what was there before the first write, \"&maps@-1\" for the frame before, or after an equals sign an expression that yields one.",
            "type": "string",
            "pattern": "^[&=]",
        })
    }
}
