//! Keys of an object by name, for those who look up many.
//!
//! Objects keep the order of the text in a list; to look for each key of one object in another, as merging does, would
//! cost the product of their lengths. [`Keys`] hashes the keys of a long list once, while it may still grow.

use std::collections::HashMap;
use std::hash::BuildHasher as _;

use super::Entry;

/// The number of entries below which the keys are searched linearly, which is then faster than hashing.
const FEW_KEYS: usize = 16;

/// A hash index of the keys in a list of object members, which may grow between calls but not change otherwise.
#[derive(Debug, Default)]
pub(crate) struct Keys {
    /// The index of an entry in the list, by the hash of its key.
    known: HashMap<u64, usize>,
    /// The number of entries that are hashed so far.
    hashed: usize,
    /// Whether two keys have the same hash, so that the search is linear.
    is_ambiguous: bool,
}

impl Keys {
    /// Returns the index of the entry with the given key; `None` if there is none. All calls must pass the same list,
    /// which may grow between calls.
    pub(crate) fn find(&mut self, entries: &[Entry], key: &str) -> Option<usize> {
        let look = || entries.iter().position(|entry| entry.key == key);
        if entries.len() < FEW_KEYS {
            return look();
        }
        for (at, entry) in entries.iter().enumerate().skip(self.hashed) {
            let hash = self.known.hasher().hash_one(entry.key.as_str());
            self.is_ambiguous |= self.known.insert(hash, at).is_some();
        }
        self.hashed = entries.len();
        if self.is_ambiguous {
            return look();
        }
        let at = *self.known.get(&self.known.hasher().hash_one(key))?;
        (entries.get(at)?.key == key).then_some(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{Kind, Value};
    use crate::source::{Sources, Span};

    #[test]
    fn keys_are_found_where_they_stand_however_many_there_are() {
        let span = Span::new(Sources::new().add("t", ""), 0..0);
        let (mut keys, mut entries) = (Keys::default(), Vec::new());
        for at in 0..100 {
            let key = format!("k{at}");
            assert_eq!(keys.find(&entries, &key), None);
            entries.push(Entry { key, key_span: span, value: Value { span, kind: Kind::Null } });
            for wanted in [0, at / 2, at] {
                assert_eq!(keys.find(&entries, &format!("k{wanted}")), Some(wanted));
            }
        }
        keys.is_ambiguous = true;
        assert_eq!((keys.find(&entries, "k70"), keys.find(&entries, "k")), (Some(70), None));
    }
}
