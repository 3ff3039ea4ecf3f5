//! Declarations and names in the text of a template, without a parser of WGSL.
//!
//! A template is WGSL with tags between, and may be broken, so no parser takes it. [`Scan`] lays blanks over tags and
//! comments, byte for byte, and finds declarations by their keywords in what is left. A name that is made by a tag
//! (`shade_{{ kind }}`) is one word.
//!
//! Limits: `const` counts as a declaration of the module outside of braces; braces that stand in one branch of a tag
//! only make that count wrong.

use std::ops::Range;

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
pub(super) struct Declared {
    pub(super) kind: TemplateItem,
    /// The bytes of the name.
    pub(super) name: Range<usize>,
    /// The bytes of the declaration with its attributes and body.
    pub(super) whole: Range<usize>,
    /// The bytes of what a reader needs of the declaration: a function without its body.
    pub(super) signature: Range<usize>,
}

/// A tag `{% … %}`, `{{ … }}` or `{# … #}`.
#[derive(Clone, Debug)]
pub(super) struct Tag {
    pub(super) kind: TagKind,
    /// The bytes with both delimiters.
    pub(super) range: Range<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TagKind {
    Statement,
    Expression,
    Comment,
}

impl Tag {
    /// The bytes between the delimiters, without the signs that trim blanks.
    pub(super) fn inner<'t>(&self, text: &'t str) -> &'t str {
        let inner = text.get(self.range.start + 2..self.range.end.saturating_sub(2)).unwrap_or_default();
        inner.trim_matches(['-', '+'])
    }

    /// The template that the tag names: in `include`, `import`, `from` and `extends`. Returns the name and its bytes.
    pub(super) fn template<'t>(&self, text: &'t str) -> Option<(&'t str, Range<usize>)> {
        if self.kind != TagKind::Statement {
            return None;
        }
        let word = self.inner(text).split_whitespace().next()?;
        if !["include", "import", "from", "extends"].contains(&word) {
            return None;
        }
        let quote = |sign: char| Some((self.range.start + text[self.range.clone()].find(sign)?, sign));
        let (start, sign) = quote('"').into_iter().chain(quote('\'')).min()?;
        let rest = text.get(start + 1..self.range.end)?;
        let name = &rest[..rest.find(sign)?];
        Some((name, start + 1..start + 1 + name.len()))
    }
}

/// A template's text with what was found in it.
#[derive(Debug)]
pub(super) struct Scan<'t> {
    pub(super) text: &'t str,
    /// The WGSL of the text: comments and tags are blanks, and tags of values are part of the word around them.
    pub(super) flat: String,
    pub(super) tags: Vec<Tag>,
    pub(super) declared: Vec<Declared>,
}

impl<'t> Scan<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        let (flat, tags) = flattened(text);
        let mut declared = declarations(text, &flat);
        declared.extend(tags.iter().filter_map(|tag| declared_by(text, tag)));
        declared.sort_by_key(|one| one.name.start);
        Self { text, flat, tags, declared }
    }

    pub(super) fn name(&self, declared: &Declared) -> &'t str {
        &self.text[declared.name.clone()]
    }

    /// The tag that contains a byte, delimiters left out.
    pub(super) fn tag_at(&self, offset: usize) -> Option<&Tag> {
        self.tags.iter().find(|tag| tag.range.start + 2 <= offset && offset + 2 <= tag.range.end)
    }

    /// The word of WGSL at a byte, or before it.
    pub(super) fn word_at(&self, offset: usize) -> Range<usize> {
        word_at(&self.flat, offset)
    }

    /// Returns `true` for a word that names a member of a structure: after a dot, or where it is declared.
    pub(super) fn is_member(&self, range: &Range<usize>) -> bool {
        let is_declared = |one: &Declared| one.kind == TemplateItem::Member && one.name == *range;
        self.flat[..range.start].ends_with('.') || self.declared.iter().any(is_declared)
    }

    /// All occurrences of a word in the WGSL.
    pub(super) fn words<'s>(&'s self, word: &'s str) -> impl Iterator<Item = Range<usize>> + 's {
        words(&self.flat).filter(move |range| &self.text[range.clone()] == word)
    }

    /// All occurrences of a word within statements and values of tags.
    pub(super) fn words_of_tags<'s>(&'s self, word: &'s str) -> impl Iterator<Item = Range<usize>> + 's {
        let tags = self.tags.iter().filter(|tag| tag.kind != TagKind::Comment);
        tags.flat_map(move |tag| {
            let inner = &self.text[tag.range.clone()];
            let start = tag.range.start;
            let is_it =
                move |range: &Range<usize>| inner[range.clone()] == *word && !is_quoted(inner, range.start);
            words(inner).filter(is_it).map(move |range| start + range.start..start + range.end)
        })
    }

    /// The function that contains a byte.
    pub(super) fn function_at(&self, offset: usize) -> Option<&Declared> {
        let is_it = |one: &&Declared| {
            one.kind == TemplateItem::Function && (one.name.end..=one.whole.end).contains(&offset)
        };
        self.declared.iter().rfind(is_it)
    }

    /// The bytes of a local name's declaration: the last before the use at `offset`, in the same function.
    pub(super) fn local(&self, word: &str, offset: usize) -> Option<Range<usize>> {
        let function = self.function_at(offset)?;
        let mut found = None;
        let mut before = "";
        for range in words(&self.flat).skip_while(|range| range.start < function.name.end) {
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
    pub(super) fn comment(&self, declared: &Declared) -> String {
        let before = &self.text[..declared.whole.start];
        let trimmed = before.trim_end();
        // A comment of the template that ends on the line before.
        let is_next = !before[trimmed.len()..].contains("\n\n");
        if let Some(tag) =
            self.tags.iter().find(|tag| tag.kind == TagKind::Comment && tag.range.end == trimmed.len())
            && is_next
        {
            let lines = tag.inner(self.text).trim_matches('#').lines().map(str::trim);
            return lines.collect::<Vec<_>>().join("\n").trim().to_owned();
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

/// Returns `true` for a byte within a string of a tag.
pub(super) fn is_quoted(inner: &str, offset: usize) -> bool {
    let mut open = None;
    for sign in inner[..offset].chars().filter(|sign| matches!(sign, '"' | '\'')) {
        open = match open {
            None => Some(sign),
            Some(known) if known == sign => None,
            known => known,
        };
    }
    open.is_some()
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_' || byte >= 0x80
}

/// The word at a byte, or before it; empty where there is none.
pub(super) fn word_at(text: &str, offset: usize) -> Range<usize> {
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

/// Blanks over tags and comments, and the tags.
fn flattened(text: &str) -> (String, Vec<Tag>) {
    let bytes = text.as_bytes();
    let (mut flat, mut tags, mut at) = (bytes.to_vec(), Vec::new(), 0);
    // The signs that end no tag from here on, so that no text is searched again and again.
    let mut missing: Vec<&str> = Vec::new();
    while at < bytes.len() {
        let rest = &text.as_bytes()[at..];
        let tag = match rest {
            [b'{', b'%', ..] => Some((TagKind::Statement, "%}")),
            [b'{', b'{', ..] => Some((TagKind::Expression, "}}")),
            [b'{', b'#', ..] => Some((TagKind::Comment, "#}")),
            _ => None,
        };
        let (end, fill) = match (tag, rest) {
            (Some((kind, close)), _) => {
                let found = Some(at + 2).filter(|_| !missing.contains(&close));
                let end = found.and_then(|start| tag_end(text, start, close, kind)).unwrap_or_else(|| {
                    missing.push(close);
                    text[at..].find('\n').map_or(text.len(), |end| at + end)
                });
                tags.push(Tag { kind, range: at..end });
                (end, if kind == TagKind::Expression { b'_' } else { b' ' })
            }
            (None, [b'/', b'/', ..]) => {
                (rest.iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |end| at + end), b' ')
            }
            (None, [b'/', b'*', ..]) => (comment_end(bytes, at), b' '),
            _ => {
                at += 1;
                continue;
            }
        };
        for byte in flat[at..end].iter_mut().filter(|byte| **byte != b'\n') {
            *byte = fill;
        }
        at = end;
    }
    // Whole characters were replaced, or none of their bytes.
    (String::from_utf8_lossy(&flat).into_owned(), tags)
}

/// The byte after a tag's end; strings may hold what ends one. `None` for a tag without an end.
fn tag_end(text: &str, start: usize, close: &str, kind: TagKind) -> Option<usize> {
    let mut open = None;
    for (at, sign) in text[start..].char_indices() {
        let at = start + at;
        match open {
            Some(known) if sign == known => open = None,
            None if text[at..].starts_with(close) => return Some(at + close.len()),
            None if kind != TagKind::Comment && matches!(sign, '"' | '\'') => open = Some(sign),
            _ => {}
        }
    }
    None
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
fn attributes_start(flat: &str, keyword: usize) -> usize {
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
    if tag.kind != TagKind::Statement {
        return None;
    }
    let inner = &text[tag.range.clone()];
    let mut all = words(inner);
    let kind = match &inner[all.next()?] {
        "block" => TemplateItem::Block,
        "macro" => TemplateItem::Macro,
        _ => return None,
    };
    let name = all.next()?;
    let name = tag.range.start + name.start..tag.range.start + name.end;
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
        let scan = Scan::new(text);
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
        let scan = Scan::new(TEXT);
        assert_eq!(scan.comment(&scan.declared[0]), "Doubles\na number.");
        assert_eq!(&TEXT[scan.declared[0].signature.clone()], "fn double(x: f32) -> f32 ");
        assert!(TEXT[scan.declared[0].whole.clone()].starts_with("@must_use"));
        let template = scan.tags.iter().find_map(|tag| tag.template(TEXT));
        assert_eq!(template.map(|(name, _)| name), Some("lib/a.wgsl.jinja"));
    }

    #[test]
    fn local_names_are_those_of_their_function() {
        let scan = Scan::new(TEXT);
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
            let scan = Scan::new(&TEXT[..end]);
            assert_eq!(scan.flat.len(), end);
            let _ = (scan.word_at(end), scan.tag_at(end), scan.local("x", end));
        }
        assert_eq!(Scan::new("ä {% ö %} // ü\n").flat.len(), "ä {% ö %} // ü\n".len());
    }
}
