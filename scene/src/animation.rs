//! Key-frame animation of node transforms.
//!
//! A channel moves one property of one node through key frames, interpolated as glTF 2.0 (appendix C) defines: held,
//! linear (spherical for rotations), or by a cubic Hermite spline whose tangents the file gives. Before its first key
//! and after its last one a channel holds the value there. Evaluation is a binary search and one interpolation.

use glam::{DQuat, DVec4};

use crate::node::NodeId;

/// A glTF animation: a set of channels that are played together on one timeline.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// The channels, in the order of the file; each one animates one property of one node.
    pub channels: Vec<Channel>,
    /// The time of the last key frame of all channels, in seconds.
    pub duration: f64,
}

/// The property of a node that a channel animates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// The node's translation, in metres.
    Translation,
    /// The node's rotation, a unit quaternion.
    Rotation,
    /// The node's scale factor along each axis.
    Scale,
    /// The weight of one morph target of the node's mesh; the value is the index of the target.
    Weight(usize),
}

/// The interpolation between two key frames: a step that holds the earlier value, linear (along the shorter arc for
/// rotations), or a cubic Hermite spline.
pub use gltf::json::animation::Interpolation;

/// The key frames of one property of one node. A glTF channel that animates all morph weights of a node becomes one
/// `Channel` for each weight.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The animated node.
    pub node: NodeId,
    /// The animated property of the node.
    pub property: Property,
    /// The kind of interpolation between key frames.
    pub interpolation: Interpolation,
    /// The times of the key frames in seconds, strictly increasing; at least one.
    pub times: Vec<f32>,
    /// One value for each key frame: x, y, z, and also w for rotations; a morph weight is in x. Cubic splines have
    /// three values for each key frame: in-tangent, value, out-tangent.
    pub values: Vec<[f32; 4]>,
}

impl Channel {
    /// Evaluates the channel at a time in seconds. Returns a translation or scale in x, y, z, a rotation as a unit
    /// quaternion, or a morph weight in x.
    pub fn sample(&self, time: f64) -> DVec4 {
        let after = self.times.partition_point(|key| f64::from(*key) <= time);
        let (Some(before), true) = (after.checked_sub(1), after < self.times.len()) else {
            return self.finished(self.value(after.min(self.times.len().saturating_sub(1))));
        };
        let (start, end) = (f64::from(self.times[before]), f64::from(self.times[after]));
        let span = end - start;
        let t = (time - start) / span;
        match self.interpolation {
            Interpolation::Step => self.finished(self.value(before)),
            Interpolation::Linear if self.property == Property::Rotation => {
                let rotation = |key| DQuat::from_vec4(self.finished(self.value(key)));
                DVec4::from(rotation(before).slerp(rotation(after), t))
            }
            Interpolation::Linear => self.value(before).lerp(self.value(after), t),
            Interpolation::CubicSpline => {
                let (t2, t3) = (t * t, t * t * t);
                self.finished(
                    self.value(before) * (2.0 * t3 - 3.0 * t2 + 1.0)
                        + self.raw(before * 3 + 2) * (span * (t3 - 2.0 * t2 + t))
                        + self.value(after) * (3.0 * t2 - 2.0 * t3)
                        + self.raw(after * 3) * (span * (t3 - t2)),
                )
            }
        }
    }

    /// The value at the key frame with index `key`; for a cubic spline, the value between its two tangents.
    fn value(&self, key: usize) -> DVec4 {
        self.raw(if self.interpolation == Interpolation::CubicSpline { key * 3 + 1 } else { key })
    }

    fn raw(&self, at: usize) -> DVec4 {
        self.values.get(at).map_or(DVec4::ZERO, |value| DVec4::from_array(value.map(f64::from)))
    }

    /// Returns the normalized quaternion for a rotation channel (identity for length zero), and other values unchanged.
    fn finished(&self, value: DVec4) -> DVec4 {
        match self.property {
            Property::Rotation => value.try_normalize().unwrap_or(DVec4::W),
            Property::Translation | Property::Scale | Property::Weight(_) => value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn channel(property: Property, interpolation: Interpolation, values: Vec<[f32; 4]>) -> Channel {
        Channel { node: NodeId(0), property, interpolation, times: vec![1.0, 3.0], values }
    }

    #[test]
    fn a_step_holds_the_earlier_key() {
        let channel = channel(
            Property::Translation,
            Interpolation::Step,
            vec![[1.0, 0.0, 0.0, 0.0], [5.0, 0.0, 0.0, 0.0]],
        );
        assert_eq!([0.0, 1.0, 2.999, 3.0, 9.0].map(|time| channel.sample(time).x), [1.0, 1.0, 1.0, 5.0, 5.0]);
    }

    #[test]
    fn linear_rotations_take_the_shorter_arc_at_constant_speed() {
        let end = DQuat::from_rotation_y(FRAC_PI_2).as_quat().to_array();
        for values in [vec![[0.0, 0.0, 0.0, 1.0], end], vec![[0.0, 0.0, 0.0, 1.0], end.map(|part| -part)]] {
            let half = channel(Property::Rotation, Interpolation::Linear, values).sample(2.0);
            let half = DQuat::from_vec4(half);
            assert!(half.angle_between(DQuat::from_rotation_y(FRAC_PI_2 / 2.0)) < 1e-3);
        }
    }

    #[test]
    fn a_spline_passes_its_keys_and_follows_its_tangents() {
        let zero = [0.0; 4];
        let slope = [1.0, 0.0, 0.0, 0.0];
        let values = vec![slope, zero, slope, slope, [2.0, 0.0, 0.0, 0.0], slope];
        let channel = channel(Property::Translation, Interpolation::CubicSpline, values);
        for (time, x) in [(0.0, 0.0), (1.0, 0.0), (1.5, 0.5), (2.0, 1.0), (3.0, 2.0), (4.0, 2.0)] {
            assert!((channel.sample(time).x - x).abs() < 1e-12, "at {time}");
        }
        // A cubic is its own spline: u³ − u² + 0.5, u seconds behind the first key.
        let values = [0.0, 0.5, 0.0, 1.0, 0.5, 1.0, 8.0, 4.5, 0.0].map(|x| [x, 0.0, 0.0, 0.0]).to_vec();
        let cubic = Channel { values, times: vec![1.0, 2.0, 3.0], ..channel };
        for u in [0.25, 0.5, 1.25, 1.75] {
            let wanted = u * u * u - u * u + 0.5;
            assert!((cubic.sample(1.0 + u).x - wanted).abs() < 1e-12, "{u} s behind the key");
        }
    }
}
