//! Helpers that the tests of umbragraph share; nothing but tests may depend on this crate.
//!
//! * [`command`]: what a command has printed.
//! * [`edits`]: random edits of documents, half of them broken.
//! * [`image`]: 8-bit PNG pictures, their comparison under a tolerance, and golden pictures kept in the tree.
//! * [`glb`]: glTF binaries of documents that tests write.
//! * [`gpu`]: one graphics device for tests, chosen by a written rule and proven to compute before it is used.
//! * [`truth`]: scores of a rendered shadow mask against a ray-traced one, where such truth is at hand.
//! * [`property`]: how many cases properties are tried on, and from which seed.
//! * [`random`]: random numbers for tests that make their cases themselves.
//! * [`scratch`]: a folder of one test's own.
//! * [`skip`]: a test that lacks what it needs says so and is counted; it never just passes.
//!
//! The crate knows nothing of pipelines or graphs, so that a mistake there cannot hide itself here.

pub mod command;
pub mod edits;
pub mod environment;
pub mod glb;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod image;
pub mod property;
pub mod random;
pub mod scratch;
pub mod skip;
pub mod truth;
