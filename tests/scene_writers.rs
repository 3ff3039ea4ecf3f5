//! What the programs that write the example scenes share: tested here, since examples are not run as tests.

#[path = "../examples/glb/mod.rs"]
mod glb;
