//! Answers for editors in templates: what stands at a byte, where it is declared and used, what can stand there.
//!
//! A template is looked at with its *unit*: the templates that it includes, those that include it, and what these
//! include, since their texts meet in one module. Names of WGSL lead to declarations in the unit, names in tags to the
//! axes of the template and of those that include it, and a string in `include` to its template.
//!
//! Tags and declarations of a text are kept for as long as it stays ([`Texts`]).
//!
//! Limits: no types are known, so a member leads to each structure of the unit that has one of its name.

mod bound;
mod rename;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::{Candidate, CandidateKind, Expected, Hover};
use crate::cancel::Cancelled;
use crate::choice::Target;
use crate::graph::diagnostic::{Diagnostic, Diagnostics};
use crate::graph::language::node_kind;
use crate::graph::shader::builtins::{self, Builtin};
use crate::graph::shader::tags::{TagKind, Word, WordKind};
use crate::graph::shader::{Axes, Axis, AxisValues, TargetProfile};
use crate::graph::source::{FileId, Span};
use crate::session::Session;
use crate::texts::Texts;
pub use crate::texts::scan::TemplateItem;
use crate::texts::scan::{self, Declared, Scan};

/// A declaration of a template, for an outline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TemplateSymbol {
    /// The kind of thing that is declared.
    pub kind: TemplateItem,
    /// The name as it is written; it may hold tags.
    pub name: String,
    /// The place of the name.
    pub place: Span,
    /// The place of the declaration with its attributes and body.
    pub whole: Span,
}

/// Words that begin a statement of a template.
const STATEMENTS: [&str; 13] = [
    "if", "elif", "else", "endif", "for", "endfor", "include", "extends", "block", "endblock", "set",
    "macro", "endmacro",
];

/// Words within tags that are no names.
const OPERATORS: [&str; 9] = ["and", "or", "not", "in", "is", "import", "from", "as", "with"];

/// A template and the texts that meet in one module with it.
struct Unit<'a> {
    texts: &'a Texts,
    /// The names of the templates, that of the cursor first.
    names: Vec<&'a str>,
    scans: BTreeMap<&'a str, (FileId, Scan<'a>)>,
    /// The template of the cursor, and those that it is part of.
    roots: BTreeSet<&'a str>,
}

/// The thing that stands at a byte of a template.
enum Spot<'a> {
    /// The name of a template, in a tag.
    Template(&'a str),
    /// A word in a tag: an axis, or a name that the template sets.
    OfTag(&'a str),
    /// A word of WGSL.
    Word(&'a str),
    /// A word of WGSL after a dot.
    Member(&'a str),
}

impl<'a> Unit<'a> {
    fn new(texts: &'a Texts, file: FileId) -> Option<Self> {
        let own = texts.name(file)?;
        let (roots, names) = texts.met(own);
        let scans = names.iter().filter_map(|name| texts.scan(name).map(|found| (*name, found))).collect();
        Some(Self { texts, names, scans, roots })
    }

    fn own(&self) -> Option<&(FileId, Scan<'a>)> {
        self.scans.get(self.names.first()?)
    }

    /// All declarations of the unit, those of near templates first.
    fn declared(&self) -> impl Iterator<Item = (FileId, &Scan<'a>, &'a Declared)> {
        let scans = self.names.iter().filter_map(|name| self.scans.get(name));
        scans.flat_map(|(file, scan)| scan.declared.iter().map(move |one| (*file, scan, one)))
    }

    fn named<'s>(&'s self, name: &'s str) -> impl Iterator<Item = (FileId, &'s Scan<'a>, &'a Declared)> {
        self.declared().filter(move |(_, scan, one)| scan.name(one) == name)
    }

    /// The axes of the template at the cursor and of those that it is part of.
    fn axes(&self) -> BTreeMap<&'a str, &'a Axis> {
        let axes = self.names.iter().filter(|name| self.roots.contains(*name));
        let axes = axes.filter_map(|name| self.texts.set.axes(name)).flat_map(Axes::iter);
        axes.map(|axis| (axis.name.as_str(), axis)).collect()
    }

    /// Returns what stands at a byte of the template at the cursor, and its bytes.
    fn spot(&self, offset: usize) -> Option<(Spot<'a>, std::ops::Range<usize>)> {
        let (_, scan) = self.own()?;
        if let Some(tag) = scan.tag_at(offset) {
            if let Some((name, range)) = scan::template(scan.text, tag)
                && (range.start..=range.end).contains(&offset)
            {
                return Some((Spot::Template(name), range));
            }
            let is_here = |word: &&Word| (word.range.start..=word.range.end).contains(&offset);
            let is_name = |word: &&Word| word.kind == WordKind::Identifier;
            let range = tag.words.iter().filter(is_here).find(is_name)?.range.clone();
            let word = scan.text.get(range.clone())?;
            let is_keyword = STATEMENTS.contains(&word) || OPERATORS.contains(&word);
            return (!is_keyword).then_some((Spot::OfTag(word), range));
        }
        let range = scan.word_at(offset);
        let word = scan.text.get(range.clone()).filter(|word| !word.is_empty())?;
        if word.starts_with(|sign: char| sign.is_ascii_digit()) || scan.is_comment(offset) {
            return None;
        }
        Some((if scan.is_member(&range) { Spot::Member(word) } else { Spot::Word(word) }, range))
    }

    fn definition(&self, offset: usize) -> Vec<Span> {
        let Some(((spot, _), (file, scan))) = self.spot(offset).zip(self.own()) else { return Vec::new() };
        match spot {
            Spot::Template(name) => {
                self.texts.set.file(name).map(|file| Span::new(file, 0..0)).into_iter().collect()
            }
            Spot::OfTag(word) => {
                if let Some(axis) = self.axes().get(word) {
                    return vec![axis.span];
                }
                let declared = self.named(word).map(|(file, _, one)| Span::new(file, one.name.clone()));
                let first = scan.words_of_tags(word).next().map(|range| Span::new(*file, range));
                let declared: Vec<Span> = declared.collect();
                if declared.is_empty() { first.into_iter().collect() } else { declared }
            }
            Spot::Word(word) => match scan.local(word, offset) {
                Some(range) => vec![Span::new(*file, range)],
                None => self.spans(word, |kind| kind != TemplateItem::Member),
            },
            Spot::Member(word) => self.spans(word, |kind| kind == TemplateItem::Member),
        }
    }

    fn spans(&self, word: &str, is_it: impl Fn(TemplateItem) -> bool) -> Vec<Span> {
        let found = self.named(word).filter(|(_, _, one)| is_it(one.kind));
        found.map(|(file, _, one)| Span::new(file, one.name.clone())).collect()
    }

    fn references(&self, offset: usize) -> Vec<Span> {
        let Some(((spot, _), (file, scan))) = self.spot(offset).zip(self.own()) else { return Vec::new() };
        let mut places = self.definition(offset);
        // The words of tags, or those of WGSL that are members of structures, or that are none.
        let everywhere = |are_members: Option<bool>, word: &'a str| {
            let scans = self.names.iter().filter_map(|name| self.scans.get(name));
            let found = scans.flat_map(move |(file, scan)| {
                let ranges: Vec<_> = match are_members {
                    None => scan.words_of_tags(word).collect(),
                    Some(wanted) => {
                        scan.words(word).filter(|range| scan.is_member(range) == wanted).collect()
                    }
                };
                ranges.into_iter().map(|range| Span::new(*file, range))
            });
            found.collect::<Vec<Span>>()
        };
        match spot {
            Spot::Template(name) => {
                places.extend(self.texts.naming(name));
            }
            Spot::OfTag(word) => places.extend(everywhere(None, word)),
            Spot::Word(word) => match scan.local(word, offset).and(scan.function_at(offset)) {
                Some(function) => {
                    let is_in = |range: &std::ops::Range<usize>| {
                        function.name.end <= range.start
                            && range.end <= function.whole.end
                            && !scan.is_member(range)
                    };
                    places.extend(scan.words(word).filter(is_in).map(|range| Span::new(*file, range)));
                }
                None if places.is_empty() => {}
                None => places.extend(everywhere(Some(false), word)),
            },
            Spot::Member(word) => places.extend(everywhere(Some(true), word)),
        }
        let mut known = BTreeSet::new();
        places.retain(|place| known.insert((place.file, place.start)));
        places
    }

    fn hover(&self, offset: usize) -> Option<Hover> {
        let (spot, range) = self.spot(offset)?;
        let (file, scan) = self.own()?;
        let text = match spot {
            Spot::Template(name) => {
                let comment = self.texts.scan(name)?.1.text.strip_prefix("{#")?;
                comment.split("#}").next()?.trim_matches(['-', '+']).trim().to_owned()
            }
            Spot::OfTag(word) => match self.axes().get(word) {
                Some(axis) => {
                    let Axis { name, kind, default, description, .. } = axis;
                    format!("axis `{name}`: {} (default {default})\n\n{description}", kind.describe())
                }
                None => self.told(word, |kind| matches!(kind, TemplateItem::Macro | TemplateItem::Block))?,
            },
            Spot::Word(word) => match scan.local(word, offset) {
                Some(range) => {
                    let line = scan.text[range.start..].lines().next().unwrap_or_default();
                    let start = scan.text[..range.start].rfind('\n').map_or(0, |at| at + 1);
                    let before = scan.text[start..range.start].trim_start();
                    let is_parameter =
                        scan.function_at(offset).is_some_and(|one| range.end <= one.signature.end);
                    match is_parameter {
                        true => code(line.split([',', ')']).next().unwrap_or_default()),
                        false => code(&format!("{before}{line}")),
                    }
                }
                None => {
                    let builtin = || {
                        let Builtin { name, signature, about } = builtins::builtin(word)?;
                        Some(format!(
                            "{}\n\nBuilt-in function of WGSL: {about}.",
                            code(&format!("{name}{signature}"))
                        ))
                    };
                    self.told(word, |kind| kind != TemplateItem::Member).or_else(builtin)?
                }
            },
            Spot::Member(word) => self.told(word, |kind| kind == TemplateItem::Member)?,
        };
        Some(Hover { place: Span::new(*file, range), text, is_preformatted: false })
    }

    /// The declarations of a name with their comments, each once.
    fn told(&self, word: &str, is_it: impl Fn(TemplateItem) -> bool) -> Option<String> {
        let own = self.own()?.0;
        let mut all: Vec<String> = Vec::new();
        for (file, scan, declared) in self.named(word).filter(|(_, _, one)| is_it(one.kind)) {
            let mut text = code(scan.text[declared.signature.clone()].trim_end());
            let comment = scan.comment(declared);
            if !comment.is_empty() && declared.kind != TemplateItem::Member {
                text.push_str(&format!("\n\n{comment}"));
            }
            if file != own {
                let name = self.names.iter().find(|name| self.texts.set.file(name) == Some(file))?;
                text.push_str(&format!("\n\nin `{name}`"));
            }
            if !all.contains(&text) {
                all.push(text);
            }
        }
        (!all.is_empty()).then(|| all.join("\n\n---\n\n"))
    }

    fn expected(&self, offset: usize) -> Option<Expected> {
        let (file, scan) = self.own()?;
        let mut list: BTreeMap<String, Candidate> = BTreeMap::new();
        let mut add = |kind, label: &str, detail: Option<String>, description: Option<String>| {
            let candidate =
                Candidate { kind, label: label.to_owned(), text: label.to_owned(), detail, description };
            list.entry(label.to_owned()).or_insert(candidate);
        };
        let replaced = match scan.tag_at(offset) {
            Some(tag) => match scan::template(scan.text, tag) {
                Some((_, range)) if (range.start..=range.end).contains(&offset) => {
                    self.texts.names().for_each(|name| add(CandidateKind::Template, name, None, None));
                    range
                }
                _ => {
                    for axis in self.axes().values() {
                        let detail = format!("{} ({})", axis.kind.describe(), axis.default);
                        add(CandidateKind::Axis, &axis.name, Some(detail), Some(axis.description.clone()));
                    }
                    let range = scan::word_at(scan.text, offset);
                    let is_first = tag.words.first().is_none_or(|first| range.start <= first.range.start);
                    if is_first && tag.kind == TagKind::Block {
                        STATEMENTS.iter().for_each(|word| add(CandidateKind::Word, word, None, None));
                    }
                    range
                }
            },
            None if scan.is_comment(offset) => return None,
            None => {
                let range = scan.word_at(offset);
                let is_member = scan.flat[..range.start].ends_with('.');
                for (_, scan, declared) in self.declared() {
                    let is_wgsl = !matches!(declared.kind, TemplateItem::Macro | TemplateItem::Block);
                    if is_wgsl && is_member == (declared.kind == TemplateItem::Member) {
                        let signature =
                            scan.text[declared.signature.clone()].lines().next().unwrap_or_default();
                        let comment = scan.comment(declared);
                        let comment = (!comment.is_empty() && !is_member).then_some(comment);
                        add(
                            CandidateKind::OfTemplate(declared.kind),
                            scan.name(declared),
                            Some(signature.trim().to_owned()),
                            comment,
                        );
                    }
                }
                for Builtin { name, signature, about } in builtins::all().filter(|_| !is_member) {
                    let detail = Some(format!("{name}{signature}"));
                    add(
                        CandidateKind::Function,
                        name,
                        detail,
                        Some(format!("Built-in function of WGSL: {about}.")),
                    );
                }
                range
            }
        };
        Some(Expected { replaced: Span::new(*file, replaced), candidates: list.into_values().collect() })
    }
}

fn code(text: &str) -> String {
    format!("```wgsl\n{text}\n```")
}

impl Session {
    /// Returns the file of a template by the path or name that its text has; `None` if no template of the session has it.
    pub fn template_file(&mut self, name: &str) -> Option<FileId> {
        let set = self.templates();
        let files = set.names().filter_map(|one| set.file(one));
        files.into_iter().find(|file| self.sources().get(*file).is_some_and(|source| source.name() == name))
    }

    fn in_template<T>(&mut self, file: FileId, answer: impl FnOnce(&Unit<'_>) -> Option<T>) -> Option<T> {
        let texts = self.template_texts();
        answer(&Unit::new(&texts, file)?)
    }

    /// Returns `true` if a pass of a pipeline names a template as its shader, or one that includes it.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn uses_template(&mut self, target: &Target, file: FileId) -> Result<bool, Cancelled> {
        let texts = self.template_texts();
        let loaded = self.load(target)?;
        let Some((own, composed)) = texts.name(file).zip(loaded.understood()) else { return Ok(false) };
        let (roots, _) = texts.met(own);
        let root = &composed.document.root;
        let of_subgraphs = root.entries_of("subgraphs").iter().map(|entry| &entry.value);
        let mut passes = of_subgraphs.chain([root]).flat_map(|value| value.entries_of("passes"));
        Ok(passes.any(|pass| {
            let shader = node_kind(&pass.value).and_then(|kind| kind.value.get("shader")?.text());
            shader.is_some_and(|shader| roots.contains(shader))
        }))
    }

    /// Returns what is wrong with a template that no pipeline uses: its syntax and, if it has an entry point, its WGSL
    /// with the default values of its axes.
    pub fn check_template(&mut self, file: FileId) -> Diagnostics {
        let (texts, templates) = (self.template_texts(), self.read_templates());
        let is_of_file = |one: &&Diagnostic| one.span().is_some_and(|span| span.file == file);
        let mut found: Diagnostics = templates.diagnostics.iter().filter(is_of_file).cloned().collect();
        let named = texts.name(file).and_then(|name| Some((name, texts.scan(name)?.1)));
        let Some((name, scan)) = named.filter(|_| !found.has_errors()) else { return found };
        let is_entry = |one: &Declared| {
            let attributes = &scan.text[one.whole.start..one.name.start];
            ["@vertex", "@fragment", "@compute"].iter().any(|stage| attributes.contains(stage))
        };
        if scan.declared.iter().any(is_entry) {
            let shaders = templates.shaders(&TargetProfile::webgpu());
            found.extend(shaders.module(name, AxisValues::new()).err().into_iter().flatten());
        }
        found
    }

    /// Returns the declarations of a template in the order of its text.
    pub fn template_symbols(&mut self, file: FileId) -> Vec<TemplateSymbol> {
        let Some(source) = self.sources().get(file) else { return Vec::new() };
        let text = scan::Text::new(source.text().clone());
        let scan = text.scan();
        let symbol = |one: &Declared| TemplateSymbol {
            kind: one.kind,
            name: scan.name(one).to_owned(),
            place: Span::new(file, one.name.clone()),
            whole: Span::new(file, one.whole.clone()),
        };
        scan.declared.iter().map(symbol).collect()
    }

    /// Returns the declarations of the name at a byte of a template: a name of WGSL, an axis, or a template that is
    /// included. Empty if there is none.
    pub fn template_definition(&mut self, file: FileId, offset: usize) -> Vec<Span> {
        self.in_template(file, |unit| Some(unit.definition(offset))).unwrap_or_default()
    }

    /// Returns the declarations and uses of the name at a byte of a template, the declarations first.
    pub fn template_references(&mut self, file: FileId, offset: usize) -> Vec<Span> {
        self.in_template(file, |unit| Some(unit.references(offset))).unwrap_or_default()
    }

    /// Returns the hover text for a byte of a template: a declaration with its comment, or an axis. `None` elsewhere.
    pub fn template_hover(&mut self, file: FileId, offset: usize) -> Option<Hover> {
        self.in_template(file, |unit| unit.hover(offset))
    }

    /// Returns the completion candidates for a byte of a template; `None` in a comment.
    pub fn template_expected(&mut self, file: FileId, offset: usize) -> Option<Expected> {
        self.in_template(file, |unit| unit.expected(offset))
    }
}

impl Session {
    /// The texts of the templates, read again where they changed.
    pub(crate) fn template_texts(&mut self) -> Arc<Texts> {
        let set = self.templates();
        match &self.texts {
            Some(known) if Arc::ptr_eq(&known.set, &set) => known.clone(),
            before => {
                let texts = Arc::new(Texts::new(set, self.sources(), before.as_deref()));
                self.texts = Some(texts.clone());
                texts
            }
        }
    }
}
