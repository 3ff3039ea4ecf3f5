//! `umbragraph score --of color`: the picture of a pipeline against a path-traced one.
//!
//! Frames add up: "together" are the pixels of all frames. Limits: paths are traced anew in every run.

use std::fmt::Write as _;

use serde_json::json;
use umbragraph::diagnostic::Diagnostics;
use umbragraph_score::Rays;
use umbragraph_score::color::{Ambient, ColorScores, Settings};

use super::color_view::{self, ColorView, Look};
use super::{broken, nothing, read_limits};
use crate::answer::Answer;
use crate::arguments::ScoreArguments;
use crate::device;
use crate::progress::Progress;
use crate::render::Drawing;
use crate::render::files::{self, Compression, Format};
use crate::session::Session;

/// The color scores of a pipeline on a scene. A lower absolute value is better.
pub(super) struct ColorScored {
    adapter: String,
    triangles: usize,
    settings: Settings,
    frames: Vec<(u32, ColorScores)>,
    together: ColorScores,
}

pub(super) fn score(
    arguments: &ScoreArguments,
    session: &mut Session,
    progress: &mut Progress,
) -> Result<ColorScored, Diagnostics> {
    let settings = arguments.colors.settings(arguments.seed.unwrap_or(1))?;
    let limits = arguments.limits.as_deref().map(read_limits::<ColorScores>).transpose()?;
    if let Some(out) = &arguments.out {
        files::check("--out", out, &[(".png", Format::Png)])?;
    }
    let path = session.camera(arguments.shots.film.camera.as_ref())?;
    let choices = color_view::choices(&arguments.choices, &arguments.colors);
    let checked = progress.stage("check", || session.check(&arguments.pipeline, &choices));
    let scene = progress.stage("load scene", || session.scene(&arguments.scene))?;
    session.ensure_fine(&checked)?;
    let chosen = (&*arguments.pipeline, &choices);
    let (checked, given) = color_view::with_resource(checked, chosen, &arguments.colors, session)?;
    let graphics = progress.stage("open device", || device::open(arguments.drawn.adapter.as_deref()))?;
    let checked = session.check_on(&graphics, checked, &arguments.pipeline, &choices);
    session.ensure_fine(&checked)?;
    let plan = checked.plan.clone().ok_or_else(Diagnostics::new)?;
    session.diagnostics.extend(color_view::effects(&plan, &arguments.colors));
    let look = Look::of(&plan, &given, session)?;
    let options = Session::options(&choices);
    let mut drawing = Drawing::new(&graphics, &scene, checked, options, session, given)?;
    progress.count("tracing paths, row", u64::from(choices.size[1]) * u64::from(arguments.shots.frames));
    let mut scored = ColorScored {
        adapter: graphics.name.clone(),
        triangles: 0,
        settings,
        frames: Vec::new(),
        together: ColorScores::default(),
    };
    let mut sheet = Vec::new();
    for shot in arguments.shots.all() {
        let input = drawing.input(&path, shot);
        let pose = drawing.pose().clone();
        let rays = progress.stage("boxes around triangles", || Rays::new(&scene, &pose));
        scored.triangles = rays.count();
        let looked = (&look, settings);
        let Some(view) = ColorView::new((&rays, &scene, &pose), &input, choices.size, looked, progress)
        else {
            continue;
        };
        let answer = view.answer(&mut drawing, &input, progress)?;
        scored.together.add(&answer.compared.scores);
        if arguments.out.is_some() {
            sheet = answer.compared.sheet(&answer.picture, choices.size[0]);
        }
        scored.frames.push((shot.index, answer.compared.scores));
    }
    if scored.frames.is_empty() {
        return Err(nothing("the camera sees no surface", "move it, or give another with --camera").into());
    }
    if let Some(out) = &arguments.out {
        let [width, height] = choices.size;
        files::write_png(out, [3 * width, height], &sheet, Compression { fast: false })?;
    }
    if let (Some(limits), Some(path)) = (&limits, &arguments.limits) {
        let help =
            "look at the difference with --out FILE.png: rendered, traced, and what a person sees of it";
        session.diagnostics.extend(broken(limits, path, &scored.together, help));
    }
    Ok(scored)
}

impl Answer for ColorScored {
    fn json(&self) -> serde_json::Value {
        let frames: Vec<_> =
            self.frames.iter().map(|(frame, scores)| json!({ "frame": frame, "scores": scores })).collect();
        let Settings { samples, bounces, seed, .. } = self.settings;
        json!({
            "adapter": self.adapter, "triangles": self.triangles, "samples": samples, "bounces": bounces, "seed": seed,
            "ambient": self.ambient(), "frames": frames, "together": self.together,
        })
    }

    fn text(&self) -> String {
        let Settings { samples, bounces, seed, .. } = self.settings;
        let mut text = format!(
            "{} triangles, {samples} paths per pixel, {bounces} bounces, ambient light {}, seed {seed}, on {}\n",
            self.triangles,
            self.ambient(),
            self.adapter
        );
        let heads = ["mean error", "surfaces", "bias", "FLIP", "noise"];
        let _ = writeln!(text, "{:<10}{}", "", heads.map(|head| format!("{head:>12}")).concat());
        let mut row = |name: &str, scores: &ColorScores| {
            let columns =
                [&scores.mean_error, &scores.surface_error, &scores.bias, &scores.flip, &scores.noise];
            let cells = columns.map(|errors| {
                errors.mean().map_or_else(|| format!("{:>12}", "-"), |mean| format!("{mean:12.4}"))
            });
            let _ = writeln!(text, "{name:<10}{}", cells.concat());
        };
        if self.frames.len() > 1 {
            self.frames.iter().for_each(|(frame, scores)| row(&format!("frame {frame}"), scores));
        }
        row("together", &self.together);
        text
    }
}

impl ColorScored {
    fn ambient(&self) -> &'static str {
        match self.settings.ambient {
            Ambient::Occluded => "occluded",
            Ambient::Open => "open",
        }
    }
}
