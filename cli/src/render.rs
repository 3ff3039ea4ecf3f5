//! `umbragraph render`

use std::collections::BTreeMap;
use std::sync::Arc;

use umbragraph::compiler::{Plan, PlanOptions};
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use umbragraph::executor::{Executor, Frame};
use umbragraph::frame::FrameInput;
use umbragraph::language::Lifetime;
use umbragraph::scene::Scene;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::shader::TargetProfile;

use crate::arguments::RenderArguments;
use crate::device::{self, Graphics};
use crate::output;
use crate::progress::Progress;
use crate::session::Session;
use crate::streams::print;

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
        let (out, times) = (arguments.out.display(), progress.summary());
        print(&format!("{out}: {width} by {height} on {name}\n{times}\n"));
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
    session.findings.extend(scene.warnings.clone());
    let Some(plan) = &checked.plan else { return Ok(None) };
    session.findings.extend(umbragraph::scene::filter::left_out(&scene, plan));
    if session.findings.has_errors() {
        return Ok(None);
    }
    let graphics = progress.stage("open device", device::open)?;
    let on_device = |profile: TargetProfile| profile.on_device(&graphics.device.limits(), graphics.flags);
    let checked = session.check_on(checked, &on_device, &arguments.pipeline, &arguments.choices);
    let Some(plan) = checked.plan.clone().filter(|_| !session.findings.has_errors()) else { return Ok(None) };
    let [width, height] = arguments.choices.size;
    let input = scene.frame_input(f64::from(width) / f64::from(height), arguments.time);
    let options = Session::options(&arguments.choices);
    let again =
        |data_sizes| checked.plan_again(&PlanOptions { data_sizes, ..options.clone() }, &session.sources);
    let drawing = Drawing {
        graphics: &graphics,
        scene: &scene,
        input: &input,
        toggles: &arguments.toggles,
        again: &again,
    };
    let (pixels, notices) = progress.stage("draw", || draw(&drawing, plan))?;
    session.findings.extend(notices);
    progress.stage("write", || output::write_png(&arguments.out, width, height, &pixels))?;
    Ok(Some(graphics.name))
}

/// How often a picture is planned anew, so that host passes get the sizes that they want.
const ROUNDS: usize = 8;

/// What a picture is drawn of.
struct Drawing<'a> {
    graphics: &'a Graphics,
    scene: &'a Scene,
    input: &'a FrameInput,
    toggles: &'a [(String, bool)],
    /// Makes the plan with sizes that host passes want.
    again: &'a dyn Fn(BTreeMap<String, u32>) -> Result<Plan, Diagnostics>,
}

/// The picture, and what host passes had to say of it.
fn draw(drawing: &Drawing<'_>, plan: Plan) -> Result<(Vec<u8>, Diagnostics), Diagnostics> {
    let Drawing { graphics, scene, input, toggles, again } = *drawing;
    let draws = SceneResources::new(&graphics.device, &graphics.queue, scene, &scene.pose(input.time))?;
    let picture = picture_of(&plan)?;
    let targets = imports(graphics, &plan, &picture);
    let scope = graphics.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let memory = graphics.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
    let mut executor =
        pollster::block_on(Executor::new(&graphics.device, &graphics.queue, Arc::new(plan), Some(&draws)))?;
    let imports: Vec<(&str, &wgpu::Texture)> =
        targets.iter().map(|(name, texture)| (name.as_str(), texture)).collect();
    let toggles: Vec<(&str, bool)> = toggles.iter().map(|(name, on)| (name.as_str(), *on)).collect();
    let frame = Frame { input, draws: Some(&draws), imports: &imports, toggles: &toggles };
    for round in 0..ROUNDS {
        let mut encoder = graphics.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor.record(&mut encoder, &frame)?;
        match executor.wanted_sizes().filter(|_| round + 1 < ROUNDS) {
            Some(sizes) => {
                pollster::block_on(executor.set_plan(Arc::new(again(sizes)?), Some(&draws)))?;
            }
            None => {
                graphics.queue.submit([encoder.finish()]);
                break;
            }
        }
    }
    for scope in [memory, scope] {
        if let Some(error) = pollster::block_on(scope.pop()) {
            let finding = Diagnostic::error(
                codes::DEVICE,
                Place::Nowhere,
                format!("the device refused the frame: {error}"),
            );
            return Err(finding
                .help("please report this: what a device refuses should have been found before")
                .into());
        }
    }
    let notices = executor.notices().cloned().collect();
    match targets.first() {
        Some((_, texture)) => Ok((output::read_back(graphics, texture)?, notices)),
        None => Ok((Vec::new(), notices)),
    }
}

/// The name of the imported texture that is the picture: the one that passes write, or "target" among several.
fn picture_of(plan: &Plan) -> Result<String, Diagnostics> {
    let written: Vec<&String> = plan
        .resources
        .iter()
        .filter(|(_, resource)| resource.lifetime == Lifetime::Imported)
        .filter(|(_, resource)| plan.passes.iter().any(|pass| plan.writes(pass.handle, resource.handle)))
        .map(|(name, _)| name)
        .collect();
    let chosen = match written.as_slice() {
        [one] => Some(*one),
        several => several.iter().copied().find(|name| *name == "target"),
    };
    let refuse = |place: Place, message: String, help: &str| {
        Err(Diagnostic::error(codes::PICTURE, place, message).help(help).into())
    };
    let Some(name) = chosen else {
        let message = format!("the pipeline writes {} imported textures", written.len());
        return refuse(
            Place::Nowhere,
            message,
            "a picture is made of the one imported texture that passes write, or of \"target\"",
        );
    };
    let resource = &plan.resources[name];
    let place = Place::Span(plan.pipeline.resource(resource.handle).place);
    let (Some(format), Some(size)) = (resource.format, resource.size) else { return Ok(name.clone()) };
    if !matches!(format, wgpu::TextureFormat::Rgba8Unorm | wgpu::TextureFormat::Rgba8UnormSrgb) {
        return refuse(
            place,
            format!("\"{name}\" is {format:?}"),
            "pictures are rgba8unorm or rgba8unorm-srgb",
        );
    }
    if [size.width, size.height] != plan.viewport || size.layers != 1 || size.samples != 1 {
        let message = format!(
            "\"{name}\" is {} by {} with {} layers and {} samples",
            size.width, size.height, size.layers, size.samples
        );
        return refuse(place, message, "a picture has the size of the viewport, one layer and one sample");
    }
    Ok(name.clone())
}

/// A texture for each import of the plan; the picture first.
fn imports(graphics: &Graphics, plan: &Plan, picture: &str) -> Vec<(String, wgpu::Texture)> {
    let mut imported: Vec<_> =
        plan.resources.iter().filter(|(_, resource)| resource.lifetime == Lifetime::Imported).collect();
    imported.sort_by_key(|(name, _)| (*name != picture, (*name).clone()));
    imported
        .into_iter()
        .filter_map(|(name, resource)| {
            let (format, size) = (resource.format?, resource.size?);
            let texture = graphics.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(name),
                size: wgpu::Extent3d {
                    width: size.width,
                    height: size.height,
                    depth_or_array_layers: size.layers,
                },
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
