//! Meshes: attributes and indices of every primitive, checked and completed.

use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive as JsonPrimitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::{Accessors, Component};
use super::extras::ObjectExtras;
use super::morph;
use super::report::Report;
use super::tangents;
use crate::codes;
use crate::material::{Map, Material};
use crate::mesh::{
    JointWeights, Mesh, Primitive, VertexDetail, bounds_of, fan_to_list, flat_normals, strip_to_list, unit,
};
use crate::morph::MorphTarget;

/// The size in bytes of a vertex that is duplicated for tangents: position, normal, texture coordinates and
/// [`VertexDetail`].
const BYTES_OF_SPLIT: u64 = 80;

/// Reads all meshes. Primitives of points or lines are left out with a warning, and invalid primitives with an error.
pub(super) fn read(accessors: &Accessors<'_>, materials: &[Material], report: &mut Report) -> Vec<Mesh> {
    let mut meshes = Vec::with_capacity(accessors.root.meshes.len());
    for (index, json) in accessors.root.meshes.iter().enumerate() {
        let at = format!("/meshes/{index}");
        let extras = ObjectExtras::new(&json.extras, &at);
        let count = morph::targets(json);
        if let Some(part) =
            json.primitives.iter().position(|one| one.targets.as_ref().map_or(0, Vec::len) != count)
        {
            let message = format!("primitives of mesh {index} have different numbers of morph targets");
            let at = format!("{at}/primitives/{part}/targets");
            report.error(codes::BAD_MORPH, &at, message, "give each of them as many");
        }
        if let Some(weights) = &json.weights {
            let what = format!("mesh {index}");
            morph::check_weights(weights, count, &what, &format!("{at}/weights"), report);
        }
        let mut primitives = Vec::with_capacity(json.primitives.len());
        for (part, json) in json.primitives.iter().enumerate() {
            let at = format!("{at}/primitives/{part}");
            primitives.extend(Reader { accessors, materials, json, at: &at }.primitive(report));
        }
        meshes.push(Mesh {
            name: json.name.clone().unwrap_or_default(),
            primitives,
            cast_shadow: extras.boolean("castShadow", report).unwrap_or(true),
            receive_shadow: extras.boolean("receiveShadow", report).unwrap_or(true),
            weights: json.weights.clone().unwrap_or_else(|| vec![0.0; count]),
        });
    }
    meshes
}

struct Reader<'a> {
    accessors: &'a Accessors<'a>,
    materials: &'a [Material],
    json: &'a JsonPrimitive,
    at: &'a str,
}

impl Reader<'_> {
    fn primitive(&self, report: &mut Report) -> Option<Primitive> {
        let (json, at) = (self.json, self.at);
        let help = "it is 0 to 6; triangles are 4";
        let mode = report.known(&json.mode, &format!("{at}/mode"), "unknown primitive mode", help)?;
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            let help = "make thin triangles of them";
            report.warning(codes::LEFT_OUT, at, "points and lines are not drawn", help);
            return None;
        }
        let material = self.material(report);
        if !json.attributes.contains_key(&Checked::Valid(Semantic::Positions)) {
            return report.reject(
                codes::INCOMPLETE_PRIMITIVE,
                at,
                "the primitive has no POSITION",
                "export the mesh with positions",
            );
        }
        let base_color_map = self.materials.get(material).and_then(|material| material.base_color_map);
        // All attributes are read before any is given up, so that each of them gets its diagnostics.
        let positions = self.attribute::<f32, 3>(&Semantic::Positions, "position", report);
        // Normals that cannot be used are as good as missing, for which glTF has a rule.
        let normals = report.optional("flat normals are computed", |report| {
            let normals = self.attribute::<f32, 3>(&Semantic::Normals, "normal", report).flatten();
            normals.filter(|normals| self.fits("NORMAL", Some(normals.len()), &positions, report))
        });
        let maps = self.maps(material);
        let is_wanted = |set: u32| match &maps[..] {
            [] => set == 0,
            maps => maps.iter().any(|(_, map)| map.set == set),
        };
        let sets = [0, 1].map(|set| {
            let semantic = Semantic::TexCoords(set);
            if !is_wanted(set) {
                return Some(None);
            }
            self.attribute::<f32, 2>(&semantic, "texture coordinate", report)
        });
        // A tangent that cannot be used is as good as missing.
        let tangents = report.optional("tangents are computed", |report| {
            let tangents = self.attribute::<f32, 4>(&Semantic::Tangents, "tangent", report).flatten();
            tangents.filter(|tangents| self.fits("TANGENT", Some(tangents.len()), &positions, report))
        });
        let colors = report.optional("white is used", |report| {
            let colors = self.colors(report).flatten();
            colors.filter(|colors| self.fits("COLOR_0", Some(colors.len()), &positions, report))
        });
        let joints = self.attribute::<u32, 4>(&Semantic::Joints(0), "joint", report);
        let weights = self.attribute::<f32, 4>(&Semantic::Weights(0), "weight", report);
        let indices = self.indices(report);
        let fits = [
            ("TEXCOORD_0", length(&sets[0])),
            ("TEXCOORD_1", length(&sets[1])),
            ("JOINTS_0", length(&joints)),
            ("WEIGHTS_0", length(&weights)),
        ]
        .map(|(name, length)| self.fits(name, length, &positions, report));
        let [first, second] = sets;
        let (positions, sets) = (positions??, [first?, second?]);
        let (joints, weights, indices) = (joints?, weights?, indices?);
        let count = positions.len();
        if fits.contains(&false) {
            return None;
        }
        let indices = indices.unwrap_or_else(|| (0..count as u32).collect());
        if let Some(place) = indices.iter().position(|index| *index as usize >= count) {
            return report.reject(
                codes::INDEX_OUT_OF_RANGE,
                &format!("{at}/indices"),
                format!("index {} (at place {place}) is beyond the {count} vertices", indices[place]),
                "export the mesh again",
            );
        }
        let mut indices = match mode {
            Mode::TriangleStrip => strip_to_list(&indices),
            Mode::TriangleFan => fan_to_list(&indices),
            _ => indices,
        };
        let whole = indices.len() / 3 * 3;
        if whole != indices.len() || whole == 0 {
            report.warning(
                codes::LEFT_OUT,
                at,
                "the primitive ends with an incomplete triangle",
                "it is not drawn",
            );
            indices.truncate(whole);
        }
        let joints = match (joints, weights) {
            (Some(joints), Some(weights)) => Some(join(&joints, &weights)),
            (None, None) => None,
            _ => {
                let message = "JOINTS_0 and WEIGHTS_0 belong together, but only one of them is there";
                return report.reject(
                    codes::INCOMPLETE_PRIMITIVE,
                    &format!("{at}/attributes"),
                    message,
                    "export the mesh again",
                );
            }
        };
        let bounds = bounds_of(&positions);
        self.check_texcoords(&maps, &sets, report);
        let has_texcoords = match maps.iter().find(|(name, _)| *name == "normal") {
            Some((_, map)) => sets.get(map.set as usize).is_some_and(Option::is_some),
            None => false,
        };
        let texcoords = match base_color_map {
            Some(map) => {
                sets[map.set as usize].iter().flatten().map(|texcoord| map.texcoord(*texcoord)).collect()
            }
            None => sets[0].clone().unwrap_or_default(),
        };
        let texcoords = if texcoords.is_empty() { vec![[0.0; 2]; count] } else { texcoords };
        let is_pbr = colors.is_some() || self.materials.get(material).is_some_and(Material::is_pbr);
        if is_pbr && !report.charge(count as u64 * 48, at) {
            return None;
        }
        // Given ones belong to given normals.
        let tangents = tangents.filter(|_| normals.is_some());
        let is_without = tangents.is_none();
        let details = is_pbr.then(|| VertexDetail::all(count, sets, tangents, colors));
        let smooth: Option<Vec<[f32; 3]>> = normals.map(|normals| normals.into_iter().map(unit).collect());
        let targets = json.targets.as_deref().unwrap_or_default();
        let targets = morph::read(self.accessors, targets, count, &format!("{at}/targets"), report);
        let primitive = Primitive {
            positions,
            normals: Vec::new(),
            texcoords,
            details,
            joints,
            indices,
            material,
            bounds,
            targets,
            has_flat_normals: smooth.is_none(),
        };
        let mut primitive = match smooth {
            Some(normals) => Primitive { normals, ..primitive },
            None => report
                .charge(primitive.indices.len() as u64 * (108 + 12 * primitive.targets.len() as u64), at)
                .then(|| with_flat_normals(&primitive))?,
        };
        let normal_map = self.materials.get(material).and_then(|material| material.normal_map);
        if let Some(map) = normal_map.filter(|_| is_without && has_texcoords) {
            let before = primitive.positions.len();
            tangents::add(&mut primitive, &map);
            if !report.charge((primitive.positions.len() - before) as u64 * BYTES_OF_SPLIT, at) {
                return None;
            }
        }
        Some(primitive)
    }

    /// The index of the primitive's material; the index of the default material if the primitive has none.
    fn material(&self, report: &mut Report) -> usize {
        let materials = &self.accessors.root.materials;
        let at = format!("{}/material", self.at);
        report.index(materials, self.json.material, "material", &at).unwrap_or(materials.len())
    }

    /// The texture maps of a material, each with a name for diagnostics. Empty if the material does not exist.
    fn maps(&self, material: usize) -> Vec<(&'static str, Map)> {
        let Some(material) = self.materials.get(material) else { return Vec::new() };
        let maps = [
            ("base colour", material.base_color_map),
            ("metallic-roughness", material.metallic_roughness_map),
            ("normal", material.normal_map),
            ("occlusion", material.occlusion_map),
            ("emissive", material.emissive_map),
        ];
        maps.into_iter().filter_map(|(name, map)| Some((name, map?))).collect()
    }

    /// Reports a warning for the first texture map whose texture coordinate set the primitive lacks.
    fn check_texcoords(&self, maps: &[(&str, Map)], sets: &[Option<Vec<[f32; 2]>>; 2], report: &mut Report) {
        let lacks = |map: &Map| sets.get(map.set as usize).is_none_or(Option::is_none);
        if let Some((name, map)) = maps.iter().find(|(_, map)| lacks(map)) {
            let message =
                format!("the {name} texture wants TEXCOORD_{}, which the primitive does not have", map.set);
            let help = "one texel is used everywhere; export the mesh with texture coordinates";
            report.warning(codes::LEFT_OUT, &format!("{}/attributes", self.at), message, help);
        }
    }

    /// Reads the vertex colours; alpha is 1 if the file has RGB only. Returns `Some(None)` if the primitive has no
    /// colours, and `None` after reporting an error.
    fn colors(&self, report: &mut Report) -> Option<Option<Vec<[f32; 4]>>> {
        let semantic = Semantic::Colors(0);
        let accessor = self.json.attributes.get(&Checked::Valid(semantic.clone()));
        let accessor = accessor.and_then(|accessor| self.accessors.root.accessors.get(accessor.value()));
        let is_opaque = accessor.is_some_and(|accessor| accessor.type_ == Checked::Valid(Type::Vec3));
        let colors: Option<Vec<[f32; 4]>> = if is_opaque {
            let colors = self.attribute::<f32, 3>(&semantic, "colour", report)?;
            colors
                .map(|colors| colors.into_iter().map(|[red, green, blue]| [red, green, blue, 1.0]).collect())
        } else {
            self.attribute::<f32, 4>(&semantic, "colour", report)?
        };
        // Beyond their range some exporters write noise.
        let clamped = |colors: Vec<[f32; 4]>| {
            colors.into_iter().map(|color| color.map(|part| part.clamp(0.0, 65_504.0))).collect()
        };
        Some(colors.map(clamped))
    }

    /// Reads a vertex attribute; `noun` is its name in diagnostics. Returns `Some(None)` if the primitive does not have
    /// the attribute, and `None` after reporting an error.
    fn attribute<T: Component, const N: usize>(
        &self,
        semantic: &Semantic,
        noun: &str,
        report: &mut Report,
    ) -> Option<Option<Vec<[T; N]>>> {
        let Some(accessor) = self.json.attributes.get(&Checked::Valid(semantic.clone())) else {
            return Some(None);
        };
        let at = format!("{}/attributes/{}", self.at, semantic.to_string());
        let values = self.accessors.read::<T, N>(accessor.value(), &at, report)?;
        let broken = |value: &[T; N]| !value.map(Into::into).iter().all(|part| part.is_finite());
        if let Some(first) = values.iter().position(broken) {
            let count = values.iter().filter(|value| broken(value)).count();
            let message =
                format!("the {noun} of vertex {first} is not finite ({count} of {} are not)", values.len());
            let help = "mend the mesh in the program that made it, and export it again";
            return report.reject(codes::NOT_FINITE, &at, message, help);
        }
        Some(Some(values))
    }

    /// Returns `true` if an attribute has as many elements as there are positions, or if one of the two numbers is
    /// unknown. Reports an error if the numbers differ.
    fn fits(
        &self,
        name: &str,
        length: Option<usize>,
        positions: &Option<Option<Vec<[f32; 3]>>>,
        report: &mut Report,
    ) -> bool {
        let (Some(length), Some(Some(positions))) = (length, positions) else { return true };
        if length != positions.len() {
            report.error(
                codes::INCOMPLETE_PRIMITIVE,
                &format!("{}/attributes/{name}", self.at),
                format!("{name} has {length} elements, but POSITION has {}", positions.len()),
                "export the mesh again: all attributes have one element for each vertex",
            );
        }
        length == positions.len()
    }

    /// Reads the vertex indices. Returns `Some(None)` if the primitive has no indices, and `None` after reporting an
    /// error.
    fn indices(&self, report: &mut Report) -> Option<Option<Vec<u32>>> {
        let Some(accessor) = self.json.indices else { return Some(None) };
        let at = format!("{}/indices", self.at);
        let indices = self.accessors.read::<u32, 1>(accessor.value(), &at, report)?;
        Some(Some(indices.into_iter().map(|[index]| index).collect()))
    }
}

/// The number of elements of an attribute. `None` if the attribute is absent or could not be read.
fn length<T>(attribute: &Option<Option<Vec<T>>>) -> Option<usize> {
    attribute.as_ref()?.as_ref().map(Vec::len)
}

/// Combines the joint indices and weights of vertices, and normalizes the weights of each vertex to a sum of 1. A
/// vertex whose weights have no positive, finite sum gets weight 1 for its first joint. Joint indices too large for
/// `u16` become `u16::MAX`, which is larger than any valid index.
fn join(joints: &[[u32; 4]], weights: &[[f32; 4]]) -> JointWeights {
    let joints =
        joints.iter().map(|four| four.map(|joint| u16::try_from(joint).unwrap_or(u16::MAX))).collect();
    let normalized = |four: &[f32; 4]| {
        let four = four.map(|weight| weight.max(0.0));
        let sum: f32 = four.iter().sum();
        if sum > 0.0 && sum.is_finite() { four.map(|weight| weight / sum) } else { [1.0, 0.0, 0.0, 0.0] }
    };
    JointWeights { joints, weights: weights.iter().map(normalized).collect() }
}

/// Returns the primitive with three separate vertices for each triangle, whose normals are the face normal of the
/// triangle.
fn with_flat_normals(shared: &Primitive) -> Primitive {
    fn gather<T: Copy>(values: &[T], indices: &[u32]) -> Vec<T> {
        indices.iter().filter_map(|index| values.get(*index as usize).copied()).collect()
    }
    let positions: Vec<[f32; 3]> = gather(&shared.positions, &shared.indices);
    Primitive {
        normals: flat_normals(&positions).collect(),
        texcoords: gather(&shared.texcoords, &shared.indices),
        details: shared.details.as_ref().map(|details| gather(details, &shared.indices)),
        joints: shared.joints.as_ref().map(|shared_joints| JointWeights {
            joints: gather(&shared_joints.joints, &shared.indices),
            weights: gather(&shared_joints.weights, &shared.indices),
        }),
        indices: (0..positions.len() as u32).collect(),
        positions,
        targets: shared
            .targets
            .iter()
            .map(|target| MorphTarget {
                positions: gather(&target.positions, &shared.indices),
                normals: Vec::new(),
                bounds: target.bounds,
            })
            .collect(),
        ..*shared
    }
}
