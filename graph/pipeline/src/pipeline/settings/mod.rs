//! Parameters, features and derived values: what a document declares, what presets and the caller say, and what follows
//! from them while frames run.

pub(crate) mod availability;
pub(crate) mod derived;
pub(crate) mod evaluate;
pub(crate) mod kinds;
pub(crate) mod live;
pub(crate) mod misfit;
pub(crate) mod overrides;
pub(crate) mod preset;
pub(crate) mod scope;
pub(crate) mod setting;

pub(crate) use derived::Derived;
pub(crate) use evaluate::Evaluate;
pub(crate) use live::{Constraint, Dependence, Following, LiveSetting, Structural, names};
pub(crate) use overrides::Overrides;
pub(crate) use scope::StaticScope;
pub(crate) use setting::{Feature, ValuedParameter};
