//! Decodes a tree with places into typed values, without an intermediate tree.

use serde::de::value::{BorrowedStrDeserializer, MapAccessDeserializer, MapDeserializer, SeqDeserializer};
use serde::de::{DeserializeOwned, Deserializer, Error as _, IntoDeserializer, MapAccess, Visitor};
use serde_json::Error;

use super::{Entry, Kind, Value};

impl Value {
    /// Decodes this JSON value into a typed value.
    ///
    /// # Errors
    /// A value that does not match the type.
    pub fn decode<T: DeserializeOwned>(&self) -> Result<T, Error> {
        T::deserialize(self)
    }
}

/// Decodes the given members of an object into a typed value.
///
/// # Errors
/// Members that do not match the type.
pub fn decode_entries<'a, T: DeserializeOwned>(entries: impl Iterator<Item = &'a Entry>) -> Result<T, Error> {
    T::deserialize(MapAccessDeserializer::new(members(entries)))
}

fn members<'de>(entries: impl Iterator<Item = &'de Entry>) -> impl MapAccess<'de, Error = Error> {
    MapDeserializer::new(entries.map(|entry| (entry.key.as_str(), &entry.value)))
}

impl<'de> IntoDeserializer<'de, Error> for &'de Value {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for &'de Value {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match &self.kind {
            Kind::Null | Kind::Missing => visitor.visit_unit(),
            Kind::Bool(value) => visitor.visit_bool(*value),
            Kind::Number(number) => number.deserialize_any(visitor),
            Kind::Text(text) => visitor.visit_borrowed_str(text),
            Kind::Array(elements) => {
                let mut left = SeqDeserializer::<_, Error>::new(elements.iter());
                let value = visitor.visit_seq(&mut left)?;
                let more = |_| Error::invalid_length(elements.len(), &"fewer elements in array");
                left.end().map_err(more).map(|()| value)
            }
            Kind::Object(entries) => visitor.visit_map(members(entries.iter())),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.kind {
            Kind::Null | Kind::Missing => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        match &self.kind {
            Kind::Text(word) => BorrowedStrDeserializer::new(word).deserialize_enum(name, variants, visitor),
            Kind::Object(entries) if entries.len() == 1 => {
                visitor.visit_enum(MapAccessDeserializer::new(members(entries.iter())))
            }
            // The error is that of `serde_json`.
            _ => self.to_json().deserialize_enum(name, variants, visitor),
        }
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use crate::language::{PassCommon, ResourceDeclaration};
    use crate::source::Sources;

    /// Returns `true` if the text decodes to the type. Panics if decoding through `serde_json::Value` gives another
    /// result or error.
    fn alike<T: serde::de::DeserializeOwned + std::fmt::Debug>(text: &str) -> bool {
        let mut sources = Sources::new();
        let file = sources.add("t", text);
        let value = crate::document::parse(&sources, file).valid().unwrap().root;
        let direct = value.decode::<T>().map_err(|error| error.to_string());
        let indirect = serde_json::from_value::<T>(value.to_json()).map_err(|error| error.to_string());
        assert_eq!(format!("{direct:?}"), format!("{indirect:?}"));
        direct.is_ok()
    }

    #[test]
    fn values_decode_as_they_do_by_way_of_an_untyped_tree() {
        let texture =
            |rest: &str| format!(r#"{{ "texture": {{ "format": ["r8unorm"], "size": [1, 2.5] {rest} }} }}"#);
        assert!(alike::<ResourceDeclaration>(&texture(
            r#", "view_dimension": "2d-array", "description": null"#
        )));
        assert!(alike::<ResourceDeclaration>(&texture(r#", "lifetime": "history", "initial": -1"#)));
        assert!(!alike::<ResourceDeclaration>(&texture(r#", "view_dimension": { "2d": 1 }"#)));
        assert!(!alike::<ResourceDeclaration>(&texture(r#", "lifetime": 3"#)));
        assert!(!alike::<ResourceDeclaration>(&texture(r#", "lifetime": "ever""#)));
        assert!(!alike::<ResourceDeclaration>(&texture(r#", "depth": 1"#)));
        assert!(!alike::<ResourceDeclaration>(r#"{ "texture": {}, "buffer": {} }"#));
        assert!(!alike::<ResourceDeclaration>(r#""texture""#));
        assert!(alike::<PassCommon>(
            r#"{ "after": ["a"], "passthrough": { "a": "&b" }, "with": { "n": [true, "x"] } }"#
        ));
        assert!(!alike::<PassCommon>(r#"{ "after": "a" }"#));
        assert!(!alike::<PassCommon>(r#"{ "side_effect": 1 }"#));
        assert!(alike::<BTreeMap<String, (u32, f32, i8)>>(r#"{ "a": [1, 2, -3] }"#));
        assert!(!alike::<BTreeMap<String, (u32, f32)>>(r#"{ "a": [1, 2, 3] }"#));
        assert!(!alike::<BTreeMap<String, u32>>(r#"{ "a": -1 }"#));
        assert!(!alike::<BTreeMap<String, u32>>(r#"{ "a": 1.5 }"#));
        assert!(!alike::<Option<u8>>("300"));
        assert!(alike::<Option<u8>>("null"));
    }
}
