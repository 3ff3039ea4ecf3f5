//! Ranges and histograms of a texture's channels, as bars and words.

use eframe::egui::{self, Color32, RichText, pos2, vec2};
use umbragraph::low_level::sheet::Range;

use crate::texels::{Channel, shown};

/// Shows the histogram, the range and the mean of each channel.
pub(crate) fn show(ui: &mut egui::Ui, channels: &[Channel], ranges: &[Range]) {
    let names = if channels.len() == 1 { ["value", "", "", ""] } else { ["R", "G", "B", "A"] };
    let colors = [
        Color32::from_rgb(232, 104, 96),
        Color32::from_rgb(110, 200, 110),
        Color32::from_rgb(110, 150, 240),
        Color32::from_gray(170),
    ];
    for (at, channel) in channels.iter().enumerate() {
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 34.0), egui::Sense::hover());
        ui.painter().rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        let max = channel.bars.iter().copied().max().unwrap_or(0).max(1) as f32;
        let width = rect.width() / channel.bars.len() as f32;
        for (bar, count) in channel.bars.iter().enumerate() {
            // A root, so that few values beside many are seen.
            let height = (*count as f32 / max).sqrt() * rect.height();
            let left = rect.left() + bar as f32 * width;
            let shape = egui::Rect::from_min_max(
                pos2(left, rect.bottom() - height),
                pos2(left + width - 1.0, rect.bottom()),
            );
            // Red would say that the one channel is red.
            let color = if channels.len() == 1 { colors[3] } else { colors[at] };
            ui.painter().rect_filled(shape, 0.0, color);
        }
        let not_finite = match channel.not_finite {
            0 => String::new(),
            count => format!("  {count} not finite"),
        };
        let shows = ranges.get(at).map(|range| format!("shown {} to {}", shown(range.min), shown(range.max)));
        let mean = shown(channel.mean as f32);
        let said = format!(
            "{} {} to {}, mean {mean}{not_finite}",
            names[at],
            shown(channel.min),
            shown(channel.max)
        );
        ui.label(RichText::new(said).small().monospace());
        if let Some(shows) = shows {
            ui.label(RichText::new(shows).small().monospace().weak());
        }
        ui.add_space(2.0);
    }
}
