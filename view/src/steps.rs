//! The keyboard in the graph: one pass or resource has it, arrows go to those beside it, and Enter opens it.

use eframe::egui::{self, Key};
use umbragraph::low_level::report::{PassReport, ResourceReport};

use crate::graph::Selected;

/// The direction of an arrow key: columns to the right, and rows down.
pub(crate) type Arrow = [isize; 2];

/// The arrow key that was pressed in this frame; `None` if there was none.
pub(crate) fn arrow(ui: &egui::Ui) -> Option<Arrow> {
    let arrows = [
        (Key::ArrowLeft, [-1, 0]),
        (Key::ArrowRight, [1, 0]),
        (Key::ArrowUp, [0, -1]),
        (Key::ArrowDown, [0, 1]),
    ];
    ui.input(|input| arrows.into_iter().find(|(key, _)| input.key_pressed(*key)).map(|(_, arrow)| arrow))
}

/// The place of the keyboard in the graph: what has it, and the column that arrows up and down stay in.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cursor {
    pub(crate) at: Selected,
    pub(crate) column: usize,
}

/// The place to which an arrow key goes; the same place at an edge. `lanes` are the rows below the passes.
pub(crate) fn stepped(
    cursor: &Cursor,
    [right, down]: Arrow,
    passes: &[PassReport],
    lanes: &[Vec<&ResourceReport>],
) -> Cursor {
    let pass = |column: usize| {
        let found = passes.get(column).map(|pass| Selected::Pass(pass.name.clone()));
        found.map(|at| Cursor { at, column })
    };
    let bar = |resource: &ResourceReport, column: usize| {
        let [first, last] = resource.columns;
        Cursor { at: Selected::Resource(resource.name.clone()), column: column.clamp(first, last.max(first)) }
    };
    let name = match &cursor.at {
        Selected::Pass(name) => {
            let at = passes.iter().position(|pass| pass.name == *name).unwrap_or(0);
            let next = match down {
                // What the pass uses comes first in a row of several.
                1.. => lanes.first().and_then(|lane| nearest(lane, at)).map(|one| bar(one, at)),
                _ => at.checked_add_signed(right).and_then(pass),
            };
            return next.unwrap_or_else(|| cursor.clone());
        }
        Selected::Resource(name) => name,
    };
    let place = lanes
        .iter()
        .enumerate()
        .find_map(|(row, lane)| lane.iter().position(|one| one.name == *name).map(|at| (row, at)));
    let Some((row, at)) = place else { return pass(cursor.column).unwrap_or_else(|| cursor.clone()) };
    let next = match (right, down) {
        (0, -1) if row == 0 => pass(cursor.column),
        (0, down) => {
            let lane = row.checked_add_signed(down).and_then(|row| lanes.get(row));
            // The column stays, so that a way down and up ends where it began.
            let resource = lane.and_then(|lane| nearest(lane, cursor.column));
            resource.map(|one| Cursor { column: cursor.column, ..bar(one, cursor.column) })
        }
        (right, _) => {
            let beside = at.checked_add_signed(right).and_then(|at| lanes[row].get(at));
            beside.map(|one| bar(one, one.columns[0]))
        }
    };
    next.unwrap_or_else(|| cursor.clone())
}

/// The resource of a row whose bar is nearest to a column.
fn nearest<'a>(lane: &[&'a ResourceReport], column: usize) -> Option<&'a ResourceReport> {
    let distance = |one: &&ResourceReport| {
        let [first, last] = one.columns;
        first.saturating_sub(column).max(column.saturating_sub(last))
    };
    lane.iter().copied().min_by_key(distance)
}
