//! The node kind `mesh`: vertices from the pipeline's own buffers, without the host.
//!
//! The attributes of vertex buffers are matched with the shader's vertex inputs by name, so that the output of a
//! compute pass can be drawn without any Rust. Numbers or a buffer give the draw count.
//!
//! Limits: at most eight vertex buffers; buffers are drawn from their beginning.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::diagnostic::codes;
use umbragraph_pipeline::language::{Expr, Ref, Word};
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{Evaluate, PassBuilder, Produced};
use umbragraph_pipeline::wgpu_types::{IndexFormat, PrimitiveTopology, VertexStepMode};
use umbragraph_pipeline::work::{BufferDraw, Draw, DrawCounts, IndexStream, ProgramHandle, VertexStream};

use crate::attachment::Attachments;
use crate::compute::IndirectSettings;
use crate::draw::Cull;
use crate::if_said::if_said;
use crate::shader::ShaderSettings;

/// The maximum number of vertex buffers that WebGPU guarantees.
const MAX_STREAMS: usize = 8;

/// The maximum stride of a vertex buffer that WebGPU guarantees, in bytes.
const MAX_STRIDE: u64 = 2048;

/// Draws vertices from the pipeline's own buffers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    /// The shader template with its axes, bindings and entry points.
    #[serde(flatten)]
    pub shader: ShaderSettings,
    /// The vertex buffers; none for a shader that computes its vertices itself.
    #[serde(default)]
    pub vertices: Vec<VertexSettings>,
    /// The index buffer; without this key vertices are drawn in their order.
    pub indices: Option<IndexSettings>,
    /// The number of vertices to draw, or of indices with an index buffer.
    pub count: Option<Expr>,
    /// The number of instances to draw; 1 by default.
    pub instances: Option<Expr>,
    /// A buffer with the draw arguments, instead of "count" and "instances": four u32 (vertices, instances, first
    /// vertex, first instance). With indices there are five u32 (indices, instances, first index, base vertex, first
    /// instance).
    pub indirect: Option<IndirectSettings>,
    /// The primitive topology; "triangle-list" by default.
    pub topology: Option<Word<Topology>>,
    /// The faces that are culled; "none" by default.
    pub cull: Option<Word<Cull>>,
    /// The color, depth and stencil attachments.
    #[serde(flatten)]
    pub attachments: Attachments,
}

/// A buffer of values for each vertex or each instance.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VertexSettings {
    /// The buffer: a reference.
    pub buffer: Ref,
    /// The bytes from one element to the next, a multiple of 4 (unit: bytes). By default the end of the last attribute,
    /// rounded up.
    pub stride: Option<Expr>,
    /// Whether an element belongs to each vertex or to each instance; "vertex" by default.
    pub step: Option<Word<Step>>,
    /// The attributes of an element, each with the name of a vertex input of the shader.
    #[schemars(length(min = 1))]
    pub attributes: Vec<AttributeSettings>,
}

/// An attribute of a vertex buffer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AttributeSettings {
    /// The name of the shader's vertex input.
    pub name: String,
    /// The vertex format of the attribute, by WebGPU's name, such as "float32x3".
    pub format: String,
    /// The first byte of the attribute in an element (unit: bytes); by default just after the previous attribute.
    pub offset: Option<Expr>,
}

/// A buffer of indices.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IndexSettings {
    /// The buffer: a reference.
    pub buffer: Ref,
    /// The format of the indices; "uint32" by default.
    pub format: Option<Word<IndexWord>>,
}

umbragraph_pipeline::webgpu_words! {
    /// The step mode of a vertex buffer: an element for each vertex or for each instance.
    Step = VertexStepMode {
        /// One element for each vertex.
        Vertex,
        /// One element for each instance.
        Instance,
    }
}

umbragraph_pipeline::webgpu_words! {
    /// The format of indices.
    IndexWord = IndexFormat {
        /// Unsigned indices of two bytes.
        Uint16,
        /// Unsigned indices of four bytes.
        Uint32,
    }
}

umbragraph_pipeline::webgpu_words! {
    /// The primitive topology, by WebGPU's names.
    Topology = PrimitiveTopology {
        /// Points of one pixel.
        PointList,
        /// A line for every two vertices.
        LineList,
        /// Connected lines: one from each vertex to the next.
        LineStrip,
        /// A triangle for every three vertices.
        TriangleList,
        /// Connected triangles: each vertex after the second forms one with the two vertices before.
        TriangleStrip,
    }
}

impl Node for Mesh {
    const NAME: &'static str = "mesh";
    const SUMMARY: &'static str = "Draws vertices from the pipeline's own buffers.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let draw = self.buffers(pass);
        self.attachments.check(pass)?;
        let produced = self.attachments.render(pass, false, draw)?;
        let topology = pass.word_or(&self.topology, "/topology", Topology::TriangleList)?;
        let bias = self.attachments.depth.as_ref().map(|depth| &depth.slope_bias);
        let bias = bias.map_or(Some(0.0), |bias| pass.number_or(bias, "/depth/slope_bias", 0.0))?;
        if bias != 0.0 && !PrimitiveTopology::from(topology).is_triangles() {
            let message = "points and lines have no slope, so no bias for it";
            let help = "leave out \"slope_bias\", or draw triangles";
            return pass.reject(codes::DEVICE_RULE, "/depth/slope_bias", message, help);
        }
        Some(produced)
    }
}

impl Mesh {
    fn buffers(&self, pass: &mut PassBuilder<'_>) -> Option<Draw> {
        let (program, bindings) = self.shader.declare(pass, None);
        let vertices = program.and_then(|program| self.vertices(program, pass));
        let indices = if_said(&self.indices, |settings| indices(settings, pass));
        let counts = self.counts(pass);
        let topology = pass.word_or(&self.topology, "/topology", Topology::TriangleList)?;
        let cull = pass.word_or(&self.cull, "/cull", Cull::None)?;
        Some(Draw::Buffers(Box::new(BufferDraw {
            program: program?,
            bindings: bindings?,
            vertices: vertices?,
            indices: indices?,
            counts: counts?,
            topology: topology.into(),
            cull: cull.face(),
        })))
    }

    fn vertices(&self, program: ProgramHandle, pass: &mut PassBuilder<'_>) -> Option<Vec<VertexStream>> {
        if self.vertices.len() > MAX_STREAMS {
            let message =
                format!("{} vertex buffers are more than a device needs to have", self.vertices.len());
            let help = format!("use at most {MAX_STREAMS}: several attributes can lie in one buffer");
            return pass.reject(codes::DEVICE_RULE, "/vertices", message, help);
        }
        let streams: Vec<Option<VertexStream>> =
            self.vertices.iter().enumerate().map(|(at, stream)| stream.declare(at, program, pass)).collect();
        let streams: Vec<VertexStream> = streams.into_iter().collect::<Option<_>>()?;
        let attributes = self.vertices.iter().flat_map(|stream| &stream.attributes);
        let given: Vec<&str> = attributes.map(|attribute| attribute.name.as_str()).collect();
        pass.check_vertex_inputs(program, &given, "/vertices")?;
        Some(streams)
    }

    fn counts(&self, pass: &mut PassBuilder<'_>) -> Option<DrawCounts> {
        match (&self.count, &self.indirect) {
            (Some(count), None) => {
                let count = pass.live_value(count, "/count");
                let instances = if_said(&self.instances, |expr| pass.live_value(expr, "/instances"));
                let instances = instances?.unwrap_or_else(|| 1.into());
                Some(DrawCounts::Direct { count: count?, instances })
            }
            (None, Some(settings)) if self.instances.is_none() => {
                let words = if self.indices.is_some() { 5 } else { 4 };
                settings.declare(pass, words).map(DrawCounts::Indirect)
            }
            (None, None) => {
                let help = "add \"count\", perhaps with \"instances\", or \"indirect\": a buffer";
                pass.reject(codes::MISSING_KEY, "", "the mesh does not say how much is drawn", help)
            }
            (count, _) => {
                let other = if count.is_some() { "count" } else { "instances" };
                let message = format!("\"{other}\" and \"indirect\" exclude one another");
                pass.reject(codes::UNKNOWN_KEY, "/indirect", message, "remove one of the two")
            }
        }
    }
}

impl VertexSettings {
    fn declare(&self, at: usize, program: ProgramHandle, pass: &mut PassBuilder<'_>) -> Option<VertexStream> {
        let here = format!("/vertices/{at}");
        let mut attributes = Vec::with_capacity(self.attributes.len());
        for (position, attribute) in self.attributes.iter().enumerate() {
            let offset =
                pass.count_if(&attribute.offset, format_args!("{here}/attributes/{position}/offset"))?;
            let offset = offset.map(u64::from);
            attributes.push((attribute.name.as_str(), attribute.format.as_str(), offset));
        }
        let found = pass.vertex_attributes(program, &attributes, &format!("{here}/attributes"));
        let step = pass.word_or(&self.step, format_args!("{here}/step"), Step::Vertex)?;
        let stride = pass.count_if(&self.stride, format_args!("{here}/stride"))?;
        let buffer = pass.buffer(&self.buffer, &format!("{here}/buffer"));
        let (attributes, end) = found?;
        let stride = stride.map_or(end.next_multiple_of(4), u64::from);
        if stride % 4 != 0 || stride < end || stride > MAX_STRIDE {
            let message = format!("elements of {end} bytes cannot follow one another every {stride} bytes");
            let help = format!("write a multiple of 4 from {} to {MAX_STRIDE}", end.next_multiple_of(4));
            return pass.reject(codes::DEVICE_RULE, &format!("{here}/stride"), message, help);
        }
        Some(VertexStream { buffer: buffer?, stride, step: step.into(), attributes })
    }
}

fn indices(settings: &IndexSettings, pass: &mut PassBuilder<'_>) -> Option<IndexStream> {
    let format = pass.word_or(&settings.format, "/indices/format", IndexWord::Uint32)?;
    let buffer = pass.buffer(&settings.buffer, "/indices/buffer")?;
    Some(IndexStream { buffer, format: format.into() })
}
