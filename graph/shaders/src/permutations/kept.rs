//! Proofs of earlier runs.
//!
//! Kept of a unit: the profiles that accept it, and what its callers see of it. Its name is the hash of all that it is
//! made of. A unit with an error or a warning is not kept: it is proven and reported again. What cannot be read is not
//! there.
//!
//! The host keeps the bytes ([`Keep`]), and keeps apart what different versions of this program have proven.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::units::{Profiles, Unit};
use crate::reflection::{Binding, EntryPoint};
use crate::rules::summary::Summary;

/// The maximum number of stored validation units; above it, the units of earlier runs are dropped.
const MAX_UNITS: usize = 1 << 16;

/// A store for validation results from one run to the next.
pub trait Keep: Sync {
    /// Returns the bytes that were last stored under `name`, or `None`.
    fn get(&self, name: &str) -> Option<Vec<u8>>;

    /// Stores bytes under `name` and replaces earlier ones. A failure to store is ignored.
    fn put(&self, name: &str, bytes: &[u8]);
}

/// The validation units that earlier runs have checked, keyed by the hexadecimal hash of each unit.
#[derive(Debug)]
pub(super) struct Kept(BTreeMap<String, Record>);

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Record {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    summary: Option<Summary>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    binding: Option<Binding>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    entry_point: Option<EntryPoint>,
    accepted: Profiles,
    reached: Profiles,
    /// Whether the entry point writes every texel; stored here since serialization of `EntryPoint` skips this field.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    covers: bool,
}

impl Kept {
    /// Deserializes stored units; empty if the bytes are missing or unreadable.
    pub(super) fn of(bytes: Option<Vec<u8>>) -> Self {
        Self(bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default())
    }

    /// Returns the stored unit with this hash, or `None`.
    pub(super) fn unit(&self, hash: &[u8; 32]) -> Option<Unit> {
        let Record { summary, binding, entry_point, accepted, reached, covers } =
            self.0.get(&name(hash))?.clone();
        let entry_point = entry_point.map(|entry_point| EntryPoint { covers, ..entry_point });
        Some(Unit {
            accepted,
            reached,
            summary: summary.map(Arc::new),
            binding,
            entry_point,
            ..Unit::default()
        })
    }

    /// Merges the validated units into the stored ones and serializes them; `None` if nothing has changed.
    pub(super) fn with(mut self, proven: &[Unit]) -> Option<Vec<u8>> {
        let is_accepted = |unit: &&Unit| !unit.follows && unit.accepted != 0 && unit.refusals.is_empty();
        let record = |unit: &Unit| {
            let record = Record {
                summary: unit.summary.as_deref().cloned(),
                binding: unit.binding.clone(),
                covers: unit.entry_point.as_ref().is_some_and(|entry_point| entry_point.covers),
                entry_point: unit.entry_point.clone(),
                accepted: unit.accepted,
                reached: unit.reached,
            };
            (name(&unit.hash), record)
        };
        let own: BTreeMap<String, Record> = proven.iter().filter(is_accepted).map(record).collect();
        if own.iter().all(|(name, record)| self.0.get(name) == Some(record)) {
            return None;
        }
        if self.0.len() + own.len() > MAX_UNITS {
            self.0.clear();
        }
        self.0.extend(own);
        serde_json::to_vec(&self.0).ok()
    }
}

fn name(hash: &[u8; 32]) -> String {
    blake3::Hash::from_bytes(*hash).to_hex().to_string()
}
