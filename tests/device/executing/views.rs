//! A node kind whose views each frame chooses, through the names of its lights: `LAYER`, `LAYER X Y WIDTH HEIGHT`, or
//! the same with how far the view moves everything to the right and up, in fractions if need be.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph::data::{BlackboardData, DataShape, ValueType, View};
use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::low_level::language::Ref;
use umbragraph::low_level::pipeline::{PassBuilder, Produced};
use umbragraph::node::Node;
use umbragraph::work::{CpuContext, CpuNode, CpuWork, Work};

use crate::common::gpu::empty_frame;

/// Publishes views, and the frame's time.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Views {
    /// The blackboard data to publish.
    to: Ref,
    /// The maximum number of views.
    max: u32,
    /// Whether to publish what was not declared.
    #[serde(default)]
    lies: bool,
}

impl Node for Views {
    const NAME: &'static str = "views";
    const SUMMARY: &'static str = "Publishes the views that a frame chooses.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let shape = DataShape::new().value("time", ValueType::F32, "seconds").views(self.max);
        let output = pass.publish(&self.to, "/to", shape)?;
        pass.produce(Work::Cpu(CpuWork::new(Run { lies: self.lies }, output, Vec::new())))
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Run {
    lies: bool,
}

impl CpuNode for Run {
    type State = ();

    fn run(&self, (): &mut (), context: &CpuContext<'_>, data: &mut BlackboardData) {
        data.set_f32("time", context.frame.time as f32);
        if self.lies {
            data.set_f32("undeclared", 1.0);
        }
        for light in &context.frame.lights {
            let words: Vec<&str> = light.name.split(' ').collect();
            let [right, up] =
                [5, 6].map(|at| words.get(at).map_or(0.0, |word| word.parse().expect("a number")));
            let numbers: Vec<u32> = words.iter().take(5).filter_map(|word| word.parse().ok()).collect();
            let (layer, viewport) = match numbers[..] {
                [layer] => (layer, None),
                [layer, x, y, width, height] => (layer, Some([x, y, width, height])),
                _ => panic!("{} is no view", light.name),
            };
            data.push_view(
                View::new(
                    glam::DMat4::from_translation(glam::DVec3::new(right, up, 0.0)),
                    glam::DMat4::IDENTITY,
                    glam::DVec3::ZERO,
                    glam::DVec3::NEG_Z,
                )
                .layer(layer)
                .viewport(viewport),
            );
        }
    }
}

/// A frame with these views.
pub(crate) fn frame(views: &[&str]) -> FrameInput {
    let light = |name: &&str| Light::new((*name).to_owned(), LightKind::Directional).property("cast_shadow");
    empty_frame().lights(views.iter().map(light).collect())
}
