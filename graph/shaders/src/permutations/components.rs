//! Strongly connected components.

/// The edges of a directed graph, stored node by node.
#[derive(Debug, Default)]
pub(super) struct Edges {
    to: Vec<u32>,
    /// For each node, the end index of its edges in `to`.
    ends: Vec<usize>,
}

impl Edges {
    /// Adds a node with edges to the nodes `to`.
    pub(super) fn node(&mut self, to: impl Iterator<Item = u32>) {
        self.to.extend(to);
        self.ends.push(self.to.len());
    }

    fn of(&self, node: usize) -> &[u32] {
        let start = node.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.to[start..self.ends[node]]
    }
}

/// Strongly connected components, in an order where each follows the components that it points to.
#[derive(Debug, Default)]
pub(super) struct Components {
    nodes: Vec<u32>,
    ends: Vec<usize>,
}

impl Components {
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| &self.nodes[start..*end])
    }
}

/// The strongly connected components of a graph (Tarjan 1972).
pub(super) fn components(edges: &Edges) -> Components {
    struct Search<'e> {
        edges: &'e Edges,
        number: Vec<u32>,
        low: Vec<u32>,
        open: Vec<u32>,
        is_open: Vec<bool>,
        found: Components,
        count: u32,
    }
    impl Search<'_> {
        fn visit(&mut self, node: u32) {
            self.count += 1;
            let at = node as usize;
            (self.number[at], self.low[at]) = (self.count, self.count);
            self.open.push(node);
            self.is_open[at] = true;
            let edges = self.edges;
            for next in edges.of(at) {
                let to = *next as usize;
                if self.number[to] == 0 {
                    self.visit(*next);
                    self.low[at] = self.low[at].min(self.low[to]);
                } else if self.is_open[to] {
                    self.low[at] = self.low[at].min(self.number[to]);
                }
            }
            if self.low[at] == self.number[at] {
                let start = self.open.iter().rposition(|each| *each == node).unwrap_or_default();
                for each in self.open.drain(start..) {
                    self.is_open[each as usize] = false;
                    self.found.nodes.push(each);
                }
                self.found.ends.push(self.found.nodes.len());
            }
        }
    }
    let nodes = edges.ends.len();
    let mut search = Search {
        edges,
        number: vec![0; nodes],
        low: vec![0; nodes],
        open: Vec::with_capacity(nodes),
        is_open: vec![false; nodes],
        found: Components { nodes: Vec::with_capacity(nodes), ends: Vec::with_capacity(nodes) },
        count: 0,
    };
    for node in 0..nodes as u32 {
        if search.number[node as usize] == 0 {
            search.visit(node);
        }
    }
    search.found
}

#[cfg(test)]
mod tests {
    use super::{Edges, components};

    #[test]
    fn circles_are_one_component_behind_what_they_lead_to() {
        let mut edges = Edges::default();
        for to in [&[1][..], &[2, 3], &[0], &[], &[4, 3]] {
            edges.node(to.iter().copied());
        }
        let found = components(&edges);
        let mut found: Vec<Vec<u32>> = found.iter().map(<[u32]>::to_vec).collect();
        found.iter_mut().for_each(|component| component.sort_unstable());
        assert_eq!(found, [vec![3], vec![0, 1, 2], vec![4]]);
    }
}
