//! Light from everywhere: a sky of two colors, or an equirectangular picture; sampled by its brightness.
//!
//! An equirectangular picture has +x in its middle and +y at its top; to the right it turns towards +z.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

/// Rows and columns of the table by which skies without a picture are sampled.
const TABLE: [usize; 2] = [64, 32];

/// The part of samples that are drawn from all sides alike.
const EVEN: f64 = 0.1;

/// The light of a sky, per direction.
#[derive(Clone, Debug)]
pub enum Radiance {
    /// A color that goes from `horizon` to `zenith` with the height to the power of 0.6, and one below.
    Gradient {
        /// Radiance at the horizon.
        horizon: DVec3,
        /// Radiance overhead.
        zenith: DVec3,
        /// Radiance of the ground.
        below: DVec3,
    },
    /// A color above the horizon, and one below.
    Halves {
        /// Radiance from above.
        above: DVec3,
        /// Radiance from below.
        below: DVec3,
    },
    /// An equirectangular picture, between whose texels radiance is linear.
    Picture {
        /// The width in texels.
        width: usize,
        /// Linear colors, rows from the top.
        texels: Vec<[f32; 3]>,
        /// The angle in degrees by which the picture is turned about the vertical axis.
        turn: f64,
        /// The factor of its light.
        strength: f64,
    },
}

impl Radiance {
    /// The radiance from a unit direction.
    pub fn of(&self, direction: DVec3) -> DVec3 {
        match self {
            Self::Gradient { below, .. } if direction.y < 0.0 => *below,
            Self::Gradient { horizon, zenith, .. } => {
                horizon.lerp(*zenith, direction.y.clamp(0.0, 1.0).powf(0.6))
            }
            Self::Halves { above, below } => {
                if direction.y < 0.0 {
                    *below
                } else {
                    *above
                }
            }
            Self::Picture { width, texels, turn, strength } => {
                let (sine, cosine) = turn.to_radians().sin_cos();
                let x = cosine * direction.x + sine * direction.z;
                let z = cosine * direction.z - sine * direction.x;
                let height = texels.len() / width;
                let at = DVec2::new(
                    (0.5 + z.atan2(x) / TAU) * *width as f64 - 0.5,
                    direction.y.clamp(-1.0, 1.0).acos() / PI * height as f64 - 0.5,
                );
                let (low, part) = (at.floor(), at - at.floor());
                let texel = |x: f64, y: f64| {
                    let (x, y) = (x.rem_euclid(*width as f64), y.clamp(0.0, height as f64 - 1.0));
                    DVec3::from_array(texels[y as usize * width + x as usize % width].map(f64::from))
                };
                let row = |y: f64| texel(low.x, y).lerp(texel(low.x + 1.0, y), part.x);
                row(low.y).lerp(row(low.y + 1.0), part.y) * *strength
            }
        }
    }

    /// The columns and rows of a table for samples.
    fn table(&self) -> [usize; 2] {
        match self {
            Self::Picture { width, texels, .. } => [*width, texels.len() / width],
            _ => TABLE,
        }
    }
}

/// A sky: the light that it sends, and what a camera sees of it.
#[derive(Clone, Debug)]
pub struct Sky {
    light: Radiance,
    background: Radiance,
    columns: usize,
    /// Sums of brightness: of all cells up to each one of a row, from 0 to 1, row by row.
    along: Vec<f64>,
    /// Sums of brightness: of all rows up to each one, from 0 to 1.
    down: Vec<f64>,
}

impl Sky {
    /// A sky that a camera sees as `background`, and that lights surfaces as `light` does.
    pub fn new(light: Radiance, background: Radiance) -> Self {
        let [columns, rows] = light.table();
        let luminance = |column: usize, row: usize| {
            let direction = direction_at(DVec2::new(
                (column as f64 + 0.5) / columns as f64,
                (row as f64 + 0.5) / rows as f64,
            ));
            light.of(turned_back(direction, &light)).dot(DVec3::new(0.2126, 0.7152, 0.0722)).max(0.0)
        };
        let cells: Vec<f64> = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (column, row)))
            .map(|(column, row)| luminance(column, row))
            .collect();
        let (mut along, mut down, mut all) = (Vec::with_capacity(cells.len()), Vec::with_capacity(rows), 0.0);
        for row in 0..rows {
            // The neighbours count, too: radiance is linear between texels.
            let near = |column: usize| -> f64 {
                let rows = row.saturating_sub(1)..(row + 2).min(rows);
                let columns_near = [column + columns - 1, column, column + 1];
                rows.flat_map(|row| columns_near.map(|near| cells[row * columns + near % columns])).sum()
            };
            let mut sum = 0.0;
            let first = along.len();
            for column in 0..columns {
                sum += near(column) + 1e-12;
                along.push(sum);
            }
            along[first..].iter_mut().for_each(|part| *part /= sum);
            all += sum * (PI * (row as f64 + 0.5) / rows as f64).sin();
            down.push(all);
        }
        down.iter_mut().for_each(|part| *part /= all);
        Self { light, background, columns, along, down }
    }

    /// The radiance that surfaces get from a unit direction.
    pub fn light(&self, direction: DVec3) -> DVec3 {
        self.light.of(direction)
    }

    /// The radiance that a camera sees in a unit direction.
    pub fn seen(&self, direction: DVec3) -> DVec3 {
        self.background.of(direction)
    }

    /// Draws a unit direction, the more often the brighter the sky is there, with its density per steradian.
    pub fn sample(&self, mut at: DVec2) -> (DVec3, f64) {
        let direction = if at.x < EVEN {
            let (z, angle) = (1.0 - 2.0 * at.x / EVEN, TAU * at.y);
            DVec3::new(angle.cos(), 0.0, angle.sin()) * (1.0 - z * z).max(0.0).sqrt() + DVec3::Y * z
        } else {
            at.x = (at.x - EVEN) / (1.0 - EVEN);
            let (row, y) = cell(&self.down, at.y);
            let (column, x) = cell(&self.along[row * self.columns..][..self.columns], at.x);
            let place = DVec2::new(
                (column as f64 + x) / self.columns as f64,
                (row as f64 + y) / self.down.len() as f64,
            );
            turned_back(direction_at(place), &self.light)
        };
        (direction, self.density(direction))
    }

    /// The density per steradian with which [`Self::sample`] draws a direction.
    pub fn density(&self, direction: DVec3) -> f64 {
        let place = place_of(turned(direction, &self.light));
        let (columns, rows) = (self.columns, self.down.len());
        let column = ((place.x * columns as f64) as usize).min(columns - 1);
        let row = ((place.y * rows as f64) as usize).min(rows - 1);
        let step = |sums: &[f64], at: usize| sums[at] - if at == 0 { 0.0 } else { sums[at - 1] };
        let chance = step(&self.down, row) * step(&self.along[row * columns..][..columns], column);
        let sine = (1.0 - direction.y * direction.y).max(1e-12).sqrt();
        let density = chance * (columns * rows) as f64 / (TAU * PI * sine);
        EVEN / (2.0 * TAU) + (1.0 - EVEN) * density
    }
}

/// The first cell whose sum exceeds `at`, and the part of the way through it.
fn cell(sums: &[f64], at: f64) -> (usize, f64) {
    let index = sums.partition_point(|sum| *sum <= at).min(sums.len() - 1);
    let before = if index == 0 { 0.0 } else { sums[index - 1] };
    (index, ((at - before) / (sums[index] - before).max(1e-300)).clamp(0.0, 1.0))
}

fn direction_at(place: DVec2) -> DVec3 {
    let ((sine, cosine), (across, up)) = (((place.x - 0.5) * TAU).sin_cos(), (place.y * PI).sin_cos());
    DVec3::new(cosine * across, up, sine * across)
}

fn place_of(direction: DVec3) -> DVec2 {
    DVec2::new(0.5 + direction.z.atan2(direction.x) / TAU, direction.y.clamp(-1.0, 1.0).acos() / PI)
}

fn turned(direction: DVec3, light: &Radiance) -> DVec3 {
    let Radiance::Picture { turn, .. } = light else { return direction };
    glam::DQuat::from_rotation_y(turn.to_radians()) * direction
}

fn turned_back(direction: DVec3, light: &Radiance) -> DVec3 {
    let Radiance::Picture { turn, .. } = light else { return direction };
    glam::DQuat::from_rotation_y(-turn.to_radians()) * direction
}

#[cfg(test)]
mod tests {
    use super::super::sequence::Sequence;
    use super::*;

    fn skies() -> [Radiance; 3] {
        let mut texels = vec![[0.2, 0.3, 0.4]; 32 * 16];
        texels[5 * 32 + 9] = [90.0, 80.0, 60.0];
        let (horizon, zenith, below) =
            (DVec3::new(0.75, 0.72, 0.66), DVec3::new(0.16, 0.32, 0.62), DVec3::splat(0.2));
        [
            Radiance::Gradient { horizon, zenith, below },
            Radiance::Halves { above: horizon, below },
            Radiance::Picture { width: 32, texels, turn: 35.0, strength: 2.0 },
        ]
    }

    /// The illuminance of a surface with a normal, as a sum over directions in equal solid angles.
    fn illuminance(sky: &Sky, normal: DVec3) -> DVec3 {
        let (rows, columns) = (800, 1600);
        let mut sum = DVec3::ZERO;
        for row in 0..rows {
            let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(rows);
            for column in 0..columns {
                let (sine, cosine) = (TAU * (f64::from(column) + 0.5) / f64::from(columns)).sin_cos();
                let direction = DVec3::new(cosine, 0.0, sine) * (1.0 - y * y).sqrt() + DVec3::Y * y;
                sum += sky.light(direction) * direction.dot(normal).max(0.0);
            }
        }
        sum * 2.0 * TAU / f64::from(rows * columns)
    }

    #[test]
    fn samples_of_a_sky_agree_with_quadrature() {
        for light in skies() {
            let sky = Sky::new(light.clone(), light);
            for normal in [DVec3::Y, DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.36, -0.8, 0.48)] {
                let count = 1 << 15;
                let sample = |index| {
                    let (direction, density) = sky.sample(Sequence::new(4, 2, index).pair());
                    sky.light(direction) * (direction.dot(normal).max(0.0) / density)
                };
                let sampled = (0..count).map(sample).sum::<DVec3>() / f64::from(count);
                let expected = illuminance(&sky, normal);
                assert!(
                    (sampled - expected).length() < 0.01 * expected.length(),
                    "{normal}: {sampled} {expected}"
                );
            }
        }
    }

    #[test]
    fn halves_light_a_surface_in_proportion_to_what_it_faces() {
        let [_, halves, _] = skies();
        let Radiance::Halves { above, below } = halves.clone() else { unreachable!() };
        let sky = Sky::new(halves.clone(), halves);
        for cosine in [1.0, 0.5, 0.0, -0.7] {
            let normal = DVec3::new((1.0_f64 - cosine * cosine).sqrt(), cosine, 0.0);
            let expected = (above * (0.5 + 0.5 * cosine) + below * (0.5 - 0.5 * cosine)) * PI;
            assert!((illuminance(&sky, normal) - expected).length() < 1e-3, "{cosine}");
        }
    }

    #[test]
    fn a_turned_picture_is_bright_where_its_bright_texel_is() {
        let [.., light] = skies();
        let sky = Sky::new(light.clone(), light);
        let middle = direction_at(DVec2::new(9.5 / 32.0, 5.5 / 16.0));
        let toward = glam::DQuat::from_rotation_y(-35_f64.to_radians()) * middle;
        assert!((sky.seen(toward) - DVec3::new(180.0, 160.0, 120.0)).length() < 1e-3, "{}", sky.seen(toward));
        let near = (0..1000).filter(|index| {
            let (direction, _) = sky.sample(Sequence::new(1, 1, *index).pair());
            direction.dot(toward) > 0.9
        });
        assert!(near.count() > 250, "even samples would be 50");
    }
}
