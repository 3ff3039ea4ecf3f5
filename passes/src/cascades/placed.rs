//! The cascades of several suns, in the layers that a placement gives them.
//!
//! Every sun is fitted with the same settings. Its cascades are drawn into consecutive layers, from the first that the
//! placement names; a cascade that could not be fitted leaves a descriptor that shadows nothing.
//!
//! A filter of equal width in the world has other texels in each cascade. Where the bounds that a pipeline sets in texels
//! bite, the width changes from cascade to cascade: a notice names those, and their width.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec4, UVec2};
use umbragraph_graph::data::{DataShape, HostData, ValueType};
use umbragraph_graph::diagnostic::{Diagnostic, Place, Severity, list_of};
use umbragraph_graph::frame::Light;
use umbragraph_graph::pipeline::{PassBuilder, Produced};
use umbragraph_graph::work::{HostContext, HostNode, HostWork, Work};

use super::configuration::{Cascade, Configuration};
use super::node::Cascades;
use crate::codes;
use crate::lights::descriptor::{self, Descriptor};
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
    let filter = match &settings.filter {
        Some(filter) => Some(Filter {
            radius: pass.number(&filter.radius, "/filter/radius")?,
            least: pass.number(&filter.least, "/filter/least")?,
            greatest: pass.number(&filter.greatest, "/filter/greatest")?,
        }),
        None => None,
    };
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
    /// The cascades of this frame in which the filter's bounds bite: light, cascade, half the width there.
    bounded: Vec<(u32, usize, f64)>,
    /// Which those of the last notice were.
    reported: Vec<(u32, usize)>,
}

/// Half the width of a filter in metres, and its bounds in texels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Filter {
    radius: f64,
    least: f64,
    greatest: f64,
}

impl Filter {
    /// Half the width where texels are so wide, in metres, if it is not the one that is wanted.
    fn bounded(&self, texel: f64) -> Option<f64> {
        let width = (self.radius / texel).max(self.least).min(self.greatest) * texel;
        ((width - self.radius).abs() > 1e-6 * self.radius).then_some(width)
    }
}

impl HostNode for RunPlaced {
    fn run(&self, context: &HostContext<'_>, data: &mut HostData) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let State { descriptors, bounded, reported } = &mut *state;
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
                let width = self.filter.and_then(|filter| filter.bounded(cascade.texel_size));
                bounded.extend(width.map(|width| (entry.light, at, width)));
            }
            let missing = (count as usize).saturating_sub(set.count());
            descriptors.extend(std::iter::repeat_n(Descriptor::default(), missing));
        }
        descriptor::publish(data, descriptors);
        if !bounded.iter().map(|(light, at, _)| (*light, *at)).eq(reported.iter().copied()) {
            reported.clear();
            reported.extend(bounded.iter().map(|(light, at, _)| (*light, *at)));
            data.set_notices(self.notice(bounded, &context.frame.lights).into_iter().collect());
        }
    }
}

impl RunPlaced {
    fn notice(&self, bounded: &[(u32, usize, f64)], lights: &[Light]) -> Option<Diagnostic> {
        let filter = self.filter.filter(|_| !bounded.is_empty())?;
        let names: Vec<String> = bounded
            .iter()
            .map(|(light, at, width)| {
                let name = lights.get(*light as usize).map_or("", |light| &light.name);
                format!("{at} of \"{name}\" ({width:.3} m)")
            })
            .collect();
        let message = format!(
            "shadow filters are not {} m to a side in cascade {}",
            filter.radius,
            list_of(names.iter().map(String::as_str))
        );
        let help = format!(
            "their bounds of {} to {} texels bite there: change them, the resolution, or the far distances",
            filter.least, filter.greatest
        );
        let notice = Diagnostic::warning(codes::FILTER_BOUNDED, Place::Nowhere, message).help(help);
        Some(Diagnostic { severity: Severity::Note, ..notice })
    }

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
