//! Strongly connected components.

/// The strongly connected components of a graph, each after those that it leads to (Tarjan 1972).
pub(super) fn components(edges: &[Vec<u32>]) -> Vec<Vec<u32>> {
    struct Search<'e> {
        edges: &'e [Vec<u32>],
        number: Vec<u32>,
        low: Vec<u32>,
        open: Vec<u32>,
        is_open: Vec<bool>,
        found: Vec<Vec<u32>>,
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
            for next in &edges[at] {
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
                let component = self.open.split_off(start);
                component.iter().for_each(|each| self.is_open[*each as usize] = false);
                self.found.push(component);
            }
        }
    }
    let nodes = edges.len();
    let mut search = Search {
        edges,
        number: vec![0; nodes],
        low: vec![0; nodes],
        open: Vec::new(),
        is_open: vec![false; nodes],
        found: Vec::new(),
        count: 0,
    };
    for node in 0..nodes as u32 {
        if search.number[node as usize] == 0 {
            search.visit(node);
        }
    }
    search.found
}
