//! Objectives of an order, and the report on the order that was chosen.

use serde::Serialize;

/// The objective of the order of the passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Objective {
    /// The order of the document where the graph leaves a choice.
    #[default]
    Declaration,
    /// Few bytes.
    Memory,
    /// Few render passes.
    FewPasses,
}

impl Objective {
    /// All objectives.
    pub const ALL: [Self; 3] = [Self::Declaration, Self::Memory, Self::FewPasses];

    /// `declaration`, `memory` or `few-passes`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Declaration => "declaration",
            Self::Memory => "memory",
            Self::FewPasses => "few-passes",
        }
    }
}

/// The objective and method of an order, and its bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct OrderReport {
    /// The objective.
    pub objective: Objective,
    /// The method.
    pub method: OrderMethod,
    /// For `memory`: what was reached, and against what.
    pub memory: Option<MemoryOrder>,
    /// For `few-passes`: the render passes of the order of the document, and of the one chosen.
    pub render_passes: Option<[usize; 2]>,
}

/// The method by which an order was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum OrderMethod {
    /// The order of the document.
    Declaration,
    /// No order is better.
    Exact,
    /// A good one.
    Heuristic,
}

/// The bytes that the frame needs in two orders, and a lower bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct MemoryOrder {
    /// The order of the document.
    pub declaration: u64,
    /// The bytes of the chosen order.
    pub chosen: u64,
    /// A lower bound for any order: what single passes need at once, summed over the classes.
    pub bound: u64,
}
