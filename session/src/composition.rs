//! A document composed of its files, and the files on which that depends.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use crate::cancel::{Cancel, Cancelled};
use crate::choice::Target;
use crate::done::Done;
use crate::files::{FileTable, Read, Role};
use crate::graph::compose::{self, Composed, Roots};
use crate::graph::diagnostic::{Diagnostic, Diagnostics};
use crate::graph::document::Document;
use crate::graph::model::Model;
use crate::graph::source::{FileId, Sources};

/// A pipeline document composed of its files, with its diagnostics and the files that it depends on.
#[derive(Debug)]
pub(crate) struct Composition {
    /// The composed document; `None` if a file is broken or missing.
    pub(crate) composed: Option<Arc<Composed>>,
    /// The composed document without its broken and missing parts; `None` if the first file cannot be read.
    pub(crate) understood: Option<Arc<Composed>>,
    model: OnceLock<Model>,
    pub(crate) diagnostics: Diagnostics,
    /// The files that were read or searched for, in this order.
    pub(crate) reads: Vec<Read>,
    pub(crate) files: Vec<FileId>,
    /// The file contents that source places refer to.
    pub(crate) sources: Sources,
    /// The diagnostics of the JSON schema check, computed at the first request.
    pub(crate) schema: OnceLock<Diagnostics>,
}

impl Composition {
    pub(crate) fn new(
        target: &Target,
        further: &Roots,
        files: &mut FileTable,
        (done, cancel): (&mut Done, &Cancel),
    ) -> Result<Self, Cancelled> {
        done.composed += 1;
        let mut diagnostics = Diagnostics::new();
        let mut reading = Vec::new();
        let composed = files.with_sources(|files, sources| {
            let reader = Reader { files, roots: None, reads: Vec::new(), read: Vec::new(), done, cancel };
            let diagnostics = &mut diagnostics;
            let mut composing = Composing { reader, further, sources, diagnostics, is_lenient: false };
            let composed = composing.pipeline(target).map(Arc::new);
            let understood = composed.clone().or_else(|| {
                composing.is_lenient = true;
                composing.pipeline(target).map(Arc::new)
            });
            let Reader { reads, read, .. } = composing.reader;
            reading = read;
            cancel.check().map(|()| (composed, understood, reads))
        });
        let (composed, understood, reads) = composed?;
        let (sources, files) = (files.settled().clone(), reading);
        let (model, schema) = (OnceLock::new(), OnceLock::new());
        Ok(Self { composed, understood, model, diagnostics, reads, files, sources, schema })
    }

    /// Returns the declarations and strings of the document; `None` if the first file cannot be read.
    pub(crate) fn model(&self) -> Option<&Model> {
        let understood = self.understood.as_ref()?;
        Some(self.model.get_or_init(|| Model::new(&understood.document)))
    }
}

struct Composing<'a> {
    reader: Reader<'a>,
    further: &'a Roots,
    sources: &'a mut Sources,
    diagnostics: &'a mut Diagnostics,
    /// Whether broken or missing files are skipped without a diagnostic.
    is_lenient: bool,
}

impl Composing<'_> {
    fn pipeline(&mut self, target: &Target) -> Option<Composed> {
        let mut composed = self.file(&target.path, None)?;
        let mut scratch = Diagnostics::new();
        for extension in &target.extensions {
            match self.file(extension, None) {
                Some(extension) => composed.insert(extension, self.reported(&mut scratch)),
                None if self.is_lenient => {}
                None => return None,
            }
        }
        if let Some((name, text)) = &target.included {
            let included = self.file(Path::new(name), Some(text))?;
            composed.include(included, self.reported(&mut scratch));
        }
        Some(composed)
    }

    /// Returns the diagnostics to report to: `scratch`, which is dropped, if composing is lenient.
    fn reported<'s>(&'s mut self, scratch: &'s mut Diagnostics) -> &'s mut Diagnostics {
        if self.is_lenient { scratch } else { self.diagnostics }
    }

    fn file(&mut self, path: &Path, text: Option<&str>) -> Option<Composed> {
        // What the host names it may read, wherever it lies.
        self.reader.roots = None;
        let file = match text {
            Some(text) => Ok(self.reader.text(path, text, self.sources)),
            None => compose::Files::read(&mut self.reader, path, self.sources),
        };
        match file {
            Ok(file) => {
                self.reader.roots = Some(Roots::of(path).with(self.further));
                if self.is_lenient {
                    return compose::compose_understood(file, path, &mut self.reader, self.sources);
                }
                compose::compose(file, path, &mut self.reader, self.sources, self.diagnostics)
            }
            Err(diagnostic) => {
                if !self.is_lenient {
                    self.diagnostics.push(diagnostic);
                }
                None
            }
        }
    }
}

/// Reads files for a composition, and records the files that were read or searched for.
struct Reader<'a> {
    files: &'a mut FileTable,
    roots: Option<Roots>,
    reads: Vec<Read>,
    read: Vec<FileId>,
    done: &'a mut Done,
    cancel: &'a Cancel,
}

impl Reader<'_> {
    fn text(&mut self, path: &Path, text: &str, sources: &mut Sources) -> FileId {
        let file = self.files.text(&path.display().to_string(), text, sources);
        self.read.push(file);
        file
    }
}

impl compose::Files for Reader<'_> {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        let result = self.files.read(path, self.roots.as_ref(), Role::Document, sources, self.done);
        self.reads.push(Read { path: path.to_owned(), revision: self.files.revision(path) });
        self.read.extend(&result);
        result
    }

    fn parse(&mut self, file: FileId, sources: &Sources) -> Result<Document, Diagnostics> {
        if self.cancel.check().is_err() {
            return Err(Diagnostics::new());
        }
        self.files.document(file, sources, self.done)
    }

    fn recover(&mut self, file: FileId, sources: &Sources) -> Document {
        self.files.parsed(file, sources, self.done).document.clone()
    }

    fn has_scheme(&self, scheme: &str) -> bool {
        self.files.has_scheme(scheme)
    }
}
