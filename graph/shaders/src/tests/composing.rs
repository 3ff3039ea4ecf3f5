//! The verdict of the cover against that of every text, one by one.

use std::collections::{BTreeMap, BTreeSet};

use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use super::Fixture;
use crate::permutations::{Options, Permutations, Request, check};
use crate::{AxisKind, TargetProfile};

/// Validity, reflection and costs of each module, keyed by its hash.
type Verdicts = BTreeMap<String, (bool, String)>;

fn verdicts(outcome: &Permutations) -> Verdicts {
    let variants = outcome.templates.iter().flat_map(|report| &report.variants);
    let of = |variant: &crate::permutations::VariantReport| {
        let reflection = variant.reflection.as_ref().map(|each| format!("{each:?}"));
        (variant.valid, format!("{}{:?}", reflection.unwrap_or_default(), variant.costs))
    };
    variants.map(|variant| (variant.hash.clone(), of(variant))).collect()
}

/// The code, place, message and profiles of every diagnostic.
fn causes(fixture: &Fixture, outcome: &Permutations) -> BTreeSet<String> {
    let line = |diagnostic: &umbragraph_text::diagnostic::Diagnostic| {
        let profiles: BTreeSet<&String> = diagnostic.extent.iter().flat_map(|one| &one.profiles).collect();
        // How much of something is too much differs between texts; the first one found is named.
        let message: String = diagnostic.message.chars().filter(|each| !each.is_ascii_digit()).collect();
        format!("{} {} {message} {profiles:?}", diagnostic.code, fixture.place(&diagnostic.place))
    };
    outcome.diagnostics.iter().map(line).collect()
}

/// Compares validation by units with validation of every module. Returns the numbers of modules and of those passed to
/// naga.
fn compare(fixture: &Fixture, request: &Request) -> (usize, usize) {
    let requests = std::slice::from_ref(request);
    let few = check(&fixture.set, requests, &Options { threads: 1, ..Options::default() });
    let every =
        check(&fixture.set, requests, &Options { threads: 1, exhaustive: true, ..Options::default() });
    let shown = || {
        let texts =
            few.templates.iter().flat_map(|report| report.variants.iter().map(move |one| (report, one)));
        let differs = |(_, variant): &(_, &crate::permutations::VariantReport)| {
            verdicts(&few).get(&variant.hash) != verdicts(&every).get(&variant.hash)
        };
        let (report, variant) = texts.clone().find(differs)?;
        let text = report.text(&fixture.set, variant).unwrap_or_default();
        Some(format!("{:?} {}\n{text}", variant.axes.values(), variant.valid))
    };
    assert!(
        verdicts(&few) == verdicts(&every),
        "{}\n{}\nfew: {:#?}\nevery: {:#?}",
        request.template,
        shown().unwrap_or_default(),
        causes(fixture, &few),
        causes(fixture, &every)
    );
    // A text says its first error only; what is behind it may be found in the cover.
    let (few_causes, every_causes) = (causes(fixture, &few), causes(fixture, &every));
    assert!(
        every_causes.is_empty() == few_causes.is_empty(),
        "{}: few: {few_causes:#?} every: {every_causes:#?}",
        request.template
    );
    if every.templates.iter().all(|report| report.variants.iter().all(|variant| variant.valid)) {
        assert_eq!(few_causes, every_causes, "{}", request.template);
    }
    assert_eq!((few.texts, every.proven), (every.texts, every.texts));
    (few.texts, few.proven)
}

/// A request for every variant of a template, with integers fixed to their defaults to limit the number of modules.
fn request(fixture: &Fixture, root: &str, profiles: &[TargetProfile]) -> Request {
    let axes = fixture.set.axes(root).into_iter().flat_map(crate::Axes::iter);
    let integers = axes.filter(|axis| matches!(axis.kind, AxisKind::Integer { .. }));
    let allowed = integers.map(|axis| (axis.name.clone(), vec![axis.default.clone()])).collect();
    Request { allowed, ..Request::all(root, profiles) }
}

#[test]
fn the_cover_of_our_templates_says_what_every_text_says() {
    let fixture = Fixture::sound(umbragraph_shaders_templates::FILES);
    let profiles: Vec<TargetProfile> = ["webgpu", "vulkan", "metal", "dx12"]
        .iter()
        .filter_map(|name| TargetProfile::from_name(name))
        .collect();
    // All with 2,000 texts: `cargo xtask soak`.
    let max = if property::times() > 1 { 2_000 } else { 300 };
    let (mut texts, mut proven, mut compared) = (0, 0, 0);
    for root in fixture.set.names().filter(|name| !name.starts_with("lib/")) {
        let request = request(&fixture, root, &profiles);
        let plain = Request { profiles: Vec::new(), ..request.clone() };
        let paths = crate::permutations::paths(&fixture.set, &plain, max);
        if paths.is_some_and(|paths| paths <= max) {
            let (all, few) = compare(&fixture, &request);
            println!("{root}: {all} texts, {few} of them proven");
            (texts, proven, compared) = (texts + all, proven + few, compared + 1);
        }
    }
    println!("{compared} templates with {texts} texts, {proven} of them proven");
    assert!(compared > 4 && proven < texts, "{compared} {texts} {proven}");
}

const AXES: &str = r#"{ "axes": {
    "a": { "type": "bool", "default": false },
    "b": { "type": "bool", "default": false },
    "c": { "type": "bool", "default": false },
    "d": { "type": "enum", "values": ["x", "y", "z"], "default": "x" },
    "n": { "type": "integer", "min": 1, "max": 3, "default": 1 },
    "o": { "type": "integer", "min": 0, "max": 3, "default": 1, "as": "override" } } }"#;

/// Templates with faults that need two or three axis values, each with a minimal set of values that causes the fault.
const FAULTS: &[(&str, &str, &[&str])] = &[
    // A parameter of a callee that another axis changes.
    (
        "fn callee(x: {% if a %}u32{% else %}f32{% endif %}) -> f32 { return f32(x); }
         fn caller() -> f32 { return {% if b %}callee(1.0){% else %}callee({{ '1u' if a else '1.0' }}){% endif %}; }
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(caller()); }",
        "",
        &["a=true", "b=true"],
    ),
    // A number of a binding that two features take.
    (
        "{% if a %}@group(0) @binding(1) var<uniform> one: vec4<f32>;{% endif %}
         {% if b %}@group(0) @binding(1) var<uniform> two: vec4<f32>;{% endif %}
         fn first() -> f32 { return {% if a %}one.x{% else %}0.0{% endif %}; }
         fn second() -> f32 { return {% if b %}two.x{% else %}0.0{% endif %}; }
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(first() + second()); }",
        "",
        &["a=true", "b=true"],
    ),
    // A member that one axis removes and another reads.
    (
        "struct Light { color: vec3<f32>, {% if not a %}reach: f32,{% endif %} }
         fn lit(light: Light) -> f32 { return light.color.x{% if b %} * light.reach{% endif %}; }
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(lit(Light())); }",
        "",
        &["a=true", "b=true"],
    ),
    // A derivative behind a condition that another axis makes differ between invocations, two calls away.
    (
        "@group(0) @binding(0) var<uniform> block: vec4<f32>;
         fn chosen(at: vec2<f32>) -> bool { return {% if a %}at.x{% else %}block.x{% endif %} > 0.0; }
         fn sharp(x: f32) -> f32 { return {% if b %}fwidth(x){% else %}x{% endif %}; }
         fn outer(x: f32) -> f32 { return sharp(x) * 2.0; }
         @fragment fn main(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
           if chosen(at.xy) { return vec4<f32>(outer(at.y)); } return vec4<f32>(0.0); }",
        "",
        &["a=true", "b=true"],
    ),
    // A barrier the same way.
    (
        "var<workgroup> shared_value: f32;
         fn wait() { {% if a %}workgroupBarrier();{% endif %} }
         fn step(x: u32) { {% if b %}if x > 2u { wait(); }{% else %}wait();{% endif %} }
         @compute @workgroup_size(8) fn main(@builtin(local_invocation_index) at: u32) { shared_value = 1.0; step(at); }",
        "",
        &["a=true", "b=true"],
    ),
    // A limit that only the sum of three features exceeds: 16 sampled textures of one stage.
    (
        "{% for on, name in [[a, 'a'], [b, 'b'], [c, 'c']] %}
         {% for at in range(6) %}@group({{ loop.index0 // 8 }}) @binding({{ at + (0 if name == 'a' else 10 if name == 'b' else 20) }}) var {{ name }}{{ at }}: texture_2d<f32>;
         {% endfor %}fn of_{{ name }}() -> f32 { return 0.0{% if on %}{% for at in range(6) %} + textureLoad({{ name }}{{ at }}, vec2<i32>(0), 0).x{% endfor %}{% endif %}; }
         {% endfor %}
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(of_a() + of_b() + of_c()); }",
        "UG0530",
        &["a=true", "b=true", "c=true"],
    ),
    // A constant that sizes an array, and an index that another axis writes.
    (
        "const COUNT = {{ 2 if a else 4 }};
         fn table() -> array<f32, COUNT> { return array<f32, COUNT>(); }
         fn pick() -> f32 { var own = table(); return own[{{ 3 if b else 1 }}]; }
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(pick()); }",
        "",
        &["a=true", "b=true"],
    ),
    // A pointer that aliases a variable which a callee writes by name.
    (
        "var<private> own: f32;
         fn inner() { {% if a %}own = 1.0;{% endif %} }
         fn add(to: ptr<private, f32>) -> f32 { inner(); *to += 1.0; return *to; }
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>({% if b %}add(&own){% else %}own{% endif %}); }",
        "",
        &["a=true", "b=true"],
    ),
    // A built-in of fragment stages, called from a stage that another axis chooses.
    (
        "fn slope(x: f32) -> f32 { return {% if a %}dpdx(x){% else %}x{% endif %}; }
         fn middle(x: f32) -> f32 { return slope(x); }
         @vertex fn corner() -> @builtin(position) vec4<f32> { return vec4<f32>({% if b %}middle(1.0){% else %}1.0{% endif %}); }
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(middle(1.0)); }",
        "",
        &["a=true", "b=true"],
    ),
    // A variable between stages that one of them lacks.
    (
        "struct Between { @builtin(position) place: vec4<f32>, {% if not a %}@location(0) color: f32,{% endif %} }
         @vertex fn corner() -> Between { var out: Between; return out; }
         @fragment fn main({% if b %}@location(0) color: f32{% endif %}) -> @location(0) vec4<f32> {
           return vec4<f32>({% if b %}color{% else %}1.0{% endif %}); }",
        "",
        &["a=true", "b=true"],
    ),
    // A recursion that two features close.
    (
        "fn one(x: f32) -> f32 { return {% if a %}two(x){% else %}x{% endif %}; }
         fn two(x: f32) -> f32 { return {% if b %}one(x){% else %}x{% endif %}; }
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(one(1.0) + two(1.0)); }",
        "",
        &["a=true", "b=true"],
    ),
    // A division by an override that one axis divides by and another declares.
    (
        "{% if a %}override o: i32 = 1;{% else %}const o: i32 = 1;{% endif %}
         fn part() -> i32 { return {% if b %}6 / o{% else %}o{% endif %}; }
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(f32(part())); }",
        "",
        &["a=true", "b=true", "o=0"],
    ),
    // Workgroup memory that only the sum of two uses exceeds.
    (
        "{% if a != b %}const N{{ 1 if a else 2 }} = 1; const M{{ 1 if a else 2 }} = 1;{% endif %}
         var<workgroup> first: array<f32, 3000>; var<workgroup> second: array<f32, 3000>;
         fn one() { {% if a %}first[0] = 1.0;{% endif %} } fn two() { {% if b %}second[0] = 1.0;{% endif %} }
         @compute @workgroup_size(1) fn main() { one(); two(); }",
        "UG0530",
        &["a=true", "b=true"],
    ),
    // An assertion about a constant, without parentheses.
    (
        "{% if a == b %}const N1 = {{ 1 if a else 2 }}; const M1 = {{ 1 if a else 2 }};{% endif %}
         const LIMIT = {{ 5 if a else 4 }}u; {% if b %}const_assert LIMIT == 4u;{% endif %}
         @compute @workgroup_size(1) fn main() {}",
        "",
        &["a=true", "b=true"],
    ),
    // A directive behind a declaration.
    (
        "{% if not a %}diagnostic(off, derivative_uniformity);{% endif %} const FIRST = 1;
         {% if a %}diagnostic(off, derivative_uniformity);{% endif %}
         @compute @workgroup_size(1) fn main() {}",
        "",
        &["a=true"],
    ),
    // Two overrides of one number.
    (
        "{% if a != b %}const N{{ 1 if a else 2 }} = 1; const M{{ 1 if a else 2 }} = 1;{% endif %}
         {% if a %}@id(1) override x: f32 = 1.0;{% endif %} {% if b %}@id(1) override y: f32 = 1.0;{% endif %}
         @compute @workgroup_size(1) fn main() {}",
        "",
        &["a=true", "b=true"],
    ),
    // Workgroup memory that only the sum of two exceeds.
    (
        "var<workgroup> first: array<f32, {{ 3000 if a else 4 }}>; var<workgroup> second: array<f32, {{ 3000 if b else 4 }}>;
         fn fill() { first[0] = 1.0; } fn more() { second[0] = 1.0; }
         @compute @workgroup_size(1) fn main() { fill(); more(); }",
        "UG0530",
        &["a=true", "b=true"],
    ),
    // A texture whose type one axis chooses, sampled with what another chooses.
    (
        "@group(0) @binding(0) var map: {% if a %}texture_depth_2d{% else %}texture_2d<f32>{% endif %};
         @group(0) @binding(1) var smooth_edges: sampler{% if b %}_comparison{% endif %};
         fn tap(at: vec2<f32>) -> f32 { return
           {%- if a and b %} textureSampleCompareLevel(map, smooth_edges, at, 0.5)
           {%- elif a %} f32(textureSampleLevel(map, smooth_edges, at, 0))
           {%- else %} textureSampleLevel(map, smooth_edges, at, 0.0).x{% endif %}; }
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(tap(vec2<f32>(0.5))); }",
        "",
        &["a=false", "b=true"],
    ),
    // A name that two features declare.
    (
        "{% if a %}fn noise() -> f32 { return 1.0; }{% endif %}
         {% if b %}fn noise() -> f32 { return 2.0; }{% endif %}
         @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }",
        "",
        &["a=true", "b=true"],
    ),
];

fn fault(text: &str) -> Fixture {
    Fixture::sound(&[("main.wgsl.jinja", text), ("main.axes.json", AXES)])
}

#[test]
fn faults_where_axes_meet_are_found_with_their_smallest_values() {
    for (text, code, provoked) in FAULTS {
        // Axes that have nothing to do with it multiply the texts.
        let text = format!(
            "{text}\n{{% if d != 'x' %}}fn other() -> f32 {{ return {{{{ n }}}}.0; }}{{% endif %}}\n{{% if n > 1 %}}const N = {{{{ n }}}};{{% endif %}}"
        );
        let fixture = fault(&text);
        let request = Request::all("main.wgsl.jinja", &[TargetProfile::webgpu()]);
        compare(&fixture, &request);
        let outcome = check(&fixture.set, &[request], &Options::default());
        let said = fixture.lines(&outcome.diagnostics);
        let causes: Vec<BTreeSet<String>> = outcome
            .diagnostics
            .iter()
            .filter(|diagnostic| diagnostic.code.id.contains(code))
            .flat_map(|diagnostic| &diagnostic.extent)
            .map(|extent| extent.provoked_by.iter().map(|(name, value)| format!("{name}={value}")).collect())
            .collect();
        let wanted: BTreeSet<String> = provoked.iter().map(|each| (*each).to_owned()).collect();
        assert!(causes.contains(&wanted), "{said:?} {causes:?}, not {wanted:?}:\n{text}");
    }
}

/// A random template of functions that call one another, with axes that change each of them.
fn random_template(random: &mut Random) -> String {
    const CONDITIONS: [&str; 8] = ["a", "b", "c", "not a", "d == 'y'", "d != 'z'", "n > 1", "a and c"];
    let pick = |random: &mut Random, from: &[&str]| from[random.below(from.len())].to_owned();
    let mut text = "@group(0) @binding(0) var<uniform> block: vec4<f32>;
        @group(0) @binding(1) var map: texture_2d<f32>;
        @group(0) @binding(2) var linear: sampler;
        var<private> own: f32;\n"
        .to_owned();
    text.push_str(&format!("const SIZE = {{{{ 4 if {} else 2 }}}};\n", pick(random, &CONDITIONS)));
    text.push_str(&format!(
        "struct Data {{ value: f32, {{% if {} %}}more: f32,{{% endif %}} list: array<f32, SIZE> }}\n",
        pick(random, &CONDITIONS)
    ));
    if random.below(2) == 0 {
        text.push_str(&format!(
            "{{% if {} %}}@group(0) @binding({}) var<uniform> second: vec4<f32>;{{% else %}}const second = vec4<f32>(1.0);{{% endif %}}\n",
            pick(random, &CONDITIONS),
            [0, 3, 3, 4][random.below(4)]
        ));
    } else {
        text.push_str("const second = vec4<f32>(2.0);\n");
    }
    let count = 3 + random.below(4);
    let pieces = |random: &mut Random, at: usize| -> String {
        let mut all: Vec<String> = [
            "x * 2.0",
            "block.x",
            "second.y",
            "own",
            "fwidth(x)",
            "textureSample(map, linear, vec2<f32>(x)).x",
            "textureSampleLevel(map, linear, vec2<f32>(x), 0.0).y",
            "Data().value",
            "Data().list[3]",
            "Data().list[1]",
            "f32(SIZE)",
            "max(x, 1.0)",
            "x",
            "x + 1.0",
            "own * x",
            "block.z * x",
            "min(x, second.x)",
        ]
        .map(str::to_owned)
        .to_vec();
        if random.below(3) == 0 {
            all.extend(["Data().more", "f32(1u) + 1u", "dpdx(own)"].map(str::to_owned));
        }
        all.extend((0..at).flat_map(|callee| std::iter::repeat_n(format!("f{callee}(x)"), 4)));
        all[random.below(all.len())].clone()
    };
    for at in 0..count {
        let ty = if random.below(6) == 0 {
            format!("{{{{ 'i32' if {} else 'f32' }}}}", pick(random, &CONDITIONS))
        } else {
            "f32".to_owned()
        };
        let mut body = String::new();
        for _ in 0..random.below(3) {
            let statement = match random.below(4) {
                0 => format!("if {} > 0.5 {{ y += {}; }}", pieces(random, at), pieces(random, at)),
                1 => format!("own = {};", pieces(random, at)),
                2 => format!("y += {};", pieces(random, at)),
                _ => format!("if block.y > 0.5 {{ y += {}; }}", pieces(random, at)),
            };
            if random.below(2) == 0 {
                body.push_str(&format!("{{% if {} %}}{statement}{{% endif %}} ", pick(random, &CONDITIONS)));
            } else {
                body.push_str(&statement);
            }
        }
        text.push_str(&format!(
            "fn f{at}(z: {ty}) -> f32 {{ let x = f32(z); var y = {}; {body} return y; }}\n",
            pieces(random, at)
        ));
    }
    let (first, second) = (random.below(count), random.below(count));
    text.push_str(&format!(
        "@fragment fn main(@location(0) x: f32) -> @location(0) vec4<f32> {{ var y = f{first}(x); \
         {{% if {} %}}if y > 1.0 {{ y = f{second}(y); }}{{% endif %}} return vec4<f32>(y); }}\n",
        pick(random, &CONDITIONS)
    ));
    if random.below(2) == 0 {
        text.push_str(&format!("@compute @workgroup_size(4) fn other() {{ own = f{second}(1.0); }}\n"));
    }
    text
}

#[test]
fn the_cover_of_random_templates_says_what_every_text_says() {
    let mut random = Random(0x5851_F42D_4C95_7F2D ^ property::seed());
    let (mut texts, mut proven, mut sound, mut mixed) = (0, 0, 0, 0);
    let profiles: Vec<TargetProfile> = TargetProfile::all().into_iter().take(3).collect();
    for _ in 0..40 * property::times() {
        let fixture = fault(&random_template(&mut random));
        let request = Request::all("main.wgsl.jinja", &profiles);
        let (all, few) = compare(&fixture, &request);
        (texts, proven) = (texts + all, proven + few);
        let outcome = check(&fixture.set, &[request], &Options::default());
        let valid = outcome.templates[0].variants.iter().filter(|variant| variant.valid).count();
        sound += usize::from(valid == outcome.templates[0].variants.len());
        mixed += usize::from(valid > 0 && valid < outcome.templates[0].variants.len());
    }
    println!("{texts} texts, {proven} of them proven; {sound} templates without errors, {mixed} with some");
    assert!(sound > 0 && mixed > 3 && proven < texts, "{sound} {mixed}");
}

#[test]
fn requests_together_say_what_each_says_alone() {
    let mut random = Random(0x2545_F491_4F6C_DD1D ^ property::seed());
    let profiles = TargetProfile::all();
    let others = AXES.replace(r#""max": 3, "default": 1, "as""#, r#""max": 2, "default": 2, "as""#);
    let (mut mixed, mut shared) = (0, 0);
    for at in 0..12 * property::times() {
        let mut text = random_template(&mut random);
        // Invalid with the values of one of two templates that share the text, and with some profiles.
        text.push_str(
            "override o: i32 = 1;\nvar<private> rows: array<f32, 3>;\nfn row() -> f32 { return rows[o]; }\n",
        );
        let (group, size) = ([0, 3, 4, 7][at as usize % 4], [64, 256, 4096][at as usize % 3]);
        text.push_str(&format!(
            "{{% if a %}}@group({group}) @binding(9) var<storage, read> list: array<f32, {size}>;
             @fragment fn listed() -> @location(0) vec4<f32> {{ return vec4<f32>(list[1] + row()); }}{{% endif %}}"
        ));
        // Browsers refuse this, and naga does not.
        text.push_str(
            "{% if b %}@fragment fn edged(@location(0) x: f32) -> @location(0) vec4<f32> {
             if x > 0.5 { return vec4<f32>(dpdx(x)); } return vec4<f32>(x); }{% endif %}",
        );
        let fixture = Fixture::sound(&[
            ("main.wgsl.jinja", &text),
            ("main.axes.json", AXES),
            ("other.wgsl.jinja", &text),
            ("other.axes.json", &others),
        ]);
        let requests: Vec<Request> =
            ["main.wgsl.jinja", "other.wgsl.jinja", "main.wgsl.jinja", "other.wgsl.jinja"]
                .iter()
                .map(|root| {
                    let some: Vec<TargetProfile> =
                        profiles.iter().filter(|_| random.below(2) == 0).cloned().collect();
                    Request::all(root, if some.is_empty() { &profiles[..1] } else { &some })
                })
                .collect();
        let together = check(&fixture.set, &requests, &Options { threads: 1, ..Options::default() });
        for (request, report) in requests.iter().zip(&together.templates) {
            let own = std::slice::from_ref(request);
            let options = Options { threads: 1, exhaustive: true, ..Options::default() };
            let alone = check(&fixture.set, own, &options);
            let of = |variants: &[crate::permutations::VariantReport]| -> Vec<_> {
                variants.iter().map(|each| (each.hash.clone(), each.valid, each.reflection.clone())).collect()
            };
            let (few, every) = (of(&report.variants), of(&alone.templates[0].variants));
            for (few, every) in few.iter().zip(&every) {
                assert_eq!(few, every, "{} {:?}\n{text}", request.template, report.profiles);
            }
            assert_eq!(few.len(), every.len());
            let valid = few.iter().filter(|(_, valid, _)| *valid).count();
            mixed += usize::from(valid > 0 && valid < few.len());
        }
        let is_invalid =
            |report: &crate::permutations::TemplateReport| report.variants.iter().any(|each| !each.valid);
        assert_eq!(together.diagnostics.has_errors(), together.templates.iter().any(is_invalid), "{text}");
        let verdicts =
            |at: usize| together.templates[at].variants.iter().map(|each| (&each.hash, each.valid));
        let other: BTreeMap<_, _> = verdicts(1).collect();
        shared +=
            verdicts(0).filter(|(hash, valid)| other.get(hash).is_some_and(|each| each != valid)).count();
    }
    println!("{mixed} requests with valid and invalid texts, {shared} texts of another verdict elsewhere");
    assert!(mixed > 0 && shared > 0, "{mixed} {shared}");
}

#[test]
fn an_error_for_one_profile_is_no_warning_because_of_another() {
    let fixture = fault(
        "fn edge(x: f32) -> f32 { if x > 0.5 { return dpdx(x); } return x; }
         {% if a %}fn more() -> f32 { return 1.0; } fn further() -> f32 { return 2.0; }{% endif %}
         @fragment fn main(@location(0) x: f32) -> @location(0) vec4<f32> {
             return vec4<f32>(edge(x){% if a %} + more() + further(){% endif %});
         }",
    );
    // The larger text is proven first, and for no browser.
    let request = |a: bool, profile: &str| Request {
        allowed: [("a".to_owned(), vec![umbragraph_text::diagnostic::AxisValue::Bool(a)])].into(),
        ..Request::all("main.wgsl.jinja", &[TargetProfile::from_name(profile).unwrap()])
    };
    let check =
        |requests: &[Request]| check(&fixture.set, requests, &Options::default()).diagnostics.has_errors();
    let [native, browser] = [request(true, "vulkan"), request(false, "webgpu")];
    assert!(!check(std::slice::from_ref(&native)));
    assert!(check(&[native, browser]));
}

#[test]
fn texts_with_names_in_a_circle_are_advised() {
    let fixture = fault(
        "struct Block { flag: u32 }
         @group(0) @binding(0) var<uniform> block: Block;
         fn area(radius: f32) -> f32 { return radius; }
         fn radius() -> f32 { return area(1.0); }
         @fragment fn main() -> @location(0) vec4<f32> {
             if block.flag != 0u { return vec4<f32>(radius()); }
             return vec4<f32>(0.0);
         }",
    );
    let request = Request::all("main.wgsl.jinja", &[TargetProfile::webgpu()]);
    compare(&fixture, &request);
    let outcome = check(&fixture.set, &[request], &Options::default());
    let codes: Vec<&str> = outcome.diagnostics.iter().map(|each| each.code.id).collect();
    assert_eq!(codes, [crate::codes::UNIFORM_BRANCH.id]);
}

#[test]
fn texts_with_open_comments_are_not_split() {
    let split = crate::written::declarations::split;
    for open in ["const A = 1; /* note", "const A = 1; /* /* */", "/*/ const A = 1;"] {
        assert!(split(open).is_none(), "{open}");
    }
    for closed in ["/* /* */ */ const A = 1;", "const A = 1; // note", "/**/ const A = 1;"] {
        assert_eq!(split(closed).map(|found| found.len()), Some(1), "{closed}");
    }
}
