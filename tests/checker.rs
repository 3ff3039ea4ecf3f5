//! The checker of plans finds every violation that is planted in a right plan, and none where there is none.

use std::sync::Arc;

use umbragraph::compiler::{
    Assembly, CullReason, KeepReason, Objective, Physical, Plan, PlanOptions, PlannedCopy, PlannedPass,
    StoreOperation, TexelOrigin, TexelRows, Violation, ViolationKind, build, plan, verify,
};
use umbragraph::diagnostic::Diagnostics;
use umbragraph::language::{Expr, FormatCandidates, Lifetime, TextureDeclaration};
use umbragraph::pipeline::{Aspect, IndexRange, Pipeline, SubresourceRange, Usage, Version};
use umbragraph::wgpu_types::{TextureFormat, TextureUsages};
use umbragraph::work::{BufferRegion, LoadOperation, TextureRegion, TransferEnd, Work};

const CLEAR: LoadOperation<[f64; 4]> = LoadOperation::Clear([0.0; 4]);

/// A plan with one of everything: a merged pair of draws, a chain that aliases, an old version that is read, updates
/// ordered by `after`, a persistent state, a history of two frames that its writer reads back, buffers, a side effect that stays in its pass, and a dead pass.
fn right() -> Plan {
    let mut assembly = Assembly::new("everything");
    let [a, b, c, e, f, g, v, w, x] =
        ["a", "b", "c", "e", "f", "g", "v", "w", "x"].map(|name| assembly.texture(name));
    let depth = assembly
        .texture_with("depth", |texture| texture.format = FormatCandidates::One("depth32float".to_owned()));
    let state = assembly.texture_with("state", |texture| texture.lifetime = Lifetime::Persistent);
    let target = assembly.imported("target");
    let first = assembly.buffer("first", 64, Lifetime::Transient);
    let second = assembly.buffer("second", 64, Lifetime::Transient);
    let past = assembly.history("past", 2);
    let [past1, past2] = [1, 2].map(|back| assembly.earlier(past, back));
    let forgotten = assembly.history("forgotten", 1);
    let forgotten1 = assembly.earlier(forgotten, 1);
    let buffer = |usage| (SubresourceRange::WHOLE, usage, Version::Newest);
    let _ = assembly.pass("draw1").color(a, CLEAR).depth(depth, LoadOperation::Clear(1.0), true);
    let _ = assembly.pass("draw2").color(a, LoadOperation::Load).depth(depth, LoadOperation::Load, true);
    let _ = assembly.pass("blur1").reads(a).writes(b);
    let _ = assembly.pass("blur2").reads(b).writes(c);
    let _ = assembly.pass("blur3").reads(c).writes(e);
    let _ = assembly.pass("v1").writes(v);
    let _ = assembly.pass("keeper").reads_version(v, "v1").writes(w);
    let _ = assembly.pass("v2").updates(v);
    let _ = assembly.pass("x1").writes(x);
    let x2 = assembly.pass("x2").updates(x).handle();
    let x3 = assembly.pass("x3").updates(x).after(x2).handle();
    let _ = assembly.pass("remember").updates(state).after(x3);
    let (range, usage, version) = buffer(Usage::StorageReplace);
    let _ = assembly.pass("count").accesses(first, range, usage, version.clone()).accesses(
        second,
        range,
        usage,
        version.clone(),
    );
    let _ = assembly.pass("blend").reads(past2).color(past, CLEAR);
    let _ = assembly.pass("cycle").reads(forgotten1).color(forgotten, CLEAR);
    let _ = assembly.pass("probe").color(g, CLEAR).side_effect();
    let _ = assembly.pass("dead").reads(a).writes(f);
    let read = Usage::StorageRead;
    let out = assembly.pass("out").reads(e).reads(v).reads(w).reads(x).reads(past1);
    let out = out.accesses(first, range, read, version.clone());
    let _ = out.accesses(second, range, read, version).color(target, CLEAR);
    planned(assembly)
}

fn planned(assembly: Assembly) -> Plan {
    let (pipeline, sources) = assembly.finish();
    let mut diagnostics = Diagnostics::new();
    let graph = build(&pipeline, &mut diagnostics).expect("a graph");
    let plan = plan(&pipeline, &graph, &options(), &sources, &mut diagnostics);
    plan.unwrap_or_else(|| panic!("{diagnostics:#?}"))
}

fn options() -> PlanOptions {
    PlanOptions::new(64, 64)
}

fn kinds(violations: &[Violation]) -> Vec<ViolationKind> {
    violations.iter().map(|violation| violation.kind).collect()
}

/// Asserts that the checker finds a violation of this kind once it is planted.
#[track_caller]
fn caught(kind: ViolationKind, plant: impl FnOnce(&mut Plan)) {
    let mut plan = right();
    assert_eq!(verify(&plan, &options()), Vec::new(), "before anything is planted");
    plant(&mut plan);
    let violations = verify(&plan, &options());
    assert!(kinds(&violations).contains(&kind), "{violations:#?}");
}

fn at(plan: &Plan, name: &str) -> usize {
    plan.passes.iter().position(|pass| pass.name == name).unwrap_or_else(|| panic!("no {name}"))
}

fn pass<'a>(plan: &'a mut Plan, name: &str) -> &'a mut PlannedPass {
    let at = at(plan, name);
    &mut plan.passes[at]
}

/// Moves a pass to the place of another.
fn shift(plan: &mut Plan, name: &str, to: &str) {
    let to = at(plan, to);
    let from = at(plan, name);
    let moved = plan.passes.remove(from);
    plan.passes.insert(to, moved);
}

fn pipeline(plan: &mut Plan) -> &mut Pipeline {
    Arc::make_mut(&mut plan.pipeline)
}

fn texture_of(plan: &Plan, name: &str) -> usize {
    match plan.resources[name].physical {
        Physical::Texture(index) => index,
        other => panic!("{name} stands at {other:?}"),
    }
}

#[test]
fn the_plan_without_violations_aliases_and_merges() {
    let plan = right();
    assert_eq!(plan.resources["b"].physical, plan.resources["e"].physical);
    assert_eq!(plan.passes[at(&plan, "draw1")].group, plan.passes[at(&plan, "draw2")].group);
    assert!(plan.passes[at(&plan, "probe")].color[0].transient_attachment);
    assert_eq!(plan.culled.keys().collect::<Vec<_>>(), ["cycle", "dead"]);
    assert_eq!(plan.histories["past"].places.len(), 3);
    assert_eq!(plan.order.objective, Objective::Declaration);
}

#[test]
fn a_pass_planned_twice_is_caught() {
    caught(ViolationKind::PassTwice, |plan| plan.passes.push(plan.passes[0].clone()));
}

#[test]
fn a_pass_both_planned_and_culled_is_caught() {
    caught(ViolationKind::PassTwice, |plan| {
        plan.culled.insert("blur1".to_owned(), CullReason::WritesNothing);
    });
}

#[test]
fn a_forgotten_pass_is_caught() {
    caught(ViolationKind::PassMissing, |plan| {
        plan.culled.remove("dead");
    });
}

#[test]
fn an_invented_pass_is_caught() {
    caught(ViolationKind::PassUnknown, |plan| {
        plan.culled.insert("ghost".to_owned(), CullReason::WritesNothing);
    });
}

#[test]
fn culling_a_writer_whose_version_is_read_is_caught() {
    caught(ViolationKind::CulledButNeeded, |plan| {
        let at = at(plan, "x3");
        plan.passes.remove(at);
        plan.culled.insert("x3".to_owned(), CullReason::NothingReads(vec!["x".to_owned()]));
    });
}

#[test]
fn culling_the_writer_of_a_named_version_is_caught() {
    caught(ViolationKind::CulledButNeeded, |plan| {
        let at = at(plan, "v1");
        plan.passes.remove(at);
        plan.culled.insert("v1".to_owned(), CullReason::NothingReads(vec!["v".to_owned()]));
    });
}

#[test]
fn culling_a_side_effect_is_caught() {
    caught(ViolationKind::CulledButNeeded, |plan| {
        let at = at(plan, "probe");
        plan.passes.remove(at);
        plan.culled.insert("probe".to_owned(), CullReason::NothingReads(vec!["g".to_owned()]));
    });
}

#[test]
fn keeping_a_dead_pass_is_caught() {
    caught(ViolationKind::KeptWithoutReason, |plan| {
        let mut dead = plan.passes[at(plan, "blur1")].clone();
        dead.handle = plan.pipeline.find_pass("dead").expect("a pass");
        dead.name = "dead".to_owned();
        plan.culled.remove("dead");
        plan.passes.push(dead);
    });
}

#[test]
fn a_false_reason_for_keeping_is_caught() {
    caught(ViolationKind::WrongReason, |plan| pass(plan, "blur1").reason = KeepReason::SideEffect);
}

#[test]
fn a_reason_in_words_that_differs_from_the_reason_is_caught() {
    caught(ViolationKind::WrongReason, |plan| {
        pass(plan, "blur1").kept = umbragraph::compiler::Kept::SideEffect;
    });
}

#[test]
fn a_false_reason_for_culling_is_caught() {
    caught(ViolationKind::WrongCullReason, |plan| {
        plan.culled.insert("dead".to_owned(), CullReason::WritesNothing);
    });
}

#[test]
fn a_pass_before_the_one_it_has_to_follow_is_caught() {
    caught(ViolationKind::AfterViolated, |plan| shift(plan, "remember", "draw1"));
}

#[test]
fn a_reader_before_its_writer_is_caught() {
    caught(ViolationKind::UninitialisedRead, |plan| shift(plan, "blur1", "draw1"));
}

#[test]
fn a_reader_of_more_than_was_written_is_caught() {
    let narrow = |plan: &mut Plan, range: SubresourceRange| {
        let writer = pipeline(plan).find_pass("blur1").expect("blur1");
        pipeline(plan).passes[writer.index()].tamper().1.iter_mut().for_each(|one| {
            one.range = if one.usage.writes() { range } else { one.range };
        });
    };
    let mut plan = right();
    narrow(&mut plan, SubresourceRange::of(Some(0), Some(0)));
    assert_eq!(verify(&plan, &options()), Vec::new(), "the texture has nothing else");
    let mut assembly = Assembly::new("mips");
    let chain = assembly.texture_with("chain", |texture| texture.mips = Some(Expr::from(3.0)));
    for mip in 0..3 {
        let _ =
            assembly.pass(&format!("mip{mip}")).writes_range(chain, SubresourceRange::of(Some(mip), None));
    }
    let _ = assembly.pass("read").reads(chain).side_effect();
    let mut plan = planned(assembly);
    assert_eq!(verify(&plan, &options()), Vec::new(), "before anything is planted");
    let writer = pipeline(&mut plan).find_pass("mip1").expect("mip1");
    pipeline(&mut plan).passes[writer.index()].tamper().1[0].range = SubresourceRange::of(Some(2), None);
    let violations = verify(&plan, &options());
    assert!(kinds(&violations).contains(&ViolationKind::UninitialisedRead), "{violations:#?}");
}

#[test]
fn a_reader_between_two_writers_of_what_it_reads_the_newest_of_is_caught() {
    caught(ViolationKind::ReadTooEarly, |plan| shift(plan, "blur1", "draw2"));
}

#[test]
fn an_old_version_that_is_overwritten_before_it_is_read_is_caught() {
    caught(ViolationKind::WrongVersion, |plan| shift(plan, "v2", "keeper"));
}

#[test]
fn writers_that_nothing_orders_are_caught() {
    caught(ViolationKind::WritersUnordered, |plan| {
        let x3 = plan.pipeline.find_pass("x3").expect("a pass").index();
        pipeline(plan).passes[x3].after.clear();
    });
}

#[test]
fn a_store_that_a_later_load_needs_is_missed() {
    caught(ViolationKind::ContentsDropped, |plan| {
        pass(plan, "draw1").color[0].store = StoreOperation::Discard;
    });
}

#[test]
fn a_store_that_a_later_reader_needs_is_missed() {
    caught(ViolationKind::ContentsDropped, |plan| {
        pass(plan, "draw2").color[0].store = StoreOperation::Discard;
    });
}

#[test]
fn an_output_that_is_not_stored_is_caught() {
    caught(ViolationKind::OutputDropped, |plan| pass(plan, "out").color[0].store = StoreOperation::Discard);
}

#[test]
fn an_attachment_left_out_is_caught() {
    caught(ViolationKind::AttachmentsDiffer, |plan| pass(plan, "draw1").depth = None);
}

#[test]
fn an_attachment_at_another_mip_is_caught() {
    caught(ViolationKind::AttachmentsDiffer, |plan| pass(plan, "draw1").color[0].target.mip = 1);
}

#[test]
fn a_clear_where_a_load_is_declared_is_caught() {
    caught(ViolationKind::LoadDiffers, |plan| pass(plan, "draw2").color[0].load = LoadOperation::Clear(()));
}

#[test]
fn a_store_of_what_is_declared_to_be_discarded_is_caught() {
    caught(ViolationKind::StoreDiffers, |plan| {
        let draw2 = plan.pipeline.find_pass("draw2").expect("a pass").index();
        if let Work::Render(render) = pipeline(plan).passes[draw2].tamper().0 {
            render.color[0].discard = true;
        }
    });
}

#[test]
fn an_attachment_marked_as_staying_in_its_pass_that_is_read_later_is_caught() {
    caught(ViolationKind::TransientAttachmentLeaves, |plan| {
        pass(plan, "draw2").color[0].transient_attachment = true;
    });
}

#[test]
fn a_render_pass_of_draws_with_different_attachments_is_caught() {
    caught(ViolationKind::GroupBroken, |plan| {
        let before = at(plan, "probe") - 1;
        plan.passes[before + 1].group = plan.passes[before].group;
    });
}

#[test]
fn a_group_that_is_not_one_run_is_caught() {
    caught(ViolationKind::GroupBroken, |plan| pass(plan, "out").group = 0);
}

#[test]
fn a_resource_without_a_place_is_caught() {
    caught(ViolationKind::ResourceMissing, |plan| {
        plan.resources.remove("b");
    });
}

#[test]
fn a_resource_that_only_a_culled_pass_uses_is_caught() {
    caught(ViolationKind::ResourceUnused, |plan| {
        let mut unused = plan.resources["b"].clone();
        unused.handle = plan.pipeline.find_resource("f").expect("a resource");
        plan.resources.insert("f".to_owned(), unused);
    });
}

#[test]
fn a_lifetime_that_ends_too_early_is_caught() {
    caught(ViolationKind::SpanWrong, |plan| plan.resources.get_mut("b").expect("planned").last -= 1);
}

#[test]
fn a_texture_in_the_place_of_a_buffer_is_caught() {
    caught(ViolationKind::PlaceWrong, |plan| {
        plan.resources.get_mut("b").expect("planned").physical = Physical::Buffer(0);
    });
}

#[test]
fn an_import_that_the_plan_creates_is_caught() {
    caught(ViolationKind::PlaceWrong, |plan| {
        plan.resources.get_mut("target").expect("planned").physical = Physical::Texture(0);
    });
}

#[test]
fn a_place_that_does_not_exist_is_caught() {
    caught(ViolationKind::PlaceMissing, |plan| {
        plan.resources.get_mut("b").expect("planned").physical = Physical::Texture(99);
    });
}

#[test]
fn overlapping_lifetimes_on_one_texture_are_caught() {
    caught(ViolationKind::Overlap, |plan| {
        let place = plan.resources["b"].physical;
        plan.resources.get_mut("c").expect("planned").physical = place;
    });
}

#[test]
fn overlapping_lifetimes_on_one_buffer_are_caught() {
    caught(ViolationKind::Overlap, |plan| {
        let place = plan.resources["first"].physical;
        plan.resources.get_mut("second").expect("planned").physical = place;
    });
}

#[test]
fn a_persistent_resource_that_shares_is_caught() {
    caught(ViolationKind::SharedThoughLasting, |plan| {
        let place = plan.resources["state"].physical;
        plan.resources.get_mut("b").expect("planned").physical = place;
    });
}

#[test]
fn another_format_than_the_resource_has_is_caught() {
    caught(ViolationKind::CompatibilityMismatch, |plan| {
        let index = texture_of(plan, "b");
        plan.textures[index].format = TextureFormat::Rgba16Float;
    });
}

#[test]
fn another_layer_count_than_the_resource_has_is_caught() {
    caught(ViolationKind::CompatibilityMismatch, |plan| {
        let index = texture_of(plan, "b");
        plan.textures[index].size.layers = 4;
    });
}

#[test]
fn another_sample_count_than_the_resource_has_is_caught() {
    caught(ViolationKind::CompatibilityMismatch, |plan| {
        let index = texture_of(plan, "a");
        plan.textures[index].size.samples = 4;
    });
}

#[test]
fn a_buffer_that_is_too_small_is_caught() {
    caught(ViolationKind::CompatibilityMismatch, |plan| plan.buffers[0].bytes = 4);
}

#[test]
fn a_buffer_larger_than_the_largest_that_it_stands_for_is_caught() {
    caught(ViolationKind::CompatibilityMismatch, |plan| {
        plan.buffers[0].bytes += 4;
        plan.bytes += 4;
        plan.bytes_bound += 4;
    });
}

#[test]
fn a_resource_in_a_buffer_of_its_class_that_is_too_small_is_caught() {
    let mut assembly = Assembly::new("sizes");
    let mut previous = None;
    for (at, bytes) in [600, 1000, 700].into_iter().enumerate() {
        let buffer = assembly.buffer(&format!("b{at}"), bytes, Lifetime::Transient);
        let mut pass = assembly.pass(&format!("p{at}")).side_effect();
        if let Some(previous) = previous.replace(buffer) {
            pass = pass.accesses(previous, SubresourceRange::WHOLE, Usage::StorageRead, Version::Newest);
        }
        let _ = pass.accesses(buffer, SubresourceRange::WHOLE, Usage::StorageReplace, Version::Newest);
    }
    let mut plan = planned(assembly);
    assert_eq!(verify(&plan, &options()), Vec::new());
    assert_eq!(plan.resources["b0"].physical, plan.resources["b2"].physical);
    let Physical::Buffer(index) = plan.resources["b2"].physical else { panic!("no buffer") };
    plan.buffers[index].bytes = 600;
    plan.bytes -= 100;
    let violations = verify(&plan, &options());
    assert_eq!(kinds(&violations)[0], ViolationKind::CompatibilityMismatch);
    assert_eq!(violations[0].message, format!("\"b2\" is not of the class of buffer {index}, or larger"));
}

/// A plan that copies two mips of two layers, the stencil of a texture to rows of a buffer, and bytes.
fn copies() -> Plan {
    let mut assembly = Assembly::new("copies");
    let layered = |texture: &mut TextureDeclaration| {
        texture.size = Expr(serde_json::json!([64, 64]));
        texture.layers = Some(Expr::from(4.0));
        texture.mips = Some(Expr::from(3.0));
    };
    let [from, to] = ["from", "to"].map(|name| assembly.texture_with(name, layered));
    let mask = assembly.texture_with("mask", |texture| {
        texture.format = FormatCandidates::One("depth24plus-stencil8".to_owned());
        texture.size = Expr(serde_json::json!([64, 64]));
    });
    let [rows, bytes] =
        ["rows", "bytes"].map(|name| assembly.buffer(name, 64 * 256 + 512, Lifetime::Transient));
    let texture = |assembly: &Assembly, resource, range| {
        let texture = assembly.subresource(resource, range);
        TransferEnd::Texture(TextureRegion { texture, origin: None })
    };
    let texels = |assembly: &Assembly, resource, layer: u32| {
        let (mip, layer) =
            (Some(IndexRange { first: 1, count: 2 }), Some(IndexRange { first: layer, count: 2 }));
        texture(assembly, resource, SubresourceRange { mip, layer, ..SubresourceRange::WHOLE })
    };
    let buffer = |assembly: &Assembly, resource, first: u64, count: u64| {
        let buffer = assembly.subresource(resource, SubresourceRange::bytes(first, count));
        TransferEnd::Buffer(BufferRegion { buffer, bytes_per_row: None, rows_per_image: None })
    };
    let whole = SubresourceRange { mip: Some(IndexRange::one(0)), ..SubresourceRange::WHOLE };
    let _ = assembly.pass("fill").writes(from);
    let _ = assembly
        .pass("mark")
        .accesses(mask, whole.aspect(Aspect::DepthOnly), Usage::DepthAttachment, Version::Newest)
        .accesses(mask, whole.aspect(Aspect::StencilOnly), Usage::StencilAttachment, Version::Newest);
    let (source, destination) = (texels(&assembly, from, 0), texels(&assembly, to, 2));
    let _ = assembly.pass("move").copies(Some(source), destination, Usage::CopyDestination);
    let stencil = texture(&assembly, mask, whole.aspect(Aspect::StencilOnly));
    let destination = buffer(&assembly, rows, 512, 64 * 256);
    let blank = buffer(&assembly, rows, 512, 64 * 256);
    let _ = assembly.pass("blank").copies(None, blank, Usage::CopyDestination);
    let _ = assembly.pass("rows").copies(Some(stencil), destination, Usage::CopyDestinationRows);
    let destination = buffer(&assembly, bytes, 0, 256);
    let _ = assembly.pass("zero").copies(None, destination, Usage::CopyDestination);
    let (moved, destination) = (buffer(&assembly, rows, 512, 256), buffer(&assembly, bytes, 256, 256));
    let _ = assembly.pass("bytes").copies(Some(moved), destination, Usage::CopyDestination);
    let range = |first| SubresourceRange {
        mip: Some(IndexRange { first: 1, count: 2 }),
        ..SubresourceRange::of(None, Some(first))
    };
    let end = assembly.pass("end").side_effect().reads_range(to, range(3));
    let _ = end.accesses(bytes, SubresourceRange::bytes(0, 512), Usage::StorageRead, Version::Newest);
    planned(assembly)
}

#[track_caller]
fn caught_in_a_copy(plant: impl FnOnce(&mut Plan)) {
    let mut plan = copies();
    assert_eq!(verify(&plan, &options()), Vec::new(), "before anything is planted");
    plant(&mut plan);
    let violations = verify(&plan, &options());
    assert!(kinds(&violations).contains(&ViolationKind::CopyWrong), "{violations:#?}");
}

/// The subresource range that a transfer says that it reads, or writes.
fn range_of<'a>(plan: &'a mut Plan, name: &str, written: bool) -> &'a mut SubresourceRange {
    let handle = plan.pipeline.find_pass(name).expect("a pass").index();
    let accesses = pipeline(plan).passes[handle].tamper().1;
    &mut accesses.iter_mut().find(|one| one.usage.writes() == written).expect("an access").range
}

#[test]
fn a_copy_of_other_mips_than_its_access_is_caught() {
    caught_in_a_copy(|plan| range_of(plan, "move", false).mip = Some(IndexRange { first: 0, count: 3 }));
}

#[test]
fn a_copy_to_other_layers_than_its_access_is_caught() {
    caught_in_a_copy(|plan| range_of(plan, "move", true).layer = Some(IndexRange { first: 0, count: 4 }));
}

#[test]
fn a_copy_of_another_aspect_than_its_access_is_caught() {
    caught_in_a_copy(|plan| range_of(plan, "rows", false).aspect = Aspect::All);
}

#[test]
fn a_copy_to_more_bytes_than_its_access_is_caught() {
    caught_in_a_copy(|plan| {
        range_of(plan, "bytes", true).bytes = Some(IndexRange { first: 384, count: 128 });
    });
}

#[test]
fn a_copy_whose_access_is_forgotten_is_caught() {
    caught_in_a_copy(|plan| {
        let handle = plan.pipeline.find_pass("bytes").expect("a pass").index();
        pipeline(plan).passes[handle].tamper().1.remove(0);
    });
}

#[test]
fn a_planned_copy_of_another_mip_layer_or_box_is_caught() {
    let plants: [fn(&mut PlannedCopy); 4] = [
        |copy| edit(copy, |from, _| from.mip = 0),
        |copy| edit(copy, |from, _| from.at[2] = 1),
        |copy| edit(copy, |_, extent| extent[0] = 16),
        |copy| edit(copy, |_, extent| extent[2] = 1),
    ];
    for plant in plants {
        caught_in_a_copy(|plan| plant(&mut pass(plan, "move").copies[0]));
    }
}

fn edit(copy: &mut PlannedCopy, change: impl FnOnce(&mut TexelOrigin, &mut [u32; 3])) {
    match copy {
        PlannedCopy::Texels { from, extent, .. } | PlannedCopy::Download { from, extent, .. } => {
            change(from, extent);
        }
        _ => panic!("no texels"),
    }
}

#[test]
fn a_planned_copy_left_out_or_made_twice_is_caught() {
    caught_in_a_copy(|plan| {
        pass(plan, "move").copies.pop();
    });
    caught_in_a_copy(|plan| {
        let again = pass(plan, "zero").copies[0];
        pass(plan, "zero").copies.push(again);
    });
}

#[test]
fn planned_rows_of_texels_at_other_bytes_are_caught() {
    let plants: [fn(&mut TexelRows); 3] =
        [|rows| rows.offset = 0, |rows| rows.bytes_per_row = 512, |rows| rows.rows_per_image = 8];
    for plant in plants {
        caught_in_a_copy(|plan| match &mut pass(plan, "rows").copies[0] {
            PlannedCopy::Download { to, .. } => plant(to),
            _ => panic!("no rows"),
        });
    }
    caught_in_a_copy(|plan| {
        edit(&mut pass(plan, "rows").copies[0], |from, _| from.aspect = Aspect::DepthOnly);
    });
}

#[test]
fn a_planned_copy_of_other_bytes_is_caught() {
    caught_in_a_copy(|plan| {
        pass(plan, "bytes").copies[0] = PlannedCopy::Bytes { from: 0, to: 256, bytes: 256 };
    });
}

#[test]
fn a_missing_usage_is_caught() {
    caught(ViolationKind::UsageMissing, |plan| {
        let index = texture_of(plan, "a");
        plan.textures[index].usages = TextureUsages::TEXTURE_BINDING;
    });
}

#[test]
fn an_import_used_beyond_its_usage_is_caught() {
    let plan = right();
    let mut options = options();
    options.import_usages.insert("target".to_owned(), TextureUsages::TEXTURE_BINDING);
    assert_eq!(kinds(&verify(&plan, &options)), [ViolationKind::ImportMisused]);
}

#[test]
fn a_mip_that_the_texture_does_not_have_is_caught() {
    caught(ViolationKind::SubresourceMissing, |plan| {
        let blur = plan.pipeline.find_pass("blur1").expect("a pass").index();
        pipeline(plan).passes[blur].tamper().1[1].range = SubresourceRange::of(Some(3), None);
    });
}

#[test]
fn a_texture_too_many_is_caught() {
    caught(ViolationKind::NotMinimal, |plan| {
        let spare = plan.textures[texture_of(plan, "e")].clone();
        plan.textures.push(spare);
        plan.resources.get_mut("e").expect("planned").physical = Physical::Texture(plan.textures.len() - 1);
    });
}

#[test]
fn a_texture_that_stands_for_nothing_is_caught() {
    caught(ViolationKind::PhysicalUnused, |plan| plan.textures.push(plan.textures[0].clone()));
}

#[test]
fn wrong_sums_of_bytes_are_caught() {
    caught(ViolationKind::BytesWrong, |plan| plan.bytes += 1);
    caught(ViolationKind::BytesWrong, |plan| plan.bytes_without_aliasing -= 1);
    caught(ViolationKind::BytesWrong, |plan| plan.bytes_bound += 1);
    caught(ViolationKind::BytesWrong, |plan| plan.bytes_peak += 1);
}

#[test]
fn workgroups_of_a_pass_that_dispatches_nothing_are_caught() {
    caught(ViolationKind::WorkgroupsWrong, |plan| pass(plan, "blur1").workgroups = Some([1, 1, 1]));
}

#[test]
fn a_wrong_name_is_caught() {
    caught(ViolationKind::NameWrong, |plan| pass(plan, "blur1").name = "blur".to_owned());
}

#[test]
fn a_wrong_lifetime_is_caught() {
    caught(ViolationKind::NameWrong, |plan| {
        plan.resources.get_mut("b").expect("planned").lifetime = Lifetime::Persistent;
    });
}

#[test]
fn sizes_given_as_numbers_or_expressions_are_the_same_to_the_checker() {
    let mut assembly = Assembly::new("sizes");
    let a = assembly
        .texture_with("a", |texture| texture.size = Expr::from("[viewport.width / 2, viewport.height / 2]"));
    let _ = assembly.pass("make").writes(a).side_effect();
    let (pipeline, sources) = assembly.finish();
    let mut diagnostics = Diagnostics::new();
    let graph = build(&pipeline, &mut diagnostics).expect("a graph");
    let plan = plan(&pipeline, &graph, &options(), &sources, &mut diagnostics).expect("a plan");
    assert_eq!(plan.bytes, 32 * 32 * 4);
    assert_eq!(verify(&plan, &options()), Vec::new());
}

fn place(plan: &Plan, name: &str, back: usize) -> Physical {
    plan.histories[name].places[back]
}

fn places<'a>(plan: &'a mut Plan, name: &str) -> &'a mut Vec<Physical> {
    &mut plan.histories.get_mut(name).expect("planned").places
}

#[test]
fn a_history_that_is_forgotten_is_caught() {
    caught(ViolationKind::HistoryWrong, |plan| {
        plan.histories.remove("past");
    });
}

#[test]
fn a_history_with_too_few_copies_is_caught() {
    caught(ViolationKind::HistoryWrong, |plan| {
        places(plan, "past").pop();
    });
}

#[test]
fn two_frames_of_a_history_at_one_place_are_caught() {
    caught(ViolationKind::HistoryWrong, |plan| {
        let first = place(plan, "past", 0);
        places(plan, "past")[1] = first;
        plan.resources.get_mut("past@-1").expect("planned").physical = first;
    });
}

#[test]
fn a_frame_that_stands_elsewhere_than_its_turn_is_caught() {
    caught(ViolationKind::HistoryWrong, |plan| places(plan, "past").swap(0, 1));
}

#[test]
fn copies_that_cannot_be_cleared_are_caught() {
    caught(ViolationKind::HistoryWrong, |plan| {
        let at = texture_of(plan, "past@-2");
        plan.textures[at].usages -= TextureUsages::RENDER_ATTACHMENT;
    });
}

#[test]
fn copies_of_different_formats_are_caught() {
    caught(ViolationKind::HistoryWrong, |plan| {
        let at = texture_of(plan, "past@-2");
        plan.textures[at].format = TextureFormat::Rgba8Snorm;
    });
}

#[test]
fn an_initial_value_of_another_kind_is_caught() {
    caught(ViolationKind::HistoryWrong, |plan| {
        plan.histories.get_mut("past").expect("planned").initial =
            umbragraph::compiler::InitialValue::Depth(1.0);
    });
}

#[test]
fn a_transient_resource_where_a_history_takes_turns_is_caught() {
    caught(ViolationKind::SharedThoughLasting, |plan| {
        let past = place(plan, "past", 2);
        plan.resources.get_mut("w").expect("planned").physical = past;
    });
}

#[test]
fn a_culled_writer_of_a_history_that_is_read_back_is_caught() {
    caught(ViolationKind::CulledButNeeded, |plan| {
        let at = at(plan, "blend");
        plan.passes.remove(at);
        plan.culled.insert("blend".to_owned(), CullReason::NothingReads(vec!["past".to_owned()]));
    });
}

#[test]
fn a_history_that_nothing_live_reads_back_is_no_reason_to_keep_its_writer() {
    caught(ViolationKind::KeptWithoutReason, |plan| {
        // Without its reader the history leads nowhere any more.
        let past = plan.resources["past@-1"].handle;
        for pass in &mut pipeline(plan).passes {
            if pass.name == "out" {
                pass.tamper().1.retain(|one| one.resource != past);
            }
        }
    });
}

#[test]
fn a_reason_of_a_later_frame_that_does_not_hold_is_caught() {
    caught(ViolationKind::WrongReason, |plan| {
        let past = plan.resources["past@-1"].handle;
        let reader = plan.passes[at(plan, "probe")].handle;
        pass(plan, "blend").reason = KeepReason::ReadLater(reader, past);
    });
}

#[test]
fn a_history_that_is_not_stored_is_caught() {
    caught(ViolationKind::OutputDropped, |plan| {
        pass(plan, "blend").color[0].store = StoreOperation::Discard;
    });
}
