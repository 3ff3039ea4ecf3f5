//! Materials, and the textures that they use.

use gltf::json::material::AlphaMode as JsonAlphaMode;
use gltf::json::texture::Info;
use gltf::json::{Material as JsonMaterial, Root};
use std::collections::BTreeMap;

use super::extras::ObjectExtras;
use super::report::Report;
use crate::codes;
use crate::material::{AlphaMode, Material};

/// The alpha below which masked surfaces have holes, where the file does not say.
const DEFAULT_CUTOFF: f32 = 0.5;

/// The materials with glTF's default one added last, and the indices (in the document) of the textures that they use:
/// the textures of a material are indices into that second list.
pub(super) fn read(root: &Root, report: &mut Report) -> (Vec<Material>, Vec<usize>) {
    let mut textures = Textures::default();
    let mut materials = Vec::with_capacity(root.materials.len() + 1);
    for (index, material) in root.materials.iter().enumerate() {
        materials.push(one(root, index, material, &mut textures, report));
    }
    materials.push(Material::default());
    (materials, textures.list)
}

/// The textures in use, each once, in the order of their first use.
#[derive(Default)]
struct Textures {
    list: Vec<usize>,
    places: BTreeMap<usize, usize>,
}

impl Textures {
    /// The place in the list of the texture that a material names at a JSON pointer.
    fn place(&mut self, root: &Root, texture: Option<&Info>, at: &str, report: &mut Report) -> Option<usize> {
        let wanted = texture?.index.value();
        report.lookup(&root.textures, wanted, "texture", &format!("{at}/index"))?;
        Some(*self.places.entry(wanted).or_insert_with(|| {
            self.list.push(wanted);
            self.list.len() - 1
        }))
    }
}

fn one(
    root: &Root,
    index: usize,
    json: &JsonMaterial,
    textures: &mut Textures,
    report: &mut Report,
) -> Material {
    let at = format!("/materials/{index}");
    let extras = ObjectExtras::new(&json.extras, &at);
    let surface = &json.pbr_metallic_roughness;
    let (base_color, emissive) = (surface.base_color_factor.0, json.emissive_factor.0);
    let cutoff = json.alpha_cutoff.map_or(DEFAULT_CUTOFF, |cutoff| cutoff.0);
    let mut check = |values: &[f32], property: &str| {
        if !values.iter().all(|value| value.is_finite() && *value >= 0.0) {
            let message = format!("a factor of material {index} is negative or not finite: {values:?}");
            report.error(codes::BAD_MATERIAL, &format!("{at}/{property}"), message, "set it between 0 and 1");
        }
    };
    check(&base_color, "pbrMetallicRoughness/baseColorFactor");
    check(&emissive, "emissiveFactor");
    check(&[cutoff], "alphaCutoff");
    let message = format!("material {index} has an unknown alpha mode");
    let help = "it is OPAQUE, MASK or BLEND";
    let alpha_mode = match report.known(&json.alpha_mode, &format!("{at}/alphaMode"), message, help) {
        Some(JsonAlphaMode::Opaque) | None => AlphaMode::Opaque,
        Some(JsonAlphaMode::Mask) => AlphaMode::Mask { cutoff },
        Some(JsonAlphaMode::Blend) => AlphaMode::Blend,
    };
    let mut texture = |texture: Option<&Info>, property: &str| {
        textures.place(root, texture, &format!("{at}/{property}"), report)
    };
    let base_color_texture =
        texture(surface.base_color_texture.as_ref(), "pbrMetallicRoughness/baseColorTexture");
    let emissive_texture = texture(json.emissive_texture.as_ref(), "emissiveTexture");
    Material {
        name: json.name.clone().unwrap_or_default(),
        base_color,
        base_color_texture,
        emissive,
        emissive_texture,
        alpha_mode,
        double_sided: json.double_sided,
        cast_shadow: extras.boolean("castShadow", report).unwrap_or(true),
        receive_shadow: extras.boolean("receiveShadow", report).unwrap_or(true),
    }
}
