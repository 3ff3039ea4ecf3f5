//! The pictures of a whole run: every pipeline with every preset, debug view and scene, and the lessons.
//!
//! Presets and debug views are asked of the command, which lists them where it is given one that does not exist. The
//! most telling pictures come first, so that a run that is interrupted has them: the defaults, then the presets, then
//! the debug views, then presets and views together.

use std::path::Path;
use std::process::Command;

/// The names of the bundled pipelines to render.
pub(crate) const PIPELINES: [&str; 6] = ["mantis", "nebula", "caracal", "lore", "awsm", "umbra"];
/// The table row for the lesson pipelines.
pub(crate) const LESSONS: &str = "lessons";
/// The names of the scenes to render, without extension.
pub(crate) const SCENES: [&str; 4] = ["courtyard", "figure", "foliage", "interior"];

/// The value of the parameter `debug_view` that shows the shadow term.
pub(crate) const SHADOW_TERM: &str = "shadow_term";

/// A picture to render with each driver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Case {
    /// The row of the table: a pipeline's name, or [`LESSONS`].
    pub(crate) row: &'static str,
    /// The path of the pipeline's file below `pipelines/`, without its extension.
    pub(crate) pipeline: String,
    pub(crate) preset: Option<String>,
    /// The debug view; `None` for the normal picture.
    pub(crate) view: Option<String>,
    pub(crate) scene: &'static str,
}

impl Case {
    /// Returns the picture's name in the table, which is also the basis of its file name.
    pub(crate) fn name(&self) -> String {
        let words = [self.preset.as_deref(), self.view.as_deref(), Some(self.scene)];
        std::iter::once(self.pipeline.as_str())
            .chain(words.into_iter().flatten())
            .collect::<Vec<_>>()
            .join(" ")
    }

    /// Returns the same case with the debug view for the shadow term; `None` for lessons.
    pub(crate) fn shadow_term(&self) -> Option<Self> {
        let view = Some(SHADOW_TERM.to_owned());
        (self.row != LESSONS).then(|| Self { view, ..self.clone() })
    }

    /// Returns the arguments of `umbragraph render` for this case.
    pub(crate) fn arguments(&self) -> Vec<String> {
        let mut arguments = vec![format!("pipelines/{}.json", self.pipeline)];
        arguments.extend(self.preset.iter().flat_map(|preset| ["--preset".to_owned(), preset.clone()]));
        arguments
            .extend(self.view.iter().flat_map(|view| ["--set".to_owned(), format!("debug_view={view}")]));
        arguments
    }

    /// Returns `true` for the picture with default settings and for its shadow term.
    pub(crate) fn is_default(&self) -> bool {
        self.turn() == 0
    }

    /// Returns the priority of rendering: the lowest number first.
    fn turn(&self) -> u8 {
        let is_plain = self.view.as_deref().is_none_or(|view| view == SHADOW_TERM);
        match (self.preset.is_none(), is_plain) {
            (true, true) => 0,
            (false, true) => 1,
            (true, false) => 2,
            (false, false) => 3,
        }
    }
}

/// Returns all cases of a run: of one pipeline if `only` names it. A quick run has only the default settings on the
/// courtyard scene.
pub(crate) fn all(program: &Path, only: Option<&str>, is_quick: bool) -> Vec<Case> {
    let is_wanted = |row: &str| only.is_none_or(|only| only == row);
    let mut cases = Vec::new();
    for row in PIPELINES.into_iter().filter(|row| is_wanted(row)) {
        let presets = if is_quick { Vec::new() } else { known(program, row, &["--preset", "?"]) };
        let presets: Vec<Option<String>> =
            std::iter::once(None).chain(presets.into_iter().map(Some)).collect();
        let views = if is_quick {
            vec![SHADOW_TERM.to_owned()]
        } else {
            known(program, row, &["--set", "debug_view=?"])
        };
        let views = views.into_iter().filter(|view| view != "off").map(Some);
        let views: Vec<Option<String>> = std::iter::once(None).chain(views).collect();
        for scene in if is_quick { &SCENES[..1] } else { &SCENES[..] } {
            for preset in &presets {
                let case = |view: &Option<String>| {
                    let (preset, view) = (preset.clone(), view.clone());
                    Case { row, pipeline: row.to_owned(), preset, view, scene }
                };
                cases.extend(views.iter().map(case));
            }
        }
    }
    if is_wanted(LESSONS) && !is_quick {
        cases.extend(lessons());
    }
    cases.sort_by_key(Case::turn);
    cases
}

fn lessons() -> Vec<Case> {
    let entries = std::fs::read_dir("pipelines/learn").into_iter().flatten().flatten();
    let names =
        entries.filter_map(|entry| entry.file_name().to_str()?.strip_suffix(".json").map(str::to_owned));
    let mut names: Vec<String> = names.collect();
    names.sort();
    let case = |name| Case {
        row: LESSONS,
        pipeline: format!("learn/{name}"),
        preset: None,
        view: None,
        scene: SCENES[0],
    };
    names.into_iter().map(case).collect()
}

/// Returns the valid names that the command lists in its error about an unknown one.
fn known(program: &Path, pipeline: &str, unknown: &[&str]) -> Vec<String> {
    let mut command = Command::new(program);
    command.args(["plan", &format!("pipelines/{pipeline}.json")]).args(unknown);
    let Ok(output) = command.output() else { return Vec::new() };
    listed(&String::from_utf8_lossy(&output.stderr))
}

/// Parses the names after `help: the presets are` or `help: known are`.
fn listed(said: &str) -> Vec<String> {
    let list = said.lines().find_map(|line| {
        let help = line.split_once("help: ")?.1;
        help.strip_prefix("the presets are ").or_else(|| help.strip_prefix("known are "))
    });
    list.into_iter().flat_map(|list| list.split(", ")).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_words_are_read_from_the_help() {
        let said = "error[UG0213]: there is no preset \"?\"\n  = help: the presets are low, high\n";
        assert_eq!(listed(said), ["low", "high"]);
        assert_eq!(listed("  = help: known are off, shadow_term\n"), ["off", "shadow_term"]);
        assert_eq!(listed("  = help: this pipeline has no presets\n"), Vec::<String>::new());
    }

    #[test]
    fn defaults_are_drawn_before_presets_and_views() {
        let case = |preset: Option<&str>, view: Option<&str>| Case {
            row: "lore",
            pipeline: "lore".to_owned(),
            preset: preset.map(str::to_owned),
            view: view.map(str::to_owned),
            scene: "courtyard",
        };
        let turns =
            [(None, None), (Some("low"), None), (None, Some("cascades")), (Some("low"), Some("cascades"))];
        assert_eq!(turns.map(|(preset, view)| case(preset, view).turn()), [0, 1, 2, 3]);
        assert_eq!(case(Some("low"), Some("cascades")).name(), "lore low cascades courtyard");
    }
}
