//! What a fragment stage reads against what the vertex stage before it writes.
//!
//! naga validates each entry point for itself; that the two fit is otherwise seen by the device alone, when the pipeline
//! is made. WebGPU wants every user-defined input of the fragment stage to be an output of the vertex stage, of the same
//! location, type and interpolation. What the vertex stage writes beside these is dropped.
//!
//! Each fragment stage of a module is compared with its vertex stage. Of several vertex stages the first by name is that of
//! the first fragment stage by name; which others go together is for passes to say. A module with one of the two stages
//! only has nothing to compare.
//!
//! Limits: an interpolation that is written out is not that of the default, though it may mean the same (`perspective`
//! against nothing): devices compare it as it is written. naga keeps no spans of arguments and members, so these are
//! looked up by name.

use std::ops::Range;

use naga::common::wgsl::TypeContext as _;
use naga::{EntryPoint, Handle, Interpolation, Module, Sampling, ShaderStage, Span, Type, TypeInner};

use super::wgsl_error::{Rejection, Stage};

/// A variable between stages.
struct Variable<'a> {
    name: &'a str,
    location: u32,
    ty: Handle<Type>,
    interpolation: Option<Interpolation>,
    sampling: Option<Sampling>,
    /// The structure that it is a member of.
    owner: Option<Handle<Type>>,
}

/// Every input of the fragment stage that the vertex stage does not write, or writes otherwise.
pub(super) fn mismatched(text: &str, module: &Module) -> Vec<Rejection> {
    let of = |stage: ShaderStage| {
        let mut those: Vec<_> = module.entry_points.iter().filter(|entry| entry.stage == stage).collect();
        those.sort_by_key(|entry| &entry.name);
        those
    };
    let (vertices, fragments) = (of(ShaderStage::Vertex), of(ShaderStage::Fragment));
    let Some(vertex) = vertices.first() else { return Vec::new() };
    let compared = if vertices.len() == 1 { fragments.len() } else { 1 };
    fragments
        .iter()
        .take(compared)
        .flat_map(|fragment| mismatched_pair(text, module, vertex, fragment))
        .collect()
}

fn mismatched_pair(
    text: &str,
    module: &Module,
    vertex: &EntryPoint,
    fragment: &EntryPoint,
) -> Vec<Rejection> {
    let mut written = Vec::new();
    if let Some(result) = &vertex.function.result {
        collect(module, result.ty, result.binding.as_ref(), "", None, &mut written);
    }
    let mut read = Vec::new();
    for argument in &fragment.function.arguments {
        let name = argument.name.as_deref().unwrap_or_default();
        collect(module, argument.ty, argument.binding.as_ref(), name, None, &mut read);
    }
    read.sort_by_key(|input| input.location);
    let pair = Pair { text, module, vertex, fragment };
    read.iter().filter_map(|input| pair.rejection(input, &written)).collect()
}

fn collect<'a>(
    module: &'a Module,
    ty: Handle<Type>,
    binding: Option<&naga::Binding>,
    name: &'a str,
    owner: Option<Handle<Type>>,
    found: &mut Vec<Variable<'a>>,
) {
    match (binding, &module.types[ty].inner) {
        (Some(naga::Binding::Location { location, interpolation, sampling, .. }), _) => {
            let (location, interpolation, sampling) = (*location, *interpolation, *sampling);
            found.push(Variable { name, location, ty, interpolation, sampling, owner });
        }
        (None, TypeInner::Struct { members, .. }) => {
            for member in members.iter().filter(|member| member.binding.is_some()) {
                let name = member.name.as_deref().unwrap_or_default();
                collect(module, member.ty, member.binding.as_ref(), name, Some(ty), found);
            }
        }
        _ => {}
    }
}

struct Pair<'a> {
    text: &'a str,
    module: &'a Module,
    vertex: &'a EntryPoint,
    fragment: &'a EntryPoint,
}

impl Pair<'_> {
    fn rejection(&self, input: &Variable<'_>, written: &[Variable<'_>]) -> Option<Rejection> {
        let Variable { name, location, .. } = input;
        let (vertex, fragment) = (&self.vertex.name, &self.fragment.name);
        // Neither words nor places are worked out for what fits.
        let reads = || format!("\"{fragment}\" reads \"{name}\" at @location({location})");
        let type_of = |variable: &Variable<'_>| self.module.to_ctx().type_to_string(variable.ty);
        let Some(output) = written.iter().find(|output| output.location == *location) else {
            let elsewhere = written.iter().find(|output| output.name == *name);
            let label = match elsewhere {
                Some(output) => format!("\"{vertex}\" writes \"{name}\" at @location({})", output.location),
                None => format!("\"{vertex}\" is the vertex stage"),
            };
            let place =
                elsewhere.map_or_else(|| self.entry_point(vertex), |output| self.place(output, vertex));
            let help = match elsewhere {
                Some(_) => "give it one location in both stages",
                None => "write it in the vertex stage too, or do not read it",
            };
            return Some(self.reject(
                input,
                format!("{}, where \"{vertex}\" writes nothing", reads()),
                place,
                label,
                help,
            ));
        };
        let (message, help) = if self.module.types[input.ty].inner != self.module.types[output.ty].inner {
            let (read, written) = (type_of(input), type_of(output));
            (
                format!("{} as {read}, but \"{vertex}\" writes {written}", reads()),
                "use one type in both stages",
            )
        } else if (input.interpolation, input.sampling) != (output.interpolation, output.sampling) {
            let (read, written) = (interpolation(input), interpolation(output));
            let help = "use one interpolation in both stages, and write it alike";
            (format!("{} {read}, but \"{vertex}\" writes it {written}", reads()), help)
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
        let mut rejection = Rejection::new(Stage::Interface, message, at);
        rejection.labels.extend(place.map(|place| (place, label)));
        rejection.help = Some(help.to_owned());
        rejection
    }

    /// Where a variable is declared: as a member of its structure, or as an argument; else its entry point.
    fn place(&self, variable: &Variable<'_>, entry_point: &str) -> Option<Range<usize>> {
        let entry_point = self.entry_point(entry_point);
        let within = match variable.owner {
            Some(owner) => self.module.types.get_span(owner).to_range(),
            None => entry_point.as_ref().map(|name| {
                let rest = &self.text[name.end..];
                name.end..name.end + rest.find('{').unwrap_or(rest.len())
            }),
        };
        let declared = within.and_then(|within| {
            let text = self.text.get(within.clone())?;
            let found =
                words(text, variable.name).find(|range| text[range.end..].trim_start().starts_with(':'));
            found.map(|range| within.start + range.start..within.start + range.end)
        });
        declared.or(entry_point)
    }

    fn entry_point(&self, name: &str) -> Option<Range<usize>> {
        entry_point(self.text, name)
    }
}

fn interpolation(variable: &Variable<'_>) -> String {
    let kind = match variable.interpolation {
        None => return "without interpolation".to_owned(),
        Some(Interpolation::Perspective) => "perspective",
        Some(Interpolation::Linear) => "linear",
        Some(Interpolation::Flat) => "flat",
        Some(Interpolation::PerVertex) => "per_vertex",
    };
    let sampling = match variable.sampling {
        None => "",
        Some(Sampling::Center) => ", center",
        Some(Sampling::Centroid) => ", centroid",
        Some(Sampling::Sample) => ", sample",
        Some(Sampling::First) => ", first",
        Some(Sampling::Either) => ", either",
    };
    format!("with @interpolate({kind}{sampling})")
}

/// Where the name of an entry point stands: naga keeps no span of it.
pub(super) fn entry_point(text: &str, name: &str) -> Option<Range<usize>> {
    words(text, name).find(|range| {
        let before = text[..range.start].trim_end();
        before.ends_with("fn") && before.len() < range.start
    })
}

/// The attribute with which an entry point says how large its workgroups are.
pub(super) fn workgroup_size(text: &str, name: &str) -> Option<Range<usize>> {
    const ATTRIBUTE: &str = "@workgroup_size";
    let before = &text[..entry_point(text, name)?.start];
    let own = before.rfind(['}', ';']).map_or(0, |end| end + 1);
    let at = own + before[own..].rfind(ATTRIBUTE)?;
    Some(at..at + ATTRIBUTE.len())
}

/// The first variable between stages of an entry point that is one too many, or its last.
pub(super) fn variable_beyond(
    text: &str,
    module: &Module,
    stage: ShaderStage,
    name: &str,
    allowed: u64,
) -> Option<Range<usize>> {
    let entry = module.entry_points.iter().find(|entry| entry.stage == stage && entry.name == name)?;
    let mut variables = Vec::new();
    if stage == ShaderStage::Vertex {
        let result = entry.function.result.as_ref()?;
        collect(module, result.ty, result.binding.as_ref(), "", None, &mut variables);
    } else {
        for argument in &entry.function.arguments {
            let name = argument.name.as_deref().unwrap_or_default();
            collect(module, argument.ty, argument.binding.as_ref(), name, None, &mut variables);
        }
    }
    variables.sort_by_key(|variable| variable.location);
    let beyond = variables.iter().enumerate();
    let beyond = beyond.filter(|(at, each)| *at as u64 >= allowed || u64::from(each.location) >= allowed);
    let (_, variable) = { beyond }.next().or(variables.last().map(|last| (0, last)))?;
    Pair { text, module, vertex: entry, fragment: entry }.place(variable, name)
}

/// The places of a name as a whole word; none of nothing.
fn words<'t>(text: &'t str, name: &'t str) -> impl Iterator<Item = Range<usize>> + 't {
    let is_word = |byte: Option<&u8>| byte.is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
    let bytes = text.as_bytes();
    let found = text.match_indices(name).map(|(at, name)| at..at + name.len());
    found.filter(move |range| {
        let before = range.start.checked_sub(1).and_then(|at| bytes.get(at));
        !range.is_empty() && !is_word(before) && !is_word(bytes.get(range.end))
    })
}
