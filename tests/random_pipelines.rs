//! Random pipelines with random small shaders, judged by `check` and by wgpu.
//!
//! A grammar draws textures, buffers and passes whose shaders bind and write them; most choices fit together, some do
//! not. What wgpu refuses `check` has to refuse. What `check` refuses and wgpu's backend without a driver takes is
//! counted by code, and each such code has a reason in `STRICTER`. Some of what passes is drawn where there is a device:
//! without an error of the device, and without a texel that is no number.

mod common;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use common::gpu::{empty_frame, executor};
use common::{Outcome, read};
use umbragraph::CheckOptions;
use umbragraph::compiler::{Plan, PlanOptions};
use umbragraph::diagnostic::{Diagnostics, Severity};
use umbragraph::executor::{DryRun, Frame, imported_texture, read_back};
use umbragraph::pipeline::{Overrides, Pipeline};
use umbragraph::shader::permutations::{self, Request};
use umbragraph::shader::{TargetProfile, TemplateSet};
use umbragraph::source::Sources;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

/// Codes of what `check` refuses and wgpu takes, with the reason.
const STRICTER: &[(&str, &str)] =
    &[("UG0401", "wgpu clears what nobody has written: it is valid, and hardly meant")];

/// What a shader sees of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Seen {
    Float,
    Unsigned,
    Depth,
}

/// Formats, how shaders see them, and whether they are storage textures.
const FORMATS: &[(&str, Seen, bool)] = &[
    ("rgba8unorm", Seen::Float, true),
    ("rgba8unorm", Seen::Float, true),
    ("rgba16float", Seen::Float, true),
    ("rgba8unorm-srgb", Seen::Float, false),
    ("r16float", Seen::Float, false),
    ("rgba32float", Seen::Float, true),
    ("r32float", Seen::Float, true),
    ("rgba8uint", Seen::Unsigned, true),
    ("r32uint", Seen::Unsigned, true),
    ("depth32float", Seen::Depth, false),
    ("depth24plus", Seen::Depth, false),
    ("rg11b10ufloat", Seen::Float, false),
];

#[derive(Clone, Debug)]
struct Texture {
    name: String,
    format: &'static str,
    seen: Seen,
    is_storage: bool,
    is_array: bool,
    samples: usize,
    size: &'static str,
    is_written: bool,
    /// Whether the pass at hand reads it.
    is_read: bool,
}

struct Drawn {
    document: String,
    templates: Vec<(String, String)>,
}

struct Grammar<'r> {
    random: &'r mut Random,
    textures: Vec<Texture>,
    passes: Vec<String>,
    templates: Vec<(String, String)>,
}

fn pipeline(random: &mut Random) -> Drawn {
    let mut grammar = Grammar { random, textures: Vec::new(), passes: Vec::new(), templates: Vec::new() };
    let mut resources = vec![
        r#""target": { "texture": { "format": "rgba8unorm", "size": "viewport", "lifetime": "imported" } }"#
            .to_owned(),
        r#""words": { "buffer": { "size": 1024 } }"#.to_owned(),
    ];
    for at in 0..2 + grammar.random.below(3) {
        resources.push(grammar.texture(at));
    }
    let words = r#""empty": { "clear": { "buffer": "words" }, "side_effect": true }"#;
    grammar.passes.push(words.to_owned());
    for at in 0..2 + grammar.random.below(4) {
        grammar.pass(at);
    }
    let document = format!(
        "{{ \"format\": 1, \"name\": \"random\",\n\"resources\": {{\n{} }},\n\"passes\": {{\n{} }} }}",
        resources.join(",\n"),
        grammar.passes.join(",\n")
    );
    Drawn { document, templates: grammar.templates }
}

impl Grammar<'_> {
    fn texture(&mut self, at: usize) -> String {
        let (format, seen, is_storage) = self.random.one_of(FORMATS);
        let size = self.random.one_of(&["[64, 64]", "[64, 64]", "[32, 64]", "\"viewport\""]);
        let samples = if self.random.one_in(6) { 4 } else { 1 };
        let is_array = samples == 1 && self.random.one_in(5);
        let mut more = String::new();
        if samples > 1 {
            let _ = write!(more, ", \"samples\": {samples}");
        }
        if is_array {
            more += ", \"layers\": 2";
        } else if self.random.one_in(6) {
            more += ", \"mips\": 2";
        }
        if self.random.one_in(2) {
            let lifetime = if samples == 1 && !["depth24plus", "rg11b10ufloat"].contains(&format) {
                "imported"
            } else {
                "persistent"
            };
            let _ = write!(more, ", \"lifetime\": \"{lifetime}\"");
        }
        let name = format!("t{at}");
        let text =
            format!("\"{name}\": {{ \"texture\": {{ \"format\": \"{format}\", \"size\": {size}{more} }} }}");
        self.textures.push(Texture {
            name,
            format,
            seen,
            is_storage,
            is_array,
            samples,
            size,
            is_written: false,
            is_read: false,
        });
        text
    }

    /// A texture of those for which something holds, or any now and then.
    fn any(&mut self, is_meant: impl Fn(&Texture) -> bool) -> Option<usize> {
        let is_wild = self.random.one_in(14);
        let fitting: Vec<usize> =
            (0..self.textures.len()).filter(|at| is_wild || is_meant(&self.textures[*at])).collect();
        (!fitting.is_empty()).then(|| self.random.one_of(&fitting))
    }

    fn pass(&mut self, at: usize) {
        self.textures.iter_mut().for_each(|texture| texture.is_read = false);
        let body = match self.random.below(6) {
            0 => self.compute(at),
            1 => self.copy(),
            _ => self.fullscreen(at),
        };
        let Some(body) = body else { return };
        let after = match self.passes.len() {
            1 => "empty".to_owned(),
            _ => {
                let last = self.passes.last().and_then(|pass| pass.split('"').nth(1));
                last.unwrap_or_default().to_owned()
            }
        };
        self.passes.push(format!("\"p{at}\": {{ {body}, \"after\": [\"{after}\"], \"side_effect\": true }}"));
    }

    /// The bindings of a shader: their declarations, an expression that reads each, and the JSON that binds them.
    fn inputs(&mut self, shader: &mut String, has_derivatives: bool) -> (String, Vec<String>) {
        let (mut sum, mut bind) = ("vec4<f32>(0.25)".to_owned(), Vec::new());
        for at in 0..self.random.below(3) {
            let (first, second) = (4 * at, 4 * at + 1);
            if has_derivatives && self.random.one_in(4) {
                let _ =
                    writeln!(shader, "@group(0) @binding({first}) var<storage, read> words{at}: array<u32>;");
                let _ = write!(sum, " + vec4<f32>(f32(words{at}[{}]))", self.random.below(4));
                bind.push(format!("\"words{at}\": \"words\""));
                continue;
            }
            let Some(index) = self.any(|texture| texture.is_written) else { continue };
            self.textures[index].is_read = true;
            let texture = self.textures[index].clone();
            let seen = if self.random.one_in(12) {
                self.random.one_of(&[Seen::Float, Seen::Unsigned, Seen::Depth])
            } else {
                texture.seen
            };
            let (ty, zero) = match (seen, texture.samples > 1, texture.is_array) {
                (Seen::Float, true, _) => ("texture_multisampled_2d<f32>", "vec2<i32>(0), 0"),
                (Seen::Unsigned, true, _) => ("texture_multisampled_2d<u32>", "vec2<i32>(0), 0"),
                (Seen::Depth, true, _) => ("texture_depth_multisampled_2d", "vec2<i32>(0), 0"),
                (Seen::Float, _, true) => ("texture_2d_array<f32>", "vec2<i32>(0), 1, 0"),
                (Seen::Unsigned, _, true) => ("texture_2d_array<u32>", "vec2<i32>(0), 0, 0"),
                (Seen::Depth, _, true) => ("texture_depth_2d_array", "vec2<i32>(0), 0, 0"),
                (Seen::Float, ..) => ("texture_2d<f32>", "vec2<i32>(0), 0"),
                (Seen::Unsigned, ..) => ("texture_2d<u32>", "vec2<i32>(0), 0"),
                (Seen::Depth, ..) => ("texture_depth_2d", "vec2<i32>(0), 0"),
            };
            let _ = writeln!(shader, "@group(0) @binding({first}) var image{at}: {ty};");
            bind.push(format!("\"image{at}\": \"{}\"", texture.name));
            let is_plain = ty == "texture_2d<f32>";
            if is_plain && self.random.one_in(2) {
                let filter = self.random.one_of(&["linear", "linear", "nearest"]);
                let _ = writeln!(shader, "@group(0) @binding({second}) var reader{at}: sampler;");
                bind.push(format!("\"reader{at}\": {{ \"sampler\": {{ \"filter\": \"{filter}\" }} }}"));
                let read = if has_derivatives && self.random.one_in(2) {
                    format!("textureSample(image{at}, reader{at}, uv)")
                } else {
                    format!("textureSampleLevel(image{at}, reader{at}, uv, 0.0)")
                };
                let _ = write!(sum, " + {read}");
            } else {
                let _ = match seen {
                    Seen::Depth => write!(sum, " + vec4<f32>(textureLoad(image{at}, {zero}))"),
                    _ => write!(sum, " + vec4<f32>(textureLoad(image{at}, {zero}))"),
                };
            }
        }
        (sum, bind)
    }

    fn fullscreen(&mut self, at: usize) -> Option<String> {
        let mut shader = "{% include \"lib/fullscreen.wgsl.jinja\" %}\n".to_owned();
        let (sum, bind) = self.inputs(&mut shader, true);
        let mut color = Vec::new();
        let (mut members, mut values) = (String::new(), Vec::new());
        let mut first: Option<Texture> = None;
        for location in 0..1 + usize::from(self.random.one_in(3)) {
            let beside = first.clone();
            let index = self.any(|texture| {
                texture.seen != Seen::Depth
                    && !texture.is_read
                    && texture.format != "rg11b10ufloat"
                    && beside.as_ref().is_none_or(|other| {
                        other.name != texture.name
                            && (other.size, other.samples) == (texture.size, texture.samples)
                    })
            })?;
            let texture = self.textures[index].clone();
            self.textures[index].is_written = true;
            let ty = match (texture.seen, self.random.one_in(16)) {
                (Seen::Unsigned, false) => "vec4<u32>",
                (_, false) => "vec4<f32>",
                _ => self.random.one_of(&["vec4<u32>", "f32", "vec2<f32>", "vec4<i32>"]),
            };
            let _ = write!(members, "@location({location}) c{location}: {ty}, ");
            values.push(match ty {
                "vec4<f32>" => "sum".to_owned(),
                "f32" => "sum.x".to_owned(),
                "vec2<f32>" => "sum.xy".to_owned(),
                ty => format!("{ty}(sum)"),
            });
            let blend = match self.random.below(6) {
                0 => ", \"blend\": \"add\"",
                _ => "",
            };
            let layer = if texture.is_array { ", \"layer\": 1" } else { "" };
            let clear = if self.random.one_in(3) { ", \"clear\": [0, 0, 0, 1]" } else { "" };
            color.push(format!("{{ \"to\": \"{}\"{blend}{layer}{clear} }}", texture.name));
            first.get_or_insert(texture);
        }
        let mut depth = String::new();
        if self.random.one_in(4) {
            let beside = first.clone();
            let index = self.any(|texture| {
                texture.seen == Seen::Depth
                    && !texture.is_read
                    && beside
                        .as_ref()
                        .is_none_or(|other| (other.size, other.samples) == (texture.size, texture.samples))
            });
            if let Some(index) = index {
                self.textures[index].is_written = true;
                let texture = &self.textures[index];
                let layer = if texture.is_array { ", \"layer\": 1" } else { "" };
                depth = format!(
                    ", \"depth\": {{ \"to\": \"{}\"{layer}, \"clear\": 1, \"compare\": \"always\", \"write\": true }}",
                    texture.name
                );
                if self.random.one_in(2) {
                    members += "@builtin(frag_depth) depth: f32, ";
                    values.push("0.5".to_owned());
                }
            }
        }
        let branch = match self.random.below(12) {
            0 => "if uv.x > 0.5 { sum += vec4<f32>(dpdx(uv.y)); }",
            1 => "if uv.x > 0.5 { sum *= 0.5; }",
            _ => "",
        };
        let _ = write!(
            shader,
            "struct Out {{ {members} }}\n@fragment fn paint(covered: Covered) -> Out {{\n    let uv = covered.uv;\n    var sum = {sum};\n    {branch}\n    return Out({});\n}}\n",
            values.join(", ")
        );
        let name = format!("own{at}.wgsl.jinja");
        self.templates.push((name.clone(), shader));
        Some(format!(
            "\"fullscreen\": {{ \"shader\": \"{name}\", \"bind\": {{ {} }}, \"color\": [{}]{depth} }}",
            bind.join(", "),
            color.join(", ")
        ))
    }

    fn compute(&mut self, at: usize) -> Option<String> {
        let mut shader = String::new();
        let (sum, mut bind) = self.inputs(&mut shader, false);
        let over = if let Some(index) =
            self.any(|one| one.is_storage && !one.is_read && one.samples == 1 && !one.is_array)
        {
            let texture = self.textures[index].clone();
            self.textures[index].is_written = true;
            let format = if self.random.one_in(14) { "rgba8unorm" } else { texture.format };
            let access = self.random.one_of(&["write", "write", "write", "read_write"]);
            let value = if texture.seen == Seen::Unsigned { "vec4<u32>(sum)" } else { "sum" };
            let _ =
                writeln!(shader, "@group(1) @binding(0) var result: texture_storage_2d<{format}, {access}>;");
            bind.push(format!("\"result\": \"{}\"", texture.name));
            format!("textureStore(result, id.xy, {value});")
        } else {
            shader += "@group(1) @binding(0) var<storage, read_write> result: array<u32>;\n";
            bind.push("\"result\": \"words\"".to_owned());
            "result[id.x] = u32(sum.x);".to_owned()
        };
        let side = self.random.one_of(&[8, 8, 8, 4, 16, 32]);
        let _ = write!(
            shader,
            "@compute @workgroup_size({side}, {side}) fn fill(@builtin(global_invocation_id) id: vec3<u32>) {{\n    let uv = vec2<f32>(id.xy) / 64.0;\n    var sum = {sum};\n    {over}\n}}\n"
        );
        let name = format!("own{at}.wgsl.jinja");
        self.templates.push((name.clone(), shader));
        Some(format!(
            "\"compute\": {{ \"shader\": \"{name}\", \"bind\": {{ {} }}, \"workgroups\": [8, 8, 1] }}",
            bind.join(", ")
        ))
    }

    fn copy(&mut self) -> Option<String> {
        let from = self.any(|texture| texture.is_written)?;
        let of = self.textures[from].clone();
        let to = self.any(|texture| {
            texture.name != of.name
                && (texture.format, texture.size, texture.samples, texture.is_array)
                    == (of.format, of.size, of.samples, of.is_array)
        })?;
        self.textures[to].is_written = true;
        let into = &self.textures[to].name;
        Some(format!(
            "\"copy\": {{ \"from\": {{ \"name\": \"{}\" }}, \"to\": {{ \"name\": \"{into}\" }} }}",
            of.name
        ))
    }
}

/// What `check` says: of the plan, and of each shader for the profile.
fn check(drawn: &Drawn) -> Outcome {
    let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
    let mut templates = TemplateSet::new();
    let covering = "lib/fullscreen.wgsl.jinja";
    let text = read(&format!("shaders-templates/{covering}"));
    let all = drawn.templates.iter().map(|(name, text)| (name.as_str(), text.as_str()));
    for (name, text) in all.chain([(covering, text.as_str())]) {
        templates.add(&mut sources, name, text, &mut diagnostics);
    }
    templates.check(&mut diagnostics);
    let templates = Arc::new(templates);
    let file = sources.add("random.json", drawn.document.as_str());
    let profile = TargetProfile::webgpu();
    let options = CheckOptions {
        registry: &umbragraph::registry(),
        templates: &templates,
        profile: &profile,
        overrides: &Overrides::default(),
        plan: &PlanOptions::new(64, 64),
    };
    let checked = umbragraph::check(file, &options, &sources, &mut diagnostics);
    let programs = checked.pipeline.iter().flat_map(|pipeline| &pipeline.programs);
    let variants = programs.flat_map(|program| program.variants.iter().map(move |one| (program, one)));
    let requests: Vec<Request> = variants
        .map(|(program, variant)| {
            let profiles = std::slice::from_ref(&profile);
            Request::one(&templates, &program.template, &variant.module.axes, profiles)
        })
        .collect();
    let options = permutations::Options { threads: 1, ..permutations::Options::default() };
    diagnostics.extend(permutations::check(&templates, &requests, &options).diagnostics);
    Outcome { sources, diagnostics, checked }
}

fn describe(drawn: &Drawn) -> String {
    let shaders: Vec<String> =
        drawn.templates.iter().map(|(name, text)| format!("--- {name}\n{text}")).collect();
    format!("{}\n{}", drawn.document, shaders.join(""))
}

/// Pipelines in ordinary tests; forty times as many make 20,000.
const PIPELINES: u32 = 500;

#[test]
fn what_wgpu_refuses_of_random_pipelines_check_refuses() {
    let mut dry_run = pollster::block_on(DryRun::new(&TargetProfile::webgpu())).expect("a device");
    let mut random = Random(property::seed());
    let (mut passed, mut refused, mut wrong) = (0, 0, Vec::new());
    let mut said_of: BTreeMap<&'static str, usize> = BTreeMap::new();
    let mut stricter: BTreeMap<&'static str, (usize, String)> = BTreeMap::new();
    for _ in 0..PIPELINES * property::times() {
        let drawn = pipeline(&mut random);
        let outcome = check(&drawn);
        let is_sound = !outcome.diagnostics.has_errors();
        let errors = outcome.diagnostics.iter().filter(|one| one.severity == Severity::Error);
        let codes: Vec<&'static str> = errors.map(|one| one.code.id).collect();
        passed += usize::from(is_sound);
        refused += usize::from(!is_sound);
        codes.iter().for_each(|code| *said_of.entry(code).or_default() += 1);
        let text = outcome.text();
        let is_whole = |pipeline: &Arc<Pipeline>| pipeline.gaps.is_empty() && pipeline.refused.is_empty();
        let pipeline = outcome.checked.pipeline.filter(is_whole);
        let Some(plan) = outcome.checked.plan.filter(|_| pipeline.is_some()) else { continue };
        let said = pollster::block_on(dry_run.run(&Arc::new(plan)));
        match (is_sound, said.has_errors()) {
            (true, true) => wrong.push(format!("{:?}\n{}", said, describe(&drawn))),
            (false, false) => {
                for code in codes {
                    let (count, _) = stricter.entry(code).or_insert((0, text.clone()));
                    *count += 1;
                }
            }
            _ => {}
        }
    }
    println!("{passed} pass, {refused} are refused: {said_of:?}");
    for (code, (count, _)) in &stricter {
        println!("{code}: refused {count} times where wgpu takes the plan");
    }
    assert!(passed > 50 && refused > 20, "{passed} pass, {refused} are refused");
    wrong.sort_by_key(String::len);
    assert!(wrong.is_empty(), "{} of {passed}, the shortest:\n{}", wrong.len(), wrong[0]);
    let unargued = stricter.iter().filter(|(code, _)| STRICTER.iter().all(|(known, _)| known != *code));
    let unargued: Vec<String> =
        unargued.map(|(code, (count, text))| format!("{code} ({count})\n{text}")).collect();
    assert!(unargued.is_empty(), "{}", unargued.join("\n"));
}

/// A texture for each of the host's own.
fn imports(gpu: &Gpu, plan: &Plan) -> Vec<(String, wgpu::Texture)> {
    let more = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = |name| imported_texture(&gpu.device, plan, name, more);
    plan.resources.keys().filter_map(|name| Some((name.clone(), texture(name)?))).collect()
}

#[test]
fn random_pipelines_are_drawn_without_an_error_and_every_texel_is_a_number() {
    let Some(gpu) = gpu::device() else { return };
    let mut random = Random(property::seed() ^ 0x5eed);
    let (mut drawn, mut read) = (0, 0);
    while drawn < 40 * property::times().min(5) {
        let case = pipeline(&mut random);
        let outcome = check(&case);
        if outcome.diagnostics.has_errors() {
            continue;
        }
        drawn += 1;
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let plan = outcome.checked.plan.as_ref().expect("a plan");
        let mut executor = executor(&gpu, plan, None);
        let textures = imports(&gpu, plan);
        let imports: Vec<_> = textures.iter().map(|(name, texture)| (name.as_str(), texture)).collect();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor
            .record(&mut encoder, &Frame::new(&empty_frame()).imports(&imports))
            .unwrap_or_else(|said| panic!("{said:?}\n{}", describe(&case)));
        gpu.queue.submit([encoder.finish()]);
        let error = pollster::block_on(scope.pop());
        assert!(error.is_none(), "{error:?}\n{}", describe(&case));
        for (name, texture) in &textures {
            let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, texture)).expect("numbers");
            let is_number = texels.values.iter().flatten().all(|one| !one.is_nan());
            assert!(is_number, "{name}\n{}", describe(&case));
            read += texels.values.len();
        }
    }
    println!("{drawn} pipelines drawn, {read} texels read");
    assert!(read > 0);
}
