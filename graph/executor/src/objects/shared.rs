//! Objects that plans share: shader modules, layouts, pipelines, samplers.
//!
//! Each is found by its whole descriptor (see [`super::cache`]); layouts and modules stand in the descriptors of
//! pipelines as themselves, since wgpu compares its objects by identity. Labels are no part of a descriptor: an object
//! that several passes share is labelled after the first.

use super::cache::Cache;
use super::creation::Creation;
use umbragraph_pipeline::shader::ShaderModule;
use umbragraph_pipeline::work::{Filter, Sampler};

/// The cache of shader modules, samplers, layouts and pipelines of the current plan and of recent ones.
#[derive(Default)]
pub(crate) struct Objects {
    /// The generation of the current attempt to instantiate a plan.
    now: u64,
    /// The last generation that the device accepted.
    proven: u64,
    modules: Cache<[u8; 32], wgpu::ShaderModule>,
    samplers: Cache<Sampler, wgpu::Sampler>,
    group_layouts: Cache<Vec<wgpu::BindGroupLayoutEntry>, wgpu::BindGroupLayout>,
    pipeline_layouts: Cache<Vec<Option<wgpu::BindGroupLayout>>, wgpu::PipelineLayout>,
    render_pipelines: Cache<RenderKey, wgpu::RenderPipeline>,
    compute_pipelines: Cache<ComputeKey, wgpu::ComputePipeline>,
}

/// The layout of a vertex buffer: stride in bytes, step mode and attributes.
pub(crate) type VertexBufferKey = (u64, wgpu::VertexStepMode, Vec<wgpu::VertexAttribute>);

/// The state of a render pipeline without its label: the key of the cache.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct RenderKey {
    pub(crate) layout: wgpu::PipelineLayout,
    pub(crate) module: wgpu::ShaderModule,
    pub(crate) vertex: Option<String>,
    /// The fragment entry point; `None` for a pipeline without a fragment stage.
    pub(crate) fragment: Option<String>,
    /// Pipeline-overridable constants: names, and the bits of their values.
    pub(crate) constants: Vec<(String, u64)>,
    pub(crate) buffers: Vec<Option<VertexBufferKey>>,
    pub(crate) targets: Vec<Option<wgpu::ColorTargetState>>,
    pub(crate) depth_stencil: Option<wgpu::DepthStencilState>,
    pub(crate) samples: u32,
    pub(crate) primitive: Primitive,
}

impl RenderKey {
    /// Creates the key of a pipeline that draws triangles without vertex buffers, and writes only depth, without a
    /// depth test.
    pub(crate) fn depth_alone(
        layout: wgpu::PipelineLayout,
        module: wgpu::ShaderModule,
        vertex: &str,
        fragment: Option<&str>,
        format: wgpu::TextureFormat,
        samples: u32,
    ) -> Self {
        Self {
            layout,
            module,
            vertex: Some(vertex.to_owned()),
            fragment: fragment.map(str::to_owned),
            constants: Vec::new(),
            buffers: Vec::new(),
            targets: Vec::new(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            samples,
            primitive: Primitive::default(),
        }
    }
}

/// The primitive state of a render pipeline: topology, culling and strip indices.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub(crate) struct Primitive {
    pub(crate) topology: wgpu::PrimitiveTopology,
    /// The faces that are culled; `None` culls none.
    pub(crate) cull: Option<wgpu::Face>,
    /// The index format of an indexed strip; `None` for lists and for strips without indices.
    pub(crate) strip_indices: Option<wgpu::IndexFormat>,
}

/// The state of a compute pipeline without its label: the key of the cache.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct ComputeKey {
    pub(crate) layout: wgpu::PipelineLayout,
    pub(crate) module: wgpu::ShaderModule,
    pub(crate) entry_point: Option<String>,
    pub(crate) constants: Vec<(String, u64)>,
}

impl Objects {
    /// Begins an attempt to instantiate a plan, and drops objects of an earlier attempt that failed.
    pub(crate) fn begin(&mut self) {
        self.clean();
        self.now += 1;
    }

    /// Ends an attempt that the device accepted, and evicts objects that no plan has used for long.
    pub(crate) fn commit(&mut self) {
        self.proven = self.now;
        self.clean();
    }

    fn clean(&mut self) {
        let proven = self.proven;
        self.modules.clean(proven);
        self.samplers.clean(proven);
        self.group_layouts.clean(proven);
        self.pipeline_layouts.clean(proven);
        self.render_pipelines.clean(proven);
        self.compute_pipelines.clean(proven);
    }

    pub(crate) fn module(
        &mut self,
        creation: &mut Creation<'_>,
        shader: &ShaderModule,
    ) -> wgpu::ShaderModule {
        self.modules.get(shader.hash, self.now, |_| creation.shader_module(&shader.template, &shader.wgsl))
    }

    /// Returns a shader module of the executor's own, cached under a fixed key in place of a hash.
    pub(crate) fn built_in(
        &mut self,
        creation: &mut Creation<'_>,
        label: &str,
        key: [u8; 32],
        wgsl: &str,
    ) -> wgpu::ShaderModule {
        self.modules.get(key, self.now, |_| creation.shader_module(label, wgsl))
    }

    pub(crate) fn sampler(
        &mut self,
        creation: &mut Creation<'_>,
        label: &str,
        sampler: Sampler,
    ) -> wgpu::Sampler {
        self.samplers.get(sampler, self.now, |_| {
            let (address, filter) = (sampler.address.into(), sampler.filter.into());
            let mipmap_filter = match sampler.filter {
                Filter::Nearest => wgpu::MipmapFilterMode::Nearest,
                Filter::Linear => wgpu::MipmapFilterMode::Linear,
            };
            creation.sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                address_mode_u: address,
                address_mode_v: address,
                address_mode_w: address,
                mag_filter: filter,
                min_filter: filter,
                mipmap_filter,
                compare: sampler.compare.map(Into::into),
                anisotropy_clamp: sampler.max_anisotropy,
                lod_min_clamp: sampler.lod_clamp[0] as f32 / 1000.0,
                lod_max_clamp: sampler.lod_clamp[1] as f32 / 1000.0,
                ..wgpu::SamplerDescriptor::default()
            })
        })
    }

    pub(crate) fn group_layout(
        &mut self,
        creation: &mut Creation<'_>,
        label: &str,
        entries: Vec<wgpu::BindGroupLayoutEntry>,
    ) -> wgpu::BindGroupLayout {
        self.group_layouts.get(entries, self.now, |entries| {
            creation.bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        })
    }

    pub(crate) fn pipeline_layout(
        &mut self,
        creation: &mut Creation<'_>,
        label: &str,
        groups: Vec<Option<wgpu::BindGroupLayout>>,
    ) -> wgpu::PipelineLayout {
        self.pipeline_layouts.get(groups, self.now, |groups| {
            let groups: Vec<_> = groups.iter().map(Option::as_ref).collect();
            creation.pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: &groups,
                immediate_size: 0,
            })
        })
    }

    pub(crate) fn compute_pipeline(
        &mut self,
        creation: &mut Creation<'_>,
        label: &str,
        key: ComputeKey,
    ) -> wgpu::ComputePipeline {
        self.compute_pipelines.get(key, self.now, |key| {
            let constants = constants(&key.constants);
            creation.compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(label),
                layout: Some(&key.layout),
                module: &key.module,
                entry_point: key.entry_point.as_deref(),
                compilation_options: options(&constants),
                cache: None,
            })
        })
    }

    pub(crate) fn render_pipeline(
        &mut self,
        creation: &mut Creation<'_>,
        label: &str,
        key: RenderKey,
    ) -> wgpu::RenderPipeline {
        self.render_pipelines.get(key, self.now, |key| create_render_pipeline(creation, label, key))
    }
}

fn create_render_pipeline(creation: &mut Creation<'_>, label: &str, key: &RenderKey) -> wgpu::RenderPipeline {
    let constants = constants(&key.constants);
    let buffers: Vec<Option<wgpu::VertexBufferLayout<'_>>> = key
        .buffers
        .iter()
        .map(|buffer| {
            let (array_stride, step_mode, attributes) = buffer.as_ref()?;
            Some(wgpu::VertexBufferLayout { array_stride: *array_stride, step_mode: *step_mode, attributes })
        })
        .collect();
    creation.render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(label),
        layout: Some(&key.layout),
        vertex: wgpu::VertexState {
            module: &key.module,
            entry_point: key.vertex.as_deref(),
            compilation_options: options(&constants),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: key.primitive.topology,
            strip_index_format: key.primitive.strip_indices,
            cull_mode: key.primitive.cull,
            ..wgpu::PrimitiveState::default()
        },
        depth_stencil: key.depth_stencil.clone(),
        multisample: wgpu::MultisampleState { count: key.samples, ..wgpu::MultisampleState::default() },
        fragment: key.fragment.as_ref().map(|entry_point| wgpu::FragmentState {
            module: &key.module,
            entry_point: Some(entry_point),
            compilation_options: options(&constants),
            targets: &key.targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn constants(constants: &[(String, u64)]) -> Vec<(&str, f64)> {
    constants.iter().map(|(name, bits)| (name.as_str(), f64::from_bits(*bits))).collect()
}

fn options<'a>(constants: &'a [(&'a str, f64)]) -> wgpu::PipelineCompilationOptions<'a> {
    wgpu::PipelineCompilationOptions { constants, ..wgpu::PipelineCompilationOptions::default() }
}
