//! Workgroup counts of compute passes.

use crate::resources::resolved::ResolvedResources;
use umbragraph_pipeline::diagnostic::{Diagnostic, Place, codes, shorten};
use umbragraph_pipeline::expression::Value;
use umbragraph_pipeline::pipeline::{Located as _, whole_number};
use umbragraph_pipeline::shader::Stage;
use umbragraph_pipeline::work::{ComputeWork, Dispatch, Live, PassHandle};

/// Converts a value to a number of workgroups.
///
/// # Errors
/// Returns a diagnostic without a place if the value is not a whole number from 0 to `limit`.
pub(crate) fn count(value: &Value, limit: u32) -> Result<u32, Diagnostic> {
    whole_number(value, 0..=limit).ok_or_else(|| {
        let message = format!("{} is not a workgroup count", shorten(&value.to_string()));
        Diagnostic::error(codes::DISPATCH, Place::Nowhere, message)
            .help(format!("whole numbers from 0 to {limit} are possible; ceil() rounds up"))
    })
}

/// Returns the workgroup counts of a compute pass in x, y and z; `None` after a diagnostic, or for an indirect
/// dispatch.
pub(crate) fn workgroups(
    resolved: &ResolvedResources<'_>,
    compute: &ComputeWork,
    handle: PassHandle,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<[u32; 3]> {
    let pipeline = resolved.pipeline;
    let limit = pipeline.profile.limits.max_compute_workgroups_per_dimension;
    let counts = match &compute.dispatch {
        Dispatch::Indirect { .. } => return None,
        Dispatch::Over { resource, mip } => {
            let size = resolved.sizes.texture(*resource)?;
            let entry = pipeline.program(compute.program).variants.first()?.entry_point(Stage::Compute)?;
            let [x, y, z] = entry.workgroup_size.map(|side| side.max(1));
            let side = |length: u32| (length >> mip.min(&31)).max(1);
            let volume = resolved.texture(*resource).is_some_and(|texture| texture.volume);
            let layers = if volume { side(size.layers) } else { size.layers };
            [side(size.width).div_ceil(x), side(size.height).div_ceil(y), layers.div_ceil(z)]
        }
        Dispatch::Workgroups(expressions) => {
            let mut counts = [0; 3];
            let mut zero = None;
            for (count, Live { value: deferred, .. }) in counts.iter_mut().zip(expressions) {
                let value = resolved.sizes.value(deferred)?;
                let found = self::count(&value, limit).map_err(|diagnostic| {
                    diagnostics.push(diagnostic.at(deferred.place, &deferred.pointer));
                });
                *count = found.ok()?;
                zero = zero.or((*count == 0).then_some(deferred));
            }
            // A parameter of the frame may make it more than none.
            let is_fixed = expressions.iter().all(|Live { setting, .. }| setting.is_none());
            if let Some(deferred) = zero.filter(|_| is_fixed) {
                let name = &pipeline.pass(handle).name;
                let [x, y, z] = counts;
                let message = format!("\"{name}\" dispatches {x} × {y} × {z} workgroups, so it does nothing");
                let help = "round up, as in \"=ceil(viewport.width / 8)\"; or say \"when\", for frames without the pass";
                let warning = Diagnostic::warning(codes::DISPATCH, deferred.place, message);
                diagnostics.push(warning.pointer(&deferred.pointer).help(help));
            }
            counts
        }
    };
    if counts.iter().any(|count| *count > limit) {
        let (profile, name) = (&pipeline.profile.name, &pipeline.pass(handle).name);
        let (message, help) = match limit {
            0 => (
                format!("\"{name}\" is a compute pass, and the profile {profile} has no compute shaders"),
                "give the pass a \"when\" with a feature that has \"required_limits\", or leave the profile out"
                    .to_owned(),
            ),
            _ => (
                format!("{counts:?} workgroups are too many"),
                format!("the profile {profile} allows {limit} in each direction"),
            ),
        };
        diagnostics.push(pipeline.pass(handle).error(codes::DISPATCH, message).help(help));
        return None;
    }
    Some(counts)
}
