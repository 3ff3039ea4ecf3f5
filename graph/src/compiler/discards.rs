//! Attachments that are thrown away after their pass, and who reads them nevertheless.
//!
//! Whether an attachment is stored follows from who reads it later. `"store": "discard"` is a promise beyond that:
//! nobody does, neither a later pass, nor a later frame, nor the host. Passes that break it are found here; the host's
//! own reads are its own affair. What is thrown away counts for no output.
//!
//! A read comes from the frame before where no write of this frame that is always there covers it.
//!
//! Cost: for each such attachment the uses of its resource.

use super::graph::Graph;
use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::language::Lifetime;
use crate::pipeline::{Part, Pipeline, Use};
use crate::work::{AttachmentTarget, PassHandle, RenderWork, ResourceHandle, Work};

/// Finds the readers of what passes throw away.
pub(super) fn check(pipeline: &Pipeline, graph: &Graph, diagnostics: &mut Diagnostics) {
    for handle in pipeline.pass_handles() {
        let pass = pipeline.pass(handle);
        let Work::Render(render) = &pass.work else { continue };
        for one in pass.uses.iter().filter(|one| one.usage.is_attachment() && one.usage.writes()) {
            if discards(render, one.resource, one.part) {
                Check { pipeline, graph, handle, one }.run(diagnostics);
            }
        }
    }
}

/// Whether a pass throws away what it leaves in a part.
pub(super) fn discards(render: &RenderWork, resource: ResourceHandle, part: Part) -> bool {
    use crate::pipeline::Aspect::{DepthOnly, StencilOnly};
    let same = |target: AttachmentTarget| {
        target.resource == resource && Part::of(Some(target.mip), target.layer).aspect(part.aspect) == part
    };
    render.color.iter().any(|color| color.discard && same(color.target))
        || render
            .depth
            .as_ref()
            .is_some_and(|one| one.discard && part.aspect != StencilOnly && same(one.target))
        || render
            .stencil
            .as_ref()
            .is_some_and(|one| one.discard && part.aspect != DepthOnly && same(one.target))
}

struct Check<'a> {
    pipeline: &'a Pipeline,
    graph: &'a Graph,
    /// The pass that throws away.
    handle: PassHandle,
    /// What it throws away.
    one: &'a Use,
}

impl Check<'_> {
    fn run(&self, diagnostics: &mut Diagnostics) {
        let resource = self.pipeline.resource(self.one.resource);
        let mut readers: Vec<PassHandle> = self
            .graph
            .consumers(self.handle)
            .filter(|(_, read)| *read == self.one.resource)
            .map(|(reader, _)| reader)
            .collect();
        readers.sort_unstable();
        readers.dedup();
        for reader in &readers {
            if let Some(read) = self.reads(*reader, self.one.resource) {
                diagnostics.push(self.finding(*reader, read, ""));
            }
        }
        let before = " of the frame before";
        for reader in self.pipeline.pass_handles().filter(|reader| !readers.contains(reader)) {
            let read = match resource.lifetime() {
                Lifetime::Persistent => {
                    self.reads(reader, self.one.resource).filter(|read| !self.is_written(reader, read))
                }
                Lifetime::History => self.pipeline.pass(reader).uses.iter().find(|read| {
                    let history = self.pipeline.resource(read.resource).history;
                    history.is_some_and(|history| history.back > 0 && history.of == self.one.resource)
                        && read.part.overlaps(self.one.part)
                }),
                Lifetime::Transient | Lifetime::Imported => None,
            };
            if let Some(read) = read {
                diagnostics.push(self.finding(reader, read, before));
            }
        }
    }

    /// Where a pass reads what is thrown away.
    fn reads(&self, reader: PassHandle, resource: ResourceHandle) -> Option<&Use> {
        let uses = self.pipeline.pass(reader).uses.iter();
        uses.filter(|read| read.resource == resource && read.usage.reads())
            .find(|read| read.part.overlaps(self.one.part))
    }

    /// Whether passes before write all that a use reads, in each frame.
    fn is_written(&self, reader: PassHandle, read: &Use) -> bool {
        self.graph.producers(reader).any(|(writer, resource)| {
            let pass = self.pipeline.pass(writer);
            let writes = |one: &&Use| one.resource == resource && one.usage.writes() && !one.usage.reads();
            resource == read.resource
                && (pass.condition.is_none() || pass.condition == self.pipeline.pass(reader).condition)
                && pass.uses.iter().filter(writes).any(|one| one.part.contains(read.part))
        })
    }

    fn finding(&self, reader: PassHandle, read: &Use, when: &str) -> Diagnostic {
        let (by, name) = (&self.pipeline.pass(self.handle).name, &self.pipeline.pass(reader).name);
        let resource = &self.pipeline.resource(self.one.resource).name;
        let message = format!("\"{name}\" reads \"{resource}\"{when}, which \"{by}\" throws away");
        Diagnostic::error(codes::DISCARDED, read.place, message)
            .pointer(&read.pointer)
            .related(self.one.place, "thrown away here")
            .help(format!("remove \"store\" from \"{by}\", or let another pass write it before it is read"))
    }
}
