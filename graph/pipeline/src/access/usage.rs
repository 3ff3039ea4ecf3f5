//! Usages: the ways in which passes use resources.

use crate::access::subresource_range::Aspect;

/// The way in which a pass uses a resource, such as a sampled texture or a color attachment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Usage {
    /// A sampled texture binding.
    Sampled,
    /// A uniform buffer binding.
    Uniform,
    /// A storage binding that is read.
    StorageRead,
    /// A storage binding that is only written; contents that the shader does not write are kept.
    StorageWrite,
    /// A storage binding that overwrites all of a subresource range.
    StorageReplace,
    /// A storage binding that is read and written.
    StorageReadWrite,
    /// A color attachment whose contents are not needed.
    ColorAttachment,
    /// A color attachment that is loaded.
    ColorAttachmentLoad,
    /// A depth attachment whose contents are not needed.
    DepthAttachment,
    /// A depth attachment that is loaded and written.
    DepthAttachmentLoad,
    /// A depth attachment that is only tested against.
    DepthAttachmentReadOnly,
    /// A stencil attachment whose contents are not needed.
    StencilAttachment,
    /// A stencil attachment that is loaded and written.
    StencilAttachmentLoad,
    /// A stencil attachment that is only tested against.
    StencilAttachmentReadOnly,
    /// The target of a multisample resolve.
    ResolveTarget,
    /// A vertex buffer.
    Vertex,
    /// An index buffer.
    Index,
    /// A buffer with the indirect arguments of a draw or a dispatch.
    Indirect,
    /// The source of a copy.
    CopySource,
    /// The destination of a copy that overwrites all of a subresource range.
    CopyDestination,
    /// The destination of a copy that keeps the rest of a subresource range.
    CopyDestinationLoad,
    /// A buffer as the destination of rows of texels. Bytes between the rows are kept, and need not be initialised.
    CopyDestinationRows,
    /// Blackboard data that is read.
    BlackboardRead,
    /// Blackboard data that is published.
    BlackboardWrite,
}

/// The effect of a usage on the contents of a resource.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Effect {
    Reads,
    /// Reads and writes.
    Loads,
    /// Writes without needing earlier contents, though not all of them may be overwritten.
    Writes,
    /// Overwrites all of a subresource range.
    Replaces,
}

impl Usage {
    /// The effect of the usage, the flags that a texture and a buffer must be created with, and its name in
    /// diagnostics.
    fn properties(self) -> (Effect, wgpu_types::TextureUsages, wgpu_types::BufferUsages, &'static str) {
        use Effect::{Loads, Reads, Replaces, Writes};
        use wgpu_types::{BufferUsages as B, TextureUsages as T};
        const STORAGE: (T, B) = (T::STORAGE_BINDING, B::STORAGE);
        const ATTACHMENT: (T, B) = (T::RENDER_ATTACHMENT, B::empty());
        const DESTINATION: (T, B) = (T::COPY_DST, B::COPY_DST);
        const DATA: (T, B) = (T::empty(), B::empty());
        const fn buffer(usage: B) -> (T, B) {
            (T::empty(), usage)
        }
        let (effect, (texture, buffer), name) = match self {
            Usage::Sampled => (Reads, (T::TEXTURE_BINDING, B::empty()), "sampled texture"),
            Usage::Uniform => (Reads, buffer(B::UNIFORM), "uniform buffer"),
            Usage::StorageRead => (Reads, STORAGE, "read-only storage"),
            Usage::StorageWrite => (Loads, STORAGE, "write-only storage"),
            Usage::StorageReplace => (Replaces, STORAGE, "storage that is replaced"),
            Usage::StorageReadWrite => (Loads, STORAGE, "read-write storage"),
            Usage::ColorAttachment => (Replaces, ATTACHMENT, "color attachment"),
            Usage::ColorAttachmentLoad => (Loads, ATTACHMENT, "color attachment"),
            Usage::DepthAttachment => (Replaces, ATTACHMENT, "depth attachment"),
            Usage::DepthAttachmentLoad => (Loads, ATTACHMENT, "depth attachment"),
            Usage::DepthAttachmentReadOnly => (Reads, ATTACHMENT, "depth attachment"),
            Usage::StencilAttachment => (Replaces, ATTACHMENT, "stencil attachment"),
            Usage::StencilAttachmentLoad => (Loads, ATTACHMENT, "stencil attachment"),
            Usage::StencilAttachmentReadOnly => (Reads, ATTACHMENT, "stencil attachment"),
            Usage::ResolveTarget => (Replaces, ATTACHMENT, "resolve target"),
            Usage::Vertex => (Reads, buffer(B::VERTEX), "vertex buffer"),
            Usage::Index => (Reads, buffer(B::INDEX), "index buffer"),
            Usage::Indirect => (Reads, buffer(B::INDIRECT), "indirect buffer"),
            Usage::CopySource => (Reads, (T::COPY_SRC, B::COPY_SRC), "source of a copy"),
            Usage::CopyDestination => (Writes, DESTINATION, "destination of a copy"),
            Usage::CopyDestinationLoad => {
                (Loads, DESTINATION, "destination of a copy of a subresource range")
            }
            Usage::CopyDestinationRows => (Loads, DESTINATION, "destination of rows of texels"),
            Usage::BlackboardRead => (Reads, DATA, "blackboard data"),
            Usage::BlackboardWrite => (Writes, DATA, "published blackboard data"),
        };
        (effect, texture, buffer, name)
    }

    /// Returns `true` if earlier contents are read, or if they are [kept](Self::keeps_what_is_there).
    pub fn reads(self) -> bool {
        matches!(self.properties().0, Effect::Reads | Effect::Loads)
    }

    /// Returns `true` if contents that the pass does not overwrite are kept, but need not be initialised.
    pub fn keeps_what_is_there(self) -> bool {
        matches!(self, Usage::CopyDestinationRows | Usage::StorageWrite)
    }

    /// Returns `true` if the usage writes the resource, which makes a new version of the resource.
    pub fn writes(self) -> bool {
        self.properties().0 != Effect::Reads
    }

    /// Returns `true` for an attachment of a render pass, including a resolve target.
    pub fn is_attachment(self) -> bool {
        self.texture_usages() == wgpu_types::TextureUsages::RENDER_ATTACHMENT
    }

    /// Returns `true` for a depth attachment.
    pub fn is_depth(self) -> bool {
        matches!(self, Usage::DepthAttachment | Usage::DepthAttachmentLoad | Usage::DepthAttachmentReadOnly)
    }

    /// Returns `true` for a stencil attachment.
    pub fn is_stencil(self) -> bool {
        use Usage as U;
        matches!(self, U::StencilAttachment | U::StencilAttachmentLoad | U::StencilAttachmentReadOnly)
    }

    /// The aspect of a depth or stencil attachment; [`Aspect::All`] for all other usages.
    pub fn aspect(self) -> Aspect {
        match self {
            _ if self.is_depth() => Aspect::DepthOnly,
            _ if self.is_stencil() => Aspect::StencilOnly,
            _ => Aspect::All,
        }
    }

    /// Returns `true` if the usage certainly overwrites all contents of its subresource range.
    pub fn replaces_contents(self) -> bool {
        self.properties().0 == Effect::Replaces
    }

    /// The usage flags that a texture must be created with.
    pub fn texture_usages(self) -> wgpu_types::TextureUsages {
        self.properties().1
    }

    /// The usage flags that a buffer must be created with.
    pub fn buffer_usages(self) -> wgpu_types::BufferUsages {
        self.properties().2
    }

    /// The name of the usage for messages, such as `sampled texture`.
    pub fn name(self) -> &'static str {
        self.properties().3
    }
}
