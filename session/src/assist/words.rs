//! Explanations of words that the language defines: functions of expressions, and texture formats.

use super::context::Context;
use crate::graph::diagnostic::Diagnostics;
use crate::graph::expression::FUNCTIONS;
use crate::graph::language::parse_format;
use crate::graph::pipeline::claimed_profiles;
use crate::graph::shader::TargetProfile;
use crate::graph::source::Span;
use crate::graph::wgpu_types::{TextureFormat, TextureFormatFeatureFlags as Flags, TextureUsages};
use crate::texts::scan::word_at;

/// Returns the place and the explanation, in Markdown, of a function that an expression calls, or of a texture format,
/// at the cursor.
pub(super) fn told(context: &Context<'_>) -> Option<(Span, String)> {
    let site = context.site();
    let (value, _) = site.string(context.text, context.offset)?;
    let text = value.text()?;
    let told = |range, text| (context.span(range), text);
    if text.starts_with('=') {
        let range = word_at(context.text, context.offset);
        let function = FUNCTIONS.iter().find(|one| Some(one.name) == context.text.get(range.clone()))?;
        let is_called = context.text[range.end..].trim_start().starts_with('(');
        let text = || format!("`{}`\n\nFunction of expressions: {}.", function.usage, function.description);
        return is_called.then(|| told(range, text()));
    }
    let format = parse_format(text)?;
    let is_format = context.rules(&site).words().iter().any(|(word, _)| *word == text);
    is_format.then(|| told(site.replaced, described(context, text, format)))
}

/// Returns the bytes of a format and its uses, for each profile that the pipeline claims.
fn described(context: &Context<'_>, name: &str, format: TextureFormat) -> String {
    let mut profiles = claimed_profiles(&context.composed.document, &mut Diagnostics::new());
    if profiles.is_empty() {
        profiles.push(context.choice.profile.clone());
    }
    let uses: Vec<(String, String)> =
        profiles.iter().map(|one| (one.name.to_string(), uses(format, one))).collect();
    let (width, height) = format.block_dimensions();
    let of = if (width, height) == (1, 1) {
        "texel".to_owned()
    } else {
        format!("block of {width} × {height} texels")
    };
    let size = match format.block_copy_size(None) {
        Some(bytes) => format!("{bytes} bytes per {of}"),
        None => "bytes per texel depend on the device".to_owned(),
    };
    let mut text = format!("`{name}`: {size}");
    let is_same = uses.iter().all(|(_, one)| *one == uses[0].1);
    let names: Vec<&str> = uses.iter().map(|(name, _)| name.as_str()).collect();
    match is_same {
        true => text.push_str(&format!("\n\n{}: {}", names.join(", "), uses[0].1)),
        false => uses.iter().for_each(|(name, uses)| text.push_str(&format!("\n\n{name}: {uses}"))),
    }
    text
}

/// Returns what textures of a format can be used for on every device of a profile.
fn uses(format: TextureFormat, profile: &TargetProfile) -> String {
    if !profile.features.contains(format.required_features()) {
        return "not there".to_owned();
    }
    let guaranteed = format.guaranteed_format_features(profile.features);
    let has = |flag| guaranteed.flags.contains(flag);
    let may = |usage| guaranteed.allowed_usages.contains(usage);
    let storage = [
        (Flags::STORAGE_READ_WRITE, "storage (read and write at once)"),
        (Flags::STORAGE_READ_ONLY, "storage (read)"),
        (Flags::STORAGE_WRITE_ONLY, "storage (write)"),
    ];
    let storage =
        storage.into_iter().map(|(flag, word)| (may(TextureUsages::STORAGE_BINDING) && has(flag), word));
    let list = [
        (has(Flags::FILTERABLE), "filterable"),
        (may(TextureUsages::RENDER_ATTACHMENT), "renderable"),
        (has(Flags::BLENDABLE), "blendable"),
        (has(Flags::MULTISAMPLE_X4), "4 samples"),
        (has(Flags::MULTISAMPLE_RESOLVE), "resolvable"),
    ];
    let words: Vec<&str> =
        list.into_iter().chain(storage).filter(|(is_there, _)| *is_there).map(|(_, word)| word).collect();
    if words.is_empty() { "only read texel by texel".to_owned() } else { words.join(", ") }
}
