//! One variant, to be looked at: in the language of a target, or line by line with where it came from.

use std::fmt::Write as _;

use super::compile::ShaderModule;
use crate::module::backend::Emitted;
use crate::module::{backend, wgsl};
use crate::targets::profile::TargetLanguage;
use crate::targets::profile::TargetProfile;
use crate::written::rejection::Rejection;
use umbragraph_text::diagnostic::{Diagnostic, Place};
use umbragraph_text::source::Sources;

impl ShaderModule {
    /// Translates the module to a shading language, with its overrides set to [`ShaderModule::constants`].
    ///
    /// # Errors
    /// A diagnostic, placed in the template, if the language cannot express the module.
    pub fn emit(
        &self,
        profile: &TargetProfile,
        language: TargetLanguage,
    ) -> Result<Emitted, Box<Diagnostic>> {
        if language == TargetLanguage::Wgsl {
            return Ok(Emitted::Text(self.wgsl.to_string()));
        }
        let written = wgsl::with_stack(|| -> Result<Emitted, Rejection> {
            let module = wgsl::parse(&self.wgsl)?;
            let info = wgsl::validate(&module, profile.capabilities)?;
            let constants = self.constants.iter().map(|(name, value)| (name.clone(), *value)).collect();
            let (module, info) = wgsl::resolve_overrides(&module, &info, &constants)?;
            backend::emit(&module, &info, language)
        });
        written.map_err(|rejection| {
            let mut pieces = self.map.pieces();
            Box::new(match pieces.find_map(|(_, span)| span) {
                Some(span) => rejection.to_diagnostic(&self.wgsl, &self.map, span.file),
                None => Diagnostic::error(rejection.code, Place::Nowhere, rejection.message),
            })
        })
    }

    /// Returns the WGSL with the template file and line of each line: `lib/noise.wgsl.jinja:12 | let x = 1.0;`. A line
    /// that starts with the output of a template expression shows the place of that expression.
    pub fn annotated(&self, sources: &Sources) -> String {
        let mut lines: Vec<(String, &str)> = Vec::new();
        let mut start = 0;
        for line in self.wgsl.split_inclusive('\n') {
            let indent = line.len() - line.trim_start().len();
            let at = if indent < line.len() { start + indent } else { start };
            let place = self.map.place(at).and_then(|span| {
                let file = sources.get(span.file)?;
                Some(format!("{}:{}", file.name(), file.line_column(span.start).line))
            });
            lines.push((place.unwrap_or_default(), line.trim_end_matches(['\n', '\r'])));
            start += line.len();
        }
        let width = lines.iter().map(|(place, _)| place.chars().count()).max().unwrap_or(0);
        let mut text = String::with_capacity(self.wgsl.len() * 2);
        for (place, line) in lines {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{place:<width$} | {line}");
        }
        text
    }
}
