//! Objects by their descriptors, kept from plan to plan.
//!
//! A plan that replaces another shares most of its shader modules, layouts, pipelines and samplers with it. Lookups
//! compare whole descriptors, never a hash alone. Each attempt to instantiate a plan is a generation. Objects of an
//! attempt that the device rejects are removed, and objects that the last few successful attempts did not use are
//! evicted.

use std::collections::HashMap;
use std::hash::Hash;

/// The number of plans for which an unused object is kept, so that a switch can be turned off and on again.
const KEPT_PLANS: u64 = 4;

/// Objects by their descriptors.
pub(crate) struct Cache<K, V> {
    entries: HashMap<K, Entry<V>>,
}

struct Entry<V> {
    value: V,
    created: u64,
    used: u64,
}

impl<K, V> Default for Cache<K, V> {
    fn default() -> Self {
        Self { entries: HashMap::new() }
    }
}

impl<K: Hash + Eq, V: Clone> Cache<K, V> {
    /// Returns the object of a descriptor, which `create` makes if there is none.
    pub(crate) fn get(&mut self, key: K, now: u64, create: impl FnOnce(&K) -> V) -> V {
        let create = |key: &K| Entry { value: create(key), created: now, used: now };
        let entry = self.entries.entry(key).or_insert_with_key(create);
        entry.used = now;
        entry.value.clone()
    }

    /// Drops objects created after generation `proven`, the last that the device accepted. Also drops objects that no
    /// plan has used for [`KEPT_PLANS`] generations.
    pub(crate) fn clean(&mut self, proven: u64) {
        let is_kept = |entry: &Entry<V>| entry.created <= proven && entry.used + KEPT_PLANS > proven;
        self.entries.retain(|_, entry| is_kept(entry));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_is_created_once() {
        let mut cache = Cache::default();
        let now = 1;
        assert_eq!(cache.get("a", now, |_| 1), 1);
        assert_eq!(cache.get("a", now + 1, |_| 2), 1);
        assert_eq!(cache.get("b", now, |_| 3), 3);
    }

    #[test]
    fn rejected_objects_are_forgotten_and_valid_ones_kept() {
        let mut cache = Cache::default();
        cache.get("good", 1, |_| 1);
        cache.get("bad", 2, |_| 2);
        cache.clean(1);
        assert_eq!(cache.get("good", 3, |_| 3), 1);
        assert_eq!(cache.get("bad", 3, |_| 4), 4);
    }

    #[test]
    fn what_no_plan_uses_for_a_while_is_evicted() {
        let mut cache = Cache::default();
        cache.get("a", 1, |_| 1);
        cache.clean(KEPT_PLANS);
        assert_eq!(cache.entries.len(), 1);
        cache.clean(1 + KEPT_PLANS);
        assert_eq!(cache.entries.len(), 0);
    }
}
