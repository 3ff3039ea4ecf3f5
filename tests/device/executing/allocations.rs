//! Heap allocations of a steady frame with a live parameter that changes in each. They are as many as the same calls of
//! wgpu made by hand cause, and no more.
//!
//! wgpu allocates itself when passes are begun, encoded and ended, so a count of zero cannot be asked of any recorder.
//! The rival is a recording of the same calls, written down here, over objects of the same kinds on the same device.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use allocation_counter::measure;
use umbragraph::Frame;

use crate::common::gpu::import_on;
use crate::executing::devices::device;
use crate::executing::stage::{SIDE, fill, plan_of_text};
use crate::executing::views::frame;

const TARGETS: [&str; 3] = ["first", "second", "third"];

/// Recordings made before anything is counted: by then pools and caches have what they need.
const WARM: usize = 8;

/// One full-screen pass with a block of constants into each of three textures of the host.
#[test]
fn a_steady_record_allocates_as_much_as_calls_by_hand() {
    let (device, queue) = device(wgpu::Features::empty(), |_| {});
    let texture = |name: &str| {
        format!(
            r#""{name}": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}"#
        )
    };
    let pass = |name: &str| {
        fill(
            &format!("fill_{name}"),
            &format!(r#"{{ "to": "&{name}" }}"#),
            r#""=[red * 2, tint[0], tint[1], 1]""#,
        )
    };
    let text = format!(
        r#"{{ "format": 1, "name": "test", "parameters": {{ "red": {{ "type": "f32", "default": 0.5, "min": 0, "max": 1 }},
            "tint": {{ "type": "f32[]", "default": [0, 1], "min": 0, "max": 1, "min_length": 2, "max_length": 2 }} }},
            "resources": {{ {} }}, "passes": {{ {} }} }}"#,
        TARGETS.map(texture).join(", "),
        TARGETS.map(pass).join(", ")
    );
    let plan = plan_of_text(text, SIDE);
    let made = umbragraph::Executor::new(&device, &queue, plan.clone(), None);
    let mut executor = made.expect("an executor");
    let red = executor.parameter::<f32>("red").expect("a live parameter");
    let tint = executor.parameter::<[f32; 2]>("tint").expect("a live parameter");
    let textures = TARGETS.map(|name| import_on(&device, &plan, name));
    let imports: Vec<(&str, &wgpu::Texture)> = TARGETS.iter().copied().zip(&textures).collect();
    let input = frame(&[]);
    let mut by_hand = ByHand::new(&device, &queue, &textures);
    let mut counts = Vec::new();
    for round in 0..WARM + 4 {
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let frame = Frame::new(&input).imports(&imports);
        let ours = measure(|| {
            let value = round as f32 / 16.0;
            executor.set(red, value).expect("a value within its range");
            executor.set(tint, [value; 2]).expect("values within their range");
            executor.record(&mut encoder, &frame).expect("a record");
        });
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let theirs = measure(|| by_hand.record(&mut encoder));
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
        if round >= WARM {
            counts.push((ours.count_total, theirs.count_total));
        }
    }
    println!("allocations of a record, and of the same calls by hand: {counts:?}");
    assert!(counts.iter().all(|(_, theirs)| *theirs > 0), "the counter counts: {counts:?}");
    assert!(counts.iter().all(|(ours, theirs)| ours <= theirs), "ours and by hand: {counts:?}");
}

/// The same calls of wgpu, without anything around them.
struct ByHand {
    queue: wgpu::Queue,
    views: Vec<wgpu::TextureView>,
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    block: wgpu::Buffer,
    busy: Arc<AtomicBool>,
}

impl ByHand {
    fn new(device: &wgpu::Device, queue: &wgpu::Queue, textures: &[wgpu::Texture]) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(
                "@group(1) @binding(0) var<uniform> color: vec4<f32>;
                @vertex fn cover(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
                    return vec4<f32>(f32(at & 2u) * 2.0 - 1.0, 1.0 - f32((at << 1u) & 2u) * 2.0, 0.0, 1.0);
                }
                @fragment fn fill() -> @location(0) vec4<f32> { return color; }"
                    .into(),
            ),
        });
        let entry = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let layout = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &[entry] });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[None, Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::TextureFormat::Rgba8Unorm.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let block = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 768,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: block.as_entire_binding() }],
        });
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let views = textures.iter().map(view).collect();
        Self { queue: queue.clone(), views, pipeline, group, block, busy: Arc::default() }
    }

    fn record(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let busy = self.busy.clone();
        encoder.on_submitted_work_done(move || busy.store(false, Ordering::Release));
        self.queue.write_buffer(&self.block, 0, &[1; 768]);
        for view in &self.views {
            let ops = wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            };
            let attachment =
                wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("fill_second"),
                color_attachments: &[Some(attachment)],
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_viewport(0.0, 0.0, 8.0, 8.0, 0.0, 1.0);
            pass.set_scissor_rect(0, 0, 8, 8);
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(1, &self.group, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}
