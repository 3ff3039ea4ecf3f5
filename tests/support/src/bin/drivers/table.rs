//! The table of what drivers draw, and what is wrong with it.

use std::fmt::Write as _;

use crate::case::LESSONS;
use crate::{MAX_SCORE_CHANGE, MAX_UNEXPLAINED, NotDrawn, Row, Section, is_whole};

const HEAD: &str = "| | drawn | >2 | >8 | edge | filtering | placement | rest | worst | IoU | change |\n|---|---|---|---|---|---|---|---|---|---|---|\n";

/// Remarks below the sections of some drivers: known defects of the driver, and the origin of pictures.
const NOTES: [(&str, &str); 2] = [
    (
        "SwiftShader",
        "SwiftShader draws a triangle too small where the near plane of a cube map's face clips it: the rods of the floor lamp of \
         `interior` are up to nine texels too narrow, where lavapipe's edges are those of rays. Shadows of that lamp differ on \
         the floor below it.",
    ),
    (
        "NVIDIA H200 (vulkan)",
        "Another machine drew these pictures, at the same commit; they were put into `target/drivers/pictures` of this one. \
         It drew none with the nearest texel. 92 scores of software drivers that both machines computed are equal.",
    ),
];

/// Returns the Markdown page with the tables of all drivers.
pub(crate) fn markdown(sections: &[Section], is_quick: bool, commit: &str) -> String {
    let mut text = String::from("# Drivers\n\n");
    let (command, what) = match is_quick {
        true => ("cargo xtask drivers --quick", "the six systems with their defaults on the courtyard"),
        false => (
            "cargo xtask drivers",
            "the six systems with every preset and debug view on the four scenes of `examples/scenes`, and the lessons of \
             `pipelines/learn`",
        ),
    };
    let of = if commit.is_empty() { String::new() } else { format!(" Its pictures are of commit {commit}.") };
    let _ = write!(
        text,
        "`{command}` writes this page. It draws {what}, 320 × 180, on every driver of the machine.{of}\n\n\
         Pixels are compared with those of lavapipe. Lower is better; all are percentages of the pixels of all pictures of a \
         row.\n\n\
         * **drawn**: pictures that are drawn, of those that there are. A run that was ended early has fewer: of each scene the \
         picture and the shadow term with the defaults, then those of presets, then other debug views. The next run goes \
         on.\n\
         * **>2**, **>8**: pixels that differ by more than 2 or 8 levels of 255. Those beyond 8 have a cause:\n\
         \x20 * **edge**: within a pixel of a discontinuity of lavapipe's depth, normal or shadow term, or of what a debug view or \
         lesson shows;\n\
         \x20 * **filtering**: equal within 8 levels once textures are sampled at the nearest texel of the largest level;\n\
         \x20 * **placement**: within 8 levels of what lavapipe draws there once its camera is turned by a sixteenth of a pixel up, \
         down, left and right. So far apart are the places that a vertex can have with 4 bits for parts of a pixel, the fewest \
         that Vulkan allows: SwiftShader has 4, Mesa 8. A cell of noise or a texel of a shadow map then begins elsewhere;\n\
         \x20 * **rest**: nothing of this, at most {MAX_UNEXPLAINED} %. **worst**: the largest rest of one picture.\n\
         * **IoU**: shadows of the sun on the courtyard against rays (`umbragraph score`, texels beyond two pixels from an edge; \
         higher is better). **change**: the largest difference of such a score from lavapipe's, over all lights of all \
         scenes, at most {MAX_SCORE_CHANGE}.\n\n\
         A picture that lacks a feature is drawn, and not compared unless the feature (`storage_descriptors`) leaves no trace in it. \
         One that needs what a driver lacks is not drawn, for which there is a diagnostic.\n\n"
    );
    text.push_str("| driver | adapter | version | lacks of WebGPU's core mode |\n|---|---|---|---|\n");
    for Section { name, adapter, .. } in sections {
        let lacking =
            if adapter.lacking.is_empty() { "nothing".to_owned() } else { adapter.lacking.join(", ") };
        let _ = writeln!(text, "| {name} | {} | {} | {lacking} |", adapter.name, adapter.driver);
    }
    for section in sections {
        let _ = write!(text, "\n## {}\n\n{HEAD}", section.name);
        for row in &section.rows {
            let _ = writeln!(text, "| {} | {} |", row.name, cells(row).join(" | "));
        }
        let known = NOTES.iter().filter(|(driver, _)| *driver == section.name);
        let known = known.map(|(_, note)| format!("* {note}"));
        let notes: Vec<String> = section.rows.iter().flat_map(notes).chain(known).collect();
        if !notes.is_empty() {
            let _ = writeln!(text, "\n{}", notes.join("\n"));
        }
    }
    text
}

/// Returns the remarks on a row: disabled features, missing pictures and changed scores.
fn notes(row: &Row) -> impl Iterator<Item = String> {
    let off = row
        .off
        .iter()
        .map(|(feature, count)| format!("* {}: `{feature}` is off in {}.", row.name, pictures(*count)));
    let not_drawn = by_reason(row.rejected.iter().chain(&row.failures))
        .into_iter()
        .map(|(pictures, reason)| format!("* not drawn: {}: {reason}", several(row.name, &pictures)));
    let change = row.change.iter().filter(|(_, change)| change.abs() > MAX_SCORE_CHANGE);
    let change = change
        .map(|(of, change)| format!("* {}: shadows of {of} score {change:+.4} beside lavapipe's.", row.name));
    let nearest = (row.without_nearest > 0).then(|| {
        let (name, count) = (row.name, row.without_nearest);
        format!(
            "* {name}: filtering counts as rest in {}: with the nearest texel there is none.",
            pictures(count)
        )
    });
    off.chain(not_drawn).chain(nearest).chain(change)
}

fn pictures(count: usize) -> String {
    format!("{count} {}", if count == 1 { "picture" } else { "pictures" })
}

/// Groups missing pictures by the reason, in the order of first occurrence.
fn by_reason<'a>(failures: impl IntoIterator<Item = &'a NotDrawn>) -> Vec<(Vec<&'a str>, &'a str)> {
    let mut all: Vec<(Vec<&str>, &str)> = Vec::new();
    for NotDrawn { picture, reason } in failures {
        match all.iter_mut().find(|(_, other)| other == reason) {
            Some((pictures, _)) => pictures.push(picture),
            None => all.push((vec![picture], reason)),
        }
    }
    all
}

/// Returns the names of up to three pictures, or else the number of pictures.
fn several(row: &str, pictures: &[&str]) -> String {
    match pictures {
        [_, _, _, _, ..] => format!("{} pictures of {row}", pictures.len()),
        few => few.join(", "),
    }
}

fn cells(row: &Row) -> Vec<String> {
    let found = &row.difference;
    let beyond_8 = found.edge + found.filtering + found.placement + found.unexplained;
    let counts = [found.beyond_2, beyond_8, found.edge, found.filtering, found.placement, found.unexplained];
    let percent = counts.into_iter().map(|count| format!("{:.3}", found.percent(count)));
    let none = || "–".to_owned();
    let worst = row.worst.as_ref().map_or_else(none, |(name, percent)| format!("{percent:.3} ({name})"));
    let score = row.score.map_or_else(none, |score| format!("{score:.4}"));
    let change = row.change.as_ref().map_or_else(none, |(_, change)| format!("{change:+.4}"));
    let drawn = format!("{} of {}", row.drawn, row.pictures);
    std::iter::once(drawn).chain(percent).chain([worst, score, change]).collect()
}

/// Returns descriptions of failures, unexplained differences and changed scores.
pub(crate) fn complaints(sections: &[Section]) -> Vec<String> {
    let mut complaints = Vec::new();
    for section in sections {
        for row in &section.rows {
            let what = format!("{} on {}", row.name, section.name);
            let failures = by_reason(&row.failures).into_iter();
            complaints.extend(
                failures
                    .map(|(pictures, reason)| format!("{what}: {}: {reason}", several(row.name, &pictures))),
            );
            let unexplained = row.difference.percent(row.difference.unexplained);
            if unexplained > MAX_UNEXPLAINED {
                let worst = row.worst.as_ref().map(|(name, _)| name.as_str()).unwrap_or_default();
                complaints.push(format!(
                    "{what}: {unexplained:.3} % of the pixels are unexplained, most in {worst}"
                ));
            }
            // A system without a feature has other shadows.
            if let Some((of, change)) = &row.change
                && change.abs() > MAX_SCORE_CHANGE
                && is_whole(row.off.keys())
            {
                complaints.push(format!("{what}: shadows of {of} score {change:+.4} beside lavapipe's"));
            }
            // Of a row that is not finished the score may be still to come.
            let is_finished = row.drawn > 0 && row.drawn + row.rejected.len() == row.pictures;
            if row.name != LESSONS && is_finished && row.score.is_none() {
                complaints.push(format!("{what}: there is no score"));
            }
        }
    }
    complaints
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_one_reason_are_one_line() {
        let failed =
            |picture: &str, reason: &str| NotDrawn { picture: picture.to_owned(), reason: reason.to_owned() };
        let failures = vec![failed("a", "x"), failed("b", "y"), failed("c", "x")];
        let mut row = Row { name: "mantis", failures, ..Row::default() };
        let lines = |row: &Row| notes(row).collect::<Vec<_>>();
        assert_eq!(lines(&row), ["* not drawn: a, c: x", "* not drawn: b: y"]);
        row.failures = ["a", "b", "c", "d"].map(|picture| failed(picture, "x")).into();
        assert_eq!(lines(&row), ["* not drawn: 4 pictures of mantis: x"]);
    }
}
