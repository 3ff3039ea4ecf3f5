//! Shapes: triangles with normals and texture coordinates.

use super::vector::{Placement, Vec3};

/// A vertex: position in metres, unit normal and texture coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) texcoord: [f64; 2],
}

/// A triangle mesh under construction. Triangles are counter-clockwise seen from outside.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// Creates a shape without triangles.
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Adds a vertex and returns its index.
    pub(crate) fn vertex(&mut self, position: Vec3, normal: Vec3, texcoord: [f64; 2]) -> u32 {
        self.vertices.push(Vertex { position, normal, texcoord });
        self.vertices.len() as u32 - 1
    }

    /// Adds a flat convex polygon, its corners counter-clockwise seen from its front.
    pub(crate) fn polygon(&mut self, corners: &[Vec3]) {
        let normal = newell(corners);
        let first = self.vertices.len() as u32;
        for corner in corners {
            self.vertex(*corner, normal, [0.0; 2]);
        }
        for at in 2..corners.len() as u32 {
            self.triangles.push([first, first + at - 1, first + at]);
        }
    }

    /// Adds a flat polygon with texture coordinates for each corner.
    pub(crate) fn textured_polygon(&mut self, corners: &[(Vec3, [f64; 2])]) {
        let first = self.vertices.len();
        self.polygon(&corners.iter().map(|(corner, _)| *corner).collect::<Vec<_>>());
        for (vertex, (_, texcoord)) in self.vertices[first..].iter_mut().zip(corners) {
            vertex.texcoord = *texcoord;
        }
    }

    /// Adds a grid of smooth quads over rows of points with normals. With the next row above the last, points run
    /// counter-clockwise around the surface seen from outside.
    pub(crate) fn grid(&mut self, rows: &[Vec<(Vec3, Vec3)>]) {
        let first = self.vertices.len() as u32;
        let width = rows.first().map_or(0, Vec::len) as u32;
        for (position, normal) in rows.iter().flatten() {
            self.vertex(*position, *normal, [0.0; 2]);
        }
        for row in 1..rows.len() as u32 {
            for column in 1..width {
                let at = |row: u32, column: u32| first + row * width + column;
                let (a, b) = (at(row - 1, column - 1), at(row - 1, column));
                let (c, d) = (at(row, column), at(row, column - 1));
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// Creates a grid of `rows` × `columns` smooth quads from the position and normal of each corner.
    pub(crate) fn surface(rows: u32, columns: u32, corner: impl Fn(u32, u32) -> (Vec3, Vec3)) -> Self {
        let row = |row: u32| (0..=columns).map(|column| corner(row, column)).collect();
        let mut shape = Self::new();
        shape.grid(&(0..=rows).map(row).collect::<Vec<_>>());
        shape
    }

    /// Adds another shape, transformed by a placement.
    pub(crate) fn add(&mut self, other: &Shape, placement: &Placement) {
        let first = self.vertices.len() as u32;
        for vertex in &other.vertices {
            let (position, normal) = (placement.point(vertex.position), placement.normal(vertex.normal));
            self.vertex(position, normal, vertex.texcoord);
        }
        let mirrored = placement.is_mirrored();
        self.triangles.extend(other.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|index| first + index);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
    }

    /// Adds another shape without a transform.
    pub(crate) fn join(&mut self, other: &Shape) {
        self.add(other, &Placement::IDENTITY);
    }

    /// Returns this shape joined with another one, transformed by a placement.
    #[must_use]
    pub(crate) fn and(mut self, other: &Shape, placement: &Placement) -> Self {
        self.add(other, placement);
        self
    }

    /// Returns this shape joined with another one.
    #[must_use]
    pub(crate) fn joined(self, other: &Shape) -> Self {
        self.and(other, &Placement::IDENTITY)
    }

    /// Replaces the texture coordinates: the texture is projected along the axis nearest to each normal, and repeats
    /// every `size` metres.
    #[must_use]
    pub(crate) fn box_mapped(mut self, size: f64) -> Self {
        for vertex in &mut self.vertices {
            let (position, normal) = (vertex.position, vertex.normal);
            let (x, y, z) = (normal.x.abs(), normal.y.abs(), normal.z.abs());
            let [u, v] = if y >= x && y >= z {
                [position.x, position.z]
            } else if x >= z {
                [position.z * -normal.x.signum(), -position.y]
            } else {
                [position.x * normal.z.signum(), -position.y]
            };
            vertex.texcoord = [u / size, v / size];
        }
        self
    }

    /// Returns a copy of the shape, transformed by a placement.
    #[must_use]
    pub(crate) fn placed(&self, placement: &Placement) -> Self {
        Self::new().and(self, placement)
    }
}

/// The unit normal of a flat polygon, which may have collinear corners.
fn newell(corners: &[Vec3]) -> Vec3 {
    let mut normal = Vec3::ZERO;
    for (at, corner) in corners.iter().enumerate() {
        normal += (*corner - corners[0]).cross(corners[(at + 1) % corners.len()] - corners[0]);
    }
    normal.normalize_or(Vec3::Y)
}
