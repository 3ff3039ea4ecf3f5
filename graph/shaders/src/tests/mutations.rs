//! Random corruptions of the project's templates: every one is found, in the file that was corrupted.
//!
//! A corruption deletes a bracket or a semicolon, or misspells an identifier, in literal text that some variant
//! contains. Some change nothing that a compiler could see (a field that is used nowhere else, a comma at the end of a
//! list); what counts is whether naga itself rejects the text. Most corruptions are looked for in one variant that
//! contains the spot; some of each template in everything that the template can express, so that causes are put
//! together as well.

use std::collections::BTreeMap;
use std::sync::Arc;

use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use super::Fixture;
use crate::module::wgsl;
use crate::permutations::{Options, Request, check};
use crate::rendering::render;
use crate::{AxisKind, AxisValues, TargetProfile};
use umbragraph_text::diagnostic::{Diagnostic, Place};

/// Creates a fixture of the project's templates in which the template `name` is replaced by `text`.
fn corrupted(name: &str, text: &str) -> Fixture {
    let files: Vec<(&str, &str)> = umbragraph_shaders_templates::FILES
        .iter()
        .map(|(other, original)| (*other, if *other == name { text } else { original }))
        .collect();
    Fixture::new(&files)
}

/// A request for every variant of a template, with integers fixed to their defaults. The project's templates have no
/// conditions on numbers, and all combinations would take minutes per corruption.
fn request(fixture: &Fixture, root: &str, profiles: &[TargetProfile]) -> Request {
    let axes = fixture.set.axes(root).into_iter().flat_map(crate::Axes::iter);
    let integers = axes.filter(|axis| matches!(axis.kind, AxisKind::Integer { .. }));
    let allowed = integers.map(|axis| (axis.name.clone(), vec![axis.default.clone()])).collect();
    Request { allowed, ..Request::all(root, profiles) }
}

/// A piece of literal template text that some variant contains.
struct Piece {
    file: String,
    range: std::ops::Range<usize>,
    axes: Arc<AxisValues>,
}

fn reachable(fixture: &Fixture, root: &str) -> Vec<Piece> {
    let outcome = check(&fixture.set, &[request(fixture, root, &[])], &Options::default());
    let mut found = BTreeMap::new();
    for variant in &outcome.templates[0].variants {
        let (source, _) = render::render(&fixture.set, root, &variant.axes.values()).unwrap();
        for (_, span) in source.map.pieces() {
            let Some(span) = span else { continue };
            if !fixture.sources.text(span).starts_with("{{") {
                found
                    .entry((span.file, span.start, span.end))
                    .or_insert_with(|| Arc::new(variant.axes.values()));
            }
        }
    }
    let piece = |((file, start, end), axes)| Piece {
        file: fixture.sources.get(file).unwrap().name().to_owned(),
        range: start as usize..end as usize,
        axes,
    };
    found.into_iter().map(piece).collect()
}

/// Corrupts a random place in a byte range of a template; `None` if the chosen place cannot be corrupted.
fn corrupt(text: &str, range: std::ops::Range<usize>, random: &mut Random) -> Option<String> {
    let at = range.start + random.below(range.len());
    let piece = text.get(range.start..)?;
    let line_start = text[..at.min(text.len())].rfind('\n').map_or(0, |at| at + 1);
    if !piece.is_char_boundary(at - range.start) || text[line_start..at].contains("//") {
        return None;
    }
    let rest = &text[at..range.end];
    let first = rest.chars().next()?;
    if "(){}[];".contains(first) {
        return Some(format!("{}{}", &text[..at], &text[at + 1..]));
    }
    let before = text[..at].chars().next_back();
    let word = |each: char| each.is_ascii_alphanumeric() || each == '_';
    if !first.is_ascii_alphabetic() || before.is_some_and(word) {
        return None;
    }
    let length = rest.chars().take_while(|each| word(*each)).count();
    (length > 2 && at + length < range.end)
        .then(|| format!("{}q{}", &text[..at + length], &text[at + length..]))
}

fn in_file(fixture: &Fixture, diagnostic: &Diagnostic, name: &str) -> bool {
    let file = fixture.sources.find(name).unwrap();
    let places =
        [&diagnostic.place].into_iter().chain(diagnostic.related.iter().map(|related| &related.place));
    places.into_iter().any(|place| matches!(place, Place::Span(span) if span.file == file))
}

#[test]
fn random_corruptions_are_found_in_the_right_file() {
    let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ property::seed());
    let sound = Fixture::sound(umbragraph_shaders_templates::FILES);
    let profiles = [TargetProfile::webgpu()];
    let roots = super::roots(&sound.set);
    assert!(!roots.is_empty());
    let mut misplaced = Vec::new();
    for root in property::part(roots, 4) {
        let pieces = reachable(&sound, root);
        let mut made = 0;
        while made < 10 * property::times().min(10) {
            let Piece { file: name, range, axes } = &pieces[random.below(pieces.len())];
            let original = sound.sources.get(sound.sources.find(name).unwrap()).unwrap().text().clone();
            let Some(text) = corrupt(&original, range.clone(), &mut random) else { continue };
            let fixture = corrupted(name, &text);
            let one = Request::one(&fixture.set, root, axes, &profiles);
            let request = if made % 25 == 0 { request(&fixture, root, &profiles) } else { one };
            let outcome = check(&fixture.set, std::slice::from_ref(&request), &Options::default());
            let rejected = render::render(&fixture.set, root, axes).is_ok_and(|(source, _)| {
                wgsl::parse(&source.wgsl)
                    .and_then(|module| wgsl::validate(&module, profiles[0].capabilities))
                    .is_err()
            });
            if !rejected {
                continue;
            }
            made += 1;
            assert!(outcome.diagnostics.has_errors(), "not found in {name}:\n{text}");
            if !outcome.diagnostics.iter().any(|diagnostic| in_file(&fixture, diagnostic, name)) {
                misplaced.push(format!("{root}, {name}: {:?}", fixture.lines(&outcome.diagnostics)));
            }
        }
    }
    assert!(misplaced.is_empty(), "{}\n{}", misplaced.len(), misplaced.join("\n"));
}
