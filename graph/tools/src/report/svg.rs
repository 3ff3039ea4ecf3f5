//! The picture of a plan.
//!
//! Passes stand side by side in the order in which they run, one column each. Below them every place in memory is a
//! lane, and every resource a bar in its lane from its first to its last use, so that resources which share memory
//! stand in one lane. On a bar a full dot is a write and a ring is a read; an arc leads from each write to the reads of
//! its version. Arcs above the passes are hazards and explicit order; those that follow from others are left out, and
//! of those between the rounds of two loops the shortest stands for all. At the bottom the bytes alive at each pass
//! stand under the line of what is created. Culled passes and resources are grey.
//!
//! Coordinates are whole or half numbers and nothing depends on the machine, so the same plan gives the same text.
//! Pictures of more than a few hundred passes are drawn, but are wide.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use umbragraph_pipeline::diagnostic::counted;
use umbragraph_pipeline::diagnostic::render::visible;
use umbragraph_pipeline::language::Lifetime;

use super::model::{EdgeKind, EdgeReport, PassReport, Report, ResourceReport, bytes_in_words};
use super::settings::word;

const GUTTER: usize = 244;
const COLUMN: usize = 116;
const LANE: usize = 38;
const BOX_WIDTH: usize = 100;
const BOX_HEIGHT: usize = 46;
const CHART: usize = 96;
/// The horizontal position of the legend in pixels, beside the title so that it stays visible on wide images.
const LEGEND: usize = 520;

const STYLE: &str = "
text { font: 12px ui-sans-serif, system-ui, 'DejaVu Sans', sans-serif; fill: #1f2933 }
.title { font-size: 20px; font-weight: 650 } .sub { fill: #52606d } .small { font-size: 10.5px; fill: #7b8794 }
.section { font-size: 10.5px; font-weight: 650; letter-spacing: .08em; fill: #7b8794 }
.name { font-weight: 600 } .middle { text-anchor: middle } .end { text-anchor: end }
.pass rect.body { fill: #fff; stroke: #cbd2d9 } .pass .strip { stroke: none }
.cpu .strip { fill: #9b8afb } .draw .strip { fill: #2f80ed } .compute .strip { fill: #f2994a } .copy .strip { fill: #56b3a8 }
.culled { opacity: .45 } .culled rect.body { fill: #f0f1f3; stroke-dasharray: 4 3 } .culled .strip { fill: #9aa5b1 }
.guide { stroke: #e4e7eb; stroke-width: 1 } .stripe { fill: #f7f9fb }
.bar { rx: 7; stroke-width: 1.2 }
.transient .bar { fill: #dbeafe; stroke: #7db1f5 } .persistent .bar { fill: #dcf5e7; stroke: #6cc494 }
.history .bar { fill: #dcf5e7; stroke: #6cc494 }
.imported .bar { fill: #fdeccb; stroke: #e8b04b } .data .bar { fill: #ebe7fe; stroke: #a99af0 }
.resource.culled .bar { fill: #eceef1; stroke: #b0b8c1; stroke-dasharray: 4 3 }
.write { fill: #1f2933 } .read { fill: #fff; stroke: #1f2933; stroke-width: 1.8 }
.version { fill: none; stroke: #1f2933; stroke-opacity: .4; stroke-width: 1.3 }
.edge { fill: none; stroke-width: 1.4 } .edge.write-after-read { stroke: #d64545; stroke-dasharray: 5 3 }
.edge.later-frame { stroke: #3a9d6a; stroke-dasharray: 1 3 } .edge.write-after-write { stroke: #b44d12; stroke-dasharray: 2 3 } .edge.explicit { stroke: #7b8794 }
.group { fill: none; stroke: #2f80ed; stroke-width: 2 }
.alive { fill: #bcd7fb; stroke: #5b9bf0 } .created { stroke: #2f80ed; stroke-width: 1.6 } .without { stroke: #d64545; stroke-dasharray: 5 4 }
";

/// Draws a report as SVG, with `room` pixels below each pass for a captured image.
pub(super) fn picture(report: &Report, room: usize) -> String {
    let lanes = lanes(report);
    let arcs = shown(report);
    let head = 112 + arcs.iter().map(|edge| arc_rise(edge)).max().map_or(0, |rise| rise + 6);
    let lanes_top = head + BOX_HEIGHT + 34 + room;
    let lanes_height: usize =
        lanes.iter().map(|lane| if lane.first_of_section { LANE + 26 } else { LANE }).sum();
    let chart_top = lanes_top + lanes_height + 44;
    let width = (GUTTER + report.passes.len() * COLUMN + 40).max(LEGEND + 460);
    let height = chart_top + CHART + 40;
    let mut out = String::new();
    let _ = write!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         role=\"img\" aria-label=\"The graph of {}\">\n<style>{STYLE}</style>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n",
        escape(&report.pipeline)
    );
    header(&mut out, report);
    for column in (0..report.passes.len()).step_by(2) {
        let (x, top, tall) = (GUTTER + column * COLUMN, lanes_top - 8, lanes_height + 16);
        let _ = writeln!(
            out,
            "<rect class=\"stripe\" x=\"{x}\" y=\"{top}\" width=\"{COLUMN}\" height=\"{tall}\"/>"
        );
    }
    hazards(&mut out, report, &arcs, head);
    passes(&mut out, report, head);
    draw_lanes(&mut out, report, &lanes, lanes_top);
    chart(&mut out, report, chart_top);
    out.push_str("</svg>\n");
    out
}

fn center(column: usize) -> usize {
    GUTTER + column * COLUMN + COLUMN / 2
}

fn header(out: &mut String, report: &Report) {
    let (live, all) = (report.live_passes(), report.passes.len());
    let memory = &report.memory;
    let resources = report.resources.iter().filter(|resource| resource.live).count();
    let [width, height] = report.viewport;
    let culled = if all > live { format!(", {} culled", all - live) } else { String::new() };
    let (live, resources) = (counted(live, "pass"), counted(resources, "resource"));
    let counts =
        format!("{width} × {height} · {live}{culled} · {resources} · order for {}", report.objective);
    let [created, apart, bound] = [memory.created, memory.without_aliasing, memory.bound].map(bytes_in_words);
    let bytes = format!("{created} created, {apart} without aliasing; bound {bound}");
    for (class, y, words) in [("title", 38, &report.pipeline), ("sub", 60, &counts), ("sub", 79, &bytes)] {
        let _ = writeln!(out, "{}", text(class, [24, y], words));
    }
    for (at, word) in ["cpu", "draw", "compute", "copy"].into_iter().enumerate() {
        let x = LEGEND + 84 * at;
        let _ = writeln!(
            out,
            "<g class=\"{word}\"><rect class=\"strip\" x=\"{x}\" y=\"28\" width=\"12\" height=\"12\" rx=\"3\"/><text x=\"{}\" y=\"38\">{word}</text></g>",
            x + 18
        );
    }
    let x = LEGEND;
    let _ = writeln!(
        out,
        "<circle class=\"write\" cx=\"{}\" cy=\"56\" r=\"5\"/><text x=\"{}\" y=\"60\">write</text><circle class=\"read\" cx=\"{}\" cy=\"56\" r=\"4.5\"/>\
         <text x=\"{}\" y=\"60\">read</text><path class=\"edge write-after-read\" d=\"M{} 56h22\"/><text x=\"{}\" y=\"60\">read before overwritten</text>",
        x + 6,
        x + 18,
        x + 90,
        x + 102,
        x + 168,
        x + 196
    );
    let arcs = [
        ("edge write-after-write", "overwritten", 0),
        ("edge later-frame", "a later frame", 108),
        ("edge explicit", "as said", 224),
        ("group", "one render pass", 302),
    ];
    for (class, words, at) in arcs {
        let x = x + at;
        let _ = writeln!(
            out,
            "<path class=\"{class}\" d=\"M{x} 75h22\"/><text x=\"{}\" y=\"79\">{words}</text>",
            x + 28
        );
    }
}

/// Returns the edges drawn as arcs above the passes: hazards not implied by data edges, explicit order, and reads by
/// later frames.
fn shown(report: &Report) -> Vec<&EdgeReport> {
    let follows = followers(report);
    let arcs = report.edges.iter().filter(|edge| match edge.kind {
        EdgeKind::Data => false,
        EdgeKind::LaterFrame => edge.from != edge.to,
        _ => edge.from < edge.to && !follows.contains(&(edge.from, edge.to)),
    });
    // Of all the arcs between two loops, or a loop and a pass, the shortest.
    let ends = |edge: &EdgeReport| [edge.from, edge.to].map(|at| loop_of(&report.passes[at].name));
    let mut shortest: BTreeMap<_, &EdgeReport> = BTreeMap::new();
    for (at, edge) in arcs.enumerate() {
        let [from, to] = ends(edge);
        let apart = if from == to { at + 1 } else { 0 };
        let known = shortest.entry((edge.kind, from, to, apart)).or_insert(edge);
        if edge.to.abs_diff(edge.from) < known.to.abs_diff(known.from) {
            *known = edge;
        }
    }
    let mut shown: Vec<&EdgeReport> = shortest.into_values().collect();
    shown.sort_by_key(|edge| (edge.from, edge.to));
    shown
}

/// Returns the name of the loop that made a pass; the pass's own name if no loop did.
fn loop_of(pass: &str) -> &str {
    match pass.rsplit_once('.') {
        Some((name, round)) if round.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => pass,
    }
}

/// Returns the pairs of passes, as columns, whose order follows from other edges, or between which a data edge leads.
fn followers(report: &Report) -> BTreeSet<(usize, usize)> {
    let mut next: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    let mut follows = BTreeSet::new();
    for edge in report.edges.iter().filter(|edge| edge.kind != EdgeKind::LaterFrame && edge.from < edge.to) {
        next.entry(edge.from).or_default().insert(edge.to);
        if edge.kind == EdgeKind::Data {
            follows.insert((edge.from, edge.to));
        }
    }
    // From the last to the first: what runs after each of a pass's next is known before the pass.
    let mut after: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for (from, next) in next.iter().rev() {
        let mut all = BTreeSet::new();
        for to in next {
            if all.contains(to) {
                follows.insert((*from, *to));
            }
            all.insert(*to);
            all.extend(after.get(to).into_iter().flatten());
        }
        after.insert(*from, all);
    }
    follows
}

fn arc_rise(edge: &EdgeReport) -> usize {
    (14 + 8 * edge.to.abs_diff(edge.from)).min(64)
}

fn hazards(out: &mut String, report: &Report, arcs: &[&EdgeReport], head: usize) {
    for edge in arcs {
        let (from, to) = if edge.from < edge.to {
            (center(edge.from) + 16, center(edge.to) - 16)
        } else {
            (center(edge.from) - 16, center(edge.to) + 16)
        };
        let rise = arc_rise(edge) * 4 / 3;
        let (class, words) = match edge.kind {
            EdgeKind::WriteAfterRead => ("write-after-read", "overwrites what is read before"),
            EdgeKind::WriteAfterWrite => ("write-after-write", "overwrites"),
            EdgeKind::LaterFrame => ("later-frame", "reads in a later frame what is left"),
            _ => ("explicit", "runs after, as the document says"),
        };
        let resource = edge.resource.as_deref().map_or(String::new(), |name| format!(" ({name})"));
        let _ = writeln!(
            out,
            "<path class=\"edge {class}\" data-from=\"{}\" data-to=\"{}\" d=\"M{from} {head}C{from} {top} {to} {top} {to} {head}\"><title>{} {words}: {}{}</title></path>",
            escape(&report.passes[edge.from].name),
            escape(&report.passes[edge.to].name),
            escape(&report.passes[edge.to].name),
            escape(&report.passes[edge.from].name),
            escape(&resource),
            top = head - rise,
        );
    }
}

fn passes(out: &mut String, report: &Report, head: usize) {
    for (column, pass) in report.passes.iter().enumerate() {
        let x = center(column) - BOX_WIDTH / 2;
        let class = format!("pass {}{}", pass.work, if pass.live { "" } else { " culled" });
        let _ = writeln!(
            out,
            "<g class=\"{class}\" data-pass=\"{}\" tabindex=\"0\"><title>{}</title><rect class=\"body\" x=\"{x}\" y=\"{head}\" width=\"{BOX_WIDTH}\" \
             height=\"{BOX_HEIGHT}\" rx=\"8\"/><path class=\"strip\" d=\"M{x} {}a8 8 0 0 1 8-8h{}a8 8 0 0 1 8 8z\"/>{}{}</g>",
            escape(&pass.name),
            escape(&title(pass)),
            head + 8,
            BOX_WIDTH - 16,
            text("name middle", [center(column), head + 25], &shorten(&pass.name, 14)),
            text("small middle", [center(column), head + 39], &shorten(&pass.kind, 16)),
        );
        if let Some(toggle) = &pass.toggle {
            // Above the box, where no edge runs.
            let words = format!("⏻ {}", shorten(toggle, 14));
            let _ = writeln!(out, "{}", text("small middle", [center(column), head - 4], &words));
        }
    }
    let mut start = 0;
    for group in report.passes.chunk_by(|a, b| a.group.is_some() && a.group == b.group) {
        let end = start + group.len();
        if group.len() > 1 {
            let (left, right, y) =
                (center(start) - BOX_WIDTH / 2, center(end - 1) + BOX_WIDTH / 2, head + BOX_HEIGHT + 5);
            let _ = writeln!(
                out,
                "<path class=\"group\" d=\"M{left} {y}v5H{right}v-5\"><title>one render pass</title></path>"
            );
        }
        start = end;
    }
}

fn title(pass: &PassReport) -> String {
    let state = if pass.live { "kept" } else { "culled" };
    let mut words = format!("{} ({})\n{state}: {}", pass.name, pass.kind, pass.why.join(", "));
    words.extend(pass.toggle.iter().map(|toggle| format!("\ntoggle: {toggle}")));
    words.extend(pass.passthrough.iter().map(|passthrough| format!("\nwithout it: {passthrough}")));
    words
}

struct Lane<'a> {
    section: &'static str,
    first_of_section: bool,
    label: String,
    detail: String,
    resources: Vec<&'a ResourceReport>,
}

/// A predicate that selects the resources of a section of the image.
type Belongs = fn(&ResourceReport) -> bool;

fn is_created(one: &ResourceReport) -> bool {
    one.live && one.place.contains(' ')
}

fn lanes(report: &Report) -> Vec<Lane<'_>> {
    let sections: [(&'static str, Belongs); 5] = [
        ("BLACKBOARD DATA", |one| one.live && one.place == "blackboard"),
        ("IMPORTED", |one| one.live && one.place == "imported"),
        ("KEPT FROM FRAME TO FRAME", |one| is_created(one) && one.lifetime != Lifetime::Transient),
        ("TRANSIENT", |one| is_created(one) && one.lifetime == Lifetime::Transient),
        ("ALLOCATED NOWHERE", |one| !one.live),
    ];
    let mut lanes: Vec<Lane<'_>> = Vec::new();
    for (section, belongs) in sections {
        let start = lanes.len();
        let mut members: Vec<&ResourceReport> = report.resources.iter().filter(|one| belongs(one)).collect();
        members.sort_by_key(|one| (one.columns, &one.name));
        for resource in members {
            let shared =
                lanes[start..].iter().position(|lane| lane.label == resource.place && section == "TRANSIENT");
            match shared {
                Some(at) => lanes[start + at].resources.push(resource),
                None => lanes.push(Lane {
                    section,
                    first_of_section: lanes.len() == start,
                    label: if resource.place.contains(' ') {
                        resource.place.clone()
                    } else {
                        resource.name.clone()
                    },
                    detail: if resource.bytes > 0 && resource.description.contains('×') {
                        format!("{} · {}", resource.description, bytes_in_words(resource.bytes))
                    } else {
                        resource.description.clone()
                    },
                    resources: vec![resource],
                }),
            }
        }
    }
    lanes
}

fn draw_lanes(out: &mut String, report: &Report, lanes: &[Lane<'_>], top: usize) {
    let right = GUTTER + report.passes.len() * COLUMN;
    let mut y = top;
    for lane in lanes {
        if lane.first_of_section {
            y += 26;
            let _ = writeln!(out, "{}", text("section", [24, y - 8], lane.section));
        }
        let middle = y + LANE / 2;
        let _ = writeln!(
            out,
            "<path class=\"guide\" d=\"M24 {}H{right}\"/>{}{}",
            y + LANE,
            text("name", [24, middle - 2], &shorten(&lane.label, 26)),
            text("small", [24, middle + 12], &shorten(&lane.detail, 37)),
        );
        for resource in &lane.resources {
            bar(out, report, resource, y);
        }
        y += LANE;
    }
}

fn bar(out: &mut String, report: &Report, resource: &ResourceReport, y: usize) {
    let [first, last] = resource.columns;
    let (x, width) = (center(first) - 44, (last - first) * COLUMN + 88);
    let middle = y + LANE / 2;
    let lifetime = match resource.kind.as_str() {
        "data" => "data".to_owned(),
        _ => word(&resource.lifetime),
    };
    let culled = if resource.live { "" } else { " culled" };
    let shared = if resource.shares_with.is_empty() {
        String::new()
    } else {
        format!("\nshares memory with {}", resource.shares_with.join(", "))
    };
    let _ = write!(
        out,
        "<g class=\"resource {lifetime}{culled}\" data-resource=\"{}\" tabindex=\"0\"><title>{} ({}){}</title><rect class=\"bar\" x=\"{x}\" y=\"{}\" \
         width=\"{width}\" height=\"{}\" rx=\"7\"/>",
        escape(&resource.name),
        escape(&resource.name),
        escape(&resource.description),
        escape(&shared),
        y + 5,
        LANE - 10,
    );
    // The versions: from each write to the reads of it.
    for edge in report
        .edges
        .iter()
        .filter(|edge| edge.kind == EdgeKind::Data && edge.resource.as_deref() == Some(&resource.name))
    {
        // A culled reader stands outside the lifetime; the bar says nothing of it.
        if edge.from < edge.to && edge.to <= last {
            let (from, to) = (center(edge.from) + 20, center(edge.to) - 4);
            let line = middle + 5;
            let dip = if edge.to - edge.from > 1 { 9 } else { 0 };
            let _ = write!(
                out,
                "<path class=\"version\" d=\"M{from} {line}C{} {low} {} {low} {to} {line}\"/>",
                from + 20,
                to - 20,
                low = line + dip
            );
        }
    }
    out.push_str(&text("name", [x + 9, middle - 2], &shorten(&resource.name, width / 8)));
    for column in resource.read_in.iter().filter(|column| (first..=last).contains(*column)) {
        let _ =
            write!(out, "<circle class=\"read\" cx=\"{}\" cy=\"{}\" r=\"4\"/>", center(*column), middle + 5);
    }
    for column in resource.written_in.iter().filter(|column| (first..=last).contains(*column)) {
        let _ = write!(
            out,
            "<circle class=\"write\" cx=\"{}\" cy=\"{}\" r=\"4.5\"/>",
            center(*column) + 14,
            middle + 5
        );
    }
    out.push_str("</g>\n");
}

fn chart(out: &mut String, report: &Report, top: usize) {
    let memory = &report.memory;
    let max = memory.without_aliasing.max(memory.created).max(1);
    if report.passes.is_empty() || memory.created == 0 {
        return;
    }
    let bottom = top + CHART;
    let rise = |bytes: u64| bottom - (u128::from(bytes) * (CHART as u128 - 6) / u128::from(max)) as usize;
    let right = GUTTER + report.passes.len() * COLUMN;
    let mut path = format!("M{GUTTER} {bottom}");
    for (column, bytes) in memory.alive.iter().enumerate() {
        let _ = write!(path, "V{}H{}", rise(*bytes), GUTTER + (column + 1) * COLUMN);
    }
    let _ = writeln!(
        out,
        "{}<path class=\"alive\" d=\"{path}V{bottom}z\"/>\
         <path class=\"created\" d=\"M{GUTTER} {created}H{right}\"/><path class=\"without\" d=\"M{GUTTER} {without}H{right}\"/>",
        text("section", [24, top + 4], "MEMORY ALIVE AT EACH PASS"),
        created = rise(memory.created),
        without = rise(memory.without_aliasing),
    );
    let lines = [
        format!("{} created (solid)", bytes_in_words(memory.created)),
        format!("{} without aliasing (dashed)", bytes_in_words(memory.without_aliasing)),
        format!("{} alive at most", bytes_in_words(memory.peak)),
        format!("{} bound: peaks of the classes", bytes_in_words(memory.bound)),
    ];
    for (at, line) in lines.iter().enumerate() {
        let _ = writeln!(out, "{}", text("small", [24, top + 26 + at * 16], line));
    }
    for (column, bytes) in memory.alive.iter().enumerate() {
        let _ =
            writeln!(out, "{}", text("small middle", [center(column), bottom + 16], &bytes_in_words(*bytes)));
    }
}

/// Truncates a string to at most `max` characters.
pub(super) fn shorten(text: &str, max: usize) -> String {
    let max = max.max(3);
    if text.chars().count() <= max {
        return text.to_owned();
    }
    text.chars().take(max - 1).chain(['…']).collect()
}

/// Escapes a string for XML and HTML, and replaces the control characters that XML forbids by visible escapes.
pub(super) fn escape(text: &str) -> String {
    visible(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Returns an SVG text element at a position in pixels.
fn text(class: &str, [x, y]: [usize; 2], words: &str) -> String {
    format!("<text class=\"{class}\" x=\"{x}\" y=\"{y}\">{}</text>", escape(words))
}
