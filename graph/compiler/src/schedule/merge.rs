//! Neighbouring passes that can be recorded as one render pass.
//!
//! Draws fit into one render pass if they have the same attachments (texture, mip, layer), all but the first load all
//! of them, and nothing else connects them: no other resource that one of them writes is used by another, and what is
//! attached is used in no second way. Draws whose layer depends on the view stay apart, and so do those with different
//! toggles: a render pass is recorded whole or not at all.
//!
//! Cost: linear in the accesses of the passes.

use std::collections::HashSet;

use crate::resources::resolved::ResolvedResources;
use umbragraph_pipeline::pipeline::{Access, Aspect, Condition, TypedPipeline};
use umbragraph_pipeline::work::{AttachmentTarget, Draw, LoadOperation, PassHandle, ResourceHandle, Work};

/// The state that passes of one render pass share: the attachments and their aspects, and the toggle.
pub(crate) type Key = (Vec<(AttachmentTarget, Aspect)>, Option<Condition>);

/// Returns the attachments and toggle of a render pass; `None` if the pass cannot be merged with others.
pub(crate) fn key(resolved: &ResolvedResources<'_>, pass: PassHandle) -> Option<Key> {
    let pipeline = resolved.pipeline;
    let Work::Render(render) = pipeline.pass(pass).work() else { return None };
    // Samples are resolved at the end of a render pass, and one that keeps what is there need not be recorded at all.
    let keeps = matches!(&render.draw, Draw::Scene(scene) if scene.redraw.is_some());
    if keeps || render.color.iter().any(|color| color.resolve.is_some()) {
        return None;
    }
    let targets: Vec<_> = render.attachments().map(|one| (one.to.target(), one.usage.aspect())).collect();
    let can_share = targets.iter().all(|(AttachmentTarget { resource, layer, .. }, _)| {
        let single = || resolved.texture(*resource).is_some_and(|texture| texture.size.layers == 1);
        (layer.is_some() || single()) && others(pipeline, pass).all(|one| one.resource != *resource)
    });
    can_share.then(|| (targets, pipeline.pass(pass).condition))
}

/// Returns `true` for a render pass that loads all of its attachments.
pub(crate) fn loads_all(pipeline: &TypedPipeline, pass: PassHandle) -> bool {
    let Work::Render(render) = pipeline.pass(pass).work() else { return false };
    render.attachments().all(|one| one.load == LoadOperation::Load)
}

/// Returns the accesses of a pass that are not attachments.
fn others(pipeline: &TypedPipeline, pass: PassHandle) -> impl Iterator<Item = &Access> {
    pipeline.pass(pass).accesses().iter().filter(|one| !one.usage.is_attachment())
}

/// The state of merging consecutive passes into render passes.
pub(crate) struct Merger<'a, 'p> {
    resolved: &'a ResolvedResources<'p>,
    /// The attachments and toggle that the next pass must have to join; `None` if no pass can join.
    pub(crate) key: Option<Key>,
    used: HashSet<ResourceHandle>,
    written: HashSet<ResourceHandle>,
}

impl<'a, 'p> Merger<'a, 'p> {
    /// Creates a merger before the first pass.
    pub(crate) fn new(resolved: &'a ResolvedResources<'p>) -> Self {
        Self { resolved, key: None, used: HashSet::new(), written: HashSet::new() }
    }

    /// Returns `true` if a pass can be recorded into the current render pass.
    pub(crate) fn joins(&self, pass: PassHandle) -> bool {
        self.key.is_some()
            && loads_all(self.resolved.pipeline, pass)
            && key(self.resolved, pass) == self.key
            && others(self.resolved.pipeline, pass).all(|one| {
                let used = if one.usage.writes() { &self.used } else { &self.written };
                !used.contains(&one.resource)
            })
    }

    /// Adds the next pass; returns `true` if the pass joins the current render pass.
    pub(crate) fn push(&mut self, pass: PassHandle) -> bool {
        let joins = self.joins(pass);
        if !joins {
            self.key = key(self.resolved, pass);
            self.used.clear();
            self.written.clear();
        }
        if self.key.is_some() {
            for one in others(self.resolved.pipeline, pass) {
                self.used.insert(one.resource);
                if one.usage.writes() {
                    self.written.insert(one.resource);
                }
            }
        }
        joins
    }
}
