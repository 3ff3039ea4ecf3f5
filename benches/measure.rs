//! Statistics of measurements, and their tables, which `cargo xtask figures` puts into pages.

// Each bench uses a part of it.
#![allow(dead_code)]

/// Returns the slope of the least-squares line through points.
pub(crate) fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let up: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    up / points.iter().map(|point| (point.0 - x).powi(2)).sum::<f64>()
}

/// Prints a Markdown table with column heads and rows.
pub(crate) fn table<const N: usize>(heads: [&str; N], rows: &[[String; N]]) {
    println!("\n| {} |\n|{}", heads.join(" | "), "---|".repeat(N));
    for row in rows {
        println!("| {} |", row.join(" | "));
    }
    println!();
}
