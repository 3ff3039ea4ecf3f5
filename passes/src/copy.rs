//! The node kinds `copy`: a texture or buffer, or a part of it, into another; and `clear`: zeros into a buffer.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_graph::diagnostic::codes;
use umbragraph_graph::language::Expr;
use umbragraph_graph::node::Node;
use umbragraph_graph::pipeline::{Part, PassBuilder, Produced, Usage};
use umbragraph_graph::work::{AttachmentTarget, BufferView, CopyWork, TransferEnd, TransferWork, Work};

/// Copies a texture or buffer, or a part of it, to another: texels to texels of the same size and format, bytes to as
/// many bytes. Between a texture and a buffer, texels lie in the buffer row by row, each row at a multiple of 256 bytes.
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
    /// The texture or buffer: a reference.
    pub name: String,
    /// Of a buffer the first byte (unit: bytes); 0 without it.
    #[serde(default)]
    pub offset: Option<Expr>,
    /// Of a buffer how many bytes (unit: bytes); all without it.
    #[serde(default)]
    pub size: Option<Expr>,
    /// The mip level; 0 without it.
    #[serde(default)]
    pub mip: Option<Expr>,
    /// The layer; without it all.
    #[serde(default)]
    pub layer: Option<Expr>,
}

impl Node for Copy {
    const NAME: &'static str = "copy";
    const SUMMARY: &'static str = "Copies a texture or buffer, or a part of it, to another.";

    fn declare(self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let source = end(pass, &self.from, Usage::CopySource, "/from");
        let destination = end(pass, &self.to, Usage::CopyDestination, "/to");
        let (source, destination) = (source?, destination?);
        let work = match (source, destination) {
            (TransferEnd::Texture(source), TransferEnd::Texture(destination)) => {
                Work::Copy(CopyWork { source, destination })
            }
            _ => Work::Transfer(TransferWork { source: Some(source), destination }),
        };
        Some(pass.produce(work))
    }
}

/// Fills a buffer, or bytes of one, with zeros.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Clear {
    /// The buffer: a reference.
    pub buffer: String,
    /// The first byte, a multiple of 4 (unit: bytes); 0 without it.
    #[serde(default)]
    pub offset: Option<Expr>,
    /// How many bytes, a multiple of 4 (unit: bytes); all without it.
    #[serde(default)]
    pub size: Option<Expr>,
}

impl Node for Clear {
    const NAME: &'static str = "clear";
    const SUMMARY: &'static str = "Fills a buffer with zeros.";

    fn declare(self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let ends = (self.offset.as_ref(), self.size.as_ref());
        let view = bytes_of(pass, &self.buffer, ends, Usage::CopyDestination, "", "/buffer")?;
        let destination = TransferEnd::Buffer(view);
        Some(pass.produce(Work::Transfer(TransferWork { source: None, destination })))
    }
}

fn bytes_of(
    pass: &mut PassBuilder<'_>,
    name: &str,
    (offset, size): (Option<&Expr>, Option<&Expr>),
    usage: Usage,
    at: &str,
    pointer: &str,
) -> Option<BufferView> {
    let bytes = pass.bytes(offset, size, at)?;
    if let Some(run) = bytes.filter(|run| run.first % 4 != 0 || run.count % 4 != 0) {
        let message = format!("{} bytes from byte {} are copied", run.count, run.first);
        pass.report(codes::DEVICE_RULE, at, message, "copies begin at, and have, multiples of 4 bytes");
        return None;
    }
    let resource = pass.buffer_part(name, bytes, usage, pointer)?;
    Some(BufferView { resource, bytes })
}

fn end(pass: &mut PassBuilder<'_>, settings: &CopyEnd, usage: Usage, at: &str) -> Option<TransferEnd> {
    if pass.is_buffer(&settings.name) {
        let ends = (settings.offset.as_ref(), settings.size.as_ref());
        let view = bytes_of(pass, &settings.name, ends, usage, at, &format!("{at}/name"))?;
        return Some(TransferEnd::Buffer(view));
    }
    for (key, value) in [("offset", &settings.offset), ("size", &settings.size)] {
        if value.is_some() {
            let message = format!("\"{}\" is no buffer, of which bytes could be copied", settings.name);
            pass.report(
                codes::WRONG_RESOURCE,
                &format!("{at}/{key}"),
                message,
                "choose \"mip\" and \"layer\"",
            );
            return None;
        }
    }
    let mip = match &settings.mip {
        Some(expr) => pass.count(expr, &format!("{at}/mip"))?,
        None => 0,
    };
    let layer = match &settings.layer {
        Some(expr) => Some(pass.count(expr, &format!("{at}/layer"))?),
        None => None,
    };
    let resource = pass.texture(&settings.name, Part::of(Some(mip), layer), usage, &format!("{at}/name"))?;
    Some(TransferEnd::Texture(AttachmentTarget { resource, mip, layer }))
}
