//! All of the application that concerns umbragraph: how its meshes are stored and drawn, and what a frame is.

use std::path::Path;

use umbragraph::prelude::*;
use wgpu::VertexFormat::Float32x3;

use super::city::{COUNT, City, camera};

fn interface() -> HostInterface {
    let vertex = [("position", Float32x3, 0), ("normal", Float32x3, 12), ("color", Float32x3, 24)];
    HostInterface::new()
        .vertices(HostVertexBuffer::new(36, vertex))
        .object(HostResource::array("objects", 64, [("world_from_object", ValueType::MAT4, 0)]))
        .filters(&[filters::OPAQUE, filters::CASTERS, filters::TRANSPARENT])
}

impl DrawSource for City {
    fn object(&self, _: &str) -> Option<wgpu::BindingResource<'_>> {
        Some(self.matrices.as_entire_binding())
    }

    fn draw(&self, pass: &mut dyn DrawPass) {
        if pass.filter() != filters::TRANSPARENT {
            pass.render_pass().set_vertex_buffer(0, self.vertices.slice(..));
            pass.render_pass().draw(0..36, 0..COUNT);
        }
    }
}

pub(crate) fn pipeline() -> Result<Pipeline, Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/city");
    Library::new().templates(&folder).host("city", interface()).load(folder.join("city.json"))
}

/// Records a frame into a texture of any size and format. The renderer makes a new plan if size or format has changed.
pub(crate) fn record(
    (renderer, pipeline): (&mut Renderer, &Pipeline),
    encoder: &mut wgpu::CommandEncoder,
    city: &City,
    target: &wgpu::Texture,
    (time, vignette): (f32, f32),
) -> Result<(), Error> {
    let [world_from_view, clip_from_view] = camera(time, target.width() as f32 / target.height() as f32);
    let sun = Light::directional("sun", [-0.6, -0.7, -0.35], [1.0, 0.95, 0.9], 4.0).casts_shadow();
    let input = FrameInput::new(Camera::from_matrices(world_from_view, clip_from_view))
        .lights(vec![sun])
        .scene_bounds(Bounds::between([-100.0, -2.0, -100.0], [100.0, 14.0, 100.0]));
    if let Some(executor) = renderer.executor() {
        executor.set(executor.parameter("vignette")?, vignette)?;
    }
    let options = Options::new(target.width(), target.height());
    let imports = [("target", target)];
    renderer.record(pipeline, &options, encoder, &Frame::new(&input).draws(city).imports(&imports))
}
