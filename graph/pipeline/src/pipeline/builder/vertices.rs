//! Vertex attributes of the pipeline's own buffers, matched with the shader's vertex inputs by name.

use wgpu_types::VertexAttribute;

use crate::pipeline::builder::PassBuilder;
use crate::pipeline::builder::host_contract::{compatible, format_name, parse_format, vertex_formats};
use crate::pipeline::settings::evaluate::Evaluate;
use crate::work::ProgramHandle;
use umbragraph_shaders::VertexInput;
use umbragraph_text::diagnostic::{codes, list_of};

impl PassBuilder<'_> {
    /// The vertex inputs of a program's variant without mesh properties, with their shader locations.
    pub fn vertex_inputs(&self, program: ProgramHandle) -> Vec<VertexInput> {
        let variant = self.shared.programs.list[program.index()].variants.first();
        variant.map(|variant| variant.vertex_inputs().to_vec()).unwrap_or_default()
    }

    /// Checks the vertex attributes of one buffer, each given as name, vertex format and byte offset. An attribute
    /// without an offset begins where the attributes before it end. Returns the attributes and the byte offset at which
    /// the last one ends. Returns `None` after a diagnostic for an unknown name, or for an invalid format or offset.
    /// `pointer` is the JSON pointer of the list of attributes.
    pub fn vertex_attributes(
        &mut self,
        program: ProgramHandle,
        attributes: &[(&str, &str, Option<u64>)],
        pointer: &str,
    ) -> Option<(Vec<VertexAttribute>, u64)> {
        let inputs = self.vertex_inputs(program);
        let mut found = Vec::with_capacity(attributes.len());
        let mut end = 0;
        let mut sound = true;
        for (at, (name, format, offset)) in attributes.iter().enumerate() {
            let here = format!("{pointer}/{at}");
            let Some(parsed) = parse_format(format) else {
                let message = format!("\"{format}\" is not a vertex format");
                let (at, known) = (format!("{here}/format"), vertex_formats());
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                self.report_unknown(codes::HOST_CONTRACT, &at, message, format, &known, || {
                    let read = inputs.iter().find(|input| input.name == *name);
                    let fitting = read.map_or("float32x3".to_owned(), |input| format_name(input.format));
                    format!("vertex formats have WebGPU's names: write \"{fitting}\"")
                });
                sound = false;
                continue;
            };
            let offset = offset.unwrap_or(end);
            end = end.max(offset + parsed.size());
            let Some(input) = inputs.iter().find(|input| input.name == *name) else {
                let names: Vec<&str> = inputs.iter().map(|input| input.name.as_str()).collect();
                let message = format!("the shader reads no attribute \"{name}\"");
                let at = format!("{here}/name");
                self.report_unknown(codes::UNKNOWN_BINDING, &at, message, name, &names, || match &*names {
                    [] => "its vertex stage reads no attributes".to_owned(),
                    names => format!("it reads {}", list_of(names.iter().copied())),
                });
                sound = false;
                continue;
            };
            if !compatible(parsed, input.format) {
                let wanted = format_name(input.format);
                let message = format!("\"{name}\" is {format}, which the shader cannot read as {wanted}");
                let help = format!("store {wanted}");
                self.report(codes::HOST_CONTRACT, &format!("{here}/format"), message, help);
                sound = false;
                continue;
            }
            if offset % parsed.size().clamp(1, 4) != 0 {
                let message = format!("\"{name}\" begins at byte {offset}");
                let help = format!("begin at a multiple of {}", parsed.size().clamp(1, 4));
                self.report(codes::DEVICE_RULE, &format!("{here}/offset"), message, help);
                sound = false;
                continue;
            }
            found.push(VertexAttribute { format: parsed, offset, shader_location: input.location });
        }
        sound.then_some((found, end))
    }

    /// Checks that each vertex input of a program is given exactly once; returns `None` after a diagnostic.
    pub fn check_vertex_inputs(
        &mut self,
        program: ProgramHandle,
        given: &[&str],
        pointer: &str,
    ) -> Option<()> {
        let mut sound = true;
        for input in self.vertex_inputs(program) {
            let count = given.iter().filter(|name| **name == input.name).count();
            if count == 1 {
                continue;
            }
            sound = false;
            let (code, message) = match count {
                0 => (
                    codes::UNBOUND,
                    format!("the shader reads the attribute \"{}\", which no buffer has", input.name),
                ),
                _ => (
                    codes::UNKNOWN_BINDING,
                    format!("the attribute \"{}\" is given {count} times", input.name),
                ),
            };
            self.report(code, pointer, message, "give each attribute in one buffer");
        }
        sound.then_some(())
    }
}
