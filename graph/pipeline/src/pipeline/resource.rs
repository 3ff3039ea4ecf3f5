//! A resource of a pipeline: its kind, and its lifetime.

use std::sync::Arc;

use crate::data::DataShape;
use crate::pipeline::names::environment::Environment;
use crate::work::ResourceHandle;
use umbragraph_text::language::{BufferDeclaration, Lifetime, TextureDeclaration};
use umbragraph_text::source::Span;

/// A resource of a pipeline.
#[derive(Clone, Debug)]
pub struct Resource {
    /// Its name.
    pub name: String,
    /// The place of its declaration; for blackboard data, the place where the publishing pass names it.
    pub place: Span,
    /// Its JSON pointer.
    pub pointer: String,
    /// The declaration as it is written; for blackboard data, the value that names it.
    pub value: umbragraph_text::document::Value,
    /// The scope of names in its declaration.
    pub environment: Arc<Environment>,
    /// The kind.
    pub kind: ResourceKind,
    /// For a history, which of its frames it is.
    pub history: Option<History>,
}

impl Resource {
    /// Whether it is an earlier frame of a history, which can only be read.
    pub fn is_earlier_frame(&self) -> bool {
        self.history.is_some_and(|history| history.back > 0)
    }

    /// Whether the host looks at it between frames.
    pub fn is_exposed(&self) -> bool {
        match &self.kind {
            ResourceKind::Texture(texture) => texture.exposed,
            ResourceKind::Buffer(buffer) => buffer.exposed,
            ResourceKind::Data(_) | ResourceKind::Broken => false,
        }
    }

    /// Its lifetime; what is exposed keeps its memory from frame to frame.
    pub fn lifetime(&self) -> Lifetime {
        match self.declared_lifetime() {
            Lifetime::Transient if self.is_exposed() => Lifetime::Persistent,
            declared => declared,
        }
    }

    /// The lifetime of what is in it.
    pub fn declared_lifetime(&self) -> Lifetime {
        match &self.kind {
            ResourceKind::Texture(texture) => texture.lifetime,
            ResourceKind::Buffer(buffer) => buffer.lifetime,
            ResourceKind::Data(_) | ResourceKind::Broken => Lifetime::Transient,
        }
    }

    /// The texture's declaration, if it is one.
    pub fn texture(&self) -> Option<&TextureDeclaration> {
        match &self.kind {
            ResourceKind::Texture(texture) => Some(texture),
            _ => None,
        }
    }

    /// The kind in words, with an article.
    pub fn kind_name(&self) -> &'static str {
        match self.kind {
            ResourceKind::Texture(_) => "a texture",
            ResourceKind::Buffer(_) => "a buffer",
            ResourceKind::Data(_) => "blackboard data",
            ResourceKind::Broken => "broken",
        }
    }
}

/// The kind of a resource.
#[derive(Clone, Debug)]
pub enum ResourceKind {
    /// A texture.
    Texture(Box<TextureDeclaration>),
    /// A buffer.
    Buffer(Box<BufferDeclaration>),
    /// Blackboard data: values and views; `None` until the pass that publishes it is declared.
    Data(Option<DataShape>),
    /// A declaration with diagnostics of its own: nothing is known, and nothing is said of it.
    Broken,
}

/// The position of a resource in a history.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct History {
    /// The resource that this frame writes.
    pub of: ResourceHandle,
    /// The number of frames back; 0 for the resource that this frame writes.
    pub back: u32,
    /// The number of earlier frames that can be read. Their resources follow that of this frame, in the order of their
    /// age.
    pub frames: u32,
}

impl History {
    /// The resources of a history: this frame's, and those of earlier frames.
    pub fn members(self) -> impl Iterator<Item = ResourceHandle> {
        (self.of.0..=self.of.0 + self.frames).map(ResourceHandle)
    }
}
