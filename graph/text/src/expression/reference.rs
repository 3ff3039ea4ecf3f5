//! References to resources and published data: `maps`, `maps@blur` for the version that one pass wrote, `maps@0` for
//! what was there before the first write of the frame, or `maps@-1` for what the frame before left. In a document `&`
//! stands in front.

use std::ops::Range;

use super::{ErrorKind, ExpressionError};

/// A reference to a version of a resource or of published data.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Reference {
    /// The name of the resource or published data.
    pub resource: String,
    /// The name of the pass that wrote the version, or `0` for the contents before the first write. `None` for the
    /// newest version.
    pub version: Option<String>,
    /// The age of the version in frames: 0 for this frame, 1 for the previous one.
    pub back: u32,
}

/// The error of a string that is not a valid reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a reference is the name of a resource, name@pass for the version that a pass wrote, name@0 for what was there before the first write, or name@-1 for the frame before"
)]
pub struct ReferenceError;

impl Reference {
    /// Parses a reference without its `&`, such as `maps@blur`.
    ///
    /// # Errors
    /// An empty name or version, more than one `@`, or a frame count below 1.
    pub fn parse(text: &str) -> Result<Self, ReferenceError> {
        let mut parts = text.split('@');
        let resource = parts.next().filter(|name| !name.is_empty()).ok_or(ReferenceError)?;
        let version = parts.next();
        if parts.next().is_some() || version == Some("") {
            return Err(ReferenceError);
        }
        match version.and_then(|version| version.strip_prefix('-')) {
            None => Ok(Self { resource: resource.to_owned(), version: version.map(str::to_owned), back: 0 }),
            Some(frames) => {
                let plain = frames.bytes().all(|digit| digit.is_ascii_digit());
                let back = frames.parse().ok().filter(|back| plain && *back > 0);
                Ok(Self { resource: resource.to_owned(), version: None, back: back.ok_or(ReferenceError)? })
            }
        }
    }
}

impl ReferenceError {
    /// Converts to an [`ExpressionError`] at the byte range `range` of the expression; `0..0` stands for the whole
    /// expression.
    pub fn of(self, text: &str, range: Range<usize>) -> ExpressionError {
        let message = format!("\"{text}\" is not a reference");
        let help = Some(self.to_string());
        ExpressionError { help, ..ExpressionError::new(ErrorKind::Reference, range, message) }
    }
}

impl std::fmt::Display for Reference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.resource)?;
        match (&self.version, self.back) {
            (Some(version), _) => write!(f, "@{version}"),
            (None, 0) => Ok(()),
            (None, back) => write!(f, "@-{back}"),
        }
    }
}

impl serde::Serialize for Reference {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_names_a_resource_and_perhaps_a_version() {
        let parsed = |text| Reference::parse(text).map(|one| (one.resource, one.version, one.back));
        assert_eq!(parsed("maps"), Ok(("maps".to_owned(), None, 0)));
        assert_eq!(parsed("maps@draw"), Ok(("maps".to_owned(), Some("draw".to_owned()), 0)));
        assert_eq!(parsed("maps@-12"), Ok(("maps".to_owned(), None, 12)));
        for text in ["maps", "maps@draw.0", "maps@0", "maps@-2"] {
            assert_eq!(Reference::parse(text).map(|one| one.to_string()).as_deref(), Ok(text));
        }
        for text in ["", "@a", "a@", "a@b@c", "a@-0", "a@-", "a@-+1", "a@-x", "a@-99999999999"] {
            assert_eq!(Reference::parse(text), Err(ReferenceError), "{text}");
        }
    }
}
