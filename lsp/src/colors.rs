//! Colors of documents, as the protocol shows and changes them.

use lsp_types::{
    ColorInformation, ColorPresentation, ColorPresentationParams, DocumentColorParams,
    TextDocumentIdentifier, TextEdit,
};

use crate::workspace::{Workspace, document_path, is_document, range, source};
use umbragraph_graph::edit::{Edit, Edits};
use umbragraph_session::Color;

fn of_document(workspace: &mut Workspace, document: &TextDocumentIdentifier) -> Option<Vec<Color>> {
    let path = document_path(&document.uri).filter(|path| is_document(path))?;
    let target = workspace.target_of_text(&path)?;
    let choice = workspace.choice(&target);
    Some(workspace.sure(|session| session.colors(&target, &choice, &path)))
}

/// Returns the colors of a document. The protocol's colors are encoded as sRGB.
pub(crate) fn colors(
    workspace: &mut Workspace,
    params: &DocumentColorParams,
) -> Option<Vec<ColorInformation>> {
    let colors = of_document(workspace, &params.text_document)?;
    let shown = |color: &Color| {
        let [red, green, blue, alpha] = color.shown.map(|one| one as f32);
        let color_shown = lsp_types::Color { red, green, blue, alpha };
        Some(ColorInformation { range: range(workspace, color.place())?, color: color_shown })
    };
    Some(colors.iter().filter_map(shown).collect())
}

/// Returns the edit that sets another color. Layout and comments of the list stay, and so do numbers that are the same.
pub(crate) fn presentations(
    workspace: &mut Workspace,
    params: &ColorPresentationParams,
) -> Option<Vec<ColorPresentation>> {
    let colors = of_document(workspace, &params.text_document)?;
    let color = colors.iter().find(|color| range(workspace, color.place()) == Some(params.range))?;
    let file = source(workspace, color.place().file)?;
    let lsp_types::Color { red, green, blue, alpha } = params.color;
    let (label, edits) = color.edits(file.text(), [red, green, blue, alpha].map(f64::from)).ok()?;
    let place = color.place().range();
    let moved = edits.iter().map(|edit| Edit {
        range: edit.range.start.saturating_sub(place.start)..edit.range.end.saturating_sub(place.start),
        replacement: edit.replacement.clone(),
    });
    let new_text = Edits::new(moved).ok()?.apply(file.text().get(place)?).ok()?;
    let edit = TextEdit { range: params.range, new_text };
    Some(vec![ColorPresentation { label, text_edit: Some(edit), additional_text_edits: None }])
}
