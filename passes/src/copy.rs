//! The node kind `copy`: one texture, or a part of it, into another.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_graph::language::Expr;
use umbragraph_graph::node::Node;
use umbragraph_graph::pipeline::{Part, PassBuilder, Produced, Usage};
use umbragraph_graph::work::{AttachmentTarget, CopyWork, Work};

/// Copies a texture, or a part of it, to another of the same size and format.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Copy {
    /// From where.
    pub from: CopyEnd,
    /// To where.
    pub to: CopyEnd,
}

/// One end of a copy.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CopyEnd {
    /// The texture: a reference.
    pub name: String,
    /// The mip level; 0 without it.
    #[serde(default)]
    pub mip: Option<Expr>,
    /// The layer; without it all.
    #[serde(default)]
    pub layer: Option<Expr>,
}

impl Node for Copy {
    const NAME: &'static str = "copy";
    const SUMMARY: &'static str = "Copies a texture, or a part of it, to another.";

    fn declare(self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let source = end(pass, &self.from, Usage::CopySource, "/from");
        let destination = end(pass, &self.to, Usage::CopyDestination, "/to");
        Some(pass.produce(Work::Copy(CopyWork { source: source?, destination: destination? })))
    }
}

fn end(pass: &mut PassBuilder<'_>, settings: &CopyEnd, usage: Usage, at: &str) -> Option<AttachmentTarget> {
    let mip = match &settings.mip {
        Some(expr) => pass.count(expr, &format!("{at}/mip"))?,
        None => 0,
    };
    let layer = match &settings.layer {
        Some(expr) => Some(pass.count(expr, &format!("{at}/layer"))?),
        None => None,
    };
    let resource = pass.texture(&settings.name, Part::of(Some(mip), layer), usage, &format!("{at}/name"))?;
    Some(AttachmentTarget { resource, mip, layer })
}
