//! [`Renderer`]: a pipeline recorded frame by frame, whatever becomes of it.

use std::sync::Arc;

use crate::executor::Import;
use crate::front::{Options, Pipeline};
use crate::low_level::compiler::ImportDescriptor;
use crate::{Error, Executor, Frame, Plan, wgpu};

/// Records frames of a pipeline, and plans it anew where something is other than in the frame before: the pipeline (as
/// when its file was loaded again), the options, the format, the size or the usages of the host's textures.
///
/// In a frame in which nothing is, this is [`Executor::record`]. An application that wants to say itself when it plans,
/// or to plan off its thread ([`Executor::preparer`]), has an executor of its own instead.
pub struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    executor: Option<Executor>,
    made_of: Option<MadeOf>,
    /// Whether meshes may be stored otherwise than the draw source said.
    #[cfg(feature = "watch")]
    pub(super) has_new_source: bool,
}

/// The inputs of the last plan, whether planning succeeded or not.
struct MadeOf {
    pipeline: Pipeline,
    options: Options,
    imports: Vec<(String, ImportDescriptor)>,
}

impl Renderer {
    /// A renderer on a device, with nothing made yet.
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
    /// As of [`Pipeline::plan`], [`Executor::new`] and [`Executor::record`]. What cannot be planned or made is said
    /// once; until something changes, the plan before goes on, and nothing is recorded where there is none.
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

    /// Installs a plan, with meshes stored as the frame's draw source declares.
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

    /// The executor, once there was a frame: for live parameters, times, exposed resources.
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
