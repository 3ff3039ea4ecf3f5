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

/// A node kind, as its settings.
pub trait Node: DeserializeOwned + JsonSchema + 'static {
    /// The key that names the kind in a pass.
    const NAME: &'static str;
    /// Its purpose in one sentence.
    const SUMMARY: &'static str;

    /// States what a pass with these settings uses and does. Diagnostics go to the builder; `None` after at least one.
    /// A pass of a subgraph is declared once for each instance, with the same settings.
    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced>;

    /// The data that its passes publish, for the reference: a shape for each way of using the kind, with the way's name
    /// before it. Arrays whose length the settings decide may have any.
    fn published() -> Vec<(&'static str, DataShape)> {
        Vec::new()
    }
}

/// A node kind without its type; [`Registry::register`] makes it of any [`Node`], and [`Registry::register_kind`] takes
/// one that has values of its own.
pub trait NodeKind: Send + Sync {
    /// The key that names the kind in a pass.
    fn name(&self) -> &'static str;
    /// Its purpose in one sentence.
    fn summary(&self) -> &'static str;
    /// The schema of its settings.
    fn schema(&self, generator: &mut SchemaGenerator) -> Schema;
    /// Decodes settings, which fit the schema.
    ///
    /// # Errors
    /// Settings that fit the schema, but not the type behind it.
    fn decode(&self, settings: &document::Value) -> Result<Box<dyn Settings>, serde_json::Error>;
    /// The data that its passes publish; see [`Node::published`].
    fn published(&self) -> Vec<(&'static str, DataShape)>;
}

/// Settings of some node kind.
pub trait Settings {
    /// Declares a pass with these settings.
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

/// The node kinds that pipelines can name, and the hosts whose meshes they can draw.
#[derive(Clone, Default)]
pub struct Registry {
    kinds: BTreeMap<&'static str, Arc<dyn NodeKind>>,
    hosts: BTreeMap<String, HostInterface>,
    /// The schema of pipelines of these kinds, once a pipeline was checked.
    schema: OnceLock<Arc<document::schema::Schema>>,
}

impl Registry {
    /// No kinds yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a kind; one of the same name is replaced.
    pub fn register<N: Node>(&mut self) -> &mut Self {
        self.kinds.insert(N::NAME, Arc::new(Typed::<N>(PhantomData)));
        self.schema = OnceLock::new();
        self
    }

    /// Adds a kind that is an object, with values of its own: a channel to the host, or a name that is known at run
    /// time. One of the same name is replaced.
    pub fn register_kind(&mut self, kind: impl NodeKind + 'static) -> &mut Self {
        self.kinds.insert(kind.name(), Arc::new(kind));
        self.schema = OnceLock::new();
        self
    }

    /// The kind of a name.
    pub fn get(&self, name: &str) -> Option<&Arc<dyn NodeKind>> {
        self.kinds.get(name)
    }

    /// States how the host stores what pipelines draw under a geometry contract of this name: what it uploads is then
    /// compared with every shader that reads it whenever a pipeline is loaded, without a device, and an executor counts
    /// on it. A pipeline whose geometry has another name is none of this host's.
    pub fn host(&mut self, geometry: impl Into<String>, interface: HostInterface) -> &mut Self {
        self.hosts.insert(geometry.into(), interface);
        self
    }

    /// The hosts that were stated, by the geometry contract that each fulfils.
    pub fn hosts(&self) -> &BTreeMap<String, HostInterface> {
        &self.hosts
    }

    /// The schema of pipelines that use these kinds, made when it is first wanted.
    pub(crate) fn schema(&self) -> &document::schema::Schema {
        self.schema.get_or_init(|| {
            let json = crate::pipeline::schema_of_composed(crate::pipeline::FileKind::Pipeline, self);
            Arc::new(document::schema::Schema::new(&json))
        })
    }

    /// All kinds by name.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<dyn NodeKind>> {
        self.kinds.values()
    }
}

impl std::fmt::Debug for Registry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_set().entries(self.kinds.keys()).finish()
    }
}
