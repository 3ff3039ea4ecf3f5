//! One set of values, scored on all scenes and camera positions.
//!
//! Rays are traced once; after that a trial draws. Values of live parameters are set, and nothing is planned; a
//! structural one makes another plan, for all scenes. Every trial begins without history, so that its score depends on
//! its values alone.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use serde::Serialize;
use umbragraph::Executor;
use umbragraph::diagnostic::Diagnostics;
use umbragraph::frame::FrameInput;
use umbragraph::low_level::CheckReport;
use umbragraph::low_level::expression::Value;
use umbragraph::low_level::pipeline::TypedPipeline;
use umbragraph::low_level::shader::{Stage, texture_reads};
use umbragraph::work::Work;
use umbragraph_score::Scores;
use umbragraph_score::color::ColorScores;

use crate::arguments::{Choices, Measure, Of, TuneArguments};
use crate::device::Graphics;
use crate::progress::Progress;
use crate::render::Drawing;
use crate::score::color_view::ColorView;
use crate::score::view::View;
use crate::session::Session;

/// The loss of values that the pipeline rejects, which exceeds that of any picture.
pub(crate) const REJECTED: f64 = 2.0;

/// A frame of a scene, and its ray-traced reference.
pub(crate) struct Subject<'r> {
    /// The index of the frame's scene.
    pub(crate) scene: usize,
    pub(crate) input: FrameInput,
    pub(crate) reference: Reference<'r>,
}

/// The ray-traced reference of a frame: of its shadows or of its colors.
pub(crate) enum Reference<'r> {
    Shadows(View<'r>),
    Color(Box<ColorView>),
}

/// The scores of a scene: of its shadows or of its colors.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum Scored {
    Shadows(Box<Scores>),
    Color(ColorScores),
}

impl Scored {
    /// No scores yet, of what is scored.
    fn new(of: Of) -> Self {
        match of {
            Of::Shadows => Self::Shadows(Box::default()),
            Of::Color => Self::Color(ColorScores::default()),
        }
    }
}

/// The outcome of rendering and scoring one set of parameter values.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// The loss to minimize: the mean over the scenes.
    pub(crate) loss: f64,
    /// The scores of each scene, in the order of the scenes.
    pub(crate) scenes: Vec<Scored>,
    pub(crate) cost: Cost,
    /// The hash of all rendered pictures.
    pub(crate) pictures: u64,
}

/// The rendering cost of a set of values, in counts that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Cost {
    /// The number of texels of the shadow map areas drawn per frame, the mean over all views.
    pub(crate) texels: u64,
    /// The number of texture reads per shaded pixel, in the pass with the most reads.
    pub(crate) taps: u64,
}

/// A pipeline with the scenes on which values are tried.
pub(crate) struct Trials<'a> {
    pub(crate) arguments: &'a TuneArguments,
    pub(crate) measure: Measure,
    /// The options of the command line, with the shadow term as the picture if shadows are scored.
    pub(crate) choices: Choices,
    pub(crate) graphics: &'a Graphics,
    pub(crate) session: &'a mut Session,
    pub(crate) drawings: Vec<Drawing<'a>>,
    pub(crate) subjects: &'a [Subject<'a>],
    /// The values with which the current plan was made.
    pub(crate) planned: Vec<(String, Value)>,
    /// The value of [`Cost::taps`] for the current plan.
    pub(crate) taps: u64,
}

impl Trials<'_> {
    /// Renders the scenes with the given values and returns the scores.
    ///
    /// # Errors
    /// Values that the pipeline rejects.
    pub(crate) fn run(
        &mut self,
        values: &[(String, Value)],
        progress: &mut Progress,
    ) -> Result<Outcome, Diagnostics> {
        self.set(values)?;
        let mut scenes = vec![Scored::new(self.arguments.colors.of); self.drawings.len()];
        let (mut texels, mut hasher) = (0, DefaultHasher::new());
        for drawing in &mut self.drawings {
            drawing.executor.reset_history();
        }
        for subject in self.subjects {
            let Some(drawing) = self.drawings.get_mut(subject.scene) else { continue };
            drawing.place(subject.input.time);
            let Some(scene) = scenes.get_mut(subject.scene) else { continue };
            match (&subject.reference, scene) {
                (Reference::Shadows(view), Scored::Shadows(scene)) => {
                    for answer in view.answers(drawing, &subject.input, progress)? {
                        answer.pixels.hash(&mut hasher);
                        scene.add(&answer.scores);
                        texels += drawn_texels(&drawing.executor);
                    }
                }
                (Reference::Color(view), Scored::Color(scene)) => {
                    let answer = view.answer(drawing, &subject.input, progress)?;
                    let parts = answer.picture.iter().flat_map(glam::DVec3::to_array);
                    parts.for_each(|part| part.to_bits().hash(&mut hasher));
                    scene.add(&answer.compared.scores);
                    texels += drawn_texels(&drawing.executor);
                }
                _ => {}
            }
        }
        let losses: Vec<f64> = scenes.iter().filter_map(|scores| loss(scores, self.measure)).collect();
        let loss = losses.iter().sum::<f64>() / losses.len().max(1) as f64;
        let cost = Cost { texels: texels / self.subjects.len().max(1) as u64, taps: self.taps };
        Ok(Outcome { loss, scenes, cost, pictures: hasher.finish() })
    }

    /// Applies parameter values to the drawings. Plans again if a value that is not live differs from the current plan.
    fn set(&mut self, values: &[(String, Value)]) -> Result<(), Diagnostics> {
        let Some(first) = self.drawings.first() else { return Ok(()) };
        let plan = first.executor.plan().clone();
        let is_live = |name: &str| plan.parameters.get(name).is_some_and(|parameter| parameter.live);
        let is_planned = values.iter().all(|(name, value)| {
            is_live(name) || self.planned.iter().any(|(known, planned)| known == name && planned == value)
        });
        if !is_planned {
            let checked = self.check(values)?;
            for drawing in &mut self.drawings {
                drawing.set_plan(checked.clone(), self.session)?;
            }
            self.planned = values.to_vec();
            self.taps = self.drawings.first().map_or(0, |drawing| taps(&drawing.executor.plan().pipeline));
        }
        for drawing in &mut self.drawings {
            for (name, value) in values {
                let executor = &mut drawing.executor;
                if executor.plan().parameters.get(name).is_some_and(|parameter| parameter.live) {
                    let parameter = executor.parameter::<Value>(name)?;
                    executor.set(parameter, value.clone())?;
                }
            }
        }
        Ok(())
    }

    /// Plans the pipeline with the given values.
    fn check(&mut self, values: &[(String, Value)]) -> Result<CheckReport, Diagnostics> {
        let mut choices = self.choices.clone();
        choices.settings.set.extend(values.iter().map(|(name, value)| format!("{name}={value}")));
        let known = std::mem::take(&mut self.session.diagnostics);
        let checked = self.session.check(&self.arguments.pipeline, &choices);
        let checked = self.session.check_on(self.graphics, checked, &self.arguments.pipeline, &choices);
        let found = std::mem::replace(&mut self.session.diagnostics, known);
        if checked.plan.is_none() || found.has_errors() { Err(found) } else { Ok(checked) }
    }
}

/// Returns the loss of a scene from its scores; `None` if the measured score is missing.
pub(crate) fn loss(scores: &Scored, measure: Measure) -> Option<f64> {
    match (scores, measure) {
        (Scored::Shadows(scores), Measure::Iou) => scores.iou().map(|iou| 1.0 - iou),
        (Scored::Shadows(scores), _) => scores.mean_error.mean(),
        (Scored::Color(scores), Measure::Flip) => scores.flip.mean(),
        (Scored::Color(scores), _) => scores.mean_error.mean(),
    }
}

/// Returns the number of texels in the areas that depth-only passes drew in the last frame. Passes that share their
/// depth attachment with a color pass do not count.
fn drawn_texels(executor: &Executor) -> u64 {
    let pipeline = &executor.plan().pipeline;
    let renders = || {
        pipeline.passes.iter().filter_map(|pass| match pass.work() {
            Work::Render(render) => Some((pass.name.as_str(), render)),
            _ => None,
        })
    };
    let with_color: Vec<_> = renders()
        .filter(|(_, render)| !render.color.is_empty())
        .filter_map(|(_, render)| render.depth.as_ref().map(|depth| depth.to.resource))
        .collect();
    let is_map = |name: &str| {
        renders().any(|(known, render)| {
            let depth = render.depth.as_ref().map(|depth| depth.to.resource);
            known == name
                && render.color.is_empty()
                && depth.is_some_and(|depth| !with_color.contains(&depth))
        })
    };
    executor.pass_counts().filter(|(name, _)| is_map(name)).map(|(_, counts)| counts.texels).sum()
}

/// Returns the largest number of texture reads in a fragment shader of a pass that writes colors.
pub(crate) fn taps(pipeline: &TypedPipeline) -> u64 {
    let passes = pipeline.passes.iter().filter_map(|pass| match pass.work() {
        Work::Render(render) if !render.color.is_empty() => Some(pipeline.program(render.draw.bound().0)),
        _ => None,
    });
    let reads = passes.flat_map(|program| &program.variants).filter_map(|variant| {
        let entry_point = variant.entry_point(Stage::Fragment)?;
        Some(texture_reads(&variant.module, &entry_point.name))
    });
    reads.max().unwrap_or(0)
}
