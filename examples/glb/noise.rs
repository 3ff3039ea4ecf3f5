//! Random numbers that are the same everywhere: hashes of integers.

/// A pseudo-random number from 0 (included) to 1 (excluded), a hash of two integers.
pub(crate) fn unit(a: i64, b: i64) -> f64 {
    let mut bits =
        (a as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (b as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    for _ in 0..3 {
        bits ^= bits >> 29;
        bits = bits.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits ^= bits >> 32;
    }
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// A pseudo-random number from `low` to `high`, a hash of two integers.
pub(crate) fn between(low: f64, high: f64, a: i64, b: i64) -> f64 {
    low + (high - low) * unit(a, b)
}

/// Smooth value noise from 0 to 1 at a point of the plane; it repeats after `period` units in both directions.
pub(crate) fn smooth(x: f64, y: f64, period: i64, seed: i64) -> f64 {
    let (column, row) = (x.floor(), y.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (s, t) = (ease(x - column), ease(y - row));
    let corner = |dx: i64, dy: i64| {
        let wrap = |at: f64, offset: i64| (at as i64 + offset).rem_euclid(period);
        unit(wrap(column, dx) + seed * 1009, wrap(row, dy) + seed * 9176)
    };
    let top = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * s;
    let bottom = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * s;
    top + (bottom - top) * t
}

/// Smooth noise summed over several octaves, from 0 to 1; it repeats after `period` units in both directions.
pub(crate) fn fractal(x: f64, y: f64, period: i64, octaves: u32, seed: i64) -> f64 {
    let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        let scale = f64::from(1 << octave);
        sum += weight * smooth(x * scale, y * scale, period << octave, seed + i64::from(octave));
        total += weight;
        weight *= 0.5;
    }
    sum / total
}
