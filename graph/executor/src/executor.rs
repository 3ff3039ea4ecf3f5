//! A plan on a device, and the frames that it records.

use std::collections::BTreeMap;
use std::marker::PhantomData;
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
use crate::instance::preparation::{PlanPreparer, PreparedPlan};
use crate::measure::gpu_times::{GpuTime, GpuTimes};
use crate::measure::statistics::{PassCounts, Statistics};
use crate::measure::times::Times;
use crate::memory::imports::{Given, ImportHandle, Importable};
use crate::memory::pool::Pool;
use crate::memory::read_back::{Texels, read_back};
use crate::objects::creation::{Caught, Creation, reject};
use umbragraph_pipeline::frame::FrameInput;

/// A plan with its textures, buffers, pipelines and bind groups on a device. It records frames of the plan into command
/// encoders.
pub struct Executor {
    preparation: PlanPreparer,
    queue: wgpu::Queue,
    instantiated: Instantiated,
    pool: Pool,
    scratch: Scratch,
    times: Times,
    gpu_times: GpuTimes,
    statistics: Statistics,
    warnings: Diagnostics,
    /// Device errors of object creation that a later record reports; only browsers report errors with such a delay.
    late: Caught,
    /// The number of records so far.
    records: u64,
}

impl Executor {
    /// Instantiates a plan. `source` declares the layout of the host's meshes, if the plan does not contain it.
    ///
    /// In a browser, errors of the device arrive late; a later record reports them.
    ///
    /// # Errors
    /// Mesh layouts of the host that do not fit the shaders; a device that is lost or does not meet the plan's
    /// requirements; errors of the device.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        plan: Arc<Plan>,
        source: Option<&dyn DrawSource>,
    ) -> Result<Self, Error> {
        let preparation =
            PlanPreparer { device: device.clone(), objects: Arc::default(), stated: Arc::default() };
        Self::with(preparation, queue, plan, source)
    }

    /// Instantiates a plan on the device of another executor, and shares that executor's shader modules, layouts and
    /// pipelines. Objects that either executor creates later are shared, too.
    ///
    /// # Errors
    /// As of [`Executor::new`].
    pub fn with_shared_cache(
        other: &Executor,
        plan: Arc<Plan>,
        source: Option<&dyn DrawSource>,
    ) -> Result<Self, Error> {
        Self::with(other.preparer(), &other.queue, plan, source)
    }

    fn with(
        mut preparation: PlanPreparer,
        queue: &wgpu::Queue,
        plan: Arc<Plan>,
        source: Option<&dyn DrawSource>,
    ) -> Result<Self, Error> {
        let mut statistics = Statistics::default();
        let (instantiated, late) = preparation.instantiate(&mut statistics, plan, source, None)?;
        preparation.stated = Arc::new(instantiated.stated.clone());
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

    /// Instantiates another plan: after a resize, or with other parameters or features.
    ///
    /// Pipelines, samplers, textures and buffers with unchanged descriptors are reused, and blackboard data is kept.
    /// Textures and buffers that outlive frames keep their contents under their own names. During the change, the
    /// textures of both plans exist. Values of live parameters and imports stay set for all later plans that have them,
    /// even if a plan in between does not. The mesh layouts are those that the last draw source declared.
    ///
    /// # Errors
    /// As of [`Executor::new`]. The executor then keeps the previous plan.
    pub fn set_plan(&mut self, plan: Arc<Plan>) -> Result<(), Error> {
        self.replace_plan(plan, None)
    }

    /// Replaces the plan as [`Executor::set_plan`] does, and takes the mesh layouts from `source`. Needed for another
    /// draw source, or after one has added geometry contracts.
    ///
    /// # Errors
    /// As of [`Executor::new`]. The executor then keeps the previous plan.
    pub fn set_plan_and_source(&mut self, plan: Arc<Plan>, source: &dyn DrawSource) -> Result<(), Error> {
        self.replace_plan(plan, Some(source))
    }

    fn replace_plan(&mut self, plan: Arc<Plan>, source: Option<&dyn DrawSource>) -> Result<(), Error> {
        let before = Some(&self.instantiated);
        let (instantiated, late) =
            self.preparation.instantiate(&mut self.statistics, plan, source, before)?;
        self.late.append(late);
        let mut before = std::mem::replace(&mut self.instantiated, instantiated);
        self.instantiated.parameters.go_on_from(&mut before.parameters);
        self.preparation.stated = Arc::new(self.instantiated.stated.clone());
        let Instantiated { resources, plan, .. } = &mut self.instantiated;
        let fits = |name: &str, buffer: &wgpu::Buffer| inputs::fits(plan, name, buffer);
        resources.imports.go_on_from(&mut before.resources.imports, fits);
        // Values that the other plan rejects are as it says them.
        let rejected = self.instantiated.apply_parameters();
        self.instantiated.cpu_passes.go_on_from(before.cpu_passes);
        self.warnings.extend(rejected.err().into_iter().flatten());
        Ok(())
    }

    /// Returns a preparer of plans for this executor, for use on any thread. [`PlanPreparer::prepare`] creates the
    /// pipelines of a plan, and [`Executor::set_prepared_plan`] installs the plan between two frames.
    pub fn preparer(&self) -> PlanPreparer {
        self.preparation.clone()
    }

    /// Installs a prepared plan as [`Executor::set_plan`] does, but creates only textures, buffers and bind groups.
    /// From this call on, [`Executor::statistics`] includes the objects that the preparation created.
    ///
    /// # Errors
    /// As of [`Executor::set_plan`].
    pub fn set_prepared_plan(&mut self, prepared: PreparedPlan) -> Result<(), Error> {
        self.statistics += prepared.statistics;
        self.late.append(prepared.late);
        let before = std::mem::replace(&mut self.preparation.stated, Arc::new(prepared.stated));
        let set = self.set_plan(prepared.plan);
        if set.is_err() {
            self.preparation.stated = before;
        }
        set
    }

    /// Returns the handle of a live parameter, for [`Executor::set`].
    ///
    /// # Errors
    /// An unknown parameter; a structural parameter, which needs a new plan, with the place in the pipeline that makes
    /// it structural; a parameter of another type.
    pub fn parameter<T: ParameterValue>(&self, name: &str) -> Result<Parameter<T>, Error> {
        Parameter::new(name, &self.instantiated.parameters, &self.instantiated.plan)
            .map_err(|found| self.error(found))
    }

    /// Sets a live parameter for the following records, without planning or creating objects. Later plans with a live
    /// parameter of the same name keep the value. Handles are valid for all plans with the same parameters.
    ///
    /// # Errors
    /// A handle of a plan with other parameters; a value out of range; a list of another length. If values are invalid
    /// only in combination, the next record reports an error, and all parameters keep the values of the record before.
    pub fn set<T: ParameterValue>(&mut self, parameter: Parameter<T>, value: T) -> Result<(), Error> {
        let at = if parameter.of == self.instantiated.parameters.id() { parameter.at } else { usize::MAX };
        let set = self.instantiated.parameters.set(at, &mut |to| value.assign(to));
        set.map_err(|found| self.error(found))
    }

    /// Returns the handle of a resource with the lifetime `imported`, for [`Executor::give`].
    ///
    /// # Errors
    /// A name that is no import of the plan, or an import of the other type (texture or buffer).
    pub fn import<T: Importable>(&self, name: &str) -> Result<ImportHandle<T>, Error> {
        let Instantiated { resources, plan, .. } = &self.instantiated;
        let imports = &resources.imports;
        if let Some(at) = imports.named(name, T::IS_TEXTURE) {
            return Ok(ImportHandle { at, of: imports.id(), kind: PhantomData });
        }
        let kind = if T::IS_TEXTURE { "texture" } else { "buffer" };
        let message = format!("the plan imports no {kind} \"{name}\"");
        let diagnostic = Diagnostic::error(codes::IMPORT, Place::Nowhere, message);
        let all = plan.imports().filter(|(_, one)| one.format.is_some() == T::IS_TEXTURE);
        let diagnostic = diagnostic.suggest(name, all.map(|(name, _)| name), None, |known| match known {
            [] => format!("it imports no {kind}"),
            known => format!("the {kind}s that it imports are {}", known.join(", ")),
        });
        Err(self.error(diagnostic.into()))
    }

    /// Sets the texture, part of a texture ([`Import`](crate::Import)) or buffer of an import until it is replaced, so
    /// that frames need not list the import. Later plans with the same import keep the object. Handles are valid for
    /// all plans with the same imports.
    ///
    /// # Errors
    /// A handle of a plan with other imports; a texture or buffer without the size, format or usages that the plan
    /// requires. The previous object then stays.
    pub fn give<'g, T: Importable>(
        &mut self,
        handle: ImportHandle<T>,
        given: impl Into<T::Given<'g>>,
    ) -> Result<(), Error> {
        let Instantiated { resources, plan, .. } = &self.instantiated;
        let name = resources.imports.name(handle.at).filter(|_| handle.of == resources.imports.id());
        let Some(name) = name else {
            let message = "the handle is of no import of this plan";
            let diagnostic = Diagnostic::error(codes::IMPORT, Place::Nowhere, message);
            return Err(self.error(diagnostic.help("ask the executor for the import again").into()));
        };
        let Given(given) = T::given(given.into());
        if let Some(error) = inputs::given_error(plan, name, &given) {
            let place = plan.resources.get(name).map(|one| plan.pipeline.resource(one.handle).place);
            let place = place.map_or(Place::Nowhere, Place::from);
            let help = "give it as the plan was made for it, or plan again";
            return Err(self.error(Diagnostic::error(codes::IMPORT, place, error).help(help).into()));
        }
        if self.instantiated.resources.imports.keep(handle.at, given) {
            let groups = self.instantiated.passes.iter_mut().flat_map(|pass| &mut pass.groups);
            groups.for_each(groups::Group::forget);
        }
        Ok(())
    }

    fn error(&self, found: Diagnostics) -> Error {
        Error::new(found, &self.instantiated.plan.pipeline.sources)
    }

    /// The current plan.
    pub fn plan(&self) -> &Arc<Plan> {
        &self.instantiated.plan
    }

    /// The counts of the device objects that the executor has created so far.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// The notices of the last record: an unusable camera or light, reached limits, and parts that CPU passes left out,
    /// with the reasons. Between [`Executor::set_plan`] and the next record they include the live values that the new
    /// plan rejects.
    pub fn notices(&self) -> impl Iterator<Item = &Diagnostic> {
        self.warnings.iter().chain(self.instantiated.cpu_passes.notices())
    }

    /// Returns the names of the lights in `frame` that no pass read in the last record, so that they do not affect the
    /// image. `frame` is the input of that record; invalid lights are not included.
    pub fn unread_lights<'f>(&self, frame: &'f FrameInput) -> Vec<&'f str> {
        self.instantiated.cpu_passes.unread_lights(frame)
    }

    /// Returns the sizes of blackboard data that CPU passes request, for
    /// [`umbragraph_compiler::PlanOptions::data_sizes`]. `None` if they equal the planned sizes. Frames with the
    /// planned sizes are correct, but of lower quality.
    pub fn wanted_sizes(&self) -> Option<BTreeMap<String, u32>> {
        self.instantiated.cpu_passes.wanted_sizes()
    }

    /// The blackboard data that a CPU pass published in the last record, by the name of its resource; `None` if there
    /// is no data of this name.
    pub fn data(&self, name: &str) -> Option<&BlackboardData> {
        self.instantiated.cpu_passes.data(name)
    }

    /// Drops all results of earlier frames: the next record begins every history with its initial value, and draws all
    /// kept views. Call this after a cut to another scene, or when a record's encoder was never submitted.
    pub fn reset_history(&mut self) {
        self.instantiated.resources.histories.reset();
        self.instantiated.kept.iter_mut().for_each(redraw::Kept::forget);
    }

    /// Reads a texture of the plan back, as [`read_back`] does, after all work that was submitted before. The texture
    /// must be exposed, with `"exposed": true` in its resource or with `Options::expose`.
    ///
    /// # Errors
    /// A name that is no texture of the plan; a texture of the host's; a texture that is not exposed; errors as of
    /// [`read_back`].
    pub async fn read(&self, name: &str) -> Result<Texels, Error> {
        let texture = self.readable(name).map_err(|found| self.error((*found).into()))?;
        let texels = read_back(&self.preparation.device, &self.queue, texture).await;
        texels.map_err(|found| self.error(found.into()))
    }

    fn readable(&self, name: &str) -> Result<&wgpu::Texture, Box<Diagnostic>> {
        let plan = &self.instantiated.plan;
        let cannot = |message: String, help: String| {
            Err(Box::new(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help(help)))
        };
        let base = name.split('@').next().unwrap_or(name);
        let textures = plan.resources.iter().filter(|(_, one)| one.format.is_some());
        let Some((_, resource)) = textures.clone().find(|(known, _)| *known == base) else {
            let message = match plan.pipeline.find_resource(base) {
                Some(_) => format!("no pass of the plan uses a texture \"{name}\""),
                None => format!("the pipeline has no texture \"{name}\""),
            };
            let known = textures.map(|(name, _)| name.as_str());
            let diagnostic = Diagnostic::error(codes::CAPTURE, Place::Nowhere, message);
            return Err(Box::new(
                diagnostic
                    .suggest(name, known, None, |known| format!("the textures are {}", known.join(", "))),
            ));
        };
        let declared = plan.pipeline.resource(resource.handle);
        match self.texture(name) {
            Some(texture) if declared.is_exposed() => Ok(texture),
            Some(_) => cannot(
                format!("the texture \"{name}\" is not exposed: others share its memory"),
                format!("write \"exposed\": true in the resource \"{name}\", or plan with Options::expose"),
            ),
            None => cannot(
                format!("the texture \"{name}\" is the application's own"),
                "read it with umbragraph::executor::read_back".to_owned(),
            ),
        }
    }

    /// The texture of a resource; `None` for a texture of the host's, or if the plan has no texture of this name. Other
    /// resources may share it within a frame. The name of a history returns the texture that the last record wrote;
    /// `NAME@-1` returns the texture of the frame before.
    pub fn texture(&self, name: &str) -> Option<&wgpu::Texture> {
        match self.instantiated.resources.physical(&self.instantiated.plan, name)? {
            Physical::Texture(index) => self.instantiated.resources.textures.texture(index),
            _ => None,
        }
    }

    /// The buffer of a resource; `None` for a buffer of the host's, or if the plan has no buffer of this name. Other
    /// resources may share it within a frame.
    pub fn buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        match self.instantiated.resources.physical(&self.instantiated.plan, name)? {
            Physical::Buffer(index) => self.instantiated.resources.textures.buffer(index),
            _ => None,
        }
    }

    /// Switches the measurement of CPU times for each pass on or off; off at first.
    pub fn measure_times(&mut self, on: bool) {
        self.times.switch(on);
    }

    /// The CPU time of each pass of the last record, in the plan's order; empty if measurement is off. Passes that are
    /// recorded as one render pass count with the first of them; skipped passes take no time.
    pub fn times(&self) -> impl Iterator<Item = (&str, Duration)> {
        let names = self.instantiated.plan.passes.iter().map(|pass| pass.name.as_str());
        names.zip(self.times.passes.iter().copied())
    }

    /// The start of each pass of [`Executor::times`] on the CPU, measured from the begin of the record.
    pub fn starts(&self) -> impl Iterator<Item = Duration> {
        self.times.starts.iter().copied()
    }

    /// Switches the measurement of GPU times for each pass on or off; off at first. Returns `true` if the device has
    /// the feature `timestamp-query`, which measurement requires. Copies are measured only with the feature
    /// `TIMESTAMP_QUERY_INSIDE_ENCODERS`.
    pub fn measure_gpu_times(&mut self, on: bool) -> bool {
        self.gpu_times.switch(on, &self.preparation.device)
    }

    /// Returns the GPU time of each pass of the last record, in the order in which the passes began. Submit the
    /// record's encoder first; the call waits until the GPU is done. Empty if measurement is off, or on a second call
    /// for the same record.
    pub fn gpu_times(&mut self) -> Vec<GpuTime> {
        self.gpu_times.take(&self.preparation.device, &self.queue)
    }

    /// The passes that the last record skipped because of their toggles, in the plan's order.
    pub fn skipped(&self) -> impl Iterator<Item = &str> {
        let instantiated = &self.instantiated;
        let skipped = |pass: &&PlannedPass| !instantiated.switches().runs(&instantiated.plan, pass.handle);
        instantiated.plan.passes.iter().filter(skipped).map(|pass| pass.name.as_str())
    }

    /// The counts of the last record for each pass that draws the host's meshes.
    pub fn pass_counts(&self) -> impl Iterator<Item = (&str, PassCounts)> {
        let passes = self.instantiated.plan.passes.iter().zip(&self.instantiated.passes);
        let draws = |pass: &InstantiatedPass| matches!(pass.work, InstantiatedWork::Scene { .. });
        let drawn = passes.zip(&self.scratch.counts).filter(move |((_, pass), _)| draws(pass));
        drawn.map(|((planned, _), counts)| (planned.name.as_str(), *counts))
    }

    /// The CPU time for preparing bind groups and uploading blocks in the last record.
    pub fn preparation_time(&self) -> Duration {
        self.times.preparation
    }

    /// Records a frame into an encoder. Several records in one submission are independent of one another.
    ///
    /// For histories, each record is a frame of its own: the next record reads the current contents of `color` as
    /// `color@-1`, even within one submission. Submit encoders in the order of their records.
    ///
    /// # Errors
    /// Live parameters that are invalid in combination; imports that are missing or not as planned; toggles that the
    /// pipeline does not have; a draw source that is missing, or whose mesh layouts differ from those that the plan was
    /// instantiated with; blackboard data that a CPU pass did not declare; textures of another device; errors of the
    /// device. Nothing is recorded then, and the next frame is possible. Draws of the host that fail or panic are an
    /// error, too, but the rest of the frame is recorded.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder, frame: &Frame<'_>) -> Result<(), Error> {
        self.try_record(encoder, frame, false).map_err(|found| self.error(found))
    }

    /// Records the last frame again, for example after [`Executor::set_plan`] with a plan that also copies textures.
    /// Pass the same `frame` as to the last record. CPU passes that have run keep their published data; passes that have
    /// not run yet run now. Each history reads the same earlier frames as before, and its contents of that frame are
    /// written again.
    ///
    /// Persistent resources and imports are as the last record left them. If a frame changes them step by step, restore
    /// them first (`Options::copyable_state`). After a change of plans all kept views are drawn again. After a record
    /// that failed, record again before you repeat.
    ///
    /// # Errors
    /// As of [`Executor::record`].
    pub fn repeat(&mut self, encoder: &mut wgpu::CommandEncoder, frame: &Frame<'_>) -> Result<(), Error> {
        self.try_record(encoder, frame, true).map_err(|found| self.error(found))
    }

    fn try_record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame<'_>,
        is_again: bool,
    ) -> Result<(), Diagnostics> {
        reject(self.late.known())?;
        if let Some(source) = frame.draws {
            inputs::provide(&mut self.instantiated, source)?;
        }
        let mut diagnostics = inputs::check(&self.instantiated, frame);
        diagnostics.extend(Switches::check(&self.instantiated.plan, frame.toggles));
        reject(diagnostics)?;
        self.instantiated.apply_parameters()?;
        self.instantiated.cpu_passes.switch(frame.toggles);
        self.warnings = Diagnostics::new();
        inputs::warnings(frame, &mut self.warnings);
        self.times.reset(self.instantiated.plan.passes.len());
        inputs::run_cpu_passes(&mut self.instantiated, frame, &mut self.times, is_again)?;
        let start = self.times.now();
        self.prepare(encoder, frame, is_again)?;
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

    /// Creates the device objects that the record needs, and uploads its uniform and storage blocks.
    fn prepare(
        &mut self,
        encoder: &wgpu::CommandEncoder,
        frame: &Frame<'_>,
        is_again: bool,
    ) -> Result<(), Diagnostics> {
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
            (self.records, is_again),
        );
        if let (Some(blocks), Ok(())) = (&blocks, &prepared) {
            // Within the scopes of the creation, if there are any: on a device that is lost, a new buffer is none.
            let Instantiated { plan, cpu_passes, blocks: packed, .. } = &mut self.instantiated;
            for (offset, bytes) in packed.pack(plan, cpu_passes) {
                self.queue.write_buffer(blocks, offset, bytes);
            }
        }
        let mut caught = creation.finish();
        let mut diagnostics = caught.known();
        self.late.append(caught);
        diagnostics.extend(prepared.err());
        if diagnostics.has_errors() {
            record::forget(&mut self.instantiated);
            self.pool.forget();
            return Err(diagnostics);
        }
        Ok(())
    }
}
