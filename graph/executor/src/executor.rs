//! A plan on a device, and the frames that it records.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use umbragraph_compiler::{Physical, Plan, PlannedPass, Switches};
use umbragraph_pipeline::Error;
use umbragraph_pipeline::data::BlackboardData;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, codes};

use crate::binding::draw::DrawSource;
use crate::binding::groups;
use crate::drawing::redraw;
use crate::frame::input::Frame;
use crate::frame::record::Scratch;
use crate::frame::{inputs, record};
use crate::instance::instantiate::{Instantiated, InstantiatedPass, InstantiatedWork};
use crate::instance::parameters::{Parameter, ParameterValue};
use crate::instance::preparation::{Preparation, Prepared};
use crate::measure::gpu_times::{GpuTime, GpuTimes};
use crate::measure::statistics::{PassCounts, Statistics};
use crate::measure::times::Times;
use crate::memory::imports::ImportPart;
use crate::memory::pool::Pool;
use crate::objects::creation;
use crate::objects::creation::{Caught, Creation, reject};
use umbragraph_pipeline::frame::FrameInput;

/// A plan, instantiated on a device.
pub struct Executor {
    preparation: Preparation,
    queue: wgpu::Queue,
    instantiated: Instantiated,
    pool: Pool,
    scratch: Scratch,
    times: Times,
    gpu_times: GpuTimes,
    statistics: Statistics,
    warnings: Diagnostics,
    /// Errors of creation that a browser has not told yet.
    late: Caught,
    /// The number of records so far.
    records: u64,
}

impl Executor {
    /// Instantiates a plan. `source` says how the host's meshes are stored, where the plan does not know it.
    ///
    /// In a browser errors of the device arrive late; a record reports them then.
    ///
    /// # Errors
    /// A host whose interface does not fit the shaders, a device that lacks what the plan needs or is lost, errors of the
    /// device.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        plan: Arc<Plan>,
        source: Option<&dyn DrawSource>,
    ) -> Result<Self, Error> {
        let preparation = Preparation { device: device.clone(), objects: Arc::default() };
        Self::with(preparation, queue, plan, source)
    }

    /// The same with the shader modules, layouts and pipelines of another executor, on its device. What one of them makes
    /// from here on serves both.
    ///
    /// # Errors
    /// As of [`Executor::new`].
    pub fn beside(other: &Executor, plan: Arc<Plan>, source: Option<&dyn DrawSource>) -> Result<Self, Error> {
        Self::with(other.preparation(), &other.queue, plan, source)
    }

    fn with(
        preparation: Preparation,
        queue: &wgpu::Queue,
        plan: Arc<Plan>,
        source: Option<&dyn DrawSource>,
    ) -> Result<Self, Error> {
        let mut statistics = Statistics::default();
        let (instantiated, late) = preparation.instantiate(&mut statistics, plan, source, None)?;
        Ok(Self {
            preparation,
            queue: queue.clone(),
            instantiated,
            pool: Pool::default(),
            scratch: Scratch::default(),
            times: Times::default(),
            gpu_times: GpuTimes::default(),
            statistics,
            warnings: Diagnostics::new(),
            late,
            records: 0,
        })
    }

    /// Instantiates another plan: after a resize, with other parameters or features, or for another draw source.
    ///
    /// What does not change is kept: pipelines and samplers of equal descriptors, textures and buffers of equal
    /// descriptors (those that outlive frames under their own names, with their contents), blackboard data. For as long
    /// as it takes, the textures of both plans exist.
    ///
    /// # Errors
    /// As of [`Executor::new`]. The executor goes on with the plan before.
    pub fn set_plan(&mut self, plan: Arc<Plan>, source: Option<&dyn DrawSource>) -> Result<(), Error> {
        let before = Some(&self.instantiated);
        let (instantiated, late) =
            self.preparation.instantiate(&mut self.statistics, plan, source, before)?;
        self.late.append(late);
        let before = std::mem::replace(&mut self.instantiated, instantiated);
        self.instantiated.parameters.go_on_from(&before.parameters);
        let Instantiated { resources, plan, .. } = &mut self.instantiated;
        let fits = |name: &str, buffer: &wgpu::Buffer| inputs::check_buffer(plan, name, buffer).is_ok();
        resources.imports.go_on_from(&before.resources.imports, fits);
        // Values that the other plan rejects are as it says them.
        let rejected = self.instantiated.apply_parameters();
        self.instantiated.cpu_passes.go_on_from(before.cpu_passes);
        self.warnings.extend(rejected.err().into_iter().flatten());
        Ok(())
    }

    /// What prepares plans for this executor, on any thread: [`Preparation::prepare`] makes their pipelines, and
    /// [`Executor::adopt`] takes them over in a frame.
    pub fn preparation(&self) -> Preparation {
        self.preparation.clone()
    }

    /// Takes over a plan that was prepared: as [`Executor::set_plan`], with nothing left to be made but textures, buffers
    /// and bind groups.
    ///
    /// # Errors
    /// As of [`Executor::set_plan`].
    pub fn adopt(&mut self, prepared: Prepared, source: Option<&dyn DrawSource>) -> Result<(), Error> {
        self.set_plan(prepared.plan, source)?;
        self.late.append(prepared.late);
        Ok(())
    }

    /// A live parameter, to be set from frame to frame.
    ///
    /// # Errors
    /// No such parameter; one that is structural, with the place that makes it so; one of another type.
    pub fn parameter<T: ParameterValue>(&self, name: &str) -> Result<Parameter<T>, Error> {
        Parameter::new(name, &self.instantiated.parameters).map_err(|found| self.error(found))
    }

    /// Sets a live parameter for the records to come. Nothing is planned or created. Another plan takes it over, if it has
    /// a live parameter of that name; handles are good for plans with the same parameters.
    ///
    /// # Errors
    /// A handle of another plan; a value out of range, or of another length. What a record does not accept of several
    /// values together it reports, and then all have the values of the record before.
    pub fn set<T: ParameterValue>(&mut self, parameter: Parameter<T>, value: T) -> Result<(), Error> {
        let at = if parameter.of == self.instantiated.parameters.id() { parameter.at } else { usize::MAX };
        let set = self.instantiated.parameters.set(at, &mut |to| value.assign(to));
        set.map_err(|found| self.error(found))
    }

    /// Gives a buffer of the host's for a resource with the lifetime `imported`, until another is given. Another plan
    /// takes it over, if it fits there.
    ///
    /// # Errors
    /// A name that is of no imported buffer of the plan; too few bytes; a usage that passes need and the buffer lacks.
    pub fn import_buffer(&mut self, name: &str, buffer: &wgpu::Buffer) -> Result<(), Error> {
        let resource = inputs::check_buffer(&self.instantiated.plan, name, buffer).map_err(|message| {
            let help = "create the buffer as the plan was made for it, or plan again";
            self.import_error(name, message, help)
        })?;
        if self.instantiated.resources.imports.set_buffer(resource, buffer) {
            let groups = self.instantiated.passes.iter_mut().flat_map(|pass| &mut pass.groups);
            groups.for_each(groups::Group::forget);
        }
        Ok(())
    }

    /// Lets a part of the host's textures stand for a resource with the lifetime `imported`, until it is told otherwise:
    /// a mip level, a layer of an array or a face of a cube, another format. The plan is made for the part's size and
    /// format. Another plan takes it over.
    ///
    /// # Errors
    /// A name that is of no imported texture of the plan; one that a pass copies.
    pub fn import_part(&mut self, name: &str, part: Option<ImportPart>) -> Result<(), Error> {
        let resource = inputs::check_part(&self.instantiated.plan, name).map_err(|message| {
            self.import_error(name, message, "draw into the part, or give a texture of its own")
        })?;
        self.instantiated.resources.imports.set_part(resource, part);
        Ok(())
    }

    fn import_error(&self, name: &str, message: String, help: &str) -> Error {
        let plan = &self.instantiated.plan;
        let place = plan.resources.get(name).map(|one| plan.pipeline.resource(one.handle).place);
        let place = place.map_or(Place::Nowhere, Place::from);
        self.error(Diagnostic::error(codes::IMPORT, place, message).help(help).into())
    }

    fn error(&self, found: Diagnostics) -> Error {
        Error::new(found, &self.instantiated.plan.pipeline.sources)
    }

    /// The plan.
    pub fn plan(&self) -> &Arc<Plan> {
        &self.instantiated.plan
    }

    /// The counts of objects created so far.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// The warnings about the last recorded frame: a camera or light that cannot be used. After [`Executor::set_plan`] and
    /// until the next record also the errors of live values that the new plan does not take.
    pub fn warnings(&self) -> &Diagnostics {
        &self.warnings
    }

    /// The notices of CPU passes from the last record: limits that were reached, what was left out and why.
    pub fn notices(&self) -> impl Iterator<Item = &Diagnostic> {
        self.instantiated.cpu_passes.notices()
    }

    /// The lights of the last recorded frame that no pass has read: they have no part in the picture.
    pub fn unread_lights<'f>(&self, frame: &'f FrameInput) -> Vec<&'f str> {
        self.instantiated.cpu_passes.unread_lights(frame)
    }

    /// The sizes that CPU passes want other than the plan has them, for [`umbragraph_compiler::PlanOptions::data_sizes`];
    /// `None` if they are content. A frame is right without them too, only not as good.
    pub fn wanted_sizes(&self) -> Option<BTreeMap<String, u32>> {
        self.instantiated.cpu_passes.wanted_sizes()
    }

    /// The data that a CPU pass published in the last record, by the name of its resource.
    pub fn data(&self, name: &str) -> Option<&BlackboardData> {
        self.instantiated.cpu_passes.data(name)
    }

    /// Forgets what earlier frames left: the next record begins every history with its initial value, as after a cut to
    /// another scene, or when a record's encoder was never submitted, and draws all views that were kept.
    pub fn reset_history(&mut self) {
        self.instantiated.resources.histories.reset();
        self.instantiated.kept.iter_mut().for_each(redraw::Kept::forget);
    }

    /// The texture that stands for a resource, unless it is the host's own. Others may share it within a frame. That of
    /// a history is the one that the last record wrote; `NAME@-1` is the one before.
    pub fn texture(&self, name: &str) -> Option<&wgpu::Texture> {
        match self.instantiated.resources.physical(&self.instantiated.plan, name)? {
            Physical::Texture(index) => self.instantiated.resources.textures.texture(index),
            _ => None,
        }
    }

    /// The buffer that stands for a resource. Others may share it within a frame.
    pub fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        match self.instantiated.resources.physical(&self.instantiated.plan, name)? {
            Physical::Buffer(index) => self.instantiated.resources.textures.buffer(index),
            _ => None,
        }
    }

    /// Switches measuring of the processor's time for each pass on or off; off at first.
    pub fn measure_times(&mut self, on: bool) {
        self.times.switch(on);
    }

    /// The processor's time for each pass of the last record, in the plan's order; nothing if measuring is off. Passes
    /// that are recorded as one render pass count with the first of them; those that are left out count nothing.
    pub fn times(&self) -> impl Iterator<Item = (&str, Duration)> {
        let names = self.instantiated.plan.passes.iter().map(|pass| pass.name.as_str());
        names.zip(self.times.passes.iter().copied())
    }

    /// When the processor began with each pass of [`Executor::times`], from the begin of the record on.
    pub fn starts(&self) -> impl Iterator<Item = Duration> {
        self.times.starts.iter().copied()
    }

    /// Switches measuring of the GPU's time for each pass on or off; off at first. Whether the device can measure it: it
    /// needs the feature `timestamp-query`, and for copies `TIMESTAMP_QUERY_INSIDE_ENCODERS`.
    pub fn measure_gpu_times(&mut self, on: bool) -> bool {
        self.gpu_times.switch(on, &self.preparation.device)
    }

    /// The GPU's time for each pass of the last record, in the order in which they began. Its encoder has to be submitted;
    /// this waits until the GPU is done. Nothing if measuring is off, or when asked a second time.
    pub fn gpu_times(&mut self) -> Vec<GpuTime> {
        self.gpu_times.take(&self.preparation.device, &self.queue)
    }

    /// The passes that the last record left out, since their toggles are switched that way; in the plan's order.
    pub fn skipped(&self) -> impl Iterator<Item = &str> {
        let instantiated = &self.instantiated;
        let skipped = |pass: &&PlannedPass| !instantiated.switches().runs(&instantiated.plan, pass.handle);
        instantiated.plan.passes.iter().filter(skipped).map(|pass| pass.name.as_str())
    }

    /// For each pass that draws the host's meshes, what the last record has drawn.
    pub fn pass_counts(&self) -> impl Iterator<Item = (&str, PassCounts)> {
        let passes = self.instantiated.plan.passes.iter().zip(&self.instantiated.passes);
        let draws = |pass: &InstantiatedPass| matches!(pass.work, InstantiatedWork::Scene { .. });
        let drawn = passes.zip(&self.scratch.counts).filter(move |((_, pass), _)| draws(pass));
        drawn.map(|((planned, _), counts)| (planned.name.as_str(), *counts))
    }

    /// The processor's time for preparing bind groups and uploading blocks in the last record.
    pub fn preparation_time(&self) -> Duration {
        self.times.preparation
    }

    /// Records a frame into an encoder. Several records in one submission do not disturb one another.
    ///
    /// Each record is a frame of its own to histories: what one writes to `color`, the next one reads as `color@-1`, also
    /// within one submission. Encoders have to be submitted in the order of their records.
    ///
    /// # Errors
    /// Live parameters that do not go together; imports that are missing or not as planned; toggles that the pipeline does
    /// not have; a draw source that is missing, or stores meshes otherwise than the plan was instantiated for;
    /// blackboard data that a CPU pass did not declare; textures of another device; errors of the device. Nothing is
    /// recorded then, and the next frame is possible. Draws of the host that fail or panic are an error, too; what else
    /// is in the frame is recorded.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder, frame: &Frame<'_>) -> Result<(), Error> {
        self.try_record(encoder, frame).map_err(|found| self.error(found))
    }

    fn try_record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame<'_>,
    ) -> Result<(), Diagnostics> {
        reject(self.late.known())?;
        let mut diagnostics = inputs::check(&self.instantiated, frame);
        diagnostics.extend(Switches::check(&self.instantiated.plan, frame.toggles));
        reject(diagnostics)?;
        self.instantiated.apply_parameters()?;
        self.instantiated.cpu_passes.switch(frame.toggles);
        self.warnings = Diagnostics::new();
        inputs::warnings(frame, &mut self.warnings);
        self.times.reset(self.instantiated.plan.passes.len());
        inputs::run_cpu_passes(&mut self.instantiated, frame, &mut self.times)?;
        let start = self.times.now();
        self.prepare(encoder, frame)?;
        self.times.add_preparation(start);
        self.gpu_times.reset(&self.preparation.device);
        record::record(
            &mut self.instantiated,
            encoder,
            frame,
            self.records,
            &mut self.scratch,
            &mut self.times,
            &self.gpu_times,
        );
        self.gpu_times.resolve(encoder);
        let failures = self.scratch.failures(&self.instantiated.plan);
        if !failures.is_empty() {
            // What was left out is drawn again.
            self.instantiated.kept.iter_mut().for_each(redraw::Kept::forget);
        }
        reject(failures)
    }

    /// Creates what the record needs and uploads its blocks.
    fn prepare(&mut self, encoder: &wgpu::CommandEncoder, frame: &Frame<'_>) -> Result<(), Diagnostics> {
        self.records += 1;
        let mut creation = Creation::new(&self.preparation.device, &mut self.statistics);
        let size = self.instantiated.blocks.size;
        let blocks = (size > 0).then(|| self.pool.take(&mut creation, encoder, size, self.records));
        let prepared = record::prepare(
            &mut self.instantiated,
            &mut creation,
            &self.queue,
            frame,
            blocks.as_ref(),
            self.records,
        );
        if let (Some(blocks), Ok(())) = (&blocks, &prepared) {
            // Within the scopes of the creation, if there are any: on a device that is lost, a new buffer is none.
            let Instantiated { plan, cpu_passes, blocks: packed, .. } = &mut self.instantiated;
            for (offset, bytes) in packed.pack(plan, cpu_passes) {
                self.queue.write_buffer(blocks, offset, bytes);
            }
        }
        let has_created = creation.has_created();
        let mut caught = creation.finish();
        let mut diagnostics = caught.known();
        self.late.append(caught);
        if has_created {
            diagnostics.extend(creation::lost(&self.preparation.device));
        }
        diagnostics.extend(prepared.err());
        if diagnostics.has_errors() {
            record::forget(&mut self.instantiated);
            self.pool.forget();
            return Err(diagnostics);
        }
        Ok(())
    }
}
