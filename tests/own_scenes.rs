//! Shadows of the project's own scenes against rays on the CPU: through the holes of leaves, and of a figure that moves.
//!
//! The oracle knows nothing of shadow maps: triangles in the world, skinned by the joints of the pose, texels of alpha
//! masks, and rays to the sun. It is asked at points that the camera sees on what stands still, away from the edges of shadows,
//! where no map of finite resolution can be right.

mod common;

use common::gpu::{render_frame, scene};
use common::{With, check_file, root};
use glam::{DMat4, DVec2, DVec3};
use umbragraph::frame::{Bounds, FrameInput};
use umbragraph::scene::material::AlphaMode;
use umbragraph::scene::{Draw, Pose, Scene};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;

const SIZE: [u32; 2] = [480, 270];

/// A triangle in the world.
struct Triangle {
    corners: [DVec3; 3],
    texcoords: [DVec2; 3],
    draw: Draw,
}

/// A scene in a pose, to be asked by rays.
struct Rays<'a> {
    scene: &'a Scene,
    draws: Vec<(Bounds, Vec<Triangle>)>,
    /// Whether alpha masks are taken for what they are, or every card for a whole one.
    has_holes: bool,
}

impl<'a> Rays<'a> {
    fn new(scene: &'a Scene, pose: &Pose, has_holes: bool) -> Self {
        let draws = scene.draws().map(|draw| (scene.draw_bounds(draw, pose), triangles(scene, pose, draw)));
        Self { scene, draws: draws.collect(), has_holes }
    }

    /// The nearest hit of a ray, as its distance and the triangle.
    fn nearest(&self, origin: DVec3, direction: DVec3) -> Option<(f64, &Triangle)> {
        self.hits(origin, direction).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Whether a point sees a sun in a direction.
    fn is_lit(&self, point: DVec3, to_sun: DVec3) -> bool {
        let origin = point + to_sun * 1e-3;
        !self.hits(origin, to_sun).any(|(_, triangle)| triangle.draw.cast_shadow)
    }

    fn hits(&self, origin: DVec3, direction: DVec3) -> impl Iterator<Item = (f64, &Triangle)> {
        let near = self.draws.iter().filter(move |(bounds, _)| may_hit(bounds, origin, direction));
        near.flat_map(|(_, triangles)| triangles).filter_map(move |triangle| {
            let (t, b, c) = hit(&triangle.corners, origin, direction)?;
            self.is_there(triangle, b, c).then_some((t, triangle))
        })
    }

    fn is_there(&self, triangle: &Triangle, b: f64, c: f64) -> bool {
        let material = self.scene.material(triangle.draw);
        match material.alpha_mode {
            AlphaMode::Mask { cutoff } if self.has_holes => {
                let [first, second, third] = triangle.texcoords;
                let at = first + (second - first) * b + (third - first) * c;
                let Some(texture) = material.base_color_texture else { return true };
                let image = &self.scene.images[self.scene.textures[texture].image];
                let texel =
                    |value: f64, count: u32| ((value - value.floor()) * f64::from(count)) as u32 % count;
                let (x, y) = (texel(at.x, image.width), texel(at.y, image.height));
                let alpha = image.rgba[(y as usize * image.width as usize + x as usize) * 4 + 3];
                f32::from(alpha) / 255.0 * material.base_color[3] >= cutoff
            }
            AlphaMode::Blend => false,
            _ => true,
        }
    }
}

fn triangles(scene: &Scene, pose: &Pose, draw: Draw) -> Vec<Triangle> {
    let primitive = scene.primitive(draw);
    let joints: Vec<DMat4> = scene.joint_transforms(draw.node, pose).collect();
    let corner = |index: u32| {
        let point = DVec3::from_array(primitive.positions[index as usize].map(f64::from));
        match (&primitive.joints, draw.skin) {
            (Some(moved), Some(_)) => {
                let (four, weights) = (moved.joints[index as usize], moved.weights[index as usize]);
                let parts = four.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
                let place = |joint: u16| joints[usize::from(joint)].transform_point3(point);
                parts.map(|(joint, weight)| place(joint) * f64::from(weight)).sum()
            }
            _ => pose.world(draw.node).transform_point3(point),
        }
    };
    let texcoord = |index: u32| DVec2::from_array(primitive.texcoords[index as usize].map(f64::from));
    let faces = primitive.indices.chunks_exact(3);
    faces
        .map(|face| Triangle {
            corners: [corner(face[0]), corner(face[1]), corner(face[2])],
            texcoords: [texcoord(face[0]), texcoord(face[1]), texcoord(face[2])],
            draw,
        })
        .collect()
}

/// Whether a ray meets a box (by slabs).
fn may_hit(bounds: &Bounds, origin: DVec3, direction: DVec3) -> bool {
    let (low, high) = ((bounds.minimum - origin) / direction, (bounds.maximum - origin) / direction);
    let (enter, leave) = (low.min(high).max_element(), low.max(high).min_element());
    // A ray along a face divides zero by zero: it counts as a hit.
    let passes_by = leave < enter.max(0.0) - 1e-9;
    !passes_by
}

/// Where a ray meets a triangle, from either side: the distance and two barycentric coordinates (Möller and Trumbore).
fn hit(corners: &[DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, f64, f64)> {
    let (ab, ac) = (corners[1] - corners[0], corners[2] - corners[0]);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant.abs() < 1e-14 {
        return None;
    }
    let to_origin = origin - corners[0];
    let b = to_origin.dot(p) / determinant;
    let q = to_origin.cross(ab);
    let c = direction.dot(q) / determinant;
    let t = ac.dot(q) / determinant;
    (b >= 0.0 && c >= 0.0 && b + c <= 1.0 && t > 0.0).then_some((t, b, c))
}

/// A point, the pixel that shows it, and whether the sun shines there.
struct Point {
    pixel: [u32; 2],
    at: DVec3,
    is_lit: bool,
}

/// Points that a camera sees on what stands still and faces the sun, on a grid of pixels, away from edges of shadows.
fn points_in_view(rays: &Rays<'_>, input: &FrameInput, step: u32, margin: f64) -> Vec<Point> {
    let world_from_clip = (input.camera.clip(false) * input.camera.view()).inverse();
    let to_sun = -input.lights[0].direction;
    let mut points = Vec::new();
    for y in (step / 2..SIZE[1]).step_by(step as usize) {
        for x in (step / 2..SIZE[0]).step_by(step as usize) {
            let ndc = DVec2::new(
                (f64::from(x) + 0.5) / f64::from(SIZE[0]) * 2.0 - 1.0,
                1.0 - (f64::from(y) + 0.5) / f64::from(SIZE[1]) * 2.0,
            );
            let origin = input.camera.position;
            let direction = (world_from_clip.project_point3(ndc.extend(0.5)) - origin).normalize();
            let Some((t, triangle)) = rays.nearest(origin, direction) else { continue };
            let at = origin + direction * t;
            let [a, b, c] = triangle.corners;
            let normal = (b - a).cross(c - a).normalize();
            let is_masked = rays.scene.is_alpha_masked(triangle.draw);
            if triangle.draw.dynamic || is_masked || normal.dot(to_sun) < 0.3 || t > 14.0 {
                continue;
            }
            let (across, along) = normal.any_orthonormal_pair();
            let around = [across, -across, along, -along];
            let is_lit = rays.is_lit(at, to_sun);
            if around.into_iter().all(|offset| rays.is_lit(at + offset * margin, to_sun) == is_lit) {
                points.push(Point { pixel: [x, y], at, is_lit });
            }
        }
    }
    points
}

fn shadow_term(gpu: &Gpu, scene: &Scene, input: &FrameInput) -> Picture {
    let parameters =
        [("debug_view", "\"shadow_term\""), ("far", "[6, 16, 60]"), ("resolution", "2048"), ("blend", "0")];
    let with = With { parameters: &parameters, size: Some(SIZE), ..With::default() };
    render_frame(gpu, check_file("pipelines/nebula.json", &with).plan(), scene, input)
}

fn is_lit_in(picture: &Picture, point: &Point) -> bool {
    let [x, y] = point.pixel;
    picture.bytes()[((y * SIZE[0] + x) * 4) as usize] >= 128
}

fn input(scene: &Scene, time: f64) -> FrameInput {
    scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), time)
}

fn share(count: usize, of: usize) -> f64 {
    count as f64 / of.max(1) as f64
}

#[test]
fn sunlight_falls_through_the_holes_of_leaves_and_nowhere_else() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/foliage.glb"));
    let (input, pose) = (input(&scene, 0.0), scene.pose(0.0));
    let points = points_in_view(&Rays::new(&scene, &pose, true), &input, 3, 0.02);
    let picture = shadow_term(&gpu, &scene, &input);
    let agree = points.iter().filter(|point| is_lit_in(&picture, point) == point.is_lit).count();
    let shadowed = points.iter().filter(|point| !point.is_lit).count();
    assert!(shadowed > 100 && points.len() > 1000, "{shadowed} of {} points", points.len());
    assert!(share(agree, points.len()) > 0.97, "{agree} of {} points", points.len());
    // Where whole cards would throw a shadow, but the leaves that are cut out of them do not.
    let (whole, to_sun) = (Rays::new(&scene, &pose, false), -input.lights[0].direction);
    let through: Vec<&Point> =
        points.iter().filter(|point| point.is_lit && !whole.is_lit(point.at, to_sun)).collect();
    let lit = through.iter().filter(|point| is_lit_in(&picture, point)).count();
    assert!(through.len() > 100, "{} points are lit through holes", through.len());
    assert!(share(lit, through.len()) > 0.9, "{lit} of {} points", through.len());
}

#[test]
fn the_shadow_of_a_skinned_figure_is_where_its_joints_have_taken_it() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/figure.glb"));
    let mut seen: Vec<(Vec<Point>, Picture)> = Vec::new();
    for time in [0.0, 1.5] {
        let input = input(&scene, time);
        let points = points_in_view(&Rays::new(&scene, &scene.pose(time), true), &input, 3, 0.01);
        let picture = shadow_term(&gpu, &scene, &input);
        let agree = points.iter().filter(|point| is_lit_in(&picture, point) == point.is_lit).count();
        assert!(points.len() > 1000, "{} points", points.len());
        assert!(share(agree, points.len()) > 0.99, "at {time}: {agree} of {} points", points.len());
        seen.push((points, picture));
    }
    let [(before, first), (after, second)] = seen.as_slice() else { panic!("two times") };
    // Where the shadow has come or gone.
    let moved: Vec<(&Point, &Point)> = before
        .iter()
        .filter_map(|point| Some((point, after.iter().find(|other| other.pixel == point.pixel)?)))
        .filter(|(point, other)| point.is_lit != other.is_lit)
        .collect();
    let agree = moved.iter().filter(|(point, other)| {
        is_lit_in(first, point) == point.is_lit && is_lit_in(second, other) == other.is_lit
    });
    assert!(moved.len() > 20, "only {} points change between light and shadow", moved.len());
    assert!(share(agree.count(), moved.len()) > 0.9, "of {} points", moved.len());
}
