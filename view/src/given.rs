//! The pictures that the command line gives to frames: the environment, and those of imported textures.

use std::path::PathBuf;

use umbragraph::diagnostic::{Diagnostic, Diagnostics, Severity};
use umbragraph::low_level::environment::{self, Environment};
use umbragraph::low_level::import::ImportFiles;
use umbragraph::{Error, Plan, wgpu};

use crate::arguments::Arguments;
use crate::stage::error_of;

/// The pictures of `--environment` and `--import`, and their state on the device.
pub(crate) struct Given {
    /// The picture of the environment and its path; `None` without one.
    environment: Option<(Environment, PathBuf)>,
    imports: ImportFiles,
    /// The reason why a picture of an import cannot be used; `None` if all can.
    unusable: Option<Error>,
}

impl Given {
    /// Reads the pictures of the command line.
    ///
    /// # Errors
    /// An environment that cannot be read. Pictures of imports are files under work: [`Given::error`] has their errors.
    pub(crate) fn read(arguments: &Arguments) -> Result<Self, Error> {
        let read = |path: &PathBuf| Ok((Environment::read(path).map_err(error_of)?, path.clone()));
        let environment = arguments.environment.as_ref().map(read).transpose()?;
        Ok(Self { environment, imports: ImportFiles::read(&arguments.imports), unusable: None })
    }

    /// The reason why a picture of an import cannot be used; `None` if all can.
    pub(crate) fn error(&self) -> Option<&Error> {
        self.unusable.as_ref()
    }

    /// The warnings about pictures that a plan does not read, and about textures that have no picture.
    pub(crate) fn warnings(&self, plan: &Plan) -> Vec<Diagnostic> {
        let environment = self.environment.as_ref();
        let unread = environment.and_then(|(_, path)| environment::unread(path, plan));
        let unread = unread.into_iter().chain(self.imports.unknown(plan));
        let empty = self.imports.empty(plan, environment.is_some());
        empty.chain(unread.map(|one| one.severity(Severity::Warning))).collect()
    }

    /// Reads the pictures of imports whose files have changed. Returns `true` if there were any.
    pub(crate) fn read_again(&mut self, plan: Option<&Plan>) -> bool {
        let is_read = self.imports.read_again();
        if let (true, Some(plan)) = (is_read, plan) {
            self.judge(plan);
        }
        is_read
    }

    /// Takes note of a new plan.
    pub(crate) fn planned(&mut self, plan: &Plan) {
        // What a plan makes of the picture may not outlive it.
        self.environment.iter_mut().for_each(|(environment, _)| environment.read_again());
        self.judge(plan);
    }

    /// Updates the error of the pictures of imports.
    fn judge(&mut self, plan: &Plan) {
        let errors: Diagnostics = self.imports.errors(plan).into_iter().collect();
        self.unusable = (!errors.is_empty()).then(|| Error::new(errors, &plan.pipeline.sources));
    }

    /// Writes the pictures to the textures of a plan that do not contain them, and adds the toggle of an environment
    /// that is as before to `toggles`.
    pub(crate) fn bring<'a>(
        &mut self,
        queue: &wgpu::Queue,
        plan: &Plan,
        imports: &[(&'a str, &'a wgpu::Texture)],
        toggles: &mut Vec<(&'a str, bool)>,
    ) {
        self.imports.bring(queue, plan, imports.iter().copied());
        if let Some((environment, _)) = &mut self.environment {
            environment.bring(queue, imports.iter().copied());
            let kept = environment.kept(plan).filter(|(name, _)| !toggles.iter().any(|one| one.0 == *name));
            toggles.extend(kept.map(|(name, (_, is_on))| (name, is_on)));
        }
    }

    /// Takes note of a frame that was drawn.
    pub(crate) fn drawn(&mut self) {
        self.environment.iter_mut().for_each(|(environment, _)| environment.drawn());
    }
}
