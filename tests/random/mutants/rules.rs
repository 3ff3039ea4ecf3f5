//! Places of a template at which a fault can be planted, and the text with the fault.
//!
//! Only WGSL is changed: not tags and expressions of the template language, comments, attributes, or declarations (of
//! types, and of overrides, whose values are pipelines' own).
//! Faults are single: an operator, a comparison, a sign, a component, a number, or a call whose operands are
//! swapped or which is left out. Guards against zero (numbers below a thousandth) are left alone, since no picture
//! shows them.

use std::ops::Range;

/// A template with one fault.
#[derive(Clone, Debug)]
pub(crate) struct Violation {
    /// The line, from 1.
    pub(crate) line: usize,
    /// The rule that was applied.
    pub(crate) rule: &'static str,
    /// The bytes of the project's template that it takes the place of.
    pub(crate) place: Range<usize>,
    /// The line as it reads now; of a call over several lines the first.
    pub(crate) reads: String,
    /// The whole template with it.
    pub(crate) text: String,
}

/// Replacements of operators, spaces included: old, new, name of the rule.
const OPERATORS: &[(&str, &str, &str)] = &[
    (" + ", " - ", "operator"),
    (" - ", " + ", "operator"),
    (" * ", " / ", "operator"),
    (" / ", " * ", "operator"),
    (" += ", " -= ", "operator"),
    (" *= ", " /= ", "operator"),
    (" < ", " > ", "comparison"),
    (" > ", " < ", "comparison"),
    (" <= ", " >= ", "comparison"),
    (" >= ", " <= ", "comparison"),
    (" == ", " != ", "comparison"),
    (" != ", " == ", "comparison"),
    (" && ", " || ", "comparison"),
    (" || ", " && ", "comparison"),
];

const COMPONENTS: &[(&str, &str)] = &[
    ("x", "y"),
    ("y", "x"),
    ("z", "y"),
    ("w", "z"),
    ("r", "g"),
    ("g", "b"),
    ("b", "r"),
    ("xy", "yx"),
    ("zw", "xy"),
    ("xyz", "zyx"),
    ("rgb", "bgr"),
    ("zy", "yz"),
    ("xz", "zx"),
];

/// Every template that differs by one fault, in the order of the places.
pub(crate) fn violations(template: &str) -> Vec<Violation> {
    let code = code(template);
    let mut found: Vec<(Range<usize>, String, &'static str)> = Vec::new();
    for (was, is, rule) in OPERATORS {
        for (at, _) in template.match_indices(was).filter(|(at, _)| code[at + 1]) {
            found.push((at..at + was.len(), (*is).to_owned(), rule));
        }
    }
    let bytes = template.as_bytes();
    let is_word = |at: usize| bytes.get(at).is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
    for at in (0..bytes.len()).filter(|at| code[*at]) {
        let before = at.checked_sub(1).map(|at| bytes[at]);
        if bytes[at] == b'-' && before.is_some_and(|byte| b"( ".contains(&byte)) && is_word(at + 1) {
            found.push((at..at + 1, String::new(), "sign"));
        }
        if bytes[at] == b'.' && at > 0 && (is_word(at - 1) || b")]".contains(&bytes[at - 1])) {
            let end = (at + 1..bytes.len()).find(|at| !is_word(*at)).unwrap_or(bytes.len());
            let own = COMPONENTS.iter().find(|(was, _)| *was == &template[at + 1..end]);
            found.extend(own.map(|(_, is)| (at + 1..end, (*is).to_owned(), "component")));
        }
        if bytes[at].is_ascii_digit() && at > 0 && !is_word(at - 1) && bytes[at - 1] != b'.' {
            found.extend(number(template, at).map(|(range, is)| (range, is, "constant")));
        }
        if bytes[at].is_ascii_alphabetic() && (at == 0 || !is_word(at - 1)) {
            found.extend(call(template, at));
        }
    }
    found.sort_by_key(|(range, ..)| (range.start, range.end));
    let plant = |(range, is, rule): (Range<usize>, String, &'static str)| {
        let text = [&template[..range.start], &is, &template[range.end..]].concat();
        let start = text[..range.start].rfind('\n').map_or(0, |at| at + 1);
        let reads = text[start..].lines().next().unwrap_or_default().trim().to_owned();
        Violation { line: template[..range.start].matches('\n').count() + 1, rule, place: range, reads, text }
    };
    found.into_iter().map(plant).collect()
}

/// For each byte whether it is WGSL that runs.
fn code(template: &str) -> Vec<bool> {
    let mut code = vec![true; template.len() + 1];
    for (open, close) in [("{%", "%}"), ("{#", "#}"), ("{{", "}}"), ("//", "\n")] {
        let mut from = 0;
        while let Some(start) = template[from..].find(open).map(|at| at + from) {
            let end = template[start..].find(close).map_or(template.len(), |at| start + at + close.len());
            code[start..end].fill(false);
            from = end;
        }
    }
    let mut start = 0;
    for line in template.split_inclusive('\n') {
        let trimmed = line.trim_start();
        let declares =
            ["@", "struct ", "fn ", "var<", "override "].iter().any(|words| trimmed.starts_with(words));
        let is_member = trimmed.trim_end().ends_with(',') && trimmed.contains(": ") && !trimmed.contains('(');
        if declares || is_member {
            code[start..start + line.len()].fill(false);
        }
        start += line.len();
    }
    code
}

/// Another number: half as much, a half for nothing, or the next whole one.
fn number(template: &str, at: usize) -> Option<(Range<usize>, String)> {
    let end = template[at..]
        .find(|c: char| !c.is_ascii_alphanumeric() && c != '.')
        .map_or(template.len(), |end| at + end);
    let text = &template[at..end];
    if let Some(whole) = text.strip_suffix('u') {
        return Some((at..end, format!("{}u", whole.parse::<u32>().ok()? + 1)));
    }
    if !text.contains('.') {
        return None;
    }
    let value: f64 = text.parse().ok()?;
    // Of a guard the exponent is behind the digits.
    let is = if value == 0.0 { 0.5 } else { value * 0.5 };
    (!text.contains('e')).then(|| (at..end, format!("{is:?}")))
}

/// A call with its operands swapped, or left out.
fn call(template: &str, at: usize) -> Option<(Range<usize>, String, &'static str)> {
    let open = at + template[at..].find(|c: char| !c.is_ascii_alphanumeric() && c != '_')?;
    if !template[open..].starts_with('(') {
        return None;
    }
    let (arguments, end) = arguments(template, open)?;
    let argument = |at: usize| template[arguments[at].clone()].trim();
    let (is, rule) = match (&template[at..open], arguments.len()) {
        ("clamp", 3) | ("normalize" | "abs" | "saturate", 1) => {
            (format!("({})", argument(0)), "call left out")
        }
        ("min" | "max", 2) => {
            let is_guard = |text: &str| text.parse::<f64>().is_ok_and(|value| value > 0.0 && value <= 1e-3);
            if is_guard(argument(0)) || is_guard(argument(1)) {
                return None;
            }
            let is_number = argument(0).starts_with(|c: char| c.is_ascii_digit());
            (format!("({})", argument(usize::from(is_number))), "call left out")
        }
        (name @ ("mix" | "select"), 3) => {
            (format!("{name}({}, {}, {})", argument(1), argument(0), argument(2)), "operands swapped")
        }
        ("cross", 2) => (format!("cross({}, {})", argument(1), argument(0)), "operands swapped"),
        _ => return None,
    };
    Some((at..end, is, rule))
}

/// The text between the parentheses of a call, argument by argument, and the place after it.
fn arguments(template: &str, open: usize) -> Option<(Vec<Range<usize>>, usize)> {
    let (mut depth, mut start, mut found) = (0, open + 1, Vec::new());
    for (at, byte) in template.bytes().enumerate().skip(open) {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => {
                depth -= 1;
                if depth == 0 {
                    found.push(start..at);
                    found.retain(|range| !template[range.clone()].trim().is_empty());
                    return Some((found, at + 1));
                }
            }
            b',' if depth == 1 => {
                found.push(start..at);
                start = at + 1;
            }
            _ => {}
        }
    }
    None
}

#[test]
fn each_kind_of_fault_is_planted_in_code_only() {
    let template = "{# a + b #}\n// 1.0 * 2.0\n@group(1) @binding(3) var x: f32;\n    let at = max(-uv.x, 0.5) + 2u; // - 1.0\n{{ 1.0 }}\n";
    let violations = violations(template);
    let reads: Vec<&str> = violations.iter().map(|fault| fault.reads.as_str()).collect();
    assert_eq!(
        reads,
        [
            "let at = (-uv.x) + 2u; // - 1.0",
            "let at = max(uv.x, 0.5) + 2u; // - 1.0",
            "let at = max(-uv.y, 0.5) + 2u; // - 1.0",
            "let at = max(-uv.x, 0.25) + 2u; // - 1.0",
            "let at = max(-uv.x, 0.5) - 2u; // - 1.0",
            "let at = max(-uv.x, 0.5) + 3u; // - 1.0",
        ]
    );
    assert!(violations.iter().all(|fault| fault.line == 4));
}
