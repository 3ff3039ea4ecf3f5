//! Objectives of an order, and the report on the order that was chosen.

use serde::Serialize;

/// The objective by which the execution order of the passes is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Objective {
    /// Document order wherever the dependencies leave a choice.
    #[default]
    Declaration,
    /// The fewest bytes of texture and buffer memory.
    Memory,
    /// The fewest render passes after merging.
    FewPasses,
}

impl Objective {
    /// All objectives, in the order of the enum.
    pub const ALL: [Self; 3] = [Self::Declaration, Self::Memory, Self::FewPasses];

    /// The name of the objective: `declaration`, `memory` or `few-passes`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Declaration => "declaration",
            Self::Memory => "memory",
            Self::FewPasses => "few-passes",
        }
    }
}

/// The objective and method by which a pass order was chosen, with the bytes or render passes that result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct OrderReport {
    /// The objective of the order.
    pub objective: Objective,
    /// The method by which the order was found.
    pub method: OrderMethod,
    /// The bytes of document order and chosen order, with a lower bound; `None` unless the objective is `memory`.
    pub memory: Option<MemoryOrder>,
    /// The numbers of render passes in document order and in the chosen order; `None` unless the objective is
    /// `few-passes`.
    pub render_passes: Option<[usize; 2]>,
}

/// The method by which a pass order was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum OrderMethod {
    /// Document order.
    Declaration,
    /// An exact search: no order is better.
    Exact,
    /// A heuristic: a better order may exist.
    Heuristic,
}

/// The bytes that the frame needs in document order and in the chosen order, with a lower bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct MemoryOrder {
    /// The bytes that document order needs.
    pub declaration: u64,
    /// The bytes that the chosen order needs.
    pub chosen: u64,
    /// A lower bound in bytes for every order. For each class of resources that can share memory, it counts the most
    /// bytes that a single pass uses.
    pub bound: u64,
}
