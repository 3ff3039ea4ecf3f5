//! The templates that stand alone, and the files that they share: what one of them does not need, another may.

use std::collections::BTreeSet;

use umbragraph::low_level::source::FileId;

use crate::session::Session;

/// Returns the names of the templates that no other template names; files below `lib/` are excluded.
pub(super) fn whole_templates(session: &Session) -> Vec<String> {
    let named: BTreeSet<&str> = session.templates.names().flat_map(|name| named_in(session, name)).collect();
    let is_part = |name: &str| name.starts_with("lib/") || named.contains(name);
    session.templates.names().filter(|name| !is_part(name)).map(str::to_owned).collect()
}

/// Returns the names of the templates that the source of a template names in quotes.
fn named_in<'s>(session: &'s Session, name: &str) -> Vec<&'s str> {
    let file = session.templates.file(name).and_then(|file| session.sources().get(file));
    let text = file.map(|file| file.text().clone()).unwrap_or_else(|| "".into());
    let quoted = |other: &str| {
        let before_and_after =
            |at: usize| (text[..at].chars().next_back(), text[at + other.len()..].chars().next());
        text.match_indices(other)
            .any(|(at, _)| matches!(before_and_after(at), (Some('"'), Some('"')) | (Some('\''), Some('\''))))
    };
    session.templates.names().filter(|other| *other != name && quoted(other)).collect()
}

/// Returns the files in which no code is reported as dead, because other templates may use it. With a folder of own
/// templates, all bundled files are included.
pub(super) fn shared(session: &Session, names: &BTreeSet<String>) -> BTreeSet<FileId> {
    let files = |name: &str| {
        let templates = &session.templates;
        [templates.file(name), templates.axes_file(name)].into_iter().flatten()
    };
    let mut open = whole_templates(session);
    open.retain(|name| !names.contains(name));
    let mut used: BTreeSet<String> = open.iter().cloned().collect();
    while let Some(name) = open.pop() {
        for other in named_in(session, &name) {
            if used.insert(other.to_owned()) {
                open.push(other.to_owned());
            }
        }
    }
    let mut shared: BTreeSet<FileId> = used.iter().flat_map(|name| files(name)).collect();
    if let Some(own) = &session.own_files {
        shared.extend(session.templates.names().flat_map(files).filter(|file| !own.contains(file)));
    }
    shared
}
