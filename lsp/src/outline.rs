//! The outline of a document, and the kinds of its strings.

use lsp_types::{DocumentSymbol, SemanticToken, SemanticTokenType, SemanticTokens, SymbolKind};

use crate::position::Encoding;
use umbragraph_graph::document::{Entry, Kind, Value, Written};
use umbragraph_graph::language::node_kind;
use umbragraph_graph::source::{SourceFile, Span};

/// The semantic token types of strings, by index: literals, references, expressions.
pub(crate) const TOKEN_TYPES: [SemanticTokenType; 3] =
    [SemanticTokenType::STRING, SemanticTokenType::VARIABLE, SemanticTokenType::FUNCTION];

/// Returns the outline of a document: its sections and their declarations, including those inside subgraphs and the
/// passes that `inserts` adds.
pub(crate) fn symbols(root: &Value, file: &SourceFile, encoding: Encoding) -> Vec<DocumentSymbol> {
    let sections = root.entries().unwrap_or_default().iter().filter(|entry| entry.value.entries().is_some());
    sections.map(|section| symbol(section, &section.key, 0, (file, encoding))).collect()
}

fn symbol(
    entry: &Entry,
    section: &str,
    depth: usize,
    (file, encoding): (&SourceFile, Encoding),
) -> DocumentSymbol {
    let kind = match (depth, section) {
        (0, _) => SymbolKind::NAMESPACE,
        (_, "passes" | "inserts") => SymbolKind::FUNCTION,
        (_, "resources" | "inputs") => SymbolKind::VARIABLE,
        (_, "subgraphs") => SymbolKind::MODULE,
        (_, "toggles" | "features") => SymbolKind::BOOLEAN,
        _ => SymbolKind::CONSTANT,
    };
    let goes_on = depth == 0 || depth == 1 && matches!(section, "subgraphs" | "inserts");
    let below = |inner: &Entry| {
        let is_section = section == "subgraphs" && depth == 1;
        let section = if is_section { inner.key.as_str() } else { section };
        symbol(inner, section, if is_section { 0 } else { depth + 1 }, (file, encoding))
    };
    let members = entry.value.entries().unwrap_or_default().iter();
    let members =
        members.filter(|inner| depth == 0 || section != "subgraphs" || inner.value.entries().is_some());
    let children: Vec<DocumentSymbol> = if goes_on { members.map(below).collect() } else { Vec::new() };
    let detail = match section {
        "passes" | "inserts" if depth > 0 => node_kind(&entry.value).map(|kind| kind.key.clone()),
        "parameters" | "features" if depth > 0 => {
            entry.value.get("type").and_then(Value::text).map(str::to_owned)
        }
        _ => None,
    };
    let whole = Span { end: entry.value.span.end.max(entry.key_span.end), ..entry.key_span };
    #[expect(deprecated, reason = "the type has no other constructor")]
    DocumentSymbol {
        name: entry.key.clone(),
        detail,
        kind,
        tags: None,
        deprecated: None,
        range: encoding.range(file, whole),
        selection_range: encoding.range(file, entry.key_span),
        children: (!children.is_empty()).then_some(children),
    }
}

/// Returns the semantic tokens of a document: each string is a literal, a reference or an expression. Omits
/// descriptions.
pub(crate) fn tokens(root: &Value, file: &SourceFile, encoding: Encoding) -> SemanticTokens {
    let mut strings = Vec::new();
    collect(root, &mut strings);
    strings.sort_by_key(|(place, _)| place.start);
    let (mut line, mut character) = (0, 0);
    let mut data = Vec::new();
    for (place, kind) in strings {
        let range = encoding.range(file, place);
        // A string that never ends has no more than its line.
        if range.start.line != range.end.line {
            continue;
        }
        let delta_line = range.start.line - line;
        let delta_start = range.start.character - if delta_line == 0 { character } else { 0 };
        let length = range.end.character - range.start.character;
        data.push(SemanticToken {
            delta_line,
            delta_start,
            length,
            token_type: kind,
            token_modifiers_bitset: 0,
        });
        (line, character) = (range.start.line, range.start.character);
    }
    SemanticTokens { result_id: None, data }
}

fn collect(value: &Value, strings: &mut Vec<(Span, u32)>) {
    match &value.kind {
        Kind::Text(text) => strings.push((
            value.span,
            match Written::of(text) {
                Written::Plain(_) => 0,
                Written::Reference(_) => 1,
                Written::Expression(_) => 2,
            },
        )),
        Kind::Array(elements) => elements.iter().for_each(|element| collect(element, strings)),
        Kind::Object(entries) => {
            let entries = entries.iter().filter(|entry| entry.key != "description");
            entries.for_each(|entry| collect(&entry.value, strings));
        }
        _ => {}
    }
}
