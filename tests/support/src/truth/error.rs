//! Errors of the truth, or of a picture that is compared with it.

use std::fmt;
use std::path::PathBuf;

use crate::image::PictureError;

/// The reason why a picture cannot be scored.
#[derive(Debug)]
pub enum TruthError {
    /// A mask or a picture cannot be read.
    Picture(PictureError),
    /// A mask of the scene differs in size from its `hit` mask.
    MaskSize {
        /// The path of the mask.
        path: PathBuf,
        /// The size of the `hit` mask, in pixels.
        expected: (u32, u32),
        /// The size of the mask at `path`, in pixels.
        actual: (u32, u32),
    },
    /// The picture differs in size from the scene's masks.
    PictureSize {
        /// The size of the masks, in pixels.
        expected: (u32, u32),
        /// The size of the picture, in pixels.
        actual: (u32, u32),
    },
    /// The picture is not grey.
    NotGrey {
        /// The column of the first pixel with colour.
        x: u32,
        /// The row of the first pixel with colour.
        y: u32,
    },
    /// The file with the limits cannot be read or parsed.
    Limits {
        /// The path of the file.
        path: PathBuf,
        /// The description of the error.
        reason: String,
    },
}

impl fmt::Display for TruthError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Picture(error) => error.fmt(formatter),
            Self::MaskSize { path, expected, actual } => write!(
                formatter,
                "{} is {}x{} pixels, the hit mask of its scene {}x{}",
                path.display(),
                actual.0,
                actual.1,
                expected.0,
                expected.1
            ),
            Self::PictureSize { expected, actual } => write!(
                formatter,
                "the picture is {}x{} pixels, the truth {}x{}",
                actual.0, actual.1, expected.0, expected.1
            ),
            Self::NotGrey { x, y } => write!(
                formatter,
                "the picture has colour at column {x}, row {y}; raw visibility in grey is wanted"
            ),
            Self::Limits { path, reason } => write!(formatter, "{}: {reason}", path.display()),
        }
    }
}

impl std::error::Error for TruthError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Picture(error) => Some(error),
            _ => None,
        }
    }
}

impl From<PictureError> for TruthError {
    fn from(error: PictureError) -> Self {
        Self::Picture(error)
    }
}
