//! Whether some variant of a template declares a binding, or a member of a binding's block.
//!
//! A pass names all that its variants bind, and one of them may have less than another. What none of them has is
//! misspelt. The variants are those that the given values allow, found as for their proof, and their declarations are
//! looked at only where the text has the name. Those that differ in one axis from the first come first, then those that
//! differ in two, and the search ends at the first that declares it, so a name that is right is found soon.
//!
//! Limits: a text that cannot be split into declarations is taken to declare every name in it, since its own diagnostic
//! comes first; and where there are more variants than [`super::explore`] takes, the others are taken to declare it.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::explore::Explorer;
use crate::axes::Space;
use crate::module::wgsl;
use crate::rendering::templates::TemplateSet;
use crate::written::complexity::words;
use crate::written::declarations::{self, Declaration, Kind};
use umbragraph_text::diagnostic::AxisValues;

/// Returns axis values of a variant that declares `binding` (and `member` in its block). `fixed` restricts the
/// variants. `None` if no variant declares it; empty values if the search was incomplete.
pub fn declares(
    templates: &TemplateSet,
    template: &str,
    fixed: &AxisValues,
    binding: &str,
    member: Option<&str>,
) -> Option<AxisValues> {
    let axes = templates.axes(template)?;
    let allowed: BTreeMap<_, _> =
        fixed.iter().map(|(name, value)| (name.clone(), vec![value.clone()])).collect();
    wgsl::with_stack(|| {
        let space = Arc::new(Space::new(axes, &allowed));
        let mut explorer = Explorer::new(templates, template, &space, false).nearest_first();
        while let Some(text) = explorer.next_text() {
            if text.contains(member.unwrap_or(binding)) && has(&text, binding, member) {
                let exploration = &explorer.exploration;
                let leaf = exploration.texts.last().and_then(|text| exploration.leaves.get(text.leaf));
                return Some(leaf.map(|leaf| leaf.decided.values()).unwrap_or_default());
            }
        }
        (!explorer.exploration.complete).then(AxisValues::new)
    })
}

/// Returns `true` if a WGSL module declares `binding`, with `member` in its block if given.
fn has(text: &str, binding: &str, member: Option<&str>) -> bool {
    let Some(ranges) = declarations::split(text) else { return true };
    let all: Vec<&str> = ranges.into_iter().map(|range| &text[range]).collect();
    // Only the last can be cut off.
    let braces = |last: &str, brace| last.bytes().filter(|byte| *byte == brace).count();
    if all.last().is_some_and(|last| braces(last, b'{') != braces(last, b'}')) {
        return true;
    }
    let named = |name: &str| {
        let mut all = all.iter().filter(|text| text.contains(name));
        all.find_map(|text| {
            let Declaration { kind, name: own, .. } = Declaration::new(text);
            (own.as_deref() == Some(name)).then_some((kind, *text))
        })
    };
    let Some((Kind::Variable, variable)) = named(binding).filter(|(_, text)| text.starts_with('@')) else {
        return false;
    };
    let Some(member) = member else { return true };
    let mut name = following(variable, ":");
    for _ in 0..=all.len() {
        let Some(declared) = name.and_then(named).map(|(_, text)| text) else { return false };
        match following(declared, "=") {
            Some(other) if declared.starts_with("alias") => name = Some(other),
            _ => {
                let tokens: Vec<&str> = words(declared).map(|range| &declared[range]).collect();
                return tokens.first() == Some(&"struct")
                    && tokens.windows(2).any(|two| two == [member, ":"]);
            }
        }
    }
    false
}

/// The token after the first occurrence of `sign` in a declaration.
fn following<'t>(declaration: &'t str, sign: &str) -> Option<&'t str> {
    let mut words = words(declaration).map(|range| &declaration[range]).skip_while(|word| *word != sign);
    words.nth(1)
}

#[cfg(test)]
mod tests {
    use super::has;

    #[test]
    fn bindings_and_members_are_told_from_other_names() {
        let text = "struct Light { color: vec3f, @size(16) far: f32 }\nalias Sun = Light;\n\
                    @group(0) @binding(0) var<uniform> sun: Sun;\nvar<private> near: f32;\n\
                    fn lit(strength: f32) -> f32 { let far_off: f32 = strength; return far_off; }\n";
        let found = |binding, member| has(text, binding, member);
        assert!(found("sun", None) && found("sun", Some("color")) && found("sun", Some("far")));
        assert!(!found("near", None) && !found("strength", None) && !found("lit", None));
        assert!(
            !found("sun", Some("vec3f")) && !found("sun", Some("far_off")) && !found("Light", Some("color"))
        );
        assert!(has(&text[..text.len() - 3], "anything", None), "a text that is cut off has every name");
        assert!(!has("alias A = B; alias B = A; @group(0) @binding(0) var<uniform> a: A;", "a", Some("b")));
    }
}
