//! `umbragraph show`: lists the files that come with the command, or prints one.
//!
//! Pipelines have names that begin with `umbragraph:`, templates are named as documents name them. The text is printed
//! as it is bundled, so that `umbragraph show NAME > FILE` makes a file of it.

use std::fmt::Write as _;

use umbragraph::PIPELINES;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, codes, list_of, render, suggested_name};
use umbragraph::low_level::session::TemplateText;
use umbragraph::low_level::source::Sources;

use crate::arguments::ShowArguments;
use crate::streams::{complain, print, print_contents};

/// The beginning of the names of bundled pipelines.
pub(crate) const SCHEME: &str = "umbragraph:";

/// Prints one bundled file, or the list of all. Returns `false` if there is no file of the name.
pub(crate) fn run(arguments: &ShowArguments) -> bool {
    let files = files();
    let Some(wanted) = &arguments.name else {
        print(&list(&files));
        return true;
    };
    let bare = wanted.strip_prefix("shaders-templates/").unwrap_or(wanted);
    let is_meant = |name: &str| name == bare || name.strip_prefix(SCHEME) == Some(bare);
    match files.iter().find(|(name, _)| is_meant(name)) {
        Some((_, text)) => {
            print_contents(text.as_bytes());
            true
        }
        None => {
            let diagnostics = Diagnostics::from(unknown(wanted, bare, &files));
            complain(&render::human_all(&diagnostics, &Sources::new()));
            false
        }
    }
}

/// Returns the names and texts of all bundled files: pipelines, then templates with their axes.
fn files() -> Vec<(String, &'static str)> {
    let pipelines = PIPELINES.iter().map(|(name, text)| (format!("{SCHEME}{name}"), *text));
    let templates = umbragraph::with_templates([]).into_iter().filter_map(|template| match template.text {
        TemplateText::Library { text, .. } => Some((template.name, text)),
        _ => None,
    });
    pipelines.chain(templates).collect()
}

/// Lists the names, each with the beginning of its first comment.
fn list(files: &[(String, &str)]) -> String {
    let is_pipeline = |name: &str| name.starts_with(SCHEME);
    let width = files.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for (title, pipelines) in [("Pipelines and their parts", true), ("Templates", false)] {
        let _ = writeln!(text, "{title}");
        for (name, contents) in files.iter().filter(|(name, _)| is_pipeline(name) == pipelines) {
            let line = format!("  {name:width$}  {}", summary(contents));
            let _ = writeln!(text, "{}", line.trim_end());
        }
        text.push('\n');
    }
    text.push_str("`umbragraph show NAME` prints one, `umbragraph show NAME > FILE` makes a file of it\n");
    text
}

/// Returns the first sentence of the comment with which a file begins; empty if it begins with none.
fn summary(text: &str) -> String {
    let comment: String = match text.strip_prefix("{#") {
        Some(rest) => rest.trim_start_matches('-').split("#}").next().unwrap_or_default().to_owned(),
        None => {
            let lines = text.lines().map_while(|line| line.strip_prefix("//"));
            lines.collect::<Vec<_>>().join(" ")
        }
    };
    let words = comment.split_whitespace().collect::<Vec<_>>().join(" ");
    let words = words.strip_prefix("A subgraph: ").unwrap_or(&words);
    // A sentence ends with a dot after a word; "J. Wald" has none.
    let is_end = |at: &usize| {
        let last = words[..*at].rsplit([' ', '(']).next().unwrap_or_default();
        last.len() > 1 && words[*at + 1..].chars().next().is_none_or(char::is_whitespace)
    };
    let end = words.match_indices('.').map(|(at, _)| at).find(is_end).unwrap_or(words.len());
    let sentence = words[..end].split(": ").next().unwrap_or_default().trim_end_matches(':');
    if sentence.chars().count() <= LONGEST {
        return sentence.to_owned();
    }
    let cut: String = sentence.chars().take(LONGEST).collect();
    format!("{}…", cut.rsplit_once(' ').map_or(cut.as_str(), |(whole, _)| whole))
}

/// The maximum number of characters of a summary.
const LONGEST: usize = 90;

fn unknown(wanted: &str, bare: &str, files: &[(String, &str)]) -> Diagnostic {
    let names = || files.iter().map(|(name, _)| name.as_str());
    let with_scheme = format!("{SCHEME}{bare}");
    let suggested = suggested_name(wanted, names()).or_else(|| suggested_name(&with_scheme, names()));
    let part = bare.trim_start_matches(SCHEME).to_lowercase();
    let similar: Vec<&str> = names().filter(|name| name.contains(&part)).take(8).collect();
    let help = match suggested {
        Some(suggested) => format!("did you mean \"{suggested}\"?"),
        None if similar.is_empty() => "`umbragraph show` lists the names".to_owned(),
        None => format!("there are {}", list_of(similar)),
    };
    let message = format!("no file \"{wanted}\" comes with this version");
    Diagnostic::in_file(codes::FILE_UNREADABLE, wanted, "", message).help(help)
}
