//! Surface points: attributes of vertices between corners, with the textures and factors of the material.
//!
//! Normal maps bend the normal in the tangent space of the file or of MikkTSpace, as the loader has it; without
//! tangents, in that of the triangle's texture coordinates.

use glam::{DVec2, DVec3, DVec4};
use umbragraph_scene::material::{AlphaMode, Map, Material};
use umbragraph_scene::mesh::Primitive;
use umbragraph_scene::{Pose, Scene};

use super::brdf::{Brdf, MIN_COSINE, Reflectance};
use super::texture::{Changes, Textures};
use super::vertices::{Directions, directions};
use crate::triangles::{Hit, Triangle};

/// All that turns a hit into a surface point.
pub struct Surfaces<'s> {
    scene: &'s Scene,
    textures: Textures<'s>,
    /// The directions of the vertices of each draw.
    directions: Vec<Directions>,
}

/// A surface point as light sees it.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The position in world metres.
    pub position: DVec3,
    /// The unit normal of shading, toward the visible side.
    pub normal: DVec3,
    /// The unit normal of the triangle, toward the visible side.
    pub plane: DVec3,
    /// Two unit vectors across the normal.
    across: [DVec3; 2],
    /// The reflection toward the view; `None` for a surface without lighting.
    pub brdf: Option<Brdf>,
    /// Emitted radiance.
    pub emission: DVec3,
    /// The part of ambient light that arrives by the occlusion map, 0 to 1.
    pub occlusion: f64,
}

impl Point {
    /// A world direction in the axes of the reflection.
    pub fn to_local(&self, world: DVec3) -> DVec3 {
        DVec3::new(world.dot(self.across[0]), world.dot(self.across[1]), world.dot(self.normal))
    }

    /// A direction of the reflection in the world.
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        self.across[0] * local.x + self.across[1] * local.y + self.normal * local.z
    }
}

/// A pixel on the plane of a triangle: world offsets of its neighbours to the right and below.
pub type Footprint = [DVec3; 2];

/// The three vertices of a hit triangle, and where between them the hit lies.
struct Place<'s> {
    primitive: &'s Primitive,
    face: [usize; 3],
    weights: [f64; 3],
    /// Changes of the weights from a pixel to its neighbours.
    changes: Option<[[f64; 3]; 2]>,
}

impl Place<'_> {
    fn texcoord(&self, of: impl Fn(usize) -> [f32; 2]) -> (DVec2, Option<Changes>) {
        let corners = self.face.map(|vertex| DVec2::from_array(of(vertex).map(f64::from)));
        let mixed =
            |weights: [f64; 3]| corners.iter().zip(weights).map(|(corner, weight)| *corner * weight).sum();
        (mixed(self.weights), self.changes.map(|changes| changes.map(mixed)))
    }

    fn vector(&self, of: impl Fn(usize) -> DVec3) -> DVec3 {
        self.face.iter().zip(self.weights).map(|(vertex, weight)| of(*vertex) * weight).sum()
    }
}

impl<'s> Surfaces<'s> {
    /// Prepares the surfaces of a scene in a pose.
    pub fn new(scene: &'s Scene, pose: &Pose) -> Self {
        let directions = scene.draws().map(|draw| directions(scene, draw, pose)).collect();
        Self { scene, textures: Textures::new(scene), directions }
    }

    fn place(
        &self,
        triangle: &Triangle,
        hit: Hit,
        footprint: Option<Footprint>,
    ) -> Option<(Place<'s>, &'s Material)> {
        let draw = self.scene.draws().nth(triangle.draw as usize)?;
        let primitive = self.scene.primitive(draw);
        let first = 3 * triangle.index as usize;
        let face: [u32; 3] = primitive.indices.get(first..first + 3)?.try_into().ok()?;
        let [a, b, c] = triangle.corners;
        let cross = (b - a).cross(c - a);
        let size = cross.length_squared();
        let weights = |second: f64, third: f64| [1.0 - second - third, second, third];
        // By how much the weights of the corners change along an offset in the plane.
        let changed = |offset: DVec3| {
            let (second, third) =
                (offset.cross(c - a).dot(cross) / size, (b - a).cross(offset).dot(cross) / size);
            [-second - third, second, third]
        };
        let place = Place {
            primitive,
            face: face.map(|vertex| vertex as usize),
            weights: weights(hit.weights.x, hit.weights.y),
            changes: footprint.filter(|_| size > 0.0).map(|footprint| footprint.map(changed)),
        };
        Some((place, self.scene.material(draw)))
    }

    fn mapped(&self, place: &Place<'_>, map: Option<Map>, is_srgb: bool) -> DVec4 {
        let Some(map) = map else { return DVec4::ONE };
        let coordinates = |vertex: usize| {
            let details = place.primitive.details.as_ref().and_then(|details| details.get(vertex));
            let [u, v, s, t] = details.map_or([0.0; 4], |detail| detail.texcoords);
            map.texcoord(if map.set == 0 { [u, v] } else { [s, t] })
        };
        let (at, changes) = place.texcoord(coordinates);
        self.textures.sample(map, is_srgb, at, changes)
    }

    /// Base color and alpha: factor, texture and color of the vertices.
    fn color(&self, place: &Place<'_>, material: &Material) -> DVec4 {
        let mut color = DVec4::from_array(material.base_color.map(f64::from));
        if let Some(map) = material.base_color_map {
            let (at, changes) = place.texcoord(|vertex| place.primitive.texcoords[vertex]);
            color *= self.textures.sample(map, true, at, changes);
        }
        if let Some(details) = &place.primitive.details {
            let part = |(vertex, weight): (&usize, f64)| {
                DVec4::from_array(details[*vertex].color.map(f64::from)) * weight
            };
            color *= place.face.iter().zip(place.weights).map(part).sum::<DVec4>();
        }
        color
    }

    /// The part of what lies behind a hit that its surface covers: alpha of a blended one, 1 of others.
    pub fn coverage(&self, triangle: &Triangle, hit: Hit, footprint: Option<Footprint>) -> f64 {
        let Some((place, material)) = self.place(triangle, hit, footprint) else { return 1.0 };
        match material.alpha_mode {
            AlphaMode::Blend => self.color(&place, material).w.clamp(0.0, 1.0),
            _ => 1.0,
        }
    }

    /// The surface point of a hit, seen along `toward` (a unit vector from the camera).
    pub fn point(
        &self,
        triangle: &Triangle,
        is_front: bool,
        hit: Hit,
        toward: DVec3,
        footprint: Option<Footprint>,
    ) -> Option<Point> {
        let (place, material) = self.place(triangle, hit, footprint)?;
        let corners = triangle.corners;
        let position = corners[0]
            + (corners[1] - corners[0]) * hit.weights.x
            + (corners[2] - corners[0]) * hit.weights.y;
        let directions = self.directions.get(triangle.draw as usize)?;
        let plain = place.vector(|vertex| directions.normals[vertex]).normalize_or(triangle.normal());
        let mut normal = self.bent(&place, material, directions, triangle, plain);
        if !is_front {
            normal = -normal;
        }
        // A normal that faces away is turned until it is seen.
        let cosine = -toward.dot(normal);
        if cosine < MIN_COSINE {
            normal = (normal - toward * (MIN_COSINE - cosine)).normalize_or(-toward);
        }
        let (one, other) = normal.any_orthonormal_pair();
        let plane = triangle.normal();
        let plane = if plane.dot(toward) > 0.0 { -plane } else { plane };
        let mut point = Point {
            position,
            normal,
            plane,
            across: [one, other],
            brdf: None,
            emission: DVec3::ZERO,
            occlusion: 1.0,
        };
        let color = self.color(&place, material).truncate();
        if material.unlit {
            point.emission = color;
            return Some(point);
        }
        let rough = self.mapped(&place, material.metallic_roughness_map, false);
        let reflectance = Reflectance {
            base_color: color.clamp(DVec3::ZERO, DVec3::ONE),
            metallic: f64::from(material.metallic) * rough.z,
            roughness: f64::from(material.roughness) * rough.y,
            f0: DVec3::from_array(material.f0.map(f64::from)),
            f90: f64::from(material.f90),
        };
        point.brdf = Some(Brdf::new(&reflectance, point.to_local(-toward)));
        let light = self.mapped(&place, material.emissive_map, true).truncate();
        point.emission = DVec3::from_array(material.emissive.map(f64::from)) * light;
        let open = self.mapped(&place, material.occlusion_map, false).x;
        point.occlusion = 1.0 + f64::from(material.occlusion_strength) * (open - 1.0);
        Some(point)
    }

    /// The normal of a normal map in the world (glTF 2.0, section 3.9.3); the plain one without a map.
    fn bent(
        &self,
        place: &Place<'_>,
        material: &Material,
        directions: &Directions,
        triangle: &Triangle,
        plain: DVec3,
    ) -> DVec3 {
        let Some(map) = material.normal_map else { return plain };
        let texel = self.mapped(place, Some(map), false).truncate() * 2.0 - 1.0;
        let scale = f64::from(material.normal_scale);
        let of = |vertex: &usize| directions.tangents.get(*vertex).copied().unwrap_or_default();
        let sign = place.face.first().map_or(0.0, |vertex| of(vertex).w);
        let own = place.vector(|vertex| of(&vertex).truncate());
        let (tangent, bitangent) = if sign != 0.0 && own != DVec3::ZERO {
            let tangent = own.normalize();
            (tangent, plain.cross(tangent) * sign.signum())
        } else {
            self.along_texcoords(place, map, triangle, plain)
        };
        let bent = tangent * (texel.x * scale) + bitangent * (texel.y * scale) + plain * texel.z;
        bent.normalize_or(plain)
    }

    /// Tangent and bitangent of a triangle by its texture coordinates; green of a normal map points against v.
    fn along_texcoords(
        &self,
        place: &Place<'_>,
        map: Map,
        triangle: &Triangle,
        plain: DVec3,
    ) -> (DVec3, DVec3) {
        let at = |vertex: usize| {
            let details = place.primitive.details.as_ref().and_then(|details| details.get(vertex));
            let [u, v, s, t] = details.map_or([0.0; 4], |detail| detail.texcoords);
            DVec2::from_array(map.texcoord(if map.set == 0 { [u, v] } else { [s, t] }).map(f64::from))
        };
        let ([a, b, c], [p, q, r]) = (place.face.map(at), triangle.corners);
        let (one, other) = (b - a, c - a);
        let area = one.perp_dot(other);
        if area == 0.0 {
            return (DVec3::ZERO, DVec3::ZERO);
        }
        let tangent = ((q - p) * other.y - (r - p) * one.y) / area;
        let bitangent = ((q - p) * other.x - (r - p) * one.x) / area;
        let flat = |vector: DVec3| (vector - plain * vector.dot(plain)).normalize_or_zero();
        (flat(tangent), flat(bitangent))
    }
}
