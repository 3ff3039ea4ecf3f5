//! `--report`: what changes from frame to frame, as JSON.
//!
//! Of each frame but the first, the share of the points that the frame before saw too whose shadow term is another one
//! ([`umbragraph::reprojection`]), and what each pass has drawn of the scene and left as it was. The picture is the
//! shadow term; depth is the texture `depth`, the camera's matrix that of the data `eye`.

use std::path::Path;

use serde_json::json;
use umbragraph::capture::Capture;
use umbragraph::diagnostic::{Diagnostic, Place, codes};
use umbragraph::executor::{Executor, PassCounts, Texels};
use umbragraph::reprojection::{Changes, Seen, changes};

use crate::replace::{replace, unwritable};

/// What is read back of each frame.
pub(super) fn depth() -> Capture {
    Capture { reference: "depth".to_owned(), mip: 0 }
}

/// What is known of some frames.
#[derive(Default)]
pub(crate) struct Report {
    before: Option<Kept>,
    frames: Vec<serde_json::Value>,
    changes: Changes,
}

/// What is kept of a frame for the next one.
struct Kept {
    size: [u32; 2],
    clip_from_world: glam::DMat4,
    reverse: bool,
    depth: Vec<f32>,
    values: Vec<f32>,
}

impl Kept {
    fn seen(&self) -> Seen<'_> {
        Seen {
            size: self.size,
            clip_from_world: self.clip_from_world,
            depth: &self.depth,
            far_depth: if self.reverse { 0.0 } else { 1.0 },
            values: &self.values,
        }
    }
}

impl Report {
    /// Takes in a frame: its picture, 8 bits a channel, and its depth.
    ///
    /// # Errors
    /// A pipeline that has no camera of the name.
    pub(super) fn frame(
        &mut self,
        executor: &Executor,
        (picture, depth): (&[u8], &Texels),
        time: f64,
    ) -> Result<(), Diagnostic> {
        let view = executor.data("eye").and_then(|data| data.views().first()).ok_or_else(|| {
            Diagnostic::error(codes::CAPTURE, Place::Nowhere, "a report needs the camera's data \"eye\"")
                .help("let a camera node publish it: { \"camera\": { \"to\": \"eye\" } }")
        })?;
        let kept = Kept {
            size: [depth.width, depth.height],
            clip_from_world: view.clip_from_world,
            reverse: view.reverse,
            depth: depth.values.iter().map(|texel| texel[0]).collect(),
            values: picture.chunks_exact(4).map(|pixel| f32::from(pixel[0]) / 255.0).collect(),
        };
        let found = self.before.as_ref().map(|before| changes(&before.seen(), &kept.seen()));
        self.changes += found.unwrap_or_default();
        let passes: serde_json::Map<_, _> = executor
            .pass_counts()
            .map(|(name, PassCounts { views, kept, draws, texels })| {
                let counts = json!({ "views": views, "kept": kept, "draws": draws, "texels": texels });
                (name.to_owned(), counts)
            })
            .collect();
        self.frames.push(json!({
            "time": time,
            "points": found.map(|found| found.points),
            "changed": found.map(|found| found.changed),
            "passes": passes,
        }));
        self.before = Some(kept);
        Ok(())
    }

    /// Writes the report; what is said of it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write(&self, path: &Path) -> Result<String, Diagnostic> {
        let Changes { points, changed } = self.changes;
        let share = self.changes.share();
        let report = json!({ "points": points, "changed": changed, "share": share, "frames": self.frames });
        replace(path, format!("{report:#}\n")).map_err(|error| unwritable(path, &error))?;
        let percent = 100.0 * share;
        Ok(format!("{}: the shadow term of {percent:.4} % of {points} points changed\n", path.display()))
    }
}
