//! The picture of a watched pipeline, drawn again after each change on a device that stays open.

use std::path::{Path, PathBuf};

use umbragraph::diagnostic::Diagnostics;
use umbragraph::scene::Scene;

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
    scene: Option<(Stamps, Scene)>,
}

impl Painter {
    /// Creates a painter that renders a scene to a file.
    pub(super) fn new((out, scene): (&PathBuf, &PathBuf)) -> Self {
        Self { out: out.clone(), path: scene.clone(), graphics: None, scene: None }
    }

    /// Returns the files that the picture depends on besides the pipeline.
    pub(super) fn files(&self) -> impl Iterator<Item = PathBuf> + use<> {
        std::iter::once(self.path.clone())
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
        let stamps = Stamps::of([self.path.as_path()]);
        match &self.scene {
            Some((known, scene)) if *known == stamps => session.diagnostics.extend(scene.warnings.clone()),
            _ => self.scene = Some((stamps, session.scene(&self.path)?)),
        }
        if self.graphics.is_none() {
            self.graphics = Some(device::open(None)?);
        }
        let (Some(graphics), Some((_, scene))) = (&self.graphics, &self.scene) else { return Ok(()) };
        let checked = session.check_on(graphics, checked, pipeline, choices);
        session.ensure_fine(&checked)?;
        let options = Session::options(choices);
        let mut drawing = Drawing::new(graphics, scene, checked, options, session, Given::default())?;
        let input = drawing.input(&CameraPath::of(None)?, Shot { index: 0, time: 0.0, part: 0.0 });
        drawing.frame(&input)?;
        session.diagnostics.extend(drawing.note());
        write_png(&self.out, choices.size, &drawing.shown()?, Compression { fast: true })?;
        Ok(())
    }
}
