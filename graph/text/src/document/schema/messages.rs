//! The diagnostics of schema checks, with their help texts and fixes.

use super::{Entry, Value};
use crate::diagnostic::{DID_YOU_MEAN, Diagnostic, codes, list_of};

/// Keys here, each with the keys of WebGPU, Vulkan and other engines that mean the same, as [`plain`] writes them.
const FOREIGN_KEYS: &str = "\
    clear: loadop depthloadop stencilloadop load clearvalue clearcolor cleardepth depthclearvalue \
    stencilclearvalue; store: storeop depthstoreop stencilstoreop; slope_bias: depthbiasslopescale slopescale \
    depthbias bias polygonoffset slopescaleddepthbias; write: depthwriteenabled depthwriteenable depthwrite zwrite \
    writedepth; compare: depthcompare depthcompareop depthtest depthfunc ztest comparefunction compareop; \
    write_mask: colormask colorwritemask stencilwritemask mask; read_mask: stencilreadmask comparemask; reference: \
    stencilreference ref; depth_fail: depthfailop zfail; fail: failop; pass: passop; cull: cullmode culling \
    facecull backfaceculling; topology: primitivetopology primitive; order: sort sorting sortorder; mesh_filter: \
    filter layer queue renderqueue objects meshes; filter: magfilter minfilter mipmapfilter mipfilter; address: \
    addressmode addressmodeu addressmodev addressmodew wrap wrapmode wraps wrapt; max_anisotropy: anisotropy aniso; \
    mips: miplevelcount miplevels mipmaps mipcount levels; mip: miplevel basemiplevel level lod; layers: \
    depthorarraylayers arraylayers arraylayercount layercount arraysize slices; layer: arraylayer basearraylayer \
    slice; samples: samplecount msaa multisample; view_dimension: dimension type kind texturetype; size: width \
    height extent dimensions resolution bytes bytelength bytesize length count stride elements elementcount \
    elementsize capacity; bind: bindings bindgroup bindgroups inputs uniforms textures resources params; shader: \
    module program template material wgsl effect; axes: defines macros constants overrides permutations variants \
    keywords; entry_points: entrypoint entry; color: colorattachments colors outputs output targets rendertargets \
    attachments rgb; depth: depthstencil depthstencilattachment depthattachment depthbuffer depthtarget; resolve: \
    resolvetarget; to: target view attachment texture output destination; from: source src; workgroups: \
    workgroupcount dispatch dispatchsize groups threadgroups numgroups; dispatch_over: over domain; vertices: \
    vertexbuffers vertexbuffer buffers vertex; indices: indexbuffer index; count: vertexcount indexcount drawcount; \
    instances: instancecount; stride: arraystride pitch; step: stepmode inputrate; bytes_per_row: rowpitch pitch; \
    after: dependson dependencies depends needs waitfor; when: condition enabled enable if onlyif active; for_each: \
    loop repeat forall iterate; holds: when condition assert expression check test require rule if; src_factor: src \
    srcblend source; dst_factor: dst dstblend destination; operation: op blendop equation function; default: value \
    initial defaultvalue; values: options choices enum variants words; description: doc docs comment tooltip help; \
    parameters: params settings variables uniforms properties; features: flags options keywords defines; passes: \
    nodes steps stages; resources: textures buffers images attachments targets; include: import imports includes;";

/// Keys of other engines that nothing here stands for, as [`plain`] writes them, each with a key that is known at the
/// place and the way out.
#[rustfmt::skip]
const NEEDLESS_KEYS: &[(&str, &str, &str)] = &[
    ("usage usages flags", "lifetime", "remove it: usages follow from the passes that use the resource"),
    ("color depth stencil colorattachments outputs targets", "dispatch_over",
        "a compute pass has no attachments: bind a storage texture and write it with textureStore, or use \"fullscreen\""),
    ("vertices indices topology cull count", "dispatch_over", "a compute pass draws nothing: use \"mesh\" or \"draw\""),
    ("layout pipelinelayout visibility binding group set slot", "bind",
        "remove it: layouts follow from the shader, and the name of a variable is its slot"),
    ("label id name", "lifetime", "remove it: the key before the { is the name"),
    ("label id name", "passthrough", "remove it: the key before the { is the name"),
];

/// A key in lower case without anything but letters and digits.
fn plain(key: &str) -> String {
    key.chars().filter(|each| each.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Returns the known key that means the same as a key of another API or engine; `None` if none does.
pub(super) fn same_key<'k>(key: &str, mut known: impl Iterator<Item = &'k str>) -> Option<&'k str> {
    let key = plain(key);
    let same = || FOREIGN_KEYS.split(';').filter_map(|entry| entry.trim().split_once(": "));
    known.find(|own| same().any(|(one, keys)| one == *own && keys.split(' ').any(|each| each == key)))
}

/// Returns the number of bytes that two keys of another API say together: a count and a stride.
pub(super) fn joined(entries: &[&Entry]) -> Option<u64> {
    let [first, second] = entries else { return None };
    let number = |entry: &Entry| entry.value.to_json().as_u64();
    number(first)?.checked_mul(number(second)?).filter(|_| first.key != "width")
}

/// Creates the diagnostic for a key that is not one of `known`; `beside` lists all members of the object that contains
/// the key.
pub fn unknown_key(entry: &Entry, known: &[&str], beside: &[Entry]) -> Diagnostic {
    let diagnostic =
        Diagnostic::error(codes::UNKNOWN_KEY, entry.key_span, format!("unknown key \"{}\"", entry.key));
    // A key that is there already would stand twice; one of a file below is laid over.
    let file = entry.key_span.file;
    let taken = |name: &str| beside.iter().any(|other| other.key == name && other.key_span.file == file);
    let plain = plain(&entry.key);
    let is_it = |keys: &str| keys.split(' ').any(|key| key == plain);
    let needless = NEEDLESS_KEYS.iter().find(|(keys, beside, _)| is_it(keys) && known.contains(beside));
    if let Some((.., help)) = needless {
        return diagnostic.help(*help);
    }
    if let Some(same) = same_key(&entry.key, known.iter().copied()) {
        return diagnostic.help(format!("{DID_YOU_MEAN} \"{same}\"?"));
    }
    let known = known.iter().copied();
    diagnostic.suggest_unless(&entry.key, known, Some(entry.key_span), taken, |known| match known {
        [] => "no keys are known here".to_owned(),
        known => format!("the keys known here are {}", list_of(known)),
    })
}

/// Creates the diagnostic for a value of another type than `wanted`.
pub(super) fn wrong_type(value: &Value, wanted: &str) -> Diagnostic {
    let message = format!("{wanted} is wanted here, this is {}", value.kind_name());
    let diagnostic = Diagnostic::error(codes::WRONG_TYPE, value.span, message);
    let number = value.text().filter(|text| text.parse::<f64>().is_ok_and(f64::is_finite));
    match number.filter(|_| wanted.contains("number")) {
        Some(number) => diagnostic.help(format!("write it without quotes: {number}")),
        None => diagnostic,
    }
}

/// Adds the help and the fix that put a value between two texts.
pub(super) fn with_wrapper(
    diagnostic: Diagnostic,
    value: &Value,
    wrapper: Option<(String, &'static str)>,
) -> Diagnostic {
    let Some((before, after)) = wrapper else { return diagnostic };
    let written = match value.text() {
        Some(text) => format!("\"{text}\""),
        None => "…".to_owned(),
    };
    let end = value.span.range().len();
    diagnostic
        .help(format!("write {before}{written}{after}"))
        .fix(value.span.inside(0..0), before)
        .fix(value.span.inside(end..end), after)
}

/// The beginning of the help text that lists all known words.
pub(super) const KNOWN_ARE: &str = "known are";

/// Words of other languages, each with the words here that mean the same; the first that is known counts.
const ALIASES: &[(&str, &[&str])] = &[
    ("float", &["f32"]),
    ("int", &["integer", "i32"]),
    ("uint", &["u32"]),
    ("boolean", &["bool"]),
    ("r", &["red"]),
    ("g", &["green"]),
    ("b", &["blue"]),
    ("a", &["alpha"]),
];

/// Creates the diagnostic for a value that is not one of the allowed words.
pub fn unknown_word(value: &Value, words: &[&str]) -> Diagnostic {
    let found = value.text().map_or_else(|| value.kind_name().to_owned(), |text| format!("\"{text}\""));
    let diagnostic = Diagnostic::error(codes::UNKNOWN_WORD, value.span, format!("{found} is not known here"));
    let text = value.text().unwrap_or_default();
    let mut same = ALIASES.iter().filter(|(alias, _)| *alias == text).flat_map(|(_, same)| *same);
    if let Some(word) = same.find(|word| words.contains(word)) {
        let diagnostic = diagnostic.help(format!("{DID_YOU_MEAN} \"{word}\"?"));
        return diagnostic.fix(value.span, format!("\"{word}\""));
    }
    if text.starts_with("vec") && words.contains(&"f32[]") {
        let help = "a vector is an \"f32[]\" with a length: \"min_length\": 3, \"max_length\": 3";
        return diagnostic.help(help);
    }
    // "additive" means "add".
    let shorter = words.iter().filter(|word| word.len() >= 3 && text.starts_with(**word));
    let begins = shorter.max_by_key(|word| word.len());
    let begins = begins.filter(|begun| words.iter().filter(|word| word.starts_with(**begun)).count() == 1);
    diagnostic.suggest(text, words.iter().copied(), Some(value.span), |words| match (words, begins) {
        (words, Some(word)) if words.len() <= 24 => {
            format!("is \"{word}\" meant? {KNOWN_ARE} {}", list_of(words))
        }
        (words, None) if words.len() <= 24 => format!("{KNOWN_ARE} {}", list_of(words)),
        (_, Some(word)) => format!("is \"{word}\" meant?"),
        _ => "see the schema for the words known here".to_owned(),
    })
}
