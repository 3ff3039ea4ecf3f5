//! Texts that a terminal shows as they are.
//!
//! Names and excerpts come from files that anybody may have written. A control character in them would be a command to
//! the terminal (ECMA-48: colours, titles, a cursor that moves over what was printed before), and a bidirectional one
//! (Unicode Standard Annex 9) would show the rest of a line in another order than it has: "Trojan Source", Boucher and
//! Anderson, 2021. Here each becomes the escape sequence by which Rust or JSON writes it.
//!
//! Limits: letters that look like others stay as they are.

use std::borrow::Cow;

/// Escapes control and bidirectional characters as Rust does, such as `\u{1b}`, so that a terminal does not interpret
/// them. Line feeds and tabs stay; a carriage return before a line feed is removed.
pub fn visible(text: &str) -> Cow<'_, str> {
    written(text, |character| format!("\\u{{{:x}}}", u32::from(character)))
}

/// Escapes control and bidirectional characters in JSON source as JSON does, such as `\u001b`. The JSON values stay the
/// same.
pub fn visible_json(text: &str) -> Cow<'_, str> {
    // All of them are in the basic plane.
    written(text, |character| format!("\\u{:04x}", u32::from(character)))
}

fn written(text: &str, write: impl Fn(char) -> String) -> Cow<'_, str> {
    if !text.contains(is_command) {
        return text.into();
    }
    let mut result = String::with_capacity(text.len() + 16);
    let mut rest = text.chars().peekable();
    while let Some(character) = rest.next() {
        match character {
            '\r' if rest.peek() == Some(&'\n') => {}
            _ if is_command(character) => result.push_str(&write(character)),
            _ => result.push(character),
        }
    }
    result.into()
}

/// Returns `true` if a character is a control character other than a line feed or tab, or changes the direction of
/// text.
fn is_command(character: char) -> bool {
    let is_bidirectional = matches!(
        character,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    );
    is_bidirectional || character.is_control() && !matches!(character, '\n' | '\t')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_commands_a_terminal_is_written_out() {
        assert_eq!(visible("a\x1b[31mb\u{9b}c\x7f\r\n\td\re"), "a\\u{1b}[31mb\\u{9b}c\\u{7f}\n\td\\u{d}e");
        assert_eq!(visible("\u{202e}\u{2066}\u{200f}é→"), "\\u{202e}\\u{2066}\\u{200f}é→");
        assert!(matches!(visible("plain\ttext\n"), Cow::Borrowed(_)));
        let value = serde_json::json!({ "na\u{202e}me": "\x1b\u{85}\n" });
        let text = serde_json::to_string_pretty(&value).unwrap();
        let shown = visible_json(&text);
        assert!(!shown.contains(is_command));
        assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).unwrap(), value);
    }
}
