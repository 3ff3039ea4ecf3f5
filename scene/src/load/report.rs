//! Diagnostics while a scene is loaded, and the budget that they share.

use gltf::json::Index;
use gltf::json::validation::Checked;
use umbragraph_pipeline::diagnostic::{Code, Diagnostic, Diagnostics, Severity};

use super::limits::{FREE_DECODED_BYTES, MAX_DECODED_BYTES, MAX_DIAGNOSTICS};
use crate::codes;

/// Collects the diagnostics of one file, and limits the number of decoded bytes by a budget.
pub(super) struct Report {
    file: String,
    errors: Diagnostics,
    warnings: Diagnostics,
    unlisted: usize,
    decoded_bytes: u64,
    /// The budget: the maximum number of decoded bytes, which grows with the number of bytes read.
    allowed_bytes: u64,
    /// If set, errors are reported as warnings that mention this fallback, such as "white is used".
    instead: Option<&'static str>,
}

impl Report {
    pub(super) fn new(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            errors: Diagnostics::new(),
            warnings: Diagnostics::new(),
            unlisted: 0,
            decoded_bytes: 0,
            allowed_bytes: FREE_DECODED_BYTES,
            instead: None,
        }
    }

    pub(super) fn error(
        &mut self,
        code: Code,
        at: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        if let Some(instead) = self.instead {
            self.warning(code, at, format!("{}; {instead}", message.into()), help);
            return;
        }
        if self.errors.len() >= MAX_DIAGNOSTICS {
            self.unlisted += 1;
            return;
        }
        self.errors.push(Diagnostic::in_file(code, &*self.file, at, message).help(help));
    }

    /// Reports an error and returns `None`, so that a caller can report an error and return in one expression.
    pub(super) fn reject<T>(
        &mut self,
        code: Code,
        at: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Option<T> {
        self.error(code, at, message, help);
        None
    }

    pub(super) fn warning(
        &mut self,
        code: Code,
        at: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        if self.warnings.len() < MAX_DIAGNOSTICS {
            let diagnostic = Diagnostic::in_file(code, &*self.file, at, message).help(help);
            self.warnings.push(diagnostic.severity(Severity::Warning));
        }
    }

    /// Runs `read`, which reads an optional part of the file. Errors of `read` are reported as warnings that mention
    /// the fallback `instead`.
    pub(super) fn optional<T>(&mut self, instead: &'static str, read: impl FnOnce(&mut Self) -> T) -> T {
        let outer = self.instead.replace(instead);
        let result = read(self);
        self.instead = outer;
        result
    }

    pub(super) fn has_errors(&self) -> bool {
        !self.errors.is_empty()
    }

    /// Raises the budget for decoded bytes by `decoded_per_byte` for each of the `bytes` bytes that were read.
    pub(super) fn allow(&mut self, bytes: usize, decoded_per_byte: u64) {
        let allowed = (bytes as u64).saturating_mul(decoded_per_byte);
        self.allowed_bytes = self.allowed_bytes.saturating_add(allowed);
    }

    /// Charges `bytes` decoded bytes to the budget. Reports an error and returns `false` if the rest of the budget is
    /// smaller.
    pub(super) fn charge(&mut self, bytes: u64, at: &str) -> bool {
        let total = self.decoded_bytes.saturating_add(bytes);
        let max = self.allowed_bytes.min(MAX_DECODED_BYTES);
        if total > max {
            let limit = max >> 20;
            self.error(
                codes::TOO_LARGE,
                at,
                format!(
                    "decoding this would take the scene beyond {limit} MiB, the most for files of their size"
                ),
                "simplify the scene, or share accessors and images instead of repeating them",
            );
            return false;
        }
        self.decoded_bytes = total;
        true
    }

    /// The element `index` of a list of the document. `noun` names an element in diagnostics. Reports an error and
    /// returns `None` if the element does not exist.
    pub(super) fn lookup<'a, T>(
        &mut self,
        list: &'a [T],
        index: usize,
        noun: &str,
        at: &str,
    ) -> Option<&'a T> {
        let found = list.get(index);
        if found.is_none() {
            let help = match list.len() {
                0 => format!("the document has no {noun}s"),
                1 => format!("the document has one {noun}, number 0"),
                count => format!("the document has {count} {noun}s, numbered 0 to {}", count - 1),
            };
            let message = match u32::try_from(index) {
                Ok(u32::MAX) => format!("no {noun} is named here"),
                _ => format!("{noun} {index} does not exist"),
            };
            self.error(codes::DANGLING_REFERENCE, at, message, help);
        }
        found
    }

    /// The value of an index into a list of the document. Returns `None` if there is no index. Reports an error and
    /// returns `None` if the element does not exist.
    pub(super) fn index<T, U>(
        &mut self,
        list: &[T],
        index: Option<Index<U>>,
        noun: &str,
        at: &str,
    ) -> Option<usize> {
        let index = index?.value();
        self.lookup(list, index, noun, at).map(|_| index)
    }

    /// The value of an enumerated property. Reports an error and returns `None` if glTF does not define the value.
    pub(super) fn known<T: Copy>(
        &mut self,
        value: &Checked<T>,
        at: &str,
        message: impl Into<String>,
        help: &str,
    ) -> Option<T> {
        match value {
            Checked::Valid(value) => Some(*value),
            Checked::Invalid => self.reject(codes::BAD_VALUE, at, message, help),
        }
    }

    /// Returns the warnings as `Ok` if there are no errors, else the errors followed by the warnings as `Err`.
    pub(super) fn finish(mut self) -> Result<Diagnostics, Diagnostics> {
        if self.errors.is_empty() {
            return Ok(self.warnings);
        }
        if self.unlisted > 0 {
            let message = format!("{} further errors are not listed", self.unlisted);
            let diagnostic = Diagnostic::in_file(codes::MORE_DIAGNOSTICS, &*self.file, "", message);
            self.errors
                .push(diagnostic.help("mend the listed ones first; the others are often of the same kind"));
        }
        self.errors.extend(self.warnings);
        Err(self.errors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_budget_is_shared_and_a_rejected_charge_takes_nothing() {
        let mut report = Report::new("a.glb");
        assert!(!Report::new("a.glb").charge(FREE_DECODED_BYTES + 1, "/a"));
        report.allow(100, 1);
        assert!(report.charge(FREE_DECODED_BYTES + 100, "/a") && !report.charge(1, "/a"));
        let mut report = Report::new("a.glb");
        report.allow(usize::MAX, 2);
        assert!(report.charge(MAX_DECODED_BYTES - 10, "/a"));
        assert!(!report.charge(11, "/b") && !report.charge(u64::MAX, "/b"));
        assert!(report.charge(10, "/c"));
        let found = report.finish().unwrap_err();
        assert_eq!(found.iter().map(|diagnostic| diagnostic.code).collect::<Vec<_>>(), [codes::TOO_LARGE]);
    }
}
