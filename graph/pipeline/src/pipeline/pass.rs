//! A declared pass, and what it uses.

use std::sync::Arc;

use crate::access::{SubresourceRange, Usage, Version, canonical};
use crate::pipeline::names::environment::Environment;
use crate::pipeline::resource::Resource;
use crate::pipeline::settings::live::LiveSetting;
use crate::pipeline::toggle::Condition;
use crate::work::{PassHandle, ResourceHandle, Subresource, Work};
use umbragraph_text::source::Span;

/// A declared pass, with its work and its accesses to resources.
#[derive(Clone, Debug)]
pub struct Pass {
    /// The name of the pass.
    pub name: String,
    /// The name of the node kind.
    pub kind: String,
    /// The place of the pass's key in the document.
    pub place: Span,
    /// The JSON pointer of the pass.
    pub pointer: String,
    /// The scope of names for expressions in the pass's settings.
    pub environment: Arc<Environment>,
    /// The passes that must run before this pass because of an `after` setting. An order that follows only from data is
    /// not listed here.
    pub after: Vec<PassHandle>,
    /// Whether an `after` setting names a pass that does not exist. An error was then reported, and the order of this
    /// pass is not known.
    pub is_misplaced: bool,
    /// Whether the pass is kept even if nothing reads its outputs.
    pub side_effect: bool,
    /// The toggle condition under which the pass runs; `None` for every frame.
    pub condition: Option<Condition>,
    /// The settings that are evaluated again when a live parameter changes.
    pub live: Vec<LiveSetting>,
    work: Work,
    pub(crate) accesses: Vec<Access>,
}

impl Pass {
    /// Creates a pass without work.
    pub fn new(
        name: String,
        kind: String,
        place: Span,
        pointer: String,
        environment: Arc<Environment>,
    ) -> Self {
        Self {
            name,
            kind,
            place,
            pointer,
            environment,
            after: Vec::new(),
            is_misplaced: false,
            side_effect: false,
            condition: None,
            live: Vec::new(),
            work: Work::Nothing,
            accesses: Vec::new(),
        }
    }

    /// The work of the pass.
    pub fn work(&self) -> &Work {
        &self.work
    }

    /// The accesses of the pass to resources, including reads of fallbacks in frames in which other passes are off.
    pub fn accesses(&self) -> &[Access] {
        &self.accesses
    }

    /// The accesses with which the pass writes a resource.
    pub fn writes_of(&self, resource: ResourceHandle) -> impl Iterator<Item = &Access> {
        self.accesses.iter().filter(move |one| one.resource == resource && one.usage.writes())
    }

    /// Returns `true` if the pass writes a resource.
    pub fn writes(&self, resource: ResourceHandle) -> bool {
        self.writes_of(resource).next().is_some()
    }

    /// Sets the work and derives the accesses from it. `others` are further accesses, for passes that code assembles
    /// without work.
    pub fn set_work(&mut self, work: Work, others: Vec<Access>, resources: &[Resource]) {
        self.accesses.clear();
        for (named, usage) in work.accesses() {
            let texture = resources.get(named.resource.index()).and_then(Resource::texture);
            let range = texture.map_or(named.range, |texture| canonical(texture, named.range, usage));
            let is_known =
                |known: &Access| usage == Usage::BlackboardRead && known.resource == named.resource;
            if !self.accesses.iter().any(is_known) {
                self.accesses.push(Access::new(named, range, usage));
            }
        }
        self.accesses.extend(others);
        self.work = work;
    }

    /// Returns work and accesses for changes that may make them inconsistent, for tests of consistency checks.
    #[doc(hidden)]
    pub fn tamper(&mut self) -> (&mut Work, &mut Vec<Access>) {
        (&mut self.work, &mut self.accesses)
    }
}

/// One access of a pass to a resource.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Access {
    /// The accessed resource.
    pub resource: ResourceHandle,
    /// The accessed subresource range.
    pub range: SubresourceRange,
    /// The usage of the resource, such as a sampled texture or a color attachment.
    pub usage: Usage,
    /// The version of the resource that is read.
    pub version: Version,
    /// The toggle conditions under which the access happens; all must hold. Empty unless the resource has a passthrough
    /// or the access is to a fallback.
    pub when: Vec<Condition>,
    /// The place of the access in the document.
    pub place: Span,
    /// The JSON pointer of the access.
    pub pointer: String,
}

impl Access {
    fn new(named: &Subresource, range: SubresourceRange, usage: Usage) -> Self {
        let Subresource { resource, version, place, pointer, .. } = named.clone();
        Self { resource, range, usage, version, when: Vec::new(), place, pointer }
    }
}
