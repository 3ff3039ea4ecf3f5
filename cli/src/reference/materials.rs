//! The contract of materials: what a template that lights surfaces may read, and what a host brings for it.
//!
//! The members come from the structs of the templates, each with the comment above it, so the page follows the
//! contract.

use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::source::Sources;

use super::markdown::table;
use super::page::{Entry, Page};

/// The structs of the interface between materials and lights: name, declaring template, and purpose.
const STRUCTS: [(&str, &str, &str); 6] = [
    (
        "Surface",
        "lib/surface.wgsl.jinja",
        "A point of a surface that a pixel shows. The block `surface` of `forward`, `lit`, `surfaces` and `deferred` may \
         read and change it; lights read it.",
    ),
    (
        "Reflection",
        "lib/reflection.wgsl.jinja",
        "Reflection of a surface beside its base color, with the axis `pbr`.",
    ),
    (
        "Material",
        "lib/scene_blocks.wgsl.jinja",
        "Factors of every material of a scene (group 2), beside `base_color_texture` and `base_color_sampler`.",
    ),
    (
        "MaterialDetail",
        "lib/scene_details.wgsl.jinja",
        "Factors of a whole material, with the axis `pbr`. Each map has a texture and a sampler of its name, such as \
         `normal_texture` and `normal_sampler`.",
    ),
    ("Object", "lib/scene_blocks.wgsl.jinja", "A placed mesh (group 3)."),
    (
        "Motion",
        "lib/scene_motion.wgsl.jinja",
        "The motion of a placed mesh (group 3), beside the vertex attribute `previous_position`: where joints and morph \
         targets had the vertex in the frame before. A host of other meshes replaces `lib/motion.wgsl.jinja`.",
    ),
];

pub(super) fn page() -> Page {
    let mut sources = Sources::new();
    let templates = umbragraph::templates(&mut sources, &mut Diagnostics::new());
    let text = |name: &str| {
        let file = templates.file(name).and_then(|file| sources.get(file));
        file.map_or_else(String::new, |file| file.text().to_string())
    };
    let mut entries: Vec<Entry> = (STRUCTS.iter())
        .map(|(name, template, about)| {
            let rows = members(&text(template), name);
            let from =
                format!("Declared by [{template}](templates.md#{}).", super::templates::anchor(template));
            let members = table(["member", "type", "meaning"], &rows);
            Entry {
                name: (*name).to_owned(),
                summary: (*about).to_owned(),
                text: format!("{about} {from}\n\n{members}"),
            }
        })
        .collect();
    let functions = super::templates::declarations(&text("lib/meshes.wgsl.jinja"), true);
    let about = "Functions that templates call for a material or an object. A host with other materials or objects \
        replaces `lib/meshes.wgsl.jinja` by a template that defines them.";
    entries.push(Entry {
        name: "MeshFunctions".to_owned(),
        summary: about.to_owned(),
        text: format!("{about}\n\n{}", table(["function", "meaning"], &functions)),
    });
    Page {
        name: "materials",
        title: "Materials",
        introduction: "The contract between a host's materials and the templates that light them. `scene/src/interface.rs` \
            lists each factor, texture and vertex attribute once; the blocks of the templates, the geometry of \
            `pipelines/base/scene_geometry.json` and this page follow from it.\n\n\
            A host with fewer values replaces `lib/meshes.wgsl.jinja`: it lists the vertex attributes that it has as \
            `attributes`, each a name and a type, and defines the functions below. A host with \
            whole materials of its own also replaces `lib/material.wgsl.jinja`, which defines `pbr_material`. A vertex \
            attribute is a member of `MeshData`, the parameter `data` of these functions.",
        entries,
    }
}

/// Returns the members of a struct in a template: name, type, and the comment above each.
fn members(text: &str, name: &str) -> Vec<[String; 3]> {
    let Some((_, body)) = text.split_once(&format!("struct {name} {{\n")) else { return Vec::new() };
    let (mut comment, mut rows) = (Vec::new(), Vec::new());
    for line in body.lines().take_while(|line| !line.starts_with('}')).map(str::trim) {
        if let Some(words) = line.strip_prefix("//") {
            comment.push(words.trim());
        } else if let Some((member, kind)) = line.split_once(": ").filter(|_| !line.starts_with('{')) {
            let code = |text: &str| format!("`{}`", text.trim_end_matches(','));
            rows.push([code(member), code(kind), comment.join(" ")]);
            comment.clear();
        }
    }
    rows
}
