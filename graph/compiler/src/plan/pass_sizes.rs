//! Parts of a pass that depend on sizes: the number of workgroups, copies, the bytes of its blocks, and whether
//! attachments fit.
//!
//! Planning a pass ends here, and planning it again for another size is nothing else.

use crate::plan::planned::{PlannedAttachment, PlannedPass};
use crate::resources::format;
use crate::resources::resolved::{Descriptor, ResolvedResources, TextureProperties};
use crate::values::packed::{self, PackedBlock};
use crate::values::settings::{self, Bound, PlannedSetting};
use crate::work::copies;
use crate::work::dispatch;
use crate::work::drawn_buffers::{Counted, DrawnBuffer};
use umbragraph_pipeline::diagnostic::{Diagnostic, codes, counted};
use umbragraph_pipeline::pipeline::{Access, ResourceKind};
use umbragraph_pipeline::work::{
    AttachmentTarget, Dispatch, Draw, DrawCounts, PassHandle, Redraw, RenderWork, SceneDraw, Work,
};

impl ResolvedResources<'_> {
    /// Computes the parts of a planned pass that depend on sizes: constant blocks, live settings, workgroup counts and
    /// copies.
    ///
    /// Reports values that do not fit their block, impossible dispatches and copies, and attachments that do not match.
    pub(crate) fn size_pass(&self, planned: &mut PlannedPass, diagnostics: &mut Vec<Diagnostic>) {
        let handle = planned.handle;
        let pass = self.pipeline.pass(handle);
        planned.blocks.clear();
        planned.live = settings::of_pass(&self.sizes, &pass.live);
        if let Some((_, slots)) = format::slots(self.pipeline, handle) {
            for slot in slots {
                if let Some(block) = slot.source.values()
                    && let (position, live) = (planned.blocks.len(), &mut planned.live)
                    && let Some(bytes) = packed::pack(block, position, &self.sizes, live, diagnostics)
                {
                    planned.blocks.push(PackedBlock { group: slot.group, binding: slot.binding, bytes });
                }
            }
        }
        match pass.work() {
            Work::Render(render) => {
                self.check_attachments(handle, planned, render, diagnostics);
                self.bind_counts(&render.draw, &mut planned.live);
            }
            Work::Compute(compute) => {
                planned.workgroups = dispatch::workgroups(self, compute, handle, diagnostics);
                if let Dispatch::Workgroups(counts) = &compute.dispatch {
                    let limit = self.pipeline.profile.limits.max_compute_workgroups_per_dimension;
                    for setting in counts.iter().filter_map(|count| count.setting) {
                        if let Some(live) = planned.live.get_mut(setting) {
                            live.bound = Bound::Workgroups(limit);
                        }
                    }
                }
            }
            Work::Transfer(transfer) => {
                planned.copies = copies::copies(self, transfer, handle, diagnostics).unwrap_or_default();
            }
            Work::Nothing | Work::Cpu(_) => {}
        }
    }

    /// Bounds the live element and instance counts of a draw by the number of elements in its buffers.
    fn bind_counts(&self, draw: &Draw, live: &mut [PlannedSetting]) {
        let Draw::Buffers(draw) = draw else { return };
        let DrawCounts::Direct { count, instances } = draw.counts else { return };
        for (counted, setting) in
            [(Counted::Elements, count.setting), (Counted::Instances, instances.setting)]
        {
            let Some(live) = setting.and_then(|at| live.get_mut(at)) else { continue };
            let drawn = DrawnBuffer::all(draw).into_iter().filter(|one| one.counted == counted);
            let most = drawn.filter_map(|one| {
                let Descriptor::Buffer { bytes, .. } = self.get(one.buffer)?.descriptor? else { return None };
                Some((one.elements(bytes)?, self.pipeline.resource(one.buffer).name.clone()))
            });
            live.bound = most.min().map_or(Bound::Free, |(most, buffer)| Bound::Drawn(most, buffer));
        }
    }

    /// Returns an error that is located at an attachment of a pass.
    fn reject(
        &self,
        handle: PassHandle,
        attachment: &PlannedAttachment,
        message: String,
        help: &str,
    ) -> Diagnostic {
        let is_it = |one: &Access| one.resource == attachment.target.resource && one.usage.is_attachment();
        self.pipeline.pass(handle).access_or_self(is_it).error(codes::ATTACHMENTS, message).help(help)
    }

    /// Reports attachments of a pass that differ in size or sample count, or do not match the views drawn into them.
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
                    // A size that both have is not said.
                    let words = |size: [u32; 3]| match own[..2] == wanted[..2] {
                        true => format!("a texture with {}", counted(size[2] as usize, "sample")),
                        false if own[2] == wanted[2] => format!("{} by {}", size[0], size[1]),
                        false => {
                            format!("{} by {} with {}", size[0], size[1], counted(size[2] as usize, "sample"))
                        }
                    };
                    let message = format!(
                        "\"{}\" is {}, but \"{}\" of the same pass is {}",
                        attachment.resource,
                        words(own),
                        other.resource,
                        words(wanted)
                    );
                    let (name, resource) = (&attachment.resource, attachment.target.resource);
                    let help = match own[..2] == wanted[..2] {
                        true => format!(
                            "give \"{name}\" the samples too: \"{name}\": {{ \"texture\": {{ \"samples\": {} }} }} under \
                             \"resources\"",
                            wanted[2]
                        ),
                        false => format!("give \"{name}\" the \"size\" of \"{}\"", other.resource),
                    };
                    let declared = [resource, other.target.resource].map(|one| self.pipeline.resource(one));
                    let diagnostic = self.reject(handle, attachment, message, &help);
                    diagnostics.push(declared.into_iter().fold(diagnostic, |diagnostic, one| {
                        diagnostic.related(one.place, format!("\"{}\" is declared here", one.name))
                    }));
                }
                Some(_) => {}
            }
        }
        self.check_views(handle, planned, render, diagnostics);
        diagnostics.extend(self.check_over(handle, render));
    }

    /// Returns an error if the texture from which redrawn views start has no depth, has several samples, or differs
    /// from the depth attachment in size.
    fn check_over(&self, handle: PassHandle, render: &RenderWork) -> Option<Diagnostic> {
        let Draw::Scene(SceneDraw { redraw: Some(Redraw { base: Some(over), .. }), .. }) = &render.draw
        else {
            return None;
        };
        let (over, depth) = (over.target(), render.depth.as_ref()?.to.target());
        let shape = |target: AttachmentTarget| {
            let TextureProperties { size, format, .. } = self.texture(target.resource)?;
            let side = |length: u32| (length >> target.mip.min(31)).max(1);
            let layers = target.layer.map_or(size.layers, |_| 1);
            Some(([side(size.width), side(size.height), layers, size.samples], format))
        };
        let ((own, format), (wanted, _)) = (shape(over)?, shape(depth)?);
        let name = |target: AttachmentTarget| &self.pipeline.resource(target.resource).name;
        let (below, above) = (name(over), name(depth));
        let words = |[width, height, layers, samples]: [u32; 4]| {
            format!("{width} by {height} with {layers} layers and {samples} samples")
        };
        let (message, help) = if !format.has_depth_aspect() {
            let message = format!("\"{below}\" has no depth, over which \"{above}\" could be drawn");
            (message, "name a depth texture of the same size")
        } else if own != wanted {
            let message = format!(
                "\"{below}\" is {}, but \"{above}\", which is drawn over it, is {}",
                words(own),
                words(wanted)
            );
            (message, "what is drawn over another texture has its width, height and layers, and its samples")
        } else if own[3] > 1 {
            let message = format!("\"{below}\" has {} samples, over which nothing is drawn", own[3]);
            (message, "give both textures one sample")
        } else {
            return None;
        };
        let is_it = |one: &Access| one.resource == over.resource && !one.usage.is_attachment();
        let named = self.pipeline.pass(handle).access_or_self(is_it);
        Some(named.error(codes::ATTACHMENTS, message).help(help))
    }

    /// Reports attachments with fewer layers than the views need, or of another size than the views are made for.
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
                let views = &self.pipeline.resource(scene.views.resource).name;
                let message = format!(
                    "\"{}\" is {width} by {height}, but the views of \"{views}\" are made for {wide} by {high}",
                    attachment.resource
                );
                let help = "layers of an array have one size, that of the largest view: give the texture that size (smaller \
                     views take a part of it), or each view a texture of its own (\"view\")";
                diagnostics.push(self.reject(handle, attachment, message, help));
            }
            for attachment in planned.attachments().filter(|attachment| attachment.target.layer.is_none()) {
                let Some(TextureProperties { size, .. }) = self.texture(attachment.target.resource) else {
                    continue;
                };
                if size.layers > 1 && size.layers < shape.view_layers {
                    let (name, views) = (&attachment.resource, shape.max_views);
                    let published = self.pipeline.resource(scene.views.resource);
                    let message = format!("\"{name}\" has {} layers for {views} views", size.layers);
                    let help = format!("give \"{name}\" \"layers\": {views}, a layer for each view");
                    let diagnostic = self.reject(handle, attachment, message, &help);
                    let label = format!("\"{}\" is published here", published.name);
                    diagnostics.push(diagnostic.related(published.place, label));
                }
            }
        }
    }
}
