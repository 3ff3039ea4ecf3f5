//! What sizes change about a pass: the number of workgroups, what is copied, the bytes of its blocks, and whether
//! attachments fit.
//!
//! Planning a pass ends here, and planning it again for another size is nothing else.

use super::copies;
use super::dispatch;
use super::format;
use super::parameters;
use super::planned::{PlannedAttachment, PlannedPass};
use super::resolved_resources::{ResolvedResources, TextureProperties};
use super::values::{self, PackedBlock};
use crate::diagnostic::{Diagnostic, codes};
use crate::pipeline::ResourceKind;
use crate::source::Span;
use crate::work::{Dispatch, Draw, PassHandle, RenderWork, ResourceHandle, Work};

impl ResolvedResources<'_> {
    /// Fills in, or makes again, what depends on sizes.
    ///
    /// Diagnostics: values that do not fit their block, impossible dispatches, attachments that do not fit together.
    pub(super) fn size_pass(&self, planned: &mut PlannedPass, diagnostics: &mut Vec<Diagnostic>) {
        let handle = planned.handle;
        planned.blocks.clear();
        planned.live.clear();
        if let Some((_, slots)) = format::slots(self.pipeline, handle) {
            for slot in slots {
                if let Some(block) = slot.source.values()
                    && let Some(bytes) =
                        values::pack(&block.layout, &block.expressions, &self.sizes, diagnostics)
                {
                    let position = planned.blocks.len();
                    parameters::of_block(&self.sizes, position, block, &mut planned.live);
                    planned.blocks.push(PackedBlock { group: slot.group, binding: slot.binding, bytes });
                }
            }
        }
        parameters::of_pass(&self.sizes, &self.pipeline.pass(handle).live, &mut planned.live);
        match self.pipeline.pass(handle).work() {
            Work::Render(render) => self.check_attachments(handle, planned, render, diagnostics),
            Work::Compute(compute) => {
                planned.workgroups = dispatch::workgroups(self, compute, handle, diagnostics);
                if let Dispatch::Workgroups(counts) = &compute.dispatch {
                    let limit = self.pipeline.profile.limits.max_compute_workgroups_per_dimension;
                    parameters::of_dispatch(&self.sizes, counts, limit, &mut planned.live);
                }
            }
            Work::Transfer(transfer) => {
                planned.copies = copies::copies(self, transfer, handle, diagnostics).unwrap_or_default();
            }
            Work::Nothing | Work::Cpu(_) => {}
        }
    }

    /// The place of an attachment of a pass.
    fn place_of(&self, handle: PassHandle, resource: ResourceHandle) -> (Span, String) {
        let pass = self.pipeline.pass(handle);
        let found = pass.accesses().iter().find(|one| one.resource == resource && one.usage.is_attachment());
        found.map_or((pass.place, pass.pointer.clone()), |one| (one.place, one.pointer.clone()))
    }

    /// Finds attachments that do not fit one another or the views.
    fn check_attachments(
        &self,
        handle: PassHandle,
        planned: &PlannedPass,
        render: &RenderWork,
        diagnostics: &mut Vec<Diagnostic>,
    ) {
        let mut first: Option<(&PlannedAttachment, [u32; 3])> = None;
        for attachment in planned.attachments() {
            let Some(TextureProperties { size, .. }) = self.texture(attachment.target.resource) else {
                return;
            };
            let mip = attachment.target.mip.min(31);
            let own = [(size.width >> mip).max(1), (size.height >> mip).max(1), size.samples];
            match first {
                None => first = Some((attachment, own)),
                Some((other, wanted)) if wanted != own => {
                    let (place, pointer) = self.place_of(handle, attachment.target.resource);
                    let words =
                        |size: [u32; 3]| format!("{} by {} with {} samples", size[0], size[1], size[2]);
                    let message = format!(
                        "\"{}\" is {}, but \"{}\" of the same pass is {}",
                        attachment.resource,
                        words(own),
                        other.resource,
                        words(wanted)
                    );
                    diagnostics.push(
                        Diagnostic::error(codes::ATTACHMENTS, place, message)
                            .pointer(pointer)
                            .help("attachments of one pass have one size and sample count"),
                    );
                }
                Some(_) => {}
            }
        }
        self.check_views(handle, planned, render, diagnostics);
    }

    /// Finds attachments with fewer layers than there are views, or of another size than these are made for.
    fn check_views(
        &self,
        handle: PassHandle,
        planned: &PlannedPass,
        render: &RenderWork,
        diagnostics: &mut Vec<Diagnostic>,
    ) {
        if let Draw::Scene(scene) = &render.draw
            && let ResourceKind::Data(Some(shape)) = &self.pipeline.resource(scene.views.resource).kind
        {
            let other = shape.view_extent.and_then(|extent| {
                let mut attachments = planned.attachments();
                let other = attachments.find_map(|attachment| {
                    let size = self.texture(attachment.target.resource)?.size;
                    let own =
                        [size.width, size.height].map(|side| (side >> attachment.target.mip.min(31)).max(1));
                    (own != extent).then_some((attachment, own))
                });
                Some((other?, extent))
            });
            if let Some(((attachment, [width, height]), [wide, high])) = other {
                let (place, pointer) = self.place_of(handle, attachment.target.resource);
                let views = &self.pipeline.resource(scene.views.resource).name;
                let message = format!(
                    "\"{}\" is {width} by {height}, but the views of \"{views}\" are made for {wide} by {high}",
                    attachment.resource
                );
                diagnostics.push(Diagnostic::error(codes::ATTACHMENTS, place, message).pointer(pointer).help(
                    "layers of an array have one size, that of the largest view: give the texture that size (smaller \
                     views take a part of it), or each view a texture of its own (\"view\")",
                ));
            }
            for attachment in planned.attachments().filter(|attachment| attachment.target.layer.is_none()) {
                let Some(TextureProperties { size, .. }) = self.texture(attachment.target.resource) else {
                    continue;
                };
                if size.layers > 1 && size.layers < shape.view_layers {
                    let (place, pointer) = self.place_of(handle, attachment.target.resource);
                    let message = format!(
                        "\"{}\" has {} layers for {} views",
                        attachment.resource, size.layers, shape.max_views
                    );
                    diagnostics.push(
                        Diagnostic::error(codes::ATTACHMENTS, place, message)
                            .pointer(pointer)
                            .help("give the texture a layer for each view"),
                    );
                }
            }
        }
    }
}
