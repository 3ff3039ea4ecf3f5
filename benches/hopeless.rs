//! Texts of which nothing can be made; each is answered with diagnostics, soon, and in little memory.

use std::fmt::Write as _;

/// Returns the names and the texts of invalid or extreme pipelines.
pub(crate) fn texts() -> Vec<(&'static str, String)> {
    const TEN_MEGABYTES: usize = 10 << 20;
    vec![
        ("empty", String::new()),
        ("a byte-order mark alone", "\u{feff}".to_owned()),
        ("a comment alone", "// nothing".to_owned()),
        ("a comment without end", "/* ".to_owned() + &"x".repeat(TEN_MEGABYTES)),
        ("nul bytes", "\0".repeat(TEN_MEGABYTES)),
        ("one line of 10 MB", "x".repeat(TEN_MEGABYTES)),
        ("10 MB of empty lines", "\n".repeat(TEN_MEGABYTES)),
        ("a list of 10 MB on one line", format!("[{}0]", "0,".repeat(TEN_MEGABYTES / 2))),
        ("a list of 10 MB on many lines", format!("[\n{}0]", "1,\n".repeat(TEN_MEGABYTES / 3))),
        ("a string of 10 MB", format!("\"{}\"", "x".repeat(TEN_MEGABYTES))),
        ("a string of 10 MB without end", format!("\"{}", "x".repeat(TEN_MEGABYTES))),
        ("a name of 10 MB", valid(&format!("\"{}\": {{}}", "x".repeat(TEN_MEGABYTES)), "")),
        ("a key of 10 MB", format!("{{ \"{}\": 1 }}", "k".repeat(TEN_MEGABYTES))),
        ("a number of 10 MB", "9".repeat(TEN_MEGABYTES)),
        ("an expression of 10 MB", sized(&format!("\"{}1\"", "1+".repeat(TEN_MEGABYTES / 2)))),
        (
            "an expression 100,000 deep",
            sized(&format!("\"{}1{}\"", "(".repeat(100_000), ")".repeat(100_000))),
        ),
        ("an expression of 100,000 signs", sized(&format!("\"{}1\"", "-".repeat(100_000)))),
        ("arrays 100,000 deep", "[".repeat(100_000) + &"]".repeat(100_000)),
        ("objects 100,000 deep", "{\"a\":".repeat(100_000) + "1" + &"}".repeat(100_000)),
        ("arrays 100,000 deep, open", "[".repeat(100_000)),
        ("500 arrays and 10 MB of braces", "[".repeat(500) + &"}".repeat(TEN_MEGABYTES)),
        (
            "10 MB of lines in a list that is never closed",
            format!(
                "{{\n  \"a\": [\n{}\n  \"b\": 1\n}}\n",
                format!("    \"{}\",\n", "x".repeat(100)).repeat(TEN_MEGABYTES / 107)
            ),
        ),
        ("a million passes", valid(&many(1_000_000, "\"fullscreen\":{}"), "")),
        ("a million empty passes", valid(&many(1_000_000, ""), "")),
        ("a million passes of a bad name", valid(&many(1_000_000, "\"fulscreen\":{}"), "")),
        ("a million parameters", valid("", &many(1_000_000, "\"type\":\"f32\",\"default\":1"))),
        ("a million broken parameters", valid("", &many(1_000_000, "\"type\":\"f33\""))),
        ("60,000 passes without a resource", valid(&many(60_000, SHOWN), "")),
        ("a million unknown keys", format!("{{{}}}", many(1_000_000, ""))),
        ("a key a million times", format!("{{{}\"a\":1}}", "\"a\":1,".repeat(1_000_000))),
        ("a loop of 1e9 rounds", looped("1e9")),
        ("a loop of a list of 1e9", looped("[1e9, 1e9][0]")),
        ("loops in loops", nested()),
        ("a width of 1e308 * 10", sized("\"1e308 * 10\"")),
        ("a width of 1e999", sized("1e999")),
        ("a width of NaN", sized("NaN")),
        ("a width of \"nan\"", sized("\"nan\"")),
        ("a width of \"inf\"", sized("\"inf\"")),
        ("a width of -1", sized("-1")),
        ("a width of 0", sized("0")),
        ("a width of 1e300", sized("1e300")),
        ("a width of 2^64", sized("18446744073709551616")),
        ("a width of 0.5", sized("0.5")),
    ]
}

const SHOWN: &str = "\"fullscreen\":{\"shader\":\"tonemap.wgsl.jinja\",\"bind\":{\"source\":\"&nowhere\"},\"color\":[{\"to\":\"&target\"}]}";

fn many(count: usize, inside: &str) -> String {
    let mut text = String::new();
    for at in 0..count {
        let _ = write!(text, "{}\"n{at}\":{{{inside}}}", if at == 0 { "" } else { "," });
    }
    text
}

/// Returns a pipeline with the given passes and parameters; everything else in it is valid.
fn valid(passes: &str, parameters: &str) -> String {
    format!(
        r#"{{ "format": 1, "name": "hopeless", "parameters": {{ {parameters} }},
  "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{ {passes} }} }}"#
    )
}

/// Returns a pipeline with a texture of the given width.
fn sized(width: &str) -> String {
    format!(
        r#"{{ "format": 1, "name": "hopeless",
  "resources": {{ "wide": {{ "texture": {{ "format": "rgba8unorm", "size": [{width}, 1], "lifetime": "persistent" }} }} }},
  "passes": {{ "fill": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&wide" }}] }} }} }} }}"#
    )
}

fn looped(rounds: &str) -> String {
    valid(
        &format!(
            r#""fill": {{ "for_each": {{ "at": "={rounds}" }}, "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target" }}] }} }}"#
        ),
        "",
    )
}

/// Returns a pipeline with subgraphs that each use the next one 4,096 times.
fn nested() -> String {
    let step = |next: &str| {
        format!(r#"{{ "passes": {{ "a": {{ "for_each": {{ "at": 4096 }}, "use": "{next}" }} }} }}"#)
    };
    format!(
        r#"{{ "format": 1, "name": "hopeless", "subgraphs": {{ "a": {}, "b": {}, "c": {}, "d": {{ "passes": {{}} }} }},
  "resources": {{}}, "passes": {{ "all": {{ "use": "a" }} }} }}"#,
        step("b"),
        step("c"),
        step("d")
    )
}
