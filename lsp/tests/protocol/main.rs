//! The server as an editor meets it.

mod colors;
mod configurations;
mod editor;
mod fresh;
mod renames;
mod services;
mod template_renames;
mod templates;
mod workspace;
