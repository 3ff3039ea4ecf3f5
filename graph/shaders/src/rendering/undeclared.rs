//! Ways out of names that a template reads and nothing declares.

use std::ops::Range;

use super::templates::TemplateSet;
use super::unchanged::NAMING;
use crate::jinja::template::Template;
use umbragraph_text::source::FileId;

/// The way out of an undeclared name at a place of a template that the template `root` reads; `None` if all that is
/// known is that it may be an axis.
pub(super) fn way_out(
    set: &TemplateSet,
    root: &str,
    file: FileId,
    name: &str,
    range: &Range<usize>,
) -> Option<String> {
    let template = set.templates.values().find(|template| template.file == file)?;
    let text = &template.text;
    let before = text.get(..range.start)?.trim_end();
    let after = text.get(range.end..)?.trim_start();
    if after.starts_with('(') {
        return match &template.prepared.structure.extends {
            Some(base) if ["base", "parent", "inherited"].contains(&name) => {
                Some(format!("{{{{ super() }}}} is the text of this block in \"{base}\""))
            }
            _ => importable(set, name),
        };
    }
    let stem = root.strip_suffix(".wgsl.jinja").unwrap_or(root);
    let mut tags = template.scan.tags.iter().filter(|tag| tag.range.contains(&range.start));
    if let Some(tag) = tags.find(|tag| tag.keyword(text).is_some_and(|keyword| NAMING.contains(&keyword))) {
        let (first, last) = (tag.words.get(1)?, tag.words.last()?);
        let name = text.get(first.range.start..last.range.end)?;
        return Some(format!("the name of a template stands in quotes: \"{name}\""));
    }
    if before.ends_with("==") || before.ends_with("!=") {
        return Some(format!(
            "write a word in quotes: \"{name}\"; if it is an axis, declare it in {stem}.axes.json"
        ));
    }
    None
}

/// The tag that imports a macro from the only template that has it; `None` if no template has it, or several.
pub(super) fn importable(set: &TemplateSet, name: &str) -> Option<String> {
    let has_it = |template: &Template| template.prepared.structure.macros.iter().any(|one| one.name == name);
    let mut having = set.templates.iter().filter(|(_, template)| has_it(template));
    let (file, _) = having.next()?;
    having.next().is_none().then(|| format!("import the macro: {{% from \"{file}\" import {name} %}}"))
}
