//! Pictures and scores of the command, kept in files so that a run goes on where an earlier one ended.
//!
//! A picture is drawn by a process of its own. Beside it lies a text with what the command said: its first line is
//! `drawn` or a failure, the others are features that were off. All of it belongs to one state of the command, of the
//! pipelines and of the scenes: their hash is in a file, and where it is another one, everything is drawn again.

use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use umbragraph_test_support::image::Picture;

use crate::case::Case;
use crate::driver::Driver;
use crate::variant::Variant;

/// The time after which a process counts as hanging.
const LONGEST: Duration = Duration::from_secs(600);
/// The size of all pictures in pixels, as the command takes it.
pub(crate) const SIZE: &str = "320x180";

/// A task for the command: a picture to render, or shadows to score.
pub(crate) enum Job<'a> {
    /// Render one variant of a case with a driver.
    Picture { driver: &'a Driver, case: Case, variant: Variant },
    /// Score the shadows of a pipeline on a scene with a driver.
    Score { driver: &'a Driver, pipeline: &'static str, scene: &'static str },
}

/// The result of rendering a picture.
pub(crate) enum Drawn {
    Not,
    Failed(String),
    /// The picture's file, and the names of features that were off.
    Picture(PathBuf, Vec<String>),
}

/// The folder with the results of a run, and the program that makes them.
pub(crate) struct Drawings {
    pub(crate) program: PathBuf,
    pub(crate) folder: PathBuf,
}

impl Drawings {
    /// Opens the folder of results. Removes old results if the program, a pipeline or a scene has changed.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub(crate) fn open(program: &Path, folder: &Path) -> Result<Self, String> {
        let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
        let folder_of_pictures = folder.join("pictures");
        let state = state(program).to_string();
        let key = folder_of_pictures.join("state");
        if std::fs::read_to_string(&key).ok().as_ref() != Some(&state) {
            if folder_of_pictures.exists() {
                std::fs::remove_dir_all(&folder_of_pictures).map_err(failed)?;
            }
            std::fs::create_dir_all(&folder_of_pictures).map_err(failed)?;
            std::fs::write(&key, state).map_err(failed)?;
            let commit =
                output(Command::new("git").args(["rev-parse", "--short", "HEAD"])).unwrap_or_default();
            std::fs::write(folder_of_pictures.join("commit"), commit.trim()).map_err(failed)?;
        }
        Ok(Self { program: program.to_owned(), folder: folder_of_pictures })
    }

    /// Returns the short hash of the commit that was checked out when the first picture was rendered.
    pub(crate) fn commit(&self) -> String {
        std::fs::read_to_string(self.folder.join("commit")).unwrap_or_default()
    }

    fn file(&self, driver: &Driver, name: &str, ending: &str) -> PathBuf {
        let name = format!("{} {name}", driver.name).replace([' ', '/', '(', ')', ','], "_");
        self.folder.join(format!("{name}.{ending}"))
    }

    fn picture_file(&self, driver: &Driver, case: &Case, variant: Variant, ending: &str) -> PathBuf {
        self.file(driver, &format!("{}{}", case.name(), variant.word()), ending)
    }

    /// Returns the stored result for a picture on a driver.
    pub(crate) fn drawn(&self, driver: &Driver, case: &Case, variant: Variant) -> Drawn {
        let said = std::fs::read_to_string(self.picture_file(driver, case, variant, "txt"));
        let Some(said) = said.ok().filter(|said| !said.is_empty()) else { return Drawn::Not };
        let mut lines = said.lines();
        match lines.next() {
            Some("drawn") => {
                let off = lines.map(str::to_owned).collect();
                Drawn::Picture(self.picture_file(driver, case, variant, "png"), off)
            }
            reason => Drawn::Failed(reason.unwrap_or("it fails without a word").to_owned()),
        }
    }

    /// Loads a picture; `None` if it has not been rendered.
    pub(crate) fn picture(&self, driver: &Driver, case: &Case, variant: Variant) -> Option<Picture> {
        match self.drawn(driver, case, variant) {
            Drawn::Picture(file, _) => Picture::load(&file).ok(),
            _ => None,
        }
    }

    /// Loads the intersection over union of shadows with ray tracing, for each light. Only pixels at least two pixels
    /// from a shadow edge count.
    pub(crate) fn scores(&self, driver: &Driver, pipeline: &str, scene: &str) -> Option<Vec<(String, f64)>> {
        let file = self.file(driver, &format!("{pipeline} {scene} score"), "json");
        let scores: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(file).ok()?).ok()?;
        let lights = scores.get("lights")?.as_array()?.iter();
        let score = |light: &serde_json::Value| {
            let name = light.get("light")?.as_str()?.to_owned();
            Some((name, light.pointer("/scores/bands/2/iou")?.as_f64()?))
        };
        Some(lights.filter_map(score).collect())
    }

    /// Returns the depth of a scene, rendered by lavapipe with `umbra`: row by row, 1 is near and 0 is far.
    pub(crate) fn depth(&self, lavapipe: &Driver, scene: &'static str) -> Option<Vec<f32>> {
        let file = self.file(lavapipe, &format!("{scene} depth"), "exr");
        if !file.exists() {
            let mut command = lavapipe.command(&self.program);
            command.args(["render", "pipelines/umbra.json", "--size", SIZE, "--scene"]).arg(path_of(scene));
            command.arg("--out").arg(self.file(lavapipe, &format!("{scene} depth"), "png"));
            output(command.arg("--capture").arg(format!("depth={}", file.display()))).ok()?;
        }
        let read = exr::prelude::read_first_flat_layer_from_file(&file).ok()?;
        let channel = read.layer_data.channel_data.list.first()?;
        Some(channel.sample_data.values_as_f32().collect())
    }

    /// Runs all unfinished jobs in parallel until a given time. Returns the number of jobs left.
    pub(crate) fn draw(&self, jobs: Vec<Job<'_>>, until: Option<Instant>) -> usize {
        let todo: VecDeque<Job<'_>> = jobs.into_iter().filter(|job| !self.is_done(job)).collect();
        let (count, todo) = (todo.len(), Mutex::new(todo));
        std::thread::scope(|scope| {
            for _ in 0..workers() {
                scope.spawn(|| {
                    while until.is_none_or(|until| Instant::now() < until) {
                        let (job, left) = {
                            let mut todo = todo.lock().unwrap_or_else(PoisonError::into_inner);
                            (todo.pop_front(), todo.len())
                        };
                        let Some(job) = job else { break };
                        self.run(&job);
                        if left % 50 == 0 {
                            eprintln!("{left} of {count} are left");
                        }
                    }
                });
            }
        });
        todo.into_inner().unwrap_or_else(PoisonError::into_inner).len()
    }

    fn is_done(&self, job: &Job<'_>) -> bool {
        match job {
            Job::Picture { driver, case, variant } => {
                !matches!(self.drawn(driver, case, *variant), Drawn::Not)
            }
            Job::Score { driver, pipeline, scene } => {
                self.file(driver, &format!("{pipeline} {scene} score"), "json").exists()
            }
        }
    }

    fn run(&self, job: &Job<'_>) {
        match job {
            Job::Picture { driver, case, variant } => {
                let scene = variant.scene(&path_of(case.scene), &self.folder);
                let picture = self.picture_file(driver, case, *variant, "png");
                let drawn = scene.and_then(|scene| {
                    let mut command = driver.command(&self.program);
                    command.arg("render").args(case.arguments()).args(["--size", SIZE, "--fast"]);
                    output(command.arg("--scene").arg(scene).arg("--out").arg(picture))
                });
                let said = match drawn {
                    Ok(said) => {
                        std::iter::once("drawn".to_owned()).chain(off(&said)).collect::<Vec<_>>().join("\n")
                    }
                    Err(reason) => reason,
                };
                write(&self.picture_file(driver, case, *variant, "txt"), &said);
            }
            Job::Score { driver, pipeline, scene } => {
                let mut command = driver.command(&self.program);
                command.args(["score", &format!("pipelines/{pipeline}.json"), "--size", SIZE]);
                let scores = output(command.args(["--format", "json", "--scene"]).arg(path_of(scene)));
                let file = self.file(driver, &format!("{pipeline} {scene} score"), "json");
                write(&file, &scores.unwrap_or_else(|reason| reason));
            }
        }
    }
}

/// Returns the number of processors, at least two, since rendering processes sometimes wait for their driver.
fn workers() -> usize {
    std::thread::available_parallelism().map_or(2, |count| count.get().max(2))
}

/// Applies a function to all items in [`workers`] threads, and returns the results in the order of the items.
pub(crate) fn parallel<T: Sync, R: Send>(items: &[T], function: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut done = Vec::new();
        while let at = next.fetch_add(1, Ordering::Relaxed)
            && let Some(item) = items.get(at)
        {
            done.push((at, function(item)));
        }
        done
    };
    let mut done: Vec<(usize, R)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..workers()).map(|_| scope.spawn(work)).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap_or_default()).collect()
    });
    done.sort_by_key(|(at, _)| *at);
    done.into_iter().map(|(_, result)| result).collect()
}

/// Writes a file atomically, so that an interrupted run can be continued.
fn write(file: &Path, text: &str) {
    let beside = file.with_extension("part");
    if let Err(error) = std::fs::write(&beside, text).and_then(|()| std::fs::rename(&beside, file)) {
        eprintln!("{}: {error}", file.display());
    }
}

fn path_of(scene: &str) -> PathBuf {
    Path::new("examples/scenes").join(format!("{scene}.glb"))
}

/// Parses the names of features that the command reports as off.
fn off(said: &str) -> Vec<String> {
    let off = said.lines().filter_map(|line| line.split_once(" is off: ")?.0.split('"').nth(1));
    off.map(str::to_owned).collect()
}

/// Runs a command and returns its output, or the first line that explains its failure.
fn output(command: &mut Command) -> Result<String, String> {
    let failed = |error: std::io::Error| format!("{error}");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().map_err(failed)?;
    let (printed, said) = (reader(child.stdout.take()), reader(child.stderr.take()));
    let end = Instant::now() + LONGEST;
    let status = loop {
        match child.try_wait().map_err(failed)? {
            Some(status) => break status,
            None if Instant::now() < end => std::thread::sleep(Duration::from_millis(10)),
            // A process that waits in the kernel for its driver ends later or never: nobody waits for it.
            None => {
                child.kill().map_err(failed)?;
                return Err(format!("it hangs: after {} s it has not ended", LONGEST.as_secs()));
            }
        }
    };
    let [printed, said] = [printed, said].map(|reader| reader.join().unwrap_or_default());
    if !status.success() {
        let first = said.lines().find(|line| line.starts_with("error") || line.contains("panicked"));
        return Err(first.unwrap_or("it fails without a word").to_owned());
    }
    Ok(if printed.starts_with('{') { printed } else { said + &printed })
}

/// Starts a thread that reads a pipe to its end.
fn reader(pipe: Option<impl Read + Send + 'static>) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        // What was read before an error is kept.
        let _ = pipe.map(|mut pipe| pipe.read_to_end(&mut bytes));
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// Returns a hash that changes if the command, a pipeline or a scene changes.
fn state(program: &Path) -> u64 {
    let mut hasher = DefaultHasher::new();
    let mut folders = vec![PathBuf::from("pipelines"), PathBuf::from("examples/scenes")];
    let mut files = vec![program.to_owned()];
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.sort();
    for file in files {
        std::fs::read(&file).unwrap_or_default().hash(&mut hasher);
    }
    hasher.finish()
}
