//! A glTF document under construction, and its binary form.
//!
//! Objects are written as JSON when they are added, and joined when the document is; only nodes wait for their
//! children.

use super::json::{Object, array, number, numbers, string};
use super::shape::Shape;
use super::streams::{Streams, Weight};
use super::vector::Placement;

/// The index of a material in a document.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MaterialId(usize);

/// The index of a mesh in a document.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeshId(usize);

/// The index of a node in a document.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeId(usize);

/// The parameters of a material to be added to a document.
#[derive(Clone, Debug)]
pub(crate) struct Material<'a> {
    pub(crate) name: &'a str,
    /// Linear base colour, multiplied with the texture if there is one.
    pub(crate) color: [f64; 3],
    /// Linear colour that the surface emits.
    pub(crate) emissive: [f64; 3],
    /// The contents of a PNG file with the base colour; `None` for a plain colour.
    pub(crate) texture: Option<Vec<u8>>,
    /// The smallest alpha that is drawn; `None` for a surface without an alpha test.
    pub(crate) alpha_cutoff: Option<f64>,
    pub(crate) double_sided: bool,
    /// The opacity from 0 to 1; below 1, the surface is blended with the surfaces behind it.
    pub(crate) opacity: f64,
}

impl Default for Material<'_> {
    fn default() -> Self {
        Self {
            name: "",
            color: [1.0; 3],
            emissive: [0.0; 3],
            texture: None,
            alpha_cutoff: None,
            double_sided: false,
            opacity: 1.0,
        }
    }
}

/// The parameters of a light to be added. The light shines along −Z of its node.
#[derive(Clone, Debug)]
pub(crate) struct Light<'a> {
    pub(crate) name: &'a str,
    /// The type of the light: `directional`, `point` or `spot`.
    pub(crate) kind: &'a str,
    pub(crate) color: [f64; 3],
    /// The intensity: lux for a directional light, else candela.
    pub(crate) intensity: f64,
    /// The range in metres; `None` for an unlimited range.
    pub(crate) range: Option<f64>,
    /// The inner and outer angle of a spot from its axis, in degrees; `None` for other lights.
    pub(crate) cone: Option<(f64, f64)>,
    /// The property `angular_diameter_deg` (degrees) or `radius` (metres), and its value; `None` for a light without
    /// size.
    pub(crate) size: Option<(&'a str, f64)>,
}

impl Light<'_> {
    /// A sun with the angular diameter of the real one, 0.53°. `intensity` is in lux.
    pub(crate) fn sun(color: [f64; 3], intensity: f64) -> Self {
        Self {
            name: "sun",
            kind: "directional",
            color,
            intensity,
            range: None,
            cone: None,
            size: Some(("angular_diameter_deg", 0.53)),
        }
    }
}

/// A glTF document under construction.
#[derive(Default)]
pub(crate) struct Document {
    name: String,
    textures: Vec<Vec<u8>>,
    materials: Vec<String>,
    is_textured: Vec<bool>,
    meshes: Vec<String>,
    triangles_of_meshes: Vec<usize>,
    drawn_triangles: usize,
    nodes: Vec<Object>,
    children: Vec<Vec<usize>>,
    roots: Vec<usize>,
    cameras: Vec<String>,
    lights: Vec<String>,
    skins: Vec<String>,
    animations: Vec<String>,
    streams: Streams,
}

impl Document {
    /// Creates a document with an empty scene.
    pub(crate) fn new(name: &str) -> Self {
        Self { name: name.to_owned(), ..Self::default() }
    }

    /// The number of triangles that the scene draws; each mesh counts as often as it is placed.
    pub(crate) fn drawn_triangles(&self) -> usize {
        self.drawn_triangles
    }

    /// Adds a material.
    pub(crate) fn material(&mut self, material: Material<'_>) -> MaterialId {
        let texture = material.texture.map(|texture| {
            self.textures.push(texture);
            Object::default().with("index", self.textures.len() - 1).json()
        });
        self.is_textured.push(texture.is_some());
        let [red, green, blue] = material.color;
        let surface = Object::default()
            .with("baseColorFactor", numbers(&[red, green, blue, material.opacity]))
            .with_some("baseColorTexture", texture)
            .with("metallicFactor", 0)
            .with("roughnessFactor", 1);
        let emits = material.emissive != [0.0; 3];
        let json = Object::default()
            .with("name", string(material.name))
            .with("pbrMetallicRoughness", surface.json())
            .with_some("emissiveFactor", emits.then(|| numbers(&material.emissive)))
            .with_some("alphaMode", material.alpha_cutoff.map(|_| string("MASK")))
            .with_some("alphaMode", (material.opacity < 1.0).then(|| string("BLEND")))
            .with_some("alphaCutoff", material.alpha_cutoff.map(number))
            .with_some("doubleSided", material.double_sided.then_some(true));
        self.materials.push(json.json());
        MaterialId(self.materials.len() - 1)
    }

    /// Adds a material of one colour, given as linear RGB.
    pub(crate) fn plain(&mut self, name: &str, color: [f64; 3]) -> MaterialId {
        self.material(Material { name, color, ..Material::default() })
    }

    /// Adds a double-sided material whose texture has holes where its alpha is below 0.5.
    pub(crate) fn cut_out(&mut self, name: &str, texture: Vec<u8>) -> MaterialId {
        self.material(Material {
            name,
            texture: Some(texture),
            alpha_cutoff: Some(0.5),
            double_sided: true,
            ..Material::default()
        })
    }

    /// Adds a mesh with a primitive for each pair of material and shape.
    pub(crate) fn mesh(&mut self, name: &str, parts: &[(MaterialId, &Shape)]) -> MeshId {
        let parts: Vec<_> = parts.iter().map(|(material, shape)| (*material, *shape, None)).collect();
        self.skinned_mesh(name, &parts)
    }

    /// Adds a mesh; parts with weights are skinned, others are not.
    pub(crate) fn skinned_mesh(
        &mut self,
        name: &str,
        parts: &[(MaterialId, &Shape, Option<&[Weight]>)],
    ) -> MeshId {
        let primitives = parts.iter().map(|(material, shape, weights)| {
            self.streams.primitive(material.0, self.is_textured[material.0], shape, *weights)
        });
        let mesh = Object::default().with("name", string(name)).with("primitives", array(primitives));
        self.meshes.push(mesh.json());
        self.triangles_of_meshes.push(parts.iter().map(|(_, shape, _)| shape.triangles.len()).sum());
        MeshId(self.meshes.len() - 1)
    }

    fn node(&mut self, parent: Option<NodeId>, node: Object) -> NodeId {
        let index = self.nodes.len();
        self.nodes.push(node);
        self.children.push(Vec::new());
        match parent {
            Some(parent) => self.children[parent.0].push(index),
            None => self.roots.push(index),
        }
        NodeId(index)
    }

    /// Adds a node without a mesh, to group other nodes.
    pub(crate) fn group(&mut self, name: &str, parent: Option<NodeId>, placement: Placement) -> NodeId {
        self.node(parent, placed(name, placement))
    }

    /// Adds a node that shows a mesh.
    pub(crate) fn place(
        &mut self,
        name: &str,
        parent: Option<NodeId>,
        mesh: MeshId,
        placement: Placement,
    ) -> NodeId {
        self.drawn_triangles += self.triangles_of_meshes[mesh.0];
        self.node(parent, placed(name, placement).with("mesh", mesh.0))
    }

    /// Adds a mesh and a node that shows it, both with the same name.
    pub(crate) fn put(
        &mut self,
        name: &str,
        parent: Option<NodeId>,
        parts: &[(MaterialId, &Shape)],
        placement: Placement,
    ) -> NodeId {
        let mesh = self.mesh(name, parts);
        self.place(name, parent, mesh, placement)
    }

    /// Adds a perspective camera: vertical field of view in degrees, near and far in metres.
    pub(crate) fn camera(&mut self, name: &str, placement: Placement, fov: f64, near: f64, far: f64) {
        let view = Object::default()
            .with("yfov", number(fov.to_radians()))
            .with("znear", number(near))
            .with("zfar", number(far));
        let camera = Object::default()
            .with("name", string(name))
            .with("type", string("perspective"))
            .with("perspective", view.json());
        self.cameras.push(camera.json());
        self.node(None, placed(name, placement).with("camera", self.cameras.len() - 1));
    }

    /// Adds a light and the node that places it.
    pub(crate) fn light(
        &mut self,
        parent: Option<NodeId>,
        placement: Placement,
        light: &Light<'_>,
    ) -> NodeId {
        let cone = light.cone.map(|(inner, outer)| {
            let cone = Object::default().with("innerConeAngle", number(inner.to_radians()));
            cone.with("outerConeAngle", number(outer.to_radians())).json()
        });
        let extras = light.size.map(|(key, value)| Object::default().with(key, number(value)).json());
        let json = Object::default()
            .with("name", string(light.name))
            .with("type", string(light.kind))
            .with("color", numbers(&light.color))
            .with("intensity", number(light.intensity))
            .with_some("range", light.range.map(number))
            .with_some("spot", cone)
            .with_some("extras", extras);
        self.lights.push(json.json());
        let index = Object::default().with("light", self.lights.len() - 1);
        let extension = Object::default().with("KHR_lights_punctual", index.json());
        self.node(parent, placed(light.name, placement).with("extensions", extension.json()))
    }

    /// Adds a skin to a node that shows a skinned mesh. Each joint has its position in mesh space at rest, without
    /// rotation, in metres.
    pub(crate) fn skin(&mut self, node: NodeId, joints: &[(NodeId, super::Vec3)]) {
        let matrices: Vec<f64> = joints
            .iter()
            .flat_map(|(_, at)| [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., -at.x, -at.y, -at.z, 1.])
            .collect();
        let matrices = self.streams.floats(&matrices, 16, "MAT4");
        let joints = array(joints.iter().map(|(joint, _)| joint.0.to_string()));
        self.skins
            .push(Object::default().with("inverseBindMatrices", matrices).with("joints", joints).json());
        self.nodes[node.0] = self.nodes[node.0].clone().with("skin", self.skins.len() - 1);
    }

    /// Adds an animation. Each channel has a node, a property (`translation` or `rotation`), key times in seconds, and
    /// three or four numbers per key.
    pub(crate) fn animation(&mut self, name: &str, channels: &[(NodeId, &str, Vec<f64>, Vec<f64>)]) {
        let (mut samplers, mut targets) = (Vec::new(), Vec::new());
        for (index, (node, property, times, values)) in channels.iter().enumerate() {
            let (parts, kind) = if *property == "rotation" { (4, "VEC4") } else { (3, "VEC3") };
            let input = self.streams.floats(times, 1, "SCALAR");
            let output = self.streams.floats(values, parts, kind);
            samplers.push(Object::default().with("input", input).with("output", output).json());
            let target = Object::default().with("node", node.0).with("path", string(property));
            targets.push(Object::default().with("sampler", index).with("target", target.json()).json());
        }
        let animation = Object::default().with("name", string(name)).with("channels", array(targets));
        self.animations.push(animation.with("samplers", array(samplers)).json());
    }

    /// Writes the document as a binary glTF.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let (mut binary, mut views) = (Vec::new(), Vec::new());
        let mut view = |bytes: &[u8], stride: Option<usize>, target: Option<u32>| {
            let offset = binary.len();
            binary.extend(bytes);
            binary.resize(binary.len().next_multiple_of(4), 0);
            let view = Object::default()
                .with("buffer", 0)
                .with("byteOffset", offset)
                .with("byteLength", bytes.len());
            views.push(view.with_some("byteStride", stride).with_some("target", target).json());
            views.len() - 1
        };
        for (bytes, stride, target) in self.streams.views() {
            view(bytes, stride, target);
        }
        let images = self.textures.iter().map(|texture| {
            let view = view(texture, None, None);
            Object::default().with("bufferView", view).with("mimeType", string("image/png")).json()
        });
        let images: Vec<String> = images.collect();
        let textures =
            (0..images.len()).map(|image| Object::default().with("sampler", 0).with("source", image).json());
        let sampler = Object::default()
            .with("magFilter", 9729)
            .with("minFilter", 9987)
            .with("wrapS", 10_497)
            .with("wrapT", 10_497);
        let nodes = self.nodes.iter().zip(&self.children).map(|(node, children)| {
            let children = (!children.is_empty()).then(|| array(children.iter().map(usize::to_string)));
            node.clone().with_some("children", children).json()
        });
        let scene = Object::default()
            .with("name", string(&self.name))
            .with("nodes", array(self.roots.iter().map(usize::to_string)));
        let asset = Object::default()
            .with("version", string("2.0"))
            .with("generator", string("umbragraph example scenes"));
        let lights = (!self.lights.is_empty()).then(|| {
            let lights = Object::default().with("lights", array(self.lights.clone()));
            Object::default().with("KHR_lights_punctual", lights.json()).json()
        });
        let used = lights.as_ref().map(|_| array([string("KHR_lights_punctual")]));
        let list = |values: &[String]| (!values.is_empty()).then(|| array(values.to_vec()));
        let json = Object::default()
            .with("asset", asset.json())
            .with_some("extensionsUsed", used)
            .with_some("extensions", lights)
            .with("scene", 0)
            .with("scenes", array([scene.json()]))
            .with("nodes", array(nodes))
            .with_some("cameras", list(&self.cameras))
            .with("meshes", array(self.meshes.clone()))
            .with("materials", array(self.materials.clone()))
            .with_some("textures", list(&textures.collect::<Vec<_>>()))
            .with_some("samplers", (!images.is_empty()).then(|| array([sampler.json()])))
            .with_some("images", list(&images))
            .with_some("skins", list(&self.skins))
            .with_some("animations", list(&self.animations))
            .with("accessors", array(self.streams.accessors.clone()))
            .with("bufferViews", array(views))
            .with("buffers", array([Object::default().with("byteLength", binary.len()).json()]));
        container(json.json().into_bytes(), &binary)
    }
}

fn placed(name: &str, placement: Placement) -> Object {
    let node = Object::default().with("name", string(name));
    if placement == Placement::IDENTITY {
        node
    } else if placement.axes == Placement::IDENTITY.axes {
        node.with("translation", numbers(&placement.origin.to_array()))
    } else {
        let column = |axis: usize| placement.axes[axis].to_array();
        let [[a, b, c], [d, e, f], [g, h, i], [x, y, z]] =
            [column(0), column(1), column(2), placement.origin.to_array()];
        node.with("matrix", numbers(&[a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0, x, y, z, 1.0]))
    }
}

fn container(mut json: Vec<u8>, binary: &[u8]) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let word = |bytes: &mut Vec<u8>, value: usize| bytes.extend((value as u32).to_le_bytes());
    word(&mut bytes, 2);
    word(&mut bytes, 12 + 8 + json.len() + 8 + binary.len());
    for (kind, content) in [(b"JSON", &json[..]), (b"BIN\0", binary)] {
        word(&mut bytes, content.len());
        bytes.extend(kind);
        bytes.extend(content);
    }
    bytes
}
