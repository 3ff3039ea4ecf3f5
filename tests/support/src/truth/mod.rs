//! Ray-traced truth for shadows, and how a rendered shadow mask is scored against it.
//!
//! The truth is a folder of scenes, kept outside the repository: for each, a glTF binary and masks that an
//! independent ray tracer wrote. A test that uses it runs where the folder exists and is skipped, with a count,
//! where it does not.
//!
//! ```no_run
//! use std::path::Path;
//! use umbragraph_test_support::{image::Picture, truth};
//!
//! let Some(scene) = truth::TruthScene::find("contact_sun") else { return };
//! let rendered = Picture::load(Path::new("shadow_term.png")).unwrap();
//! let scores = truth::evaluate(&scene, &rendered).unwrap();
//! truth::check(&scores, &scene.hard_limits().unwrap()).unwrap();
//! ```

mod alignment;
mod difference;
mod error;
mod limits;
mod scene;
mod score;

pub use difference::difference_picture;
pub use error::TruthError;
pub use limits::{Limits, check};
pub use scene::TruthScene;
pub use score::{BANDS, BandScore, Scores, SoftScore, evaluate};
