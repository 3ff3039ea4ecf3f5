//! JSON pointers that are written out only where somebody reads them.
//!
//! A walk through a document knows at every value where it is, but only a diagnostic wants it as text. So the walk
//! keeps the way as a chain on the stack, from each value to the one around it.

use std::fmt;

/// A JSON pointer (RFC 6901), stored as a chain from a value to the objects and arrays around it. The string is only
/// built on demand.
#[derive(Clone, Copy, Debug)]
pub enum Pointer<'p> {
    /// A complete pointer as a string, such as `/passes/blur`.
    Text(&'p str),
    /// The pointer of an object, and the unescaped key of a member.
    Key(&'p Pointer<'p>, &'p str),
    /// The pointer of an array, and the index of an element.
    Element(&'p Pointer<'p>, usize),
}

impl<'p> Pointer<'p> {
    /// The pointer of the member `key` of the object at this pointer.
    pub fn key(&'p self, key: &'p str) -> Self {
        Pointer::Key(self, key)
    }

    /// The pointer of the element with index `at` of the array at this pointer.
    pub fn element(&'p self, at: usize) -> Self {
        Pointer::Element(self, at)
    }
}

impl fmt::Display for Pointer<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Pointer::Text(text) => f.write_str(text),
            Pointer::Key(above, key) => {
                write!(f, "{above}/")?;
                escaped(key, f)
            }
            Pointer::Element(above, at) => write!(f, "{above}/{at}"),
        }
    }
}

impl From<&Pointer<'_>> for String {
    fn from(pointer: &Pointer<'_>) -> Self {
        pointer.to_string()
    }
}

/// Appends one key to a JSON pointer, escaped according to RFC 6901.
pub fn pointer_join(pointer: &str, key: &str) -> String {
    let mut joined = String::with_capacity(pointer.len() + 1 + key.len());
    joined.push_str(pointer);
    joined.push('/');
    // Writing to a string does not fail.
    let _ = escaped(key, &mut joined);
    joined
}

fn escaped(key: &str, text: &mut impl fmt::Write) -> fmt::Result {
    let mut rest = key;
    while let Some(at) = rest.find(['~', '/']) {
        text.write_str(&rest[..at])?;
        text.write_str(if rest.as_bytes()[at] == b'~' { "~0" } else { "~1" })?;
        rest = &rest[at + 1..];
    }
    text.write_str(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pointer_reads_as_the_keys_that_lead_to_it() {
        let root = Pointer::Text("");
        let (passes, odd) = (root.key("passes"), "a/b~c");
        let (pass, after) = (passes.key(odd), "after");
        assert_eq!(pass.key(after).element(2).to_string(), "/passes/a~1b~0c/after/2");
        assert_eq!(pointer_join("/passes", odd), pass.to_string());
    }
}
