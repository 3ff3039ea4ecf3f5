//! The camera under pointer and keys: a drag turns, shift or the middle button pans, the wheel goes nearer, W, A, S, D, Q and E
//! move it.

use eframe::egui;
use umbragraph::glam::{DVec2, DVec3};

use crate::app::Viewer;

impl Viewer {
    /// Moves the camera as pointer and keys say.
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
            self.stage.touch();
            self.resolution.touch();
        }
    }
}
