//! The actions of buttons and keys, each with its key and its words for the list of keys.

use eframe::egui::{self, Key, Modifiers};

use crate::buffers::{List, OF_LISTS};
use crate::dock::Pane;
use crate::turns::Turn;

/// An action that a button or a key of the window starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    Play,
    Step,
    Restart,
    Mode,
    Home,
    Bookmark,
    Visit(usize),
    /// Opens a panel, or closes it if it is in view.
    Panel(Pane),
    /// Gives the keyboard to another panel, so many panels further.
    NextPanel(isize),
    ResetPanels,
    Help,
    Screenshot,
    Clip,
    CopyCommand,
    SaveParameters,
    SaveDocument,
    SaveCamera,
    ResetAll,
    Search,
    SearchGraph,
    Previous,
    Next,
    /// Changes a choice of the inspector by so many steps.
    Turn(Turn, isize),
    Close,
    Coarser,
    Finer,
    Reload,
}

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const COMMAND: Modifiers = Modifiers::COMMAND;
const SHIFT_COMMAND: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

/// A keyboard shortcut: modifiers, key, action and description. An empty description hides it in the list.
type Shortcut = (Modifiers, Key, Action, &'static str);

/// The keyboard shortcuts in groups with a title. Shortcuts with more modifiers come first.
#[rustfmt::skip]
pub(crate) const KEYS: [(&str, &[Shortcut]); 4] = [
    ("FRAME", &[
        (NONE, Key::Space, Action::Play, "play or pause the animations"),
        (NONE, Key::Period, Action::Step, "step by one frame of 30 a second"),
        (NONE, Key::Backspace, Action::Restart, "back to the time 0"),
        (NONE, Key::O, Action::Mode, "orbit or fly; W A S D Q E move, shift drags sideways"),
        (NONE, Key::Home, Action::Home, "back to the scene's camera"),
        (NONE, Key::B, Action::Bookmark, "bookmark the camera; 1 to 9 go to a bookmark"),
        (NONE, Key::Minus, Action::Coarser, "fewer texels per pixel"),
        (NONE, Key::Plus, Action::Finer, "more texels per pixel"),
        (NONE, Key::Equals, Action::Finer, ""),
    ]),
    ("FILES", &[
        (SHIFT_COMMAND, Key::S, Action::SaveDocument, "save the values into the pipeline's document"),
        (COMMAND, Key::S, Action::SaveParameters, "save the values as a parameter file"),
        (COMMAND, Key::B, Action::SaveCamera, "save the bookmarks as a camera path"),
        (COMMAND, Key::R, Action::ResetAll, "reset all values"),
        (NONE, Key::F2, Action::Screenshot, "write the frame as a PNG"),
        (NONE, Key::R, Action::Clip, "begin or end a clip (APNG)"),
        (NONE, Key::C, Action::CopyCommand, "copy a command line that draws this frame"),
        (NONE, Key::F5, Action::Reload, "read all files again"),
    ]),
    ("PANELS", &[
        (SHIFT, Key::F6, Action::NextPanel(-1), ""),
        (NONE, Key::F6, Action::NextPanel(1), "keyboard to the next panel (Shift: before)"),
        (NONE, Key::P, Action::Panel(Pane::Values), "values"),
        (NONE, Key::Slash, Action::Search, "search the values"),
        (NONE, Key::G, Action::Panel(Pane::Graph), "graph"),
        (COMMAND, Key::F, Action::SearchGraph, "search the graph"),
        (NONE, Key::T, Action::Panel(Pane::Times), "times of passes"),
        (NONE, Key::N, Action::Panel(Pane::Notices), "diagnostics and notices"),
        (COMMAND, Key::Num0, Action::ResetPanels, "reset the layout and the zoom"),
        (NONE, Key::F1, Action::Help, "this list"),
    ]),
    ("INSPECTOR", &[
        (NONE, Key::ArrowLeft, Action::Previous, "pass before the selected one"),
        (NONE, Key::ArrowRight, Action::Next, "pass after the selected one"),
        (NONE, Key::PageUp, Action::Turn(Turn::Version, -1), "version before"),
        (NONE, Key::PageDown, Action::Turn(Turn::Version, 1), "version after"),
        (NONE, Key::X, Action::Turn(Turn::Side, 1), "after, before or difference"),
        (SHIFT, Key::Z, Action::Turn(Turn::AgainstVersion, 1), "its version to compare with"),
        (NONE, Key::Z, Action::Turn(Turn::Against, 1), "what to compare with"),
        (SHIFT, Key::M, Action::Turn(Turn::Mip, -1), ""),
        (NONE, Key::M, Action::Turn(Turn::Mip, 1), "mip level (Shift: before)"),
        (SHIFT, Key::L, Action::Turn(Turn::Layer, -1), ""),
        (NONE, Key::L, Action::Turn(Turn::Layer, 1), "layer, face or slice (Shift: before)"),
        (SHIFT, Key::K, Action::Turn(Turn::Sample, -1), ""),
        (NONE, Key::K, Action::Turn(Turn::Sample, 1), "sample (Shift: before)"),
        (NONE, Key::U, Action::Turn(Turn::Aspect, 1), "depth or stencil"),
        (SHIFT, Key::V, Action::Turn(Turn::Channel, -1), ""),
        (NONE, Key::V, Action::Turn(Turn::Channel, 1), "channel (Shift: before)"),
        (SHIFT, Key::J, Action::Turn(Turn::Tile, -1), ""),
        (NONE, Key::J, Action::Turn(Turn::Tile, 1), "tile of an atlas (Shift: before)"),
        (NONE, Key::Y, Action::Turn(Turn::Range, 1), "own range: type its ends"),
        (NONE, Key::I, Action::Turn(Turn::Declaration, 1), "declaration of a buffer"),
        (NONE, Key::Escape, Action::Close, "leave a control, then close the inspector"),
    ]),
];

/// All keyboard shortcuts.
fn shortcuts() -> impl Iterator<Item = &'static Shortcut> {
    KEYS.iter().flat_map(|(_, keys)| keys.iter())
}

/// The keys that belong to a control while it has the keyboard.
const OF_CONTROLS: [Key; 6] =
    [Key::Space, Key::Enter, Key::ArrowUp, Key::ArrowDown, Key::ArrowLeft, Key::ArrowRight];

/// The keys that write no text.
const WITHOUT_TEXT: [Key; 4] = [Key::F1, Key::F2, Key::F5, Key::F6];

/// The number of bookmarks that have a key and a button.
pub(crate) const KEYED: usize = 9;

const NUMBERS: [Key; KEYED] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

/// The actions whose keys were pressed in this frame; none while a list is open. While a text field has the keyboard,
/// keys that write no text still act. `had_focus` is `true` if a control had the keyboard before the frame: escape took
/// it away, and does nothing more.
pub(crate) fn pressed(context: &egui::Context, had_focus: bool) -> Vec<Action> {
    if egui::Popup::is_any_open(context) {
        return Vec::new();
    }
    let focused = context.memory(|memory| memory.focused());
    let has_focus = focused.is_some();
    let has_list = focused == Some(List::id());
    let is_writing = context.text_edit_focused();
    let is_taken = |modifiers: &Modifiers, key: Key| {
        (has_focus && OF_CONTROLS.contains(&key))
            || (has_list && OF_LISTS.contains(&key))
            || (had_focus && key == Key::Escape)
            || (is_writing && !modifiers.command && !WITHOUT_TEXT.contains(&key))
    };
    context.input_mut(|input| {
        let keys = shortcuts().filter(|(modifiers, key, ..)| !is_taken(modifiers, *key));
        let keys = keys.filter(|(modifiers, key, ..)| input.consume_key(*modifiers, *key));
        let mut actions: Vec<Action> = keys.map(|(_, _, action, _)| *action).collect();
        for (at, key) in NUMBERS.into_iter().enumerate().filter(|_| !is_writing) {
            if input.consume_key(Modifiers::NONE, key) {
                actions.push(Action::Visit(at));
            }
        }
        actions
    })
}

/// The keyboard shortcut of an action as text, such as `Ctrl+S`; empty if it has none.
pub(crate) fn key_of(action: Action) -> String {
    let known = shortcuts().find(|one| one.2 == action);
    known.map_or_else(String::new, |(modifiers, key, ..)| written(*modifiers, *key))
}

fn written(modifiers: Modifiers, key: Key) -> String {
    let mut words = String::new();
    for (is_down, word) in [(modifiers.command, "Ctrl+"), (modifiers.shift, "Shift+")] {
        if is_down {
            words.push_str(word);
        }
    }
    // The font has no arrows.
    words + if OF_CONTROLS.contains(&key) { key.name() } else { key.symbol_or_name() }
}

/// Shows a group of keyboard shortcuts.
fn group(ui: &mut egui::Ui, title: &str, keys: &[Shortcut]) {
    ui.label(egui::RichText::new(title).small().strong().weak());
    egui::Grid::new(title).num_columns(2).spacing([16.0, 3.0]).min_col_width(84.0).show(ui, |ui| {
        for (modifiers, key, _, words) in keys.iter().filter(|one| !one.3.is_empty()) {
            ui.monospace(written(*modifiers, *key));
            ui.label(*words);
            ui.end_row();
        }
    });
    ui.add_space(8.0);
}

/// Shows the window with the list of keyboard shortcuts.
pub(crate) fn help(context: &egui::Context, is_open: &mut bool) {
    let window = egui::Window::new("Keys").open(is_open).resizable(false).collapsible(false);
    window.anchor(egui::Align2::CENTER_CENTER, egui::vec2(0.0, 0.0)).show(context, |ui| {
        ui.horizontal_top(|ui| {
            for half in KEYS.chunks(3) {
                ui.vertical(|ui| half.iter().for_each(|(title, keys)| group(ui, title, keys)));
                ui.add_space(18.0);
            }
        });
        ui.add_space(6.0);
        ui.label(
            "Tab goes from control to control, arrows go through the graph, Enter opens. Drop a pipeline, a \
             parameter file, a camera path (.json) or a scene (.glb, .gltf) to open it.",
        );
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_has_two_actions() {
        for (at, one) in shortcuts().enumerate() {
            let is_taken = shortcuts().take(at).any(|other| (other.0, other.1) == (one.0, one.1));
            assert!(!is_taken, "{one:?}");
        }
    }
}
