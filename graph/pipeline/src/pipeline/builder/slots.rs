//! The bindings of a program, matched by name with what a pass binds.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::access::{IndexRange, SubresourceRange, Usage};
use crate::draw::MATERIAL_GROUP;
use crate::pipeline::builder::PassBuilder;
use crate::pipeline::builder::binding::{Bind, BindObject, Contents};
use crate::pipeline::builder::host_contract;
use crate::pipeline::program::{Program, ProgramBinding};
use crate::pipeline::settings::evaluate::Evaluate;
use crate::work::{BoundSlot, BoundTexture, Filter, ProgramHandle, Sampler, SlotSource};
use umbragraph_shaders::{AxisValue, AxisValues, TypeLayout, describe};
use umbragraph_text::diagnostic::{Diagnostic, codes, list_of, suggested_name};
use umbragraph_text::document;
use umbragraph_text::language::{TextureShape, Word};

impl PassBuilder<'_> {
    /// Matches the bindings of a program by name with what a pass binds; returns `None` after a diagnostic. With
    /// `geometry`, groups 2 and 3 are the host's and are checked against that contract. A uniform block `view` is then
    /// the view being drawn.
    pub fn bind(
        &mut self,
        program: ProgramHandle,
        bind: &BTreeMap<String, Bind>,
        geometry: Option<&str>,
        pointer: &str,
    ) -> Option<Vec<BoundSlot>> {
        let at = format!("{pointer}/bind");
        let program: Arc<Program> = self.shared.programs.list[program.index()].clone();
        let mut fine = true;
        let mut unknown: Vec<&str> = Vec::new();
        let renamed = renamed(&program, bind, geometry.is_some());
        for name in bind.keys() {
            if program.binding(name).is_some() {
                continue;
            }
            let mut names: Vec<&str> = program.bindings.iter().map(|binding| binding.name.as_str()).collect();
            if let Some((_, unbound)) = renamed.filter(|(written, _)| *written == name) {
                names = vec![unbound];
            }
            let here = document::pointer_join(&at, name);
            if !self.is_of_another_variant(&program, (name, None), &here, &names) {
                unknown.push(name);
                fine = false;
            }
        }
        let mut slots = Vec::with_capacity(program.bindings.len());
        for binding in &program.bindings {
            if geometry.is_some() && binding.group >= MATERIAL_GROUP {
                continue;
            }
            let here = document::pointer_join(&at, &binding.name);
            let misspelt = || {
                unknown.iter().any(|name| {
                    renamed == Some((*name, binding.name.as_str()))
                        || suggested_name(name, [binding.name.as_str()]).is_some()
                })
            };
            let source = match bind.get(&binding.name) {
                Some(bind) => self.slot(&program, binding, bind, &here),
                None if misspelt() => None,
                None => self.default_slot(&program, binding, geometry, &here),
            };
            match source {
                Some(source) => slots.push(BoundSlot {
                    group: binding.group,
                    binding: binding.entry.binding,
                    name: binding.name.clone(),
                    source,
                    place: self.place(&here),
                    pointer: self.absolute(&here),
                }),
                None => fine = false,
            }
        }
        if let Some(geometry) = geometry {
            fine &= host_contract::check(self, geometry, &program, pointer);
        }
        fine.then_some(slots)
    }

    /// Returns `true` if another variant that this pipeline reaches declares the binding, or the member of its block.
    /// Otherwise reports an unknown binding or member. `names` lists the existing bindings or members, for the help
    /// text.
    pub(super) fn is_of_another_variant(
        &mut self,
        program: &Program,
        (binding, member): (&str, Option<&str>),
        here: &str,
        names: &[&str],
    ) -> bool {
        let template = &program.template;
        let mut own = self.fixed_axes(program);
        let shaders = self.shared.programs.shaders.clone();
        let declares = |fixed: &AxisValues| shaders.declares(template, fixed, binding, member);
        if declares(&own).is_some() {
            return true;
        }
        let (what, known) = match member {
            None => (format!("{template} has no binding \"{binding}\""), "bindings"),
            Some(member) => (format!("the block has no member \"{member}\""), "members"),
        };
        let otherwise = || match names {
            [] => format!("it has no {known}: remove this"),
            // The only one to which nothing is bound.
            [only] if member.is_none() && program.bindings.len() > 1 => format!("is \"{only}\" meant?"),
            names => format!("its {known} are {}", list_of(names)),
        };
        // Of the axes in which another variant differs, those that it takes; none where the search was cut short.
        let mut other = declares(&AxisValues::new()).unwrap_or_default();
        let is_other = |fixed: &AxisValues, axis: &String, value: &AxisValue| {
            fixed.get(axis).is_some_and(|fixed| fixed != value)
        };
        let mut free = own.clone();
        free.retain(|axis, value| !is_other(&other, axis, value));
        for (axis, value) in &own {
            let mut fewer = free.clone();
            fewer.insert(axis.clone(), value.clone());
            if let Some(found) = declares(&fewer).filter(|_| !other.is_empty()) {
                (free, other) = (fewer, found);
            }
        }
        other.retain(|axis, value| is_other(&own, axis, value));
        if other.is_empty() {
            let unknown = member.unwrap_or(binding);
            self.report_unknown(codes::UNKNOWN_BINDING, here, what, unknown, names, otherwise);
        } else {
            own.retain(|axis, _| other.contains_key(axis));
            let message = format!("{what} with {}, as this pass always has", describe(&own));
            let help = format!(
                "it has one with {}: set these axes in the pass, or remove the binding",
                describe(&other)
            );
            self.report(codes::UNKNOWN_BINDING, here, message, help);
        }
        false
    }

    pub(super) fn default_slot(
        &mut self,
        program: &Program,
        binding: &ProgramBinding,
        geometry: Option<&str>,
        here: &str,
    ) -> Option<SlotSource> {
        use wgpu_types::{BindingType, SamplerBindingType};
        let template = &program.template;
        match binding.entry.ty {
            BindingType::Buffer { .. } if geometry.is_some() && binding.name == "view" => {
                Some(SlotSource::View)
            }
            BindingType::Sampler(SamplerBindingType::Filtering) => {
                Some(SlotSource::Sampler(Sampler::default()))
            }
            BindingType::Sampler(SamplerBindingType::NonFiltering) => {
                Some(SlotSource::Sampler(Sampler { filter: Filter::Nearest, ..Sampler::default() }))
            }
            BindingType::Sampler(SamplerBindingType::Comparison) => {
                let message =
                    format!("the comparison sampler \"{}\" of {template} is not bound", binding.name);
                let help = "bind it: { \"sampler\": { \"compare\": \"less-equal\" } }";
                self.reject(codes::UNBOUND, here, message, help)
            }
            _ => {
                let name = &binding.name;
                let message = format!("\"{name}: {}\" of {template} is not bound", binding.type_name);
                let example = match (&binding.block, &binding.entry.ty) {
                    (Some(layout @ TypeLayout::Struct { members, .. }), BindingType::Buffer { ty, .. })
                        if *ty == wgpu_types::BufferBindingType::Uniform && members.len() <= MAX_EXAMPLE =>
                    {
                        format!("{{ \"values\": {} }}", example(layout))
                    }
                    (Some(_), _) => "\"&BUFFER\"".to_owned(),
                    (None, _) => "\"&TEXTURE\"".to_owned(),
                };
                let diagnostic = Diagnostic::error(codes::UNBOUND, self.place(here), message)
                    .pointer(self.absolute(here))
                    .labelled(program.plain().variable(name), "declared here")
                    .help(format!("add \"{name}\": {example} to \"bind\""));
                self.shared.diagnostics.push(diagnostic);
                None
            }
        }
    }

    pub(super) fn slot(
        &mut self,
        program: &Program,
        binding: &ProgramBinding,
        bind: &Bind,
        here: &str,
    ) -> Option<SlotSource> {
        use wgpu_types::{BindingType, StorageTextureAccess};
        let wanted = |what: &str| format!("\"{}\" of {} is {what}", binding.name, program.template);
        match binding.entry.ty {
            BindingType::Texture { view_dimension, .. } => {
                self.texture_slot(bind, Usage::Sampled, view_dimension, here, &|| wanted("a texture"))
            }
            BindingType::StorageTexture { access, view_dimension, .. } => {
                let usage = match access {
                    StorageTextureAccess::WriteOnly => Usage::StorageWrite,
                    StorageTextureAccess::ReadOnly => Usage::StorageRead,
                    _ => Usage::StorageReadWrite,
                };
                self.texture_slot(bind, usage, view_dimension, here, &|| wanted("a storage texture"))
            }
            BindingType::Sampler(kind) => {
                let Bind::Object(BindObject::Sampler(sampler)) = bind else {
                    let help = "bind { \"sampler\": { } } with its settings";
                    return self.reject(codes::WRONG_RESOURCE, here, wanted("a sampler"), help);
                };
                self.sampler(kind, sampler, &format!("{here}/sampler"), &wanted).map(SlotSource::Sampler)
            }
            BindingType::Buffer { ty, .. } => match bind {
                Bind::Object(BindObject::Values(values)) => {
                    let at = format!("{here}/values");
                    self.block_values(program, binding, values, &at, true).map(SlotSource::Values)
                }
                Bind::Object(BindObject::Block(block)) => {
                    let at = format!("{here}/block");
                    let placed =
                        self.block_offsets(program, binding, &block.offsets, &format!("{at}/offsets"));
                    let values =
                        self.block_values(program, binding, &block.values, &format!("{at}/values"), true)?;
                    placed.map(|()| SlotSource::Values(values))
                }
                Bind::Object(BindObject::Data(data)) => {
                    let at = format!("{here}/data");
                    let values =
                        self.block_values(program, binding, &data.values, &format!("{at}/values"), false);
                    let data = self.data(&data.name, &format!("{at}/name"))?;
                    Some(SlotSource::Data { data, values: Some(values?) })
                }
                Bind::Object(BindObject::Buffer(buffer)) => {
                    let at = format!("{here}/buffer");
                    let bytes = self.bytes(buffer.offset.as_ref(), buffer.size.as_ref(), &at)?;
                    let usage = self.written(buffer_usage(ty), buffer.contents.as_ref(), &at)?;
                    let buffer = self.buffer_range(&buffer.name, bytes, &format!("{at}/name"))?;
                    Some(SlotSource::Buffer { buffer, usage })
                }
                Bind::Name(name) => {
                    if self.is_buffer(name) {
                        let (buffer, usage) = (self.buffer(name, here)?, buffer_usage(ty));
                        return Some(SlotSource::Buffer { buffer, usage });
                    }
                    if self.is_texture(name) {
                        let help = "bind the name of a buffer or of blackboard data, or { \"values\": { } }";
                        let message = format!("{}, but \"{name}\" is a texture", wanted("a buffer"));
                        return self.reject(codes::WRONG_RESOURCE, here, message, help);
                    }
                    Some(SlotSource::Data { data: self.data(name, here)?, values: None })
                }
                Bind::Object(_) => {
                    let help = "bind the name of a buffer or of blackboard data, or { \"values\": { } }";
                    self.reject(codes::WRONG_RESOURCE, here, wanted("a buffer"), help)
                }
            },
            _ => {
                let message = wanted("of a type that passes cannot bind");
                self.reject(codes::WRONG_RESOURCE, here, message, "use a texture, a buffer or a sampler")
            }
        }
    }

    pub(super) fn texture_slot(
        &mut self,
        bind: &Bind,
        usage: Usage,
        dimension: wgpu_types::TextureViewDimension,
        here: &str,
        wanted: &dyn Fn() -> String,
    ) -> Option<SlotSource> {
        let declared = match dimension {
            wgpu_types::TextureViewDimension::D2 => TextureShape::D2,
            wgpu_types::TextureViewDimension::D2Array => TextureShape::D2Array,
            wgpu_types::TextureViewDimension::Cube => TextureShape::Cube,
            wgpu_types::TextureViewDimension::CubeArray => TextureShape::CubeArray,
            wgpu_types::TextureViewDimension::D3 => TextureShape::D3,
            wgpu_types::TextureViewDimension::D1 => {
                let message = "one-dimensional textures cannot be declared";
                let help = "use a two-dimensional one";
                return self.reject(codes::WRONG_RESOURCE, here, message, help);
            }
        };
        let (name, range, usage, shape, format, at) = match bind {
            Bind::Name(name) => (name, SubresourceRange::WHOLE, usage, None, None, here.to_owned()),
            Bind::Object(BindObject::Texture(texture)) => {
                let at = format!("{here}/texture");
                let range = self.subresource_range(&texture.range, &at)?;
                let format = match &texture.format {
                    Some(name) => Some(self.format(name, &format!("{at}/format"))?),
                    None => None,
                };
                let usage = self.written(usage, texture.contents.as_ref(), &at)?;
                (&texture.name, range, usage, texture.view_dimension, format, format!("{at}/name"))
            }
            Bind::Object(_) => {
                return self.reject(codes::WRONG_RESOURCE, here, wanted(), "bind the name of a texture");
            }
        };
        // Storage is one mip level.
        if let Some(IndexRange { count: count @ 2.., .. }) = range.mip.filter(|_| usage != Usage::Sampled) {
            let message = format!("storage is one mip level, these are {count}");
            return self.reject(codes::WRONG_RESOURCE, here, message, "bind one of them, with \"mip\"");
        }
        let mip = range.mip.or((usage != Usage::Sampled).then_some(IndexRange::one(0)));
        let texture = self.texture(name, SubresourceRange { mip, ..range }, &at)?;
        Some(SlotSource::Texture(BoundTexture { texture, usage, shape: shape.unwrap_or(declared), format }))
    }
}

impl PassBuilder<'_> {
    /// Returns the usage of a storage binding with its setting "contents", if that is present; `None` after a
    /// diagnostic.
    fn written(&mut self, usage: Usage, contents: Option<&Word<Contents>>, at: &str) -> Option<Usage> {
        let Some(word) = contents else { return Some(usage) };
        let at = format!("{at}/contents");
        let contents = self.word(word, &at)?;
        if !usage.writes() {
            let help = "remove \"contents\": it says whether what is written needs what was there";
            let message = "\"contents\" is set, but the shader only reads the resource";
            return self.reject(codes::WRONG_RESOURCE, &at, message, help);
        }
        Some(match contents {
            Contents::Load => Usage::StorageReadWrite,
            Contents::Discard => Usage::StorageReplace,
        })
    }
}

/// The only name of `bind` that the program does not have, and the only binding that nothing is bound to, if they can be
/// the same thing under two names.
fn renamed<'b>(
    program: &'b Program,
    bind: &'b BTreeMap<String, Bind>,
    host: bool,
) -> Option<(&'b str, &'b str)> {
    use wgpu_types::BindingType;
    let mut unknown = bind.iter().filter(|(name, _)| program.binding(name).is_none());
    let is_unbound = |binding: &&ProgramBinding| {
        let is_of_host = host && (binding.group >= MATERIAL_GROUP || binding.name == "view");
        !is_of_host
            && !bind.contains_key(&binding.name)
            && !matches!(binding.entry.ty, BindingType::Sampler(_))
    };
    let mut unbound = program.bindings.iter().filter(is_unbound);
    let ((name, bound), binding) = (unknown.next()?, unbound.next()?);
    if unknown.next().is_some() || unbound.next().is_some() {
        return None;
    }
    let is_buffer = matches!(binding.entry.ty, BindingType::Buffer { .. });
    let fits = match bound {
        Bind::Name(_) => true,
        Bind::Object(BindObject::Texture(_)) => !is_buffer,
        Bind::Object(BindObject::Sampler(_)) => false,
        Bind::Object(_) => is_buffer,
    };
    fits.then_some((name.as_str(), binding.name.as_str()))
}

/// The maximum number of members of a block for which a help text shows values.
const MAX_EXAMPLE: usize = 8;

/// Zeros for a type of a uniform block, as JSON writes them.
pub(super) fn example(layout: &TypeLayout) -> serde_json::Value {
    match layout {
        TypeLayout::Scalar { .. } => 0.into(),
        TypeLayout::Struct { members, .. } => {
            members.iter().map(|member| (member.name.clone(), example(&member.layout))).collect()
        }
        _ => vec![0; (layout.size() / 4).min(16) as usize].into(),
    }
}

fn buffer_usage(ty: wgpu_types::BufferBindingType) -> Usage {
    use wgpu_types::BufferBindingType;
    match ty {
        BufferBindingType::Uniform => Usage::Uniform,
        BufferBindingType::Storage { read_only: true } => Usage::StorageRead,
        BufferBindingType::Storage { read_only: false } => Usage::StorageReadWrite,
    }
}
