//! Violations planted in the histories of a plan.

use umbragraph::Plan;
use umbragraph::low_level::compiler::{CullReason, KeepReason, Physical, StoreOperation};
use umbragraph::wgpu_types::{TextureFormat, TextureUsages};
use umbragraph_verify::ViolationKind;

use crate::checker::{at, caught, pass, pipeline, texture_of};

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
            umbragraph::low_level::compiler::InitialValue::Depth(1.0);
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
fn an_unread_history_does_not_keep_its_writer() {
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
        pass(plan, "blend").reason = KeepReason::ReadLater((reader, past));
    });
}

#[test]
fn a_history_that_is_not_stored_is_caught() {
    caught(ViolationKind::OutputDropped, |plan| {
        pass(plan, "blend").color[0].store = StoreOperation::Discard;
    });
}
