//! Values that a caller gives parameters and features.

use umbragraph_text::diagnostic::Place;
use umbragraph_text::document;
use umbragraph_text::source::Span;

/// A value for a parameter or feature, given from outside the pipeline.
#[derive(Clone, Debug)]
pub struct Override {
    /// The name.
    pub name: String,
    /// The value.
    pub value: document::Value,
    /// The place of the value.
    pub place: Span,
}

/// The caller's values for parameters and features. Later settings win.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Values of parameters.
    pub parameters: Vec<Override>,
    /// Values of features.
    pub features: Vec<Override>,
}

impl Overrides {
    /// This choice with another one over it: where both give a value, the other's counts.
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
