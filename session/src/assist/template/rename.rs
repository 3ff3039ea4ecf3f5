//! Renames of names that templates declare.
//!
//! A name is replaced in all texts that can see it: the *family*. It begins with the texts that meet in one module with
//! the template at the cursor, and grows by those that meet with each text that has the name, since two templates may
//! declare the name for a third that includes either of them. A local name is replaced in its function.
//!
//! A rename is refused where the text does not say enough: tags may write the name, another name would be hidden, or
//! the host knows it. Limits: no types are known, so a member is renamed only if one structure has a member of its
//! name. Comments keep the old name, and so do tests of shader functions.

use std::collections::BTreeSet;
use std::ops::Range;

use naga::keywords::wgsl::{BUILTIN_IDENTIFIERS, RESERVED};

use super::{Axes, Axis, OPERATORS, STATEMENTS, Spot, TemplateItem, Texts, Unit};
use crate::graph::shader::AxisKind;
use crate::graph::shader::tags::WordKind;
use crate::graph::source::{FileId, Span};
use crate::texts::scan::{Declared, Scan, attributes_start, is_of_name};

/// Names within tags that the template language defines.
const OF_TAGS: [&str; 7] = ["loop", "self", "super", "true", "false", "none", "caller"];
/// Names of vector components, and of members that WGSL's own structures have.
const OF_VALUES: [&str; 5] = ["fract", "whole", "exp", "old_value", "exchanged"];
/// Names of bindings that the host binds itself.
const OF_HOST: &str = "view";

/// The places of a name, and how JSON knows it.
pub(super) struct Places<'a> {
    pub(super) old: &'a str,
    pub(super) spans: Vec<Span>,
    pub(super) in_json: InJson,
    /// The templates in which the name occurs.
    pub(super) holders: BTreeSet<&'a str>,
    /// The bytes of the function that a local name belongs to.
    function: Option<Range<usize>>,
}

/// The place of a template's name in pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InJson {
    /// Pipelines do not name it.
    Nowhere,
    /// The key of a binding, under `bind`.
    Binding,
    /// A word under `entry_points`.
    EntryPoint,
}

/// The sort of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sort {
    Module,
    Member,
    Tag,
}

struct Family<'a> {
    texts: &'a Texts,
    /// The templates in which the name occurs.
    holders: BTreeSet<&'a str>,
    /// The templates that could see it.
    seen: BTreeSet<&'a str>,
}

impl<'a> Family<'a> {
    fn of(texts: &'a Texts, own: &'a str, name: &str, sort: Sort) -> Self {
        let (mut holders, mut seen) = (BTreeSet::from([own]), BTreeSet::new());
        let mut next = vec![own];
        while let Some(holder) = next.pop() {
            for met in texts.met(holder).1 {
                let is_new = seen.insert(met);
                let has =
                    || texts.scan(met).is_some_and(|(_, scan)| !occurrences(scan, name, sort).is_empty());
                if is_new && has() && holders.insert(met) {
                    next.push(met);
                }
            }
        }
        Self { texts, holders, seen }
    }

    fn scans(&self) -> impl Iterator<Item = (&'a str, FileId, Scan<'a>)> {
        let scan = |name: &&'a str| self.texts.scan(name).map(|(file, scan)| (*name, file, scan));
        self.seen.iter().filter_map(scan)
    }

    fn declared(&self) -> impl Iterator<Item = (Scan<'a>, &'a Declared)> {
        self.scans().flat_map(|(_, _, scan)| scan.declared.iter().map(move |one| (scan, one)))
    }

    fn axes(&self) -> impl Iterator<Item = &'a Axis> {
        self.seen.iter().filter_map(|name| self.texts.set.axes(name)).flat_map(Axes::iter)
    }
}

/// The occurrences of a name in a text, without those that are local to a function.
fn occurrences(scan: Scan<'_>, name: &str, sort: Sort) -> Vec<Range<usize>> {
    match sort {
        Sort::Tag => scan.words_of_tags(name).filter(|range| is_name_of_tags(scan.text, range)).collect(),
        Sort::Member => scan.words(name).filter(|range| scan.is_member(range)).collect(),
        Sort::Module => {
            let is_it = |range: &Range<usize>| {
                !scan.is_member(range)
                    && scan.local(name, range.start).is_none_or(|at| at.start > range.start)
            };
            scan.words(name).filter(is_it).collect()
        }
    }
}

/// Returns `false` for a word of a tag that names no block or macro: an attribute (`loop.first`), a filter (`| length`)
/// or a test (`is even`).
fn is_name_of_tags(text: &str, range: &Range<usize>) -> bool {
    let before = text[..range.start].trim_end();
    let last = |text: &str| -> String {
        let start = text.rfind(|c: char| !is_of_name(c)).map_or(0, |at| at + 1);
        text.get(start..).unwrap_or_default().to_owned()
    };
    match before.strip_suffix('.') {
        // Blocks are called as `self.NAME`, macros of an imported template as `ALIAS.NAME`.
        Some(object) => {
            let object = last(object.trim_end());
            let alias = format!(" as {object}");
            let is_alias = |(at, _): (usize, &str)| !text[at + alias.len()..].starts_with(is_of_name);
            object == "self" || (!object.is_empty() && text.match_indices(&alias).any(is_alias))
        }
        None => {
            let test = before.strip_suffix("not").filter(|rest| rest.ends_with(char::is_whitespace));
            !before.ends_with('|') && last(test.unwrap_or(before).trim_end()) != "is"
        }
    }
}

/// Returns `true` if a tag assigns to the name, as in `{% set NAME = 1 %}` or `half(NAME=1)`.
fn assigns(scan: Scan<'_>, name: &str) -> bool {
    scan.words_of_tags(name).any(|range| {
        let after = scan.text[range.end..].trim_start();
        after.starts_with('=') && !after.starts_with("==")
    })
}

/// Returns the name at a byte of the template at the cursor with all its places; an error says why it cannot get
/// another name. `None` if no declared name is there.
pub(super) fn places<'a>(unit: &Unit<'a>, offset: usize) -> Option<Result<Places<'a>, String>> {
    let (spot, range) = unit.spot(offset)?;
    let (file, scan) = *unit.own()?;
    let own = *unit.names.first()?;
    let (old, sort) = match spot {
        Spot::Template(_) => return None,
        Spot::OfTag(word) => (word, Sort::Tag),
        Spot::Word(word) => (word, Sort::Module),
        Spot::Member(word) => (word, Sort::Member),
    };
    if unit.definition(offset).is_empty() {
        return None;
    }
    if old.contains(['{', '}']) {
        return Some(Err(format!("tags write the name \"{old}\"; rename what they put together")));
    }
    if sort == Sort::Module && scan.local(old, offset).is_some() {
        let function = scan.function_at(offset)?;
        return Some(local(unit, old, function, scan).map(|ranges| {
            let spans = ranges.into_iter().map(|range| Span::new(file, range)).collect();
            let function = Some(function.whole.clone());
            Places { old, spans, in_json: InJson::Nowhere, holders: BTreeSet::from([own]), function }
        }));
    }
    let family = Family::of(unit.texts, own, old, sort);
    let in_json = match refused(&family, old, sort) {
        Ok(in_json) => in_json,
        Err(reason) => return Some(Err(reason)),
    };
    let mut spans = Vec::new();
    for (_, file, scan) in family.scans() {
        spans.extend(occurrences(scan, old, sort).into_iter().map(|range| Span::new(file, range)));
    }
    if !spans.contains(&Span::new(file, range)) {
        return Some(Err(format!("this \"{old}\" is another one than the declaration of that name")));
    }
    Some(Ok(Places { old, spans, in_json, holders: family.holders, function: None }))
}

/// The places of a local name: all in its function.
fn local(
    unit: &Unit<'_>,
    old: &str,
    function: &Declared,
    scan: Scan<'_>,
) -> Result<Vec<Range<usize>>, String> {
    if unit.named(old).any(|(_, _, one)| !matches!(one.kind, TemplateItem::Member | TemplateItem::Block)) {
        return Err(format!("a declaration of the module has the name \"{old}\", too"));
    }
    let is_in = |range: &Range<usize>| function.name.end <= range.start && range.end <= function.whole.end;
    let others = unit.scans.values().flat_map(|(file, scan)| {
        occurrences(*scan, old, Sort::Module).into_iter().map(move |range| (*file, range))
    });
    let own = unit.own().map(|(file, _)| *file);
    // Included texts, blocks and macros may see the names of the function that they stand in.
    if let Some((file, _)) = others.into_iter().find(|(file, range)| Some(*file) != own || !is_in(range)) {
        let name = unit.texts.name(file).unwrap_or_default();
        return Err(format!("{name} uses \"{old}\" without a declaration, and may mean this one"));
    }
    written_by_tags(unit.scans.iter().map(|(name, (_, scan))| (*name, *scan)), old)?;
    let is_input = |range: Range<usize>| {
        scan.flat[attributes_start(scan.flat, range.start)..range.start].contains("@location")
    };
    if scan.words(old).filter(is_in).any(is_input) {
        return Err(format!("\"{old}\" has a location: geometries of pipelines name such inputs"));
    }
    Ok(scan.words(old).filter(|range| is_in(range) && !scan.is_member(range)).collect())
}

/// Returns the place in JSON of a name of the module, a member or a name of tags; an error says why it is not safe to
/// rename it.
fn refused(family: &Family<'_>, old: &str, sort: Sort) -> Result<InJson, String> {
    if let Some(axis) = family.axes().find(|axis| axis.name == old) {
        return Err(format!(
            "\"{}\" is an axis: pipelines and files of axes name it; rename it there by hand",
            axis.name
        ));
    }
    let kinds: Vec<(Scan<'_>, &Declared)> =
        family.declared().filter(|(scan, one)| scan.name(one) == old && sort_of(one.kind) == sort).collect();
    if sort == Sort::Tag {
        return match kinds.is_empty() {
            true => {
                Err(format!("\"{old}\" is neither a block nor a macro; only their names are changed in tags"))
            }
            false => match family.scans().find(|(_, _, scan)| assigns(*scan, old)) {
                Some((name, ..)) => {
                    Err(format!("{name} gives a variable or an argument the name \"{old}\", too"))
                }
                None => Ok(InJson::Nowhere),
            },
        };
    }
    written_by_tags(family.scans().map(|(name, _, scan)| (name, scan)), old)?;
    let has_word =
        |axis: &&Axis| matches!(&axis.kind, AxisKind::Enum(words) if words.iter().any(|word| word == old));
    if let Some(axis) = family.axes().find(has_word) {
        return Err(format!(
            "the axis \"{}\" has the value \"{old}\", by which tags can write the name",
            axis.name
        ));
    }
    if sort == Sort::Member {
        return member(family, old, &kinds).map(|()| InJson::Nowhere);
    }
    if let Some(name) = also_local(family, old) {
        return Err(format!("{name} has a local name \"{old}\", too; rename that first"));
    }
    let of = |wanted: &[&str]| {
        kinds.iter().any(|(scan, one)| {
            let text = &scan.flat[one.whole.start..one.name.start];
            let has = |attribute: &&str| {
                text.match_indices(attribute)
                    .any(|(at, _)| !text[at + attribute.len()..].starts_with(is_of_name))
            };
            wanted.iter().any(has)
        })
    };
    let is_binding = |(scan, one): &(Scan<'_>, &Declared)| {
        one.kind == TemplateItem::Variable && scan.flat[one.whole.clone()].contains("@binding")
    };
    let bindings = kinds.iter().filter(|one| is_binding(one)).count();
    if bindings > 0 {
        let is_of_pass = |(scan, one): &(Scan<'_>, &Declared)| {
            let text = scan.text[one.whole.clone()].replace(' ', "");
            ["@group(0)", "@group(1)"].iter().any(|group| text.contains(group))
        };
        if old == OF_HOST || !kinds.iter().all(|one| is_binding(one) && is_of_pass(one)) {
            return Err(format!(
                "the host may bind \"{old}\" by its name: it is not in group 0 or 1 everywhere"
            ));
        }
        return Ok(InJson::Binding);
    }
    Ok(if of(&["@vertex", "@fragment", "@compute"]) { InJson::EntryPoint } else { InJson::Nowhere })
}

fn sort_of(kind: TemplateItem) -> Sort {
    match kind {
        TemplateItem::Member => Sort::Member,
        TemplateItem::Macro | TemplateItem::Block => Sort::Tag,
        _ => Sort::Module,
    }
}

/// Returns an error if tags may write a name: by a string, or together with text.
fn written_by_tags<'a>(scans: impl Iterator<Item = (&'a str, Scan<'a>)>, word: &str) -> Result<(), String> {
    for (name, scan) in scans {
        let mut strings =
            scan.tags.iter().flat_map(|tag| &tag.words).filter(|one| one.kind == WordKind::Text);
        if strings
            .any(|one| scan.text[one.range.clone()].split(|c: char| !is_of_name(c)).any(|part| part == word))
        {
            return Err(format!("a tag of {name} has the text \"{word}\", and may write the name"));
        }
        if let Some(written) = scan.generated().find(|written| can_be(written, word)) {
            return Err(format!("{name} writes \"{written}\", which can be \"{word}\""));
        }
    }
    Ok(())
}

/// Returns `true` if a word with tags can be written as a name. A word of nothing but tags is left out: it is a number
/// or a value of an axis.
fn can_be(written: &str, name: &str) -> bool {
    let first = written.split("{{").next().unwrap_or_default();
    let last = written.rsplit("}}").next().unwrap_or_default();
    let has_text = !(first.is_empty() && last.is_empty());
    has_text && name.len() >= first.len() + last.len() && name.starts_with(first) && name.ends_with(last)
}

/// Returns an error if a member may be one of several structures, or if the host knows its name.
fn member(family: &Family<'_>, old: &str, kinds: &[(Scan<'_>, &Declared)]) -> Result<(), String> {
    let is_swizzle =
        old.len() <= 4 && ["xyzw", "rgba"].iter().any(|all| old.chars().all(|c| all.contains(c)));
    if is_swizzle || OF_VALUES.contains(&old) {
        return Err(format!("values of WGSL's own types have a member \"{old}\", too"));
    }
    let [(scan, one)] = kinds else {
        return Err(format!(
            "{} structures have a member \"{old}\", and no types are known here",
            kinds.len()
        ));
    };
    let is_around = |other: &&Declared| {
        other.kind == TemplateItem::Structure
            && other.whole.start <= one.name.start
            && one.name.end <= other.whole.end
    };
    let Some(structure) = scan.declared.iter().find(is_around) else {
        return Err(format!("\"{old}\" is in no structure"));
    };
    let body = &scan.flat[structure.whole.clone()];
    if body.contains("@location") || body.contains("@builtin") {
        return Err(format!("pipelines and the host know the members of \"{}\"", scan.name(structure)));
    }
    // Structures that a binding has, and those of their members.
    let words = |scan: Scan<'_>, one: &Declared| -> BTreeSet<String> {
        scan.flat[one.whole.clone()].split(|c| !is_of_name(c)).map(str::to_owned).collect()
    };
    let all: Vec<_> = family.declared().collect();
    let bound = all.iter().filter(|(scan, one)| {
        one.kind == TemplateItem::Variable && scan.flat[one.whole.clone()].contains("@binding")
    });
    let mut shared: BTreeSet<String> = bound.flat_map(|(scan, one)| words(*scan, one)).collect();
    loop {
        let before = shared.len();
        for (scan, one) in &all {
            let is_type = matches!(one.kind, TemplateItem::Structure | TemplateItem::Constant);
            if is_type && shared.contains(scan.name(one)) {
                shared.extend(words(*scan, one));
            }
        }
        if shared.len() == before {
            break;
        }
    }
    match shared.contains(scan.name(structure)) {
        true => Err(format!(
            "a binding has the structure \"{}\": pipelines and the host name its members",
            scan.name(structure)
        )),
        false => Ok(()),
    }
}

/// Returns the template that has a local name which is also one of the module: scopes of functions are not told apart.
fn also_local<'a>(family: &Family<'a>, old: &str) -> Option<&'a str> {
    let is_local = |(_, _, scan): &(&str, FileId, Scan<'_>)| {
        scan.words(old).any(|range| !scan.is_member(&range) && scan.local(old, range.start).is_some())
    };
    family.scans().find(is_local).map(|(name, ..)| name)
}

/// Returns an error if a name cannot be the new one: WGSL or the template language has it, or another text that would
/// see it.
pub(super) fn is_free(unit: &Unit<'_>, places: &Places<'_>, offset: usize, new: &str) -> Result<(), String> {
    let sort = match unit.spot(offset) {
        Some((Spot::OfTag(_), _)) => Sort::Tag,
        Some((Spot::Member(_), _)) => Sort::Member,
        _ => Sort::Module,
    };
    let begins = new.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
    if !begins || !new.chars().all(is_of_name) || new == "_" || new.starts_with("__") {
        return Err(format!(
            "\"{new}\" is no name: names begin with a letter and consist of letters, digits and \"_\""
        ));
    }
    let taken = [&STATEMENTS[..], &OPERATORS, &OF_TAGS];
    let is_word = match sort {
        Sort::Tag => taken.iter().any(|words| words.contains(&new)),
        Sort::Member => RESERVED.contains(&new),
        Sort::Module => RESERVED.contains(&new) || BUILTIN_IDENTIFIERS.contains(&new) || new == OF_HOST,
    };
    if is_word {
        return Err(format!("\"{new}\" is a word of the language; choose another name"));
    }
    let mut seen: BTreeSet<&str> = unit.names.iter().copied().collect();
    for holder in &places.holders {
        seen.extend(unit.texts.met(holder).1);
    }
    let axes = seen.iter().filter_map(|name| unit.texts.set.axes(name));
    if sort != Sort::Member && axes.into_iter().any(|axes| axes.get(new).is_some()) {
        return Err(format!("\"{new}\" is an axis of the template; choose another name"));
    }
    for name in seen {
        let Some((file, scan)) = unit.texts.scan(name) else { continue };
        let has = match sort {
            Sort::Tag => scan.words_of_tags(new).next().is_some(),
            Sort::Member => scan.words(new).any(|range| scan.is_member(&range)),
            Sort::Module => hides(scan, file, places, new),
        };
        if has {
            return Err(format!("{name} has the name \"{new}\" already; choose another name"));
        }
        if sort != Sort::Tag {
            written_by_tags([(name, scan)].into_iter(), new)?;
        }
    }
    Ok(())
}

/// Returns `true` if a text has a name that the new one would hide, or that would hide the new one. A local name in a
/// function without the old name does neither.
fn hides(scan: Scan<'_>, file: FileId, places: &Places<'_>, new: &str) -> bool {
    if !occurrences(scan, new, Sort::Module).is_empty() {
        return true;
    }
    let is_near = |range: Range<usize>| {
        let function = scan.function_at(range.start).map_or(0..scan.text.len(), |one| one.whole.clone());
        let is_in = |place: &Span| place.file == file && function.contains(&(place.start as usize));
        // A text in no declaration may be in any function.
        let is_loose = |place: &Span| {
            let is_around = |one: &Declared| one.whole.contains(&(place.start as usize));
            places.function.is_none() && !scan.declared.iter().any(is_around)
        };
        places.spans.iter().any(|place| is_in(place) || place.file == file && is_loose(place))
    };
    scan.words(new).filter(|range| !scan.is_member(range)).any(is_near)
}
