//! Attachments that are discarded after their pass, and who reads them nevertheless.
//!
//! Whether an attachment is stored follows from who reads it later. `"store": "discard"` is a promise beyond that:
//! nobody does, neither a later pass, nor a later frame, nor the host. Passes that break it are found here; the host's
//! own reads are its own affair. What is discarded counts for no output.
//!
//! A read comes from the frame before where writes of this frame leave something of it [open](crate::regions::visible)
//! in some state of the toggles.
//!
//! Cost: for each such attachment the accesses of its resource.

use crate::graph::Graph;
use crate::graph::conditions;
use crate::regions::visible::{Effort, View, Write};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::{Access, Aspect, Located as _, SubresourceRange, TypedPipeline};
use umbragraph_pipeline::work::{AttachmentTarget, PassHandle, RenderWork, ResourceHandle, Work};

/// Reports passes that read attachments after another pass discarded them.
pub(crate) fn check(pipeline: &TypedPipeline, graph: &Graph, diagnostics: &mut Diagnostics) {
    let mut discarded = Vec::new();
    for handle in pipeline.pass_handles() {
        let pass = pipeline.pass(handle);
        let Work::Render(render) = pass.work() else { continue };
        let written = pass.accesses().iter().filter(|one| one.usage.is_attachment() && one.usage.writes());
        discarded
            .extend(written.filter(|one| discards(render, one.resource, one.range)).map(|one| (handle, one)));
    }
    if discarded.is_empty() {
        return;
    }
    // The passes that use each resource, or an earlier frame of it.
    let mut users: Vec<Vec<PassHandle>> = vec![Vec::new(); pipeline.resources.len()];
    for handle in pipeline.pass_handles() {
        for one in pipeline.pass(handle).accesses() {
            let history = pipeline.resource(one.resource).history;
            let list = &mut users[history.map_or(one.resource, |history| history.of).index()];
            if list.last() != Some(&handle) {
                list.push(handle);
            }
        }
    }
    for (handle, one) in discarded {
        Check { pipeline, graph, handle, one, users: &users[one.resource.index()] }.run(diagnostics);
    }
}

/// Returns `true` if a pass discards its result in a subresource range of an attachment (store operation "discard").
pub(crate) fn discards(render: &RenderWork, resource: ResourceHandle, range: SubresourceRange) -> bool {
    render.attachments().filter(|one| one.discard).any(|one| {
        let AttachmentTarget { resource: discarded, mip, layer } = one.to.target();
        let is_other_aspect = matches!(
            (range.aspect, one.usage.aspect()),
            (Aspect::DepthOnly, Aspect::StencilOnly) | (Aspect::StencilOnly, Aspect::DepthOnly)
        );
        discarded == resource
            && !is_other_aspect
            && SubresourceRange::of(Some(mip), layer).aspect(range.aspect) == range
    })
}

struct Check<'a> {
    pipeline: &'a TypedPipeline,
    graph: &'a Graph,
    /// The pass that discards the attachment.
    handle: PassHandle,
    /// The write access of the discarded attachment.
    one: &'a Access,
    /// The passes that access the resource, in the same frame or, through a history, in a later frame.
    users: &'a [PassHandle],
}

impl Check<'_> {
    fn run(&self, diagnostics: &mut Diagnostics) {
        let resource = self.pipeline.resource(self.one.resource);
        let readers = self.graph.readers(self.handle, self.one.resource);
        for reader in &readers {
            if let Some(read) = self.reads(*reader).next() {
                diagnostics.push(self.diagnostic(*reader, read, ""));
            }
        }
        let before = " of the frame before";
        for reader in self.users.iter().copied().filter(|reader| !readers.contains(reader)) {
            let read = match resource.lifetime() {
                Lifetime::Persistent => self.reads(reader).find(|read| !self.is_written(reader, read)),
                Lifetime::History => self.pipeline.pass(reader).accesses().iter().find(|read| {
                    let history = self.pipeline.resource(read.resource).history;
                    history.is_some_and(|history| history.back > 0 && history.of == self.one.resource)
                        && read.range.overlaps(self.one.range)
                }),
                Lifetime::Transient | Lifetime::Imported => None,
            };
            if let Some(read) = read {
                diagnostics.push(self.diagnostic(reader, read, before));
            }
        }
    }

    /// Returns the accesses by which a pass reads subresources of the discarded attachment.
    fn reads(&self, reader: PassHandle) -> impl Iterator<Item = &Access> {
        let accesses = self.pipeline.pass(reader).accesses().iter();
        accesses
            .filter(|read| read.resource == self.one.resource && read.usage.reads())
            .filter(|read| read.range.overlaps(self.one.range))
    }

    /// Returns `true` if writes of the same frame replace, in every toggle state, all discarded contents that `reader`
    /// would read. Also `true` if this is too costly to decide.
    fn is_written(&self, reader: PassHandle, read: &Access) -> bool {
        let Some(known) = conditions::known(self.pipeline.pass(reader), read) else { return true };
        let mut effort = Effort::default();
        let mut view = View::new(read.range, &known, &mut effort);
        for (writer, _) in self.graph.producers(reader).filter(|(_, resource)| *resource == read.resource) {
            let pass = self.pipeline.pass(writer);
            for one in pass.writes_of(read.resource).filter(|one| !one.usage.reads()) {
                let condition = pass.condition;
                view.cover(Write { range: one.range, condition, writer: (), passes_on: false });
            }
        }
        !view.is_open_in(self.one.range)
    }

    fn diagnostic(&self, reader: PassHandle, read: &Access, when: &str) -> Diagnostic {
        let (by, name) = (&self.pipeline.pass(self.handle).name, &self.pipeline.pass(reader).name);
        let resource = &self.pipeline.resource(self.one.resource).name;
        let message = format!("\"{name}\" reads \"{resource}\"{when}, which \"{by}\" discards");
        read.error(codes::DISCARDED, message).related(self.one.place, "discarded here").help(format!(
            "remove \"store\" from \"{by}\", or let another pass write \"{resource}\" before it is read"
        ))
    }
}
