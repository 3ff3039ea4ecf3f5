//! Random edits of documents, as somebody at a keyboard makes them.

use std::path::PathBuf;

use crate::random::Random;

/// Returns the text after a random edit, which breaks the syntax half of the time.
#[must_use]
pub fn edited(text: &str, random: &mut Random) -> String {
    let at = |random: &mut Random| text.floor_char_boundary(random.below(text.len() + 1));
    let words = |quote: bool| -> Vec<(usize, usize)> {
        let pieces: Vec<usize> = text.match_indices('"').map(|(at, _)| at).collect();
        let pairs = pieces.chunks_exact(2).map(|pair| (pair[0], pair[1] + 1));
        if quote { pairs.collect() } else { Vec::new() }
    };
    let replaced = |from: usize, to: usize, new: &str| format!("{}{new}{}", &text[..from], &text[to..]);
    match random.below(8) {
        // Broken, mostly.
        0 => {
            let from = at(random);
            replaced(from, from, random.one_of(&["}", "{", "]", "[", ",", ":", "\"", "\u{1}", "//", "1e999"]))
        }
        1 => {
            let (a, b) = (at(random), at(random));
            replaced(a.min(b), text.floor_char_boundary(a.max(b).min(a.min(b) + 40)), "")
        }
        2 => text[..at(random)].to_owned(),
        3 => {
            let marks: Vec<usize> = text.match_indices([',', ':', '}', ']']).map(|(at, _)| at).collect();
            match marks.get(random.below(marks.len())) {
                Some(at) => replaced(*at, at + 1, ""),
                None => text.to_owned(),
            }
        }
        // Another word, number, comment, layout.
        4 => {
            let words = words(true);
            let (Some((from, to)), Some((other, end))) =
                (words.get(random.below(words.len())), words.get(random.below(words.len())))
            else {
                return text.to_owned();
            };
            replaced(*from, *to, &text[*other..*end])
        }
        5 => {
            let digits: Vec<usize> =
                text.char_indices().filter(|(_, one)| one.is_ascii_digit()).map(|(at, _)| at).collect();
            match digits.get(random.below(digits.len())) {
                Some(at) => replaced(*at, at + 1, &random.below(10).to_string()),
                None => text.to_owned(),
            }
        }
        6 => {
            let lines: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).collect();
            match lines.get(random.below(lines.len())) {
                Some(at) => {
                    replaced(*at, *at, random.one_of(&[" // a note", "\n\n", "  ", "\n/* two\nlines */"]))
                }
                None => text.to_owned(),
            }
        }
        _ => text.replace(": ", random.one_of(&[":", " : ", ":\n  "])),
    }
}

/// Returns the JSON files below a folder, sorted by path.
#[must_use]
pub fn documents(folder: impl Into<PathBuf>) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut waiting = vec![folder.into()];
    while let Some(folder) = waiting.pop() {
        let entries =
            std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        for path in entries.flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                waiting.push(path);
            } else if path.extension().is_some_and(|end| end == "json") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}
