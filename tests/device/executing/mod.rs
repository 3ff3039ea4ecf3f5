//! The executor with plans, frames and hosts of every kind.
//!
//! A host of squares ([`squares`]) and a node kind whose views each frame chooses ([`views`]) let a test say exactly
//! what is drawn where.

mod allocations;
mod blending;
mod buffers;

mod contents;
mod copies;
mod coverage;
mod devices;
mod formats;
mod history;
mod hosts;
mod layers;
mod live;
mod merging;
mod meshes;
mod misuse;
mod orders;
mod passthroughs;
mod plans;
mod read_back;
mod redraw;
mod samplers;
mod simulation;
mod squares;
mod stage;
mod state;
mod steady;
mod subresources;
mod toggles;
mod unwritten;
mod viewports;
mod views;
