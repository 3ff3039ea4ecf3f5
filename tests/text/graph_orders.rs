//! Orders for an objective, aliasing of textures, subresources and imports, on graphs made in code.

use umbragraph::Plan;
use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::{
    Assembly, ImportDescriptor, Objective, OrderMethod, PlanOptions, StoreOperation, TextureSize, build, plan,
};
use umbragraph::low_level::language::{Expr, FormatCandidates, Lifetime};
use umbragraph::low_level::pipeline::{SubresourceRange, Usage, Version};
use umbragraph::low_level::why::why_apart;
use umbragraph::wgpu_types::{TextureFormat, TextureUsages};
use umbragraph::work::LoadOperation;
use umbragraph_verify::verify;

const CLEAR: LoadOperation<[f64; 4]> = LoadOperation::Clear([0.0; 4]);

pub(crate) fn compile(assembly: Assembly, options: &PlanOptions) -> (Option<Plan>, Diagnostics) {
    let (pipeline, sources) = assembly.finish();
    let mut diagnostics = Diagnostics::new();
    let plan = build(&pipeline, &mut diagnostics)
        .and_then(|graph| plan(&pipeline, &graph, options, &sources, &mut diagnostics));
    let plan = plan.filter(|_| !diagnostics.has_errors());
    if let Some(plan) = &plan {
        assert_eq!(verify(plan, options), Vec::new());
    }
    (plan, diagnostics)
}

#[track_caller]
pub(crate) fn planned(assembly: Assembly, objective: Objective) -> Plan {
    let options = PlanOptions::new(64, 64).objective(objective);
    let (plan, diagnostics) = compile(assembly, &options);
    plan.unwrap_or_else(|| panic!("{diagnostics:#?}"))
}

#[track_caller]
pub(crate) fn rejected(assembly: Assembly) -> Vec<&'static str> {
    let (plan, diagnostics) = compile(assembly, &PlanOptions::new(64, 64));
    assert!(plan.is_none());
    diagnostics.iter().map(|diagnostic| diagnostic.code.id).collect()
}

pub(crate) fn names(plan: &Plan) -> Vec<&str> {
    plan.passes.iter().map(|pass| pass.name.as_str()).collect()
}

/// `count` producers, each with a consumer that is declared after all producers.
fn fan(count: usize) -> Assembly {
    let mut assembly = Assembly::new("fan");
    let textures: Vec<_> = (0..count).map(|at| assembly.texture(&format!("t{at}"))).collect();
    for (at, texture) in textures.iter().enumerate() {
        let _ = assembly.pass(&format!("make{at}")).writes(*texture);
    }
    for (at, texture) in textures.iter().enumerate() {
        let _ = assembly.pass(&format!("use{at}")).reads(*texture).side_effect();
    }
    assembly
}

#[test]
fn the_memory_order_runs_consumers_early_and_is_exact() {
    let declared = planned(fan(6), Objective::Declaration);
    let chosen = planned(fan(6), Objective::Memory);
    assert_eq!((declared.textures.len(), chosen.textures.len()), (6, 1));
    assert_eq!(chosen.order.method, OrderMethod::Exact);
    assert_eq!(names(&chosen)[..4], ["make0", "use0", "make1", "use1"]);
    let memory = chosen.order.memory.expect("a report");
    assert_eq!(
        (memory.declaration, memory.chosen, memory.bound),
        (declared.bytes, chosen.bytes, chosen.bytes)
    );
}

#[test]
fn a_memory_order_of_many_passes_reports_its_gap() {
    let chosen = planned(fan(40), Objective::Memory);
    let memory = chosen.order.memory.expect("a report");
    let [texture] = &chosen.textures[..] else { panic!("{:?}", chosen.textures) };
    assert!(texture.label.starts_with("t0 / t1 / t2 / ") && texture.label.matches('…').count() == 1);
    assert_eq!(memory.chosen, memory.bound);
}

#[test]
fn without_a_higher_peak_passes_that_free_most_run_first() {
    let mut assembly = Assembly::new("peaks");
    let [x, y, buffers @ ..] = [("x", 1000), ("y", 600), ("b0", 1000), ("b1", 800), ("b2", 600)]
        .map(|(name, bytes)| assembly.buffer(name, bytes, Lifetime::Transient));
    let _ = assembly.pass("wide").writes(x).writes(y).side_effect();
    for (at, buffer) in buffers.iter().enumerate() {
        let _ = assembly.pass(&format!("make{at}")).writes(*buffer);
    }
    for (at, buffer) in buffers.iter().enumerate() {
        let pass = assembly.pass(&format!("use{at}")).side_effect();
        let _ = pass.accesses(*buffer, SubresourceRange::WHOLE, Usage::StorageRead, Version::Newest);
    }
    let chosen = planned(assembly, Objective::Memory);
    assert_eq!(names(&chosen), ["wide", "make2", "use2", "make1", "use1", "make0", "use0"]);
}

#[test]
fn the_order_search_beats_the_greedy_choice() {
    let mut assembly = Assembly::new("search");
    let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| assembly.sized_texture(name, 256, 256));
    let _ = assembly.pass("apart").writes(a);
    let _ = assembly.pass("first").writes(b);
    let _ = assembly.pass("second").reads(b).writes(c);
    let _ = assembly.pass("third").reads(c).writes(d);
    let _ = assembly.pass("end").reads(a).reads(d).side_effect();
    let chosen = planned(assembly, Objective::Memory);
    assert_eq!(names(&chosen), ["first", "second", "third", "apart", "end"]);
    assert_eq!((chosen.order.method, chosen.textures.len()), (OrderMethod::Exact, 2));
}

/// A pass small at the start whose big result waits, against one that is big at once: greedy choices are wrong.
fn trap() -> Assembly {
    let mut assembly = Assembly::new("trap");
    let big = assembly.sized_texture("big", 256, 256);
    let [a, b, c] = [1u32, 2, 3].map(|at| assembly.sized_texture(&format!("s{at}"), 64, 64 + at));
    let other = assembly.sized_texture("other", 256, 256);
    let _ = assembly.pass("p0").writes(a);
    let _ = assembly.pass("p1").reads(a).writes(big);
    let _ = assembly.pass("p2").reads(a).writes(b);
    let _ = assembly.pass("p3").reads(b).writes(other);
    let _ = assembly.pass("p4").reads(other).writes(c);
    let _ = assembly.pass("p5").reads(big).reads(c).side_effect();
    assembly
}

#[test]
fn the_exact_memory_order_beats_or_equals_any_other() {
    let declared = planned(trap(), Objective::Declaration);
    let chosen = planned(trap(), Objective::Memory);
    assert_eq!(chosen.order.method, OrderMethod::Exact);
    assert!(chosen.bytes < declared.bytes);
    // One of the two big textures at a time.
    assert_eq!(chosen.textures.iter().filter(|texture| texture.size.width == 256).count(), 1);
    assert_eq!(names(&chosen), ["p0", "p2", "p3", "p4", "p1", "p5"]);
}

#[test]
fn few_passes_gathers_draws_to_one_target_into_one_render_pass() {
    let assembly = || {
        let mut assembly = Assembly::new("gather");
        let [a, b] = ["a", "b"].map(|name| assembly.texture(name));
        let target = assembly.imported("target");
        let clear = assembly.pass("clear").color(target, CLEAR).handle();
        let _ = assembly.pass("make_a").writes(a);
        let first = assembly.pass("draw_a").reads(a).color(target, LoadOperation::Load).after(clear).handle();
        let _ = assembly.pass("make_b").writes(b);
        let _ = assembly.pass("draw_b").reads(b).color(target, LoadOperation::Load).after(first);
        assembly
    };
    let declared = planned(assembly(), Objective::Declaration);
    let chosen = planned(assembly(), Objective::FewPasses);
    let groups = |plan: &Plan| plan.passes.iter().map(|pass| pass.group).collect::<Vec<_>>();
    assert_eq!(groups(&declared), [0, 1, 2, 3, 4]);
    assert_eq!(names(&chosen), ["make_a", "make_b", "clear", "draw_a", "draw_b"]);
    assert_eq!(groups(&chosen), [0, 1, 2, 2, 2]);
    assert_eq!(chosen.order.render_passes, Some([3, 1]));
}

#[test]
fn draws_connected_by_storage_share_no_render_pass() {
    let mut assembly = Assembly::new("storage");
    let target = assembly.imported("target");
    let list = assembly.buffer("list", 64, Lifetime::Transient);
    let usage = |usage| (SubresourceRange::WHOLE, usage, Version::Newest);
    let (range, write, version) = usage(Usage::StorageReplace);
    let first = assembly.pass("write").color(target, CLEAR).accesses(list, range, write, version).handle();
    let between = assembly.pass("between").color(target, LoadOperation::Load).after(first).handle();
    let (range, read, version) = usage(Usage::StorageRead);
    let _ = assembly
        .pass("read")
        .color(target, LoadOperation::Load)
        .accesses(list, range, read, version)
        .after(between);
    let plan = planned(assembly, Objective::Declaration);
    // The first two fit; the third reads what the first writes.
    assert_eq!(plan.passes.iter().map(|pass| pass.group).collect::<Vec<_>>(), [0, 0, 1]);
}

#[test]
fn depth_not_read_later_is_discarded_and_transient() {
    let mut assembly = Assembly::new("depth");
    let target = assembly.imported("target");
    let depth = assembly
        .texture_with("depth", |texture| texture.format = FormatCandidates::One("depth32float".to_owned()));
    let _ = assembly.pass("draw").color(target, CLEAR).depth(depth, LoadOperation::Clear(1.0), true);
    let plan = planned(assembly, Objective::Declaration);
    let attachment = plan.passes[0].depth.as_ref().expect("depth");
    assert_eq!(attachment.store, StoreOperation::Discard);
    assert!(attachment.transient_attachment);
    assert!(!plan.passes[0].color[0].transient_attachment);
}

#[test]
fn depth_is_stored_until_its_last_test_and_discarded_there() {
    let mut assembly = Assembly::new("depth");
    let target = assembly.imported("target");
    let depth = assembly
        .texture_with("depth", |texture| texture.format = FormatCandidates::One("depth32float".to_owned()));
    let first =
        assembly.pass("first").color(target, CLEAR).depth(depth, LoadOperation::Clear(1.0), true).handle();
    let _ = assembly
        .pass("second")
        .color(target, LoadOperation::Load)
        .depth(depth, LoadOperation::Load, false)
        .after(first);
    let plan = planned(assembly, Objective::Declaration);
    let stores: Vec<_> = plan.passes.iter().map(|pass| pass.depth.as_ref().expect("depth").store).collect();
    assert_eq!(stores, [StoreOperation::Store, StoreOperation::Discard]);
}

#[test]
fn three_lifetimes_of_which_two_overlap_need_two_textures() {
    // A lives in 1–2, B in 4–5, C in 4–6.
    let mut assembly = Assembly::new("lifetimes");
    let [a, b, c] = ["a", "b", "c"].map(|name| assembly.texture(name));
    let p1 = assembly.pass("p1").writes(a).handle();
    let p2 = assembly.pass("p2").reads(a).side_effect().after(p1).handle();
    let p3 = assembly.pass("p3").side_effect().after(p2).handle();
    let p4 = assembly.pass("p4").writes(b).writes(c).after(p3).handle();
    let p5 = assembly.pass("p5").reads(b).side_effect().after(p4).handle();
    let _ = assembly.pass("p6").reads(c).side_effect().after(p5);
    let plan = planned(assembly, Objective::Declaration);
    assert_ne!(plan.resources["b"].physical, plan.resources["c"].physical);
    assert_eq!(plan.textures.len(), 2);
}

/// Two textures with disjoint lifetimes, the second described by the caller.
fn two(describe: impl FnOnce(&mut umbragraph::low_level::language::TextureDeclaration)) -> usize {
    let mut assembly = Assembly::new("two");
    let a = assembly.texture("a");
    let b = assembly.texture_with("b", describe);
    let first = assembly.pass("p1").color(a, CLEAR).side_effect().handle();
    let _ = assembly.pass("p2").color(b, CLEAR).side_effect().after(first);
    planned(assembly, Objective::Declaration).textures.len()
}

#[test]
fn only_textures_alike_in_everything_share_memory() {
    assert_eq!(two(|_| {}), 1);
    assert_eq!(two(|texture| texture.samples = Some(Expr::from(4.0))), 2, "samples");
    assert_eq!(two(|texture| texture.layers = Some(Expr::from(4.0))), 2, "layers");
    assert_eq!(two(|texture| texture.mips = Some(Expr::from(2.0))), 2, "mips");
    assert_eq!(two(|texture| texture.format = FormatCandidates::One("bgra8unorm".to_owned())), 2, "format");
    assert_eq!(two(|texture| texture.size = Expr(serde_json::json!([63, 64]))), 2, "size");
    assert_eq!(two(|texture| texture.lifetime = Lifetime::Persistent), 2, "lifetime");
}

#[test]
fn four_mips_and_a_chain_of_mips_have_an_order() {
    let mut assembly = Assembly::new("mips");
    let chain = assembly.texture_with("chain", |texture| texture.mips = Some(Expr::from(5.0)));
    let mip = |at: u32| SubresourceRange::of(Some(at), Some(0));
    for at in (1..5).rev() {
        let _ =
            assembly.pass(&format!("down{at}")).reads_range(chain, mip(at - 1)).writes_range(chain, mip(at));
    }
    let _ = assembly.pass("top").writes_range(chain, mip(0));
    let _ = assembly.pass("show").reads(chain).side_effect();
    assert_eq!(
        names(&planned(assembly, Objective::Declaration)),
        ["top", "down1", "down2", "down3", "down4", "show"]
    );
}

#[test]
fn a_read_and_a_write_of_different_layers_in_one_pass_are_legal() {
    let mut assembly = Assembly::new("layers");
    let array = assembly.texture_with("array", |texture| texture.layers = Some(Expr::from(2.0)));
    let layer = |at: u32| SubresourceRange::of(Some(0), Some(at));
    let _ = assembly.pass("first").writes_range(array, layer(0));
    let _ = assembly.pass("second").reads_range(array, layer(0)).writes_range(array, layer(1)).side_effect();
    assert_eq!(names(&planned(assembly, Objective::Declaration)), ["first", "second"]);
}

#[test]
fn a_mip_or_layer_that_is_not_there_is_rejected() {
    for range in [SubresourceRange::of(Some(1), None), SubresourceRange::of(None, Some(3))] {
        let mut assembly = Assembly::new("range");
        let texture = assembly.texture_with("a", |texture| texture.layers = Some(Expr::from(3.0)));
        let _ = assembly.pass("p").writes_range(texture, range).side_effect();
        assert_eq!(rejected(assembly), ["UG0405"]);
    }
}

#[test]
fn a_mip_that_is_not_there_is_rejected_in_a_culled_pass_too() {
    let mut assembly = Assembly::new("range");
    let (texture, target) = (assembly.texture("a"), assembly.imported("target"));
    let _ = assembly.pass("dead").writes_range(texture, SubresourceRange::of(Some(7), None));
    let _ = assembly.pass("live").writes(target);
    assert_eq!(rejected(assembly), ["UG0405"]);
}

#[test]
fn every_reason_of_sharing_memory_or_not_is_told() {
    let mut assembly = Assembly::new("sharing");
    let [a, b, c] = ["a", "b", "c"].map(|name| assembly.texture(name));
    let small = assembly.sized_texture("small", 32, 64);
    let target = assembly.imported("target");
    let _ = assembly.pass("p1").writes(a);
    let _ = assembly.pass("p2").reads(a).writes(b);
    let _ = assembly.pass("p3").reads(b).writes(c);
    let _ = assembly.pass("p4").reads(c).writes(small);
    let _ = assembly.pass("p5").reads(small).writes(target);
    let plan = planned(assembly, Objective::Declaration);
    assert_eq!(
        why_apart(&plan, "a", "c"),
        ["a and c share memory: they are of one class, and never alive together"]
    );
    assert_eq!(why_apart(&plan, "a", "b"), ["a and b are alive together, at p2 for one"]);
    assert_eq!(why_apart(&plan, "a", "small"), ["a has a width of 64, small 32"]);
    assert_eq!(why_apart(&plan, "c", "target")[0], "target is the host's own");
    let mut assembly = Assembly::new("usages");
    let [a, b] = ["a", "b"].map(|name| assembly.buffer(name, 64, Lifetime::Transient));
    let _ = assembly.pass("p1").writes(a);
    let _ =
        assembly.pass("p2").accesses(a, SubresourceRange::WHOLE, Usage::Vertex, Version::Newest).writes(b);
    let _ = assembly.pass("p3").updates(b).side_effect();
    let usages = planned(assembly, Objective::Declaration);
    let expected = "a and b are used in different ways, and a buffer is created for its usages";
    assert_eq!(why_apart(&usages, "a", "b"), [expected, "a and b are alive together, at p2 for one"]);
    assert_eq!(why_apart(&usages, "b", "b"), ["b and b are alive together, at p2 for one"]);
    assert_eq!(why_apart(&plan, "a", "ghost"), ["no pass that runs uses ghost, so it has no memory at all"]);
}

#[test]
fn an_import_used_beyond_its_usage_is_rejected_at_the_use() {
    let mut assembly = Assembly::new("import");
    let target = assembly.imported("target");
    let _ = assembly.pass("p").writes(target);
    let mut options = PlanOptions::new(64, 64);
    let import = ImportDescriptor::new(TextureFormat::Rgba8Unorm, TextureSize::new(64, 64));
    options.imports.insert("target".to_owned(), import.usages(TextureUsages::RENDER_ATTACHMENT));
    let (plan, diagnostics) = compile(assembly, &options);
    assert!(plan.is_none());
    let found: Vec<_> =
        diagnostics.iter().map(|diagnostic| (diagnostic.code.id, diagnostic.message.as_str())).collect();
    let message = "\"p\" uses the import \"target\" as storage that is replaced, which the host's texture does not allow";
    assert_eq!(found, [("UG0408", message)]);
}

#[test]
fn writing_then_reading_a_range_in_one_pass_is_rejected() {
    let mut assembly = Assembly::new("feedback");
    let texture = assembly.texture("a");
    let _ = assembly.pass("p").writes(texture).reads(texture).side_effect();
    assert!(rejected(assembly).contains(&"UG0404"));
}

#[test]
fn a_size_through_too_many_resources_is_rejected() {
    let mut assembly = Assembly::new("deep");
    for at in 0..2_000 {
        let size =
            if at == 1_999 { Expr::from("=viewport") } else { Expr::from(format!("=r{}", at + 1).as_str()) };
        let _ = assembly.texture_with(&format!("r{at}"), |texture| texture.size = size);
    }
    let target = assembly.imported("target");
    let _ = assembly.pass("p").writes(target);
    assert!(rejected(assembly).iter().all(|code| *code == "UG0320"));
}

#[test]
fn a_cycle_of_a_hundred_thousand_passes_is_a_diagnostic() {
    let mut assembly = Assembly::new("cycle");
    let count = 100_000;
    let textures: Vec<_> = (0..count).map(|at| assembly.texture(&format!("t{at}"))).collect();
    for at in 0..count {
        let _ =
            assembly.pass(&format!("p{at}")).reads(textures[(at + count - 1) % count]).writes(textures[at]);
    }
    assert_eq!(rejected(assembly), ["UG0403"]);
}

#[test]
fn without_aliasing_every_resource_has_memory_of_its_own() {
    let options = PlanOptions::new(64, 64).aliasing(false);
    let (plan, diagnostics) = compile(fan(3), &options);
    let plan = plan.unwrap_or_else(|| panic!("{diagnostics:#?}"));
    assert_eq!(plan.textures.len(), 3);
    assert_eq!(plan.bytes, plan.bytes_without_aliasing);
}
