//! Files of camera paths.

use umbragraph::frame::{Bounds, Camera, Projection};
use umbragraph::glam::{DQuat, DVec3};
use umbragraph::low_level::camera_path::{CameraArgument, CameraPath};
use umbragraph_test_support::scratch::ScratchFolder;

use crate::mutation::{self, Choices};
use crate::worker::note;

const TEXT: &str = r#"{ "keys": [
  { "time": 0, "position": [0, 1.5, 4], "target": [0, 1, 0] },
  { "time": 1.25, "position": [2e3, 1.5, -4], "target": [0, 1, 0.5] },
  { "time": 8, "position": [2, 1.5, -4], "target": [2, 1.5, -4.5] }
] }
"#;

/// A camera that can be used at each time, or an error.
pub(crate) fn cameras(choices: &mut Choices<'_>) {
    let text = mutation::changed(TEXT, "1e300 -0.0 1e-300 12345678901234567890", choices);
    note(text.as_bytes());
    thread_local!(static FOLDER: ScratchFolder = ScratchFolder::new("fuzz-cameras"));
    let path = FOLDER.with(|folder| folder.join("keys.json"));
    std::fs::write(&path, &text).expect("a folder of our own can be written");
    let Ok(path) = CameraPath::of(Some(&CameraArgument::File(path))) else { return };
    let projection = Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 };
    let scene = Camera::new(DVec3::ZERO, DQuat::IDENTITY, projection, 1.5);
    let bounds = Bounds { min: DVec3::splat(-4.0), max: DVec3::splat(4.0) };
    let time = f64::from(choices.number::<i16>()) / 100.0;
    for time in [0.0, time, 1e9] {
        let camera = path.camera(scene, &bounds, None, [0.0, 0.5, time]);
        assert_eq!(camera.check(), None, "at {time}");
    }
}
