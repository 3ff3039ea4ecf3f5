//! The checker of plans finds the violations that only some state of the toggles shows.

use std::sync::Arc;

use umbragraph::Plan;
use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::{
    Assembly, CullReason, PlanOptions, PlannedPass, StoreOperation, build, plan,
};
use umbragraph::low_level::pipeline::{Condition, TypedPipeline, Version};
use umbragraph::work::LoadOperation;
use umbragraph_verify::{ViolationKind, verify};

const CLEAR: LoadOperation<[f64; 4]> = LoadOperation::Clear([0.0; 4]);

fn options() -> PlanOptions {
    PlanOptions::new(64, 64)
}

/// A picture that fog may cover and haze may add to, an early chain that aliases, an effect with a passthrough.
fn right() -> Plan {
    let mut assembly = Assembly::new("toggles");
    let [a, b, c, d, e, early] = ["a", "b", "c", "d", "e", "early"].map(|name| assembly.texture(name));
    let target = assembly.imported("target");
    let [effect, fog, haze] = ["effect", "fog", "haze"].map(|name| assembly.toggle(name));
    let _ = assembly.pass("start").writes(early);
    let _ = assembly.pass("middle").reads(early).writes(c);
    let base = assembly.pass("base").reads(c).color(a, CLEAR).handle();
    let fogged = assembly.pass("fog").color(a, CLEAR).after(base).toggle(fog, true).handle();
    let more = assembly.pass("more").color(a, LoadOperation::Load).after(fogged).handle();
    let _ = assembly.pass("haze").color(a, LoadOperation::Load).after(more).toggle(haze, true);
    let _ = assembly.pass("effect").reads(a).writes(b).toggle(effect, true);
    let _ = assembly.pass("late").reads(b).writes(d);
    let _ = assembly.pass("later").reads(d).writes(e);
    let _ = assembly.pass("show").reads(b).reads(e).color(target, CLEAR);
    assembly.passthrough(b, a, Version::Newest, Condition { toggle: effect, on: true });
    let (pipeline, sources) = assembly.finish();
    let mut diagnostics = Diagnostics::new();
    let graph = build(&pipeline, &mut diagnostics).expect("a graph");
    let plan = plan(&pipeline, &graph, &options(), &sources, &mut diagnostics);
    plan.unwrap_or_else(|| panic!("{diagnostics:#?}"))
}

/// Asserts that the checker finds a violation of this kind once it is planted.
#[track_caller]
fn caught(kind: ViolationKind, plant: impl FnOnce(&mut Plan)) {
    let mut plan = right();
    assert_eq!(verify(&plan, &options()), Vec::new(), "before anything is planted");
    plant(&mut plan);
    let violations = verify(&plan, &options());
    assert!(violations.iter().any(|violation| violation.kind == kind), "{violations:#?}");
}

fn at(plan: &Plan, name: &str) -> usize {
    plan.passes.iter().position(|pass| pass.name == name).unwrap_or_else(|| panic!("no {name}"))
}

fn pass<'a>(plan: &'a mut Plan, name: &str) -> &'a mut PlannedPass {
    let at = at(plan, name);
    &mut plan.passes[at]
}

fn pipeline(plan: &mut Plan) -> &mut TypedPipeline {
    Arc::make_mut(&mut plan.pipeline)
}

#[test]
fn toggled_writes_are_not_aliased_in_the_valid_plan() {
    let plan = right();
    assert_eq!(plan.resources["early"].physical, plan.resources["d"].physical);
    assert!(plan.resources["b"].conditional);
}

#[test]
fn a_store_that_only_the_state_without_a_clear_needs_is_caught() {
    caught(ViolationKind::ContentsDropped, |plan| {
        pass(plan, "base").color[0].store = StoreOperation::Discard;
    });
}

#[test]
fn a_culled_writer_that_one_toggle_state_needs_is_caught() {
    caught(ViolationKind::CulledButNeeded, |plan| {
        let base = at(plan, "base");
        plan.passes.remove(base);
        plan.culled.insert("base".to_owned(), CullReason::NothingReads(vec!["a".to_owned()]));
    });
}

#[test]
fn a_writer_that_can_be_off_under_a_reader_that_stays_is_caught() {
    caught(ViolationKind::UninitialisedRead, |plan| {
        let base = pipeline(plan).find_pass("base").expect("base");
        pipeline(plan).passes[base.index()].condition = Some(Condition { toggle: 1, on: true });
    });
}

#[test]
fn a_render_pass_of_two_toggles_is_caught() {
    caught(ViolationKind::GroupBroken, |plan| {
        let group = pass(plan, "more").group;
        let from = at(plan, "haze");
        for pass in &mut plan.passes[from..] {
            pass.group -= 1;
        }
        assert_eq!(pass(plan, "haze").group, group);
    });
}

#[test]
fn shared_memory_of_what_a_toggle_can_leave_unwritten_is_caught() {
    caught(ViolationKind::SharedThoughConditional, |plan| {
        let early = plan.resources["early"].physical;
        plan.resources.get_mut("b").expect("b").physical = early;
    });
}

#[test]
fn a_wrong_mark_of_a_toggled_first_write_is_caught() {
    caught(ViolationKind::ToggleWrong, |plan| {
        plan.resources.get_mut("b").expect("b").conditional = false;
    });
}

#[test]
fn a_toggle_stated_wrong_is_caught() {
    caught(ViolationKind::ToggleWrong, |plan| pass(plan, "fog").toggle = Some("!fog".to_owned()));
    caught(ViolationKind::ToggleWrong, |plan| pass(plan, "haze").toggle = None);
}

#[test]
fn a_passthrough_stated_wrong_is_caught() {
    caught(ViolationKind::ToggleWrong, |plan| pass(plan, "effect").passthrough.clear());
    caught(ViolationKind::ToggleWrong, |plan| {
        pass(plan, "fog").passthrough.insert("a".to_owned(), "c".to_owned());
    });
}

#[test]
fn other_states_at_the_start_than_the_pipeline_says_are_caught() {
    caught(ViolationKind::ToggleWrong, |plan| {
        plan.toggles.insert("fog".to_owned(), false);
    });
}

#[test]
fn a_reader_that_does_not_use_the_fallback_is_caught() {
    caught(ViolationKind::PassthroughMissing, |plan| {
        let (show, a) = (pipeline(plan).find_pass("show"), pipeline(plan).find_resource("a"));
        let accesses = pipeline(plan).passes[show.expect("show").index()].tamper().1;
        accesses.retain(|one| Some(one.resource) != a);
    });
}

#[test]
fn a_reader_of_a_passthrough_in_every_frame_is_caught() {
    caught(ViolationKind::PassthroughMissing, |plan| {
        let (show, b) = (pipeline(plan).find_pass("show"), pipeline(plan).find_resource("b"));
        for one in pipeline(plan).passes[show.expect("show").index()].tamper().1 {
            if Some(one.resource) == b {
                one.when.clear();
            }
        }
    });
}

#[test]
fn a_fallback_with_other_samples_is_caught() {
    caught(ViolationKind::PassthroughMisfit, |plan| {
        let size = plan.resources.get_mut("a").and_then(|one| one.size.as_mut());
        size.expect("a size").samples = 4;
    });
}

#[test]
fn a_fallback_that_is_overwritten_before_its_reader_is_caught() {
    caught(ViolationKind::ReadTooEarly, |plan| {
        let (from, to) = (at(plan, "haze"), at(plan, "show"));
        let moved = plan.passes.remove(from);
        plan.passes.insert(to, moved);
    });
}
