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

/// A loaded scene. Made by [`load`](crate::load()) and [`from_slice`](crate::from_slice) only.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scene {
    /// The name under which it was loaded.
    pub name: String,
    /// All meshes of the file. Clones of a scene share them.
    pub meshes: Arc<Vec<Mesh>>,
    /// All materials of the file and, last, glTF's default material.
    pub materials: Vec<Material>,
    /// All textures that materials use as base colour.
    pub textures: Vec<Texture>,
    /// The images of those textures, decoded. Clones of a scene share them.
    pub images: Arc<Vec<Image>>,
    /// All nodes of the file.
    pub nodes: Vec<Node>,
    /// The cameras of the shown nodes, parents before children, in the order of the file.
    pub cameras: Vec<SceneCamera>,
    /// The lights of the shown nodes, parents before children, in the order of the file.
    pub lights: Vec<SceneLight>,
    /// All skins of the file.
    pub skins: Vec<Skin>,
    /// All animations of the file.
    pub animations: Vec<Animation>,
    /// Problems of the file that are no errors.
    pub warnings: Diagnostics,
    /// Nodes, parents before children.
    pub(crate) order: Vec<NodeId>,
    /// The draws: all of the finest level of detail, then those of coarser ones.
    pub(crate) draws: Vec<Draw>,
    /// The number of draws of the finest level.
    pub(crate) finest: usize,
    /// The bounds of the vertices that each joint moves, for each skinned draw.
    pub(crate) joint_bounds: Vec<Vec<Bounds>>,
}

/// One primitive of one node: the unit that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draw {
    /// The node that places it.
    pub node: NodeId,
    /// The index of the mesh in [`Scene::meshes`].
    pub mesh: usize,
    /// The index of the primitive in [`Mesh::primitives`].
    pub primitive: usize,
    /// The index of the material in [`Scene::materials`].
    pub material: usize,
    /// The index of the skin in [`Scene::skins`], for a skinned draw.
    pub skin: Option<usize>,
    /// Whether it casts shadows: node, mesh and material all agree, and the material is not blended.
    pub cast_shadow: bool,
    /// Whether it receives shadows: node, mesh and material all agree.
    pub receive_shadow: bool,
    /// Whether it can move or change its shape from frame to frame.
    pub dynamic: bool,
    /// Its level of detail, 0 the finest.
    pub detail: u32,
    /// The last level that its node has.
    pub last_detail: u32,
    /// The index of its bounds by joint, for a skinned draw.
    pub(crate) joint_bounds: Option<usize>,
}

impl Scene {
    /// The draws of the finest level of detail, in the order of the hierarchy.
    pub fn draws(&self) -> impl ExactSizeIterator<Item = Draw> + '_ {
        self.draws.iter().take(self.finest).copied()
    }

    /// The draws of the finest level of detail, then those of the coarser levels.
    pub fn draws_of_all_details(&self) -> impl ExactSizeIterator<Item = Draw> + '_ {
        self.draws.iter().copied()
    }

    /// The triangles of a draw of this scene.
    pub fn primitive(&self, draw: Draw) -> &Primitive {
        &self.meshes[draw.mesh].primitives[draw.primitive]
    }

    /// The surface of a draw of this scene.
    pub fn material(&self, draw: Draw) -> &Material {
        &self.materials[draw.material]
    }

    /// Whether the vertices of a draw are no other's: joints move them, or they go towards other shapes.
    #[cfg(feature = "gpu")]
    pub(crate) fn has_own_vertices(&self, draw: Draw) -> bool {
        draw.skin.is_some() || self.morphs(draw)
    }

    /// Whether the vertices of a draw can go towards other shapes.
    #[cfg(feature = "gpu")]
    pub(crate) fn morphs(&self, draw: Draw) -> bool {
        !self.primitive(draw).targets.is_empty()
    }

    /// A node of this scene.
    pub fn node(&self, node: NodeId) -> &Node {
        &self.nodes[node.index()]
    }

    /// Whether a draw needs the fragment stage to decide what is there.
    pub fn is_alpha_masked(&self, draw: Draw) -> bool {
        matches!(self.material(draw).alpha_mode, AlphaMode::Mask { .. })
    }

    /// Whether a draw stands elsewhere or has another shape in another pose.
    pub fn moves(&self, draw: Draw, from: &Pose, to: &Pose) -> bool {
        let moves = |node: NodeId| from.world(node) != to.world(node);
        let skin = draw.skin.and_then(|skin| self.skins.get(skin));
        let morphs = |node: NodeId| from.weights(node) != to.weights(node);
        draw.dynamic
            && (moves(draw.node)
                || morphs(draw.node)
                || skin.is_some_and(|skin| skin.joints.iter().any(|at| moves(*at))))
    }

    /// The world box around everything that is drawn in a pose.
    pub fn bounds(&self, pose: &Pose) -> Bounds {
        self.bounds_where(pose, |_| true)
    }

    fn bounds_where(&self, pose: &Pose, wanted: impl Fn(Draw) -> bool) -> Bounds {
        let draws = self.draws().filter(|draw| wanted(*draw));
        draws.fold(Bounds::EMPTY, |bounds, draw| bounds.union(self.draw_bounds(draw, pose)))
    }

    /// The lights in a pose; the default directional light where the file has none.
    pub fn placed_lights(&self, pose: &Pose) -> Vec<Light> {
        if self.lights.is_empty() {
            return vec![default_view::sun()];
        }
        self.lights.iter().map(|light| light.placed(&pose.world(light.node))).collect()
    }

    /// The frame input at a time in seconds: the scene's first camera with the given `aspect` (width over height), all
    /// lights and the bounds. The frame's index is 0; a host that draws more than one frame counts them itself.
    pub fn frame_input(&self, aspect: f64, time: f64) -> FrameInput {
        self.frame_input_of(&self.pose(time), aspect, time)
    }

    /// The frame input as of [`Scene::frame_input`], for a pose that the caller has computed.
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
