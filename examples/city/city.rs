//! The application's meshes: boxes on a plain, one vertex buffer with positions, normals and colors, and a storage
//! buffer with a matrix for each of them; and the matrices of a camera that circles around them, with reversed depth
//! and without a far plane.

use glam::{Mat4, Vec3};

/// The number of boxes, including the plain.
pub(crate) const COUNT: u32 = 500;

/// The vertex buffer and the instance matrices of the city on a device.
pub(crate) struct City {
    pub(crate) vertices: wgpu::Buffer,
    pub(crate) matrices: wgpu::Buffer,
}

impl City {
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let buffer = |label, numbers: Vec<f32>, usage| {
            let bytes: Vec<u8> = numbers.into_iter().flat_map(f32::to_ne_bytes).collect();
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes.len() as u64,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&buffer, 0, &bytes);
            buffer
        };
        let matrices = (0..COUNT).flat_map(|at| matrix(at).to_cols_array()).collect();
        Self {
            vertices: buffer("vertices", cube(), wgpu::BufferUsages::VERTEX),
            matrices: buffer("matrices", matrices, wgpu::BufferUsages::STORAGE),
        }
    }
}

/// The world matrix of the box with index `at`: 0 is the plain, all others are houses along streets.
pub(crate) fn matrix(at: u32) -> Mat4 {
    if at == 0 {
        return Mat4::from_translation(Vec3::NEG_Y) * Mat4::from_scale(Vec3::new(200.0, 2.0, 200.0));
    }
    let (x, z) = (f64::from(at % 25) * 7.0 - 84.0, f64::from(at / 25) * 9.0 - 86.0);
    let height = 3.0 + (at * 37 % 11) as f32;
    let house = Mat4::from_scale(Vec3::new(4.0, height, 5.0));
    Mat4::from_translation(Vec3::new(x as f32, 0.5 * height, z as f32)) * house
}

/// The matrices from view to world space and from view to clip space, at a time in seconds. `aspect` is width over
/// height.
pub(crate) fn camera(time: f32, aspect: f32) -> [[[f32; 4]; 4]; 2] {
    let eye = Vec3::new(60.0 * time.cos(), 40.0, 60.0 * time.sin());
    let back = eye.normalize();
    let right = Vec3::Y.cross(back).normalize();
    let axes = [right.extend(0.0), back.cross(right).extend(0.0), back.extend(0.0), eye.extend(1.0)];
    let scale = 1.0 / 0.45_f32.tan();
    let depth = [
        [scale / aspect, 0.0, 0.0, 0.0],
        [0.0, scale, 0.0, 0.0],
        [0.0, 0.0, 0.0, -1.0],
        [0.0, 0.0, 0.1, 0.0],
    ];
    [axes.map(|axis| axis.to_array()), depth]
}

/// The vertices of a cube with sides of 1 and a lighter top: position, normal and colour. Triangles are
/// counter-clockwise seen from outside.
fn cube() -> Vec<f32> {
    let mut numbers = Vec::new();
    for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
        let right = normal.any_orthonormal_vector();
        let up = normal.cross(right);
        let color = if normal == Vec3::Y { Vec3::splat(0.6) } else { Vec3::new(0.5, 0.35, 0.25) };
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let corner = (normal + right * x + up * y) * 0.5;
            numbers.extend([corner, normal, color].into_iter().flat_map(|vector| vector.to_array()));
        }
    }
    numbers
}
