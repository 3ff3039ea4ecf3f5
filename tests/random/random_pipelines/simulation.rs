//! The contents of a random pipeline's textures, computed on the CPU.
//!
//! Passes run one after the other. Each channel of each texel is an interval that holds every value which the rounding
//! of formats, filters and sums allows; whole numbers are cut off at both ends of it. What nothing fixes (memory that
//! another texture had, levels of detail between two mips) is everything, and so is what is made of it.

use std::collections::BTreeMap;

use crate::random_pipelines::grammar::{Deed, Drawn, Seen, Target, Term, Texture};

/// The width and height of the viewport.
const VIEWPORT: usize = 64;
const WORDS: usize = 256;

/// The values between two numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interval {
    low: f64,
    high: f64,
}

const ANYTHING: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };

impl Interval {
    const fn exactly(value: f64) -> Self {
        Self { low: value, high: value }
    }

    pub(crate) fn holds(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    /// Whether it says something: the value but for some steps of eight bits.
    pub(crate) fn is_known(self) -> bool {
        self.high - self.low <= 0.05 + self.high.abs() / 100.0
    }

    fn of(self, bound: impl Fn(f64) -> f64) -> Self {
        Self { low: bound(self.low), high: bound(self.high) }
    }

    fn plus(self, other: Self) -> Self {
        Self { low: self.low + other.low, high: self.high + other.high }
    }

    fn hull(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Wider by a part of what it is.
    fn wider(self, part: f64) -> Self {
        Self { low: self.low - self.low.abs() * part, high: self.high + self.high.abs() * part }
    }
}

type Texel = [Interval; 4];

struct Image<'d> {
    of: &'d Texture,
    width: usize,
    height: usize,
    /// The texels of all layers, row by row.
    texels: Vec<Texel>,
}

impl<'d> Image<'d> {
    fn new(of: &'d Texture) -> Self {
        let width = if of.size == "[32, 64]" { 32 } else { VIEWPORT };
        let count = width * VIEWPORT * if of.is_array { 2 } else { 1 };
        let first = if of.is_kept { Interval::exactly(0.0) } else { ANYTHING };
        Self { of, width, height: VIEWPORT, texels: vec![stored(of.format, [first; 4]); count] }
    }

    fn at(&self, layer: usize, [x, y]: [usize; 2]) -> usize {
        (layer * self.height + y) * self.width + x
    }

    fn texel(&self, layer: usize, at: [usize; 2]) -> Texel {
        self.texels[self.at(layer, at)]
    }

    fn store(&mut self, layer: usize, at: [usize; 2], value: Texel) {
        let at = self.at(layer, at);
        self.texels[at] = stored(self.of.format, value);
    }

    /// Samples the image. At the middle of a texel the result is that texel, up to the fixed point of the weights.
    /// Elsewhere it lies between the texels around.
    fn sample(&self, uv: [f64; 2]) -> Texel {
        let place = [uv[0] * self.width as f64 - 0.5, uv[1] * self.height as f64 - 0.5];
        let is_middle = place.iter().all(|one| (one - one.round()).abs() < 1e-3);
        let last = [self.width - 1, self.height - 1];
        let clamped = |axis: usize, at: f64| at.clamp(0.0, last[axis] as f64) as usize;
        let range = |axis: usize| match is_middle {
            true => clamped(axis, place[axis].round() - 1.0)..=clamped(axis, place[axis].round() + 1.0),
            false => clamped(axis, place[axis].floor())..=clamped(axis, place[axis].floor() + 1.0),
        };
        let around = range(1).flat_map(|y| range(0).map(move |x| [x, y])).map(|at| self.texel(0, at));
        let hull = around.reduce(|a, b| std::array::from_fn(|at| a[at].hull(b[at]))).unwrap_or([ANYTHING; 4]);
        if !is_middle {
            return hull;
        }
        let middle = self.texel(0, [clamped(0, place[0].round()), clamped(1, place[1].round())]);
        std::array::from_fn(|at| Interval {
            low: middle[at].low + (hull[at].low - middle[at].low) / 128.0,
            high: middle[at].high + (hull[at].high - middle[at].high) / 128.0,
        })
    }
}

fn places(width: usize, height: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]))
}

/// The value that a format keeps of a texel.
fn stored(format: &str, value: Texel) -> Texel {
    let unorm = |slack: f64| {
        move |one: Interval| Interval {
            low: (one.low.clamp(0.0, 1.0) * 255.0 - slack).ceil().max(0.0) / 255.0,
            high: (one.high.clamp(0.0, 1.0) * 255.0 + slack).floor().min(255.0) / 255.0,
        }
    };
    let encoded =
        |one: f64| if one <= 0.003_130_8 { one * 12.92 } else { 1.055 * one.powf(1.0 / 2.4) - 0.055 };
    let decoded = |one: f64| if one <= 0.040_45 { one / 12.92 } else { ((one + 0.055) / 1.055).powf(2.4) };
    // Half a step more, as much as decoding may be off.
    let read = |one: Interval| Interval { low: one.low - 0.5 / 255.0, high: one.high + 0.5 / 255.0 };
    let srgb = |one: Interval| read(unorm(1.0)(one.of(|one| encoded(one.clamp(0.0, 1.0))))).of(decoded);
    let [r, g, b, a] = value;
    let (none, one) = (Interval::exactly(0.0), Interval::exactly(1.0));
    let short = |one: Interval| if one.high > 255.0 { Interval { low: 0.0, high: 255.0 } } else { one };
    let kept = match format {
        "rgba8unorm" => value.map(unorm(0.6)),
        "rgba8unorm-srgb" => [srgb(r), srgb(g), srgb(b), unorm(0.6)(a)],
        "rgba16float" => value.map(|one| one.wider(1e-3)),
        "r16float" => [r.wider(1e-3), none, none, one],
        "rgba32float" => value,
        "r32float" | "r32uint" => [r, none, none, one],
        "rgba8uint" => value.map(short),
        "depth32float" | "depth24plus" => [r.of(|one| one.clamp(0.0, 1.0)).wider(1e-6), none, none, one],
        _ => [ANYTHING; 4],
    };
    kept.map(|one| one.wider(1e-6))
}

/// As `u32` cuts a number off.
fn cut(value: Interval) -> Interval {
    value.of(|one| one.floor().max(0.0))
}

struct Simulation<'d> {
    images: Vec<Image<'d>>,
    words: Vec<Interval>,
}

impl Simulation<'_> {
    fn sum(&self, terms: &[Term], uv: [f64; 2]) -> Texel {
        let mut sum = [Interval::exactly(0.25); 4];
        for term in terms {
            let value = match *term {
                Term::Word(at) => [self.words[at]; 4],
                Term::Load { texture, layer, seen } => {
                    let image = &self.images[texture];
                    let [r, g, b, a] = image.texel(layer, [0, 0]);
                    match (image.of.seen, seen) {
                        (Seen::Depth, Seen::Depth) => [r; 4],
                        (Seen::Depth, _) => [r, ANYTHING, ANYTHING, ANYTHING],
                        _ => [r, g, b, a],
                    }
                }
                Term::Sample { texture, has_level } => match &self.images[texture] {
                    image if image.of.has_mips && !has_level => [ANYTHING; 4],
                    image if image.of.seen == Seen::Depth => [ANYTHING; 4],
                    image => image.sample(uv),
                },
            };
            sum = std::array::from_fn(|at| sum[at].plus(value[at]));
        }
        sum.map(|one| one.wider(2e-6))
    }

    fn fill(&mut self, sum: &[Term], halves: bool, targets: &[Target]) {
        let Some(first) = targets.first() else { return };
        let (width, height) = (self.images[first.texture].width, self.images[first.texture].height);
        for [x, y] in places(width, height) {
            let uv = [(x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64];
            let factor = if halves && uv[0] > 0.5 { 0.5 } else { 1.0 };
            let sum = self.sum(sum, uv).map(|one| one.of(|one| one * factor));
            for target in targets {
                let image = &mut self.images[target.texture];
                let layer = usize::from(image.of.is_array);
                let before = match target.clears {
                    true => stored(image.of.format, [0.0, 0.0, 0.0, 1.0].map(Interval::exactly)),
                    false => image.texel(layer, [x, y]),
                };
                let value = if image.of.seen == Seen::Unsigned { sum.map(cut) } else { sum };
                let value = match target.adds {
                    true => std::array::from_fn(|at| before[at].plus(value[at]).wider(2e-6)),
                    false => value,
                };
                image.store(layer, [x, y], value);
            }
        }
    }

    fn store(&mut self, sum: &[Term], side: usize, texture: usize) {
        let (width, height) = (self.images[texture].width, self.images[texture].height);
        for [x, y] in places(side.min(width), side.min(height)) {
            let sum = self.sum(sum, [x as f64 / 64.0, y as f64 / 64.0]);
            let image = &mut self.images[texture];
            image.store(0, [x, y], if image.of.seen == Seen::Unsigned { sum.map(cut) } else { sum });
        }
    }

    /// Whichever invocation of a column comes last.
    fn count(&mut self, sum: &[Term], side: usize) {
        for x in 0..side.min(WORDS) {
            let of_column = (0..side).map(|y| cut(self.sum(sum, [x as f64 / 64.0, y as f64 / 64.0])[0]));
            self.words[x] = of_column.reduce(Interval::hull).unwrap_or(ANYTHING);
        }
    }
}

/// The contents of each texture after the frame, by its name.
pub(crate) fn simulate(drawn: &Drawn) -> BTreeMap<String, Vec<Texel>> {
    let images = drawn.textures.iter().map(Image::new).collect();
    let mut simulation = Simulation { images, words: vec![Interval::exactly(0.0); WORDS] };
    for deed in &drawn.deeds {
        match deed {
            Deed::Fill { sum, halves, targets, depth } => {
                simulation.fill(sum, *halves, targets);
                if let Some((texture, value)) = depth {
                    let image = &mut simulation.images[*texture];
                    let layer = usize::from(image.of.is_array);
                    for [x, y] in places(image.width, image.height) {
                        image.store(layer, [x, y], [Interval::exactly(*value); 4]);
                    }
                }
            }
            Deed::Store { sum, side, texture: Some(texture) } => simulation.store(sum, *side, *texture),
            Deed::Store { sum, side, texture: None } => simulation.count(sum, *side),
            Deed::Copy { from, to } => {
                simulation.images[*to].texels = simulation.images[*from].texels.clone();
            }
        }
    }
    simulation.images.into_iter().map(|image| (image.of.name.clone(), image.texels)).collect()
}
