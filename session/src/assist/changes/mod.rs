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

/// A change of a graph. Names of passes are those of the text, or of parts of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// Has a pass use another resource or published data in one of its slots.
    Connect {
        /// The pass.
        pass: String,
        /// The keys of [`Slot::keys`].
        slot: Vec<String>,
        /// The reference, such as `&maps@blur`.
        to: String,
    },
    /// Gives a pass or a resource another name, wherever it is used.
    Rename {
        /// The name until now.
        from: String,
        /// The new name.
        to: String,
    },
    /// Switches a pass on or off by its key `when`.
    Switch {
        /// The pass.
        pass: String,
        /// `true` to switch the pass on, `false` to switch it off.
        on: bool,
    },
    /// Removes a pass, and its name from the lists `after` and `before` of others.
    Remove {
        /// The pass.
        pass: String,
    },
    /// Moves a pass in the text before another one, or after all.
    Move {
        /// The pass.
        pass: String,
        /// The pass before which it goes; `None` moves it to the end.
        before: Option<String>,
    },
    /// Adds a pass, of a node kind or as a use of a subgraph.
    Add {
        /// The node kind, the name of a subgraph, or the path of a file that is one.
        kind: String,
        /// The pass after which the new one is written; `None` appends it at the end.
        after: Option<String>,
    },
    /// Adds a texture or a buffer.
    Declare {
        /// The resource whose format and size are copied; `None` declares a texture as large as the frame.
        like: Option<String>,
    },
    /// Removes a resource that nothing uses.
    Forget {
        /// The resource.
        resource: String,
    },
    /// Makes passes a subgraph of the pipeline, and puts a use of it in their place.
    Group {
        /// The passes.
        passes: Vec<String>,
        /// The name of the subgraph and of its use.
        name: String,
    },
}

impl Session {
    /// Makes a change of the graph of a pipeline; nothing where its files are not understood at all.
    ///
    /// # Errors
    /// [`Cancel::set`](crate::Cancel::set). Within the answer: a change that cannot be made.
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

    /// The places of a pass that refer to resources, or can.
    ///
    /// # Errors
    /// [`Cancel::set`](crate::Cancel::set).
    pub fn slots(&mut self, target: &Target, choice: &Choice, pass: &str) -> Result<Vec<Slot>, Cancelled> {
        let cursor = Cursor { target, choice, path: &target.path, offset: 0 };
        Ok(self.around(&cursor, |context| Some(Graph { context }.slots(pass)))?.unwrap_or_default())
    }

    /// The passes of a pipeline's text.
    ///
    /// # Errors
    /// [`Cancel::set`](crate::Cancel::set).
    pub fn written(&mut self, target: &Target, choice: &Choice) -> Result<Vec<Written>, Cancelled> {
        let cursor = Cursor { target, choice, path: &target.path, offset: 0 };
        Ok(self.around(&cursor, |context| Some(Graph { context }.written()))?.unwrap_or_default())
    }

    /// The names of the inputs of a file that is a subgraph.
    fn inputs_of(&mut self, path: &Path) -> Option<Vec<String>> {
        let (_, document) = self.parsed(path)?;
        let is_subgraph = kind_of(&document) == Some(FileKind::Subgraph);
        let inputs = document.root.entries_of("inputs").iter().map(|input| input.key.clone());
        is_subgraph.then(|| inputs.collect())
    }
}
