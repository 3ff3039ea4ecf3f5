//! The cascades of several directional lights, in the layers that a placement gives them.
//!
//! Every directional light is fitted with the same settings. Its cascades are drawn into consecutive layers, from the
//! first that the placement names; a cascade that could not be fitted leaves a descriptor that shadows nothing.

use std::sync::Arc;

use glam::{DVec2, DVec3, DVec4, UVec2};
use umbragraph_pipeline::data::View;
use umbragraph_pipeline::frame::FrameInput;
use umbragraph_pipeline::language::Ref;
use umbragraph_pipeline::pipeline::{Evaluate, LiveSettings, PassBuilder, Produced};

use super::configuration::{Cascade, Configuration};
use super::declare;
use super::node::Cascades;
use crate::codes;
use crate::if_said::if_said;
use crate::importance;
use crate::lights::described::{self, DescribeShadows, LiveShadows, ShadowOutput};
use crate::lights::descriptor::{self, Descriptor};
use crate::lights::missing::NoBounds;
use crate::lights::placement::{self, Backing, Entry};

pub(super) fn declare(
    settings: &Cascades,
    data: &Ref,
    configuration: Configuration,
    pass: &mut PassBuilder<'_>,
) -> Option<Produced> {
    if let Some(light) = &settings.light {
        let message = format!("the light is \"{light}\", but \"{data}\" says which lights have cascades");
        pass.report(codes::PLACEMENT, "/light", message, "remove \"light\", or \"placement\"");
    }
    if settings.tiles.is_some() {
        let message = "with a placement, cascades lie in the layers of an array";
        pass.report(codes::PLACEMENT, "/tiles", message, "remove \"tiles\", or \"placement\"");
    }
    let count = configuration.splits.count() as u32;
    let layers =
        if_said(&settings.layers, |expr| placement::capacity(pass, expr, "/layers", placement::MAX_LAYERS));
    let layers = layers?.unwrap_or(count);
    let live = LiveShadows {
        filter: settings.shadow_filter.clone(),
        light_size: settings.light_size.clone(),
        cadence: settings.cadence.clone(),
    };
    let input = pass.data_with(data, "/placement", &placement::expected());
    let extent = configuration.layout.map.to_array();
    let shape = descriptor::shape(layers).views(layers).view_layers(1).view_extent(extent);
    let placed = Placed { configuration, settings: Arc::new(settings.clone()) };
    described::node(pass, &settings.to, input, Some((shape, placed)), live)
}

#[derive(Clone, Debug, PartialEq)]
struct Placed {
    configuration: Configuration,
    settings: Arc<Cascades>,
}

impl DescribeShadows for Placed {
    fn lacks(&self, frame: &FrameInput) -> Option<NoBounds> {
        self.configuration.lacks_bounds(frame)
    }

    fn update(&mut self, settings: &mut LiveSettings<'_>) -> Option<()> {
        declare::update(&mut self.configuration, &self.settings, settings)
    }

    fn describe(&self, entry: &Entry, output: &mut ShadowOutput<'_>) {
        let Backing::Layers { first, count } = entry.backing else { return };
        let Some(light) = output.frame.lights.get(entry.light as usize) else { return };
        let set = self.configuration.fit_light(light, output.frame);
        let (of_light, first_texel) = (output.cadence, set.iter().next().map_or(1.0, |one| one.texel_size));
        for (at, cascade) in set.iter().take(count as usize).enumerate() {
            let layer = first + at as u32;
            let ratio = f64::from(of_light) * cascade.texel_size / first_texel;
            output.cadence = importance::cadence(ratio, output.longest);
            output.view(cascade.view.layer(layer));
            let size = descriptor::light_size(light, output.light_size, f64::INFINITY);
            output.descriptors.push(self.descriptor(at, layer, size, cascade));
            let place = output
                .filter
                .and_then(|filter| filter.in_cascade(at, cascade.texel_size, cascade.depth_range, size));
            output.bounded.add(entry.light, place);
        }
        for _ in set.count()..count as usize {
            output.descriptors.push(Descriptor::default());
        }
    }
}

impl Placed {
    fn descriptor(&self, at: usize, layer: u32, light_size: f64, cascade: &Cascade) -> Descriptor {
        let side = self.configuration.layout.tiles[at].resolution;
        let View { clip_from_world: clip, view_from_world: mut axes, .. } = cascade.view;
        // The rotation alone, so that the cascades of a light have the same axes.
        axes.w_axis = DVec4::W;
        let scale =
            DVec3::from_array([0, 1, 2].map(|row| clip.row(row).truncate().dot(axes.row(row).truncate())));
        let half_side = 0.5 * f64::from(side) * DVec2::new(1.0, -1.0);
        let offset = half_side * clip.w_axis.truncate().truncate() + half_side.abs();
        Descriptor {
            axes: descriptor::rows(&axes),
            texels: (half_side * scale.truncate()).extend(offset.x).extend(offset.y),
            bounds: descriptor::square(0, 0, side),
            depth: DVec4::new(clip.w_axis.z, scale.z, cascade.texel_size, light_size),
            reach: DVec2::new(cascade.slice.far, cascade.slice.blend_start),
            place: UVec2::new(layer, side),
        }
    }
}
