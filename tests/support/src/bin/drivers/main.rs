//! A table of all that each driver of the machine draws: `cargo xtask drivers`.
//!
//! Every pipeline is rendered on scenes of the project with each driver, as the picture and as its shadow term; what
//! differs from lavapipe is counted by cause ([`difference`]), and the shadows of the sun are scored against rays. The
//! table is written to a file. The status is 1 if a driver draws something else, has shadows of another score, or more
//! than a share of pixels that nothing explains.
//!
//! usage: drivers COMMAND FOLDER TABLE [--quick]

mod difference;
mod driver;
mod table;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use difference::{Difference, Pair};
use driver::Driver;
use umbragraph_test_support::image::Picture;

/// The pipelines, and the scenes that they are drawn on.
pub(crate) const PIPELINES: [&str; 6] = ["mantis", "nebula", "caracal", "lore", "awsm", "umbra"];
const SCENES: [&str; 4] = ["courtyard", "figure", "foliage", "interior"];
const SIZE: &str = "320x180";

/// The most percent of pixels that nothing explains.
pub(crate) const MAX_UNEXPLAINED: f64 = 0.05;
/// The most by which a score of shadows changes.
pub(crate) const MAX_SCORE_CHANGE: f64 = 0.001;

/// A pipeline on one driver.
#[derive(Default)]
pub(crate) struct Drawn {
    /// The difference over all scenes.
    pub(crate) difference: Difference,
    /// The intersection over union of the sun's shadows, between 2 and 128 m and all in all.
    pub(crate) score: Option<f64>,
    /// Failures, in words.
    pub(crate) failures: Vec<String>,
    /// Features that the command said are off.
    pub(crate) off: Vec<String>,
}

/// A driver with all pipelines.
pub(crate) struct Column {
    pub(crate) name: &'static str,
    pub(crate) adapter: String,
    pub(crate) driver: String,
    /// In the order of [`PIPELINES`].
    pub(crate) drawn: Vec<Drawn>,
}

struct Run {
    program: PathBuf,
    folder: PathBuf,
    scenes: Vec<&'static str>,
}

/// The pictures of a pipeline on a scene.
struct Pictures {
    picture: Picture,
    shadow: Picture,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [program, folder, file, options @ ..] = arguments.as_slice() else {
        eprintln!("usage: drivers COMMAND FOLDER TABLE [--quick]");
        return ExitCode::from(2);
    };
    let is_quick = options.iter().any(|option| option == "--quick");
    let scenes = if is_quick { SCENES[..1].to_vec() } else { SCENES.to_vec() };
    let run = Run { program: program.into(), folder: folder.into(), scenes };
    match run.all().and_then(|columns| finish(&columns, Path::new(file), is_quick)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}

/// Writes the table; whether all is as it should be.
fn finish(columns: &[Column], file: &Path, is_quick: bool) -> Result<bool, String> {
    let text = table::markdown(columns, is_quick);
    print!("{text}");
    std::fs::write(file, &text).map_err(|error| format!("{}: {error}", file.display()))?;
    let complaints = table::complaints(columns);
    for complaint in &complaints {
        eprintln!("{complaint}");
    }
    Ok(complaints.is_empty())
}

impl Run {
    fn all(&self) -> Result<Vec<Column>, String> {
        std::fs::create_dir_all(&self.folder)
            .map_err(|error| format!("{}: {error}", self.folder.display()))?;
        let mut columns: Vec<Column> = Vec::new();
        for driver in Driver::all() {
            let Some((adapter, words)) = driver.adapter(&self.program) else {
                eprintln!("{}: no adapter", driver.name);
                continue;
            };
            eprintln!("{}: {adapter}", driver.name);
            let drawn = PIPELINES.iter().map(|pipeline| self.pipeline(&driver, pipeline));
            columns.push(Column { name: driver.name, adapter, driver: words, drawn: drawn.collect() });
        }
        match columns.first() {
            Some(first) if first.name == "lavapipe" => Ok(columns),
            _ => Err("lavapipe, which all others are compared with, gives no adapter: install \
                      mesa-vulkan-drivers"
                .to_owned()),
        }
    }

    fn pipeline(&self, driver: &Driver, pipeline: &str) -> Drawn {
        let mut drawn = Drawn::default();
        for scene in &self.scenes {
            let own = self.pictures(driver, pipeline, scene, &mut drawn);
            let reference = self.reference(pipeline, scene);
            match (own, reference) {
                (Ok(own), Ok((reference, depth))) => {
                    drawn.difference = drawn.difference.and(Difference::of(&Pair {
                        reference: &reference.picture,
                        shadow: &reference.shadow,
                        depth: depth.as_ref(),
                        picture: &own.picture,
                        own_shadow: &own.shadow,
                    }));
                }
                (Err(reason), _) | (_, Err(reason)) => drawn.failures.push(format!("{scene}: {reason}")),
            }
        }
        match self.score(driver, pipeline) {
            Ok(score) => drawn.score = Some(score),
            Err(reason) => drawn.failures.push(format!("score: {reason}")),
        }
        drawn
    }

    fn file(&self, driver: &str, pipeline: &str, scene: &str, what: &str) -> PathBuf {
        self.folder.join(format!("{}_{pipeline}_{scene}_{what}.png", driver.replace(' ', "_")))
    }

    /// Draws the picture and the shadow term.
    fn pictures(
        &self,
        driver: &Driver,
        pipeline: &str,
        scene: &str,
        drawn: &mut Drawn,
    ) -> Result<Pictures, String> {
        let mut draw = |what: &str, more: &[String]| {
            let out = self.file(driver.name, pipeline, scene, what);
            let mut command = driver.command(&self.program);
            command.args(["render", &format!("pipelines/{pipeline}.json"), "--size", SIZE, "--scene"]);
            command.arg(format!("examples/scenes/{scene}.glb")).arg("--out").arg(&out).args(more);
            let said = output(command)?;
            let off = said.lines().filter_map(|line| line.split_once(" is off: ")?.0.split('"').nth(1));
            let off: Vec<String> = off.map(str::to_owned).collect();
            drawn.off.extend(off.into_iter().filter(|name| !drawn.off.contains(name)).collect::<Vec<_>>());
            Picture::load(&out).map_err(|error| error.to_string())
        };
        let depth = self.file(driver.name, pipeline, scene, "depth");
        let depth = ["--capture".to_owned(), format!("depth={}", depth.display())];
        let with_depth = if driver.name == "lavapipe" { &depth[..] } else { &[] };
        let shadow = ["--set".to_owned(), "debug_view=shadow_term".to_owned()];
        Ok(Pictures { picture: draw("picture", with_depth)?, shadow: draw("shadow", &shadow)? })
    }

    /// The pictures of lavapipe, and the depth.
    fn reference(&self, pipeline: &str, scene: &str) -> Result<(Pictures, Option<Picture>), String> {
        let load = |what| Picture::load(&self.file("lavapipe", pipeline, scene, what));
        let whole = |what| load(what).map_err(|error| error.to_string());
        Ok((Pictures { picture: whole("picture")?, shadow: whole("shadow")? }, load("depth").ok()))
    }

    /// The score of the sun's shadows on the courtyard, between 2 and 128 m.
    fn score(&self, driver: &Driver, pipeline: &str) -> Result<f64, String> {
        let mut command = driver.command(&self.program);
        command.args(["score", &format!("pipelines/{pipeline}.json"), "--size", SIZE, "--format", "json"]);
        command.args(["--scene", "examples/scenes/courtyard.glb"]);
        let said = output(command)?;
        let scores: serde_json::Value = serde_json::from_str(&said).map_err(|error| error.to_string())?;
        let iou = scores.pointer("/lights/0/scores/bands/2/iou").and_then(serde_json::Value::as_f64);
        iou.ok_or_else(|| "there is no score".to_owned())
    }
}

/// The output of a command, or why it fails.
fn output(mut command: std::process::Command) -> Result<String, String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (said, printed) = (text(&output.stderr), text(&output.stdout));
    if !output.status.success() {
        let first = said.lines().find(|line| line.starts_with("error") || line.contains("panicked"));
        return Err(first.unwrap_or("it fails without a word").to_owned());
    }
    Ok(if printed.starts_with('{') { printed } else { said + &printed })
}
