//! The templates that stand alone, and the files that they share: what one of them does not need, another may.

use std::collections::BTreeSet;

use umbragraph::low_level::source::FileId;

use crate::session::Session;

/// The templates that stand alone: those of which no other names.
pub(super) fn whole_templates(session: &Session) -> Vec<String> {
    let named: BTreeSet<&str> = session.templates.names().flat_map(|name| named_in(session, name)).collect();
    let is_part = |name: &str| name.starts_with("lib/") || named.contains(name);
    session.templates.names().filter(|name| !is_part(name)).map(str::to_owned).collect()
}

/// The templates that the text of one names, in quotes.
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

/// The files in which nothing is called dead, whatever the templates of these names need of them: those that another
/// template which stands alone uses as well, and all that come with this program where there is a folder of others.
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
