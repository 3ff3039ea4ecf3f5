//! The draw contract: how the host's meshes get into a pass.
//!
//! The pipeline's `geometry` says what a template may want. The host says here, once and without a device, how it
//! stores that: a [`HostInterface`] with vertex buffers, blocks with their members' offsets, and the combinations of
//! mesh properties that occur. The module checks it against every shader that draws it, builds all pipelines and bind
//! groups, and at record time hands the host a `DrawPass` for each view: the host binds its vertex buffers and issues
//! draws, choosing properties, material and object by number.
//!
//! Conventions: bind group 2 is the material, one bind group for each of the host's materials; bind group 3 is the
//! object, one bind group in all, whose blocks are moved by a dynamic offset of a fixed stride for each object. Front
//! faces are counter-clockwise.

use crate::data::ValueType;
use crate::diagnostic::{Diagnostic, Related};

/// The property under which a mesh is drawn from both sides. It changes no shader unless a template has an axis of
/// that name; the rasteriser's culling is switched off for it.
pub const DOUBLE_SIDED: &str = "double_sided";

/// The bind group of what a material has.
pub const MATERIAL_GROUP: u32 = 2;

/// The bind group of what an object has; it and those before, from [`MATERIAL_GROUP`] on, are the host's.
pub const OBJECT_GROUP: u32 = 3;

/// A host's storage of a `geometry` of a pipeline.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HostInterface {
    /// The vertex buffers; the position is the slot that the host binds them to.
    pub vertex_buffers: Vec<HostVertexBuffer>,
    /// The bindings of bind group 2, by name.
    pub material: Vec<HostSlot>,
    /// The bindings of bind group 3, by name.
    pub object: Vec<HostSlot>,
    /// The names of mesh properties, such as `alpha_masked`; a [`PropertySet`] is a set of positions here.
    pub properties: Vec<String>,
    /// The combinations of properties that occur; pipelines are built for these.
    pub property_sets: Vec<PropertySet>,
}

/// A set of mesh properties, as positions in [`HostInterface::properties`]: bit 0 is the first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PropertySet(pub u32);

impl HostInterface {
    /// The names of the properties of a set.
    pub fn property_names(&self, set: PropertySet) -> Vec<&str> {
        let in_set = |at: usize| at < 32 && set.0 & (1 << at) != 0;
        self.properties
            .iter()
            .enumerate()
            .filter(|(at, _)| in_set(*at))
            .map(|(_, name)| name.as_str())
            .collect()
    }

    /// The vertex attribute of a name: its slot and itself.
    pub fn attribute(&self, name: &str) -> Option<(usize, &HostAttribute)> {
        self.vertex_buffers.iter().enumerate().find_map(|(slot, buffer)| {
            buffer
                .attributes
                .iter()
                .find(|attribute| attribute.name == name)
                .map(|attribute| (slot, attribute))
        })
    }
}

/// A vertex buffer of the host.
#[derive(Clone, Debug, PartialEq)]
pub struct HostVertexBuffer {
    /// Bytes from one vertex to the next.
    pub stride: u64,
    /// The members.
    pub attributes: Vec<HostAttribute>,
}

/// A vertex attribute of the host.
#[derive(Clone, Debug, PartialEq)]
pub struct HostAttribute {
    /// The name that shaders use.
    pub name: String,
    /// Its format.
    pub format: wgpu_types::VertexFormat,
    /// Its first byte in a vertex.
    pub offset: u64,
}

/// A binding that the host fills.
#[derive(Clone, Debug, PartialEq)]
pub struct HostSlot {
    /// The name that shaders use.
    pub name: String,
    /// The kind.
    pub kind: HostSlotKind,
}

/// The kind of a binding of the host.
#[derive(Clone, Debug, PartialEq)]
pub enum HostSlotKind {
    /// A texture or a sampler, by its WGSL type (`texture_2d<f32>`, `sampler`).
    Opaque(String),
    /// A block in a buffer.
    Block {
        /// The members with their types and first bytes.
        members: Vec<HostMember>,
        /// The size of one block in bytes.
        size: u32,
        /// Bytes from one object's block to the next; a multiple of 256. 0 for a material's block.
        stride: u32,
    },
}

/// A member of a host's block.
#[derive(Clone, Debug, PartialEq)]
pub struct HostMember {
    /// The name that shaders use.
    pub name: String,
    /// Its type.
    pub value_type: ValueType,
    /// Its first byte.
    pub offset: u32,
    /// Its bytes, padding between columns or elements included.
    pub size: u32,
}

/// Compares how a host stores things with what the programs that draw it want. Places are the passes' shaders.
///
/// Diagnostics: vertex inputs and bindings that the host does not have, members of another type or at another offset.
pub fn check_host(
    pipeline: &crate::pipeline::Pipeline,
    geometry: &str,
    host: &HostInterface,
) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    for pass in &pipeline.passes {
        let crate::work::Work::Render(render) = pass.work() else { continue };
        let crate::work::Draw::Scene(scene) = &render.draw else { continue };
        if scene.geometry == geometry {
            check_program(pipeline.program(scene.program), pass, geometry, host, &mut diagnostics);
        }
    }
    diagnostics
}

fn check_program(
    program: &crate::pipeline::Program,
    pass: &crate::pipeline::Pass,
    geometry: &str,
    host: &HostInterface,
    diagnostics: &mut Vec<Diagnostic>,
) {
    use crate::shader::{Stage, TypeLayout};
    let mut report = |message: String| {
        // Passes that draw with one template have one error in common.
        if let Some(known) = diagnostics.iter_mut().find(|known| known.message == message) {
            let also =
                Related { place: pass.place.into(), message: "this pass draws with it too".to_owned() };
            if known.pointer != pass.pointer && !known.related.contains(&also) {
                known.related.push(also);
            }
            return;
        }
        let diagnostic = Diagnostic::error(crate::diagnostic::codes::HOST_INTERFACE, pass.place, message)
            .pointer(&pass.pointer)
            .help("change the host's interface, or the template");
        diagnostics.push(diagnostic);
    };
    let template = &program.template;
    for set in &host.property_sets {
        let variant = program.variant(&host.property_names(*set));
        for input in
            variant.entry_point(Stage::Vertex).map(|entry| entry.inputs.as_slice()).unwrap_or_default()
        {
            if host.attribute(&input.name).is_none() {
                report(format!(
                    "the host has no vertex attribute \"{}\", which {template} reads (geometry \"{geometry}\")",
                    input.name
                ));
            }
        }
    }
    for binding in program.bindings.iter().filter(|binding| binding.group >= MATERIAL_GROUP) {
        let slots = if binding.group == MATERIAL_GROUP { &host.material } else { &host.object };
        let name = &binding.name;
        match (slots.iter().find(|slot| slot.name == *name).map(|slot| &slot.kind), &binding.block) {
            (None, _) => {
                report(format!("the host has no \"{name}\" for group {} of {template}", binding.group));
            }
            (Some(HostSlotKind::Opaque(type_name)), None) if *type_name == binding.type_name => {}
            (
                Some(HostSlotKind::Block { members, size, .. }),
                Some(layout @ TypeLayout::Struct { members: wanted, .. }),
            ) => {
                for member in wanted {
                    let Some(have) = members.iter().find(|have| have.name == member.name) else {
                        report(format!(
                            "the host's block \"{name}\" has no \"{}\", which {template} reads",
                            member.name
                        ));
                        continue;
                    };
                    let have_type = have.value_type.to_string();
                    if have_type != member.layout.spelling() {
                        report(format!(
                            "\"{name}.{}\" is {have_type} on the host and {} in {template}",
                            member.name,
                            member.layout.spelling()
                        ));
                    } else if have.offset != member.offset || have.size > member.layout.size() {
                        report(format!(
                            "\"{name}.{}\" lies at byte {} on the host and at byte {} in {template}",
                            member.name, have.offset, member.offset
                        ));
                    }
                }
                if *size < layout.size() {
                    report(format!(
                        "the host's block \"{name}\" has {size} bytes, {template} wants {}",
                        layout.size()
                    ));
                }
            }
            (Some(_), _) => {
                report(format!(
                    "\"{name}\" of the host is not {}, which {template} wants",
                    binding.type_name
                ));
            }
        }
    }
}
