//! Line plots of times over the last frames.

use eframe::egui::{self, Align2, Color32, FontId, Rect, Stroke, pos2, vec2};

use crate::timings::Percentiles;

/// The times of one pass, the newest last, and the colour of its line.
pub(crate) struct Line {
    pub(crate) times: Vec<f64>,
    pub(crate) color: Color32,
}

/// The colour of the line with a number: neighbours differ by the golden angle of hue.
pub(crate) fn color_of(number: usize) -> Color32 {
    let hue = (0.58 + number as f32 * 0.381_966) % 1.0;
    egui::ecolor::Hsva::new(hue, 0.55, 0.95, 1.0).into()
}

/// Draws lines over the last `frames` frames, the newest at the right, from 0 to the longest usual time.
pub(crate) fn lines(ui: &egui::Ui, rect: Rect, lines: &[Line], frames: usize) {
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let max = max_of(lines);
    let plot = rect.shrink2(vec2(3.0, 4.0));
    for line in lines {
        let step = plot.width() / frames.saturating_sub(1).max(1) as f32;
        let first = frames.saturating_sub(line.times.len());
        let point = |(at, time): (usize, &f64)| {
            let x = plot.left() + (first + at) as f32 * step;
            pos2(x, plot.bottom() - (time / max) as f32 * plot.height())
        };
        let points: Vec<_> = line.times.iter().enumerate().map(point).collect();
        painter.line(points, Stroke::new(1.3, line.color));
    }
}

/// Draws lines with the scale of their times.
pub(crate) fn plot(ui: &egui::Ui, rect: Rect, shown: &[Line], frames: usize) {
    let max = max_of(shown);
    let (scale, area) = rect.split_left_right_at_x(rect.left() + 62.0);
    lines(ui, area, shown, frames);
    let color = ui.visuals().weak_text_color();
    let font = FontId::proportional(10.5);
    let plot = area.shrink2(vec2(3.0, 4.0));
    for part in [0.0, 0.5, 1.0] {
        let y = egui::lerp(plot.bottom()..=plot.top(), part);
        let digits = if max >= 100.0 { 0 } else { 3 };
        let text = format!("{:.digits$} ms", max * f64::from(part));
        let at = pos2(scale.right() - 6.0, y.clamp(rect.top() + 6.0, rect.bottom() - 6.0));
        ui.painter().text(at, Align2::RIGHT_CENTER, text, font.clone(), color);
        ui.painter().hline(area.x_range(), y, Stroke::new(0.5, color.gamma_multiply(0.3)));
    }
}

/// The time at the top: a tenth more than all but the longest 5 % of the times of each line, such as those of a frame
/// that compiles shaders.
fn max_of(lines: &[Line]) -> f64 {
    let usual = |line: &Line| Percentiles::of(line.times.iter().copied()).map_or(0.0, |times| times.p95);
    lines.iter().map(usual).fold(1e-6, f64::max) * 1.1
}
