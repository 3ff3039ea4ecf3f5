//! Violations planted in planned copies.

use umbragraph::Plan;
use umbragraph::low_level::compiler::{Assembly, PlannedCopy, TexelOrigin, TexelRows};
use umbragraph::low_level::language::{Expr, FormatCandidates, Lifetime, TextureDeclaration};
use umbragraph::low_level::pipeline::{Aspect, IndexRange, SubresourceRange, Usage, Version};
use umbragraph::work::{BufferRegion, TextureRegion, TransferEnd};
use umbragraph_verify::{ViolationKind, verify};

use crate::checker::{kinds, options, pass, pipeline, planned};

/// A plan that copies two mips of two layers, the stencil of a texture to rows of a buffer, and bytes.
fn copies() -> Plan {
    let mut assembly = Assembly::new("copies");
    let layered = |texture: &mut TextureDeclaration| {
        texture.size = Expr(serde_json::json!([64, 64]));
        texture.layers = Some(Expr::from(4.0));
        texture.mips = Some(Expr::from(3.0));
    };
    let [from, to] = ["from", "to"].map(|name| assembly.texture_with(name, layered));
    let mask = assembly.texture_with("mask", |texture| {
        texture.format = FormatCandidates::One("depth24plus-stencil8".to_owned());
        texture.size = Expr(serde_json::json!([64, 64]));
    });
    let [rows, bytes] =
        ["rows", "bytes"].map(|name| assembly.buffer(name, 64 * 256 + 512, Lifetime::Transient));
    let texture = |assembly: &Assembly, resource, range| {
        let texture = assembly.subresource(resource, range);
        TransferEnd::Texture(TextureRegion { texture, origin: None })
    };
    let texels = |assembly: &Assembly, resource, layer: u32| {
        let (mip, layer) =
            (Some(IndexRange { first: 1, count: 2 }), Some(IndexRange { first: layer, count: 2 }));
        texture(assembly, resource, SubresourceRange { mip, layer, ..SubresourceRange::WHOLE })
    };
    let buffer = |assembly: &Assembly, resource, first: u64, count: u64| {
        let buffer = assembly.subresource(resource, SubresourceRange::bytes(first, count));
        TransferEnd::Buffer(BufferRegion { buffer, bytes_per_row: None, rows_per_image: None })
    };
    let whole = SubresourceRange { mip: Some(IndexRange::one(0)), ..SubresourceRange::WHOLE };
    let _ = assembly.pass("fill").writes(from);
    let _ = assembly
        .pass("mark")
        .accesses(mask, whole.aspect(Aspect::DepthOnly), Usage::DepthAttachment, Version::Newest)
        .accesses(mask, whole.aspect(Aspect::StencilOnly), Usage::StencilAttachment, Version::Newest);
    let (source, destination) = (texels(&assembly, from, 0), texels(&assembly, to, 2));
    let _ = assembly.pass("move").copies(Some(source), destination, Usage::CopyDestination);
    let stencil = texture(&assembly, mask, whole.aspect(Aspect::StencilOnly));
    let destination = buffer(&assembly, rows, 512, 64 * 256);
    let blank = buffer(&assembly, rows, 512, 64 * 256);
    let _ = assembly.pass("blank").copies(None, blank, Usage::CopyDestination);
    let _ = assembly.pass("rows").copies(Some(stencil), destination, Usage::CopyDestinationRows);
    let destination = buffer(&assembly, bytes, 0, 256);
    let _ = assembly.pass("zero").copies(None, destination, Usage::CopyDestination);
    let (moved, destination) = (buffer(&assembly, rows, 512, 256), buffer(&assembly, bytes, 256, 256));
    let _ = assembly.pass("bytes").copies(Some(moved), destination, Usage::CopyDestination);
    let range = |first| SubresourceRange {
        mip: Some(IndexRange { first: 1, count: 2 }),
        ..SubresourceRange::of(None, Some(first))
    };
    let end = assembly.pass("end").side_effect().reads_range(to, range(3));
    let _ = end.accesses(bytes, SubresourceRange::bytes(0, 512), Usage::StorageRead, Version::Newest);
    planned(assembly)
}

#[track_caller]
fn caught_in_a_copy(plant: impl FnOnce(&mut Plan)) {
    let mut plan = copies();
    assert_eq!(verify(&plan, &options()), Vec::new(), "before anything is planted");
    plant(&mut plan);
    let violations = verify(&plan, &options());
    assert!(kinds(&violations).contains(&ViolationKind::CopyWrong), "{violations:#?}");
}

/// The subresource range that a transfer says that it reads, or writes.
fn range_of<'a>(plan: &'a mut Plan, name: &str, written: bool) -> &'a mut SubresourceRange {
    let handle = plan.pipeline.find_pass(name).expect("a pass").index();
    let accesses = pipeline(plan).passes[handle].tamper().1;
    &mut accesses.iter_mut().find(|one| one.usage.writes() == written).expect("an access").range
}

#[test]
fn a_copy_of_other_mips_than_its_access_is_caught() {
    caught_in_a_copy(|plan| range_of(plan, "move", false).mip = Some(IndexRange { first: 0, count: 3 }));
}

#[test]
fn a_copy_to_other_layers_than_its_access_is_caught() {
    caught_in_a_copy(|plan| range_of(plan, "move", true).layer = Some(IndexRange { first: 0, count: 4 }));
}

#[test]
fn a_copy_of_another_aspect_than_its_access_is_caught() {
    caught_in_a_copy(|plan| range_of(plan, "rows", false).aspect = Aspect::All);
}

#[test]
fn a_copy_to_more_bytes_than_its_access_is_caught() {
    caught_in_a_copy(|plan| {
        range_of(plan, "bytes", true).bytes = Some(IndexRange { first: 384, count: 128 });
    });
}

#[test]
fn a_copy_whose_access_is_forgotten_is_caught() {
    caught_in_a_copy(|plan| {
        let handle = plan.pipeline.find_pass("bytes").expect("a pass").index();
        pipeline(plan).passes[handle].tamper().1.remove(0);
    });
}

#[test]
fn a_planned_copy_of_another_mip_layer_or_box_is_caught() {
    let plants: [fn(&mut PlannedCopy); 4] = [
        |copy| edit(copy, |from, _| from.mip = 0),
        |copy| edit(copy, |from, _| from.at[2] = 1),
        |copy| edit(copy, |_, extent| extent[0] = 16),
        |copy| edit(copy, |_, extent| extent[2] = 1),
    ];
    for plant in plants {
        caught_in_a_copy(|plan| plant(&mut pass(plan, "move").copies[0]));
    }
}

fn edit(copy: &mut PlannedCopy, change: impl FnOnce(&mut TexelOrigin, &mut [u32; 3])) {
    match copy {
        PlannedCopy::Texels { from, extent, .. } | PlannedCopy::Download { from, extent, .. } => {
            change(from, extent);
        }
        _ => panic!("no texels"),
    }
}

#[test]
fn a_planned_copy_left_out_or_made_twice_is_caught() {
    caught_in_a_copy(|plan| {
        pass(plan, "move").copies.pop();
    });
    caught_in_a_copy(|plan| {
        let again = pass(plan, "zero").copies[0];
        pass(plan, "zero").copies.push(again);
    });
}

#[test]
fn planned_rows_of_texels_at_other_bytes_are_caught() {
    let plants: [fn(&mut TexelRows); 3] =
        [|rows| rows.offset = 0, |rows| rows.bytes_per_row = 512, |rows| rows.rows_per_image = 8];
    for plant in plants {
        caught_in_a_copy(|plan| match &mut pass(plan, "rows").copies[0] {
            PlannedCopy::Download { to, .. } => plant(to),
            _ => panic!("no rows"),
        });
    }
    caught_in_a_copy(|plan| {
        edit(&mut pass(plan, "rows").copies[0], |from, _| from.aspect = Aspect::DepthOnly);
    });
}

#[test]
fn a_planned_copy_of_other_bytes_is_caught() {
    caught_in_a_copy(|plan| {
        pass(plan, "bytes").copies[0] = PlannedCopy::Bytes { from: 0, to: 256, bytes: 256 };
    });
}
