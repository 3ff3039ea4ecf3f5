//! One scene of the truth: where it is, and its masks.
//!
//! The folder is `../shared/truth` beside the workspace, or the one that `UMBRAGRAPH_TRUTH` names. That it is not
//! there is an everyday matter and skips a test; that it was named and is not there, or that a scene in it cannot
//! be read, is a failure.

use std::path::{Path, PathBuf};

use super::error::TruthError;
use super::limits::Limits;
use crate::image::Picture;
use crate::{environment, skip};

/// A scene with its ray-traced shadow masks; each mask has one value per pixel, row 0 first.
#[derive(Clone, Debug)]
pub struct TruthScene {
    pub(super) name: String,
    pub(super) folder: PathBuf,
    pub(super) width: u32,
    pub(super) height: u32,
    /// Set where the camera ray hits geometry.
    pub(super) hit: Vec<bool>,
    /// Set where the light is visible.
    pub(super) lit: Vec<bool>,
    /// Set for pixels that count in the scores.
    pub(super) evaluated: Vec<bool>,
    /// The highest band that the pixel belongs to; it also belongs to all lower bands.
    pub(super) band: Vec<u8>,
    /// Set where a very near occluder casts the shadow; empty if the scene has no contact mask.
    pub(super) contact: Vec<bool>,
    /// The visible fraction of an area light, 255 for all of it; empty if the scene has no such mask.
    pub(super) soft: Vec<u8>,
}

impl TruthScene {
    /// Finds a scene. Returns `None`, and counts the test as skipped, if this machine has no ray-traced reference data.
    ///
    /// # Panics
    /// If the data exists, or `UMBRAGRAPH_TRUTH` is set, and the scene cannot be read.
    #[must_use]
    pub fn find(name: &str) -> Option<Self> {
        let (folder, named) = truth_folder(&environment::process);
        if !folder.is_dir() {
            assert!(!named, "{} names {}, which is no folder", environment::TRUTH, folder.display());
            skip::skipped("no ray-traced truth on this machine");
            return None;
        }
        match Self::load(&folder, name) {
            Ok(scene) => Some(scene),
            Err(error) => panic!("the truth of scene `{name}` cannot be used: {error}"),
        }
    }

    /// Reads a scene from a folder.
    pub fn load(folder: &Path, name: &str) -> Result<Self, TruthError> {
        let path = |mask: &str| folder.join(format!("{name}.{mask}.png"));
        let hit = Picture::load(&path("hit"))?;
        let size = (hit.width(), hit.height());
        let mask = |kind: &str| -> Result<Vec<u8>, TruthError> {
            let path = path(kind);
            let picture = Picture::load(&path)?;
            let actual = (picture.width(), picture.height());
            if actual != size {
                return Err(TruthError::MaskSize { path, expected: size, actual });
            }
            Ok(first_channel(&picture))
        };
        let set = |values: Vec<u8>| values.into_iter().map(|value| value != 0).collect::<Vec<_>>();
        let contact = if path("contact").exists() { set(mask("contact")?) } else { Vec::new() };
        let soft = if path("soft").exists() { mask("soft")? } else { Vec::new() };
        Ok(Self {
            name: name.to_owned(),
            folder: folder.to_owned(),
            width: size.0,
            height: size.1,
            hit: set(first_channel(&hit)),
            lit: set(mask("hard")?),
            evaluated: set(mask("eval")?),
            band: mask("edge")?,
            contact,
            soft,
        })
    }

    /// The name of the scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The path of the scene as a glTF binary.
    pub fn glb_path(&self) -> PathBuf {
        self.folder.join(format!("{}.glb", self.name))
    }

    /// The width and height of the masks in pixels; a scored picture must have the same size.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Loads the limits that a good implementation of hard shadows meets on this scene.
    pub fn hard_limits(&self) -> Result<Limits, TruthError> {
        Limits::load(&self.folder.join("limits_hard.json"), &self.name)
    }

    /// Loads the limits that a good implementation of soft shadows meets on this scene.
    pub fn soft_limits(&self) -> Result<Limits, TruthError> {
        Limits::load(&self.folder.join("limits_soft.json"), &self.name)
    }
}

/// Returns the folder with the ray-traced data, and `true` if the environment variable names it.
fn truth_folder(lookup: environment::Lookup<'_>) -> (PathBuf, bool) {
    match lookup(environment::TRUTH) {
        Some(folder) if !folder.is_empty() => (environment::workspace_root().join(folder), true),
        _ => (environment::workspace_root().join("../shared/truth"), false),
    }
}

fn first_channel(picture: &Picture) -> Vec<u8> {
    picture.rgba_pixels().map(|pixel| pixel[0]).collect()
}

/// Returns a scene of 8 by 8 evaluated pixels whose top four rows are in shadow.
#[cfg(test)]
pub(super) fn half_shadowed() -> TruthScene {
    let rows = || (0..64).map(|pixel| pixel / 8);
    TruthScene {
        name: "half".to_owned(),
        folder: PathBuf::new(),
        width: 8,
        height: 8,
        hit: vec![true; 64],
        lit: rows().map(|row| row >= 4).collect(),
        evaluated: vec![true; 64],
        band: rows().map(|row: usize| [4, 3, 2, 0, 0, 2, 3, 4][row]).collect(),
        contact: rows().map(|row| row == 2).collect(),
        soft: rows().map(|row: usize| [0, 0, 0, 51, 204, 255, 255, 255][row]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Channels;
    use crate::scratch::ScratchFolder;
    use std::ffi::OsString;

    fn write(folder: &Path, mask: &str, width: u32, values: &[u8]) {
        let height = values.len() as u32 / width;
        let picture = Picture::new(width, height, Channels::Grey, values.to_vec()).unwrap();
        picture.save(&folder.join(format!("small.{mask}.png"))).unwrap();
    }

    fn small_scene(test: &str) -> ScratchFolder {
        let folder = ScratchFolder::new(test);
        write(&folder, "hit", 2, &[255, 255, 255, 0]);
        write(&folder, "hard", 2, &[255, 0, 0, 255]);
        write(&folder, "eval", 2, &[255, 255, 0, 0]);
        write(&folder, "edge", 2, &[0, 1, 2, 9]);
        folder
    }

    #[test]
    fn a_scene_is_read_from_its_masks() {
        let folder = small_scene("a_scene_is_read_from_its_masks");
        let scene = TruthScene::load(&folder, "small").unwrap();
        assert_eq!(scene.size(), (2, 2));
        assert_eq!(scene.hit, [true, true, true, false]);
        assert_eq!(scene.lit, [true, false, false, true]);
        assert_eq!(scene.evaluated, [true, true, false, false]);
        assert_eq!(scene.band, [0, 1, 2, 9]);
        assert!(scene.contact.is_empty());
        assert_eq!(scene.glb_path(), folder.join("small.glb"));
    }

    #[test]
    fn a_missing_mask_and_a_mask_of_another_size_are_errors() {
        let folder = small_scene("a_missing_mask_and_a_mask_of_another_size");
        write(&folder, "contact", 1, &[0, 0, 0]);
        let error = TruthScene::load(&folder, "small").unwrap_err();
        assert!(matches!(error, TruthError::MaskSize { actual: (1, 3), .. }), "{error}");
        std::fs::remove_file(folder.join("small.contact.png")).unwrap();
        std::fs::remove_file(folder.join("small.edge.png")).unwrap();
        let error = TruthScene::load(&folder, "small").unwrap_err();
        assert!(error.to_string().contains("small.edge.png"), "{error}");
    }

    #[test]
    fn a_named_folder_comes_before_the_one_beside_the_workspace() {
        let named = |_: &str| Some(OsString::from("/somewhere"));
        assert_eq!(truth_folder(&named), (PathBuf::from("/somewhere"), true));
        let (folder, named) = truth_folder(&|_| None);
        assert!(folder.ends_with("shared/truth") && !named);
    }
}
