//! The actions of buttons and keys, each with its key and its words for the list of keys.

use eframe::egui::{self, Key, Modifiers};

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
    Parameters,
    Graph,
    Times,
    Notices,
    Help,
    Screenshot,
    Clip,
    CopyCommand,
    SaveParameters,
    SaveDocument,
    SaveCamera,
    ResetAll,
    Search,
    Previous,
    Next,
    Close,
    Coarser,
    Finer,
    Reload,
}

const SHIFT_COMMAND: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

/// The keyboard shortcuts: modifiers, key, action and description. Shortcuts with more modifiers come first. An empty
/// description hides a shortcut in the list.
pub(crate) const KEYS: [(Modifiers, Key, Action, &str); 26] = [
    (SHIFT_COMMAND, Key::S, Action::SaveDocument, "save the values into the pipeline's document"),
    (Modifiers::COMMAND, Key::S, Action::SaveParameters, "save the values as a parameter file"),
    (Modifiers::COMMAND, Key::B, Action::SaveCamera, "save the bookmarks as a camera path"),
    (Modifiers::COMMAND, Key::R, Action::ResetAll, "reset all values"),
    (Modifiers::NONE, Key::Space, Action::Play, "play or pause the animations"),
    (Modifiers::NONE, Key::Period, Action::Step, "step by one frame of 30 a second"),
    (Modifiers::NONE, Key::Backspace, Action::Restart, "back to the time 0"),
    (
        Modifiers::NONE,
        Key::O,
        Action::Mode,
        "orbit or fly (W, A, S, D, Q, E move; shift or the middle button pans)",
    ),
    (Modifiers::NONE, Key::Home, Action::Home, "back to the scene's camera"),
    (Modifiers::NONE, Key::B, Action::Bookmark, "bookmark the camera; 1 to 9 go to a bookmark"),
    (Modifiers::NONE, Key::P, Action::Parameters, "the panel of values"),
    (Modifiers::NONE, Key::G, Action::Graph, "the graph"),
    (Modifiers::NONE, Key::T, Action::Times, "the times of passes"),
    (Modifiers::NONE, Key::N, Action::Notices, "diagnostics and notices"),
    (Modifiers::NONE, Key::F1, Action::Help, "this list"),
    (Modifiers::NONE, Key::F2, Action::Screenshot, "write the frame as a PNG"),
    (Modifiers::NONE, Key::R, Action::Clip, "begin or end a clip (APNG)"),
    (Modifiers::NONE, Key::C, Action::CopyCommand, "copy a command line that draws this frame"),
    (Modifiers::NONE, Key::Slash, Action::Search, "search the values"),
    (Modifiers::NONE, Key::ArrowLeft, Action::Previous, "the pass before the selected one"),
    (Modifiers::NONE, Key::ArrowRight, Action::Next, "the pass after the selected one"),
    (Modifiers::NONE, Key::Escape, Action::Close, "close the inspector"),
    (Modifiers::NONE, Key::Minus, Action::Coarser, "fewer texels per pixel"),
    (Modifiers::NONE, Key::Plus, Action::Finer, "more texels per pixel"),
    (Modifiers::NONE, Key::Equals, Action::Finer, ""),
    (Modifiers::NONE, Key::F5, Action::Reload, "read all files again"),
];

/// The number of bookmarks that have a key and a button.
pub(crate) const KEYED: usize = 9;

const NUMBERS: [Key; KEYED] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

/// The actions whose keys were pressed in this frame; none while a text field has the focus.
pub(crate) fn pressed(context: &egui::Context) -> Vec<Action> {
    if context.text_edit_focused() {
        return Vec::new();
    }
    context.input_mut(|input| {
        let keys = KEYS.iter().filter(|(modifiers, key, ..)| input.consume_key(*modifiers, *key));
        let mut actions: Vec<Action> = keys.map(|(_, _, action, _)| *action).collect();
        for (at, key) in NUMBERS.into_iter().enumerate() {
            if input.consume_key(Modifiers::NONE, key) {
                actions.push(Action::Visit(at));
            }
        }
        actions
    })
}

/// The keyboard shortcut of an action as text, such as `Ctrl+S`; empty if it has none.
pub(crate) fn key_of(action: Action) -> String {
    let known = KEYS.iter().find(|one| one.2 == action);
    known.map_or_else(String::new, |(modifiers, key, ..)| written(*modifiers, *key))
}

fn written(modifiers: Modifiers, key: Key) -> String {
    let mut words = String::new();
    for (is_down, word) in [(modifiers.command, "Ctrl+"), (modifiers.shift, "Shift+")] {
        if is_down {
            words.push_str(word);
        }
    }
    words + key.symbol_or_name()
}

/// Shows the window with the list of keyboard shortcuts.
pub(crate) fn help(context: &egui::Context, is_open: &mut bool) {
    let window = egui::Window::new("Keys").open(is_open).resizable(false).collapsible(false);
    window.anchor(egui::Align2::CENTER_CENTER, egui::vec2(0.0, 0.0)).show(context, |ui| {
        egui::Grid::new("keys").num_columns(2).spacing([24.0, 5.0]).striped(true).show(ui, |ui| {
            for (modifiers, key, _, words) in KEYS.iter().filter(|one| !one.3.is_empty()) {
                ui.monospace(written(*modifiers, *key));
                ui.label(*words);
                ui.end_row();
            }
        });
        ui.add_space(6.0);
        ui.label(
            "Drop a pipeline, a parameter file, a camera path (.json) or a scene (.glb, .gltf) to open it.",
        );
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_has_two_actions() {
        for (at, one) in KEYS.iter().enumerate() {
            let is_taken = KEYS[..at].iter().any(|other| (other.0, other.1) == (one.0, one.1));
            assert!(!is_taken, "{one:?}");
        }
    }
}
