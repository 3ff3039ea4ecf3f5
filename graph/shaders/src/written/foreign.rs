//! Words of GLSL, HLSL and C that WGSL writes in another way, and parse errors of naga with a known way out.
//!
//! Limits: declarations are looked for in the text alone, so that a member's structure is known only where a name is
//! declared with its type, or is the result of a function of the same text.

use std::ops::Range;

use super::builtins;
use super::rejection::Rejection;
use umbragraph_text::diagnostic::{list_of, name_meant, suggested_name};

/// Names of other languages, each with what WGSL has instead.
#[rustfmt::skip]
const NAMES: &[(&str, &str)] = &[
    ("float", "f32"), ("int", "i32"), ("uint", "u32"), ("half", "f32"), ("double", "f32"), ("float1", "f32"),
    ("float2", "vec2<f32>"), ("float3", "vec3<f32>"), ("float4", "vec4<f32>"),
    ("half2", "vec2<f32>"), ("half3", "vec3<f32>"), ("half4", "vec4<f32>"),
    ("int2", "vec2<i32>"), ("int3", "vec3<i32>"), ("int4", "vec4<i32>"),
    ("ivec2", "vec2<i32>"), ("ivec3", "vec3<i32>"), ("ivec4", "vec4<i32>"),
    ("uint2", "vec2<u32>"), ("uint3", "vec3<u32>"), ("uint4", "vec4<u32>"),
    ("uvec2", "vec2<u32>"), ("uvec3", "vec3<u32>"), ("uvec4", "vec4<u32>"),
    ("bool2", "vec2<bool>"), ("bool3", "vec3<bool>"), ("bool4", "vec4<bool>"),
    ("bvec2", "vec2<bool>"), ("bvec3", "vec3<bool>"), ("bvec4", "vec4<bool>"),
    ("mat2", "mat2x2<f32>"), ("mat3", "mat3x3<f32>"), ("mat4", "mat4x4<f32>"),
    ("float2x2", "mat2x2<f32>"), ("float3x3", "mat3x3<f32>"), ("float4x4", "mat4x4<f32>"),
    ("sampler2D", "texture_2d<f32> and a sampler"), ("Texture2D", "texture_2d<f32>"),
    ("samplerCube", "texture_cube<f32> and a sampler"), ("TextureCube", "texture_cube<f32>"),
    ("texture", "textureSample(texture, sampler, coordinates)"),
    ("texture2D", "textureSample(texture, sampler, coordinates)"),
    ("tex2D", "textureSample(texture, sampler, coordinates)"),
    ("textureLod", "textureSampleLevel(texture, sampler, coordinates, level)"),
    ("textureGrad", "textureSampleGrad(texture, sampler, coordinates, ddx, ddy)"),
    ("texelFetch", "textureLoad(texture, coordinates, level)"),
    ("textureSize", "textureDimensions(texture, level)"),
    ("imageLoad", "textureLoad(texture, coordinates)"),
    ("imageStore", "textureStore(texture, coordinates, value)"),
    ("imageSize", "textureDimensions(texture)"),
    ("lerp", "mix"), ("frac", "fract"), ("rsqrt", "inverseSqrt"), ("inversesqrt", "inverseSqrt"),
    ("ddx", "dpdx"), ("ddy", "dpdy"), ("dFdx", "dpdx"), ("dFdy", "dpdy"),
    ("ddx_fine", "dpdxFine"), ("ddy_fine", "dpdyFine"), ("ddx_coarse", "dpdxCoarse"), ("ddy_coarse", "dpdyCoarse"),
    ("fmod", "the operator %"), ("mod", "x - y * floor(x / y)"), ("mul", "the operator *"),
    ("lessThan", "the operator <"), ("greaterThan", "the operator >"), ("equal", "the operator =="),
    ("asfloat", "bitcast<f32>"), ("asint", "bitcast<i32>"), ("asuint", "bitcast<u32>"),
    ("uintBitsToFloat", "bitcast<f32>"), ("intBitsToFloat", "bitcast<f32>"),
    ("floatBitsToUint", "bitcast<u32>"), ("floatBitsToInt", "bitcast<i32>"),
    ("bitCount", "countOneBits"), ("countbits", "countOneBits"), ("bitfieldReverse", "reverseBits"),
    ("reversebits", "reverseBits"), ("findMSB", "firstLeadingBit"), ("findLSB", "firstTrailingBit"),
    ("firstbithigh", "firstLeadingBit"), ("firstbitlow", "firstTrailingBit"),
    ("barrier", "workgroupBarrier"), ("GroupMemoryBarrierWithGroupSync", "workgroupBarrier"),
    ("memoryBarrierShared", "workgroupBarrier"), ("memoryBarrierBuffer", "storageBarrier"),
    ("InterlockedAdd", "atomicAdd(&name, value)"), ("InterlockedMax", "atomicMax(&name, value)"),
    ("InterlockedMin", "atomicMin(&name, value)"), ("InterlockedOr", "atomicOr(&name, value)"),
    ("packUnorm4x8", "pack4x8unorm"), ("unpackUnorm4x8", "unpack4x8unorm"),
    ("packHalf2x16", "pack2x16float"), ("unpackHalf2x16", "unpack2x16float"),
    ("gl_FragCoord", "a parameter with @builtin(position)"),
    ("gl_Position", "a result with @builtin(position)"),
    ("gl_VertexID", "a parameter with @builtin(vertex_index)"),
    ("gl_VertexIndex", "a parameter with @builtin(vertex_index)"),
    ("gl_InstanceIndex", "a parameter with @builtin(instance_index)"),
    ("gl_GlobalInvocationID", "a parameter with @builtin(global_invocation_id)"),
    ("gl_LocalInvocationID", "a parameter with @builtin(local_invocation_id)"),
    ("gl_LocalInvocationIndex", "a parameter with @builtin(local_invocation_index)"),
    ("gl_WorkGroupID", "a parameter with @builtin(workgroup_id)"),
];

/// The names of WGSL's functions that can be meant by a misspelt one.
pub(super) fn functions() -> impl Iterator<Item = &'static str> {
    builtins::all().map(|one| one.name).chain(["bitcast"])
}

/// The maximum number of uses of a name among which its declaration is looked for.
const MAX_DECLARATIONS: usize = 64;

/// Explains a parse error, if a word of another language or a known mistake caused it. `words` are the identifiers and
/// brackets of the text. Returns `false` if nothing is known of the error.
pub(super) fn explain(text: &str, rejection: &mut Rejection, words: &[Range<usize>]) -> bool {
    let Some(range) = rejection.range.clone() else { return false };
    let marked = text.get(range.clone()).unwrap_or_default();
    let message = rejection.message.clone();
    let found = message.rsplit_once("found \"").map_or("", |(_, found)| found.trim_end_matches('"'));
    let quoted = message.split('`').nth(1).unwrap_or_default();
    let help = if message.starts_with("no definition in scope") || message.starts_with("unknown type") {
        let known = NAMES.iter().find(|(name, _)| *name == quoted);
        let Some((_, instead)) = known.filter(|_| is_type_or_call(text, &range) || quoted.starts_with("gl_"))
        else {
            return false;
        };
        Some(format!("WGSL has no \"{quoted}\": use {instead}"))
    } else if message.starts_with("invalid field accessor") {
        return member(text, rejection, words, quoted);
    } else if found == "?" {
        Some("WGSL has no `?:`: write select(if_false, if_true, condition), which computes both".to_owned())
    } else if message.starts_with("expected global item") && found == "#" {
        Some(directive(text.get(range.end..).unwrap_or_default()))
    } else if message.starts_with("expected global item") {
        global_item(found).map(str::to_owned)
    } else if message.starts_with("expected `;`") && found == "{" {
        literal(text, words, &range)
    } else if message.contains("`f16` enable extension") {
        rejection.message = "f16 is part of no target profile: devices need not have it".to_owned();
        Some("use f32".to_owned())
    } else if message.starts_with("expected assignment or increment") {
        return declaration(text, rejection, words, found);
    } else if let Some(numbers) = message.strip_prefix("wrong number of arguments: expected ") {
        return arguments(text, rejection, words, numbers);
    } else if message.starts_with("atomic variables cannot be accessed directly") {
        rejection.message = "an atomic is read and written by the atomic functions alone".to_owned();
        Some(atomic_access(text, &range, marked))
    } else if message.ends_with("is recursive") {
        Some("WGSL has no recursion: use a loop, with an array for what is still to do".to_owned())
    } else if message.contains("needs a 'group' attribute") {
        return group(text, rejection, words, &range);
    } else if message.starts_with("automatic conversions cannot convert") {
        return atomic_of_floats(text, rejection, words, &range);
    } else {
        None
    };
    let is_known = help.is_some();
    rejection.help = help.or(rejection.help.take());
    is_known
}

/// Returns `true` if a name is called, or stands where a type is written.
fn is_type_or_call(text: &str, range: &Range<usize>) -> bool {
    let before = text.get(..range.start).unwrap_or_default();
    let after = text.get(range.end..).unwrap_or_default().trim_start();
    let is_argument = before.strip_suffix('<').is_some_and(|name| name.ends_with(char::is_alphanumeric));
    let before = before.trim_end();
    after.starts_with('(') || is_argument || before.ends_with(':') || before.ends_with("->")
}

fn global_item(found: &str) -> Option<&'static str> {
    Some(match found {
        "let" => "a constant of the module is `const NAME = VALUE;`",
        "uniform" | "layout" | "cbuffer" => "a uniform is `@group(1) @binding(0) var<uniform> name: Type;`",
        "in" | "out" | "varying" | "attribute" => {
            "inputs and outputs are parameters and results of the entry point, with @location"
        }
        "function" | "func" | "def" | "void" => "a function is `fn name(x: f32) -> f32 { … }`",
        "static" | "shared" | "groupshared" => {
            "a variable is `var<private> x: f32;` or `var<workgroup> x: f32;`"
        }
        name if NAMES.iter().any(|(known, _)| *known == name) || is_type(name) => {
            "the type stands behind the name: `fn name(x: f32) -> f32 { … }`, `var<private> x: f32;`"
        }
        _ => return None,
    })
}

/// Returns `true` for the name of a type of WGSL that is no structure.
fn is_type(name: &str) -> bool {
    let is_of = |kind: &str| name.strip_prefix(kind).is_some_and(|rest| rest.starts_with(['2', '3', '4']));
    ["f32", "i32", "u32", "bool", "f16"].contains(&name) || is_of("vec") || is_of("mat")
}

/// The way out of a line for a preprocessor; `rest` is the text behind the `#`.
fn directive(rest: &str) -> String {
    let line = rest.lines().next().unwrap_or_default().trim_start();
    let includes = line.starts_with("import") || line.starts_with("include");
    if !includes {
        return "WGSL has no preprocessor: write `const NAME = VALUE;`, or {% set %} and {% if %} of the template \
                language"
            .to_owned();
    }
    let file = line.split(['"', '<', '>']).nth(1).unwrap_or("FILE.wgsl.jinja");
    format!(
        "WGSL has no preprocessor: write {{% include \"{file}\" %}} for the whole text of a template, or {{% from \
         \"{file}\" import NAME %}} for a macro"
    )
}

/// The way out of a structure that is made as in Rust or C: `Name { member: value }`.
fn literal(text: &str, words: &[Range<usize>], range: &Range<usize>) -> Option<String> {
    let name = words.iter().rfind(|word| word.end <= range.end && text[(*word).clone()] != *"{")?;
    let name = &text[name.clone()];
    let members: Vec<&str> = members_of(text, words, name)?.into_iter().map(|range| &text[range]).collect();
    let members = list_of(members);
    Some(format!("WGSL has no `{name} {{ … }}`: write {name}({members}) with the values in this order"))
}

/// Explains a declaration with the type before the name: `int i = 0;`.
fn declaration(text: &str, rejection: &mut Rejection, words: &[Range<usize>], name: &str) -> bool {
    let Some(at) = rejection.range.as_ref().map(|range| range.start) else { return false };
    let Some(last) = words.iter().rfind(|word| word.end <= at) else { return false };
    let written = &text[last.clone()];
    let is_of_wgsl = is_type(written);
    let known = NAMES.iter().find(|(known, _)| *known == written).map(|(_, instead)| *instead);
    let Some(ty) = known.or(is_of_wgsl.then_some(written)) else { return false };
    rejection.message =
        format!("\"{written} {name}\" declares no variable: in WGSL the type stands behind the name");
    rejection.help = Some(format!("write `var {name}: {ty} = …`, or `let` if it keeps its value"));
    rejection.range = Some(last.start..rejection.range.as_ref().map_or(last.end, |range| range.end));
    true
}

/// Explains a call with a wrong number of arguments. `numbers` is the end of naga's message: `3, found 2`.
fn arguments(text: &str, rejection: &mut Rejection, words: &[Range<usize>], numbers: &str) -> bool {
    let (Some((expected, found)), Some(range)) = (numbers.split_once(", found "), rejection.range.clone())
    else {
        return false;
    };
    let Some(name) = words.iter().find(|word| word.start == range.start).map(|word| &text[word.clone()])
    else {
        return false;
    };
    let found = found.split(' ').next().unwrap_or_default();
    if expected.parse::<u32>().is_err() {
        return false;
    }
    let plural = if expected == "1" { "" } else { "s" };
    let called = format!("`{name}` takes {expected} argument{plural} here, not {found}");
    if name == "textureLoad" {
        rejection.help = Some(
            "write textureLoad(texture, coordinates, level): the level is 0 without mips. A layer stands before it; a \
             storage texture has no level"
                .to_owned(),
        );
    } else if let Some(function) = builtins::builtin(name) {
        rejection.help = Some(format!("write {name}({})", function.parameters()));
    } else if let Some(declared) = declared(text, words, "fn", name) {
        let rest = text.get(declared.end..).unwrap_or_default();
        let Some(end) = rest.find('{') else { return false };
        rejection
            .labels
            .push((declared.start..declared.end + rest[..end].trim_end().len(), "declared here".to_owned()));
    } else {
        return false;
    }
    rejection.message = called;
    true
}

/// The place of a name behind a keyword such as `fn`; `None` if no declaration has it.
fn declared(text: &str, words: &[Range<usize>], keyword: &str, name: &str) -> Option<Range<usize>> {
    let mut pairs = words.windows(2);
    let found = pairs.find(|pair| &text[pair[0].clone()] == keyword && &text[pair[1].clone()] == name);
    found.map(|pair| pair[1].clone())
}

fn atomic_access(text: &str, range: &Range<usize>, marked: &str) -> String {
    const OPERATORS: [(&str, &str); 6] = [
        ("+=", "atomicAdd"),
        ("-=", "atomicSub"),
        ("|=", "atomicOr"),
        ("&=", "atomicAnd"),
        ("^=", "atomicXor"),
        ("=", "atomicStore"),
    ];
    let first = marked.split(['[', '(']).next().unwrap_or_default();
    let is_name =
        !first.is_empty() && first.bytes().all(|one| one.is_ascii_alphanumeric() || b"_.".contains(&one));
    let name = if is_name && marked.len() < 80 && !marked.contains('\n') { marked } else { "name" };
    let after = text.get(range.end..).unwrap_or_default().trim_start();
    let assigned = OPERATORS.iter().find(|(sign, _)| after.starts_with(sign) && !after.starts_with("=="));
    match assigned {
        Some((sign, function)) => {
            let value = after[sign.len()..].split([';', ')', '\n']).next().unwrap_or_default().trim();
            let is_whole = !value.is_empty() && !value.contains('(') && value.len() < 80;
            let value = if is_whole { value } else { "value" };
            format!("write {function}(&{name}, {value})")
        }
        None => format!("write atomicLoad(&{name}), or atomicAdd(&{name}, value) to change it"),
    }
}

/// Explains a variable with `@binding` and no `@group`.
fn group(text: &str, rejection: &mut Rejection, words: &[Range<usize>], range: &Range<usize>) -> bool {
    let word = |at: usize| words.get(at).map_or("", |range| &text[range.clone()]);
    let binding = (0..words.len()).find(|at| words[*at].start >= range.start && word(*at) == "binding");
    let Some(number) = binding.map(|at| word(at + 2)) else { return false };
    // The bindings with both attributes, in this order, and the place of each.
    let both = |at: usize| {
        (word(at) == "group" && word(at + 4) == "binding")
            .then(|| (words[at].start.abs_diff(range.start), word(at + 2), word(at + 6)))
    };
    let known: Vec<(usize, &str, &str)> = (0..words.len()).filter_map(both).collect();
    let is_free = |group: &str| !known.iter().any(|(_, known, taken)| *known == group && *taken == number);
    let near = known.iter().filter(|(_, group, _)| is_free(group)).min_by_key(|(distance, ..)| *distance);
    let group = near.map_or("0", |(_, group, _)| group);
    rejection.message = format!("a variable has @binding({number}), and no @group");
    rejection.help = Some(format!("write @group({group}) @binding({number})"));
    true
}

/// Moves the error of a conversion to the `atomic` of floats that caused it.
fn atomic_of_floats(
    text: &str,
    rejection: &mut Rejection,
    words: &[Range<usize>],
    range: &Range<usize>,
) -> bool {
    let line = text.get(..range.start).and_then(|before| before.rfind('\n')).map_or(0, |at| at + 1);
    if !text.get(line..range.start).is_some_and(|line| line.contains("atomic")) {
        return false;
    }
    let mut pairs = words.windows(2);
    let is_it =
        |pair: &[Range<usize>]| &text[pair[0].clone()] == "atomic" && text[pair[1].clone()].starts_with('f');
    let Some(pair) = pairs.find(|pair| is_it(pair)) else { return false };
    let place = pair[0].start..pair[1].end + 1;
    let noticed = format!("noticed here: {}", rejection.message);
    if let Some(range) = rejection.range.replace(place) {
        rejection.labels.insert(0, (range, noticed));
    }
    rejection.message = format!("an atomic is u32 or i32, not {}", &text[pair[1].clone()]);
    rejection.help = Some(
        "use atomic<u32>, and add whole steps: u32(value * 256.0), divided by 256.0 when read".to_owned(),
    );
    true
}

/// Explains an unknown member: the one that was meant, or the members of the structure.
fn member(text: &str, rejection: &mut Rejection, words: &[Range<usize>], name: &str) -> bool {
    let Some(at) = rejection.range.as_ref().map(|range| range.start) else { return false };
    let Some((structure, members)) = members(text, words, at) else { return false };
    let names = || members.iter().map(|range| &text[range.clone()]);
    rejection.message = format!("\"{structure}\" has no member \"{name}\"");
    rejection.help = Some(match suggested_name(name, names()) {
        Some(meant) => {
            let place = members.iter().find(|range| &text[(*range).clone()] == meant);
            rejection.labels.extend(place.map(|range| (range.clone(), format!("\"{meant}\" is here"))));
            rejection.replacement = name_meant(name, names()).map(str::to_owned);
            format!("did you mean \"{meant}\"?")
        }
        None => format!("its members are {}", list_of(names())),
    });
    true
}

/// The structure of the value whose member stands at a place, and the places of its members.
fn members<'t>(text: &'t str, words: &[Range<usize>], at: usize) -> Option<(&'t str, Vec<Range<usize>>)> {
    let word = |at: usize| words.get(at).map(|range| &text[range.clone()]);
    let follows = |at: usize, sign: char| {
        let rest = words.get(at).and_then(|range| text.get(range.end..)).unwrap_or_default();
        rest.trim_start().starts_with(sign)
    };
    let member = words.iter().position(|range| range.start == at)?;
    let object = member.checked_sub(1).filter(|before| {
        let between = text.get(words[*before].end..at).unwrap_or_default();
        between.trim() == "."
    })?;
    let object_name = word(object)?;
    // The declaration before the use that is nearest to it.
    let declarations = (0..object).rev().filter(|at| word(*at) == Some(object_name)).take(MAX_DECLARATIONS);
    let structure = { declarations }.find_map(|at| {
        if follows(at, ':') {
            return word(at + 1);
        }
        let is_let = matches!(at.checked_sub(1).and_then(word), Some("let" | "var"));
        let called = word(at + 1).filter(|_| is_let && follows(at, '=') && word(at + 2) == Some("("))?;
        let function = declared(text, words, "fn", called)?;
        let rest = text.get(function.end..)?;
        let head = &rest[..rest.find('{')?];
        let (_, result) = head.rsplit_once("->")?;
        Some(result.rsplit(' ').next().unwrap_or(result).trim()).filter(|result| !result.is_empty())
    })?;
    Some((structure, members_of(text, words, structure)?))
}

/// The places of the members of a structure; `None` if the text declares no such structure, or one without members.
fn members_of(text: &str, words: &[Range<usize>], structure: &str) -> Option<Vec<Range<usize>>> {
    let word = |at: usize| words.get(at).map(|range| &text[range.clone()]);
    let follows =
        |range: &Range<usize>| text.get(range.end..).unwrap_or_default().trim_start().starts_with(':');
    let place = declared(text, words, "struct", structure)?;
    let begin = words.iter().position(|range| *range == place)? + 1;
    let mut depth = 0_usize;
    let mut members = Vec::new();
    for (at, range) in words.iter().enumerate().skip(begin) {
        match word(at)? {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => depth = depth.checked_sub(1)?,
            _ if depth == 1 && follows(range) => members.push(range.clone()),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    (!members.is_empty()).then_some(members)
}
