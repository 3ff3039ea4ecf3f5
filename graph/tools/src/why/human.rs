//! Things as text for people: what it is, what gave it its value, what became of it, and its values in a table.

use super::{Origin, Thing, Written};
use umbragraph_pipeline::compose::Layer;
use umbragraph_pipeline::diagnostic::render::visible;

const WIDEST: usize = 44;

/// Formats explanations as plain text for people, one after the other.
pub fn human(things: &[Thing]) -> String {
    visible(&things.iter().map(thing).collect::<Vec<_>>().join("\n")).into_owned()
}

fn thing(thing: &Thing) -> String {
    let mut text = format!("{}: {}, declared at {}\n", thing.name, thing.what, thing.declared);
    if let Some(description) = &thing.description {
        text += &format!("  {description}\n");
    }
    if let Some(value) = &thing.value {
        let by = thing.given.last().map_or("", |last| last.by.as_str());
        text += &format!("\n  value {value}, by {by}\n");
        let last = thing.given.len() - 1;
        let rows = thing.given.iter().enumerate().map(|(at, given)| {
            let counts = if at == last { "counts" } else { "replaced" };
            let layer = given.layer.map_or("", word);
            let note = [counts, layer].into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>();
            [given.by.clone(), cut(&given.value), given.at.to_string(), note.join(", ")]
        });
        text += &table(&rows.collect::<Vec<_>>());
    }
    if !thing.facts.is_empty() {
        text.push('\n');
        let mut before = "";
        let rows = thing.facts.iter().map(|fact| {
            let about = if fact.about == before { "" } else { fact.about };
            before = fact.about;
            let at = fact.at.as_ref().map(ToString::to_string).unwrap_or_default();
            [about.to_owned(), fact.text.clone(), at, String::new()]
        });
        text += &table(&rows.collect::<Vec<_>>());
    }
    if !thing.values.is_empty() {
        text += "\n  set by\n";
        text += &table(&thing.values.iter().flat_map(rows).collect::<Vec<_>>());
    }
    text
}

fn rows(origin: &Origin) -> Vec<[String; 4]> {
    let note = |written: &Written| {
        let shared = written.shared_settings.as_ref().map(|group| format!("shared settings {group}"));
        let words = [Some(word(written.layer).to_owned()).filter(|word| !word.is_empty()), shared];
        words.into_iter().flatten().collect::<Vec<_>>().join(", ")
    };
    let row = |path: &str, value: String, written: &Written| {
        [path.to_owned(), value, written.at.to_string(), note(written)]
    };
    let value = &origin.written.value;
    let value = if value == "null" { "deleted".to_owned() } else { cut(value) };
    let own = row(&origin.path, value, &origin.written);
    let older = origin.replaced.iter().map(|older| row("", format!("was {}", cut(&older.value)), older));
    std::iter::once(own).chain(older).collect()
}

fn word(layer: Layer) -> &'static str {
    match layer {
        Layer::Pipeline => "",
        Layer::Extended => "extended file",
        Layer::Included => "included file",
        Layer::Extension => "extension",
        Layer::Used => "file of a subgraph",
    }
}

fn cut(value: &str) -> String {
    match value.char_indices().nth(WIDEST) {
        Some((at, _)) => format!("{}…", &value[..at]),
        None => value.to_owned(),
    }
}

/// Formats rows as lines of text with aligned columns, without spaces at the ends of lines.
fn table(rows: &[[String; 4]]) -> String {
    let mut widths = [0; 4];
    for row in rows {
        for (at, cell) in row.iter().enumerate() {
            // A long sentence with no place behind it moves nothing.
            if row[at + 1..].iter().any(|later| !later.is_empty()) {
                widths[at] = widths[at].max(cell.chars().count());
            }
        }
    }
    let mut text = String::new();
    for row in rows {
        let mut line = String::from("   ");
        for (cell, width) in row.iter().zip(widths) {
            line += &format!(" {cell:width$} ");
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}
