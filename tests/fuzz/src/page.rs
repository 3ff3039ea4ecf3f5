//! The table of counts in a page.

use std::path::Path;

use crate::counts::Counts;
use crate::targets::TARGETS;

const BEGIN: &str = "<!-- counts: written by `cargo xtask fuzz --page` -->\n";
const END: &str = "<!-- end of counts -->";

/// Writes the table between its marks.
pub(crate) fn write(file: &Path) -> Result<(), String> {
    let name = file.display();
    let text = std::fs::read_to_string(file).map_err(|error| format!("{name}: {error}"))?;
    let marks = text.split_once(BEGIN).and_then(|(before, rest)| Some((before, rest.split_once(END)?.1)));
    let (before, behind) = marks.ok_or_else(|| format!("{name} has no place for counts"))?;
    let text = format!("{before}{BEGIN}{}{END}{behind}", table()?);
    std::fs::write(file, text).map_err(|error| format!("{name}: {error}"))
}

fn table() -> Result<String, String> {
    let mut table = "\n| target | inputs | failed | what they are |\n|---|---|---|---|\n".to_owned();
    let mut all = 0;
    for target in TARGETS {
        let counts = Counts::of(target)?;
        all += counts.inputs;
        let (name, inputs, failed) = (target.name, grouped(counts.inputs), counts.failures.len());
        table += &format!("| `{name}` | {inputs} | {failed} | {} |\n", target.about);
    }
    table += &format!("| together | {} | | |\n\n", grouped(all));
    Ok(table)
}

/// A number with its thousands apart.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> = digits
        .as_bytes()
        .rchunks(3)
        .rev()
        .map(|group| std::str::from_utf8(group).unwrap_or_default())
        .collect();
    groups.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_stand_apart() {
        assert_eq!([0, 999, 1_000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
    }
}
