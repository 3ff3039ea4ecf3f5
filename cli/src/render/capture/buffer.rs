//! Captured buffers, as the structure that a shader declares: JSON, a table as CSV, and the first rows for pages.
//!
//! A JSON file says which declaration it follows and which others there are; its `contents` have one element a line.

use std::path::Path;

use serde_json::{Value, json};
use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Place, codes, list_of};
use umbragraph::low_level::buffers::{self, Layout};

use super::base;
use crate::observed::ROWS;
use crate::replace::replace;

/// The maximum number of scalars that a file holds.
const MAX_NUMBERS: usize = 1 << 20;

/// The maximum number of scalars that the report page holds of one version of a buffer.
const MAX_ON_PAGE: usize = 1 << 12;

/// The maximum length of a line of JSON that is not split further, in bytes.
const LINE: usize = 100;

/// A buffer to capture.
#[derive(Clone, Debug)]
pub(in crate::render) struct BufferCapture {
    reference: String,
    /// The layout in which the contents are written.
    layout: Layout,
    /// The other layouts with which shaders declare the buffer.
    others: Vec<String>,
}

/// The beginning of a buffer for pages.
pub(in crate::render) struct Preview {
    /// The type, the passes that declare it, and what is left out.
    pub(in crate::render) about: String,
    pub(in crate::render) columns: Vec<String>,
    pub(in crate::render) rows: Vec<Vec<String>>,
    /// The contents as a JSON file.
    pub(in crate::render) json: String,
}

impl BufferCapture {
    /// Chooses the layout for a reference `NAME` or `NAME@PASS`; `None` if no live pass uses the buffer.
    pub(super) fn new(plan: &Plan, reference: &str) -> Option<Self> {
        let name = if plan.resources.contains_key(reference) { reference } else { base(reference) };
        let layouts = buffers::layouts(plan, name);
        let by = reference.split_once('@').map(|(_, pass)| pass);
        let layout = buffers::choose(&layouts, by)?.clone();
        let others = layouts.iter().filter(|other| **other != layout).map(|other| other.label.clone());
        Some(Self { reference: reference.to_owned(), others: others.collect(), layout })
    }

    /// Returns an error if the contents are no table.
    pub(super) fn ensure_table(&self) -> Result<(), Diagnostic> {
        buffers::table(&self.layout, &[], 0).map(|_| ()).ok_or_else(|| self.no_table())
    }

    fn no_table(&self) -> Diagnostic {
        let (name, label) = (&self.reference, &self.layout.label);
        let message = format!("\"{name}\" is `{label}`, no array of elements of one size, so it is no table");
        let help = "write a file that ends in .json";
        Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help(help)
    }

    /// Writes the contents as JSON, or as a table. Returns a description of them.
    ///
    /// # Errors
    /// Contents that are no table, or a file that cannot be written.
    pub(super) fn write(&self, file: &Path, is_table: bool, bytes: &[u8]) -> Result<String, Diagnostic> {
        if !is_table {
            let (text, left_out) = self.json(bytes, MAX_NUMBERS);
            replace(file, text)?;
            return Ok(self.about(bytes, left_out));
        }
        let table = buffers::table(&self.layout, bytes, MAX_NUMBERS).ok_or_else(|| self.no_table())?;
        let mut text = table.columns.join(",") + "\n";
        for row in &table.rows {
            text += &row.join(",");
            text.push('\n');
        }
        replace(file, text)?;
        Ok(self.about(bytes, table.left_out))
    }

    /// Returns the first rows and the contents for the report page.
    pub(in crate::render) fn preview(&self, bytes: &[u8]) -> Preview {
        // The file itself has the number of elements that it leaves out.
        let (json, _) = self.json(bytes, MAX_ON_PAGE);
        let mut about = self.about(bytes, 0);
        let (columns, rows) = match buffers::table(&self.layout, bytes, ROWS * buffers::MAX_FIELDS) {
            Some(mut table) => {
                let all = table.rows.len() + table.left_out;
                table.rows.truncate(ROWS);
                let shown = table.rows.len();
                if all > shown {
                    about += &format!("; the first {shown} of {all} rows");
                }
                (table.columns, table.rows)
            }
            None => {
                let (fields, has_more) = buffers::fields(&self.layout, bytes);
                if fields.len() > 2 * ROWS || has_more {
                    about += &format!("; the first {} fields", 2 * ROWS);
                }
                let rows = fields.into_iter().take(2 * ROWS).map(|field| vec![field.name, field.value]);
                (vec!["field".to_owned(), "value".to_owned()], rows.collect())
            }
        };
        Preview { about, columns, rows, json }
    }

    /// Describes the contents: size, type, the passes that declare it, and the number of elements that are left out.
    fn about(&self, bytes: &[u8], left_out: usize) -> String {
        let Layout { label, passes, .. } = &self.layout;
        let by = declared_by(passes);
        let others = match self.others.as_slice() {
            [] => String::new(),
            others => format!(", others have {}", list_of(others.iter().map(String::as_str))),
        };
        let left_out = match left_out {
            0 => String::new(),
            left_out => format!(", without the last {left_out} elements"),
        };
        format!("{} bytes, {label} ({by}{others}){left_out}", bytes.len())
    }

    /// Returns the contents as a JSON file, and the number of elements that are left out.
    fn json(&self, bytes: &[u8], max_numbers: usize) -> (String, usize) {
        let contents = buffers::contents(&self.layout, bytes, max_numbers);
        let document = json!({
            "buffer": self.reference, "bytes": bytes.len(), "type": self.layout.label,
            "declared_by": self.layout.passes, "other_types": self.others,
            "left_out": contents.left_out, "contents": contents.value,
        });
        (laid_out(&document, "") + "\n", contents.left_out)
    }
}

impl Preview {
    /// Returns the description and the rows as lines of text.
    pub(in crate::render) fn text(&self) -> String {
        let rows = self.rows.iter().map(|row| row.join(", "));
        let lines: Vec<String> =
            [self.about.clone(), self.columns.join(", ")].into_iter().chain(rows).collect();
        lines.join("\n")
    }
}

/// Names the passes that declare a buffer: all of up to three, otherwise two and the number of the others.
fn declared_by(passes: &[String]) -> String {
    match passes {
        [] => "no shader binds it".to_owned(),
        [first, second, more @ ..] if more.len() > 1 => {
            format!("declared by \"{first}\", \"{second}\" and {} more", more.len())
        }
        passes => format!("declared by {}", list_of(passes.iter().map(|pass| format!("\"{pass}\"")))),
    }
}

/// Returns JSON on one line if it is short, otherwise with each element on lines of its own.
fn laid_out(value: &Value, indent: &str) -> String {
    let whole = value.to_string();
    if whole.len() + indent.len() <= LINE {
        return whole;
    }
    let inner = format!("{indent}  ");
    let block = |[open, close]: [char; 2], lines: Vec<String>| {
        format!("{open}\n{inner}{}\n{indent}{close}", lines.join(&format!(",\n{inner}")))
    };
    match value {
        Value::Array(values) => block(['[', ']'], values.iter().map(|one| laid_out(one, &inner)).collect()),
        Value::Object(members) => {
            let member = |(name, value): (&String, &Value)| {
                format!("{}: {}", Value::from(name.as_str()), laid_out(value, &inner))
            };
            block(['{', '}'], members.iter().map(member).collect())
        }
        _ => whole,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_beyond_the_third_are_counted() {
        let passes = ["a", "b", "c", "d", "e"].map(str::to_owned);
        assert_eq!(declared_by(&passes), "declared by \"a\", \"b\" and 3 more");
        assert_eq!(declared_by(&passes[..3]), "declared by \"a\", \"b\", \"c\"");
        assert_eq!(declared_by(&[]), "no shader binds it");
    }

    #[test]
    fn json_has_a_short_element_on_each_line() {
        let long: Vec<Value> = (0..40).map(|at| json!({ "place": [at, 1.5], "count": 7 })).collect();
        let text = laid_out(&json!({ "bytes": 8, "contents": long }), "");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[..4],
            ["{", "  \"bytes\": 8,", "  \"contents\": [", "    {\"place\":[0,1.5],\"count\":7},"]
        );
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap()["contents"][39]["place"][0], 39);
    }
}
