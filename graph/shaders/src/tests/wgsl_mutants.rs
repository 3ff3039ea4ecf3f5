//! Mutants of WGSL texts: what Chrome's compiler refuses is refused here, and what it takes is refused by naga alone.
//!
//! The texts are the valid ones of `wgsl/` and those of the project's templates. A mutant differs in one to three
//! places: an operator, a literal, a name, a type or an attribute is exchanged, or a token or statement left out,
//! repeated or moved. Where `tint` is not installed, nothing is compared.

use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;
use umbragraph_test_support::scratch::ScratchFolder;

use super::wgsl_rules::{self, Expected};
use super::{Fixture, tint};
use crate::codes;
use crate::written::tokens::{Tokens, is_name};
use crate::{AxisKind, AxisValue, AxisValues};

const OPERATORS: [&str; 19] =
    ["+", "-", "*", "/", "%", "&", "|", "^", "<<", ">>", "<", ">", "<=", ">=", "==", "!=", "&&", "||", "="];

const LITERALS: [&str; 24] = [
    "0",
    "1",
    "2",
    "-1",
    "0u",
    "1u",
    "2u",
    "4u",
    "32u",
    "0i",
    "3i",
    "0.0",
    "1.0",
    "-1.0",
    "0.5f",
    "1e38",
    "1e39f",
    "3000000000",
    "4294967295u",
    "2147483647",
    "0x7fc00000u",
    "true",
    "false",
    "65536",
];

const TYPES: [&str; 22] = [
    "f32",
    "i32",
    "u32",
    "bool",
    "vec2f",
    "vec3f",
    "vec4f",
    "vec2u",
    "vec3i",
    "vec4<bool>",
    "mat2x2f",
    "mat3x3f",
    "mat4x4f",
    "array<f32, 4>",
    "array<u32>",
    "atomic<u32>",
    "sampler",
    "texture_2d<f32>",
    "vec2<f32>",
    "vec3<u32>",
    "ptr<function, f32>",
    "array<vec4f, 2>",
];

const FUNCTIONS: [&str; 40] = [
    "abs",
    "min",
    "max",
    "clamp",
    "mix",
    "step",
    "smoothstep",
    "pow",
    "sqrt",
    "exp",
    "log",
    "sin",
    "acos",
    "sign",
    "fract",
    "floor",
    "round",
    "length",
    "distance",
    "dot",
    "cross",
    "normalize",
    "reflect",
    "select",
    "all",
    "any",
    "countOneBits",
    "extractBits",
    "ldexp",
    "modf",
    "transpose",
    "determinant",
    "dpdx",
    "fwidth",
    "saturate",
    "fma",
    "atan2",
    "inverseSqrt",
    "firstLeadingBit",
    "pack2x16float",
];

const INSERTED: [&str; 36] = [
    "@compute",
    "@fragment",
    "@vertex",
    "@workgroup_size(1)",
    "@group(0)",
    "@binding(0)",
    "@location(0)",
    "@id(1)",
    "@align(16)",
    "@size(16)",
    "@must_use",
    "@interpolate(flat)",
    "@invariant",
    "@builtin(position)",
    "@const",
    "-",
    "!",
    "~",
    "&",
    "*",
    "(",
    ")",
    "break;",
    "continue;",
    "return;",
    "discard;",
    "loop { }",
    "let k = 1;",
    "var k = 1u;",
    "const k = 2;",
    "k = 3;",
    "const_assert 1 < 2;",
    "if true { return; }",
    "{ }",
    ".x",
    "[0]",
];

/// Keywords of statements and declarations.
const WORDS: [&str; 16] = [
    "fn",
    "struct",
    "alias",
    "override",
    "var",
    "for",
    "loop",
    "continuing",
    "break",
    "continue",
    "discard",
    "default",
    "enable",
    "requires",
    "true",
    "false",
];

const SPACES: [&str; 6] = ["function", "private", "workgroup", "storage", "uniform", "storage, read_write"];

fn one_of<'a>(random: &mut Random, all: &[&'a str]) -> &'a str {
    all[random.below(all.len())]
}

/// Returns WGSL with one token or statement changed at random.
fn mutated(text: &str, random: &mut Random) -> String {
    let tokens = Tokens::new(text);
    if tokens.ranges.len() < 4 {
        return text.to_owned();
    }
    let at = random.below(tokens.ranges.len());
    let word = tokens.word(at);
    let range = tokens.ranges[at].clone();
    let put = |with: &str| format!("{}{with}{}", &text[..range.start], &text[range.end..]);
    let other = random.below(tokens.ranges.len());
    let is_number = word.starts_with(|first: char| first.is_ascii_digit());
    // The noise of which most is no WGSL at all is rare.
    match random.below(40) {
        0 => put(""),
        1 => put(&format!("{word} {word}")),
        2 | 3 => put(&format!("{} {word}", one_of(random, &INSERTED))),
        4 => put(tokens.word(other)),
        5 => put(one_of(random, &LITERALS)),
        6 => put(one_of(random, &TYPES)),
        7..=20 if word == "(" => {
            let close = tokens.ranges.get(tokens.closing(at)).map_or(text.len() - 1, |range| range.start);
            format!("{}{}{}", &text[..range.start], &text[range.end..close], &text[close + 1..])
        }
        7..=20 if word == "@" => {
            let end = tokens.ranges.get(tokens.after_attributes(at)).map_or(text.len(), |range| range.start);
            format!("{}{}", &text[..range.start], &text[end..])
        }
        7..=9 => {
            // A statement is left out, repeated or moved.
            let ends = |at: &usize| [";", "{", "}"].contains(&tokens.word(*at));
            let Some(first) = (0..at).rev().find(ends) else { return put("") };
            let Some(last) = (at..tokens.ranges.len()).find(ends) else { return put("") };
            let statement = &text[tokens.ranges[first].end..tokens.ranges[last].end];
            let without =
                format!("{}{}", &text[..tokens.ranges[first].end], &text[tokens.ranges[last].end..]);
            match random.below(3) {
                0 => without,
                1 => format!("{}{statement}{}", &text[..range.start], &text[range.start..]),
                _ => {
                    let ends: Vec<usize> =
                        without.match_indices([';', '{', '}']).map(|(at, _)| at + 1).collect();
                    let to = ends[random.below(ends.len())];
                    format!("{}{statement}{}", &without[..to], &without[to..])
                }
            }
        }
        _ if OPERATORS.contains(&word) => put(one_of(random, &OPERATORS)),
        _ if is_number => put(one_of(random, &LITERALS)),
        _ if SPACES.contains(&word) => put(one_of(random, &SPACES)),
        _ if TYPES.iter().any(|ty| ty.starts_with(word)) => put(one_of(random, &TYPES)),
        _ if tokens.word(at + 1) == "(" => put(one_of(random, &FUNCTIONS)),
        _ => {
            // A name is exchanged by another, whatever it names.
            let names: Vec<&str> = (0..tokens.ranges.len())
                .map(|at| tokens.word(at))
                .filter(|word| is_name(word) && !WORDS.contains(word))
                .collect();
            if names.is_empty() || !is_name(word) || WORDS.contains(&word) {
                return mutated(text, random);
            }
            put(one_of(random, &names))
        }
    }
}

/// Returns whether Chrome's compiler `tint` accepts the WGSL, and the first line of its error.
fn is_taken_by_tint(text: &str, folder: &ScratchFolder) -> (bool, String) {
    match tint::judge(text, folder) {
        Ok(()) => (true, String::new()),
        Err(said) => {
            let first = said.lines().find(|line| line.contains("error")).unwrap_or_default();
            (false, first.to_owned())
        }
    }
}

#[derive(Debug, Default)]
pub(super) struct Tally {
    mutants: usize,
    refused: usize,
    /// The number of modules that `tint` accepts and naga rejects.
    unknown: usize,
    missed: Vec<String>,
    too_strict: Vec<String>,
}

impl Tally {
    pub(super) fn compare(&mut self, text: &str, folder: &ScratchFolder) {
        let (is_taken, said) = is_taken_by_tint(text, folder);
        self.mutants += 1;
        self.refused += usize::from(!is_taken);
        match (is_taken, wgsl_rules::rejected(text)) {
            (false, None) => self.missed.push(format!("{said}\n{text}")),
            // It gives overrides no values.
            (true, Some((rejection, _))) if rejection.code == codes::WGSL_OVERRIDES => {}
            (true, Some((rejection, false))) => {
                self.too_strict.push(format!("{}\n{text}", rejection.message));
            }
            (true, Some((_, true))) => self.unknown += 1,
            _ => {}
        }
    }

    pub(super) fn report(&self, what: &str) {
        println!(
            "{what}: {} mutants, {} refused by tint, of which {} are taken here; {} taken by tint and refused by naga, {} by us",
            self.mutants,
            self.refused,
            self.missed.len(),
            self.unknown,
            self.too_strict.len()
        );
        let shortest = |texts: &[String]| {
            let mut texts = texts.to_vec();
            texts.sort_by_key(String::len);
            texts.truncate(40);
            texts.join("\n----\n")
        };
        let (missed, too_strict) = (shortest(&self.missed), shortest(&self.too_strict));
        assert!(
            missed.is_empty() && too_strict.is_empty(),
            "taken here alone:\n{missed}\nrefused here alone:\n{too_strict}"
        );
    }
}

#[test]
fn mutants_of_the_rules_texts_are_judged_as_by_chrome() {
    if !tint::is_installed() {
        return;
    }
    let folder = ScratchFolder::new("wgsl-mutants");
    let mut random = Random(0x5DEE_CE66_D1CE_4E5B ^ property::seed());
    let mut tally = Tally::default();
    let texts: Vec<String> = wgsl_rules::cases()
        .into_iter()
        .filter(|case| case.expected == Expected::Valid && case.text.len() < 2000)
        .map(|case| case.text)
        .collect();
    for _ in 0..400 * property::times() {
        let mut text = texts[random.below(texts.len())].clone();
        for _ in 0..1 + random.below(5) / 4 {
            text = mutated(&text, &mut random);
        }
        tally.compare(&text, &folder);
    }
    tally.report("texts of the rules");
}

/// Random values for about half of the boolean and enumeration axes of a template.
fn values(fixture: &Fixture, root: &str, random: &mut Random) -> AxisValues {
    let mut values = AxisValues::new();
    for axis in fixture.set.axes(root).into_iter().flat_map(crate::Axes::iter) {
        let value = match &axis.kind {
            AxisKind::Bool => AxisValue::Bool(random.below(2) == 0),
            AxisKind::Enum(words) => AxisValue::Name(words[random.below(words.len())].clone()),
            _ => continue,
        };
        if random.below(2) == 0 {
            values.insert(axis.name.clone(), value);
        }
    }
    values
}

#[test]
fn mutants_of_templates_are_judged_as_by_chrome() {
    if !tint::is_installed() {
        return;
    }
    let sound = Fixture::sound(umbragraph_shaders_templates::FILES);
    let folder = ScratchFolder::new("wgsl-mutants-templates");
    let mut random = Random(0x1234_5678_9ABC_DEF1 ^ property::seed());
    let mut tally = Tally::default();
    let roots = super::roots(&sound.set);
    let mut texts = 0;
    while texts < 6 * property::times() {
        let root = roots[random.below(roots.len())];
        let values = values(&sound, root, &mut random);
        // Constraints forbid some.
        let Some(text) = crate::generate(&sound.set, root, &values) else { continue };
        texts += 1;
        for _ in 0..25 {
            tally.compare(&mutated(&text, &mut random), &folder);
        }
    }
    tally.report("texts of templates");
}
