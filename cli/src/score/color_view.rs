//! The path-traced reference of a frame's picture, and the comparison of rendered pictures with it.
//!
//! The reference gets its light from the scene, and its sky from the pipeline: the picture of `--environment`, or the
//! parameters `horizon`, `zenith` and `ground_reflectance` (`ambient_sky` and `ambient_ground` where the feature
//! `sky_light` is off or absent). `exposure` and `tone_map` bring it to the display, as the pipeline does with its picture.

use glam::DVec3;
use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, Severity, list_of};
use umbragraph::frame::FrameInput;
use umbragraph::low_level::capture::{self, Capture, Wanted};
use umbragraph::low_level::environment::{self, Environment};
use umbragraph::low_level::expression::Value;
use umbragraph::low_level::pipeline::TypedPipeline;
use umbragraph::low_level::{CheckReport, picture};
use umbragraph::passes::words::CAST_SHADOW;
use umbragraph::scene::{Pose, Scene};
use umbragraph_score::Rays;
use umbragraph_score::color::lamp::Lamp;
use umbragraph_score::color::scores::{Compared, compare};
use umbragraph_score::color::sky::Radiance;
use umbragraph_score::color::surface::Surfaces;
use umbragraph_score::color::tracer::Traced;
use umbragraph_score::color::{ColorTracer, Display, Settings, Sky, ToneMap};

use super::nothing;
use crate::arguments::{Choices, ColorArguments};
use crate::codes;
use crate::progress::Progress;
use crate::render::capture::Captured;
use crate::render::{Drawing, Given};
use crate::session::Session;

/// The features that change a picture beyond the light in it, which no path traces.
const EFFECTS: [&str; 7] = ["auto_exposure", "bloom", "depth_of_field", "film", "fog", "fxaa", "temporal"];

/// Returns the choices of a command line, with the environment switched on if a picture is given.
pub(crate) fn choices(choices: &Choices, arguments: &ColorArguments) -> Choices {
    let mut choices = choices.clone();
    if arguments.environment.is_some() {
        choices.settings.feature.push("environment".to_owned());
    }
    choices
}

/// Adds the copy of the resource that `--resource` names to a checked pipeline. Returns the pipeline checked again, and
/// what a drawing of it is given: the copy, and the environment.
///
/// # Errors
/// A resource that cannot be captured, and an environment that cannot be read.
pub(crate) fn with_resource(
    checked: CheckReport,
    (pipeline, choices): (&std::path::Path, &Choices),
    arguments: &ColorArguments,
    session: &mut Session,
) -> Result<(CheckReport, Given), Diagnostics> {
    let plan = checked.plan.clone().ok_or_else(Diagnostics::new)?;
    let environment = Environment::of(arguments.environment.as_deref(), &plan)?;
    let Some(reference) = &arguments.resource else {
        picture::picture_of(&plan, &[])?;
        return Ok((checked, Given { environment, ..Given::default() }));
    };
    let wanted = Capture { reference: reference.clone(), mip: 0 };
    let document = capture::document(&plan, &[wanted], Wanted::Pictures)?;
    session.included = Some(document.text);
    let checked = session.check(pipeline, choices);
    session.ensure_fine(&checked)?;
    let size = document.imports.first().and_then(|name| checked.plan.as_ref()?.resources.get(name)?.size);
    let format = document.imports.first().and_then(|name| checked.plan.as_ref()?.resources.get(name)?.format);
    let is_linear = format.is_some_and(picture::is_of_floats);
    if size.is_some_and(|size| [size.width, size.height] != choices.size || size.layers != 1) || !is_linear {
        let [width, height] = choices.size;
        let message =
            format!("--resource: \"{reference}\" is no {width} by {height} texture of linear colors");
        let help =
            "name a texture of floats as large as the picture, such as color@sky of pipelines/umbra.json";
        return Err(Diagnostic::error(codes::SCORE, Place::Nowhere, message).help(help).into());
    }
    Ok((checked, Given { captures: document.imports, environment, ..Given::default() }))
}

/// Settings of a reference that follow from the pipeline.
pub(crate) struct Look {
    pub(crate) sky: Sky,
    display: Display,
}

impl Look {
    /// Reads the sky and the way to the display from the values of a pipeline.
    ///
    /// # Errors
    /// A tone curve that is not known.
    pub(crate) fn of(plan: &Plan, given: &Given, session: &mut Session) -> Result<Self, Diagnostic> {
        let pipeline = &plan.pipeline;
        let exposure = number(pipeline, "exposure").unwrap_or(1.0);
        let tone_map = match pipeline.parameters.get("tone_map").map(|parameter| &parameter.value) {
            None => ToneMap::None,
            Some(Value::Text(name)) if ToneMap::by_name(name).is_some() => {
                ToneMap::by_name(name).unwrap_or_default()
            }
            Some(value) => {
                let message =
                    format!("the tone curve {value} of the parameter \"tone_map\" is not known to score");
                let help = format!("set it to one of {}", list_of(ToneMap::NAMES));
                return Err(Diagnostic::error(codes::SCORE, Place::Nowhere, message).help(help));
            }
        };
        if color(pipeline, "horizon").is_none() && given.environment.is_none() {
            let message = "the pipeline has no parameter \"horizon\": the traced sky is black";
            let note = Diagnostic::warning(codes::SCORE, Place::Nowhere, message).severity(Severity::Note);
            session.diagnostics.push(
                note.help(
                    "declare \"horizon\" and \"zenith\", or give an environment with --environment FILE",
                ),
            );
        }
        Ok(Self { sky: sky(plan, given), display: Display { exposure, tone_map } })
    }
}

/// Notes which features change the picture beyond its light; nothing if a resource before them is compared.
pub(crate) fn effects(plan: &Plan, arguments: &ColorArguments) -> Option<Diagnostic> {
    let is_on = |name: &&&str| is_on(&plan.pipeline, name);
    let on: Vec<&str> = EFFECTS.iter().filter(is_on).copied().collect();
    let message = format!("the picture is compared with the effects of the features {}", list_of(&on));
    let help = "switch them off with --feature NAME=off, or compare the texture before them with --resource";
    let note = Diagnostic::warning(codes::SCORE, Place::Nowhere, message).severity(Severity::Note).help(help);
    (!on.is_empty() && arguments.resource.is_none()).then_some(note)
}

fn is_on(pipeline: &TypedPipeline, feature: &str) -> bool {
    pipeline.features.get(feature).is_some_and(|feature| feature.value == Value::Bool(true))
}

fn number(pipeline: &TypedPipeline, name: &str) -> Option<f64> {
    match pipeline.parameters.get(name)?.value {
        Value::Number(number) => Some(number),
        _ => None,
    }
}

fn color(pipeline: &TypedPipeline, name: &str) -> Option<DVec3> {
    let Value::List(list) = &pipeline.parameters.get(name)?.value else { return None };
    let number = |value: &Value| if let Value::Number(number) = value { Some(*number) } else { None };
    match list.iter().map(number).collect::<Option<Vec<f64>>>()?.as_slice() {
        [red, green, blue] => Some(DVec3::new(*red, *green, *blue)),
        _ => None,
    }
}

/// The sky of a pipeline.
fn sky(plan: &Plan, given: &Given) -> Sky {
    let pipeline = &plan.pipeline;
    let size = plan.resources.get(environment::IMPORT).and_then(|resource| resource.size);
    if let (Some(environment), Some(size)) = (&given.environment, size) {
        let (width, height) = (size.width as usize, size.height as usize);
        let light = Radiance::Picture {
            width,
            texels: environment.texels(width, height),
            turn: number(pipeline, "environment_turn").unwrap_or(0.0),
            strength: number(pipeline, "environment_strength").unwrap_or(1.0),
        };
        return Sky::new(light.clone(), light);
    }
    let of = |name: &str| color(pipeline, name).unwrap_or(DVec3::ZERO);
    let (horizon, zenith) = (of("horizon"), of("zenith"));
    let light = if is_on(pipeline, "sky_light") {
        Radiance::Gradient { horizon, zenith, below: horizon * of("ground_reflectance") }
    } else {
        // Illuminance of a surface that faces one of the halves.
        let part = std::f64::consts::FRAC_1_PI;
        Radiance::Halves { above: of("ambient_sky") * part, below: of("ambient_ground") * part }
    };
    Sky::new(light, Radiance::Gradient { horizon, zenith, below: horizon })
}

/// The path-traced reference of a frame.
pub(crate) struct ColorView {
    traced: Traced,
    display: Display,
    size: [u32; 2],
}

/// A rendered picture and its comparison with the reference.
pub(crate) struct ColorAnswer {
    pub(crate) compared: Compared,
    /// The picture as it is displayed, each channel 0 to 1.
    pub(crate) picture: Vec<DVec3>,
}

impl ColorView {
    /// Traces the paths of a frame; `None` if the camera sees no surface. Rows are counted in `progress`.
    pub(crate) fn new(
        (rays, scene, pose): (&Rays<'_>, &Scene, &Pose),
        input: &FrameInput,
        size: [u32; 2],
        (look, settings): (&Look, Settings),
        progress: &mut Progress,
    ) -> Option<Self> {
        let lamps = input.lights.iter().filter_map(|light| Lamp::new(light, light.has(CAST_SHADOW)));
        let surfaces = progress.stage("textures", || Surfaces::new(scene, pose));
        let tracer = ColorTracer::new(rays, surfaces, &look.sky, lamps.collect(), settings);
        let counter = progress.counter();
        let traced = progress.stage("paths", || tracer.picture(&input.camera, size, &|| counter(1)));
        traced.hit.contains(&true).then_some(Self { traced, display: look.display, size })
    }

    /// Renders the frame and compares its picture.
    pub(crate) fn answer(
        &self,
        drawing: &mut Drawing<'_>,
        input: &FrameInput,
        progress: &mut Progress,
    ) -> Result<ColorAnswer, Diagnostics> {
        progress.stage("draw", || drawing.frame(input))?;
        let picture = shown(drawing, &self.display)?;
        let compared =
            progress.stage("compare", || compare(&picture, &self.traced, self.size[0], &self.display));
        Ok(ColorAnswer { compared, picture })
    }
}

/// The picture of the last frame as it is displayed, or the captured texture of linear colors brought to the display.
fn shown(drawing: &Drawing<'_>, display: &Display) -> Result<Vec<DVec3>, Diagnostics> {
    if let Some(captured) = drawing.captured().next() {
        let Captured::Texels { texels, .. } = captured? else {
            return Err(nothing("--resource names a buffer", "name a texture of linear colors").into());
        };
        let color = |texel: &[f32; 4]| {
            let [red, green, blue, _] =
                texel.map(|part| if part.is_finite() { f64::from(part) } else { 0.0 });
            display.shown(DVec3::new(red, green, blue))
        };
        return Ok(texels.values.iter().map(color).collect());
    }
    let pixels = drawing.picture()?;
    let color = |[red, green, blue, _]: &[u8; 4]| {
        DVec3::new(f64::from(*red), f64::from(*green), f64::from(*blue)) / 255.0
    };
    Ok(pixels.as_chunks::<4>().0.iter().map(color).collect())
}
