//! Entries of the document with their places, so that an error can be about them.

use crate::pipeline::pass::{Access, Pass};
use crate::pipeline::resource::Resource;
use crate::pipeline::toggle::Passthrough;
use crate::work::{BoundSlot, Deferred, Subresource};
use umbragraph_text::diagnostic::{Code, Diagnostic};
use umbragraph_text::source::Span;

/// Something that stands at a place of the document.
pub trait Located {
    /// Its place, and its JSON pointer.
    fn location(&self) -> (Span, &str);

    /// An error about it.
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
    /// The first of its accesses that is meant, or the pass itself.
    pub fn access_or_self(&self, is_meant: impl Fn(&Access) -> bool) -> &dyn Located {
        self.accesses.iter().find(|one| is_meant(one)).map_or(self, |one| one)
    }
}

impl Resource {
    /// An error about a setting of its declaration.
    pub fn error_at(&self, setting: &str, code: Code, message: String) -> Diagnostic {
        let place = self.value.nearest(setting).span;
        Diagnostic::error(code, place, message).pointer(format!("{}{setting}", self.pointer))
    }
}
