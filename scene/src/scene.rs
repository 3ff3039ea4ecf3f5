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
    /// The name of the scene in diagnostics: the path of the file, or the name given to
    /// [`from_slice`](crate::from_slice).
    pub name: String,
    /// All meshes of the file. Cloning a scene does not copy them.
    pub meshes: Arc<Vec<Mesh>>,
    /// All materials of the file, followed by the default material, which primitives without a material use.
    pub materials: Vec<Material>,
    /// All textures that materials use, each listed once.
    pub textures: Vec<Texture>,
    /// The decoded images that `textures` refers to. Cloning a scene does not copy them.
    pub images: Arc<Vec<Image>>,
    /// All nodes of the file, indexed by [`NodeId`].
    pub nodes: Vec<Node>,
    /// The cameras of all drawn nodes, parent nodes before their children; empty if no drawn node has a camera.
    pub cameras: Vec<SceneCamera>,
    /// The lights of all drawn nodes, parent nodes before their children; empty if no drawn node has a light.
    pub lights: Vec<SceneLight>,
    /// All skins (sets of joints for skinned meshes) of the file.
    pub skins: Vec<Skin>,
    /// All animations of the file; only the first one is played.
    pub animations: Vec<Animation>,
    /// The warnings found while loading. A file with errors is rejected, so there are no errors here.
    pub warnings: Diagnostics,
    /// All nodes, sorted so that parents come before their children.
    pub(crate) order: Vec<NodeId>,
    /// All draws, sorted by level of detail from the finest to the coarsest.
    pub(crate) draws: Vec<Draw>,
    /// The number of draws of the finest level of detail; they are the first ones in `draws`.
    pub(crate) finest: usize,
    /// One list for each combination of a skin and a primitive, with a bounding box for each joint. A box contains the
    /// vertices that its joint moves, in metres in mesh space.
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
    /// Whether the draw casts shadows: node, mesh and material all allow it, and the material is not alpha-blended.
    pub cast_shadow: bool,
    /// Whether the draw receives shadows: node, mesh and material all allow it.
    pub receive_shadow: bool,
    /// Whether the draw can move or change its shape from frame to frame, by animation or skinning.
    pub dynamic: bool,
    /// The level of detail of the draw; 0 is the finest.
    pub detail: u32,
    /// The coarsest level of detail of the draw's node; 0 if the node has only one level.
    pub last_detail: u32,
    /// The index of the draw's joint bounding boxes in `Scene::joint_bounds`; `None` for a draw without skinning.
    pub(crate) joint_bounds: Option<usize>,
}

impl Scene {
    /// The draws of the finest level of detail, parent nodes before their children.
    pub fn draws(&self) -> impl ExactSizeIterator<Item = Draw> + '_ {
        self.draws.iter().take(self.finest).copied()
    }

    /// The draws of all levels of detail, from the finest level to the coarsest.
    pub fn draws_of_all_details(&self) -> impl ExactSizeIterator<Item = Draw> + '_ {
        self.draws.iter().copied()
    }

    /// The primitive whose triangles a draw renders.
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

    /// Returns `true` if the transform, joints or morph weights of a draw differ between two poses.
    pub fn moves(&self, draw: Draw, from: &Pose, to: &Pose) -> bool {
        let moves = |node: NodeId| from.world(node) != to.world(node);
        let skin = draw.skin.and_then(|skin| self.skins.get(skin));
        let morphs = |node: NodeId| from.weights(node) != to.weights(node);
        draw.dynamic
            && (moves(draw.node)
                || morphs(draw.node)
                || skin.is_some_and(|skin| skin.joints.iter().any(|at| moves(*at))))
    }

    /// The bounding box of all draws of the finest level of detail in a pose, in metres in world space.
    pub fn bounds(&self, pose: &Pose) -> Bounds {
        self.bounds_where(pose, |_| true)
    }

    fn bounds_where(&self, pose: &Pose, wanted: impl Fn(Draw) -> bool) -> Bounds {
        let draws = self.draws().filter(|draw| wanted(*draw));
        draws.fold(Bounds::EMPTY, |bounds, draw| bounds.union(self.draw_bounds(draw, pose)))
    }

    /// The lights of the scene with their positions and directions in a pose; one default directional light if the
    /// scene has no lights.
    pub fn placed_lights(&self, pose: &Pose) -> Vec<Light> {
        if self.lights.is_empty() {
            return vec![default_view::sun()];
        }
        self.lights.iter().map(|light| light.placed(&pose.world(light.node))).collect()
    }

    /// The per-frame input of a pipeline at `time`, in seconds: camera, lights, and bounding boxes of the scene and its
    /// shadow casters. The camera is the first one of the scene, or a default one, with the given `aspect` (width over
    /// height). The frame index is 0; a host that draws several frames must set it.
    pub fn frame_input(&self, aspect: f64, time: f64) -> FrameInput {
        self.frame_input_of(&self.pose(time), aspect, time)
    }

    /// The same as [`Scene::frame_input`], for a pose that the caller has already computed for this `time`.
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
