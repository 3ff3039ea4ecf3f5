//! Reflection of a surface point by glTF's metallic-roughness material, in 64 bits.
//!
//! | part | source |
//! |---|---|
//! | mix of a dielectric and a metal | glTF 2.0, appendix B |
//! | distribution of normals | GGX (B. Walter et al., "Microfacet models for refraction through rough surfaces", 2007, eq. 33) |
//! | shadowing and masking, height-correlated | E. Heitz, "Understanding the masking-shadowing function", 2014, eq. 99 |
//! | Fresnel term | C. Schlick, 1994, from f0 to f90 (KHR_materials_specular) |
//! | light that microfacets pass on among themselves | E. Turquin, "Practical multiple scattering compensation", 2019, eq. 15 |
//! | base under the lobe | C. Kulla and A. Conty, "Revisiting physically based shading at Imageworks", 2017 |
//! | samples | J. Dupuy and A. Benyoub, "Sampling visible GGX normals with spherical caps", 2023 |
//!
//! Directions are unit vectors about the normal +Z, away from the surface. Turquin's factor depends on the view alone, so
//! a rough metal is not reciprocal; the rest is.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::{DVec2, DVec3};

use super::albedo;

/// The least perceptual roughness: smoother surfaces reflect as if they had this one, since a mirror's density has no
/// value. The lobe is then 0.2° wide.
pub const MIN_ROUGHNESS: f64 = 0.045;

/// The least cosine between normal and view.
pub const MIN_COSINE: f64 = 0.01;

/// The GGX lobe of a roughness.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    alpha: f64,
}

impl Ggx {
    /// The lobe of a perceptual roughness, [`MIN_ROUGHNESS`] to 1.
    pub fn new(roughness: f64) -> Self {
        Self { alpha: roughness.clamp(MIN_ROUGHNESS, 1.0).powi(2) }
    }

    fn distribution(self, halfway: DVec3) -> f64 {
        let scaled = DVec3::new(halfway.x / self.alpha, halfway.y / self.alpha, halfway.z);
        1.0 / (PI * self.alpha * self.alpha * scaled.length_squared().powi(2))
    }

    fn lambda(self, cosine: f64) -> f64 {
        let tangent = 1.0 / (cosine * cosine) - 1.0;
        0.5 * ((1.0 + self.alpha * self.alpha * tangent.max(0.0)).sqrt() - 1.0)
    }

    /// The part of microfacets that is visible from one side (G1).
    pub fn masking(self, cosine: f64) -> f64 {
        1.0 / (1.0 + self.lambda(cosine))
    }

    /// The part of microfacets that is visible from view and light (G2).
    pub fn shadowing(self, view: f64, light: f64) -> f64 {
        1.0 / (1.0 + self.lambda(view) + self.lambda(light))
    }

    /// Distribution times shadowing over four cosines: the lobe without its Fresnel term, per steradian.
    pub fn value(self, view: DVec3, light: DVec3, halfway: DVec3) -> f64 {
        self.distribution(halfway) * self.shadowing(view.z, light.z) / (4.0 * view.z * light.z)
    }

    /// A microfacet normal, with the density by which the view sees them.
    pub fn visible_normal(self, view: DVec3, at: DVec2) -> DVec3 {
        let stretched = DVec3::new(view.x * self.alpha, view.y * self.alpha, view.z).normalize();
        let angle = TAU * at.x;
        let z = (1.0 - at.y) * (1.0 + stretched.z) - stretched.z;
        let across = (1.0 - z * z).max(0.0).sqrt();
        let cap = DVec3::new(across * angle.cos(), across * angle.sin(), z) + stretched;
        DVec3::new(cap.x * self.alpha, cap.y * self.alpha, cap.z.max(0.0)).normalize_or(DVec3::Z)
    }

    /// The density of a light direction that mirrors the view at a visible normal, per steradian.
    fn density(self, view: DVec3, halfway: DVec3) -> f64 {
        self.distribution(halfway) * self.masking(view.z) / (4.0 * view.z)
    }
}

/// Factors of the reflection of a surface point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflectance {
    /// Linear base color, each channel 0 to 1.
    pub base_color: DVec3,
    /// 0 for a dielectric, 1 for a metal.
    pub metallic: f64,
    /// Perceptual roughness, 0 to 1.
    pub roughness: f64,
    /// Reflectance of the dielectric at normal incidence.
    pub f0: DVec3,
    /// Reflectance of the dielectric at grazing incidence.
    pub f90: f64,
}

/// The reflection of a surface point toward one view.
#[derive(Clone, Copy, Debug)]
pub struct Brdf {
    view: DVec3,
    ggx: Ggx,
    roughness: f64,
    /// Albedo of the base, the part of metal taken off.
    base: DVec3,
    /// Reflectances of the dielectric as one number, for the energy that the base gets.
    plain: DVec2,
    /// The part of the light that the base reflects toward the view, over its mean.
    coupling: f64,
    /// The lobes of the dielectric and of the metal: reflectance at normal and grazing incidence, both with their weight
    /// and with multiple scattering.
    lobes: [[DVec3; 2]; 2],
    /// The probability with which a sample is one of the lobe.
    lobe_chance: f64,
}

/// A light direction that was drawn at random.
#[derive(Clone, Copy, Debug)]
pub struct Sampled {
    /// The unit vector to the light, about the normal +Z.
    pub light: DVec3,
    /// Reflection times cosine over density.
    pub weight: DVec3,
    /// The density per steradian.
    pub density: f64,
}

impl Brdf {
    /// The reflection toward a view. A view below the horizon counts as one at [`MIN_COSINE`].
    pub fn new(reflectance: &Reflectance, view: DVec3) -> Self {
        let cosine = view.z.clamp(MIN_COSINE, 1.0);
        let across = view.truncate().normalize_or(DVec2::X) * (1.0 - cosine * cosine).sqrt();
        let Reflectance { base_color, metallic, roughness, f0, f90 } = *reflectance;
        let roughness = roughness.clamp(MIN_ROUGHNESS, 1.0);
        let factors = albedo::directional(roughness, cosine);
        let lost = 1.0 / (factors.x + factors.y).max(1e-3) - 1.0;
        let lobe = |weight: f64, f0: DVec3, f90: f64| {
            let factor = weight * (1.0 + f0 * lost);
            [f0 * factor, f90 * factor]
        };
        let lobes = [lobe(1.0 - metallic, f0, f90), lobe(metallic, base_color, 1.0)];
        let plain = DVec2::new(f0.max_element(), f90);
        let base = base_color * (1.0 - metallic);
        let kept = 1.0 - plain.dot(factors).clamp(0.0, 1.0);
        let coupling = kept / (1.0 - plain.dot(albedo::mean(roughness)).clamp(0.0, 1.0)).max(1e-3);
        let reflected: DVec3 = lobes.iter().map(|[f0, f90]| *f0 * factors.x + *f90 * factors.y).sum();
        let (reflected, diffuse) = (reflected.element_sum(), (base * kept).element_sum());
        let lobe_chance = (reflected / (reflected + diffuse).max(1e-9)).clamp(0.1, 0.9);
        let lobe_chance = if diffuse <= 0.0 {
            1.0
        } else if reflected <= 0.0 {
            0.0
        } else {
            lobe_chance
        };
        let ggx = Ggx::new(roughness);
        Self { view: across.extend(cosine), ggx, roughness, base, plain, coupling, lobes, lobe_chance }
    }

    /// Reflection times the cosine of the light, per steradian.
    pub fn value(&self, light: DVec3) -> DVec3 {
        if light.z <= 0.0 {
            return DVec3::ZERO;
        }
        self.base_value(light) + self.lobe_value(light)
    }

    fn base_value(&self, light: DVec3) -> DVec3 {
        let kept = 1.0 - self.plain.dot(albedo::directional(self.roughness, light.z)).clamp(0.0, 1.0);
        self.base * (kept * self.coupling * light.z * FRAC_1_PI)
    }

    fn lobe_value(&self, light: DVec3) -> DVec3 {
        let halfway = (self.view + light).normalize_or(DVec3::Z);
        let edge = (1.0 - self.view.dot(halfway).clamp(0.0, 1.0)).powi(5);
        let fresnel: DVec3 = self.lobes.iter().map(|[f0, f90]| f0.lerp(*f90, edge)).sum();
        fresnel * (self.ggx.value(self.view, light, halfway) * light.z)
    }

    /// The density per steradian with which [`Self::sample`] draws a direction.
    pub fn density(&self, light: DVec3) -> f64 {
        if light.z <= 0.0 {
            return 0.0;
        }
        let halfway = (self.view + light).normalize_or(DVec3::Z);
        let lobe = self.ggx.density(self.view, halfway);
        self.lobe_chance * lobe + (1.0 - self.lobe_chance) * light.z * FRAC_1_PI
    }

    /// Draws a light direction; `None` for one below the horizon, which carries no light.
    pub fn sample(&self, mut at: DVec2) -> Option<Sampled> {
        let light = if at.x < self.lobe_chance {
            at.x /= self.lobe_chance;
            let halfway = self.ggx.visible_normal(self.view, at);
            2.0 * self.view.dot(halfway) * halfway - self.view
        } else {
            at.x = (at.x - self.lobe_chance) / (1.0 - self.lobe_chance);
            let (radius, angle) = (at.y.sqrt(), TAU * at.x);
            DVec3::new(radius * angle.cos(), radius * angle.sin(), (1.0 - at.y).max(0.0).sqrt())
        };
        let density = self.density(light);
        (density > 0.0).then(|| Sampled { light, weight: self.value(light) / density, density })
    }
}

#[cfg(test)]
mod tests {
    use super::super::sequence::Sequence;
    use super::*;

    fn direction(at: DVec2) -> DVec3 {
        let z = 0.02 + 0.98 * at.x;
        let (sine, cosine) = (TAU * at.y).sin_cos();
        DVec3::new(cosine, sine, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
    }

    fn random(index: u32) -> (Reflectance, DVec3, DVec3) {
        let mut sequence = Sequence::new(9, 0, index);
        let [one, two, three] = [0; 3].map(|_| sequence.pair());
        let f0 = DVec3::splat(0.02 + 0.1 * three.x);
        let color = DVec3::new(one.x, one.y, 0.5);
        let reflectance = Reflectance { base_color: color, metallic: 0.0, roughness: two.x, f0, f90: 1.0 };
        (reflectance, direction(sequence.pair()), direction(sequence.pair()))
    }

    #[test]
    fn light_may_run_either_way() {
        for index in 0..1000 {
            let (mut reflectance, view, light) = random(index);
            // The compensation of a smooth surface is 1, and that of a rough one is no function of the light.
            let compensation = |view: DVec3| {
                let factors = albedo::directional(reflectance.roughness, view.z);
                1.0 + reflectance.f0 * (1.0 / (factors.x + factors.y) - 1.0)
            };
            let [there, back] = [(view, light), (light, view)].map(|(view, light)| {
                let brdf = Brdf::new(&reflectance, view);
                (brdf.base_value(light) + brdf.lobe_value(light) / compensation(view)) / light.z
            });
            assert!((there - back).length() < 1e-9 * there.length(), "{index}: {there} {back}");
            reflectance.metallic = 1.0;
            let [there, back] = [(view, light), (light, view)]
                .map(|(view, light)| Brdf::new(&reflectance, view).base_value(light).length());
            assert_eq!((there, back), (0.0, 0.0), "a metal has no base");
        }
    }

    /// The reflected part of light of one from all sides.
    fn albedo_of(reflectance: &Reflectance, cosine: f64, count: u32) -> DVec3 {
        let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let brdf = Brdf::new(reflectance, view);
        let weight =
            |index| brdf.sample(Sequence::new(1, 0, index).pair()).map_or(DVec3::ZERO, |one| one.weight);
        (0..count).map(weight).sum::<DVec3>() / f64::from(count)
    }

    #[test]
    fn white_surfaces_stay_white_in_white_light() {
        for roughness in [0.05, 0.2, 0.4, 0.6, 0.8, 1.0] {
            for metallic in [0.0, 0.5, 1.0] {
                for cosine in [1.0, 0.7, 0.3, 0.1] {
                    let f0 = DVec3::splat(0.04);
                    let white = Reflectance { base_color: DVec3::ONE, metallic, roughness, f0, f90: 1.0 };
                    let reflected = albedo_of(&white, cosine, 4096).x;
                    assert!((reflected - 1.0).abs() < 0.01, "{roughness} {metallic} {cosine}: {reflected}");
                }
            }
        }
    }

    #[test]
    fn samples_agree_with_values_and_density_is_one() {
        for index in 0..8 {
            let (mut reflectance, view, _) = random(index);
            reflectance.metallic = f64::from(index % 3) / 2.0;
            reflectance.roughness = reflectance.roughness.max(0.4);
            let brdf = Brdf::new(&reflectance, view);
            let (mut sum, mut density, count) = (DVec3::ZERO, 0.0, 1 << 16);
            for at in 0..count {
                let at = Sequence::new(2, 1, at).pair();
                let (sine, cosine) = (TAU * at.y).sin_cos();
                let light = DVec3::new(cosine, sine, 0.0) * (1.0 - at.x * at.x).sqrt() + DVec3::Z * at.x;
                sum += brdf.value(light) * TAU / f64::from(count);
                density += brdf.density(light) * TAU / f64::from(count);
            }
            let sampled = albedo_of(&reflectance, view.z, 1 << 14);
            assert!((sum - sampled).length() < 0.01, "{index}: {sum} {sampled}");
            assert!(density < 1.01 && density > 0.6, "{index}: {density}");
        }
    }
}
