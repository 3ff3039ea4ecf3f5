//! The shader templates: what each says of itself, its axes, and the bindings that it takes.

use umbragraph::diagnostic::Diagnostics;
use umbragraph::shader::{Axes, AxisMode};
use umbragraph::source::Sources;

use super::markdown::table;
use super::{Entry, Page};

pub(super) fn page() -> Page {
    let mut sources = Sources::new();
    let templates = umbragraph::templates(&mut sources, &mut Diagnostics::new());
    let entries = templates.names().filter_map(|name| {
        let text = sources.get(templates.file(name)?)?.text().clone();
        let about = about(&text);
        let axes: Vec<[String; 4]> = templates
            .axes(name)
            .into_iter()
            .flat_map(Axes::iter)
            .map(|axis| {
                let mode = match axis.mode {
                    AxisMode::Template => "",
                    AxisMode::Override => " (override)",
                };
                [
                    format!("`{}`{mode}", axis.name),
                    axis.kind.describe(),
                    axis.default.to_string(),
                    axis.description.clone(),
                ]
            })
            .collect();
        let bindings: Vec<[String; 3]> = bindings(&text)
            .map(|(place, declared)| {
                [format!("`{place}`"), format!("`{declared}`"), members(&text, declared).unwrap_or_default()]
            })
            .collect();
        let includes: Vec<String> = quoted_after(&text, "{% include ")
            .map(|other| format!("[{other}](#{})", anchor(other)))
            .collect();
        let mut whole = format!("{about}\n");
        if !includes.is_empty() {
            whole.push_str(&format!("\nIncludes, with their bindings: {}.\n", includes.join(", ")));
        }
        for part in [
            table(["binding", "declared as", "members of the block"], &bindings),
            table(["axis", "values", "default", "what"], &axes),
        ] {
            if !part.is_empty() {
                whole.push_str(&format!("\n{part}"));
            }
        }
        let summary = about.split_once(". ").map_or(about.clone(), |(first, _)| format!("{first}."));
        Some(Entry { name: name.to_owned(), summary, text: whole })
    });
    Page {
        name: "templates",
        title: "Shader templates",
        introduction: "The templates that come with the module, their axes (which take the values of features, \
            parameters and derived values of their names, or those under `axes`), and the bindings that they take under \
            `bind`, by name. Those under `lib/` are there to be included.\n\n\
            Groups are counted as the executor lays them out: 0 what each view has, 1 what the pass binds, 2 and 3 what \
            the host's draws bring. In a template of your own that includes one of these, take numbers in group 1 that \
            it does not.",
        entries: entries.collect(),
    }
}

/// The comment with which a template begins, on one line for each paragraph.
fn about(text: &str) -> String {
    let Some(comment) = text.strip_prefix("{#").and_then(|rest| rest.split("#}").next()) else {
        return String::new();
    };
    let paragraphs =
        comment.split("\n\n").map(|paragraph| paragraph.split_whitespace().collect::<Vec<_>>().join(" "));
    paragraphs.collect::<Vec<_>>().join("\n\n").trim().to_owned()
}

/// Where each binding is, and how it is declared.
fn bindings(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.lines().filter_map(|line| {
        let declared = line.trim().strip_prefix("@group(")?;
        let (place, declared) =
            declared.split_once(" var").map(|(place, rest)| (place, rest.trim_end_matches(';')))?;
        let start = line.len() - line.trim_start().len();
        let place = &line[start..start + "@group(".len() + place.len()];
        Some((place, declared.trim()))
    })
}

/// The members of the struct that a binding is of, where the same text declares it: all that some variant has.
fn members(text: &str, declared: &str) -> Option<String> {
    let (_, of) = declared.rsplit_once(": ")?;
    let (_, body) = text.split_once(&format!("struct {of} {{"))?;
    let lines = body.lines().take_while(|line| !line.starts_with('}')).map(str::trim);
    let members = lines.filter(|line| !line.starts_with(['{', '/']) && line.contains(": "));
    let members: Vec<String> = members
        .map(|line| format!("`{}`", line.split("//").next().unwrap_or(line).trim().trim_end_matches(',')))
        .collect();
    (!members.is_empty()).then(|| members.join(", "))
}

/// The texts in double quotes that follow some words.
fn quoted_after<'a>(text: &'a str, words: &'a str) -> impl Iterator<Item = &'a str> {
    text.split(words).skip(1).filter_map(|rest| rest.strip_prefix('"')?.split('"').next())
}

/// What a heading is called in links.
fn anchor(heading: &str) -> String {
    let letters =
        heading.chars().filter(|letter| letter.is_alphanumeric() || matches!(letter, '_' | '-' | ' '));
    letters.collect::<String>().to_lowercase().replace(' ', "-")
}
