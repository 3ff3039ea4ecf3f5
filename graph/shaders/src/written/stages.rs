//! Compares the inputs of a fragment stage with the outputs of the vertex stage before it.
//!
//! naga validates each entry point alone; a mismatch between two is otherwise found by the device only, when it creates
//! the pipeline. WebGPU requires an output of the vertex stage for every user-defined input of the fragment stage, with
//! the same location, type and interpolation. Vertex outputs without an input are dropped.
//!
//! Each fragment stage of a module is compared with its vertex stage. With several vertex stages, only the first of
//! each by name are compared; passes define the other pairs. A module with only one of the two stages is not checked.
//!
//! Limits: an explicit interpolation does not equal the default, even if it means the same (`perspective` against
//! none): devices compare what is written. naga keeps no spans of arguments and members, so these are found by name.

use std::ops::Range;

use naga::common::wgsl::{ToWgsl as _, TypeContext as _};
use naga::{EntryPoint, Handle, Interpolation, Module, Sampling, ShaderStage, Span, Type};

use super::complexity;
use super::ir::{self, Bound};
use super::rejection::{Rejection, Scope};
use crate::codes;

/// An inter-stage variable: a user-defined output of a vertex stage or input of a fragment stage.
struct Variable<'a> {
    bound: Bound<'a>,
    location: u32,
    interpolation: Option<Interpolation>,
    sampling: Option<Sampling>,
}

/// The variables with a location among an entry point's inputs or outputs, sorted by location; built-in values are left
/// out.
fn variables(all: Vec<Bound<'_>>) -> Vec<Variable<'_>> {
    let all = all.into_iter();
    let mut found: Vec<Variable<'_>> = all
        .filter_map(|bound| match *bound.binding {
            naga::Binding::Location { location, interpolation, sampling, .. } => {
                Some(Variable { bound, location, interpolation, sampling })
            }
            naga::Binding::BuiltIn(_) => None,
        })
        .collect();
    found.sort_by_key(|variable| variable.location);
    found
}

/// Returns a rejection for each fragment input without a matching output of the vertex stage. If there are several
/// stages of a kind, only the first by name is compared. `text` is the module's WGSL.
pub(crate) fn mismatched(text: &str, module: &Module) -> Vec<Rejection> {
    let of = |stage: ShaderStage| {
        let mut those: Vec<_> = module.entry_points.iter().filter(|entry| entry.stage == stage).collect();
        those.sort_by_key(|entry| &entry.name);
        those
    };
    let (vertices, fragments) = (of(ShaderStage::Vertex), of(ShaderStage::Fragment));
    let Some(vertex) = vertices.first() else { return Vec::new() };
    let compared = if vertices.len() == 1 { fragments.len() } else { 1 };
    let pairs = fragments.iter().take(compared).map(|fragment| Pair { text, module, vertex, fragment });
    pairs.flat_map(|pair| pair.rejections()).collect()
}

struct Pair<'a> {
    text: &'a str,
    module: &'a Module,
    vertex: &'a EntryPoint,
    fragment: &'a EntryPoint,
}

impl Pair<'_> {
    fn rejections(&self) -> Vec<Rejection> {
        let written = variables(ir::outputs(self.module, &self.vertex.function));
        let read = variables(ir::inputs(self.module, &self.fragment.function));
        read.iter().filter_map(|input| self.rejection(input, &written)).collect()
    }

    fn rejection(&self, input: &Variable<'_>, written: &[Variable<'_>]) -> Option<Rejection> {
        let Variable { bound: Bound { name, ty, .. }, location, .. } = input;
        let (vertex, fragment) = (&self.vertex.name, &self.fragment.name);
        // Neither words nor places are worked out for what fits.
        let reads = || format!("\"{fragment}\" reads \"{name}\" at @location({location})");
        let type_of = |ty: Handle<Type>| self.module.to_ctx().type_to_string(ty);
        let output = written.iter().find(|output| output.location == *location);
        let Some(output) = output else {
            let message = format!("{}, where \"{vertex}\" writes nothing", reads());
            return Some(match written.iter().find(|output| output.bound.name == *name) {
                Some(output) => {
                    let label = format!("\"{vertex}\" writes \"{name}\" at @location({})", output.location);
                    let place = self.place(output, vertex);
                    self.reject(input, message, place, label, "give it one location in both stages")
                }
                None => {
                    let label = format!("\"{vertex}\" is the vertex stage");
                    let help = "write it in the vertex stage too, or do not read it";
                    self.reject(input, message, entry_point(self.text, vertex), label, help)
                }
            });
        };
        let (message, help) = if self.module.types[*ty].inner != self.module.types[output.bound.ty].inner {
            let (read, written) = (type_of(*ty), type_of(output.bound.ty));
            let message = format!("{} as {read}, but \"{vertex}\" writes {written}", reads());
            (message, "use one type in both stages")
        } else if (input.interpolation, input.sampling) != (output.interpolation, output.sampling) {
            let (read, written) = (interpolation(input), interpolation(output));
            let message = format!("{} {read}, but \"{vertex}\" writes it {written}", reads());
            (message, "use one interpolation in both stages, and write it alike")
        } else {
            return None;
        };
        let label = format!("\"{vertex}\" writes it here");
        Some(self.reject(input, message, self.place(output, vertex), label, help))
    }

    fn reject(
        &self,
        input: &Variable<'_>,
        message: String,
        place: Option<Range<usize>>,
        label: String,
        help: &str,
    ) -> Rejection {
        let at = self.place(input, &self.fragment.name).map_or(Span::UNDEFINED, Span::from);
        let mut rejection =
            Rejection::new(codes::STAGES_MISMATCH, message, at).help(help).of(Scope::Interface);
        rejection.labels.extend(place.map(|place| (place, label)));
        rejection
    }

    fn place(&self, variable: &Variable<'_>, entry_point: &str) -> Option<Range<usize>> {
        place(self.text, self.module, &variable.bound, entry_point)
    }
}

/// The byte range of an inter-stage variable's declaration (a structure member or an argument), or else of its entry
/// point's name.
fn place(text: &str, module: &Module, variable: &Bound<'_>, name: &str) -> Option<Range<usize>> {
    let entry_point = entry_point(text, name);
    let within = match variable.owner {
        Some(owner) => module.types.get_span(owner).to_range(),
        None => entry_point.as_ref().map(|name| {
            let rest = &text[name.end..];
            name.end..name.end + rest.find('{').unwrap_or(rest.len())
        }),
    };
    let declared = within.and_then(|within| {
        let text = text.get(within.clone())?;
        let found = words(text, variable.name).find(|range| text[range.end..].trim_start().starts_with(':'));
        found.map(|range| within.start + range.start..within.start + range.end)
    });
    declared.or(entry_point)
}

fn interpolation(variable: &Variable<'_>) -> String {
    let Some(interpolation) = variable.interpolation else { return "without interpolation".to_owned() };
    let sampling = variable.sampling.map(|sampling| format!(", {}", sampling.to_wgsl()));
    format!("with @interpolate({}{})", interpolation.to_wgsl(), sampling.unwrap_or_default())
}

/// The byte range of an entry point's name, found in the WGSL since naga stores no span for it. `None` if it is not
/// found.
pub(crate) fn entry_point(text: &str, name: &str) -> Option<Range<usize>> {
    words(text, name).find(|range| {
        let before = text[..range.start].trim_end();
        before.ends_with("fn") && before.len() < range.start
    })
}

/// The byte range of the attribute `@workgroup_size` of an entry point; `None` if there is none.
pub(crate) fn workgroup_size(text: &str, name: &str) -> Option<Range<usize>> {
    const ATTRIBUTE: &str = "@workgroup_size";
    let before = &text[..entry_point(text, name)?.start];
    let own = before.rfind(['}', ';']).map_or(0, |end| end + 1);
    let at = own + before[own..].rfind(ATTRIBUTE)?;
    Some(at..at + ATTRIBUTE.len())
}

/// The byte range of the first inter-stage variable whose number or location exceeds the limit `allowed`, or else of
/// the last one. `None` without inter-stage variables.
pub(crate) fn variable_beyond(
    text: &str,
    module: &Module,
    entry: &EntryPoint,
    allowed: u64,
) -> Option<Range<usize>> {
    let variables = variables(match entry.stage {
        ShaderStage::Vertex => ir::outputs(module, &entry.function),
        _ => ir::inputs(module, &entry.function),
    });
    let is_beyond =
        |(at, each): &(usize, &Variable<'_>)| *at as u64 >= allowed || u64::from(each.location) >= allowed;
    let beyond = variables.iter().enumerate().find(is_beyond).map(|(_, variable)| variable);
    place(text, module, &beyond.or(variables.last())?.bound, &entry.name)
}

/// Iterates over the byte ranges at which a name occurs in WGSL as a separate word. Empty for an empty name.
pub(crate) fn words<'t>(text: &'t str, name: &'t str) -> impl Iterator<Item = Range<usize>> + 't {
    let is_word = |byte: Option<&u8>| byte.is_some_and(complexity::is_of_word);
    let bytes = text.as_bytes();
    let found = text.match_indices(name).map(|(at, name)| at..at + name.len());
    found.filter(move |range| {
        let before = range.start.checked_sub(1).and_then(|at| bytes.get(at));
        !range.is_empty() && !is_word(before) && !is_word(bytes.get(range.end))
    })
}
