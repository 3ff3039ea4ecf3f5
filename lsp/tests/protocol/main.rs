//! The server as an editor meets it.

mod editor;
mod fresh;
mod renames;
mod services;
mod workspace;
