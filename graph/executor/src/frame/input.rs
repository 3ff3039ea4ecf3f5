//! The input of one frame.

use umbragraph_pipeline::frame::FrameInput;

use crate::binding::draw::DrawSource;
use crate::memory::imports::FrameImports;

/// The input of one frame.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct Frame<'a> {
    /// Camera, lights and bounds.
    pub input: &'a FrameInput,
    /// The host's meshes, if the pipeline draws any. If another source replaces this one, its generation must differ.
    pub draws: Option<&'a dyn DrawSource>,
    /// The host's textures, by the names of the imported resources.
    pub imports: FrameImports<'a>,
    /// The toggles that differ from the pipeline's defaults, by name; the last entry of a name counts. Toggles need no
    /// planning or compilation; bind groups for a combination are created when it first occurs.
    pub toggles: &'a [(&'a str, bool)],
}

impl<'a> Frame<'a> {
    /// Creates a frame without meshes, imported textures or toggles.
    pub fn new(input: &'a FrameInput) -> Self {
        Self { input, draws: None, imports: FrameImports::default(), toggles: &[] }
    }

    /// Sets the host's meshes.
    #[must_use]
    pub fn draws(self, draws: &'a dyn DrawSource) -> Self {
        Self { draws: Some(draws), ..self }
    }

    /// Sets the host's textures, or parts of them, by name: `&[("target", &texture)]`, or `&[("target",
    /// Import::new(&texture)), ("detail", Import::mip(&texture, 2))]`. They override textures that were
    /// [given](crate::Executor::give).
    #[must_use]
    pub fn imports(self, imports: impl Into<FrameImports<'a>>) -> Self {
        Self { imports: imports.into(), ..self }
    }

    /// Sets the toggles that differ from the pipeline's defaults.
    #[must_use]
    pub fn toggles(self, toggles: &'a [(&'a str, bool)]) -> Self {
        Self { toggles, ..self }
    }
}
