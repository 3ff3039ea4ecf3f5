//! The node kind of a pass: its one key that is none of those that every pass can have.

use crate::document::{Entry, Value};

/// The key in a group of shared settings whose value applies to the node kind of the pass, whichever kind that is.
pub(crate) const SETTINGS: &str = "settings";

/// The keys of a pass, or of a group of shared settings, that do not name a node kind.
const COMMON: [&str; 11] = [
    "description",
    "extends",
    "when",
    "for_each",
    "use",
    "with",
    "after",
    "side_effect",
    "toggle",
    "passthrough",
    SETTINGS,
];

/// Returns the member of a pass, or of a group of shared settings, whose key is the node kind, such as `draw`, and
/// whose value is its settings. `None` if there is none.
pub fn node_kind(pass: &Value) -> Option<&Entry> {
    pass.entries()?.iter().find(|member| !COMMON.contains(&member.key.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::language::PassCommon;

    #[test]
    fn the_common_keys_are_those_that_every_pass_can_have() {
        let schema = schemars::schema_for!(PassCommon).to_value();
        let keys: Vec<&str> = schema["properties"].as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(keys, COMMON[..COMMON.len() - 1]);
    }
}
