//! Values that a caller gives parameters and features.

use umbragraph_text::diagnostic::Place;
use umbragraph_text::document;
use umbragraph_text::source::Span;

/// A value for a parameter or feature, given from outside the pipeline.
#[derive(Clone, Debug)]
pub struct Override {
    /// The name of the parameter or feature.
    pub name: String,
    /// The value that replaces the default.
    pub value: document::Value,
    /// The place of the setting, for diagnostics.
    pub place: Span,
}

/// The caller's values for parameters and features. A later entry for the same name replaces an earlier one.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// The caller's values of parameters.
    pub parameters: Vec<Override>,
    /// The caller's values of features.
    pub features: Vec<Override>,
}

impl Overrides {
    /// Combines two sets of values; values of `over` replace those of `self`.
    #[must_use]
    pub fn under(mut self, over: Overrides) -> Self {
        self.parameters.extend(over.parameters);
        self.features.extend(over.features);
        self
    }
}

impl From<&Override> for Place {
    fn from(setting: &Override) -> Self {
        Place::Span(setting.place)
    }
}
