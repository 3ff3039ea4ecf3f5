//! Copies of a transfer on the device: boxes of texels and ranges of bytes, one for each mip level.
//!
//! A transfer says subresource ranges and expressions; here they become numbers, and what WebGPU does not copy becomes
//! a diagnostic. Textures are copied to textures of the same format (but for `-srgb`), sample count and extent, all
//! aspects at once; to and from buffers one aspect of one that has bytes. Texels of several samples and those of depth
//! and stencil are copied by whole layers, and compressed ones by whole blocks. A texture is not copied onto itself,
//! nor a volume's mip level or a buffer onto another subresource range of the same.
//!
//! Texels lie in a buffer row by row, layer by layer, mip level by mip level: each row at a multiple of 256 bytes, and
//! each mip level at the end of the last row before it.
//!
//! Cost: linear in mip levels; between volumes and layers of others linear in layers.

use serde::Serialize;
use wgpu_types::{COPY_BUFFER_ALIGNMENT, COPY_BYTES_PER_ROW_ALIGNMENT, TextureAspect, TextureFormat};

use crate::regions::{Runs, joined};
use crate::resources::resolved::{ResolvedResources, TextureProperties};
use umbragraph_pipeline::diagnostic::{Diagnostic, codes};
use umbragraph_pipeline::language::format_name;
use umbragraph_pipeline::pipeline::{Aspect, Located as _, Pass, whole_number};
use umbragraph_pipeline::work::{
    BufferRegion, Deferred, PassHandle, ResourceHandle, TextureRegion, TransferEnd, TransferWork, Work,
};

/// One copy or clear command of a planned transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PlannedCopy {
    /// Fills bytes of a buffer with zeros.
    Clear {
        /// The offset in bytes of the first cleared byte.
        offset: u64,
        /// The number of bytes to clear.
        bytes: u64,
    },
    /// Copies bytes from one buffer to another.
    Bytes {
        /// The byte offset in the source.
        from: u64,
        /// The byte offset in the destination.
        to: u64,
        /// The number of bytes to copy.
        bytes: u64,
    },
    /// Copies texels from one texture to another.
    Texels {
        /// The first texel in the source.
        from: TexelOrigin,
        /// The first texel in the destination.
        to: TexelOrigin,
        /// The width and height in texels, and the number of layers or depth slices.
        extent: [u32; 3],
    },
    /// Copies texels from a buffer to a texture.
    Upload {
        /// The layout of the texels in the source buffer.
        from: TexelRows,
        /// The first texel in the destination.
        to: TexelOrigin,
        /// The width and height in texels, and the number of layers or depth slices.
        extent: [u32; 3],
    },
    /// Copies texels from a texture to a buffer.
    Download {
        /// The first texel in the source.
        from: TexelOrigin,
        /// The layout of the texels in the destination buffer.
        to: TexelRows,
        /// The width and height in texels, and the number of layers or depth slices.
        extent: [u32; 3],
    },
}

/// The first texel of a copied box in a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct TexelOrigin {
    /// The mip level.
    pub mip: u32,
    /// The x and y offsets from the top left in texels, and the index of the layer or depth slice.
    pub at: [u32; 3],
    /// The aspect of the texture: all, depth only or stencil only.
    pub aspect: Aspect,
}

/// The layout of texel rows in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct TexelRows {
    /// The byte offset of the first texel in the buffer.
    pub offset: u64,
    /// The distance between rows in bytes.
    pub bytes_per_row: u32,
    /// The distance between layers or depth slices in rows.
    pub rows_per_image: u32,
}

/// Returns the copy commands of a transfer; `None` if the transfer is invalid.
pub(crate) fn copies(
    resolved: &ResolvedResources<'_>,
    transfer: &TransferWork,
    handle: PassHandle,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Vec<PlannedCopy>> {
    use TransferEnd::{Buffer, Texture};
    let mut copies = Copies { resolved, pass: resolved.pipeline.pass(handle), diagnostics };
    match (&transfer.source, &transfer.destination) {
        (None, Buffer(to)) => {
            let (offset, bytes) = copies.run(to)?;
            Some(vec![PlannedCopy::Clear { offset, bytes }])
        }
        (None, Texture(_)) => None,
        (Some(Buffer(from)), Buffer(to)) => copies.bytes(from, to).map(|copy| vec![copy]),
        (Some(Texture(from)), Texture(to)) => copies.texels(from, to, transfer.extent.as_ref()),
        (Some(Buffer(from)), Texture(to)) => {
            let boxes = copies.rows(to, from, transfer.extent.as_ref(), true)?;
            let copy = |(to, from, extent)| PlannedCopy::Upload { from, to, extent };
            Some(boxes.into_iter().map(copy).collect())
        }
        (Some(Texture(from)), Buffer(to)) => {
            let boxes = copies.rows(from, to, transfer.extent.as_ref(), false)?;
            let copy = |(from, to, extent)| PlannedCopy::Download { from, to, extent };
            Some(boxes.into_iter().map(copy).collect())
        }
    }
}

/// The maximum number of texel rows in one copy command whose byte ranges are distinguished.
const MAXIMUM_RUNS: u64 = 1 << 16;

/// Returns the byte ranges that the rows of a texture-buffer copy occupy in the buffer. `None` for other passes and
/// invalid copies, or if there are too many rows.
pub(crate) fn runs_of_rows(resolved: &ResolvedResources<'_>, handle: PassHandle) -> Option<Runs> {
    let Work::Transfer(transfer) = resolved.pipeline.pass(handle).work() else { return None };
    let texture = match (transfer.source.as_ref()?, &transfer.destination) {
        (TransferEnd::Texture(texture), TransferEnd::Buffer(_))
        | (TransferEnd::Buffer(_), TransferEnd::Texture(texture)) => texture,
        _ => return None,
    };
    let format = resolved.texture(texture.texture.resource)?.format;
    let (block_width, block_height) = format.block_dimensions();
    let mut runs = Runs::new();
    for copy in copies(resolved, transfer, handle, &mut Vec::new())? {
        let (rows, texels, [width, height, layers]) = match copy {
            PlannedCopy::Download { from, to, extent } => (to, from, extent),
            PlannedCopy::Upload { from, to, extent } => (from, to, extent),
            _ => return None,
        };
        let aspect = texels.aspect.into();
        let bytes = u64::from(width.div_ceil(block_width)) * u64::from(format.block_copy_size(Some(aspect))?);
        let lines = height.div_ceil(block_height);
        if u64::from(lines) * u64::from(layers) > MAXIMUM_RUNS {
            return None;
        }
        for line in (0..layers).flat_map(|layer| (0..lines).map(move |line| (layer, line))) {
            let line = u64::from(line.0) * u64::from(rows.rows_per_image) + u64::from(line.1);
            let first = rows.offset + line * u64::from(rows.bytes_per_row);
            runs.push((first, first + bytes));
        }
    }
    Some(joined(runs))
}

struct Copies<'a, 'p> {
    resolved: &'a ResolvedResources<'p>,
    pass: &'a Pass,
    diagnostics: &'a mut Vec<Diagnostic>,
}

impl Copies<'_, '_> {
    fn name(&self, resource: ResourceHandle) -> String {
        self.resolved.pipeline.resource(resource).name.clone()
    }

    /// Reports a diagnostic at the source or destination of the transfer in the document. Always returns `None`.
    fn reject<T>(
        &mut self,
        resource: ResourceHandle,
        written: bool,
        message: String,
        help: &str,
    ) -> Option<T> {
        let named = self.pass.access_or_self(|one| one.resource == resource && one.usage.writes() == written);
        self.diagnostics.push(named.error(codes::DEVICE_RULE, message).help(help));
        None
    }

    fn reject_at<T>(&mut self, deferred: &Deferred, message: String, help: &str) -> Option<T> {
        self.diagnostics.push(deferred.error(codes::DEVICE_RULE, message).help(help));
        None
    }

    /// Returns the byte offset and the number of bytes of a buffer region; `None` if the buffer is not resolved.
    fn run(&self, region: &BufferRegion) -> Option<(u64, u64)> {
        let all = self.resolved.get(region.buffer.resource)?.bytes;
        Some(region.buffer.range.bytes.map_or((0, all), |run| (run.first, run.count)))
    }

    fn bytes(&mut self, from: &BufferRegion, to: &BufferRegion) -> Option<PlannedCopy> {
        let (a, b) = (from.buffer.resource, to.buffer.resource);
        let ((first, source), (start, destination)) = (self.run(from)?, self.run(to)?);
        if a == b {
            let message = format!("\"{}\" is copied to itself", self.name(a));
            let help = "bytes are copied to another buffer: let a third lie between";
            return self.reject(b, true, message, help);
        }
        if source != destination {
            let (own, other) = (self.name(a), self.name(b));
            let message = format!("{source} bytes of \"{own}\" are copied to {destination} of \"{other}\"");
            return self.reject(b, true, message, "give both ends one \"size\"");
        }
        Some(PlannedCopy::Bytes { from: first, to: start, bytes: source })
    }

    /// Returns the copies from one texture to another; `None` if the transfer is invalid.
    fn texels(
        &mut self,
        from: &TextureRegion,
        to: &TextureRegion,
        extent: Option<&[Deferred; 2]>,
    ) -> Option<Vec<PlannedCopy>> {
        let (source, destination) =
            (self.resolved.texture(from.texture.resource)?, self.resolved.texture(to.texture.resource)?);
        let (a, b) = (self.name(from.texture.resource), self.name(to.texture.resource));
        if source.format.remove_srgb_suffix() != destination.format.remove_srgb_suffix() {
            let (own, wanted) = (format_name(source.format), format_name(destination.format));
            let message = format!("\"{a}\" is {own}, \"{b}\" is {wanted}: a copy changes no format");
            return self.reject(to.texture.resource, true, message, "use a full-screen pass to convert");
        }
        for (region, texture, written) in [(from, &source, false), (to, &destination, true)] {
            if self.aspect(region, texture, written)? != TextureAspect::All && has_both(texture.format) {
                let message =
                    format!("a copy of one aspect leads from the texture \"{a}\" to the texture \"{b}\"");
                let help = "copy all aspects: remove \"aspect\" from both ends; or let a buffer lie between";
                return self.reject(region.texture.resource, written, message, help);
            }
        }
        if from.mip().count != to.mip().count {
            let (own, wanted) = (from.mip().count, to.mip().count);
            let message = format!("{own} mips of \"{a}\" are copied to {wanted} of \"{b}\"");
            return self.reject(to.texture.resource, true, message, "give both ends as many \"mips\"");
        }
        if from.texture.resource == to.texture.resource && source.volume && from.mip().first == to.mip().first
        {
            let message = format!("\"{a}\" is copied to itself, within one mip level of a volume");
            let help = "copy to another texture, and from there back";
            return self.reject(to.texture.resource, true, message, help);
        }
        let sources = self.boxes(from, &source, extent)?;
        let destinations = self.boxes(to, &destination, extent)?;
        let mut copies = Vec::new();
        for ((from, own), (to_origin, wanted)) in sources.into_iter().zip(destinations) {
            if own != wanted || source.size.samples != destination.size.samples {
                let words = |[width, height, layers]: [u32; 3], samples: u32| {
                    format!("{width} by {height} with {layers} layers and {samples} samples")
                };
                let (own, wanted) =
                    (words(own, source.size.samples), words(wanted, destination.size.samples));
                let message = format!("\"{a}\" is {own}, \"{b}\" is {wanted}");
                let help = if source.size.samples == destination.size.samples {
                    "a copy joins subresource ranges of one size; choose mip, layer and extent"
                } else {
                    "a copy keeps the number of samples: give both textures the same \"samples\", or resolve"
                };
                return self.reject(to.texture.resource, true, message, help);
            }
            // wgpu 30 copies only the first of several layers to or from a volume.
            let [width, height, layers] = own;
            let single = source.volume != destination.volume;
            for layer in 0..if single { layers } else { 1 } {
                let beside = |origin: TexelOrigin| {
                    let [x, y, z] = origin.at;
                    TexelOrigin { at: [x, y, z + layer], ..origin }
                };
                let extent = if single { [width, height, 1] } else { own };
                copies.push(PlannedCopy::Texels { from: beside(from), to: beside(to_origin), extent });
            }
        }
        Some(copies)
    }

    /// Returns the copies between a texture and a buffer: per mip level, the texel origin, the buffer layout and the
    /// extent. `None` if the transfer is invalid.
    fn rows(
        &mut self,
        region: &TextureRegion,
        buffer: &BufferRegion,
        extent: Option<&[Deferred; 2]>,
        upload: bool,
    ) -> Option<Vec<(TexelOrigin, TexelRows, [u32; 3])>> {
        let texture = self.resolved.texture(region.texture.resource)?;
        let (a, b) = (self.name(region.texture.resource), self.name(buffer.buffer.resource));
        let (first, held) = self.run(buffer)?;
        let aspect = self.aspect(region, &texture, upload)?;
        if has_both(texture.format) && aspect == TextureAspect::All {
            let message = format!("depth and stencil of \"{a}\" are not copied at once");
            let help = "add \"aspect\": \"depth-only\" or \"stencil-only\"";
            return self.reject(region.texture.resource, upload, message, help);
        }
        let depth = texture.format.has_depth_aspect() && aspect != TextureAspect::StencilOnly;
        let depth_in = depth && upload && texture.format != TextureFormat::Depth16Unorm;
        let block = texture.format.block_copy_size(Some(aspect));
        let Some(block) = block.filter(|_| texture.size.samples == 1 && !depth_in) else {
            let format = format_name(texture.format);
            let message = format!("\"{a}\" ({format}) cannot be copied to or from the buffer \"{b}\"");
            let help = if texture.size.samples > 1 {
                "several samples have no bytes: resolve them first"
            } else if depth_in {
                "only depth16unorm takes its depth from a buffer: use a pass that writes depth"
            } else {
                "the depth of this format has no bytes: use a pass"
            };
            return self.reject(region.texture.resource, upload, message, help);
        };
        let step =
            if texture.format.is_depth_stencil_format() { COPY_BUFFER_ALIGNMENT } else { u64::from(block) };
        if !first.is_multiple_of(step) {
            let message = format!("the texels of \"{a}\" begin at byte {first} of \"{b}\"");
            let help = format!("begin at a multiple of {step} bytes");
            return self.reject(buffer.buffer.resource, !upload, message, &help);
        }
        let (block_width, block_height) = texture.format.block_dimensions();
        let boxes = self.boxes(region, &texture, extent)?;
        let mut rows = Vec::new();
        let (mut offset, mut end) = (first, first);
        for (origin, extent) in boxes {
            let [width, height, layers] = extent;
            let row = u64::from(width.div_ceil(block_width)) * u64::from(block);
            let min = row.next_multiple_of(u64::from(COPY_BYTES_PER_ROW_ALIGNMENT));
            let (bytes_per_row, lines) = (buffer.bytes_per_row, height.div_ceil(block_height));
            let rows_per_image = buffer.rows_per_image.unwrap_or(lines);
            let bytes_per_row = bytes_per_row.map_or(min, u64::from);
            if bytes_per_row < row || rows_per_image < lines {
                let message = format!(
                    "\"{a}\" has {lines} rows of {row} bytes, \"{b}\" {rows_per_image} of {bytes_per_row}"
                );
                let help = "make \"bytes_per_row\" and \"rows_per_image\" larger, or remove them";
                return self.reject(buffer.buffer.resource, !upload, message, help);
            }
            let image = bytes_per_row.saturating_mul(u64::from(rows_per_image));
            let last = bytes_per_row * u64::from(lines.saturating_sub(1)) + row;
            let before = image.saturating_mul(u64::from(layers.saturating_sub(1)));
            end = offset.saturating_add(before).saturating_add(last);
            let bytes_per_row = u32::try_from(bytes_per_row).ok()?;
            rows.push((origin, TexelRows { offset, bytes_per_row, rows_per_image }, extent));
            offset = offset.saturating_add(image.saturating_mul(u64::from(layers)));
        }
        let wanted = end - first;
        if held < wanted {
            let message = format!("\"{a}\" takes {wanted} bytes, of \"{b}\" there are {held}");
            let help = "each row of texels takes a multiple of 256 bytes";
            return self.reject(buffer.buffer.resource, !upload, message, help);
        }
        Some(rows)
    }

    /// Returns the aspect for the device; `None` after a diagnostic, if the format lacks the aspect.
    fn aspect(
        &mut self,
        region: &TextureRegion,
        texture: &TextureProperties,
        written: bool,
    ) -> Option<TextureAspect> {
        let (exists, aspect, word) = match region.texture.range.aspect {
            Aspect::All => return Some(TextureAspect::All),
            Aspect::DepthOnly => (texture.format.has_depth_aspect(), TextureAspect::DepthOnly, "depth"),
            Aspect::StencilOnly => {
                (texture.format.has_stencil_aspect(), TextureAspect::StencilOnly, "stencil")
            }
        };
        if !exists {
            let (name, format) = (self.name(region.texture.resource), format_name(texture.format));
            let message = format!("\"{name}\" is {format}: no {word}");
            let help = "remove \"aspect\", or choose another format";
            return self.reject(region.texture.resource, written, message, help);
        }
        Some(aspect)
    }

    /// Returns the first texel and the extent in texels of each mip level; `None` if the region is invalid.
    fn boxes(
        &mut self,
        region: &TextureRegion,
        texture: &TextureProperties,
        extent: Option<&[Deferred; 2]>,
    ) -> Option<Vec<(TexelOrigin, [u32; 3])>> {
        let TextureProperties { format, size, volume, .. } = *texture;
        // Subresources that do not exist are a diagnostic of their own.
        if region.mip().end() > u64::from(size.mips) {
            return None;
        }
        let block = <[u32; 2]>::from(format.block_dimensions());
        let whole = format.is_depth_stencil_format() || size.samples > 1;
        let mut boxes = Vec::new();
        for mip in (region.mip().first..).take(region.mip().count as usize) {
            let side = |length: u32| length.checked_shr(mip).unwrap_or(0).max(1);
            let slices = if volume { side(size.layers) } else { size.layers };
            let layer = region.texture.range.layer.map_or((0, slices), |run| (run.first, run.count));
            if u64::from(layer.0) + u64::from(layer.1) > u64::from(slices) {
                return None;
            }
            let mip_level = [side(size.width), side(size.height)];
            let (mut at, mut length) = ([0; 2], [0; 2]);
            for (axis, what) in ["x", "y"].iter().enumerate() {
                // Compressed texels are there in whole blocks, also where a mip level ends within one.
                let full = mip_level[axis].next_multiple_of(block[axis]);
                let start = region.origin.as_ref().map(|origin| &origin[axis]);
                let count = extent.map(|extent| &extent[axis]);
                at[axis] = start.map_or(Some(0), |origin| self.texel_count(origin, "origin", 0))?;
                length[axis] = match count {
                    Some(count) => self.texel_count(count, "extent", 1)?,
                    None => full.saturating_sub(at[axis]),
                };
                let Some(said) = count.or(start) else { continue };
                let (first, beyond) = (at[axis], u64::from(at[axis]) + u64::from(length[axis]));
                let name = self.name(region.texture.resource);
                if beyond > u64::from(full) || length[axis] == 0 {
                    let message = format!(
                        "\"{name}\" has {} texels in {what}, of which {} from {first} are copied",
                        mip_level[axis], length[axis]
                    );
                    return self.reject_at(said, message, "stay within the mip level");
                }
                if whole && (first > 0 || beyond < u64::from(full)) {
                    let message =
                        format!("{} of {full} texels of \"{name}\" are copied in {what}", length[axis]);
                    let help = "depth, stencil and several samples are copied by whole layers: remove \"origin\" and \"extent\"";
                    return self.reject_at(said, message, help);
                }
                if first % block[axis] != 0 || length[axis] % block[axis] != 0 {
                    let message = format!("{} texels of \"{name}\" from {first} are copied", length[axis]);
                    let help = format!("its texels come in blocks of {} by {}", block[0], block[1]);
                    return self.reject_at(said, message, &help);
                }
            }
            let at = [at[0], at[1], layer.0];
            let aspect = if has_both(format) { region.texture.range.aspect } else { Aspect::All };
            boxes.push((TexelOrigin { mip, at, aspect }, [length[0], length[1], layer.1]));
        }
        Some(boxes)
    }

    fn texel_count(&mut self, deferred: &Deferred, key: &str, min: u32) -> Option<u32> {
        let value = self.resolved.sizes.value(deferred)?;
        whole_number(&value, min..=u32::MAX).or_else(|| {
            let message = format!("\"{key}\" is {value} texels, not a whole number from {min}");
            self.reject_at(
                deferred,
                message,
                &format!("write a whole number from {min}; floor() rounds down"),
            )
        })
    }
}

fn has_both(format: TextureFormat) -> bool {
    format.has_depth_aspect() && format.has_stencil_aspect()
}
