//! Node kinds: what a pass of a pipeline can be. The built-in ones are written against this module, as yours would be.
//!
//! A node kind has a name (the key in the pass), settings (a type that is decoded from JSON and whose schema editors
//! see), and a `declare` that says what a pass with such settings uses and does:
//!
//! ```
//! use umbragraph_pipeline::data::{DataShape, BlackboardData, ValueType};
//! use umbragraph_pipeline::language::{Expr, Ref};
//! use umbragraph_pipeline::node::{Node, Registry};
//! use umbragraph_pipeline::pipeline::{Evaluate, PassBuilder, Produced};
//! use umbragraph_pipeline::work::{CpuContext, CpuNode, CpuWork, Work};
//!
//! /// Publishes the phase of a wave.
//! #[derive(serde::Deserialize, schemars::JsonSchema)]
//! #[serde(deny_unknown_fields)]
//! struct Wave {
//!     /// The data to publish.
//!     to: Ref,
//!     /// Seconds for one round.
//!     period: Expr,
//! }
//!
//! #[derive(Clone, Debug, PartialEq)]
//! struct RunWave {
//!     period: f64,
//! }
//!
//! impl CpuNode for RunWave {
//!     type State = ();
//!
//!     fn run(&self, _: &mut (), context: &CpuContext<'_>, data: &mut BlackboardData) {
//!         data.set_f32("phase", (context.frame.time / self.period).fract() as f32);
//!     }
//! }
//!
//! impl Node for Wave {
//!     const NAME: &'static str = "wave";
//!     const SUMMARY: &'static str = "Publishes the phase of a wave, from 0 to 1.";
//!
//!     fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
//!         let period = pass.number(&self.period, "/period")?;
//!         let output = pass.publish(&self.to, "/to", DataShape::new().value("phase", ValueType::F32, "from 0 to 1"))?;
//!         pass.produce(Work::Cpu(CpuWork::new(RunWave { period }, output, Vec::new())))
//!     }
//! }
//!
//! let mut registry = Registry::new();
//! registry.register::<Wave>();
//! ```
//!
//! State is the data that a node keeps from frame to frame. Each executor has its own, which begins with the type's
//! default:
//!
//! ```
//! # use umbragraph_pipeline::data::BlackboardData;
//! # use umbragraph_pipeline::work::{CpuContext, CpuNode};
//! /// Publishes the seconds since the frame before.
//! #[derive(Clone, Debug, PartialEq)]
//! struct RunStep;
//!
//! impl CpuNode for RunStep {
//!     type State = Option<f64>;
//!
//!     fn run(&self, before: &mut Option<f64>, context: &CpuContext<'_>, data: &mut BlackboardData) {
//!         let now = context.frame.time;
//!         let before = before.replace(now).unwrap_or(now);
//!         data.set_f32("step", (now - before) as f32);
//!     }
//! }
//! ```

use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::sync::{Arc, OnceLock};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::DeserializeOwned;

use crate::data::DataShape;
use crate::draw::HostInterface;
use crate::pipeline::builder::{PassBuilder, Produced};
use umbragraph_text::document;

/// A node kind: a kind of pass that pipelines can name by a JSON key. The implementing type holds the settings of a
/// pass.
pub trait Node: DeserializeOwned + JsonSchema + 'static {
    /// The JSON key by which a pass in a document names the kind.
    const NAME: &'static str;
    /// The purpose of the kind in one sentence, for the JSON Schema and the reference documentation.
    const SUMMARY: &'static str;

    /// Declares the resources and the work of a pass with these settings. Returns `None` after it reported at least one
    /// diagnostic to the builder. A pass of a subgraph is declared once for each use of the subgraph, with the same
    /// settings.
    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced>;

    /// The blackboard data that passes of this kind publish, for the reference documentation. Each way of using the
    /// kind has a name and a shape. Array lengths that depend on settings may be arbitrary here.
    fn published() -> Vec<(&'static str, DataShape)> {
        Vec::new()
    }
}

/// A node kind whose settings type is erased. [`Registry::register`] creates one from any [`Node`];
/// [`Registry::register_kind`] takes an object that may hold values of its own.
pub trait NodeKind: Send + Sync {
    /// The JSON key by which a pass in a document names the kind.
    fn name(&self) -> &'static str;
    /// The purpose of the kind in one sentence, for the JSON Schema and the reference documentation.
    fn summary(&self) -> &'static str;
    /// The JSON Schema of the kind's settings.
    fn schema(&self, generator: &mut SchemaGenerator) -> Schema;
    /// Decodes settings that are valid according to the kind's JSON Schema.
    ///
    /// # Errors
    /// Returns an error for settings that fit the schema, but not the settings type of the kind.
    fn decode(&self, settings: &document::Value) -> Result<Box<dyn Settings>, serde_json::Error>;
    /// The blackboard data that passes of this kind publish, for the reference documentation: a name and a shape for
    /// each way of using the kind.
    fn published(&self) -> Vec<(&'static str, DataShape)>;
}

/// The decoded settings of one pass, whose type is erased.
pub trait Settings {
    /// Declares the resources and the work of a pass with these settings. Returns `None` after at least one diagnostic
    /// was reported to the builder.
    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced>;
}

impl<N: Node> Settings for N {
    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        Node::declare(self, pass)
    }
}

struct Typed<N>(PhantomData<fn() -> N>);

impl<N: Node> NodeKind for Typed<N> {
    fn name(&self) -> &'static str {
        N::NAME
    }

    fn published(&self) -> Vec<(&'static str, DataShape)> {
        N::published()
    }

    fn summary(&self) -> &'static str {
        N::SUMMARY
    }

    fn schema(&self, generator: &mut SchemaGenerator) -> Schema {
        generator.subschema_for::<N>()
    }

    fn decode(&self, settings: &document::Value) -> Result<Box<dyn Settings>, serde_json::Error> {
        Ok(Box::new(settings.decode::<N>()?))
    }
}

/// The node kinds that pipelines can name, and the mesh storage ([`HostInterface`]) of hosts whose meshes they can
/// draw.
#[derive(Clone, Default)]
pub struct Registry {
    kinds: BTreeMap<&'static str, Arc<dyn NodeKind>>,
    hosts: BTreeMap<String, HostInterface>,
    /// The JSON Schema of pipelines with these kinds; made on first use, and reset when a kind is added.
    schema: OnceLock<Arc<document::schema::Schema>>,
}

impl Registry {
    /// Creates a registry without node kinds and hosts.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a node kind, and replaces a kind of the same name.
    pub fn register<N: Node>(&mut self) -> &mut Self {
        self.kinds.insert(N::NAME, Arc::new(Typed::<N>(PhantomData)));
        self.schema = OnceLock::new();
        self
    }

    /// Adds a node kind given as an object with values of its own, such as a channel to the host or a name. Replaces a
    /// kind of the same name.
    pub fn register_kind(&mut self, kind: impl NodeKind + 'static) -> &mut Self {
        self.kinds.insert(kind.name(), Arc::new(kind));
        self.schema = OnceLock::new();
        self
    }

    /// Returns the node kind with this name, or `None` if there is none.
    pub fn get(&self, name: &str) -> Option<&Arc<dyn NodeKind>> {
        self.kinds.get(name)
    }

    /// Registers the layout in which the host stores the meshes that pipelines draw under the geometry contract
    /// `geometry`. Each load of a pipeline compares this layout with every shader that reads the meshes, without a
    /// device. Executors rely on the layout. It has no effect on geometry contracts of other names.
    pub fn host(&mut self, geometry: impl Into<String>, interface: HostInterface) -> &mut Self {
        self.hosts.insert(geometry.into(), interface);
        self
    }

    /// The layouts of the hosts' mesh storage, by the name of the geometry contract that each fulfils.
    pub fn hosts(&self) -> &BTreeMap<String, HostInterface> {
        &self.hosts
    }

    /// Returns the JSON Schema of pipelines that use these kinds; it is made on the first call.
    pub(crate) fn schema(&self) -> &document::schema::Schema {
        self.schema.get_or_init(|| {
            let json = crate::pipeline::schema_of_composed(crate::pipeline::FileKind::Pipeline, self);
            Arc::new(document::schema::Schema::new(&json))
        })
    }

    /// Iterates over all node kinds in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<dyn NodeKind>> {
        self.kinds.values()
    }
}

impl std::fmt::Debug for Registry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.kinds.keys()).finish()
    }
}
