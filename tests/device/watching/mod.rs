//! Pipelines that follow their files while they are drawn.

mod changes;
mod random_edits;
mod stage;
