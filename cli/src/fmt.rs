//! `umbragraph fmt`: lays out documents.

use std::io::Read as _;
use std::path::Path;

use umbragraph::diagnostic::{Diagnostic, Diagnostics, codes, render};
use umbragraph::low_level::compose::read_bytes;
use umbragraph::low_level::document::{self, format};
use umbragraph::low_level::read_source;
use umbragraph::low_level::source::{FileId, MAX_FILE_BYTES, Sources, Span};

use crate::arguments::FmtArguments;
use crate::replace::replace;
use crate::show::SCHEME;
use crate::streams::{complain, print, print_contents, print_json};

/// The name of standard input in diagnostics.
const STANDARD_INPUT: &str = "<standard input>";

/// Formats every valid file. Returns `true` if there were no errors and, with `--check`, nothing to change.
pub(crate) fn run(arguments: &FmtArguments) -> bool {
    let mut sources = Sources::new();
    let mut diagnostics = Diagnostics::new();
    let mut canonical = true;
    for path in &arguments.files {
        match treat(path, arguments, &mut sources) {
            Ok(is_canonical) => canonical &= is_canonical,
            Err(of_file) => diagnostics.extend(of_file),
        }
    }
    complain(&render::human_all(&diagnostics, &sources));
    !diagnostics.has_errors() && (canonical || !arguments.check)
}

/// Formats or checks one file. Returns `true` if the file already had its canonical layout.
fn treat(path: &Path, arguments: &FmtArguments, sources: &mut Sources) -> Result<bool, Diagnostics> {
    if let Some(name) = path.to_str().filter(|name| name.starts_with(SCHEME)) {
        let message = format!("\"{name}\" comes with the command and is no file on the disk");
        let help = format!(
            "`umbragraph show {name} > FILE` makes a file of it, and `umbragraph show {name} | umbragraph fmt --strict -` \
             prints it as strict JSON"
        );
        return Err(Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message).help(help).into());
    }
    let is_input = path.as_os_str() == "-";
    let (file, bytes) = if is_input { read_input(sources) } else { read_file(path, sources) }?;
    if arguments.strict {
        print_json(&format::strict(&document::parse(sources, file).valid()?));
        return Ok(true);
    }
    let edits = format::format(sources, file)?;
    let text = sources.get(file).map(|file| file.text().clone()).unwrap_or_else(|| "".into());
    // A byte-order mark is no part of the text.
    let is_canonical = edits.is_empty() && bytes.len() == text.len();
    if arguments.check {
        if !is_canonical {
            let name = sources.get(file).map_or("", |file| file.name());
            print(&format!("{name}\n"));
            let laid_out = edits.apply(&text).unwrap_or_default();
            complain(&difference(name, &text, &laid_out));
        }
    } else if is_input {
        print_contents(edits.apply(&text).unwrap_or_default().as_bytes());
    } else if !is_canonical && let Ok(text) = edits.apply(&text) {
        replace(path, text)?;
    }
    Ok(is_canonical)
}

/// Describes the first line of a text that is laid out otherwise: both lines, with their number.
fn difference(name: &str, text: &str, laid_out: &str) -> String {
    let (mut old, mut new) = (text.split_inclusive('\n'), laid_out.split_inclusive('\n'));
    for number in 1.. {
        let (is, wanted) = match (old.next(), new.next()) {
            (None, None) => break,
            (is, wanted) if is == wanted => continue,
            lines => lines,
        };
        // What differs may not be seen, such as the end of a line.
        let shown = |sign, line: Option<&str>| {
            let line = line.map(|line| line.strip_suffix('\n').unwrap_or(line).replace('\r', "\\r"));
            line.map(|line| format!("{sign} {line}\n")).unwrap_or_default()
        };
        let (is_shown, wanted_shown) = (shown('-', is), shown('+', wanted));
        let is_end = is_shown.get(1..) == wanted_shown.get(1..);
        let end = if is_end { "\\ the last line has no line end\n" } else { "" };
        return format!("{name}:{number}\n{is_shown}{wanted_shown}{end}");
    }
    format!("{name}: begins with a byte-order mark\n")
}

/// Reads a file. Returns its identifier and its bytes, which may begin with a byte-order mark that the text lacks.
fn read_file(path: &Path, sources: &mut Sources) -> Result<(FileId, Vec<u8>), Diagnostics> {
    let file = read_source(path, sources)?;
    let text = sources.get(file).map_or_else(Vec::new, |file| file.text().as_bytes().to_vec());
    let bytes = read_bytes(path, MAX_FILE_BYTES as u64).ok().flatten().unwrap_or_default();
    let unmarked = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(&bytes);
    if unmarked != text {
        let name = path.display().to_string();
        let message = format!("\"{name}\" changed while it was read");
        let diagnostic = Diagnostic::in_file(codes::FILE_UNREADABLE, &name, "", message);
        return Err(diagnostic.help("run this again").into());
    }
    Ok((file, bytes))
}

fn read_input(sources: &mut Sources) -> Result<(FileId, Vec<u8>), Diagnostics> {
    let unreadable = |code, message: String| Diagnostic::in_file(code, STANDARD_INPUT, "", message);
    let mut bytes = Vec::new();
    let max = MAX_FILE_BYTES as u64;
    std::io::stdin().lock().take(max + 1).read_to_end(&mut bytes).map_err(|error| {
        unreadable(codes::FILE_UNREADABLE, format!("standard input cannot be read: {error}"))
    })?;
    if bytes.len() as u64 > max {
        let message = format!("standard input has more than {max} bytes");
        return Err(unreadable(codes::FILE_TOO_LARGE, message).into());
    }
    match std::str::from_utf8(&bytes) {
        Ok(text) => Ok((sources.add(STANDARD_INPUT, text.strip_prefix('\u{feff}').unwrap_or(text)), bytes)),
        Err(error) => {
            let at = error.valid_up_to();
            let file = sources.add(STANDARD_INPUT, String::from_utf8_lossy(&bytes).into_owned());
            let place = Span::new(file, at..at + 1);
            Err(Diagnostic::error(codes::FILE_NOT_UTF8, place, "standard input is not UTF-8").into())
        }
    }
}
