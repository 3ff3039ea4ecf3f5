//! Pieces of Markdown.

/// Returns a Markdown table with a heading; empty without rows.
pub(super) fn table<const N: usize>(heading: [&str; N], rows: &[[String; N]]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut text = line(heading.map(str::to_owned).to_vec());
    text.push_str(&line(vec!["---".to_owned(); N]));
    for row in rows {
        text.push_str(&line(row.iter().map(|cell| cell.replace('\n', " ").replace('|', "\\|")).collect()));
    }
    text
}

/// Makes a sentence of a phrase: a capital letter at the beginning and a full stop at the end.
pub(super) fn sentence(phrase: &str) -> String {
    let mut letters = phrase.chars();
    let Some(first) = letters.next() else { return String::new() };
    let end = if phrase.ends_with('.') { "" } else { "." };
    first.to_uppercase().chain(letters).chain(end.chars()).collect()
}

/// Removes the targets of Markdown links, for a terminal.
pub(super) fn without_links(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("](") {
        let (before, after) = rest.split_at(at);
        match (before.rfind('['), after.find(')')) {
            (Some(open), Some(end)) => {
                out.push_str(&before[..open]);
                out.push_str(&before[open + 1..]);
                rest = &after[end + 1..];
            }
            _ => break,
        }
    }
    out + rest
}
