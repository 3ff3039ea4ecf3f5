//! The server as an editor meets it.

mod configurations;
mod editor;
mod fresh;
mod renames;
mod services;
mod templates;
mod workspace;
