//! The world-space triangles of a scene in a pose.
//!
//! Positions are those of [`umbragraph_scene::trace`]: morphed, and moved by nodes or joints. Materials change hits: alpha
//! masks have holes, and the camera does not see the back of a single-sided material. Light rays stop at either side, as
//! casters are drawn.

use glam::{DVec2, DVec3};
use umbragraph_pipeline::wgpu_types::{AddressMode, FilterMode};
use umbragraph_scene::material::AlphaMode;
use umbragraph_scene::texture::{Image, Texture};
use umbragraph_scene::trace::place;
use umbragraph_scene::{Draw, Pose, Scene};

/// A triangle in world space.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// The corners in world metres, counter-clockwise seen from the front.
    pub corners: [DVec3; 3],
    /// The index of the triangle's draw in [`Scene::draws`].
    pub draw: u32,
    /// The index of the triangle in its draw.
    pub index: u32,
}

/// The point where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The distance along the ray, in lengths of its direction.
    pub distance: f64,
    /// The barycentric weights of the triangle's second and third corner.
    pub weights: DVec2,
}

impl Triangle {
    /// The unit normal of the triangle's front; zero for a triangle without area.
    pub fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// Intersects the triangle with a ray, from either side (Möller and Trumbore, 1997). The distance of the hit may be
    /// negative; `None` without a hit.
    pub fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let p = direction.cross(ac);
        let determinant = ab.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let from_corner = origin - a;
        let second = from_corner.dot(p) / determinant;
        if !(0.0..=1.0).contains(&second) {
            return None;
        }
        let q = from_corner.cross(ab);
        let third = direction.dot(q) / determinant;
        let inside = third >= 0.0 && second + third <= 1.0;
        inside.then(|| Hit { distance: ac.dot(q) / determinant, weights: DVec2::new(second, third) })
    }
}

/// All triangles that a scene shows in a pose, in the order of its draws.
pub fn triangles_of(scene: &Scene, pose: &Pose) -> Vec<Triangle> {
    let (mut all, mut places) = (Vec::new(), Vec::new());
    for (at, draw) in (0_u32..).zip(scene.draws()) {
        place(scene, draw, pose, &mut places);
        let primitive = scene.primitive(draw);
        let faces = (0_u32..).zip(primitive.indices.chunks_exact(3));
        all.extend(faces.map(|(index, face)| {
            let corner = |corner: usize| places[face[corner] as usize];
            Triangle { corners: [corner(0), corner(1), corner(2)], draw: at, index }
        }));
    }
    all
}

/// The properties of a draw that ray queries need: shadow casting and receiving, blending, sides and alpha mask.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    pub(crate) casts: bool,
    pub(crate) receives: bool,
    pub(crate) is_blended: bool,
    pub(crate) is_double_sided: bool,
    /// Whether the node mirrors the draw, so that its fronts are clockwise (glTF 2.0, section 3.7.4).
    is_mirrored: bool,
    pub(crate) mask: Option<Mask>,
}

/// An alpha mask: surface points with less alpha than the cutoff are holes.
#[derive(Clone, Debug)]
pub(crate) struct Mask {
    draw: Draw,
    cutoff: f64,
    factor: f64,
    texture: Option<Texture>,
}

impl Surface {
    /// Returns `true` if a ray in a direction meets the front of a triangle of the draw.
    pub(crate) fn is_front(&self, triangle: &Triangle, direction: DVec3) -> bool {
        (triangle.normal().dot(direction) < 0.0) != self.is_mirrored
    }
}

pub(crate) fn surface_of(scene: &Scene, draw: Draw, pose: &Pose) -> Surface {
    let material = scene.material(draw);
    let mask = match material.alpha_mode {
        AlphaMode::Mask { cutoff } => Some(Mask {
            draw,
            cutoff: f64::from(cutoff),
            factor: f64::from(material.base_color[3]),
            texture: material.base_color_map.and_then(|map| scene.textures.get(map.texture)).copied(),
        }),
        _ => None,
    };
    Surface {
        casts: draw.cast_shadow,
        receives: draw.receive_shadow,
        is_blended: material.alpha_mode == AlphaMode::Blend,
        is_double_sided: material.double_sided,
        is_mirrored: draw.skin.is_none() && pose.world(draw.node).determinant() < 0.0,
        mask,
    }
}

impl Mask {
    /// The data that decide the places of holes, besides the mask's own fields: image, texture coordinates and vertex
    /// indices.
    pub(crate) fn parts<'s>(&self, scene: &'s Scene) -> (Option<&'s Image>, &'s [[f32; 2]], &'s [u32]) {
        let primitive = scene.primitive(self.draw);
        let image = self.texture.and_then(|texture| scene.images.get(texture.image));
        (image, &primitive.texcoords, &primitive.indices)
    }

    /// Returns `true` if the alpha mask has a hole at the hit point of a triangle of its draw.
    pub(crate) fn is_hole(&self, scene: &Scene, triangle: &Triangle, hit: Hit) -> bool {
        let Some(texture) = self.texture else { return self.factor < self.cutoff };
        let primitive = scene.primitive(self.draw);
        let first = 3 * triangle.index as usize;
        let Some(face) = primitive.indices.get(first..first + 3) else { return false };
        let [a, b, c] = [0, 1, 2]
            .map(|corner| DVec2::from_array(primitive.texcoords[face[corner] as usize].map(f64::from)));
        let place = a + (b - a) * hit.weights.x + (c - a) * hit.weights.y;
        alpha(&scene.images[texture.image], &texture, place) * self.factor < self.cutoff
    }
}

/// The alpha, 0 to 1, of the image's base mip level at the texture coordinate `place`, filtered as the sampler
/// magnifies.
fn alpha(image: &Image, texture: &Texture, place: DVec2) -> f64 {
    let size = DVec2::new(f64::from(image.width), f64::from(image.height));
    let sampler = texture.sampler;
    let texel = |x: f64, y: f64| {
        let x = wrapped(x, image.width, sampler.wrap_u);
        let y = wrapped(y, image.height, sampler.wrap_v);
        let at = (y as usize * image.width as usize + x as usize) * 4 + 3;
        f64::from(image.rgba.get(at).copied().unwrap_or(255)) / 255.0
    };
    match sampler.magnify {
        FilterMode::Nearest => {
            let at = (place * size).floor();
            texel(at.x, at.y)
        }
        FilterMode::Linear => {
            let at = place * size - 0.5;
            let (low, part) = (at.floor(), at - at.floor());
            let row = |y: f64| texel(low.x, y) * (1.0 - part.x) + texel(low.x + 1.0, y) * part.x;
            row(low.y) * (1.0 - part.y) + row(low.y + 1.0) * part.y
        }
    }
}

/// The index, 0 to `count` − 1, of the texel that the address mode gives for a texel coordinate.
pub(crate) fn wrapped(at: f64, count: u32, wrap: AddressMode) -> u32 {
    let size = f64::from(count);
    let inside = match wrap {
        AddressMode::Repeat => at.rem_euclid(size),
        AddressMode::ClampToEdge | AddressMode::ClampToBorder => at,
        AddressMode::MirrorRepeat => {
            let twice = at.rem_euclid(2.0 * size);
            if twice < size { twice } else { 2.0 * size - 1.0 - twice }
        }
    };
    inside.clamp(0.0, size - 1.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_a_triangle_from_both_sides_and_nothing_beside_it() {
        let triangle = Triangle { corners: [DVec3::ZERO, DVec3::X, DVec3::Y], draw: 0, index: 0 };
        for side in [1.0, -1.0] {
            let from = DVec3::new(0.25, 0.5, 2.0 * side);
            let hit = triangle.hit(from, DVec3::Z * -side).unwrap();
            assert_eq!((hit.distance, hit.weights), (2.0, DVec2::new(0.25, 0.5)));
            assert_eq!(triangle.hit(DVec3::new(0.6, 0.5, 2.0 * side), DVec3::Z * -side), None);
            assert!(triangle.hit(from, DVec3::Z * side).unwrap().distance < 0.0);
        }
        assert_eq!(triangle.hit(DVec3::Z, DVec3::X), None, "along its plane");
        assert_eq!(triangle.normal(), DVec3::Z);
    }

    #[test]
    fn textures_repeat_end_or_are_mirrored() {
        let at = |wrap| [-5.0, -1.0, 0.0, 3.0, 4.0, 6.0].map(|at| wrapped(at, 4, wrap));
        assert_eq!(at(AddressMode::Repeat), [3, 3, 0, 3, 0, 2]);
        assert_eq!(at(AddressMode::ClampToEdge), [0, 0, 0, 3, 3, 3]);
        assert_eq!(at(AddressMode::MirrorRepeat), [3, 0, 0, 3, 3, 1]);
        assert_eq!(wrapped(f64::NAN, 4, AddressMode::Repeat), 0);
    }
}
