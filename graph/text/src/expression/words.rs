//! Words that enumerations are compared with.
//!
//! `mode == 'tow'` is a sound expression, and false for ever where the words of `mode` are `one` and `two`. So the
//! texts that are written beside `==` and `!=` are looked up among the words of the name on the other side, wherever
//! they stand in an expression: also in what is not evaluated this time.
//!
//! Limits: texts that come out of other names are not looked at, since two enumerations may share some words only.

use super::{
    BinaryOperator, ErrorKind, Expression, ExpressionError, ExpressionKind, Scope, UnknownName, Value,
};
use crate::diagnostic::list_of;

/// Returns an error for the first string literal that is compared with an enumeration but is not one of the
/// enumeration's words, or for a word without its quotes; `None` if there is neither. The expression must be as written: names replaced by their values
/// would be mistaken for literals.
pub fn unknown_word(expression: &Expression, scope: &dyn Scope) -> Option<ExpressionError> {
    let own = match &expression.kind {
        ExpressionKind::Binary(BinaryOperator::Equal | BinaryOperator::NotEqual, a, b) => {
            compared(a, b, scope).or_else(|| compared(b, a, scope))
        }
        _ => None,
    };
    own.or_else(|| expression.parts().find_map(|part| unknown_word(part, scope)))
}

fn compared(named: &Expression, with: &Expression, scope: &dyn Scope) -> Option<ExpressionError> {
    let ExpressionKind::Name(name) = &named.kind else { return None };
    let words = scope.words(name)?;
    match &with.kind {
        ExpressionKind::Literal(Value::Text(word)) if !words.contains(word) => Some(ExpressionError {
            // Without its quotes.
            range: with.range.start + 1..with.range.end.saturating_sub(1),
            kind: ErrorKind::UnknownWord,
            message: format!("\"{name}\" is never \"{word}\""),
            help: Some(format!("it is one of {}", list_of(words))),
            unknown: Some(Box::new(UnknownName {
                name: word.clone(),
                known: words.to_vec(),
                is_complete: true,
            })),
        }),
        ExpressionKind::Name(word)
            if words.contains(word) && scope.lookup(word).is_none() && !scope.is_broken(word) =>
        {
            let message = format!("there is no \"{word}\"");
            let help = format!("a word of \"{name}\" stands in single quotes: '{word}'");
            let error = ExpressionError::new(ErrorKind::UnknownName, with.range.clone(), message);
            Some(ExpressionError { help: Some(help), ..error })
        }
        ExpressionKind::Conditional(_, yes, no) => {
            compared(named, yes, scope).or_else(|| compared(named, no, scope))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::parse;

    struct Modes(Vec<String>);

    impl Scope for Modes {
        fn lookup(&self, name: &str) -> Option<Value> {
            (name == "mode").then(|| Value::Text("one".to_owned()))
        }
        fn names(&self) -> Vec<String> {
            vec!["mode".to_owned()]
        }
        fn words(&self, name: &str) -> Option<&[String]> {
            (name == "mode").then_some(self.0.as_slice())
        }
    }

    fn found(text: &str) -> Option<&str> {
        let scope = Modes(vec!["one".to_owned(), "two".to_owned()]);
        let error = unknown_word(&parse(text).unwrap(), &scope)?;
        Some(&text[error.range])
    }

    #[test]
    fn texts_that_are_no_words_are_found_wherever_they_stand() {
        let wrong = [
            "mode == 'tow'",
            "'tow' == mode",
            "mode != 'tow'",
            "false && mode == 'tow'",
            "mode == 'one' || mode == 'tow'",
            "!(mode == 'tow') ? 1 : 2",
            "max(1, [mode == 'tow' ? 1 : 2][0])",
            "mode == (mode == 'one' ? 'two' : 'tow')",
        ];
        for text in wrong {
            assert_eq!(found(text), Some("tow"), "{text}");
        }
        assert_eq!(found("mode == two"), Some("two"));
        for text in ["mode == 'two'", "'one' != mode", "other == 'tow'", "mode == other", "mode == 2"] {
            assert_eq!(found(text), None, "{text}");
        }
    }
}
