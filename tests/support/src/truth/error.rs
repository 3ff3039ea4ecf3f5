//! Errors of the truth, or of a picture that is compared with it.

use std::fmt;
use std::path::PathBuf;

use crate::image::PictureError;

/// Why no score can be given.
#[derive(Debug)]
pub enum TruthError {
    /// A mask or a picture cannot be read.
    Picture(PictureError),
    /// A mask of the scene is not as large as its `hit` mask.
    MaskSize {
        /// The mask.
        path: PathBuf,
        /// The size of the `hit` mask.
        expected: (u32, u32),
        /// The size of this one.
        actual: (u32, u32),
    },
    /// The picture is not as large as the scene's masks.
    PictureSize {
        /// The size of the masks.
        expected: (u32, u32),
        /// The size of the picture.
        actual: (u32, u32),
    },
    /// The picture is not grey.
    NotGrey {
        /// The column of the first pixel with colour.
        x: u32,
        /// The row of that pixel.
        y: u32,
    },
    /// The file with the limits cannot be read or understood.
    Limits {
        /// The file.
        path: PathBuf,
        /// The reason.
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
