//! The compiler's decisions on pipelines: order, culling, hazards, lifetimes, store operations.

use crate::common::{With, check, check_file};
use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::{
    Assembly, CullReason, ImportDescriptor, Physical, PlanOptions, StoreOperation, build,
};
use umbragraph::low_level::report::{EdgeKind, Report};
use umbragraph::low_level::why::{why_apart, why_culled, why_kept};
use umbragraph::wgpu_types::TextureFormat;

const TEXTURE: &str = r#"{ "texture": { "format": "rgba8unorm", "size": "=viewport" } }"#;
const TARGET: &str =
    r#"{ "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }"#;

/// A pipeline over textures `names` and the imported `target`, with these passes.
fn pipeline(names: &[&str], passes: &[String]) -> String {
    let resources: Vec<String> = names.iter().map(|name| format!("\"{name}\": {TEXTURE}")).collect();
    let separator = if names.is_empty() { "" } else { "," };
    format!(
        "{{ \"format\": 1, \"name\": \"test\", \"resources\": {{ {}{separator} \"target\": {TARGET} }}, \"passes\": {{ {} }} }}",
        resources.join(","),
        passes.join(",\n")
    )
}

/// A pass that writes all of a texture.
fn fill(name: &str, to: &str) -> String {
    format!(
        "\"{name}\": {{ \"fullscreen\": {{ \"shader\": \"gradient.wgsl.jinja\", \"color\": [{{ \"to\": \"&{to}\" }}] }} }}"
    )
}

/// A pass that adds to a texture.
fn add(name: &str, to: &str, more: &str) -> String {
    format!(
        "\"{name}\": {{ {more} \"fullscreen\": {{ \"shader\": \"gradient.wgsl.jinja\", \"color\": [{{ \"to\": \"&{to}\", \"blend\": \"add\" }}] }} }}"
    )
}

/// A pass that reads one texture and writes all of another.
fn copy(name: &str, from: &str, to: &str) -> String {
    copy_with(name, from, to, "")
}

fn copy_with(name: &str, from: &str, to: &str, more: &str) -> String {
    format!(
        "\"{name}\": {{ {more} \"fullscreen\": {{ \"shader\": \"tonemap.wgsl.jinja\", \"axes\": {{ \"debug_view\": \"shadow_term\" }}, \
         \"bind\": {{ \"source\": \"&{from}\" }}, \"color\": [{{ \"to\": \"&{to}\" }}] }} }}"
    )
}

#[test]
fn a_reader_declared_before_its_writer_runs_after_it() {
    let outcome = check(&pipeline(&["a"], &[copy("show", "a", "target"), fill("make", "a")]));
    assert_eq!(outcome.order(), ["make", "show"]);
}

/// A pipeline with a history `h` of one frame, the textures `names` and the imported `target`.
fn with_history(names: &[&str], passes: &[String]) -> String {
    let history = r#""h": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "history", "initial": 0 } },"#;
    pipeline(names, passes).replacen("\"resources\": {", &format!("\"resources\": {{ {history}"), 1)
}

#[test]
fn a_history_read_keeps_its_writer_and_waits_for_none() {
    let passes = [copy("late", "h@-1", "target"), copy("b", "a", "h"), fill("a", "a"), fill("dead", "b")];
    let outcome = check(&with_history(&["a", "b"], &passes));
    assert_eq!(outcome.order(), ["late", "a", "b"]);
    let plan = outcome.plan();
    let why = |name: &str| {
        let pass = plan.pipeline.find_pass(name).unwrap();
        why_kept(plan, pass).collect::<Vec<_>>()
    };
    assert_eq!(why("b"), ["late reads h@-1 in the next frame", "writes the output target"]);
    assert_eq!(why("a"), ["b reads a", "late reads h@-1 in the next frame", "writes the output target"]);
    assert_eq!(plan.textures.len(), 3, "two copies of the history, and a");
    let graph = outcome.checked.graph.as_ref().expect("a graph");
    let report = Report::new(plan, graph, &outcome.sources);
    let later = report.edges.iter().filter(|edge| edge.kind == EdgeKind::LaterFrame);
    let named = |at: usize| report.passes[at].name.as_str();
    let later: Vec<_> =
        later.map(|edge| (named(edge.from), named(edge.to), edge.resource.as_deref())).collect();
    assert_eq!(later, [("b", "late", Some("h@-1"))]);
}

#[test]
fn a_history_that_only_its_own_writer_reads_keeps_nothing() {
    let passes = [copy("cycle", "h@-1", "h"), fill("show", "target")];
    let outcome = check(&with_history(&[], &passes));
    assert_eq!(outcome.order(), ["show"]);
    assert_eq!(outcome.plan().culled["cycle"], CullReason::NothingReads(vec!["h".into()]));
    // What a culled pass reads of another history is no use of this one.
    let passes = [fill("write", "h"), copy("other", "g@-1", "a"), fill("g", "g"), fill("show", "target")];
    let text = with_history(&["a"], &passes);
    let at = text.find(r#""h": {"#).expect("the history");
    let end = at + text[at..].find("},").expect("its end") + 2;
    let text = format!("{}{}{}", &text[..end], text[at..end].replace("\"h\"", "\"g\""), &text[end..]);
    let plan = check(&text).checked.plan.expect("a plan with a warning");
    assert_eq!(plan.culled["write"], CullReason::NothingReads(vec!["h".into()]));
}

#[test]
fn a_cycle_of_passes_over_frames_is_culled_with_its_reasons() {
    let passes = [copy("one", "h@-1", "a"), copy("two", "a", "h"), fill("show", "target")];
    let outcome = check(&with_history(&["a"], &passes));
    assert_eq!(outcome.order(), ["show"]);
    assert_eq!(outcome.plan().culled["two"], CullReason::OnlyCulledRead(vec!["one".into()]));
    assert_eq!(outcome.plan().culled["one"], CullReason::OnlyCulledRead(vec!["two".into()]));
    assert!(outcome.plan().why_culled("one").count() <= 2);
}

#[test]
fn a_history_never_shares_memory_and_is_stored() {
    let passes = [
        fill("a", "a"),
        copy("b", "a", "h"),
        copy_with("c", "h", "d", "\"side_effect\": true,"),
        copy("show", "h@-1", "target"),
    ];
    let outcome = check(&with_history(&["a", "d"], &passes));
    let plan = outcome.plan();
    let stored = plan.passes.iter().find(|pass| pass.name == "b").unwrap().color[0].store;
    assert_eq!(stored, StoreOperation::Store);
    let places: Vec<Physical> = ["h", "h@-1", "a", "d"].map(|name| plan.resources[name].physical).to_vec();
    assert!(places[0] != places[1] && !places[2..].contains(&places[0]) && !places[2..].contains(&places[1]));
}

#[test]
fn an_input_of_a_subgraph_can_be_an_earlier_frame() {
    let subgraph = r#""subgraphs": { "blur": { "inputs": { "image": "read" }, "passes": {
        "go": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&image" }, "color": [{ "to": "&target" }] } } } } },"#;
    let passes =
        [fill("write", "h"), r#""blur": { "use": "blur", "with": { "image": "&h@-1" } }"#.to_owned()];
    let text = with_history(&[], &passes).replacen("\"passes\"", &format!("{subgraph} \"passes\""), 1);
    let text = text
        .replace(r#""inputs": { "image": "read" }"#, r#""inputs": { "image": "read", "target": "written" }"#);
    let text = text.replace(r#""image": "&h@-1" }"#, r#""image": "&h@-1", "target": "&target" }"#);
    let outcome = check(&text);
    let plan = outcome.plan();
    assert_eq!(outcome.order(), ["write", "blur.go"]);
    assert!(plan.resources.contains_key("h@-1"));
}

#[test]
fn a_history_without_a_use_is_worth_a_warning() {
    let outcome = check(&with_history(&[], &[fill("write", "h"), fill("show", "target")]));
    assert_eq!(outcome.codes(), ["UG0434"]);
    let outcome = check(&with_history(&[], &[copy("show", "h@-1", "target")]));
    assert_eq!(outcome.codes(), ["UG0434"]);
    assert_eq!(outcome.checked.plan.as_ref().unwrap().passes.len(), 1);
}

#[test]
fn an_old_version_is_read_before_it_is_overwritten() {
    // W1 writes, R reads what W1 wrote, W2 overwrites, C reads the newest.
    let passes = [
        copy("c", "a", "target"),
        copy_with("w2", "b", "a", "\"after\": [\"w1\"],"),
        copy("r", "a@w1", "b"),
        fill("w1", "a"),
    ];
    let outcome = check(&pipeline(&["a", "b"], &passes));
    assert_eq!(outcome.order(), ["w1", "r", "w2", "c"]);
}

#[test]
fn a_reader_of_an_old_version_runs_before_the_next_writer() {
    let passes = [
        add("w2", "a", ""),
        copy("old", "a@w1", "b"),
        fill("w1", "a"),
        copy("new", "a", "target"),
        add("late", "target", "\"after\": [\"new\"],"),
        copy_with("keep", "b", "c", "\"side_effect\": true,"),
    ];
    let outcome = check(&pipeline(&["a", "b", "c"], &passes));
    let order = outcome.order();
    let at = |name: &str| order.iter().position(|other| *other == name).unwrap();
    assert!(at("old") < at("w2"), "{order:?}");
    assert!(at("w2") < at("new"), "{order:?}");
}

#[test]
fn unread_passes_are_culled_and_allocate_nothing() {
    let passes = [fill("show", "target"), fill("a1", "a"), copy("b1", "a", "b"), copy("c1", "b", "c")];
    let outcome = check(&pipeline(&["a", "b", "c"], &passes));
    assert_eq!(outcome.order(), ["show"]);
    let plan = outcome.plan();
    assert!(plan.textures.is_empty());
    assert_eq!(plan.culled["c1"], CullReason::NothingReads(vec!["c".to_owned()]));
    assert_eq!(plan.culled["a1"], CullReason::OnlyCulledRead(vec!["b1".to_owned()]));
}

#[test]
fn a_kept_pass_says_on_which_way_it_leads_to_the_output() {
    let outcome = check(&pipeline(
        &["a", "b"],
        &[fill("one", "a"), copy("two", "a", "b"), copy("three", "b", "target")],
    ));
    assert_eq!(
        why_kept(outcome.plan(), outcome.plan().passes[0].handle).collect::<Vec<_>>(),
        ["two reads a", "three reads b", "writes the output target"]
    );
}

#[test]
fn a_pass_with_a_side_effect_is_kept() {
    let passes = [
        fill("show", "target"),
        add("effect", "a", "\"side_effect\": true, \"after\": [\"first\"],"),
        fill("first", "a"),
    ];
    assert_eq!(check(&pipeline(&["a"], &passes)).order(), ["show", "first", "effect"]);
}

#[test]
fn only_transients_with_disjoint_lifetimes_share_a_texture() {
    let passes = [fill("p1", "a"), copy("p2", "a", "b"), copy("p3", "b", "c"), copy("p4", "c", "target")];
    let outcome = check(&pipeline(&["a", "b", "c"], &passes));
    let plan = outcome.plan();
    let physical = |name: &str| plan.resources[name].physical;
    assert_eq!(physical("a"), physical("c"));
    assert_ne!(physical("a"), physical("b"));
    assert_eq!(plan.textures.len(), 2);
    assert_eq!(plan.bytes_without_aliasing, 3 * 640 * 480 * 4);
    assert_eq!(plan.bytes, 2 * 640 * 480 * 4);
    assert_eq!(plan.resources["target"].physical, Physical::Imported);
}

#[test]
fn only_what_is_read_later_is_stored() {
    let text = pipeline(&["a"], &[fill("p1", "a"), copy("p2", "a", "target")]).replace(
        "\"passes\": {",
        r#""geometry": { "scene": { "vertex": { "position": "float32x3" } } }, "passes": {"#,
    );
    let outcome = check(&text);
    let plan = outcome.plan();
    assert_eq!(plan.passes[0].color[0].store, StoreOperation::Store);
    let unread = check(&pipeline(
        &["a"],
        &[
            add("p1", "a", "\"side_effect\": true, \"after\": [\"p0\"],"),
            fill("p0", "a"),
            fill("p2", "target"),
        ],
    ));
    let last = unread.plan().passes.iter().find(|pass| pass.name == "p1").unwrap();
    assert_eq!(last.color[0].store, StoreOperation::Discard, "nothing reads a afterwards");
    let first = unread.plan().passes.iter().find(|pass| pass.name == "p0").unwrap();
    assert_eq!(first.color[0].store, StoreOperation::Store, "p1 loads it");
}

#[test]
fn permuted_declarations_keep_the_order_of_data() {
    let mut passes = [fill("p1", "a"), copy("p2", "a", "b"), copy("p3", "b", "target")];
    let before: Vec<String> =
        check(&pipeline(&["a", "b"], &passes)).order().into_iter().map(str::to_owned).collect();
    passes.reverse();
    assert_eq!(check(&pipeline(&["b", "a"], &passes)).order(), before);
}

#[test]
fn a_cycle_names_all_of_its_members() {
    let outcome = check(&pipeline(
        &["a", "b", "c"],
        &[copy("p1", "c", "a"), copy("p2", "a", "b"), copy("p3", "b", "c"), copy("show", "c", "target")],
    ));
    assert_eq!(outcome.codes(), ["UG0403"]);
    let diagnostic = outcome.diagnostics.iter().next().unwrap();
    assert_eq!(diagnostic.message, "the passes \"p1\", \"p2\", \"p3\" wait for one another");
    let steps: Vec<&str> = diagnostic.related.iter().map(|related| related.message.as_str()).collect();
    assert_eq!(
        steps,
        ["\"p2\" reads \"a\" of \"p1\"", "\"p3\" reads \"b\" of \"p2\"", "\"p1\" reads \"c\" of \"p3\""]
    );
}

#[test]
fn a_cycle_says_what_is_overwritten() {
    let said = |assembly: Assembly| {
        let mut diagnostics = Diagnostics::new();
        assert!(build(&assembly.finish().0, &mut diagnostics).is_none());
        let diagnostic = diagnostics.iter().next().expect("a diagnostic");
        diagnostic.related.iter().map(|related| related.message.clone()).collect::<Vec<_>>()
    };
    let start = |name: &str| {
        let mut assembly = Assembly::new(name);
        let textures = ["a", "b", "c"].map(|name| assembly.texture(name));
        (assembly, textures)
    };
    let (mut assembly, [a, b, _]) = start("what is read");
    let first = assembly.pass("first").writes(a).handle();
    let _ = assembly.pass("old").reads_version(a, "first").reads(b);
    let _ = assembly.pass("new").writes(a).writes(b).after(first);
    let read = ["\"new\" overwrites \"a\", which \"old\" reads", "\"old\" reads \"b\" of \"new\""];
    assert_eq!(said(assembly), read);
    let (mut assembly, [a, b, c]) = start("what is written");
    let old = assembly.texture("old");
    let start = assembly.pass("start").writes(old).handle();
    let _ = assembly.pass("first").writes(a).writes(b).writes(old).after(start);
    let _ = assembly.pass("between").reads(b).writes(c);
    let _ = assembly.pass("new").reads(c).reads_version(old, "start").writes(a);
    let written =
        ["\"new\" overwrites \"a\" of \"first\"", "\"first\" overwrites \"old\", which \"new\" reads"];
    assert_eq!(said(assembly), written);
}

#[test]
fn a_size_follows_from_every_property_of_another_resource() {
    let sizes = [
        ("chain.width * 4", 128),
        ("chain.height * 4", 64),
        ("chain.layers * 4", 12),
        ("chain.mips * 4", 20),
        ("many.samples * 4", 16),
        ("words", 1024),
        ("words.size / 2", 512),
    ];
    let resources = sizes.iter().enumerate().map(|(at, (size, _))| {
        format!(r#", "b{at}": {{ "buffer": {{ "size": "={size}", "lifetime": "persistent" }} }}"#)
    });
    let clears = (0..sizes.len())
        .map(|at| format!(r#", "p{at}": {{ "clear": {{ "buffer": "&b{at}" }}, "side_effect": true }}"#));
    let text = format!(
        r#"{{ "format": 1, "name": "sizes", "resources": {{
             "many": {{ "texture": {{ "format": "rgba8unorm", "size": [8, 8], "samples": 4 }} }},
             "chain": {{ "texture": {{ "format": "rgba8unorm", "size": [32, 16], "mips": 5, "layers": 3 }} }},
             "words": {{ "buffer": {{ "size": 1024 }} }}, "target": {TARGET}{} }}, "passes": {{ {}{} }} }}"#,
        resources.collect::<String>(),
        fill("show", "target"),
        clears.collect::<String>()
    );
    let outcome = check(&text);
    let planned = |(at, (size, _)): (usize, &(&'static str, u64))| {
        (*size, outcome.plan().resources[&format!("b{at}")].bytes)
    };
    assert_eq!(sizes.iter().enumerate().map(planned).collect::<Vec<_>>(), sizes);
    let misspelt = check(&text.replace("words.size / 2", "words.sice / 2"));
    assert!(misspelt.text().contains("words.size"), "{}", misspelt.text());
}

#[test]
fn a_format_goes_with_that_of_the_texture_that_the_host_has() {
    let both = TEXTURE.replace("\"rgba8unorm\"", "[\"rgba8unorm\", \"bgra8unorm\"]");
    let text = format!(
        r#"{{ "format": 1, "name": "host", "resources": {{ "a": {both}, "target": {TARGET} }}, "passes": {{ {},
             "show": {{ "copy": {{ "from": {{ "name": "&a" }}, "to": {{ "name": "&target" }} }} }} }} }}"#,
        fill("fill", "a")
    );
    let outcome = check(&text);
    for format in [TextureFormat::Bgra8Unorm, TextureFormat::Rgba8Unorm] {
        let size = outcome.plan().resources["target"].size.expect("a texture");
        let mut options = PlanOptions::new(size.width, size.height);
        options.imports.insert("target".to_owned(), ImportDescriptor::new(format, size));
        let plan = outcome.checked.plan_again(&options, &outcome.sources).expect("a plan");
        assert_eq!(plan.resources["a"].format, Some(format));
    }
}

#[test]
fn data_on_the_cpu_shares_no_memory() {
    let outcome = check_file("pipelines/learn/29-temporal.json", &With::default());
    let reasons = why_apart(outcome.plan(), "eye", "target");
    assert_eq!(reasons[..2], ["eye is data on the CPU", "target is the host's own"]);
}

#[test]
fn unordered_writers_are_rejected_and_an_order_mends_it() {
    let unordered =
        check(&pipeline(&["a"], &[fill("p1", "a"), fill("p2", "a"), copy("show", "a", "target")]));
    assert_eq!(unordered.codes(), ["UG0402"]);
    let text = unordered.text();
    assert!(text.contains("\"p1\"") && text.contains("\"p2\""), "{text}");
    let ordered = check(&pipeline(
        &["a"],
        &[
            fill("p1", "a"),
            add("p2", "a", ""),
            add("p3", "a", "\"after\": [\"p2\"],"),
            copy("show", "a", "target"),
        ],
    ));
    assert_eq!(ordered.order(), ["p1", "p2", "p3", "show"]);
}

#[test]
fn writers_of_different_mips_need_no_order() {
    let text = r#"{ "format": 1, "name": "mips",
        "resources": {
            "chain": { "texture": { "format": "rgba8unorm", "size": [64, 64], "mips": "=mip_count(64)" } },
            "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
        "passes": {
            "m1": { "fullscreen": { "shader": "tonemap.wgsl.jinja", "axes": { "debug_view": "shadow_term" },
                    "bind": { "source": { "texture": { "name": "&chain", "mip": 0 } } }, "color": [{ "to": "&chain", "mip": 1 }] } },
            "m0": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&chain", "mip": 0 }] } },
            "m2": { "fullscreen": { "shader": "tonemap.wgsl.jinja", "axes": { "debug_view": "shadow_term" },
                    "bind": { "source": { "texture": { "name": "&chain", "mip": 1 } } }, "color": [{ "to": "&chain", "mip": 2 }] } },
            "show": { "fullscreen": { "shader": "tonemap.wgsl.jinja", "axes": { "debug_view": "shadow_term" },
                    "bind": { "source": { "texture": { "name": "&chain", "mip": 2 } } }, "color": [{ "to": "&target" }] } } } }"#;
    assert_eq!(check(text).order(), ["m0", "m1", "m2", "show"]);
}

#[test]
fn reading_what_the_same_pass_writes_is_rejected() {
    let outcome = check(&pipeline(
        &["a"],
        &[fill("p0", "a"), copy_with("p1", "a", "a", "\"after\": [\"p0\"],"), copy("show", "a", "target")],
    ));
    assert!(outcome.codes().contains(&"UG0404"), "{}", outcome.text());
}

#[test]
fn a_read_of_what_nothing_writes_is_rejected() {
    assert_eq!(check(&pipeline(&["a"], &[copy("show", "a", "target")])).codes(), ["UG0401"]);
    assert_eq!(
        check(&pipeline(&["a"], &[add("load", "a", ""), copy("show", "a", "target")])).codes(),
        ["UG0401"]
    );
}

#[test]
fn the_plan_is_the_same_from_run_to_run() {
    let text = pipeline(&["a", "b"], &[fill("p1", "a"), copy("p2", "a", "b"), copy("p3", "b", "target")]);
    let plan = |outcome: &crate::common::Outcome| serde_json::to_string(outcome.plan()).unwrap();
    assert_eq!(plan(&check(&text)), plan(&check(&text)));
}

#[test]
fn an_unread_output_of_a_live_pass_still_has_memory() {
    let passes = [
        "\"both\": { \"fullscreen\": { \"shader\": \"gradient.wgsl.jinja\", \"color\": [{ \"to\": \"&target\" }] } }".to_owned(),
        add("effect", "a", "\"side_effect\": true, \"after\": [\"clear\"],"),
        fill("clear", "a"),
    ];
    let outcome = check(&pipeline(&["a"], &passes));
    assert!(outcome.plan().resources.contains_key("a"));
    assert_eq!(outcome.plan().textures.len(), 1);
}

#[test]
fn an_output_that_is_overwritten_whole_before_the_end_is_culled() {
    let passes = [
        fill("first", "target"),
        copy_with("second", "a", "target", "\"after\": [\"first\"],"),
        fill("make", "a"),
    ];
    let outcome = check(&pipeline(&["a"], &passes));
    assert_eq!(outcome.order(), ["make", "second"]);
    assert_eq!(outcome.plan().culled["first"], CullReason::NothingReads(vec!["target".to_owned()]));
}

#[test]
fn a_version_that_is_overwritten_before_it_is_read_is_culled() {
    let passes = [
        fill("first", "a"),
        copy_with("second", "b", "a", "\"after\": [\"first\"],"),
        fill("make", "b"),
        copy("show", "a", "target"),
    ];
    let outcome = check(&pipeline(&["a", "b"], &passes));
    assert_eq!(outcome.order(), ["make", "second", "show"]);
    assert!(outcome.plan().culled.contains_key("first"));
}

#[test]
fn the_way_of_a_culled_pass_is_told_to_its_end() {
    let passes = [fill("show", "target"), fill("a1", "a"), copy("b1", "a", "b")];
    let outcome = check(&pipeline(&["a", "b"], &passes));
    assert_eq!(
        why_culled(outcome.plan(), "a1").collect::<Vec<_>>(),
        ["only culled passes read what a1 writes: b1", "nothing reads what b1 writes: b"]
    );
    assert!(outcome.plan().why_culled("show").next().is_none());
}

#[test]
fn every_graph_picture_names_every_pass_deterministically() {
    let text = pipeline(&["a", "b"], &[fill("p1", "a"), copy("p2", "a", "target"), copy("dead", "a", "b")]);
    let report = |outcome: &crate::common::Outcome| {
        let graph = outcome.checked.graph.as_ref().expect("a graph");
        umbragraph::low_level::report::Report::new(outcome.plan(), graph, &outcome.sources)
    };
    let (first, second) = (check(&text), check(&text));
    for format in umbragraph::low_level::report::GraphFormat::ALL {
        let draw = |outcome: &crate::common::Outcome| {
            umbragraph::low_level::report::draw(&report(outcome), format, None)
        };
        let drawn = draw(&first);
        assert_eq!(drawn, draw(&second), "{}", format.name());
        for name in ["p1", "p2", "dead"] {
            assert!(drawn.contains(name), "{} lacks {name}", format.name());
        }
    }
}

#[test]
fn names_cannot_break_out_of_pictures() {
    let text = pipeline(&["a"], &[fill("p1", "a"), copy("p2", "a", "target")])
        .replace("\"name\": \"test\"", r#""name": "</script><b>&\"""#);
    let outcome = check(&text);
    let graph = outcome.checked.graph.as_ref().expect("a graph");
    let report = umbragraph::low_level::report::Report::new(outcome.plan(), graph, &outcome.sources);
    for format in
        [umbragraph::low_level::report::GraphFormat::Svg, umbragraph::low_level::report::GraphFormat::Html]
    {
        let drawn = umbragraph::low_level::report::draw(&report, format, None);
        assert!(!drawn.contains("<b>"), "{}", format.name());
    }
    assert!(
        umbragraph::low_level::report::draw(&report, umbragraph::low_level::report::GraphFormat::Dot, None)
            .contains(r#"digraph "</script><b>&\"""#)
    );
}

#[test]
fn the_difference_of_two_plans_is_said_in_words() {
    let report = |text: &str| {
        let outcome = check(text);
        let graph = outcome.checked.graph.as_ref().expect("a graph");
        umbragraph::low_level::report::Report::new(outcome.plan(), graph, &outcome.sources)
    };
    let before = report(&pipeline(&["a"], &[fill("p1", "a"), copy("p2", "a", "target")]));
    let after =
        report(&pipeline(&["a", "b"], &[fill("p1", "a"), copy("more", "a", "b"), copy("p2", "b", "target")]));
    assert!(umbragraph::low_level::report::diff(&before, &before).is_empty());
    assert_eq!(
        umbragraph::low_level::report::diff(&before, &after),
        [
            "the pass more (fullscreen) is new",
            "the pass p2 reads b now",
            "the pass p2 reads a no longer",
            "the pass p2 has the binding source b as 2d, it was a as 2d",
            "the resource b is new: rgba8unorm 640×480",
            "2.3 MiB are created, 1.2 MiB more than before (1.2 MiB)",
            "2.3 MiB are used without aliasing, 1.2 MiB more than before (1.2 MiB)",
            "2.3 MiB are alive at most, 1.2 MiB more than before (1.2 MiB)",
        ]
    );
}

#[test]
fn an_order_through_absent_loops_or_subgraphs_holds() {
    let fill = |name: &str, keys: &str, to: &str| {
        format!(
            r#""{name}": {{ {keys} "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&{to}" }}] }} }}"#
        )
    };
    let part = |keys: &str| {
        format!(
            r#""subgraphs": {{ "part": {{
              "resources": {{ "spare": {{ "texture": {{ "format": "rgba8unorm", "size": [8, 8] }} }} }},
              "passes": {{ {} }} }} }},"#,
            fill("p", keys, "spare")
        )
    };
    let between = |keys: &str| format!(r#""between": {{ "after": ["first"], {keys} }}"#);
    let rounds = |count: &str| {
        fill("between", &format!(r#""after": ["first"], "for_each": {{ "i": {count} }},"#), "target")
    };
    let off = r#""when": "=1 > 2","#;
    let cases = [
        (String::new(), rounds("0"), "between"),
        (String::new(), rounds("[]"), "between"),
        (part(""), between(r#""use": "part", "when": "=1 > 2""#), "between"),
        (part(""), between(r#""use": "part", "when": "=1 > 2""#), "between.p"),
        (part(off), between(r#""use": "part""#), "between"),
        (part(off), between(r#""use": "part""#), "between.p"),
        (part(""), between(r#""use": "part", "for_each": { "i": 2 }, "when": "=i > 2""#), "between"),
    ];
    for (subgraphs, between, name) in cases {
        let first = fill("first", "", "target");
        let last = fill("last", &format!(r#""after": ["{name}"],"#), "target");
        for passes in [[&last, &between, &first], [&first, &between, &last]] {
            let text = format!(
                r#"{{ "format": 1, "name": "left_out", {subgraphs} "resources": {{ "target": {{ "texture": {{
                  "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }}, "passes": {{ {} }} }}"#,
                passes.map(String::as_str).join(", ")
            );
            // What comes first is drawn over.
            assert_eq!(check(&text).order(), ["last"], "{text}");
        }
    }
}
