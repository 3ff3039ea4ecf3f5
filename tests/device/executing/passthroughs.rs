//! Chains of passthroughs: whatever the toggles of their links, the first that is there is seen, and the checker
//! agrees.

use umbragraph::Frame;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::wgpu;
use umbragraph_test_support::gpu;
use umbragraph_test_support::property;
use umbragraph_verify::verify;

use crate::common::gpu::import;
use crate::executing::stage::{SIDE, color, executor, fill, plan_of_text};
use crate::executing::views::frame;

const NAMES: [&str; 4] = ["s", "!s", "t", "!t"];

/// Whether a toggle runs its passes while "s" and "t" are switched like this.
fn holds(toggle: &str, [s, t]: [bool; 2]) -> bool {
    match toggle {
        "s" => s,
        "!s" => !s,
        "t" => t,
        _ => !t,
    }
}

/// The red of what a pass sees of `link0`, which is passed through to `link1`, and so on to `base`, in each state.
fn check(chain: &[&str], shown: &str, renders: bool) {
    let Some(gpu) = gpu::device() else { return };
    let name = |at: usize| if at < chain.len() { format!("link{at}") } else { "base".to_owned() };
    let texture = |name: String| {
        format!(r#""{name}": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport" }} }}"#)
    };
    let mut resources: Vec<String> = (0..=chain.len()).map(|at| texture(name(at))).collect();
    resources.push(crate::executing::stage::target(1));
    let mut passes = vec![fill("base", r#"{ "to": "&base" }"#, "[\"=9 / 255\", 0, 0, 1]"), shown.to_owned()];
    for (at, toggle) in chain.iter().enumerate() {
        let link = fill(
            &name(at),
            &format!(r#"{{ "to": "&{}" }}"#, name(at)),
            &format!("[\"={at} / 255\", 0, 0, 1]"),
        );
        let common = format!(
            r#"": {{ "toggle": "{toggle}", "passthrough": {{ "{}": "&{}" }}, "#,
            name(at),
            name(at + 1)
        );
        passes.push(link.replacen(r#"": {"#, &common, 1));
    }
    let used = |toggle: &&str| chain.iter().any(|other| other.trim_start_matches('!') == *toggle);
    let toggles: Vec<String> = ["s", "t"]
        .iter()
        .filter(|toggle| used(toggle))
        .map(|name| format!(r#""{name}": {{ "default": true }}"#))
        .collect();
    let text = format!(
        r#"{{ "format": 1, "name": "test", "toggles": {{ {} }}, "resources": {{ {} }}, "passes": {{ {} }} }}"#,
        toggles.join(", "),
        resources.join(", "),
        passes.join(", ")
    );
    let plan = plan_of_text(text, SIDE);
    assert_eq!(verify(&plan, &PlanOptions::new(SIDE, SIDE)), Vec::new(), "{chain:?}");
    if !renders {
        return;
    }
    let mut executor = executor(&gpu, &plan, None);
    let picture = import(&gpu, &plan, "target");
    for state in [[true, true], [true, false], [false, true], [false, false]] {
        let toggles = [("s", state[0]), ("t", state[1])];
        let toggles: Vec<(&str, bool)> = toggles.into_iter().filter(|(name, _)| used(name)).collect();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let (input, imports) = (frame(&[]), [("target", &picture)]);
        let frame = Frame::new(&input).imports(&imports).toggles(&toggles);
        executor.record(&mut encoder, &frame).expect("a record");
        gpu.queue.submit([encoder.finish()]);
        let seen = chain.iter().position(|toggle| holds(toggle, state)).map_or(9, |at| at as u8);
        assert_eq!(color(&gpu, &picture, 0)[0], seen, "{chain:?} in {state:?}");
    }
}

const SAMPLED: &str = r#""show": { "fullscreen": { "shader": "show.wgsl.jinja", "bind": { "picture": "&link0" },
    "color": [{ "to": "&target" }] } }"#;
const COPIED: &str = r#""show": { "copy": { "from": { "name": "&link0" }, "to": { "name": "&target" } } }"#;

#[test]
fn chains_over_all_toggles_show_the_first_link_that_is_there() {
    let pairs: Vec<_> = NAMES.iter().flat_map(|first| NAMES.map(|second| [*first, second])).collect();
    for [first, second] in property::part(pairs, 4) {
        for third in NAMES {
            let renders = first == "s";
            check(&[first, second, third], SAMPLED, renders);
            check(&[first, second, third], COPIED, renders);
        }
        check(&[first, second], COPIED, true);
    }
}

#[test]
fn a_pass_with_a_toggle_of_the_chain_sees_it_through() {
    for own in NAMES {
        let shown = SAMPLED.replacen(r#""show": {"#, &format!(r#""show": {{ "toggle": "{own}","#), 1);
        let back = fill("back", r#"{ "to": "&target" }"#, "[\"=7 / 255\", 0, 0, 1]");
        let shown = shown.replacen(r#""toggle""#, r#""after": ["back"], "toggle""#, 1);
        for first in property::part(NAMES, 2) {
            for second in NAMES {
                check(&[first, second, own], &format!("{back}, {shown}"), false);
            }
        }
    }
}
