//! Reads of which nothing, a subresource range or all was written: random writers and readers of random subresource
//! ranges of textures with mips and layers, of volumes, of depth and stencil, and of buffers. The oracle looks at each
//! piece that exists by itself.

use std::collections::BTreeSet;
use std::sync::Arc;

use proptest::prelude::*;
use umbragraph_test_support::property;

use crate::{ViolationKind, verify};
use umbragraph_compiler::{Assembly, PlanOptions, build, plan};
use umbragraph_pipeline::diagnostic::{Diagnostics, codes};
use umbragraph_pipeline::language::{Expr, FormatCandidates, Lifetime, TextureShape};
use umbragraph_pipeline::pipeline::{Aspect, IndexRange, SubresourceRange, TypedPipeline, Usage, Version};
use umbragraph_pipeline::source::Sources;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Layered,
    Volume,
    DepthStencil,
    Buffer,
}

/// A random subresource range, of which each kind of resource uses the dimensions that it has.
#[derive(Clone, Copy, Debug)]
struct RandomRange {
    mips: Option<(u32, u32)>,
    layers: Option<(u32, u32)>,
    aspect: usize,
    words: Option<(u64, u64)>,
}

#[derive(Clone, Debug)]
struct RandomAccess {
    range: RandomRange,
    toggle: Option<(usize, bool)>,
    /// The index of the writer whose version a reader reads; the newest version if `None` or if there are fewer
    /// writers.
    version: Option<usize>,
    /// Whether a reader has a side effect, so that it is not culled.
    is_live: bool,
}

const TOGGLES: usize = 2;
const MIPS: u32 = 3;
const LAYERS: u32 = 4;
const WORDS: u64 = 6;

/// One piece of a resource: a mip, a layer or depth slice, an aspect and a four-byte word.
type Piece = (u32, u32, usize, u64);

fn pieces(kind: Kind) -> Vec<Piece> {
    let (mips, layers, aspects, words) = match kind {
        Kind::Layered | Kind::Volume => (MIPS, LAYERS, 1, 1),
        Kind::DepthStencil => (1, LAYERS, 2, 1),
        Kind::Buffer => (1, 1, 1, WORDS),
    };
    let mut all = Vec::new();
    for mip in 0..mips {
        let layers = if kind == Kind::Volume { layers >> mip } else { layers };
        for layer in 0..layers {
            all.extend((0..aspects).flat_map(|at| (0..words).map(move |word| (mip, layer, at, word))));
        }
    }
    all
}

impl RandomRange {
    fn of(self, kind: Kind) -> SubresourceRange {
        const ASPECTS: [Aspect; 3] = [Aspect::All, Aspect::DepthOnly, Aspect::StencilOnly];
        let run = |run: Option<(u32, u32)>, of: u32| {
            run.map(|(first, count)| IndexRange { first: first % of, count: count.min(of - first % of) })
        };
        match kind {
            Kind::Layered => SubresourceRange {
                mip: run(self.mips, MIPS),
                layer: run(self.layers, LAYERS),
                ..SubresourceRange::WHOLE
            },
            Kind::Volume => {
                let mip = run(self.mips, MIPS);
                let slices = LAYERS >> mip.map_or(0, |run| run.first);
                SubresourceRange { mip, layer: run(self.layers, slices), ..SubresourceRange::WHOLE }
            }
            Kind::DepthStencil => {
                SubresourceRange { layer: run(self.layers, LAYERS), ..SubresourceRange::WHOLE }
                    .aspect(ASPECTS[self.aspect])
            }
            Kind::Buffer => self.words.map_or(SubresourceRange::WHOLE, |(first, count)| {
                SubresourceRange::bytes(first * 4, count.min(WORDS - first) * 4)
            }),
        }
    }
}

fn has(range: SubresourceRange, (mip, layer, aspect, word): Piece) -> bool {
    let within = |run: Option<IndexRange<u32>>, at: u32| {
        run.is_none_or(|run| (run.first..run.first + run.count).contains(&at))
    };
    let bytes = range.bytes.is_none_or(|run| (run.first..run.first + run.count).contains(&(word * 4)));
    let other = [Aspect::StencilOnly, Aspect::DepthOnly][aspect];
    within(range.mip, mip) && within(range.layer, layer) && range.aspect != other && bytes
}

/// Makes a pipeline of random writers and readers; `begins` adds a first pass that writes everything.
fn pipeline(
    kind: Kind,
    writers: &[RandomAccess],
    readers: &[RandomAccess],
    begins: bool,
) -> (Arc<TypedPipeline>, Sources) {
    let mut assembly = Assembly::new("uninitialised");
    let resource = match kind {
        Kind::Buffer => assembly.buffer("a", WORDS as u32 * 4, Lifetime::Transient),
        _ => assembly.texture_with("a", |texture| {
            texture.layers = Some(Expr::from("=floor(viewport.width / 16)"));
            texture.mips = (kind != Kind::DepthStencil).then(|| Expr::from(f64::from(MIPS)));
            if kind == Kind::DepthStencil {
                texture.format = FormatCandidates::One("depth24plus-stencil8".to_owned());
            }
            texture.view_dimension =
                Some(if kind == Kind::Volume { TextureShape::D3 } else { TextureShape::D2Array });
        }),
    };
    let (read, write) = match kind {
        Kind::Layered | Kind::Volume => (Usage::Sampled, Usage::StorageReplace),
        Kind::DepthStencil => (Usage::Sampled, Usage::CopyDestination),
        Kind::Buffer => (Usage::StorageRead, Usage::StorageReplace),
    };
    for at in 0..TOGGLES {
        assembly.toggle(&format!("t{at}"));
    }
    let mut last = None;
    if begins {
        let pass = assembly.pass("begin").accesses(resource, SubresourceRange::WHOLE, write, Version::Newest);
        last = Some(pass.handle());
    }
    for (at, writer) in writers.iter().enumerate() {
        let mut pass = assembly.pass(&format!("w{at}"));
        if let Some(last) = last {
            pass = pass.after(last);
        }
        if let Some((toggle, on)) = writer.toggle {
            pass = pass.toggle(toggle, on);
        }
        last = Some(pass.accesses(resource, writer.range.of(kind), write, Version::Newest).handle());
    }
    for (at, reader) in readers.iter().enumerate() {
        let mut pass = assembly.pass(&format!("r{at}"));
        if reader.is_live {
            pass = pass.side_effect();
        }
        if let Some((toggle, on)) = reader.toggle {
            pass = pass.toggle(toggle, on);
        }
        let version = reader.version.filter(|version| *version < writers.len());
        let version = version.map_or(Version::Newest, |version| Version::WrittenBy(format!("w{version}")));
        let _ = pass.accesses(resource, reader.range.of(kind), read, version);
    }
    // Something has to be kept.
    let _ = assembly.pass("end").side_effect();
    assembly.finish()
}

/// Returns the number of pieces read that no earlier writer writes in any frame with the reader, and the number of
/// other pieces read.
fn uninitialised_and_written(kind: Kind, writers: &[RandomAccess], reader: &RandomAccess) -> (usize, usize) {
    let earlier =
        reader.version.filter(|version| *version < writers.len()).map_or(writers.len(), |at| at + 1);
    let meet = |writer: &&RandomAccess| match (writer.toggle, reader.toggle) {
        (Some((a, on)), Some((b, also))) => a != b || on == also,
        _ => true,
    };
    let earlier: Vec<SubresourceRange> =
        writers[..earlier].iter().filter(meet).map(|one| one.range.of(kind)).collect();
    let read = pieces(kind).into_iter().filter(|piece| has(reader.range.of(kind), *piece));
    let (written, uninitialised): (Vec<_>, Vec<_>) =
        read.partition(|piece| earlier.iter().any(|range| has(*range, *piece)));
    (uninitialised.len(), written.len())
}

fn accesses(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<RandomAccess>> {
    let toggle = || proptest::option::weighted(0.3, (0..TOGGLES, any::<bool>()));
    let range = (
        proptest::option::of((0u32..4, 1u32..4)),
        proptest::option::of((0u32..4, 1u32..5)),
        0usize..3,
        proptest::option::weighted(0.8, (0..WORDS, 1..WORDS)),
    )
        .prop_map(|(mips, layers, aspect, words)| RandomRange { mips, layers, aspect, words });
    let one = (range, toggle(), proptest::option::weighted(0.3, 0usize..6), proptest::bool::weighted(0.9))
        .prop_map(|(range, toggle, version, is_live)| RandomAccess { range, toggle, version, is_live });
    proptest::collection::vec(one, count)
}

fn kind() -> impl Strategy<Value = Kind> {
    prop_oneof![Just(Kind::Layered), Just(Kind::Volume), Just(Kind::DepthStencil), Just(Kind::Buffer)]
}

fn check(kind: Kind, writers: &[RandomAccess], readers: &[RandomAccess]) -> Result<(), TestCaseError> {
    let options = PlanOptions::new(64, 64);
    let (whole, sources) = pipeline(kind, writers, readers, false);
    let mut diagnostics = Diagnostics::new();
    let planned = build(&whole, &mut diagnostics)
        .and_then(|graph| plan(&whole, &graph, &options, &sources, &mut diagnostics));
    // What some states take away has a diagnostic of its own.
    let found = |of: &umbragraph_pipeline::diagnostic::Code| -> BTreeSet<String> {
        let those = diagnostics.iter().filter(|one| one.code.id == of.id);
        those.filter_map(|one| Some(one.message.split('"').nth(1)?.to_owned())).collect()
    };
    let (uninitialised, taken_away) = (found(&codes::NEVER_WRITTEN), found(&codes::TOGGLED_AWAY));
    prop_assert!(
        diagnostics
            .iter()
            .all(|one| [codes::NEVER_WRITTEN.id, codes::TOGGLED_AWAY.id].contains(&one.code.id)),
        "{diagnostics:#?}"
    );
    for (at, reader) in readers.iter().enumerate() {
        let name = format!("r{at}");
        let (missing, there) = uninitialised_and_written(kind, writers, reader);
        let rejected = missing > 0 && (reader.is_live || there == 0);
        // Slices that a mip does not have may hide that nothing at all is there.
        let is_hidden = kind == Kind::Volume && there == 0 && !reader.is_live;
        if !taken_away.contains(&name) && !is_hidden {
            prop_assert_eq!(uninitialised.contains(&name), rejected, "{} of {:#?}", name, diagnostics);
        }
    }
    if let Some(planned) = planned.filter(|_| !diagnostics.has_errors()) {
        prop_assert_eq!(verify(&planned, &options), Vec::new());
    }
    // The same with a first write of everything, which is then taken out of the plan.
    let (written, sources) = pipeline(kind, writers, readers, true);
    let mut diagnostics = Diagnostics::new();
    let planned = build(&written, &mut diagnostics)
        .and_then(|graph| plan(&written, &graph, &options, &sources, &mut diagnostics));
    let mut planned = planned.unwrap_or_else(|| panic!("{diagnostics:#?}"));
    prop_assert_eq!(verify(&planned, &options), Vec::new());
    Arc::make_mut(&mut planned.pipeline).passes[0].tamper().1.clear();
    let violations = verify(&planned, &options);
    for (at, reader) in readers.iter().enumerate() {
        let message = format!("\"r{at}\" reads a subresource range of \"a\" that nothing has written");
        let (missing, there) = uninitialised_and_written(kind, writers, reader);
        let found = violations
            .iter()
            .any(|one| one.kind == ViolationKind::UninitialisedRead && one.message == message);
        if kind != Kind::Volume || there > 0 {
            prop_assert_eq!(
                found,
                reader.is_live && missing > 0 && there > 0,
                "r{} of {:#?}",
                at,
                violations
            );
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(property::config(512))]

    #[test]
    fn only_reads_of_unwritten_pieces_are_rejected(
        kind in kind(), writers in accesses(0..8), readers in accesses(1..4)
    ) {
        check(kind, &writers, &readers)?;
    }
}

/// Returns an access to mips and layers of a layered texture, each as first and count; `None` for all.
fn layered(mips: Option<(u32, u32)>, layers: Option<(u32, u32)>) -> RandomAccess {
    let range = RandomRange { mips, layers, aspect: 0, words: None };
    RandomAccess { range, toggle: None, version: None, is_live: true }
}

#[test]
fn two_writers_that_cover_a_read_keep_nothing_older() {
    let writers = [layered(None, Some((3, 1))), layered(None, Some((2, 1)))];
    check(Kind::Layered, &writers, &[layered(None, Some((2, 2)))])
        .unwrap_or_else(|failure| panic!("{failure}"));
}

#[test]
fn a_newer_write_of_the_read_mip_hides_older_ones() {
    let writers = [layered(None, Some((1, 1))), layered(Some((0, 1)), Some((1, 1)))];
    check(Kind::Layered, &writers, &[layered(Some((0, 1)), None)])
        .unwrap_or_else(|failure| panic!("{failure}"));
}
