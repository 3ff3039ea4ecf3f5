//! Template texts by their address in memory, so that literal text that the engine writes tells where it stands.

use std::collections::BTreeMap;
use std::sync::Arc;

use minijinja::Environment;

use crate::jinja::template::Template;

/// The sources of all templates, sorted by memory address. minijinja writes literal text as slices of these sources, so
/// the address of such a slice identifies its template.
#[derive(Debug)]
pub(crate) struct Placement(Vec<Placed>);

#[derive(Debug)]
struct Placed {
    address: usize,
    length: usize,
    template: Arc<Template>,
}

impl Placement {
    pub(crate) fn new(environment: &Environment<'_>, templates: &BTreeMap<String, Arc<Template>>) -> Self {
        let mut placed: Vec<Placed> = environment
            .templates()
            .filter_map(|(name, compiled)| {
                let source = compiled.source();
                let template = templates.get(name)?.clone();
                Some(Placed { address: source.as_ptr() as usize, length: source.len(), template })
            })
            .collect();
        placed.sort_by_key(|placed| placed.address);
        Self(placed)
    }

    /// Returns the template with this index, as returned by [`Self::locate`].
    pub(crate) fn template(&self, at: usize) -> &Template {
        &self.0[at].template
    }

    /// Finds the template whose source contains these bytes in memory. Returns its index and the byte offset in the
    /// source; `None` if no source contains them.
    pub(crate) fn locate(&self, bytes: &[u8]) -> Option<(usize, usize)> {
        let address = bytes.as_ptr() as usize;
        let at = self.0.partition_point(|placed| placed.address <= address).checked_sub(1)?;
        let placed = &self.0[at];
        let offset = address - placed.address;
        (offset + bytes.len() <= placed.length).then_some((at, offset))
    }
}
