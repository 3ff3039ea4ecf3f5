//! Hashes of what units are made of, the same in every run.

pub(super) type Hash = [u8; 32];

/// A BLAKE3 hasher for the contents of a validation unit. [`Content::all`] hashes parts independent of their order.
pub(super) struct Content(blake3::Hasher);

impl Content {
    pub(super) fn new(kind: &str) -> Self {
        let mut content = Self(blake3::Hasher::new());
        content.add(kind.as_bytes());
        content
    }

    pub(super) fn add(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
        self
    }

    pub(super) fn all<'n>(&mut self, parts: impl IntoIterator<Item = (&'n str, Hash)>) -> &mut Self {
        let mut parts: Vec<(&str, Hash)> = parts.into_iter().collect();
        parts.sort_unstable();
        self.add(&(parts.len() as u64).to_le_bytes());
        for (name, hash) in parts {
            self.add(name.as_bytes()).add(&hash);
        }
        self
    }

    pub(super) fn finish(&self) -> Hash {
        *self.0.finalize().as_bytes()
    }
}
