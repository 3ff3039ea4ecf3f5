//! Work that is done once for all instances of a subgraph.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use umbragraph::data::{BlackboardData, DataShape, ValueType};
use umbragraph::diagnostic::{Diagnostics, render};
use umbragraph::low_level::document;
use umbragraph::low_level::language::Ref;
use umbragraph::low_level::pipeline::{self, Overrides, PassBuilder, Produced};
use umbragraph::low_level::shader::{ShaderCache, TargetProfile};
use umbragraph::low_level::source::Sources;
use umbragraph::node::Node;
use umbragraph::work::{CpuContext, CpuNode, CpuWork, Work};

/// The number of times that [`Counted`] is decoded and declared.
static COUNTED: [AtomicUsize; 2] = [AtomicUsize::new(0), AtomicUsize::new(0)];

/// A node kind that counts what is done with it.
#[derive(schemars::JsonSchema)]
struct Counted {
    /// The data to publish.
    to: Ref,
}

impl<'de> serde::Deserialize<'de> for Counted {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        COUNTED[0].fetch_add(1, Ordering::Relaxed);
        let mut members = BTreeMap::<String, String>::deserialize(deserializer)?;
        Ok(Self { to: Ref(members.remove("to").unwrap_or_default()) })
    }
}

impl Node for Counted {
    const NAME: &'static str = "counted";
    const SUMMARY: &'static str = "Counts what is done with it.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        COUNTED[1].fetch_add(1, Ordering::Relaxed);
        let shape = DataShape::new().value("number", ValueType::U32, "any");
        let output = pass.publish(&self.to, "/to", shape)?;
        pass.produce(Work::Cpu(CpuWork::new(Idle, output, Vec::new())))
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Idle;

impl CpuNode for Idle {
    type State = ();

    fn run(&self, (): &mut (), _: &CpuContext<'_>, _: &mut BlackboardData) {}
}

#[test]
fn settings_of_a_subgraph_are_decoded_once() {
    let uses: Vec<String> = (0..1_000).map(|at| format!(r#""u{at}": {{ "use": "one" }}"#)).collect();
    let text = format!(
        r#"{{ "format": 1, "name": "many", "resources": {{}},
  "subgraphs": {{ "one": {{ "passes": {{
      "a": {{ "counted": {{ "to": "&x" }} }}, "b": {{ "for_each": {{ "i": 2 }}, "counted": {{ "to": "=[&y0, &y1][i]" }} }} }} }} }},
  "passes": {{ {} }} }}"#,
        uses.join(", ")
    );
    let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
    let templates = umbragraph::templates(&mut sources, &mut diagnostics);
    let file = sources.add("many.json", text);
    let document = document::parse(&sources, file).valid().unwrap();
    let mut registry = umbragraph::registry();
    registry.register::<Counted>();
    let shaders = std::sync::Arc::new(ShaderCache::new(&templates, &TargetProfile::webgpu()));
    let overrides = Overrides::default();
    let options = pipeline::LoadOptions::new(&registry, &shaders, &overrides);
    let pipeline = pipeline::load(&document, &options, &sources, &mut diagnostics).unwrap();
    assert_eq!(render::human_all(&diagnostics, &sources), "");
    assert_eq!(pipeline.passes.len(), 3_000);
    assert!(pipeline.find_resource("u999.y1").is_some());
    assert_eq!(COUNTED.each_ref().map(|count| count.load(Ordering::Relaxed)), [2, 3_000]);
}
