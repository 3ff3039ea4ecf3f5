//! The application's meshes: dominoes on a spiral that fall one after the other, and the floor they stand on.
//!
//! One cube in one vertex buffer, and a uniform block for each domino.

use glam::{DMat4, DQuat, DVec3, Mat4, Vec3};

/// The distance in bytes between uniform blocks: a matrix and two vectors of three, each padded to four, and padding
/// for the offset alignment.
pub(crate) const STRIDE: u32 = 256;

/// Half of the width, height and thickness of a domino, in metres.
const HALF_SIZE: Vec3 = Vec3::new(0.14, 0.3, 0.045);

/// The number of dominoes; the floor is one more object.
pub(crate) const COUNT: u32 = 64;

/// The cube and the uniform blocks of the dominoes on a device.
pub(crate) struct Dominoes {
    pub(crate) cube: wgpu::Buffer,
    pub(crate) blocks: wgpu::Buffer,
}

impl Dominoes {
    /// Uploads the dominoes in their state before the first one falls.
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let buffer = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let vertices = cube();
        let cube = buffer("cube", vertices.len() as u64, wgpu::BufferUsages::VERTEX);
        queue.write_buffer(&cube, 0, &vertices);
        let size = u64::from(STRIDE * (COUNT + 1));
        let dominoes = Self { cube, blocks: buffer("dominoes", size, wgpu::BufferUsages::UNIFORM) };
        dominoes.update(queue, 0.0);
        dominoes
    }

    /// Uploads the transforms of the dominoes at a time in seconds.
    pub(crate) fn update(&self, queue: &wgpu::Queue, time: f64) {
        let mut bytes = Vec::with_capacity((STRIDE * (COUNT + 1)) as usize);
        for number in 0..COUNT {
            let hue = number as f32 / COUNT as f32 * std::f32::consts::TAU;
            let color = Vec3::new(hue.cos(), (hue - 2.1).cos(), (hue + 2.1).cos()) * 0.3 + 0.36;
            block(&domino(number, time), HALF_SIZE, color, &mut bytes);
        }
        let floor = DMat4::from_translation(DVec3::new(0.0, -0.1, 0.0));
        block(&floor, Vec3::new(20.0, 0.1, 20.0), Vec3::new(0.42, 0.36, 0.28), &mut bytes);
        queue.write_buffer(&self.blocks, 0, &bytes);
    }
}

/// The world matrix of a domino at a time in seconds. Dominoes stand on an outward spiral; each falls after the one
/// before.
pub(crate) fn domino(number: u32, time: f64) -> DMat4 {
    // An Archimedean spiral, in steps of about a third of a metre.
    let angle = (f64::from(number) * 0.94 + 16.0).sqrt() * 1.6;
    let radius = 0.3 * angle - 0.6;
    let position = DVec3::new(radius * angle.cos(), 0.0, radius * angle.sin());
    let heading = DQuat::from_rotation_y(-angle);
    let fallen = ((time - f64::from(number) * 0.24) * 2.5).clamp(0.0, 1.0);
    let height = f64::from(HALF_SIZE.y);
    // It turns about the edge it stands on.
    let tilt = DMat4::from_quat(DQuat::from_rotation_x(fallen * fallen * 1.3));
    DMat4::from_rotation_translation(heading, position) * tilt * DMat4::from_translation(DVec3::Y * height)
}

fn block(world_from_object: &DMat4, half_size: Vec3, color: Vec3, bytes: &mut Vec<u8>) {
    let start = bytes.len();
    let matrix: Mat4 = world_from_object.as_mat4();
    let values = matrix.to_cols_array().into_iter().chain(half_size.extend(0.0).to_array());
    bytes.extend(values.chain(color.extend(0.0).to_array()).flat_map(f32::to_ne_bytes));
    bytes.resize(start + STRIDE as usize, 0);
}

/// The vertices of a cube with sides of 2: position and normal. Triangles are counter-clockwise seen from outside.
fn cube() -> Vec<u8> {
    let mut bytes = Vec::new();
    for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
        let right = normal.any_orthonormal_vector();
        let up = normal.cross(right);
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let position = normal + right * x + up * y;
            bytes.extend(position.to_array().into_iter().chain(normal.to_array()).flat_map(f32::to_ne_bytes));
        }
    }
    bytes
}
