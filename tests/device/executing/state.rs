//! State that CPU passes keep from frame to frame: each executor on a plan has its own.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph::Executor;
use umbragraph::Plan;
use umbragraph::data::{BlackboardData, DataShape, ValueType};
use umbragraph::diagnostic::{Diagnostic, Place, codes};
use umbragraph::low_level::compiler::{CpuPasses, PhysicalTexture, TextureSize};
use umbragraph::low_level::language::{Expr, Ref};
use umbragraph::low_level::pipeline::{Evaluate, PassBuilder, Produced};
use umbragraph::node::Node;
use umbragraph::work::{CpuContext, CpuNode, CpuWork, Work};
use umbragraph_test_support::gpu::{self, Gpu};

use crate::common::gpu::{empty_frame, import};
use crate::executing::stage::{self, executor, show, target, texels};

const _: () = {
    const fn shared<T: Send + Sync>() {}
    shared::<Plan>();
};

/// Counts frames up from a number, and says when it begins.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Count {
    /// The blackboard data to publish.
    to: Ref,
    /// The first number.
    from: Expr,
}

impl Node for Count {
    const NAME: &'static str = "count";
    const SUMMARY: &'static str = "Counts frames.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let from = pass.count(&self.from, "/from")?;
        let output =
            pass.publish(&self.to, "/to", DataShape::new().value("time", ValueType::F32, "seconds"))?;
        pass.produce(Work::Cpu(CpuWork::new(RunCount { from }, output, Vec::new())))
    }
}

#[derive(Clone, Debug, PartialEq)]
struct RunCount {
    from: u32,
}

impl CpuNode for RunCount {
    type State = u32;

    fn run(&self, frames: &mut u32, _: &CpuContext<'_>, data: &mut BlackboardData) {
        if *frames < 2 {
            let notice = Diagnostic::warning(codes::FRAME_INPUT, Place::Nowhere, "begins".to_owned());
            data.set_notices((*frames == 0).then_some(notice).into_iter().collect());
        }
        data.set_f32("time", (self.from + *frames) as f32 / 255.0);
        *frames += 1;
    }
}

/// A plan that shows the number of the frame, counted from one by a pass of a name.
fn plan(pass: &str, from: u32) -> Arc<Plan> {
    let passes = format!(
        r#""{pass}": {{ "count": {{ "to": "&number", "from": {from} }} }},
           "show": {{ "fullscreen": {{ "shader": "clock.wgsl.jinja", "bind": {{ "views": "&number" }},
               "color": [{{ "to": "&target" }}] }} }}"#
    );
    stage::plan(&target(1), &passes)
}

/// An executor with what it shows.
struct Player<'a> {
    gpu: &'a Gpu,
    executor: Executor,
    target: wgpu::Texture,
}

impl<'a> Player<'a> {
    fn new(gpu: &'a Gpu, plan: &Arc<Plan>) -> Self {
        Self { gpu, executor: executor(gpu, plan, None), target: import(gpu, plan, "target") }
    }

    /// The number that the next frame shows, and whether it begins.
    fn next(&mut self) -> (u8, bool) {
        show(self.gpu, &mut self.executor, None, &self.target, &empty_frame());
        (texels(self.gpu, &self.target, 0)[0][0], self.executor.notices().next().is_some())
    }

    #[track_caller]
    fn set_plan(&mut self, plan: Arc<Plan>) {
        self.executor.set_plan(plan).expect("another plan");
    }
}

#[test]
fn executors_on_one_plan_count_for_themselves() {
    let Some(gpu) = gpu::device() else { return };
    let plan = plan("count", 10);
    let mut first = Player::new(&gpu, &plan);
    assert_eq!(first.next(), (10, true));
    assert_eq!(first.next(), (11, false));
    let mut second = Player::new(&gpu, &plan);
    assert_eq!(second.next(), (10, true), "a new executor gives its notices again");
    assert_eq!(first.next(), (12, false));
    assert_eq!(second.next(), (11, false));
}

#[test]
fn a_pass_goes_on_in_another_plan_where_it_is_the_same() {
    let Some(gpu) = gpu::device() else { return };
    let mut player = Player::new(&gpu, &plan("count", 10));
    player.next();
    player.set_plan(plan("count", 10));
    assert_eq!(player.next(), (11, false), "the same pass of a plan that was made again");
    player.set_plan(plan("other", 10));
    assert_eq!(player.next(), (10, true), "another name");
    player.set_plan(plan("other", 20));
    assert_eq!(player.next(), (20, true), "other settings");
}

#[test]
fn a_rejected_plan_leaves_the_state_of_the_one_before() {
    let Some(gpu) = gpu::device() else { return };
    let good = plan("count", 10);
    let mut player = Player::new(&gpu, &good);
    player.next();
    let mut bad = (*good).clone();
    bad.textures.push(PhysicalTexture {
        label: "three samples".into(),
        format: wgpu::TextureFormat::Rgba8Unorm,
        size: TextureSize::new(4, 4).samples(3),
        volume: false,
        usages: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_format: None,
        spare_layer: false,
        bytes: 192,
    });
    player.executor.set_plan(bad.into()).expect_err("a plan that cannot be");
    assert_eq!(player.next(), (11, false));
}

#[test]
fn without_a_device_passes_publish_the_same() {
    let mut passes = CpuPasses::new(plan("count", 10));
    let mut next = |plan: Option<Arc<Plan>>| {
        plan.into_iter().for_each(|plan| passes.set_plan(plan));
        passes.run(&empty_frame(), &[]).expect("what was declared");
        let words = passes.data("number").and_then(|data| data.words("time")).expect("a published value");
        (f32::from_bits(words[0]) * 255.0, passes.notices().count())
    };
    assert_eq!(next(None), (10.0, 1));
    assert_eq!(next(Some(plan("count", 10))), (11.0, 0));
    assert_eq!(next(Some(plan("count", 20))), (20.0, 1));
    assert_eq!(next(Some(plan("other", 20))), (20.0, 1));
    assert!(passes.run(&empty_frame(), &[("nothing", true)]).is_err(), "a toggle that there is not");
}
