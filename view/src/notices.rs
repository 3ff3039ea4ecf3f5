//! Diagnostics and notices: what is wrong with the files, and what frames say of lights and atlas.
//!
//! A click on a place opens it in the editor; a mend that a diagnostic has is applied to its files.

use std::path::Path;
use std::process::{Command, Stdio};

use eframe::egui::{self, Color32, RichText};
use umbragraph::diagnostic::{Diagnostic, Place, Severity};
use umbragraph::low_level::edit;
use umbragraph::low_level::files::replace_if;
use umbragraph::low_level::source::Sources;

use crate::places::Places;

/// The display colour of a severity.
pub(crate) fn color_of(severity: Severity) -> Color32 {
    match severity {
        Severity::Error => Color32::from_rgb(240, 120, 110),
        Severity::Warning => Color32::from_rgb(240, 190, 96),
        Severity::Note => Color32::from_rgb(130, 180, 240),
    }
}

/// A request of the user by a click on a diagnostic.
pub(crate) enum Wish {
    /// Opens a source location, `file:line`.
    Open(String),
    /// Applies the fix of a diagnostic to its sources.
    Mend(Diagnostic, Sources),
}

/// Formats a source location as `file:line`; `None` if there is none.
pub(crate) fn place_of(place: &Place, sources: &Sources) -> Option<String> {
    match place {
        Place::Span(span) => {
            let file = sources.get(span.file)?;
            Some(format!("{}:{}", file.name(), file.line_column(span.start).line))
        }
        Place::File { path, .. } => Some(format!("{path}:1")),
        Place::Nowhere => None,
    }
}

/// Shows a list of diagnostics, which are numbered from `first` on. Returns the user's request, if any.
pub(crate) fn show<'a>(
    ui: &mut egui::Ui,
    diagnostics: impl Iterator<Item = &'a Diagnostic>,
    first: usize,
    sources: &Sources,
    places: &mut Places,
) -> Option<Wish> {
    let mut wish = None;
    for (at, one) in (first..).zip(diagnostics) {
        ui.horizontal(|ui| {
            let word = RichText::new(format!("{}[{}]", one.severity.name(), one.code.id)).strong();
            ui.label(word.color(color_of(one.severity)));
            if let Some(place) = place_of(&one.place, sources) {
                let link = ui.link(&place).on_hover_text("Open in the editor");
                places.note(&format!("open {at}"), &link);
                if link.clicked() {
                    wish = Some(Wish::Open(place));
                }
            }
            if one.fix.is_some() {
                let mend = ui.small_button("Mend").on_hover_text("Apply the one way to mend it");
                places.note(&format!("mend {at}"), &mend);
                if mend.clicked() {
                    wish = Some(Wish::Mend(one.clone(), sources.clone()));
                }
            }
        });
        ui.label(&one.message);
        if let Some(span) = one.span() {
            line(ui, sources, span);
        }
        for related in &one.related {
            let place = place_of(&related.place, sources).unwrap_or_default();
            ui.label(RichText::new(format!("{place} {}", related.message)).small());
        }
        if let Some(help) = &one.help {
            ui.label(RichText::new(format!("Help: {help}")).weak());
        }
        ui.add_space(6.0);
    }
    wish
}

/// Shows the source line of a span, with the span underlined.
fn line(ui: &mut egui::Ui, sources: &Sources, span: umbragraph::low_level::source::Span) {
    let Some(file) = sources.get(span.file) else { return };
    let text = file.text();
    let [start, end] = [span.start as usize, span.end as usize];
    let first = text.get(..start).and_then(|before| before.rfind('\n')).map_or(0, |at| at + 1);
    let last = text.get(start..).and_then(|after| after.find('\n')).map_or(text.len(), |at| start + at);
    let end = end.clamp(start, last.max(start));
    let (Some(before), Some(marked), Some(after)) =
        (text.get(first..start), text.get(start..end), text.get(end..last))
    else {
        return;
    };
    let mut job = egui::text::LayoutJob::default();
    let font = egui::TextStyle::Monospace.resolve(ui.style());
    let plain = egui::TextFormat::simple(font.clone(), ui.visuals().text_color());
    let strong = egui::TextFormat {
        underline: egui::Stroke::new(1.5, color_of(Severity::Error)),
        ..egui::TextFormat::simple(font, ui.visuals().strong_text_color())
    };
    let number = file.line_column(span.start).line;
    for (text, format) in [
        (format!("{number:4} │ "), &plain),
        (before.to_owned(), &plain),
        (marked.to_owned(), &strong),
        (after.to_owned(), &plain),
    ] {
        job.append(&text, 0.0, format.clone());
    }
    ui.label(job);
}

/// Starts the editor at a source location, `file:line`. Returns a notice for the user.
///
/// # Errors
/// An error message if the command cannot be started.
pub(crate) fn open_editor(command: &str, place: &str) -> Result<String, String> {
    let (file, line) = place.rsplit_once(':').unwrap_or((place, "1"));
    let words = command.split_whitespace().map(|word| word.replace("{file}", file).replace("{line}", line));
    let words: Vec<String> = words.collect();
    let (program, arguments) = words.split_first().ok_or("--editor names no command")?;
    let mut started = Command::new(program);
    started.args(arguments).stdin(Stdio::null());
    let mut child = started.spawn().map_err(|error| format!("\"{program}\" cannot be started: {error}"))?;
    // An editor may live as long as it likes.
    std::thread::spawn(move || child.wait());
    Ok(format!("opened {place}"))
}

/// Applies the fix of a diagnostic to its files. Returns a notice for the user.
///
/// # Errors
/// An error message if a file has changed since the diagnostic or cannot be written.
pub(crate) fn mend(diagnostic: &Diagnostic, sources: &Sources) -> Result<String, String> {
    let is_writable = |name: &str| Path::new(name).is_file();
    let mends = edit::mend([diagnostic], sources, is_writable);
    if mends.is_empty() {
        return Err("the mend changes a file that comes with the module".to_owned());
    }
    let mut names = Vec::new();
    for (name, edits) in mends {
        let known =
            sources.find(&name).and_then(|file| sources.get(file)).map(|file| file.text().to_string());
        let known = known.unwrap_or_default();
        let text = edits.apply(&known).map_err(|_| format!("{name} was changed meanwhile"))?;
        replace_if(Path::new(&name), &known, &text).map_err(|found| found.message)?;
        names.push(name);
    }
    Ok(format!("mended {}", names.join(", ")))
}
