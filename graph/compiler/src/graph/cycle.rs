//! Cycles of a directed graph: for each strongly connected component a shortest one.
//!
//! Components are found by Kosaraju's algorithm, since petgraph's version of it is not recursive: a graph may have a
//! million passes, a stack may not.

use petgraph::algo::kosaraju_scc;
use petgraph::graph::DiGraph;
use std::collections::VecDeque;

/// The maximum number of start nodes of the search in one component. In a larger component the cycle found may not be
/// the shortest.
const MAX_STARTS: usize = 256;
/// The maximum number of node visits in one component, summed over all start nodes. One start node is always searched.
const MAX_VISITS: usize = 1_000_000;

/// Returns a shortest cycle for each strongly connected component of more than one node, sorted. `edges` holds the
/// successors of each node; a cycle lists its nodes along the edges, from the smallest.
pub(crate) fn shortest(edges: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut graph = DiGraph::<(), ()>::with_capacity(edges.len(), edges.iter().map(Vec::len).sum());
    let nodes: Vec<_> = edges.iter().map(|_| graph.add_node(())).collect();
    for (from, list) in edges.iter().enumerate() {
        for to in list {
            graph.add_edge(nodes[from], nodes[*to], ());
        }
    }
    let mut cycles = Vec::new();
    let mut component_of = vec![usize::MAX; edges.len()];
    for (index, component) in
        kosaraju_scc(&graph).into_iter().enumerate().filter(|(_, component)| component.len() > 1)
    {
        let mut members: Vec<usize> = component.into_iter().map(petgraph::graph::NodeIndex::index).collect();
        members.sort_unstable();
        for member in &members {
            component_of[*member] = index;
        }
        let best = members
            .iter()
            .take(MAX_STARTS.min(MAX_VISITS / members.len()).max(1))
            .filter_map(|start| from_start(edges, &component_of, index, *start))
            .min_by_key(|cycle| (cycle.len(), cycle.clone()));
        cycles.extend(best);
    }
    cycles.sort();
    cycles
}

/// Returns a shortest cycle through `start` inside its component, found by breadth-first search; `None` if there is
/// none.
fn from_start(
    edges: &[Vec<usize>],
    component_of: &[usize],
    component: usize,
    start: usize,
) -> Option<Vec<usize>> {
    let mut parent = std::collections::HashMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(node) = queue.pop_front() {
        for next in edges[node].iter().copied().filter(|next| component_of[*next] == component) {
            if next == start {
                let mut cycle = vec![node];
                let mut at = node;
                while at != start {
                    at = *parent.get(&at)?;
                    cycle.push(at);
                }
                cycle.reverse();
                return Some(cycle);
            }
            parent.entry(next).or_insert_with(|| {
                queue.push_back(next);
                node
            });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::shortest;

    #[test]
    fn the_shortest_cycle_of_each_component_is_found() {
        // 0 → 1 → 2 → 3 → 0 with a short cut 2 → 1, and apart from it 4 ⇄ 5; 6 hangs on.
        let edges = vec![vec![1], vec![2], vec![3, 1], vec![0], vec![5], vec![4, 6], vec![]];
        assert_eq!(shortest(&edges), [vec![1, 2], vec![4, 5]]);
        assert!(shortest(&[vec![1], vec![2], vec![]]).is_empty());
    }
}
