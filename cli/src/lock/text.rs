//! The text of a lock.
//!
//! One value of interest a line, sections sorted by the names of their passes, an empty line between sections: what two
//! branches change in different passes merges by itself. Axes with one value share lines, since most axes of a pass
//! have only one. A lock whose lines make no sense is a diagnostic at the first of them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::ops::Range;

use umbragraph::low_level::shader::{AxisValue, AxisValues};

use super::{Lock, Pipeline, Section, Texts, Worst};

/// The version of the lock file format.
const VERSION: u32 = 1;
/// The maximum number of characters in a line with several axes.
const WIDTH: usize = 100;
/// The minimum number of consecutive integers that are written as a range.
const MANY: usize = 4;

/// A parsed lock, with the byte ranges of its parts in the file's text.
#[derive(Debug, Default)]
pub(crate) struct Parsed {
    pub(crate) lock: Lock,
    /// The byte ranges of the pipeline lines, by pipeline.
    pub(crate) pipelines: BTreeMap<String, Range<usize>>,
    /// The byte ranges of the pass lines, by pipeline and pass.
    pub(crate) passes: BTreeMap<(String, String), Range<usize>>,
}

/// A text that is no valid lock: the byte range of the error, the message, and the pipelines that the text names.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Invalid {
    pub(crate) range: Range<usize>,
    pub(crate) message: String,
    pub(crate) pipelines: BTreeSet<String>,
}

impl Lock {
    /// Returns the text of the lock file.
    pub(crate) fn text(&self) -> String {
        let mut text = format!(
            "# Shaders that pipelines reach. `umbragraph permutations PIPELINE... --update` writes this file,\n# and solves a \
             merge conflict in it.\nversion {VERSION}\n"
        );
        for (path, pipeline) in &self.pipelines {
            let all = pipeline.profiles();
            // Writing to a string cannot fail.
            let _ = write!(text, "\npipeline {path}\nprofiles {}\n", list(&all));
            for section in pipeline.sections() {
                let _ = write!(text, "\npass {}\ntemplate {}\n", list(&section.passes), section.template);
                if section.profiles.len() < all.len() {
                    let _ = writeln!(text, "profiles {}", list(&section.profiles));
                }
                figures(&mut text, &section.texts);
            }
        }
        text
    }
}

fn figures(text: &mut String, texts: &Texts) {
    let mut fixed = String::new();
    for (axis, values) in &texts.axes {
        let pair = format!("{axis} = {}", written(values));
        if values.len() > 1 {
            let _ = writeln!(text, "  {pair}");
        } else if fixed.is_empty() {
            fixed = format!("  fixed {pair}");
        } else if fixed.rsplit('\n').next().map_or(0, str::len) + pair.len() + 2 > WIDTH {
            let _ = write!(fixed, "\n  fixed {pair}");
        } else {
            let _ = write!(fixed, ", {pair}");
        }
    }
    if !fixed.is_empty() {
        let _ = writeln!(text, "{fixed}");
    }
    let Texts { combinations, texts, declarations, bytes, hash, largest, bindings, registers, worst, .. } =
        texts;
    let Worst { cost, entry_point, values } = worst;
    let _ = writeln!(
        text,
        "  largest {largest}; bindings {bindings}; registers {registers}; cost {cost} of {entry_point}{}",
        with_values(values)
    );
    let _ = writeln!(
        text,
        "  combinations {combinations}; texts {texts}; declarations {declarations}; bytes {bytes}; hash {hash}"
    );
}

fn list<S: AsRef<str>>(names: &BTreeSet<S>) -> String {
    names.iter().map(AsRef::as_ref).collect::<Vec<&str>>().join(", ")
}

/// Formats an axis value as JSON.
fn value(value: &AxisValue) -> String {
    match value {
        AxisValue::Name(name) => serde_json::Value::from(name.as_str()).to_string(),
        other => other.to_string(),
    }
}

/// Formats axis values as ` with a = 1, b = "x"`; empty if there are no values.
pub(crate) fn with_values(values: &AxisValues) -> String {
    let pairs: Vec<String> = values.iter().map(|(axis, one)| format!("{axis} = {}", value(one))).collect();
    if pairs.is_empty() { String::new() } else { format!(" with {}", pairs.join(", ")) }
}

/// Formats a set of axis values; consecutive integers as `1..8`.
pub(super) fn written(values: &BTreeSet<AxisValue>) -> String {
    let values: Vec<&AxisValue> = values.iter().collect();
    let mut parts: Vec<String> = Vec::new();
    let mut at = 0;
    while let Some(first) = values.get(at) {
        let follows = |pair: &&[&AxisValue]| match pair {
            [AxisValue::Integer(a), AxisValue::Integer(b)] => a.checked_add(1) == Some(*b),
            _ => false,
        };
        let run = 1 + values[at..].windows(2).take_while(follows).count();
        if run >= MANY
            && let Some(last) = values.get(at + run - 1)
        {
            parts.push(format!("{first}..{last}"));
            at += run;
        } else {
            parts.push(value(first));
            at += 1;
        }
    }
    parts.join(", ")
}

impl Parsed {
    /// Parses the text of a lock file.
    ///
    /// # Errors
    /// The first invalid line.
    pub(crate) fn new(text: &str) -> Result<Self, Invalid> {
        let named = |line: &str| Some(line.strip_prefix("pipeline ")?.trim_end().to_owned());
        let invalid = |range: Range<usize>, message: String| Invalid {
            range,
            message,
            pipelines: text.lines().filter_map(named).collect(),
        };
        let mut reader = Reader::default();
        let mut at = 0;
        for whole in text.split_inclusive('\n') {
            let line = whole.trim_end();
            let range = at..at + line.len();
            at += whole.len();
            reader.line(line, range.clone()).map_err(|message| invalid(range, message))?;
        }
        if !reader.has_version {
            return Err(invalid(0..0, format!("no line says \"version {VERSION}\"")));
        }
        reader.end().map_err(|message| invalid(at..at, message))?;
        Ok(reader.parsed)
    }
}

#[derive(Default)]
struct Reader {
    parsed: Parsed,
    has_version: bool,
    /// The current pipeline's path, profiles and sections; `None` before the first pipeline.
    pipeline: Option<(String, BTreeSet<String>, Vec<Section>)>,
    section: Option<Section>,
    /// Whether the lines `combinations` and `largest` of the current section have been read.
    has: [bool; 2],
}

impl Reader {
    fn line(&mut self, line: &str, range: Range<usize>) -> Result<(), String> {
        if ["<<<<<<<", "=======", ">>>>>>>", "|||||||"].iter().any(|marker| line.starts_with(marker)) {
            return Err(format!("\"{line}\" marks a merge conflict"));
        }
        if line.is_empty() || line.starts_with('#') {
            return Ok(());
        }
        let (word, rest) = line.trim_start().split_once(' ').unwrap_or((line, ""));
        if !self.has_version {
            if word != "version" {
                return Err(format!("\"{line}\" stands before the version"));
            }
            if rest.parse() != Ok(VERSION) {
                return Err(format!(
                    "the lock has version {rest}, and this program writes version {VERSION}"
                ));
            }
            self.has_version = true;
            return Ok(());
        }
        // An axis may have any name.
        if line.starts_with("  ") && rest.starts_with("= ") {
            return self.axes(line, &[line.trim_start()]);
        }
        match word {
            "pipeline" => {
                self.end()?;
                if self.parsed.pipelines.insert(rest.to_owned(), range).is_some() {
                    return Err(format!("the pipeline {rest} stands twice"));
                }
                self.pipeline = Some((rest.to_owned(), BTreeSet::new(), Vec::new()));
            }
            "pass" => {
                self.end_section()?;
                let passes = names(rest);
                let (path, profiles, _) =
                    self.pipeline.as_ref().ok_or("a pass stands before its pipeline")?;
                for pass in &passes {
                    self.parsed.passes.entry((path.clone(), pass.clone())).or_insert(range.clone());
                }
                self.section = Some(Section {
                    passes,
                    template: String::new(),
                    profiles: profiles.clone(),
                    texts: Texts {
                        axes: BTreeMap::new(),
                        combinations: String::new(),
                        texts: 0,
                        declarations: 0,
                        bytes: 0,
                        hash: String::new(),
                        largest: 0,
                        bindings: 0,
                        registers: 0,
                        worst: Worst::default(),
                    },
                });
            }
            "profiles" => match (&mut self.section, &mut self.pipeline) {
                (Some(section), _) => section.profiles = names(rest),
                (None, Some((_, profiles, _))) => *profiles = names(rest),
                (None, None) => return Err("profiles stand before their pipeline".to_owned()),
            },
            _ => self.of_section(line, word, rest)?,
        }
        Ok(())
    }

    /// Parses a line that belongs to a section of passes.
    fn of_section(&mut self, line: &str, word: &str, rest: &str) -> Result<(), String> {
        let not_understood = || format!("\"{}\" is not a valid line of a lock", line.trim_start());
        let number = |part: &str, name: &str| -> Result<usize, String> {
            let number = part.strip_prefix(name).and_then(|number| number.trim_start().parse().ok());
            number.ok_or_else(not_understood)
        };
        let section = self.section.as_mut().ok_or_else(not_understood)?;
        match word {
            "template" => section.template = rest.to_owned(),
            "combinations" => {
                let parts: Vec<&str> = rest.split("; ").collect();
                let [combinations, texts, declarations, bytes, hash] = parts[..] else {
                    return Err(not_understood());
                };
                let own = &mut section.texts;
                own.combinations = combinations.to_owned();
                own.texts = number(texts, "texts")?;
                own.declarations = number(declarations, "declarations")?;
                own.bytes = number(bytes, "bytes")?;
                own.hash = hash.strip_prefix("hash ").ok_or_else(not_understood)?.to_owned();
                self.has[0] = true;
            }
            "largest" => {
                let (figures, values) = rest.split_once(" with ").unwrap_or((rest, ""));
                let figures: Vec<&str> = figures.split("; ").collect();
                let [largest, bindings, registers, cost] = figures[..] else { return Err(not_understood()) };
                let (cost, entry_point) = cost.split_once(" of ").ok_or_else(not_understood)?;
                let own = &mut section.texts;
                own.largest = largest.parse().map_err(|_| not_understood())?;
                own.bindings = number(bindings, "bindings")?;
                own.registers = number(registers, "registers")? as u64;
                let cost = number(cost, "cost")? as u64;
                let mut worst = Worst { cost, entry_point: entry_point.to_owned(), ..Worst::default() };
                for pair in parts(values).into_iter().filter(|pair| !pair.is_empty()) {
                    let (axis, value) = pair.split_once(" = ").ok_or_else(not_understood)?;
                    let value = serde_json::from_str(value).map_err(|_| not_understood())?;
                    worst.values.insert(axis.to_owned(), value);
                }
                own.worst = worst;
                self.has[1] = true;
            }
            "fixed" => self.axes(line, &parts(rest))?,
            _ => return Err(not_understood()),
        }
        Ok(())
    }

    /// Parses axes with their values.
    fn axes(&mut self, line: &str, pairs: &[&str]) -> Result<(), String> {
        let not_understood = || format!("\"{}\" is not a valid line of a lock", line.trim_start());
        let section = self.section.as_mut().ok_or_else(not_understood)?;
        for pair in pairs {
            let (axis, values) = pair.split_once(" = ").ok_or_else(not_understood)?;
            let values: Option<Vec<BTreeSet<AxisValue>>> = parts(values).into_iter().map(read).collect();
            let values = values.ok_or_else(not_understood)?;
            section.texts.axes.insert(axis.to_owned(), values.into_iter().flatten().collect());
        }
        Ok(())
    }

    fn end_section(&mut self) -> Result<(), String> {
        let Some(section) = self.section.take() else { return Ok(()) };
        let has = std::mem::take(&mut self.has);
        if let Some((_, line)) = has.iter().zip(["combinations", "largest"]).find(|(has, _)| !**has) {
            return Err(format!("the pass {} has no line `{line} ...`", list(&section.passes)));
        }
        if let Some((_, _, sections)) = &mut self.pipeline {
            let is_same = |known: &Section| {
                known.template == section.template
                    && !known.passes.is_disjoint(&section.passes)
                    && !known.profiles.is_disjoint(&section.profiles)
            };
            if sections.iter().any(is_same) {
                return Err(format!("the pass {} stands twice for one profile", list(&section.passes)));
            }
            sections.push(section);
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), String> {
        self.end_section()?;
        if let Some((path, _, sections)) = self.pipeline.take() {
            self.parsed.lock.pipelines.insert(path, Pipeline::from(sections));
        }
        Ok(())
    }
}

fn names(text: &str) -> BTreeSet<String> {
    text.split(", ").filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

/// Splits a text at commas outside of double quotes.
fn parts(text: &str) -> Vec<&str> {
    let (mut is_quoted, mut is_escaped) = (false, false);
    let is_end = |each: char| {
        let ends = each == ',' && !is_quoted;
        is_quoted ^= each == '"' && !is_escaped;
        is_escaped = each == '\\' && !is_escaped;
        ends
    };
    text.split(is_end).map(str::trim).collect()
}

/// Parses an axis value or a range of integers; `None` if the text is neither.
fn read(part: &str) -> Option<BTreeSet<AxisValue>> {
    /// The maximum number of integers in a range, which bounds the memory for a damaged file.
    const MAX_RANGE: i64 = 1 << 20;
    if let Some((first, last)) = part.split_once("..").filter(|_| !part.starts_with('"')) {
        let (first, last): (i64, i64) = (first.parse().ok()?, last.parse().ok()?);
        let count = last.checked_sub(first)?;
        return (count < MAX_RANGE).then(|| (first..=last).map(AxisValue::Integer).collect());
    }
    serde_json::from_str(part).ok().map(|value: AxisValue| [value].into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lock() -> Lock {
        let names = |names: &[&str]| names.iter().map(|name| AxisValue::from(*name)).collect();
        let numbers = |numbers: &[i64]| numbers.iter().map(|number| AxisValue::from(*number)).collect();
        let axes = [
            ("filter".to_owned(), names(&["a, \"b\"", "true", "1..8"])),
            ("fixed".to_owned(), numbers(&[-3, -2, -1, 0, 7, 9])),
            ("combinations".to_owned(), numbers(&[1, 2])),
            ("one".to_owned(), [AxisValue::from(true)].into()),
            ("other".to_owned(), names(&["x, y = 1"])),
        ];
        let texts = Texts {
            axes: axes.into(),
            combinations: "at least 1,234".to_owned(),
            texts: 7,
            declarations: 9,
            bytes: 10,
            hash: "0123".to_owned(),
            largest: 9,
            bindings: 3,
            registers: 12,
            worst: Worst {
                cost: 77,
                entry_point: "shade".to_owned(),
                values: [("filter".to_owned(), AxisValue::from("a, \"b\" with c = 1"))].into(),
            },
        };
        let profiles = [("webgpu".to_owned(), texts.clone()), ("vulkan".to_owned(), texts.clone())];
        let fewer = Texts { axes: BTreeMap::new(), ..texts };
        let programs = [
            (("shade".to_owned(), "a.wgsl.jinja".to_owned()), profiles.clone().into()),
            (("again.0".to_owned(), "a.wgsl.jinja".to_owned()), profiles.into()),
            (("shade".to_owned(), "b.wgsl.jinja".to_owned()), [("webgpu".to_owned(), fewer)].into()),
        ];
        let pipeline = Pipeline { programs: programs.into() };
        Lock { pipelines: [("a folder/p.json".to_owned(), pipeline)].into() }
    }

    #[test]
    fn a_lock_is_read_as_it_was_written() {
        let lock = lock();
        let text = lock.text();
        assert_eq!(Parsed::new(&text).unwrap().lock, lock, "{text}");
        assert_eq!(Parsed::new(&text.replace('\n', "\r\n")).unwrap().lock, lock);
        assert!(text.contains("  fixed = -3..0, 7, 9\n"), "{text}");
        assert!(
            text.contains("\npass again.0, shade\ntemplate a.wgsl.jinja\n  combinations = 1, 2\n"),
            "{text}"
        );
        assert!(text.contains("\ntemplate b.wgsl.jinja\nprofiles webgpu\n  largest 9"), "{text}");
    }

    #[test]
    fn no_cut_or_changed_line_is_more_than_an_error() {
        let text = lock().text();
        for (at, _) in text.char_indices() {
            let _ = Parsed::new(&text[..at]);
            let _ = Parsed::new(&format!("{}~{}", &text[..at], &text[at..]));
        }
        let invalid = Parsed::new(&text.replace("version 1", "version 2")).unwrap_err();
        assert_eq!(invalid.message, "the lock has version 2, and this program writes version 1");
        assert_eq!(invalid.pipelines, ["a folder/p.json".to_owned()].into());
        let many = text.replace("-3..0", "-9000000000000000000..9000000000000000000");
        assert!(Parsed::new(&many).is_err());
    }
}
