//! A declared pass, and what it uses.

use std::sync::Arc;

use crate::access::{SubresourceRange, Usage, Version, canonical};
use crate::pipeline::names::environment::Environment;
use crate::pipeline::resource::Resource;
use crate::pipeline::settings::live::LiveSetting;
use crate::pipeline::toggle::Condition;
use crate::work::{PassHandle, ResourceHandle, Subresource, Work};
use umbragraph_text::source::Span;

/// A declared pass.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Its name.
    pub name: String,
    /// Its node kind.
    pub kind: String,
    /// The place of its key.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
    /// The scope of names in its settings.
    pub environment: Arc<Environment>,
    /// Passes that have to run before it, where no data says so.
    pub after: Vec<PassHandle>,
    /// Whether it has to follow something that is not there, which is a diagnostic: its order is not known then.
    pub is_misplaced: bool,
    /// Whether it is kept even if nothing reads what it writes.
    pub side_effect: bool,
    /// The toggle condition under which the pass runs; `None` for every frame.
    pub condition: Option<Condition>,
    /// The settings that are evaluated again when a live parameter changes.
    pub live: Vec<LiveSetting>,
    work: Work,
    pub(crate) accesses: Vec<Access>,
}

impl Pass {
    /// A pass that does nothing yet.
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

    /// The work.
    pub fn work(&self) -> &Work {
        &self.work
    }

    /// Its accesses: those of its work, and of the fallback.
    pub fn accesses(&self) -> &[Access] {
        &self.accesses
    }

    /// The accesses with which it writes a resource.
    pub fn writes_of(&self, resource: ResourceHandle) -> impl Iterator<Item = &Access> {
        self.accesses.iter().filter(move |one| one.resource == resource && one.usage.writes())
    }

    /// Whether it writes a resource.
    pub fn writes(&self, resource: ResourceHandle) -> bool {
        self.writes_of(resource).next().is_some()
    }

    /// Says what it does, and so what it uses; of work that is only assembled `others` are known besides.
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

    /// Work and accesses that need not fit one another: for tests of what is to notice that.
    #[doc(hidden)]
    pub fn tamper(&mut self) -> (&mut Work, &mut Vec<Access>) {
        (&mut self.work, &mut self.accesses)
    }
}

/// One access of a resource by a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Access {
    /// The resource.
    pub resource: ResourceHandle,
    /// The subresource range of it.
    pub range: SubresourceRange,
    /// The usage.
    pub usage: Usage,
    /// The version that is read.
    pub version: Version,
    /// Toggle conditions under which the access happens; all have to hold. Only accesses with a passthrough, and
    /// their fallbacks, have any.
    pub when: Vec<Condition>,
    /// The place in the document.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
}

impl Access {
    fn new(named: &Subresource, range: SubresourceRange, usage: Usage) -> Self {
        let Subresource { resource, version, place, pointer, .. } = named.clone();
        Self { resource, range, usage, version, when: Vec::new(), place, pointer }
    }
}
