//! How much of a picture changes though nothing moved but the camera.
//!
//! A point of the world that two frames in a row see is found again with the depth of one and the matrices of both. Its
//! value in the later frame is compared with those of the pixels around it in the earlier one: four by four of them, which
//! have to be of one value but for [`TOLERANCE`], so that the point is an interior one, a pixel or more from any edge. It
//! has changed where its value is another than theirs by more than that.
//!
//! A point counts where the four nearest pixels are of its own surface: their positions are the corners of a
//! parallelogram in which it lies. Edges of things, what was hidden or out of the picture, and surfaces seen at the most
//! grazing angles do not count.
//!
//! Limits: what moves by less than a pixel is not found; what is smaller than a pixel may lie between pixels and count as
//! changed.

use glam::{DMat4, DVec2, DVec3};

/// What a value may differ by without counting as changed.
pub const TOLERANCE: f32 = 0.02;

/// By how much of a pixel's extent on its surface a position may be off.
const FLATNESS: f64 = 0.1;

/// A frame: depth and a value of each pixel, row 0 on top.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// The width and height, in pixels.
    pub size: [u32; 2],
    /// World to clip space.
    pub clip_from_world: DMat4,
    /// Clip depth.
    pub depth: &'a [f32],
    /// The clip depth where nothing is seen.
    pub far_depth: f32,
    /// The values, such as the visibility of a light.
    pub values: &'a [f32],
}

/// The interior points that two frames see, and how many have changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// The points.
    pub points: u64,
    /// Those whose value has changed.
    pub changed: u64,
}

impl Changes {
    /// The part that has changed; 0 where there are no points.
    pub fn share(&self) -> f64 {
        if self.points == 0 { 0.0 } else { self.changed as f64 / self.points as f64 }
    }
}

impl std::ops::AddAssign for Changes {
    fn add_assign(&mut self, other: Self) {
        self.points += other.points;
        self.changed += other.changed;
    }
}

/// Compares a frame with the one before it. Points whose depth or value is missing do not count.
pub fn changes(before: &Seen<'_>, after: &Seen<'_>) -> Changes {
    let world = after.clip_from_world.inverse();
    let earlier = before.clip_from_world.inverse();
    let mut changes = Changes::default();
    for y in 0..after.size[1] {
        for x in 0..after.size[0] {
            let Some((point, value)) = after.point(&world, x, y) else { continue };
            let Some([lowest, highest]) = before.around(&earlier, point) else { continue };
            if highest - lowest <= TOLERANCE {
                changes.points += 1;
                changes.changed += u64::from(value < highest - TOLERANCE || value > lowest + TOLERANCE);
            }
        }
    }
    changes
}

impl Seen<'_> {
    /// The position and value of a pixel, where something is seen.
    fn point(&self, world_from_clip: &DMat4, x: u32, y: u32) -> Option<(DVec3, f32)> {
        let [width, height] = self.size;
        let at = y as usize * width as usize + x as usize;
        let (depth, value) = (*self.depth.get(at)?, *self.values.get(at)?);
        if depth == self.far_depth {
            return None;
        }
        let part = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
            / DVec2::new(f64::from(width), f64::from(height));
        let clip = DVec3::new(2.0 * part.x - 1.0, 1.0 - 2.0 * part.y, f64::from(depth));
        let point = world_from_clip.project_point3(clip);
        point.is_finite().then_some((point, value))
    }

    /// The lowest and the highest value of the pixels around a point, if it is of the surface that they show.
    fn around(&self, world_from_clip: &DMat4, point: DVec3) -> Option<[f32; 2]> {
        let clip = self.clip_from_world * point.extend(1.0);
        if clip.w <= 0.0 {
            return None;
        }
        let part = DVec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w);
        let [width, height] = self.size;
        let place = part * DVec2::new(f64::from(width), f64::from(height)) - 0.5;
        let last = DVec2::new(f64::from(width), f64::from(height)) - 2.0;
        if !(place.cmpge(DVec2::ONE).all() && place.cmplt(last).all()) {
            return None;
        }
        let corner = place.floor();
        let at = |right: u32, down: u32| {
            self.point(world_from_clip, corner.x as u32 + right, corner.y as u32 + down)
        };
        let [a, b, c, d] = [at(0, 0)?, at(1, 0)?, at(0, 1)?, at(1, 1)?];
        let inside = place - corner;
        let found = a.0.lerp(b.0, inside.x).lerp(c.0.lerp(d.0, inside.x), inside.y);
        let least = FLATNESS * a.0.distance(b.0).min(a.0.distance(c.0));
        let is_flat = (a.0 + d.0).distance(b.0 + c.0) <= least && found.distance(point) <= least;
        if !is_flat {
            return None;
        }
        let (first, row) = ((corner.y as usize - 1) * width as usize + corner.x as usize - 1, width as usize);
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for values in (0..4).map(|down| self.values.get(first + down * row..first + down * row + 4)) {
            for value in values? {
                range = [range[0].min(*value), range[1].max(*value)];
            }
        }
        Some(range)
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use umbragraph_pipeline::frame::{Camera, Projection};

    use super::*;

    const SIZE: [u32; 2] = [64, 48];

    /// The floor and a wall behind it, and a value of each of their points.
    struct Picture {
        clip_from_world: DMat4,
        depth: Vec<f32>,
        values: Vec<f32>,
    }

    impl Picture {
        fn new(position: DVec3, turned: f64, value: impl Fn(DVec3) -> f32) -> Self {
            let projection = Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 };
            let rotation = DQuat::from_rotation_y(turned) * DQuat::from_rotation_x(-0.4);
            let camera = Camera { position, rotation, projection, aspect: 4.0 / 3.0 };
            let clip_from_world = camera.clip(true) * camera.view();
            let world = clip_from_world.inverse();
            let (mut depth, mut values) = (Vec::new(), Vec::new());
            for at in 0..SIZE[0] * SIZE[1] {
                let [x, y] = [at % SIZE[0], at / SIZE[0]];
                let part = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / DVec2::new(64.0, 48.0);
                let clip = DVec3::new(2.0 * part.x - 1.0, 1.0 - 2.0 * part.y, 1.0);
                let ray = world.project_point3(clip) - position;
                let floor = if ray.y < 0.0 { -position.y / ray.y } else { f64::INFINITY };
                let wall = if ray.z < 0.0 { (-6.0 - position.z) / ray.z } else { f64::INFINITY };
                let point = position + ray * floor.min(wall);
                depth.push(if point.is_finite() {
                    clip_from_world.project_point3(point).z as f32
                } else {
                    0.0
                });
                values.push(if point.is_finite() { value(point) } else { 0.0 });
            }
            Self { clip_from_world, depth, values }
        }

        fn seen(&self) -> Seen<'_> {
            let Self { clip_from_world, depth, values } = self;
            Seen { size: SIZE, clip_from_world: *clip_from_world, depth, far_depth: 0.0, values }
        }
    }

    /// Squares of a metre, light and dark, that lie somewhat off.
    fn squares(off: f64) -> impl Fn(DVec3) -> f32 {
        move |point| f32::from(((point.x + off).floor() + (point.y + point.z).floor()).rem_euclid(2.0) < 0.5)
    }

    #[test]
    fn what_lies_on_the_world_does_not_change_wherever_it_is_seen_from() {
        let before = Picture::new(DVec3::new(0.0, 2.0, 0.0), 0.0, squares(0.0));
        for (step, turned) in [(0.0, 0.0), (0.03, 0.0), (0.4, 0.0), (0.0, 0.01), (0.1, -0.2)] {
            let after = Picture::new(DVec3::new(step, 2.0, 0.5 * step), turned, squares(0.0));
            let changes = changes(&before.seen(), &after.seen());
            assert!(changes.points > 600, "{changes:?}");
            assert!(changes.share() < 0.005, "{step} {turned}: {changes:?}");
        }
    }

    #[test]
    fn what_moves_on_the_world_has_changed_by_its_share() {
        let before = Picture::new(DVec3::new(0.0, 2.0, 0.0), 0.0, squares(0.0));
        let share = |off: f64| {
            let after = Picture::new(DVec3::new(0.02, 2.0, 0.01), 0.01, squares(off));
            changes(&before.seen(), &after.seen()).share()
        };
        // Squares that are dark where light ones were have all changed.
        assert!((0.15..0.3).contains(&share(0.3)), "{}", share(0.3));
        assert!(share(1.0) == 1.0, "{}", share(1.0));
    }

    #[test]
    fn what_was_hidden_or_out_of_the_picture_does_not_count() {
        let lit = |_: DVec3| 1.0;
        let dark = |_: DVec3| 0.0;
        let before = Picture::new(DVec3::new(0.0, 2.0, 0.0), 0.0, lit);
        let behind = Picture::new(DVec3::new(0.0, 2.0, 0.0), std::f64::consts::PI, dark);
        assert_eq!(changes(&before.seen(), &behind.seen()), Changes::default());
        let mut nearer = Picture::new(DVec3::new(0.0, 2.0, 0.0), 0.0, dark);
        nearer.depth.iter_mut().for_each(|depth| *depth *= 1.1);
        assert_eq!(changes(&before.seen(), &nearer.seen()), Changes::default());
        nearer.depth.fill(0.0);
        assert_eq!(changes(&before.seen(), &nearer.seen()).share(), 0.0);
    }
}
