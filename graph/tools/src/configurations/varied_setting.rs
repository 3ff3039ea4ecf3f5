//! A setting that varies between configurations.

use umbragraph_pipeline::document::{Kind, Value};
use umbragraph_pipeline::language::FeatureDeclaration;

/// A feature or parameter with the values that are tried, the default first.
#[derive(Clone, Debug)]
pub(super) struct Varied {
    pub(super) name: String,
    pub(super) feature: Option<FeatureDeclaration>,
    pub(super) values: Vec<Value>,
    pub(super) exhaustive: bool,
}

impl Varied {
    /// The name of the `one_of` group of the feature; `None` for a parameter or a feature without a group.
    pub(super) fn group(&self) -> Option<&str> {
        self.feature.as_ref()?.one_of.as_deref()
    }

    /// Returns `true` if the feature is on with `value`. An enumeration is off with its first value, and on with all
    /// others.
    pub(super) fn is_on(&self, value: &Value) -> bool {
        let first = self.feature.as_ref().and_then(|declaration| declaration.values.first());
        match &value.kind {
            Kind::Bool(on) => *on,
            Kind::Text(word) => first != Some(word),
            _ => false,
        }
    }
}
