//! `umbragraph score`: the shadows of a pipeline against ray-traced ones.
//!
//! Every light that casts shadows is rendered alone, as the pipeline's shadow term, and the same pixels are asked of
//! rays (`umbragraph-score`). Scores add up: "together" are the pixels of all lights and frames. Of frames in a row
//! each light's are held against each other as well: what changes though rays say the same.
//!
//! Rays are traced once for a scene, a pose, a camera and a light: later runs find their answers in the cache.
//!
//! With `--of color` the whole picture is scored instead ([`color`]).
//!
//! Limits: lights take turns, so that with several of them what a pipeline keeps from frame to frame (a history of its
//! picture) is of the light before.

mod color;
pub(crate) mod color_view;
pub(crate) mod view;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use serde_json::json;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, Severity, list_of};
use umbragraph_score::{Counts, Limited, Limits, Rays, Scores, Seen};

use self::view::{View, casting};
use crate::answer::{Answer, answer};
use crate::arguments::{Of, ScoreArguments};
use crate::cache::Cache;
use crate::codes;
use crate::device;
use crate::progress::Progress;
use crate::render::files::{self, Compression, Format};
use crate::render::{Drawing, Given};
use crate::session::Session;
use crate::shadow_term;

/// Scores the shadows or the colors of a pipeline. Returns `true` if there were no errors and all limits are met.
pub(crate) fn run(arguments: &ScoreArguments) -> bool {
    if arguments.colors.of == Of::Color {
        return answer(&arguments.choices, arguments.format, |session, progress| {
            color::score(arguments, session, progress)
        });
    }
    answer(&arguments.choices, arguments.format, |session, progress| score(arguments, session, progress))
}

/// The scores of a pipeline on a scene.
struct Scored {
    adapter: String,
    triangles: usize,
    /// The memory of the triangles and of their bounding volume hierarchy, in bytes.
    bytes: usize,
    /// The scores of each light, in the order of the scene; names may repeat.
    lights: Vec<(String, Scores)>,
    /// The scores of each frame in which the camera sees a surface, with the frame's number.
    frames: Vec<(u32, Scores)>,
    together: Scores,
}

fn score(
    arguments: &ScoreArguments,
    session: &mut Session,
    progress: &mut Progress,
) -> Result<Scored, Diagnostics> {
    arguments.colors.unused(arguments.seed.is_some())?;
    let limits = arguments.limits.as_deref().map(read_limits::<Scores>).transpose()?;
    if let Some(out) = &arguments.out {
        files::check("--out", out, &[(".png", Format::Png)])?;
    }
    let path = session.camera(arguments.shots.film.camera.as_ref())?;
    let cache = Cache::new(&arguments.cache);
    let choices = shadow_term::choices(&arguments.choices);
    let loaded = session.open(&arguments.pipeline, &choices.files.extension).ok_or_else(Diagnostics::new)?;
    let Some(document) = loaded.document() else { return Err(Diagnostics::new()) };
    shadow_term::required(&document.root)?;
    let checked = progress.stage("check", || session.check(&arguments.pipeline, &choices));
    let scene = progress.stage("load scene", || session.scene(&arguments.scene))?;
    session.ensure_fine(&checked)?;
    let graphics = progress.stage("open device", || device::open(arguments.drawn.adapter.as_deref()))?;
    let checked = session.check_on(&graphics, checked, &arguments.pipeline, &choices);
    session.ensure_fine(&checked)?;
    let options = Session::options(&choices);
    let mut drawing = Drawing::new(&graphics, &scene, checked, options, session, Given::default())?;
    let mut lights: Vec<(String, Scores)> = Vec::new();
    let mut frames: Vec<(u32, Scores)> = Vec::new();
    let mut differences = Vec::new();
    let (mut triangles, mut bytes) = (0, 0);
    let mut shadowed = BTreeSet::new();
    let mut before: BTreeMap<usize, Seen> = BTreeMap::new();
    // Rows of pixels from which rays are traced to each light.
    let mut traced_rows = 0;
    for shot in arguments.shots.all() {
        let input = drawing.input(&path, shot);
        let rows = casting(&input).count() as u64 * u64::from(choices.size[1]);
        if traced_rows == 0 {
            progress.count("tracing rays, row", rows * u64::from(arguments.shots.frames));
        }
        progress.reach(traced_rows);
        traced_rows += rows;
        let pose = drawing.pose().clone();
        let rays = progress.stage("boxes around triangles", || Rays::new(&scene, &pose));
        (triangles, bytes) = (rays.count(), rays.bytes());
        let Some(view) = View::new(&rays, &input, choices.size, (cache.as_ref(), progress))? else {
            before.clear();
            continue;
        };
        if lights.is_empty() {
            lights = view.names().map(|name| (name.to_owned(), Scores::default())).collect();
        }
        differences.clear();
        let mut together = Scores::default();
        let mut seen = BTreeMap::new();
        for mut answer in view.answers(&mut drawing, &input, progress)? {
            if arguments.shots.frames > 1 {
                let now = view.seen(&answer);
                answer.scores.changes =
                    before.get(&answer.at).map(|before| now.changes_since(before)).unwrap_or_default();
                seen.insert(answer.at, now);
            }
            together.add(&answer.scores);
            if arguments.out.is_some() {
                differences.extend(view.difference(&answer));
            }
            shadowed.extend((!answer.is_lit_everywhere).then_some(answer.at));
            if let Some((_, known)) = lights.get_mut(answer.at) {
                known.add(&answer.scores);
            }
        }
        before = seen;
        frames.push((shot.index, together));
    }
    if frames.is_empty() {
        return Err(nothing("the camera sees no surface", "move it, or give another with --camera").into());
    }
    // Without any shadow in any frame, though there should be some.
    let is_left_out =
        |(at, (_, scores)): &(usize, &(String, Scores))| !shadowed.contains(at) && scores.band(2).leaking > 0;
    let unshadowed: BTreeSet<&String> =
        lights.iter().enumerate().filter(is_left_out).map(|(_, (name, _))| name).collect();
    let left_out = unshadowed.into_iter().map(|name| {
        let message = format!("the pipeline gives the light \"{name}\" no shadows at all");
        Diagnostic::warning(codes::SCORE, Place::Nowhere, message)
            .help("its scores say so; pipelines/awsm.json takes every kind of light")
    });
    let mut remarks: Vec<Diagnostic> = left_out.collect();
    if let Some(out) = &arguments.out {
        let [width, height] = choices.size;
        let rows = height * (differences.len() / (4 * width as usize * height as usize)).max(1) as u32;
        files::write_png(out, [width, rows], &differences, Compression { fast: false })?;
    }
    drop(drawing);
    // A light that no frame could use has no scores.
    lights.retain(|(_, scores)| scores.band(0).pixels() > 0);
    remarks.extend(softness(&lights));
    session.diagnostics.extend(remarks);
    let mut together = Scores::default();
    lights.iter().for_each(|(_, scores)| together.add(scores));
    if let (Some(limits), Some(path)) = (&limits, &arguments.limits) {
        let help = "look at the difference with --out FILE.png; red leaks, blue is acne";
        session.diagnostics.extend(broken(limits, path, &together, help));
    }
    Ok(Scored { adapter: graphics.name.clone(), triangles, bytes, lights, frames, together })
}

/// Returns notes about figures that do not suit the filter: hard masks for soft shadows, and the extent of a light for
/// hard shadows.
fn softness(lights: &[(String, Scores)]) -> impl Iterator<Item = Diagnostic> {
    let note = |has: fn(&Scores) -> bool, message: &str, help: &str| {
        let names: Vec<String> = lights
            .iter()
            .filter(|(_, scores)| scores.darkened > 0 && has(scores))
            .map(|(name, scores)| {
                format!("\"{name}\" ({} of {} pixels partly lit)", scores.partly_lit, scores.darkened)
            })
            .collect();
        (!names.is_empty()).then(|| {
            let message = format!("the shadows of {} are {message}", list_of(names));
            Diagnostic::warning(codes::SCORE, Place::Nowhere, message).severity(Severity::Note).help(help)
        })
    };
    let soft = note(
        Scores::is_soft,
        "soft: IoU, leak and acne compare them with a hard mask, which they cannot match",
        "read the mean error against the extent of the light, or score a hard filter, such as `--feature \
         light_filter=hard` of awsm",
    );
    let hard = note(
        Scores::lacks_penumbrae,
        "hard: the mean error against the extent of the light counts the penumbra that they lack",
        "read IoU, leak and acne, or score a filter as wide as the light, such as `--feature light_filter=pcss` of awsm",
    );
    soft.into_iter().chain(hard)
}

pub(crate) fn nothing(message: &str, help: &str) -> Diagnostic {
    Diagnostic::error(codes::SCORE, Place::Nowhere, message).help(help)
}

fn read_limits<S: Limited>(path: &Path) -> Result<Limits<S>, Diagnostic> {
    let name = path.display().to_string();
    let wrong = |message: String| {
        let names = list_of(S::limits());
        Diagnostic::in_file(codes::SCORE_LIMITS, &name, "", message)
            .help(format!("write an object with names and numbers; there are {names}"))
    };
    let mut sources = umbragraph::low_level::source::Sources::new();
    let file = umbragraph::low_level::read_source(path, &mut sources)?;
    let text = sources.get(file).map(|file| file.text().clone()).unwrap_or_default();
    let values: BTreeMap<String, f64> = serde_json::from_str(&text)
        .map_err(|error| wrong(format!("these are no limits of scores: {error}")))?;
    Limits::new(values).map_err(|unknown| wrong(format!("no score has the limit \"{unknown}\"")))
}

fn broken<S: Limited>(
    limits: &Limits<S>,
    path: &Path,
    together: &S,
    help: &'static str,
) -> impl Iterator<Item = Diagnostic> + use<S> {
    let file = path.display().to_string();
    limits.broken(together).into_iter().map(move |broken| {
        let measured = match broken.measured {
            Some(value) => format!("{value:.6}"),
            None => "no pixel to measure it on".to_owned(),
        };
        let message = format!("{} is {}, but there is {measured}", broken.name, broken.limit);
        Diagnostic::in_file(codes::SCORE_LIMITS, &*file, format!("/{}", broken.name), message).help(help)
    })
}

impl Scored {
    /// Returns the number of the frame with the lowest intersection over union, and the value. Only frames with at
    /// least a hundredth of the pixels in shadow count; `None` if there is no such frame.
    fn worst(&self) -> Option<(u32, f64)> {
        let shown = self.frames.iter().filter(|(_, scores)| {
            let all = scores.band(0);
            100 * (all.shadowed_in_both + all.leaking) >= all.pixels()
        });
        let scored = shown.filter_map(|(frame, scores)| Some((*frame, scores.iou()?)));
        scored.min_by(|one, other| one.1.total_cmp(&other.1))
    }
}

impl Answer for Scored {
    fn json(&self) -> serde_json::Value {
        let lights: Vec<_> =
            self.lights.iter().map(|(name, scores)| json!({ "light": name, "scores": scores })).collect();
        let frames: Vec<_> = self
            .frames
            .iter()
            .map(|(frame, scores)| {
                json!({ "frame": frame, "iou": scores.iou(), "mean_error": scores.mean_error, "changes": scores.changes })
            })
            .collect();
        let worst = self.worst().map(|(frame, iou)| json!({ "frame": frame, "iou": iou }));
        json!({
            "adapter": self.adapter, "triangles": self.triangles, "bytes": self.bytes, "lights": lights, "frames": frames, "worst": worst,
            "together": self.together,
        })
    }

    fn text(&self) -> String {
        let mut text = format!(
            "{} triangles, {:.1} MB with their boxes, on {}\n",
            self.triangles,
            self.bytes as f64 / 1e6,
            self.adapter
        );
        for (name, scores) in &self.lights {
            table(&mut text, name, scores);
        }
        if self.lights.len() > 1 {
            table(&mut text, "together", &self.together);
        }
        if let (Some((frame, iou)), 2..) = (self.worst(), self.frames.len()) {
            let _ = writeln!(text, "worst of {} frames: frame {frame} with IoU {iou:.4}", self.frames.len());
        }
        text
    }
}

/// Formats a score as a table cell; a dash for `None`.
fn cell(value: Option<f64>) -> String {
    value.map_or_else(|| format!("{:>8}", "-"), |value| format!("{value:8.4}"))
}

fn table(text: &mut String, name: &str, scores: &Scores) {
    let line = |text: &mut String, what: &str, counts: &Counts| {
        let [iou, leak, acne] = [counts.iou(), counts.leak(), counts.acne()].map(cell);
        let _ = writeln!(text, "  {what:<24}{:>9}{iou}{leak}{acne}", counts.pixels());
    };
    let _ = writeln!(text, "{name}\n  {:<24}{:>9}{:>8}{:>8}{:>8}", "", "pixels", "IoU", "leak", "acne");
    for (band, counts) in &scores.bands {
        let what = match band {
            0 => "all".to_owned(),
            1 => "off the edges".to_owned(),
            more => format!("{more} pixels off the edges"),
        };
        line(text, &what, counts);
    }
    for (doubling, counts) in &scores.distances {
        let metres = f64::from(*doubling).exp2();
        line(text, &format!("{metres} to {} m away", 2.0 * metres), counts);
    }
    let _ = writeln!(text, "  contact leak{}", cell(scores.contact.leak()));
    if let Some(share) = scores.changes.share() {
        let points = scores.changes.points;
        let _ = writeln!(text, "  from frame to frame {:.4} % of {points} points change", 100.0 * share);
    }
    if scores.mean_error.mean().is_some() {
        let [mean, penumbra, bias] = [&scores.mean_error, &scores.penumbra_error, &scores.bias];
        let [mean, penumbra, bias] = [mean, penumbra, bias].map(|errors| cell(errors.mean()));
        let _ = writeln!(text, "  against its extent: mean error{mean}, in penumbrae{penumbra}, bias{bias}");
    }
}
