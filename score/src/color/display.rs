//! From linear radiance to what a display shows: exposure, a tone curve and the sRGB transfer function.

use glam::{DMat3, DVec3};

/// A tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Colors above 1 are cut off.
    #[default]
    None,
    /// E. Reinhard et al., "Photographic tone reproduction", 2002, eq. 3.
    Reinhard,
    /// K. Narkowicz's fit of the ACES reference curve, 2016.
    Filmic,
    /// Khronos PBR Neutral, 2024.
    PbrNeutral,
    /// T. Sobotka's AgX, 2022, with B. Wrensch's polynomial, 2023.
    Agx,
}

impl ToneMap {
    /// The curve with a name, as pipelines name it; `None` for an unknown one.
    pub fn by_name(name: &str) -> Option<Self> {
        let all = [Self::None, Self::Reinhard, Self::Filmic, Self::PbrNeutral, Self::Agx];
        Self::NAMES.iter().position(|known| *known == name).map(|at| all[at])
    }

    /// The names of all curves.
    pub const NAMES: [&str; 5] = ["none", "reinhard", "filmic", "pbr_neutral", "agx"];

    fn of(self, color: DVec3) -> DVec3 {
        match self {
            Self::None => color,
            Self::Reinhard => color / (color + 1.0),
            Self::Filmic => (color * (2.51 * color + 0.03)) / (color * (2.43 * color + 0.59) + 0.14),
            Self::PbrNeutral => pbr_neutral(color),
            Self::Agx => agx(color),
        }
    }
}

/// The way from radiance to a display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// The factor of radiance before the tone curve.
    pub exposure: f64,
    /// The tone curve.
    pub tone_map: ToneMap,
}

impl Display {
    /// The display-referred color of a radiance: sRGB-encoded, each channel 0 to 1.
    pub fn shown(&self, radiance: DVec3) -> DVec3 {
        let exposed = (radiance * self.exposure).clamp(DVec3::ZERO, DVec3::splat(65_000.0));
        let linear = self.tone_map.of(exposed).clamp(DVec3::ZERO, DVec3::ONE);
        DVec3::from_array(linear.to_array().map(encoded))
    }
}

/// The sRGB transfer function (IEC 61966-2-1).
fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn pbr_neutral(color: DVec3) -> DVec3 {
    let (start, desaturation) = (0.8 - 0.04, 0.15);
    let least = color.min_element();
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let color = color - offset;
    let peak = color.max_element();
    if peak < start {
        return color;
    }
    let room = 1.0 - start;
    let new_peak = 1.0 - room * room / (peak + room - start);
    let white = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    (color * (new_peak / peak)).lerp(DVec3::splat(new_peak), white)
}

/// AgX between the primaries of Rec. 2020, without a look.
fn agx(color: DVec3) -> DVec3 {
    let matrix = |rows: [[f64; 3]; 3]| DMat3::from_cols_array_2d(&rows);
    let inset = matrix([
        [0.856627153315983, 0.137318972929847, 0.11189821299995],
        [0.0951212405381588, 0.761241990602591, 0.0767994186031903],
        [0.0482516061458583, 0.101439036467562, 0.811302368396859],
    ]);
    let outset = matrix([
        [1.1271005818144368, -0.1413297634984383, -0.14132976349843826],
        [-0.11060664309660323, 1.157823702216272, -0.11060664309660294],
        [-0.016493938717834573, -0.016493938717834257, 1.2519364065950405],
    ]);
    let to_2020 = matrix([[0.6274, 0.0691, 0.0164], [0.3293, 0.9195, 0.0880], [0.0433, 0.0113, 0.8956]]);
    let from_2020 =
        matrix([[1.6605, -0.1246, -0.0182], [-0.5876, 1.1329, -0.1006], [-0.0728, -0.0083, 1.1187]]);
    let inside = inset * (to_2020 * color);
    let (low, high) = (-12.47393, 4.026069);
    let stops = DVec3::from_array(inside.to_array().map(|part| part.max(1e-10).log2()));
    let x = ((stops - low) / (high - low)).clamp(DVec3::ZERO, DVec3::ONE);
    let (square, fourth) = (x * x, x * x * x * x);
    let curve = 15.5 * fourth * square - 40.14 * fourth * x + 31.96 * fourth - 6.868 * square * x
        + 0.4298 * square
        + 0.1191 * x
        - 0.00232;
    let linear = (outset * curve).max(DVec3::ZERO).to_array().map(|part| part.powf(2.2));
    from_2020 * DVec3::from_array(linear)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_keep_black_rise_and_stay_on_the_display() {
        for name in ToneMap::NAMES {
            let display = Display { exposure: 2.0, tone_map: ToneMap::by_name(name).unwrap() };
            let shown = |grey: f64| display.shown(DVec3::splat(grey));
            assert!(shown(0.0).max_element() < 0.01, "{name}");
            let mut before = -1.0;
            for stop in -12..9 {
                let [red, green, blue] = shown(f64::from(stop).exp2()).to_array();
                assert!(red >= before && red <= 1.0, "{name} at {stop}");
                assert!((red - green).abs() < 0.01 && (red - blue).abs() < 0.01, "{name}: grey stays grey");
                before = red;
            }
        }
        let plain = Display { exposure: 1.0, tone_map: ToneMap::None };
        assert!((plain.shown(DVec3::splat(0.5)).x - 0.735_357).abs() < 1e-5);
    }
}
