//! Documents that are broken, or cut off: what is understood of them, and that their text is not lost.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::common::root;
use umbragraph::low_level::document::{self, Kind, Parsed, Value};
use umbragraph::low_level::model::{DeclarationKind, Model};
use umbragraph::low_level::source::Sources;

/// All documents below `pipelines/`, by their paths.
fn pipelines() -> Vec<(PathBuf, String)> {
    fn files(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
            match entry.path() {
                path if path.is_dir() => files(&path, found),
                path if path.extension().is_some_and(|kind| kind == "json") => found.push(path),
                _ => {}
            }
        }
    }
    let mut found = Vec::new();
    files(&root().join("pipelines"), &mut found);
    found.sort();
    found.into_iter().map(|path| (path.clone(), std::fs::read_to_string(path).unwrap())).collect()
}

fn parse(text: &str) -> Parsed {
    let mut sources = Sources::new();
    let file = sources.add("t.json", text);
    document::parse(&sources, file)
}

/// Prints the leaves of a tree, and what stands between them, up to its end. Returns the end of the last leaf.
fn print(text: &str, value: &Value, from: usize, out: &mut String, gaps: &mut Vec<String>) -> usize {
    let leaf = |range: std::ops::Range<usize>, from: usize, out: &mut String, gaps: &mut Vec<String>| {
        assert!(from <= range.start, "{range:?} begins before {from}");
        gaps.push(text[from..range.start].to_owned());
        out.push_str(&text[from..range.end]);
        range.end
    };
    match &value.kind {
        Kind::Array(elements) => elements.iter().fold(from, |from, one| print(text, one, from, out, gaps)),
        Kind::Object(entries) => entries.iter().fold(from, |from, entry| {
            let from = leaf(entry.key_span.range(), from, out, gaps);
            print(text, &entry.value, from, out, gaps)
        }),
        _ => leaf(value.span.range(), from, out, gaps),
    }
}

/// Whether there is nothing but space, comments and punctuation.
fn is_trivia(gap: &str) -> bool {
    let mut rest = gap.trim_start_matches(|c: char| c.is_whitespace() || "{}[],:".contains(c));
    while let Some(end) = [("//", "\n"), ("/*", "*/")].into_iter().find_map(|(begin, end)| {
        Some(rest.strip_prefix(begin)?.split_once(end).map_or("", |(_, behind)| behind))
    }) {
        rest = end.trim_start_matches(|c: char| c.is_whitespace() || "{}[],:".contains(c));
    }
    rest.is_empty()
}

#[test]
fn documents_print_back_byte_for_byte() {
    for (path, text) in pipelines() {
        let parsed = parse(&text);
        assert!(parsed.holes.is_empty() && parsed.diagnostics.is_empty(), "{}", path.display());
        let (mut out, mut gaps) = (String::new(), Vec::new());
        let end = print(&text, &parsed.document.root, 0, &mut out, &mut gaps);
        gaps.push(text[end..].to_owned());
        out.push_str(&text[end..]);
        assert_eq!(out, text, "{}", path.display());
        let odd: Vec<&String> = gaps.iter().filter(|gap| !is_trivia(gap)).collect();
        assert!(odd.is_empty(), "{}: {odd:?}", path.display());
    }
}

/// The keys of a tree, with the way to each, and where each ends.
fn keys(value: &Value, way: &str, found: &mut Vec<(String, u32)>) {
    for (at, element) in value.elements().unwrap_or_default().iter().enumerate() {
        keys(element, &format!("{way}/{at}"), found);
    }
    for entry in value.entries().unwrap_or_default() {
        let way = format!("{way}/{}", entry.key);
        keys(&entry.value, &way, found);
        found.push((way, entry.key_span.end));
    }
}

#[test]
fn a_document_that_is_cut_off_keeps_what_stands_before_the_cut() {
    for (path, text) in pipelines() {
        let whole = parse(&text);
        let mut all = Vec::new();
        keys(&whole.document.root, "", &mut all);
        for cut in (1..=20).map(|part| text.len() * part / 21).filter(|at| text.is_char_boundary(*at)) {
            let what = format!("{} cut at {cut}", path.display());
            let parsed = parse(&text[..cut]);
            assert!(!parsed.holes.is_empty(), "{what}");
            assert_eq!(parsed.diagnostics.len(), 1, "{what}");
            let (mut out, mut gaps) = (String::new(), Vec::new());
            let end = print(&text, &parsed.document.root, 0, &mut out, &mut gaps);
            assert_eq!(out, text[..end], "{what}");
            let mut found = Vec::new();
            keys(&parsed.document.root, "", &mut found);
            // The last key may be cut, too.
            let before: Vec<_> = all.iter().filter(|(_, end)| *end as usize <= cut).collect();
            assert!(before.iter().all(|key| found.contains(key)), "{what}: {found:?}");
            assert!(found.len() <= before.len() + 1, "{what}: {found:?}");
        }
    }
}

/// A use of a name: the line and the column where it stands, and what it means.
type Known = (String, usize, DeclarationKind, String);

/// The uses of names in a text, but those that touch lines that are not wanted, or lead there.
fn uses(text: &str, wanted: &dyn Fn(usize, &str) -> bool) -> BTreeSet<Known> {
    let document = parse(text).document;
    let model = Model::new(&document);
    let line_at = |at: usize| {
        let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
        (start, text[start..].lines().next().unwrap_or_default())
    };
    let is_wanted = |at: usize| wanted(at, line_at(at).1);
    // The keys that lead to a declaration, with its own.
    let is_whole = |id| {
        let mut around = &document.root;
        model.declaration(id).pointer.split('/').skip(1).all(|key| {
            let Some(entry) = around.entry(&key.replace("~1", "/")) else { return true };
            around = &entry.value;
            is_wanted(entry.key_span.end as usize)
        })
    };
    let of = |id| {
        let declared = model.declaration(id);
        let found = model.uses_of(id).filter(|one| is_wanted(one.place.end as usize) && is_whole(one.within));
        let found = found.map(|one| one.place.start as usize).collect::<Vec<_>>();
        let is_declared = declared.kind == DeclarationKind::Data || is_whole(id);
        found.into_iter().filter(move |_| is_declared).map(|at| {
            let (start, line) = line_at(at);
            (line.to_owned(), at - start, declared.kind, declared.name.clone())
        })
    };
    model.declarations().flat_map(|(id, _)| of(id)).collect()
}

#[test]
fn names_before_a_cut_are_resolved() {
    let mut number = 0;
    for (path, text) in pipelines() {
        for cut in (1..=20).map(|part| text.len() * part / 21).filter(|at| text.is_char_boundary(*at)) {
            // The last line is the broken part.
            let before = text[..cut].rfind('\n').unwrap_or_default();
            let whole = uses(&text, &|at, _| at <= before);
            let found = uses(&text[..cut], &|at, _| at <= before);
            let lost: Vec<_> = whole.difference(&found).collect();
            assert!(lost.is_empty(), "{} cut at {cut}: {lost:?}", path.display());
            number += whole.len();
        }
    }
    assert!(number > 3_000, "{number} names");
}

#[test]
fn names_outside_of_what_is_broken_are_resolved() {
    let folder = root().join("tests/broken");
    let base = std::fs::read_to_string(folder.join("chain.json")).unwrap();
    let cases = std::fs::read_to_string(folder.join("cases.txt")).unwrap();
    let mut number = 0;
    for case in cases.split("\n== ").skip(1) {
        let mut text = base.clone();
        let lines: Vec<&str> = case.lines().collect();
        for pair in lines.windows(2) {
            if let (Some(old), Some(new)) = (pair[0].strip_prefix("- "), pair[1].strip_prefix("+ ")) {
                text = text.replacen(old, new, 1);
            }
        }
        let lines: BTreeSet<&str> = text.lines().collect();
        let whole = uses(&base, &|_, line| lines.contains(line));
        let lost: Vec<_> = whole.difference(&uses(&text, &|_, _| true)).cloned().collect();
        assert!(lost.is_empty(), "{}: {lost:?}", case.lines().next().unwrap_or_default());
        number += whole.len();
    }
    assert!(number > 3_000, "{number} names");
}
