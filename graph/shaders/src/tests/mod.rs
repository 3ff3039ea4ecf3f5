//! What the tests of this module share: template sets from pairs, and findings as one line each.

mod arbitrary;
mod broken;
mod compiling;
mod dead;
mod exploring;
mod mutations;
mod provenance;
mod reflecting;
mod refusing;

use super::{AxisValue, AxisValues, TargetProfile, TemplateSet};
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use crate::source::Sources;

/// Templates, their texts, and what was found while they were added.
pub(super) struct Fixture {
    pub(super) sources: Sources,
    pub(super) set: TemplateSet,
    pub(super) findings: Diagnostics,
}

impl Fixture {
    pub(super) fn new(files: &[(&str, &str)]) -> Self {
        let mut fixture =
            Self { sources: Sources::new(), set: TemplateSet::new(), findings: Diagnostics::new() };
        for (name, text) in files {
            fixture.set.add(&mut fixture.sources, name, text, &mut fixture.findings);
        }
        fixture.set.check(&mut fixture.findings);
        fixture
    }

    /// A set that has to be free of findings.
    pub(super) fn sound(files: &[(&str, &str)]) -> Self {
        let fixture = Self::new(files);
        assert!(fixture.findings.is_empty(), "{:?}", fixture.lines(fixture.findings.iter()));
        fixture
    }

    pub(super) fn compile(&self, template: &str, given: &[(&str, AxisValue)]) -> super::ShaderModule {
        super::compile(&self.set, template, &values(given), &TargetProfile::webgpu())
            .unwrap_or_else(|findings| panic!("{:#?}", self.lines(&findings)))
    }

    /// The findings of a compilation that has to fail, as lines.
    pub(super) fn refusal(&self, template: &str, given: &[(&str, AxisValue)]) -> Vec<String> {
        match super::compile(&self.set, template, &values(given), &TargetProfile::webgpu()) {
            Ok(module) => panic!("compiles:\n{}", module.wgsl),
            Err(findings) => self.lines(&findings),
        }
    }

    /// `UG0502 main.wgsl.jinja:2:4 message`.
    pub(super) fn lines<'d>(&self, findings: impl IntoIterator<Item = &'d Diagnostic>) -> Vec<String> {
        findings
            .into_iter()
            .map(|finding| format!("{} {} {}", finding.code, self.place(&finding.place), finding.message))
            .collect()
    }

    pub(super) fn place(&self, place: &Place) -> String {
        match place {
            Place::Span(span) => {
                let file = self.sources.get(span.file).unwrap();
                let at = file.line_column(span.start);
                format!("{}:{}:{}", file.name(), at.line, at.column)
            }
            _ => "-".to_owned(),
        }
    }
}

pub(super) fn values(given: &[(&str, AxisValue)]) -> AxisValues {
    given.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect()
}

pub(super) const FRAGMENT: &str =
    "@fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }\n";
