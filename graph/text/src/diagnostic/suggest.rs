//! Suggestions for misspelt names: the help that proposes the closest one, and the fix that writes it.
//!
//! All diagnostics about a name that is none of those known take one way, [`Diagnostic::suggest`]: the closest known
//! name is the help; where no other is as close, and it is known where the name is written, putting it there is the
//! fix.
//!
//! Limits: names longer than 64 bytes are not compared; a known name that JSON would have to escape is help only.

use super::Diagnostic;
use crate::source::Span;

const MAX_NAME: usize = 64;
/// The beginning of help texts that suggest a name.
pub(crate) const DID_YOU_MEAN: &str = "did you mean";
/// The minimum length, in bytes, of an unknown name for which a longer known name with that prefix is suggested.
/// Shorter prefixes match too many names by chance.
const MIN_BEGUN: usize = 4;

impl Diagnostic {
    /// Returns `true` if the help text suggests a similar name ("did you mean …").
    pub fn has_suggestion(&self) -> bool {
        self.help.as_ref().is_some_and(|help| help.starts_with(DID_YOU_MEAN))
    }

    /// Adds a help text for an unknown `name`: the most similar name of `known`, or the result of `otherwise` if none
    /// is similar.
    ///
    /// `written` is the span of the name in the source, with or without quotes. A fix is added only if the span has the
    /// length of either form; computed or escaped names get none.
    #[must_use]
    pub fn suggest<'a>(
        self,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
        written: Option<Span>,
        otherwise: impl FnOnce(&[&'a str]) -> String,
    ) -> Self {
        self.suggest_unless(name, known, written, |_| false, otherwise)
    }

    /// Adds a help text as [`Self::suggest`] does, but no fix for a name for which `taken` returns `true`. It is meant
    /// for keys of objects, which must be unique.
    #[must_use]
    pub fn suggest_unless<'a>(
        self,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
        written: Option<Span>,
        taken: impl Fn(&str) -> bool,
        otherwise: impl FnOnce(&[&'a str]) -> String,
    ) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        match Closest::of(name, &known) {
            Some(closest) => self.propose(name, &closest, written, taken(closest.name)),
            None => self.help(match begun(name, &known) {
                Some(suggested) => format!("is \"{suggested}\" meant?"),
                None => otherwise(&known),
            }),
        }
    }

    fn propose(self, name: &str, closest: &Closest<'_>, written: Option<Span>, is_taken: bool) -> Self {
        let suggested = closest.name;
        let diagnostic = self.help(format!("{DID_YOU_MEAN} \"{suggested}\"?"));
        let replacement = written.and_then(|span| match span.range().len().checked_sub(name.len())? {
            0 => Some((span, suggested.to_owned())),
            2 => Some((span, format!("\"{suggested}\""))),
            _ => None,
        });
        // A name with an escape would be another text in JSON.
        let is_plain = !suggested.contains(['"', '\\']) && !suggested.contains(char::is_control);
        match replacement {
            Some((span, text)) if is_plain && !is_taken && closest.is_certain => diagnostic.fix(span, text),
            _ => diagnostic,
        }
    }
}

/// Returns the known name that `name` is a prefix of, such as `rgba16float` for `rgba16f`; `None` if there is none or
/// more than one.
pub(crate) fn begun<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    if name.len() < MIN_BEGUN {
        return None;
    }
    let mut longer = known.iter().filter(|known| known.starts_with(name));
    longer.next().copied().filter(|_| longer.next().is_none())
}

/// Returns the candidate most similar to a misspelt `name`; `None` if none is similar enough.
///
/// The similarity is the Damerau–Levenshtein distance of the names in lower case. It may be at most a third of the
/// longer name's length in characters, or one edit. Ties go to the alphabetically first.
pub fn suggested_name<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    Closest::of(name, &candidates).map(|closest| closest.name)
}

/// Returns the candidate that is meant by a misspelt `name`, as [`suggested_name`] does; `None` if another one is as
/// similar, so that the name could be either.
pub fn name_meant<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    Closest::of(name, &candidates).filter(|closest| closest.is_certain).map(|closest| closest.name)
}

struct Closest<'a> {
    name: &'a str,
    /// Whether no other candidate has the same distance.
    is_certain: bool,
}

impl<'a> Closest<'a> {
    fn of(name: &str, candidates: &[&'a str]) -> Option<Self> {
        let lower = name.to_lowercase();
        let (bytes, characters) = (name.len(), name.chars().count());
        let mut close: Vec<(usize, &str)> = Vec::new();
        for candidate in candidates.iter().copied() {
            // Longer names are not typed by people, and the distance costs the product of the lengths.
            if bytes.max(candidate.len()) > MAX_NAME || candidate.len().abs_diff(bytes) > MAX_NAME / 3 {
                continue;
            }
            let distance = strsim::damerau_levenshtein(&lower, &candidate.to_lowercase());
            if distance <= (characters.max(candidate.chars().count()) / 3).max(1) {
                close.push((distance, candidate));
            }
        }
        close.sort_unstable();
        close.dedup();
        // "shadow_casters" means "casters" sooner than "static_casters".
        let is_part = |one: &&&str| {
            one.len() >= MIN_BEGUN && lower.strip_suffix(**one).is_some_and(|before| before.ends_with('_'))
        };
        let part = candidates
            .iter()
            .find(is_part)
            .filter(|_| close.first().is_none_or(|(distance, _)| *distance > 2));
        if let Some(name) = part {
            return Some(Self { name, is_certain: false });
        }
        let (distance, name) = *close.first()?;
        Some(Self { name, is_certain: close.get(1).is_none_or(|(second, _)| *second != distance) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::codes;
    use crate::source::Sources;

    #[test]
    fn what_is_as_close_as_another_is_no_fix() {
        assert_eq!(name_meant("color_c", ["color_a", "color_b"]), None);
        assert_eq!(name_meant("colr", ["color", "colder"]), Some("color"));
    }

    #[test]
    fn what_begins_one_name_alone_is_that_name() {
        let names = ["rgba16float", "rgba16snorm", "rgba32float", "vignette.wgsl.jinja"];
        assert_eq!(begun("rgba16f", &names), Some("rgba16float"));
        assert_eq!(begun("vignette", &names), Some("vignette.wgsl.jinja"));
        assert_eq!(begun("rgba16", &names), None);
        assert_eq!(begun("vig", &names), None);
    }

    #[test]
    fn a_close_name_is_proposed_and_a_far_one_is_not() {
        let names = ["format", "layers", "size"];
        assert_eq!(suggested_name("fromat", names), Some("format"));
        assert_eq!(suggested_name("Size", names), Some("size"));
        assert_eq!(suggested_name("colour", names), None);
    }

    #[test]
    fn only_the_one_closest_name_is_a_fix_at_its_place() {
        let file = Sources::new().add("a", "\"frist@show\" first {frist}");
        let names = ["first", "second"];
        let diagnostic = |range: std::ops::Range<usize>, names: &[&'static str], taken: &str| {
            let diagnostic = Diagnostic::error(codes::UNKNOWN_KEY, Span::new(file, range.clone()), "x");
            let written = Some(Span::new(file, range));
            let names = names.iter().copied();
            let diagnostic =
                diagnostic.suggest_unless("frist", names, written, |one| one == taken, |_| String::new());
            assert_eq!(diagnostic.help.as_deref(), Some("did you mean \"first\"?"));
            diagnostic.fix.map(|fix| fix.edits[0].replacement.clone())
        };
        assert_eq!(diagnostic(1..6, &names, "").as_deref(), Some("first"));
        assert_eq!(diagnostic(19..26, &names, "").as_deref(), Some("\"first\""), "as long as with quotes");
        assert_eq!(diagnostic(0..12, &names, ""), None, "more than the name");
        assert_eq!(diagnostic(1..6, &names, "first"), None, "it is there already");
        assert_eq!(diagnostic(1..6, &["first", "frost"], ""), None, "two are as close");
    }
}
