//! An application without a window: a hundred boxes and balls on a floor, seen into a texture that is read back.

use std::time::{Duration, Instant};

use bevy::app::{PluginsState, ScheduleRunnerPlugin};
use bevy::camera::{Hdr, RenderTarget};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::render_resource::{TextureFormat, TextureUsages};

use crate::{Graph, Tint, UmbragraphPlugin};

/// The width and height of the picture, in pixels.
pub const SIZE: [u32; 2] = [640, 384];

/// The picture that was read back last, with four bytes (RGBA) per pixel; empty before the first.
#[derive(Resource, Default)]
pub struct Picture(pub Vec<u8>);

/// Creates the application; `assets` is the folder of its assets.
pub fn app(assets: &str) -> App {
    let mut app = App::new();
    let window = bevy::window::WindowPlugin {
        primary_window: None,
        exit_condition: bevy::window::ExitCondition::DontExit,
        ..default()
    };
    let assets = AssetPlugin { file_path: assets.to_owned(), ..default() };
    app.add_plugins(DefaultPlugins.set(window).set(assets))
        .add_plugins(ScheduleRunnerPlugin::default())
        .add_plugins(UmbragraphPlugin)
        .init_resource::<Picture>()
        .add_systems(Startup, setup);
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    app
}

/// Runs the application until a picture differs from `before` and stays unchanged for some frames. Returns `None` if
/// that takes longer than `seconds`.
pub fn picture(app: &mut App, before: &[u8], seconds: u64) -> Option<Vec<u8>> {
    let start = Instant::now();
    let (mut last, mut same) = (Vec::new(), 0);
    while start.elapsed() < Duration::from_secs(seconds) {
        app.update();
        let picture = &app.world().resource::<Picture>().0;
        same = if *picture == last { same + 1 } else { 0 };
        last.clone_from(picture);
        let is_empty = last.iter().skip(3).step_by(4).all(|alpha| *alpha == 0);
        if same > 10 && !is_empty && last != before {
            return Some(last);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    None
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut images: ResMut<Assets<Image>>,
    assets: Res<AssetServer>,
) {
    let floor = meshes.add(Cuboid::new(60.0, 0.2, 60.0));
    let grey = Tint(Color::srgb(0.72, 0.7, 0.66));
    commands.spawn((Mesh3d(floor), Transform::from_xyz(0.0, -0.1, 0.0), grey));
    let kinds = [meshes.add(Cuboid::new(1.0, 1.6, 1.0)), meshes.add(Sphere::new(0.7))];
    for at in 0..100_u8 {
        let (x, z) = (f32::from(at % 10) * 3.0 - 13.5, f32::from(at / 10) * 3.0 - 13.5);
        let (mesh, height) = if at % 3 == 0 { (&kinds[1], 0.7) } else { (&kinds[0], 0.8) };
        commands.spawn((
            Mesh3d(mesh.clone()),
            Transform::from_xyz(x, height, z).with_rotation(Quat::from_rotation_y(f32::from(at) * 0.3)),
            Tint(Color::oklch(0.7, 0.13, f32::from(at) * 37.0 % 360.0)),
        ));
    }
    commands.spawn((
        DirectionalLight { illuminance: 4000.0, shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(4.0, 3.5, 1.2).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let mut image = Image::new_target_texture(SIZE[0], SIZE[1], TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let image = images.add(image);
    commands.spawn((
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        Tonemapping::Reinhard,
        RenderTarget::Image(image.clone().into()),
        // Where alpha stays 0 the pipeline draws its sky.
        Camera { clear_color: ClearColorConfig::Custom(Color::NONE), ..default() },
        Transform::from_xyz(9.0, 6.0, 13.0).looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y),
        Graph(assets.load("cascades.graph.json")),
    ));
    commands
        .spawn(Readback::texture(image))
        .observe(|read: On<ReadbackComplete>, mut picture: ResMut<Picture>| picture.0.clone_from(&read.data));
}
