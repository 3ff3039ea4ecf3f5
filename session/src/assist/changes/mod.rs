//! Changes of a pipeline's graph: passes that are connected, added, switched off, renamed, moved, grouped and removed, and
//! resources that are added, renamed and removed.
//!
//! A graph that is drawn is a view of texts, so each change is [`Edits`](crate::graph::edit::Edits) of the files in
//! which the passes stand. Comments and layout stay, and the inverse gives the texts back byte for byte. A change is
//! made of the functions of [`edit`](crate::graph::edit) alone, and says nothing of whether the pipeline is right
//! afterwards: plan the edited texts for that.
//!
//! Passes have the names of the text: a round of a loop (`down.1`) and a part of a subgraph (`soft.up`) stand for the
//! pass that is written (`down`, `soft`). What a pass takes over from shared settings is changed in the pass, and stays
//! as it is in the others.
//!
//! Limits: a file with a syntax error is not changed, nor is one that comes with the module; a name that an expression
//! chooses (`"=soft ? &blurred : &sharp"`) is left to its author.

mod add;
mod draft;
mod error;
mod graph;
mod group;
mod pass;
mod resource;
mod slots;

use std::path::Path;

use super::{Cursor, kind_of};
use crate::cancel::Cancelled;
use crate::choice::{Choice, Target};
use crate::graph::pipeline::FileKind;
use crate::session::Session;
pub use error::{ChangeError, Changes};
use graph::Graph;
pub use pass::Written;
pub use slots::Slot;

/// A change of a pipeline's pass graph. The name of a loop round (`down.1`) or of a pass in a subgraph (`soft.up`)
/// means the pass that the file declares (`down`, `soft`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// Connects a slot of a pass to another resource or to published data.
    Connect {
        /// The name of the pass.
        pass: String,
        /// The keys of the slot, as in [`Slot::keys`].
        slot: Vec<String>,
        /// The reference to the resource or data, such as `&maps@blur`.
        to: String,
    },
    /// Renames a pass or a resource, and all its uses.
    Rename {
        /// The current name.
        from: String,
        /// The new name.
        to: String,
    },
    /// Switches a pass on or off by its key `when`.
    Switch {
        /// The name of the pass.
        pass: String,
        /// `true` to switch the pass on, `false` to switch it off.
        on: bool,
    },
    /// Removes a pass. Also removes its name from the lists `after` and `before` of other passes.
    Remove {
        /// The name of the pass.
        pass: String,
    },
    /// Moves a pass within its file, before another pass or to the end of the passes.
    Move {
        /// The name of the pass to move.
        pass: String,
        /// The name of the pass before which it is placed; `None` moves it to the end.
        before: Option<String>,
    },
    /// Adds a pass, which is a node of a given kind or a use of a subgraph.
    Add {
        /// The node kind, the name of a subgraph, or the path of a subgraph file.
        kind: String,
        /// The name of the pass after which the new one is written; `None` appends it at the end.
        after: Option<String>,
    },
    /// Adds a new texture or buffer.
    Declare {
        /// The name of the resource whose format, size and other settings are copied. `None` declares an `rgba8unorm`
        /// texture of the viewport's size.
        like: Option<String>,
    },
    /// Removes the declaration of a resource that nothing uses.
    Forget {
        /// The name of the resource.
        resource: String,
    },
    /// Moves passes into a new subgraph of the pipeline, and adds a pass that uses the subgraph in their place.
    Group {
        /// The names of the passes.
        passes: Vec<String>,
        /// The name of the subgraph, and of the pass that uses it.
        name: String,
    },
}

impl Session {
    /// Returns the edits that make a change of a pipeline's pass graph, without applying them. Returns `None` if the
    /// pipeline's file cannot be read.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set). The inner result is an error if the change
    /// cannot be made.
    pub fn change(
        &mut self,
        target: &Target,
        choice: &Choice,
        change: &Change,
    ) -> Result<Option<Changes>, Cancelled> {
        // The files of subgraphs that are to be used are read, so that their inputs are known.
        let used = match change {
            Change::Add { kind, .. } => self.inputs_of(Path::new(kind)),
            _ => None,
        };
        let cursor = Cursor { target, choice, path: &target.path, offset: 0 };
        self.around(&cursor, |context| {
            let graph = Graph { context };
            Some(match change {
                Change::Connect { pass, slot, to } => graph.connect(pass, slot, to),
                Change::Rename { from, to } => graph.rename(from, to),
                Change::Switch { pass, on } => graph.switch(pass, *on),
                Change::Remove { pass } => graph.remove(pass),
                Change::Move { pass, before } => graph.reorder(pass, before.as_deref()),
                Change::Add { kind, after } => graph.add(kind, after.as_deref(), used.as_deref()),
                Change::Declare { like } => graph.declare(like.as_deref()),
                Change::Forget { resource } => graph.forget(resource),
                Change::Group { passes, name } => graph.group(passes, name),
            })
        })
    }

    /// Returns the places in a pass that refer to resources or published data, or can. Empty if the pass does not exist
    /// or the pipeline's file cannot be read.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn slots(&mut self, target: &Target, choice: &Choice, pass: &str) -> Result<Vec<Slot>, Cancelled> {
        let cursor = Cursor { target, choice, path: &target.path, offset: 0 };
        Ok(self.around(&cursor, |context| Some(Graph { context }.slots(pass)))?.unwrap_or_default())
    }

    /// Returns the passes that the pipeline's files declare, before loops and subgraphs are expanded. Empty if the
    /// pipeline's file cannot be read.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn written(&mut self, target: &Target, choice: &Choice) -> Result<Vec<Written>, Cancelled> {
        let cursor = Cursor { target, choice, path: &target.path, offset: 0 };
        Ok(self.around(&cursor, |context| Some(Graph { context }.written()))?.unwrap_or_default())
    }

    /// Returns the names of the inputs of a subgraph file; `None` if the file cannot be read or is not a subgraph.
    fn inputs_of(&mut self, path: &Path) -> Option<Vec<String>> {
        let document = &self.parsed(path)?.1.document;
        let is_subgraph = kind_of(document) == Some(FileKind::Subgraph);
        let inputs = document.root.entries_of("inputs").iter().map(|input| input.key.clone());
        is_subgraph.then(|| inputs.collect())
    }
}
