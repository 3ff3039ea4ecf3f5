//! Bindings of the library's templates that give way to an author's.
//!
//! An author's template includes or extends one of the library, and declares bindings of its own beside those that come
//! with it. Where both take one number of a group, the library's declaration gets another one: slots are known by their
//! names, so nothing else changes. The new number follows from the old one alone ([`FIRST`] and so many), so that all
//! variants of a template agree on it as long as they agree on what the author declares.
//!
//! Groups 2 and 3 belong to the host's meshes, and keep their numbers.
//!
//! Limits: declarations are found by their attributes, `@group(1) @binding(3)` in either order, with decimal numbers.

use std::collections::BTreeSet;
use std::ops::Range;

use super::templates::TemplateSet;
use crate::written::text_map::{Origin, Segment, Source, TextMap};
use umbragraph_text::source::{FileId, Span};

/// The first binding number that a moved library binding can get; WebGPU guarantees only numbers below 1000.
const FIRST: u32 = 500;
/// The index of the first bind group that is reserved for the host's meshes. Library bindings in reserved groups are
/// never moved.
const HOST_GROUP: u32 = 2;

/// A binding declaration in generated WGSL: group, binding number, byte range of the number, and template file.
struct Declaration {
    group: u32,
    number: u32,
    range: Range<usize>,
    file: FileId,
}

/// Gives new binding numbers to bindings of library templates, below the host's group, that collide with bindings of
/// other templates.
pub(crate) fn move_aside(set: &TemplateSet, source: Source) -> Source {
    if !set.has_own_templates() {
        return source;
    }
    let declarations = declarations(&source.wgsl, &source.map);
    let numbers = |one: &Declaration| (one.group, one.number);
    let all: BTreeSet<(u32, u32)> = declarations.iter().map(numbers).collect();
    let own = declarations.iter().filter(|one| !set.is_of_library(one.file));
    let own: BTreeSet<(u32, u32)> = own.map(numbers).collect();
    let moved = declarations.iter().filter(|one| {
        set.is_of_library(one.file) && one.group < HOST_GROUP && own.contains(&(one.group, one.number))
    });
    let moved: Vec<(&Range<usize>, String)> = moved
        .map(|one| {
            let free = (FIRST + one.number..).find(|number| !all.contains(&(one.group, *number)));
            (&one.range, free.unwrap_or(one.number).to_string())
        })
        .collect();
    replaced(&source, &moved)
}

fn declarations(text: &str, map: &TextMap) -> Vec<Declaration> {
    let mut found = Vec::new();
    let mut rest = 0;
    while let Some(at) = text[rest..].find("@binding").map(|at| rest + at) {
        rest = at + "@binding".len();
        let Some((number, range)) = number(text, rest) else { continue };
        let group = group_before(text, at).or_else(|| group_behind(text, range.end));
        let file = match map.origin(range.start) {
            Some(Origin::Literal(file, _)) => file,
            Some(Origin::Tag(span)) => span.file,
            None => continue,
        };
        found.extend(group.map(|group| Declaration { group, number, range, file }));
    }
    found
}

/// Parses a number in parentheses at byte offset `at`. Returns the number and its byte range; `None` if there is none.
fn number(text: &str, at: usize) -> Option<(u32, Range<usize>)> {
    let behind = text.get(at..)?.trim_start().strip_prefix('(')?.trim_start();
    let start = text.len() - behind.len();
    let length = behind.bytes().take_while(u8::is_ascii_digit).count();
    let is_closed = behind[length..].trim_start_matches('u').trim_start().starts_with(')');
    is_closed.then_some((behind[..length].parse().ok()?, start..start + length))
}

fn group_before(text: &str, at: usize) -> Option<u32> {
    let before = text[..at].trim_end();
    let start = before.strip_suffix(')')?.rfind("@group")?;
    let (group, range) = number(text, start + "@group".len())?;
    let between = before[range.end..].trim_start_matches('u').trim();
    (between == ")").then_some(group)
}

fn group_behind(text: &str, at: usize) -> Option<u32> {
    let behind = text[at..].trim_start_matches('u').trim_start().strip_prefix(')')?.trim_start();
    behind
        .starts_with("@group")
        .then(|| number(text, text.len() - behind.len() + "@group".len()))?
        .map(|one| one.0)
}

/// Replaces the text of byte ranges, given in ascending order, in generated WGSL, and updates its map.
fn replaced(source: &Source, places: &[(&Range<usize>, String)]) -> Source {
    let Source { wgsl, map } = source;
    let (mut text, mut segments) = (String::with_capacity(wgsl.len()), Vec::new());
    let (mut at, end) = (0, wgsl.len()..wgsl.len());
    let places = places.iter().map(|(range, number)| (*range, number.as_str()));
    for (range, number) in places.chain([(&end, "")]) {
        let kept = map.part(at..range.start).map(|(piece, origin)| (&wgsl[piece], origin));
        let written = map.part(range.clone()).next().map(|(piece, origin)| match origin {
            Some(Origin::Literal(file, start)) => {
                let start = start as usize;
                (number, Some(Origin::Tag(Span::new(file, start..start + piece.len()))))
            }
            other => (number, other),
        });
        for (piece, origin) in kept.chain(written) {
            segments.push(Segment { start: text.len() as u32, origin });
            text.push_str(piece);
        }
        at = range.end;
    }
    let length = text.len() as u32;
    Source { wgsl: text, map: TextMap { segments, length } }
}
