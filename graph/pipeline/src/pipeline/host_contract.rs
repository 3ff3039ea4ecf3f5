//! The contract between a shader and the host's draws, checked without the host.
//!
//! Groups 2 (material) and 3 (object) of a program that draws the host's meshes, and its vertex inputs, must be among
//! what the pipeline's `geometry` says the host provides. How a host lays out what it uploads is compared with the same
//! shaders by [`crate::draw::check_host`]: of hosts that the registry states, with each load; of any other, when an
//! executor is made.

use super::{Evaluate, PassBuilder, Program};
use crate::diagnostic::{codes, suggested_name};
use crate::draw::MATERIAL_GROUP;
use crate::language::HostBinding;
use crate::shader::{Member, TypeLayout};

/// Checks a program against a contract; reports, and says whether it fits.
pub(super) fn check(pass: &mut PassBuilder<'_>, geometry: &str, program: &Program, pointer: &str) -> bool {
    let Some(contract) = pass.shared.geometry.get(geometry).cloned() else { return false };
    let at = format!("{pointer}/shader");
    let template = &program.template;
    let mut fine = true;
    let mut report = |pass: &mut PassBuilder<'_>, message: String, help: String| {
        pass.report(codes::HOST_CONTRACT, &at, message, help);
        fine = false;
    };
    for variant in &program.variants {
        for input in variant.vertex_inputs() {
            let Some(format) = contract.vertex.get(&input.name) else {
                let help = suggestion(&input.name, contract.vertex.keys(), "vertex");
                report(
                    pass,
                    format!(
                        "{template} reads the vertex input \"{}\", which \"{geometry}\" does not provide",
                        input.name
                    ),
                    help,
                );
                continue;
            };
            match parse_format(format) {
                Some(format) if compatible(format, input.format) => {}
                Some(_) => report(
                    pass,
                    format!(
                        "{template} reads \"{}\" as {}, \"{geometry}\" provides {format}",
                        input.name,
                        format_name(input.format)
                    ),
                    "change the template's type, or the format that the host provides".to_owned(),
                ),
                None => report(
                    pass,
                    format!("\"{format}\" of the vertex input \"{}\" is not a vertex format", input.name),
                    "the formats are those of WebGPU, such as float32x3, unorm8x4, uint16x4".to_owned(),
                ),
            }
        }
    }
    for binding in program.bindings.iter().filter(|binding| binding.group >= MATERIAL_GROUP) {
        let (section, provided) = if binding.group == MATERIAL_GROUP {
            ("material", &contract.material)
        } else {
            ("object", &contract.object)
        };
        match (provided.get(&binding.name), &binding.block) {
            (None, _) => {
                let help = suggestion(&binding.name, provided.keys(), section);
                let message = format!(
                    "{template} binds \"{}\" in group {}, which \"{geometry}\" does not provide",
                    binding.name, binding.group
                );
                report(pass, message, help);
            }
            (Some(HostBinding::Opaque(type_name)), None) if *type_name == binding.type_name => {}
            (Some(provided), Some(layout)) if members_of(provided, layout).is_some() => {
                let Some((members, wanted)) = members_of(provided, layout) else { continue };
                for member in wanted {
                    match members.get(&member.name) {
                        Some(type_name) if *type_name == member.layout.spelling() => {}
                        Some(type_name) => report(
                            pass,
                            format!(
                                "{template} reads \"{}.{}\" as {}, \"{geometry}\" provides {type_name}",
                                binding.name,
                                member.name,
                                member.layout.spelling()
                            ),
                            "change the template's type, or what the host provides".to_owned(),
                        ),
                        None => report(
                            pass,
                            format!(
                                "{template} reads \"{}.{}\", which \"{geometry}\" does not provide",
                                binding.name, member.name
                            ),
                            suggestion(&member.name, members.keys(), &format!("{section}.{}", binding.name)),
                        ),
                    }
                }
            }
            (Some(_), _) => report(
                pass,
                format!(
                    "{template} declares \"{}\" as {}, \"{geometry}\" provides something else",
                    binding.name, binding.type_name
                ),
                "write textures and samplers as their WGSL type, blocks as an object of members, arrays as a list with one"
                    .to_owned(),
            ),
        }
    }
    fine
}

type Members<'a> = (&'a std::collections::BTreeMap<String, String>, &'a [Member]);

/// The members that are provided, and those that are wanted, where both are of a block or both of an array's element.
fn members_of<'a>(provided: &'a HostBinding, layout: &'a TypeLayout) -> Option<Members<'a>> {
    match (provided, layout) {
        (HostBinding::Block(members), TypeLayout::Struct { members: wanted, .. }) => Some((members, wanted)),
        (HostBinding::Array([members]), TypeLayout::Array { element, count: None, .. }) => match &**element {
            TypeLayout::Struct { members: wanted, .. } => Some((members, wanted)),
            _ => None,
        },
        _ => None,
    }
}

fn suggestion<'a>(name: &str, known: impl Iterator<Item = &'a String>, section: &str) -> String {
    match suggested_name(name, known.map(String::as_str)) {
        Some(suggested) => format!("did the template mean \"{suggested}\"?"),
        None => format!("declare \"{name}\" under \"{section}\" of the geometry"),
    }
}

/// A vertex format by its WebGPU name.
pub(crate) fn parse_format(name: &str) -> Option<wgpu_types::VertexFormat> {
    serde_json::from_value(name.into()).ok()
}

pub(crate) fn format_name(format: wgpu_types::VertexFormat) -> String {
    serde_json::to_value(format).ok().and_then(|name| name.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Whether a buffer of format `have` can feed a shader input whose natural format is `want`: the same component type
/// in the shader. A missing component is filled with 0 (alpha: 1), a surplus one is dropped, as WebGPU has it.
pub(crate) fn compatible(have: wgpu_types::VertexFormat, want: wgpu_types::VertexFormat) -> bool {
    let class = |format: wgpu_types::VertexFormat| {
        let name = format_name(format);
        if name.starts_with("uint") {
            1
        } else if name.starts_with("sint") {
            2
        } else {
            0
        }
    };
    class(have) == class(want)
}

/// The formats of vertex attributes by name, sorted, for what a misspelt one was meant to be.
pub(crate) fn vertex_formats() -> Vec<String> {
    let kinds = ["float", "sint", "snorm", "uint", "unorm"].into_iter();
    let sized =
        kinds.flat_map(|kind| ["10-10-10-2", "16", "32", "64", "8"].map(|bits| format!("{kind}{bits}")));
    let all =
        sized.flat_map(|sized| ["", "x2", "x3", "x4", "x4-bgra"].map(|count| format!("{sized}{count}")));
    all.filter(|name| parse_format(name).is_some()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vertex_formats_are_those_of_webgpu_in_their_order() {
        let formats = vertex_formats();
        assert!(formats.is_sorted());
        assert_eq!((formats.len(), &*formats[0], &*formats[44]), (45, "float16", "unorm8x4-bgra"));
    }
}
