//! Differences between the shader variants of a pass: the axes and constants that changed, not whole lists of axes.
//!
//! A variant in words is `TEMPLATE [AXIS=VALUE, …] HASH CONSTANT=VALUE …`. Each new variant is compared with the old
//! one of the same template that differs least from it. Variants with the same changes share a line.
//!
//! Limits: variants without a counterpart are printed whole.

use std::collections::{BTreeMap, BTreeSet};

use umbragraph_pipeline::diagnostic::counted;

/// A variant in words, taken apart.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Variant<'a> {
    template: &'a str,
    hash: &'a str,
    /// The values of axes and of constants, by name.
    values: BTreeMap<&'a str, &'a str>,
}

impl<'a> Variant<'a> {
    /// Takes the words of a variant apart; `None` if they have another form.
    fn parse(words: &'a str) -> Option<Self> {
        let (template, rest) = words.split_once(" [")?;
        let (axes, rest) = rest.split_once("] ")?;
        let mut rest = rest.split(' ');
        let hash = rest.next()?;
        let values = axes.split(", ").filter(|axis| !axis.is_empty()).chain(rest);
        let values = values.map(|value| value.split_once('=')).collect::<Option<_>>()?;
        Some(Self { template, hash, values })
    }

    /// Returns the changes since an older variant, in words; empty if only the generated text differs.
    fn changes_since(&self, old: &Self) -> Vec<String> {
        let names: BTreeSet<&str> = old.values.keys().chain(self.values.keys()).copied().collect();
        let change = |name: &str| match (old.values.get(name), self.values.get(name)) {
            (Some(old), Some(new)) if old != new => Some(format!("{name} {old} → {new}")),
            (None, Some(new)) => Some(format!("{name} none → {new}")),
            (Some(old), None) => Some(format!("{name} {old} → none")),
            _ => None,
        };
        names.into_iter().filter_map(change).collect()
    }
}

/// Adds lines about the variants of a pass that one plan has and the other lacks.
pub(super) fn compare(pass: &str, old: &[String], new: &[String], lines: &mut Vec<String>) {
    let [old, new] = [old, new].map(|words| words.iter().collect::<BTreeSet<_>>());
    let added = &new - &old;
    let mut gone: BTreeMap<&String, Option<Variant<'_>>> =
        (&old - &new).into_iter().map(|words| (words, Variant::parse(words))).collect();
    let mut unpaired = Vec::new();
    // The changes of each template, and the number of variants that have them.
    let mut changed: BTreeMap<(String, Vec<String>), usize> = BTreeMap::new();
    for words in added {
        let variant = Variant::parse(words);
        let nearest = variant.as_ref().and_then(|variant| {
            let olds = gone.iter().filter_map(|(words, old)| Some((*words, old.as_ref()?)));
            let olds = olds.filter(|(_, old)| old.template == variant.template);
            olds.map(|(words, old)| (variant.changes_since(old), words))
                .min_by_key(|(changes, _)| changes.len())
        });
        match (variant, nearest) {
            (Some(variant), Some((changes, old))) => {
                gone.remove(old);
                *changed.entry((variant.template.to_owned(), changes)).or_default() += 1;
            }
            _ => unpaired.push(words),
        }
    }
    for ((template, changes), number) in changed {
        let (what, number) = (changes.join(", "), counted(number, "variant"));
        lines.push(match what.is_empty() {
            true => format!("the pass {pass} has another text of {template} ({number})"),
            false => format!("the pass {pass} has {template} with {what} ({number})"),
        });
    }
    for words in unpaired {
        lines.push(format!("the pass {pass} has the variant {words} now"));
    }
    for words in gone.into_keys() {
        lines.push(format!("the pass {pass} has the variant {words} no longer"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compared(old: &[&str], new: &[&str]) -> Vec<String> {
        let owned = |list: &[&str]| list.iter().map(|one| (*one).to_owned()).collect::<Vec<_>>();
        let mut lines = Vec::new();
        compare("shade", &owned(old), &owned(new), &mut lines);
        lines
    }

    #[test]
    fn only_the_axes_that_changed_are_named() {
        let old = [
            "lit.wgsl [a=1, filter=hard, pbr=false] 11111111 taps=24",
            "lit.wgsl [a=1, filter=hard, pbr=true] 22222222 taps=24",
        ];
        let new = [
            "lit.wgsl [a=1, filter=pcss, pbr=false] 33333333 taps=64",
            "lit.wgsl [a=1, filter=pcss, pbr=true] 44444444 taps=64",
        ];
        let line = "the pass shade has lit.wgsl with filter hard → pcss, taps 24 → 64 (2 variants)";
        assert_eq!(compared(&old, &new), [line]);
        assert_eq!(compared(&old, &old), [""; 0]);
        // Of several old variants the nearest one is compared.
        assert_eq!(
            compared(&old, &[old[0], "lit.wgsl [a=1, b=2, pbr=true] 55555555 taps=24"]),
            ["the pass shade has lit.wgsl with b none → 2, filter hard → none (1 variant)"]
        );
    }

    #[test]
    fn a_variant_without_a_counterpart_is_printed_whole() {
        let found = compared(&["x.wgsl [] 11111111"], &["x.wgsl [] 22222222", "y.wgsl [] 33333333"]);
        assert_eq!(
            found,
            [
                "the pass shade has another text of x.wgsl (1 variant)",
                "the pass shade has the variant y.wgsl [] 33333333 now"
            ]
        );
        assert_eq!(compared(&["odd"], &[]), ["the pass shade has the variant odd no longer"]);
    }
}
