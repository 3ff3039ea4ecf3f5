//! The picture of a plan: the imported texture that the command writes to a file and the viewer shows in its window.
//!
//! A pipeline may write several textures of the host, of any format and size. Only one of them can be a picture, and
//! only if its texels are colors. Scores ask [`picture_of`], which takes colors of a screen; files and windows that a
//! picture is converted for ask [`colors_of`]. Both reject a document with the same words, before a device would.

use crate::Plan;
use crate::diagnostic::{Diagnostic, Place, Severity, codes, list_of};
use crate::low_level::language::Lifetime;
use crate::wgpu_types::{TextureFormat, TextureSampleType};

/// Returns the name of the imported texture that passes write as the final picture. Among several, the one called
/// "target" counts; textures in `captures` do not count.
///
/// # Errors
/// No such texture, or one whose format, size, layer count or sample count does not fit a picture on a screen.
pub fn picture_of<'a>(plan: &'a Plan, captures: &[String]) -> Result<&'a str, Diagnostic> {
    let name = colors_of(plan, captures)?;
    let resource = &plan.resources[name];
    match resource.format {
        Some(format) if !is_of_screen(format) => {
            let place = Place::Span(plan.pipeline.resource(resource.handle).place);
            Err(Diagnostic::error(codes::PICTURE, place, format!("\"{name}\" is {format:?}")).help(
                "here a picture is rgba8unorm or rgba8unorm-srgb; `umbragraph render` writes others, too",
            ))
        }
        _ => Ok(name),
    }
}

/// Returns `true` for `rgba8unorm` and `rgba8unorm-srgb`, the formats of a picture on a screen.
pub fn is_of_screen(format: TextureFormat) -> bool {
    matches!(format, TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb)
}

/// The brightness at which tone mapping of a picture begins; 1 is the maximum of an 8-bit channel.
pub const BRIGHT: f32 = 0.8;

/// Returns `true` if a format can store colors above 1.
pub fn is_of_floats(format: TextureFormat) -> bool {
    use TextureFormat as Format;
    matches!(
        format,
        Format::R16Float
            | Format::Rg16Float
            | Format::Rgba16Float
            | Format::R32Float
            | Format::Rg32Float
            | Format::Rgba32Float
            | Format::Rg11b10Ufloat
    )
}

/// Returns the note that the colors of a picture are tone mapped for a screen; `None` if its format has none above 1.
pub fn tone_mapping(name: &str, format: TextureFormat) -> Option<Diagnostic> {
    let message = format!("\"{name}\" is {format:?}: colors above {BRIGHT} are tone mapped");
    let note = Diagnostic::warning(codes::PICTURE, Place::Nowhere, message).severity(Severity::Note).help(
        "`umbragraph render --out FILE.exr` writes the numbers themselves; a pass of the pipeline can tone map",
    );
    is_of_floats(format).then_some(note)
}

/// Returns the warning that a picture is without lights, which no pass reads; `None` if there are no such lights.
pub fn without_lights<'a>(names: impl Iterator<Item = &'a str>) -> Option<Diagnostic> {
    let names: Vec<&str> = names.collect();
    let message = format!("no pass of the pipeline reads the lights {}", list_of(&names));
    let warning = Diagnostic::warning(super::codes::UNREAD_LIGHTS, Place::Nowhere, message)
        .help("the picture is without them; pipelines/awsm.json takes every kind of light");
    (!names.is_empty()).then_some(warning)
}

/// Returns the name of the final picture as [`picture_of`] does, but accepts any color format.
///
/// # Errors
/// No such texture, or one of depth, of integers, or of another size than the viewport.
pub fn colors_of<'a>(plan: &'a Plan, captures: &[String]) -> Result<&'a str, Diagnostic> {
    let is_written = |handle| plan.passes.iter().any(|pass| plan.writes(pass.handle, handle));
    let written: Vec<&str> = plan
        .resources
        .iter()
        .filter(|(name, resource)| resource.lifetime == Lifetime::Imported && !captures.contains(name))
        .filter(|(_, resource)| is_written(resource.handle))
        .map(|(name, _)| name.as_str())
        .collect();
    let chosen = match written.as_slice() {
        [one] => Some(*one),
        several => several.iter().copied().find(|name| *name == "target"),
    };
    let Some(name) = chosen else {
        let message = format!("the pipeline writes {} imported textures", written.len());
        return Err(Diagnostic::error(codes::PICTURE, Place::Nowhere, message)
            .help("a picture is made of the one imported texture that passes write, or of \"target\""));
    };
    let resource = &plan.resources[name];
    let place = Place::Span(plan.pipeline.resource(resource.handle).place);
    let (Some(format), Some(size)) = (resource.format, resource.size) else { return Ok(name) };
    let is_color = matches!(format.sample_type(None, None), Some(TextureSampleType::Float { .. }));
    if !is_color || format.is_depth_stencil_format() || format.is_compressed() {
        return Err(Diagnostic::error(codes::PICTURE, place, format!("\"{name}\" is {format:?}"))
            .help("a picture has a format of colors, such as rgba8unorm or rgba16float; `--capture` writes the rest"));
    }
    if [size.width, size.height] != plan.viewport || size.layers != 1 || size.samples != 1 {
        let message = format!(
            "\"{name}\" is {} by {} with {} layers and {} samples",
            size.width, size.height, size.layers, size.samples
        );
        return Err(Diagnostic::error(codes::PICTURE, place, message)
            .help("a picture has the size of the viewport, one layer and one sample"));
    }
    Ok(name)
}
