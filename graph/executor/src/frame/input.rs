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
    /// The host's meshes, if the pipeline draws any: the same in each frame, or else of another generation.
    pub draws: Option<&'a dyn DrawSource>,
    /// The host's textures by the names of the resources that they stand for.
    pub imports: FrameImports<'a>,
    /// The toggles that are switched otherwise than the pipeline says, by their names; the later of two counts. Nothing
    /// is planned or compiled for it; bind groups of a state are made when it comes up for the first time.
    pub toggles: &'a [(&'a str, bool)],
}

impl<'a> Frame<'a> {
    /// A frame without meshes, textures of the host's, or toggles.
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
