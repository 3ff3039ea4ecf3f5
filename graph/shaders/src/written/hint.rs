//! Better places for two kinds of mistakes that naga reports far away.
//!
//! A bracket that is not closed is noticed where the next declaration begins, often in another template; a name that is
//! misspelt where it is declared is noticed where it is used. Only after a parse error, so at no cost otherwise, this
//! looks for the bracket itself and for the name that was meant.
//!
//! Limits: brackets are matched lexically, and `fn` or `struct` inside of brackets is taken for the sign that one is
//! missing before; a name counts as meant if it is close in spelling and occurs in the same text.

use std::collections::BTreeSet;
use std::ops::Range;

use super::complexity;
use super::foreign;
use super::rejection::Rejection;
use umbragraph_text::diagnostic::{name_meant, suggested_name};

/// Improves a rejection of WGSL: moves it to the unmatched bracket that caused it, or suggests the intended name.
pub(crate) fn improve(text: &str, mut rejection: Rejection) -> Rejection {
    // Identifiers, keywords and brackets.
    let is_word = |range: &Range<usize>| {
        let first = text.as_bytes()[range.start];
        first.is_ascii_alphanumeric() || b"_()[]{}".contains(&first)
    };
    let words: Vec<Range<usize>> = complexity::words(text).filter(is_word).collect();
    if let Some((range, message)) = unmatched(text, &words) {
        if let Some(noticed) = rejection.range.replace(range) {
            rejection.labels.insert(0, (noticed, format!("noticed here: {}", rejection.message)));
        }
        rejection.message = message;
    } else if foreign::explain(text, &mut rejection, &words) {
        return rejection;
    } else if let Some(Suggested { name, range, replacement }) = suggested(text, &rejection, &words) {
        rejection.labels.extend(range.map(|range| (range, format!("\"{name}\" is here"))));
        rejection.help = Some(format!("did you mean \"{name}\"?"));
        rejection.replacement = replacement;
    } else if let Some(structs) = structs(text, &rejection, &words) {
        rejection.help = Some(format!("the structs here are {structs}"));
    }
    rejection
}

/// The names of all declared structures, joined by commas, if the rejection is about an unknown type name; otherwise
/// `None`.
fn structs(text: &str, rejection: &Rejection, words: &[Range<usize>]) -> Option<String> {
    let at = rejection.range.as_ref().filter(|_| rejection.message.starts_with("no definition in scope"))?;
    text.get(..at.start)?.trim_end().ends_with([':', '<', '>']).then_some(())?;
    let declared = words.windows(2).filter(|pair| &text[pair[0].clone()] == "struct");
    let names: Vec<&str> = declared.map(|pair| &text[pair[1].clone()]).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

fn unmatched(text: &str, words: &[Range<usize>]) -> Option<(Range<usize>, String)> {
    let mut open: Vec<&Range<usize>> = Vec::new();
    let never_closed =
        |range: &Range<usize>| (range.clone(), format!("this \"{}\" is never closed", &text[range.clone()]));
    for range in words {
        match &text[range.clone()] {
            "(" | "[" | "{" => open.push(range),
            close @ (")" | "]" | "}") => {
                let Some(last) = open.pop() else {
                    return Some((range.clone(), format!("this \"{close}\" closes nothing")));
                };
                if !matches!((&text[last.clone()], close), ("(", ")") | ("[", "]") | ("{", "}")) {
                    return Some(never_closed(last));
                }
            }
            // Declarations stand outside of all brackets.
            "fn" | "struct" => {
                if let Some(last) = open.first() {
                    return Some(never_closed(last));
                }
            }
            _ => {}
        }
    }
    open.first().map(|last| never_closed(last))
}

/// A name that is similar to an unknown one.
struct Suggested<'t> {
    name: &'t str,
    /// The byte range where the name first occurs; `None` for a function of WGSL that the text does not call.
    range: Option<Range<usize>>,
    /// The name, if it alone can be meant.
    replacement: Option<String>,
}

/// The name in the module, or the function of WGSL, that is most similar to the unknown name in naga's message. `None`
/// if no name is similar. A function is suggested for a call only.
fn suggested<'t>(text: &'t str, rejection: &Rejection, words: &[Range<usize>]) -> Option<Suggested<'t>> {
    const UNKNOWN: [&str; 3] = ["no definition in scope", "unknown type", "invalid field accessor"];
    let message = &rejection.message;
    if !UNKNOWN.iter().any(|start| message.starts_with(start)) {
        return None;
    }
    // Short names are close to everything.
    let name = message.split('`').nth(1).filter(|name| name.len() > 3)?;
    let is_called = |end: usize| text.get(end..).is_some_and(|rest| rest.trim_start().starts_with('('));
    let is_call = rejection.range.as_ref().is_some_and(|range| is_called(range.end));
    let is_name = |range: &&Range<usize>| {
        let word = &text[(*range).clone()];
        word != name
            && word.starts_with(|each: char| each.is_alphabetic() || each == '_')
            && (!is_call || is_called(range.end))
    };
    let written = words.iter().filter(is_name).map(|range| &text[range.clone()]);
    let functions = is_call.then(foreign::functions).into_iter().flatten().map(|name| -> &'t str { name });
    let names: BTreeSet<&'t str> = written.chain(functions).collect();
    let suggested = suggested_name(name, names.iter().copied())?;
    let is_it = |range: &Range<usize>| &text[range.clone()] == suggested;
    let range = words.iter().find(|range| is_it(range)).cloned();
    // A function can be called anywhere, another name where it was written before in the same function.
    let place = rejection.range.as_ref().filter(|place| text.get((*place).clone()) == Some(name));
    let is_seen = place.is_some_and(|place| {
        let before = words.iter().rev().skip_while(|range| range.start >= place.start);
        is_call || { before }.take_while(|range| &text[(*range).clone()] != "fn").any(is_it)
    });
    let is_member = message.starts_with("invalid field accessor");
    let is_sure = is_seen && !is_member && name_meant(name, names).is_some();
    Some(Suggested { name: suggested, range, replacement: is_sure.then(|| suggested.to_owned()) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codes;

    fn improved(text: &str, message: &str) -> Rejection {
        improve(
            text,
            Rejection {
                range: Some(0..1),
                ..Rejection::new(codes::WGSL_SYNTAX, message, naga::Span::UNDEFINED)
            },
        )
    }

    #[test]
    fn where_a_type_is_unknown_the_structs_are_named() {
        let text = "struct Covered { uv: vec2f }\nfn f(a: VertexOutput) {}";
        let at = text.find("VertexOutput").unwrap();
        let message = "no definition in scope for identifier: `VertexOutput`";
        let rejection = Rejection::new(codes::WGSL_SYNTAX, message, naga::Span::UNDEFINED);
        let rejection = improve(text, Rejection { range: Some(at..at + 12), ..rejection });
        assert_eq!(rejection.help.as_deref(), Some("the structs here are Covered"));
    }

    #[test]
    fn the_bracket_itself_is_found() {
        let place = |text: &str| improved(text, "expected").range.unwrap().start;
        assert_eq!(place("fn f() { if a { }\nfn g() {}"), 7, "the function that is not closed");
        assert_eq!(place("fn f() { let a = (1; }\nfn g() {}"), 17);
        assert_eq!(place("fn f() { }}\nfn g() {}"), 10);
        assert_eq!(place("fn f() { /* { */ } // {\n"), 0, "nothing is wrong with the brackets");
    }

    #[test]
    fn the_name_that_was_meant_is_shown() {
        let text = "fn sample_noise() {}\nfn f() { sample_noises(); }";
        let rejection = improved(text, "no definition in scope for identifier: `sample_noises`");
        assert_eq!(rejection.help.as_deref(), Some("did you mean \"sample_noise\"?"));
        assert_eq!(rejection.labels[0].0, 3..15);
    }
}
