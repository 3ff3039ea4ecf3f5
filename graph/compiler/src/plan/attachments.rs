//! Attachments: what each loads and stores, and whether they fit the shader. Whether their sizes fit one another, the
//! passes' sizes (`pass_sizes`) say.
//!
//! Load comes from the pass. Store is per access, unless the pass discards the attachment: an attachment is stored
//! if a later live pass reads a subresource range of it before another clears all of that subresource range, or if it
//! outlives the frame. Only storage that says so, and an attachment that clears or discards, of one fixed layer, count
//! as clearing: what draws a layer for each view may have fewer views than layers this frame. Nor does a pass count
//! that can be off in a frame in which the attachment is drawn.
//!
//! Cost: for each attachment the accesses of its resource up to the one that decides.

use wgpu_types::{BlendComponent, BlendState, Features};

use crate::plan::planned::{PlannedAttachment, PlannedPass, StoreOperation};
use crate::plan::planner::Planner;
use crate::resources::resolved::TextureProperties;
use crate::schedule::cull::single_layer;
use umbragraph_pipeline::diagnostic::{Diagnostic, codes, counted};
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::language::format_name;
use umbragraph_pipeline::pipeline::{Located as _, SubresourceRange, canonical};
use umbragraph_pipeline::shader::{ScalarKind, Stage};
use umbragraph_pipeline::work::{Attachment, LoadOperation, PassHandle, RenderWork};

impl Planner<'_> {
    /// Plans the load and store operations of an attachment of the pass at position `at` in execution order.
    pub(crate) fn attachment(&self, at: usize, attachment: Attachment<'_>) -> PlannedAttachment {
        let Attachment { to, usage, load, discard } = attachment;
        let (target, resource) = (to.target(), self.pipeline.resource(to.resource));
        let range = SubresourceRange::of(Some(target.mip), target.layer);
        let range = resource.texture().map_or(range, |texture| canonical(texture, range, usage));
        let users = &self.users[target.resource.index()];
        let transient = resource.lifetime() == Lifetime::Transient;
        let mut store = if transient { StoreOperation::Discard } else { StoreOperation::Store };
        let start = users.partition_point(|(position, _)| *position <= at);
        for (position, later) in users[start..].iter().filter(|(_, later)| later.range.overlaps(range)) {
            if later.usage.reads() {
                store = StoreOperation::Store;
                break;
            }
            let clears = later.usage.replaces_contents();
            let fixed = later.range.layer.is_some()
                || single_layer(self.pipeline, target.resource)
                || !later.usage.is_attachment();
            let when = self.conditions[*position];
            let follows = when.is_none() || when == self.conditions[at];
            if clears && fixed && follows && later.range.contains(range) {
                store = StoreOperation::Discard;
                break;
            }
        }
        if discard {
            store = StoreOperation::Discard;
        }
        let alone = users.first().is_some_and(|(first, _)| *first == at)
            && users.last().is_some_and(|(last, _)| *last == at)
            && users.iter().all(|(_, one)| one.usage.is_attachment());
        let transient_attachment =
            transient && alone && store == StoreOperation::Discard && load != LoadOperation::Load;
        PlannedAttachment { resource: resource.name.clone(), load, store, transient_attachment, target }
    }

    /// Returns an error if the outputs of the fragment shader do not match the attachments of the pass in location and
    /// type.
    pub(crate) fn check_outputs(
        &self,
        handle: PassHandle,
        planned: &PlannedPass,
        render: &RenderWork,
    ) -> Option<Diagnostic> {
        let program = self.pipeline.program(render.draw.bound().0);
        let mismatch = |error: &str| Some(self.output_mismatch(handle, &program.template, error));
        let by_alpha = |at: usize| render.color.get(at).is_some_and(|color| blends_by_alpha(color.blend));
        let needs_second = render.color.iter().any(|color| blends_two_sources(color.blend));
        if needs_second && !self.pipeline.profile.features.contains(Features::DUAL_SOURCE_BLENDING) {
            let pass = self.pipeline.pass(handle);
            let message = format!(
                "\"{}\" blends with a second source, for which the profile {} lacks \"dual-source-blending\"",
                pass.name, self.pipeline.profile.name
            );
            let help = "use a profile with the feature (webgpu+dual-source-blending), let a feature of the pipeline \
                        require it (\"required_features\"), or blend without \"src1\"";
            return Some(pass.error(codes::ATTACHMENTS, message).help(help));
        }
        if needs_second && planned.color.len() > 1 {
            let error = "is blended with a second source, for which a pass has one color attachment only";
            return mismatch(error);
        }
        for variant in &program.variants {
            let Some(fragment) = variant.entry_point(Stage::Fragment) else {
                if !planned.color.is_empty() {
                    return mismatch("has no fragment stage to write color attachments");
                }
                continue;
            };
            if needs_second && !fragment.has_second_source {
                let error = "writes no @location(0) @blend_src(1), with which the pass blends";
                return mismatch(error);
            }
            if fragment.writes_depth && planned.depth.is_none() {
                let error = "writes frag_depth, for which the pass has no depth attachment";
                return mismatch(error);
            }
            let place = |location: u32| variant.module.location(&fragment.name, location);
            for (location, attachment) in planned.color.iter().enumerate() {
                let Some(TextureProperties { format, .. }) =
                    self.resolved.texture(attachment.target.resource)
                else {
                    continue;
                };
                let wanted = match format.sample_type(None, None) {
                    Some(wgpu_types::TextureSampleType::Uint) => ScalarKind::Uint,
                    Some(wgpu_types::TextureSampleType::Sint) => ScalarKind::Sint,
                    _ => ScalarKind::Float,
                };
                let output = fragment.outputs.iter().find(|output| output.location as usize == location);
                let mut help = None;
                let error = match output {
                    None => {
                        format!("writes no @location({location}), which \"{}\" wants", attachment.resource)
                    }
                    Some(output) if output.kind != wanted => {
                        let ty = scalar_name(wanted);
                        let name = &attachment.resource;
                        help = Some(format!(
                            "let the shader return vec4<{ty}>, or give \"{name}\" a format of {}s",
                            scalar_name(output.kind)
                        ));
                        format!(
                            "writes {} to @location({location}), but \"{}\" is {}, which takes {}",
                            scalar_name(output.kind),
                            attachment.resource,
                            format_name(format),
                            scalar_name(wanted)
                        )
                    }
                    Some(output) if output.components < u32::from(format.components()) => {
                        let (own, wanted) = (output.components, format.components());
                        format!(
                            "writes {own} components to @location({location}), of {wanted} that \"{}\" has",
                            attachment.resource
                        )
                    }
                    Some(output) if output.components < 4 && by_alpha(location) => {
                        format!(
                            "writes {} components to @location({location}), without the alpha by which \"{}\" is blended",
                            output.components, attachment.resource
                        )
                    }
                    Some(_) => continue,
                };
                let found = output.and_then(|output| place(output.location));
                let diagnostic = mismatch(&error)?.labelled(found, "the output");
                return Some(match help {
                    Some(help) => diagnostic.help(help),
                    None => diagnostic,
                });
            }
            if let Some(output) =
                fragment.outputs.iter().find(|output| output.location as usize >= planned.color.len())
            {
                let error = format!(
                    "writes @location({}), for which the pass has no color attachment",
                    output.location
                );
                let count = planned.color.len();
                let help = format!(
                    "add {{ \"to\": … }} to \"color\", which has {}, or remove the output from the shader",
                    counted(count, "attachment")
                );
                let found = place(output.location);
                return mismatch(&error)
                    .map(|diagnostic| diagnostic.labelled(found, "the output").help(help));
            }
        }
        None
    }

    fn output_mismatch(&self, handle: PassHandle, template: &str, error: &str) -> Diagnostic {
        self.pipeline
            .pass(handle)
            .error(codes::ATTACHMENTS, format!("{template} {error}"))
            .help("the outputs of the fragment shader and the color attachments match one to one")
    }
}

/// The name of a scalar kind in WGSL.
fn scalar_name(kind: ScalarKind) -> &'static str {
    match kind {
        ScalarKind::Uint => "u32",
        ScalarKind::Sint => "i32",
        ScalarKind::Bool => "bool",
        _ => "f32",
    }
}

/// Returns `true` if blending multiplies a color by the alpha of a fragment shader output.
fn blends_by_alpha(blend: Option<BlendState>) -> bool {
    use wgpu_types::BlendFactor as Factor;
    blend.is_some_and(|BlendState { color, .. }| {
        [color.src_factor, color.dst_factor].iter().any(|factor| {
            matches!(
                factor,
                Factor::SrcAlpha
                    | Factor::OneMinusSrcAlpha
                    | Factor::SrcAlphaSaturated
                    | Factor::Src1Alpha
                    | Factor::OneMinusSrc1Alpha
            )
        })
    })
}

/// Returns `true` if blending reads the second source color of the fragment shader (dual-source blending).
fn blends_two_sources(blend: Option<BlendState>) -> bool {
    let second = |one: BlendComponent| {
        one.src_factor.ref_second_blend_source() || one.dst_factor.ref_second_blend_source()
    };
    blend.is_some_and(|blend| second(blend.color) || second(blend.alpha))
}
