//! Entries of the document with their places, so that an error can be about them.

use crate::pipeline::pass::{Access, Pass};
use crate::pipeline::resource::Resource;
use crate::pipeline::toggle::Passthrough;
use crate::work::{BoundSlot, Deferred, Subresource};
use umbragraph_text::diagnostic::{Code, Diagnostic};
use umbragraph_text::source::Span;

/// An item with a place in a document, at which diagnostics can be reported.
pub trait Located {
    /// The place of the item, and its JSON pointer.
    fn location(&self) -> (Span, &str);

    /// Creates an error at the place of the item.
    fn error(&self, code: Code, message: String) -> Diagnostic {
        let (place, pointer) = self.location();
        Diagnostic::error(code, place, message).pointer(pointer)
    }
}

macro_rules! located {
    ($($name:ty),*) => {$(
        impl Located for $name {
            fn location(&self) -> (Span, &str) {
                (self.place, &self.pointer)
            }
        }
    )*};
}

located!(Access, BoundSlot, Deferred, Pass, Passthrough, Subresource);

impl Pass {
    /// Returns the first access for which `is_meant` returns `true`, or the pass itself if there is none.
    pub fn access_or_self(&self, is_meant: impl Fn(&Access) -> bool) -> &dyn Located {
        self.accesses.iter().find(|one| is_meant(one)).map_or(self, |one| one)
    }
}

impl Resource {
    /// Creates an error at a setting of the resource's declaration; `setting` is a JSON pointer within the declaration.
    pub fn error_at(&self, setting: &str, code: Code, message: String) -> Diagnostic {
        let place = self.value.nearest(setting).span;
        Diagnostic::error(code, place, message).pointer(format!("{}{setting}", self.pointer))
    }
}
