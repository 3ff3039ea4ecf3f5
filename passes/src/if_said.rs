//! Settings that may be left out.

/// Declares an optional setting: `Some(None)` if the setting is absent, `None` after a diagnostic.
pub(crate) fn if_said<T, U>(setting: &Option<T>, declare: impl FnOnce(&T) -> Option<U>) -> Option<Option<U>> {
    setting.as_ref().map_or(Some(None), |setting| declare(setting).map(Some))
}
