//! Elementary functions with the same bits everywhere.
//!
//! The standard library's sine, power and so on are those of the platform, which may differ in the last bit; a rounded
//! coordinate or a texel at a threshold could then fall to the other side. These are made of additions,
//! multiplications, divisions and square roots alone, which IEEE 754 defines to the bit, and are accurate to a few
//! units of the last place over what scenes need (angles up to some thousand radians, moderate powers). The kernels of
//! sine and cosine are those of fdlibm.

use std::f64::consts::{FRAC_PI_2, LN_2, PI, SQRT_2};

/// The sine and the cosine of an angle in radians.
pub(crate) fn sin_cos(angle: f64) -> (f64, f64) {
    // π/2 in two parts, of which the first has few enough digits for its multiples to be exact.
    const HIGH: f64 = 1.570_796_326_734_125_6;
    const LOW: f64 = 6.077_100_506_506_192e-11;
    const SIN: [f64; 6] = [
        -1.666_666_666_666_663_2e-1,
        8.333_333_333_322_49e-3,
        -1.984_126_982_985_795e-4,
        2.755_731_370_707_006_8e-6,
        -2.505_076_025_340_686_3e-8,
        1.589_690_995_211_55e-10,
    ];
    const COS: [f64; 6] = [
        4.166_666_666_666_66e-2,
        -1.388_888_888_887_411e-3,
        2.480_158_728_947_673e-5,
        -2.755_731_435_139_066_3e-7,
        2.087_572_321_298_175e-9,
        -1.135_964_755_778_819_5e-11,
    ];
    let quarters = (angle / FRAC_PI_2).round();
    let x = (angle - quarters * HIGH) - quarters * LOW;
    let square = x * x;
    let sin = x + x * square * polynomial(square, &SIN);
    let cos = 1.0 - 0.5 * square + square * square * polynomial(square, &COS);
    match (quarters as i64).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The sine of an angle in radians.
pub(crate) fn sin(angle: f64) -> f64 {
    sin_cos(angle).0
}

/// The cosine of an angle in radians.
pub(crate) fn cos(angle: f64) -> f64 {
    sin_cos(angle).1
}

/// The angle from the +X axis to the direction (`x`, `y`), in radians from −π to π.
pub(crate) fn angle_of(y: f64, x: f64) -> f64 {
    if x == 0.0 && y == 0.0 {
        return 0.0;
    }
    let steep = y.abs() > x.abs();
    let mut tangent = if steep { x.abs() / y.abs() } else { y.abs() / x.abs() };
    // Twice half the angle, until the series needs few terms.
    for _ in 0..3 {
        tangent /= 1.0 + (1.0 + tangent * tangent).sqrt();
    }
    let square = tangent * tangent;
    let series: Vec<f64> =
        (0..12).map(|term| if term % 2 == 0 { 1.0 } else { -1.0 } / f64::from(2 * term + 1)).collect();
    let slope = 8.0 * tangent * polynomial(square, &series);
    let first = if steep { FRAC_PI_2 - slope } else { slope };
    let upper = if x < 0.0 { PI - first } else { first };
    if y < 0.0 { -upper } else { upper }
}

/// Raises a number that is not negative to a power.
pub(crate) fn power(base: f64, exponent: f64) -> f64 {
    if base <= 0.0 { 0.0 } else { exponential(exponent * logarithm(base)) }
}

/// The natural logarithm of a positive normal number.
fn logarithm(value: f64) -> f64 {
    let bits = value.to_bits();
    let mut exponent = ((bits >> 52) & 0x7ff) as i64 - 1023;
    let mut mantissa = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) | 0x3ff0_0000_0000_0000);
    if mantissa > SQRT_2 {
        mantissa *= 0.5;
        exponent += 1;
    }
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let series: Vec<f64> = (0..12).map(|term| 2.0 / f64::from(2 * term + 1)).collect();
    exponent as f64 * LN_2 + s * polynomial(s * s, &series)
}

/// The exponential function, for exponents of moderate size.
fn exponential(value: f64) -> f64 {
    let doublings = (value / LN_2).round().clamp(-1000.0, 1000.0);
    let x = value - doublings * LN_2;
    let mut sum = 1.0;
    for term in (1..18).rev() {
        sum = 1.0 + sum * x / f64::from(term);
    }
    sum * f64::from_bits(((doublings as i64 + 1023) as u64) << 52)
}

/// Evaluates a polynomial at `x`; the constant coefficient comes first.
fn polynomial(x: f64, coefficients: &[f64]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_match_the_platform_to_the_last_bits() {
        for step in -40_000..40_000 {
            let angle = f64::from(step) * 0.003_7;
            let (sin, cos) = sin_cos(angle);
            assert!((sin - angle.sin()).abs() < 4e-16, "sine of {angle}");
            assert!((cos - angle.cos()).abs() < 4e-16, "cosine of {angle}");
        }
    }

    #[test]
    fn angles_and_powers_match_the_platform_to_the_last_bits() {
        for step in 0..4000 {
            let angle = (f64::from(step) - 1999.5) / 1999.5 * PI;
            assert!((angle_of(angle.sin() * 7.0, angle.cos() * 7.0) - angle).abs() < 2e-15, "{angle}");
            let (base, exponent) = (f64::from(step) * 0.013, f64::from(step % 7) * 0.4 + 0.2);
            let expected = base.powf(exponent);
            assert!((power(base, exponent) - expected).abs() <= 1e-14 * expected, "{base} to {exponent}");
        }
    }
}
