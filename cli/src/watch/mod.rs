//! `umbragraph watch`: checks pipelines whenever one of their files changes.
//!
//! Files are compared by size and time of change ten times a second, which sees whatever an editor does, on network
//! mounts as well. After a change only files whose diagnostics differ are printed, each with all that is to be said of
//! it:
//!
//! ```text
//! watch: pipelines/frame.json
//! pipelines/frame.json:11:34: error[UG0301]: there is no resource "colour"; did you mean "color"?
//! checked: 1 error, 0 warnings in 0.21 s
//! ```
//!
//! The first line is the beginning and the last one the end of a background task of Visual Studio Code; the lines
//! between them are for its problem matcher, which `umbragraph new` writes.

mod files;
#[cfg(feature = "gpu")]
mod picture;
mod problems;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::arguments::WatchArguments;
use crate::session::Session;
use crate::streams;
use files::Stamps;
#[cfg(feature = "gpu")]
use picture::Painter;
use problems::Problems;

/// The time between two checks for changed files.
const INTERVAL: Duration = Duration::from_millis(100);

/// Checks the pipelines at each change, until the process ends or the reader closes standard output. Returns `false` if
/// standard output could not be written.
pub(crate) fn run(arguments: &WatchArguments) -> bool {
    let mut session = Session::new(&arguments.choices.files);
    let mut problems = Problems::default();
    #[cfg(feature = "gpu")]
    let mut painter = arguments.render.as_ref().zip(arguments.scene.as_ref()).map(Painter::new);
    let mut known = Stamps::default();
    let mut is_first = true;
    loop {
        let mut now = Stamps::of(known.paths().chain(given(arguments)));
        if is_first || now != known {
            // Half of a change is rarely a pipeline.
            loop {
                std::thread::sleep(INTERVAL / 4);
                let later = Stamps::of(now.paths());
                if later == now {
                    break;
                }
                now = later;
            }
            let start = Instant::now();
            if !is_first {
                session.again(&arguments.choices.files);
            }
            // Before the check, so that what changes meanwhile is seen.
            known = now.with(session.paths(&arguments.pipelines, &arguments.choices.files.extension));
            #[cfg(feature = "gpu")]
            if let (Some(painter), Some(first)) = (&mut painter, arguments.pipelines.first()) {
                let painted = painter.paint(first, &arguments.choices, &mut session);
                session.diagnostics.extend(painted.err().into_iter().flatten());
                known = known.and(painter.stamps());
            }
            for path in &arguments.pipelines {
                if session.check_part(path).is_none() {
                    session.check_all(path, &arguments.choices, arguments.config, false);
                }
            }
            session.arrange();
            problems.print(&session, start, is_first);
            is_first = false;
        }
        if streams::is_closed() || streams::is_lost() {
            return !streams::is_lost();
        }
        std::thread::sleep(INTERVAL);
    }
}

/// Returns the files and folders that the command line names.
fn given(arguments: &WatchArguments) -> impl Iterator<Item = &Path> {
    let files = &arguments.choices.files;
    let pipelines = arguments.pipelines.iter().chain(&arguments.choices.settings.params);
    pipelines.chain(&files.extension).chain(&files.templates).map(PathBuf::as_path)
}
