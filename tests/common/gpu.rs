//! Rendering in tests.

use std::path::Path;
use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::executor::{imported_texture, read_bytes};
use umbragraph::frame::FrameInput;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::scene::Scene;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::{Executor, Frame};
use umbragraph_test_support::gpu::Gpu;
use umbragraph_test_support::image::{Channels, Picture};

use super::Outcome;

/// A texture as the host of a plan would bring it for one of its imports.
pub fn import(gpu: &Gpu, plan: &Plan, name: &str) -> wgpu::Texture {
    import_on(&gpu.device, plan, name)
}

/// The same on any device.
pub fn import_on(device: &wgpu::Device, plan: &Plan, name: &str) -> wgpu::Texture {
    let more = wgpu::TextureUsages::RENDER_ATTACHMENT
        | wgpu::TextureUsages::COPY_SRC
        | wgpu::TextureUsages::COPY_DST
        | wgpu::TextureUsages::TEXTURE_BINDING;
    imported_texture(device, plan, name, more).expect("a texture")
}

/// An executor for a plan.
#[track_caller]
pub fn executor(gpu: &Gpu, plan: &Plan, scene: Option<&SceneResources>) -> Executor {
    let source = scene.map(|scene| scene as &dyn umbragraph::draw::DrawSource);
    match Executor::new(&gpu.device, &gpu.queue, Arc::new(plan.clone()), source) {
        Ok(executor) => executor,
        Err(diagnostics) => panic!("{diagnostics:?}"),
    }
}

/// A camera that sees nothing in particular, without lights.
pub fn empty_frame() -> FrameInput {
    use umbragraph::frame::{Camera, Projection};
    FrameInput::new(Camera::new(
        glam::DVec3::ZERO,
        Default::default(),
        Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 },
        4.0 / 3.0,
    ))
}

/// The picture that a pipeline without a scene writes to `target`.
#[track_caller]
pub fn picture(gpu: &Gpu, outcome: &Outcome) -> Picture {
    let plan = outcome.plan();
    let target = import(gpu, plan, "target");
    let mut executor = executor(gpu, plan, None);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    executor
        .record(&mut encoder, &Frame::new(&empty_frame()).imports(&[("target", &target)]))
        .expect("a record");
    gpu.queue.submit([encoder.finish()]);
    read(gpu, &target)
}

/// A scene of the workspace or of elsewhere.
#[track_caller]
pub fn scene(path: &Path) -> Scene {
    match umbragraph::scene::load(path) {
        Ok(scene) => scene,
        Err(diagnostics) => panic!("{}: {diagnostics:?}", path.display()),
    }
}

/// The picture that a pipeline makes of a scene.
#[track_caller]
pub fn render(gpu: &Gpu, outcome: &Outcome, scene: &Scene) -> Picture {
    let plan = outcome.plan();
    let [width, height] = plan.viewport;
    let input = scene.frame_input(f64::from(width) / f64::from(height), 0.0);
    render_frame(gpu, plan, scene, &input)
}

/// The picture that a plan makes of a scene as a frame sees it.
#[track_caller]
pub fn render_frame(gpu: &Gpu, plan: &Plan, scene: &Scene, input: &FrameInput) -> Picture {
    let resources = SceneResources::new(&gpu.device, &gpu.queue, scene, &scene.pose(input.time))
        .expect("a scene that fits");
    let target = import(gpu, plan, "target");
    let mut executor = executor(gpu, plan, Some(&resources));
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    if let Err(diagnostics) =
        executor.record(&mut encoder, &Frame::new(input).draws(&resources).imports(&[("target", &target)]))
    {
        panic!("{diagnostics:?}");
    }
    gpu.queue.submit([encoder.finish()]);
    read(gpu, &target)
}

/// A host that plans again until CPU passes have the sizes that they want, as an application would over some frames.
pub struct Host<'a> {
    pub gpu: &'a Gpu,
    pub outcome: &'a Outcome,
    pub scene: SceneResources,
    pub executor: Executor,
    pub target: wgpu::Texture,
    /// The imports besides the target.
    pub imports: Vec<(&'static str, wgpu::Texture)>,
    pub options: PlanOptions,
}

impl<'a> Host<'a> {
    #[track_caller]
    pub fn new(gpu: &'a Gpu, outcome: &'a Outcome, scene: &Scene) -> Self {
        let plan = outcome.plan();
        let scene =
            SceneResources::new(&gpu.device, &gpu.queue, scene, &scene.pose(0.0)).expect("a scene that fits");
        let executor = executor(gpu, plan, Some(&scene));
        let target = import(gpu, plan, "target");
        let options = PlanOptions::new(plan.viewport[0], plan.viewport[1]);
        Self { gpu, outcome, scene, executor, target, imports: Vec::new(), options }
    }

    /// Draws one frame; whether CPU passes wanted other sizes, for which everything is planned again.
    #[track_caller]
    pub fn frame(&mut self, input: &FrameInput) -> bool {
        let commands = self.record(input);
        self.gpu.queue.submit([commands]);
        self.plan_again()
    }

    /// Follows the sizes that CPU passes want for a frame before it is drawn.
    #[track_caller]
    pub fn settle(&mut self, input: &FrameInput) {
        let rounds = (0..16).take_while(|_| {
            drop(self.record(input));
            self.plan_again()
        });
        assert!(rounds.count() < 16, "sizes that never settle: {:?}", self.executor.wanted_sizes());
    }

    fn record(&mut self, input: &FrameInput) -> wgpu::CommandBuffer {
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut imports = vec![("target", &self.target)];
        imports.extend(self.imports.iter().map(|(name, texture)| (*name, texture)));
        let frame = Frame::new(input).draws(&self.scene).imports(&imports);
        if let Err(diagnostics) = self.executor.record(&mut encoder, &frame) {
            panic!("{diagnostics:?}");
        }
        encoder.finish()
    }

    /// Whether CPU passes wanted other sizes than the plan has, which has them then.
    fn plan_again(&mut self) -> bool {
        let Some(sizes) = self.executor.wanted_sizes() else { return false };
        self.options.data_sizes = sizes;
        let plan = self.outcome.checked.plan_again(&self.options, &self.outcome.sources).expect("a plan");
        let violations = umbragraph_verify::verify(&plan, &self.options);
        assert!(violations.is_empty(), "{violations:#?}");
        self.executor.set_plan(Arc::new(plan)).expect("another plan");
        true
    }

    /// The picture of a frame once all sizes are as they are wanted.
    #[track_caller]
    pub fn picture(&mut self, input: &FrameInput) -> Picture {
        let rounds = (0..16).take_while(|_| self.frame(input)).count();
        assert!(rounds < 16, "sizes that never settle: {:?}", self.executor.wanted_sizes());
        read(self.gpu, &self.target)
    }

    /// The notices of CPU passes about the last frame.
    pub fn notices(&self) -> Vec<String> {
        self.executor.notices().map(|notice| format!("{}: {}", notice.code.id, notice.message)).collect()
    }
}

/// Reads an rgba8 texture back, row 0 on top.
pub fn read(gpu: &Gpu, texture: &wgpu::Texture) -> Picture {
    let (width, height) = (texture.width(), texture.height());
    let pixels = pollster::block_on(read_bytes(&gpu.device, &gpu.queue, texture)).expect("bytes");
    Picture::new(width, height, Channels::Rgba, pixels).expect("a picture")
}
