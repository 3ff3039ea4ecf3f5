//! [`Picture`]: the executor of one pipeline, and the host's own textures, the picture among them.

use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use umbragraph::draw::DrawSource;
use umbragraph::executor::imported_texture;
use umbragraph::frame::FrameInput;
use umbragraph::low_level::CheckReport;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::language::Lifetime;
use umbragraph::low_level::source::Sources;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::wgpu;
use umbragraph::{Executor, Frame};

/// The maximum number of attempts to record a frame with the data sizes that CPU passes request.
const ROUNDS: usize = 8;

/// A pipeline that is being drawn: its executor, its plan options, and the textures that it imports.
pub(crate) struct Picture {
    checked: CheckReport,
    options: PlanOptions,
    sources: Sources,
    pub(crate) executor: Executor,
    name: String,
    imports: Vec<(String, wgpu::Texture)>,
    /// The width and height in pixels for which the canvas is configured; `None` if it must be configured again.
    shown: Option<[u32; 2]>,
}

impl Picture {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        checked: CheckReport,
        options: PlanOptions,
        sources: &Sources,
        draws: Option<&SceneResources>,
    ) -> Result<Self, Diagnostics> {
        let Some(plan) = checked.plan.clone() else { return Err(Diagnostics::new()) };
        let name = name_of(&plan)?;
        let imports = imports(device, &plan);
        let executor = Executor::new(device, queue, plan, draws.map(|draws| draws as &dyn DrawSource))?;
        Ok(Self { checked, options, sources: sources.clone(), executor, name, imports, shown: None })
    }

    /// Replaces the plan with that of a new check. On an error, the previous plan stays in use.
    pub(crate) fn go_on(
        &mut self,
        device: &wgpu::Device,
        checked: CheckReport,
        options: PlanOptions,
        sources: &Sources,
        draws: Option<&SceneResources>,
    ) -> Result<(), Diagnostics> {
        let Some(plan) = checked.plan.clone() else { return Err(Diagnostics::new()) };
        let name = name_of(&plan)?;
        let imports = imports(device, &plan);
        match draws {
            Some(draws) => self.executor.set_plan_and_source(plan, draws)?,
            None => self.executor.set_plan(plan)?,
        }
        (self.checked, self.options, self.sources) = (checked, options, sources.clone());
        (self.name, self.imports, self.shown) = (name, imports, None);
        Ok(())
    }

    /// The width and height of a frame in texels.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.options.viewport
    }

    /// The source files to which diagnostics of the pipeline refer.
    pub(crate) fn sources(&self) -> &Sources {
        &self.sources
    }

    /// The texture that holds the last frame; `None` if the plan imports no such texture.
    pub(crate) fn texture(&self) -> Option<&wgpu::Texture> {
        self.imports.iter().find(|(name, _)| *name == self.name).map(|(_, texture)| texture)
    }

    /// Records and submits a frame. Plans and records again, up to a limit, while CPU passes request other data sizes.
    pub(crate) fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        input: &FrameInput,
        draws: Option<&SceneResources>,
    ) -> Result<(), Diagnostics> {
        for round in 0..ROUNDS {
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let given: Vec<(&str, &wgpu::Texture)> =
                self.imports.iter().map(|(name, texture)| (name.as_str(), texture)).collect();
            let frame = Frame::new(input).imports(&given);
            let frame = match draws {
                Some(draws) => frame.draws(draws),
                None => frame,
            };
            self.executor.record(&mut encoder, &frame)?;
            let Some(sizes) = self.executor.wanted_sizes().filter(|_| round + 1 < ROUNDS) else {
                queue.submit([encoder.finish()]);
                break;
            };
            self.options.data_sizes = sizes;
            let plan = self.checked.plan_again(&self.options, &self.sources)?;
            self.imports = imports(device, &plan);
            self.executor.set_plan(Arc::new(plan))?;
        }
        Ok(())
    }

    /// Records and submits one frame with `plan`, which copies a texture to the import `import`. Returns the texture of
    /// this import. The previous plan is then used again.
    pub(crate) fn capture(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        (plan, import): (Arc<Plan>, &str),
        input: &FrameInput,
        draws: Option<&SceneResources>,
    ) -> Result<wgpu::Texture, Diagnostics> {
        let running = self.executor.plan().clone();
        let more = wgpu::TextureUsages::COPY_SRC;
        let contents = imported_texture(device, &plan, import, more).ok_or_else(Diagnostics::new)?;
        self.executor.set_plan(plan)?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut given: Vec<(&str, &wgpu::Texture)> =
            self.imports.iter().map(|(name, texture)| (name.as_str(), texture)).collect();
        given.push((import, &contents));
        let frame = Frame::new(input).imports(&given);
        let frame = match draws {
            Some(draws) => frame.draws(draws),
            None => frame,
        };
        let recorded = self.executor.record(&mut encoder, &frame);
        if recorded.is_ok() {
            queue.submit([encoder.finish()]);
        }
        let again = self.executor.set_plan(running);
        recorded?;
        again?;
        Ok(contents)
    }

    /// The options of the current plan: the size of a frame in texels, and the data sizes that CPU passes requested.
    pub(crate) fn options(&self) -> &PlanOptions {
        &self.options
    }

    /// Copies the last frame to a canvas. Fails if the canvas has no texture for the frame.
    pub(crate) fn show(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        canvas: &wgpu::Surface<'static>,
    ) -> Result<(), String> {
        let [width, height] = self.size();
        if self.shown != Some([width, height]) {
            // Copies take the texels as they are, encoded or not, as browsers show them.
            canvas.configure(
                device,
                &wgpu::SurfaceConfiguration {
                    usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::RENDER_ATTACHMENT,
                    format: wgpu::TextureFormat::Rgba8Unorm,
                    color_space: wgpu::SurfaceColorSpace::Auto,
                    width,
                    height,
                    present_mode: wgpu::PresentMode::Fifo,
                    desired_maximum_frame_latency: 2,
                    alpha_mode: wgpu::CompositeAlphaMode::Opaque,
                    view_formats: Vec::new(),
                },
            );
            self.shown = Some([width, height]);
        }
        let Some(texture) = self.texture() else { return Ok(()) };
        let target = match canvas.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(target)
            | wgpu::CurrentSurfaceTexture::Suboptimal(target) => target,
            _ => return Err("the canvas has no texture for this frame".to_owned()),
        };
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_texture(
            texture.as_image_copy(),
            target.texture.as_image_copy(),
            texture.size(),
        );
        queue.submit([encoder.finish()]);
        queue.present(target);
        Ok(())
    }
}

/// Returns the name of the imported texture that receives the frame: the only one that passes write, or "target" if
/// they write several.
fn name_of(plan: &Plan) -> Result<String, Diagnostics> {
    let written = plan.resources.iter().filter(|(_, resource)| {
        let is_written = |handle| plan.writes(handle, resource.handle);
        resource.lifetime == Lifetime::Imported && plan.passes.iter().any(|pass| is_written(pass.handle))
    });
    let written: Vec<&String> = written.map(|(name, _)| name).collect();
    match written.as_slice() {
        [one] => Ok((*one).clone()),
        several => {
            let target = several.iter().find(|name| **name == "target");
            target.map(|name| (*name).clone()).ok_or_else(|| no_picture(several.len()))
        }
    }
}

/// Creates a texture for each texture that a plan imports, and returns it with its name.
fn imports(device: &wgpu::Device, plan: &Plan) -> Vec<(String, wgpu::Texture)> {
    let more = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = |name: &String| Some((name.clone(), imported_texture(device, plan, name, more)?));
    plan.resources.keys().filter_map(texture).collect()
}

/// The diagnostic for a pipeline without a texture that receives the frame. `written` is the number of imported
/// textures that passes write.
fn no_picture(written: usize) -> Diagnostics {
    let message = format!("the pipeline writes {written} imported textures");
    let help = "a picture is made of the one imported texture that passes write, or of \"target\"";
    Diagnostic::error(codes::PICTURE, Place::Nowhere, message).help(help).into()
}
