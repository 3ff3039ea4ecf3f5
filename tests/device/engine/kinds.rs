//! Node kinds that are objects of the host, with values of its own which change from frame to frame.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use umbragraph::data::{BlackboardData, DataShape, ValueType};
use umbragraph::frame::{Camera, FrameInput};
use umbragraph::low_level::document::Value;
use umbragraph::low_level::language::Ref;
use umbragraph::low_level::pipeline::{PassBuilder, Produced};
use umbragraph::node::{NodeKind, Settings};
use umbragraph::work::{CpuContext, CpuNode, CpuWork, Work};
use umbragraph::{Executor, Frame, Library, Options};
use umbragraph_test_support::gpu;

/// Publishes what the host sets.
struct Gauge {
    name: &'static str,
    level: Arc<AtomicU32>,
}

struct GaugeSettings {
    to: Ref,
    level: Arc<AtomicU32>,
}

#[derive(Clone, Debug)]
struct RunGauge(Arc<AtomicU32>);

impl PartialEq for RunGauge {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl CpuNode for RunGauge {
    type State = ();

    fn run(&self, _: &mut (), _: &CpuContext<'_>, data: &mut BlackboardData) {
        data.set_f32("level", f32::from_bits(self.0.load(Ordering::Relaxed)));
    }
}

impl NodeKind for Gauge {
    fn name(&self) -> &'static str {
        self.name
    }
    fn summary(&self) -> &'static str {
        "Publishes a level of the host's."
    }
    fn schema(&self, _: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "type": "object", "properties": { "to": { "type": "string" } }, "required": ["to"], "additionalProperties": false
        })
    }
    fn decode(&self, settings: &Value) -> Result<Box<dyn Settings>, serde_json::Error> {
        let to = Ref(settings.get("to").and_then(Value::text).unwrap_or_default().to_owned());
        Ok(Box::new(GaugeSettings { to, level: self.level.clone() }))
    }
    fn published(&self) -> Vec<(&'static str, DataShape)> {
        Vec::new()
    }
}

impl Settings for GaugeSettings {
    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let shape = DataShape::new().value("level", ValueType::F32, "from 0 to 1");
        let output = pass.publish(&self.to, "/to", shape)?;
        pass.produce(Work::Cpu(CpuWork::new(RunGauge(self.level.clone()), output, Vec::new())))
    }
}

#[test]
fn a_kind_with_values_of_the_host_publishes_them_each_frame() {
    let Some(gpu) = gpu::device() else { return };
    let level = Arc::new(AtomicU32::new(0));
    let shader = "{% include 'lib/fullscreen.wgsl.jinja' %}
struct Gauge { level: f32 }
@group(1) @binding(0) var<uniform> gauge: Gauge;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(gauge.level, 0.0, 0.0, 1.0); }
";
    let text = r#"{ "format": 1, "name": "gauge",
      "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
      "passes": {
        "read": { "fuel": { "to": "&gauge" } },
        "fill": { "fullscreen": { "shader": "fill.wgsl.jinja", "bind": { "gauge": "&gauge" }, "color": [{ "to": "&target" }] } }
      } }"#;
    let library = Library::new()
        .template("fill.wgsl.jinja", shader)
        .register_kind(Gauge { name: "fuel", level: level.clone() });
    let pipeline = library.load_text("gauge.json", text).unwrap_or_else(|error| panic!("{error}"));
    let plan = pipeline.plan(&Options::new(4, 4)).unwrap_or_else(|error| panic!("{error}"));
    let target = crate::common::gpu::import(&gpu, &plan, "target");
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, None).unwrap();
    let input = FrameInput::new(Camera::look_at([1.0; 3], [0.0; 3], 1.0, 1.0));
    for wanted in [0_u8, 51, 255] {
        level.store((f32::from(wanted) / 255.0).to_bits(), Ordering::Relaxed);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor
            .record(&mut encoder, &Frame::new(&input).imports(&[("target", &target)]))
            .unwrap_or_else(|error| panic!("{error}"));
        gpu.queue.submit([encoder.finish()]);
        assert!(
            crate::common::gpu::read(&gpu, &target).rgba_pixels().all(|pixel| pixel == [wanted, 0, 0, 255])
        );
    }
}
