//! The shader of a pass and what it binds, shared by the node kinds that run one.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::language::{AnyExpr, Expr};
use umbragraph_pipeline::pipeline::{Bind, PassBuilder};
use umbragraph_pipeline::shader::Stage;
use umbragraph_pipeline::work::{BoundSlot, ProgramHandle};

/// The shader of a pass: its template, axis values, bindings and entry points.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct ShaderSettings {
    /// The name of the shader template.
    pub shader: String,
    /// The values of the template's axes by name. An axis without a value here takes the feature or parameter of the
    /// same name.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, AnyExpr>")]
    pub axes: BTreeMap<String, Expr>,
    /// Resources and values for the shader's bindings, by name. A pass that draws the host's meshes sets groups 0 and 1
    /// only, and its block "view" holds the view being drawn.
    #[serde(default)]
    pub bind: BTreeMap<String, Bind>,
    /// The names of the entry points, needed for a stage with several of them.
    pub entry_points: Option<EntryPointSettings>,
}

/// The names of entry points; each is needed only if the template has several for the stage.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EntryPointSettings {
    /// The entry point of the vertex stage.
    pub vertex: Option<String>,
    /// The entry point of the fragment stage.
    pub fragment: Option<String>,
    /// The entry point of the compute stage.
    pub compute: Option<String>,
}

impl ShaderSettings {
    /// Declares the program and its bindings. `geometry` names the contract of the host's draws; `None` if the pass
    /// draws none. A `None` result follows a diagnostic.
    pub(crate) fn declare(
        &self,
        pass: &mut PassBuilder<'_>,
        geometry: Option<&str>,
    ) -> (Option<ProgramHandle>, Option<Vec<BoundSlot>>) {
        let named = self.entry_points.clone().unwrap_or_default();
        let named = [
            (Stage::Vertex, named.vertex),
            (Stage::Fragment, named.fragment),
            (Stage::Compute, named.compute),
        ];
        let named = named.into_iter().filter_map(|(stage, name)| Some((stage, name?))).collect();
        let program = pass.program(&self.shader, &self.axes, geometry, &named, "");
        (program, program.and_then(|program| pass.bind(program, &self.bind, geometry, "")))
    }
}
