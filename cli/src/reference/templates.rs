//! The shader templates: what each says of itself, its axes, and the bindings that it takes.

use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::shader::{Axes, AxisMode};
use umbragraph::low_level::source::Sources;

use super::markdown::table;
use super::page::{Entry, Page};

pub(super) fn page() -> Page {
    let mut sources = Sources::new();
    let templates = umbragraph::templates(&mut sources, &mut Diagnostics::new());
    let entries = templates.names().filter_map(|name| {
        let text = without_tags(sources.get(templates.file(name)?)?.text());
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
        let mut includes: Vec<String> = Vec::new();
        for other in quoted_after(&text, "{% include ") {
            let link = format!("[{other}](#{})", anchor(other));
            if !includes.contains(&link) {
                includes.push(link);
            }
        }
        let mut whole = format!("{about}\n");
        if !includes.is_empty() {
            whole.push_str(&format!("\nIncludes, with their bindings: {}.\n", includes.join(", ")));
        }
        for part in [
            table(["declares", "meaning"], &declarations(&text, name.starts_with("lib/"))),
            table(["binding", "declared as", "members of the block"], &bindings),
            table(["axis", "values", "default", "meaning"], &axes),
        ] {
            if !part.is_empty() {
                whole.push_str(&format!("\n{part}"));
            }
        }
        Some(Entry { name: name.to_owned(), summary: first_sentence(&about).to_owned(), text: whole })
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

/// Replaces the expressions in a template by plain words: the name of a value, or the alternatives that an axis
/// selects.
fn without_tags(text: &str) -> String {
    let mut parts = text.split("{{ ");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (expression, rest) = part.split_once(" }}").unwrap_or((part, ""));
        match expression.split_once(" if ") {
            Some((first, other)) => {
                out.push_str(first.trim_matches('"'));
                if let Some((_, other)) = other.split_once(" else ") {
                    out.push_str(&format!(" or {}", other.trim_matches('"')));
                }
            }
            None => out.push_str(expression),
        }
        out.push_str(rest);
    }
    out
}

/// Returns the comment at the beginning of a template, one line for each paragraph. Without one, the description of its
/// first function.
fn about(text: &str) -> String {
    let Some(comment) = text.strip_prefix("{#").and_then(|rest| rest.split("#}").next()) else {
        return declarations(text, true)
            .into_iter()
            .map(|[_, what]| what)
            .find(|what| !what.is_empty())
            .unwrap_or_default();
    };
    let paragraphs =
        comment.split("\n\n").map(|paragraph| paragraph.split_whitespace().collect::<Vec<_>>().join(" "));
    paragraphs.collect::<Vec<_>>().join("\n\n").trim().to_owned()
}

/// Returns the first sentence of a text. A full stop after an initial, as in `J. Doe`, does not end the sentence.
fn first_sentence(text: &str) -> &str {
    let text = text.lines().next().unwrap_or_default();
    let end = text.match_indices(". ").find(|(at, _)| {
        let mut before = text[..*at].chars().rev();
        let initial = before.next().is_some_and(char::is_uppercase)
            && before.next().is_none_or(|one| !one.is_alphanumeric());
        !initial
    });
    end.map_or(text, |(at, _)| &text[..=at])
}

/// Returns the structs and functions that a template offers to including templates, each with its comment. Declarations
/// in several variants appear once; blocks are described at their bindings.
pub(super) fn declarations(text: &str, included: bool) -> Vec<[String; 2]> {
    let mut rows: Vec<[String; 2]> = Vec::new();
    let (mut comment, mut entry_point) = (Vec::new(), false);
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(words) = line.strip_prefix("//") {
            comment.push(words.trim());
            continue;
        }
        let declared =
            if let Some(name) = line.strip_prefix("struct ").and_then(|rest| rest.strip_suffix(" {")) {
                let bound = bindings(text).any(|(_, declared)| declared.ends_with(&format!(": {name}")));
                let members = members(text, &format!(": {name}")).unwrap_or_default().replace('`', "");
                (!bound).then(|| format!("struct {name} {{ {members} }}"))
            } else if line.starts_with("fn ") && !entry_point {
                let mut signature = line.to_owned();
                while !signature.ends_with('{') {
                    let Some(next) = lines.next() else { break };
                    let gap = if signature.ends_with('(') || next.starts_with(')') { "" } else { " " };
                    signature = format!(
                        "{}{gap}{}",
                        signature.trim_end_matches(if next.starts_with(')') { "," } else { "" }),
                        next.trim()
                    );
                }
                Some(signature.trim_end_matches('{').trim_end().to_owned())
            } else {
                None
            };
        if let Some(declared) = declared.filter(|_| included) {
            let row = [format!("`{declared}`"), comment.join(" ")];
            if !rows.iter().any(|[known, _]| *known == row[0]) {
                rows.push(row);
            }
        }
        entry_point = line.starts_with(['@']) && !line.contains(" var");
        comment.clear();
    }
    rows
}

/// Returns the `@group` and `@binding` attributes and the declaration of each binding in a template.
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

/// Returns the members of the struct of a binding, over all variants. `None` if the template does not declare the
/// struct.
fn members(text: &str, declared: &str) -> Option<String> {
    let (_, of) = declared.rsplit_once(": ")?;
    let (_, body) = text.split_once(&format!("struct {of} {{"))?;
    let (first, rest) = body.split_once('\n')?;
    let (first, rest) = match first.split_once('}') {
        Some((only, _)) => (only, ""),
        None => (first, rest),
    };
    let lines =
        [first].into_iter().chain(rest.lines()).take_while(|line| !line.starts_with('}')).map(str::trim);
    let members = lines.filter(|line| !line.starts_with(['{', '/']) && line.contains(": "));
    let members: Vec<String> = members
        .map(|line| format!("`{}`", line.split("//").next().unwrap_or(line).trim().trim_end_matches(',')))
        .collect();
    (!members.is_empty()).then(|| members.join(", "))
}

/// Returns the double-quoted strings that directly follow each occurrence of `words`.
fn quoted_after<'a>(text: &'a str, words: &'a str) -> impl Iterator<Item = &'a str> {
    text.split(words).skip(1).filter_map(|rest| rest.strip_prefix('"')?.split('"').next())
}

/// Returns the link anchor of a heading.
pub(super) fn anchor(heading: &str) -> String {
    let letters =
        heading.chars().filter(|letter| letter.is_alphanumeric() || matches!(letter, '_' | '-' | ' '));
    letters.collect::<String>().to_lowercase().replace(' ', "-")
}
