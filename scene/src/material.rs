//! Surfaces: glTF's metallic-roughness material and the extensions that the engine uses.

/// The alpha mode of a material: alpha is ignored, tested against a cutoff, or used for blending.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// The surface is fully opaque, and alpha is ignored.
    Opaque,
    /// Alpha test: fragments with an alpha below the cutoff are discarded.
    Mask {
        /// The smallest alpha of a fragment that is drawn, usually from 0 to 1.
        cutoff: f32,
    },
    /// Alpha blending: surfaces are drawn from back to front, and blended with the picture by their alpha.
    Blend,
}

/// A texture of a material, and the texture coordinates at which it is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// The index of the texture in [`Scene::textures`](crate::Scene::textures).
    pub texture: usize,
    /// The index of the texture coordinate set of the mesh, 0 or 1 (`TEXCOORD_0` or `TEXCOORD_1`).
    pub set: u32,
    /// The two rows of the matrix that transforms texture coordinates of the mesh before the texture is sampled
    /// (`KHR_texture_transform`). The last column is the offset.
    pub transform: [[f32; 3]; 2],
}

impl Map {
    /// The value of `transform` that leaves texture coordinates unchanged.
    pub const IDENTITY: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    /// Transforms texture coordinates of the mesh to the coordinates at which the texture is sampled.
    pub fn texcoord(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        self.transform.map(|[x, y, offset]| x * u + y * v + offset)
    }
}

/// A surface described by the metallic-roughness model of glTF.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// Linear base colour and alpha, multiplied with the base colour texture.
    pub base_color: [f32; 4],
    /// The base colour texture; `None` for a uniform colour. Its transformed coordinates are in
    /// [`Primitive::texcoords`](crate::mesh::Primitive::texcoords).
    pub base_color_map: Option<Map>,
    /// Metalness from 0 (dielectric) to 1 (metal), multiplied with the blue channel of `metallic_roughness_map`.
    pub metallic: f32,
    /// Perceptual roughness from 0 (mirror) to 1 (fully rough), multiplied with the green channel of
    /// `metallic_roughness_map`.
    pub roughness: f32,
    /// The texture with roughness in green and metalness in blue; `None` if the factors alone apply.
    pub metallic_roughness_map: Option<Map>,
    /// The normal map in tangent space; `None` if vertex normals are used unchanged.
    pub normal_map: Option<Map>,
    /// The factor by which the x and y components of normals from `normal_map` are multiplied.
    pub normal_scale: f32,
    /// The occlusion map, whose red channel is the fraction of ambient light that reaches the surface. `None` without
    /// occlusion.
    pub occlusion_map: Option<Map>,
    /// The strength of `occlusion_map`, from 0 (no effect) to 1.
    pub occlusion_strength: f32,
    /// The linear colour of emitted light, multiplied with `emissive_map`. It includes the factor of
    /// `KHR_materials_emissive_strength`.
    pub emissive: [f32; 3],
    /// The texture of emitted colour, multiplied with `emissive`; `None` for a uniform emission.
    pub emissive_map: Option<Map>,
    /// Reflectance (red, green, blue) of the dielectric at normal incidence, from 0 to 1 (`KHR_materials_ior`,
    /// `KHR_materials_specular`).
    pub f0: [f32; 3],
    /// Reflectance of the dielectric at grazing incidence, from 0 to 1.
    pub f90: f32,
    /// Whether the base colour is output without lighting (`KHR_materials_unlit`).
    pub unlit: bool,
    /// The alpha mode: alpha is ignored, tested against a cutoff, or used for blending.
    pub alpha_mode: AlphaMode,
    /// Whether back faces are drawn, lit with the reversed normal.
    pub double_sided: bool,
    /// Whether the surface casts shadows (glTF property `extras.castShadow`, `true` if absent).
    pub cast_shadow: bool,
    /// Whether the surface receives shadows (glTF property `extras.receiveShadow`, `true` if absent).
    pub receive_shadow: bool,
}

/// Reflectance at normal incidence of a dielectric with the refractive index 1.5, the default of glTF.
pub const DEFAULT_F0: f32 = 0.04;

impl Material {
    /// Returns `true` if the material needs the full physically based model, beyond base colour and constant emission.
    /// Returns `false` for a dielectric of roughness 1 with no map other than base colour. Shaders treat such a
    /// material as Lambertian; its reflectance is then within 1 % of the full model.
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
    /// The material of primitives that name no material: white, opaque, one-sided and Lambertian. glTF's own default is
    /// a metal of roughness 1. It reflects light about as strongly and evenly, but takes several times as long to
    /// shade.
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
