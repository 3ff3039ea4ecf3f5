//! The pipeline language: the types that a document is checked against and decoded into.
//!
//! The JSON Schema of these types (doc comments are its descriptions) is both what editors complete with and what
//! [`crate::document::schema`] checks, so grammar, checker and decoder cannot drift apart. A pass is the one place
//! where a document names code: its one key beside the common ones is the name of a registered node kind, and the
//! value its settings.

mod declaration;
mod expression;
mod files;
mod format_names;
mod node_kind;
mod reference;
mod resource;
mod word;

pub use crate::document::Written;
pub use crate::expression::{Reference, ReferenceError};
pub use declaration::{
    ConstraintDeclaration, ConstraintSeverity, ExtensionPointDeclaration, FeatureDeclaration, FeatureType,
    GeometryDeclaration, HostBinding, Names, Order, ParameterDeclaration, ParameterType, PassCommon, Paths,
    PipelineDeclaration, PresetDeclaration, Sections, SubgraphDeclaration, ToggleDeclaration,
    VertexFormatName,
};
pub use expression::{AnyExpr, Expr};
pub use files::{ExtensionDeclaration, ParameterFileDeclaration};
pub use format_names::{format_name, parse_format, unknown_format};
pub(crate) use node_kind::SETTINGS;
pub use node_kind::node_kind;
pub use reference::Ref;
pub use resource::{
    BufferDeclaration, FormatCandidates, Lifetime, ResourceDeclaration, TextureDeclaration, TextureShape,
    WordValue,
};
pub use word::Word;
