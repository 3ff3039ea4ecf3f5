//! Writing a module in the language of a target.
//!
//! Validation does not run the writers, and each of them rejects some valid modules, so proving a variant for a target
//! means writing it. Bindings keep their WGSL numbers; the host's driver layer maps them in its own way later, which
//! changes numbers and nothing else.

use naga::back::{glsl, hlsl, msl, spv, wgsl as wgsl_out};
use naga::proc::BoundsCheckPolicies;
use naga::valid::ModuleInfo;
use naga::{Expression, ImageClass, Module, Span, TypeInner};

use super::profile::TargetLanguage;
use super::wgsl::guarded;
use super::wgsl_error::{Rejection, Stage, one_line};

/// A module in the language of a target.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Emitted {
    /// A text; GLSL is one text per entry point, one after the other, each under a comment with its name.
    Text(String),
    /// SPIR-V words.
    Words(Vec<u32>),
}

impl Emitted {
    /// The bytes of a file: text as UTF-8, words in little-endian order.
    pub fn to_bytes(&self) -> Vec<u8> {
        match self {
            Emitted::Text(text) => text.clone().into_bytes(),
            Emitted::Words(words) => words.iter().flat_map(|word| word.to_le_bytes()).collect(),
        }
    }
}

/// Writes a validated module without overrides.
///
/// # Errors
/// Why the writer rejects it.
pub(crate) fn emit(
    module: &Module,
    info: &ModuleInfo,
    language: TargetLanguage,
) -> Result<Emitted, Rejection> {
    guarded(|| match language {
        TargetLanguage::Wgsl => wgsl_out::write_string(module, info, wgsl_out::WriterFlags::empty())
            .map(Emitted::Text)
            .map_err(|error| reject(language, &error.to_string())),
        TargetLanguage::Spirv => {
            let options = spv::Options { lang_version: (1, 3), ..spv::Options::default() };
            spv::write_vec(module, info, &options, None)
                .map(Emitted::Words)
                .map_err(|error| reject(language, &error.to_string()))
        }
        TargetLanguage::Msl => {
            let options = msl::Options { lang_version: (2, 3), ..msl::Options::default() };
            let (text, found) = msl::write_string(module, info, &options, &msl::PipelineOptions::default())
                .map_err(|error| reject(language, &error.to_string()))?;
            match found.entry_point_names.into_iter().find_map(Result::err) {
                Some(error) => Err(reject(language, &error.to_string())),
                None => Ok(Emitted::Text(text)),
            }
        }
        TargetLanguage::Hlsl => {
            let options = hlsl::Options { shader_model: hlsl::ShaderModel::V6_0, ..hlsl::Options::default() };
            let mut text = String::new();
            let pipeline = hlsl::PipelineOptions::default();
            let found = hlsl::Writer::new(&mut text, &options, &pipeline)
                .write(module, info, None)
                .map_err(|error| reject(language, &error.to_string()))?;
            match found.entry_point_names.into_iter().find_map(Result::err) {
                Some(error) => Err(reject(language, &error.to_string())),
                None => Ok(Emitted::Text(text)),
            }
        }
        TargetLanguage::Glsl => glsl_texts(module, info).map(Emitted::Text),
    })
}

fn glsl_texts(module: &Module, info: &ModuleInfo) -> Result<String, Rejection> {
    let mut text = String::new();
    for entry_point in &module.entry_points {
        let options = glsl::Options { version: glsl::Version::new_gles(310), ..glsl::Options::default() };
        let pipeline = glsl::PipelineOptions {
            shader_stage: entry_point.stage,
            entry_point: entry_point.name.clone(),
            multiview: None,
        };
        let mut one = String::new();
        glsl::Writer::new(&mut one, module, info, &options, &pipeline, BoundsCheckPolicies::default())
            .and_then(|mut writer| writer.write())
            .map_err(|error| Rejection {
                range: depth_load(module).filter(|_| error.to_string().contains("depth textures")),
                ..reject(
                    TargetLanguage::Glsl,
                    &format!("{error} (in the entry point \"{}\")", entry_point.name),
                )
            })?;
        text.push_str(&format!("// entry point {}\n{one}", entry_point.name));
    }
    Ok(text)
}

/// The first load from a depth texture; GLSL's writer rejects it without saying where.
fn depth_load(module: &Module) -> Option<std::ops::Range<usize>> {
    let functions = module.functions.iter().map(|(_, function)| function);
    functions.chain(module.entry_points.iter().map(|entry_point| &entry_point.function)).find_map(
        |function| {
            let (handle, _) = function.expressions.iter().find(|(_, expression)| {
                let Expression::ImageLoad { image, .. } = expression else { return false };
                let ty = match function.expressions[*image] {
                    Expression::GlobalVariable(variable) => module.global_variables[variable].ty,
                    Expression::FunctionArgument(at) => match function.arguments.get(at as usize) {
                        Some(argument) => argument.ty,
                        None => return false,
                    },
                    _ => return false,
                };
                matches!(module.types[ty].inner, TypeInner::Image { class: ImageClass::Depth { .. }, .. })
            })?;
            function.expressions.get_span(handle).to_range()
        },
    )
}

fn reject(language: TargetLanguage, message: &str) -> Rejection {
    let message = format!("{} cannot express this: {}", language.name(), one_line(message));
    Rejection::new(Stage::Backend, message, Span::UNDEFINED)
}
