//! Capabilities that the server offers, and what it takes from the client's.

use std::path::PathBuf;

use lsp_types::{
    CodeActionProviderCapability, CodeLensOptions, ColorProviderCapability, CompletionOptions,
    ExecuteCommandOptions, HoverProviderCapability, OneOf, PositionEncodingKind, RenameOptions,
    SemanticTokensFullOptions, SemanticTokensLegend, SemanticTokensOptions, ServerCapabilities,
    TextDocumentSyncKind, TextDocumentSyncOptions, TextDocumentSyncSaveOptions, Uri, WorkDoneProgressOptions,
};
use serde_json::Value as Json;

use crate::configuration;
use crate::generated;
use crate::outline;
use crate::position::Encoding;
use crate::workspace::document_path;

/// The commands that the server runs.
pub(crate) const COMMANDS: [&str; 3] = [generated::TEXT, configuration::LIST, configuration::CONFIGURE];

pub(crate) fn encoding(params: &Json) -> Encoding {
    let offered = params.pointer("/capabilities/general/positionEncodings").and_then(Json::as_array);
    match offered.is_some_and(|offered| offered.iter().any(|one| one == "utf-8")) {
        true => Encoding::Utf8,
        false => Encoding::Utf16,
    }
}

/// Returns the workspace folders in the client's `initialize` parameters; for an older client, its only root folder.
pub(crate) fn folders(params: &Json) -> Vec<PathBuf> {
    let uri = |value: &Json| serde_json::from_value::<Uri>(value.clone()).ok();
    let listed = params.get("workspaceFolders").and_then(Json::as_array).into_iter().flatten();
    let mut folders: Vec<Uri> = listed.filter_map(|folder| uri(folder.get("uri")?)).collect();
    if folders.is_empty() {
        folders.extend(params.get("rootUri").and_then(uri));
    }
    folders.iter().filter_map(document_path).collect()
}

pub(crate) fn capabilities(encoding: Encoding) -> ServerCapabilities {
    let kind = match encoding {
        Encoding::Utf8 => PositionEncodingKind::UTF8,
        Encoding::Utf16 => PositionEncodingKind::UTF16,
    };
    let sync = TextDocumentSyncOptions {
        open_close: Some(true),
        change: Some(TextDocumentSyncKind::INCREMENTAL),
        save: Some(TextDocumentSyncSaveOptions::Supported(true)),
        ..TextDocumentSyncOptions::default()
    };
    let triggers = ["\"", "&", "=", "@", ".", ":", "'", "{", ","];
    ServerCapabilities {
        position_encoding: Some(kind),
        text_document_sync: Some(sync.into()),
        completion_provider: Some(CompletionOptions {
            trigger_characters: Some(triggers.map(str::to_owned).to_vec()),
            ..CompletionOptions::default()
        }),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        definition_provider: Some(OneOf::Left(true)),
        references_provider: Some(OneOf::Left(true)),
        rename_provider: Some(OneOf::Right(RenameOptions {
            prepare_provider: Some(true),
            work_done_progress_options: WorkDoneProgressOptions::default(),
        })),
        document_symbol_provider: Some(OneOf::Left(true)),
        color_provider: Some(ColorProviderCapability::Simple(true)),
        inlay_hint_provider: Some(OneOf::Left(true)),
        document_formatting_provider: Some(OneOf::Left(true)),
        code_lens_provider: Some(CodeLensOptions { resolve_provider: None }),
        execute_command_provider: Some(ExecuteCommandOptions {
            commands: COMMANDS.map(str::to_owned).to_vec(),
            ..ExecuteCommandOptions::default()
        }),
        code_action_provider: Some(CodeActionProviderCapability::Simple(true)),
        semantic_tokens_provider: Some(
            SemanticTokensOptions {
                legend: SemanticTokensLegend {
                    token_types: outline::TOKEN_TYPES.to_vec(),
                    token_modifiers: Vec::new(),
                },
                full: Some(SemanticTokensFullOptions::Bool(true)),
                ..SemanticTokensOptions::default()
            }
            .into(),
        ),
        ..ServerCapabilities::default()
    }
}
