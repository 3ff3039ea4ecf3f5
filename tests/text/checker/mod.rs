//! The checker of plans finds every violation that is planted in a right plan, and none where there is none.

mod copies;
mod histories;

use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::{
    Assembly, CullReason, ImportDescriptor, KeepReason, Objective, Physical, PlanOptions, PlannedPass,
    StoreOperation, build, plan,
};
use umbragraph::low_level::language::{Expr, FormatCandidates, Lifetime};
use umbragraph::low_level::pipeline::{SubresourceRange, TypedPipeline, Usage, Version};
use umbragraph::wgpu_types::{TextureFormat, TextureUsages};
use umbragraph::work::{LoadOperation, Work};
use umbragraph_verify::{Violation, ViolationKind, verify};

const CLEAR: LoadOperation<[f64; 4]> = LoadOperation::Clear([0.0; 4]);

/// A plan with one of everything: a merged pair of draws, a chain that aliases, an old version that is read, updates
/// ordered by `after`, a persistent state, a history of two frames that its writer reads back, buffers, a side effect
/// that stays in its pass, and a dead pass.
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

fn pipeline(plan: &mut Plan) -> &mut TypedPipeline {
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
        pass(plan, "blur1").kept = umbragraph::low_level::compiler::Kept::SideEffect;
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
fn a_newest_version_read_too_early_is_caught() {
    caught(ViolationKind::ReadTooEarly, |plan| shift(plan, "blur1", "draw2"));
}

#[test]
fn an_old_version_overwritten_before_its_read_is_caught() {
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
fn a_transient_attachment_that_is_read_later_is_caught() {
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
fn a_buffer_larger_than_its_largest_alias_is_caught() {
    caught(ViolationKind::CompatibilityMismatch, |plan| {
        plan.buffers[0].bytes += 4;
        plan.bytes += 4;
        plan.bytes_bound += 4;
    });
}

#[test]
fn a_resource_in_too_small_a_buffer_is_caught() {
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
    let target = &plan.resources["target"];
    let import = ImportDescriptor::new(target.format.expect("a texture"), target.size.expect("a texture"));
    options.imports.insert("target".to_owned(), import.usages(TextureUsages::TEXTURE_BINDING));
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
fn the_checker_treats_numbers_and_expressions_alike() {
    let mut assembly = Assembly::new("sizes");
    let a = assembly
        .texture_with("a", |texture| texture.size = Expr::from("=[viewport.width / 2, viewport.height / 2]"));
    let _ = assembly.pass("make").writes(a).side_effect();
    let (pipeline, sources) = assembly.finish();
    let mut diagnostics = Diagnostics::new();
    let graph = build(&pipeline, &mut diagnostics).expect("a graph");
    let plan = plan(&pipeline, &graph, &options(), &sources, &mut diagnostics).expect("a plan");
    assert_eq!(plan.bytes, 32 * 32 * 4);
    assert_eq!(verify(&plan, &options()), Vec::new());
}
