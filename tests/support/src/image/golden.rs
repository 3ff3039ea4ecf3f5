//! Golden pictures: references kept in the tree, against which tests compare what they render.
//!
//! * The reference of `NAME` is `NAME.png` in the golden folder. A missing reference is a failure: a test without
//!   its reference tests nothing.
//! * On a failure the actual picture and the picture of the differences are written under the target folder, and
//!   the message names both and the command that accepts the new picture.
//! * With `UMBRAGRAPH_BLESS=1` the actual picture becomes the reference, but only where it does not match: a
//!   reference within the tolerance stays as it is, and so does the history of the repository.

use std::path::{Path, PathBuf};

use super::comparison::{Comparison, Tolerance, compare};
use super::picture::Picture;
use crate::{environment, skip};

/// A folder of reference pictures, and a folder for the output of failing tests.
#[derive(Clone, Debug)]
pub struct GoldenFolder {
    references: PathBuf,
    output: PathBuf,
    bless: bool,
}

/// The verdict on a picture that was compared with its reference.
#[must_use = "a verdict that nobody looks at lets every picture pass"]
#[derive(Debug)]
pub enum Verdict {
    /// The picture matches its reference.
    Matches(Comparison),
    /// The picture was stored as the new reference, at this path.
    Blessed(PathBuf),
    /// The picture does not match, or has no reference; the message explains the problem and the remedy.
    Failed(String),
}

impl GoldenFolder {
    /// Opens the folder at a path; relative paths begin at the root of the workspace.
    pub fn new(references: impl AsRef<Path>) -> Self {
        let lookup = &environment::process;
        Self {
            references: environment::workspace_root().join(references),
            output: environment::target_folder(lookup).join("golden"),
            bless: environment::is_set(lookup, environment::BLESS),
        }
    }

    /// Returns the path of the reference with a name.
    pub fn reference_path(&self, name: &str) -> PathBuf {
        self.references.join(format!("{name}.png"))
    }

    /// Compares a picture with the reference of this name.
    pub fn check(&self, name: &str, actual: &Picture, tolerance: &Tolerance) -> Verdict {
        let path = self.reference_path(name);
        match Picture::load(&path) {
            Ok(reference) => {
                let comparison = compare(&reference, actual, tolerance);
                if comparison.matches() {
                    Verdict::Matches(comparison)
                } else if self.bless {
                    bless(actual, path)
                } else {
                    Verdict::Failed(self.report(name, actual, &comparison))
                }
            }
            Err(_) if self.bless => bless(actual, path),
            Err(error) => {
                let kept = written(actual, &self.output_path(name, "actual"));
                Verdict::Failed(format!(
                    "golden picture `{name}`: {error}\n  actual picture: {kept}\n  {}",
                    acceptance()
                ))
            }
        }
    }

    fn output_path(&self, name: &str, kind: &str) -> PathBuf {
        self.output.join(format!("{name}.{kind}.png"))
    }

    fn report(&self, name: &str, actual: &Picture, comparison: &Comparison) -> String {
        let difference = comparison.difference_picture().map_or_else(
            || "none, since the sizes differ".to_owned(),
            |picture| written(picture, &self.output_path(name, "difference")),
        );
        format!(
            "golden picture `{name}`: {}\n  reference: {}\n  actual picture: {}\n  differences: {difference}\n  {}",
            comparison.message(),
            self.reference_path(name).display(),
            written(actual, &self.output_path(name, "actual")),
            acceptance(),
        )
    }
}

impl Verdict {
    /// Returns `true` if the picture matches or was stored as the reference.
    pub fn is_success(&self) -> bool {
        !matches!(self, Self::Failed(_))
    }

    /// Fails the test unless the picture matches or was stored as the reference.
    ///
    /// # Panics
    /// If the picture does not match; the message explains the problem and the remedy.
    #[track_caller]
    pub fn expect_match(&self) {
        match self {
            Self::Matches(_) => {}
            Self::Blessed(path) => skip::announce(&format!("blessed {}", path.display())),
            Self::Failed(message) => panic!("{message}"),
        }
    }
}

fn bless(actual: &Picture, path: PathBuf) -> Verdict {
    match actual.save(&path) {
        Ok(()) => Verdict::Blessed(path),
        Err(error) => Verdict::Failed(format!("the new reference could not be kept: {error}")),
    }
}

fn written(picture: &Picture, path: &Path) -> String {
    match picture.save(path) {
        Ok(()) => path.display().to_string(),
        Err(error) => error.to_string(),
    }
}

fn acceptance() -> String {
    let test = skip::test_name().map(|name| format!(" {name}")).unwrap_or_default();
    format!("to accept the new picture: {}=1 cargo nextest run{test}", environment::BLESS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Channels;
    use crate::scratch::ScratchFolder;

    fn golden_in(root: &ScratchFolder, bless: bool) -> GoldenFolder {
        GoldenFolder { references: root.join("references"), output: root.join("output"), bless }
    }

    fn grey(value: u8) -> Picture {
        Picture::filled(8, 8, Channels::Grey, &[value])
    }

    fn failure(verdict: Verdict) -> String {
        match verdict {
            Verdict::Failed(message) => message,
            other => panic!("expected a failure, found {other:?}"),
        }
    }

    #[test]
    fn a_missing_reference_fails_and_names_its_command() {
        let root = ScratchFolder::new("a_missing_reference_fails");
        let golden = golden_in(&root, false);
        let message = failure(golden.check("sun", &grey(1), &Tolerance::EXACT));
        assert!(message.contains("sun.png") && message.contains("UMBRAGRAPH_BLESS=1 cargo nextest run"));
        assert!(golden.output_path("sun", "actual").is_file());
        assert!(!golden.reference_path("sun").exists());
    }

    #[test]
    fn blessing_makes_a_reference_that_then_matches() {
        let root = ScratchFolder::new("blessing_makes_a_reference");
        let mut golden = golden_in(&root, true);
        assert!(matches!(golden.check("sun", &grey(1), &Tolerance::EXACT), Verdict::Blessed(_)));
        golden.bless = false;
        assert!(matches!(golden.check("sun", &grey(1), &Tolerance::EXACT), Verdict::Matches(_)));
        assert!(!golden.check("sun", &grey(2), &Tolerance::EXACT).is_success());
    }

    #[test]
    fn blessing_leaves_a_reference_within_the_tolerance_alone() {
        let root = ScratchFolder::new("blessing_leaves_a_reference");
        let golden = golden_in(&root, true);
        grey(10).save(&golden.reference_path("sun")).unwrap();
        let tolerance = Tolerance { per_channel: 2, failed_pixels: 0 };
        assert!(matches!(golden.check("sun", &grey(12), &tolerance), Verdict::Matches(_)));
        assert_eq!(Picture::load(&golden.reference_path("sun")).unwrap(), grey(10));
    }

    #[test]
    fn a_mismatch_keeps_both_pictures_and_the_reference() {
        let root = ScratchFolder::new("a_mismatch_keeps_both_pictures");
        let golden = golden_in(&root, false);
        grey(10).save(&golden.reference_path("sun")).unwrap();
        let message = failure(golden.check("sun", &grey(200), &Tolerance::EXACT));
        assert!(message.contains("64 of 64 pixels"), "{message}");
        assert_eq!(Picture::load(&golden.output_path("sun", "actual")).unwrap(), grey(200));
        assert!(golden.output_path("sun", "difference").is_file());
        assert_eq!(Picture::load(&golden.reference_path("sun")).unwrap(), grey(10));
    }

    #[test]
    fn a_broken_reference_fails_until_it_is_blessed_over() {
        let root = ScratchFolder::new("a_broken_reference");
        let mut golden = golden_in(&root, false);
        std::fs::create_dir_all(&golden.references).unwrap();
        std::fs::write(golden.reference_path("sun"), b"not a picture").unwrap();
        let message = failure(golden.check("sun", &grey(1), &Tolerance::EXACT));
        assert!(message.contains("not a readable PNG"), "{message}");
        golden.bless = true;
        assert!(matches!(golden.check("sun", &grey(1), &Tolerance::EXACT), Verdict::Blessed(_)));
        assert_eq!(Picture::load(&golden.reference_path("sun")).unwrap(), grey(1));
    }

    #[test]
    #[should_panic(expected = "cargo nextest run")]
    fn an_expected_match_without_a_reference_fails_the_test() {
        let root = ScratchFolder::new("an_expected_match_without_a_reference");
        let golden = golden_in(&root, false);
        golden.check("sun", &grey(1), &Tolerance::EXACT).expect_match();
    }
}
