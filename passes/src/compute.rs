//! The node kind `compute`: a compute shader.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::diagnostic::codes;
use umbragraph_pipeline::language::{Expr, Ref};
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{Evaluate, IndexRange, PassBuilder, Produced};
use umbragraph_pipeline::work::{
    BoundSlot, ComputeWork, Deferred, Dispatch, Live, ResourceHandle, SlotSource, Subresource, Work,
};

use crate::shader::ShaderSettings;

/// Dispatches a compute shader: one invocation for each texel of a texture, or a number of workgroups.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Compute {
    /// The shader template with its axes, bindings and entry points.
    #[serde(flatten)]
    pub shader: ShaderSettings,
    /// A texture under "bind"; each of its texels (width, height, layers) gets an invocation. The shader guards against
    /// the surplus invocations of the last workgroups.
    pub dispatch_over: Option<Ref>,
    /// The mip level of the texture of "dispatch_over" whose size counts; 0 by default.
    pub mip: Option<Expr>,
    /// A buffer with the number of workgroups, instead of "dispatch_over": three u32 for x, y and z.
    pub indirect: Option<IndirectSettings>,
    /// The number of workgroups in x, y and z, instead of "dispatch_over".
    #[schemars(length(min = 3, max = 3))]
    pub workgroups: Option<Vec<Expr>>,
}

/// A buffer with the arguments of an indirect draw or dispatch, written by an earlier pass.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IndirectSettings {
    /// The buffer: a reference.
    pub buffer: Ref,
    /// The first byte of the arguments, a multiple of 4 (unit: bytes); 0 by default.
    pub offset: Option<Expr>,
}

impl IndirectSettings {
    /// Declares the byte range of the buffer that holds this number of 32-bit words.
    pub(crate) fn declare(&self, pass: &mut PassBuilder<'_>, words: u64) -> Option<Subresource> {
        let offset = pass.count_or(&self.offset, "/indirect/offset", 0)?;
        if offset % 4 != 0 {
            let message = format!("counts begin at byte {offset}");
            return pass.reject(codes::DEVICE_RULE, "/indirect/offset", message, "begin at a multiple of 4");
        }
        let bytes = Some(IndexRange { first: u64::from(offset), count: 4 * words });
        pass.buffer_range(&self.buffer, bytes, "/indirect/buffer")
    }
}

/// Warns of a pass that writes storage textures, but runs for the texels of a texture that it does not bind. Passes that
/// write buffers alone can run for a texture whose size is all that counts.
fn warn_of_unbound(pass: &mut PassBuilder<'_>, over: ResourceHandle, bindings: &[BoundSlot]) {
    let textures = || {
        bindings.iter().filter_map(|slot| match &slot.source {
            SlotSource::Texture(bound) => Some((slot, bound)),
            _ => None,
        })
    };
    let written = textures().find(|(_, bound)| bound.usage.writes());
    let Some((slot, _)) = written.filter(|_| !textures().any(|(_, bound)| bound.texture.resource == over))
    else {
        return;
    };
    let message =
        format!("\"{}\" runs for each texel of a texture that is not under its \"bind\"", pass.name());
    let help = format!(
        "name the texture that is written, which is bound to \"{}\"; say the number with \"workgroups\" if it is another \
         one on purpose",
        slot.name
    );
    pass.warn(codes::DISPATCH, "/dispatch_over", message, help);
}

impl Node for Compute {
    const NAME: &'static str = "compute";
    const SUMMARY: &'static str = "Dispatches a compute shader.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let (program, bindings) = self.shader.declare(pass, None);
        let dispatch = match (&self.dispatch_over, &self.workgroups, &self.indirect) {
            (None, None, Some(settings)) => settings.declare(pass, 3).map(Dispatch::Indirect),
            (Some(over), None, None) => {
                let mip = pass.count_or(&self.mip, "/mip", 0)?;
                let resource = pass.declared_texture(over, "/dispatch_over");
                if let (Some(resource), Some(bindings)) = (resource, &bindings) {
                    warn_of_unbound(pass, resource, bindings);
                }
                resource.map(|resource| Dispatch::Over { resource, mip })
            }
            (None, Some(counts), None) => {
                let counts: Option<Vec<Live<Deferred>>> = counts
                    .iter()
                    .enumerate()
                    .map(|(at, expr)| pass.live_deferred(expr, &format!("/workgroups/{at}")))
                    .collect();
                counts.and_then(|counts| <[_; 3]>::try_from(counts).ok()).map(Dispatch::Workgroups)
            }
            (None, None, None) => {
                let help = "add \"dispatch_over\": a texture, or \"workgroups\": [x, y, z], or \"indirect\": a buffer";
                pass.reject(codes::MISSING_KEY, "", "the pass does not say how often it runs", help)
            }
            (over, counts, _) => {
                let (first, second) = match (over, counts) {
                    (Some(_), Some(_)) => ("dispatch_over", "workgroups"),
                    (Some(_), None) => ("dispatch_over", "indirect"),
                    _ => ("workgroups", "indirect"),
                };
                let message = format!("\"{first}\" and \"{second}\" exclude one another");
                pass.reject(codes::UNKNOWN_KEY, &format!("/{second}"), message, "remove one of the two")
            }
        };
        pass.produce(Work::Compute(Box::new(ComputeWork {
            program: program?,
            bindings: bindings?,
            dispatch: dispatch?,
        })))
    }
}
