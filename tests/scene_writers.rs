//! What the programs that write the example scenes share: tested here, since examples are not run as tests.

#[path = "../examples/glb/functions.rs"]
#[allow(dead_code, reason = "some of it only the examples use")]
mod functions;
