//! From a tree with places to typed values, without a tree of another kind between them.

use serde::de::value::{BorrowedStrDeserializer, MapAccessDeserializer};
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Error as _, MapAccess, SeqAccess,
    Unexpected, VariantAccess, Visitor,
};
use serde_json::Error;

use super::{Entry, Kind, Value};

impl Value {
    /// The typed value that this one describes.
    ///
    /// # Errors
    /// The error: the value does not fit the type.
    pub fn decode<T: DeserializeOwned>(&self) -> Result<T, Error> {
        T::deserialize(self)
    }
}

/// The typed value that these members of an object describe.
///
/// # Errors
/// The error: the value does not fit the type.
pub fn decode_entries<'a, T: DeserializeOwned>(entries: impl Iterator<Item = &'a Entry>) -> Result<T, Error> {
    T::deserialize(MapAccessDeserializer::new(Entries { entries, value: None }))
}

impl<'de> Deserializer<'de> for &'de Value {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match &self.kind {
            Kind::Null => visitor.visit_unit(),
            Kind::Bool(value) => visitor.visit_bool(*value),
            Kind::Number(number) => number.deserialize_any(visitor),
            Kind::Text(text) => visitor.visit_borrowed_str(text),
            Kind::Array(elements) => {
                let mut left = Elements(elements.iter());
                let value = visitor.visit_seq(&mut left)?;
                match left.0.len() {
                    0 => Ok(value),
                    _ => Err(Error::invalid_length(elements.len(), &"fewer elements in array")),
                }
            }
            Kind::Object(entries) => visitor.visit_map(Entries { entries: entries.iter(), value: None }),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.kind {
            Kind::Null => visitor.visit_none(),
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
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        match &self.kind {
            Kind::Text(name) => visitor.visit_enum(Variant { name, value: None }),
            Kind::Object(entries) => match entries.as_slice() {
                [entry] => visitor.visit_enum(Variant { name: &entry.key, value: Some(&entry.value) }),
                _ => Err(Error::invalid_value(Unexpected::Map, &"map with a single key")),
            },
            _ => Err(Error::invalid_type(self.unexpected(), &"string or map")),
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

impl Value {
    fn unexpected(&self) -> Unexpected<'_> {
        match &self.kind {
            Kind::Null => Unexpected::Unit,
            Kind::Bool(value) => Unexpected::Bool(*value),
            Kind::Number(number) => match (number.as_u64(), number.as_i64()) {
                (Some(whole), _) => Unexpected::Unsigned(whole),
                (_, Some(whole)) => Unexpected::Signed(whole),
                _ => Unexpected::Float(number.as_f64().unwrap_or_default()),
            },
            Kind::Text(text) => Unexpected::Str(text),
            Kind::Array(_) => Unexpected::Seq,
            Kind::Object(_) => Unexpected::Map,
        }
    }
}

struct Elements<'de>(std::slice::Iter<'de, Value>);

impl<'de> SeqAccess<'de> for Elements<'de> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Error> {
        self.0.next().map(|value| seed.deserialize(value)).transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

struct Entries<'de, I> {
    entries: I,
    value: Option<&'de Value>,
}

impl<'de, I: Iterator<Item = &'de Entry>> MapAccess<'de> for Entries<'de, I> {
    type Error = Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Error> {
        let Some(entry) = self.entries.next() else { return Ok(None) };
        self.value = Some(&entry.value);
        seed.deserialize(BorrowedStrDeserializer::new(&entry.key)).map(Some)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, Error> {
        match self.value.take() {
            Some(value) => seed.deserialize(value),
            None => Err(Error::custom("value is missing")),
        }
    }
}

struct Variant<'de> {
    name: &'de str,
    value: Option<&'de Value>,
}

impl<'de> EnumAccess<'de> for Variant<'de> {
    type Error = Error;
    type Variant = Self;

    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Self), Error> {
        Ok((seed.deserialize(BorrowedStrDeserializer::new(self.name))?, self))
    }
}

impl<'de> VariantAccess<'de> for Variant<'de> {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        match self.value {
            Some(value) => serde::Deserialize::deserialize(value),
            None => Ok(()),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Error> {
        match self.value {
            Some(value) => seed.deserialize(value),
            None => Err(Error::invalid_type(Unexpected::UnitVariant, &"newtype variant")),
        }
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Error> {
        match self.value {
            Some(value) => value.deserialize_any(visitor),
            None => Err(Error::invalid_type(Unexpected::UnitVariant, &"tuple variant")),
        }
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        match self.value {
            Some(value) => value.deserialize_any(visitor),
            None => Err(Error::invalid_type(Unexpected::UnitVariant, &"struct variant")),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use crate::language::{PassCommon, ResourceDeclaration};
    use crate::source::Sources;

    /// Whether decoding gives what it gives by way of an untyped tree, diagnostics included.
    fn alike<T: serde::de::DeserializeOwned + std::fmt::Debug>(text: &str) -> bool {
        let mut sources = Sources::new();
        let file = sources.add("t", text);
        let value = crate::document::parse(&sources, file).unwrap().root;
        let direct = value.decode::<T>().map_err(|error| error.to_string());
        let indirect = serde_json::from_value::<T>(value.to_json()).map_err(|error| error.to_string());
        assert_eq!(format!("{direct:?}"), format!("{indirect:?}"));
        direct.is_ok()
    }

    #[test]
    fn values_decode_as_they_do_by_way_of_an_untyped_tree() {
        let texture =
            |rest: &str| format!(r#"{{ "texture": {{ "format": ["r8unorm"], "size": [1, 2.5] {rest} }} }}"#);
        assert!(alike::<ResourceDeclaration>(&texture(r#", "view": "2d-array", "description": null"#)));
        assert!(alike::<ResourceDeclaration>(&texture(r#", "lifetime": "history", "initial": -1"#)));
        assert!(!alike::<ResourceDeclaration>(&texture(r#", "view": { "2d": 1 }"#)));
        assert!(!alike::<ResourceDeclaration>(&texture(r#", "lifetime": 3"#)));
        assert!(!alike::<ResourceDeclaration>(&texture(r#", "lifetime": "ever""#)));
        assert!(!alike::<ResourceDeclaration>(&texture(r#", "depth": 1"#)));
        assert!(!alike::<ResourceDeclaration>(r#"{ "texture": {}, "buffer": {} }"#));
        assert!(!alike::<ResourceDeclaration>(r#""texture""#));
        assert!(alike::<PassCommon>(
            r#"{ "after": ["a"], "passthrough": { "a": "b" }, "with": { "n": [true, "x"] } }"#
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
