//! Checks that a plan has the attachments that the passes declare, with correct properties.

use std::collections::HashMap;

use crate::violation::{ViolationKind as Kind, Violations};
use umbragraph_compiler::{Plan, PlannedAttachment, PlannedPass, StoreOperation};
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::work::{AttachmentTarget, LoadOperation, RenderWork, ResourceHandle, Work};

/// Checks the attachments of the passes, their load and store operations, and the render pass groups.
pub(crate) fn check(plan: &Plan, violations: &mut Violations) {
    let mut users: HashMap<ResourceHandle, Vec<usize>> = HashMap::new();
    for (at, planned) in plan.passes.iter().enumerate() {
        for one in plan.pipeline.pass(planned.handle).accesses() {
            users.entry(one.resource).or_default().push(at);
        }
    }
    for (at, planned) in plan.passes.iter().enumerate() {
        let declared: Vec<(AttachmentTarget, &'static str, bool)> =
            match plan.pipeline.pass(planned.handle).work() {
                Work::Render(render) => declared(render),
                _ => Vec::new(),
            };
        let attachments: Vec<&PlannedAttachment> = planned.attachments().collect();
        let same = attachments.len() == declared.len()
            && attachments.iter().zip(&declared).all(|(planned, (declared, ..))| {
                planned.target == *declared
                    && plan
                        .pipeline
                        .resources
                        .get(planned.target.resource.index())
                        .is_some_and(|one| one.name == planned.resource)
            });
        if !same {
            let message = format!("the attachments of \"{}\" are not those that it declares", planned.name);
            violations.add(Kind::AttachmentsDiffer, message);
            continue;
        }
        for (attachment, (_, load, discard)) in attachments.iter().zip(&declared) {
            if word(&attachment.load) != *load {
                let message = format!("\"{}\" declares {load} for \"{}\"", planned.name, attachment.resource);
                violations.add(Kind::LoadDiffers, message);
            }
            if *discard && attachment.store == StoreOperation::Store {
                let message =
                    format!("\"{}\" declares that \"{}\" is discarded", planned.name, attachment.resource);
                violations.add(Kind::StoreDiffers, message);
            }
            if attachment.transient_attachment && !stays(plan, planned, attachment, at, &users) {
                let message = format!("\"{}\" does not stay in \"{}\"", attachment.resource, planned.name);
                violations.add(Kind::TransientAttachmentLeaves, message);
            }
        }
    }
    check_groups(plan, violations);
}

/// Returns the declared attachments: color, depth, then stencil. Each has its load operation as a word, and `true` if
/// it is discarded.
pub(crate) fn declared(render: &RenderWork) -> Vec<(AttachmentTarget, &'static str, bool)> {
    let color = render.color.iter().map(|one| (one.to.target(), word(&one.load), one.discard));
    let depth = render.depth.iter().map(|one| (one.to.target(), word(&one.load), one.discard));
    let stencil = render.stencil.iter().map(|one| (one.to.target(), word(&one.load), one.discard));
    color.chain(depth).chain(stencil).collect()
}

fn word<T>(load: &LoadOperation<T>) -> &'static str {
    match load {
        LoadOperation::Load => "load",
        LoadOperation::Clear(_) => "clear",
        LoadOperation::Discard => "discard",
    }
}

/// Returns `true` if no contents of an attachment enter or leave its pass.
fn stays(
    plan: &Plan,
    planned: &PlannedPass,
    attachment: &PlannedAttachment,
    at: usize,
    users: &HashMap<ResourceHandle, Vec<usize>>,
) -> bool {
    let handle = attachment.target.resource;
    let mut accesses = plan.pipeline.pass(planned.handle).accesses().iter();
    let is_used_otherwise = accesses.any(|one| one.resource == handle && !one.usage.is_attachment());
    attachment.store == StoreOperation::Discard
        && word(&attachment.load) != "load"
        && plan.pipeline.resource(handle).lifetime() == Lifetime::Transient
        && !is_used_otherwise
        && users.get(&handle).is_none_or(|list| list.iter().all(|user| *user == at))
}

/// Checks each group of passes that is recorded as one render pass. Its passes are consecutive and have the same toggle
/// and attachments. All but the first load, and no other resource that one of them writes is shared.
fn check_groups(plan: &Plan, violations: &mut Violations) {
    let mut before: Option<usize> = None;
    for group in plan.passes.chunk_by(|a, b| a.group == b.group) {
        let Some(first) = group.first() else { continue };
        if before.is_some_and(|before| before >= first.group) {
            violations
                .add(Kind::GroupBroken, format!("the group of \"{}\" is not one run of passes", first.name));
        }
        before = Some(first.group);
        let targets = |pass: &PlannedPass| {
            let color: Vec<AttachmentTarget> = pass.color.iter().map(|one| one.target).collect();
            let rest = [&pass.depth, &pass.stencil];
            (color, rest.map(|one| one.as_ref().map(|one| one.target)))
        };
        let mut others: HashMap<ResourceHandle, (bool, usize)> = HashMap::new();
        for (offset, pass) in group.iter().enumerate() {
            let condition = |pass: &PlannedPass| plan.pipeline.pass(pass.handle).condition;
            let mut broken = offset > 0
                && (targets(pass) != targets(first)
                    || condition(pass) != condition(first)
                    || pass.attachments().next().is_none()
                    || pass.attachments().any(|one| word(&one.load) != "load"));
            for one in plan.pipeline.pass(pass.handle).accesses() {
                let attached = first.attachments().any(|other| other.target.resource == one.resource);
                let as_attachment = one.usage.is_attachment();
                broken |= group.len() > 1 && attached != as_attachment;
                if !as_attachment {
                    let (written, by) = others.entry(one.resource).or_insert((false, offset));
                    broken |= *by != offset && (*written || one.usage.writes());
                    *written |= one.usage.writes();
                }
            }
            if broken {
                let message = format!("\"{}\" cannot join the render pass of \"{}\"", pass.name, first.name);
                violations.add(Kind::GroupBroken, message);
            }
        }
    }
}
