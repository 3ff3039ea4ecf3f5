//! Surfaces: glTF's metallic-roughness material and the extensions that the engine uses.

/// The meaning of a material's alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Alpha below the cutoff is a hole.
    Mask {
        /// The smallest alpha that is drawn.
        cutoff: f32,
    },
    /// Alpha is coverage: drawn over what is behind, from back to front.
    Blend,
}

/// A texture of a material, and the texture coordinates with which it is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// The index in [`Scene::textures`](crate::Scene::textures).
    pub texture: usize,
    /// The set of texture coordinates, 0 or 1.
    pub set: u32,
    /// From the coordinates of the set to those of the texture (`KHR_texture_transform`): rows of a matrix, the offset
    /// last.
    pub transform: [[f32; 3]; 2],
}

impl Map {
    /// The matrix that leaves coordinates as they are.
    pub const IDENTITY: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    /// The texture coordinates for those of the set.
    pub fn texcoord(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        self.transform.map(|[x, y, offset]| x * u + y * v + offset)
    }
}

/// A surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// Linear base colour and alpha, multiplied with the texture's.
    pub base_color: [f32; 4],
    /// The texture of base colour; [`Primitive::texcoords`](crate::mesh::Primitive::texcoords) are its coordinates.
    pub base_color_map: Option<Map>,
    /// 0 for a dielectric, 1 for a metal; multiplied with the blue channel of the texture.
    pub metallic: f32,
    /// Perceptual roughness, 0 for a mirror, 1 for chalk; multiplied with the green channel of the texture.
    pub roughness: f32,
    /// The texture of roughness and metal.
    pub metallic_roughness_map: Option<Map>,
    /// The texture of normals in tangent space.
    pub normal_map: Option<Map>,
    /// Factor of the first two coordinates of those normals.
    pub normal_scale: f32,
    /// The texture whose red channel is the part of ambient light that arrives.
    pub occlusion_map: Option<Map>,
    /// Weight of that texture, 0 to 1.
    pub occlusion_strength: f32,
    /// Linear colour that the surface emits, multiplied with the texture's; `KHR_materials_emissive_strength` included.
    pub emissive: [f32; 3],
    /// The texture of emitted colour.
    pub emissive_map: Option<Map>,
    /// Reflectance of the dielectric at normal incidence (`KHR_materials_ior`, `KHR_materials_specular`).
    pub f0: [f32; 3],
    /// Reflectance of the dielectric at grazing incidence.
    pub f90: f32,
    /// Whether the base colour is shown as it is, whatever the light (`KHR_materials_unlit`).
    pub unlit: bool,
    /// The meaning of alpha.
    pub alpha_mode: AlphaMode,
    /// Whether back faces are drawn, lit by the reversed normal.
    pub double_sided: bool,
    /// Whether the surface casts shadows (`extras.castShadow`, true where absent).
    pub cast_shadow: bool,
    /// Whether the surface receives shadows (`extras.receiveShadow`, true where absent).
    pub receive_shadow: bool,
}

/// Reflectance at normal incidence of a dielectric with the refractive index 1.5.
pub const DEFAULT_F0: f32 = 0.04;

impl Material {
    /// Whether a shader needs more of the material than base colour and constant emission. A dielectric of roughness 1
    /// without maps does not: it is shaded as a Lambertian surface, whose reflectance is within 1 % of its own.
    pub fn is_pbr(&self) -> bool {
        let maps = [self.metallic_roughness_map, self.normal_map, self.occlusion_map, self.emissive_map];
        self.metallic != 0.0
            || self.roughness != 1.0
            || self.unlit
            || (self.f0, self.f90) != ([DEFAULT_F0; 3], 1.0)
            || maps.iter().any(Option::is_some)
    }
}

impl Default for Material {
    /// The material of primitives that name none: white, opaque, one-sided, a Lambertian surface. glTF's default is a
    /// metal of roughness 1, which reflects about as much light about as evenly, and takes a shader several times as
    /// long.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_map: None,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_map: None,
            normal_map: None,
            normal_scale: 1.0,
            occlusion_map: None,
            occlusion_strength: 1.0,
            emissive: [0.0; 3],
            emissive_map: None,
            f0: [DEFAULT_F0; 3],
            f90: 1.0,
            unlit: false,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            cast_shadow: true,
            receive_shadow: true,
        }
    }
}
