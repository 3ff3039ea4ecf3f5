//! Animations: key times and values of every channel, checked.

use glam::DVec4;
use gltf::json::animation::{Animation as JsonAnimation, Channel as JsonChannel, Property as JsonProperty};

use super::accessor::Accessors;
use super::hierarchy::Hierarchy;
use super::report::Report;
use crate::animation::{Animation, Channel, Interpolation, Property};
use crate::codes;
use crate::node::{LocalTransform, NodeId};

/// Reads all animations of the document. Channels that cannot be read are reported as errors and left out.
pub(super) fn read(accessors: &Accessors<'_>, hierarchy: &Hierarchy, report: &mut Report) -> Vec<Animation> {
    let mut animations = Vec::with_capacity(accessors.root.animations.len());
    for (index, json) in accessors.root.animations.iter().enumerate() {
        if index == 1 {
            let message = "only the first animation is played";
            report.warning(codes::LEFT_OUT, "/animations/1", message, "put the animation to be played first");
        }
        if json.channels.is_empty() {
            let at = format!("/animations/{index}/channels");
            let message = "the animation has no channels, so nothing moves";
            report.warning(codes::LEFT_OUT, &at, message, "give it channels, or remove it");
        }
        let mut channels = Vec::with_capacity(json.channels.len());
        for (place, channel) in json.channels.iter().enumerate() {
            let at = format!("/animations/{index}/channels/{place}");
            let reader = Reader { accessors, hierarchy, json, index, at: &at };
            channels.extend(reader.channels(channel, report).into_iter().flatten());
        }
        let last = channels.iter().filter_map(|channel| channel.times.last().copied()).fold(0.0, f32::max);
        let name = json.name.clone().unwrap_or_default();
        animations.push(Animation { name, channels, duration: f64::from(last) });
    }
    animations
}

struct Reader<'a> {
    accessors: &'a Accessors<'a>,
    hierarchy: &'a Hierarchy,
    json: &'a JsonAnimation,
    index: usize,
    at: &'a str,
}

impl Reader<'_> {
    /// Converts a channel of the document; a channel of morph weights becomes one channel for each weight. Returns
    /// `None` after reporting an error.
    fn channels(&self, json: &JsonChannel, report: &mut Report) -> Option<Vec<Channel>> {
        let at = self.at;
        let message = "the channel moves an unknown property";
        let help = "it is translation, rotation, scale or weights";
        let property = match report.known(&json.target.path, &format!("{at}/target/path"), message, help)? {
            JsonProperty::Translation => Property::Translation,
            JsonProperty::Rotation => Property::Rotation,
            JsonProperty::Scale => Property::Scale,
            JsonProperty::MorphTargetWeights => Property::Weight(0),
        };
        let node = json.target.node.value();
        let target = report.lookup(&self.hierarchy.nodes, node, "node", &format!("{at}/target/node"))?;
        let count = target.weights.len();
        if property == Property::Weight(0) && count == 0 {
            let message =
                format!("node {node} has no mesh with morph targets, so it has no weights to animate");
            let help = "remove the channel, or give the mesh its targets";
            return report.reject(codes::BAD_ANIMATION, at, message, help);
        }
        if property != Property::Weight(0) && matches!(target.local, LocalTransform::Matrix(_)) {
            let message = format!("node {node} has a matrix, so its {property:?} cannot be animated");
            let help = "give the node translation, rotation and scale instead";
            return report.reject(codes::BAD_ANIMATION, at, message, help);
        }
        let sampler =
            report.lookup(&self.json.samplers, json.sampler.value(), "sampler", &format!("{at}/sampler"))?;
        let sampler_at = format!("/animations/{}/samplers/{}", self.index, json.sampler.value());
        let interpolation = report.known(
            &sampler.interpolation,
            &format!("{sampler_at}/interpolation"),
            "the interpolation is unknown",
            "it is STEP, LINEAR or CUBICSPLINE",
        )?;
        let (input, output) = (format!("{sampler_at}/input"), format!("{sampler_at}/output"));
        let help = "export the animation again";
        let times = self.accessors.read::<f32, 1>(sampler.input.value(), &input, report);
        let values: Option<Vec<[f32; 4]>> = match property {
            Property::Rotation => self.accessors.read::<f32, 4>(sampler.output.value(), &output, report),
            Property::Weight(_) => {
                let values = self.accessors.read::<f32, 1>(sampler.output.value(), &output, report);
                values.map(|values| values.into_iter().map(|[x]| [x, 0.0, 0.0, 0.0]).collect())
            }
            Property::Translation | Property::Scale => {
                let values = self.accessors.read::<f32, 3>(sampler.output.value(), &output, report);
                values.map(|values| values.into_iter().map(|[x, y, z]| [x, y, z, 0.0]).collect())
            }
        };
        let times: Vec<f32> = times?.into_iter().map(|[time]| time).collect();
        let values = values?;
        let increasing = times.windows(2).all(|pair| pair[0] < pair[1]) && times[0] >= 0.0;
        if !increasing || !times.iter().all(|time| time.is_finite()) {
            let message = "the key times do not increase from zero on";
            return report.reject(codes::BAD_ANIMATION, &input, message, help);
        }
        let parts = times.len() * if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let each = if property == Property::Weight(0) { count } else { 1 };
        let wanted = parts * each;
        if values.len() != wanted {
            let message =
                format!("{} values stand for {} keys, where {wanted} are needed", values.len(), times.len());
            return report.reject(codes::BAD_ANIMATION, &output, message, help);
        }
        if let Some(first) = values.iter().position(|value| !value.iter().all(|part| part.is_finite())) {
            return report.reject(codes::NOT_FINITE, &output, format!("value {first} is not finite"), help);
        }
        let is_key = |place: &usize| interpolation != Interpolation::CubicSpline || place % 3 == 1;
        let length = |place: &usize| DVec4::from_array(values[*place].map(f64::from)).length();
        let mut turned_nowhere = (0..values.len()).filter(is_key).filter(|place| length(place) < 1e-6);
        if let (Property::Rotation, Some(first)) = (property, turned_nowhere.next()) {
            let message = format!("value {first} is a rotation of length zero");
            return report.reject(codes::BAD_ANIMATION, &output, message, "it has to be a unit quaternion");
        }
        let node = NodeId(node as u32);
        if property != Property::Weight(0) {
            return Some(vec![Channel { node, property, interpolation, times, values }]);
        }
        // Each weight is a channel of its own, with the times once more.
        if !report.charge((wanted as u64).saturating_mul(24), &output) {
            return None;
        }
        let channel = |weight: usize| {
            let values = values.iter().skip(weight).step_by(count).copied().collect();
            Channel { node, property: Property::Weight(weight), interpolation, times: times.clone(), values }
        };
        Some((0..count).map(channel).collect())
    }
}
