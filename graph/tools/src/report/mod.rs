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
mod table;
mod text;
mod variants;

pub use diff::diff;
pub use html::{Observed, page};
pub use model::{
    AttachmentReport, CompatibilityClassReport, EdgeKind, EdgeReport, MAX_STEPS, MemoryReport, PassReport,
    Report, ResourceReport, bytes_in_words,
};
pub use table::table;

/// The output format of a drawn render graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum GraphFormat {
    /// An SVG image.
    #[default]
    Svg,
    /// A self-contained HTML page: the SVG image with search, details and comparison.
    Html,
    /// A Graphviz DOT graph.
    Dot,
    /// A Mermaid flowchart for Markdown.
    Mermaid,
    /// The report data as JSON.
    Json,
}

impl GraphFormat {
    /// All output formats.
    pub const ALL: [Self; 5] = [Self::Svg, Self::Html, Self::Dot, Self::Mermaid, Self::Json];

    /// The name of the format: `svg`, `html`, `dot`, `mermaid` or `json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Html => "html",
            Self::Dot => "dot",
            Self::Mermaid => "mermaid",
            Self::Json => "json",
        }
    }

    /// Returns the format with a name; `None` for an unknown name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }
}

/// Renders a report in a format. `comparison` holds the lines of [`diff`] against another report; only the HTML page
/// shows them.
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
