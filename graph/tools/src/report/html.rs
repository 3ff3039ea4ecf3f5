//! The page: the picture with search, details and comparison, in one file that needs no network.
//!
//! The page has the report as JSON in itself and a script that only shows it: everything that is known is in the
//! report. Nothing in it can break out: the JSON's `<` are escaped, and the script writes text, never markup.

use std::collections::BTreeMap;

use serde::Serialize;

use super::model::Report;
use super::svg::{self, escape};
use umbragraph_pipeline::diagnostic::render::visible_json;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The height in pixels of the captured images below the passes; the page's script has the same constant.
const PICTURE: usize = 60;

/// Captured images, captured buffers and pass times that the page shows.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Observed {
    /// The captured images by resource name or `NAME@PASS`, each as a `data:` URL.
    pub pictures: BTreeMap<String, String>,
    /// The first rows of captured buffers as text, by resource name or `NAME@PASS`.
    pub buffers: BTreeMap<String, String>,
    /// The CPU and GPU time of each pass in milliseconds, by pass name.
    pub times: BTreeMap<String, [f64; 2]>,
}

/// Builds the HTML page of a report, with captured images, pass times and optional comparison lines.
pub fn page(report: &Report, comparison: Option<&[String]>, observed: &Observed) -> String {
    let json =
        |value: serde_json::Result<String>| visible_json(&value.unwrap_or_default()).replace('<', "\\u003c");
    let pictures = !observed.pictures.is_empty();
    let data = json(serde_json::to_string(report));
    let comparison = json(serde_json::to_string(&comparison));
    let observed = json(serde_json::to_string(observed));
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{name} · umbragraph</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header><h1>{name}</h1><input id=\"search\" type=\"search\" placeholder=\"Search passes and resources  ( / )\" autocomplete=\"off\">\
         <nav id=\"tabs\"></nav></header>\n<main>\n<section id=\"picture\">\n{picture}</section>\n<section id=\"table\" hidden></section>\n\
         <aside id=\"details\"></aside>\n</main>\n<script type=\"application/json\" id=\"report\">{data}</script>\n\
         <script type=\"application/json\" id=\"comparison\">{comparison}</script>\n\
         <script type=\"application/json\" id=\"observed\">{observed}</script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        name = escape(&report.pipeline),
        picture = svg::picture(report, if pictures { PICTURE } else { 0 }),
    )
}
