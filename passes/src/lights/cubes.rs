//! The node kind `cube_shadows`: six views and a descriptor for each point light that has a cube.
//!
//! The views are those of [`crate::views::cube`], which mirror what they show: fronts become backs, so casters are
//! drawn without culling. Face f of slot s is layer 6·s + f of the array. A shader finds the depth of a point from the
//! distance along the axis of its face alone ([`depth_coefficients`]).
//!
//! Limits: a light that has no views leaves a descriptor that shadows nothing.

use glam::{DMat4, DVec2, DVec4, UVec2};
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::DataShape;
use umbragraph_pipeline::language::Expr;
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{PassBuilder, Produced};

use super::described::{DescribeShadows, DescribedSettings, ShadowOutput};
use super::descriptor::{self, Descriptor};
use super::placement::{self, Backing, Entry};
use crate::views::cube::{CubeViews, Face};
use crate::views::depth_coefficients;

/// The border on each side of a face, in texels beyond its 90°. Bilinear filtering at the edge of a face then finds all
/// four texels.
const BORDER: f64 = 1.0;

/// Publishes six views and a shadow descriptor for each point light with a cube for its shadow maps.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CubeShadows {
    /// The maximum number of point lights with shadows, 1 to 341.
    pub capacity: Expr,
    /// The width and height of each face, in texels.
    pub side: Expr,
    /// The settings that `spot_shadows` and `cube_shadows` have in common.
    #[serde(flatten)]
    pub described: DescribedSettings,
}

impl Node for CubeShadows {
    const NAME: &'static str = "cube_shadows";
    const SUMMARY: &'static str =
        "Publishes six views and a descriptor for each point light that has a cube.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let capacity = placement::capacity(pass, &self.capacity, "/capacity", placement::MAX_CUBES);
        let side = placement::capacity(pass, &self.side, "/side", crate::cascades::layout::MAX_SIDE);
        self.described.declare(pass, capacity.zip(side), |(capacity, side), reverse| {
            let shape = descriptor::shape(capacity).views(6 * capacity).view_layers(1);
            (shape, Cubes { side, reverse })
        })
    }

    fn published() -> Vec<(&'static str, DataShape)> {
        vec![("", descriptor::shape(1))]
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Cubes {
    side: u32,
    reverse: bool,
}

impl DescribeShadows for Cubes {
    fn describe(&self, entry: &Entry, output: &mut ShadowOutput<'_>) {
        let Backing::Cube { slot } = entry.backing else { return };
        let light = output.frame.lights.get(entry.light as usize);
        let border = BORDER / f64::from(self.side);
        let cube = light.and_then(|light| Some((light, CubeViews::new(light, border, self.reverse)?)));
        let Some((light, cube)) = cube else {
            output.descriptors.push(Descriptor::default());
            return;
        };
        for face in Face::ALL {
            output.view(cube.view(face, 6 * slot + face as u32, None));
        }
        let half_side = 0.5 * f64::from(self.side);
        let texel = cube.half_width / half_side;
        let size = descriptor::light_size(light, output.light_size, cube.far);
        output.bounded_in_perspective(entry.light, cube.position, [cube.near, cube.far], texel, size);
        let depth = depth_coefficients(cube.near, cube.far, self.reverse);
        let scale = half_side / cube.half_width;
        output.descriptors.push(Descriptor {
            axes: descriptor::rows(&DMat4::from_translation(-cube.position)),
            texels: DVec4::new(scale, scale, half_side, half_side),
            bounds: descriptor::square(0, 0, self.side),
            depth: depth.extend(texel).extend(size),
            reach: DVec2::new(cube.far, cube.near),
            place: UVec2::new(6 * slot, self.side),
        });
    }
}
