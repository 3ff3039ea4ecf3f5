//! The templates of a session, and what is kept of their shaders.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use crate::done::Done;
use crate::files::{FileTable, Read, Role};
use crate::graph::compose::Roots;
use crate::graph::diagnostic::Diagnostics;
use crate::graph::shader::{AxisValues, ShaderCache, TargetProfile, TemplateSet};
use crate::graph::source::FileId;

/// A shader template, or the axis declarations of one, by name and source. A template outside libraries replaces the
/// library template of the same name. Any other duplicate name is reported as a diagnostic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Template {
    /// The name by which other templates include this one.
    pub name: String,
    /// The source of the template's content.
    pub text: TemplateText,
}

/// The source of a template's content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TemplateText {
    /// A file, which must lie below one of some root folders.
    File {
        /// The path of the file.
        path: PathBuf,
        /// The folders below which the file must lie.
        roots: Roots,
    },
    /// A text in memory.
    Text(Arc<str>),
    /// A text in memory that belongs to a library. Its bindings get other numbers if they collide with those of other
    /// templates.
    Library {
        /// The folder that diagnostics show before the template's name.
        folder: &'static str,
        /// The content of the template.
        text: &'static str,
    },
}

/// The shader templates of a session as they were read, with cached shader modules and validation results.
#[derive(Debug)]
pub(crate) struct Templates {
    pub(crate) set: Arc<TemplateSet>,
    pub(crate) diagnostics: Diagnostics,
    /// The files of the templates, in the order in which they were read.
    pub(crate) files: Vec<FileId>,
    /// The files of the templates that belong to no library.
    pub(crate) own: BTreeSet<FileId>,
    reads: Vec<Read>,
    shaders: Mutex<Vec<Arc<ShaderCache>>>,
    pub(crate) proofs: Mutex<Vec<Proof>>,
}

/// Shader variants, by template name and axis values, each with the indices of the profiles whose configurations use
/// it.
pub(crate) type Reached = BTreeMap<(String, AxisValues), Vec<usize>>;

/// The result of validating shader variants for target profiles: the inputs, and the diagnostics.
#[derive(Clone, Debug)]
pub(crate) struct Proof {
    pub(crate) variants: Reached,
    pub(crate) profiles: Vec<TargetProfile>,
    pub(crate) diagnostics: Diagnostics,
}

impl Templates {
    /// Reads the templates in a list. Keeps the cached results of `before` for templates that have not changed since.
    pub(crate) fn read(
        list: &[Template],
        before: Option<&Self>,
        files: &mut FileTable,
        done: &mut Done,
    ) -> Self {
        let (mut set, mut diagnostics) = (TemplateSet::new(), Diagnostics::new());
        let (mut slots, mut own, mut reads) = (Vec::new(), BTreeSet::new(), Vec::new());
        let is_own = |one: &&Template| !matches!(one.text, TemplateText::Library { .. });
        let taken: BTreeSet<&str> = list.iter().filter(is_own).map(|one| one.name.as_str()).collect();
        files.with_sources(|files, sources| {
            for Template { name, text } in
                list.iter().filter(|one| is_own(one) || !taken.contains(one.name.as_str()))
            {
                done.templates += 1;
                let file = match text {
                    TemplateText::File { path, roots } => {
                        let read = files.read(path, Some(roots), Role::Template, sources, done);
                        reads.push(Read { path: path.clone(), revision: files.revision(path) });
                        match read {
                            Ok(file) => file,
                            Err(diagnostic) => {
                                set.add_unreadable(sources, name, diagnostic, &mut diagnostics);
                                continue;
                            }
                        }
                    }
                    TemplateText::Text(text) => files.text(name, text, sources),
                    TemplateText::Library { folder, text } => {
                        let file = files.text(&format!("{folder}/{name}"), text, sources);
                        slots.push(file);
                        set.add_library_file(sources, file, name, &mut diagnostics);
                        continue;
                    }
                };
                slots.push(file);
                own.insert(file);
                set.add_file(sources, file, name, &mut diagnostics);
            }
        });
        set.check(&mut diagnostics);
        let (set, files) = (Arc::new(set), slots);
        let (shaders, proofs) = before.map(|before| before.kept(&set)).unwrap_or_default();
        let (shaders, proofs) = (Mutex::new(shaders), Mutex::new(proofs));
        Self { set, diagnostics, files, own, reads, shaders, proofs }
    }

    /// Returns the shader modules and successful validation results of templates that are unchanged in another set.
    fn kept(&self, set: &Arc<TemplateSet>) -> (Vec<Arc<ShaderCache>>, Vec<Proof>) {
        let unchanged = set.unchanged_since(&self.set);
        let carried = |one: &Arc<ShaderCache>| Arc::new(ShaderCache::carrying(one, set, &unchanged));
        let shaders = self.shaders.lock().unwrap_or_else(PoisonError::into_inner);
        let is_kept = |proof: &&Proof| {
            proof.diagnostics.is_empty()
                && proof.variants.keys().all(|(name, _)| unchanged.contains(name.as_str()))
        };
        let proofs = self.proofs.lock().unwrap_or_else(PoisonError::into_inner);
        (shaders.iter().map(carried).collect(), proofs.iter().filter(is_kept).cloned().collect())
    }

    pub(crate) fn is_current(&self, files: &FileTable) -> bool {
        files.are_unchanged(&self.reads)
    }

    /// Returns the cache of shader modules for a target profile; creates the cache at the first call.
    pub(crate) fn shaders(&self, profile: &TargetProfile) -> Arc<ShaderCache> {
        let mut all = self.shaders.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = all.iter().find(|known| known.profile() == profile) {
            return known.clone();
        }
        let new = match all.first() {
            Some(first) => ShaderCache::beside(first, profile),
            None => ShaderCache::new(&self.set, profile),
        };
        let new = Arc::new(new);
        all.push(new.clone());
        new
    }
}
