//! `umbragraph reference`: what can be written, from the things themselves.
//!
//! Everything in it comes from what the checker goes by: the schema of pipelines, the shapes that node kinds publish,
//! the table of functions, the axes and bindings of templates, the codes of diagnostics. So a page cannot say what is
//! not so. Pages are Markdown; the command prints an entry, and writes all of them as files.

mod functions;
mod markdown;
mod materials;
mod page;
mod settings;
mod templates;

use std::path::Path;

use umbragraph::diagnostic::render::human_all;
use umbragraph::diagnostic::suggested_name;
use umbragraph::low_level::source::Sources;

use self::page::{Entry, Page};
use crate::arguments::ReferenceArguments;
use crate::replace::replace;
use crate::streams::{complain, print};

/// Prints an entry or the list of entries, or writes the pages. Returns `true` on success.
pub(crate) fn run(arguments: &ReferenceArguments) -> bool {
    let pages = pages();
    if let Some(folder) = &arguments.write {
        return write(&pages, folder);
    }
    let Some(wanted) = &arguments.name else {
        print(&list(&pages));
        return true;
    };
    let entries = || pages.iter().flat_map(|page| page.entries.iter().map(move |entry| (page, entry)));
    let found: String = entries()
        .filter(|(_, entry)| entry.name.eq_ignore_ascii_case(wanted))
        .map(|(page, entry)| {
            format!("{} ({})\n\n{}\n", entry.name, page.title, markdown::without_links(entry.text.trim_end()))
        })
        .collect::<Vec<_>>()
        .join("\n");
    if found.is_empty() {
        let suggested = suggested_name(wanted, entries().map(|(_, entry)| entry.name.as_str()));
        let has = |entry: &Entry| {
            let part = wanted.to_lowercase();
            entry.name.to_lowercase().contains(&part) || entry.summary.to_lowercase().contains(&part)
        };
        let about: Vec<&str> =
            entries().filter(|(_, entry)| has(entry)).map(|(_, entry)| entry.name.as_str()).take(8).collect();
        let help = match suggested {
            Some(suggested) => format!(" (did you mean {suggested}?)"),
            None if about.is_empty() => String::new(),
            None => format!("; of it speak {}", about.join(", ")),
        };
        complain(&format!("the reference has no {wanted}{help}; `umbragraph reference` lists what it has\n"));
        return false;
    }
    print(&found);
    true
}

fn pages() -> Vec<Page> {
    let settings = settings::Settings::new();
    vec![
        settings.document(),
        settings.kinds(),
        settings.types(),
        functions::page(),
        templates::page(),
        materials::page(),
        codes(),
    ]
}

fn codes() -> Page {
    let mut codes = umbragraph::codes();
    codes.extend_from_slice(crate::codes::ALL);
    codes.sort_unstable();
    let entries = codes.into_iter().map(|code| Entry {
        name: code.id.to_owned(),
        summary: code.title.to_owned(),
        text: format!("{}\n\n{}", markdown::sentence(code.title), code.page),
    });
    Page {
        name: "diagnostics",
        title: "Diagnostics",
        introduction: "The meaning of each code, and the way out.",
        entries: entries.collect(),
    }
}

fn list(pages: &[Page]) -> String {
    let mut text = String::new();
    for page in pages {
        text.push_str(&format!("{}\n", page.title));
        let width = page.entries.iter().map(|entry| entry.name.chars().count()).max().unwrap_or(0);
        for entry in &page.entries {
            text.push_str(&format!("  {:width$}  {}\n", entry.name, entry.summary));
        }
        text.push('\n');
    }
    text
}

fn write(pages: &[Page], folder: &Path) -> bool {
    let mut index = "# Reference\n\n<!-- Written by `umbragraph reference --write docs/reference`. -->\n\n\
        `umbragraph reference NAME` prints an entry of these pages.\n\n"
        .to_owned();
    for page in pages {
        index.push_str(&format!("- [{}]({}.md): {}\n", page.title, page.name, page.introduction));
    }
    let files = pages.iter().map(|page| (page.name, page.markdown())).chain([("README", index)]);
    for (name, text) in files {
        if let Err(diagnostic) = replace(&folder.join(format!("{name}.md")), text) {
            complain(&human_all([&diagnostic], &Sources::new()));
            return false;
        }
    }
    true
}
