//! The node kind `compute`: a compute shader.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_graph::diagnostic::codes;
use umbragraph_graph::language::{Expr, Reference};
use umbragraph_graph::node::Node;
use umbragraph_graph::pipeline::{Bind, PassBuilder, Produced};
use umbragraph_graph::work::{ComputeWork, Deferred, Dispatch, Work};

/// Dispatches a compute shader: once for each texel of a texture, or so many workgroups.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Compute {
    /// The template.
    pub shader: String,
    /// Values for axes of the template; an axis that is not named takes the feature or parameter of its name.
    #[serde(default)]
    pub axes: BTreeMap<String, Expr>,
    /// What stands behind the shader's bindings.
    #[serde(default)]
    pub bind: BTreeMap<String, Bind>,
    /// The texture for each of whose texels (width, height, layers) there is an invocation; the shader guards against
    /// the rest of the last workgroups. One of the textures under "bind".
    #[serde(default)]
    pub over: Option<String>,
    /// The mip level whose size "over" means; 0 without it.
    #[serde(default)]
    pub mip: Option<Expr>,
    /// The number of workgroups in x, y and z, instead of "over".
    #[serde(default)]
    #[schemars(length(min = 3, max = 3))]
    pub workgroups: Option<Vec<Expr>>,
}

impl Node for Compute {
    const NAME: &'static str = "compute";
    const SUMMARY: &'static str = "Dispatches a compute shader.";

    fn declare(self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let program = pass.program(&self.shader, &self.axes, None, "");
        let bindings = program.and_then(|program| pass.bind(program, &self.bind, None, ""));
        let dispatch = match (&self.over, &self.workgroups) {
            (Some(over), None) => {
                let mip = match &self.mip {
                    Some(expr) => pass.count(expr, "/mip")?,
                    None => 0,
                };
                let name = Reference::parse(over).map_or(over.as_str(), |reference| reference.resource);
                let resource = pass.declared_texture(name, "/over");
                resource.map(|resource| Dispatch::Over { resource, mip })
            }
            (None, Some(counts)) => {
                let counts: Option<Vec<Deferred>> = counts
                    .iter()
                    .enumerate()
                    .map(|(at, expr)| pass.deferred(expr, &format!("/workgroups/{at}")))
                    .collect();
                counts.and_then(|counts| <[Deferred; 3]>::try_from(counts).ok()).map(Dispatch::Workgroups)
            }
            _ => {
                let help = "\"over\": a texture, or \"workgroups\": [x, y, z]";
                pass.report(codes::MISSING_KEY, "", "a compute pass says how often it runs in one way", help);
                None
            }
        };
        Some(pass.produce(Work::Compute(ComputeWork {
            program: program?,
            bindings: bindings?,
            dispatch: dispatch?,
        })))
    }
}
