//! Declarations of passes and resources, decoded once for all instances.

use std::collections::HashMap;
use std::rc::Rc;

use crate::node::{Registry, Settings};
use crate::pipeline::names::instance::Instance;
use crate::pipeline::resource::ResourceKind;
use umbragraph_text::document::{Entry, decode_entries};
use umbragraph_text::language::{PassCommon, ResourceDeclaration, node_kind};

/// The decoded declaration of a pass.
pub(super) struct Declared<'a> {
    /// The entry whose key names the node kind, and whose value has the settings.
    pub(super) kind: &'a Entry,
    /// The common keys of the pass, beside the node kind.
    pub(super) common: PassCommon,
    pub(super) settings: Result<Box<dyn Settings>, serde_json::Error>,
}

/// The decoded declarations of passes and resources, by the address of their entry in the document.
pub(super) struct Declarations<'a, 'r> {
    registry: &'r Registry,
    passes: HashMap<*const Entry, Option<Rc<Declared<'a>>>>,
    resources: HashMap<*const Entry, ResourceKind>,
}

impl<'a, 'r> Declarations<'a, 'r> {
    pub(super) fn new(registry: &'r Registry) -> Self {
        Self { registry, passes: HashMap::new(), resources: HashMap::new() }
    }

    /// Returns the declaration of a pass that fits the schema; `None` if the pass cannot be decoded.
    pub(super) fn pass(&mut self, instance: &Instance<'a>) -> Option<Rc<Declared<'a>>> {
        let decode = || decode_pass(instance.entry, self.registry).map(Rc::new);
        if instance.environment.is_top() {
            return decode();
        }
        self.passes.entry(instance.entry).or_insert_with(decode).clone()
    }

    /// Returns the declared kind of a resource; [`ResourceKind::Broken`] if it does not fit the schema or cannot be
    /// decoded.
    pub(super) fn resource(&mut self, instance: &Instance<'a>) -> ResourceKind {
        if instance.is_broken {
            return ResourceKind::Broken;
        }
        let decode = || match instance.entry.value.decode() {
            Ok(ResourceDeclaration::Texture(texture)) => ResourceKind::Texture(Box::new(texture)),
            Ok(ResourceDeclaration::Buffer(buffer)) => ResourceKind::Buffer(Box::new(buffer)),
            Err(_) => ResourceKind::Broken,
        };
        if instance.environment.is_top() {
            return decode();
        }
        self.resources.entry(instance.entry).or_insert_with(decode).clone()
    }
}

fn decode_pass<'a>(entry: &'a Entry, registry: &Registry) -> Option<Declared<'a>> {
    let kind = node_kind(&entry.value)?;
    let node = registry.get(&kind.key)?;
    let members = entry.value.entries().unwrap_or_default().iter();
    let beside = members.filter(|member| registry.get(&member.key).is_none());
    let common = decode_entries(beside).ok()?;
    Some(Declared { kind, common, settings: node.decode(&kind.value) })
}
