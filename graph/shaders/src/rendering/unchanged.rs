//! Templates of which every variant renders to the same text as in an earlier set.
//!
//! A session that reads one edited template again keeps the modules of all others. A template depends on its own text
//! and axes, on the templates that it names in `include`, `import`, `from` and `extends`, and on those whose axes it
//! inherits. A template with a tag that names another by an expression depends on all.
//!
//! Limits: a set with other names, with other variables bound by its changed templates, or with a longer literal text
//! (see [`guard::fuel`](crate::jinja::guard::fuel)) shares nothing with the set before.

use std::collections::{BTreeMap, BTreeSet};

use super::templates::TemplateSet;
use crate::jinja::scan::{Tag, WordKind};
use crate::jinja::template::Template;

/// The keywords of template tags that refer to other templates by name.
pub(super) const NAMING: [&str; 4] = ["include", "import", "from", "extends"];

impl TemplateSet {
    /// Returns the names of the templates of which every variant has the same WGSL as in the set `before`.
    pub fn unchanged_since(&self, before: &Self) -> BTreeSet<&str> {
        if self.library != before.library
            || self.environment.fuel() != before.environment.fuel()
            || !self.templates.keys().eq(before.templates.keys())
        {
            return BTreeSet::new();
        }
        let mut affected = BTreeSet::new();
        for ((name, new), old) in self.templates.iter().zip(before.templates.values()) {
            let is_same = new.file == old.file
                && new.text == old.text
                && self.declared_text(name) == before.declared_text(name);
            if is_same {
                continue;
            }
            if new.prepared.names.bound != old.prepared.names.bound {
                return BTreeSet::new();
            }
            affected.insert(name.as_str());
        }
        if affected.is_empty() {
            return self.names().collect();
        }
        let needed: BTreeMap<&str, Option<BTreeSet<&str>>> =
            self.templates.iter().map(|(name, one)| (name.as_str(), self.needed(name, one))).collect();
        loop {
            let is_new = |(name, needed): &(&&str, &Option<BTreeSet<&str>>)| {
                let is_affected = || needed.as_ref().is_none_or(|needed| !needed.is_disjoint(&affected));
                !affected.contains(**name) && is_affected()
            };
            let new: Vec<&str> = needed.iter().filter(is_new).map(|(name, _)| *name).collect();
            if new.is_empty() {
                return self.names().filter(|name| !affected.contains(name)).collect();
            }
            affected.extend(new);
        }
    }

    /// The names of the templates that a template refers to directly; `None` if an expression computes one of them.
    fn needed<'s>(&'s self, name: &str, template: &'s Template) -> Option<BTreeSet<&'s str>> {
        let mut needed: BTreeSet<&str> = self.inherited(name).collect();
        let text = &*template.text;
        let tags = template.scan.tags.iter();
        for tag in tags.filter(|tag| tag.keyword(text).is_some_and(|word| NAMING.contains(&word))) {
            needed.insert(self.templates.get_key_value(named(tag, text)?)?.0);
        }
        Some(needed)
    }
}

/// The template name that a template tag contains as a string literal; `None` if an expression computes the name.
fn named<'t>(tag: &Tag, text: &'t str) -> Option<&'t str> {
    let name = tag.words.get(1).filter(|word| word.kind == WordKind::Text)?;
    let is_plain = match (tag.keyword(text), tag.word(text, 2)) {
        (Some("import"), next) => next == Some("as"),
        (Some("from"), next) => next == Some("import"),
        (_, None) => true,
        (_, next) => next == Some("ignore") && tag.word(text, 3) == Some("missing") && tag.words.len() == 4,
    };
    is_plain.then(|| text.get(name.range.clone())).flatten().map(|name| name.trim_matches(['"', '\'']))
}
