//! Draw filters of passes: the words that a pipeline may write under `filter`.
//!
//! `all`, `opaque` (alpha-masked ones included) and `transparent` (alpha mode `BLEND`) select visible draws, `moving` the
//! opaque ones that an animation can move; `casters`, `static_casters` and `dynamic_casters` are for shadow maps. Transparent draws cast no shadows, and are always issued
//! back to front, in passes of any order. A pipeline without a pass for them omits them; [`left_out`] counts them in a
//! warning.

use std::collections::BTreeSet;
use umbragraph_compiler::Plan;
use umbragraph_pipeline::diagnostic::{Diagnostic, Severity};

use crate::codes;
use crate::interface::GEOMETRY;
use crate::material::AlphaMode;
use crate::scene::{Draw, Scene};

/// The names of all draw filters that a pass may have as its `filter` in a pipeline file.
pub const FILTERS: &[&str] =
    &["all", "opaque", "transparent", "moving", "casters", "static_casters", "dynamic_casters"];

/// Returns `true` if a pass with this filter draws `draw`. Returns `false` for a filter that is not in [`FILTERS`].
pub fn wants(filter: &str, scene: &Scene, draw: Draw) -> bool {
    wants_draw(filter, draw, scene.material(draw).alpha_mode == AlphaMode::Blend)
}

/// Returns `true` if a pass with this filter draws `draw`. `is_blended` is `true` if the material of the draw has alpha
/// mode `BLEND`.
pub(crate) fn wants_draw(filter: &str, draw: Draw, is_blended: bool) -> bool {
    match filter {
        "all" => true,
        "opaque" => !is_blended,
        "transparent" => is_blended,
        "moving" => draw.dynamic && !is_blended,
        "casters" => draw.cast_shadow,
        "static_casters" => draw.cast_shadow && !draw.dynamic,
        "dynamic_casters" => draw.cast_shadow && draw.dynamic,
        _ => false,
    }
}

/// A warning with the number of transparent draws that no pass of the plan draws. `None` if every transparent draw is
/// drawn, or if no pass of the plan draws the scene.
pub fn left_out(scene: &Scene, plan: &Plan) -> Option<Diagnostic> {
    let filters: BTreeSet<&str> = plan
        .passes
        .iter()
        .filter_map(|planned| plan.pipeline.pass(planned.handle).work().scene())
        .filter(|draw| draw.geometry == GEOMETRY)
        .map(|draw| draw.filter.as_str())
        .collect();
    let is_drawn = |draw: Draw| filters.iter().any(|filter| wants(filter, scene, draw));
    let is_blended = |draw: Draw| scene.material(draw).alpha_mode == AlphaMode::Blend;
    let count = scene.draws().filter(|draw| is_blended(*draw) && !is_drawn(*draw)).count();
    if filters.is_empty() || count == 0 {
        return None;
    }
    let (draws, are) = if count == 1 { ("draw", "is") } else { ("draws", "are") };
    let message = format!(
        "{count} transparent {draws} {are} left out: no pass of the pipeline has the filter \"transparent\" or \"all\""
    );
    let diagnostic = Diagnostic::in_file(codes::LEFT_OUT, &*scene.name, "", message)
        .help("add a pass that blends over the opaque ones, or use a pipeline that has one");
    Some(diagnostic.severity(Severity::Warning))
}
