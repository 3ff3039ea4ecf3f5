//! Toggles: passes that the host switches from frame to frame, and the fallbacks of what they write.
//!
//! ```jsonc
//! "toggles": { "bloom": { "default": true } },
//! "passes": {
//!   "glow": { "toggle": "bloom", "passthrough": { "glowing": "&color" }, "fullscreen": { … "&color" … "to": "&glowing" } },
//!   "show": { "fullscreen": { … "&glowing" … } }
//! }
//! ```
//!
//! A plan is made for all states at once: a pass that is off is not recorded, and nothing else changes but what readers
//! bind. Three things can happen to what it writes:
//!
//! - an earlier pass wrote it too: readers see that, since a conditional write never counts as covering;
//! - every reader has the same toggle, and vanishes with it;
//! - a **passthrough** names what readers see instead. It is a statement about the resource, which only passes of that
//!   one toggle may write. Each reader gets, beside its access of the resource, an access of the fallback, under the
//!   condition that the toggle is off; so edges, lifetimes, usages and hazards of both are what they are for any other
//!   access. The fallback can have a passthrough in turn, as in a chain of effects.
//!
//! Names: `bloom` runs a pass while the toggle is on, `!bloom` while it is off. A toggle of a `use` is that of every
//! pass of the subgraph. Limits: a pass has one toggle; attachments have no passthrough.

use crate::access::version::Version;
use crate::work::ResourceHandle;
use umbragraph_text::source::Span;

/// A runtime toggle that the host switches from frame to frame; passes run depending on its state.
#[derive(Clone, Debug)]
pub struct Toggle {
    /// The name of the toggle.
    pub name: String,
    /// Whether the toggle is on until the host sets it.
    pub default: bool,
    /// A description for people; `None` if the document has none.
    pub description: Option<String>,
    /// The place of the declaration.
    pub place: Span,
    /// The JSON pointer of the declaration.
    pub pointer: String,
}

/// A condition on the state of a toggle: on or off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Condition {
    /// The index of the toggle in [`TypedPipeline::toggles`](crate::pipeline::TypedPipeline::toggles).
    pub toggle: usize,
    /// Whether the toggle must be on; `false` if it must be off.
    pub on: bool,
}

impl Condition {
    /// Returns the condition that holds exactly if this one does not.
    #[must_use]
    pub fn opposite(self) -> Self {
        Self { on: !self.on, ..self }
    }

    /// Returns `true` if the condition holds for these states, which are in the order of the pipeline's toggles.
    pub fn holds(self, states: &[bool]) -> bool {
        states.get(self.toggle) == Some(&self.on)
    }
}

/// The fallback that is read instead of a resource in frames in which the passes that write the resource are off.
#[derive(Clone, Debug)]
pub struct Passthrough {
    /// The condition under which the resource itself is written and read.
    pub condition: Condition,
    /// The resource that is read if the condition does not hold.
    pub fallback: ResourceHandle,
    /// The version of the fallback that is read.
    pub version: Version,
    /// The place of the passthrough in the document.
    pub place: Span,
    /// The JSON pointer of the passthrough.
    pub pointer: String,
}
