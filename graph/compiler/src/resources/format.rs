//! Choosing formats: the first candidate that supports every use, and why the others do not.
//!
//! Textures that are copied or resolved to one another have one format, but for "-srgb" where they are copied. Of their
//! candidates the first of the first texture is taken to which all others have one alike; where there is none, each has
//! the first of its own, and the copy or the attachment its diagnostic.

use smallvec::SmallVec;
use wgpu_types::{BindingType, TextureFormat, TextureFormatFeatureFlags, TextureSampleType, TextureUsages};

use crate::request::texture_size::TextureSize;
use crate::resources::texture_rules;
use umbragraph_pipeline::diagnostic::{Diagnostic, codes, list_of};
use umbragraph_pipeline::language::{
    TextureDeclaration, TextureShape, format_name, parse_format, unknown_format,
};
use umbragraph_pipeline::pipeline::{Access, Aspect, Program, Resource, TypedPipeline, Usage};
use umbragraph_pipeline::work::{
    BoundSlot, ColorAttachment, PassHandle, ResourceHandle, SlotSource, TextureView, TransferEnd, Work,
};

/// The requirements that live passes put on the format of one texture.
#[derive(Default)]
pub(crate) struct FormatRequirements<'a> {
    /// The accesses of the texture, each with its pass.
    pub(crate) accesses: SmallVec<[(PassHandle, &'a Access); 4]>,
    /// The shader bindings of the texture: pass, binding type that the shader declares, and view.
    pub(crate) bindings: Vec<(PassHandle, BindingType, TextureView)>,
    /// The formats of texture views that name one, each with its pass.
    pub(crate) views: Vec<(PassHandle, TextureFormat)>,
    /// The textures that this texture is copied or resolved to or from. `true` marks a resolve, which needs exactly the
    /// same format.
    pub(crate) alike: Vec<(ResourceHandle, bool)>,
    /// Whether a pass blends into the texture as a color attachment.
    pub(crate) blends: bool,
    /// Whether the texture is a history, which is cleared to its initial value before passes use it.
    pub(crate) cleared: bool,
}

impl FormatRequirements<'_> {
    /// The usages that a texture must be created with.
    pub(crate) fn texture_usages(&self) -> TextureUsages {
        self.accesses.iter().fold(TextureUsages::empty(), |all, (_, one)| all | one.usage.texture_usages())
    }
}

/// Returns the shader program of a pass and the sources of its bindings; `None` if the pass has no program.
pub(crate) fn slots(pipeline: &TypedPipeline, pass: PassHandle) -> Option<(&Program, &[BoundSlot])> {
    let (program, slots) = pipeline.pass(pass).work().bound()?;
    Some((pipeline.program(program), slots))
}

/// Returns the requirements that live passes put on the format of each texture, by resource index. Each access and each
/// binding is visited once.
pub(crate) fn wants<'a>(pipeline: &'a TypedPipeline, passes: &[PassHandle]) -> Vec<FormatRequirements<'a>> {
    let mut wants: Vec<FormatRequirements<'a>> =
        pipeline.resources.iter().map(|_| FormatRequirements::default()).collect();
    for pass in passes {
        let declared = pipeline.pass(*pass);
        for one in declared.accesses() {
            wants[one.resource.index()].accesses.push((*pass, one));
        }
        if let Some((program, slots)) = slots(pipeline, *pass) {
            for slot in slots {
                if let SlotSource::Texture(bound) = &slot.source
                    && let Some(binding) = program.binding_at(slot.group, slot.binding)
                {
                    for resource in pipeline.fallbacks(bound.texture.resource) {
                        let wants = &mut wants[resource.index()];
                        wants.bindings.push((*pass, program.bound_type(binding, slots), bound.view()));
                        wants.views.extend(bound.format.map(|format| (*pass, format)));
                    }
                }
            }
        }
        let resolves = matches!(declared.work(), Work::Render(_));
        for (a, b) in copied(declared.work()) {
            for source in pipeline.fallbacks(a) {
                let [a, b] = [source, b].map(|one| pipeline.resource(one).history.map_or(one, |all| all.of));
                wants[a.index()].alike.push((b, resolves));
                wants[b.index()].alike.push((a, resolves));
            }
        }
        if let Work::Render(render) = declared.work() {
            for color in &render.color {
                let wants = &mut wants[color.to.resource.index()];
                wants.blends |= color.blend.is_some();
                wants.views.extend(color.format.map(|format| (*pass, format)));
            }
        }
    }
    // The frames of a history are of one format; what is wanted of any of them is wanted of all.
    for handle in pipeline.resource_handles() {
        let Some(history) = pipeline.resource(handle).history.filter(|history| history.back == 0) else {
            continue;
        };
        for member in history.members().skip(1) {
            let earlier = std::mem::take(&mut wants[member.index()]);
            let all = &mut wants[handle.index()];
            all.accesses.extend(earlier.accesses);
            all.bindings.extend(earlier.bindings);
        }
        wants[handle.index()].cleared = true;
    }
    wants
}

/// Returns the pairs of textures that a pass copies or resolves: source and destination.
fn copied(work: &Work) -> Vec<(ResourceHandle, ResourceHandle)> {
    match work {
        Work::Transfer(transfer) => match (&transfer.source, &transfer.destination) {
            (Some(TransferEnd::Texture(from)), TransferEnd::Texture(to)) => {
                vec![(from.texture.resource, to.texture.resource)]
            }
            _ => Vec::new(),
        },
        Work::Render(render) => {
            let resolved =
                |color: &ColorAttachment| Some((color.to.resource, color.resolve.as_ref()?.resource));
            render.color.iter().filter_map(resolved).collect()
        }
        Work::Nothing | Work::Cpu(_) | Work::Compute(_) => Vec::new(),
    }
}

/// Returns the first candidate format that meets the requirements and `goes_with_others`. If none does both, the first
/// that meets the requirements.
///
/// # Errors
/// One diagnostic that says of each candidate why not.
pub(crate) fn choose(
    pipeline: &TypedPipeline,
    resource: &Resource,
    texture: &TextureDeclaration,
    wants: &FormatRequirements<'_>,
    size: TextureSize,
    goes_with_others: &dyn Fn(TextureFormat) -> bool,
) -> Result<TextureFormat, Box<Diagnostic>> {
    let names = texture.format.names();
    let volume = texture.view_dimension == Some(TextureShape::D3);
    let mut first = None;
    let mut reasons = Vec::new();
    let mut unknown = None;
    for (at, name) in names.iter().enumerate() {
        let Some(format) = parse_format(name) else {
            unknown.get_or_insert((at, name));
            continue;
        };
        match rejection(pipeline, format, wants, size, volume) {
            None if unknown.is_none() && goes_with_others(format) => return Ok(format),
            None if unknown.is_none() => {
                first.get_or_insert(format);
            }
            None => {}
            Some(reason) => reasons.push(format!("{name} {reason}")),
        }
    }
    if let Some(format) = first.filter(|_| unknown.is_none()) {
        return Ok(format);
    }
    let list_at = |at: usize| {
        if names.len() == 1 { "/texture/format".to_owned() } else { format!("/texture/format/{at}") }
    };
    if let Some((at, name)) = unknown {
        let pointer = list_at(at);
        let place = resource.value.nearest(&pointer).span;
        return Err(Box::new(unknown_format(name, place, resource.pointer.clone() + &pointer)));
    }
    let message =
        format!("no format of \"{}\" supports all of its usages: {}", resource.name, reasons.join("; "));
    let would_do = could_be(pipeline, wants, size, volume);
    // Where no format does, it is a use that is wrong: what is attached is not read as the shader wants it.
    let sampled = wants.accesses.iter().rfind(|(_, one)| one.usage == Usage::Sampled);
    let (place, pointer) = match sampled.filter(|_| would_do.is_empty()) {
        Some((_, one)) => (one.place, one.pointer.clone()),
        None => {
            let pointer = format!("{}/texture/format", resource.pointer);
            (resource.value.nearest("/texture/format").span, pointer)
        }
    };
    let mut diagnostic = Diagnostic::error(codes::FORMAT_USAGE, place, message).pointer(pointer).help(
        match would_do.as_slice() {
            [] if reasons.iter().any(|reason| reason.contains("cannot be filtered")) => {
                "bind a nearest sampler beside it, under the sampler's name: { \"sampler\": { \"filter\": \"nearest\" } }, or \
                 declare texture_depth_2d in the shader"
                    .to_owned()
            }
            [] => "choose another format, or use it otherwise: no common format would do".to_owned(),
            formats => format!("choose another format, or add a candidate: {} would do", list_of(formats)),
        },
    );
    for (pass, one) in wants.accesses.iter().filter(|(_, one)| one.place != place).take(4) {
        diagnostic = diagnostic
            .related(one.place, format!("\"{}\" uses it as {}", pipeline.pass(*pass).name, one.usage.name()));
    }
    Err(Box::new(diagnostic))
}

/// Returns up to three common formats that meet the requirements, for a help text.
fn could_be(
    pipeline: &TypedPipeline,
    wants: &FormatRequirements<'_>,
    size: TextureSize,
    volume: bool,
) -> Vec<&'static str> {
    const COMMON: [&str; 12] = [
        "rgba8unorm",
        "rgba16float",
        "rgba32float",
        "r8unorm",
        "r16float",
        "r32float",
        "depth32float",
        "depth24plus",
        "depth24plus-stencil8",
        "r32uint",
        "rgba8uint",
        "r32sint",
    ];
    let does = |name: &&str| {
        parse_format(name).is_some_and(|format| rejection(pipeline, format, wants, size, volume).is_none())
    };
    COMMON.into_iter().filter(does).take(3).collect()
}

/// Returns `true` if some candidate format of a texture meets its requirements and satisfies `fits`.
pub(crate) fn could_be_like(
    pipeline: &TypedPipeline,
    texture: &TextureDeclaration,
    wants: &FormatRequirements<'_>,
    size: TextureSize,
    fits: &dyn Fn(TextureFormat) -> bool,
) -> bool {
    let volume = texture.view_dimension == Some(TextureShape::D3);
    let mut formats = texture.format.names().iter().filter_map(|name| parse_format(name));
    formats.any(|format| fits(format) && rejection(pipeline, format, wants, size, volume).is_none())
}

/// Returns `true` if WebGPU can copy texels between two formats: they are equal except for the suffix `-srgb`.
pub(crate) fn are_alike(a: TextureFormat, b: TextureFormat) -> bool {
    a.remove_srgb_suffix() == b.remove_srgb_suffix()
}

/// Returns the reason why a shader cannot sample type `have` as the type `want`, and a WGSL alternative. Both are parts
/// of a message.
fn misread(have: Option<TextureSampleType>, want: TextureSampleType) -> (&'static str, &'static str) {
    use TextureSampleType::{Depth, Float, Sint, Uint};
    match (have, want) {
        (Some(Uint), _) => ("holds unsigned integers, which is not how", "texture_2d<u32>"),
        (Some(Sint), _) => ("holds signed integers, which is not how", "texture_2d<i32>"),
        (Some(Depth), Float { .. }) => {
            ("is depth and cannot be filtered as", "texture_depth_2d, textureLoad or a nearest sampler")
        }
        (Some(Depth), _) => ("is depth, which is not how", "texture_depth_2d"),
        (Some(Float { filterable: false }), Float { .. }) => {
            ("cannot be filtered as", "textureLoad or a nearest sampler")
        }
        (Some(Float { .. }) | None, _) => ("holds numbers, which is not how", "texture_2d<f32>"),
    }
}

/// Returns the reason why a format does not meet the requirements; `None` if it does.
fn rejection(
    pipeline: &TypedPipeline,
    format: TextureFormat,
    wants: &FormatRequirements<'_>,
    size: TextureSize,
    volume: bool,
) -> Option<String> {
    let (profile, samples) = (&pipeline.profile, size.samples);
    let missing = format.required_features() - profile.features;
    if !missing.is_empty() {
        return Some(format!("needs a feature that the profile {} does not have", profile.name));
    }
    let guaranteed = format.guaranteed_format_features(profile.features);
    for (pass, one) in &wants.accesses {
        let name = &pipeline.pass(*pass).name;
        if one.usage.is_stencil() && !format.has_stencil_aspect() {
            return Some(format!("has no stencil (\"{name}\")"));
        }
        if one.usage.is_depth() && !format.has_depth_aspect() {
            return Some(format!("cannot be a depth attachment (\"{name}\")"));
        }
        let is_color = matches!(one.usage, Usage::ColorAttachment | Usage::ColorAttachmentLoad);
        if is_color && (format.has_depth_aspect() || format.has_stencil_aspect()) {
            return Some(format!("cannot be a color attachment (\"{name}\")"));
        }
        if !guaranteed.allowed_usages.contains(one.usage.texture_usages()) {
            return Some(format!("cannot be used as {} (\"{name}\")", one.usage.name()));
        }
        if one.usage == Usage::ResolveTarget
            && !guaranteed.flags.contains(TextureFormatFeatureFlags::MULTISAMPLE_RESOLVE)
        {
            return Some(format!("cannot be resolved to (\"{name}\")"));
        }
        if samples > 1 && !guaranteed.flags.sample_count_supported(samples) {
            return Some(format!("cannot have {samples} samples"));
        }
    }
    // Textures of several samples are attachments, used as such or not.
    if samples > 1 && !guaranteed.allowed_usages.contains(wgpu_types::TextureUsages::RENDER_ATTACHMENT) {
        return Some(format!("cannot have {samples} samples"));
    }
    if wants.cleared && !guaranteed.allowed_usages.contains(wgpu_types::TextureUsages::RENDER_ATTACHMENT) {
        return Some("cannot be cleared to the initial value of a history".to_owned());
    }
    if wants.blends && !guaranteed.flags.contains(TextureFormatFeatureFlags::BLENDABLE) {
        return Some("cannot be blended".to_owned());
    }
    for (pass, view) in &wants.views {
        if view.remove_srgb_suffix() != format.remove_srgb_suffix() {
            return Some(format!(
                "cannot be seen as {} (\"{}\")",
                format_name(*view),
                pipeline.pass(*pass).name
            ));
        }
    }
    for (pass, binding, view) in &wants.bindings {
        let name = &pipeline.pass(*pass).name;
        match binding {
            BindingType::Texture { sample_type, .. } => {
                let stencil = view.aspect == Aspect::StencilOnly;
                if stencil && !format.has_stencil_aspect() {
                    return Some(format!("has no stencil (\"{name}\")"));
                }
                let aspect = match (stencil, format.has_depth_aspect()) {
                    (true, _) => Some(wgpu_types::TextureAspect::StencilOnly),
                    (false, true) => Some(wgpu_types::TextureAspect::DepthOnly),
                    (false, false) => None,
                };
                let have = view.format.unwrap_or(format).sample_type(aspect, Some(profile.features));
                let fits = match (have, sample_type) {
                    (
                        Some(TextureSampleType::Float { filterable: true }),
                        TextureSampleType::Float { .. },
                    ) => true,
                    (
                        Some(TextureSampleType::Float { filterable: false }),
                        TextureSampleType::Float { filterable },
                    ) => !filterable,
                    (Some(TextureSampleType::Depth), TextureSampleType::Float { filterable }) => !filterable,
                    (Some(have), want) => have == *want,
                    (None, _) => false,
                };
                if !fits {
                    let (why, instead) = misread(have, *sample_type);
                    return Some(format!("{why} the shader of \"{name}\" reads it ({instead} would do)"));
                }
            }
            BindingType::StorageTexture { format: wanted, .. }
                if *wanted != view.format.unwrap_or(format) =>
            {
                return Some(format!(
                    "is not {}, which the shader of \"{name}\" declares",
                    format_name(*wanted)
                ));
            }
            _ => {}
        }
    }
    texture_rules::of_format(format, size, volume, wants.texture_usages())
}
