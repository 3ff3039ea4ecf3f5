//! [`Renderer`]: records a pipeline frame by frame, and plans again after changes.

use std::sync::Arc;

use crate::executor::Import;
use crate::front::{Options, Pipeline};
use crate::low_level::compiler::ImportDescriptor;
use crate::{Error, Executor, Frame, Plan, wgpu};

/// Records frames of a pipeline, and plans again when an input differs from the frame before. Such inputs are the
/// pipeline (as after a reload), the options, and the format, size or usages of the host's textures.
///
/// While no input changes, recording is [`Executor::record`]. An application that controls when it plans, or that plans
/// on another thread ([`Executor::preparer`]), uses an executor of its own.
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    executor: Option<Executor>,
    made_of: Option<MadeOf>,
    /// Whether the draw source may declare other mesh layouts than before.
    #[cfg(feature = "watch")]
    pub(super) has_new_source: bool,
}

/// The inputs of the last attempt to plan, whether or not it succeeded.
struct MadeOf {
    pipeline: Pipeline,
    options: Options,
    imports: Vec<(String, ImportDescriptor)>,
}

impl Renderer {
    /// Creates a renderer on a device, without a plan.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self {
            device: device.clone(),
            queue: queue.clone(),
            executor: None,
            made_of: None,
            #[cfg(feature = "watch")]
            has_new_source: false,
        }
    }

    /// Records a frame into an encoder.
    ///
    /// # Errors
    /// The errors of [`Pipeline::plan`], [`Executor::new`] and [`Executor::record`]. A failure to plan is reported
    /// once. Until an input changes, the previous plan is used; without one, nothing is recorded.
    pub fn record(
        &mut self,
        pipeline: &Pipeline,
        options: &Options,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame<'_>,
    ) -> Result<(), Error> {
        if !self.made_of.as_ref().is_some_and(|made_of| made_of.is_of(pipeline, options, frame)) {
            let imports = frame.imports.iter();
            self.made_of = Some(MadeOf {
                pipeline: pipeline.clone(),
                options: options.clone(),
                imports: imports.map(|(name, import)| (name.to_owned(), import.descriptor())).collect(),
            });
            let plan = pipeline.plan(&options.clone().imports(frame.imports))?;
            self.install(plan, frame)?;
        }
        self.executor.as_mut().map_or(Ok(()), |executor| executor.record(encoder, frame))
    }

    /// Installs a plan, with the mesh layouts that the frame's draw source declares.
    pub(super) fn install(&mut self, plan: Arc<Plan>, frame: &Frame<'_>) -> Result<(), Error> {
        match (&mut self.executor, frame.draws) {
            (Some(executor), Some(draws)) => executor.set_plan_and_source(plan, draws),
            (Some(executor), None) => executor.set_plan(plan),
            (none, _) => {
                *none = Some(Executor::new(&self.device, &self.queue, plan, frame.draws)?);
                Ok(())
            }
        }
    }

    /// Returns the executor, for live parameters, times and exposed resources; `None` before the first planned frame.
    pub fn executor(&mut self) -> Option<&mut Executor> {
        self.executor.as_mut()
    }
}

impl MadeOf {
    fn is_of(&self, pipeline: &Pipeline, options: &Options, frame: &Frame<'_>) -> bool {
        let is_same =
            |((name, known), (given, import)): (&(String, ImportDescriptor), (&str, Import<'_>))| {
                name == given && *known == import.descriptor()
            };
        self.pipeline == *pipeline
            && self.options == *options
            && self.imports.len() == frame.imports.iter().len()
            && self.imports.iter().zip(frame.imports.iter()).all(is_same)
    }
}
