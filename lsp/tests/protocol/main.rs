//! The server as an editor meets it.

mod editor;
mod fresh;
mod services;
mod workspace;
