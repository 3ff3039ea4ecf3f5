//! The node kinds `copy`: a texture or buffer, or a subresource range of it, into another; and `clear`: zeros into a
//! buffer.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::diagnostic::codes;
use umbragraph_pipeline::language::{Expr, Ref, Word};
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{
    Contents, Evaluate, IndexRange, PassBuilder, Produced, SubresourceRange, SubresourceRangeSettings, Usage,
};
use umbragraph_pipeline::work::{
    BufferRegion, Deferred, Subresource, TextureRegion, TransferEnd, TransferWork, Work,
};

use crate::if_said::if_said;

/// Copies a texture or buffer, or a subresource range of one, to another: texels to texels of the same extent and
/// format, or bytes to as many bytes. In a copy between a texture and a buffer, texels lie in the buffer row by row,
/// layer by layer, mip level by mip level. Each row begins at a multiple of 256 bytes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Copy {
    /// The source of the copy.
    pub from: CopyEnd,
    /// The destination of the copy.
    pub to: CopyEnd,
    /// The width and height of the copied box (unit: texels); by default up to the end of the mip level.
    #[schemars(length(min = 2, max = 2))]
    pub extent: Option<Vec<Expr>>,
}

/// The source or the destination of a copy.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CopyEnd {
    /// The texture or buffer: a reference.
    pub name: Ref,
    /// The first byte of a buffer (unit: bytes); 0 by default.
    pub offset: Option<Expr>,
    /// The number of bytes of a buffer (unit: bytes); by default all.
    pub size: Option<Expr>,
    /// The bytes of a buffer from one row of texels to the next, a multiple of 256 (unit: bytes); by default as few as
    /// possible.
    pub bytes_per_row: Option<Expr>,
    /// The rows of a buffer from one layer of texels to the next; by default as few as possible.
    pub rows_per_image: Option<Expr>,
    /// The subresource range of a texture: mip levels, layers, face and aspect.
    #[serde(flatten)]
    pub range: SubresourceRangeSettings,
    /// The first texel of a texture that is copied, from the left and from the top (unit: texels); [0, 0] by default.
    #[schemars(length(min = 2, max = 2))]
    pub origin: Option<Vec<Expr>>,
    /// The treatment of the destination's earlier contents around the copied box or between rows: "load" keeps them,
    /// "discard" leaves them undefined. By default a copy to a box of a texture ("origin" or "extent") loads. A copy of
    /// texels to a buffer keeps the bytes between and after the rows, unless numbers in the document show that the
    /// texels fill all bytes. Other copies discard.
    pub contents: Option<Word<Contents>>,
}

impl Node for Copy {
    const NAME: &'static str = "copy";
    const SUMMARY: &'static str = "Copies a texture or buffer, or a subresource range of it, to another.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let ends = [(&self.from, "/from"), (&self.to, "/to")];
        let buffers = ends.map(|(settings, _)| pass.is_buffer(&settings.name));
        let bytes = buffers == [true, true];
        let extent = if_said(&self.extent, |exprs| two(pass, exprs, "/extent"));
        if bytes && self.extent.is_some() {
            let help = "remove \"extent\"; \"size\" is the number of bytes that are copied";
            let message =
                "\"extent\" is set, but \"from\" and \"to\" are buffers, which have no width and height";
            pass.report(codes::WRONG_RESOURCE, "/extent", message, help);
        }
        let range = !buffers[1] && (self.extent.is_some() || self.to.origin.is_some());
        if self.from.contents.is_some() {
            let help = "remove \"contents\", which says whether what is copied to needs what was there";
            let message =
                format!("\"contents\" is set for \"{}\", which the copy only reads", self.from.name);
            return pass.reject(codes::WRONG_RESOURCE, "/from/contents", message, help);
        }
        let contents = match &self.to.contents {
            Some(word) => Some(pass.word(word, "/to/contents")?),
            None => range.then_some(Contents::Load),
        };
        let end = |pass: &mut PassBuilder<'_>, (settings, at): (&CopyEnd, &str)| {
            if pass.is_buffer(&settings.name) {
                buffer_end(pass, settings, bytes, at)
            } else {
                texture_end(pass, settings, self.extent.is_some(), at)
            }
        };
        let (source, destination) = (end(pass, ends[0]), end(pass, ends[1]));
        let written = match (contents, &source) {
            (Some(Contents::Load), _) => Usage::CopyDestinationLoad,
            (None, Some(TransferEnd::Texture(texture))) if buffers[1] && !self.fills(pass, texture) => {
                Usage::CopyDestinationRows
            }
            _ => Usage::CopyDestination,
        };
        let (extent, source, destination) =
            (extent.filter(|one| one.is_none() || !bytes)?, source?, destination?);
        let source = Some(source);
        pass.produce(Work::Transfer(Box::new(TransferWork { source, destination, written, extent })))
    }
}

impl Copy {
    /// Returns `true` if the copied texels surely fill all bytes of the destination buffer, without gaps between rows.
    fn fills(&self, pass: &mut PassBuilder<'_>, texture: &TextureRegion) -> bool {
        let said = |expr: &Option<Expr>| expr.as_ref().and_then(|expr| expr.0.as_u64());
        let says_more = [&self.to.offset, &self.to.bytes_per_row, &self.to.rows_per_image]
            .iter()
            .any(|one| one.is_some());
        let held = match &self.to.size {
            Some(_) => said(&self.to.size),
            None => pass.declared_bytes(&self.to.name),
        };
        !says_more && self.extent.is_none() && held.is_some() && held == pass.bytes_of_full_rows(texture)
    }
}

/// Fills a buffer, or a range of its bytes, with zeros.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Clear {
    /// The buffer: a reference.
    pub buffer: Ref,
    /// The first byte, a multiple of 4 (unit: bytes); 0 by default.
    pub offset: Option<Expr>,
    /// The number of bytes, a multiple of 4 (unit: bytes); by default all.
    pub size: Option<Expr>,
}

impl Node for Clear {
    const NAME: &'static str = "clear";
    const SUMMARY: &'static str = "Fills a buffer with zeros.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let ends = (self.offset.as_ref(), self.size.as_ref());
        let buffer = bytes_of(pass, &self.buffer, ends, true, "", "/buffer")?;
        let region = BufferRegion { buffer, bytes_per_row: None, rows_per_image: None };
        let (destination, written) = (TransferEnd::Buffer(region), Usage::CopyDestination);
        let transfer = TransferWork { source: None, destination, written, extent: None };
        pass.produce(Work::Transfer(Box::new(transfer)))
    }
}

fn bytes_of(
    pass: &mut PassBuilder<'_>,
    name: &Ref,
    (offset, size): (Option<&Expr>, Option<&Expr>),
    words: bool,
    at: &str,
    pointer: &str,
) -> Option<Subresource> {
    let bytes = pass.bytes(offset, size, at)?;
    if let Some(run) = bytes.filter(|run| words && (run.first % 4 != 0 || run.count % 4 != 0)) {
        let (key, value) = if run.first % 4 == 0 { ("size", run.count) } else { ("offset", run.first) };
        let message = format!("\"{key}\" is {value} bytes, no multiple of 4");
        let help = "copies of bytes begin at multiples of 4, and have multiples of 4";
        return pass.reject(codes::DEVICE_RULE, &format!("{at}/{key}"), message, help);
    }
    pass.buffer_range(name, bytes, pointer)
}

/// Reports each key that is set although it does not apply to the kind of resource; returns `None` if there is one.
fn foreign(
    pass: &mut PassBuilder<'_>,
    keys: &[(&str, bool)],
    message: &str,
    help: &str,
    at: &str,
) -> Option<()> {
    let said: Vec<&str> = keys.iter().filter(|(_, said)| *said).map(|(key, _)| *key).collect();
    for key in &said {
        pass.report(codes::WRONG_RESOURCE, &format!("{at}/{key}"), message, help);
    }
    said.is_empty().then_some(())
}

/// Declares the buffer end of a copy. `bytes` is `true` if the other end is a buffer too, so that there are no rows.
fn buffer_end(pass: &mut PassBuilder<'_>, settings: &CopyEnd, bytes: bool, at: &str) -> Option<TransferEnd> {
    let keys = [
        ("mip", settings.range.mip.is_some()),
        ("mips", settings.range.mips.is_some()),
        ("layer", settings.range.layer.is_some()),
        ("layers", settings.range.layers.is_some()),
        ("face", settings.range.face.is_some()),
        ("aspect", settings.range.aspect.is_some()),
        ("origin", settings.origin.is_some()),
    ];
    let message =
        format!("\"{}\" is not a texture, of which a subresource range could be copied", settings.name);
    let textures = foreign(pass, &keys, &message, "choose \"offset\" and \"size\"", at);
    let keys = [
        ("bytes_per_row", bytes && settings.bytes_per_row.is_some()),
        ("rows_per_image", bytes && settings.rows_per_image.is_some()),
    ];
    let help = "remove it; only a buffer whose other end is a texture has rows";
    let rows = foreign(pass, &keys, "\"from\" and \"to\" are buffers, so that no rows are copied", help, at);
    textures.and(rows)?;
    let bytes_per_row = pass.count_if(&settings.bytes_per_row, format_args!("{at}/bytes_per_row"))?;
    let rows_per_image = pass.count_if(&settings.rows_per_image, format_args!("{at}/rows_per_image"))?;
    if let Some(bytes) = bytes_per_row.filter(|bytes| bytes % 256 != 0) {
        let message = format!("\"bytes_per_row\" is {bytes} bytes, no multiple of 256");
        let help = "choose a multiple of 256";
        return pass.reject(codes::DEVICE_RULE, &format!("{at}/bytes_per_row"), message, help);
    }
    let ends = (settings.offset.as_ref(), settings.size.as_ref());
    let buffer = bytes_of(pass, &settings.name, ends, bytes, at, &format!("{at}/name"))?;
    Some(TransferEnd::Buffer(BufferRegion { buffer, bytes_per_row, rows_per_image }))
}

/// Evaluates two expressions, which may name sizes; the JSON Schema requires exactly two.
fn two(pass: &mut PassBuilder<'_>, exprs: &[Expr], at: &str) -> Option<[Deferred; 2]> {
    let all = exprs.iter().enumerate().map(|(index, expr)| pass.deferred(expr, &format!("{at}/{index}")));
    all.collect::<Option<Vec<Deferred>>>()?.try_into().ok()
}

/// Declares the texture end of a copy. `boxed` is `true` if the copy has an extent.
fn texture_end(pass: &mut PassBuilder<'_>, settings: &CopyEnd, boxed: bool, at: &str) -> Option<TransferEnd> {
    let keys = [
        ("offset", settings.offset.is_some()),
        ("size", settings.size.is_some()),
        ("bytes_per_row", settings.bytes_per_row.is_some()),
        ("rows_per_image", settings.rows_per_image.is_some()),
    ];
    let message = format!("\"{}\" is not a buffer, of which bytes could be copied", settings.name);
    foreign(pass, &keys, &message, "choose \"mip\", \"layer\", \"origin\" and \"extent\"", at)?;
    let range = pass.subresource_range(&settings.range, at)?;
    let mip = range.mip.unwrap_or(IndexRange::one(0));
    if mip.count > 1 && (boxed || settings.origin.is_some()) {
        let help = "remove \"mips\", and let a copy for each mip level follow";
        let message = format!(
            "\"mips\" is {}, but \"origin\" and \"extent\" choose texels of one mip level",
            mip.count
        );
        return pass.reject(codes::DEVICE_RULE, &format!("{at}/mips"), message, help);
    }
    let origin = if_said(&settings.origin, |exprs| two(pass, exprs, &format!("{at}/origin")))?;
    let texture =
        pass.texture(&settings.name, SubresourceRange { mip: Some(mip), ..range }, &format!("{at}/name"))?;
    Some(TransferEnd::Texture(TextureRegion { texture, origin }))
}
