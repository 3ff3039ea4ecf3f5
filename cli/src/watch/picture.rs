//! The picture of a watched pipeline, drawn again after each change on a device that stays open.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compose::read_bytes;
use umbragraph::scene::{self, Folder, ResolveError, Resolver, Scene};

use super::files::Stamps;
use crate::arguments::{Choices, Shot};
use crate::device::{self, Graphics};
use crate::render::files::{Compression, write_png};
use crate::render::{Drawing, Given};
use crate::session::Session;
use umbragraph::low_level::camera_path::CameraPath;

/// The state for rendering the picture after each change: output file, scene file, device and loaded scene.
pub(super) struct Painter {
    out: PathBuf,
    path: PathBuf,
    graphics: Option<Graphics>,
    /// The scene file, and the buffers and images that the scene was loaded from, as they were before they were read.
    stamps: Stamps,
    /// The loaded scene; `None` before the first one, and after an error.
    scene: Option<Scene>,
}

impl Painter {
    /// Creates a painter that renders a scene to a file.
    pub(super) fn new((out, scene): (&PathBuf, &PathBuf)) -> Self {
        let stamps = Stamps::of([scene.as_path()]);
        Self { out: out.clone(), path: scene.clone(), graphics: None, stamps, scene: None }
    }

    /// Returns the files that the picture depends on besides the pipeline, missing ones among them.
    pub(super) fn stamps(&self) -> &Stamps {
        &self.stamps
    }

    /// Loads the scene, and notes the files that it consists of.
    ///
    /// # Errors
    /// A scene that cannot be loaded.
    fn load(&mut self, session: &mut Session) -> Result<Scene, Diagnostics> {
        self.stamps = Stamps::of([self.path.as_path()]);
        let Ok(Some(bytes)) = read_bytes(&self.path, scene::MAX_FILE_BYTES) else {
            // It says why.
            return session.scene(&self.path);
        };
        let folder = self.path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let files = Folder::new(&folder).below(session.roots(&self.path));
        let noting = Noting { files, folder, stamps: Mutex::default() };
        let loaded = scene::from_slice(&self.path.display().to_string(), &bytes, &noting);
        let noted = noting.stamps.into_inner().unwrap_or_else(PoisonError::into_inner);
        self.stamps = std::mem::take(&mut self.stamps).and(&noted);
        loaded
    }

    /// Renders the picture and writes the file.
    ///
    /// # Errors
    /// Diagnostics that the session does not have already; the file is then left unchanged.
    pub(super) fn paint(
        &mut self,
        pipeline: &Path,
        choices: &Choices,
        session: &mut Session,
    ) -> Result<(), Diagnostics> {
        let checked = session.check(pipeline, choices);
        session.ensure_fine(&checked)?;
        if self.scene.is_none() || Stamps::of(self.stamps.paths()) != self.stamps {
            self.scene = None;
            self.scene = Some(self.load(session)?);
        }
        session.diagnostics.extend(self.scene.iter().flat_map(|scene| scene.warnings.clone()));
        if self.graphics.is_none() {
            self.graphics = Some(device::open(None)?);
        }
        let (Some(graphics), Some(scene)) = (&self.graphics, &self.scene) else { return Ok(()) };
        let checked = session.check_on(graphics, checked, pipeline, choices);
        session.ensure_fine(&checked)?;
        let options = Session::options(choices);
        let mut drawing = Drawing::new(graphics, scene, checked, options, session, Given::default())?;
        let input = drawing.input(&CameraPath::Scene, Shot { index: 0, time: 0.0, part: 0.0 });
        drawing.frame(&input)?;
        session.diagnostics.extend(drawing.note());
        write_png(&self.out, choices.size, &drawing.shown()?, Compression { fast: true })?;
        Ok(())
    }
}

/// Reads the files that a scene references, and records the path, size and modification time of each before it is read.
struct Noting {
    files: Folder,
    folder: PathBuf,
    stamps: Mutex<Stamps>,
}

impl Resolver for Noting {
    fn read(&self, path: &str) -> Result<Vec<u8>, ResolveError> {
        let mut stamps = self.stamps.lock().unwrap_or_else(PoisonError::into_inner);
        *stamps = std::mem::take(&mut *stamps).with_file(self.folder.join(path));
        drop(stamps);
        self.files.read(path)
    }
}
