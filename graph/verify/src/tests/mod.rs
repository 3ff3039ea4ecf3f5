//! Random pipelines, planned and verified.

mod orders;
mod toggles;
mod uninitialised;
mod writers;
