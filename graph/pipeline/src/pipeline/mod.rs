//! One typed configuration of a pipeline: parameters and features chosen, passes declared, shaders reflected.
//!
//! [`load`] takes a document through these steps, collecting diagnostics on the way:
//!
//! 1. the tree is checked against the schema composed of the language and the registered node kinds ([`schema`]);
//! 2. parameters and features get their values (default, preset by the caller's [`Overrides`]) and are checked against
//!    their ranges and constraints;
//! 3. each pass whose `when` holds is declared by its node kind, which states resources used, shaders and bindings
//!    through a [`PassBuilder`]; shaders are rendered, validated and reflected here, since the usage of a binding is
//!    what the shader says it is;
//! 4. what passes say of one another (blackboard data, versions) is connected.
//!
//! A pass that could not be declared leaves a gap: the resources that it mentions are exempt from diagnostics that
//! would only follow ([`TypedPipeline::uncertain`]).

pub(crate) mod builder;
pub(crate) mod configuration;
pub(crate) mod expand;
pub(crate) mod load;
pub(crate) mod located;
pub(crate) mod names;
pub(crate) mod pass;
pub(crate) mod program;
pub(crate) mod resource;
pub(crate) mod resources;
pub(crate) mod schema;
pub(crate) mod settings;
pub(crate) mod state;
pub(crate) mod survey;
pub(crate) mod toggle;

pub use crate::access::subresource_range::{Aspect, IndexRange, SubresourceRange, canonical};
pub use crate::access::usage::Usage;
pub use crate::access::version::Version;
pub use crate::whole_number::whole_number;
pub use builder::binding::{Bind, BindObject, BufferBind, Contents, ValuesBind, element_type, member_runs};
pub use builder::programs::axis_value;
pub use builder::subresources::{Face, SubresourceRangeSettings};
pub use builder::{PassBuilder, Produced};
pub use configuration::TypedPipeline;
pub use load::hosts::check_host;
pub use load::passthroughs::add_fallbacks;
pub use load::profiles::{claimed_profiles, profile_named};
pub use load::sections::check_schema;
pub use load::{LoadOptions, load};
pub use located::Located;
pub use names::environment::{Environment, with_names};
pub use names::expression_diagnostic::expression_diagnostic;
pub use names::identifiers::{is_of, is_round};
pub use pass::{Access, Pass};
pub use program::{Program, ProgramBinding, ProgramVariant};
pub use resource::{History, Resource, ResourceKind};
pub use schema::{FileKind, schema, schema_of, schema_of_composed};
pub use settings::availability::{Lacking, lacking, off};
pub use settings::derived::Derived;
pub use settings::evaluate::{Evaluate, LiveSettings};
pub use settings::live::{Constraint, Following, LiveSetting, Structural};
pub use settings::misfit::{is_alike, rejected};
pub use settings::overrides::{Override, Overrides};
pub use settings::preset::{ParameterFile, of_preset};
pub use settings::scope::StaticScope;
pub use settings::setting::{Feature, ValuedParameter};
pub use survey::{Absent, Chosen, EntryPoints, Survey, Wanted};
pub use toggle::{Condition, Passthrough, Toggle};
