//! The page of a graph, opened in a browser: it is clicked, says what it should, and a picture is taken.
//!
//! Needs Chromium from the distribution's packages; without one the test is skipped and says so, and with
//! `UMBRAGRAPH_REQUIRE_BROWSER=1` that is a failure.

use std::path::PathBuf;
use std::process::Command;

use crate::common::{With, check_file};
use umbragraph::low_level::report::{GraphFormat, Report, diff, draw};

fn browser() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders)
        .flat_map(|folder| names.map(|name| folder.join(name)))
        .find(|path| path.is_file())
}

/// Clicks through the page and leaves in the title what it saw.
const CLICKS: &str = r##"<script>{
const seen = [];
const text = () => document.getElementById("details").textContent;
const click = (selector) => document.querySelector(selector).dispatchEvent(new MouseEvent("click", { bubbles: true }));
seen.push(text().includes("Overview") ? "overview" : "no overview");
click('[data-pass="shade"]');
seen.push(text().includes("Why it is kept") && text().includes("present reads color") ? "reason" : "no reason");
seen.push(document.querySelectorAll("svg .on").length > 3 && document.querySelectorAll("svg .picked").length === 1 ? "highlight" : "no highlight");
click('[data-resource="maps"]');
seen.push(text().includes("depth32float 2048×2048") && text().includes("Written by") ? "resource" : "no resource");
const search = document.getElementById("search");
search.value = "eye"; search.dispatchEvent(new Event("input"));
seen.push(document.querySelectorAll("svg .on").length === 2 ? "search" : "no search");
for (const button of document.querySelectorAll("#tabs button")) button.click();
seen.push(document.getElementById("table").textContent.includes("the plans are the same") ? "comparison" : "no comparison");
document.querySelectorAll("#tabs button")[0].click();
click('[data-pass="shade"]');
document.title = seen.join(" ");
}</script></body>"##;

#[test]
fn the_page_opens_without_a_network_and_answers_clicks() {
    let outcome = check_file("pipelines/nebula.json", &With::default());
    let graph = outcome.checked.graph.as_ref().expect("a graph");
    let report = Report::new(outcome.plan(), graph, &outcome.sources);
    let page = draw(&report, GraphFormat::Html, Some(&diff(&report, &report)));
    for outside in ["src=", "href=", "@import", "url(http"] {
        assert!(!page.contains(outside), "the page fetches something: {outside}");
    }
    let Some(browser) = browser() else {
        assert!(std::env::var_os("UMBRAGRAPH_REQUIRE_BROWSER").is_none(), "there is no browser");
        eprintln!("skipped: there is no Chromium in the PATH");
        return;
    };
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("graph_page");
    std::fs::create_dir_all(&folder).expect("a folder");
    let (path, picture) = (folder.join("page.html"), folder.join("page.png"));
    std::fs::write(&path, page.replace("</body>", CLICKS)).expect("the page");
    let _ = std::fs::remove_file(&picture);
    let run = |last: &[&str]| {
        let profile = format!("--user-data-dir={}", folder.join("profile").display());
        let mut command = Command::new(&browser);
        command.args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            "--window-size=1500,900",
            &profile,
        ]);
        command.args(last).arg(format!("file://{}", path.display())).output().expect("the browser runs")
    };
    let shown = run(&["--dump-dom"]);
    let shown = String::from_utf8_lossy(&shown.stdout).into_owned();
    let title =
        shown.split("<title>").nth(1).and_then(|rest| rest.split("</title>").next()).unwrap_or("no title");
    assert_eq!(title, "overview reason highlight resource search comparison");
    run(&[&format!("--screenshot={}", picture.display())]);
    let bytes = std::fs::read(&picture).expect("a picture");
    assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 20_000, "{} bytes", bytes.len());
}

#[test]
fn loops_of_many_rounds_are_no_hairball() {
    let pass = |name: &str, more: &str| {
        format!(
            r#""{name}": {{ "for_each": {{ "i": 25 }}, {more} "fullscreen": {{ "shader": "gradient.wgsl.jinja",
            "color": [{{ "to": "&{name}", "layer": "=i" }}] }}, "side_effect": true }}"#
        )
    };
    let texture = |name: &str| {
        format!(r#""{name}": {{ "texture": {{ "format": "rgba8unorm", "size": [8, 8], "layers": 25 }} }}"#)
    };
    let text = format!(
        r#"{{ "format": 1, "name": "rounds", "resources": {{ {}, {} }}, "passes": {{ {}, {} }} }}"#,
        texture("first"),
        texture("second"),
        pass("first", ""),
        pass("second", r#""after": ["first"],"#)
    );
    let outcome = crate::common::check(&text);
    let graph = outcome.checked.graph.as_ref().expect("a graph");
    let report = Report::new(outcome.plan(), graph, &outcome.sources);
    assert!(report.edges.len() >= 625, "{}", report.edges.len());
    let picture = draw(&report, GraphFormat::Svg, None);
    assert_eq!(picture.matches("data-from=").count(), 1);
}

#[test]
fn cpu_passes_have_a_colour_and_their_data_a_lane() {
    let outcome = check_file("pipelines/nebula.json", &With::default());
    let graph = outcome.checked.graph.as_ref().expect("a graph");
    let picture = draw(&Report::new(outcome.plan(), graph, &outcome.sources), GraphFormat::Svg, None);
    assert!(picture.contains(">BLACKBOARD DATA<"));
    for work in ["cpu", "draw"] {
        assert!(picture.contains(&format!("class=\"pass {work}\"")), "no pass of {work}");
        assert!(picture.contains(&format!(".{work} .strip {{ fill:")), "no colour of {work}");
    }
}
