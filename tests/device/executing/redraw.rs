//! Views that are drawn again only when something changes.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use umbragraph::Executor;
use umbragraph::Plan;
use umbragraph::executor::PassCounts;
use umbragraph::frame::Bounds;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::random::Random;

use crate::common::gpu::import;
use crate::executing::squares::{RED, Square, Squares, WHOLE};
use crate::executing::stage::{executor, plan, show, target, texels, try_plan_of_text};
use crate::executing::views::frame;

/// Steps of depth that 8 bits tell apart.
const STEPS: u32 = 85;

/// A persistent depth texture of some layers, drawn into as `draw` says, and one of its layers shown.
fn kept(layers: u32, shown: u32, draw: &str) -> Arc<Plan> {
    let maps = format!(
        r#""maps": {{ "texture": {{ "format": "depth32float", "size": "=viewport", "layers": {layers}, "view_dimension": "2d-array",
            "lifetime": "persistent" }} }}, {}"#,
        target(1)
    );
    let max = if layers > 1 { layers } else { 4 };
    let passes = format!(
        r#""views": {{ "views": {{ "to": "&views", "max": {max} }} }},
           "squares": {{ "draw": {{ "geometry": "squares", "mesh_filter": "all", "views": "&views", "cull": "none",
               "shader": "square_depth.wgsl.jinja", {draw},
               "depth": {{ "to": "&maps", "clear": 1, "compare": "less-equal" }} }} }},
           "show": {{ "fullscreen": {{ "shader": "show_depth.wgsl.jinja",
               "bind": {{ "maps": "&maps", "settings": {{ "values": {{ "layer": {shown} }} }} }},
               "color": [{{ "to": "&target" }}] }} }}"#
    );
    plan(&maps, &passes)
}

/// A host that draws one square over everything, whose depth tells its revision, and counts its draws.
struct Stage<'a> {
    gpu: &'a Gpu,
    squares: Squares,
    executor: Executor,
    target: wgpu::Texture,
    shown: Arc<AtomicU32>,
    draws: Arc<AtomicU32>,
}

impl<'a> Stage<'a> {
    fn new(gpu: &'a Gpu, plan: &Arc<Plan>) -> Self {
        let steps: Vec<Square> = (0..STEPS)
            .map(|step| Square { rectangle: WHOLE, color: RED, depth: step as f32 / STEPS as f32 })
            .collect();
        let (shown, draws) = (Arc::new(AtomicU32::new(0)), Arc::new(AtomicU32::new(0)));
        let (object, count) = (shown.clone(), draws.clone());
        let mut squares = Squares::new(&gpu.device, &gpu.queue, &steps, &[[1.0; 4]]);
        squares.revision = Some(0);
        let squares = squares.drawing(move |pass, corners| {
            count.fetch_add(1, Ordering::Relaxed);
            pass.set_object(object.load(Ordering::Relaxed));
            pass.render_pass().set_vertex_buffer(0, corners.slice(..));
            pass.render_pass().draw(0..6, 0..1);
        });
        let executor = executor(gpu, plan, Some(&squares));
        Self { gpu, squares, executor, target: import(gpu, plan, "target"), shown, draws }
    }

    /// Moves what is drawn.
    fn change(&mut self) {
        let revision = self.squares.revision.map(|revision| revision + 1);
        self.shown.store(revision.unwrap_or(0) as u32 % STEPS, Ordering::Relaxed);
        self.squares.revision = revision;
    }

    /// Plays a frame; how many draws it took.
    fn play(&mut self, views: &[&str]) -> u32 {
        self.draws.store(0, Ordering::Relaxed);
        show(self.gpu, &mut self.executor, Some(&self.squares), &self.target, &frame(views));
        self.draws.load(Ordering::Relaxed)
    }

    /// The step that each texel of the shown layer has; those that are clear have [`STEPS`].
    fn steps(&self) -> Vec<u32> {
        let texels = texels(self.gpu, &self.target, 0);
        texels.iter().map(|[red, ..]| (f32::from(*red) / 255.0 * STEPS as f32).round() as u32).collect()
    }
}

const CHANGED: &str = r#""redraw": "changed""#;

#[test]
fn only_what_changed_is_drawn_again_and_the_rest_stays() {
    let Some(gpu) = gpu::device() else { return };
    let mut stage = Stage::new(&gpu, &kept(3, 1, CHANGED));
    assert_eq!(stage.play(&["0", "1", "2"]), 3);
    let mut drawn = PassCounts::default();
    (drawn.views, drawn.draws, drawn.texels) = (3, 3, 3 * 64);
    assert_eq!(stage.executor.pass_counts().collect::<Vec<_>>(), [("squares", drawn)]);
    assert_eq!(stage.play(&["0", "1", "2"]), 0);
    let mut left = PassCounts::default();
    left.kept = 3;
    assert_eq!(stage.executor.pass_counts().collect::<Vec<_>>(), [("squares", left)]);
    left += drawn;
    left += left;
    assert_eq!((left.views, left.kept, left.draws, left.texels), (6, 6, 6, 6 * 64));
    stage.change();
    // A view moved, in a frame in which the others vanish, and come back.
    assert_eq!(stage.play(&["1 0 0 8 8 2"]), 1);
    assert!(stage.steps().iter().all(|step| *step == STEPS), "cleared, and drawn out of sight");
    assert_eq!(stage.play(&["0", "1", "2"]), 3);
    assert!(stage.steps().iter().all(|step| *step == 1));
    // In another order.
    assert_eq!(stage.play(&["2", "1", "0"]), 0);
    // A host that does not say what changes, and one whose materials do.
    stage.squares.generation += 1;
    assert_eq!(stage.play(&["0", "1"]), 2);
    stage.squares.revision = None;
    assert_eq!((stage.play(&["0"]), stage.play(&["0"])), (1, 1));
}

#[test]
fn views_that_see_nothing_are_not_drawn_again_whatever_changes() {
    let Some(gpu) = gpu::device() else { return };
    let mut stage = Stage::new(&gpu, &kept(1, 0, CHANGED));
    let mut play = |view: &str, x: f64| {
        stage.change();
        let elsewhere = Bounds::between([8.0, -1.0, 0.0], [9.0, 1.0, 1.0]);
        let there = Bounds::between([x, -1.0, 0.0], [x + 1.0, 1.0, 1.0]);
        let input = frame(&[view]).filter_bounds("others", elsewhere).filter_bounds("all", there);
        show(&gpu, &mut stage.executor, Some(&stage.squares), &stage.target, &input);
        let counts =
            stage.executor.pass_counts().map(|(_, counts)| [counts.views, counts.kept, counts.draws]);
        counts.collect::<Vec<_>>()
    };
    // What is beyond the right edge is cleared once, and then kept.
    assert_eq!([play("0", 3.0), play("0", 3.0)], [[[1, 0, 0]], [[0, 1, 0]]]);
    assert_eq!([play("0", 0.0), play("0", 0.0)], [[[1, 0, 1]], [[1, 0, 1]]]);
    // A view of no texels is none.
    assert_eq!([play("0 0 0 8 0", 0.0), play("0 0 0 0 8", 0.0)], [[[0, 0, 0]]; 2]);
}

#[test]
fn another_plan_draws_everything_again() {
    let Some(gpu) = gpu::device() else { return };
    let plan = kept(1, 0, CHANGED);
    let mut stage = Stage::new(&gpu, &plan);
    assert_eq!((stage.play(&["0"]), stage.play(&["0"])), (1, 0));
    let created = stage.executor.statistics();
    stage.executor.set_plan(plan).expect("a plan");
    assert_eq!(
        stage.executor.statistics().pipelines,
        created.pipelines,
        "those of the plan before are taken over"
    );
    assert_eq!(stage.play(&["0"]), 1);
    let created = stage.executor.statistics();
    assert_eq!(stage.play(&["0"]), 0);
    assert_eq!(stage.executor.statistics(), created, "nothing is created for what is kept");
}

#[test]
fn what_a_view_still_shows_is_moved_along_and_strips_are_drawn() {
    let Some(gpu) = gpu::device() else { return };
    let scroll = format!(r#"{CHANGED}, "scroll": true"#);
    let mut stage = Stage::new(&gpu, &kept(2, 1, &scroll));
    stage.play(&["1 0 0 8 8 1"]);
    let texels =
        |stage: &Stage<'_>| stage.executor.pass_counts().map(|(_, counts)| counts.texels).sum::<u64>();
    assert_eq!(texels(&stage), 64);
    // What is drawn from now on has another depth, of which the host does not tell.
    stage.shown.store(5, Ordering::Relaxed);
    let created = stage.executor.statistics();
    assert_eq!(stage.play(&["1 0 0 8 8"]), 1);
    assert_eq!((texels(&stage), stage.executor.statistics()), (32, created));
    let rows = stage.steps();
    assert!(rows.chunks(8).all(|row| row[..4] == [0; 4] && row[4..] == [5; 4]), "{rows:?}");
    // Back, where nothing is drawn at the left.
    assert_eq!(stage.play(&["1 0 0 8 8 1"]), 1);
    let rows = stage.steps();
    assert!(rows.chunks(8).all(|row| row[..4] == [STEPS; 4] && row[4..] == [0; 4]), "{rows:?}");
    // By less than can be seen.
    assert_eq!(stage.play(&["1 0 0 8 8 1.0000001"]), 0);
    let mut left = PassCounts::default();
    left.kept = 1;
    assert_eq!(stage.executor.pass_counts().collect::<Vec<_>>(), [("squares", left)]);
    // Two tiles, of which one moves; what lies beside it stays.
    stage.play(&["1 0 0 4 8", "1 4 0 4 8"]);
    stage.shown.store(7, Ordering::Relaxed);
    assert_eq!(stage.play(&["1 0 0 4 8", "1 4 0 4 8 1"]), 1);
    let rows = stage.steps();
    assert!(rows.chunks(8).all(|row| *row == [5, 5, 5, 5, STEPS, STEPS, 5, 5]), "{rows:?}");
    // What changed is drawn again as a whole, and so is a view that jumps.
    stage.change();
    stage.play(&["1 0 0 4 8", "1 4 0 4 8"]);
    assert_eq!(texels(&stage), 64);
    stage.play(&["1 0 0 4 8", "1 4 0 4 8 9"]);
    assert_eq!(texels(&stage), 32);
}

#[test]
fn what_moved_up_or_down_is_moved_along_too() {
    let Some(gpu) = gpu::device() else { return };
    let mut stage = Stage::new(&gpu, &kept(2, 1, &format!(r#"{CHANGED}, "scroll": true"#)));
    stage.play(&["1 0 0 8 8"]);
    stage.shown.store(5, Ordering::Relaxed);
    for (view, upper, lower) in [("1 0 0 8 8 0 1", 0, STEPS), ("1 0 0 8 8", 5, 0)] {
        assert_eq!(stage.play(&[view]), 1);
        let rows = stage.steps();
        assert!(rows[..32] == [upper; 32] && rows[32..] == [lower; 32], "{view}: {rows:?}");
    }
}

#[test]
fn tiles_are_cleared_by_themselves() {
    let Some(gpu) = gpu::device() else { return };
    let mut stage = Stage::new(&gpu, &kept(1, 0, CHANGED));
    stage.play(&["0 0 0 4 8", "0 4 0 4 8"]);
    // The left tile looks elsewhere, where nothing is.
    assert_eq!(stage.play(&["0 0 0 4 8 2", "0 4 0 4 8"]), 1);
    let rows: Vec<u32> = stage.steps();
    assert!(rows.chunks(8).all(|row| row[..4] == [STEPS; 4] && row[4..] == [0; 4]), "{rows:?}");
    // A tile over parts of both takes their place; both are drawn when they come back.
    stage.change();
    assert_eq!(stage.play(&["0 2 2 4 4"]), 1);
    let rows = stage.steps();
    let is_inside = |at: usize| (2..6).contains(&(at % 8)) && (2..6).contains(&(at / 8));
    assert!(rows.iter().enumerate().all(|(at, step)| (*step == 1) == is_inside(at)), "{rows:?}");
    assert_eq!(stage.play(&["0 0 0 4 8", "0 4 0 4 8"]), 2);
}

#[test]
fn no_tile_is_older_than_the_cadence_when_something_moved() {
    let Some(gpu) = gpu::device() else { return };
    let plans = [1, 2, 4, 8].map(|every| (every, kept(1, 0, &format!(r#"{CHANGED}, "every": {every}"#))));
    for (run, (every, plan)) in (0..50_u64).zip(plans.iter().cycle()) {
        let mut stage = Stage::new(&gpu, plan);
        let mut random = Random(run);
        let mut steps = Vec::new();
        let mut corners = [0, 1, 2, 3];
        for _ in 0..24 {
            if !random.one_in(3) {
                stage.change();
            }
            // Four tiles that change places, some of which are not there.
            if random.one_in(8) {
                corners.swap(random.below(4), random.below(4));
            }
            let present = random.below(16);
            let tile = |at: u32| (at % 2 * 4, at / 2 * 4);
            let views: Vec<String> = corners
                .iter()
                .filter(|at| present >> **at & 1 == 1)
                .map(|at| format!("0 {} {} 4 4", tile(*at).0, tile(*at).1))
                .collect();
            let views: Vec<&str> = views.iter().map(String::as_str).collect();
            stage.play(&views);
            steps.push(stage.squares.revision.unwrap_or(0) as u32);
            let oldest = steps[steps.len().saturating_sub(*every)];
            let drawn = stage.steps();
            for at in (0..4).filter(|at| present >> at & 1 == 1) {
                let (x, y) = tile(at);
                let step = drawn[(y * 8 + x) as usize];
                assert!(
                    (oldest..=*steps.last().unwrap_or(&0)).contains(&step),
                    "run {run}: tile {at} shows {step}, {oldest} is {every} frames old"
                );
            }
        }
    }
}

#[test]
fn the_cadence_saves_draws_and_turns_are_staggered() {
    let Some(gpu) = gpu::device() else { return };
    let mut stage = Stage::new(&gpu, &kept(4, 0, &format!(r#"{CHANGED}, "every": [1, 4, 4, 4]"#)));
    stage.play(&["0", "1", "2", "3"]);
    let counts: Vec<u32> = (0..8)
        .map(|_| {
            stage.change();
            stage.play(&["0", "1", "2", "3"])
        })
        .collect();
    assert_eq!(counts.iter().sum::<u32>(), 8 + 3 * 2);
    assert!(counts.iter().all(|count| (1..=2).contains(count)), "{counts:?}");
}

#[test]
fn what_cannot_be_kept_is_found() {
    let draw = |texture: &str, more: &str| {
        try_plan_of_text(
            format!(
                r#"{{ "format": 1, "name": "test", {}, "resources": {{
                    "maps": {{ "texture": {{ "format": "depth32float", "size": "=viewport", {texture} }} }},
                    "below": {{ "texture": {{ "format": "depth32float", "size": "=viewport", {texture} }} }} }},
                  "passes": {{ "views": {{ "views": {{ "to": "&views", "max": 1 }} }},
                    "squares": {{ "draw": {{ "geometry": "squares", "mesh_filter": "all", "views": "&views",
                      "shader": "square_depth.wgsl.jinja", "redraw": "changed", {more} }} }} }} }}"#,
                crate::executing::squares::GEOMETRY
            ),
            8,
        )
        .map(drop)
    };
    let persistent = r#""lifetime": "persistent""#;
    let depth = r#""depth": { "to": "&maps", "clear": 1, "compare": "less" }"#;
    assert_eq!(draw(persistent, depth), Ok(()));
    let said = |texture: &str, more: &str, wanted: &str| {
        let error = draw(texture, more).expect_err("a diagnostic");
        assert!(error.contains(wanted), "{error}");
    };
    said(persistent, r#""depth": { "to": "&maps", "compare": "less" }"#, "UG0405");
    said(persistent, &format!(r#""every": 0, {depth}"#), "every so many frames");
    said(persistent, &format!(r#""base": "&maps", {depth}"#), "UG0405");
    let several = format!(r#"{persistent}, "samples": 4"#);
    let over = r#""base": "&below", "depth": { "to": "&maps", "compare": "less" }"#;
    said(&several, over, "has 4 samples, over which nothing is drawn");
    said(r#""lifetime": "transient""#, depth, "UG04");
}

#[test]
fn views_over_a_base_texture_are_drawn_texel_by_texel() {
    let over = |below: &str| {
        let text = format!(
            r#"{{ "format": 1, "name": "test", {}, "resources": {{ {},
                "below": {{ "texture": {{ "lifetime": "persistent", "view_dimension": "2d-array", {below} }} }},
                "maps": {{ "texture": {{ "format": "depth32float", "size": "=viewport", "layers": 2, "view_dimension": "2d-array",
                  "lifetime": "persistent" }} }} }},
              "passes": {{ "views": {{ "views": {{ "to": "&views", "max": 2 }} }},
                "squares": {{ "draw": {{ "geometry": "squares", "mesh_filter": "all", "views": "&views",
                  "shader": "square_depth.wgsl.jinja", {CHANGED}, "base": "&below",
                  "depth": {{ "to": "&maps", "compare": "less" }} }} }},
                "show": {{ "fullscreen": {{ "shader": "show_depth.wgsl.jinja",
                  "bind": {{ "maps": "&maps", "settings": {{ "values": {{ "layer": 1 }} }} }},
                  "color": [{{ "to": "&target" }}] }} }} }} }}"#,
            crate::executing::squares::GEOMETRY,
            target(1)
        );
        let at = text.find(r#""base": "&below""#).expect("the key") + r#""base": "#.len();
        let (line, column) = (text[..at].lines().count(), at - text[..at].rfind('\n').expect("a line"));
        try_plan_of_text(text, 8).map(drop).map_err(|said| (said, format!(":{line}:{column}\n")))
    };
    let depth = r#""format": "depth32float""#;
    assert_eq!(over(&format!(r#"{depth}, "size": "=viewport", "layers": 2"#)), Ok(()));
    assert_eq!(over(r#""format": "depth16unorm", "size": "=viewport", "layers": 2"#), Ok(()));
    for (below, wanted) in [
        (
            format!(r#"{depth}, "size": [4, 8], "layers": 2"#),
            "\"below\" is 4 by 8 with 2 layers and 1 samples",
        ),
        (format!(r#"{depth}, "size": "=viewport", "layers": 3"#), "\"below\" is 8 by 8 with 3 layers"),
        (format!(r#"{depth}, "size": "=viewport""#), "\"below\" is 8 by 8 with 1 layers"),
        (r#""format": "rgba8unorm", "size": "=viewport", "layers": 2"#.to_owned(), "\"below\" has no depth"),
    ] {
        let (said, place) = over(&below).expect_err("a diagnostic");
        let error = &said[said.find("error[UG0405]").expect("the error behind a warning")..];
        assert!(error.contains(wanted), "{error}");
        assert!(error.contains(&place), "{place}{error}");
    }
}

#[test]
fn a_parameter_draws_those_views_again_that_are_drawn_with_it() {
    let Some(gpu) = gpu::device() else { return };
    let text = format!(
        r#"{{ "format": 1, "name": "test", {}, "parameters": {{
            "layer": {{ "type": "u32", "default": 0, "min": 0, "max": 1 }},
            "far": {{ "type": "f32", "default": 1, "min": 0, "max": 1 }},
            "idle": {{ "type": "f32", "default": 1, "min": 0, "max": 1 }} }},
          "resources": {{ "maps": {{ "texture": {{ "format": "depth32float", "size": "=viewport", "layers": 2,
            "view_dimension": "2d-array", "lifetime": "persistent" }} }}, {} }},
          "passes": {{ "views": {{ "views": {{ "to": "&views", "max": 2 }} }},
            "squares": {{ "draw": {{ "geometry": "squares", "mesh_filter": "all", "views": "&views", "cull": "none",
              "shader": "square_depth.wgsl.jinja", {CHANGED},
              "depth": {{ "to": "&maps", "clear": "=far * idle / idle", "compare": "less-equal" }} }} }},
            "show": {{ "fullscreen": {{ "shader": "show_depth.wgsl.jinja",
              "bind": {{ "maps": "&maps", "settings": {{ "values": {{ "layer": "=layer" }} }} }},
              "color": [{{ "to": "&target" }}] }} }} }} }}"#,
        crate::executing::squares::GEOMETRY,
        target(1)
    );
    let plan = try_plan_of_text(text, 8).unwrap_or_else(|said| panic!("{said}"));
    let mut stage = Stage::new(&gpu, &plan);
    // Both views look elsewhere, where nothing is.
    let views = ["0 0 0 8 8 2", "1 0 0 8 8 2"];
    assert_eq!((stage.play(&views), stage.play(&views)), (2, 0));
    assert!(stage.steps().iter().all(|step| *step == STEPS));
    // What shows the maps is no part of them; nor is a value that stays the same.
    let layer = stage.executor.parameter::<u32>("layer").expect("a live parameter");
    stage.executor.set(layer, 1).expect("a value");
    assert_eq!(stage.play(&views), 0);
    let idle = stage.executor.parameter::<f32>("idle").expect("a live parameter");
    stage.executor.set(idle, 0.5).expect("a value");
    assert_eq!(stage.play(&views), 0);
    let far = stage.executor.parameter::<f32>("far").expect("a live parameter");
    stage.executor.set(far, 0.4).expect("a value");
    assert_eq!((stage.play(&views), stage.play(&views)), (2, 0));
    assert!(stage.steps().iter().all(|step| *step == STEPS * 2 / 5), "{:?}", stage.steps());
}

#[test]
fn a_parameter_redraws_views_that_follow_from_it() {
    let Some(gpu) = gpu::device() else { return };
    let text = format!(
        r#"{{ "format": 1, "name": "test", {}, "parameters": {{
            "step": {{ "type": "u32", "default": 1, "min": 0, "max": 80 }} }},
          "resources": {{ "maps": {{ "texture": {{ "format": "depth32float", "size": "=viewport",
            "view_dimension": "2d-array", "lifetime": "persistent" }} }}, "words": {{ "buffer": {{ "size": 4 }} }}, {} }},
          "passes": {{ "views": {{ "views": {{ "to": "&views", "max": 1 }} }},
            "clear": {{ "clear": {{ "buffer": "&words" }} }},
            "bump": {{ "compute": {{ "shader": "bump.wgsl.jinja", "workgroups": [1, 1, 1],
              "bind": {{ "words": "&words", "settings": {{ "values": {{ "number": "=step" }} }} }} }} }},
            "squares": {{ "draw": {{ "geometry": "squares", "mesh_filter": "all", "views": "&views", "cull": "none",
              "shader": "sunk_depth.wgsl.jinja", "bind": {{ "words": "&words" }}, {CHANGED},
              "depth": {{ "to": "&maps", "clear": 1, "compare": "less-equal" }} }} }},
            "show": {{ "fullscreen": {{ "shader": "show_depth.wgsl.jinja",
              "bind": {{ "maps": "&maps", "settings": {{ "values": {{ "layer": 0 }} }} }},
              "color": [{{ "to": "&target" }}] }} }} }} }}"#,
        crate::executing::squares::GEOMETRY,
        target(1)
    );
    let plan = try_plan_of_text(text, 8).unwrap_or_else(|said| panic!("{said}"));
    let mut stage = Stage::new(&gpu, &plan);
    assert_eq!((stage.play(&["0"]), stage.play(&["0"])), (1, 0));
    assert!(stage.steps().iter().all(|step| *step == 1));
    let step = stage.executor.parameter::<u32>("step").expect("a live parameter");
    stage.executor.set(step, 7).expect("a value");
    assert_eq!((stage.play(&["0"]), stage.play(&["0"])), (1, 0));
    assert!(stage.steps().iter().all(|step| *step == 7), "{:?}", stage.steps());
}
