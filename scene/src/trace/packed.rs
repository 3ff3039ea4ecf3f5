//! A scene as one array of words that shaders trace rays through.
//!
//! Rows of four words, by the template `lib/shadow/rays`:
//!
//! | rows | content |
//! |---|---|
//! | 1 | number of nodes, row of the first triangle, row of the first texel, number of triangles |
//! | 2 for each node | minimum of the box, row of the node to go on with; maximum, triangle of a leaf |
//! | 3 for each triangle | corners in the world; in the fourth words flags, row of its texture coordinates, row of its mask |
//! | 2 for each masked triangle | six texture coordinates |
//! | 2 for each masked draw | first texel, width, height, sampling; factor of alpha, cutoff |
//! | the rest | alpha of the base level of masks, four texels to a word |
//!
//! Triangles are those of the finest level of detail, without blended materials. A triangle takes 112 bytes, one with
//! a mask 144, and a texel of a mask one.
//!
//! Blended draws are left out, and masked ones without a picture are either there or not.

use std::collections::BTreeMap;

use bytemuck::cast_slice;
use glam::DVec3;
use umbragraph_pipeline::wgpu_types::{AddressMode, FilterMode};

use super::hierarchy::{Box32, Hierarchy};
use super::places::place;
use crate::material::AlphaMode;
use crate::pose::Pose;
use crate::scene::{Draw, Scene};
use crate::texture::Sampler;

/// The flag bit of a triangle that casts shadows. Shaders contain the same values of `CASTS`, `DOUBLE_SIDED`, `MASKED`
/// and `MIRRORED`.
const CASTS: u32 = 1;
const DOUBLE_SIDED: u32 = 2;
const MASKED: u32 = 4;
const MIRRORED: u32 = 8;

/// The flag bit for linear filtering of an alpha mask. Shaders contain the same values of `LINEAR` and of the address
/// mode flags from `CLAMP_U` to `MIRROR_V`.
const LINEAR: u32 = 1;
const CLAMP_U: u32 = 2;
const MIRROR_U: u32 = 4;
const CLAMP_V: u32 = 8;
const MIRROR_V: u32 = 16;

/// The minimum number of rows (16 bytes each) in a buffer, so that the buffer of an empty scene can be bound.
const MIN_ROWS: usize = 4;

/// The number of rows in an upload block (4 KiB). Changes are tracked and uploaded in whole blocks.
const BLOCK: usize = 256;

/// The error for a scene that needs more bytes than its buffer for ray tracing may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{triangles} triangles and their masks need {needed} bytes, which is more than {max}")]
pub struct TooLarge {
    /// The number of triangles to be packed.
    pub triangles: u64,
    /// The number of bytes that the packed scene needs.
    pub needed: u64,
    /// The maximum size of the buffer in bytes.
    pub max: u64,
}

/// The triangles of a scene in a pose and their bounding volume hierarchy, packed into rows of four 32-bit words for
/// ray tracing in shaders.
#[derive(Clone, Debug)]
pub struct PackedScene {
    rows: Vec<[u32; 4]>,
    boxes: Vec<Box32>,
    hierarchy: Hierarchy,
    parts: Vec<Part>,
    /// The index of the row with the first triangle.
    first: usize,
    /// One flag for each upload block: `true` if it has changed since the last call of [`PackedScene::changes`].
    changed: Vec<bool>,
    places: Vec<DVec3>,
}

/// The triangles of one draw in the packed scene, with flags and locations of the data for its alpha mask.
#[derive(Clone, Copy, Debug)]
struct Part {
    draw: Draw,
    /// The index of the draw's first triangle in the packed scene.
    first: usize,
    flags: u32,
    /// The row with the draw's first texture coordinates; 0 without a mask. `mask` is the row with the draw's mask.
    texcoords: usize,
    mask: usize,
}

/// The alpha test of a draw: passed everywhere, passed nowhere, or decided by a texture.
enum Mask {
    /// Every point of the draw is opaque.
    Whole,
    /// No point of the draw is visible.
    Hole,
    /// Points at which the texture's alpha times `factor` is below `cutoff` are holes. `texture` is an index in
    /// [`Scene::textures`].
    Texture { texture: usize, factor: f32, cutoff: f32 },
}

fn mask_of(scene: &Scene, draw: Draw) -> Mask {
    let material = scene.material(draw);
    let AlphaMode::Mask { cutoff } = material.alpha_mode else { return Mask::Whole };
    let factor = material.base_color[3];
    match material.base_color_map.map(|map| map.texture).filter(|texture| *texture < scene.textures.len()) {
        Some(texture) => Mask::Texture { texture, factor, cutoff },
        None if factor < cutoff => Mask::Hole,
        None => Mask::Whole,
    }
}

fn sampling(sampler: Sampler) -> u32 {
    let linear = if sampler.magnify == FilterMode::Linear { LINEAR } else { 0 };
    let wrap = |mode: AddressMode, clamp: u32, mirror: u32| match mode {
        AddressMode::Repeat => 0,
        AddressMode::MirrorRepeat => mirror,
        AddressMode::ClampToEdge | AddressMode::ClampToBorder => clamp,
    };
    linear | wrap(sampler.wrap_u, CLAMP_U, MIRROR_U) | wrap(sampler.wrap_v, CLAMP_V, MIRROR_V)
}

impl PackedScene {
    /// Packs the triangles of a scene in a pose, of the finest level of detail and without alpha-blended materials.
    ///
    /// # Errors
    /// [`TooLarge`] if the packed scene needs more than `max` bytes.
    pub fn new(scene: &Scene, pose: &Pose, max: u64) -> Result<Self, TooLarge> {
        let mut parts = Vec::new();
        let (mut triangles, mut masked, mut masks) = (0_usize, 0_usize, 0_usize);
        let mut images: BTreeMap<usize, usize> = BTreeMap::new();
        let mut texels = 0_usize;
        for draw in scene.draws() {
            let material = scene.material(draw);
            let mask = mask_of(scene, draw);
            if material.alpha_mode == AlphaMode::Blend || matches!(mask, Mask::Hole) {
                continue;
            }
            let casts = if draw.cast_shadow { CASTS } else { 0 };
            let sides = if material.double_sided { DOUBLE_SIDED } else { 0 };
            let count = scene.primitive(draw).indices.len() / 3;
            let mut part = Part { draw, first: triangles, flags: casts | sides, texcoords: 0, mask: 0 };
            if let Mask::Texture { texture, .. } = mask {
                let image = scene.textures[texture].image;
                images.entry(image).or_insert_with(|| {
                    let first = texels;
                    texels += scene.images[image].rgba.len() / 4;
                    first
                });
                part.flags |= MASKED;
                (part.texcoords, part.mask) = (masked, masks);
                (masked, masks) = (masked + count, masks + 1);
            }
            parts.push(part);
            triangles += count;
        }
        let nodes = (2 * triangles).saturating_sub(1);
        let first = 1 + 2 * nodes;
        let texcoords = first + 3 * triangles;
        let first_mask = texcoords + 2 * masked;
        let first_texel = first_mask + 2 * masks;
        let rows = (first_texel + texels.div_ceil(16)).max(MIN_ROWS);
        let needed = 16 * rows as u64;
        if needed > max || rows > i32::MAX as usize {
            return Err(TooLarge { triangles: triangles as u64, needed, max });
        }
        for part in &mut parts {
            if part.flags & MASKED != 0 {
                (part.texcoords, part.mask) = (texcoords + 2 * part.texcoords, first_mask + 2 * part.mask);
            }
        }
        let mut packed = Self {
            rows: vec![[0; 4]; rows],
            boxes: vec![Box32::EMPTY; triangles],
            hierarchy: Hierarchy::default(),
            parts,
            first,
            changed: vec![false; rows.div_ceil(BLOCK)],
            places: Vec::new(),
        };
        packed.rows[0] = [nodes as u32, first as u32, first_texel as u32, triangles as u32];
        packed.pack_masks(scene, &images, first_texel);
        packed.place(scene, pose, |_| true);
        packed.hierarchy = Hierarchy::build(&packed.boxes);
        packed.write_nodes();
        packed.changed.fill(false);
        Ok(packed)
    }

    /// Writes the data of alpha-masked draws that does not depend on the pose: texture coordinates, masks and alpha
    /// texels.
    fn pack_masks(&mut self, scene: &Scene, images: &BTreeMap<usize, usize>, first_texel: usize) {
        for part in &self.parts {
            let Mask::Texture { texture, factor, cutoff } = mask_of(scene, part.draw) else { continue };
            let texture = scene.textures[texture];
            let image = &scene.images[texture.image];
            let first = images.get(&texture.image).copied().unwrap_or(0);
            self.rows[part.mask] = [first as u32, image.width, image.height, sampling(texture.sampler)];
            self.rows[part.mask + 1] = [factor.to_bits(), cutoff.to_bits(), 0, 0];
            let primitive = scene.primitive(part.draw);
            for (at, face) in primitive.indices.chunks_exact(3).enumerate() {
                let of = |corner: usize| {
                    let texcoord = primitive.texcoords.get(face[corner] as usize).copied();
                    texcoord.unwrap_or_default().map(|part| if part.is_finite() { part.to_bits() } else { 0 })
                };
                let [[a, b], [c, d], [e, f]] = [of(0), of(1), of(2)];
                self.rows[part.texcoords + 2 * at] = [a, b, c, d];
                self.rows[part.texcoords + 2 * at + 1] = [e, f, 0, 0];
            }
        }
        for (image, first) in images {
            for (at, texel) in scene.images[*image].rgba.chunks_exact(4).enumerate() {
                let at = first + at;
                self.rows[first_texel + at / 16][at / 4 % 4] |= u32::from(texel[3]) << (8 * (at % 4));
            }
        }
    }

    /// Writes the world-space triangles of the draws for which `wanted` returns `true`.
    fn place(&mut self, scene: &Scene, pose: &Pose, wanted: impl Fn(Draw) -> bool) {
        let mut places = std::mem::take(&mut self.places);
        for at in 0..self.parts.len() {
            let part = self.parts[at];
            if !wanted(part.draw) {
                continue;
            }
            place(scene, part.draw, pose, &mut places);
            // Joints place skinned vertices, whatever the node does.
            let is_mirrored = part.draw.skin.is_none() && pose.world(part.draw.node).determinant() < 0.0;
            let flags = part.flags | if is_mirrored { MIRRORED } else { 0 };
            for (at, face) in scene.primitive(part.draw).indices.chunks_exact(3).enumerate() {
                let corners = [0, 1, 2].map(|corner| places[face[corner] as usize]);
                let bounds = Box32::around(corners);
                self.boxes[part.first + at] = bounds;
                let texcoords = if part.texcoords == 0 { 0 } else { part.texcoords + 2 * at };
                let words = [flags, texcoords as u32, part.mask as u32];
                for (corner, word) in words.into_iter().enumerate() {
                    // No ray meets an empty box.
                    let place = if bounds == Box32::EMPTY { DVec3::ZERO } else { corners[corner] };
                    let [x, y, z] = place.as_vec3().to_array().map(f32::to_bits);
                    self.write(self.first + 3 * (part.first + at) + corner, [x, y, z, word]);
                }
            }
        }
        self.places = places;
    }

    fn write_nodes(&mut self) {
        let hierarchy = std::mem::take(&mut self.hierarchy);
        for (at, node) in hierarchy.nodes().iter().enumerate() {
            let [x, y, z] = node.min.map(f32::to_bits);
            self.write(1 + 2 * at, [x, y, z, 1 + 2 * node.exit]);
            let [x, y, z] = node.max.map(f32::to_bits);
            self.write(2 + 2 * at, [x, y, z, node.triangle]);
        }
        self.hierarchy = hierarchy;
    }

    fn write(&mut self, row: usize, words: [u32; 4]) {
        if self.rows[row] != words {
            self.rows[row] = words;
            self.changed[row / BLOCK] = true;
        }
    }

    /// Updates the triangles of the draws for which `moved` returns `true`, and refits the hierarchy. Does nothing if
    /// no draw has moved.
    pub fn follow(&mut self, scene: &Scene, pose: &Pose, moved: impl Fn(Draw) -> bool) {
        if self.parts.iter().any(|part| moved(part.draw)) {
            self.place(scene, pose, moved);
            self.hierarchy.refit(&self.boxes);
            self.write_nodes();
        }
    }

    /// The number of triangles in the packed scene.
    pub fn triangles(&self) -> usize {
        self.boxes.len()
    }

    /// The packed scene as bytes, to be uploaded as a storage buffer.
    pub fn bytes(&self) -> &[u8] {
        cast_slice(&self.rows)
    }

    /// Calls `each` with the byte offset and the bytes of each range that has changed since the last call of this
    /// method.
    pub fn changes(&mut self, mut each: impl FnMut(u64, &[u8])) {
        let mut at = 0;
        while at < self.changed.len() {
            let run = self.changed[at..].iter().take_while(|changed| **changed).count();
            if run > 0 {
                let (begin, end) = (BLOCK * at, (BLOCK * (at + run)).min(self.rows.len()));
                each(16 * begin as u64, cast_slice(&self.rows[begin..end]));
                self.changed[at..at + run].fill(false);
            }
            at += run.max(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::Node;

    /// A scene with `still` static and `moving` animated nodes of one triangle each. `corner` is the z coordinate of
    /// the triangle's third corner. In one second, animated node `n` moves along x by `n` metres.
    fn scene(still: usize, moving: usize, corner: f32) -> Scene {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, corner]];
        let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|part: &f32| part.to_le_bytes()).collect();
        bytes.extend([0.0_f32, 1.0].iter().flat_map(|time| time.to_le_bytes()));
        let count = still + moving;
        for at in 0..count {
            bytes.extend([0.0, at as f32].iter().flat_map(|x| [*x, 0.0, 0.0]).flat_map(f32::to_le_bytes));
        }
        let uri = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &bytes);
        let list = |each: &dyn Fn(usize) -> String| (0..count).map(each).collect::<Vec<_>>().join(",");
        let nodes = list(&|at| format!(r#"{{ "mesh": 0, "translation": [0, {at}, 0] }}"#));
        let accessors = list(&|at| {
            format!(
                r#"{{ "bufferView": 2, "byteOffset": {}, "componentType": 5126, "count": 2, "type": "VEC3" }}"#,
                24 * at
            )
        });
        let moved = |each: &dyn Fn(usize) -> String| (still..count).map(each).collect::<Vec<_>>().join(",");
        let samplers = moved(&|at| format!(r#"{{ "input": 1, "output": {} }}"#, 2 + at));
        let channels = moved(&|at| {
            let (sampler, path) = (at - still, "translation");
            format!(r#"{{ "sampler": {sampler}, "target": {{ "node": {at}, "path": "{path}" }} }}"#)
        });
        let animations = if moving == 0 {
            String::new()
        } else {
            format!(r#""animations": [{{ "samplers": [{samplers}], "channels": [{channels}] }}],"#)
        };
        let shown = list(&|at| at.to_string());
        let text = format!(
            r#"{{ "asset": {{ "version": "2.0" }}, {animations} "scenes": [{{ "nodes": [{shown}] }}], "nodes": [{nodes}],
            "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }} }}] }}],
            "accessors": [
                {{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1] }},
                {{ "bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1] }}, {accessors}],
            "bufferViews": [{{ "buffer": 0, "byteLength": 36 }}, {{ "buffer": 0, "byteOffset": 36, "byteLength": 8 }},
                {{ "buffer": 0, "byteOffset": 44, "byteLength": {} }}],
            "buffers": [{{ "byteLength": {}, "uri": "data:application/octet-stream;base64,{uri}" }}] }}"#,
            24 * count,
            bytes.len()
        );
        crate::from_slice("many.gltf", text.as_bytes(), &crate::NoFiles).expect("a scene")
    }

    fn packed(scene: &Scene, time: f64) -> PackedScene {
        PackedScene::new(scene, &scene.pose(time), u64::MAX).expect("a scene that fits")
    }

    /// Packs a scene at time `from`, updates it to time `to`, and returns it with the number of changed bytes.
    fn followed(scene: &Scene, from: f64, to: f64) -> (PackedScene, usize) {
        let (before, after) = (scene.pose(from), scene.pose(to));
        let mut packed = packed(scene, from);
        packed.follow(scene, &after, |draw| scene.moves(draw, &before, &after));
        let mut changed = 0;
        packed.changes(|_, bytes| changed += bytes.len());
        packed.changes(|_, _| panic!("changes are handed out once"));
        (packed, changed)
    }

    fn triangles(packed: &PackedScene) -> &[[u32; 4]] {
        &packed.rows[packed.first..packed.first + 3 * packed.triangles()]
    }

    #[test]
    fn triangles_that_move_are_those_of_a_scene_packed_there() {
        let scene = scene(20, 5, 0.0);
        let (moved, changed) = followed(&scene, 0.0, 0.75);
        assert!(changed > 0);
        assert_eq!(triangles(&moved), triangles(&packed(&scene, 0.75)));
        let bounds = |packed: &PackedScene| packed.hierarchy.nodes()[0];
        let [root, new] = [&moved, &packed(&scene, 0.75)].map(bounds);
        assert_eq!((root.min, root.max), (new.min, new.max));
    }

    #[test]
    fn a_scene_at_rest_writes_nothing() {
        let (_, changed) = followed(&scene(20, 5, 0.0), 0.5, 0.5);
        assert_eq!(changed, 0);
        assert_eq!(followed(&scene(20, 0, 0.0), 0.0, 0.5).1, 0);
    }

    #[test]
    fn one_mover_of_many_writes_a_part_of_the_bytes() {
        let scene = scene(4000, 1, 0.0);
        let (moved, changed) = followed(&scene, 0.0, 1e-3);
        assert!(changed > 0 && changed < moved.bytes().len() / 8, "{changed} of {}", moved.bytes().len());
    }

    #[test]
    fn ten_thousand_movers_are_followed_in_one_walk_over_nodes() {
        let scene = scene(0, 10_000, 0.0);
        let poses = [scene.pose(0.0), scene.pose(0.5)];
        let mut packed = packed(&scene, 0.0);
        let start = std::time::Instant::now();
        packed.follow(&scene, &poses[1], |_| true);
        println!("{} triangles follow in {:?}", packed.triangles(), start.elapsed());
        assert_eq!(packed.hierarchy.nodes().len(), 19_999);
    }

    #[test]
    fn bad_triangles_are_packed_as_finite_numbers() {
        let mut scene = scene(3, 0, 1.0);
        let positions = &mut std::sync::Arc::make_mut(&mut scene.meshes)[0].primitives[0].positions;
        positions[2] = [0.0, f32::NAN, 1.0];
        let bad = packed(&scene, 0.0);
        assert!(bad.boxes.iter().all(|bounds| *bounds == Box32::EMPTY));
        let is_finite = |rows: &[[u32; 4]]| {
            rows.iter().flat_map(|row| &row[..3]).all(|word| f32::from_bits(*word).is_finite())
        };
        assert!(is_finite(triangles(&bad)) && is_finite(&bad.rows[1..bad.first]));
        let empty = &mut std::sync::Arc::make_mut(&mut scene.meshes)[0].primitives[0].positions;
        *empty = vec![[1.0; 3]; 3];
        let flat = packed(&scene, 0.0);
        assert!(is_finite(&flat.rows[1..flat.first]));
    }

    #[test]
    fn a_scene_without_triangles_can_be_bound() {
        let mut scene = scene(1, 0, 0.0);
        std::sync::Arc::make_mut(&mut scene.meshes)[0].primitives[0].indices.clear();
        let packed = packed(&scene, 0.0);
        assert_eq!((packed.triangles(), packed.bytes().len(), packed.rows[0]), (0, 64, [0, 1, 1, 0]));
    }

    #[test]
    fn a_scene_that_is_too_large_says_what_it_needs() {
        let scene = scene(10, 0, 0.0);
        let needed = 16 * (1 + 2 * 19 + 3 * 10);
        let error = PackedScene::new(&scene, &scene.rest_pose(), needed - 1).unwrap_err();
        assert_eq!(error, TooLarge { triangles: 10, needed, max: needed - 1 });
        assert!(PackedScene::new(&scene, &scene.rest_pose(), needed).is_ok());
    }

    #[test]
    fn nodes_have_the_bytes_that_shaders_read() {
        let packed = packed(&scene(2, 0, 0.0), 0.0);
        let nodes: &[Node] = cast_slice(&packed.rows[1..packed.first]);
        assert_eq!(nodes.len(), 3);
        assert_eq!((nodes[0].exit, nodes[0].triangle), (7, u32::MAX));
        assert_eq!((nodes[1].exit, nodes[2].exit), (5, 7));
    }
}
