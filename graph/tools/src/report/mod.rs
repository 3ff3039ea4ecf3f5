//! Seeing what the compiler made: pictures of graphs, a page to explore them, and the difference of two plans in words.
//!
//! A [`Report`] is a value taken from a plan and its graph with everything that a reader may ask: the passes in their
//! order with the culled ones among them, the resources with their lifetimes and what they share memory with, versions
//! and hazards, bytes against their bounds. [`draw`] turns it into one of the [`GraphFormat`]s, [`diff`] compares two.
//!
//! Everything is deterministic: no times, no addresses, nothing from outside.

use umbragraph_pipeline::diagnostic::render::visible;

mod diff;
mod html;
mod model;
mod settings;
mod svg;
mod text;

pub use diff::diff;
pub use html::{Observed, page};
pub use model::{
    AttachmentReport, CompatibilityClassReport, EdgeKind, EdgeReport, MAX_STEPS, MemoryReport, PassReport,
    Report, ResourceReport, bytes_in_words,
};

/// The form of a drawn graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum GraphFormat {
    /// A picture.
    #[default]
    Svg,
    /// A page that needs no network: the picture with search, details and comparison.
    Html,
    /// Graphviz.
    Dot,
    /// A flowchart for Markdown.
    Mermaid,
    /// The report itself.
    Json,
}

impl GraphFormat {
    /// All forms.
    pub const ALL: [Self; 5] = [Self::Svg, Self::Html, Self::Dot, Self::Mermaid, Self::Json];

    /// `svg`, `html`, `dot`, `mermaid` or `json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Html => "html",
            Self::Dot => "dot",
            Self::Mermaid => "mermaid",
            Self::Json => "json",
        }
    }

    /// A form by its name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }
}

/// Draws a report. `comparison` is what [`diff`] says about it and another one; only the page shows it.
pub fn draw(report: &Report, format: GraphFormat, comparison: Option<&[String]>) -> String {
    match format {
        GraphFormat::Svg => svg::picture(report, 0),
        GraphFormat::Html => html::page(report, comparison, &Observed::default()),
        GraphFormat::Dot => visible(&text::dot(report)).into_owned(),
        GraphFormat::Mermaid => visible(&text::mermaid(report)).into_owned(),
        GraphFormat::Json => {
            let mut json = serde_json::to_string_pretty(report).unwrap_or_default();
            json.push('\n');
            json
        }
    }
}
