//! Order that the document states: `after`.
//!
//! Both sides may be a pass, all rounds of a loop, or all passes of one use of a subgraph: `"after": ["soften"]`. One
//! pass of a subgraph can be named alone: `"after": ["soften.half"]`. Names are those of the place where `after`
//! stands. Every pass on the one side then runs after every pass on the other. A pass can be absent: its `when` does
//! not hold, its loop has no round, or the subgraph is not used. "After an absent pass" then means after those that it
//! would have followed itself.
//!
//! Limits: [`MAX_PAIRS`] pairs of passes, since each is an edge of the graph.

use std::collections::{BTreeMap, BTreeSet};

use crate::pipeline::load::versions::{is_absent, is_gap};
use crate::pipeline::names::{Instance, expression_diagnostic, is_of};
use crate::pipeline::pass::Pass;
use crate::pipeline::state::shared::Shared;
use crate::work::PassHandle;
use umbragraph_text::diagnostic::{Diagnostic, MAX_DIAGNOSTICS, codes, list_of};
use umbragraph_text::document::{Entry, Value};

/// The maximum number of pairs of a pass and a pass that it must follow.
const MAX_PAIRS: usize = 1 << 20;

/// Fills the list [`Pass::after`] of every pass. Reports names under `after` that no pass has, and passes that would
/// follow themselves.
pub(super) fn connect(
    waiting: &[Instance<'_>],
    passes: &mut [Pass],
    instances: &[Instance<'_>],
    absent: &BTreeSet<String>,
    gaps: &[(String, &Entry)],
    shared: &mut Shared,
) {
    if waiting.is_empty() {
        return;
    }
    let positions: BTreeMap<String, usize> =
        passes.iter().enumerate().map(|(at, pass)| (pass.name.clone(), at)).collect();
    let mut known: Option<BTreeSet<&str>> = None;
    let mut said = BTreeSet::new();
    let mut pairs = 0;
    let followed = followed(waiting, absent, shared);
    for Instance { name: later, entry, pointer, environment, .. } in waiting {
        if is_absent(absent, later) {
            continue;
        }
        if shared.diagnostics.len() >= MAX_DIAGNOSTICS {
            return;
        }
        let followers = members(&positions, later);
        let wanted = entry.value.elements_of("after");
        for (position, value) in wanted.iter().enumerate() {
            let Some(written) = value.text() else { continue };
            let at = || format!("{pointer}/after/{position}");
            let name = match environment.word(written, &shared.scope) {
                Ok(name) => environment.pass(&name),
                Err(mut error) => {
                    environment.widen(&mut error, std::iter::empty());
                    shared.report_from(expression_diagnostic(&error, value, &at()), environment);
                    continue;
                }
            };
            let mut before = members(&positions, &name);
            before.extend(through(&positions, &followed, &name));
            pairs += before.len() * followers.len();
            if pairs > MAX_PAIRS {
                let message =
                    format!("more than {MAX_PAIRS} pairs of passes are in an order stated by \"after\"");
                let diagnostic = Diagnostic::error(codes::LOOP, value.span, message).pointer(at());
                let help = "put a pass between the two that the one side is before and the other after";
                shared.diagnostics.push(diagnostic.help(help));
                return;
            }
            if followers.iter().any(|follower| before.contains(follower)) {
                if said.insert((value.span, name.clone())) {
                    let shown = environment.pass_inside(later).unwrap_or(later);
                    let message = format!("\"{shown}\" waits for itself");
                    let diagnostic = Diagnostic::error(codes::CYCLE, value.span, message).pointer(at());
                    let diagnostic = diagnostic.help("remove it: \"after\" names passes that run earlier");
                    shared.report_from([diagnostic], environment);
                }
                continue;
            }
            for follower in &followers {
                passes[*follower].after.extend(before.iter().map(|index| PassHandle(*index as u32)));
            }
            let is_known = !before.is_empty()
                || is_absent(absent, &name)
                || has_absent(absent, &name)
                || is_gap(gaps, &name);
            if is_known {
                continue;
            }
            followers.iter().for_each(|follower| passes[*follower].is_misplaced = true);
            if !said.insert((value.span, name.clone())) {
                continue;
            }
            let known = known.get_or_insert_with(|| {
                instances.iter().flat_map(|instance| groups(&instance.name)).collect()
            });
            let message = format!("there is no pass \"{name}\"");
            let diagnostic = Diagnostic::error(codes::UNKNOWN_PASS, value.span, message).pointer(at());
            let all = known.iter().filter_map(|known| environment.pass_inside(known));
            let known_as = environment.pass_inside(&name).unwrap_or(&name);
            let written = (written == known_as).then_some(value.span);
            let diagnostic = diagnostic.suggest(known_as, all, written, |names| {
                format!("the passes are {}", list_of(names.iter().copied()))
            });
            shared.report_from([diagnostic], environment);
        }
    }
}

/// Returns `true` if a pass in a loop or in a use of a subgraph with this name is absent.
fn has_absent(absent: &BTreeSet<String>, name: &str) -> bool {
    let begin = format!("{name}.");
    absent.range(begin.clone()..).next().is_some_and(|other| other.starts_with(&begin))
}

/// For each absent pass, loop or use of a subgraph, the names of the passes that it would follow.
fn followed(
    waiting: &[Instance<'_>],
    absent: &BTreeSet<String>,
    shared: &Shared,
) -> BTreeMap<String, Vec<String>> {
    let mut followed: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for Instance { name, entry, environment, .. } in waiting {
        // What a use of a subgraph follows, those of its passes follow that are not there.
        if is_absent(absent, name) || has_absent(absent, name) {
            let wanted = entry.value.elements_of("after");
            let names = wanted.iter().filter_map(Value::text);
            let names = names.filter_map(|name| environment.word(name, &shared.scope).ok());
            followed.entry(name.clone()).or_default().extend(names.map(|name| environment.pass(&name)));
        }
    }
    followed
}

/// The indices of the passes that the absent passes of a name would have followed, directly or through other absent
/// passes.
fn through(
    positions: &BTreeMap<String, usize>,
    followed: &BTreeMap<String, Vec<String>>,
    name: &str,
) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut seen = BTreeSet::new();
    let mut names = vec![name];
    while let Some(name) = names.pop().filter(|_| !followed.is_empty()) {
        for (gone, before) in followed.iter().filter(|(gone, _)| is_of(gone, name) || is_of(name, gone)) {
            if seen.insert(gone) {
                found.extend(before.iter().flat_map(|name| members(positions, name)));
                names.extend(before.iter().map(String::as_str));
            }
        }
    }
    found
}

/// The indices of the passes that a name outside of all subgraphs refers to. The name is of a pass, of a loop or of a
/// use of a subgraph.
fn members(positions: &BTreeMap<String, usize>, name: &str) -> Vec<usize> {
    if let Some(index) = positions.get(name) {
        return vec![*index];
    }
    let begin = format!("{name}.");
    let those = positions.range(begin.clone()..).take_while(|(other, _)| other.starts_with(&begin));
    those.map(|(_, index)| *index).collect()
}

/// The name of a pass, and the names of the loops and uses of subgraphs that contain it.
fn groups(name: &str) -> impl Iterator<Item = &str> {
    name.match_indices('.').map(|(at, _)| &name[..at]).chain([name])
}
