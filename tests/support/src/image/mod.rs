//! Pictures for tests: 8-bit PNG in and out, comparison under a tolerance, golden pictures.
//!
//! ```
//! use umbragraph_test_support::image::{compare, Channels, Picture, Tolerance};
//!
//! let white = Picture::filled(4, 4, Channels::Grey, &[255]);
//! compare(&white, &white, &Tolerance::EXACT).expect_match();
//! ```

mod comparison;
mod golden;
mod picture;

pub use comparison::{Comparison, MaxDifference, Tolerance, compare};
pub use golden::{GoldenFolder, Verdict};
pub use picture::{Channels, Picture, PictureError};
