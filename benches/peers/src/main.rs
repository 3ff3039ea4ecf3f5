//! The compiler against the render graph of `myth_render` 0.3.0, on the same graphs in one run.
//!
//! Two figures: its topology alone (dependencies, culling, order, lifetimes), and its compile, which also takes
//! textures from its pool, here on a device that does nothing; ours is graph and plan, which decides on sharing but
//! creates nothing. Both are given graphs again each time, since the rival is built for that; building them is not
//! counted for either. Its pool is fresh each time and then used a second time, which is its steady state.
//!
//! The rival lacks seven abilities. It does not name cycles (its sort fails) and does not reject unordered writers (its
//! versions are chained by hand). It does not part a texture into mips and layers, tell why a pass is culled, or choose
//! formats and check sizes. It cannot plan without a device or give the plan as a value.

use std::time::{Duration, Instant};

use myth_render::graph::core::{
    ExecuteContext, FrameArena, GraphStorage, PassNode, RenderGraph, TextureDesc, TransientPool,
};
use umbragraph::low_level::compiler::{PlanOptions, build, plan};
use umbragraph::diagnostic::Diagnostics;

#[path = "../../shapes.rs"]
mod shapes;
use shapes::{Graph, SHAPES};

struct Nothing;

impl PassNode<'_> for Nothing {
    fn execute(&self, _: &ExecuteContext<'_>, _: &mut wgpu::CommandEncoder) {}
}

fn main() {
    let device = device();
    println!("microseconds a pass: ours; the rival's topology; its compile with a fresh pool, and with a warm one");
    for (name, shape) in SHAPES {
        for count in [100, 1_000, 5_000, 10_000] {
            let graph = shape(count);
            let runs = if count > 1_000 { 3 } else { 9 };
            let ours = min_time(runs, || ours(&graph));
            let topology = min_time(runs, || rival(&graph, None).0);
            let (cold, warm) = if count <= 5_000 {
                let pairs: Vec<_> = (0..runs.min(3)).map(|_| rival(&graph, Some(&device))).collect();
                (pairs.iter().map(|pair| pair.0).min(), pairs.iter().map(|pair| pair.1).min())
            } else {
                (None, None)
            };
            let micros = |time: Duration| time.as_secs_f64() * 1e6 / count as f64;
            let shown = |time: Option<Duration>| time.map_or("-".to_owned(), |time| format!("{:.3}", micros(time)));
            println!("{name:<10} {count:>6}: {:.3}; {:.3}; {}; {}", micros(ours), micros(topology), shown(cold), shown(warm));
            println!("ratio peers/{name}/{count}/to_topology {:.3}", ours.as_secs_f64() / topology.as_secs_f64());
            for (what, time) in [("cold", cold), ("warm", warm)] {
                if let Some(time) = time {
                    println!("ratio peers/{name}/{count}/to_{what}_compile {:.3}", ours.as_secs_f64() / time.as_secs_f64());
                }
            }
        }
    }
}

fn device() -> wgpu::Device {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::NOOP;
    descriptor.backend_options.noop.enable = true;
    let instance = wgpu::Instance::new(descriptor);
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).expect("an adapter");
    pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default())).expect("a device").0
}

fn min_time(runs: usize, mut run: impl FnMut() -> Duration) -> Duration {
    (0..runs).map(|_| run()).min().unwrap_or_default()
}

fn ours(graph: &Graph) -> Duration {
    let (pipeline, sources) = shapes::pipeline(graph);
    let start = Instant::now();
    let mut diagnostics = Diagnostics::new();
    let built = build(&pipeline, &mut diagnostics).expect("a graph");
    let planned = plan(&pipeline, &built, &PlanOptions::new(64, 64), &sources, &mut diagnostics).expect("a plan");
    assert_eq!(planned.passes.len(), graph.passes.len());
    start.elapsed()
}

/// Returns the time of a first compilation, and of a second one that reuses the resources in the pool.
fn rival(graph: &Graph, device: Option<&wgpu::Device>) -> (Duration, Duration) {
    let mut storage = GraphStorage::new();
    let mut pool = TransientPool::new();
    let mut times = [Duration::ZERO; 2];
    for time in &mut times {
        storage.clear();
        let arena = FrameArena::new();
        pool.begin_frame();
        let mut new = RenderGraph::new(&mut storage, &arena);
        let mut textures = vec![None; graph.resources.len()];
        for pass in &graph.passes {
            new.add_pass("pass", |builder| {
                for resource in &pass.reads {
                    if let Some(texture) = textures[*resource] {
                        builder.read_texture(texture);
                    }
                }
                for resource in &pass.writes {
                    let [width, height] = graph.resources[*resource];
                    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
                    let description = TextureDesc::new_2d(width, height, wgpu::TextureFormat::Rgba8Unorm, usage);
                    textures[*resource] = Some(builder.create_texture("texture", description));
                }
                for resource in &pass.updates {
                    if let Some(texture) = textures[*resource] {
                        textures[*resource] = Some(builder.mutate_texture(texture, "texture"));
                    }
                }
                if pass.output {
                    builder.mark_side_effect();
                }
                (Nothing, ())
            });
        }
        let start = Instant::now();
        match device {
            Some(device) => new.compile(&mut pool, device),
            None => new.compile_topology(),
        }
        *time = start.elapsed();
    }
    (times[0], times[1])
}
