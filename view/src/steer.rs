//! The camera under pointer and keys, and on a path.
//!
//! A drag turns, shift or the middle button pans, the wheel goes nearer, W, A, S, D, Q and E move the camera. Until
//! then it goes the way that `--camera` names, as far as the time of the animations says. `umbragraph render` keeps
//! such a camera away from walls; the viewer does not.

use eframe::egui;
use umbragraph::glam::{DVec2, DVec3};

use umbragraph::low_level::camera_path::CameraPath;

use crate::app::Viewer;

/// The time in which the camera completes its path, in seconds.
const LAP: f64 = 10.0;

impl Viewer {
    /// Places the camera of a newly loaded scene: at the first key of a camera path file, or at the start of its path.
    pub(crate) fn begin_path(&mut self) {
        let Some(home) = &self.view else { return };
        if let CameraPath::Keys(keys) = &self.path {
            let at = |key| {
                let mut view = home.clone();
                view.go_to(key);
                view
            };
            self.bookmarks = keys.iter().map(at).collect();
            self.view = self.bookmarks.first().cloned();
            self.path = CameraPath::Scene;
            self.stage.touch();
        }
        self.follow_path();
    }

    /// Moves the camera along its path, unless the user has moved the camera by hand.
    pub(crate) fn follow_path(&mut self) {
        if self.path == CameraPath::Scene {
            return;
        }
        let (Some(view), Some(scene)) = (&mut self.view, self.stage.scene()) else { return };
        let input = scene.frame_input_of(&scene.pose(0.0), 1.0, 0.0);
        let time = self.clock.time;
        let moment = [(time / crate::clock::STEP).floor(), (time / LAP).fract(), time];
        let before = view.clone();
        view.place(&self.path.camera(input.camera, &input.scene_bounds, None, moment));
        if *view != before {
            self.stage.touch();
        }
    }

    /// Moves the camera by pointer and keyboard input.
    pub(crate) fn steer(&mut self, ui: &egui::Ui, response: &egui::Response) {
        let Some(view) = &mut self.view else { return };
        let before = view.clone();
        let height = f64::from(response.rect.height()).max(1.0);
        let by = response.drag_delta();
        let by = DVec2::new(f64::from(by.x), f64::from(by.y)) / height;
        let is_shift = ui.input(|input| input.modifiers.shift);
        if response.dragged_by(egui::PointerButton::Middle) || (response.dragged() && is_shift) {
            view.pan(by);
        } else if response.dragged() {
            view.turn(by * std::f64::consts::PI);
        }
        if response.hovered() {
            let wheel = ui.input(|input| input.smooth_scroll_delta().y);
            if wheel != 0.0 {
                view.zoom(f64::from(wheel) / 50.0);
            }
        }
        if !ui.ctx().text_edit_focused() && !ui.input(|input| input.modifiers.command) {
            let (way, dt) = ui.input(|input| {
                let axis = |plus, minus| f64::from(input.key_down(plus)) - f64::from(input.key_down(minus));
                use egui::Key;
                let way = DVec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::S, Key::W));
                (way, f64::from(input.stable_dt).min(0.1))
            });
            if way != DVec3::ZERO {
                view.fly(way * dt * 0.5);
                ui.ctx().request_repaint();
            }
        }
        if *view != before {
            self.path = CameraPath::Scene;
            self.stage.touch();
            self.resolution.touch();
        }
    }
}
