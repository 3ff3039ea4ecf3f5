//! Ray queries of a scene in a pose.
//!
//! Triangles lie in the bounding volume hierarchy that shaders trace, too ([`umbragraph_scene::trace`]). Each node names
//! the next node if a ray misses its box, so traversal needs no stack. Boxes are stored in 32 bits, rounded outwards; hits
//! are computed in 64.
//!
//! Memory: about 170 bytes per triangle, about 230 while the hierarchy is built.

use glam::DVec3;
use umbragraph_scene::trace::Node;
use umbragraph_scene::trace::hierarchy::{Box32, Hierarchy, INNER};
use umbragraph_scene::{Pose, Scene};

use crate::triangles::{Hit, Surface, Triangle, surface_of, triangles_of};

/// A scene in a pose, with a bounding volume hierarchy for ray queries.
pub struct Rays<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) surfaces: Vec<Surface>,
    pub(crate) triangles: Vec<Triangle>,
    hierarchy: Hierarchy,
}

/// The surface that a camera sees along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// The index of the triangle, for [`Rays::triangle`].
    pub triangle: u32,
    /// The distance from the ray's origin to the surface, in lengths of the ray's direction.
    pub distance: f64,
    /// The unit normal of the visible side.
    pub normal: DVec3,
    /// Whether the surface receives shadows and no blended surface lies in front of it.
    pub counts: bool,
}

impl<'a> Rays<'a> {
    /// Builds the hierarchy for a scene in a pose. Triangles with non-finite coordinates are left out.
    pub fn new(scene: &'a Scene, pose: &Pose) -> Self {
        let mut triangles = triangles_of(scene, pose);
        triangles.retain(|triangle| triangle.corners.iter().all(|corner| corner.is_finite()));
        let boxes: Vec<Box32> = triangles.iter().map(|triangle| Box32::around(triangle.corners)).collect();
        let hierarchy = Hierarchy::build(&boxes);
        let surfaces = scene.draws().map(|draw| surface_of(scene, draw, pose)).collect();
        Self { scene, surfaces, triangles, hierarchy }
    }

    /// The number of triangles in the hierarchy.
    pub fn count(&self) -> usize {
        self.triangles.len()
    }

    /// The memory of triangles and hierarchy nodes, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.triangles.as_slice()) + size_of_val(self.hierarchy.nodes())
    }

    /// The triangle with an index, such as [`Seen::triangle`]; panics if the index is out of range.
    pub fn triangle(&self, index: u32) -> &Triangle {
        &self.triangles[index as usize]
    }

    /// Finds the nearest opaque or masked surface along a ray; `None` without one. `range` holds the least and greatest
    /// distance, in lengths of the direction.
    pub fn seen(&self, origin: DVec3, direction: DVec3, range: [f64; 2]) -> Option<Seen> {
        let [begin, mut end] = range;
        let mut found: Option<(u32, Hit)> = None;
        let mut glass = f64::INFINITY;
        self.each(origin, direction, end, &mut |index, triangle, surface, hit| {
            if hit.distance >= begin && hit.distance < end && self.is_there(triangle, surface, hit) {
                let is_front = surface.is_double_sided || surface.is_front(triangle, direction);
                if surface.is_blended {
                    glass = glass.min(hit.distance);
                } else if is_front {
                    end = hit.distance;
                    found = Some((index, hit));
                }
            }
            Some(end)
        });
        let (triangle, hit) = found?;
        let normal = self.triangles[triangle as usize].normal();
        let receives = self.surfaces[self.triangles[triangle as usize].draw as usize].receives;
        Some(Seen {
            triangle,
            distance: hit.distance,
            normal: if normal.dot(direction) > 0.0 { -normal } else { normal },
            counts: receives && glass > hit.distance,
        })
    }

    /// Returns `true` if a shadow caster other than the triangle `from` meets a ray between the two distances of
    /// `range`, in lengths of the direction.
    pub fn is_blocked(&self, from: u32, origin: DVec3, direction: DVec3, range: [f64; 2]) -> bool {
        let mut blocked = false;
        self.each(origin, direction, range[1], &mut |index, triangle, surface, hit| {
            blocked = index != from && self.is_blocker(triangle, surface, hit, range);
            (!blocked).then_some(range[1])
        });
        blocked
    }

    /// The distance of the farthest shadow caster other than the triangle `from` along a ray; `None` without one.
    /// `range` holds the least and greatest distance; all are in lengths of the direction. On a ray towards a light,
    /// this caster is the one that the light meets first.
    pub fn first_blocker(&self, from: u32, origin: DVec3, direction: DVec3, range: [f64; 2]) -> Option<f64> {
        let mut farthest = None;
        self.each(origin, direction, range[1], &mut |index, triangle, surface, hit| {
            let beyond = [farthest.unwrap_or(range[0]), range[1]];
            if index != from && self.is_blocker(triangle, surface, hit, beyond) {
                farthest = Some(hit.distance);
            }
            Some(range[1])
        });
        farthest
    }

    /// Returns `true` if the surface casts shadows and is hit between two distances, outside the holes of its alpha
    /// mask.
    fn is_blocker(&self, triangle: &Triangle, surface: &Surface, hit: Hit, [begin, end]: [f64; 2]) -> bool {
        let is_between = hit.distance > begin && hit.distance < end;
        surface.casts && is_between && self.is_there(triangle, surface, hit)
    }

    /// Returns `true` if a hit lies outside the holes of the surface's alpha mask.
    pub(crate) fn is_there(&self, triangle: &Triangle, surface: &Surface, hit: Hit) -> bool {
        surface.mask.as_ref().is_none_or(|mask| !mask.is_hole(self.scene, triangle, hit))
    }

    /// Calls `visit` for each hit of a ray up to the distance `end`, in no particular order. The visitor returns the
    /// distance beyond which later hits are skipped, or `None` to stop.
    pub(crate) fn each(
        &self,
        origin: DVec3,
        direction: DVec3,
        mut end: f64,
        visit: &mut impl FnMut(u32, &Triangle, &Surface, Hit) -> Option<f64>,
    ) {
        let inverse = direction.recip();
        let nodes = self.hierarchy.nodes();
        let mut at = 0;
        while let Some(node) = nodes.get(at as usize) {
            if !meets(node, origin, inverse, end) {
                at = node.exit;
                continue;
            }
            at += 1;
            if node.triangle == INNER {
                continue;
            }
            let triangle = &self.triangles[node.triangle as usize];
            if let Some(hit) = triangle.hit(origin, direction) {
                match visit(node.triangle, triangle, &self.surfaces[triangle.draw as usize], hit) {
                    Some(distance) => end = distance,
                    None => return,
                }
            }
        }
    }
}

/// Returns `true` if a ray meets a node's box at a distance of at most `end` (slab test). A ray in the plane of a side
/// counts as a hit.
fn meets(node: &Node, origin: DVec3, inverse: DVec3, end: f64) -> bool {
    let low = (DVec3::from_array(node.min.map(f64::from)) - origin) * inverse;
    let high = (DVec3::from_array(node.max.map(f64::from)) - origin) * inverse;
    let enter = low.min(high).max_element();
    let leave = low.max(high).min_element();
    enter <= leave && leave >= 0.0 && enter <= end
}
