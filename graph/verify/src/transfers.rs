//! Checks that the accesses of copies match their passes, and that the plan copies what the passes describe.
//!
//! The description of a transfer defines the mips, layers, aspect or bytes that it reads and writes. The accesses of
//! its pass, the base of all orders and lifetimes, must name exactly these. The plan's copies must add up to them: one
//! box for each mip level, or ranges of bytes, within the resource; with a sufficient row pitch, and within the named
//! bytes.
//!
//! Limits: expressions for an origin or an extent are not evaluated again; their boxes must only lie within their mip
//! level and have equal sizes.

use wgpu_types::{COPY_BYTES_PER_ROW_ALIGNMENT, TextureFormat};

use crate::violation::{ViolationKind as Kind, Violations};
use umbragraph_compiler::{Plan, PlannedCopy, PlannedPass, PlannedResource, TexelOrigin, TexelRows};
use umbragraph_pipeline::language::TextureShape;
use umbragraph_pipeline::pipeline::{Aspect, IndexRange, SubresourceRange, Usage};
use umbragraph_pipeline::work::{
    BufferRegion, ResourceHandle, TextureRegion, TransferEnd, TransferWork, Work,
};

/// Checks the accesses and the copies of every planned transfer.
pub(crate) fn check(plan: &Plan, violations: &mut Violations) {
    for planned in &plan.passes {
        match plan.pipeline.pass(planned.handle).work() {
            Work::Transfer(transfer) => {
                let wrong = check_accesses(plan, planned, transfer).or_else(|| {
                    let transfer = Transfer { plan, transfer };
                    transfer.check(&planned.copies).err()
                });
                if let Some(wrong) = wrong {
                    violations.add(Kind::CopyWrong, format!("\"{}\" {wrong}", planned.name));
                }
            }
            _ if !planned.copies.is_empty() => {
                violations.add(Kind::CopyWrong, format!("\"{}\" copies, but is no transfer", planned.name));
            }
            _ => {}
        }
    }
}

/// Returns the error in the accesses of a transfer, which must be exactly those of its source and destination; `None`
/// if there is none.
fn check_accesses(plan: &Plan, planned: &PlannedPass, transfer: &TransferWork) -> Option<String> {
    let pass = plan.pipeline.pass(planned.handle);
    let mut wanted: Vec<(ResourceHandle, SubresourceRange, bool)> = Vec::new();
    for (end, writes) in transfer.source.iter().map(|end| (end, false)).chain([(&transfer.destination, true)])
    {
        wanted.push((end.subresource().resource, range(plan, end), writes));
    }
    for one in pass.accesses() {
        let writes = match one.usage {
            Usage::CopySource => false,
            Usage::CopyDestination | Usage::CopyDestinationLoad | Usage::CopyDestinationRows => true,
            _ => return Some(format!("uses something as {}, but copies", one.usage.name())),
        };
        // The fallback of another resource is copied in its place.
        let stands_in =
            |wanted: ResourceHandle| plan.pipeline.fallbacks(wanted).any(|known| known == one.resource);
        let is_described = wanted.iter().any(|(resource, range, written)| {
            (one.resource == *resource || stands_in(*resource)) && one.range == *range && writes == *written
        });
        if !is_described {
            let name = &plan.pipeline.resource(one.resource).name;
            return Some(format!("says that it uses other subresource ranges of \"{name}\" than it copies"));
        }
    }
    let missing = wanted.into_iter().find(|(resource, range, writes)| {
        !pass.accesses().iter().any(|one| {
            one.resource == *resource && one.range == *range && (one.usage != Usage::CopySource) == *writes
        })
    });
    missing.map(|(resource, ..)| {
        format!(
            "copies subresource ranges of \"{}\" that it does not use",
            plan.pipeline.resource(resource).name
        )
    })
}

/// Returns the subresource range that the source or destination of a transfer covers.
fn range(plan: &Plan, end: &TransferEnd) -> SubresourceRange {
    match end {
        TransferEnd::Buffer(region) => {
            SubresourceRange { mip: None, layer: None, aspect: Aspect::All, bytes: region.buffer.range.bytes }
        }
        TransferEnd::Texture(region) => {
            let format = planned(plan, region.texture.resource).and_then(|one| one.format);
            let aspect =
                if format.is_some_and(has_two_aspects) { region.texture.range.aspect } else { Aspect::All };
            SubresourceRange {
                mip: Some(region.mip()),
                layer: region.texture.range.layer,
                aspect,
                bytes: None,
            }
        }
    }
}

fn has_two_aspects(format: TextureFormat) -> bool {
    format.has_depth_aspect() && format.has_stencil_aspect()
}

fn planned(plan: &Plan, resource: ResourceHandle) -> Option<&PlannedResource> {
    plan.resources.get(&plan.pipeline.resource(resource).name)
}

struct Transfer<'a> {
    plan: &'a Plan,
    transfer: &'a TransferWork,
}

/// A copied box of texels: the first texel, and the width, height and number of layers or depth slices.
type TexelBox = (TexelOrigin, [u32; 3]);

impl Transfer<'_> {
    /// Checks that the plan copies what the transfer declares.
    fn check(&self, copies: &[PlannedCopy]) -> Result<(), String> {
        use TransferEnd::{Buffer, Texture};
        match (&self.transfer.source, &self.transfer.destination) {
            (None, Buffer(to)) => {
                let (offset, bytes) = self.run(to)?;
                same(copies, &[PlannedCopy::Clear { offset, bytes }])
            }
            (Some(Buffer(from)), Buffer(to)) => {
                let ((from, bytes), (to, room)) = (self.run(from)?, self.run(to)?);
                if bytes != room {
                    return Err("copies to fewer or more bytes".to_owned());
                }
                same(copies, &[PlannedCopy::Bytes { from, to, bytes }])
            }
            (Some(Texture(from)), Texture(to)) => {
                let boxes = copies.iter().map(|copy| match copy {
                    PlannedCopy::Texels { from, to, extent } => Ok(((*from, *extent), (*to, *extent))),
                    _ => Err("copies no texels to texels"),
                });
                let (own, other): (Vec<_>, Vec<_>) = boxes.collect::<Result<_, _>>()?;
                self.boxes(from, &own)?;
                self.boxes(to, &other)
            }
            (Some(Buffer(from)), Texture(to)) => {
                let list = copies.iter().map(|copy| match copy {
                    PlannedCopy::Upload { from, to, extent } => Ok((*from, (*to, *extent))),
                    _ => Err("copies no rows to texels"),
                });
                self.rows(to, from, &list.collect::<Result<Vec<_>, _>>()?)
            }
            (Some(Texture(from)), Buffer(to)) => {
                let list = copies.iter().map(|copy| match copy {
                    PlannedCopy::Download { from, to, extent } => Ok((*to, (*from, *extent))),
                    _ => Err("copies no texels to rows"),
                });
                self.rows(from, to, &list.collect::<Result<Vec<_>, _>>()?)
            }
            (None, Texture(_)) => Err("clears a texture".to_owned()),
        }
    }

    /// Returns the byte offset and the number of bytes of a buffer region.
    fn run(&self, region: &BufferRegion) -> Result<(u64, u64), String> {
        let all = planned(self.plan, region.buffer.resource).ok_or("copies what is not planned")?.bytes;
        let run = region.buffer.range.bytes.unwrap_or(IndexRange { first: 0, count: all });
        if run.end() > all {
            return Err("copies bytes that the buffer does not have".to_owned());
        }
        Ok((run.first, run.count))
    }

    /// Checks that boxes of texels cover a texture region: all of its mip levels, with all layers of each.
    fn boxes(&self, region: &TextureRegion, boxes: &[TexelBox]) -> Result<(), String> {
        let resource = planned(self.plan, region.texture.resource).ok_or("copies what is not planned")?;
        let (Some(size), Some(format)) = (resource.size, resource.format) else {
            return Err("copies texels of what is not a texture".to_owned());
        };
        let declared = self.plan.pipeline.resource(region.texture.resource).texture();
        let volume = declared.is_some_and(|texture| texture.view_dimension == Some(TextureShape::D3));
        let aspect = if has_two_aspects(format) { region.texture.range.aspect } else { Aspect::All };
        let (block_width, block_height) = format.block_dimensions();
        let mut list = boxes.iter();
        for mip in u64::from(region.mip().first)..region.mip().end() {
            if mip >= u64::from(size.mips) {
                return Err(format!("copies mip {mip}, which is not there"));
            }
            let shift = u32::try_from(mip).unwrap_or(u32::MAX);
            let half = |length: u32| length.checked_shr(shift).unwrap_or(0).max(1);
            let [width, height] = [
                half(size.width).next_multiple_of(block_width),
                half(size.height).next_multiple_of(block_height),
            ];
            let slices = if volume { half(size.layers) } else { size.layers };
            let layers = region.texture.range.layer.unwrap_or(IndexRange { first: 0, count: slices });
            if layers.end() > u64::from(slices) {
                return Err("copies layers that are not there".to_owned());
            }
            // One box for all layers, or one for each.
            let mut next = layers.first;
            while u64::from(next) < layers.end() {
                let Some((origin, [own_width, own_height, count])) = list.next() else {
                    return Err("copies less than it says".to_owned());
                };
                let [x, y, z] = origin.at;
                if u64::from(origin.mip) != mip || origin.aspect != aspect || z != next || *count == 0 {
                    return Err("copies another mip, layer or aspect than it says".to_owned());
                }
                let fits = |first: u32, length: u32, all: u32| {
                    length > 0 && u64::from(first) + u64::from(length) <= u64::from(all)
                };
                let is_whole = [x, y, *own_width, *own_height] == [0, 0, width, height];
                let is_cut = region.origin.is_some() || self.transfer.extent.is_some();
                if !is_whole && !is_cut || !fits(x, *own_width, width) || !fits(y, *own_height, height) {
                    return Err("copies another box of texels than it says".to_owned());
                }
                next = next.saturating_add(*count);
            }
            if u64::from(next) != layers.end() {
                return Err("copies more layers than it says".to_owned());
            }
        }
        if list.next().is_some() { Err("copies more than it says".to_owned()) } else { Ok(()) }
    }

    /// Checks that texels lie in a buffer mip level after mip level, within the declared bytes.
    fn rows(
        &self,
        region: &TextureRegion,
        buffer: &BufferRegion,
        list: &[(TexelRows, TexelBox)],
    ) -> Result<(), String> {
        let boxes: Vec<TexelBox> = list.iter().map(|(_, one)| *one).collect();
        self.boxes(region, &boxes)?;
        let (first, count) = self.run(buffer)?;
        let format = planned(self.plan, region.texture.resource).and_then(|one| one.format);
        let format = format.ok_or("copies texels of what is not a texture")?;
        let aspect = region.texture.range.aspect.into();
        let texel = format.block_copy_size(Some(aspect)).ok_or("copies texels that have no bytes")?;
        let (block_width, block_height) = format.block_dimensions();
        let mut at = first;
        for (rows, (_, [width, height, layers])) in list {
            let row = u64::from(width.div_ceil(block_width)) * u64::from(texel);
            let lines = u64::from(height.div_ceil(block_height));
            let (pitch, image) = (u64::from(rows.bytes_per_row), u64::from(rows.rows_per_image));
            let said = buffer.bytes_per_row.is_none_or(|said| said == rows.bytes_per_row)
                && buffer.rows_per_image.is_none_or(|said| said == rows.rows_per_image);
            if pitch < row || pitch % u64::from(COPY_BYTES_PER_ROW_ALIGNMENT) != 0 || image < lines || !said {
                return Err("copies rows of texels that do not fit one another".to_owned());
            }
            let before = image.saturating_mul(u64::from(layers.saturating_sub(1)));
            let lines = before.saturating_add(lines.saturating_sub(1));
            let end = rows.offset.saturating_add(pitch.saturating_mul(lines)).saturating_add(row);
            if rows.offset != at || end > first + count {
                return Err("copies to or from other bytes than it says".to_owned());
            }
            at = at.saturating_add(pitch.saturating_mul(image).saturating_mul(u64::from(*layers)));
        }
        Ok(())
    }
}

fn same(copies: &[PlannedCopy], right: &[PlannedCopy]) -> Result<(), String> {
    if copies == right { Ok(()) } else { Err("copies other bytes than it says".to_owned()) }
}
