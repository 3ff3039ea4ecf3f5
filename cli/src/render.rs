//! `umbragraph render`

use std::sync::Arc;

use umbragraph::Checked;
use umbragraph::diagnostic::Diagnostics;
use umbragraph::executor::{Executor, Frame};
use umbragraph::frame::FrameInput;
use umbragraph::language::Lifetime;
use umbragraph::scene::Scene;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::work::ResourceHandle;

use crate::arguments::RenderArguments;
use crate::device::{self, Graphics};
use crate::output;
use crate::progress::Progress;
use crate::session::Session;

/// Renders one picture; whether there were no errors.
pub(crate) fn run(arguments: &RenderArguments) -> bool {
    let mut session = Session::new(arguments.choices.templates.as_deref());
    let mut progress = Progress::new();
    let result = render(arguments, &mut session, &mut progress);
    progress.finish();
    let name = match result {
        Ok(name) => name,
        Err(findings) => {
            session.findings.extend(findings);
            None
        }
    };
    let fine = session.report();
    if let Some(name) = name.filter(|_| fine) {
        let [width, height] = arguments.choices.size;
        println!("{}: {width} by {height} on {name}", arguments.out.display());
        println!("{}", progress.summary());
        return true;
    }
    false
}

/// The adapter's name, or `None` if the findings are in the session.
fn render(
    arguments: &RenderArguments,
    session: &mut Session,
    progress: &mut Progress,
) -> Result<Option<String>, Diagnostics> {
    let checked = progress.stage("check", || session.check(&arguments.pipeline, &arguments.choices));
    let scene = progress.stage("load scene", || umbragraph::scene::load(&arguments.scene));
    let scene = match scene {
        Ok(scene) => scene,
        Err(findings) => {
            session.findings.extend(findings);
            return Ok(None);
        }
    };
    let Checked { plan: Some(plan), .. } = checked else { return Ok(None) };
    if session.findings.has_errors() {
        return Ok(None);
    }
    let graphics = progress.stage("open device", device::open)?;
    let [width, height] = arguments.choices.size;
    let input = scene.frame_input(f64::from(width) / f64::from(height), arguments.time);
    let pixels = progress.stage("draw", || draw(&graphics, plan, &scene, &input, arguments.time))?;
    progress.stage("write", || output::write_png(&arguments.out, width, height, &pixels))?;
    Ok(Some(graphics.name))
}

fn draw(
    graphics: &Graphics,
    plan: umbragraph::compiler::Plan,
    scene: &Scene,
    input: &FrameInput,
    time: f64,
) -> Result<Vec<u8>, Diagnostics> {
    let draws = SceneResources::new(&graphics.device, &graphics.queue, scene, &scene.pose(time))?;
    let targets = imports(graphics, &plan);
    let mut executor =
        pollster::block_on(Executor::new(&graphics.device, &graphics.queue, Arc::new(plan), Some(&draws)))?;
    let mut encoder = graphics.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let imports: Vec<(&str, &wgpu::Texture)> = targets.iter().map(|(name, texture)| (name.as_str(), texture)).collect();
    executor.record(&mut encoder, &Frame { input, draws: Some(&draws), imports: &imports })?;
    graphics.queue.submit([encoder.finish()]);
    let picture = targets.first().map(|(_, texture)| texture);
    match picture {
        Some(texture) => Ok(output::read_back(graphics, texture)?),
        None => Ok(Vec::new()),
    }
}

/// A texture for each import of the plan that passes write; the picture first.
fn imports(graphics: &Graphics, plan: &umbragraph::compiler::Plan) -> Vec<(String, wgpu::Texture)> {
    let writes = |handle: ResourceHandle| plan.passes.iter().any(|pass| plan.writes(pass.handle, handle));
    let mut imported: Vec<_> =
        plan.resources.iter().filter(|(_, resource)| resource.lifetime == Lifetime::Imported).collect();
    imported.sort_by_key(|(name, resource)| (!writes(resource.handle), *name != "target", (*name).clone()));
    imported
        .into_iter()
        .filter_map(|(name, resource)| {
            let (format, size) = (resource.format?, resource.size?);
            let texture = graphics.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(name),
                size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: size.layers },
                mip_level_count: size.mips,
                sample_count: size.samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::COPY_SRC
                    | wgpu::TextureUsages::COPY_DST
                    | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            Some((name.clone(), texture))
        })
        .collect()
}
