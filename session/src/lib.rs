//! One session over the files of pipelines.
//!
//! A command, an application, a test, an editor and a page in a browser ask the same questions: what is wrong with
//! these files, what is their plan, why is this pass there. A [`Session`] answers them, again and again while the files
//! change, and does only what a change makes necessary:
//!
//! ```text
//! text ──parse──▶ document ──compose──▶ Loaded ──load, plan──▶ Planned
//!   │ per file      per file       per Target        per Choice
//!   └ templates ──▶ TemplateSet ──▶ shader modules, per profile
//! ```
//!
//! - **Files.** Every path is read once, through a [`Storage`], and again when [`Session::changed`] or
//!   [`Session::refresh`] says so: one answer sees one text of each file. [`Session::overlay`] lays an unsaved text
//!   over a path, also over one where no file is.
//! - **What is kept.** A document per text; a composition for as long as every file that was read *or looked for* is as
//!   it was; loads and plans per composition and choice; shader modules for as long as their templates, and those that
//!   these name, stay.
//! - **Comments and layout.** A text with the same tokens as before is the same document: nothing is done again, and
//!   the places of diagnostics are moved to where their tokens are now.
//! - **Counts.** [`Session::take_done`] says what was done.
//! - **Cancelling.** A [`Cancel`] that another thread sets ends an answer between two steps; nothing half done is kept.
//!
//! Sessions start no threads (but for proofs, with as many as [`Survey::threads`] says), know no clock and read files
//! only through the [`Storage`] that they are given. They are `Send`.
//!
//! - **Editors.** A [`Cursor`] asks what can stand at a place ([`Session::expected_at`]), what stands there and where
//!   it is declared and used, also in broken files.
//!
//! Limits: a storage is asked again only when the session is told; a set with more or fewer templates shares no shader
//! module with the one before.

mod assist;
mod cancel;
mod choice;
mod composition;
mod done;
mod exposed;
mod files;
mod loaded;
mod places;
mod session;
mod survey;
mod templates;
mod texts;
mod tokens;

pub use assist::{
    Candidate, CandidateKind, Change, ChangeError, Changes, Color, Computed, Cursor, Expected, Hover,
    RenameError, Renamed, Slot, TemplateItem, TemplateSymbol, Written, is_about_color, kind_of,
};
pub use cancel::{Cancel, Cancelled};
pub use choice::{Choice, Target};
pub use done::Done;
pub use files::Storage;
pub use loaded::{Loaded, Planned};
pub use session::Session;
pub use survey::{Judges, Survey, Surveyed};
pub use templates::{Template, TemplateText};

use umbragraph_graph as graph;
