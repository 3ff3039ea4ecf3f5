//! References to resources: `maps`, or `maps@casters` for the version that one pass wrote.

/// A resource, and which of its versions is meant.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Reference<'a> {
    /// The resource's name.
    pub resource: &'a str,
    /// The pass whose write made the version; `None` for the newest.
    pub version: Option<&'a str>,
}

/// A text that is no reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a reference is the name of a resource, or name@pass for the version that a pass wrote")]
pub struct ReferenceError;

impl<'a> Reference<'a> {
    /// Takes a text apart.
    ///
    /// # Errors
    /// An empty name, or more than one `@`.
    pub fn parse(text: &'a str) -> Result<Self, ReferenceError> {
        let mut parts = text.split('@');
        let resource = parts.next().filter(|name| !name.is_empty()).ok_or(ReferenceError)?;
        let version = parts.next();
        if parts.next().is_some() || version == Some("") {
            return Err(ReferenceError);
        }
        Ok(Self { resource, version })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_names_a_resource_and_perhaps_a_version() {
        assert_eq!(Reference::parse("maps"), Ok(Reference { resource: "maps", version: None }));
        assert_eq!(Reference::parse("maps@draw"), Ok(Reference { resource: "maps", version: Some("draw") }));
        for text in ["", "@a", "a@", "a@b@c"] {
            assert_eq!(Reference::parse(text), Err(ReferenceError), "{text}");
        }
    }
}
