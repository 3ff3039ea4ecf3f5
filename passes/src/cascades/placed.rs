//! The cascades of several suns, in the layers that a placement gives them.
//!
//! Every sun is fitted with the same settings. Its cascades are drawn into consecutive layers, from the first that the
//! placement names; a cascade that could not be fitted leaves a descriptor that shadows nothing.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec4, UVec2};
use umbragraph_graph::data::{DataShape, HostData, ValueType};
use umbragraph_graph::pipeline::{PassBuilder, Produced};
use umbragraph_graph::work::{HostContext, HostNode, HostWork, Work};

use super::configuration::{Cascade, Configuration};
use super::node::Cascades;
use crate::codes;
use crate::lights::descriptor::{self, Descriptor};
use crate::lights::filter::{Bounded, Filter};
use crate::lights::placement::{self, Backing};

pub(super) fn declare(
    settings: &Cascades,
    data: &str,
    configuration: Configuration,
    pass: &mut PassBuilder<'_>,
) -> Option<Produced> {
    if settings.light.is_some() {
        let message = "the placement says which lights have cascades";
        pass.report(codes::PLACEMENT, "/light", message, "remove \"light\", or \"placement\"");
    }
    if settings.tiles.is_some() {
        let message = "with a placement, cascades lie in the layers of an array";
        pass.report(codes::PLACEMENT, "/tiles", message, "remove \"tiles\", or \"placement\"");
    }
    let count = configuration.splits.count() as u32;
    let layers = match &settings.layers {
        Some(expr) => placement::capacity(pass, expr, "/layers", placement::LARGEST_LAYERS)?,
        None => count,
    };
    let filter = Filter::declare(settings.filter.as_ref(), pass)?;
    let input = pass.data_with(data, "/placement", &placement::expected())?;
    let shape = DataShape::new().value("count", ValueType::U32).views(layers).views_choose_layers();
    let shape = descriptor::shape(shape, layers);
    let output = pass.publish(&settings.to, "/to", shape)?;
    let node = Arc::new(RunPlaced { configuration, filter, state: Mutex::default() });
    Some(pass.produce(Work::Host(HostWork { node, output, inputs: vec![input] })))
}

#[derive(Debug)]
struct RunPlaced {
    configuration: Configuration,
    filter: Option<Filter>,
    state: Mutex<State>,
}

/// Memory that is used again in each frame.
#[derive(Debug, Default)]
struct State {
    descriptors: Vec<Descriptor>,
    bounded: Bounded,
}

impl HostNode for RunPlaced {
    fn run(&self, context: &HostContext<'_>, data: &mut HostData) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let State { descriptors, bounded } = &mut *state;
        descriptors.clear();
        bounded.clear();
        let Some(placement) = context.inputs.first() else { return };
        for entry in placement::entries(placement) {
            let Backing::Layers { first, count } = entry.backing else { continue };
            let Some(light) = context.frame.lights.get(entry.light as usize) else { continue };
            let set = self.configuration.fit_light(light, context.frame);
            for (at, cascade) in set.iter().take(count as usize).enumerate() {
                let layer = first + at as u32;
                data.push_view(umbragraph_graph::data::View { layer, ..cascade.view });
                descriptors.push(self.descriptor(at, layer, cascade));
                let filter = self.filter.as_ref();
                bounded.add(entry.light, filter.and_then(|it| it.in_cascade(at, cascade.texel_size)));
            }
            let missing = (count as usize).saturating_sub(set.count());
            descriptors.extend(std::iter::repeat_n(Descriptor::default(), missing));
        }
        descriptor::publish(data, descriptors);
        bounded.report(self.filter, context.frame, data);
    }
}

impl RunPlaced {
    fn descriptor(&self, at: usize, layer: u32, cascade: &Cascade) -> Descriptor {
        let layout = &self.configuration.layout;
        Descriptor {
            clip_from_world: cascade.view.clip_from_world,
            rectangle: layout.scale_offset(at),
            reach: DVec4::new(cascade.slice.far, cascade.slice.blend_start, cascade.texel_size, 0.0),
            place: UVec2::new(layer, layout.tiles[at].resolution),
        }
    }
}
