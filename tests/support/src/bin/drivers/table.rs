//! The table of what drivers draw, and what is wrong with it.

use std::fmt::Write as _;

use crate::{Column, Drawn, MAX_SCORE_CHANGE, MAX_UNEXPLAINED, PIPELINES};

/// The page.
pub(crate) fn markdown(columns: &[Column], is_quick: bool) -> String {
    let mut text = String::from("# Drivers\n\n");
    let command = if is_quick { "cargo xtask drivers --quick" } else { "cargo xtask drivers" };
    let scenes = if is_quick { "the courtyard" } else { "the four scenes of `examples/scenes`" };
    let _ = write!(
        text,
        "Written by `{command}`: the six systems with their defaults on {scenes}, 320 × 180, on every driver of the \
         machine.\n\n\
         Pixels are compared with those of lavapipe. Lower is better. **>2**, **>8**: percent of pixels that differ by more \
         than 2 or 8 levels of 255. Those beyond 8 by cause: **edge**, within a pixel of a jump of depth or shadow term; \
         **filtering**, the shadow terms agree, or the value lies between those of neighbouring pixels; **rest**, neither, at \
         most {MAX_UNEXPLAINED} %. **IoU**: shadows of the sun on the courtyard against rays (`umbragraph score`, texels \
         beyond two pixels from an edge; higher is better), within {MAX_SCORE_CHANGE} of lavapipe's.\n\n"
    );
    text.push_str("| driver | adapter | version |\n|---|---|---|\n");
    for Column { name, adapter, driver, .. } in columns {
        let _ = writeln!(text, "| {name} | {adapter} | {driver} |");
    }
    for column in columns {
        let _ = write!(
            text,
            "\n## {}\n\n| system | drawn | >2 | >8 | edge | filtering | rest | IoU |\n|---|---|---|---|---|---|---|---|\n",
            column.name
        );
        for (pipeline, drawn) in PIPELINES.iter().zip(&column.drawn) {
            let _ = writeln!(text, "| {pipeline} | {} |", cells(drawn).join(" | "));
        }
    }
    text
}

fn cells(drawn: &Drawn) -> Vec<String> {
    let state = match (drawn.failures.first(), drawn.off.is_empty()) {
        (Some(reason), _) => format!("no: {reason}"),
        (None, true) => "whole".to_owned(),
        (None, false) => format!("without {}", drawn.off.join(", ")),
    };
    let found = &drawn.difference;
    let beyond_8 = found.edge + found.filtering + found.unexplained;
    let counts = [found.beyond_2, beyond_8, found.edge, found.filtering, found.unexplained];
    let percent = counts.into_iter().map(|count| format!("{:.2}", found.percent(count)));
    let score = drawn.score.map_or_else(|| "–".to_owned(), |score| format!("{score:.4}"));
    std::iter::once(state).chain(percent).chain([score]).collect()
}

/// Complaints about a table. A pipeline without one of its features may differ, and its shadows too.
pub(crate) fn complaints(columns: &[Column]) -> Vec<String> {
    let mut complaints = Vec::new();
    let Some(first) = columns.first() else { return complaints };
    for column in columns {
        for ((pipeline, drawn), reference) in PIPELINES.iter().zip(&column.drawn).zip(&first.drawn) {
            let what = format!("{pipeline} on {}", column.name);
            complaints.extend(drawn.failures.iter().map(|reason| format!("{what}: {reason}")));
            if !drawn.off.is_empty() {
                continue;
            }
            let unexplained = drawn.difference.percent(drawn.difference.unexplained);
            if unexplained > MAX_UNEXPLAINED {
                complaints.push(format!("{what}: {unexplained:.3} % of the pixels are unexplained"));
            }
            if let (Some(own), Some(reference)) = (drawn.score, reference.score)
                && (own - reference).abs() > MAX_SCORE_CHANGE
            {
                complaints.push(format!("{what}: shadows score {own:.4}, those of lavapipe {reference:.4}"));
            }
        }
    }
    complaints
}
