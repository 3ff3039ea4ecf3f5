//! Reads of which only a subresource range was written.
//!
//! The [graph](crate::graph) knows which writes a read finds, but not how many mips, layers or bytes there are, so it
//! notes what those writes leave of each read, and here, where sizes are known, what is left that exists is a
//! diagnostic. It would hold what another resource left in the same memory.
//!
//! The same holds for what is written only with some toggle switched one way, for layers of earlier frames that are not
//! written in each frame in which others of the history are, which would be from some frame longer ago, and for the
//! bytes that a copy leaves between rows of texels and behind them, where something reads them.
//!
//! Persistent resources and earlier frames of histories hold what they held: there, what no pass writes in any frame is
//! a warning.
//!
//! A pass that also writes (an attachment that is loaded, storage that is read and written, a copy to a box) reads all
//! that it does not say to discard. A read with more writers than are [told apart](crate::regions::visible) has no
//! diagnostic.
//!
//! Cost: for each such read linear in the writes that it finds, and sorting them.

use std::collections::BTreeSet;

use crate::contents::LiveResources;
use crate::graph::conditions;
use crate::regions::{Effort, Extents, Left, Runs, View, Write, between, extents, joined};
use crate::resources::resolved::{Descriptor, ResolvedResources};
use crate::work::copies;

use umbragraph_pipeline::diagnostic::{Diagnostic, codes};
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::{Access, Condition, Located as _, ResourceKind, TypedPipeline, Usage};
use umbragraph_pipeline::work::PassHandle;

/// The maximum number of entries in a list of mips, layers or bytes in a diagnostic.
const SHOWN: usize = 8;
/// An upper limit on the number of mip levels, which no texture reaches.
const MAX_MIPS: u64 = 32;

/// The subresources of a read that exist in the resource. Ranges are first index and end (exclusive).
struct Wanted {
    mips: (u64, u64),
    /// The range of layers, of slices of mip 0 for a 3D texture, or of bytes for a buffer.
    run: (u64, u64),
    /// The number of depth slices of mip 0, which halves with each mip; `None` unless the texture is 3D.
    slices: Option<u64>,
    /// The aspects that are read: 0 for color or depth, 1 for stencil.
    aspects: Vec<u64>,
    is_buffer: bool,
}

/// Reports reads by live passes of contents that no pass has written.
pub(crate) fn check(live: LiveResources<'_, '_>, diagnostics: &mut Vec<Diagnostic>) {
    let LiveResources { resolved, graph, is_live } = live;
    for read in graph.partial.iter().filter(|read| is_live(read.reader)) {
        let pipeline = resolved.pipeline;
        let Some(one) = pipeline.pass(read.reader).accesses().get(read.at) else { continue };
        match &read.left {
            Left::Toggled(boxes) => {
                for (_, writer, place, condition) in boxes {
                    let same = boxes.iter().filter(|(_, by, _, on)| (by, on) == (writer, condition));
                    let same = same.map(|(extents, ..)| *extents).collect();
                    if let Some(pieces) = existing(resolved, one, &Left::Boxes(same)) {
                        let reader = read.reader;
                        diagnostics.push(conditions::taken_away(
                            pipeline, reader, one, *writer, *place, *condition, &pieces,
                        ));
                        break;
                    }
                }
            }
            Left::BetweenRows(boxes) => {
                let readers = graph.readers(read.reader, one.resource);
                for reader in readers.into_iter().filter(|reader| is_live(*reader)) {
                    diagnostics.extend(between_rows(resolved, read.reader, one, reader, boxes));
                }
            }
            left => {
                let pieces = existing(resolved, one, left);
                diagnostics.extend(pieces.map(|pieces| diagnostic(pipeline, read.reader, one, &pieces)));
            }
        }
    }
    check_earlier_frames(live, diagnostics);
    check_lasting(live, diagnostics);
}

/// Warns of reads of persistent resources and of earlier frames whose subresources no pass writes in any frame.
fn check_lasting(live: LiveResources<'_, '_>, diagnostics: &mut Vec<Diagnostic>) {
    let LiveResources { resolved, graph, is_live } = live;
    let pipeline = resolved.pipeline;
    for reader in pipeline.pass_handles().filter(|pass| is_live(*pass)) {
        for one in pipeline.pass(reader).accesses().iter().filter(|one| one.usage.reads()) {
            let resource = pipeline.resource(one.resource);
            let of = match (resource.lifetime(), resource.history) {
                (Lifetime::Persistent, _) => one.resource,
                (_, Some(history)) if history.back > 0 => history.of,
                _ => continue,
            };
            // A history that no pass writes at all has a warning of its own.
            let is_known = !pipeline.uncertain.contains(&of)
                && (of == one.resource || graph.versions_of(of).next().is_some());
            let mut effort = Effort::default();
            let mut view = View::new(one.range, &[], &mut effort);
            for (rank, (range, _)) in graph.versions_of(of).enumerate() {
                if view.is_covered() {
                    break;
                }
                view.cover(Write { range, condition: None, writer: rank, passes_on: false });
            }
            let unwritten = Left::Boxes(view.unwritten());
            let Some(pieces) = existing(resolved, one, &unwritten).filter(|_| is_known) else { continue };
            let (name, by) = (&resource.name, &pipeline.pass(reader).name);
            let pieces = if pieces.is_empty() { String::new() } else { format!("{pieces} of ") };
            let message = format!("\"{by}\" reads {pieces}\"{name}\", which no pass writes in any frame");
            let help = match of == one.resource {
                true => {
                    "it holds zeros: let a pass write it, or make it \"lifetime\": \"imported\" if the host fills it"
                }
                false => "it holds its initial value: let a pass write it",
            };
            let diagnostic = Diagnostic::warning(codes::NEVER_WRITTEN, one.place, message);
            let diagnostic = diagnostic.pointer(&one.pointer).help(help);
            diagnostics.push(diagnostic.related(resource.place, "declared here"));
        }
    }
}

/// Returns the existing subresources of an access that are in `left` (unwritten), in words. An empty string stands for
/// the full access; `None` means that nothing is unwritten or sizes are unknown.
pub(crate) fn existing(resolved: &ResolvedResources<'_>, one: &Access, left: &Left) -> Option<String> {
    let wanted = wanted(resolved, one)?;
    let gaps = gaps(&wanted, left);
    gaps.iter().any(|(_, _, runs)| !runs.is_empty()).then(|| pieces(&wanted, &gaps))
}

/// Reports reads of an earlier frame of a history that may find older contents, because a toggle keeps a pass from
/// writing some layers in that frame.
fn check_earlier_frames(live: LiveResources<'_, '_>, diagnostics: &mut Vec<Diagnostic>) {
    let LiveResources { resolved, graph, is_live } = live;
    let pipeline = resolved.pipeline;
    if pipeline.toggles.is_empty() {
        return;
    }
    for reader in pipeline.pass_handles().filter(|pass| is_live(*pass)) {
        for one in pipeline.pass(reader).accesses() {
            let history = pipeline.resource(one.resource).history.filter(|history| history.back > 0);
            let Some(history) = history.filter(|history| !pipeline.uncertain.contains(&history.of)) else {
                continue;
            };
            let writers: Vec<_> =
                graph.versions_of(history.of).filter(|(_, writer)| is_live(*writer)).collect();
            let condition = |writer: PassHandle| pipeline.pass(writer).condition;
            // A frame in which nothing writes it is none to the history.
            let frames: BTreeSet<_> = writers.iter().map(|(_, writer)| condition(*writer)).collect();
            let stale = frames.iter().find_map(|known| {
                let known: Vec<Condition> = known.iter().copied().collect();
                let mut effort = Effort::default();
                let mut view = View::new(one.range, &known, &mut effort);
                for (rank, (range, writer)) in writers.iter().enumerate().rev() {
                    let condition = condition(*writer);
                    view.cover(Write { range: *range, condition, writer: rank, passes_on: false });
                }
                view.toggled().into_iter().find_map(|(extents, rank, off)| {
                    Some((existing(resolved, one, &Left::Boxes(vec![extents]))?, rank, off))
                })
            });
            let Some((pieces, rank, off)) = stale else { continue };
            let writer = writers[rank].1;
            let pass = pipeline.pass(writer);
            let place = pass.writes_of(history.of).next().map_or(pass.place, |known| known.place);
            diagnostics.push(conditions::taken_away(pipeline, reader, one, writer, place, off, &pieces));
        }
    }
}

/// Returns the error if `reader` reads bytes that `copy` leaves between its rows of texels. `boxes` holds the bytes
/// that nothing filled before the copy.
fn between_rows(
    resolved: &ResolvedResources<'_>,
    copy: PassHandle,
    written: &Access,
    reader: PassHandle,
    boxes: &[Extents],
) -> Option<Diagnostic> {
    let pipeline = resolved.pipeline;
    let rows = copies::runs_of_rows(resolved, copy)?;
    let read_rows = copies::runs_of_rows(resolved, reader);
    for one in pipeline.pass(reader).accesses() {
        if one.resource != written.resource || !one.usage.reads() || one.usage.keeps_what_is_there() {
            continue;
        }
        let (wanted, own) = (wanted(resolved, one)?, wanted(resolved, written)?);
        let read = read_rows.clone().unwrap_or_else(|| vec![wanted.run]);
        let mut unfilled = Runs::new();
        for [.., bytes] in boxes {
            unfilled.extend(between(&rows, (bytes.0.max(own.run.0), bytes.1.min(own.run.1))));
        }
        let unfilled = joined(unfilled);
        let missing = joined(
            read.iter()
                .flat_map(|(first, end)| unfilled.iter().map(move |run| (run.0.max(*first), run.1.min(*end))))
                .collect(),
        );
        if missing.is_empty() {
            continue;
        }
        let (name, by) = (&pipeline.pass(reader).name, &pipeline.pass(copy).name);
        let resource = &pipeline.resource(written.resource).name;
        let bytes = counted("byte", &missing);
        let message = format!(
            "\"{name}\" reads {bytes} of \"{resource}\", which \"{by}\" leaves beside its rows of texels"
        );
        let help = format!(
            "fill the buffer before \"{by}\" ({{ \"clear\": {{ \"buffer\": \"&{resource}\" }} }}), choose rows of a multiple of \
             256 bytes that fill it, or let \"{name}\" read less with \"offset\" and \"size\""
        );
        let diagnostic = one.error(codes::NEVER_WRITTEN, message);
        return Some(diagnostic.related(written.place, format!("\"{by}\" writes rows here")).help(help));
    }
    None
}

/// Returns the subresources of an access that exist in the resource; `None` if the resource has no resolved descriptor.
fn wanted(resolved: &ResolvedResources<'_>, one: &Access) -> Option<Wanted> {
    let [mips, layers, aspects, bytes] = extents(one.range);
    let within = |run: (u64, u64), count: u64| (run.0, run.1.min(count));
    Some(match resolved.get(one.resource)?.descriptor? {
        Descriptor::Texture(texture) => {
            let of_format: &[u64] =
                match (texture.format.has_depth_aspect(), texture.format.has_stencil_aspect()) {
                    (true, true) => &[0, 1],
                    (false, true) => &[1],
                    _ => &[0],
                };
            Wanted {
                mips: within(mips, u64::from(texture.size.mips).min(MAX_MIPS)),
                run: within(layers, texture.size.layers.into()),
                slices: texture.volume.then_some(texture.size.layers.into()),
                aspects: of_format.iter().copied().filter(|at| aspects.0 <= *at && *at < aspects.1).collect(),
                is_buffer: false,
            }
        }
        Descriptor::Buffer { bytes: count, .. } => Wanted {
            mips: (0, 1),
            run: within(bytes, count),
            slices: None,
            aspects: vec![0],
            is_buffer: true,
        },
    })
}

impl Wanted {
    /// Returns the layers, slices or bytes that are read of one mip level, as first index and end (exclusive).
    fn run_of(&self, mip: u64) -> (u64, u64) {
        let end = self.slices.map_or(u64::MAX, |slices| (slices >> mip).max(1));
        (self.run.0, self.run.1.min(end))
    }
}

/// Returns the unwritten runs of layers, slices or bytes for each mip level and aspect, as `(mip, aspect, runs)`.
fn gaps(wanted: &Wanted, left: &Left) -> Vec<(u64, u64, Runs)> {
    let mips = wanted.mips.0..wanted.mips.1;
    let each = || mips.clone().flat_map(|mip| wanted.aspects.iter().map(move |aspect| (mip, *aspect)));
    match left {
        Left::Boxes(boxes) => {
            let runs = |mip: u64, aspect: u64| {
                let all = wanted.run_of(mip);
                let here = boxes.iter().filter(|[mips, _, aspects, _]| {
                    mips.0 <= mip && mip < mips.1 && aspects.0 <= aspect && aspect < aspects.1
                });
                let runs = here.map(|[_, layers, _, bytes]| {
                    let run = if wanted.is_buffer { bytes } else { layers };
                    (run.0.max(all.0), run.1.min(all.1))
                });
                joined(runs.collect())
            };
            each().map(|(mip, aspect)| (mip, aspect, runs(mip, aspect))).collect()
        }
        Left::Toggled(_) | Left::BetweenRows(_) => Vec::new(),
        Left::AllBut(ranges) => {
            let mut everywhere = Runs::new();
            let mut of_mip: Vec<Runs> = vec![Runs::new(); wanted.mips.1 as usize];
            for range in ranges {
                let [mips, layers, ..] = extents(*range);
                if range.mip.is_none() {
                    everywhere.push(layers);
                } else if let Some(runs) = of_mip.get_mut(mips.0 as usize) {
                    runs.push(layers);
                }
            }
            let everywhere = joined(everywhere);
            let written = |mip: u64| {
                let own = of_mip.get(mip as usize).into_iter().flatten();
                joined(own.chain(&everywhere).copied().collect())
            };
            each().map(|(mip, aspect)| (mip, aspect, between(&written(mip), wanted.run_of(mip)))).collect()
        }
    }
}

/// Returns the unwritten subresources in words. Mip levels with the same unwritten runs are named together.
fn pieces(wanted: &Wanted, gaps: &[(u64, u64, Runs)]) -> String {
    // What of a mip is missing: by aspect the ranges, none of which means all.
    type Shape = Vec<(u64, Option<Runs>)>;
    let mut groups: Vec<(Shape, Runs)> = Vec::new();
    for mip in wanted.mips.0..wanted.mips.1 {
        let of_mip = gaps.iter().filter(|(at, _, runs)| *at == mip && !runs.is_empty());
        let shape: Shape = of_mip
            .map(|(_, aspect, runs)| (*aspect, (runs[..] != [wanted.run_of(mip)]).then(|| runs.clone())))
            .collect();
        if shape.is_empty() {
            continue;
        }
        match groups.iter_mut().find(|(known, _)| *known == shape) {
            Some((_, mips)) => mips.push((mip, mip + 1)),
            None => groups.push((shape, vec![(mip, mip + 1)])),
        }
    }
    let mut words = Vec::new();
    for (shape, mips) in groups {
        let mips = joined(mips);
        let of_mips = (mips[..] != [wanted.mips]).then(|| counted("mip", &mips));
        let alike =
            shape.len() == wanted.aspects.len() && shape.windows(2).all(|pair| pair[0].1 == pair[1].1);
        for (aspect, runs) in shape.into_iter().take(if alike { 1 } else { usize::MAX }) {
            let aspect = (!alike).then(|| ["the depth", "the stencil"][aspect.min(1) as usize].to_owned());
            let unit = match (wanted.is_buffer, wanted.slices.is_some()) {
                (true, _) => "byte",
                (_, true) => "slice",
                _ => "layer",
            };
            let runs = runs.map(|runs| counted(unit, &runs));
            let one: Vec<String> = [aspect, runs, of_mips.clone()].into_iter().flatten().collect();
            words.extend((!one.is_empty()).then(|| one.join(" of ")));
        }
    }
    listed(words)
}

/// Returns a unit and index runs in words, such as `mips 1 and 3 to 5`.
fn counted(unit: &str, runs: &[(u64, u64)]) -> String {
    let several = runs.len() > 1 || runs.iter().any(|(first, end)| end - first > 1);
    let one = |(first, end): &(u64, u64)| match end - first {
        1 => first.to_string(),
        _ => format!("{first} to {}", end - 1),
    };
    format!("{unit}{} {}", if several { "s" } else { "" }, listed(runs.iter().map(one).collect()))
}

/// Joins entries with commas and "and". A list of more than `SHOWN` entries is cut and ends with the number of the
/// rest.
fn listed(mut words: Vec<String>) -> String {
    if words.len() > SHOWN {
        let more = words.len() - (SHOWN - 1);
        words.truncate(SHOWN - 1);
        words.push(format!("{more} more"));
    }
    match words.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

fn diagnostic(pipeline: &TypedPipeline, reader: PassHandle, one: &Access, pieces: &str) -> Diagnostic {
    let resource = pipeline.resource(one.resource);
    let (pass, name) = (&pipeline.pass(reader).name, &resource.name);
    let of = if pieces.is_empty() { String::new() } else { format!("{pieces} of ") };
    let verb = if one.usage.writes() { "loads" } else { "reads" };
    let message = format!("\"{pass}\" {verb} {of}\"{name}\", which nothing writes before");
    let help = match &resource.kind {
        ResourceKind::Buffer(_) if one.usage == Usage::StorageReadWrite => format!(
            "fill the buffer first ({{ \"clear\": {{ \"buffer\": \"&{name}\" }} }}), bind what is written only, with \"offset\" and \
             \"size\", or say that nothing of it is needed: \"contents\": \"discard\""
        ),
        ResourceKind::Buffer(_) => format!(
            "write all that is read, fill the buffer first ({{ \"clear\": {{ \"buffer\": \"&{name}\" }} }}), or read \
             fewer bytes with \"offset\" and \"size\""
        ),
        _ => format!(
            "write the rest too, read what is written alone ({{ \"texture\": {{ \"name\": \"&{name}\", \"mip\": 0 }} }}, or \
             \"layer\" or \"aspect\"), or give \"{name}\" fewer"
        ),
    };
    one.error(codes::NEVER_WRITTEN, message).related(resource.place, "declared here").help(help)
}
