//! `--report`: one page of a run, to be attached to a bug report.
//!
//! The page needs no network and no other file: frame, diagnostics, parameters and features, times, memory, every pass
//! with what it reads and writes, and the page of the graph in a frame of its own. A texture is shown as a small picture
//! of its capture, a buffer by the first rows. The graph leaves out the copies that captures add. A run that fails writes
//! the page with what there is by then.
//!
//! Limits: a multisampled texture shows sample 0, a volume its middle slice.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use umbragraph::diagnostic::{Diagnostic, render};
use umbragraph::low_level::CheckReport;
use umbragraph::low_level::pipeline::TypedPipeline;
use umbragraph::low_level::report::{Observed, PassReport, Report, page};

use super::capture::{CaptureFile, Captured, Preview, base};
use super::files::{Compression, png_bytes};
use super::timings::Timings;
use crate::arguments::RenderArguments;
use crate::device;
use crate::replace::{replace, unwritable};
use crate::session::Session;

/// The maximum width and height in pixels of the texture pictures on the page.
const SIDE: u32 = 360;

const STYLE: &str = include_str!("report.css");

/// The contents of a report page that are collected during the run.
pub(super) struct RunReport {
    folder: PathBuf,
    /// The name of the adapter; `None` before it is opened.
    pub(super) device: Option<String>,
    /// The pipeline that was loaded; `None` after errors in its documents.
    pipeline: Option<Arc<TypedPipeline>>,
    /// The plan and the graph without the copies for captures; `None` after errors.
    report: Option<Report>,
    /// The last frame as a `data:` URL.
    frame: Option<String>,
    /// The table of times.
    times: Option<String>,
    /// The HTML of captured contents by reference, such as `NAME@PASS`.
    contents: BTreeMap<String, String>,
    observed: Observed,
}

impl RunReport {
    /// Begins a report, and creates its folder.
    ///
    /// # Errors
    /// A folder that cannot be created.
    pub(super) fn begin(folder: &Path) -> Result<Self, Diagnostic> {
        std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
        Ok(Self {
            folder: folder.to_owned(),
            device: None,
            pipeline: None,
            report: None,
            frame: None,
            times: None,
            contents: BTreeMap::new(),
            observed: Observed::default(),
        })
    }

    /// Adds the pipeline with its plan and graph, as far as there are any.
    pub(super) fn checked(&mut self, checked: &CheckReport, session: &Session) {
        self.pipeline.clone_from(&checked.pipeline);
        if let (Some(plan), Some(graph)) = (&checked.plan, &checked.graph) {
            self.report = Some(Report::new(plan, graph, session.sources()));
        }
    }

    /// Adds the last frame, as 8-bit RGBA, and the times of the passes.
    pub(super) fn drawn(&mut self, size: [u32; 2], rgba: &[u8], timings: Option<&Timings>) {
        self.frame = data_url(size, rgba);
        self.times = timings.map(Timings::table);
        self.observed.times = timings.map(Timings::means).unwrap_or_default();
    }

    /// Adds captured contents, or the reason why there are none.
    pub(super) fn add(&mut self, capture: &CaptureFile, captured: Result<Captured, Diagnostic>) {
        let name = capture.capture.reference.clone();
        let shown = captured.and_then(|captured| match (captured, capture.buffer()) {
            (Captured::Bytes(bytes), Some(buffer)) => Ok(self.buffer(&name, &buffer.preview(&bytes))),
            (Captured::Texels { texels, samples }, _) => {
                let (sheet, content, remark) = capture.sheet(&texels, samples)?;
                let rgba = sheet.rgba(content, &sheet.ranges(content));
                Ok(self.picture(&name, [sheet.width, sheet.height], &rgba, &remark))
            }
            (Captured::Bytes(_), None) => Ok(String::new()),
        });
        match shown {
            Ok(html) => {
                self.contents.insert(name, html);
            }
            Err(error) => self.leave_out(capture, &error.message),
        }
    }

    /// Adds the reason why contents are not shown.
    pub(super) fn leave_out(&mut self, capture: &CaptureFile, reason: &str) {
        let html = format!("<p>not shown: {}</p>", escaped(reason));
        self.contents.insert(capture.capture.reference.clone(), html);
    }

    fn picture(&mut self, name: &str, size: [u32; 2], rgba: &[u8], remark: &str) -> String {
        let (size, rgba) = smaller(size, rgba);
        let Some(url) = data_url(size, &rgba) else { return String::new() };
        let remark = if remark.is_empty() { String::new() } else { format!("<p>{}</p>", escaped(remark)) };
        let html = format!("<img alt=\"\" src=\"{url}\">{remark}");
        self.observed.pictures.insert(name.to_owned(), url);
        html
    }

    fn buffer(&mut self, name: &str, preview: &Preview) -> String {
        let Preview { about, columns, rows, json } = preview;
        self.observed.buffers.insert(name.to_owned(), preview.text());
        let row = |tag: &str, cells: &[String]| {
            let cells: String =
                cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect();
            format!("<tr>{cells}</tr>\n")
        };
        let rows: String = rows.iter().map(|cells| row("td", cells)).collect();
        let (head, file) = (row("th", columns), escaped(&name.replace('@', "_at_")));
        let url = format!("data:application/json;base64,{}", STANDARD.encode(json));
        format!(
            "<p>{} (<a download=\"{file}.json\" href=\"{url}\">JSON</a>)</p>\n<table>\n{head}{rows}</table>\n",
            escaped(about)
        )
    }

    /// Writes the page into the folder, and returns a line that names the written file.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub(super) fn write(&self, session: &Session, arguments: &RenderArguments) -> Result<String, Diagnostic> {
        let name = match &self.report {
            Some(report) => report.pipeline.clone(),
            None => arguments.pipeline.display().to_string(),
        };
        let name = escaped(&name);
        let mut html = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
             <title>{name}: a run</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>\n"
        );
        let mut add = |text: String| html.push_str(&text);
        let [width, height] = arguments.choices.size;
        let version = env!("CARGO_PKG_VERSION");
        // A run that failed before a device was opened names the adapter that it would have used.
        let device =
            self.device.clone().map_or_else(|| device::chosen(arguments.drawn.adapter.as_deref()), Ok);
        let device = device.unwrap_or_else(|_| "no adapter".to_owned());
        let profile = self.pipeline.as_ref().map(|pipeline| format!(", profile {}", pipeline.profile.name));
        add(format!(
            "<p>{width} by {height} on {}{}, umbragraph {version}</p>\n<p><code>{}</code></p>\n",
            escaped(&device),
            escaped(&profile.unwrap_or_default()),
            escaped(&command_line())
        ));
        if session.diagnostics.has_errors() {
            add("<p><b>The run failed.</b> The page shows what there is.</p>\n".to_owned());
        }
        if let Some(url) = &self.frame {
            add(format!("<h2>Frame</h2>\n<img class=\"frame\" alt=\"the frame\" src=\"{url}\">\n"));
        }
        let said = render::human_all(&session.diagnostics, session.sources());
        let said = if said.is_empty() { "none\n".to_owned() } else { said };
        add(format!("<h2>Diagnostics</h2>\n<pre>{}</pre>\n", escaped(&said)));
        if let Some(pipeline) = &self.pipeline {
            add(settings(pipeline));
        }
        if let Some(times) = &self.times {
            add(format!("<h2>Times</h2>\n<pre>{}</pre>\n", escaped(times)));
        }
        if let Some(report) = &self.report {
            add(self.graph(report));
        }
        add("</body>\n</html>\n".to_owned());
        let path = self.folder.join("index.html");
        replace(&path, html)?;
        Ok(format!("{}: a page of the run\n", path.display()))
    }

    /// Returns the HTML of the plan: memory, passes and graph.
    fn graph(&self, report: &Report) -> String {
        let memory = &report.memory;
        let rows = [
            ("without aliasing", memory.without_aliasing),
            ("created", memory.created),
            ("alive at most", memory.peak),
        ];
        let memory = table(["", "bytes"], rows.map(|(name, bytes)| [name.to_owned(), bytes.to_string()]));
        let passes = (0..).zip(&report.passes).map(|(column, pass)| self.pass(report, column, pass));
        format!(
            "<h2>Memory</h2>\n{memory}<h2>Passes</h2>\n{}<h2>Graph</h2>\n<iframe title=\"the graph\" srcdoc=\"{}\"></iframe>\n",
            passes.collect::<String>(),
            escaped(&page(report, None, &self.observed))
        )
    }

    /// Returns the HTML of a pass with its inputs and outputs.
    fn pass(&self, report: &Report, column: usize, pass: &PassReport) -> String {
        let before = &report.passes[..column];
        let reads: BTreeSet<String> = pass.reads.iter().map(|name| version(name, before)).collect();
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
                let shown = self.contents.get(&name).or_else(|| self.contents.get(base(&name)));
                let (shown, name) = (shown.map_or("", String::as_str), escaped(&name));
                let _ = write!(text, "<figure>{shown}<figcaption>{name}</figcaption></figure>");
            }
            text.push_str("</div>\n");
        }
        text + "</details>\n"
    }
}

/// Returns the version of a resource that a pass reads: `name@PASS` with the last of the passes before it that writes
/// the resource.
fn version(name: &str, before: &[PassReport]) -> String {
    let writes = |pass: &&PassReport| pass.live && pass.writes.iter().any(|written| written == name);
    before.iter().rev().find(writes).map_or_else(|| name.to_owned(), |pass| format!("{name}@{}", pass.name))
}

/// Returns the HTML table of the values of parameters and features.
fn settings(pipeline: &TypedPipeline) -> String {
    let parameters = pipeline.parameters.iter().map(|(name, parameter)| {
        let kind = if parameter.structural.is_some() { "structural" } else { "live" };
        [name.clone(), parameter.value.to_string(), kind.to_owned()]
    });
    let features = pipeline.features.iter();
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
