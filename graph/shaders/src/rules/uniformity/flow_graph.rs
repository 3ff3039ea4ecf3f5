//! WGSL's uniformity graph of one function.
//!
//! Nodes are values and the control flow of statements; an edge leads from a node to a node that it depends on. One
//! node stands for everything that may differ between invocations. A backward search from it finds all nodes that
//! depend on it, and the shortest path of each: the reasons.

use std::collections::{HashMap, VecDeque};

use naga::Span;

pub(super) type Node = u32;

const NONE: Node = Node::MAX;

/// A message about one step of the path that explains a non-uniform value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Note {
    pub(super) span: Span,
    pub(super) text: String,
}

#[derive(Debug, Default)]
pub(super) struct FlowGraph {
    /// For each node, the nodes that depend on it directly.
    dependents: Vec<Vec<Node>>,
    notes: HashMap<Node, Note>,
}

impl FlowGraph {
    pub(super) fn node(&mut self, depends_on: &[Node]) -> Node {
        let node = self.dependents.len() as Node;
        self.dependents.push(Vec::new());
        depends_on.iter().for_each(|to| self.edge(node, *to));
        node
    }

    pub(super) fn noted(&mut self, depends_on: &[Node], span: Span, text: impl Into<String>) -> Node {
        let node = self.node(depends_on);
        self.notes.insert(node, Note { span, text: text.into() });
        node
    }

    pub(super) fn edge(&mut self, from: Node, to: Node) {
        self.dependents[to as usize].push(from);
    }

    /// Returns the nodes that depend on `target`, directly or indirectly.
    pub(super) fn depending_on(&self, target: Node) -> Depending<'_> {
        let mut next = vec![NONE; self.dependents.len()];
        next[target as usize] = target;
        let mut found = VecDeque::from([target]);
        while let Some(node) = found.pop_front() {
            for from in &self.dependents[node as usize] {
                if next[*from as usize] == NONE {
                    next[*from as usize] = node;
                    found.push_back(*from);
                }
            }
        }
        Depending { graph: self, next }
    }
}

/// The nodes that depend on a target node; for each, the next node on a shortest path to the target.
#[derive(Debug)]
pub(super) struct Depending<'a> {
    graph: &'a FlowGraph,
    next: Vec<Node>,
}

impl Depending<'_> {
    pub(super) fn has(&self, node: Node) -> bool {
        self.next[node as usize] != NONE
    }

    /// The notes on the path from a node to the target; of several notes with one span, only the first.
    pub(super) fn reasons(&self, mut node: Node) -> Vec<Note> {
        let mut reasons: Vec<Note> = Vec::new();
        while self.has(node) {
            let note = self.graph.notes.get(&node);
            if let Some(note) = note.filter(|note| reasons.iter().all(|known| known.span != note.span)) {
                reasons.push(note.clone());
            }
            match self.next[node as usize] {
                next if next == node => break,
                next => node = next,
            }
        }
        reasons
    }
}
