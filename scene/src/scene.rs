//! A scene: the contents of a file, decoded and checked.
//!
//! The lists are public for reading; the loader has checked that every index in them is valid, and the few accessors
//! below rely on it. A scene without a camera gets one framed on its bounds, a scene without a light gets a directional
//! light ([`default_view`]).

use std::sync::Arc;

use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::frame::{Bounds, FrameInput, Light};

use crate::animation::Animation;
use crate::default_view;
use crate::filter::wants;
use crate::light::SceneLight;
use crate::material::{AlphaMode, Material};
use crate::mesh::{Mesh, Primitive};
use crate::node::{Node, NodeId};
use crate::pose::Pose;
use crate::skin::Skin;
use crate::texture::{Image, Texture};
use crate::view::SceneCamera;

/// A loaded scene, created only by [`load`](crate::load()) and [`from_slice`](crate::from_slice).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scene {
    /// The name of the scene in diagnostics: the path or the name given to the loader.
    pub name: String,
    /// All meshes of the file. Clones of a scene share the list.
    pub meshes: Arc<Vec<Mesh>>,
    /// All materials of the file and, last, the default material for primitives without one.
    pub materials: Vec<Material>,
    /// All textures that maps of materials use, each once.
    pub textures: Vec<Texture>,
    /// The decoded images of `textures`. Clones of a scene share them.
    pub images: Arc<Vec<Image>>,
    /// All nodes of the file, indexed by [`NodeId`].
    pub nodes: Vec<Node>,
    /// The cameras of the shown nodes, parents before children; empty if the file has none.
    pub cameras: Vec<SceneCamera>,
    /// The lights of the shown nodes, parents before children; empty if the file has none.
    pub lights: Vec<SceneLight>,
    /// All skins of the file.
    pub skins: Vec<Skin>,
    /// All animations of the file; only the first one is played.
    pub animations: Vec<Animation>,
    /// Warnings about the file from loading; errors prevent a scene.
    pub warnings: Diagnostics,
    /// All nodes, sorted so that parents come before their children.
    pub(crate) order: Vec<NodeId>,
    /// All draws: first those of the finest level of detail, then those of coarser levels.
    pub(crate) draws: Vec<Draw>,
    /// The number of draws of the finest level of detail, which come first in `draws`.
    pub(crate) finest: usize,
    /// For each combination of skin and skinned primitive, one bounding box per joint of the vertices that it moves, in
    /// mesh space.
    pub(crate) joint_bounds: Vec<Vec<Bounds>>,
}

/// One primitive drawn at one node: the unit of a draw call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    /// The node whose transform places the primitive.
    pub node: NodeId,
    /// The index of the mesh in [`Scene::meshes`].
    pub mesh: usize,
    /// The index of the primitive in [`Mesh::primitives`].
    pub primitive: usize,
    /// The index of the material in [`Scene::materials`].
    pub material: usize,
    /// The index of the skin in [`Scene::skins`]; `None` for a draw without skinning.
    pub skin: Option<usize>,
    /// Whether the draw casts shadows: allowed by node, mesh and material, and the material is not blended.
    pub cast_shadow: bool,
    /// Whether the draw receives shadows: allowed by node, mesh and material.
    pub receive_shadow: bool,
    /// Whether the draw can move or change its shape from frame to frame, by animation or skinning.
    pub dynamic: bool,
    /// The level of detail that the draw belongs to; 0 is the finest.
    pub detail: u32,
    /// The coarsest level of detail of the draw's node; 0 if the node has only one level.
    pub last_detail: u32,
    /// The index in `Scene::joint_bounds`; `None` for a draw without skinning.
    pub(crate) joint_bounds: Option<usize>,
}

impl Scene {
    /// The draws of the finest level of detail, parent nodes before their children.
    pub fn draws(&self) -> impl ExactSizeIterator<Item = Draw> + '_ {
        self.draws.iter().take(self.finest).copied()
    }

    /// The draws of the finest level of detail, then those of the coarser levels.
    pub fn draws_of_all_details(&self) -> impl ExactSizeIterator<Item = Draw> + '_ {
        self.draws.iter().copied()
    }

    /// The primitive with the triangles of a draw.
    pub fn primitive(&self, draw: Draw) -> &Primitive {
        &self.meshes[draw.mesh].primitives[draw.primitive]
    }

    /// The material of a draw.
    pub fn material(&self, draw: Draw) -> &Material {
        &self.materials[draw.material]
    }

    /// Returns `true` if a draw needs its own copy of the vertices, because skinning or morph targets change them.
    #[cfg(feature = "gpu")]
    pub(crate) fn has_own_vertices(&self, draw: Draw) -> bool {
        draw.skin.is_some() || self.morphs(draw)
    }

    /// Returns `true` if the primitive of a draw has morph targets.
    #[cfg(feature = "gpu")]
    pub(crate) fn morphs(&self, draw: Draw) -> bool {
        !self.primitive(draw).targets.is_empty()
    }

    /// The node with this identifier.
    pub fn node(&self, node: NodeId) -> &Node {
        &self.nodes[node.index()]
    }

    /// Returns `true` if the material of a draw has alpha mode `MASK`, so that the fragment stage discards fragments.
    pub fn is_alpha_masked(&self, draw: Draw) -> bool {
        matches!(self.material(draw).alpha_mode, AlphaMode::Mask { .. })
    }

    /// Returns `true` if the placement or the shape of a draw differs between two poses.
    pub fn moves(&self, draw: Draw, from: &Pose, to: &Pose) -> bool {
        let moves = |node: NodeId| from.world(node) != to.world(node);
        let skin = draw.skin.and_then(|skin| self.skins.get(skin));
        let morphs = |node: NodeId| from.weights(node) != to.weights(node);
        draw.dynamic
            && (moves(draw.node)
                || morphs(draw.node)
                || skin.is_some_and(|skin| skin.joints.iter().any(|at| moves(*at))))
    }

    /// The bounding box of all draws of the finest level of detail, in world space, for a pose.
    pub fn bounds(&self, pose: &Pose) -> Bounds {
        self.bounds_where(pose, |_| true)
    }

    fn bounds_where(&self, pose: &Pose, wanted: impl Fn(Draw) -> bool) -> Bounds {
        let draws = self.draws().filter(|draw| wanted(*draw));
        draws.fold(Bounds::EMPTY, |bounds, draw| bounds.union(self.draw_bounds(draw, pose)))
    }

    /// The lights of the scene placed for a pose; one default directional light if the file has no lights.
    pub fn placed_lights(&self, pose: &Pose) -> Vec<Light> {
        if self.lights.is_empty() {
            return vec![default_view::sun()];
        }
        self.lights.iter().map(|light| light.placed(&pose.world(light.node))).collect()
    }

    /// The frame input at a time in seconds: the first camera with the given `aspect` (width over height), all lights
    /// and the bounds. The frame index is 0; a host that draws several frames must set it.
    pub fn frame_input(&self, aspect: f64, time: f64) -> FrameInput {
        self.frame_input_of(&self.pose(time), aspect, time)
    }

    /// The frame input like [`Scene::frame_input`], for a pose that the caller has already computed.
    pub fn frame_input_of(&self, pose: &Pose, aspect: f64, time: f64) -> FrameInput {
        let scene_bounds = self.bounds(pose);
        let camera = match self.cameras.first() {
            Some(camera) => camera.placed(&pose.world(camera.node), &scene_bounds, aspect),
            None => default_view::camera(&scene_bounds, aspect),
        };
        let input =
            FrameInput::new(camera).lights(self.placed_lights(pose)).scene_bounds(scene_bounds).time(time);
        let casters = ["casters", "static_casters", "dynamic_casters"];
        casters.into_iter().fold(input, |input, filter| {
            input.filter_bounds(filter, self.bounds_where(pose, |draw| wants(filter, self, draw)))
        })
    }
}
