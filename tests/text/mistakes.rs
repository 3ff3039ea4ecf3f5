//! Mistakes that authors make on the teaching pipelines, each with what has to be said of it.
//!
//! Each row has the code, the text that is underlined, and a word of the way out. A finding counts three where all
//! hold, one less for each of place and way out that does not, and one where another code comes first.

use crate::common::{Outcome, With, check_with, read};
use umbragraph::diagnostic::{Place, Severity};

/// A lesson, the text that is replaced and by what, the code, what is underlined, and what leads out.
struct Mistake(&'static str, &'static str, &'static str, &'static str, &'static str, &'static str);

#[rustfmt::skip]
const MISTAKES: &[Mistake] = &[
    // Words
    Mistake("01-smallest", "\"fullscreen\"", "\"fulscreen\"", "UG0102", "fulscreen", "fullscreen"),
    Mistake("01-smallest", "gradient.wgsl.jinja", "gradiant.wgsl.jinja", "UG0500", "gradiant.wgsl.jinja", "gradient.wgsl.jinja"),
    Mistake("01-smallest", "\"to\": \"&target\"", "\"to\": \"&targt\"", "UG0301", "targt", "target"),
    Mistake("01-smallest", "rgba8unorm", "rgba8unrom", "UG0322", "rgba8unrom", "rgba8unorm"),
    Mistake("01-smallest", "\"lifetime\": \"imported\"", "\"lifetime\": \"import\"", "UG0107", "import", "imported"),
    Mistake("01-smallest", "\"=viewport\"", "\"=vieport\"", "UG0311", "vieport", "viewport"),
    Mistake("01-smallest", "\"format\": 1", "\"format\": 2", "UG0110", "2", "1"),
    Mistake("01-smallest", ", \"lifetime\": \"imported\"", "", "UG0407", "fill", "imported"),
    Mistake("01-smallest", "\"name\": \"smallest\",", "\"name\": \"smallest\"", "UG0101", "", ","),
    Mistake("02-resources", "\"source\": \"&kept\"", "\"sorce\": \"&kept\"", "UG0603", "sorce", "source"),
    Mistake("02-resources", "\"clear\": [0, 0, 0, 1]", "\"clear\": [0, 0, 0]", "UG0108", "[0, 0, 0]", "four"),
    // Order
    Mistake("03-versions", "color@paint", "color@pant", "UG0207", "color@pant", "paint"),
    Mistake("03-versions", "\"after\": [\"paint\"],", "\"after\": [\"paintt\"],", "UG0207", "paintt", "paint"),
    Mistake("03-versions", "\"blend\": \"add\"", "\"blend\": \"ad\"", "UG0107", "ad", "add"),
    // Expressions
    Mistake("04-expressions", "viewport / divisor", "viewport / divisr", "UG0311", "divisr", "divisor"),
    Mistake("04-expressions", "align(small.width, 16)", "algin(small.width, 16)", "UG0311", "algin", "align"),
    Mistake("04-expressions", "ceil(small.height / 3)", "ceil(small.height / 3", "UG0310", "", ")"),
    Mistake("04-expressions", "align(small.width, 16)", "align(smal.width, 16)", "UG0311", "smal.width", "small"),
    Mistake("04-expressions", "\"default\": 2", "\"default\": 9", "UG0204", "9", "8"),
    Mistake("04-expressions", "\"default\": 2", "\"default\": \"1,000\"", "UG0203", "1,000", "write a whole number"),
    Mistake("04-expressions", "\"max\": 8", "\"max\": \"8\"", "UG0105", "\"8\"", "without quotes: 8"),
    // Formats
    Mistake("05-formats", "[\"rgba32float\", \"rgba16float\"]", "\"rgba32float\"", "UG0323", "rgba32float", "rgba16float"),
    Mistake("05-formats", "[\"rgba32float\", \"rgba16float\"]", "\"rgba8uint\"", "UG0323", "rgba8uint", "rgba8unorm"),
    Mistake("27-ssao", "\"bind\": { \"source\": \"&occlusion_2\" }", "\"bind\": { \"source\": \"&depth\" }", "UG0323", "depth", "texture_depth_2d"),
    // Composition
    Mistake("06-extends", "\"kept\": null", "\"kep\": null", "UG0109", "kep", "kept"),
    Mistake("07-include", "parts/canvas.json", "parts/canvass.json", "UG0001", "parts/canvass.json", "canvas.json"),
    Mistake("08-subgraph", "\"use\": \"through_small\"", "\"use\": \"through_smal\"", "UG0212", "through_smal", "through_small"),
    Mistake("08-subgraph", "\"with\": { \"image\": \"&sharp\"", "\"with\": { \"imge\": \"&sharp\"", "UG0102", "imge", "image"),
    Mistake("08-subgraph", "\"divisor\": 16", "\"divisor\": 65", "UG0204", "65", "64"),
    Mistake("08-subgraph", "\"image\": \"&softer\", \"result\": \"&target\", \"divisor\"", "\"image\": \"&sofer\", \"result\": \"&target\", \"divisor\"", "UG0301", "sofer", "softer"),
    Mistake("21-subgraph-file", "parts/through_small.json", "parts/overlay.json", "UG0212", "parts/overlay.json", "extension"),
    Mistake("25-shared-settings", "\"extends\": \"smooth\"", "\"extends\": \"smoth\"", "UG0221", "smoth", "smooth"),
    // Loops and mips
    Mistake("09-loops-and-mips", "\"level\": \"=levels - 1\"", "\"level\": \"=level - 1\"", "UG0311", "level", "levels"),
    Mistake("09-loops-and-mips", "\"mip\": \"=level + 1\"", "\"mip\": \"=level\"", "UG0404", "chain", "mip"),
    Mistake("09-loops-and-mips", "\"mip\": \"=levels - 1\" } } }", "\"mip\": \"=levels\" } } }", "UG0405", "chain", "counted from 0"),
    Mistake("09-loops-and-mips", "\"show\": {", "\"show\": { \"after\": [\"dwn\"],", "UG0207", "dwn", "down"),
    Mistake("09-loops-and-mips", "\"for_each\": { \"level\": \"=levels - 1\" }", "\"for_each\": \"=levels - 1\"", "UG0105", "=levels - 1", "{ \\\"level\\\": \\\"=levels - 1\\\" }"),
    // Features, presets, toggles
    Mistake("10-features", "\"requires\": [\"glow\"]", "\"requires\": [\"glw\"]", "UG0202", "glw", "glow"),
    Mistake("10-features", "\"when\": \"=glow\"", "\"when\": \"=glo\"", "UG0311", "glo", "glow"),
    Mistake("12-extension-point", "\"before\": [\"show\"]", "\"before\": [\"shw\"]", "UG0207", "shw", "show"),
    Mistake("13-presets", "{ \"width\": 128", "{ \"widht\": 128", "UG0202", "widht", "width"),
    Mistake("17-toggles", "\"toggle\": \"softer\"", "\"toggle\": \"softr\"", "UG0214", "softr", "softer"),
    Mistake("17-toggles", "{ \"small\": \"&color\" }", "{ \"smal\": \"&color\" }", "UG0301", "smal", "small"),
    Mistake("19-feature-groups", "\"default\": true", "\"default\": false", "UG0217", "false", "plain"),
    Mistake("23-required-limits", "max_texture_dimension_2d", "max_texture_dimension_2", "UG0218", "max_texture_dimension_2", "max_texture_dimension_2d"),
    // Lifetimes and subresources
    Mistake("11-persistent", ", \"lifetime\": \"persistent\"", "", "UG0401", "sum", "clear"),
    Mistake("14-history", "trail@-1", "trail@-2", "UG0432", "trail@-2", "\\\"frames\\\": 2"),
    Mistake("14-history", ", \"initial\": [0, 0, 0, 1]", "", "UG0430", "{ \"format\": \"rgba16float\", \"size\": \"=viewport\", \"lifetime\": \"history\" }", "initial"),
    Mistake("15-subresources", "\"face\": \"+x\" }] } }", "\"face\": \"+w\" }] } }", "UG0107", "+w", "+x"),
    Mistake("15-subresources", "\"depth24plus-stencil8\"", "\"depth32float\"", "UG0323", "depth32float", "depth24plus-stencil8"),
    Mistake("15-subresources", "\"compare\": \"equal\"", "\"compare\": \"equals\"", "UG0107", "equals", "equal"),
    // Buffers, copies, meshes
    Mistake("16-buffers", "\"offset\": 2048, \"size\": 2048", "\"offset\": 2050, \"size\": 2044", "UG0409", "2050", "4"),
    Mistake("16-buffers", "\"samples\": 4", "\"samples\": 2", "UG0321", "2", "4"),
    Mistake("16-buffers", "\"resolve\": { \"to\": \"&target\" }", "\"resolve\": { \"to\": \"&small\" }", "UG0402", "small", "after"),
    Mistake("18-mesh", "\"float32x2\" }, {", "\"float32x\" }, {", "UG0607", "float32x", "float32"),
    Mistake("18-mesh", "\"name\": \"position\"", "\"name\": \"positon\"", "UG0603", "positon", "position"),
    Mistake("18-mesh", "triangle-strip", "triangle-stripe", "UG0107", "triangle-stripe", "triangle-strip"),
    Mistake("18-mesh", "\"buffer\": \"&points\",\n", "\"buffer\": \"&point\",\n", "UG0301", "point", "points"),
    Mistake("18-mesh", "\"=ceil(columns / 64)\"", "\"=columns / 48\"", "UG0406", "=columns / 48", "ceil"),
    Mistake("20-copies", "\"stencil-only\"", "\"stencil\"", "UG0107", "stencil", "stencil-only"),
    Mistake("20-copies", "\"extent\": [64, 32]", "\"extent\": [64, 64]", "UG0409", "64", "within"),
    // Values that follow
    Mistake("24-derived", "quality == 'low'", "quality == 'lo'", "UG0107", "lo", "low"),
    Mistake("24-derived", "\"filter\": \"=mixing\"", "\"filter\": \"mixing\"", "UG0107", "mixing", "=mixing"),
    Mistake("26-depth-prepass", "\"compare\": \"=closer\"", "\"compare\": \"closer\"", "UG0107", "closer", "=closer"),
    Mistake("31-constraints", "high <= wide / 4", "hihg <= wide / 4", "UG0311", "hihg", "high"),
    // Shaders
    Mistake("28-bloom", "\"upward\": true", "\"upwards\": true", "UG0602", "upwards", "upward"),
    Mistake("28-bloom", "\"upward\": true", "\"upward\": \"yes\"", "UG0512", "\"yes\"", "true"),
    Mistake("27-ssao", "\"radius\": \"=occlusion_radius\"", "\"radios\": \"=occlusion_radius\"", "UG0603", "radios", "radius"),
    Mistake("29-temporal", "\"jitter\": 8", "\"jiter\": 8", "UG0102", "jiter", "jitter"),
    // Declarations that contradict themselves
    Mistake("04-expressions", "\"max\": 8", "\"max\": 0", "UG0204", "0", "swap"),
    Mistake("04-expressions", "\"type\": \"u32\"", "\"type\": \"uint\"", "UG0107", "uint", "u32"),
    Mistake("10-features", "\"requires\": [\"glow\"]", "\"requires\": [\"glow\"], \"excludes\": [\"glow\"]", "UG0206", "glow", "remove one"),
    Mistake("10-features", "\"type\": \"bool\", \"default\": false, \"requires\"", "\"type\": \"enum\", \"default\": \"off\", \"requires\"", "UG0106", "", "[\\\"off\\\", …]"),
    // Names of another kind
    Mistake("10-features", "\"when\": \"=glow\"", "\"toggle\": \"glow\"", "UG0214", "glow", "\\\"when\\\": \\\"=glow\\\""),
    Mistake("10-features", "\"requires\": [\"glow\"]", "\"requires\": [\"low\"]", "UG0202", "low", "glow"),
    Mistake("17-toggles", "\"toggle\": \"veil\"", "\"when\": \"=veil\"", "UG0311", "veil", "toggle"),
    Mistake("13-presets", "\"parameters\": { \"width\": 128", "\"features\": { \"width\": 128", "UG0202", "width", "--set"),
    // Operators and members of other languages
    Mistake("04-expressions", "viewport / divisor\"", "viewport / divisor ** 2\"", "UG0310", "**", "multiply"),
    Mistake("04-expressions", "=align(small.width, 16)", "=divisor > 1 and divisor < 3 ? 16 : 8", "UG0310", "and", "&&"),
    Mistake("04-expressions", "=align(small.width, 16)", "=divisor = 1 ? 16 : 8", "UG0310", "", "=="),
    Mistake("04-expressions", "=align(small.width, 16)", "=viewport.x", "UG0311", "viewport.x", "viewport.width"),
    Mistake("24-derived", "quality == 'low'", "quality == low", "UG0311", "low", "'low'"),
    // Wrappers that lack, and keys a level too high
    Mistake("01-smallest", "[{ \"to\": \"&target\" }]", "{ \"to\": \"&target\" }", "UG0105", "{ \"to\": \"&target\" }", "write […]"),
    Mistake("01-smallest", "[{ \"to\": \"&target\" }]", "[\"&target\"]", "UG0105", "&target", "write { \\\"to\\\": \\\"&target\\\" }"),
    Mistake("01-smallest", "\"target\": { \"texture\": { \"format\": \"rgba8unorm\", \"size\": \"=viewport\", \"lifetime\": \"imported\" } }", "\"target\": { \"format\": \"rgba8unorm\", \"size\": \"=viewport\", \"lifetime\": \"imported\" }", "UG0102", "format", "within \\\"texture\\\""),
    Mistake("01-smallest", "\"size\": \"=viewport\", \"lifetime\": \"imported\" }", "\"lifetime\": \"imported\" }, \"size\": \"=viewport\"", "UG0102", "size", "within \\\"texture\\\""),
    Mistake("02-resources", "\"clear\": [0, 0, 0, 1]", "\"clear\": \"#000000\"", "UG0310", "#000000", "[0, 0, 0, 1]"),
    Mistake("03-versions", "\"blend\": \"add\"", "\"blend\": \"additive\"", "UG0107", "additive", "is \\\"add\\\" meant?"),
    // What follows from an error is not told
    Mistake("02-resources", "\"keep\": {", "\"keep\": { \"after\": [\"show\"],", "UG0403", "keep", "after"),
    Mistake("09-loops-and-mips", "\"mip\": \"=level\" }", "\"mip\": \"=level + 1\" }", "UG0404", "chain", "mip"),
    Mistake("09-loops-and-mips", "{ \"texture\": { \"name\": \"&chain\", \"mip\": \"=level\" } }", "\"&chain\"", "UG0404", "chain", "mip"),
    Mistake("16-buffers", "\"samples\": 4", "\"samples\": 8", "UG0321", "8", "1 and 4"),
    Mistake("16-buffers", "\"samples\": { \"texture\": { \"format\": \"rgba8unorm\"", "\"samples\": { \"texture\": { \"format\": \"rgba16float\"", "UG0409", "", "rgba8unorm"),
    // Keys and names of other engines
    Mistake("02-resources", "\"clear\": [0, 0, 0, 1]", "\"loadOp\": \"clear\", \"clearValue\": [0, 0, 0, 1]", "UG0102", "loadOp", "\\\"clear\\\" stands for \\\"loadOp\\\", \\\"clearValue\\\""),
    Mistake("01-smallest", "\"lifetime\": \"imported\"", "\"usage\": [\"storage\"], \"lifetime\": \"imported\"", "UG0102", "usage", "usages follow from the passes"),
    Mistake("26-depth-prepass", "\"compare\": \"equal\"", "\"depthCompare\": \"equal\"", "UG0102", "depthCompare", "compare"),
    Mistake("31-constraints", "\"holds\": \"=high", "\"when\": \"=high", "UG0102", "when", "holds"),
    Mistake("16-buffers", "\"size\": \"=2 * 1024\"", "\"count\": 512, \"stride\": 4", "UG0102", "count", "\\\"size\\\": 2048"),
    Mistake("03-versions", "\"blend\": \"add\"", "\"blend\": { \"src_factor\": \"one\", \"dst_factor\": \"one\" }", "UG0102", "src_factor", "within \\\"color\\\""),
    Mistake("01-smallest", "\"format\": \"rgba8unorm\"", "\"format\": \"rgb8unorm\"", "UG0322", "rgb8unorm", "rgba8unorm"),
    Mistake("01-smallest", "\"size\": \"=viewport\"", "\"size\": [8, 8, 8]", "UG0321", "[8, 8, 8]", "view_dimension"),
    Mistake("18-mesh", "\"format\": \"float32x2\" }, {", "\"format\": \"vec2<f32>\" }, {", "UG0607", "vec2<f32>", "write \\\"float32x2\\\""),
    // One cause, one diagnostic
    Mistake("14-history", "\"lifetime\": \"history\", ", "", "UG0431", "[0, 0, 0, 1]", "history"),
    Mistake("08-subgraph", "\"brighter\": { \"use\"", "\"brighter\": { \"fullscreen\": {}, \"use\"", "UG0102", "use", "make it two"),
];

fn check(mistake: &Mistake) -> Outcome {
    let Mistake(lesson, from, to, ..) = mistake;
    let path = format!("pipelines/learn/{lesson}.json");
    let text = read(&path);
    assert!(text.contains(from), "{lesson} does not contain {from}");
    check_with(&path, &text.replacen(from, to, 1), &With::default())
}

/// The points of what is said, from 0 to 3, with what is missing.
fn points(mistake: &Mistake, outcome: &Outcome) -> (u32, &'static str) {
    let Mistake(_, _, _, code, marked, way) = mistake;
    let errors = outcome.diagnostics.iter().filter(|one| one.severity == Severity::Error);
    let Some(found) = errors.clone().find(|one| one.code.id == *code) else {
        return if errors.count() == 0 { (0, "nothing") } else { (1, "another code") };
    };
    let place = match &found.place {
        Place::Span(span) => outcome.sources.text(*span),
        _ => "",
    };
    let is_there =
        place.trim_matches(['"', '&', '=']) == marked.trim_matches(['"', '&', '=']) || marked.is_empty();
    let said = format!("{} {:?} {:?}", found.message, found.help, found.fix);
    match (is_there, said.contains(way)) {
        (true, true) => (3, ""),
        (false, true) => (2, "another place"),
        (true, false) => (2, "another way out"),
        (false, false) => (1, "place and way out"),
    }
}

#[test]
fn what_authors_get_wrong_is_named_where_it_is_with_a_way_out() {
    let (mut total, mut short) = (0, Vec::new());
    for mistake in MISTAKES {
        let outcome = check(mistake);
        let (points, missing) = points(mistake, &outcome);
        total += points;
        if points < 3 {
            let Mistake(lesson, from, to, code, marked, way) = mistake;
            short.push(format!(
                "{lesson}: {from} -> {to}: {missing} ({code}, {marked}, {way})\n{}",
                outcome.text()
            ));
        }
    }
    println!("{total} of {} points for {} mistakes", 3 * MISTAKES.len(), MISTAKES.len());
    assert!(MISTAKES.len() >= 60);
    assert!(short.is_empty(), "{} fall short:\n{}", short.len(), short.join("\n"));
}

/// Consequences of a mistake are not told: each of these has one diagnostic.
#[test]
fn a_mistake_is_told_once_and_without_consequences() {
    for mistake in MISTAKES.iter().skip_while(|one| one.4 != "usage") {
        let outcome = check(mistake);
        assert_eq!(outcome.diagnostics.error_count(), 1, "{}: {}\n{}", mistake.0, mistake.2, outcome.text());
    }
    let once = ["04-expressions", "09-loops-and-mips", "10-features", "17-toggles", "02-resources"];
    let codes = ["UG0107", "UG0204", "UG0404", "UG0403", "UG0106", "UG0214", "UG0311"];
    for mistake in MISTAKES.iter().skip_while(|one| one.4 != "jiter") {
        let Mistake(lesson, _, to, code, ..) = mistake;
        if once.contains(lesson) && codes.contains(code) {
            let outcome = check(mistake);
            assert_eq!(outcome.diagnostics.len(), 1, "{lesson}: {to}\n{}", outcome.text());
        }
    }
}

/// The words of a feature's enumeration, on the command line: the one that was meant, or all of them.
#[test]
fn a_word_that_a_feature_does_not_have_leads_to_those_it_has() {
    for (value, way_out) in [
        ("\"ray\"", "did you mean \"rays\"?"),
        (
            "\"nothing\"",
            "known are hard, grid_pcf, poisson9, poisson16, poisson64, vogel, pcss, hybrid, rays",
        ),
        ("3", "its words are hard, grid_pcf, poisson9"),
    ] {
        let features = &[("light_filter", value)];
        let path = "pipelines/awsm.json";
        let outcome = check_with(path, &read(path), &With { features, ..With::default() });
        assert!(outcome.text().contains(way_out), "{value}: {}", outcome.text());
    }
}
