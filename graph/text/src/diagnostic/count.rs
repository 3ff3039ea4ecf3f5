//! Numbers of configurations.
//!
//! Spaces of axes grow beyond any machine word, so a count has 128 bits and says whether it is exact: one that
//! overflowed, or whose diagram grew too wide, is a lower bound.

use std::fmt;

/// A number of shader configurations (assignments of values to axes), exact or a lower bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct Count {
    /// The exact number if `exact` is `true`, otherwise a lower bound.
    pub number: u128,
    /// Whether `number` is exact. `false` if it is only a lower bound, such as after an overflow.
    pub exact: bool,
}

impl Count {
    /// The exact count 0.
    pub const ZERO: Self = Self { number: 0, exact: true };

    /// Returns the sum of two counts, which is exact if both counts are exact and the sum does not overflow.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self::bounded(self.number.checked_add(other.number), self.exact && other.exact)
    }

    /// Returns the count multiplied by `factor`; on overflow the result is no longer exact.
    #[must_use]
    pub fn times(self, factor: u128) -> Self {
        Self::bounded(self.number.checked_mul(factor), self.exact)
    }

    fn bounded(number: Option<u128>, exact: bool) -> Self {
        Self { number: number.unwrap_or(u128::MAX), exact: exact && number.is_some() }
    }
}

impl Default for Count {
    fn default() -> Self {
        Self::ZERO
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = self.number.to_string();
        let mut grouped = String::with_capacity(digits.len() * 4 / 3);
        for (at, digit) in digits.chars().enumerate() {
            if at > 0 && (digits.len() - at).is_multiple_of(3) {
                grouped.push(',');
            }
            grouped.push(digit);
        }
        if self.exact { f.write_str(&grouped) } else { write!(f, "at least {grouped}") }
    }
}
