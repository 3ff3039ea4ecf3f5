//! Random constant expressions with extreme numbers: Chrome's compiler refuses the same of them.
//!
//! Floats, integers without a type and vectors of both, under operators and the built-in functions whose steps WGSL
//! looks at. Where `tint` is not installed, nothing is compared.

use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;
use umbragraph_test_support::scratch::ScratchFolder;

use super::tint;
use super::wgsl_mutants::Tally;

const FLOATS: [&str; 18] = [
    "0f", "1f", "2f", "0.5", "3", "-1f", "3e38f", "-3e38f", "1e38f", "1e20f", "-1e19f", "1e-40f", "1e-20f",
    "7.5f", "z", "1e10f", "2e19f", "K",
];
const INTEGERS: [&str; 13] = [
    "0",
    "1",
    "3",
    "40",
    "65536",
    "-1",
    "2147483647",
    "2147483648",
    "4294967295",
    "4611686018427387904",
    "-9223372036854775807",
    "3000000000",
    "N",
];

fn one_of<'a>(random: &mut Random, all: &[&'a str]) -> &'a str {
    all[random.below(all.len())]
}

/// A scalar of floats, with at most so many calls and operators around each other.
fn float(random: &mut Random, depth: usize) -> String {
    if depth == 0 || random.below(4) == 0 {
        return one_of(random, &FLOATS).to_owned();
    }
    let mut next = || float(random, depth - 1);
    let (one, other, third) = (next(), next(), next());
    match random.below(11) {
        0 => format!("fma({one}, {other}, {third})"),
        1 => format!("dot(vec2({one}, {other}), vec2({third}, 1f))"),
        2 => format!("inverseSqrt({one})"),
        3 => format!("abs({one})"),
        4 => format!("max({one}, {other})"),
        5 => format!("({one} * {other})"),
        6 => format!("({one} / {other})"),
        7 => format!("({one} - {other})"),
        8 => format!("select({one}, {other}, false && {third} > 0)"),
        9 => format!("vec2({one}, {other}).y"),
        _ => format!("({one} % {other})"),
    }
}

/// A call of a function that naga does not compute, whose value is not followed.
fn called(random: &mut Random) -> String {
    let (one, other, third) = (float(random, 0), float(random, 0), float(random, 0));
    match random.below(3) {
        0 => format!("smoothstep({one}, {other}, {third})"),
        1 => format!("refract(vec2({one}, {other}), vec2(1f, {third}), 2f)"),
        _ => format!("faceForward(vec2({one}, 1f), vec2({other}, 1f), vec2({third}, 1f))"),
    }
}

/// An expression of integers without a type.
fn integer(random: &mut Random, depth: usize) -> String {
    if depth == 0 || random.below(4) == 0 {
        return one_of(random, &INTEGERS).to_owned();
    }
    let (one, other) = (integer(random, depth - 1), integer(random, depth - 1));
    let by = random.below(40);
    match random.below(10) {
        0 => format!("abs({one})"),
        1 => format!("max({one}, {other})"),
        2 => format!("min({one}, {other})"),
        3 => format!("({one} >> {by}u)"),
        4 => format!("vec2({one}, {other}).x"),
        5 => format!("({one} - {other})"),
        6 => format!("({one} & {other})"),
        7 => format!("({one} / {other})"),
        8 => format!("(~{one})"),
        _ => format!("dot(vec2({one}, 1), vec2({other}, 1))"),
    }
}

#[test]
fn extreme_constants_are_judged_as_by_chrome() {
    if !tint::is_installed() {
        return;
    }
    let folder = ScratchFolder::new("wgsl-constants");
    let mut random = Random(0x0DDB_1A5E_5BAD_5EED ^ property::seed());
    let mut tally = Tally::default();
    for at in 0..300 * property::times() {
        let word = one_of(&mut random, &["let", "const", "var"]);
        let value = match at % 4 {
            0 => integer(&mut random, 2),
            1 => format!("vec2({}, {})", float(&mut random, 1), float(&mut random, 1)),
            2 => called(&mut random),
            _ => float(&mut random, 2),
        };
        let text =
            format!("const K = 2e38f;\nconst N = 5000000000;\nfn f(z: f32) {{ {word} r = {value}; }}\n");
        tally.compare(&text, &folder);
    }
    tally.report("constants");
}
