//! The answers to requests.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use lsp_types::request::{
    CodeActionRequest, CodeLensRequest, ColorPresentationRequest, Completion, DocumentColor,
    DocumentSymbolRequest, ExecuteCommand, Formatting, GotoDefinition, HoverRequest, InlayHintRequest,
    PrepareRenameRequest, References, Rename, Request as _, SemanticTokensFullRequest,
};
use lsp_types::{
    CodeAction, CodeActionKind, CodeActionOrCommand, CodeActionParams, CompletionItem, CompletionItemKind,
    CompletionParams, CompletionTextEdit, DocumentFormattingParams, DocumentSymbolParams, Documentation,
    ExecuteCommandParams, GotoDefinitionParams, Hover, HoverContents, HoverParams, InlayHint, InlayHintLabel,
    InlayHintParams, Location, MarkupContent, MarkupKind, Range, ReferenceParams, SemanticTokensParams,
    TextDocumentIdentifier, TextDocumentPositionParams, TextEdit, WorkspaceEdit,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value as Json;

use crate::capabilities::COMMANDS;
use crate::colors;
use crate::configuration;
use crate::generated;
use crate::outline;
use crate::renames;
use crate::templates::{self, Template, is_axes};
use crate::workspace::{Workspace, document_path, is_document, range, source};
use umbragraph_graph::diagnostic::Fix;
use umbragraph_graph::document::{Parsed, format};
use umbragraph_graph::edit::Edit;
use umbragraph_graph::model::DeclarationKind;
use umbragraph_graph::source::{FileId, SourceFile, Span};
use umbragraph_session::{Candidate, CandidateKind, Choice, Computed, Cursor, Target};

type Answer = Result<Json, String>;

/// Answers a request of the client; `None` if its method is not supported.
pub(crate) fn answer(workspace: &mut Workspace, method: &str, params: Json) -> Option<Answer> {
    Some(match method {
        Completion::METHOD => with(params, |params| completion(workspace, params)),
        HoverRequest::METHOD => with(params, |params| hover(workspace, params)),
        GotoDefinition::METHOD => with(params, |params| definition(workspace, params)),
        References::METHOD => with(params, |params| references(workspace, params)),
        PrepareRenameRequest::METHOD => {
            parsed(params).and_then(|params| json(renames::prepare(workspace, params)?))
        }
        Rename::METHOD => parsed(params).and_then(|params| json(renames::rename(workspace, params)?)),
        DocumentSymbolRequest::METHOD => with(params, |params: DocumentSymbolParams| {
            if let Some(Template::Wgsl(file)) = Template::of(workspace, &params.text_document) {
                return Some(templates::symbols(workspace, file));
            }
            let (file, parsed) = of_document(workspace, &params.text_document)?;
            Some(outline::symbols(&parsed.document.root, source(workspace, file)?, workspace.encoding))
        }),
        SemanticTokensFullRequest::METHOD => with(params, |params: SemanticTokensParams| {
            let (file, parsed) = of_document(workspace, &params.text_document)?;
            Some(outline::tokens(&parsed.document.root, source(workspace, file)?, workspace.encoding))
        }),
        InlayHintRequest::METHOD => with(params, |params| hints(workspace, &params)),
        DocumentColor::METHOD => with(params, |params| colors::colors(workspace, &params)),
        ColorPresentationRequest::METHOD => with(params, |params| colors::presentations(workspace, &params)),
        Formatting::METHOD => with(params, |params| formatted(workspace, params)),
        CodeLensRequest::METHOD => with(params, |params| generated::lenses(workspace, &params)),
        ExecuteCommand::METHOD => parsed(params).and_then(|params| execute(workspace, params)),
        CodeActionRequest::METHOD => with(params, |params| Some(actions(workspace, &params))),
        _ => return None,
    })
}

fn execute(workspace: &mut Workspace, params: ExecuteCommandParams) -> Answer {
    let argument = params.arguments.into_iter().next().unwrap_or_default();
    match params.command.as_str() {
        generated::TEXT => json(generated::execute(workspace, argument)?),
        configuration::LIST => json(configuration::list(workspace, argument)?),
        configuration::CONFIGURE => json(configuration::configure(workspace, argument)?),
        other => Err(format!("`{other}` is not a command of this server; it has {}", COMMANDS.join(", "))),
    }
}

fn with<P: DeserializeOwned, R: Serialize>(params: Json, answer: impl FnOnce(P) -> Option<R>) -> Answer {
    parsed(params).and_then(|params| json(answer(params)))
}

fn parsed<P: DeserializeOwned>(params: Json) -> Result<P, String> {
    serde_json::from_value(params).map_err(|error| error.to_string())
}

fn json(answer: impl Serialize) -> Answer {
    serde_json::to_value(answer).map_err(|error| error.to_string())
}

/// A position in a document that a request refers to, with the pipeline and configuration to answer for.
pub(crate) struct Asked {
    pub(crate) path: PathBuf,
    pub(crate) offset: usize,
    pub(crate) target: Target,
    pub(crate) choice: Choice,
}

impl Asked {
    pub(crate) fn of(workspace: &mut Workspace, at: TextDocumentPositionParams) -> Option<Self> {
        let path = document_path(&at.text_document.uri).filter(|path| is_document(path))?;
        let (file, _) = workspace.session.parsed(&path)?;
        let offset = workspace.encoding.offset(source(workspace, file)?, at.position);
        let target = workspace.target_of_text(&path)?;
        let choice = workspace.choice(&target);
        Some(Self { path, offset, target, choice })
    }

    pub(crate) fn cursor(&self) -> Cursor<'_> {
        Cursor { target: &self.target, choice: &self.choice, path: &self.path, offset: self.offset }
    }
}

fn of_document(
    workspace: &mut Workspace,
    document: &TextDocumentIdentifier,
) -> Option<(FileId, Arc<Parsed>)> {
    let path = document_path(&document.uri)?;
    if !is_axes(&path) {
        workspace.target(Some(&path).filter(|path| is_document(path))?)?;
    }
    workspace.session.parsed(&path)
}

fn completion(workspace: &mut Workspace, params: CompletionParams) -> Option<Vec<CompletionItem>> {
    let at = params.text_document_position;
    let expected = match Template::at(workspace, &at) {
        Some((Template::Wgsl(file), offset)) => workspace.session.template_expected(file, offset)?,
        Some((Template::Axes(path), offset)) => workspace.session.axes_expected(&path, offset)?,
        None => {
            let asked = Asked::of(workspace, at)?;
            workspace.sure(|session| session.expected_at(&asked.cursor()))?
        }
    };
    let range = range(workspace, expected.replaced)?;
    let candidates = expected.candidates.into_iter().enumerate();
    Some(candidates.map(|(place, candidate)| item(candidate, place, range)).collect())
}

fn item(candidate: Candidate, place: usize, range: Range) -> CompletionItem {
    let Candidate { kind, label, text, detail, description } = candidate;
    let kind = match kind {
        CandidateKind::Key => CompletionItemKind::PROPERTY,
        CandidateKind::Word | CandidateKind::Axis => CompletionItemKind::ENUM_MEMBER,
        CandidateKind::Function => CompletionItemKind::FUNCTION,
        CandidateKind::Template => CompletionItemKind::FILE,
        CandidateKind::Binding => CompletionItemKind::FIELD,
        CandidateKind::Name(DeclarationKind::Resource | DeclarationKind::Data) => {
            CompletionItemKind::VARIABLE
        }
        CandidateKind::Name(DeclarationKind::Pass | DeclarationKind::Subgraph) => CompletionItemKind::METHOD,
        CandidateKind::Name(_) => CompletionItemKind::CONSTANT,
        CandidateKind::OfTemplate(item) => templates::completion_kind(item),
    };
    CompletionItem {
        label,
        kind: Some(kind),
        detail,
        documentation: description.map(|text| Documentation::MarkupContent(markdown(text))),
        // Clients sort by label otherwise: what the file declares itself comes before what it inherits.
        sort_text: Some(format!("{place:05}")),
        filter_text: Some(text.trim_start_matches(", ").to_owned()),
        text_edit: Some(CompletionTextEdit::Edit(TextEdit { range, new_text: text })),
        ..CompletionItem::default()
    }
}

fn markdown(value: String) -> MarkupContent {
    MarkupContent { kind: MarkupKind::Markdown, value }
}

fn hover(workspace: &mut Workspace, params: HoverParams) -> Option<Hover> {
    let at = params.text_document_position_params;
    let found = match Template::at(workspace, &at) {
        Some((Template::Wgsl(file), offset)) => workspace.session.template_hover(file, offset)?,
        Some((Template::Axes(path), offset)) => workspace.session.axes_hover(&path, offset)?,
        None => {
            let asked = Asked::of(workspace, at)?;
            workspace.sure(|session| session.hover(&asked.cursor()))?
        }
    };
    let text = match found.is_preformatted {
        true => format!("```text\n{}\n```", found.text.trim_end()),
        false => found.text,
    };
    Some(Hover { contents: HoverContents::Markup(markdown(text)), range: range(workspace, found.place) })
}

fn definition(workspace: &mut Workspace, params: GotoDefinitionParams) -> Option<Vec<Location>> {
    let at = params.text_document_position_params;
    let places = match Template::at(workspace, &at) {
        Some((Template::Wgsl(file), offset)) => {
            let mut places = workspace.session.template_definition(file, offset);
            // From the declaration of a binding the way leads on to the keys that bind it.
            let is_here = |place: &Span| place.file == file && place.range().contains(&offset);
            if places.iter().any(is_here) {
                let bound = bound(workspace, file, offset);
                places = if bound.is_empty() { places } else { bound };
            }
            places
        }
        Some((Template::Axes(_), _)) => Vec::new(),
        None => {
            let asked = Asked::of(workspace, at)?;
            workspace.sure(|session| session.definition(&asked.cursor()))
        }
    };
    Some(places.into_iter().filter_map(|place| workspace.readable(place)).collect())
}

/// Returns the keys of all pipelines of the workspace that bind the binding at a byte of a template.
fn bound(workspace: &mut Workspace, file: FileId, offset: usize) -> Vec<Span> {
    let targets = workspace.pipelines();
    workspace.sure(|session| session.template_bound(file, offset, &targets))
}

fn references(workspace: &mut Workspace, params: ReferenceParams) -> Option<Vec<Location>> {
    let (at, with_declaration) = (params.text_document_position, params.context.include_declaration);
    let places = match Template::at(workspace, &at) {
        Some((Template::Wgsl(file), offset)) => {
            let declared = workspace.session.template_definition(file, offset);
            let mut places = workspace.session.template_references(file, offset);
            places.retain(|place| with_declaration || !declared.contains(place));
            places.extend(bound(workspace, file, offset));
            places
        }
        Some((Template::Axes(_), _)) => Vec::new(),
        None => {
            let asked = Asked::of(workspace, at)?;
            let places = workspace.sure(|session| session.references(&asked.cursor()));
            places.into_iter().skip(usize::from(!with_declaration)).collect()
        }
    };
    Some(places.into_iter().filter_map(|place| workspace.location(place)).collect())
}

pub(crate) type Changes = BTreeMap<PathBuf, Vec<TextEdit>>;

pub(crate) fn edit_of(workspace: &Workspace, changes: Changes) -> WorkspaceEdit {
    let changes = changes.into_iter().filter_map(|(path, edits)| Some((workspace.uri(&path)?, edits)));
    WorkspaceEdit { changes: Some(changes.collect()), ..WorkspaceEdit::default() }
}

pub(crate) fn text_edits<'e>(
    workspace: &Workspace,
    file: &SourceFile,
    edits: impl IntoIterator<Item = &'e Edit>,
) -> Vec<TextEdit> {
    let position =
        |offset: usize| workspace.encoding.position(file, u32::try_from(offset).unwrap_or(u32::MAX));
    let edit = |edit: &Edit| TextEdit {
        range: Range { start: position(edit.range.start), end: position(edit.range.end) },
        new_text: edit.replacement.clone(),
    };
    edits.into_iter().map(edit).collect()
}

/// Returns inlay hints in the requested range, which show the value of each expression after its text.
fn hints(workspace: &mut Workspace, params: &InlayHintParams) -> Option<Vec<InlayHint>> {
    let path = document_path(&params.text_document.uri).filter(|path| is_document(path))?;
    let target = workspace.target_of_text(&path)?;
    let choice = workspace.choice(&target);
    let values = workspace.sure(|session| session.values(&target, &choice, &path));
    let hint = |computed: Computed| {
        let position = range(workspace, computed.place)?.end;
        let is_asked = params.range.start <= position && position <= params.range.end;
        is_asked.then(|| InlayHint {
            position,
            label: InlayHintLabel::String(computed.value),
            padding_left: Some(true),
            kind: None,
            text_edits: None,
            tooltip: None,
            padding_right: None,
            data: None,
        })
    };
    Some(values.into_iter().filter_map(hint).collect())
}

fn formatted(workspace: &mut Workspace, params: DocumentFormattingParams) -> Option<Vec<TextEdit>> {
    let (file, _) = of_document(workspace, &params.text_document)?;
    let edits = format::format(workspace.session.sources(), file).ok()?;
    Some(text_edits(workspace, source(workspace, file)?, edits.iter()))
}

/// Returns the fixes that diagnostics in the requested range offer.
fn actions(workspace: &mut Workspace, params: &CodeActionParams) -> Vec<CodeActionOrCommand> {
    let Some(path) = document_path(&params.text_document.uri) else { return Vec::new() };
    let is_there = |range: &Range| range.start <= params.range.end && params.range.start <= range.end;
    let found = workspace.of_file(&path);
    let found = found.into_iter().filter(|(one, _)| is_there(&one.range));
    let action =
        |(written, diagnostic): &(lsp_types::Diagnostic, umbragraph_graph::diagnostic::Diagnostic)| {
            let fix = diagnostic.fix.as_ref()?;
            Some(CodeActionOrCommand::CodeAction(CodeAction {
                title: title(workspace, fix),
                kind: Some(CodeActionKind::QUICKFIX),
                diagnostics: Some(vec![written.clone()]),
                edit: Some(mended(workspace, fix)?),
                is_preferred: Some(true),
                ..CodeAction::default()
            }))
        };
    found.filter_map(action).collect()
}

fn title(workspace: &Workspace, fix: &Fix) -> String {
    match fix.edits.as_slice() {
        [one] if one.replacement.is_empty() => "Remove it".to_owned(),
        [one] => {
            let old = workspace.session.sources().text(one.span).trim().to_owned();
            match old.is_empty() {
                true => format!("Insert {}", one.replacement.trim()),
                false => format!("Replace {old} by {}", one.replacement.trim()),
            }
        }
        many => format!("Mend it at {} places", many.len()),
    }
}

/// Converts a fix to the protocol's edit; `None` if the fix changes a file that is bundled with the module.
fn mended(workspace: &Workspace, fix: &Fix) -> Option<WorkspaceEdit> {
    let mut changes = Changes::default();
    for one in &fix.edits {
        let file = source(workspace, one.span.file)?;
        let path = PathBuf::from(file.name());
        workspace.uri(&path)?;
        let edit =
            TextEdit { range: workspace.encoding.range(file, one.span), new_text: one.replacement.clone() };
        changes.entry(path).or_default().push(edit);
    }
    Some(edit_of(workspace, changes))
}
