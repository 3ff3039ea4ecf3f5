//! Proving permutations, against doing it without this crate, in one run.
//!
//! Each line `ratio NAME VALUE` is ours divided by the rival's, or by the bound where there is no rival; the goal of
//! each stands beside it. Rivals: naga called directly on the same distinct texts, to parse and validate them and to
//! resolve their overrides, and the same without resolving; one thread; one `naga` process per combination (the
//! installed one, or this program standing in for it). Times are the minimum of several runs.
//!
//! `cargo bench -p umbragraph-graph --bench permutations -- count_ours` does once what `overhead` measures, so that a
//! tool can count the instructions; `count_naga` does naga's part, and `count_neither` what both need beforehand:
//! (ours - neither) / (naga - neither) is the same whatever else the machine does.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use naga::back::PipelineConstants;
use naga::back::pipeline_constants::process_overrides;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use umbragraph_graph::diagnostic::Diagnostics;
use umbragraph_graph::document;
use umbragraph_graph::pipeline::claimed_profiles;
use umbragraph_graph::shader::permutations::{Options, Permutations, Request, check};
use umbragraph_graph::shader::{Axes, AxisKind, TargetProfile, TemplateSet};
use umbragraph_graph::source::Sources;

/// The argument that makes this program stand in for the `naga` command.
const STAND_IN: &str = "--stand-in-for-naga";

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|argument| argument == STAND_IN) {
        validate_file(&arguments[at + 1]);
        return;
    }
    let synthetic =
        set(&[("synthetic.wgsl.jinja", &synthetic_template()), ("synthetic.axes.json", &synthetic_axes(0))]);
    let project = project();
    if let Some(what) = arguments.iter().find_map(|argument| argument.strip_prefix("count_")) {
        count(what, &synthetic);
        count(what, &project);
        return;
    }
    let parts: [(&str, &dyn Fn()); 6] = [
        ("threads", &|| threads(&synthetic)),
        ("wide_space", &wide_space),
        ("everything", &|| everything(&project)),
        ("processes", &|| processes(&synthetic)),
        // Before the rival of the last one keeps all texts in memory at once.
        ("memory", &memory),
        ("overhead", &|| overheads(&synthetic, &project)),
    ];
    // `cargo bench ... -- overhead threads` runs these parts only.
    println!("| what | ours | beside | ratio | goal |\n|---|---|---|---|---|");
    let is_named = |part: &str| arguments.iter().any(|argument| argument == part);
    let all = !parts.iter().any(|(part, _)| is_named(part));
    for (_, run) in parts.iter().filter(|(part, _)| all || is_named(part)) {
        run();
    }
}

fn overheads(synthetic: &TemplateSet, project: &TemplateSet) {
    let parts = [overhead("overhead_synthetic", synthetic), overhead("overhead_project", project)];
    let [ours, all, validating] = [0, 1, 2].map(|at| parts[0][at] + parts[1][at]);
    report("overhead", "at most 1.10", ours, all, "of naga alone, on both");
    report("overhead_and_overrides", "no goal", ours, validating, "of naga without resolving overrides");
}

fn set(files: &[(&str, &str)]) -> TemplateSet {
    let (mut sources, mut set, mut diagnostics) = (Sources::new(), TemplateSet::new(), Diagnostics::new());
    for (name, text) in files {
        set.add(&mut sources, name, text, &mut diagnostics);
    }
    set.check(&mut diagnostics);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    set
}

/// Returns the project's templates, except those with more than 16 axes, whose thousands of variants take minutes.
fn project() -> TemplateSet {
    const FILES: &[(&str, &str)] = umbragraph_shaders_templates::FILES;
    let all = set(FILES);
    let is_small = |(file, _): &&(&str, &str)| {
        let template = file.replace(".axes.json", ".wgsl.jinja");
        file.starts_with("lib/") || all.axes(&template).is_none_or(|axes| axes.iter().count() <= 16)
    };
    set(&FILES.iter().filter(is_small).copied().collect::<Vec<_>>())
}

fn roots(set: &TemplateSet) -> Vec<String> {
    set.names().filter(|name| !name.starts_with("lib/")).map(str::to_owned).collect()
}

/// Validates all variants of the templates with integer axes at their defaults: a tenth of the project's shader
/// sources.
fn prove_plain(set: &TemplateSet, profiles: &[TargetProfile]) -> Permutations {
    let requests: Vec<Request> = roots(set)
        .iter()
        .map(|name| {
            let axes = set.axes(name).into_iter().flat_map(Axes::iter);
            let numbers = axes.filter(|axis| matches!(axis.kind, AxisKind::Integer { .. }));
            let allowed = numbers.map(|axis| (axis.name.clone(), vec![axis.default.clone()])).collect();
            Request { allowed, ..Request::all(name, profiles) }
        })
        .collect();
    check(set, &requests, &Options { threads: 1, ..Options::default() })
}

/// Returns the target profiles that the bundled pipeline `forward` claims.
fn claimed() -> Vec<TargetProfile> {
    let mut sources = Sources::new();
    let file = sources.add("forward.json", include_str!("../pipelines/base/forward.json"));
    let document = document::parse(&sources, file).valid().expect("a pipeline of the tree");
    claimed_profiles(&document, &mut Diagnostics::new())
}

fn prove(set: &TemplateSet, profiles: &[TargetProfile], threads: usize) -> Permutations {
    let requests: Vec<Request> = roots(set).iter().map(|name| Request::all(name, profiles)).collect();
    check(set, &requests, &Options { threads, ..Options::default() })
}

/// Returns the minimum times of two functions. Runs alternate, so that a slow moment of the machine affects both.
fn min_time(runs: usize, mut ours: impl FnMut(), mut rival: impl FnMut()) -> (Duration, Duration) {
    let mut min = (Duration::MAX, Duration::MAX);
    for _ in 0..runs {
        let start = Instant::now();
        ours();
        min.0 = min.0.min(start.elapsed());
        let start = Instant::now();
        rival();
        min.1 = min.1.min(start.elapsed());
    }
    min
}

fn report(name: &str, goal: &str, ours: Duration, rival: Duration, of: &str) {
    let ratio = ours.as_secs_f64() / rival.as_secs_f64();
    println!("| {} | {ours:.2?} | {rival:.2?} {of} | {ratio:.3} | {goal} |", name.replace('_', " "));
    println!("ratio {name} {ratio:.4}");
}

/// The part of naga's work to measure.
#[derive(Clone, Copy, PartialEq)]
enum Naga {
    /// Parsing and validating.
    Validate,
    /// Parsing, validating and applying the defaults of overrides. A module with overrides is cloned, rewritten and
    /// validated again.
    Resolve,
}

/// Returns the distinct shader sources that this crate validates.
fn distinct_texts(set: &TemplateSet, profiles: &[TargetProfile]) -> BTreeSet<String> {
    let outcome = prove_plain(set, profiles);
    let texts = outcome.templates.iter();
    texts.flat_map(|report| report.variants.iter().filter_map(|variant| report.text(set, variant))).collect()
}

/// Runs only naga on shader sources, in a new thread: a new thread begins with a cold heap, as in this crate.
fn naga_alone(texts: &BTreeSet<String>, profile: &TargetProfile, what: Naga) {
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for text in texts {
                let module = naga::front::wgsl::parse_str(text).expect("the text is valid");
                let mut validator = Validator::new(ValidationFlags::all(), profile.capabilities);
                let info = validator.validate(&module).expect("the text is valid");
                if what == Naga::Resolve {
                    drop(process_overrides(&module, &info, None, &PipelineConstants::default()));
                }
            }
        });
    });
}

/// Measures the overhead of this crate over naga on the same distinct shader sources, with one profile and one thread.
/// Returns the times of this crate, of naga with override resolution, and of naga's parsing and validation.
fn overhead(name: &str, set: &TemplateSet) -> [Duration; 3] {
    let profiles = [TargetProfile::webgpu()];
    let texts = distinct_texts(set, &profiles);
    let bytes: usize = texts.iter().map(String::len).sum();
    println!("{name}: {} distinct texts, {bytes} bytes", texts.len());
    let naga = |what: Naga| naga_alone(&texts, &profiles[0], what);
    let runs = if texts.len() < 100 { 15 } else { 9 };
    let (ours, all) = min_time(runs, || drop(prove_plain(set, &profiles)), || naga(Naga::Resolve));
    let (validating, _) = min_time(runs, || naga(Naga::Validate), || {});
    report(name, "no goal of its own", ours, all, "of naga alone");
    [ours, all, validating]
}

/// Runs this crate or naga once, or neither, as the argument says.
fn count(what: &str, set: &TemplateSet) {
    let profiles = [TargetProfile::webgpu()];
    let texts = distinct_texts(set, &profiles);
    match what {
        "ours" => drop(prove_plain(set, &profiles)),
        "naga" => naga_alone(&texts, &profiles[0], Naga::Resolve),
        _ => {}
    }
}

fn threads(set: &TemplateSet) {
    let profiles = TargetProfile::all();
    let (two, one) = min_time(7, || drop(prove(set, &profiles, 2)), || drop(prove(set, &profiles, 1)));
    report("two_threads", "at most 0.625", two, one, "on one thread");
}

/// Measures a template with about 10^10 combinations and 9 distinct shader sources, against 100 ms.
fn wide_space() {
    let text = "{% for i in range(group) %}\nconst G{{ i }} = {{ i }};\n{% endfor %}\n{% if needs %}\n{% if sscs %}\n\
                const S = 1;\n{% endif %}\nconst N = 1;\n{% endif %}\n@compute @workgroup_size(1) fn main() {}\n";
    let set = set(&[("wide.wgsl.jinja", text), ("wide.axes.json", &synthetic_axes(30))]);
    let outcome = prove(&set, &[TargetProfile::webgpu()], 2);
    let found = &outcome.templates[0];
    println!("wide_space: {} combinations, {} distinct texts", found.configurations, found.variants.len());
    assert!(found.configurations.number >= 10_u128.pow(10) && found.variants.len() == 9);
    let (ours, _) = min_time(7, || drop(prove(&set, &[TargetProfile::webgpu()], 2)), || {});
    report("wide_space", "at most 1", ours, Duration::from_millis(100), "allowed");
}

fn everything(set: &TemplateSet) {
    let profiles = claimed();
    let outcome = prove(set, &profiles, 2);
    println!("everything: {} distinct texts, {} profiles", outcome.proven, profiles.len());
    for diagnostic in &outcome.diagnostics {
        println!("  {} {}", diagnostic.code, diagnostic.message);
    }
    let (ours, _) = min_time(2, || drop(prove(set, &profiles, 2)), || {});
    report("everything", "at most 1", ours, Duration::from_secs(10), "allowed");
}

/// Compares one process of the `naga` command per combination, two at a time, with this crate for all combinations.
fn processes(set: &TemplateSet) {
    const COMBINATIONS: usize = 384;
    let profiles = [TargetProfile::webgpu()];
    let outcome = prove(set, &profiles, 2);
    let found = &outcome.templates[0];
    let folder = std::env::temp_dir().join(format!("umbragraph-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let files: Vec<PathBuf> = found
        .variants
        .iter()
        .enumerate()
        .map(|(at, variant)| {
            let path = folder.join(format!("{at}.wgsl"));
            std::fs::write(&path, found.text(set, variant).expect("a text")).expect("a file");
            path
        })
        .collect();
    let this = std::env::current_exe().expect("this program");
    let installed = Command::new("naga").arg("--version").stdout(Stdio::null()).status().is_ok();
    let start = |path: &PathBuf| {
        let mut command = if installed { Command::new("naga") } else { Command::new(&this) };
        if !installed {
            command.arg(STAND_IN);
        }
        command.arg(path).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("a process")
    };
    let begin = Instant::now();
    let order: Vec<&PathBuf> = files.iter().cycle().take(COMBINATIONS).collect();
    for pair in order.chunks(2) {
        let children: Vec<_> = pair.iter().map(|path| start(path)).collect();
        for mut child in children {
            assert!(child.wait().expect("a status").success());
        }
    }
    let rival = begin.elapsed();
    let _ = std::fs::remove_dir_all(&folder);
    let (ours, _) = min_time(7, || drop(prove(set, &profiles, 2)), || {});
    let name = if installed { "of naga processes" } else { "of processes that stand in for naga" };
    assert_eq!(found.configurations.number, COMBINATIONS as u128);
    report("processes", "at most 0.02", ours, rival, name);
}

fn memory() {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse::<f64>().ok());
    if let Some(kib) = peak {
        let mebibytes = kib / 1024.0;
        println!(
            "| peak memory | {mebibytes:.1} MiB | 200 MiB allowed | {:.3} | at most 1 |",
            mebibytes / 200.0
        );
        println!("ratio peak_memory {:.4}", kib / 1024.0 / 200.0);
    }
}

fn validate_file(path: &str) {
    let text = std::fs::read_to_string(path).expect("a file");
    let module = naga::front::wgsl::parse_str(&text).expect("the text is valid");
    let info = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module);
    drop(info.expect("the text is valid"));
}

/// Returns axes with 384 combinations. The template reads three of them, and none of `free` more boolean axes.
fn synthetic_axes(free: usize) -> String {
    let mut axes = String::from(
        "{ \"axes\": { \"group\": { \"type\": \"integer\", \"min\": 1, \"max\": 3, \"default\": 1 }",
    );
    let named = ["needs", "sscs", "msaa", "skinning", "transmission", "overlay", "fog"].map(str::to_owned);
    for name in named.into_iter().chain((0..free).map(|at| format!("free{at}"))) {
        write!(axes, ", \"{name}\": {{ \"type\": \"bool\", \"default\": false }}").expect("a string grows");
    }
    axes.push_str(" } }");
    axes
}

/// Returns about 50 KB of WGSL: filters, projections and lights, two thirds of it inside conditional blocks.
fn synthetic_template() -> String {
    let mut text = String::from(
        "struct Light { matrix: mat4x4<f32>, color: vec4<f32>, range: f32, bias: f32, kind: u32, layer: i32 }\n\
         struct Frame { view: mat4x4<f32>, eye: vec3<f32>, count: u32, lights: array<Light, 16> }\n\
         @group({{ group }}) @binding(0) var<uniform> frame: Frame;\n\
         @group({{ group }}) @binding(1) var maps: texture_depth_2d_array;\n\
         @group({{ group }}) @binding(2) var map_sampler: sampler_comparison;\n",
    );
    let function = |at: usize| {
        format!(
            "fn filter_{at}(light: Light, position: vec3<f32>, normal: vec3<f32>) -> f32 {{\n\
             \x20   let world = vec4<f32>(position + normal * light.bias, 1.0);\n\
             \x20   let clip = light.matrix * world;\n\
             \x20   let ndc = clip.xyz / max(clip.w, 1e-6);\n\
             \x20   let uv = ndc.xy * vec2<f32>(0.5, -0.5) + vec2<f32>(0.5);\n\
             \x20   var sum = 0.0;\n\
             \x20   for (var y = -1; y <= 1; y++) {{\n\
             \x20       for (var x = -1; x <= 1; x++) {{\n\
             \x20           let offset = vec2<f32>(f32(x), f32(y)) * {at}.5 / 2048.0;\n\
             \x20           sum += textureSampleCompareLevel(maps, map_sampler, uv + offset, light.layer, ndc.z);\n\
             \x20       }}\n\
             \x20   }}\n\
             \x20   let fade = clamp(1.0 - length(position - frame.eye) / light.range, 0.0, 1.0);\n\
             \x20   return mix(1.0, sum / 9.0, fade * fade * (3.0 - 2.0 * fade));\n\
             }}\n"
        )
    };
    let calls = |from: usize, to: usize| -> String {
        (from..to)
            .map(|at| format!("    visible *= filter_{at}(frame.lights[{}], position, normal);\n", at % 16))
            .collect()
    };
    for at in 0..20 {
        text.push_str(&function(at));
    }
    text.push_str("{% if needs %}\n");
    for at in 20..40 {
        text.push_str(&function(at));
    }
    text.push_str("{% if sscs %}\n");
    for at in 40..60 {
        text.push_str(&function(at));
    }
    text.push_str("{% endif %}\n{% endif %}\n");
    text.push_str("@fragment fn main(@location(0) position: vec3<f32>, @location(1) normal: vec3<f32>) -> @location(0) vec4<f32> {\n    var visible = 1.0;\n");
    text.push_str(&calls(0, 20));
    text.push_str(&format!(
        "{{% if needs %}}\n{}{{% if sscs %}}\n{}{{% endif %}}\n{{% endif %}}\n",
        calls(20, 40),
        calls(40, 60)
    ));
    text.push_str("    return vec4<f32>(visible);\n}\n");
    text
}
