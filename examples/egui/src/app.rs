//! The window: parameters on the left, the live frame beside them.

use std::path::Path;
use std::time::Instant;

use eframe::egui::{self, load::SizedTexture};
use eframe::egui_wgpu::RenderState;
use umbragraph::scene::Scene;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::{Frame, Library, Options, Pipeline, Renderer, wgpu};

use crate::controls::{Control, controls};
use crate::drive::Drive;

/// The application: pipeline, scene, controls and frame state.
pub(crate) struct Viewer {
    pipeline: Pipeline,
    renderer: Renderer,
    scene: Scene,
    meshes: SceneResources,
    target: Option<(wgpu::Texture, egui::TextureId)>,
    controls: Vec<Control>,
    error: Option<String>,
    start: Instant,
    index: u64,
    drive: Option<Drive>,
}

impl Viewer {
    pub(crate) fn new(
        context: &eframe::CreationContext<'_>,
        pipeline: &str,
        scene: &Path,
        drive: Option<Drive>,
    ) -> Result<Self, Box<dyn std::error::Error + Send + Sync>> {
        let state = context.wgpu_render_state.as_ref().ok_or("eframe draws without wgpu")?;
        let failed = |found: umbragraph::diagnostic::Diagnostics| format!("{}: {found:?}", scene.display());
        let scene = umbragraph::scene::load(scene).map_err(failed)?;
        let pose = scene.pose(0.0);
        let meshes = SceneResources::new(&state.device, &state.queue, &scene, &pose)
            .map_err(|found| format!("{found:?}"))?;
        Ok(Self {
            pipeline: Library::new().load(pipeline)?,
            renderer: Renderer::new(&state.device, &state.queue),
            scene,
            meshes,
            target: None,
            controls: Vec::new(),
            error: None,
            start: Instant::now(),
            index: 0,
            drive,
        })
    }

    /// Draws a frame of a size in pixels into a texture that egui can show.
    fn draw(
        &mut self,
        state: &RenderState,
        [width, height]: [u32; 2],
    ) -> Result<SizedTexture, umbragraph::Error> {
        let target = self.target(state, [width, height]);
        let time = if self.drive.is_some() { 0.0 } else { self.start.elapsed().as_secs_f64() };
        let pose = self.scene.pose(time);
        self.meshes.update(&state.queue, &self.scene, &pose);
        let mut input = self.scene.frame_input_of(&pose, f64::from(width) / f64::from(height), time);
        input.index = self.index;
        self.index += 1;
        let imports = [("target", &target.0)];
        let frame = Frame::new(&input).draws(&self.meshes).imports(&imports);
        let mut encoder = state.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.renderer.record(&self.pipeline, &Options::new(width, height), &mut encoder, &frame)?;
        state.queue.submit([encoder.finish()]);
        Ok(SizedTexture::new(target.1, [width as f32, height as f32]))
    }

    fn target(&mut self, state: &RenderState, [width, height]: [u32; 2]) -> (wgpu::Texture, egui::TextureId) {
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let before = self.target.take().filter(|(texture, id)| {
            let is_fit = texture.size() == size;
            if !is_fit {
                state.renderer.write().free_texture(id);
            }
            is_fit
        });
        let target = before.unwrap_or_else(|| {
            let texture = state.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("target"),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            let filter = wgpu::FilterMode::Nearest;
            let id = state.renderer.write().register_native_texture(&state.device, &view, filter);
            (texture, id)
        });
        self.target = Some(target.clone());
        target
    }

    /// Shows a row for each live parameter. A changed value takes effect from this frame on.
    fn parameters(&mut self, ui: &mut egui::Ui) {
        let Some(executor) = self.renderer.executor() else { return };
        if self.controls.is_empty() {
            self.controls = controls(executor.plan());
        }
        for control in &mut self.controls {
            let (changed, rect) = control.show(ui);
            if let Some(drive) = &mut self.drive {
                drive.sees(&control.name, rect);
            }
            if changed {
                let set = executor
                    .parameter(&control.name)
                    .and_then(|parameter| executor.set(parameter, control.value.clone()));
                self.error = set.err().map(|error| error.to_string());
            }
        }
    }
}

impl eframe::App for Viewer {
    fn raw_input_hook(&mut self, context: &egui::Context, input: &mut egui::RawInput) {
        if let Some(drive) = &mut self.drive {
            drive.step(context, input, self.renderer.executor().map(|executor| executor.statistics()));
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        egui::Panel::left("parameters").exact_size(330.0).show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| self.parameters(ui));
        });
        egui::CentralPanel::no_frame().show(ui, |ui| {
            let pixels = ui.available_size() * ui.ctx().pixels_per_point();
            let size = [pixels.x, pixels.y].map(|length| (length.round() as u32).max(1));
            let Some(state) = frame.wgpu_render_state() else { return };
            match self.draw(state, size) {
                Ok(texture) => {
                    let shown = egui::Image::new(texture).fit_to_exact_size(ui.available_size());
                    ui.add(shown);
                }
                Err(error) => self.error = Some(error.to_string()),
            }
        });
        if let Some(error) = &self.error {
            egui::Window::new("Error").show(ui.ctx(), |ui| ui.monospace(error));
        }
        ui.ctx().request_repaint();
    }
}
