//! Frames of a watched pipeline: where the watcher's thread and the renderer meet.

use std::sync::Arc;

use crate::front::{Options, Renderer};
use crate::{Error, Frame, wgpu};

use super::{Ready, Watcher};

impl Renderer {
    /// Records a frame of a pipeline that follows its files. Returns `true` if there was a plan to record. The
    /// watcher's finished plan is installed first. A new size, format or usage of the host's textures is planned at
    /// once. Other options are planned on the watcher's thread, and the previous plan is used until then.
    ///
    /// # Errors
    /// The errors of [`Renderer::record`], except errors in files or options, which [`Watcher::error`] returns.
    pub fn record_watched(
        &mut self,
        watcher: &mut Watcher,
        options: &Options,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame<'_>,
    ) -> Result<bool, Error> {
        let options = options.clone();
        let options = if watcher.has_declared_imports { options } else { options.imports(frame.imports) };
        watcher.receive();
        watcher.tell(&options, self.executor().map(|executor| executor.preparer()));
        if let Some(ready) = watcher.take_ready(&options) {
            self.take_over(watcher, *ready, frame);
        } else if self.executor().is_some()
            && let Some(plan) = watcher.plan_for_others(&options)?
        {
            self.install(plan, frame)?;
        }
        if self.has_new_source {
            if let Some(plan) = self.executor().map(|executor| executor.plan().clone()) {
                self.install(plan, frame)?;
                // Plans from here on are prepared for the new meshes.
                watcher.told = None;
            }
            self.has_new_source = false;
        }
        match self.executor() {
            Some(executor) => executor.record(encoder, frame).map(|()| true),
            None => Ok(false),
        }
    }

    /// Makes the next watched frame query its draw source for mesh layouts again. To be called after a scene was
    /// reloaded.
    pub fn renew_source(&mut self) {
        self.has_new_source = true;
    }

    fn take_over(&mut self, watcher: &mut Watcher, ready: Ready, frame: &Frame<'_>) {
        let taken = match (self.executor(), ready.prepared) {
            (Some(executor), _) if Arc::ptr_eq(executor.plan(), &ready.plan) => Ok(()),
            (Some(executor), Some(prepared)) => executor.set_prepared_plan(prepared),
            _ => self.install(ready.plan, frame),
        };
        watcher.took((ready.read, ready.warnings), ready.options, taken.map(|()| ready.reload));
    }
}
