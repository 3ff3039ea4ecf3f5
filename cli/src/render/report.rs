//! `--report`: one page of a run, to be attached to a bug report.
//!
//! The page needs no network and no other file: frame, diagnostics, parameters and features, times, memory, every pass
//! with what it reads and writes, and the page of the graph in a frame of its own. Pictures of textures are captures,
//! made smaller; the graph is that of the pipeline without the copies that make them.
//!
//! Limits: textures of several samples, volumes and buffers have no picture; the page is written only after a run
//! without errors.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, render};
use umbragraph::executor::Texels;
use umbragraph::low_level::CheckReport;
use umbragraph::low_level::report::{Observed, PassReport, Report, page};

use super::capture::CaptureFile;
use super::files::{Compression, png_bytes};
use super::timings::Timings;
use crate::replace::{replace, unwritable};
use crate::session::Session;

/// The maximum width and height in pixels of the texture pictures on the page.
const SIDE: u32 = 360;

const STYLE: &str = include_str!("report.css");

/// The contents of a report page that are collected during the run.
pub(super) struct RunReport {
    report: Report,
    pictures: BTreeMap<String, String>,
}

impl RunReport {
    /// Begins the report on `checked`, the plan without the copies for captures, and creates the folder; `None` if
    /// there is no plan.
    ///
    /// # Errors
    /// A folder that cannot be created.
    pub(super) fn begin(
        folder: &Path,
        checked: &CheckReport,
        session: &Session,
    ) -> Result<Option<Self>, Diagnostic> {
        std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
        let (Some(plan), Some(graph)) = (&checked.plan, &checked.graph) else { return Ok(None) };
        Ok(Some(Self { report: Report::new(plan, graph, session.sources()), pictures: BTreeMap::new() }))
    }

    /// Adds the picture of a captured texture.
    pub(super) fn add(&mut self, capture: &CaptureFile, texels: &Texels) {
        let ([width, height], rgba) = capture.picture(texels);
        let (size, rgba) = smaller([width, height], &rgba);
        if let Some(url) = data_url(size, &rgba) {
            self.pictures.insert(capture.capture.reference.clone(), url);
        }
    }

    /// Writes the page into a folder, and returns a line that names the written file.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub(super) fn write(
        &self,
        folder: &Path,
        plan: &Plan,
        frame: &[u8],
        timings: Option<&Timings>,
        (session, device): (&Session, &str),
    ) -> Result<String, Diagnostic> {
        let observed = Observed {
            pictures: self.pictures.clone(),
            times: timings.map(Timings::means).unwrap_or_default(),
        };
        let graph = page(&self.report, None, &observed);
        let name = escaped(&self.report.pipeline);
        let mut html = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
             <title>{name}: a run</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>\n"
        );
        let mut add = |text: String| html.push_str(&text);
        let [width, height] = plan.viewport;
        let version = env!("CARGO_PKG_VERSION");
        let profile = &plan.pipeline.profile.name;
        add(format!(
            "<p>{width} by {height} on {}, profile {}, umbragraph {version}</p>\n<p><code>{}</code></p>\n",
            escaped(device),
            escaped(profile),
            escaped(&command_line())
        ));
        if let Some(url) = data_url(plan.viewport, frame) {
            add(format!("<h2>Frame</h2>\n<img class=\"frame\" alt=\"the frame\" src=\"{url}\">\n"));
        }
        let said = render::human_all(&session.diagnostics, session.sources());
        let said = if said.is_empty() { "none\n".to_owned() } else { said };
        add(format!("<h2>Diagnostics</h2>\n<pre>{}</pre>\n", escaped(&said)));
        add(settings(plan));
        if let Some(timings) = timings {
            add(format!("<h2>Times</h2>\n<pre>{}</pre>\n", escaped(&timings.table())));
        }
        let memory = &self.report.memory;
        add(format!(
            "<h2>Memory</h2>\n{}",
            table(
                ["", "bytes"],
                [
                    ["without aliasing".to_owned(), memory.without_aliasing.to_string()],
                    ["created".to_owned(), memory.created.to_string()],
                    ["alive at most".to_owned(), memory.peak.to_string()],
                ]
            )
        ));
        add("<h2>Passes</h2>\n".to_owned());
        for (column, pass) in self.report.passes.iter().enumerate() {
            add(self.pass(column, pass));
        }
        add(format!(
            "<h2>Graph</h2>\n<iframe title=\"the graph\" srcdoc=\"{}\"></iframe>\n</body>\n</html>\n",
            escaped(&graph)
        ));
        let path = folder.join("index.html");
        replace(&path, html)?;
        Ok(format!("{}: a page of the run\n", path.display()))
    }

    /// Returns the HTML of a pass with its inputs and outputs.
    fn pass(&self, column: usize, pass: &PassReport) -> String {
        let reads: BTreeSet<String> = pass.reads.iter().map(|name| self.version(name, column)).collect();
        let writes = pass.writes.iter().map(|name| format!("{name}@{}", pass.name));
        let state = if pass.live { "kept" } else { "culled" };
        let mut text = format!(
            "<details{}><summary><b>{}</b> {} <i>{state}</i></summary>\n<p>{}</p>\n",
            if pass.live { " open" } else { "" },
            escaped(&pass.name),
            escaped(&pass.kind),
            escaped(pass.why.last().map_or("", String::as_str)),
        );
        for (title, names) in [("reads", reads.into_iter().collect()), ("writes", writes.collect::<Vec<_>>())]
        {
            if names.is_empty() {
                continue;
            }
            let _ = write!(text, "<div class=\"row\"><span>{title}</span>");
            for name in names {
                let picture = self.pictures.get(&name).or_else(|| self.pictures.get(base(&name)));
                let picture = picture.map(|url| format!("<img alt=\"\" src=\"{url}\">")).unwrap_or_default();
                let name = escaped(&name);
                let _ = write!(text, "<figure>{picture}<figcaption>{name}</figcaption></figure>");
            }
            text.push_str("</div>\n");
        }
        text + "</details>\n"
    }

    /// Returns the version of a resource that a pass reads: `name@PASS` with the last pass before it that writes the
    /// resource.
    fn version(&self, name: &str, column: usize) -> String {
        let writer = self.report.passes[..column]
            .iter()
            .rev()
            .find(|pass| pass.live && pass.writes.iter().any(|written| written == name));
        writer.map_or_else(|| name.to_owned(), |pass| format!("{name}@{}", pass.name))
    }
}

/// Returns the name of a resource without its `@PASS` suffix.
fn base(version: &str) -> &str {
    version.split('@').next().unwrap_or(version)
}

/// Returns the HTML table of the values of parameters and features.
fn settings(plan: &Plan) -> String {
    let parameters = plan.pipeline.parameters.iter().map(|(name, parameter)| {
        let kind = if parameter.structural.is_some() { "structural" } else { "live" };
        [name.clone(), parameter.value.to_string(), kind.to_owned()]
    });
    let features = plan.pipeline.features.iter();
    let features =
        features.map(|(name, feature)| [name.clone(), feature.value.to_string(), "feature".to_owned()]);
    format!("<h2>Parameters and features</h2>\n{}", table(["", "value", ""], parameters.chain(features)))
}

fn table<const N: usize>(head: [&str; N], rows: impl IntoIterator<Item = [String; N]>) -> String {
    let cells = |tag: &str, row: [String; N]| {
        let cells: String = row.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let head = cells("th", head.map(str::to_owned));
    let rows: String = rows.into_iter().map(|row| cells("td", row)).collect();
    format!("<table>\n{head}{rows}</table>\n")
}

/// Returns the command line of this process.
fn command_line() -> String {
    let arguments = std::env::args_os().skip(1).map(|one| one.to_string_lossy().into_owned());
    std::iter::once("umbragraph".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// Encodes a picture as a PNG in a `data:` URL; `None` if encoding fails.
fn data_url(size: [u32; 2], rgba: &[u8]) -> Option<String> {
    let bytes = png_bytes(size, rgba, Compression { fast: false }).ok()?;
    Some(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
}

/// Reduces a picture to at most [`SIDE`] pixels per side by averaging blocks of pixels.
fn smaller([width, height]: [u32; 2], rgba: &[u8]) -> ([u32; 2], Vec<u8>) {
    let block = width.max(height).div_ceil(SIDE).max(1);
    let size = [width.div_ceil(block), height.div_ceil(block)];
    let mut pixels = Vec::with_capacity(size[0] as usize * size[1] as usize * 4);
    for row in 0..size[1] {
        for column in 0..size[0] {
            let (mut sum, mut count) = ([0_u32; 4], 0);
            for y in row * block..((row + 1) * block).min(height) {
                for x in column * block..((column + 1) * block).min(width) {
                    let at = (y as usize * width as usize + x as usize) * 4;
                    let Some(pixel) = rgba.get(at..at + 4) else { continue };
                    sum.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += u32::from(*value));
                    count += 1;
                }
            }
            pixels.extend(sum.map(|sum| (sum / count.max(1)) as u8));
        }
    }
    (size, pixels)
}

/// Escapes text for HTML, including attribute values.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_made_smaller_by_whole_blocks() {
        let rgba: Vec<u8> = (0..800_u32).flat_map(|x| [(x / 4) as u8, 0, 0, 255]).collect();
        let (size, small) = smaller([800, 1], &rgba);
        assert_eq!((size, small.len()), ([267, 1], 267 * 4));
        assert_eq!(&small[..4], &[0, 0, 0, 255]);
        assert_eq!(smaller([2, 1], &rgba[..8]).1, rgba[..8]);
    }

    #[test]
    fn names_never_become_markup() {
        assert_eq!(escaped("<a href=\"x\">&"), "&lt;a href=&quot;x&quot;&gt;&amp;");
    }
}
