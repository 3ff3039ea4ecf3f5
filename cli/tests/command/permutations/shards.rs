//! `--shard` and `--merge`: parts of a run, and their reports as one.

use std::process::Output;

use serde_json::Value;
use umbragraph_test_support::command::{rejected, text};

use super::lock::Project;

const BOTH: [&str; 5] = ["permutations", "small.json", "other.json", "--templates", "."];

impl Project {
    fn shards(&self, of: u32) -> Vec<String> {
        let report = |index| {
            let (shard, name) = (format!("{index}/{of}"), format!("{index}-{of}.json"));
            let output =
                self.run(&[&BOTH[..], &["--no-cache", "--shard", &shard, "--format", "json"]].concat());
            assert_eq!(text(&output.stderr), "");
            self.write(&name, &text(&output.stdout));
            name
        };
        (1..=of).map(report).collect()
    }

    fn merge(&self, reports: &[String], further: &[&str]) -> Output {
        let reports: Vec<&str> = reports.iter().map(String::as_str).collect();
        self.run(&[&["permutations", "--merge"], &reports[..], further].concat())
    }
}

#[test]
fn shards_are_the_whole_however_many() {
    let project = Project::new("shards-whole").with_other();
    assert!(project.run(&[&BOTH[..], &["--update", "--no-cache"]].concat()).status.success());
    let lock = project.read("permutations.lock");
    let parts = |output: Output| -> Value {
        let mut report: Value = serde_json::from_slice(&output.stdout).unwrap();
        // A text that several shards have is proven in each.
        let members = report.as_object_mut().unwrap();
        assert!(members.remove("proven").is_some() && members.remove("declarations").is_some());
        report
    };
    let whole = parts(project.merge(&project.shards(1), &["--format", "json"]));
    assert_eq!(whole["pipelines"].as_array().unwrap().len(), 2);
    let single = project.run(&[&BOTH[..], &["--no-cache", "--format", "json"]].concat());
    let single: Value = serde_json::from_slice(&single.stdout).unwrap();
    assert_eq!((&single["combinations"], &single["texts"]), (&whole["combinations"], &whole["texts"]));
    for of in [2, 3, 8] {
        let reports = project.shards(of);
        assert_eq!(reports, project.shards(of));
        assert_eq!(parts(project.merge(&reports, &["--format", "json"])), whole, "{of} shards");
        let mut backwards = reports.clone();
        backwards.reverse();
        let output = project.merge(&backwards, &["--locked"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let lines = "other.json: 2 passes, 9 texts, for webgpu, webgpu-compat\nsmall.json: 2 passes, 9 texts, for webgpu, \
                     webgpu-compat\n";
        assert_eq!(text(&output.stdout), lines);
        let output = project.merge(&reports, &["--update", "--lock", "merged.lock"]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert_eq!(project.read("merged.lock"), lock);
        std::fs::remove_file(project.folder.join("merged.lock")).unwrap();
    }
    let has_part = |name: &str| {
        let report: Value = serde_json::from_str(&project.read(name)).unwrap();
        !report["templates"].as_array().unwrap().is_empty()
    };
    assert!(has_part("1-2.json") && has_part("2-2.json"), "both have a part");
    project.edit("permutations.lock", "taps = 1, 2", "taps = 1");
    let output = project.merge(&project.shards(3), &["--locked"]);
    rejected(
        &output,
        1,
        &["error[UG0818]", "pass \"fill\" for all profiles: axis taps gained 2", "permutations.lock:"],
    );
}

#[test]
fn shards_that_cannot_be_are_not_understood() {
    let project = Project::new("shards-wrong").with_other();
    for (shard, says) in [
        ("0/0", "there is no shard of 0; the only one of all is 1/1"),
        ("9/8", "there is no shard 9 of 8; the last is 8/8"),
        ("0/3", "shards count from 1: the first is 1/3"),
        ("3", "the third of eight is written 3/8"),
        ("1/99999999", "99999999 shards are too many"),
    ] {
        let output = project.run(&["permutations", "small.json", "--shard", shard]);
        assert_eq!(output.status.code(), Some(2), "{shard}");
        assert!(text(&output.stderr).contains(says), "{}", text(&output.stderr));
    }
    for mode in ["--locked", "--update"] {
        let output = project.run(&["permutations", "small.json", "--shard", "1/2", mode]);
        assert_eq!(output.status.code(), Some(2));
        let says = "a lock has all that is reached: leave out --shard, or join the reports of all shards";
        assert!(text(&output.stderr).contains(says), "{}", text(&output.stderr));
    }
}

#[test]
fn reports_of_other_shards_are_not_joined() {
    let project = Project::new("shards-others").with_other();
    let (two, three) = (project.shards(2), project.shards(3));
    let whole = project.run(&[&BOTH[..], &["--format", "json", "--no-cache"]].concat());
    project.write("whole.json", &text(&whole.stdout));
    let names = |names: &[&str]| -> Vec<String> { names.iter().map(|name| (*name).to_owned()).collect() };
    for (reports, says) in [
        (two[..1].to_vec(), "these shards are missing: 2/2"),
        (names(&["1-2.json", "1-2.json", "2-2.json"]), "shard 1/2 is there twice"),
        ([&two[..], &three[1..]].concat(), "shards of 2 and of 3 do not belong together"),
        (
            names(&["1-2.json", "2-2.json", "whole.json"]),
            "a report of a whole run cannot be joined with reports of shards",
        ),
        (names(&["small.json"]), "is not a report"),
        (names(&["whole.json", "whole.json"]), "a report before \"whole.json\" has its pipelines, too"),
    ] {
        let output = project.merge(&reports, &[]);
        rejected(&output, 1, &["error[UG0822]", says]);
    }
    let output = project.merge(&names(&["none.json"]), &[]);
    rejected(&output, 1, &["error[UG0001]", "the file \"none.json\" cannot be read: it does not exist"]);
    assert_eq!(project.merge(&names(&["whole.json"]), &["--format", "json"]).status.code(), Some(0));
}

#[test]
fn reports_of_different_files_are_not_joined() {
    let project = Project::new("shards-files").with_other();
    let first = project.shards(2);
    let kept = project.read("1-2.json");
    project.edit("fill.wgsl.jinja", "0.0, 1.0);\n}\n@fragment", "0.5, 1.0);\n}\n@fragment");
    assert_eq!(project.shards(2), first);
    project.write("1-2.json", &kept);
    let says = "\"2-2.json\" is of other files, options or another version than \"1-2.json\"";
    rejected(&project.merge(&first, &["--update"]), 1, &["error[UG0822]", says]);
}

#[test]
fn a_report_of_a_part_is_put_into_no_lock() {
    let project = Project::new("shards-part").with_other();
    for option in [&["--config"][..], &["--all"], &["--profile", "webgpu"]] {
        let output = project.run(&[&BOTH[..], &["--no-cache", "--format", "json"], option].concat());
        project.write("part.json", &text(&output.stdout));
        let reports = ["part.json".to_owned()];
        let output = project.merge(&reports, &["--update"]);
        rejected(&output, 1, &["error[UG0822]", "\"part.json\" is of a part of what is reached"]);
        assert!(!project.folder.join("permutations.lock").exists());
    }
}

#[test]
fn an_error_of_several_shards_is_said_once_at_its_place() {
    let project = Project::new("shards-error").with_other();
    project.edit("veil.wgsl.jinja", "0.0, 0.0, 0.0, 1.0", "oops, 0.0, 0.0, 1.0");
    let reports = project.shards(3);
    let output = project.merge(&reports, &[]);
    let said = rejected(&output, 1, &["veil.wgsl.jinja:5:20", "`oops`", "1 error"]);
    let whole = project.run(&[&BOTH[..], &["--no-cache"]].concat());
    assert_eq!(said.lines().next(), text(&whole.stderr).lines().next());
    let output = project.merge(&reports, &["--update"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(!project.folder.join("permutations.lock").exists());
    assert!(text(&project.merge(&reports, &["--format", "github"]).stdout).contains("line=5"));
    let output = project.merge(&reports, &["--update"]);
    rejected(&output, 1, &["permutations.lock is left as it is, because of errors"]);
}
