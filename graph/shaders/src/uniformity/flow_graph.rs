//! What depends on what within one function: WGSL's uniformity graph.
//!
//! Nodes are values, and the control flow in which something runs; an edge goes from what depends to what it depends on.
//! One node stands for all that may differ between invocations. Which nodes reach another is found by going backwards
//! from it, which also gives the shortest way there: the reasons.

use std::collections::{HashMap, VecDeque};

use naga::Span;

pub(super) type Node = u32;

const NONE: Node = Node::MAX;

/// What is to be seen at a place on the way of a reason.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Note {
    pub(super) span: Span,
    pub(super) text: String,
}

#[derive(Debug, Default)]
pub(super) struct FlowGraph {
    nodes: Node,
    /// From what depends to what it depends on.
    edges: Vec<(Node, Node)>,
    notes: HashMap<Node, Note>,
}

impl FlowGraph {
    pub(super) fn node(&mut self, depends_on: &[Node]) -> Node {
        let node = self.nodes;
        self.nodes += 1;
        self.edges.extend(depends_on.iter().map(|to| (node, *to)));
        node
    }

    pub(super) fn noted(&mut self, depends_on: &[Node], span: Span, text: impl Into<String>) -> Node {
        let node = self.node(depends_on);
        self.notes.insert(node, Note { span, text: text.into() });
        node
    }

    pub(super) fn edge(&mut self, from: Node, to: Node) {
        self.edges.push((from, to));
    }

    /// The same edges, seen from where they lead.
    pub(super) fn reversed(&self) -> Reversed<'_> {
        let mut ends = vec![0; self.nodes as usize + 1];
        self.edges.iter().for_each(|(_, to)| ends[*to as usize + 1] += 1);
        for at in 1..ends.len() {
            ends[at] += ends[at - 1];
        }
        let mut into = vec![NONE; self.edges.len()];
        let mut at: Vec<usize> = ends.clone();
        for (from, to) in &self.edges {
            into[at[*to as usize]] = *from;
            at[*to as usize] += 1;
        }
        Reversed { graph: self, ends, into }
    }
}

#[derive(Debug)]
pub(super) struct Reversed<'a> {
    graph: &'a FlowGraph,
    /// Where the list of each node begins among all, and the next one's.
    ends: Vec<usize>,
    into: Vec<Node>,
}

impl<'a> Reversed<'a> {
    /// All that depends on a node, however indirectly.
    pub(super) fn depending_on(&self, target: Node) -> Depending<'a> {
        let mut next = vec![NONE; self.graph.nodes as usize];
        next[target as usize] = target;
        let mut found = VecDeque::from([target]);
        while let Some(node) = found.pop_front() {
            for from in &self.into[self.ends[node as usize]..self.ends[node as usize + 1]] {
                if next[*from as usize] == NONE {
                    next[*from as usize] = node;
                    found.push_back(*from);
                }
            }
        }
        Depending { graph: self.graph, next }
    }
}

/// The nodes that depend on one, each with the next on its way there.
#[derive(Debug)]
pub(super) struct Depending<'a> {
    graph: &'a FlowGraph,
    next: Vec<Node>,
}

impl Depending<'_> {
    pub(super) fn has(&self, node: Node) -> bool {
        self.next[node as usize] != NONE
    }

    /// The notes on the way from a node, each place once.
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
