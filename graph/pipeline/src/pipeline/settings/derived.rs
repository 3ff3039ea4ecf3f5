//! Derived values: named expressions over parameters, features and one another.
//!
//! ```jsonc
//! "derived": { "closer": "=reverse_z ? 'greater' : 'less'", "taps": "=soft ? 16 : 1" }
//! ```
//!
//! A derived value is no choice of anybody's: it follows from what is chosen, and expressions see it by its name as
//! they see a parameter. The values of one section are computed in the order in which they need one another, however
//! they stand; what is left then needs itself. In a subgraph they see its parameters, and what the subgraph sees of the
//! pipeline.
//!
//! Limits: sizes of resources and `viewport`, which are not known yet, have no part in derived values.

use std::collections::{BTreeMap, BTreeSet};

use crate::pipeline::names::{VIEWPORT, expression_diagnostic, name_diagnostic, twin_diagnostic};
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, way_of};
use umbragraph_text::document::{Entry, pointer_join};
use umbragraph_text::expression::{self, Expression, ExpressionKind, Scope, Value};
use umbragraph_text::language::Expr;
use umbragraph_text::source::Span;

/// A derived value: a named expression over parameters, features and other derived values.
#[derive(Clone, Debug)]
pub struct Derived {
    /// The value in this configuration.
    pub value: Value,
    /// The words that the value can have; `None` if the value is not limited to a list of words.
    pub words: Option<Vec<String>>,
    /// The place of the expression in the document.
    pub place: Span,
    /// The parsed expression of the value.
    pub expression: Expression,
    /// The position in the order of evaluation, in which a derived value comes after the derived values that it depends
    /// on.
    pub rank: usize,
}

/// The derived values of a section, and the names of derived values that have no value because of errors.
#[derive(Debug, Default)]
pub(crate) struct Section {
    pub(crate) values: BTreeMap<String, Derived>,
    pub(crate) broken: BTreeSet<String>,
}

/// The scope in which derived values are evaluated: derived values of the same section, and names of the enclosing
/// scope.
struct Names<'a> {
    section: &'a Section,
    declared: &'a [Entry],
    around: &'a dyn Scope,
}

impl Scope for Names<'_> {
    fn lookup(&self, name: &str) -> Option<Value> {
        match self.section.values.get(name) {
            Some(derived) => Some(derived.value.clone()),
            None => self.around.lookup(name).filter(|_| !self.is_broken(name)),
        }
    }

    fn is_broken(&self, name: &str) -> bool {
        self.section.broken.contains(name) || self.around.is_broken(name)
    }

    fn words(&self, name: &str) -> Option<&[String]> {
        match self.section.values.get(name) {
            Some(derived) => derived.words.as_deref(),
            None => self.around.words(name),
        }
    }

    fn names(&self) -> Vec<String> {
        self.around.names().into_iter().chain(self.declared.iter().map(|entry| entry.key.clone())).collect()
    }
}

/// The way out of an expression that names a toggle.
pub(crate) const NO_TOGGLES: &str = "expressions cannot see toggles, which change from frame to frame: give the pass \
                                     \"toggle\", or make it a feature";

/// Computes the derived values of the section at the JSON pointer `pointer`, in the scope `around`. `taken` lists other
/// declarations whose names derived values must not have, each with its place and kind.
pub(crate) fn evaluate(
    declared: &[Entry],
    pointer: &str,
    around: &dyn Scope,
    taken: &BTreeMap<&str, (Span, &str)>,
    is_broken: &dyn Fn(&str) -> bool,
    diagnostics: &mut Diagnostics,
) -> Section {
    let mut section = Section::default();
    let mut open: BTreeMap<&str, (&Entry, Expression)> = BTreeMap::new();
    for entry in declared {
        let at = pointer_join(pointer, &entry.key);
        let diagnostic = declaration_diagnostic(entry, taken);
        let is_misnamed = diagnostic.is_some();
        diagnostics.extend(diagnostic.map(|diagnostic| diagnostic.pointer(&at)));
        match Expr(entry.value.to_json()).parse() {
            _ if is_misnamed || is_broken(&at) => drop(section.broken.insert(entry.key.clone())),
            Ok(expression) => drop(open.insert(&entry.key, (entry, expression))),
            Err(error) => {
                diagnostics.extend(expression_diagnostic(&error, &entry.value, &at));
                section.broken.insert(entry.key.clone());
            }
        }
    }
    let needs: BTreeMap<&str, BTreeSet<&str>> = open
        .iter()
        .map(|(name, (_, expression))| {
            let known = expression.names().into_iter().filter_map(|name| Some(*open.get_key_value(name)?.0));
            (*name, known.collect())
        })
        .collect();
    let (order, waiting) = order(&needs);
    for name in order {
        let (entry, expression) = &open[name];
        let names = Names { section: &section, declared, around };
        let result = expression::unknown_word(expression, &names)
            .map_or(Ok(()), Err)
            .and_then(|()| expression::evaluate(expression, &names));
        match result {
            Ok(value) => {
                let words = words(expression, &names).map(|words| words.into_iter().collect());
                let (expression, rank) = (expression.clone(), section.values.len());
                let derived = Derived { value, words, place: entry.value.span, expression, rank };
                section.values.insert(entry.key.clone(), derived);
            }
            Err(mut error) => {
                let unknown = error.unknown.as_deref().and_then(|unknown| taken.get(unknown.name.as_str()));
                if unknown.is_some_and(|(_, what)| *what == "toggle") {
                    error.unknown = None;
                    error.help = Some(NO_TOGGLES.to_owned());
                }
                let is_size = error.unknown.as_deref().is_some_and(|unknown| {
                    let head = unknown.name.split('.').next().unwrap_or_default();
                    VIEWPORT.contains(&head) || taken.get(head).is_some_and(|(_, what)| *what == "resource")
                });
                if is_size {
                    error.unknown = None;
                    error.message += " here";
                    let help =
                        "derived values see parameters, features and one another; sizes are known later";
                    error.help = Some(help.to_owned());
                }
                let at = pointer_join(pointer, &entry.key);
                diagnostics.extend(expression_diagnostic(&error, &entry.value, &at));
                section.broken.insert(entry.key.clone());
            }
        }
    }
    let mut unsaid: BTreeSet<&str> = waiting.clone();
    while let Some(first) = unsaid.first().copied() {
        // Following what is waited for leads into a cycle.
        let mut way = vec![first];
        let cycle = loop {
            let Some(last) = way.last() else { break &way[..] };
            let next = needs[last].iter().find(|needed| waiting.contains(*needed));
            let Some(next) = next.copied() else { break &way[..] };
            match way.iter().position(|known| *known == next) {
                Some(at) => break &way[at..],
                None => way.push(next),
            }
        };
        if let [begin, others @ ..] = cycle
            && cycle.iter().all(|name| unsaid.contains(name))
        {
            let (entry, _) = &open[begin];
            let names = way_of(cycle.iter().chain([begin]));
            let message = format!("the derived value \"{begin}\" depends on itself: {names}");
            let mut diagnostic = Diagnostic::error(codes::DERIVED_CYCLE, entry.value.span, message)
                .pointer(pointer_join(pointer, begin))
                .help("let one of them follow from parameters and features alone");
            for other in others {
                diagnostic = diagnostic.related(open[other].0.value.span, "on the way");
            }
            diagnostics.push(diagnostic);
        }
        way.iter().for_each(|name| {
            unsaid.remove(name);
        });
    }
    section.broken.extend(waiting.into_iter().map(str::to_owned));
    section
}

/// Sorts names so that each name comes after the names that it needs. The second result has the names in cycles, and
/// the names that depend on a cycle.
pub(crate) fn order<'n>(needs: &BTreeMap<&'n str, BTreeSet<&'n str>>) -> (Vec<&'n str>, BTreeSet<&'n str>) {
    let mut waiting: BTreeMap<&str, usize> = needs.iter().map(|(name, needs)| (*name, needs.len())).collect();
    let mut needed_by: BTreeMap<&str, Vec<&'n str>> = BTreeMap::new();
    for (name, needs) in needs {
        needs.iter().for_each(|needed| needed_by.entry(needed).or_default().push(name));
    }
    let mut order: Vec<&'n str> =
        needs.iter().filter(|(_, needs)| needs.is_empty()).map(|(name, _)| *name).collect();
    let mut at = 0;
    while let Some(name) = order.get(at).copied() {
        at += 1;
        for follower in needed_by.get(name).into_iter().flatten() {
            let Some(count) = waiting.get_mut(follower) else { continue };
            *count -= 1;
            if *count == 0 {
                order.push(follower);
            }
        }
    }
    let done: BTreeSet<&str> = order.iter().copied().collect();
    let rest = needs.keys().copied().filter(|name| !done.contains(name)).collect();
    (order, rest)
}

fn declaration_diagnostic(entry: &Entry, taken: &BTreeMap<&str, (Span, &str)>) -> Option<Diagnostic> {
    if let Some(diagnostic) = name_diagnostic(entry) {
        return Some(diagnostic);
    }
    let twin = taken.get(entry.key.as_str())?;
    Some(twin_diagnostic(entry, "derived value", *twin))
}

/// The words of enumerations that an expression can yield; `None` if it can also yield other values.
fn words(expression: &Expression, scope: &dyn Scope) -> Option<BTreeSet<String>> {
    match &expression.kind {
        ExpressionKind::Literal(Value::Text(word)) => Some(BTreeSet::from([word.clone()])),
        ExpressionKind::Name(name) => Some(scope.words(name)?.iter().cloned().collect()),
        ExpressionKind::Conditional(_, yes, no) => {
            let mut all = words(yes, scope)?;
            all.append(&mut words(no, scope)?);
            Some(all)
        }
        _ => None,
    }
}
