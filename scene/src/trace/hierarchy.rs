//! A bounding volume hierarchy over triangles.
//!
//! It is built top-down: of 16 bins along each axis the split with the least surface area (I. Wald, "On fast
//! Construction of SAH-based Bounding Volume Hierarchies", 2007). A leaf is one triangle. Nodes lie in depth-first
//! order. Each has an exit: the index of the first node after its subtree. A ray that meets a node's box goes on to the
//! next node; a ray that misses it jumps to the exit. So a ray needs no stack, and visits each node at most once.
//!
//! A hierarchy that is refitted keeps its order. If the boxes grew to twice their surface since it was built, it is
//! built anew.
//!
//! Bounds: below [`MAX_SAH_DEPTH`] levels a node is split in the middle of its triangles, so `n` triangles take
//! O(n log n) steps, however they lie. A triangle with a coordinate that is not finite has an empty box, which no ray
//! meets.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

/// The value of [`Node::triangle`] for an inner node.
pub const INNER: u32 = u32::MAX;

/// The tree depth from which nodes are split at their median triangle instead of by the surface area heuristic.
pub const MAX_SAH_DEPTH: u32 = 40;

/// The number of bins along each axis for the surface area heuristic.
const BINS: usize = 16;

/// The maximum factor by which refitting may increase the total surface area of all boxes before the hierarchy is
/// rebuilt.
const MAX_GROWTH: f32 = 2.0;

/// An axis-aligned box with 32-bit coordinates, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Box32 {
    /// The corner with the minimum coordinates.
    pub min: Vec3,
    /// The corner with the maximum coordinates.
    pub max: Vec3,
}

impl Box32 {
    /// The empty box. Its coordinates are finite: the minimum is `f32::MAX`, the maximum `f32::MIN`.
    pub const EMPTY: Self = Self { min: Vec3::MAX, max: Vec3::MIN };

    /// The box around the corners of a triangle, rounded outwards to `f32`. It is empty if a coordinate is not finite
    /// as `f32`.
    pub fn around(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        let is_finite = corners.iter().all(|corner| corner.is_finite() && corner.as_vec3().is_finite());
        if !is_finite {
            return Self::EMPTY;
        }
        let round =
            |corner: DVec3, round: fn(f32) -> f32| Vec3::from_array(corner.as_vec3().to_array().map(round));
        let (min, max) = (round(min, f32::next_down), round(max, f32::next_up));
        Self { min: min.max(Vec3::MIN), max: max.min(Vec3::MAX) }
    }

    fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Half the surface area of the box; 0 for the empty box.
    fn area(self) -> f32 {
        let size = (self.max - self.min).max(Vec3::ZERO);
        if self.min.x > self.max.x { 0.0 } else { size.x * size.y + size.y * size.z + size.z * size.x }
    }

    fn middle(self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }
}

/// A node of the hierarchy: a bounding box, the index of the first node after the subtree, and the triangle of a leaf.
/// Shaders read this memory layout.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// The corner of the bounding box with the minimum coordinates, in metres.
    pub min: [f32; 3],
    /// The index of the first node after the subtree, at which a ray that misses the bounding box continues.
    pub exit: u32,
    /// The corner of the bounding box with the maximum coordinates, in metres.
    pub max: [f32; 3],
    /// The index of the triangle of a leaf node; [`INNER`] for an inner node.
    pub triangle: u32,
}

impl Node {
    fn bounds(&self) -> Box32 {
        Box32 { min: self.min.into(), max: self.max.into() }
    }

    fn set_bounds(&mut self, bounds: Box32) {
        (self.min, self.max) = (bounds.min.to_array(), bounds.max.to_array());
    }
}

/// A bounding volume hierarchy over triangles. A triangle is identified by the index of its bounding box in a list.
#[derive(Clone, Debug, Default)]
pub struct Hierarchy {
    nodes: Vec<Node>,
    /// Half the total surface area of all boxes after the last build, in square metres.
    area: f32,
}

/// The kind of change that [`Hierarchy::refit`] made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refit {
    /// The bounding boxes of nodes were updated; the nodes kept their order.
    Moved,
    /// The hierarchy was rebuilt, so all nodes may have changed.
    Rebuilt,
}

/// A range of triangles that is still to be split, and the index and depth of the node for it.
struct Part {
    begin: usize,
    end: usize,
    node: usize,
    depth: u32,
}

impl Hierarchy {
    /// Builds a hierarchy over triangles with the bounding boxes `boxes`, one for each triangle.
    pub fn build(boxes: &[Box32]) -> Self {
        let mut hierarchy = Self::default();
        hierarchy.rebuild(boxes);
        hierarchy
    }

    /// The nodes in depth-first order; empty if there are no triangles.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    fn rebuild(&mut self, boxes: &[Box32]) {
        let count = boxes.len();
        let middles: Vec<Vec3> = boxes.iter().map(|bounds| bounds.middle()).collect();
        let mut order: Vec<u32> = (0..count as u32).collect();
        self.nodes.clear();
        self.nodes.resize((2 * count).saturating_sub(1), Node::zeroed());
        let mut open = Vec::new();
        if count > 0 {
            open.push(Part { begin: 0, end: count, node: 0, depth: 0 });
        }
        while let Some(Part { begin, end, node, depth }) = open.pop() {
            let leaves = end - begin;
            self.nodes[node].exit = (node + 2 * leaves - 1) as u32;
            if leaves == 1 {
                self.nodes[node].triangle = order[begin];
                continue;
            }
            self.nodes[node].triangle = INNER;
            let part = &mut order[begin..end];
            let split = if depth < MAX_SAH_DEPTH { split_by_area(part, boxes, &middles) } else { None };
            let first = split.unwrap_or_else(|| split_in_the_middle(part, &middles));
            let middle = begin + first;
            open.push(Part { begin: middle, end, node: node + 2 * first, depth: depth + 1 });
            open.push(Part { begin, end: middle, node: node + 1, depth: depth + 1 });
        }
        self.fit(boxes);
        self.area = self.surface();
    }

    /// Computes the bounding box of each node, from its triangle or from its children.
    fn fit(&mut self, boxes: &[Box32]) {
        for at in (0..self.nodes.len()).rev() {
            let node = self.nodes[at];
            let bounds = if node.triangle == INNER {
                let first = self.nodes[at + 1];
                first.bounds().union(self.nodes[first.exit as usize].bounds())
            } else {
                boxes.get(node.triangle as usize).copied().unwrap_or(Box32::EMPTY)
            };
            self.nodes[at].set_bounds(bounds);
        }
    }

    fn surface(&self) -> f32 {
        self.nodes.iter().map(|node| node.bounds().area()).sum()
    }

    /// Updates the hierarchy with new bounding boxes of the same triangles. The hierarchy is rebuilt if its total
    /// surface area is more than twice that of the last build.
    pub fn refit(&mut self, boxes: &[Box32]) -> Refit {
        self.fit(boxes);
        if self.surface() <= MAX_GROWTH * self.area {
            return Refit::Moved;
        }
        self.rebuild(boxes);
        Refit::Rebuilt
    }
}

/// Partitions a list of triangles at the bin boundary with the least surface area cost. Returns the number of triangles
/// before the boundary, or `None` if no boundary separates the box centres.
fn split_by_area(part: &mut [u32], boxes: &[Box32], middles: &[Vec3]) -> Option<usize> {
    let mut low = Vec3::MAX;
    let mut high = Vec3::MIN;
    for at in part.iter() {
        (low, high) = (low.min(middles[*at as usize]), high.max(middles[*at as usize]));
    }
    let extent = high - low;
    let scale = Vec3::splat(BINS as f32) / extent;
    let bin = |middle: Vec3, axis: usize| (((middle[axis] - low[axis]) * scale[axis]) as usize).min(BINS - 1);
    let mut bins = [[(Box32::EMPTY, 0_u32); BINS]; 3];
    let axes: Vec<usize> = (0..3).filter(|axis| extent[*axis] > 0.0 && scale[*axis].is_finite()).collect();
    for at in part.iter() {
        for axis in &axes {
            let (bounds, count) = &mut bins[*axis][bin(middles[*at as usize], *axis)];
            (*bounds, *count) = (bounds.union(boxes[*at as usize]), *count + 1);
        }
    }
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in &axes {
        let bins = &bins[*axis];
        let mut after = [0.0; BINS];
        let (mut bounds, mut count) = (Box32::EMPTY, 0);
        for at in (1..BINS).rev() {
            (bounds, count) = (bounds.union(bins[at].0), count + bins[at].1);
            after[at] = bounds.area() * count as f32;
        }
        let (mut bounds, mut count) = (Box32::EMPTY, 0);
        for at in 1..BINS {
            (bounds, count) = (bounds.union(bins[at - 1].0), count + bins[at - 1].1);
            let cost = bounds.area() * count as f32 + after[at];
            if count > 0 && (count as usize) < part.len() && best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, *axis, at));
            }
        }
    }
    let (_, axis, split) = best?;
    let mut first = 0;
    for at in 0..part.len() {
        if bin(middles[part[at] as usize], axis) < split {
            part.swap(first, at);
            first += 1;
        }
    }
    (first > 0 && first < part.len()).then_some(first)
}

/// Partitions a list of triangles at their median along the longest axis. Returns the number of triangles before the
/// median.
fn split_in_the_middle(part: &mut [u32], middles: &[Vec3]) -> usize {
    let mut low = Vec3::MAX;
    let mut high = Vec3::MIN;
    for at in part.iter() {
        (low, high) = (low.min(middles[*at as usize]), high.max(middles[*at as usize]));
    }
    let axis = (high - low).max_position();
    let half = part.len() / 2;
    part.select_nth_unstable_by(half, |a, b| {
        let key = |at: &u32| middles[*at as usize][axis];
        key(a).total_cmp(&key(b)).then(a.cmp(b))
    });
    half
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(at: DVec3, size: f64) -> Box32 {
        Box32::around([at, at + DVec3::X * size, at + DVec3::Y * size])
    }

    /// Asserts that each triangle has one leaf, that each box contains the boxes of its subtree, and that each exit
    /// lies after its node.
    #[track_caller]
    fn assert_sound(hierarchy: &Hierarchy, boxes: &[Box32]) {
        let nodes = hierarchy.nodes();
        assert_eq!(nodes.len(), (2 * boxes.len()).saturating_sub(1));
        let mut found: Vec<u32> = nodes.iter().map(|node| node.triangle).filter(|at| *at != INNER).collect();
        found.sort_unstable();
        assert!(found.iter().copied().eq(0..boxes.len() as u32));
        for (at, node) in nodes.iter().enumerate() {
            assert!(node.exit as usize > at && node.exit as usize <= nodes.len());
            for below in &nodes[at..node.exit as usize] {
                let (outer, inner) = (node.bounds(), below.bounds());
                if inner != Box32::EMPTY {
                    assert!(outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all());
                }
            }
        }
    }

    #[test]
    fn every_box_holds_its_subtree_before_and_after_a_refit() {
        let place = |at: u32, turn: f64| {
            let angle = f64::from(at) * 2.4 + turn;
            DVec3::new(angle.cos(), angle.sin(), 0.1) * f64::from(at)
        };
        for count in [0, 1, 2, 3, 17, 400] {
            let boxes = |turn| (0..count).map(|at| triangle(place(at, turn), 0.5)).collect::<Vec<_>>();
            let mut hierarchy = Hierarchy::build(&boxes(0.0));
            assert_sound(&hierarchy, &boxes(0.0));
            hierarchy.refit(&boxes(1.0));
            assert_sound(&hierarchy, &boxes(1.0));
        }
    }

    #[test]
    fn triangles_that_scatter_have_the_hierarchy_built_anew() {
        let near: Vec<Box32> = (0..64).map(|at| triangle(DVec3::X * f64::from(at), 1.0)).collect();
        let shuffled: Vec<Box32> =
            (0..64).map(|at| triangle(DVec3::X * f64::from(at * 37 % 64), 1.0)).collect();
        let mut hierarchy = Hierarchy::build(&near);
        assert_eq!(hierarchy.refit(&near), Refit::Moved);
        assert_eq!(hierarchy.refit(&shuffled), Refit::Rebuilt);
        assert_eq!(hierarchy.nodes(), Hierarchy::build(&shuffled).nodes());
    }

    #[test]
    fn bad_coordinates_make_empty_boxes_that_are_finite() {
        for bad in [f64::NAN, f64::INFINITY, f64::MAX] {
            let boxes =
                [triangle(DVec3::ZERO, 1.0), triangle(DVec3::splat(bad), 1.0), triangle(DVec3::X, bad)];
            assert_eq!(boxes[1..], [Box32::EMPTY; 2]);
            let hierarchy = Hierarchy::build(&boxes);
            assert_sound(&hierarchy, &boxes);
            assert_eq!(hierarchy.nodes()[0].bounds(), boxes[0]);
        }
    }

    #[test]
    fn equal_and_exponential_triangles_are_split_evenly_enough() {
        let depth = |hierarchy: &Hierarchy| {
            let mut exits: Vec<u32> = Vec::new();
            let depths = (0_u32..).zip(hierarchy.nodes()).map(|(at, node)| {
                exits.retain(|exit| *exit > at);
                exits.push(node.exit);
                exits.len()
            });
            depths.max().unwrap_or(0)
        };
        let equal = vec![triangle(DVec3::ONE, 1.0); 4096];
        assert_eq!(depth(&Hierarchy::build(&equal)), 13);
        let spread: Vec<Box32> = (0..4096).map(|at| triangle(DVec3::X * (1.02_f64).powi(at), 1e-3)).collect();
        assert!(depth(&Hierarchy::build(&spread)) <= MAX_SAH_DEPTH as usize + 13);
    }
}
