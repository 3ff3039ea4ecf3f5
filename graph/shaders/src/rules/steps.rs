//! Arithmetic on floats known at creation, one step after the other.
//!
//! WGSL computes such a value by the steps of its definition, and rejects the module if one of them leaves the range of
//! the type, whatever the result would be: `smoothstep(-3e38f, 3e38f, x)` has the difference 6e38. naga computes some
//! functions in other ways, and looks at the result alone.
//!
//! Limit: `f16` is left to naga.

/// The steps of one value in `f32`.
#[derive(Clone, Debug, Default)]
pub(super) struct Steps {
    /// The first step that leaves the range: `3e38 * 2e0`. `None` if there is none.
    pub(super) beyond: Option<String>,
}

impl Steps {
    /// Computes `one` with an operator of `+ - * /` and `other`, and notes the step if it leaves the range.
    fn step(&mut self, one: f64, operator: &str, other: f64) -> f64 {
        let value = match operator {
            "+" => one + other,
            "-" => one - other,
            "*" => one * other,
            _ => one / other,
        };
        let value = f64::from(value as f32);
        if !value.is_finite() {
            self.beyond.get_or_insert_with(|| format!("{:e} {operator} {:e}", one as f32, other as f32));
        }
        value
    }

    pub(super) fn dot(&mut self, one: &[f64], other: &[f64]) -> f64 {
        let products: Vec<f64> =
            one.iter().zip(other).map(|(one, other)| self.step(*one, "*", *other)).collect();
        products.into_iter().reduce(|sum, product| self.step(sum, "+", product)).unwrap_or_default()
    }

    /// The steps of `smoothstep`; `x` is `None` if it is not constant.
    pub(super) fn smoothstep(&mut self, low: f64, high: f64, x: Option<f64>) {
        let Some(x) = x else {
            self.step(high, "-", low);
            return;
        };
        let from_low = self.step(x, "-", low);
        let range = self.step(high, "-", low);
        self.step(from_low, "/", range);
    }

    /// The steps of `refract`.
    pub(super) fn refract(&mut self, incident: &[f64], normal: &[f64], ratio: f64) {
        let cosine = self.dot(normal, incident);
        let square = self.step(cosine, "*", cosine);
        let rest = self.step(1.0, "-", square);
        let ratio_square = self.step(ratio, "*", ratio);
        let product = self.step(ratio_square, "*", rest);
        let k = self.step(1.0, "-", product);
        if self.beyond.is_some() || k < 0.0 {
            return;
        }
        let scaled = self.step(ratio, "*", cosine);
        let root = f64::from(k.sqrt() as f32);
        let share = self.step(scaled, "+", root);
        for (incident, normal) in incident.iter().zip(normal) {
            let (one, other) = (self.step(ratio, "*", *incident), self.step(share, "*", *normal));
            self.step(one, "-", other);
        }
    }
}
