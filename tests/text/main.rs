//! Documents, compositions, plans and sessions: everything that needs no device.

#[path = "../common/mod.rs"]
mod common;

mod broken;
mod checker;
mod checker_toggles;
mod codes;
mod core_mode;
mod dead_parameters;
mod device_limits;
mod documents;
#[cfg(all(feature = "gltf", feature = "noop"))]
mod dry_runs;
mod editor_schema;
mod front_door;
mod graph;
mod graph_orders;
mod graph_page;
mod graph_parts;
mod graph_toggles;
mod hopeless;
mod instances;
mod language;
mod light_data;
mod mistakes;
mod ray_traced_truth;
mod recovery;
mod resizing;
mod rust_sources;
mod scene_writers;
mod session;
mod stability;
mod structure;
mod systems;
#[cfg(feature = "gltf")]
mod tracer;
#[cfg(feature = "noop")]
mod webgpu_rules;
