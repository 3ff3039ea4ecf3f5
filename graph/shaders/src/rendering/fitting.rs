//! Parts of templates that do not fit to the templates that they name.
//!
//! The engine drops three things without a word: a block that the extended template does not have, text outside of
//! blocks in a template that extends another, and the import of a macro that does not exist (the first call fails).
//!
//! Limits: nothing is said of a template whose bases are not all known, because a name is computed, missing or broken.
//! A block that some included template has counts as known. Text is dropped without a diagnostic if it does not look
//! like WGSL.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use crate::codes;
use crate::jinja::template::Template;
use umbragraph_text::diagnostic::{Diagnostic, list_of};
use umbragraph_text::source::Span;

type Templates = BTreeMap<String, Arc<Template>>;

/// The maximum number of templates that are followed from one.
const MAX_TEMPLATES: usize = 256;

/// Returns the errors about parts of the template `name` that appear in no text.
pub(super) fn check(templates: &Templates, name: &str) -> Vec<Diagnostic> {
    let Some(template) = templates.get(name).filter(|template| template.broken.is_none()) else {
        return Vec::new();
    };
    let mut found: Vec<Diagnostic> = missing_imports(templates, template).collect();
    if let Some(base) = &template.prepared.structure.extends {
        found.extend(dropped(template, base));
        found.extend(unknown_blocks(templates, name, template, base));
    }
    found
}

/// The templates that a template extends, the nearest first; `None` if one of them is not known.
fn bases<'t>(templates: &'t Templates, name: &str) -> Option<Vec<&'t Template>> {
    let mut bases: Vec<&Template> = Vec::new();
    let mut next = templates.get(name)?;
    loop {
        let structure = &next.prepared.structure;
        if structure.extends_any || next.broken.is_some() || bases.len() > MAX_TEMPLATES {
            return None;
        }
        let Some(base) = &structure.extends else { return Some(bases) };
        next = templates.get(base)?;
        bases.push(next);
    }
}

/// The blocks of templates, and of all that they include.
fn blocks<'t>(templates: &'t Templates, roots: &[&'t Template]) -> BTreeSet<&'t str> {
    let mut seen: Vec<&Template> = roots.to_vec();
    let mut at = 0;
    while let Some(template) = seen.get(at).copied() {
        at += 1;
        let structure = &template.prepared.structure;
        for name in structure.includes.iter().chain(&structure.extends) {
            let other = templates.get(name).map(|other| &**other);
            let is_new = |other: &&Template| !seen.iter().any(|known| known.file == other.file);
            seen.extend(other.filter(|_| at < MAX_TEMPLATES).filter(is_new));
        }
    }
    seen.iter().flat_map(|one| &one.prepared.structure.blocks).map(|block| block.name.as_str()).collect()
}

fn unknown_blocks(templates: &Templates, name: &str, template: &Template, base: &str) -> Vec<Diagnostic> {
    let Some(bases) = bases(templates, name) else { return Vec::new() };
    let calls_blocks = |one: &Template| one.prepared.names.uses.iter().any(|(name, _)| name == "self");
    if calls_blocks(template) || bases.iter().any(|base| calls_blocks(base)) {
        return Vec::new();
    }
    let known = blocks(templates, &bases);
    // A template that extends this one can write its block in a block of its own.
    let is_in_descendant = |block: &str| {
        templates.iter().any(|(other, descendant)| {
            let mut blocks = descendant.prepared.structure.blocks.iter();
            blocks.any(|one| one.is_nested && one.name == block)
                && self::bases(templates, other)
                    .is_none_or(|bases| bases.iter().any(|base| base.file == template.file))
        })
    };
    let own = template.prepared.structure.blocks.iter().filter(|block| !block.is_nested);
    let unknown = own.filter(|block| !known.contains(block.name.as_str()) && !is_in_descendant(&block.name));
    let diagnostic = |block: &crate::jinja::structure::Block| {
        let span = Span::new(template.file, block.range.clone());
        let message = format!(
            "\"{base}\", which this template extends, has no block \"{}\": its text appears nowhere",
            block.name
        );
        Diagnostic::error(codes::TEMPLATES_MISFIT, span, message).suggest(
            &block.name,
            known.iter().copied(),
            Some(span),
            |names| match names {
                [] => "it has no blocks at all".to_owned(),
                names => format!("its blocks are {}", list_of(names)),
            },
        )
    };
    unknown.map(diagnostic).collect()
}

/// The first WGSL outside of blocks in a template that extends another.
fn dropped(template: &Template, base: &str) -> Option<Diagnostic> {
    let range = code_in(&template.text, &template.prepared.structure.dropped)?;
    let message =
        format!("text outside of blocks appears nowhere in a template that extends another, here \"{base}\"");
    let diagnostic = Diagnostic::error(codes::TEMPLATES_MISFIT, Span::new(template.file, range), message);
    Some(diagnostic.help("put it into one of the blocks"))
}

/// The line of the first WGSL declaration in some ranges of a template, without comments.
fn code_in(text: &str, ranges: &[Range<usize>]) -> Option<Range<usize>> {
    const DECLARATIONS: [&str; 9] =
        ["fn ", "struct ", "const ", "var<", "var ", "override ", "alias ", "@", "const_assert "];
    // All else than the ranges becomes spaces, so that a comment may go on behind a tag.
    let mut bytes: Vec<u8> = text.bytes().map(|byte| if byte == b'\n' { byte } else { b' ' }).collect();
    for range in ranges {
        bytes.get_mut(range.clone())?.copy_from_slice(text.as_bytes().get(range.clone())?);
    }
    let seen = String::from_utf8(bytes).ok()?;
    let (mut start, mut is_comment) = (0, false);
    for line in seen.split_inclusive('\n') {
        let code = line.trim();
        is_comment |= code.starts_with("/*");
        if !is_comment && DECLARATIONS.iter().any(|word| code.starts_with(word)) {
            let at = start + line.len() - line.trim_start().len();
            return Some(at..at + code.len());
        }
        is_comment &= !code.contains("*/");
        start += line.len();
    }
    None
}

/// The imported names that the other template does not define.
fn missing_imports<'t>(templates: &'t Templates, template: &'t Template) -> impl Iterator<Item = Diagnostic> {
    template.prepared.structure.imports.iter().filter_map(|import| {
        let other = templates.get(&import.template).filter(|other| other.broken.is_none())?;
        let structure = &other.prepared.structure;
        let is_closed =
            structure.includes.is_empty() && structure.extends.is_none() && !structure.extends_any;
        if !is_closed || other.prepared.names.bound.contains(&import.name) {
            return None;
        }
        let span = Span::new(template.file, import.range.clone());
        let message = format!("\"{}\" has no macro \"{}\"", import.template, import.name);
        let macros = structure.macros.iter().map(|one| one.name.as_str());
        let diagnostic = Diagnostic::error(codes::TEMPLATES_MISFIT, span, message);
        // A fix would have to rename the calls, too.
        Some(diagnostic.suggest(&import.name, macros, None, |names| match names {
            [] => "it has no macros at all".to_owned(),
            names => format!("its macros are {}", list_of(names)),
        }))
    })
}
