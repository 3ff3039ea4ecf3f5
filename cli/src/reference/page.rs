//! Pages of the reference, and the entries on them.

/// One entry of the reference.
pub(super) struct Entry {
    /// The name by which users find the entry.
    pub(super) name: String,
    /// A description in one line.
    pub(super) summary: String,
    /// The complete text of the entry, as Markdown.
    pub(super) text: String,
}

/// A Markdown file of the reference.
pub(super) struct Page {
    /// The name of the file, without its extension.
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    pub(super) introduction: &'static str,
    pub(super) entries: Vec<Entry>,
}

impl Page {
    /// Returns the page as Markdown.
    pub(super) fn markdown(&self) -> String {
        let mut text = format!(
            "# {}\n\n<!-- Written by `umbragraph reference --write docs/reference`. -->\n\n{}\n",
            self.title, self.introduction
        );
        for entry in &self.entries {
            text.push_str(&format!("\n## {}\n\n{}\n", entry.name, entry.text.trim_end()));
        }
        text
    }
}
