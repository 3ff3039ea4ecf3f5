//! The limits of a profile against what a module reflects.
//!
//! Validation knows no limits of devices. Everything that can be read off the reflected interface is compared here: bind
//! groups, bindings, what a stage uses of each kind, sizes of blocks, variables between stages, vertex attributes, colour
//! attachments, workgroups. The place of an excess is the declaration that goes beyond: the variable, the size of the
//! workgroup, or the entry point.

use naga::{BuiltIn, Handle, Module, Span, Type, TypeInner};
use wgpu_types::{BindGroupLayoutEntry, BindingType, BufferBindingType};

use super::profile::TargetProfile;
use super::reflection::{Binding, EntryPoint, Reflection, Stage as ShaderStage};
use super::stages;
use super::wgsl_error::{Excess, Rejection, Stage};

/// Every limit of the profile that the module exceeds.
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
        check.entry_point(entry_point);
    }
    check.found
}

/// A kind of binding of which a stage has a limited number.
struct Kind {
    what: &'static str,
    allowed: u32,
    is: fn(&BindingType) -> bool,
}

fn kinds(profile: &TargetProfile, stage: ShaderStage) -> [Kind; 5] {
    let limits = &profile.limits;
    let storage_buffers = match stage {
        ShaderStage::Vertex => profile.vertex_storage_buffers,
        ShaderStage::Fragment | ShaderStage::Compute => limits.max_storage_buffers_per_shader_stage,
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

/// What a layout has more of in one stage than the profile guarantees: a layout is the union over variants, each of
/// which may be within every limit.
pub fn exceeded_by_layout<'a>(
    entries: impl Iterator<Item = &'a BindGroupLayoutEntry> + Clone,
    profile: &TargetProfile,
) -> Vec<String> {
    let mut found = Vec::new();
    for stage in [ShaderStage::Vertex, ShaderStage::Fragment, ShaderStage::Compute] {
        for Kind { what, allowed, is } in kinds(profile, stage) {
            let of_kind =
                entries.clone().filter(|entry| entry.visibility.contains(stage.stages()) && is(&entry.ty));
            let count: u32 = of_kind.map(|entry| entry.count.map_or(1, std::num::NonZeroU32::get)).sum();
            if count > allowed {
                found.push(format!("{count} {what}, but only {allowed} are guaranteed"));
            }
        }
    }
    found
}

struct Check<'a> {
    text: &'a str,
    module: &'a Module,
    profile: &'a TargetProfile,
    found: Vec<Rejection>,
}

impl Check<'_> {
    /// Neither the place nor the words are worked out for what is within its limit.
    fn over(
        &mut self,
        span: &dyn Fn(&Self) -> Span,
        what: std::fmt::Arguments<'_>,
        found: u64,
        allowed: u64,
    ) {
        self.over_as(span, what, what, found, allowed);
    }

    /// The same for what has one cause with other excesses `of` one thing.
    fn over_as(
        &mut self,
        span: &dyn Fn(&Self) -> Span,
        of: std::fmt::Arguments<'_>,
        what: std::fmt::Arguments<'_>,
        found: u64,
        allowed: u64,
    ) {
        if found > allowed {
            let message = format!("{what} is {found}, but only {allowed} is guaranteed");
            let excess = Excess { of: of.to_string(), found };
            self.found.push(Rejection {
                excess: Some(excess),
                ..Rejection::new(Stage::Limit, message, span(self))
            });
        }
    }

    fn span_of_binding(&self, binding: &Binding) -> Span {
        let mut variables = self.module.global_variables.iter();
        variables
            .find(|(_, variable)| {
                variable
                    .binding
                    .is_some_and(|place| (place.group, place.binding) == (binding.group, binding.binding))
            })
            .map(|(handle, _)| self.module.global_variables.get_span(handle))
            .unwrap_or_default()
    }

    fn span_of_entry_point(&self, entry_point: &EntryPoint) -> Span {
        stages::entry_point(self.text, &entry_point.name).map_or(Span::UNDEFINED, Span::from)
    }

    /// The attribute that says how large a workgroup is.
    fn span_of_workgroup_size(&self, entry_point: &EntryPoint) -> Span {
        stages::workgroup_size(self.text, &entry_point.name)
            .map_or_else(|| self.span_of_entry_point(entry_point), Span::from)
    }

    /// The first variable between stages beyond those that are allowed, or the last of all.
    fn span_of_variable(&self, entry_point: &EntryPoint, allowed: u64) -> Span {
        let stage = entry_point.stage.to_naga();
        stages::variable_beyond(self.text, self.module, stage, &entry_point.name, allowed)
            .map_or_else(|| self.span_of_entry_point(entry_point), Span::from)
    }

    /// How many of the variables that may go between stages built-in ones take: one each for what a fragment stage is
    /// given beside its position, one for four distances that a vertex stage clips by.
    fn built_in_variables(&self, entry_point: &EntryPoint) -> u64 {
        let is_it = |entry: &&naga::EntryPoint| {
            (&entry.name, entry.stage) == (&entry_point.name, entry_point.stage.to_naga())
        };
        let Some(entry) = self.module.entry_points.iter().find(is_it) else { return 0 };
        let function = &entry.function;
        let taken = |ty: Handle<Type>, binding: Option<&naga::Binding>| -> u64 {
            let of = |ty: Handle<Type>, binding: &naga::Binding| match (binding, &self.module.types[ty].inner)
            {
                (naga::Binding::Location { .. } | naga::Binding::BuiltIn(BuiltIn::Position { .. }), _) => 0,
                (naga::Binding::BuiltIn(BuiltIn::Barycentric { .. }), _) => 3,
                (naga::Binding::BuiltIn(BuiltIn::ClipDistances), TypeInner::Array { size, .. }) => match size
                {
                    naga::ArraySize::Constant(size) => u64::from(size.get()).div_ceil(4),
                    _ => 0,
                },
                (naga::Binding::BuiltIn(_), _) => u64::from(entry_point.stage == ShaderStage::Fragment),
            };
            match (binding, &self.module.types[ty].inner) {
                (Some(binding), _) => of(ty, binding),
                (None, TypeInner::Struct { members, .. }) => {
                    members.iter().filter_map(|member| Some(of(member.ty, member.binding.as_ref()?))).sum()
                }
                (None, _) => 0,
            }
        };
        match entry_point.stage {
            ShaderStage::Vertex => {
                function.result.as_ref().map_or(0, |result| taken(result.ty, result.binding.as_ref()))
            }
            ShaderStage::Fragment => {
                let arguments = function.arguments.iter();
                arguments.map(|argument| taken(argument.ty, argument.binding.as_ref())).sum()
            }
            ShaderStage::Compute => 0,
        }
    }

    fn binding(&mut self, binding: &Binding) {
        let limits = &self.profile.limits;
        let (groups, bindings) = (limits.max_bind_groups, limits.max_bindings_per_bind_group);
        let (uniform, storage) =
            (limits.max_uniform_buffer_binding_size, limits.max_storage_buffer_binding_size);
        let span = &|check: &Self| check.span_of_binding(binding);
        let name = &binding.name;
        let count = u64::from(binding.group) + 1;
        self.over(span, format_args!("the number of bind groups with \"{name}\""), count, u64::from(groups));
        let count = u64::from(binding.binding) + 1;
        self.over(span, format_args!("the number of bindings with \"{name}\""), count, u64::from(bindings));
        if let BindingType::Buffer { ty, min_binding_size: Some(size), .. } = binding.entry.ty {
            match ty {
                BufferBindingType::Uniform => {
                    self.over(span, format_args!("the size of \"{name}\" in bytes"), size.get(), uniform);
                }
                BufferBindingType::Storage { .. } => {
                    self.over(span, format_args!("the size of \"{name}\" in bytes"), size.get(), storage);
                }
            }
        }
    }

    fn bindings_of_stage(&mut self, reflection: &Reflection, entry_point: &EntryPoint) {
        for Kind { what, allowed, is } in kinds(self.profile, entry_point.stage) {
            let used = reflection
                .bindings
                .iter()
                .filter(|binding| is(&binding.entry.ty))
                .filter(|binding| entry_point.bindings.contains(&(binding.group, binding.binding)));
            let count: u64 = used
                .clone()
                .map(|binding| binding.entry.count.map_or(1, |count| u64::from(count.get())))
                .sum();
            let Some(beyond) = used.clone().nth(allowed as usize).or(used.clone().next_back()) else {
                continue;
            };
            let span = &|check: &Self| check.span_of_binding(beyond);
            let names: Vec<&str> = used.map(|binding| binding.name.as_str()).collect();
            let before = self.found.len();
            self.over(
                span,
                format_args!("the number of {what} in \"{}\"", entry_point.name),
                count,
                u64::from(allowed),
            );
            for rejection in &mut self.found[before..] {
                rejection.help = Some(format!("they are {}", names.join(", ")));
            }
        }
    }

    fn entry_point(&mut self, entry_point: &EntryPoint) {
        let limits = &self.profile.limits;
        let span = &|check: &Self| check.span_of_entry_point(entry_point);
        let name = &entry_point.name;
        let count = |length: usize| length as u64;
        let highest =
            |locations: &mut dyn Iterator<Item = u32>| locations.max().map_or(0, |at| u64::from(at) + 1);
        match entry_point.stage {
            ShaderStage::Vertex | ShaderStage::Fragment => {
                let allowed = u64::from(limits.max_inter_stage_shader_variables);
                let between = &|check: &Self| check.span_of_variable(entry_point, allowed);
                let built_in = self.built_in_variables(entry_point);
                let among =
                    if built_in > 0 { format!(", {built_in} of them built in,") } else { String::new() };
                self.over_as(
                    between,
                    format_args!("variables between stages"),
                    format_args!("the number of variables between stages in \"{name}\"{among}"),
                    count(entry_point.varyings.len()) + built_in,
                    allowed,
                );
                // Distances to clip planes take locations, which what a fragment stage is given does not.
                let taken = if entry_point.stage == ShaderStage::Vertex { built_in } else { 0 };
                self.over_as(
                    between,
                    format_args!("variables between stages"),
                    format_args!("the number of locations between stages in \"{name}\""),
                    highest(&mut entry_point.varyings.iter().copied()) + taken,
                    allowed,
                );
                let locations = &mut entry_point.inputs.iter().map(|input| input.location);
                self.over(
                    span,
                    format_args!("the number of vertex attributes in \"{name}\""),
                    highest(locations),
                    u64::from(limits.max_vertex_attributes),
                );
                let locations = &mut entry_point.outputs.iter().map(|output| output.location);
                self.over(
                    span,
                    format_args!("the number of colour attachments in \"{name}\""),
                    highest(locations),
                    u64::from(limits.max_color_attachments),
                );
            }
            ShaderStage::Compute => {
                let [x, y, z] = entry_point.workgroup_size;
                let sides = [
                    ("width", x, limits.max_compute_workgroup_size_x),
                    ("height", y, limits.max_compute_workgroup_size_y),
                    ("depth", z, limits.max_compute_workgroup_size_z),
                ];
                let size_span = &|check: &Self| check.span_of_workgroup_size(entry_point);
                for (side, size, allowed) in sides {
                    self.over_as(
                        size_span,
                        format_args!("the workgroup of \"{name}\""),
                        format_args!("the {side} of the workgroup of \"{name}\""),
                        u64::from(size),
                        u64::from(allowed),
                    );
                }
                let invocations = u64::from(x).saturating_mul(u64::from(y)).saturating_mul(u64::from(z));
                self.over_as(
                    size_span,
                    format_args!("the workgroup of \"{name}\""),
                    format_args!("the number of invocations in the workgroup of \"{name}\""),
                    invocations,
                    u64::from(limits.max_compute_invocations_per_workgroup),
                );
                let allowed = u64::from(limits.max_compute_workgroup_storage_size);
                self.over(
                    span,
                    format_args!("the workgroup memory of \"{name}\" in bytes"),
                    u64::from(entry_point.workgroup_storage),
                    allowed,
                );
            }
        }
    }
}
