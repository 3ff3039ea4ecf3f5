//! Checks a module's interface against the limits of a profile.
//!
//! naga's validation does not know device limits. This check compares the reflected interface with them: bind groups,
//! bindings, resources of each kind per stage, block sizes, inter-stage variables, vertex attributes, color
//! attachments, workgroups. The place of an excess is the declaration that exceeds the limit: the variable, the
//! workgroup size, or the entry point.

use naga::{BuiltIn, Module, ShaderStage, Span, TypeInner};
use wgpu_types::{BindGroupLayoutEntry, BindingType, BufferBindingType};

use crate::codes;
use crate::reflection::{Binding, EntryPoint, Reflection, Stage};
use crate::targets::profile::{TargetLanguage, TargetProfile};
use crate::written::ir;
use crate::written::ir::Bound;
use crate::written::rejection::{Excess, Rejection, Scope};
use crate::written::stages;
use umbragraph_text::diagnostic::list_of;

/// Returns a rejection for each limit of the target profile that the module exceeds. `text` is the module's WGSL.
pub(crate) fn exceeded(
    text: &str,
    module: &Module,
    reflection: &Reflection,
    profile: &TargetProfile,
) -> Vec<Rejection> {
    let mut check = Check { text, module, profile, found: Vec::new() };
    for binding in &reflection.bindings {
        check.binding(binding);
    }
    for entry_point in &reflection.entry_points {
        check.bindings_of_stage(reflection, entry_point);
        let is_it = |entry: &&naga::EntryPoint| {
            (&entry.name, entry.stage) == (&entry_point.name, entry_point.stage.to_naga())
        };
        if let Some(entry) = module.entry_points.iter().find(is_it) {
            check.entry_point(entry_point, entry);
        }
    }
    check.found
}

/// A kind of binding with the allowed number per shader stage, such as samplers or storage buffers.
struct Kind {
    what: &'static str,
    allowed: u32,
    is: fn(&BindingType) -> bool,
}

fn kinds(profile: &TargetProfile, stage: Stage) -> [Kind; 5] {
    let limits = &profile.limits;
    let storage_buffers = match stage {
        Stage::Vertex => profile.vertex_storage_buffers,
        Stage::Fragment | Stage::Compute => limits.max_storage_buffers_per_shader_stage,
    };
    let kind = |what, allowed, is| Kind { what, allowed, is };
    [
        kind("sampled textures", limits.max_sampled_textures_per_shader_stage, |ty| {
            matches!(ty, BindingType::Texture { .. })
        }),
        kind("samplers", limits.max_samplers_per_shader_stage, |ty| matches!(ty, BindingType::Sampler(_))),
        kind("storage textures", limits.max_storage_textures_per_shader_stage, |ty| {
            matches!(ty, BindingType::StorageTexture { .. })
        }),
        kind("uniform buffers", limits.max_uniform_buffers_per_shader_stage, |ty| {
            matches!(ty, BindingType::Buffer { ty: BufferBindingType::Uniform, .. })
        }),
        kind("storage buffers", storage_buffers, |ty| {
            matches!(ty, BindingType::Buffer { ty: BufferBindingType::Storage { .. }, .. })
        }),
    ]
}

/// Counts bindings; each element of a binding array counts as one binding.
fn count<'a>(entries: impl Iterator<Item = &'a BindGroupLayoutEntry>) -> u64 {
    entries.map(|entry| entry.count.map_or(1, |count| u64::from(count.get()))).sum()
}

/// Returns messages for the limits per shader stage that the bind-group layouts of a shader exceed. If `entries` are
/// the union over several variants, they can exceed limits that each variant meets.
pub fn exceeded_by_layout<'a>(
    entries: impl Iterator<Item = &'a BindGroupLayoutEntry> + Clone,
    profile: &TargetProfile,
) -> Vec<String> {
    let mut found = Vec::new();
    for stage in [Stage::Vertex, Stage::Fragment, Stage::Compute] {
        for Kind { what, allowed, is } in kinds(profile, stage) {
            let of_kind =
                entries.clone().filter(|entry| entry.visibility.contains(stage.stages()) && is(&entry.ty));
            let count = count(of_kind);
            if count > u64::from(allowed) {
                found.push(format!("{count} {what}, but only {allowed} are guaranteed"));
            }
        }
    }
    found
}

/// Returns `true` if each entry point meets the profile's limits on bindings, and no two of its bindings share group
/// and index. For GLSL, each texture must also be sampled with only one sampler.
pub(crate) fn fits(reflection: &Reflection, profile: &TargetProfile) -> bool {
    reflection.entry_points.iter().all(|entry_point| {
        let is_used = |binding: &&Binding| entry_point.bindings.contains(&(binding.group, binding.binding));
        let used: Vec<&Binding> = reflection.bindings.iter().filter(is_used).collect();
        let is_within = |Kind { allowed, is, .. }: Kind| {
            let those = used.iter().filter(|binding| is(&binding.entry.ty));
            count(those.map(|binding| &binding.entry)) <= u64::from(allowed)
        };
        let is_alone = |pair: &[(u32, u32)]| pair[0] != pair[1];
        // The language has no sampler apart from its texture.
        let is_paired = !matches!(profile.language, TargetLanguage::Glsl | TargetLanguage::GlslWebgl2)
            || entry_point.sampling_pairs.windows(2).all(|pairs| pairs[0].0 != pairs[1].0);
        entry_point.bindings.windows(2).all(is_alone)
            && is_paired
            && kinds(profile, entry_point.stage).into_iter().all(is_within)
    })
}

struct Check<'a> {
    text: &'a str,
    module: &'a Module,
    profile: &'a TargetProfile,
    found: Vec<Rejection>,
}

impl Check<'_> {
    /// Adds a rejection if `found` exceeds `allowed`. `what` names the quantity in the message; excesses with the same
    /// `of` have one root cause. `span` is only called for a rejection.
    fn over(
        &mut self,
        span: &dyn Fn(&Self) -> Span,
        of: &str,
        what: &str,
        found: u64,
        allowed: impl Into<u64>,
    ) {
        let allowed = allowed.into();
        if found > allowed {
            let message = format!("{what} is {found}, but only {allowed} is guaranteed");
            let excess = Some(Excess { of: of.to_owned(), found });
            let rejection = Rejection::new(codes::LIMIT_EXCEEDED, message, span(self)).of(Scope::Interface);
            self.found.push(Rejection { excess, ..rejection });
        }
    }

    fn span_of_binding(&self, binding: &Binding) -> Span {
        let place = naga::ResourceBinding { group: binding.group, binding: binding.binding };
        let variables = &self.module.global_variables;
        let found = variables.iter().find(|(_, variable)| variable.binding == Some(place));
        found.map(|(handle, _)| variables.get_span(handle)).unwrap_or_default()
    }

    fn span_of_entry_point(&self, entry_point: &EntryPoint) -> Span {
        stages::entry_point(self.text, &entry_point.name).map_or(Span::UNDEFINED, Span::from)
    }

    /// The span of the `@workgroup_size` attribute, or else of the entry point.
    fn span_of_workgroup_size(&self, entry_point: &EntryPoint) -> Span {
        stages::workgroup_size(self.text, &entry_point.name)
            .map_or_else(|| self.span_of_entry_point(entry_point), Span::from)
    }

    /// The span of the first inter-stage variable whose number or location exceeds the limit, or else of the last one.
    /// Without inter-stage variables, the span of the entry point.
    fn span_of_variable(&self, entry_point: &EntryPoint, entry: &naga::EntryPoint, allowed: u64) -> Span {
        stages::variable_beyond(self.text, self.module, entry, allowed)
            .map_or_else(|| self.span_of_entry_point(entry_point), Span::from)
    }

    /// The number of inter-stage variables that built-in values take up. Of fragment inputs, barycentric coordinates
    /// take three, the position none, and any other one. Of vertex outputs, clip distances take one for every four.
    fn built_in_variables(&self, entry: &naga::EntryPoint) -> u64 {
        let is_fragment = entry.stage == ShaderStage::Fragment;
        let between = match is_fragment {
            true => ir::inputs(self.module, &entry.function),
            false => ir::outputs(self.module, &entry.function),
        };
        let taken = |variable: &Bound<'_>| match (variable.binding, &self.module.types[variable.ty].inner) {
            (naga::Binding::Location { .. } | naga::Binding::BuiltIn(BuiltIn::Position { .. }), _) => 0,
            (naga::Binding::BuiltIn(BuiltIn::Barycentric { .. }), _) => 3,
            (naga::Binding::BuiltIn(BuiltIn::ClipDistances), TypeInner::Array { size, .. }) => match size {
                naga::ArraySize::Constant(size) => u64::from(size.get()).div_ceil(4),
                _ => 0,
            },
            (naga::Binding::BuiltIn(_), _) => u64::from(is_fragment),
        };
        between.iter().map(taken).sum()
    }

    fn binding(&mut self, binding: &Binding) {
        let limits = &self.profile.limits;
        let span = &|check: &Self| check.span_of_binding(binding);
        let name = &binding.name;
        let what = format!("the number of bind groups with \"{name}\"");
        self.over(span, &what, &what, u64::from(binding.group) + 1, limits.max_bind_groups);
        let what = format!("the number of bindings with \"{name}\"");
        self.over(span, &what, &what, u64::from(binding.binding) + 1, limits.max_bindings_per_bind_group);
        if let BindingType::Buffer { ty, min_binding_size: Some(size), .. } = binding.entry.ty {
            let allowed = match ty {
                BufferBindingType::Uniform => limits.max_uniform_buffer_binding_size,
                BufferBindingType::Storage { .. } => limits.max_storage_buffer_binding_size,
            };
            let what = format!("the size of \"{name}\" in bytes");
            self.over(span, &what, &what, size.get(), allowed);
        }
    }

    fn bindings_of_stage(&mut self, reflection: &Reflection, entry_point: &EntryPoint) {
        for Kind { what, allowed, is } in kinds(self.profile, entry_point.stage) {
            let used = reflection
                .bindings
                .iter()
                .filter(|binding| is(&binding.entry.ty))
                .filter(|binding| entry_point.bindings.contains(&(binding.group, binding.binding)));
            let count = count(used.clone().map(|binding| &binding.entry));
            let Some(beyond) = used.clone().nth(allowed as usize).or(used.clone().next_back()) else {
                continue;
            };
            let span = &|check: &Self| check.span_of_binding(beyond);
            let names: Vec<&str> = used.map(|binding| binding.name.as_str()).collect();
            let before = self.found.len();
            let what = format!("the number of {what} in \"{}\"", entry_point.name);
            self.over(span, &what, &what, count, allowed);
            for rejection in &mut self.found[before..] {
                rejection.help = Some(format!("they are {}", list_of(&names)));
            }
        }
    }

    fn entry_point(&mut self, entry_point: &EntryPoint, entry: &naga::EntryPoint) {
        let limits = &self.profile.limits;
        let span = &|check: &Self| check.span_of_entry_point(entry_point);
        let name = &entry_point.name;
        let highest = |location: Option<u32>| location.map_or(0, |at| u64::from(at) + 1);
        match entry_point.stage {
            Stage::Vertex | Stage::Fragment => {
                let allowed = u64::from(limits.max_inter_stage_shader_variables);
                let between = &|check: &Self| check.span_of_variable(entry_point, entry, allowed);
                let built_in = self.built_in_variables(entry);
                let among =
                    if built_in > 0 { format!(", {built_in} of them built in,") } else { String::new() };
                let what = format!("the number of variables between stages in \"{name}\"{among}");
                let count = entry_point.varyings.len() as u64 + built_in;
                self.over(between, "variables between stages", &what, count, allowed);
                // Distances to clip planes take locations, which what a fragment stage is given does not.
                let taken = if entry_point.stage == Stage::Vertex { built_in } else { 0 };
                let what = format!("the number of locations between stages in \"{name}\"");
                let count = highest(entry_point.varyings.iter().copied().max()) + taken;
                self.over(between, "variables between stages", &what, count, allowed);
                let what = format!("the number of vertex attributes in \"{name}\"");
                let count = highest(entry_point.inputs.iter().map(|input| input.location).max());
                self.over(span, &what, &what, count, limits.max_vertex_attributes);
                let what = format!("the number of colour attachments in \"{name}\"");
                let count = highest(entry_point.outputs.iter().map(|output| output.location).max());
                self.over(span, &what, &what, count, limits.max_color_attachments);
            }
            Stage::Compute => {
                let [x, y, z] = entry_point.workgroup_size.map(u64::from);
                let size_span = &|check: &Self| check.span_of_workgroup_size(entry_point);
                let workgroup = format!("the workgroup of \"{name}\"");
                let before = self.found.len();
                for (side, size, allowed) in [
                    ("the width of", x, limits.max_compute_workgroup_size_x),
                    ("the height of", y, limits.max_compute_workgroup_size_y),
                    ("the depth of", z, limits.max_compute_workgroup_size_z),
                    (
                        "the number of invocations in",
                        x.saturating_mul(y).saturating_mul(z),
                        limits.max_compute_invocations_per_workgroup,
                    ),
                ] {
                    self.over(size_span, &workgroup, &format!("{side} {workgroup}"), size, allowed);
                }
                for rejection in &mut self.found[before..] {
                    rejection.help =
                        Some("@workgroup_size(16, 16) and (256) have 256 invocations".to_owned());
                }
                let before = self.found.len();
                let what = format!("the workgroup memory of \"{name}\" in bytes");
                let size = u64::from(entry_point.workgroup_storage);
                self.over(span, &what, &what, size, limits.max_compute_workgroup_storage_size);
                for rejection in &mut self.found[before..] {
                    let help = "make the arrays in var<workgroup> smaller: array<f32, 4096> has 16384 bytes";
                    rejection.help = Some(help.to_owned());
                }
            }
        }
    }
}
