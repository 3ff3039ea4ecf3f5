//! The names that expressions can see before sizes are known.

use std::collections::{BTreeMap, BTreeSet};

use crate::pipeline::settings::derived::Derived;
use crate::pipeline::settings::setting::{Feature, ValuedParameter};
use umbragraph_text::expression::{Scope, Value};
use umbragraph_text::source::Span;

/// The scope of expressions before sizes are known: parameters, features and derived values by name.
#[derive(Clone, Debug, Default)]
pub struct StaticScope {
    values: BTreeMap<String, Value>,
    /// The allowed words of each enumeration, by the name of its parameter, feature or derived value.
    words: BTreeMap<String, Vec<String>>,
    /// The places of the expressions of derived values, by name.
    derived: BTreeMap<String, Span>,
    /// The names that are declared, but have no value because of errors.
    broken: BTreeSet<String>,
}

impl StaticScope {
    /// Creates the scope of parameters and features.
    pub fn new(parameters: &BTreeMap<String, ValuedParameter>, features: &BTreeMap<String, Feature>) -> Self {
        let parameters = parameters.iter().map(|(name, one)| (name, &one.value, &one.declaration.values));
        let features = features.iter().map(|(name, one)| (name, &one.value, &one.declaration.values));
        let mut scope = Self::default();
        for (name, value, words) in parameters.chain(features) {
            scope.set(name, value.clone());
            if matches!(value, Value::Text(_)) {
                scope.words.insert(name.clone(), words.clone());
            }
        }
        scope
    }

    /// The place of the expression of a derived value; `None` if no derived value has this name.
    pub(crate) fn derived_at(&self, name: &str) -> Option<Span> {
        self.derived.get(name).copied()
    }

    /// Adds the derived values to the scope.
    #[must_use]
    pub fn with_derived(mut self, derived: &BTreeMap<String, Derived>) -> Self {
        for (name, one) in derived {
            self.set(name, one.value.clone());
            self.derived.insert(name.clone(), one.place);
            self.words.extend(one.words.clone().map(|words| (name.clone(), words)));
        }
        self
    }

    /// Adds the arguments of subgraphs, by their internal names, to the scope.
    #[must_use]
    pub fn with_given(mut self, given: &BTreeMap<String, Value>) -> Self {
        given.iter().for_each(|(name, value)| self.set(name, value.clone()));
        self
    }

    /// Sets the value of a name; reuses the memory of an existing entry.
    pub fn set(&mut self, name: &str, value: Value) {
        match self.values.get_mut(name) {
            Some(before) => *before = value,
            None => drop(self.values.insert(name.to_owned(), value)),
        }
    }

    /// Returns the value of a name for changes, or `None` if there is no such name.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut Value> {
        self.values.get_mut(name)
    }

    /// Adds names that are declared, but have no value because of errors, to the scope.
    #[must_use]
    pub fn with_broken(self, broken: BTreeSet<String>) -> Self {
        Self { broken, ..self }
    }
}

impl Scope for StaticScope {
    fn lookup(&self, name: &str) -> Option<Value> {
        self.values.get(name).cloned()
    }

    fn borrow(&self, name: &str) -> Option<&Value> {
        self.values.get(name)
    }

    fn is_broken(&self, name: &str) -> bool {
        self.broken.contains(name)
    }

    fn words(&self, name: &str) -> Option<&[String]> {
        self.words.get(name).map(Vec::as_slice)
    }

    fn names(&self) -> Vec<String> {
        self.values.keys().cloned().collect()
    }
}
