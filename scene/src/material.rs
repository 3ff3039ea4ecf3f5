//! Surfaces: glTF's metallic-roughness material and the extensions that the engine uses.

/// The use of a material's alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// The surface is fully opaque, and alpha is ignored.
    Opaque,
    /// Alpha test: fragments with an alpha below the cutoff are discarded.
    Mask {
        /// The smallest alpha that is drawn.
        cutoff: f32,
    },
    /// Alpha blending: the surface is drawn over the surfaces behind it, from back to front.
    Blend,
}

/// A texture of a material, and the texture coordinates used to sample it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// The index of the texture in [`Scene::textures`](crate::Scene::textures).
    pub texture: usize,
    /// The index of the texture coordinate set of the mesh, 0 or 1 (`TEXCOORD_0` or `TEXCOORD_1`).
    pub set: u32,
    /// The two rows of the matrix that transforms coordinates of the set to coordinates of the texture
    /// (`KHR_texture_transform`). The last column is the offset.
    pub transform: [[f32; 3]; 2],
}

impl Map {
    /// The identity transform of texture coordinates.
    pub const IDENTITY: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    /// Transforms coordinates of the mesh's set to coordinates of the texture.
    pub fn texcoord(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        self.transform.map(|[x, y, offset]| x * u + y * v + offset)
    }
}

/// A surface with the metallic-roughness model of glTF.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// Linear base colour and alpha, multiplied with the base colour texture.
    pub base_color: [f32; 4],
    /// The texture of base colour, if any. Its transformed coordinates are in
    /// [`Primitive::texcoords`](crate::mesh::Primitive::texcoords).
    pub base_color_map: Option<Map>,
    /// Metalness from 0 (dielectric) to 1 (metal), multiplied with the blue channel of the texture.
    pub metallic: f32,
    /// Perceptual roughness from 0 (mirror) to 1 (fully rough), multiplied with the green channel of the texture.
    pub roughness: f32,
    /// The texture with roughness in green and metalness in blue, if any.
    pub metallic_roughness_map: Option<Map>,
    /// The normal map in tangent space, if any.
    pub normal_map: Option<Map>,
    /// The factor of the x and y components of normals from `normal_map`.
    pub normal_scale: f32,
    /// The occlusion map, if any: its red channel is the fraction of ambient light that reaches the surface.
    pub occlusion_map: Option<Map>,
    /// The strength of `occlusion_map`, from 0 (no effect) to 1.
    pub occlusion_strength: f32,
    /// Linear colour that the surface emits, multiplied with the emissive texture; includes
    /// `KHR_materials_emissive_strength`.
    pub emissive: [f32; 3],
    /// The texture of emitted colour, if any.
    pub emissive_map: Option<Map>,
    /// Reflectance of the dielectric at normal incidence (`KHR_materials_ior`, `KHR_materials_specular`).
    pub f0: [f32; 3],
    /// Reflectance of the dielectric at grazing incidence.
    pub f90: f32,
    /// Whether the base colour is output without lighting (`KHR_materials_unlit`).
    pub unlit: bool,
    /// The use of alpha: ignored, tested against a cutoff, or blended.
    pub alpha_mode: AlphaMode,
    /// Whether back faces are drawn, lit with the reversed normal.
    pub double_sided: bool,
    /// Whether the surface casts shadows (`extras.castShadow`, true where absent).
    pub cast_shadow: bool,
    /// Whether the surface receives shadows (`extras.receiveShadow`, true where absent).
    pub receive_shadow: bool,
}

/// Reflectance at normal incidence of a dielectric with the refractive index 1.5.
pub const DEFAULT_F0: f32 = 0.04;

impl Material {
    /// Returns `true` if a shader needs more of the material than base colour and constant emission. A dielectric of
    /// roughness 1 without maps does not. It is shaded as a Lambertian surface, with a reflectance within 1 % of the
    /// full model.
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
    /// The material of primitives that reference none: white, opaque, one-sided and Lambertian. The default of glTF is
    /// a metal of roughness 1, which reflects about as much light as evenly but takes several times the shading time.
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
