//! The page: the picture with search, details and comparison, in one file that needs no network.
//!
//! The page has the report as JSON in itself and a script that only shows it: everything that is known is in the
//! report. Nothing in it can break out: the JSON's `<` are escaped, and the script writes text, never markup.

use super::model::Report;
use super::svg::{self, escape};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The page of a report, with the lines of a comparison if there is one.
pub(super) fn page(report: &Report, comparison: Option<&[String]>) -> String {
    let json = |value: serde_json::Result<String>| value.unwrap_or_default().replace('<', "\\u003c");
    let data = json(serde_json::to_string(report));
    let comparison = json(serde_json::to_string(&comparison));
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{name} · umbragraph</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header><h1>{name}</h1><input id=\"search\" type=\"search\" placeholder=\"Search passes and resources  ( / )\" autocomplete=\"off\">\
         <nav id=\"tabs\"></nav></header>\n<main>\n<section id=\"picture\">\n{picture}</section>\n<section id=\"table\" hidden></section>\n\
         <aside id=\"details\"></aside>\n</main>\n<script type=\"application/json\" id=\"report\">{data}</script>\n\
         <script type=\"application/json\" id=\"comparison\">{comparison}</script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        name = escape(&report.pipeline),
        picture = svg::picture(report),
    )
}
