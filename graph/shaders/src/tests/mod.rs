//! Helpers of the tests: template sets from pairs, and diagnostics as one line each.

mod arbitrary;
mod broken;
mod compiling;
mod composing;
mod creation;
mod dead;
mod exploring;
mod messages;
mod mutations;
mod parts;
mod provenance;
mod random_wgsl;
mod reflecting;
mod rejecting;
mod second_compiler;
mod texture_reads;
mod tint;
mod wgsl_mutants;
mod wgsl_rules;

use super::{AxisValue, AxisValues, TargetProfile, TemplateSet};
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, Place};
use umbragraph_text::source::Sources;

/// A template set with its sources and the diagnostics from adding the templates.
pub(super) struct Fixture {
    pub(super) sources: Sources,
    pub(super) set: TemplateSet,
    pub(super) diagnostics: Diagnostics,
}

impl Fixture {
    pub(super) fn new(files: &[(&str, &str)]) -> Self {
        let mut fixture =
            Self { sources: Sources::new(), set: TemplateSet::new(), diagnostics: Diagnostics::new() };
        for (name, text) in files {
            fixture.set.add(&mut fixture.sources, name, text, &mut fixture.diagnostics);
        }
        fixture.set.check(&mut fixture.diagnostics);
        fixture
    }

    /// Creates a fixture that must have no diagnostics.
    pub(super) fn sound(files: &[(&str, &str)]) -> Self {
        let fixture = Self::new(files);
        assert!(fixture.diagnostics.is_empty(), "{:?}", fixture.lines(fixture.diagnostics.iter()));
        fixture
    }

    pub(super) fn compile(&self, template: &str, given: &[(&str, AxisValue)]) -> super::ShaderModule {
        crate::compile(&self.set, template, &values(given), &TargetProfile::webgpu())
            .unwrap_or_else(|diagnostics| panic!("{:#?}", self.lines(&diagnostics)))
    }

    /// Compiles a variant that must be rejected. Returns the diagnostics as lines.
    pub(super) fn rejection(&self, template: &str, given: &[(&str, AxisValue)]) -> Vec<String> {
        match crate::compile(&self.set, template, &values(given), &TargetProfile::webgpu()) {
            Ok(module) => panic!("compiles:\n{}", module.wgsl),
            Err(diagnostics) => self.lines(&diagnostics),
        }
    }

    /// Formats diagnostics as lines: `UG0502 main.wgsl.jinja:2:4 message`.
    pub(super) fn lines<'d>(&self, diagnostics: impl IntoIterator<Item = &'d Diagnostic>) -> Vec<String> {
        diagnostics
            .into_iter()
            .map(|diagnostic| {
                format!("{} {} {}", diagnostic.code, self.place(&diagnostic.place), diagnostic.message)
            })
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

/// The templates that are compiled directly, not only included. Without `cargo xtask soak`, templates with over 4,096
/// variants are left out.
pub(super) fn roots(set: &TemplateSet) -> Vec<&str> {
    let count = |name: &str| {
        let axes = set.axes(name).into_iter().flat_map(crate::Axes::iter);
        let in_text = axes.filter(|axis| axis.mode == crate::axes::AxisMode::Template);
        let counts = in_text.filter(|axis| !matches!(axis.kind, crate::AxisKind::Integer { .. }));
        counts.fold(1_u64, |product, axis| product.saturating_mul(axis.kind.count()))
    };
    let max = if umbragraph_test_support::property::times() > 1 { u64::MAX } else { 4096 };
    set.names().filter(|name| !name.starts_with("lib/") && count(name) <= max).collect()
}

pub(super) fn values(given: &[(&str, AxisValue)]) -> AxisValues {
    given.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect()
}

pub(super) const FRAGMENT: &str =
    "@fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }\n";
