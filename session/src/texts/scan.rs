//! Declarations and names in the text of a template, without a parser of WGSL.
//!
//! A template is WGSL with tags between, and may be broken, so no parser takes it. The template engine's tokenizer finds
//! the tags; after a broken one it goes on in the next line. [`Scan`] lays blanks over tags and comments, byte for byte,
//! and finds declarations by their keywords in what is left. A name that is made by a tag (`shade_{{ kind }}`) is one
//! word.
//!
//! Limits: after [`MOST_BROKEN`] broken tags the rest of a text is not looked at. `const` counts as a declaration of the
//! module outside of braces; braces that stand in one branch of a tag only make that count wrong.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use crate::graph::shader::tags::{self, Tag, TagKind, Word, WordKind};

/// The kinds of things that a template declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TemplateItem {
    /// A function of WGSL.
    Function,
    /// A structure of WGSL.
    Structure,
    /// A variable of a module: a binding, or one of an address space.
    Variable,
    /// A constant, `override` or alias.
    Constant,
    /// A member of a structure.
    Member,
    /// A macro of a template.
    Macro,
    /// A block that other templates may replace.
    Block,
}

/// A declaration in a template.
#[derive(Clone, Debug)]
pub(crate) struct Declared {
    pub(crate) kind: TemplateItem,
    /// The bytes of the name.
    pub(crate) name: Range<usize>,
    /// The bytes of the declaration with its attributes and body.
    pub(crate) whole: Range<usize>,
    /// The bytes of what a reader needs of the declaration: a function without its body.
    pub(crate) signature: Range<usize>,
}

/// The maximum number of broken tags after which a text is read on.
const MOST_BROKEN: usize = 16;

/// The tags and the literal text of a template, in source order.
#[derive(Debug, Default)]
pub(crate) struct Tags {
    pub(crate) tags: Vec<Tag>,
    literals: Vec<Range<usize>>,
}

impl Tags {
    pub(crate) fn of(text: &str) -> Self {
        let (mut all, mut at) = (Self::default(), 0);
        for _ in 0..=MOST_BROKEN {
            let moved = |range: &Range<usize>| at + range.start..at + range.end;
            let Some(rest) = text.get(at..) else { break };
            let found = tags::scan(rest);
            let broken = found.tags.iter().position(|tag| is_broken(rest, tag));
            let whole = broken.map_or(rest.len(), |broken| found.tags[broken].range.start);
            let literals = found.literals.iter().filter(|range| range.start < whole);
            all.literals.extend(literals.map(moved));
            all.tags.extend(found.tags.into_iter().take(broken.map_or(usize::MAX, |at| at + 1)).map(
                |mut tag| {
                    tag.range = moved(&tag.range);
                    tag.words.iter_mut().for_each(|word| word.range = moved(&word.range));
                    tag
                },
            ));
            let Some(last) = all.tags.last_mut().filter(|_| broken.is_some()) else { break };
            // It ends with its line.
            let end = text[last.range.start..].find('\n').map_or(text.len(), |end| last.range.start + end);
            last.range.end = end;
            last.words.retain(|word| word.range.end <= end);
            at = end;
        }
        all
    }

    /// The names of the templates that tags name, with their bytes.
    pub(crate) fn templates<'t>(&self, text: &'t str) -> impl Iterator<Item = (&'t str, Range<usize>)> {
        self.tags.iter().filter_map(move |tag| template(text, tag))
    }
}

/// Returns `true` for a tag that ends with its closing delimiter.
fn is_closed(text: &str, tag: &Tag) -> bool {
    let close = if tag.kind == TagKind::Block { "%}" } else { "}}" };
    text[tag.range.clone()].ends_with(close)
}

/// Returns `true` for a tag without an end, or whose end is that of another tag.
fn is_broken(text: &str, tag: &Tag) -> bool {
    let is_in_string =
        |at: usize| tag.words.iter().any(|word| word.kind == WordKind::Text && word.range.contains(&at));
    let start = tag.range.start + 2;
    let mut others = text[start.min(tag.range.end)..tag.range.end].match_indices("{%");
    !is_closed(text, tag) || others.any(|(at, _)| !is_in_string(start + at))
}

/// The template that a tag names, in `include`, `import`, `from` and `extends`, and the bytes of the name.
pub(crate) fn template<'t>(text: &'t str, tag: &Tag) -> Option<(&'t str, Range<usize>)> {
    if !["include", "import", "from", "extends"].contains(&text.get(tag.words.first()?.range.clone())?) {
        return None;
    }
    let written = &tag.words.iter().find(|word| word.kind == WordKind::Text)?.range;
    let name = written.start + 1..written.end - 1;
    Some((text.get(name.clone())?, name))
}

/// The text of a template with its tags. The rest is found when it is first asked for.
#[derive(Debug)]
pub(crate) struct Text {
    pub(crate) text: Arc<str>,
    pub(crate) tags: Tags,
    found: OnceLock<(String, Vec<Declared>)>,
}

impl Text {
    pub(crate) fn new(text: Arc<str>) -> Self {
        Self { tags: Tags::of(&text), text, found: OnceLock::new() }
    }

    pub(crate) fn scan(&self) -> Scan<'_> {
        let Self { text, tags, found } = self;
        let (flat, declared) = found.get_or_init(|| {
            let flat = flattened(text, tags);
            let mut declared = declarations(text, &flat);
            declared.extend(tags.tags.iter().filter_map(|tag| declared_by(text, tag)));
            declared.sort_by_key(|one| one.name.start);
            (flat, declared)
        });
        Scan { text, flat, tags: &tags.tags, declared }
    }
}

/// A template's text with what was found in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scan<'t> {
    pub(crate) text: &'t str,
    /// The WGSL of the text: comments and tags are blanks, and tags of values are part of the word around them.
    pub(crate) flat: &'t str,
    pub(crate) tags: &'t [Tag],
    pub(crate) declared: &'t [Declared],
}

impl<'t> Scan<'t> {
    pub(crate) fn name(&self, declared: &Declared) -> &'t str {
        &self.text[declared.name.clone()]
    }

    /// The tag that contains a byte, delimiters left out.
    pub(crate) fn tag_at(&self, offset: usize) -> Option<&'t Tag> {
        let end = |tag: &Tag| tag.range.end - if is_closed(self.text, tag) { 2 } else { 0 };
        self.tags.iter().find(|tag| (tag.range.start + 2..=end(tag)).contains(&offset))
    }

    /// Returns `true` for a byte within a comment, of the template or of WGSL.
    pub(crate) fn is_comment(&self, offset: usize) -> bool {
        let Some(before) = self.text.get(..offset) else { return false };
        [("{#", "#}"), ("/*", "*/"), ("//", "\n")].iter().any(|(open, close)| {
            before.rfind(open).is_some_and(|start| {
                self.flat[start..].starts_with("  ") && !before[start + open.len()..].contains(close)
            })
        })
    }

    /// The word of WGSL at a byte, or before it.
    pub(crate) fn word_at(&self, offset: usize) -> Range<usize> {
        word_at(self.flat, offset)
    }

    /// Returns `true` for a word that names a member of a structure: after a dot, or where it is declared.
    pub(crate) fn is_member(&self, range: &Range<usize>) -> bool {
        let is_declared = |one: &Declared| one.kind == TemplateItem::Member && one.name == *range;
        self.flat[..range.start].ends_with('.') || self.declared.iter().any(is_declared)
    }

    /// All occurrences of a name in the WGSL. Names of attributes and of their built-in values are left out.
    pub(crate) fn words<'s>(self, word: &'s str) -> impl Iterator<Item = Range<usize>> + use<'s, 't> {
        let is_it = move |range: &Range<usize>| {
            &self.text[range.clone()] == word && !is_of_attribute(&self.flat[..range.start])
        };
        words(self.flat).filter(is_it)
    }

    /// All names that tags write together with text or other tags, such as `shade_{{ kind }}`.
    pub(crate) fn generated(self) -> impl Iterator<Item = &'t str> {
        words(self.flat).map(move |range| &self.text[range]).filter(|word| word.contains("{{"))
    }

    /// All occurrences of a name within tags.
    pub(crate) fn words_of_tags<'s>(self, name: &'s str) -> impl Iterator<Item = Range<usize>> + use<'s, 't> {
        let words = self.tags.iter().flat_map(|tag| &tag.words);
        let is_it =
            move |word: &&Word| word.kind == WordKind::Identifier && &self.text[word.range.clone()] == name;
        words.filter(is_it).map(|word| word.range.clone())
    }

    /// The function that contains a byte.
    pub(crate) fn function_at(&self, offset: usize) -> Option<&'t Declared> {
        let is_it = |one: &&Declared| {
            one.kind == TemplateItem::Function && (one.name.end..=one.whole.end).contains(&offset)
        };
        self.declared.iter().rfind(is_it)
    }

    /// The bytes of a local name's declaration: the last before the use at `offset`, in the same function.
    pub(crate) fn local(&self, word: &str, offset: usize) -> Option<Range<usize>> {
        let function = self.function_at(offset)?;
        let mut found = None;
        let mut before = "";
        for range in words(self.flat).skip_while(|range| range.start < function.name.end) {
            if range.start > offset {
                break;
            }
            let this = &self.text[range.clone()];
            let is_declared = ["let", "var", "const", "function"].contains(&before)
                || self.flat[range.end..].trim_start().starts_with(':')
                    && range.end <= function.signature.end;
            if this == word && is_declared {
                found = Some(range.clone());
            }
            before = this;
        }
        found
    }

    /// The lines of comments directly before a declaration.
    pub(crate) fn comment(&self, declared: &Declared) -> String {
        let before = &self.text[..declared.whole.start];
        let trimmed = before.trim_end();
        // A comment of the template that ends on the line before.
        let is_next = !before[trimmed.len()..].contains("\n\n") && trimmed.ends_with("#}");
        if is_next && let Some(start) = trimmed.rfind("{#").filter(|start| self.is_comment(start + 2)) {
            let inner = trimmed[start + 2..].trim_end_matches("#}").trim_matches(['-', '+']);
            return inner.lines().map(str::trim).collect::<Vec<_>>().join("\n").trim().to_owned();
        }
        let mut lines: Vec<&str> = Vec::new();
        let complete = before.rfind('\n').map_or("", |end| &before[..end]);
        for line in complete.lines().rev() {
            let Some(comment) = line.trim().strip_prefix("//") else { break };
            lines.push(comment.trim_start_matches('/').trim());
        }
        lines.reverse();
        lines.join("\n")
    }
}

/// Returns `true` where the next word is an attribute, such as `@vertex`, or the built-in value that one names.
fn is_of_attribute(before: &str) -> bool {
    before.ends_with('@') || ["@builtin(", "@interpolate("].iter().any(|one| before.trim_end().ends_with(one))
}

/// Returns `true` for a character of WGSL names as templates write them.
pub(crate) fn is_of_name(sign: char) -> bool {
    sign.is_ascii_alphanumeric() || sign == '_'
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte >= 0x80
}

/// The word at a byte, or before it; empty where there is none.
pub(crate) fn word_at(text: &str, offset: usize) -> Range<usize> {
    let bytes = text.as_bytes();
    let offset = offset.min(bytes.len());
    let start = bytes[..offset].iter().rposition(|byte| !is_word(*byte)).map_or(0, |at| at + 1);
    let end = bytes[offset..].iter().position(|byte| !is_word(*byte)).map_or(bytes.len(), |at| offset + at);
    start..end
}

/// All words of a text. Numbers are words, too.
fn words(text: &str) -> impl Iterator<Item = Range<usize>> + '_ {
    let bytes = text.as_bytes();
    let mut at = 0;
    std::iter::from_fn(move || {
        at += bytes.get(at..)?.iter().position(|byte| is_word(*byte))?;
        let start = at;
        at += bytes[at..].iter().position(|byte| !is_word(*byte)).unwrap_or(bytes.len() - at);
        Some(start..at)
    })
}

/// Lays blanks over all that is no WGSL, and `_` over tags of values; line breaks stay.
fn flattened(text: &str, tags: &Tags) -> String {
    let bytes = text.as_bytes();
    let mut flat: Vec<u8> = bytes.iter().map(|byte| if *byte == b'\n' { b'\n' } else { b' ' }).collect();
    let fill = |flat: &mut [u8], range: Range<usize>, sign: u8| {
        flat[range].iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = sign);
    };
    for range in &tags.literals {
        flat[range.clone()].copy_from_slice(&bytes[range.clone()]);
    }
    for tag in tags.tags.iter().filter(|tag| tag.kind == TagKind::Expression) {
        fill(&mut flat, tag.range.clone(), b'_');
    }
    let mut at = 0;
    while at < flat.len() {
        let end = match &flat[at..] {
            [b'/', b'/', rest @ ..] => {
                rest.iter().position(|byte| *byte == b'\n').map_or(flat.len(), |end| at + 2 + end)
            }
            [b'/', b'*', ..] => comment_end(&flat, at),
            _ => {
                at += 1;
                continue;
            }
        };
        fill(&mut flat, at..end, b' ');
        at = end;
    }
    // Literal text and comments begin and end with whole characters.
    String::from_utf8_lossy(&flat).into_owned()
}

/// The byte after a block comment, which may hold others.
fn comment_end(bytes: &[u8], start: usize) -> usize {
    let (mut depth, mut at) = (0_usize, start);
    while at < bytes.len() {
        match &bytes[at..] {
            [b'/', b'*', ..] => (depth, at) = (depth + 1, at + 2),
            [b'*', b'/', ..] => (depth, at) = (depth.saturating_sub(1), at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            return at;
        }
    }
    bytes.len()
}

/// The declarations of WGSL.
fn declarations(text: &str, flat: &str) -> Vec<Declared> {
    let mut found = Vec::new();
    let (mut depth, mut last) = (0_i32, 0);
    let mut all = words(flat).peekable();
    while let Some(keyword) = all.next() {
        let between = &flat.as_bytes()[last..keyword.start];
        for byte in between {
            match byte {
                b'{' => depth += 1,
                b'}' => depth = (depth - 1).max(0),
                _ => {}
            }
        }
        last = keyword.end;
        let kind = match &flat[keyword.clone()] {
            "fn" => TemplateItem::Function,
            "struct" => TemplateItem::Structure,
            "alias" | "override" => TemplateItem::Constant,
            "const" if depth == 0 => TemplateItem::Constant,
            "var" if is_of_module(flat, &keyword) => TemplateItem::Variable,
            _ => continue,
        };
        let after = match flat[keyword.end..].trim_start().starts_with('<') && kind == TemplateItem::Variable
        {
            true => flat[keyword.end..].find('>').map_or(keyword.end, |end| keyword.end + end),
            false => keyword.end,
        };
        while all.peek().is_some_and(|next| next.start < after) {
            all.next();
        }
        let Some(name) = all.peek().cloned() else { break };
        // Only blanks lie between a keyword and the name.
        if !flat[after..name.start].trim_matches('>').trim().is_empty()
            || flat.as_bytes()[name.start].is_ascii_digit()
        {
            continue;
        }
        let start = attributes_start(flat, keyword.start);
        let body = matches!(kind, TemplateItem::Function | TemplateItem::Structure);
        let end = match body {
            true => closed(flat, name.end),
            false => flat[name.end..].find(';').map_or(name.end, |end| name.end + end + 1),
        };
        let signature = match kind {
            TemplateItem::Function => {
                keyword.start..flat[name.end..end].find('{').map_or(end, |open| name.end + open)
            }
            _ => start..end,
        };
        if kind == TemplateItem::Structure {
            members(flat, &(name.end..end), &mut found);
        }
        found.push(Declared { kind, name, whole: start..end, signature });
    }
    debug_assert!(found.iter().all(|one| text.get(one.whole.clone()).is_some()));
    found
}

/// Returns `true` for a `var` of a module: with an address space, or after an attribute.
fn is_of_module(flat: &str, keyword: &Range<usize>) -> bool {
    let space = flat[keyword.end..].trim_start();
    let spaces = ["<private", "<workgroup", "<uniform", "<storage", "<immediate"];
    spaces.iter().any(|one| space.starts_with(one)) || flat[..keyword.start].trim_end().ends_with(')')
}

/// The first byte of the attributes before a keyword.
pub(crate) fn attributes_start(flat: &str, keyword: usize) -> usize {
    let mut start = keyword;
    loop {
        let before = flat[..start].trim_end();
        let open = match before.ends_with(')') {
            true => before.rfind('(').unwrap_or(before.len()),
            false => before.len(),
        };
        let name = word_at(before, open).start.min(open);
        match name.checked_sub(1) {
            Some(at) if before.as_bytes()[at] == b'@' => start = at,
            _ => return start,
        }
    }
}

/// The byte after the brace that closes the first one that opens; the end of the line where none does.
fn closed(flat: &str, start: usize) -> usize {
    let mut depth = 0_usize;
    for (at, byte) in flat.bytes().enumerate().skip(start) {
        match byte {
            b'{' => depth += 1,
            b'}' if depth == 1 => return at + 1,
            b'}' => depth = depth.saturating_sub(1),
            b';' if depth == 0 => break,
            // The next declaration begins before this one has a body.
            b'f' | b's'
                if depth == 0 && ["fn ", "struct "].iter().any(|word| flat[at..].starts_with(word)) =>
            {
                break;
            }
            _ => {}
        }
    }
    flat[start..].find('\n').map_or(flat.len(), |end| start + end)
}

/// The members of a structure: names before a colon.
fn members(flat: &str, body: &Range<usize>, found: &mut Vec<Declared>) {
    let text = &flat[body.clone()];
    let mut depth = 0_i32;
    let mut last = 0;
    for word in words(text) {
        for byte in &text.as_bytes()[last..word.start] {
            match byte {
                b'<' | b'(' => depth += 1,
                b'>' | b')' => depth -= 1,
                _ => {}
            }
        }
        last = word.end;
        if depth == 0 && text[word.end..].trim_start().starts_with(':') {
            let name = body.start + word.start..body.start + word.end;
            let rest = &flat[name.end..body.end];
            let end = rest.find([';', '}', '\n']).unwrap_or(rest.len());
            let whole = name.start..name.end + rest[..end].trim_end().trim_end_matches(',').len();
            found.push(Declared { kind: TemplateItem::Member, name, whole: whole.clone(), signature: whole });
        }
    }
}

/// The block or macro that a tag begins.
fn declared_by(text: &str, tag: &Tag) -> Option<Declared> {
    let [keyword, name, ..] = &tag.words[..] else { return None };
    let kind = match text.get(keyword.range.clone())? {
        "block" => TemplateItem::Block,
        "macro" => TemplateItem::Macro,
        _ => return None,
    };
    let name = name.range.clone();
    Some(Declared { kind, name, whole: tag.range.clone(), signature: tag.range.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"{# File. #}
{% include "lib/a.wgsl.jinja" %}
// Doubles
// a number.
@must_use
fn double(x: f32) -> f32 {
    let twice = x * 2.0; // fn no()
    return twice;
}
/* struct Not { /* nested */ } */
struct Light {
    @align(16) color: vec3<f32>,
    range: array<f32, 2>
}
@group({{ group }}) @binding(0) var<storage, read> lights: array<Light>;
@group(1) @binding(1) var shadow_map: texture_depth_2d;
var<private> seed: u32;
{% if axis == "fn odd" %}
const LIMIT = 3u;
override size_{{ kind }}: u32 = 1u;
{% endif %}
{% macro pair(a, b) %}{{ a }}{% endmacro %}
{%- block surface -%}{% endblock %}
alias Pair = vec2<f32>;
"#;

    fn found(text: &str) -> Vec<(TemplateItem, String)> {
        let whole = Text::new(text.into());
        let scan = whole.scan();
        scan.declared.iter().map(|one| (one.kind, scan.name(one).to_owned())).collect()
    }

    #[test]
    fn declarations_are_found_between_tags_and_comments() {
        use TemplateItem::*;
        let expected = [
            (Function, "double"),
            (Structure, "Light"),
            (Member, "color"),
            (Member, "range"),
            (Variable, "lights"),
            (Variable, "shadow_map"),
            (Variable, "seed"),
            (Constant, "LIMIT"),
            (Constant, "size_{{ kind }}"),
            (Macro, "pair"),
            (Block, "surface"),
            (Constant, "Pair"),
        ];
        assert_eq!(found(TEXT), expected.map(|(kind, name)| (kind, name.to_owned())));
        let whole = Text::new(TEXT.into());
        let scan = whole.scan();
        assert_eq!(scan.comment(&scan.declared[0]), "Doubles\na number.");
        assert_eq!(&TEXT[scan.declared[0].signature.clone()], "fn double(x: f32) -> f32 ");
        assert!(TEXT[scan.declared[0].whole.clone()].starts_with("@must_use"));
        assert_eq!(whole.tags.templates(TEXT).next().map(|(name, _)| name), Some("lib/a.wgsl.jinja"));
    }

    #[test]
    fn local_names_are_those_of_their_function() {
        let whole = Text::new(TEXT.into());
        let scan = whole.scan();
        let last = TEXT.find("return twice").expect("a use") + 8;
        assert_eq!(scan.local("twice", last), TEXT.find("twice").map(|at| at..at + 5));
        assert_eq!(scan.local("x", last), TEXT.find("x: f32").map(|at| at..at + 1));
        assert_eq!(scan.local("LIMIT", last), None);
        assert_eq!(scan.words("twice").count(), 2);
        assert_eq!(scan.words_of_tags("axis").count(), 1);
        assert_eq!(scan.words_of_tags("odd").count(), 0);
    }

    #[test]
    fn texts_cut_anywhere_are_taken() {
        for end in (0..=TEXT.len()).filter(|end| TEXT.is_char_boundary(*end)) {
            let whole = Text::new(TEXT[..end].into());
            let scan = whole.scan();
            assert_eq!(scan.flat.len(), end);
            let _ = (scan.word_at(end), scan.tag_at(end), scan.local("x", end));
        }
        let text = "ä {% ö %} // ü\nfn a() {}";
        let whole = Text::new(text.into());
        let scan = whole.scan();
        assert_eq!((scan.flat.len(), scan.declared.len()), (text.len(), 1));
    }

    #[test]
    fn text_after_a_broken_tag_is_read_on() {
        for broken in ["{% if a", "{{ x", "{% if a ? %", "{% include \"a", "{{ 'a }}"] {
            let text = format!("fn a() {{}}\n{broken}\nfn b() {{}}\n{{% if c %}}fn d() {{}}{{% endif %}}");
            let names: Vec<String> = found(&text).into_iter().map(|(_, name)| name).collect();
            assert_eq!(names, ["a", "b", "d"], "{broken}");
        }
    }
}
