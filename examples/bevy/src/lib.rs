//! Pipelines of umbragraph in Bevy: a plugin that draws Bevy's meshes into what a camera of Bevy's sees, in Bevy's own
//! textures and encoder, between its opaque and its transparent pass.
//!
//! A pipeline is an asset, and changes when its file does. A camera with a [`Graph`] draws one; an entity with a mesh
//! and a [`Tint`] is drawn by it, and every [`DirectionalLight`] lights it. [`extract`] brings these into the render
//! world, [`meshes`] is the draw contract.
//!
//! Limits: cameras without multisampling; meshes with positions, normals and one set of texture coordinates.

mod extract;
mod meshes;
pub mod scene;

use bevy::asset::{AssetLoader, LoadContext, io::Reader};
use bevy::core_pipeline::core_3d::{main_opaque_pass_3d, main_transparent_pass_3d};
use bevy::core_pipeline::{Core3d, Core3dSystems};
use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;
use bevy::render::camera::ExtractedCamera;
use bevy::render::mesh::{RenderMesh, allocator::MeshAllocator};
use bevy::render::render_asset::RenderAssets;
use bevy::render::renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery};
use bevy::render::view::{ExtractedView, ViewDepthStencilTexture, ViewTarget};
use bevy::render::{ExtractSchedule, Render, RenderApp, RenderSystems};
use umbragraph::frame::{Bounds, Camera as FrameCamera, FrameInput, Light};
use umbragraph::prelude::LightProperties as _;
use umbragraph::{Frame, Library, Options, Renderer};

use extract::{Scene, extract, upload};
use meshes::{Meshes, interface};

/// An umbragraph pipeline as an asset, loaded from a file whose name ends in `.graph.json`.
#[derive(Asset, TypePath)]
pub struct Pipeline(umbragraph::Pipeline);

/// A component of cameras: the pipeline that draws the camera's picture.
#[derive(Component)]
pub struct Graph(pub Handle<Pipeline>);

/// A component of meshes: the colour with which pipelines draw the entity. Pipelines do not draw meshes without this
/// component.
#[derive(Component)]
pub struct Tint(pub Color);

/// A plugin that loads pipelines, and draws them for cameras with a [`Graph`].
pub struct UmbragraphPlugin;

impl Plugin for UmbragraphPlugin {
    fn build(&self, app: &mut App) {
        let library = Library::new()
            .host("bevy", interface())
            .template("lib/meshes.wgsl.jinja", include_str!("templates/meshes.wgsl.jinja"));
        app.init_asset::<Pipeline>().register_asset_loader(Loader(library));
        let Some(app) = app.get_sub_app_mut(RenderApp) else { return };
        let place = draw.after(main_opaque_pass_3d).before(main_transparent_pass_3d);
        app.init_resource::<Scene>()
            .add_systems(ExtractSchedule, extract)
            .add_systems(Render, upload.in_set(RenderSystems::PrepareResources))
            .add_systems(Core3d, place.in_set(Core3dSystems::MainPass));
    }
}

#[derive(TypePath)]
struct Loader(Library);

impl AssetLoader for Loader {
    type Asset = Pipeline;
    type Settings = ();
    type Error = BevyError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        (): &(),
        context: &mut LoadContext<'_>,
    ) -> Result<Pipeline, BevyError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Ok(Pipeline(self.0.load_text(&context.path().to_string(), str::from_utf8(&bytes)?)?))
    }

    fn extensions(&self) -> &[&str] {
        &["graph.json"]
    }
}

fn draw(
    view: ViewQuery<(&ExtractedView, &ExtractedCamera, &ViewTarget, &ViewDepthStencilTexture)>,
    views: Query<(), With<ExtractedView>>,
    mut renderers: Local<EntityHashMap<Renderer>>,
    scene: Res<Scene>,
    (allocator, meshes): (Res<MeshAllocator>, Res<RenderAssets<RenderMesh>>),
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    mut context: RenderContext,
) {
    renderers.retain(|entity, _| views.contains(*entity));
    let entity = view.entity();
    let Some(pipeline) = scene.pipelines.get(&entity) else { return };
    let (view, camera, target, depth) = view.into_inner();
    let light = |sun: &extract::Sun| {
        // Bevy's exposure is a camera's; what the pipeline draws is exposed already.
        let light = Light::directional("sun", sun.direction, sun.color, sun.illuminance * camera.exposure);
        if sun.casts_shadows { light.casts_shadow() } else { light }
    };
    let world_from_view = view.world_from_view.to_matrix().to_cols_array_2d();
    let camera = FrameCamera::from_matrices(world_from_view, view.clip_from_view.to_cols_array_2d());
    let bounds = scene.bounds.map_or(Bounds::EMPTY, |[min, max]| Bounds::between(min, max));
    let lights = scene.suns.iter().map(light).collect();
    let input = FrameInput::new(camera).lights(lights).scene_bounds(bounds).index(scene.index);
    let draws = Meshes { scene: &scene, allocator: &allocator, meshes: &meshes };
    let imports = [("color", &**target.main_texture()), ("depth", &**depth.texture())];
    let frame = Frame::new(&input).draws(&draws).imports(&imports);
    let options = Options::new(imports[0].1.width(), imports[0].1.height());
    let renderer = renderers.entry(entity).or_insert_with(|| Renderer::new(device.wgpu_device(), &queue));
    if let Err(error) = renderer.record(pipeline, &options, context.command_encoder(), &frame) {
        error!("{error}");
    }
}
