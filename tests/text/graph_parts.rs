//! Parts of resources that are written and read, and buffers that share memory, on graphs made in code.

use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::{Assembly, Objective, Physical, PlanOptions, build, plan};
use umbragraph::low_level::language::{Expr, FormatCandidates, Lifetime};
use umbragraph::low_level::pipeline::{Aspect, IndexRange, SubresourceRange, Usage, Version};
use umbragraph::low_level::why::why_apart;

use crate::graph_orders::{compile, names, planned, rejected};

/// A pass that copies to bytes of a buffer, and one that reads bytes of it.
fn bytes(writes: &[SubresourceRange], read: SubresourceRange) -> Assembly {
    let mut assembly = Assembly::new("bytes");
    let buffer = assembly.buffer("a", 1024, Lifetime::Transient);
    for (at, range) in writes.iter().enumerate() {
        let pass = assembly.pass(&format!("w{at}"));
        let _ = pass.accesses(buffer, *range, Usage::CopyDestination, Version::Newest);
    }
    let pass = assembly.pass("read");
    let _ = pass.accesses(buffer, read, Usage::StorageRead, Version::Newest).side_effect();
    assembly
}

#[test]
fn writers_of_separate_bytes_need_no_order() {
    let halves = [SubresourceRange::bytes(0, 512), SubresourceRange::bytes(512, 512)];
    let plan = planned(bytes(&halves, SubresourceRange::bytes(256, 512)), Objective::Declaration);
    assert_eq!(names(&plan), ["w0", "w1", "read"]);
    let plan = planned(bytes(&halves, SubresourceRange::bytes(512, 256)), Objective::Declaration);
    assert_eq!(names(&plan), ["w1", "read"]);
}

#[test]
fn common_bytes_and_reads_beyond_the_buffer_are_rejected() {
    let common = [SubresourceRange::bytes(0, 516), SubresourceRange::bytes(512, 512)];
    assert_eq!(rejected(bytes(&common, SubresourceRange::WHOLE)), ["UG0402"]);
    assert_eq!(rejected(bytes(&[SubresourceRange::WHOLE], SubresourceRange::bytes(512, 1024))), ["UG0405"]);
    assert_eq!(
        rejected(bytes(&[SubresourceRange::bytes(0, 512)], SubresourceRange::bytes(512, 512))),
        ["UG0401"]
    );
}

/// The message about a read of a texture with four mips and three layers, of which these subresource ranges are
/// written.
fn message(format: &str, writes: &[SubresourceRange], read: SubresourceRange) -> String {
    let mut assembly = Assembly::new("pieces");
    let texture = assembly.texture_with("c", |texture| {
        texture.mips = Some(Expr::from(4.0));
        texture.layers = Some(Expr::from(3.0));
        texture.format = FormatCandidates::One(format.to_owned());
    });
    for (at, range) in writes.iter().enumerate() {
        let pass = assembly.pass(&format!("w{at}"));
        let _ = pass.accesses(texture, *range, Usage::CopyDestination, Version::Newest);
    }
    let _ = assembly.pass("read").reads_range(texture, read).side_effect();
    let (_, diagnostics) = compile(assembly, &PlanOptions::new(64, 64));
    diagnostics.iter().map(|one| format!("{} {}", one.code.id, one.message)).collect()
}

#[test]
fn a_partly_written_read_is_rejected_and_the_rest_named() {
    let unwritten =
        |pieces: &str| format!("UG0401 \"read\" reads {pieces} of \"c\", which nothing writes before");
    let mips = |mips: &[u32]| -> Vec<SubresourceRange> {
        mips.iter().map(|mip| SubresourceRange::of(Some(*mip), None)).collect()
    };
    let color = |writes: &[SubresourceRange], read: SubresourceRange| message("rgba8unorm", writes, read);
    assert_eq!(color(&mips(&[0, 2]), SubresourceRange::WHOLE), unwritten("mips 1 and 3"));
    assert_eq!(color(&mips(&[0, 1]), SubresourceRange::WHOLE), unwritten("mips 2 to 3"));
    assert_eq!(color(&mips(&[0, 1, 2, 3]), SubresourceRange::WHOLE), "");
    assert_eq!(
        color(&[SubresourceRange::of(None, Some(1))], SubresourceRange::WHOLE),
        unwritten("layers 0 and 2")
    );
    assert_eq!(color(&[SubresourceRange::of(None, Some(1))], SubresourceRange::of(Some(1), Some(1))), "");
    let corner = [SubresourceRange::of(Some(0), None), SubresourceRange::of(Some(1), Some(0))];
    assert_eq!(
        color(
            &corner,
            SubresourceRange { mip: Some(IndexRange { first: 0, count: 2 }), ..SubresourceRange::WHOLE }
        ),
        unwritten("layers 1 to 2 of mip 1")
    );
    assert_eq!(color(&corner, SubresourceRange::WHOLE), unwritten("layers 1 to 2 of mip 1 and mips 2 to 3"));
    let depth = [SubresourceRange::WHOLE.aspect(Aspect::DepthOnly)];
    assert_eq!(message("depth24plus-stencil8", &depth, SubresourceRange::WHOLE), unwritten("the stencil"));
    assert_eq!(message("depth24plus-stencil8", &depth, depth[0]), "");
    let stencil = SubresourceRange::WHOLE.aspect(Aspect::StencilOnly);
    assert_eq!(message("stencil8", &mips(&[0]), stencil), unwritten("mips 1 to 3"));
    let of_bytes = |writes: &[SubresourceRange], read: SubresourceRange| {
        let (_, diagnostics) = compile(bytes(writes, read), &PlanOptions::new(64, 64));
        diagnostics.iter().next().expect("a diagnostic").clone()
    };
    let every_other = |count: u64| {
        let writes: Vec<_> = (0..count).map(|at| SubresourceRange::bytes(8 * at, 4)).collect();
        of_bytes(&writes, SubresourceRange::bytes(0, 8 * count)).message
    };
    let seven = "4 to 7, 12 to 15, 20 to 23, 28 to 31, 36 to 39, 44 to 47, 52 to 55";
    let unwritten_bytes =
        |rest: &str| format!("\"read\" reads bytes {seven} and {rest} of \"a\", which nothing writes before");
    assert_eq!(every_other(8), unwritten_bytes("60 to 63"));
    assert_eq!(every_other(10), unwritten_bytes("3 more"));
    let diagnostic = of_bytes(&[SubresourceRange::bytes(0, 512)], SubresourceRange::bytes(256, 512));
    assert_eq!(diagnostic.message, "\"read\" reads bytes 512 to 767 of \"a\", which nothing writes before");
    assert!(
        diagnostic.help.as_deref().is_some_and(|help| help.contains("{ \"clear\": { \"buffer\": \"&a\" } }"))
    );
}

#[test]
fn persistent_culled_and_write_only_uses_may_be_partial() {
    let ranges = |lifetime: Lifetime, usage: Usage, is_live: bool| {
        let mut assembly = Assembly::new("parts");
        let buffer = assembly.buffer("a", 1024, lifetime);
        let range = SubresourceRange::bytes(0, 512);
        let _ = assembly.pass("write").accesses(buffer, range, Usage::CopyDestination, Version::Newest);
        let reader = assembly.pass("read").accesses(buffer, SubresourceRange::WHOLE, usage, Version::Newest);
        let _ = if is_live { reader.side_effect() } else { reader };
        let _ = assembly.pass("end").side_effect();
        let (plan, diagnostics) = compile(assembly, &PlanOptions::new(64, 64));
        (plan.is_some(), diagnostics.iter().map(|one| one.code.id).collect::<Vec<_>>())
    };
    use Lifetime::{Persistent, Transient};
    assert_eq!(ranges(Transient, Usage::StorageRead, true), (false, vec!["UG0401"]));
    assert_eq!(ranges(Transient, Usage::StorageRead, false), (true, vec![]));
    assert_eq!(ranges(Transient, Usage::StorageReadWrite, true), (false, vec!["UG0401"]));
    assert_eq!(ranges(Transient, Usage::CopyDestinationLoad, true), (false, vec!["UG0401"]));
    assert_eq!(ranges(Transient, Usage::StorageWrite, true), (true, vec![]));
    assert_eq!(ranges(Persistent, Usage::StorageRead, true), (true, vec!["UG0401"]), "a warning");
}

#[test]
fn a_size_of_the_viewport_decides_what_of_a_read_is_missing() {
    let mut assembly = Assembly::new("layers");
    let layers = assembly.texture_with("a", |texture| {
        texture.layers = Some(Expr::from("=floor(viewport.width / 64)"));
    });
    for layer in 0..2 {
        let _ =
            assembly.pass(&format!("w{layer}")).writes_range(layers, SubresourceRange::of(None, Some(layer)));
    }
    let _ = assembly.pass("read").reads(layers).side_effect();
    let (pipeline, sources) = assembly.finish();
    let mut diagnostics = Diagnostics::new();
    let graph = build(&pipeline, &mut diagnostics).expect("a graph");
    let two = plan(&pipeline, &graph, &PlanOptions::new(128, 64), &sources, &mut diagnostics);
    let two = two.unwrap_or_else(|| panic!("{diagnostics:#?}"));
    assert!(two.resized(&graph, &PlanOptions::new(191, 64), &sources).is_ok());
    let diagnostics = two.resized(&graph, &PlanOptions::new(256, 64), &sources).expect_err("two layers more");
    let messages: Vec<&str> = diagnostics.iter().map(|one| one.message.as_str()).collect();
    assert_eq!(messages, ["\"read\" reads layers 2 to 3 of \"a\", which nothing writes before"]);
}

/// A chain of passes over buffers of so many bytes: each is written by one and read by the next.
fn buffers(sizes: &[u32]) -> Assembly {
    let mut assembly = Assembly::new("buffers");
    let mut previous: Option<umbragraph::work::ResourceHandle> = None;
    for (at, bytes) in sizes.iter().enumerate() {
        let buffer = assembly.buffer(&format!("b{at}"), *bytes, Lifetime::Transient);
        let mut pass = assembly.pass(&format!("p{at}")).side_effect();
        if let Some(previous) = previous {
            pass = pass.accesses(previous, SubresourceRange::WHOLE, Usage::StorageRead, Version::Newest);
        }
        let _ = pass.accesses(buffer, SubresourceRange::WHOLE, Usage::StorageReplace, Version::Newest);
        previous = Some(buffer);
    }
    assembly
}

#[test]
fn buffers_share_up_to_the_same_power_of_two() {
    let plan = planned(buffers(&[1000, 64, 900]), Objective::Declaration);
    assert_eq!(plan.resources["b0"].physical, plan.resources["b2"].physical);
    assert_eq!((plan.buffers.len(), plan.bytes, plan.bytes_without_aliasing), (2, 1064, 1964));
    assert_eq!((plan.resources["b0"].bytes, plan.resources["b2"].bytes), (1000, 900));
    // 1025 bytes round up to 2048.
    let plan = planned(buffers(&[1000, 64, 1028]), Objective::Declaration);
    assert_eq!((plan.buffers.len(), plan.bytes), (3, 1000 + 64 + 1028));
    assert!(why_apart(&plan, "b0", "b2").iter().any(|reason| reason.contains("power of two")));
}

#[test]
fn a_buffer_is_as_large_as_the_largest_that_it_stands_for() {
    // All of one class: b0, b2 and b4 share one buffer, b1 and b3 the other.
    let plan = planned(buffers(&[600, 1000, 700, 520, 640]), Objective::Declaration);
    let bytes: Vec<u64> = plan.buffers.iter().map(|buffer| buffer.bytes).collect();
    assert_eq!((bytes, plan.bytes, plan.bytes_bound), (vec![700, 1000], 1700, 1700));
    // Two that are alive together have the bytes that they have apart, though their class goes to 1000.
    let plan = planned(buffers(&[520, 1000]), Objective::Declaration);
    assert_eq!((plan.bytes, plan.bytes_without_aliasing), (1520, 1520));
}

#[test]
fn each_class_of_buffers_has_as_many_as_are_alive_at_once() {
    let sizes: Vec<u32> = (0..200u32).map(|at| 4 * (1 + at.wrapping_mul(2_654_435_761) % 500)).collect();
    for objective in Objective::ALL {
        let plan = planned(buffers(&sizes), objective);
        let class = |bytes: u64| bytes.next_power_of_two();
        let mut classes: Vec<u64> = plan.buffers.iter().map(|buffer| class(buffer.bytes)).collect();
        classes.sort_unstable();
        classes.dedup();
        let mut bound = 0;
        for one in classes {
            let members = plan.resources.values().filter(|resource| class(resource.bytes) == one);
            let alive =
                |at: usize| members.clone().filter(|one| (one.first..=one.last).contains(&at)).count();
            let peak = (0..plan.passes.len()).map(alive).max();
            let created = plan.buffers.iter().filter(|buffer| class(buffer.bytes) == one);
            assert_eq!(Some(created.clone().count()), peak, "{one}");
            let alive = |at: usize| -> u64 {
                members.clone().filter(|one| (one.first..=one.last).contains(&at)).map(|one| one.bytes).sum()
            };
            bound += (0..plan.passes.len()).map(alive).max().unwrap_or(0);
        }
        for (index, buffer) in plan.buffers.iter().enumerate() {
            let aliases = plan.resources.values().filter(|one| one.physical == Physical::Buffer(index));
            assert_eq!(Some(buffer.bytes), aliases.map(|one| one.bytes).max(), "{}", buffer.label);
        }
        assert_eq!(plan.bytes_bound, bound);
        assert!(bound <= plan.bytes);
        assert!(plan.bytes < plan.bytes_without_aliasing);
    }
}
