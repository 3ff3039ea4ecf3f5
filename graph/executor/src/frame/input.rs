//! The input of one frame.

use umbragraph_pipeline::frame::FrameInput;

use crate::binding::draw::DrawSource;
use crate::memory::imports::FrameImports;

/// The input of [`Executor::record`](crate::Executor::record) for one frame: camera, lights, meshes, imports and
/// toggles.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct Frame<'a> {
    /// The camera, the lights, and the bounds of the scene.
    pub input: &'a FrameInput,
    /// The source of the host's meshes; `None` if the pipeline draws none. A source that replaces another must return a
    /// different [`DrawSource::generation`].
    pub draws: Option<&'a dyn DrawSource>,
    /// The host's textures, by the names of the imported resources.
    pub imports: FrameImports<'a>,
    /// The states of runtime toggles, as pairs of name and on (`true`) or off. Toggles that are not listed keep the
    /// pipeline's defaults; of several entries with one name, the last counts. Toggling needs no planning or
    /// compilation, only new bind groups when a combination first occurs.
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
    /// Import::new(&texture)), ("detail", Import::mip(&texture, 2))]`. For this frame, these override textures that
    /// were set with [`Executor::give`](crate::Executor::give).
    #[must_use]
    pub fn imports(self, imports: impl Into<FrameImports<'a>>) -> Self {
        Self { imports: imports.into(), ..self }
    }

    /// Sets the states of the toggles that differ from the pipeline's defaults, by name; `true` is on.
    #[must_use]
    pub fn toggles(self, toggles: &'a [(&'a str, bool)]) -> Self {
        Self { toggles, ..self }
    }
}
