//! References to resources: `maps`, `maps@blur` for the version that one pass wrote, `maps@0` for what was there
//! before the first write of the frame, or `maps@-1` for what the frame before left.

/// A resource, and which of its versions is meant.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Reference<'a> {
    /// The resource's name.
    pub resource: &'a str,
    /// The pass whose write made the version, or `0` for what was there before the first; `None` for the newest.
    pub version: Option<&'a str>,
    /// The number of frames back; 0 for this frame.
    pub back: u32,
}

/// A text that is not a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a reference is the name of a resource, name@pass for the version that a pass wrote, name@0 for what was there before the first write, or name@-1 for the frame before"
)]
pub struct ReferenceError;

impl<'a> Reference<'a> {
    /// Takes a text apart.
    ///
    /// # Errors
    /// An empty name, more than one `@`, or frames that are not counted from 1.
    pub fn parse(text: &'a str) -> Result<Self, ReferenceError> {
        let mut parts = text.split('@');
        let resource = parts.next().filter(|name| !name.is_empty()).ok_or(ReferenceError)?;
        let version = parts.next();
        if parts.next().is_some() || version == Some("") {
            return Err(ReferenceError);
        }
        match version.and_then(|version| version.strip_prefix('-')) {
            None => Ok(Self { resource, version, back: 0 }),
            Some(frames) => {
                let plain = frames.bytes().all(|digit| digit.is_ascii_digit());
                let back = frames.parse().ok().filter(|back| plain && *back > 0);
                Ok(Self { resource, version: None, back: back.ok_or(ReferenceError)? })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_names_a_resource_and_perhaps_a_version() {
        assert_eq!(Reference::parse("maps"), Ok(Reference { resource: "maps", version: None, back: 0 }));
        assert_eq!(
            Reference::parse("maps@draw"),
            Ok(Reference { resource: "maps", version: Some("draw"), back: 0 })
        );
        assert_eq!(Reference::parse("maps@-12"), Ok(Reference { resource: "maps", version: None, back: 12 }));
        for text in ["", "@a", "a@", "a@b@c", "a@-0", "a@-", "a@-+1", "a@-x", "a@-99999999999"] {
            assert_eq!(Reference::parse(text), Err(ReferenceError), "{text}");
        }
    }
}
