//! Work on the CPU: a function from frame input to named data and views, with a state of its own for each executor.

use std::any::Any;
use std::sync::Arc;

use crate::data::BlackboardData;
use crate::frame::FrameInput;
use crate::pipeline::settings::evaluate::LiveSettings;
use crate::work::Subresource;

/// A node that computes blackboard data (values and views) on the CPU from the host's input of a frame. The node is
/// part of the plan; each executor runs a clone, which receives changed live settings. Two equal nodes must compute the
/// same results.
pub trait CpuNode: Clone + PartialEq + Send + Sync + std::fmt::Debug + 'static {
    /// The state that is kept from frame to frame; `()` for a node without state. Each executor has one state for each
    /// pass.
    type State: Default + Send + Sync + 'static;

    /// Computes the data of one frame. `data` is cleared before the call. All values in it must be finite afterwards,
    /// whatever the input.
    fn run(&self, state: &mut Self::State, context: &CpuContext<'_>, data: &mut BlackboardData);

    /// Updates the node with its live settings ([`PassBuilder::live`](crate::pipeline::PassBuilder::live)) after some
    /// of them changed. Returns `None` after a diagnostic; the previous settings are then passed again.
    fn update(&mut self, _settings: &mut LiveSettings<'_>) -> Option<()> {
        Some(())
    }
}

/// A [`CpuNode`] whose type is erased.
pub trait AnyCpuNode: Any + Send + Sync + std::fmt::Debug {
    /// Creates a clone of the node that can run, with a default state.
    fn start(&self) -> Box<dyn CpuRun>;
    /// Returns `true` if `other` is of the same type and equal.
    fn is_same(&self, other: &dyn AnyCpuNode) -> bool;
}

/// A running clone of a CPU node, with its state.
pub trait CpuRun: Send + Sync {
    /// Computes the data of the next frame.
    fn run(&mut self, context: &CpuContext<'_>, data: &mut BlackboardData);
    /// The node with its current live settings.
    fn node(&self) -> &dyn AnyCpuNode;
    /// Updates the node with its changed live settings; returns `None` after a diagnostic.
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
    /// The host's input for the frame: camera, lights, bounds and time.
    pub frame: &'a FrameInput,
    /// The width and height of the picture, in pixels.
    pub viewport: [u32; 2],
    /// The blackboard data that the pass reads, in the order of `CpuWork::inputs`.
    pub inputs: &'a [&'a BlackboardData],
}

/// The work of a pass that runs a node on the CPU.
#[derive(Clone, Debug)]
pub struct CpuWork {
    /// The node that the pass runs.
    pub node: Arc<dyn AnyCpuNode>,
    /// The blackboard data that the node computes and publishes.
    pub output: Subresource,
    /// The blackboard data that the node reads.
    pub inputs: Vec<Subresource>,
}

impl CpuWork {
    /// Creates the work of a node that computes the blackboard data `output` from a frame and from the data `inputs`.
    pub fn new(node: impl CpuNode, output: Subresource, inputs: Vec<Subresource>) -> Self {
        Self { node: Arc::new(node), output, inputs }
    }
}
