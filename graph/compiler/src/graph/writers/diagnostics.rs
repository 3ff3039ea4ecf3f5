//! Diagnostics about writers that nothing orders, about cycles, and about reads of contents that nothing writes.

use super::{Builder, Via};
use crate::graph::Hazard;
use crate::graph::access::PassAccess;
use crate::graph::cycle;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_pipeline::pipeline::{Located as _, ResourceKind, TypedPipeline, is_round};
use umbragraph_pipeline::work::ResourceHandle;

/// The maximum number of passes of a cycle that a diagnostic names.
const SHOWN: usize = 32;

impl Builder<'_> {
    pub(super) fn report_cycles(&mut self, diagnostics: &mut Diagnostics) {
        let edges: Vec<Vec<usize>> =
            self.next.iter().map(|list| list.iter().map(|(to, _)| to.index()).collect()).collect();
        for members in cycle::shortest(&edges) {
            let steps = members.iter().zip(members.iter().cycle().skip(1));
            let mut resources = steps.clone().filter_map(|(from, to)| match self.via(*from, *to)? {
                Via::Order(Hazard::Explicit) => None,
                Via::Data(one) | Via::Order(Hazard::WriteAfterRead(one) | Hazard::WriteAfterWrite(one)) => {
                    Some(one)
                }
            });
            let unclear = resources.find(|one| self.unclear.contains(one));
            if unclear.is_some_and(|resource| self.leaves_out(resource)) {
                continue;
            }
            let first = &self.pipeline.passes[members[0]];
            let mut names: Vec<String> = members
                .iter()
                .take(SHOWN)
                .map(|pass| format!("\"{}\"", self.pipeline.passes[*pass].name))
                .collect();
            if members.len() > SHOWN {
                names.push(format!("and {} more", members.len() - SHOWN));
            }
            let message = format!("the passes {} wait for one another", names.join(", "));
            let is_explicit = |(from, to): (&usize, &usize)| {
                matches!(self.via(*from, *to), Some(Via::Order(Hazard::Explicit)))
            };
            let help = if steps.clone().any(is_explicit) {
                "break the cycle: remove one of the \"after\""
            } else {
                "break the cycle: read an older version (name@pass), or write to another resource"
            };
            let mut diagnostic = first.error(codes::CYCLE, message).help(help);
            for (from, to) in steps.take(SHOWN) {
                let step = self.describe_step(*from, *to);
                diagnostic = diagnostic.related(self.pipeline.passes[*from].place, step);
            }
            diagnostics.push(diagnostic);
        }
    }

    fn via(&self, from: usize, to: usize) -> Option<Via> {
        self.next[from].iter().find(|(next, _)| next.index() == to).map(|(_, via)| *via)
    }

    fn describe_step(&self, from: usize, to: usize) -> String {
        let via = self.via(from, to);
        let (first, second) = (&self.pipeline.passes[from].name, &self.pipeline.passes[to].name);
        let resource = |handle: ResourceHandle| &self.pipeline.resource(handle).name;
        match via {
            Some(Via::Data(handle)) => format!("\"{second}\" reads \"{}\" of \"{first}\"", resource(handle)),
            Some(Via::Order(Hazard::WriteAfterRead(handle))) => {
                format!("\"{second}\" overwrites \"{}\", which \"{first}\" reads", resource(handle))
            }
            Some(Via::Order(Hazard::WriteAfterWrite(handle))) => {
                format!("\"{second}\" overwrites \"{}\" of \"{first}\"", resource(handle))
            }
            _ => format!("\"{second}\" is after \"{first}\""),
        }
    }
}

pub(super) fn never_written(
    pipeline: &TypedPipeline,
    resource: ResourceHandle,
    reader: &PassAccess<'_>,
    list: &[PassAccess<'_>],
    behind: Option<&PassAccess<'_>>,
) -> Diagnostic {
    let known = pipeline.resource(resource);
    if let Some(writer) = behind.filter(|writer| pipeline.pass(writer.pass).after.contains(&reader.pass)) {
        let (reads, writes) = (&pipeline.pass(reader.pass).name, pipeline.pass(writer.pass));
        let message = format!(
            "\"{}\" is to run after \"{reads}\", but \"{reads}\" reads \"{}\", which \"{}\" writes",
            writes.name, known.name, writes.name
        );
        let help = format!(
            "remove \"{reads}\" from \"after\" of \"{}\", or let it read another resource",
            writes.name
        );
        let diagnostic = writes.error(codes::CYCLE, message);
        return diagnostic.related(reader.one.place, format!("\"{reads}\" reads it here")).help(help);
    }
    let scene = pipeline.pass(reader.pass).work().scene();
    if reader.writes && reader.one.usage.is_depth() && scene.is_some_and(|scene| scene.redraw.is_some()) {
        let message = format!(
            "\"{}\" keeps views from frame to frame (\"redraw\": \"changed\"), but \"{}\" lasts for one frame",
            pipeline.pass(reader.pass).name,
            known.name
        );
        let diagnostic =
            reader.one.error(codes::NEVER_WRITTEN, message).related(known.place, "declared here");
        return diagnostic.help(format!("add \"lifetime\": \"persistent\" to \"{}\"", known.name));
    }
    let verb = if reader.writes { "loads" } else { "reads" };
    let message = format!(
        "\"{}\" {verb} \"{}\", which nothing writes before",
        pipeline.pass(reader.pass).name,
        known.name
    );
    let others = list.iter().any(|access| access.writes && access.pass != reader.pass);
    let help = match (&known.kind, others, reader.writes) {
        (ResourceKind::Data(_), ..) => "let a CPU pass publish it".to_owned(),
        _ if known.history.is_some() => {
            format!(
                "let a pass write it before, or read \"{}@-1\", which is what the frame before left",
                known.name
            )
        }
        (_, true, _) => "the passes that write it write other mips or layers, or run later".to_owned(),
        (ResourceKind::Buffer(_), false, true) => {
            format!("fill it before: {{ \"clear\": {{ \"buffer\": \"&{}\" }} }}", known.name)
        }
        (_, false, true) => "give the attachment a \"clear\" value".to_owned(),
        (_, false, false) => {
            "let a pass write it, or make it \"lifetime\": \"imported\" if the host fills it".to_owned()
        }
    };
    reader.one.error(codes::NEVER_WRITTEN, message).related(known.place, "declared here").help(help)
}

pub(super) fn unordered_writers(
    pipeline: &TypedPipeline,
    resource: ResourceHandle,
    a: &PassAccess<'_>,
    b: &PassAccess<'_>,
) -> Diagnostic {
    let (first, second) = if a.pass < b.pass { (a, b) } else { (b, a) };
    let name = |access: &PassAccess<'_>| &pipeline.pass(access.pass).name;
    let resource = &pipeline.resource(resource).name;
    let message = format!(
        "\"{}\" and \"{}\" both write \"{resource}\", and nothing says which goes first",
        name(first),
        name(second)
    );
    let diagnostic = second.one.error(codes::UNORDERED_WRITERS, message);
    diagnostic
        .related(first.one.place, format!("\"{}\" writes it here", name(first)))
        .help(order_help(name(first), name(second)))
}

/// Returns the help text that tells how to order two passes with `after`. A common subgraph prefix is removed from both
/// names, so that the text names the passes or subgraph instances to order.
fn order_help(first: &str, second: &str) -> String {
    let outer = first
        .match_indices('.')
        .map(|(at, _)| at + 1)
        .take_while(|end| second.get(..*end) == first.get(..*end))
        .last()
        .unwrap_or(0);
    let beside = |name: &str| name[outer..].split('.').next().unwrap_or_default().to_owned();
    let (earlier, later) = (beside(first), beside(second));
    let common = first[..outer].trim_end_matches('.');
    if is_round(&earlier) || is_round(&later) {
        return format!(
            "let the rounds of \"{common}\" write different subresource ranges, or one resource each"
        );
    }
    let inside = if common.is_empty() { String::new() } else { format!(" in \"{common}\"") };
    format!("add \"after\": [\"{earlier}\"] to \"{later}\"{inside}, or the other way round")
}
