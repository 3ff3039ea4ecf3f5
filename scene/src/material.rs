//! Surfaces: the properties of glTF materials that the engine uses.

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

/// A surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// Linear base colour and alpha, multiplied with the texture's.
    pub base_color: [f32; 4],
    /// The index of the base colour texture in [`Scene::textures`](crate::Scene::textures).
    pub base_color_texture: Option<usize>,
    /// Linear colour that the surface emits, multiplied with the texture's.
    pub emissive: [f32; 3],
    /// The index of the texture of emitted colour in [`Scene::textures`](crate::Scene::textures).
    pub emissive_texture: Option<usize>,
    /// The meaning of alpha.
    pub alpha_mode: AlphaMode,
    /// Whether back faces are drawn, lit by the reversed normal.
    pub double_sided: bool,
    /// Whether the surface casts shadows (`extras.castShadow`, true where absent).
    pub cast_shadow: bool,
    /// Whether the surface receives shadows (`extras.receiveShadow`, true where absent).
    pub receive_shadow: bool,
}

impl Material {
    /// Whether a shader needs more of the material than base colour and constant emission.
    pub fn is_pbr(&self) -> bool {
        self.emissive_texture.is_some()
    }
}

impl Default for Material {
    /// glTF's default material: white, opaque, one-sided.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_texture: None,
            emissive: [0.0; 3],
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            cast_shadow: true,
            receive_shadow: true,
        }
    }
}
