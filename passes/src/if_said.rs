//! Settings that may be left out.

/// Declaration of a setting: `Some(None)` where nothing is said, `None` after a diagnostic.
pub(crate) fn if_said<T, U>(setting: &Option<T>, declare: impl FnOnce(&T) -> Option<U>) -> Option<Option<U>> {
    setting.as_ref().map_or(Some(None), |setting| declare(setting).map(Some))
}
