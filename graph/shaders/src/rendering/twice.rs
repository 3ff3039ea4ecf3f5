//! Templates that one text includes twice, found from a name that is declared twice.
//!
//! naga says where the second declaration stands. If both declarations come from one place of one template, that
//! template was written out twice, and the mistake is in the tags that include it. Those tags are looked for in the
//! templates of the text: if only one includes it, the template of that tag is the one that is written out twice.
//!
//! Limits: the name in a tag has to be a string. A tag in a loop writes its template again and again, and is the only
//! one to be found; the error then stays as naga says it.

use std::collections::BTreeSet;

use umbragraph_text::diagnostic::Diagnostic;
use umbragraph_text::source::{FileId, Span};

use super::templates::TemplateSet;
use crate::written::rejection::Rejection;
use crate::written::text_map::TextMap;

/// The tags that write the text of a template into others.
const TAGS: [&str; 2] = ["include", "extends"];
/// The maximum number of templates through which the tags are followed.
const MAX_DEPTH: usize = 16;

/// Adds both ways by which a template comes into the text of the template `root` twice. Other diagnostics stay as they
/// are.
pub(super) fn explain(
    set: &TemplateSet,
    root: FileId,
    rejection: &Rejection,
    map: &TextMap,
    mut diagnostic: Diagnostic,
) -> Diagnostic {
    let Some((name, tags)) = written_twice(set, root, rejection, map) else { return diagnostic };
    let own = diagnostic.place.clone();
    diagnostic.related.retain(|related| related.place != own);
    for tag in &tags {
        diagnostic = diagnostic.related(*tag, format!("\"{name}\" is included here"));
    }
    diagnostic
        .help(format!("\"{name}\" is included {} times: include it once, before its first use", tags.len()))
}

/// The template that is written out twice, and the tags that include it, in the order of the templates' names.
fn written_twice(
    set: &TemplateSet,
    root: FileId,
    rejection: &Rejection,
    map: &TextMap,
) -> Option<(String, Vec<Span>)> {
    if !rejection.message.starts_with("redefinition of") {
        return None;
    }
    let place = |at: usize| map.place(at).map(|span| (span.file, span.start));
    let twice = place(rejection.range.as_ref()?.start)?;
    if !rejection.labels.iter().any(|(range, _)| place(range.start) == Some(twice)) {
        return None;
    }
    let name_of =
        |file| set.templates.iter().find(|(_, one)| one.file == file).map(|(name, _)| name.as_str());
    let tags = tags_below(set, name_of(root)?);
    let mut name = name_of(twice.0)?;
    for _ in 0..MAX_DEPTH {
        let to_it: Vec<&Include<'_>> = tags.iter().filter(|tag| tag.of == name).collect();
        match to_it[..] {
            [] => return None,
            [only] => name = only.by,
            _ => return Some((name.to_owned(), to_it.iter().map(|tag| tag.span).collect())),
        }
    }
    None
}

/// A tag of the template `by` that writes the template `of`.
struct Include<'s> {
    by: &'s str,
    of: &'s str,
    span: Span,
}

/// The tags of the template `root` and of all templates that come into its text.
fn tags_below<'s>(set: &'s TemplateSet, root: &'s str) -> Vec<Include<'s>> {
    let mut found: Vec<Include<'s>> = Vec::new();
    let mut names = BTreeSet::from([root]);
    let mut open = vec![root];
    while let Some(by) = open.pop() {
        let Some(template) = set.templates.get(by) else { continue };
        for tag in &template.scan.tags {
            let writes = tag.keyword(&template.text).is_some_and(|word| TAGS.contains(&word));
            let name = tag.word(&template.text, 1).map(|word| word.trim_matches(['"', '\'']));
            let (true, Some(of)) = (writes, name) else { continue };
            found.push(Include { by, of, span: Span::new(template.file, tag.range.clone()) });
            if names.insert(of) {
                open.push(of);
            }
        }
    }
    found.sort_by_key(|tag| (tag.by, tag.span.start));
    found
}
