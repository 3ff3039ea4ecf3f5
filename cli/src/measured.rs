//! `--measured FILE`: figures of an offline compiler (malioc, RGA) for variants, put into the JSON report.
//!
//! ```json
//! { "tool": "malioc 8.5, Mali-G78", "variants": { "1f2e3d4c": { "cycles": 12.5, "registers": 32 } } }
//! ```
//!
//! A variant is named by the hash that the report has of it, or by its first digits, eight or more, as `--write` puts
//! them into names of files. No compiler comes with this program: a script of the user's runs one over the texts of
//! `--write`, or over what `wgsl --target` prints.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use umbragraph::diagnostic::Diagnostic;
use umbragraph::low_level::document::{Kind, Value};
use umbragraph::low_level::shader::permutations::TemplateReport;

use crate::codes;
use crate::session::Session;

/// The minimum number of hexadecimal digits of a hash.
const MIN_DIGITS: usize = 8;

/// The measured values of a variant, by name.
type Figures = BTreeMap<String, f64>;

/// Measurements of variants in a report, by their hashes.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Measured {
    tool: String,
    variants: BTreeMap<String, Figures>,
}

impl Measured {
    /// Reads a file of measurements. Returns `None` if the file is missing or not valid JSON. Errors are added to the
    /// session's diagnostics.
    pub(crate) fn read(session: &mut Session, path: &Path, reports: &[TemplateReport]) -> Option<Self> {
        let root = match session.read_figures(path) {
            Ok(document) => document.root,
            Err(diagnostics) => {
                session.diagnostics.extend(diagnostics);
                return None;
            }
        };
        let mut hashes: Vec<&str> =
            reports.iter().flat_map(|report| report.variants.iter().map(|each| each.hash.as_str())).collect();
        hashes.sort_unstable();
        hashes.dedup();
        let mut measured = Self::default();
        let mut wrong = |value: &Value, message: String| {
            session.diagnostics.push(Diagnostic::error(codes::MEASURED, value.span, message));
        };
        match root.get("tool").and_then(Value::text) {
            Some(tool) => tool.clone_into(&mut measured.tool),
            None => wrong(&root, "\"tool\" names the compiler that the figures are of".to_owned()),
        }
        if root.get("variants").and_then(Value::entries).is_none() {
            wrong(&root, "\"variants\" is an object of figures by hashes".to_owned());
        }
        for own in root.entries_of("variants") {
            let first = hashes.partition_point(|hash| *hash < own.key.as_str());
            let mut found = hashes[first..].iter().take_while(|hash| hash.starts_with(&own.key));
            let hash = match (found.next(), found.next()) {
                _ if own.key.len() < MIN_DIGITS => {
                    wrong(&own.value, format!("\"{}\" has fewer than {MIN_DIGITS} digits", own.key));
                    continue;
                }
                (Some(hash), None) => *hash,
                (None, _) => {
                    wrong(&own.value, format!("no variant of this run has the hash \"{}\"", own.key));
                    continue;
                }
                (Some(_), Some(_)) => {
                    wrong(
                        &own.value,
                        format!("several variants have a hash that begins with \"{}\"", own.key),
                    );
                    continue;
                }
            };
            let figures = measured.variants.entry(hash.to_owned()).or_default();
            let Some(entries) = own.value.entries() else {
                wrong(&own.value, format!("figures are an object of numbers, not {}", own.value.kind_name()));
                continue;
            };
            for figure in entries {
                match (&figure.value.kind, figure.value.decode::<f64>()) {
                    (Kind::Number(_), Ok(number)) => drop(figures.insert(figure.key.clone(), number)),
                    _ => wrong(&figure.value, format!("\"{}\" is a number", figure.key)),
                }
            }
        }
        Some(measured)
    }
}
