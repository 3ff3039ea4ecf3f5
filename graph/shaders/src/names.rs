//! Names in the tags of a template: where they are used, and what binds them.

use super::template::Template;
use crate::source::FileId;

/// Whether a tag of the template binds a name.
pub(crate) fn binds(template: &Template, name: &str) -> bool {
    find_name(template, name).is_some_and(|found| found.bound)
}

pub(super) struct NameUse {
    pub(super) file: FileId,
    pub(super) uses: Vec<std::ops::Range<usize>>,
    pub(super) bound: bool,
}

pub(super) fn find_name(template: &Template, name: &str) -> Option<NameUse> {
    const BINDING: &[&str] = &["set", "for", "macro", "call", "with", "import", "from"];
    let mut found = NameUse { file: template.file, uses: Vec::new(), bound: false };
    for tag in &template.scan.tags {
        let binds = tag.keyword(&template.text).is_some_and(|keyword| BINDING.contains(&keyword));
        let word = |at: usize| tag.word(&template.text, at);
        for at in 0..tag.words.len() {
            if word(at) != Some(name) || (at > 0 && word(at - 1) == Some(".")) {
                continue;
            }
            // The name of an argument is no use of a variable.
            let is_argument = tag.keyword(&template.text) != Some("set") && word(at + 1) == Some("=");
            if binds && is_target(at, &word) {
                found.bound = true;
            } else if !is_argument {
                found.uses.push(tag.words[at].range.clone());
            }
        }
    }
    (found.bound || !found.uses.is_empty()).then_some(found)
}

/// Whether the word at an index of a binding tag is one that the tag binds.
fn is_target<'t>(at: usize, word: &impl Fn(usize) -> Option<&'t str>) -> bool {
    match word(0) {
        Some("set") => (1..at).all(|before| word(before) != Some("=")),
        Some("for") => (1..at).all(|before| word(before) != Some("in")),
        Some("with") => word(at + 1) == Some("="),
        Some("macro") => at == 1 || matches!(word(at - 1), Some("(" | ",")),
        Some("call") => (1..at).all(|before| word(before) != Some(")")) && word(1) == Some("("),
        _ => matches!(word(at - 1), Some("as" | "import" | ",")),
    }
}
