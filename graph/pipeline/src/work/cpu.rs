//! Work on the CPU: a function from frame input to named data and views, with a state of its own for each executor.

use std::any::Any;
use std::sync::Arc;

use crate::data::BlackboardData;
use crate::frame::FrameInput;
use crate::pipeline::settings::evaluate::LiveSettings;
use crate::work::Subresource;

/// A function from what the host says of a frame to named data and views. The node itself is part of the plan; each
/// executor has a clone of it, which takes over live settings. Equal nodes compute the same.
pub trait CpuNode: Clone + PartialEq + Send + Sync + std::fmt::Debug + 'static {
    /// The state that is kept from frame to frame; `()` for nothing. Each executor has one for each pass.
    type State: Default + Send + Sync + 'static;

    /// Computes the data of one frame. `data` comes cleared; whatever the input is, it must end up finite.
    fn run(&self, state: &mut Self::State, context: &CpuContext<'_>, data: &mut BlackboardData);

    /// Takes over the settings that were evaluated as live ([`PassBuilder::live`](crate::pipeline::PassBuilder::live))
    /// when some of them have changed. `None` after a diagnostic: the settings before are given again then.
    fn update(&mut self, _settings: &mut LiveSettings<'_>) -> Option<()> {
        Some(())
    }
}

/// A type-erased [`CpuNode`].
pub trait AnyCpuNode: Any + Send + Sync + std::fmt::Debug {
    /// The node with a new state.
    fn start(&self) -> Box<dyn CpuRun>;
    /// Whether another node is of the same type and equal.
    fn is_same(&self, other: &dyn AnyCpuNode) -> bool;
}

/// A CPU node with its state.
pub trait CpuRun: Send + Sync {
    /// Computes the data of the next frame.
    fn run(&mut self, context: &CpuContext<'_>, data: &mut BlackboardData);
    /// The node as it is now.
    fn node(&self) -> &dyn AnyCpuNode;
    /// Takes over live settings; `None` after a diagnostic.
    fn update(&mut self, settings: &mut LiveSettings<'_>) -> Option<()>;
}

struct Started<N: CpuNode> {
    node: N,
    state: N::State,
}

impl<N: CpuNode> AnyCpuNode for N {
    fn start(&self) -> Box<dyn CpuRun> {
        Box::new(Started { node: self.clone(), state: N::State::default() })
    }

    fn is_same(&self, other: &dyn AnyCpuNode) -> bool {
        let other: &dyn Any = other;
        other.downcast_ref::<N>().is_some_and(|other| self == other)
    }
}

impl<N: CpuNode> CpuRun for Started<N> {
    fn run(&mut self, context: &CpuContext<'_>, data: &mut BlackboardData) {
        self.node.run(&mut self.state, context, data);
    }

    fn node(&self) -> &dyn AnyCpuNode {
        &self.node
    }

    fn update(&mut self, settings: &mut LiveSettings<'_>) -> Option<()> {
        self.node.update(settings)
    }
}

/// The input of a CPU node for one frame.
#[derive(Debug)]
pub struct CpuContext<'a> {
    /// The host's input.
    pub frame: &'a FrameInput,
    /// The width and height of the picture.
    pub viewport: [u32; 2],
    /// The data that the pass declared to read, in the order of the declaration.
    pub inputs: &'a [&'a BlackboardData],
}

/// Work on the CPU.
#[derive(Clone, Debug)]
pub struct CpuWork {
    /// The function.
    pub node: Arc<dyn AnyCpuNode>,
    /// The data that it computes.
    pub output: Subresource,
    /// The data that it reads.
    pub inputs: Vec<Subresource>,
}

impl CpuWork {
    /// A node that computes data from a frame and from other data.
    pub fn new(node: impl CpuNode, output: Subresource, inputs: Vec<Subresource>) -> Self {
        Self { node: Arc::new(node), output, inputs }
    }
}
