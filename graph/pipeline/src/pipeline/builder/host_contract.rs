//! The contract between a shader and the host's draws, checked without the host.
//!
//! Groups 2 (material) and 3 (object) of a program that draws the host's meshes, and its vertex inputs, must be among
//! what the pipeline's `geometry` says the host provides. How a host lays out what it uploads is compared with the same
//! shaders by [`crate::draw::check_host`]: of hosts that the registry states, with each load; of any other, when an
//! executor is made.

use crate::draw::{MATERIAL_GROUP, OBJECT_GROUP};
use crate::pipeline::builder::PassBuilder;
use crate::pipeline::program::{Program, ProgramBinding, ProgramVariant};
use crate::pipeline::settings::evaluate::Evaluate;
use umbragraph_shaders::{Member, TypeLayout, VertexInput};
use umbragraph_text::diagnostic::{codes, suggested_name};
use umbragraph_text::language::{GeometryDeclaration, HostBinding};

/// A message about a mismatch, and the help text for it.
type Misfit = (String, String);

/// Checks a program against a geometry contract and reports what does not fit. Returns `true` if all fits.
pub(crate) fn check(pass: &mut PassBuilder<'_>, geometry: &str, program: &Program, pointer: &str) -> bool {
    let Some(contract) = pass.shared.geometry.get(geometry) else { return false };
    let mut misfits = vertex_misfits(geometry, contract, program);
    misfits.extend(binding_misfits(geometry, contract, program));
    let fine = misfits.is_empty();
    for (message, help) in misfits {
        pass.report(codes::HOST_CONTRACT, &format!("{pointer}/shader"), message, help);
    }
    fine
}

fn vertex_misfits(geometry: &str, contract: &GeometryDeclaration, program: &Program) -> Vec<Misfit> {
    let template = &program.template;
    let mut misfits = Vec::new();
    let inputs = program.variants.iter().flat_map(ProgramVariant::vertex_inputs);
    for VertexInput { name, format: wanted, .. } in inputs {
        let Some(format) = contract.vertex.get(name) else {
            let message = format!(
                "{template} reads the vertex input \"{name}\", which \"{geometry}\" does not provide"
            );
            misfits.push((message, suggestion(name, contract.vertex.keys(), "vertex")));
            continue;
        };
        let (message, help) = match parse_format(format) {
            Some(format) if compatible(format, *wanted) => continue,
            Some(_) => {
                let wanted = format_name(*wanted);
                let message =
                    format!("{template} reads \"{name}\" as {wanted}, \"{geometry}\" provides {format}");
                (message, "change the template's type, or the format that the host provides")
            }
            None => {
                let message = format!("\"{format}\" of the vertex input \"{name}\" is not a vertex format");
                (message, "the formats are those of WebGPU, such as float32x3, unorm8x4, uint16x4")
            }
        };
        misfits.push((message, help.to_owned()));
    }
    misfits
}

fn binding_misfits(geometry: &str, contract: &GeometryDeclaration, program: &Program) -> Vec<Misfit> {
    let template = &program.template;
    let mut misfits = Vec::new();
    for ProgramBinding { group, name, type_name, block, .. } in &program.bindings {
        let (section, provided) = match *group {
            MATERIAL_GROUP => ("material", &contract.material),
            OBJECT_GROUP.. => ("object", &contract.object),
            _ => continue,
        };
        let provided_here = provided.get(name);
        let members = provided_here.zip(block.as_ref()).and_then(|(own, layout)| members_of(own, layout));
        match (provided_here, block, members) {
            (None, ..) => {
                let message = format!(
                    "{template} binds \"{name}\" in group {group}, which \"{geometry}\" does not provide"
                );
                let help = suggestion(name, provided.keys(), section);
                misfits.push((
                    message,
                    format!("{help}; bindings of your own are in group 1, from @binding(20) on"),
                ));
            }
            (Some(HostBinding::Opaque(own)), None, _) if own == type_name => {}
            (_, _, Some((members, wanted))) => {
                for Member { name: member, layout, .. } in wanted {
                    let wanted = layout.spelling();
                    misfits.extend(match members.get(member) {
                        Some(own) if *own == wanted => None,
                        Some(own) => {
                            let message = format!(
                                "{template} reads \"{name}.{member}\" as {wanted}, \"{geometry}\" provides {own}"
                            );
                            let help = "change the template's type, or what the host provides";
                            Some((message, help.to_owned()))
                        }
                        None => {
                            let message = format!(
                                "{template} reads \"{name}.{member}\", which \"{geometry}\" does not provide"
                            );
                            let section = format!("{section}.{name}");
                            Some((message, suggestion(member, members.keys(), &section)))
                        }
                    });
                }
            }
            _ => {
                let message = format!(
                    "{template} declares \"{name}\" as {type_name}, \"{geometry}\" provides something else"
                );
                let help = "write textures and samplers as their WGSL type, blocks as an object of members, arrays as a list with one";
                misfits.push((message, help.to_owned()));
            }
        }
    }
    misfits
}

type Members<'a> = (&'a std::collections::BTreeMap<String, String>, &'a [Member]);

/// The members that the host provides and the members that the shader declares, of a uniform block or of an array's
/// element. `None` if the host provides another kind of binding than the shader declares.
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

/// Parses a vertex format by its WebGPU name; `None` if there is no such format.
pub(crate) fn parse_format(name: &str) -> Option<wgpu_types::VertexFormat> {
    serde_json::from_value(name.into()).ok()
}

pub(crate) fn format_name(format: wgpu_types::VertexFormat) -> String {
    serde_json::to_value(format).ok().and_then(|name| name.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Returns `true` if a vertex buffer of format `have` can feed a shader input whose natural format is `want`. Both must
/// have the same component type in the shader. WebGPU fills missing components with 0 (alpha: 1) and drops surplus
/// ones.
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

/// The names of all vertex formats, sorted, for suggestions where a name is misspelt.
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
