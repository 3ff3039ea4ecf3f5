//! The command as a user meets it: exit status, diagnostics, and the files it writes.

mod adapters;
mod captures;
mod check;
mod diff;
mod environment;
mod fmt;
mod guide;
mod imports;
mod input;
#[cfg(feature = "lsp")]
mod lsp_renames;
mod new;
mod permutations;
mod reference;
mod render;
mod render_colors;
mod render_failures;
mod report;
mod score;
mod score_color;
mod shader_tests;
mod show;
mod stability;
mod status;
mod streams;
mod swimming;
mod tune;
#[cfg(unix)]
mod view;
mod watch;
mod why;
