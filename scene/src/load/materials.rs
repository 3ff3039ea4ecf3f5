//! Materials, and the textures that they use.

use gltf::json::extensions::texture::Info as InfoExtensions;
use gltf::json::material::AlphaMode as JsonAlphaMode;
use gltf::json::{Material as JsonMaterial, Root};
use serde_json::{Map as Object, Value};
use std::collections::BTreeMap;

use super::extensions::Extension;
use super::extras::ObjectExtras;
use super::report::Report;
use crate::codes;
use crate::material::{AlphaMode, DEFAULT_F0, Map, Material};

/// The default alpha cutoff of alpha-masked materials.
const DEFAULT_CUTOFF: f32 = 0.5;

/// The maximum of each emissive colour channel after multiplication by `KHR_materials_emissive_strength`: the largest
/// 16-bit float.
const MAX_EMISSION: f32 = 65_504.0;

/// Reads the materials and adds the default material as the last one. The second list has the index in the document of
/// each texture in use; [`Map::texture`] is an index into this list.
pub(super) fn read(root: &Root, report: &mut Report) -> (Vec<Material>, Vec<usize>) {
    let mut textures = Textures { root, list: Vec::new(), places: BTreeMap::new() };
    let mut materials = Vec::with_capacity(root.materials.len() + 1);
    for (index, material) in root.materials.iter().enumerate() {
        materials.push(one(index, material, &mut textures, report));
    }
    materials.push(Material::default());
    (materials, textures.list)
}

/// Collects the indices of the textures in use, each once, in the order of their first use.
struct Textures<'a> {
    root: &'a Root,
    list: Vec<usize>,
    places: BTreeMap<usize, usize>,
}

/// A material's reference to a texture: index of the texture, texture coordinate set, and extensions of the reference.
struct Named<'a> {
    index: usize,
    set: u32,
    extensions: Option<&'a Object<String, Value>>,
}

impl<'a> Named<'a> {
    fn new(texture: &'a gltf::json::texture::Info) -> Self {
        let extensions = texture.extensions.as_ref().map(|InfoExtensions { others }| others);
        Self { index: texture.index.value(), set: texture.tex_coord, extensions }
    }
}

impl Textures<'_> {
    /// Converts the texture reference at the JSON pointer `at` to a [`Map`]. Returns `None` if there is no reference,
    /// or after reporting an error.
    fn map(&mut self, named: Option<Named<'_>>, at: &str, report: &mut Report) -> Option<Map> {
        let Named { index, mut set, extensions } = named?;
        report.lookup(&self.root.textures, index, "texture", &format!("{at}/index"))?;
        let mut transform = Map::IDENTITY;
        if let Some(change) = Extension::find(extensions, "KHR_texture_transform", at) {
            let offset = change.numbers("offset", report).unwrap_or([0.0; 2]);
            let scale = change.numbers("scale", report).unwrap_or([1.0; 2]);
            let [rotation] = change.numbers("rotation", report).unwrap_or([0.0]);
            let (sine, cosine) = rotation.sin_cos();
            transform = [
                [cosine * scale[0], sine * scale[1], offset[0]],
                [-sine * scale[0], cosine * scale[1], offset[1]],
            ];
            set = change.numbers("texCoord", report).map_or(set, |[set]: [f32; 1]| set as u32);
        }
        if set > 1 {
            let message = format!("a texture uses the texture coordinates TEXCOORD_{set}");
            let help = "use the sets 0 and 1; others are not read";
            return report.reject(codes::BAD_MATERIAL, &format!("{at}/texCoord"), message, help);
        }
        let list = &mut self.list;
        let texture = *self.places.entry(index).or_insert_with(|| {
            list.push(index);
            list.len() - 1
        });
        Some(Map { texture, set, transform })
    }
}

fn one(index: usize, json: &JsonMaterial, textures: &mut Textures<'_>, report: &mut Report) -> Material {
    let at = format!("/materials/{index}");
    let extras = ObjectExtras::new(&json.extras, &at);
    let surface = &json.pbr_metallic_roughness;
    let extensions = json.extensions.as_ref().map(|extensions| &extensions.others);
    let (base_color, mut emissive) = (surface.base_color_factor.0, json.emissive_factor.0);
    let (metallic, roughness) = (surface.metallic_factor.0, surface.roughness_factor.0);
    let cutoff = json.alpha_cutoff.map_or(DEFAULT_CUTOFF, |cutoff| cutoff.0);
    let normal_scale = json.normal_texture.as_ref().map_or(1.0, |texture| texture.scale);
    let occlusion_strength = json.occlusion_texture.as_ref().map_or(1.0, |texture| texture.strength.0);
    let mut check = |values: &[f32], max: f32, property: &str| {
        if values.iter().all(|value| (0.0..=max).contains(value)) {
            return;
        }
        let is_above = values.iter().any(|value| *value > max && value.is_finite());
        let problem = if is_above { format!("above {max}") } else { "negative or not finite".to_owned() };
        let message = format!("a factor of material {index} is {problem}: {values:?}");
        report.error(codes::BAD_MATERIAL, &format!("{at}/{property}"), message, "set it between 0 and 1");
    };
    check(&base_color, f32::MAX, "pbrMetallicRoughness/baseColorFactor");
    check(&[metallic], 1.0, "pbrMetallicRoughness/metallicFactor");
    check(&[roughness], 1.0, "pbrMetallicRoughness/roughnessFactor");
    check(&[occlusion_strength], 1.0, "occlusionTexture/strength");
    check(&emissive, f32::MAX, "emissiveFactor");
    check(&[cutoff], f32::MAX, "alphaCutoff");
    if !normal_scale.is_finite() {
        let message = format!("the scale of the normals of material {index} is not finite");
        report.error(
            codes::BAD_MATERIAL,
            &format!("{at}/normalTexture/scale"),
            message,
            "1 leaves normals as they are",
        );
    }
    let message = format!("material {index} has an unknown alpha mode");
    let help = "it is OPAQUE, MASK or BLEND";
    let alpha_mode = match report.known(&json.alpha_mode, &format!("{at}/alphaMode"), message, help) {
        Some(JsonAlphaMode::Opaque) | None => AlphaMode::Opaque,
        Some(JsonAlphaMode::Mask) => AlphaMode::Mask { cutoff },
        Some(JsonAlphaMode::Blend) => AlphaMode::Blend,
    };
    if let Some(strength) = Extension::find(extensions, "KHR_materials_emissive_strength", &at) {
        let [strength] = strength.positive("emissiveStrength", report).unwrap_or([1.0]);
        emissive = emissive.map(|part| (part * strength).min(MAX_EMISSION));
    }
    let (f0, f90) = reflectance(extensions, &at, report);
    let mut map = |named, property: &str| textures.map(named, &format!("{at}/{property}"), report);
    let (color, metal) = (&surface.base_color_texture, &surface.metallic_roughness_texture);
    let normal = json.normal_texture.as_ref().map(|texture| Named {
        index: texture.index.value(),
        set: texture.tex_coord,
        extensions: texture.extensions.as_ref().map(|extensions| &extensions.others),
    });
    let occlusion = json.occlusion_texture.as_ref().map(|texture| Named {
        index: texture.index.value(),
        set: texture.tex_coord,
        extensions: texture.extensions.as_ref().map(|extensions| &extensions.others),
    });
    Material {
        name: json.name.clone().unwrap_or_default(),
        base_color,
        base_color_map: map(color.as_ref().map(Named::new), "pbrMetallicRoughness/baseColorTexture"),
        metallic,
        roughness,
        metallic_roughness_map: map(
            metal.as_ref().map(Named::new),
            "pbrMetallicRoughness/metallicRoughnessTexture",
        ),
        normal_map: map(normal, "normalTexture"),
        normal_scale,
        occlusion_map: map(occlusion, "occlusionTexture"),
        occlusion_strength,
        emissive,
        emissive_map: map(json.emissive_texture.as_ref().map(Named::new), "emissiveTexture"),
        f0,
        f90,
        unlit: Extension::find(extensions, "KHR_materials_unlit", &at).is_some(),
        alpha_mode,
        double_sided: json.double_sided,
        cast_shadow: extras.boolean("castShadow", report).unwrap_or(true),
        receive_shadow: extras.boolean("receiveShadow", report).unwrap_or(true),
    }
}

/// The reflectance of a dielectric at normal (f0: red, green, blue) and at grazing incidence (f90), by the formulas of
/// `KHR_materials_ior` and `KHR_materials_specular`.
fn reflectance(extensions: Option<&Object<String, Value>>, at: &str, report: &mut Report) -> ([f32; 3], f32) {
    let mut normal = DEFAULT_F0;
    if let Some(ior) = Extension::find(extensions, "KHR_materials_ior", at) {
        match ior.positive("ior", report) {
            // Of the extension's own words: no refraction, and full reflection.
            Some([0.0]) => normal = 1.0,
            Some([index]) if index >= 1.0 => normal = ((index - 1.0) / (index + 1.0)).powi(2),
            Some([index]) => {
                let message = format!("the index of refraction is {index}");
                let at = format!("{at}/extensions/KHR_materials_ior/ior");
                report.error(codes::BAD_MATERIAL, &at, message, "it is 0, or at least 1; glass has 1.5");
            }
            None => {}
        }
    }
    let Some(specular) = Extension::find(extensions, "KHR_materials_specular", at) else {
        return ([normal; 3], 1.0);
    };
    let [factor] = specular.positive("specularFactor", report).unwrap_or([1.0]);
    let color = specular.positive("specularColorFactor", report).unwrap_or([1.0; 3]);
    for texture in ["specularTexture", "specularColorTexture"] {
        specular.left_out(texture, report);
    }
    let factor = factor.min(1.0);
    (color.map(|part| (normal * part).min(1.0) * factor), factor)
}
