//! The application of `examples/city`: an engine's meshes in the shadows of `umbra`, with a pass of its own.

#[path = "../../../examples/city/city.rs"]
pub(crate) mod city;
#[path = "../../../examples/city/shadows.rs"]
mod shadows;

use glam::{Mat4, Vec3, Vec4};
use umbragraph::executor::{Texels, read_back};
use umbragraph::frame::{Bounds, Camera, FrameInput, Light};
use umbragraph::{Frame, Options, Renderer};
use umbragraph_test_support::gpu;

use city::City;

/// Whether the straight way from a point towards the sun meets a box of the city.
fn is_shadowed(from: Vec3, to_sun: Vec3) -> bool {
    (1..city::COUNT).any(|at| {
        let into: Mat4 = city::matrix(at).inverse();
        let (origin, along) = (into.transform_point3(from), into.transform_vector3(to_sun));
        let [one, other] = [-0.5_f32, 0.5].map(|side| (Vec3::splat(side) - origin) / along);
        let (enters, leaves) = (one.min(other).max_element(), one.max(other).min_element());
        leaves > enters.max(0.0)
    })
}

#[test]
fn an_adopter_s_meshes_have_the_shadows_that_rays_have() {
    let Some(gpu) = gpu::device() else { return };
    let pipeline = shadows::pipeline().unwrap_or_else(|error| panic!("{error}"));
    let city = City::new(&gpu.device, &gpu.queue);
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue);
    let mut record = |target: &wgpu::Texture, vignette: f32| -> (Texels, Texels, usize) {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        shadows::record((&mut renderer, &pipeline), &mut encoder, &city, target, (0.8, vignette))
            .unwrap_or_else(|error| panic!("{error}"));
        gpu.queue.submit([encoder.finish()]);
        let executor = renderer.executor().expect("a frame was recorded");
        let color = pollster::block_on(executor.read("color")).unwrap_or_else(|error| panic!("{error}"));
        let picture = pollster::block_on(read_back(&gpu.device, &gpu.queue, target)).unwrap();
        (color, picture, executor.notices().count())
    };
    record(&gpu.target([64, 36], wgpu::TextureFormat::Rgba8Unorm), 0.0);
    // Another size and format, and another value of the pass of its own.
    let size = [320, 180];
    let (color, picture, notices) = record(&gpu.target(size, wgpu::TextureFormat::Rgba8Unorm), 0.0);
    let (_, encoded, _) = record(&gpu.target(size, wgpu::TextureFormat::Rgba8UnormSrgb), 0.0);
    let (dark, _, _) = record(&gpu.target(size, wgpu::TextureFormat::Rgba8Unorm), 1.0);
    assert_eq!(notices, 0);
    assert!(dark.values[0][0] < 0.2 * color.values[0][0], "{:?} {:?}", dark.values[0], color.values[0]);

    // Of a format that encodes, numbers are linear.
    let linear =
        |value: f32| if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
    let pairs = picture.values.iter().zip(&encoded.values);
    let apart = pairs.map(|(one, other)| (linear(one[0]) - other[0]).abs()).fold(0.0, f32::max);
    assert!(apart < 0.012, "{apart}");

    // Points of the plain that the camera sees, lit or not.
    let [world_from_view, clip_from_view] = city::camera(0.8, size[0] as f32 / size[1] as f32);
    let clip_from_world =
        Mat4::from_cols_array_2d(&clip_from_view) * Mat4::from_cols_array_2d(&world_from_view).inverse();
    let eye = Vec4::from_array(world_from_view[3]).truncate();
    let to_sun = Vec3::new(0.6, 0.7, 0.35).normalize();
    let (mut right, mut all) = (0, 0);
    let mut seen = [Vec::new(), Vec::new()];
    for at in 0..4000_u32 {
        let point = Vec3::new((at % 80) as f32 - 40.0, 0.0, (at / 80) as f32 * 1.6 - 40.0);
        let clip = clip_from_world * point.extend(1.0);
        let ndc = clip.truncate() / clip.w;
        let shadowed = is_shadowed(point, to_sun);
        // A pixel is not a point: no edge of a shadow or a house is near.
        let around = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].map(|aside| point + aside * 0.4);
        let is_near = around.iter().any(|near| is_shadowed(*near, to_sun) != shadowed)
            || around.iter().any(|near| is_shadowed(*near, (eye - *near).normalize()));
        if ndc.x.abs() > 0.98 || ndc.y.abs() > 0.98 || is_near {
            continue;
        }
        let [x, y] = [ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5];
        let texel = (y * size[1] as f32) as usize * size[0] as usize + (x * size[0] as f32) as usize;
        seen[usize::from(shadowed)].push(color.values[texel][0]);
    }
    let mut lit = seen[0].clone();
    lit.sort_by(f32::total_cmp);
    let middle = lit[lit.len() / 2] * 0.6;
    for (list, is_dark) in seen.iter().zip([false, true]) {
        all += list.len();
        right += list.iter().filter(|value| (**value < middle) == is_dark).count();
    }
    println!("{right} of {all} points are as rays say");
    assert!(all > 100 && seen[1].len() > 30 && right * 100 > all * 98, "{right} of {all}, {}", seen[1].len());
}

/// Without bounds there are shadows too, with a notice; without a light that casts any there is a notice.
#[test]
fn a_frame_without_bounds_or_casting_lights_says_so() {
    let Some(gpu) = gpu::device() else { return };
    let pipeline = shadows::pipeline().unwrap_or_else(|error| panic!("{error}"));
    let city = City::new(&gpu.device, &gpu.queue);
    let target = gpu.target([160, 90], wgpu::TextureFormat::Rgba8Unorm);
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue);
    let [world_from_view, clip_from_view] = city::camera(0.8, 16.0 / 9.0);
    let sun = Light::directional("sun", [-0.6, -0.7, -0.35], [1.0; 3], 4.0);
    let input = FrameInput::new(Camera::from_matrices(world_from_view, clip_from_view));
    let bounds = Bounds::between([-100.0, -2.0, -100.0], [100.0, 14.0, 100.0]);
    let mut picture = |input: &FrameInput| -> (Vec<[f32; 4]>, Vec<String>) {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let options = Options::new(160, 90).set("debug_view", "shadow_term").set("vignette", 0);
        let imports = [("target", &target)];
        let frame = Frame::new(input).draws(&city).imports(&imports);
        renderer.record(&pipeline, &options, &mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
        gpu.queue.submit([encoder.finish()]);
        let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, &target)).unwrap();
        let notices = renderer.executor().unwrap().notices();
        (texels.values, notices.map(|notice| format!("{} {}", notice.code.id, notice.message)).collect())
    };
    let bounded = input.clone().scene_bounds(bounds);
    let (with, said) = picture(&bounded.clone().lights(vec![sun.clone().property("cast_shadow")]));
    assert!(said.is_empty(), "{said:?}");
    let (without, said) = picture(&input.clone().lights(vec![sun.clone().property("cast_shadow")]));
    assert!(said.len() == 1 && said[0].starts_with("UG0623 the frame has no bounds"), "{said:?}");
    let differing = with.iter().zip(&without).filter(|(one, other)| (one[0] - other[0]).abs() > 0.2).count();
    let dark = with.iter().filter(|texel| texel[3] > 0.5 && texel[0] < 0.5).count();
    assert!(dark > 1000 && differing * 20 < dark, "{differing} of {dark}");
    let (all_lit, said) = picture(&bounded.lights(vec![sun]));
    assert!(
        said.len() == 1 && said[0].starts_with("UG0624 nothing casts shadows: the light \"sun\""),
        "{said:?}"
    );
    // Alpha is 1 where there is something.
    assert!(all_lit.iter().all(|texel| texel[3] < 0.5 || texel[0] > 0.99));
}

/// Counts the lines of Rust about the module that an adopter writes.
#[test]
fn an_adopter_writes_at_most_fifty_lines_about_the_module() {
    let lines = |file: &str| -> Vec<String> {
        let path = format!("examples/city/{file}");
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
        lines.map(str::to_owned).collect()
    };
    let words = ["umbragraph", "shadows", "enderer", "read_bytes"];
    let is_about = |line: &String| words.iter().any(|word| line.contains(word));
    let count = lines("shadows.rs").len() + lines("main.rs").iter().filter(|line| is_about(line)).count();
    println!("{count} lines of Rust concern the module");
    assert!((30..=50).contains(&count), "{count}");
}
