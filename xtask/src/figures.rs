//! `cargo xtask figures`: runs the benches whose tables stand in pages, and writes the tables again.
//!
//! A page holds such a table between two comments. The first names the command:
//!
//! ```text
//! <!-- figures: cargo bench --bench session -->
//! | edit | … |
//!
//! Measured at COMMIT on MACHINE.
//! <!-- end of figures -->
//! ```
//!
//! The rows are the lines of the command's output that begin with `|`, whatever stands between them. A line `on NAME`
//! of the output names the graphics adapter. A comment that begins with `figures on a GPU:` is of a table for real
//! hardware: it is left as it is unless that adapter is named with `--gpu`.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::process;

const BEGIN: &str = "<!-- figures";
const END: &str = "<!-- end of figures -->";

/// The options that select the tables to write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Options {
    /// Selects the tables whose commands contain this text; `None` selects all.
    pub(crate) only: Option<String>,
    /// Also writes the tables for real hardware, which need a GPU.
    pub(crate) gpu: bool,
}

/// A generated table in a documentation page.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Block {
    /// The byte range of the table in the page, between the comments that mark it.
    range: std::ops::Range<usize>,
    command: String,
    needs_gpu: bool,
}

/// Writes the tables. Returns `true` if every table was written.
pub(crate) fn run(options: &Options) -> Result<bool, String> {
    let mut fine = true;
    let mut count = 0;
    for page in pages()? {
        let mut text = read(&page)?;
        for at in 0..blocks(&text).map_err(|reason| format!("{}: {reason}", page.display()))?.len() {
            // The blocks before have another length now.
            let block = blocks(&text)?.swap_remove(at);
            let is_named = options.only.as_ref().is_none_or(|only| block.command.contains(only.as_str()));
            if !is_named || block.needs_gpu && !options.gpu {
                continue;
            }
            count += 1;
            println!("{}", block.command);
            match measured(&block.command) {
                Ok(table) => {
                    text.replace_range(block.range, &table);
                    std::fs::write(&page, &text).map_err(|error| format!("{}: {error}", page.display()))?;
                }
                Err(reason) => {
                    eprintln!("{reason}; {} keeps its table", page.display());
                    fine = false;
                }
            }
        }
    }
    if count == 0 {
        return Err("no page has such a table".to_owned());
    }
    Ok(fine)
}

/// Returns the Markdown files in the folder `docs`, sorted.
fn pages() -> Result<Vec<PathBuf>, String> {
    let folder = process::workspace_root().join("docs");
    let entries = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut pages: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    pages.retain(|page| page.extension().is_some_and(|extension| extension == "md"));
    pages.sort();
    Ok(pages)
}

fn read(page: &Path) -> Result<String, String> {
    std::fs::read_to_string(page).map_err(|error| format!("{}: {error}", page.display()))
}

/// Finds the marked tables of a page.
fn blocks(text: &str) -> Result<Vec<Block>, String> {
    let mut blocks = Vec::new();
    let mut from = 0;
    while let Some(at) = text[from..].find(BEGIN) {
        let head = from + at + BEGIN.len();
        let close = text[head..].find("-->").ok_or("a comment has no end")?;
        let (whose, command) =
            text[head..head + close].split_once(':').ok_or("a comment names no command")?;
        let command = command.trim().to_owned();
        let start = head + close + "-->\n".len();
        let rest = text.get(start..).unwrap_or_default();
        // Another table before the end means that this one has none.
        let end = rest.find(END).filter(|end| !rest[..*end].contains(BEGIN));
        let end = start + end.ok_or_else(|| format!("{command}: there is no \"{END}\""))?;
        blocks.push(Block { range: start..end, command, needs_gpu: whose.contains("GPU") });
        from = end;
    }
    Ok(blocks)
}

/// Runs a command, and returns its table with a line about the machine.
fn measured(command: &str) -> Result<String, String> {
    let mut words = command.split_whitespace();
    let mut run = process::program(words.next().unwrap_or_default());
    let output = run.args(words).stderr(Stdio::inherit()).output();
    let output = output.map_err(|error| format!("{command} could not be started: {error}"))?;
    if !output.status.success() {
        return Err(format!("{command} failed ({})", output.status));
    }
    let said = String::from_utf8_lossy(&output.stdout);
    let (table, adapter) = table(&said);
    if table.is_empty() {
        return Err(format!("{command} printed no table"));
    }
    let adapter = adapter.map_or_else(String::new, |adapter| format!(", {adapter}"));
    let commit = process::output("git", &["rev-parse", "--short=8", "HEAD"]).unwrap_or_default();
    Ok(format!("{table}\nMeasured at {} on {}{adapter}.\n", commit.trim(), machine()))
}

/// Returns the tables in an output, and the adapter's name if present. A table begins with its line of column heads.
fn table(output: &str) -> (String, Option<&str>) {
    let rows: Vec<&str> = output.lines().filter(|line| line.starts_with('|')).collect();
    let mut table = String::new();
    for (at, row) in rows.iter().enumerate() {
        if at > 0 && rows.get(at + 1).is_some_and(|next| next.starts_with("|---")) {
            table.push('\n');
        }
        table += row;
        table.push('\n');
    }
    (table, output.lines().find_map(|line| line.strip_prefix("on ")))
}

/// Returns the number of hardware threads and the processor's name.
fn machine() -> String {
    let count = std::thread::available_parallelism().map_or(1, usize::from);
    let about = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = about.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or(std::env::consts::ARCH, |(_, model)| model.trim());
    format!("{count} threads of {model}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_found_between_their_comments() {
        let page = "a\n<!-- figures: cargo bench -->\n| 1 |\n<!-- end of figures -->\n\
                    <!-- figures on a GPU: cargo bench --bench frame -->\n<!-- end of figures -->\n";
        let [first, second] = &blocks(page).unwrap()[..] else { panic!("two tables") };
        assert_eq!((&page[first.range.clone()], &*first.command), ("| 1 |\n", "cargo bench"));
        assert_eq!((second.range.len(), second.needs_gpu, first.needs_gpu), (0, true, false));
        assert!(blocks("<!-- figures: cargo bench -->\n| 1 |\n").unwrap_err().contains("cargo bench"));
        let swallowed = page.replacen(END, "", 1);
        assert!(blocks(&swallowed).unwrap_err().starts_with("cargo bench:"), "{:?}", blocks(&swallowed));
    }

    #[test]
    fn rows_are_lines_with_a_bar() {
        let output = "on an adapter\n| a |\n|---|\nratio x 1\n| 1 |\n| b |\n|---|\n| 2 |\n";
        let rows = "| a |\n|---|\n| 1 |\n\n| b |\n|---|\n| 2 |\n";
        assert_eq!(table(output), (rows.to_owned(), Some("an adapter")));
    }

    #[test]
    fn every_table_of_the_pages_has_a_command_that_there_is() {
        for page in pages().unwrap() {
            for block in blocks(&read(&page).unwrap()).unwrap() {
                let bench = block.command.split_once("--bench ").map(|(_, bench)| bench);
                let bench = bench.and_then(|bench| bench.split_whitespace().next()).unwrap_or_default();
                let root = process::workspace_root();
                let files = [format!("benches/{bench}.rs"), format!("benches/{bench}/main.rs")];
                assert!(files.iter().any(|file| root.join(file).is_file()), "{}", block.command);
            }
        }
    }

    /// Pages with measured figures; the figures of other pages are values of settings.
    const MEASURED: [&str; 8] = [
        "README.md",
        "docs/accuracy.md",
        "docs/drivers.md",
        "docs/performance.md",
        "docs/shadows.md",
        "docs/trust.md",
        "docs/viewer.md",
        "docs/web.md",
    ];

    /// Returns the first number that is followed by a unit; `None` if there is none.
    fn figure(section: &str) -> Option<String> {
        const UNITS: [&str; 8] = ["ms", "s", "µs", "kB", "MB", "GB", "MiB", "%"];
        let words: Vec<&str> = section.split_whitespace().collect();
        let is_figure = |pair: &&[&str]| {
            let number = pair[0].trim_start_matches(['(', '~']).replace(',', "");
            let unit = pair[1].trim_end_matches(['.', ',', ';', ':', ')']);
            number.parse::<f64>().is_ok() && UNITS.contains(&unit)
        };
        words.windows(2).find(is_figure).map(|pair| pair.join(" "))
    }

    /// Returns `true` if a section names a command, a test, or the comment of a generated table.
    fn has_source(section: &str) -> bool {
        let text = section.split_whitespace().collect::<Vec<_>>().join(" ");
        ["`cargo ", "`umbragraph ", "the test `", "The tests `", BEGIN]
            .iter()
            .any(|source| text.contains(source))
    }

    #[test]
    fn every_figure_of_the_pages_has_a_source() {
        for page in MEASURED {
            let text = read(&process::workspace_root().join(page)).unwrap();
            for section in text.split("\n## ") {
                let head = section.lines().next().unwrap_or_default();
                let figure = figure(section).filter(|_| !has_source(section));
                assert_eq!(figure, None, "{page}, \"{head}\": no command or test stands beside it");
            }
        }
    }

    #[test]
    fn a_figure_without_a_source_is_found() {
        assert_eq!(figure("It takes (1,200 ms), or more.").as_deref(), Some("(1,200 ms),"));
        assert!(figure("four of 12 maps").is_none());
        assert!(has_source("measured by\n`cargo\nbench`") && !has_source("it takes 12 ms"));
    }
}
