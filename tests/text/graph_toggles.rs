//! Effects of toggles on graphs and plans: lifetimes, stores, shared memory, and rejections.

use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostics, codes};
use umbragraph::low_level::compiler::{Assembly, KeepReason, PlanOptions, StoreOperation, build, plan};
use umbragraph::low_level::language::{Expr, Lifetime, TextureDeclaration};
use umbragraph::low_level::pipeline::{Condition, IndexRange, SubresourceRange, Usage, Version};
use umbragraph::work::{LoadOperation, ResourceHandle};
use umbragraph_verify::{ViolationKind, verify};

const CLEAR: LoadOperation<[f64; 4]> = LoadOperation::Clear([0.0; 4]);

fn planned(assembly: Assembly) -> Result<Plan, Diagnostics> {
    let (pipeline, sources) = assembly.finish();
    let mut diagnostics = Diagnostics::new();
    let options = PlanOptions::new(64, 64);
    let plan = build(&pipeline, &mut diagnostics)
        .and_then(|graph| plan(&pipeline, &graph, &options, &sources, &mut diagnostics));
    match plan {
        Some(plan) if !diagnostics.has_errors() => {
            assert_eq!(verify(&plan, &options), Vec::new());
            Ok(plan)
        }
        _ => Err(diagnostics),
    }
}

#[track_caller]
fn right(assembly: Assembly) -> Plan {
    planned(assembly).unwrap_or_else(|diagnostics| panic!("{diagnostics:#?}"))
}

#[track_caller]
fn rejected(assembly: Assembly) -> (&'static str, String) {
    let diagnostics = planned(assembly).expect_err("diagnostics");
    let diagnostic = diagnostics.iter().next().expect("a diagnostic");
    (diagnostic.code.id, diagnostic.message.clone())
}

fn names(plan: &Plan) -> Vec<&str> {
    plan.passes.iter().map(|pass| pass.name.as_str()).collect()
}

fn pass<'a>(plan: &'a Plan, name: &str) -> &'a umbragraph::low_level::compiler::PlannedPass {
    plan.passes.iter().find(|pass| pass.name == name).unwrap_or_else(|| panic!("no {name}"))
}

fn on(toggle: usize) -> Condition {
    Condition { toggle, on: true }
}

fn start() -> (Assembly, [ResourceHandle; 3], ResourceHandle) {
    let mut assembly = Assembly::new("toggles");
    let resources = ["a", "b", "c"].map(|name| assembly.texture(name));
    let target = assembly.imported("target");
    (assembly, resources, target)
}

#[test]
fn what_a_toggled_pass_draws_over_stays_alive_and_is_stored() {
    let (mut assembly, [a, ..], target) = start();
    let toggle = assembly.toggle("fog");
    let base = assembly.pass("base").color(a, CLEAR).handle();
    let _ = assembly.pass("fog").color(a, CLEAR).after(base).toggle(toggle, true);
    let _ = assembly.pass("show").reads(a).color(target, CLEAR);
    let plan = right(assembly);
    assert_eq!(names(&plan), ["base", "fog", "show"]);
    assert_eq!(pass(&plan, "base").color[0].store, StoreOperation::Store);
    assert!(matches!(pass(&plan, "base").reason, KeepReason::ReadBy(..)));
    assert_eq!(pass(&plan, "fog").toggle.as_deref(), Some("fog"));
}

#[test]
fn without_a_toggle_the_same_overwrite_culls_what_it_covers() {
    let (mut assembly, [a, ..], target) = start();
    let base = assembly.pass("base").color(a, CLEAR).handle();
    let _ = assembly.pass("fog").color(a, CLEAR).after(base);
    let _ = assembly.pass("show").reads(a).color(target, CLEAR);
    assert_eq!(names(&right(assembly)), ["fog", "show"]);
}

#[test]
fn a_toggled_clear_of_a_picture_keeps_what_is_below_it() {
    let (mut assembly, _, target) = start();
    let toggle = assembly.toggle("cover");
    let base = assembly.pass("base").color(target, CLEAR).handle();
    let _ = assembly.pass("cover").color(target, CLEAR).after(base).toggle(toggle, true);
    assert_eq!(names(&right(assembly)), ["base", "cover"]);
}

#[test]
fn what_opposite_toggles_cover_together_is_culled() {
    let (mut assembly, [a, ..], target) = start();
    let toggle = assembly.toggle("night");
    let below = assembly.pass("below").writes(a).handle();
    let day = assembly.pass("day").writes(a).toggle(toggle, false).after(below).handle();
    let night = assembly.pass("night").color(a, CLEAR).toggle(toggle, true).after(day).handle();
    let old = assembly.pass("old").color(target, CLEAR).handle();
    let stars = assembly.pass("stars").color(target, CLEAR).toggle(toggle, true).after(old).handle();
    let sun = assembly.pass("sun").color(target, CLEAR).toggle(toggle, false).after(stars).handle();
    assembly.pass("show").reads(a).after(night).after(sun).color(target, LoadOperation::Load);
    // The storage write of the day covers everything, the attachment of the night one subresource: of what is below the
    // rest is seen at night. The old picture is seen in no state.
    assert_eq!(names(&right(assembly)), ["below", "day", "night", "stars", "sun", "show"]);
}

#[test]
fn a_reader_that_stays_without_its_writer_is_rejected() {
    let (mut assembly, [a, ..], target) = start();
    let toggle = assembly.toggle("glow");
    let _ = assembly.pass("glow").writes(a).toggle(toggle, true);
    let _ = assembly.pass("show").reads(a).color(target, CLEAR);
    let (code, message) = rejected(assembly);
    assert_eq!(code, codes::TOGGLED_AWAY.id);
    assert_eq!(message, "\"show\" reads \"a\", which nothing writes while \"glow\" is off");
}

#[test]
fn a_reader_of_a_range_that_a_toggle_takes_away_is_rejected() {
    let reader = |is_live: bool| {
        let (mut assembly, _, target) = start();
        let a = assembly.texture_with("mips", |texture| texture.mips = Some(Expr::from(3.0)));
        let toggle = assembly.toggle("mip");
        let range = |mip| SubresourceRange::of(Some(mip), None);
        let _ = assembly.pass("first").writes_range(a, range(0));
        for mip in [1, 2] {
            let _ = assembly.pass(&format!("mip{mip}")).writes_range(a, range(mip)).toggle(toggle, true);
        }
        let show = assembly.pass("show").reads(a);
        let _ = if is_live { show.color(target, CLEAR) } else { show };
        let _ = assembly.pass("end").side_effect();
        assembly
    };
    let message = "\"show\" reads mip 2 of \"mips\", which nothing writes while \"mip\" is off";
    assert_eq!(rejected(reader(true)), (codes::TOGGLED_AWAY.id, message.to_owned()));
    // Where nothing needs the reader, what it finds is no matter, as it is none without toggles.
    let _ = right(reader(false));
}

#[test]
fn constant_writes_of_each_piece_cover_a_toggled_write() {
    let (mut assembly, [a, ..], target) = start();
    let toggle = assembly.toggle("effect");
    let layers = assembly.texture_with("layers", |texture| texture.layers = Some(Expr::from(2.0)));
    let buffer = assembly.buffer("bytes", 256, Lifetime::Transient);
    let whole = assembly.pass("attachment").color(a, CLEAR).handle();
    let bytes = assembly.pass("bytes").writes_range(buffer, SubresourceRange::bytes(0, 256)).handle();
    let [one, two] = [0, 1].map(|layer| {
        let range = SubresourceRange::of(Some(0), Some(layer));
        assembly.pass(&format!("layer{layer}")).writes_range(layers, range).handle()
    });
    let effect = assembly.pass("effect").toggle(toggle, true).writes(a).writes(layers).writes(buffer);
    let _ = effect.after(whole).after(bytes).after(one).after(two);
    let _ = assembly.pass("show").reads(a).reads(layers).reads(buffer).color(target, CLEAR);
    let plan = right(assembly);
    assert_eq!(names(&plan), ["attachment", "bytes", "layer0", "layer1", "effect", "show"]);
}

#[test]
fn a_toggled_write_within_a_constant_one_may_alias() {
    let (mut assembly, _, target) = start();
    let toggle = assembly.toggle("effect");
    let mips = assembly.texture_with("mips", |texture| texture.mips = Some(Expr::from(3.0)));
    let mip =
        |first, count| SubresourceRange { mip: Some(IndexRange { first, count }), ..SubresourceRange::WHOLE };
    let all = assembly.pass("all").writes_range(mips, mip(0, 3)).handle();
    let _ = assembly.pass("one").toggle(toggle, true).writes_range(mips, mip(1, 1)).after(all);
    let _ = assembly.pass("show").reads(mips).color(target, CLEAR);
    let plan = right(assembly);
    assert_eq!(names(&plan), ["all", "one", "show"]);
    assert!(!plan.resources["mips"].conditional);
}

#[test]
fn layers_drawn_alone_while_a_toggle_is_off_are_fine() {
    let (mut assembly, _, target) = start();
    let toggle = assembly.toggle("at_once");
    let layered = |texture: &mut TextureDeclaration| {
        (texture.layers, texture.lifetime) = (Some(Expr::from(2.0)), Lifetime::Imported);
    };
    let layers = assembly.texture_with("layers", layered);
    let _ = assembly.pass("at_once").toggle(toggle, true).writes(layers);
    for layer in 0..2 {
        let range = SubresourceRange::of(Some(0), Some(layer));
        let _ = assembly.pass(&format!("layer{layer}")).toggle(toggle, false).writes_range(layers, range);
    }
    let _ = assembly.pass("show").color(target, CLEAR);
    assert_eq!(names(&right(assembly)), ["at_once", "layer0", "layer1", "show"]);
}

#[test]
fn readers_with_the_same_toggle_vanish_with_the_writer() {
    let (mut assembly, [a, b, _], target) = start();
    let toggle = assembly.toggle("glow");
    let _ = assembly.pass("base").writes(b);
    let _ = assembly.pass("glow").writes(a).toggle(toggle, true);
    let _ = assembly.pass("add").reads(a).updates(b).toggle(toggle, true);
    let _ = assembly.pass("show").reads(b).color(target, CLEAR);
    assert_eq!(names(&right(assembly)), ["base", "glow", "add", "show"]);
}

#[test]
fn a_reader_with_the_opposite_toggle_never_sees_the_write() {
    let (mut assembly, [a, ..], target) = start();
    let toggle = assembly.toggle("glow");
    let _ = assembly.pass("glow").writes(a).toggle(toggle, true);
    let _ = assembly.pass("show").reads(a).color(target, CLEAR).toggle(toggle, false);
    let (code, message) = rejected(assembly);
    assert_eq!((code, message.as_str()), ("UG0401", "\"show\" reads \"a\", which nothing writes before"));
}

#[test]
fn opposite_toggles_need_no_order_and_no_passthrough() {
    let (mut assembly, [a, ..], target) = start();
    let toggle = assembly.toggle("fine");
    let _ = assembly.pass("fine").writes(a).toggle(toggle, true);
    let _ = assembly.pass("rough").writes(a).toggle(toggle, false);
    let _ = assembly.pass("add").updates(a);
    let _ = assembly.pass("show").reads(a).color(target, CLEAR);
    let plan = right(assembly);
    assert_eq!(names(&plan), ["fine", "rough", "add", "show"]);
    assert!(pass(&plan, "rough").toggle.as_deref() == Some("!fine"));
}

#[test]
fn a_passthrough_keeps_the_fallback_alive_for_the_reader() {
    let (mut assembly, [a, b, c], target) = start();
    let toggle = assembly.toggle("blur");
    let _ = assembly.pass("draw").writes(a);
    let _ = assembly.pass("blur").reads(a).writes(b).toggle(toggle, true);
    assembly.passthrough(b, a, Version::Newest, on(toggle));
    let _ = assembly.pass("other").writes(c).side_effect();
    let _ = assembly.pass("show").reads(b).color(target, CLEAR);
    let plan = right(assembly);
    assert_eq!(names(&plan), ["draw", "blur", "other", "show"]);
    assert_eq!(plan.resources["a"].last, 3);
    assert_eq!(pass(&plan, "blur").passthrough["b"], "a");
}

#[test]
fn a_fallback_is_no_smaller_a_buffer() {
    let with_fallback_of = |bytes: u32| {
        let (mut assembly, _, target) = start();
        let toggle = assembly.toggle("sort");
        let [raw, sorted] = [("raw", bytes), ("sorted", 64)]
            .map(|(name, bytes)| assembly.buffer(name, bytes, Lifetime::Transient));
        let all = SubresourceRange::WHOLE;
        let _ = assembly.pass("fill").writes(raw);
        let sort = assembly.pass("sort").accesses(raw, all, Usage::StorageRead, Version::Newest);
        let _ = sort.writes(sorted).toggle(toggle, true);
        assembly.passthrough(sorted, raw, Version::Newest, on(toggle));
        let show = assembly.pass("show").accesses(sorted, all, Usage::StorageRead, Version::Newest);
        let _ = show.color(target, CLEAR);
        assembly
    };
    let message = "\"sorted\" and \"raw\" have 64 and 60 bytes".to_owned();
    assert_eq!(rejected(with_fallback_of(60)), (codes::PASSTHROUGH.id, message));
    right(with_fallback_of(64));
    right(with_fallback_of(68));
}

#[test]
fn a_later_write_of_the_fallback_waits_for_its_readers() {
    let (mut assembly, [a, b, c], target) = start();
    let toggle = assembly.toggle("blur");
    // "later" updates what "show" sees without the blur; it is declared first, but must not run first.
    let _ = assembly.pass("later").updates(a).side_effect();
    let _ = assembly.pass("draw").writes(a);
    let _ = assembly
        .pass("blur")
        .accesses(a, SubresourceRange::WHOLE, Usage::Sampled, Version::WrittenBy("draw".into()))
        .writes(b)
        .toggle(toggle, true);
    let _ = assembly.pass("show").reads(b).writes(c);
    let _ = assembly.pass("out").reads(c).color(target, CLEAR);
    assembly.passthrough(b, a, Version::WrittenBy("draw".into()), on(toggle));
    let plan = right(assembly);
    let at = |name: &str| names(&plan).iter().position(|one| *one == name);
    assert!(at("show") < at("later"), "{:?}", names(&plan));
}

#[test]
fn passthroughs_of_a_chain_lead_back_to_its_source() {
    let (mut assembly, [a, b, c], target) = start();
    let bloom = assembly.toggle("bloom");
    let dof = assembly.toggle("dof");
    let _ = assembly.pass("draw").writes(a);
    let _ = assembly.pass("bloom").reads(a).writes(b).toggle(bloom, true);
    let _ = assembly.pass("dof").reads(b).writes(c).toggle(dof, true);
    let _ = assembly.pass("show").reads(c).color(target, CLEAR);
    assembly.passthrough(b, a, Version::Newest, on(bloom));
    assembly.passthrough(c, b, Version::Newest, on(dof));
    let plan = right(assembly);
    assert_eq!(plan.resources["a"].last, 3);
    assert_eq!(plan.resources["b"].last, 3);
}

#[test]
fn a_conditional_writer_never_aliases() {
    let build = |toggled: bool| {
        let (mut assembly, [a, b, c], target) = start();
        let toggle = assembly.toggle("extra");
        let _ = assembly.pass("p1").writes(a);
        let _ = assembly.pass("p2").reads(a).writes(b);
        let pass = assembly.pass("p3").reads(b).writes(c);
        let _ = if toggled { pass.toggle(toggle, true) } else { pass };
        let _ = assembly.pass("p4").reads(c).color(target, CLEAR);
        assembly.passthrough(c, b, Version::Newest, on(toggle));
        right(assembly)
    };
    assert_eq!(build(false).textures.len(), 2);
    let plan = build(true);
    assert_eq!(plan.textures.len(), 3);
    assert!(plan.resources["c"].conditional && !plan.resources["a"].conditional);
    let why = umbragraph::low_level::why::why_apart(&plan, "a", "c");
    assert!(why.iter().any(|reason| reason.contains("toggle")), "{why:?}");
}

#[test]
fn draws_join_a_render_pass_only_with_the_same_toggle() {
    let groups = |second: Option<bool>, third: Option<bool>| {
        let (mut assembly, [a, ..], target) = start();
        let toggle = assembly.toggle("extra");
        let first = assembly.pass("p1").color(a, CLEAR).handle();
        let pass = assembly.pass("p2").color(a, LoadOperation::Load).after(first);
        let second = match second {
            Some(on) => pass.toggle(toggle, on).handle(),
            None => pass.handle(),
        };
        let pass = assembly.pass("p3").color(a, LoadOperation::Load).after(second);
        let _ = match third {
            Some(on) => pass.toggle(toggle, on),
            None => pass,
        };
        let _ = assembly.pass("show").reads(a).color(target, CLEAR);
        let plan = right(assembly);
        plan.passes.iter().map(|pass| pass.group).collect::<Vec<_>>()
    };
    assert_eq!(groups(None, None), [0, 0, 0, 1]);
    assert_eq!(groups(Some(true), Some(true)), [0, 1, 1, 2]);
    assert_eq!(groups(Some(true), Some(false)), [0, 1, 2, 3]);
    assert_eq!(groups(None, Some(true)), [0, 0, 1, 2]);
}

#[test]
fn a_picture_that_a_toggle_leaves_unwritten_is_rejected() {
    let (mut assembly, _, target) = start();
    let toggle = assembly.toggle("all");
    let _ = assembly.pass("draw").color(target, CLEAR).toggle(toggle, true);
    let (code, message) = rejected(assembly);
    assert_eq!(code, codes::TOGGLED_AWAY.id);
    assert_eq!(message, "nothing writes \"target\" while \"all\" is off");
}

#[test]
fn a_toggled_draw_over_the_hosts_own_picture_is_fine() {
    let (mut assembly, _, target) = start();
    let toggle = assembly.toggle("overlay");
    let _ = assembly.pass("draw").color(target, LoadOperation::Load).toggle(toggle, true);
    assert_eq!(names(&right(assembly)), ["draw"]);
}

#[test]
fn a_store_that_only_one_state_needs_is_not_dropped() {
    let (mut assembly, [a, ..], target) = start();
    let toggle = assembly.toggle("fog");
    let base = assembly.pass("base").color(a, CLEAR).handle();
    let _ = assembly.pass("fog").color(a, CLEAR).after(base).toggle(toggle, true);
    let _ = assembly.pass("show").reads(a).color(target, CLEAR);
    let mut plan = right(assembly);
    plan.passes[0].color[0].store = StoreOperation::Discard;
    let violations = verify(&plan, &PlanOptions::new(64, 64));
    assert_eq!(violations[0].kind, ViolationKind::ContentsDropped);
    assert_eq!(
        violations[0].message,
        "\"show\" needs \"a\", which \"base\" does not store, with \"fog\" off"
    );
}
