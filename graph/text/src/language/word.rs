//! [`Word`]: the place of one of a few words, or of an expression that yields one.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{DeserializeOwned, Error};
use serde::{Deserialize, Deserializer};

use super::{Expr, Written};

/// A word such as `"less-equal"`, or `=` and an expression that yields one: `"=reverse_z ? 'greater-equal' :
/// 'less-equal'"`.
#[derive(Clone, Debug, PartialEq)]
pub enum Word<T> {
    /// The literal word, decoded.
    Is(T),
    /// The expression that yields the word, with its equals sign.
    Computed(Expr),
}

impl<'de, T: DeserializeOwned> Deserialize<'de> for Word<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        match Written::of(&text) {
            Written::Expression(_) => Ok(Word::Computed(Expr(text.into()))),
            _ => serde_json::from_value(text.into()).map(Word::Is).map_err(D::Error::custom),
        }
    }
}

impl<T: JsonSchema> JsonSchema for Word<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("{}OrExpression", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let word = generator.subschema_for::<T>();
        json_schema!({
            "anyOf": [
                word,
                { "type": "string", "pattern": "^=", "description": "An expression after an equals sign: \"=reverse_z ? 'greater-equal' : 'less-equal'\"." },
            ]
        })
    }
}

/// Declares an enumeration with the variants of a WebGPU type, with descriptions for the JSON Schema and a conversion
/// into that type.
#[macro_export]
macro_rules! webgpu_words {
    ($(#[$attribute:meta])* $name:ident = $webgpu:ty { $($(#[$of_word:meta])* $word:ident,)* }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(rename_all = "kebab-case")]
        pub enum $name { $($(#[$of_word])* $word,)* }

        impl From<$name> for $webgpu {
            fn from(word: $name) -> Self {
                match word { $($name::$word => Self::$word,)* }
            }
        }
    };
}
