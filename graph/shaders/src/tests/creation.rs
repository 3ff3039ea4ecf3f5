//! Messages about texts that browsers refuse when the module is created, and naga does not.

use super::wgsl_rules;
use crate::TargetProfile;
use crate::module::wgsl;

/// Statements that must be rejected, each with a part of the message.
const STATEMENTS: [(&str, &str); 35] = [
    ("let r = x & 7u | y;", "\"&\" and \"|\""),
    ("let r = x << y + 1u;", "\"<<\" and \"+\""),
    ("let r = x == y == true;", "takes one \"==\""),
    ("let r = x < 1u && y < 1u || x > 3u;", "\"&&\" and \"||\""),
    ("loop { }", "nothing leaves this loop"),
    ("loop { loop { break; } }", "nothing leaves this loop"),
    ("loop { switch x { default: { break; } } }", "nothing leaves this loop"),
    ("for (;;) { }", "nothing leaves this loop"),
    ("loop { continuing { } }", "nothing leaves this loop"),
    ("let r = clamp(z, 2.0, 1.0);", "low bound 2 above the high bound 1"),
    ("let r = clamp(vec2(z), vec2(0.0, HIGH), vec2(1.0));", "low bound 3 above the high bound 1"),
    ("let r = clamp(z, HIGH, 1.0);", "low bound 3"),
    ("let r = smoothstep(1.0, 1.0, z);", "both edges at 1"),
    ("let r = extractBits(x, 30u, 5u);", "more than 32 together"),
    ("let r = insertBits(x, y, 30u, 5u);", "more than 32 together"),
    ("let r = ldexp(z, 129);", "exponent 129"),
    ("let r = pack2x16float(vec2(1e6, 0.0));", "1000000 does not fit"),
    ("let r = quantizeToF16(-7e4);", "-70000 does not fit"),
    ("let r = unpack2x16float(0x7c00u);", "0x7c00"),
    ("let r = bitcast<f32>(0x7fc00000u);", "0x7fc00000"),
    ("let r = bitcast<f32>(-1);", "0xffffffff"),
    ("let r = bitcast<vec2<f32>>(vec2(0u, 0x7f800000u));", "0x7f800000"),
    ("let r = quantizeToF16(65510.0);", "65510 does not fit"),
    ("let r = bitcast<f32>(2139095040u);", "0x7f800000"),
    ("return; loop { }", "nothing leaves this loop"),
    (
        "loop { if x == y { continue; } let k = x; continuing { _ = k; break if x == y; } }",
        "jumps over the declaration of \"k\"",
    ),
    ("let k = 1u; switch x { case k: { } default: { } }", "but \"k\" is none"),
    ("let r = 3000000000;", "without a suffix is an i32"),
    ("let r = bitcast<u32>(vec2(x));", "as many bits as it gives"),
    ("let r = sign(x);", "takes no unsigned numbers"),
    ("var r: array<f32, 70000>;", "the elements of \"r\" are 70000, but WGSL allows 65535"),
    ("let r = array<f32, 3>(1, 2)[0];", "has 3 elements, but 2 are given"),
    ("let r = mix(3e38f, -3e38f, 3f);", "\"mix\" of these constants"),
    ("let r = determinant(mat2x2f(1e38, 0, 0, 1e38));", "\"determinant\" of these constants"),
    ("// \0", "null character"),
];

/// Modules that must be rejected, each with a part of the message.
const MODULES: [(&str, &str); 13] = [
    ("@id(1) const a = 1;", "\"@id\" does not belong before \"const\""),
    ("@workgroup_size(1) fn g() { }", "belongs to compute entry points alone"),
    ("@compute @workgroup_size(1u, 1i) fn main() { }", "of the types i32 and u32"),
    (
        "var<workgroup> a: f32; fn g() { a = 1; } @fragment fn main() { g(); }",
        "\"main\", a fragment stage, uses \"a\", which is memory of a workgroup",
    ),
    (
        "@group(0) @binding(0) var<storage, read_write> a: f32; @vertex fn main() -> @builtin(position) vec4f { a = 1; return vec4f(); }",
        "uses \"a\", which can be written",
    ),
    ("@compute @workgroup_size(1) fn main(@location(0) a: u32) { }", "has the input \"a\" with a location"),
    ("@group(0) @binding(0) var<storage> a: atomic<u32>;", "\"a\" holds atomics, but can only be read"),
    ("struct S { a: atomic<u32> } var<workgroup> a: S; fn g() { let r = a; }", "is not read as a whole"),
    ("var<workgroup> a: atomic<u32>; fn g() { a = 1u; }", "an atomic is not assigned to"),
    ("struct S { a: f32 } fn g(s: S) { let r = s[0]; }", "has members, and no elements"),
    ("fn g() -> f32 { discard; }", "not every way through \"g\" ends"),
    (
        "@group(0) @binding(0) var t: texture_2d<f32>; @group(0) @binding(1) var s: sampler; @fragment fn main() { _ = textureSample(t, s, vec2f(), vec2(8)); }",
        "the offset 8 is not between -8 and 7",
    ),
    ("struct S { @size(2) a: bool }", "less than the 4 bytes"),
];

fn text(statements: &str) -> String {
    format!("const HIGH = 3.0;\nfn f(x: u32, y: u32, z: f32) {{ {statements}\n }}")
}

#[test]
fn messages_name_what_is_wrong() {
    let statements = STATEMENTS.iter().map(|(refused, says)| (text(refused), *says));
    let modules = MODULES.iter().map(|(refused, says)| ((*refused).to_owned(), *says));
    for (refused, says) in statements.chain(modules) {
        let message = wgsl_rules::rejected(&refused).map(|(rejection, _)| rejection.message);
        assert!(message.as_ref().is_some_and(|message| message.contains(says)), "{refused}: {message:?}");
    }
}

#[test]
fn values_of_overrides_are_arguments_too() {
    let text =
        "override low = 2.0; @compute @workgroup_size(1) fn main() { var z = 1.0; z = clamp(z, low, 1.5); }";
    let module = wgsl::parse(text).expect("WGSL");
    let info = wgsl::validate(&module, TargetProfile::webgpu().capabilities).expect("a valid module");
    let resolved = |low| wgsl::resolve_overrides(&module, &info, &[("low".to_owned(), low)].into()).map(drop);
    assert!(resolved(2.0).is_err_and(|rejection| rejection.message.contains("low bound 2 above")));
    assert!(resolved(1.0).is_ok());
}
