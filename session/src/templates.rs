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

/// A template, or the axes beside one, and where its text is. One that is in no library takes the place of one of its
/// name that is; otherwise a name that is given twice is a diagnostic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Template {
    /// The name by which other templates include this one.
    pub name: String,
    /// The text.
    pub text: TemplateText,
}

/// The source of a template's text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TemplateText {
    /// A template in a file, below some roots.
    File {
        /// The path.
        path: PathBuf,
        /// The folders below which the file must lie.
        roots: Roots,
    },
    /// A text in memory.
    Text(Arc<str>),
    /// A template of a library. Its bindings give way to those of the others; diagnostics show it below a folder.
    Library {
        /// The folder.
        folder: &'static str,
        /// The text.
        text: &'static str,
    },
}

/// Templates that were read, with the shader modules made of them.
#[derive(Debug)]
pub(crate) struct Templates {
    pub(crate) set: Arc<TemplateSet>,
    pub(crate) diagnostics: Diagnostics,
    /// Their files, in the order in which they were read.
    pub(crate) files: Vec<FileId>,
    /// The files of those that are in no library.
    pub(crate) own: BTreeSet<FileId>,
    reads: Vec<Read>,
    shaders: Mutex<Vec<Arc<ShaderCache>>>,
    pub(crate) proofs: Mutex<Vec<Proof>>,
}

/// Shader variants, as template and values, and the positions of the profiles whose configurations reach each.
pub(crate) type Reached = BTreeMap<(String, AxisValues), Vec<usize>>;

/// Shader variants that were proven for some profiles, and the diagnostics.
#[derive(Clone, Debug)]
pub(crate) struct Proof {
    pub(crate) variants: Reached,
    pub(crate) profiles: Vec<TargetProfile>,
    pub(crate) diagnostics: Diagnostics,
}

impl Templates {
    /// Reads the templates, and takes over what is known of those that are as they were before.
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

    /// The modules and proofs that hold for another set as well.
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

    /// The shader modules for a profile.
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
