//! The viewer under a display: every control is used by pointer or key, and its effect is read back.
//!
//! Input goes through the X server, as that of a hand does. What the window says of itself comes from `--log-state`;
//! pictures, files and numbers are compared with those of the module.

#![cfg(target_os = "linux")]

mod contents;
mod controls;
mod edits;
mod environment;
mod formats;
mod hand;
mod imports;
mod keyboard;
mod looking;
mod opening;
mod output;
mod panels;
mod pictures;
mod random;
mod read_back;
mod reload;
mod tiles;
mod x11;
mod xdnd;

use hand::Hand;

/// A pipeline with one example of everything for which the window has a control.
const PIPELINE: &str = r#"// A comment that stays.
{
  "format": 1,
  "name": "own",
  "extends": "umbragraph:nebula.json",
  "parameters": {
    "far": { "default": [20, 60] }, // metres
    "resolution": { "default": 256 },
    "gain": { "type": "f32", "default": 1, "min": 0, "max": 4, "description": "Weight of the veil." }
  },
  "toggles": { "veil": { "default": false, "description": "The picture once more over itself." } },
  "presets": { "coarse": { "parameters": { "resolution": 64 } } },
  "resources": {
    "half": { "texture": { "format": "rgba16float", "size": "=viewport / 2", "mips": 2 } },
    "unused": { "texture": { "format": "rgba8unorm", "size": "=viewport" } }
  },
  "passes": {
    "halve": { "fullscreen": { "shader": "resample.wgsl.jinja", "bind": { "source": "&color" }, "color": [{ "to": "&half", "mip": 0 }] } },
    "quarter": {
      "fullscreen": {
        "shader": "resample.wgsl.jinja", "bind": { "source": { "texture": { "name": "&half", "mip": 0 } } },
        "color": [{ "to": "&half", "mip": 1 }]
      }
    },
    "veil": {
      "toggle": "veil", "after": ["present"],
      "fullscreen": {
        "shader": "resample.wgsl.jinja", "bind": { "source": { "texture": { "name": "&half", "mip": 1 } } },
        "color": [{ "to": "&target", "blend": "add" }]
      }
    },
    "dead": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&unused" }] } }
  }
}
"#;

/// Starts a viewer on the pipeline; `None` if there is no display.
fn start(name: &str, arguments: &[&str]) -> Option<Hand> {
    let arguments = arguments.iter().map(|one| (*one).to_owned()).collect();
    Hand::start_with(name, PIPELINE, |_| arguments)
}
