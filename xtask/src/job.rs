//! `cargo xtask integrations ci`: the job that users copy, run as it is written.
//!
//! The command is installed as the job installs it, without a graphics driver. The `run:` lines of the workflow that
//! `umbragraph new` writes, and of the one in the guide, are then run in a clean folder each: on shaders that are fine,
//! a second time with what the first has kept, with a template that is broken, and with an axis that has grown beyond
//! the lock. What a step prints for GitHub is looked at, as is its exit status.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use crate::process;

/// The path of the page with the CI workflow that users copy.
const GUIDE: &str = "docs/guide/6-ci.md";
/// The name of the pipeline that `umbragraph new` creates for the test.
const NAME: &str = "look";

/// The result of a step of a CI job.
struct Step {
    line: String,
    is_fine: bool,
    printed: String,
}

/// The folder of the installed command, and the folder in which jobs run.
struct Job {
    bin: PathBuf,
    folder: PathBuf,
}

/// Tests the CI jobs of the guide and of new pipelines.
///
/// # Errors
/// The first step with an unexpected result.
pub(crate) fn run() -> Result<(), String> {
    let root = process::target_folder().join("integrations/ci");
    let start = Instant::now();
    let mut install = process::program("cargo");
    install.args(["install", "--locked", "--path", "cli", "--no-default-features", "--force", "--root"]);
    process::run(install.arg(&root).args(["--target-dir"]).arg(root.join("build")), "cargo install")?;
    println!("ci: the command is installed after {:.0} s", start.elapsed().as_secs_f64());
    let job = |name: &str| Job { bin: root.join("bin"), folder: root.join(name) };

    let own = job("new");
    own.clean()?;
    let workflow = read(&own.folder.join(".github/workflows/pipelines.yml"))?;
    own.check("the workflow of `umbragraph new`", &lines(&workflow), &format!("{NAME}.json"))?;

    let guide = job("guide");
    guide.clean()?;
    let pipelines = guide.folder.join("pipelines");
    let moved = pipelines.join(format!("{NAME}.json"));
    std::fs::create_dir_all(&pipelines).map_err(|error| error.to_string())?;
    std::fs::rename(guide.folder.join(format!("{NAME}.json")), moved).map_err(|error| error.to_string())?;
    let page = read(&process::workspace_root().join(GUIDE))?;
    let workflow = page.split("```yaml\n").nth(1).and_then(|rest| rest.split("```").next());
    let workflow = workflow.ok_or_else(|| format!("{GUIDE} has no workflow"))?;
    guide.check(&format!("the workflow of {GUIDE}"), &lines(workflow), &format!("pipelines/{NAME}.json"))
}

/// Returns the `run:` lines of a workflow, except those that install the command.
fn lines(workflow: &str) -> Vec<String> {
    let lines = workflow.lines().filter_map(|line| line.trim_start().strip_prefix("- run: "));
    lines.filter(|line| !line.starts_with("cargo install ")).map(str::to_owned).collect()
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

impl Job {
    /// Replaces the folder by a new one that `umbragraph new` creates.
    fn clean(&self) -> Result<(), String> {
        let _ = std::fs::remove_dir_all(&self.folder);
        let parent = self.folder.parent().unwrap_or(&self.folder);
        let made = parent.join(NAME);
        let _ = std::fs::remove_dir_all(&made);
        let mut new = Command::new(self.bin.join("umbragraph"));
        process::run(new.args(["new", NAME]).current_dir(parent), "umbragraph new")?;
        std::fs::rename(&made, &self.folder).map_err(|error| error.to_string())
    }

    /// Runs the lines of a job with valid shaders, with broken ones, and with more shaders than the lock file has.
    fn check(&self, what: &str, lines: &[String], pipeline: &str) -> Result<(), String> {
        if lines.is_empty() {
            return Err(format!("{what} has no line `- run: ...`"));
        }
        let lock = format!("umbragraph permutations {pipeline} --templates shaders --update");
        self.all_fine(what, std::slice::from_ref(&lock))?;
        self.all_fine(what, lines)?;
        let start = Instant::now();
        self.all_fine(what, lines)?;
        let seconds = start.elapsed().as_secs_f64();
        println!("ci: {what}: {} lines are fine, the second time in {seconds:.2} s", lines.len());
        let is_kept = std::fs::read_dir(self.folder.join(".umbragraph")).is_ok_and(|all| all.count() > 0);
        if !is_kept {
            return Err(format!("{what}: nothing is kept in .umbragraph"));
        }

        let template = self.template()?;
        let text = read(&template)?;
        let write = |text: &str| std::fs::write(&template, text).map_err(|error| error.to_string());
        write(&format!("{text}\nfn broken() -> f32 {{ return 1u; }}\n"))?;
        self.fails(what, lines, "::error file=shaders/")?;
        // With a lock that is not asked for nothing differs.
        write(&format!("{text}\nfn unused_so_far() -> f32 {{ return 1.0; }}\n"))?;
        if lines.iter().any(|line| line.contains("--locked")) {
            self.fails(what, lines, "UG0818")?;
        } else {
            self.all_fine(what, lines)?;
        }
        write(&text)?;
        self.all_fine(what, lines)
    }

    /// Returns the path of a template in the folder.
    fn template(&self) -> Result<PathBuf, String> {
        let shaders = self.folder.join("shaders");
        let entries =
            std::fs::read_dir(&shaders).map_err(|error| format!("{}: {error}", shaders.display()))?;
        let mut all: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        all.sort();
        let is_template = |path: &PathBuf| path.to_string_lossy().ends_with(".wgsl.jinja");
        all.into_iter().find(is_template).ok_or_else(|| format!("{} has no template", shaders.display()))
    }

    fn steps(&self, lines: &[String]) -> Result<Vec<Step>, String> {
        lines.iter().map(|line| self.step(line)).collect()
    }

    fn step(&self, line: &str) -> Result<Step, String> {
        let paths = std::env::var_os("PATH").unwrap_or_default();
        let paths = std::iter::once(self.bin.clone()).chain(std::env::split_paths(&paths));
        let path = std::env::join_paths(paths).map_err(|error| error.to_string())?;
        let summary = self.folder.join("summary.md");
        let output = Command::new("sh")
            .args(["-e", "-c", line])
            .current_dir(&self.folder)
            .env("PATH", path)
            .env("GITHUB_STEP_SUMMARY", &summary)
            .output()
            .map_err(|error| format!("sh could not be started: {error}"))?;
        let printed = [&output.stdout[..], &output.stderr[..]].concat();
        let printed = String::from_utf8_lossy(&printed).into_owned();
        Ok(Step { line: line.to_owned(), is_fine: output.status.success(), printed })
    }

    fn all_fine(&self, what: &str, lines: &[String]) -> Result<(), String> {
        match self.steps(lines)?.into_iter().find(|step| !step.is_fine || step.printed.contains("::error")) {
            Some(Step { line, printed, .. }) => Err(format!("{what}: `{line}` fails:\n{printed}")),
            None => Ok(()),
        }
    }

    /// Checks that a step fails with this message, and that the summary contains the message.
    fn fails(&self, what: &str, lines: &[String], says: &str) -> Result<(), String> {
        let _ = std::fs::remove_file(self.folder.join("summary.md"));
        let steps = self.steps(lines)?;
        let printed: String = steps.iter().map(|step| step.printed.as_str()).collect();
        if !steps.iter().any(|step| !step.is_fine && step.printed.contains(says)) {
            return Err(format!("{what}: no step fails with \"{says}\":\n{printed}"));
        }
        let summary = read(&self.folder.join("summary.md")).unwrap_or_default();
        match summary.contains("UG0") {
            true => Ok(()),
            false => Err(format!("{what}: the summary of the job says nothing:\n{summary}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn run_lines_are_taken_from_a_workflow() {
        let workflow =
            "steps:\n  - uses: x\n  - run: cargo install a\n  - run: a b | c\n    - run: d\n  run: |\n";
        assert_eq!(lines(workflow), ["a b | c", "d"]);
    }
}
