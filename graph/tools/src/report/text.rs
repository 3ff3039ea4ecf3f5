//! Graphs as text for other tools: Graphviz and Mermaid.
//!
//! Passes are boxes, versions are edges labelled with the resource; hazards without data are dashed. Names never stand
//! for identifiers, so that any name is possible.

use std::fmt::Write as _;

use super::model::{EdgeKind, EdgeReport, PassReport, Report};

/// Renders the graph in Graphviz DOT.
pub(super) fn dot(report: &Report) -> String {
    let quote =
        |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', " "));
    let mut out = format!(
        "digraph {} {{\n  rankdir=LR;\n  node [shape=box, style=rounded];\n",
        quote(&report.pipeline)
    );
    for (at, pass) in report.passes.iter().enumerate() {
        let label = quote(&format!("{} ({}{})", pass.name, pass.kind, toggle(pass)));
        let grey = if pass.live { "" } else { ", color=grey, fontcolor=grey, style=\"rounded,dashed\"" };
        let _ = writeln!(out, "  p{at} [label={label}{grey}];");
    }
    for edge in &report.edges {
        let style = if edge.kind == EdgeKind::Data { "solid" } else { "dashed" };
        let _ =
            writeln!(out, "  p{} -> p{} [label={}, style={style}];", edge.from, edge.to, quote(&label(edge)));
    }
    out.push_str("}\n");
    out
}

fn toggle(pass: &PassReport) -> String {
    pass.toggle.as_ref().map_or_else(String::new, |toggle| format!(", toggle {toggle}"))
}

/// Renders the graph as a Mermaid flowchart.
pub(super) fn mermaid(report: &Report) -> String {
    let quote = |text: &str| {
        text.replace('&', "#amp;")
            .replace('"', "#quot;")
            .replace('<', "#lt;")
            .replace('>', "#gt;")
            .replace('\n', " ")
    };
    let mut out = String::from("flowchart LR\n");
    for (at, pass) in report.passes.iter().enumerate() {
        let _ = writeln!(
            out,
            "  p{at}[\"{} ({}{})\"]{}",
            quote(&pass.name),
            quote(&pass.kind),
            quote(&toggle(pass)),
            if pass.live { "" } else { ":::culled" }
        );
    }
    for edge in &report.edges {
        let arrow = if edge.kind == EdgeKind::Data { "-->" } else { "-.->" };
        let _ = writeln!(out, "  p{} {arrow}|\"{}\"| p{}", edge.from, quote(&label(edge)), edge.to);
    }
    out.push_str("  classDef culled fill:#eee,stroke:#aaa,color:#888,stroke-dasharray:4 3\n");
    out
}

fn label(edge: &EdgeReport) -> String {
    let resource = edge.resource.as_deref().unwrap_or_default();
    match edge.kind {
        EdgeKind::Data => format!("{resource} v{}", edge.version.as_deref().unwrap_or_default()),
        EdgeKind::WriteAfterRead => format!("{resource} is overwritten"),
        EdgeKind::WriteAfterWrite => format!("{resource} again"),
        EdgeKind::Explicit => "after".to_owned(),
        EdgeKind::LaterFrame => format!("{resource}, in a later frame"),
    }
}
