//! The first character of a string says what the string is.
//!
//! ```jsonc
//! "size": "=viewport / 2",       // computed
//! "source": "&maps@blur",        // refers to a resource or to published data
//! "compare": "less-equal"        // a word, a file or a declared name, as its key says
//! ```
//!
//! This is the one place that knows the signs.

/// A string of a document without its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written<'a> {
    /// An expression, after an equals sign.
    Expression(&'a str),
    /// A reference, after an ampersand.
    Reference(&'a str),
    /// A word, a file or a declared name.
    Plain(&'a str),
}

impl<'a> Written<'a> {
    /// Reads the sign of a string.
    pub fn of(text: &'a str) -> Self {
        match (text.strip_prefix('='), text.strip_prefix('&')) {
            (Some(expression), _) => Self::Expression(expression),
            (None, Some(reference)) => Self::Reference(reference),
            (None, None) => Self::Plain(text),
        }
    }
}
