//! Documents that are no JSON, or cut off: what is understood of them, and that their text is not lost.

mod common;

use std::path::{Path, PathBuf};

use common::root;
use umbragraph::document::{self, Kind, Parsed, Value};
use umbragraph::source::Sources;

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
