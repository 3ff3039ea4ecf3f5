//! A resource of a pipeline: its kind, and its lifetime.

use std::sync::Arc;

use crate::data::DataShape;
use crate::pipeline::names::environment::Environment;
use crate::work::ResourceHandle;
use umbragraph_text::language::{BufferDeclaration, Lifetime, TextureDeclaration};
use umbragraph_text::source::Span;

/// A resource of a pipeline: a texture, a buffer or blackboard data.
#[derive(Clone, Debug)]
pub struct Resource {
    /// The name of the resource.
    pub name: String,
    /// The place of the declaration; for blackboard data, the place where the publishing pass names the data.
    pub place: Span,
    /// The JSON pointer of the declaration; for blackboard data, of the place that names the data.
    pub pointer: String,
    /// The JSON value of the declaration; for blackboard data, null at the place that first names the data.
    pub value: umbragraph_text::document::Value,
    /// The scope of names for expressions in the declaration.
    pub environment: Arc<Environment>,
    /// The kind of the resource.
    pub kind: ResourceKind,
    /// The position of the resource in a history of frames; `None` if earlier frames of the resource are not kept.
    pub history: Option<History>,
}

impl Resource {
    /// Returns `true` for an earlier frame of a history, which passes can only read.
    pub fn is_earlier_frame(&self) -> bool {
        self.history.is_some_and(|history| history.back > 0)
    }

    /// Returns `true` if the host accesses the resource between frames.
    pub fn is_exposed(&self) -> bool {
        match &self.kind {
            ResourceKind::Texture(texture) => texture.exposed,
            ResourceKind::Buffer(buffer) => buffer.exposed,
            ResourceKind::Data(_) | ResourceKind::Broken => false,
        }
    }

    /// The lifetime of the resource's memory: an exposed transient resource counts as persistent.
    pub fn lifetime(&self) -> Lifetime {
        match self.declared_lifetime() {
            Lifetime::Transient if self.is_exposed() => Lifetime::Persistent,
            declared => declared,
        }
    }

    /// The declared lifetime of the contents; transient for blackboard data.
    pub fn declared_lifetime(&self) -> Lifetime {
        match &self.kind {
            ResourceKind::Texture(texture) => texture.lifetime,
            ResourceKind::Buffer(buffer) => buffer.lifetime,
            ResourceKind::Data(_) | ResourceKind::Broken => Lifetime::Transient,
        }
    }

    /// The declaration of a texture; `None` for other resources.
    pub fn texture(&self) -> Option<&TextureDeclaration> {
        match &self.kind {
            ResourceKind::Texture(texture) => Some(texture),
            _ => None,
        }
    }

    /// The name of the kind for messages, with an article.
    pub fn kind_name(&self) -> &'static str {
        match self.kind {
            ResourceKind::Texture(_) => "a texture",
            ResourceKind::Buffer(_) => "a buffer",
            ResourceKind::Data(_) => "blackboard data",
            ResourceKind::Broken => "broken",
        }
    }
}

/// The kind of a resource, with its declaration.
#[derive(Clone, Debug)]
pub enum ResourceKind {
    /// A texture.
    Texture(Box<TextureDeclaration>),
    /// A buffer.
    Buffer(Box<BufferDeclaration>),
    /// Blackboard data: values and views; `None` until the publishing pass is declared.
    Data(Option<DataShape>),
    /// A declaration with errors: nothing is known of the resource, and no further diagnostics are reported about it.
    Broken,
}

/// The position of a resource in a history, which keeps the contents of earlier frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct History {
    /// The resource that the current frame writes.
    pub of: ResourceHandle,
    /// The age of the contents in frames; 0 for the resource that the current frame writes.
    pub back: u32,
    /// The number of earlier frames that can be read. Their resources follow the current frame's resource in the list
    /// of resources, the newest first.
    pub frames: u32,
}

impl History {
    /// The resources of a history, from the current frame to the oldest frame.
    pub fn members(self) -> impl Iterator<Item = ResourceHandle> {
        (self.of.0..=self.of.0 + self.frames).map(ResourceHandle)
    }
}
