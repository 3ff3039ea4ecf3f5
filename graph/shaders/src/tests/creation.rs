//! Texts that browsers refuse when the module is created, each with a twin that they take.
//!
//! If `tint`, Chrome's compiler, is installed, it must refuse the one and take the other as well.

use std::process::Command;

use umbragraph_test_support::scratch::ScratchFolder;
use umbragraph_test_support::skip;

use crate::TargetProfile;
use crate::module::wgsl;

/// The refused text, the sound one, and a part of the message.
const PAIRS: [(&str, &str, &str); 25] = [
    ("let r = x & 7u | y;", "let r = (x & 7u) | y;", "\"&\" and \"|\""),
    ("let r = x << y + 1u;", "let r = x << (y + 1u);", "\"<<\" and \"+\""),
    ("let r = x == y == true;", "let r = (x == y) == true;", "takes one \"==\""),
    ("let r = x < 1u && y < 1u || x > 3u;", "let r = (x < 1u && y < 1u) || x > 3u;", "\"&&\" and \"||\""),
    ("loop { }", "loop { break; }", "nothing leaves this loop"),
    ("loop { loop { break; } }", "loop { loop { break; } break; }", "nothing leaves this loop"),
    (
        "loop { switch x { default: { break; } } }",
        "loop { if x == y { return; } }",
        "nothing leaves this loop",
    ),
    ("for (;;) { }", "for (;x < 3u;) { }", "nothing leaves this loop"),
    ("loop { continuing { } }", "loop { continuing { break if x == y; } }", "nothing leaves this loop"),
    ("let r = clamp(z, 2.0, 1.0);", "let r = clamp(z, 1.0, 2.0);", "low bound 2 above the high bound 1"),
    (
        "let r = clamp(vec2(z), vec2(0.0, HIGH), vec2(1.0));",
        "let r = clamp(vec2(z), vec2(0.0), vec2(1.0, HIGH));",
        "low bound 3 above the high bound 1",
    ),
    ("let r = clamp(z, HIGH, 1.0);", "let low = 3.0; let r = clamp(z, low, 1.0);", "low bound 3"),
    ("let r = smoothstep(1.0, 1.0, z);", "let r = smoothstep(2.0, 1.0, z);", "both edges at 1"),
    ("let r = extractBits(x, 30u, 5u);", "let r = extractBits(x, 27u, 5u);", "more than 32 together"),
    ("let r = insertBits(x, y, 30u, 5u);", "let r = insertBits(x, y, 30u, 2u);", "more than 32 together"),
    ("let r = ldexp(z, 129);", "let r = ldexp(z, 128);", "exponent 129"),
    (
        "let r = pack2x16float(vec2(1e6, 0.0));",
        "let r = pack2x16float(vec2(1e4, 0.0));",
        "1000000 does not fit",
    ),
    ("let r = quantizeToF16(-7e4);", "let r = quantizeToF16(-6e4);", "-70000 does not fit"),
    ("let r = unpack2x16float(0x7c00u);", "let r = unpack2x16float(0x7b00u);", "0x7c00"),
    ("let r = bitcast<f32>(0x7fc00000u);", "let r = bitcast<f32>(0x3fc00000u);", "0x7fc00000"),
    ("let r = bitcast<f32>(-1);", "let r = bitcast<f32>(1);", "0xffffffff"),
    (
        "let r = bitcast<vec2<f32>>(vec2(0u, 0x7f800000u));",
        "let r = bitcast<vec2<f32>>(vec2(0u, x));",
        "0x7f800000",
    ),
    ("let r = quantizeToF16(65510.0);", "let r = quantizeToF16(65504.0);", "65510 does not fit"),
    ("let r = bitcast<f32>(2139095040u);", "let r = bitcast<f32>(2143289344.0f);", "0x7f800000"),
    ("return; loop { }", "return; loop { break; }", "nothing leaves this loop"),
];

fn text(statements: &str) -> String {
    format!(
        "const HIGH = 3.0;\nfn f(x: u32, y: u32, z: f32) {{ {statements} }}\n@compute @workgroup_size(1) fn main() {{ f(1u, 2u, 3.0); }}\n"
    )
}

fn rejected(text: &str) -> Option<String> {
    let module = match wgsl::parse(text) {
        Ok(module) => module,
        Err(rejection) => return Some(rejection.message),
    };
    wgsl::validate(&module, TargetProfile::webgpu().capabilities).err().map(|rejection| rejection.message)
}

#[test]
fn browsers_refuse_one_of_each_pair_and_so_do_we() {
    for (refused, sound, says) in PAIRS {
        let message = rejected(&text(refused));
        assert!(message.as_ref().is_some_and(|message| message.contains(says)), "{refused}: {message:?}");
        assert_eq!(rejected(&text(sound)), None, "{sound}");
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

#[test]
fn chromes_compiler_says_the_same_of_each_pair() {
    if Command::new("tint").arg("--help").output().is_err() {
        skip::skipped("no tint on this machine");
        return;
    }
    let folder = ScratchFolder::new("creation");
    let path = folder.join("one.wgsl");
    for (refused, sound, _) in PAIRS {
        for (statements, takes) in [(refused, false), (sound, true)] {
            std::fs::write(&path, text(statements)).expect("a file");
            let output =
                Command::new("tint").args(["--format", "wgsl"]).arg(&path).output().expect("a process");
            let said = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.success(), takes, "{statements}: {said}");
        }
    }
}
