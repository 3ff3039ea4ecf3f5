//! WGSL that browsers take and naga does not: the name of the feature, and a way without it.
//!
//! WGSL grows by language extensions, and naga follows; it also evaluates fewer functions when a module is created. Its
//! messages say what is wrong, as if the text were at fault. This table adds the name of what is missing.
//!
//! Source: *WebGPU Shading Language*, "Language Extensions".

use super::rejection::Rejection;

/// WGSL features that naga does not support. Each has a part of naga's error message, the name of the feature, and a
/// workaround.
const KNOWN: [(&str, &str, &str); 10] = [
    (
        "which can't be passed into functions",
        "\"unrestricted_pointer_parameters\"",
        "use the variable by its name in the function, or pass an index",
    ),
    (
        "is not a multiple of the required alignment 16",
        "\"uniform_buffer_standard_layout\"",
        "use elements of 16 bytes, as vec4f, or a storage buffer",
    ),
    (
        "must be at least 16",
        "\"uniform_buffer_standard_layout\"",
        "give the member behind the structure \"@align(16)\", or use a storage buffer",
    ),
    (
        "unknown language extension",
        "this extension",
        "leave the line out, and write what it allows in another way",
    ),
    (
        "language extension is not yet supported",
        "this extension",
        "leave the line out, and write what it allows in another way",
    ),
    (
        "enable-extension is not yet supported",
        "this extension",
        "leave the line out: naga may know the functions",
    ),
    ("unknown builtin", "the built-in value, if it is one of WGSL", "compute it from those that naga knows"),
    (
        "Not implemented as constant expression",
        "the value of this function where a constant is needed",
        "write the value, or call the function in a \"let\"",
    ),
    (
        "failed to convert expression to a concrete type",
        "the value of a function of untyped numbers",
        "give one of them a suffix, as 1f; a number that is too large is an error in browsers, too",
    ),
    ("attribute(s) not yet implemented", "\"@diagnostic\" within a function", "put it before the function"),
];

/// Adds help to a rejection by naga if an unsupported WGSL feature caused it: the name of the feature and a workaround.
pub(crate) fn explain(text: &str, rejection: Rejection) -> Rejection {
    let is_swizzle = || {
        let written = rejection.range.clone().and_then(|range| text.get(range)).unwrap_or_default();
        let components = written.rsplit_once('.').map_or("", |(_, components)| components.trim());
        components.len() > 1 && components.bytes().all(|one| b"xyzwrgba".contains(&one))
    };
    let swizzle = ("invalid left-hand side", "\"swizzle_assignment\"", "assign each component");
    let mut known = KNOWN.into_iter().chain(is_swizzle().then_some(swizzle));
    let Some((_, name, way)) = known.find(|(message, ..)| rejection.message.contains(message)) else {
        return rejection;
    };
    let help = format!("naga does not know {name}: {way}");
    let help = rejection.help.as_ref().map_or_else(|| help.clone(), |before| format!("{help} ({before})"));
    Rejection { help: Some(help), ..rejection }
}
