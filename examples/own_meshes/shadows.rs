//! All of the application that concerns umbragraph: how its meshes are stored, what a frame is, what it is drawn with.

use std::path::Path;
use std::sync::Arc;

use umbragraph::data::ValueType;
use umbragraph::draw::{DrawPass, DrawSource, HostInterface, HostResource, HostVertexBuffer};
use umbragraph::frame::{Bounds, Camera, FrameInput, Light};
use umbragraph::{Error, Library, Options, Plan};
use wgpu::VertexFormat::Float32x3;

use super::dominoes::{COUNT, Dominoes, STRIDE};

/// The layout of the meshes, with which every shader that draws them is compared.
pub(crate) fn interface() -> HostInterface {
    let members = [
        ("world_from_object", ValueType::MAT4, 0),
        ("half_size", ValueType::VEC3, 64),
        ("color", ValueType::VEC3, 80),
    ];
    HostInterface::new()
        .vertices(HostVertexBuffer::new(24, [("position", Float32x3, 0), ("normal", Float32x3, 12)]))
        .object(HostResource::block("domino", STRIDE, members))
        .any_filter()
}

/// Loads the pipeline and its shaders, checks them against the layout of the meshes, and makes a plan for a size in
/// pixels. No device is needed, so a test of the application can do the same.
pub(crate) fn plan(meshes: HostInterface, [width, height]: [u32; 2]) -> Result<Arc<Plan>, Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/own_meshes");
    let library = Library::new().templates(&folder).host("dominoes", meshes);
    library.load(folder.join("dominoes.json"))?.plan(&Options::new(width, height))
}

/// Draws all dominoes and the floor for every pass, since all objects cast shadows.
impl DrawSource for Dominoes {
    fn object(&self, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        (binding == "domino").then(|| self.blocks.as_entire_binding())
    }

    fn draw(&self, pass: &mut dyn DrawPass) {
        pass.render_pass().set_vertex_buffer(0, self.cube.slice(..));
        for object in 0..=COUNT {
            pass.set_object(object);
            pass.render_pass().draw(0..36, 0..1);
        }
    }
}

/// The frame input with camera and sun, at a time in seconds.
pub(crate) fn input(aspect: f64, time: f64, index: u64) -> FrameInput {
    let sun = Light::directional("sun", [-0.8, -0.7, -0.35], [1.0, 0.92, 0.8], 4.0).property("cast_shadow");
    let camera = Camera::look_at([1.2, 4.6, 6.2], [0.3, 0.0, 0.3], 0.8, aspect);
    let bounds = Bounds::between([-20.0, -0.2, -20.0], [20.0, 1.0, 20.0]);
    FrameInput::new(camera).lights(vec![sun]).scene_bounds(bounds).time(time).index(index)
}
