//! Templates with their axes, explored and proven.

use std::sync::OnceLock;

use umbragraph::diagnostic::{Diagnostics, Place};
use umbragraph::low_level::shader::permutations::{Options, Request, check};
use umbragraph::low_level::shader::{TargetProfile, TemplateSet};
use umbragraph::low_level::source::Sources;

use crate::mutation::{self, Choices};
use crate::worker::note;

/// A template in which most of the language occurs.
const TEMPLATE: &str = r"{% macro twice(x, y=2) %}({{ x }} * {{ y }}){% endmacro %}
{% set wide = n > 1 and a %}
struct Input { @builtin(global_invocation_id) id: vec3<u32>, }
struct Light { color: vec3<f32>, reach: f32, }
@group(0) @binding(0) var<storage, read_write> sums: array<f32>;
@group(0) @binding(1) var<uniform> lights: array<Light, 4>;
{% if b == 'x' %}
@group(0) @binding(2) var picture: texture_2d<f32>;
{% elif wide %}
@group(0) @binding(2) var picture: texture_depth_2d;
{% endif %}
override side: u32 = 8u;
const SCALE = f32({{ twice(n, 3) }}) + 0.5;

fn weight(at: u32, light: Light) -> f32 {
    var sum = 0.0;
    {% for i in range(n) %}
    sum += light.reach * f32(at + {{ loop.index }}u);
    {% endfor %}
    return select(sum, SCALE, at > 3u && {{ a }});
}
{% include 'lib.wgsl.jinja' %}

@compute @workgroup_size(side, {{ n + 1 }})
fn main(input: Input) {
    let at = input.id.x;
    {% if b == 'x' %}
    sums[at] = weight(at, lights[at & 3u]) + textureLoad(picture, vec2<i32>(input.id.xy), 0).r;
    {% else %}
    loop { if sums[at] > lower(at) { break; } sums[at] += 1.0; }
    {% endif %}
}
";

const LIBRARY: &str =
    "fn lower(at: u32) -> f32 {\n{%- with d = n %} return f32(at) / {{ d + 1 }}.0; {% endwith %}\n}\n";

const AXES: &str = r#"{ "axes": {
  "a": { "type": "bool", "default": false, "requires": ["n!=2"] },
  "b": { "type": "enum", "values": ["x", "y"], "default": "x" },
  "n": { "type": "integer", "min": 0, "max": 3, "default": 1 },
  "side": { "type": "integer", "min": 1, "max": 16, "default": 8, "as": "override" } } }"#;

/// Pieces of other languages' ends.
const OTHERS: &str = "{{ }} {% %} {# #} {%- -%} {% raw %} {% endraw %} {% call(q) twice(1) %} {% endcall %} {% filter upper %} \
    @fragment @vertex @location(0) @interpolate(flat) vec4<f32> mat4x4f atomic<i32> workgroup ptr<function, f32> enable f16 \
    workgroupBarrier() dpdx(1.0) discard continue continuing switch default return bitcast<u32> 3000000000 1e39 0x1p-200 // /*";

/// Variants, or diagnostics inside a text.
pub(crate) fn templates(choices: &mut Choices<'_>) {
    static PROFILES: OnceLock<[TargetProfile; 2]> = OnceLock::new();
    let profiles = PROFILES.get_or_init(|| [TargetProfile::webgpu(), TargetProfile::webgpu_compat()]);
    let mut texts = [TEMPLATE, LIBRARY, AXES].map(str::to_owned);
    let at = *choices.one_of(&[0, 0, 0, 0, 1, 2]);
    texts[at] = mutation::changed(&texts[at], OTHERS, choices);
    note(texts[at].as_bytes());
    let (mut sources, mut found, mut set) = (Sources::new(), Diagnostics::new(), TemplateSet::new());
    for (name, text) in ["main.wgsl.jinja", "lib.wgsl.jinja", "main.axes.json"].iter().zip(&texts) {
        set.add(&mut sources, name, text, &mut found);
    }
    set.check(&mut found);
    let options = Options { threads: 1, report_dead: choices.below(2) == 0, ..Options::default() };
    let outcome = check(&set, &[Request::all("main.wgsl.jinja", profiles)], &options);
    let is_covered = outcome.templates.first().is_some_and(|report| report.covered == report.configurations);
    found.extend(outcome.diagnostics);
    assert!(found.has_errors() || is_covered, "no verdict of some configurations, and no word of it");
    for diagnostic in &found {
        // A panic of naga's is caught, and told of with this code.
        assert_ne!(diagnostic.code.id, "UG0523", "{}", diagnostic.message);
        let Place::Span(span) = &diagnostic.place else { continue };
        let length = sources.get(span.file).map_or(0, |file| file.text().len());
        assert!(span.start <= span.end && span.end as usize <= length, "\"{}\"", diagnostic.message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seed_has_no_errors_in_any_variant() {
        let (mut sources, mut found, mut set) = (Sources::new(), Diagnostics::new(), TemplateSet::new());
        let texts = [TEMPLATE, LIBRARY, AXES];
        for (name, text) in ["main.wgsl.jinja", "lib.wgsl.jinja", "main.axes.json"].iter().zip(texts) {
            set.add(&mut sources, name, text, &mut found);
        }
        let profiles = [TargetProfile::webgpu(), TargetProfile::webgpu_compat()];
        let outcome = check(&set, &[Request::all("main.wgsl.jinja", &profiles)], &Options::default());
        assert!(!outcome.diagnostics.has_errors() && !found.has_errors(), "{:?}", outcome.diagnostics);
        assert!(outcome.texts > 10, "{}", outcome.texts);
    }
}
