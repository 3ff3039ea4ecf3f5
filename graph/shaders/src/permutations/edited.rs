//! Variants that a caller edits before they are proven, such as a runner of shader tests.
//!
//! [`variants`] takes every path through a template, as `permutations` does. [`Variant::edited`] replaces parts of a
//! text and keeps its map, so that a rejection of the edited text has its place in the template. [`root_causes`] merges
//! what a caller found on many variants: one diagnostic per cause, with the smallest set of axis values that provokes
//! it.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use super::cause::{Causes, Failure, Ground};
use super::explore::{Explorer, Leaf};
use super::request::{Request, space_of};
use crate::axes::Axes;
use crate::module::wgsl;
use crate::rendering::templates::TemplateSet;
use crate::targets::profile::TargetProfile;
use crate::variant::compile::{self, ShaderModule};
use crate::written::text_map::{Origin, Segment, Source, TextMap};
use umbragraph_text::diagnostic::{AxisValues, Diagnostic};

/// One distinct WGSL module generated from a template, not yet validated.
#[derive(Clone, Debug)]
pub struct Variant {
    /// The name of the template.
    pub template: String,
    /// The values of the axes that the WGSL depends on.
    pub axes: Arc<AxisValues>,
    source: Source,
}

/// A replacement of a byte range of WGSL.
#[derive(Clone, Debug)]
pub struct TextEdit {
    /// The byte range to replace.
    pub range: Range<usize>,
    /// The WGSL to insert.
    pub text: String,
    /// The byte range of the old WGSL to which diagnostics in the new WGSL refer.
    pub origin: Range<usize>,
}

/// Renders the distinct variants of a request. Also returns diagnostics for variants that cannot be rendered.
pub fn variants(templates: &TemplateSet, request: &Request) -> (Vec<Variant>, Vec<Diagnostic>) {
    let template = &request.template;
    let space = match space_of(templates, request) {
        Ok(space) => Arc::new(space),
        Err(diagnostics) => return (Vec::new(), diagnostics),
    };
    let mut explorer = Explorer::new(templates, template, &space, false);
    while explorer.next_text().is_some() {}
    let exploration = explorer.finish();
    let mut diagnostics = exploration.diagnostics.clone();
    diagnostics.extend(exploration.failures.iter().map(|(_, diagnostic)| diagnostic.clone()));
    diagnostics.dedup_by_key(|diagnostic| diagnostic.key());
    let variant = |at: usize| {
        let leaf = exploration.leaves.get(exploration.texts.get(at)?.leaf)?;
        let source = exploration.source(templates, template, at)?;
        Some(Variant { template: template.clone(), axes: Arc::new(leaf.decided.values()), source })
    };
    ((0..exploration.texts.len()).filter_map(variant).collect(), diagnostics)
}

impl Variant {
    /// The generated WGSL of the variant.
    pub fn wgsl(&self) -> &str {
        &self.source.wgsl
    }

    /// The map from byte offsets of the WGSL to places in the templates.
    pub fn map(&self) -> &TextMap {
        &self.source.map
    }

    /// Replaces byte ranges of the WGSL. If edits overlap, only the first one is applied.
    #[must_use]
    pub fn edited(&self, edits: &[TextEdit]) -> Self {
        let (old, map) = (&self.source.wgsl, &self.source.map);
        let mut sorted: Vec<&TextEdit> = edits.iter().collect();
        sorted.sort_by_key(|edit| (edit.range.start, edit.range.end));
        let (mut wgsl, mut segments, mut done) = (String::with_capacity(old.len() * 2), Vec::new(), 0);
        let keep = |range: Range<usize>, wgsl: &mut String, segments: &mut Vec<Segment>| {
            for (piece, origin) in map.part(range) {
                segments.push(Segment { start: wgsl.len() as u32, origin });
                wgsl.push_str(old.get(piece).unwrap_or_default());
            }
        };
        for edit in sorted {
            if edit.range.start < done || edit.range.end > old.len() {
                continue;
            }
            keep(done..edit.range.start, &mut wgsl, &mut segments);
            segments.push(Segment {
                start: wgsl.len() as u32,
                origin: map.span(edit.origin.clone()).map(Origin::Tag),
            });
            wgsl.push_str(&edit.text);
            done = edit.range.end;
        }
        keep(done..old.len(), &mut wgsl, &mut segments);
        let map = TextMap { segments, length: wgsl.len() as u32 };
        Self { source: Source { wgsl, map }, ..self.clone() }
    }

    /// Parses, validates and reflects the WGSL. `overrides` sets override axes; other overrides have their defaults.
    ///
    /// # Errors
    /// The errors of the WGSL, with places in the templates.
    pub fn prove(
        &self,
        templates: &TemplateSet,
        overrides: &AxisValues,
        profile: &TargetProfile,
    ) -> Result<ShaderModule, Vec<Diagnostic>> {
        let mut values = templates.axes(&self.template).map(Axes::defaults).unwrap_or_default();
        values.extend(self.axes.as_ref().clone());
        values.extend(overrides.clone());
        let rendered = (self.source.clone(), self.axes.keys().cloned().collect());
        wgsl::with_stack(|| compile::check(templates, &self.template, &values, &rendered, profile))
    }
}

/// Merges the diagnostics of several variants into one per root cause. `found` pairs axis values with diagnostics.
pub fn root_causes(
    templates: &TemplateSet,
    request: &Request,
    found: &[(AxisValues, Vec<Diagnostic>)],
) -> Vec<Diagnostic> {
    let space = match space_of(templates, request) {
        Ok(space) => space,
        Err(diagnostics) => return diagnostics,
    };
    let leaf = |(values, _): &(AxisValues, _)| Leaf { decided: values.into(), text: None };
    let leaves: Vec<Leaf> = found.iter().map(leaf).collect();
    let ground = Ground {
        template: &request.template,
        space: &space,
        leaves: &leaves,
        assumed: &request.assumed,
        profiles: BTreeSet::new(),
    };
    let failure = |leaf: usize, diagnostic: &Diagnostic| Failure {
        diagnostic: diagnostic.clone(),
        leaves: [leaf].into(),
        profiles: BTreeSet::new(),
        excess: None,
        overrides: AxisValues::new(),
    };
    let of_leaf = |(leaf, (_, found)): (usize, &(_, Vec<Diagnostic>))| {
        found.iter().map(|diagnostic| failure(leaf, diagnostic)).collect::<Vec<_>>()
    };
    let mut causes = Causes::default();
    causes.add(&ground, found.iter().enumerate().flat_map(of_leaf).collect());
    causes.diagnostics()
}
