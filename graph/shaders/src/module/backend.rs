//! Writing a module in the language of a target.
//!
//! Validation does not run the writers, and each of them rejects some valid modules, so proving a variant for a target
//! means writing it. Bindings keep their WGSL numbers; the host's driver layer maps them in its own way later, which
//! changes numbers and nothing else.

use std::error::Error;
use std::ops::Range;

use naga::back::{glsl, hlsl, msl, spv, wgsl as wgsl_out};
use naga::proc::BoundsCheckPolicies;
use naga::valid::ModuleInfo;
use naga::{Expression, Function, Handle, ImageClass, Module, Span, TypeInner};

use super::wgsl::guarded;
use crate::codes;
use crate::targets::profile::TargetLanguage;
use crate::written::ir;
use crate::written::rejection::{Rejection, Scope, one_line};

/// A module translated to a target's shading language.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Emitted {
    /// Source code in the target's language. For GLSL this is one shader per entry point, each after a comment with the
    /// entry point's name.
    Text(String),
    /// A SPIR-V module as 32-bit words.
    Words(Vec<u32>),
}

impl Emitted {
    /// Returns the bytes to write to a file: source code as UTF-8, or SPIR-V words in little-endian order.
    pub fn to_bytes(&self) -> Vec<u8> {
        match self {
            Emitted::Text(text) => text.clone().into_bytes(),
            Emitted::Words(words) => words.iter().flat_map(|word| word.to_le_bytes()).collect(),
        }
    }
}

/// The help text for reads of depth textures that GLSL cannot express.
const AS_NUMBERS: &str =
    "declare the texture as texture_2d<f32>, and read it by textureLoad or through a nearest sampler";

/// Translates a validated module, in which no overrides are left, to a shading language.
///
/// # Errors
/// A rejection if the language cannot express the module.
pub(crate) fn emit(
    module: &Module,
    info: &ModuleInfo,
    language: TargetLanguage,
) -> Result<Emitted, Rejection> {
    if matches!(language, TargetLanguage::Glsl | TargetLanguage::GlslWebgl2)
        && let Some(range) = uncompared(module)
    {
        let message = format!("{} compares whatever it samples of a depth texture", language.name());
        let rejection = Rejection::new(codes::BACKEND_REJECTS, message, Span::UNDEFINED);
        return Err(Rejection { range: Some(range), help: Some(AS_NUMBERS.to_owned()), ..rejection });
    }
    let gather =
        |expression: &Expression| matches!(expression, Expression::ImageSample { gather: Some(_), .. });
    if language == TargetLanguage::GlslWebgl2
        && let Some(range) = first(module, |_, expression| gather(expression))
    {
        let message = format!("{} has no textureGather", language.name());
        let help = "read the four texels by textureLoad";
        let rejection = Rejection::new(codes::BACKEND_REJECTS, message, Span::UNDEFINED);
        return Err(Rejection { range: Some(range), help: Some(help.to_owned()), ..rejection });
    }
    guarded(|| {
        write(module, info, language).map_err(|error| {
            let error = error.to_string();
            let message = format!("{} cannot express this: {}", language.name(), one_line(&error));
            // The writer of GLSL does not say where.
            let range = depth_load(module).filter(|_| error.contains("depth textures"));
            let help = range.as_ref().map(|_| AS_NUMBERS.to_owned());
            // Writers name things over the whole module, and most do not say which of them they reject.
            let rejection = Rejection::new(codes::BACKEND_REJECTS, message, Span::UNDEFINED).of(Scope::Text);
            Rejection { range, help, ..rejection }
        })
    })
}

fn write(module: &Module, info: &ModuleInfo, language: TargetLanguage) -> Result<Emitted, Box<dyn Error>> {
    Ok(match language {
        TargetLanguage::Wgsl => {
            Emitted::Text(wgsl_out::write_string(module, info, wgsl_out::WriterFlags::empty())?)
        }
        TargetLanguage::Spirv => {
            let options = spv::Options { lang_version: (1, 3), ..spv::Options::default() };
            Emitted::Words(spv::write_vec(module, info, &options, None)?)
        }
        TargetLanguage::Msl => {
            let options = msl::Options { lang_version: (2, 3), ..msl::Options::default() };
            let (text, found) = msl::write_string(module, info, &options, &msl::PipelineOptions::default())?;
            found.entry_point_names.into_iter().collect::<Result<Vec<String>, _>>()?;
            Emitted::Text(text)
        }
        TargetLanguage::Hlsl => {
            let options = hlsl::Options { shader_model: hlsl::ShaderModel::V6_0, ..hlsl::Options::default() };
            let (mut text, pipeline) = (String::new(), hlsl::PipelineOptions::default());
            let found = hlsl::Writer::new(&mut text, &options, &pipeline).write(module, info, None)?;
            found.entry_point_names.into_iter().collect::<Result<Vec<String>, _>>()?;
            Emitted::Text(text)
        }
        TargetLanguage::Glsl => Emitted::Text(glsl_texts(module, info, glsl::Version::new_gles(310))?),
        TargetLanguage::GlslWebgl2 => {
            let version = glsl::Version::Embedded { version: 300, is_webgl: true };
            Emitted::Text(glsl_texts(module, info, version)?)
        }
    })
}

fn glsl_texts(module: &Module, info: &ModuleInfo, version: glsl::Version) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    let options = glsl::Options { version, ..glsl::Options::default() };
    for naga::EntryPoint { stage, name, .. } in &module.entry_points {
        let pipeline =
            glsl::PipelineOptions { shader_stage: *stage, entry_point: name.clone(), multiview: None };
        let mut one = String::new();
        glsl::Writer::new(&mut one, module, info, &options, &pipeline, BoundsCheckPolicies::default())
            .and_then(|mut writer| writer.write())
            .map_err(|error| format!("{error} (in the entry point \"{name}\")"))?;
        text.push_str(&format!("// entry point {name}\n{one}"));
    }
    Ok(text)
}

/// The byte range of the first `textureLoad` from a depth texture; `None` if there is none.
fn depth_load(module: &Module) -> Option<Range<usize>> {
    of_depth(module, |expression| match expression {
        Expression::ImageLoad { image, .. } => Some(*image),
        _ => None,
    })
}

/// The byte range of the first sample of a depth texture without comparison; `None` if there is none. naga translates
/// such samples to GLSL that drivers reject.
fn uncompared(module: &Module) -> Option<Range<usize>> {
    of_depth(module, |expression| match expression {
        Expression::ImageSample { image, depth_ref: None, .. } => Some(*image),
        _ => None,
    })
}

/// The byte range of the first expression for which `image_of` returns a depth texture; `None` if there is none.
fn of_depth(
    module: &Module,
    image_of: impl Fn(&Expression) -> Option<Handle<Expression>>,
) -> Option<Range<usize>> {
    first(module, |function, expression| {
        let image = image_of(expression).and_then(|image| ir::image(module, function, image));
        matches!(image, Some(TypeInner::Image { class: ImageClass::Depth { .. }, .. }))
    })
}

/// The byte range of the first expression for which `is_one` returns `true`; `None` if there is none.
fn first(module: &Module, is_one: impl Fn(&Function, &Expression) -> bool) -> Option<Range<usize>> {
    ir::functions(module).find_map(|function| {
        let (handle, _) = function.expressions.iter().find(|(_, each)| is_one(function, each))?;
        function.expressions.get_span(handle).to_range()
    })
}
