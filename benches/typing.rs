//! The time of the language server's answers while one types: JSON messages in, JSON messages out.
//!
//! Before each answer one character is typed in the middle of the document, so that nothing of it is known yet. The
//! edit is in a description, which changes no declaration, or in a reference, which is broken by it. Inlay hints are
//! asked for 60 lines, as editors do. No shader text changes. Lines `ratio NAME VALUE` are ours divided by what is
//! aimed at (20 ms for `awsm`, 50 ms for 10,000 lines). Times are the minimum of several runs.

use std::time::{Duration, Instant};

use serde_json::{Value as Json, json};
use umbragraph::low_level::document::format;
use umbragraph::low_level::session::Session;
use umbragraph::low_level::source::Sources;
use umbragraph::{DiskStorage, with_templates};
use umbragraph_lsp::Texts;

#[path = "chain.rs"]
mod chain;
#[path = "measure.rs"]
mod measure;

const RUNS: usize = 15;

/// The name of an answer in the table, and its method; none for the diagnostics that follow an edit.
const ANSWERS: [(&str, Option<&str>); 5] = [
    ("diagnostics", None),
    ("completion", Some("completion")),
    ("hover", Some("hover")),
    ("semantic tokens", Some("semanticTokens/full")),
    ("inlay hints", Some("inlayHint")),
];

fn main() {
    let root = root();
    // 10,000 lines as the formatter writes them, and with two lines for a pass, which are longer than it would write.
    let (long, dense) = (formatted(&chain::chain(1_000)), chain::chain(5_000));
    assert!([&long, &dense].iter().all(|text| (9_900..10_100).contains(&text.lines().count())));
    let long_path = format!("{root}/pipelines/long.json");
    let [whole, part] = ["awsm.json", "awsm/filters.json"].map(|name| format!("{root}/pipelines/{name}"));
    let rows = [
        typed("`awsm`, a description", &whole, None, ["\"description\": \"", "\"contact_form"], "0", 20),
        typed("a file of `awsm`, a default", &part, None, ["\"default\": ", "\"description"], "0", 20),
        typed("1,000 passes, a description", &long_path, Some(&long), ["one of a chain", "\"&"], "0", 50),
        typed("1,000 passes, a reference", &long_path, Some(&long), ["\"&", "\"&"], "0", 50),
        typed("1,000 passes, a quote", &long_path, Some(&long), ["\"fullscreen", "\"&"], "\"", 50),
        typed("5,000 passes, a description", &long_path, Some(&dense), ["one of a chain", "\"&"], "0", 50),
        typed("5,000 passes, a reference", &long_path, Some(&dense), ["\"&", "\"&"], "0", 50),
        typed("5,000 passes, a quote", &long_path, Some(&dense), ["\"fullscreen", "\"&"], "\"", 50),
    ];
    measure::table(
        [
            "document and edit",
            "open",
            "diagnostics",
            "completion",
            "hover",
            "semantic tokens",
            "inlay hints",
            "aim",
        ],
        &rows,
    );
}

/// Returns a table row: name, time to open a document, shortest times of answers after one character typed behind
/// `typed`, and the target time. Completion and hover are asked behind the first `asked` that follows.
fn typed(
    name: &str,
    path: &str,
    text: Option<&str>,
    [typed, asked]: [&str; 2],
    by: &str,
    aim_ms: u64,
) -> [String; 8] {
    let on_disk = || std::fs::read_to_string(path).expect("a text");
    let text = text.map_or_else(on_disk, str::to_owned);
    let mut editor = Editor::new(path, &text);
    let middle = text.len() / 2;
    let behind = |from: usize, part: &str| from + text[from..].find(part).expect("the part") + part.len();
    let edit = behind(middle, typed);
    let asked = if typed == asked { edit } else { behind(edit, asked) };
    let mut row = vec![name.to_owned(), shown(editor.opened)];
    for (answer, method) in ANSWERS {
        let time = (0..RUNS)
            .map(|_| {
                // Typed, and taken back unmeasured, so that every run finds the same text.
                let time = editor.after_edit(edit, 0, by, method, asked + 1);
                editor.after_edit(edit, 1, "", None, asked);
                time
            })
            .min()
            .unwrap_or_default();
        println!(
            "ratio typing/{}/{} {:.3}",
            name.replace(' ', "_"),
            answer.replace(' ', "_"),
            time.as_secs_f64() * 1e3 / aim_ms as f64
        );
        row.push(shown(time));
    }
    row.push(format!("{aim_ms} ms"));
    row.try_into().expect("a cell for each head")
}

/// Formats a time in milliseconds with about two significant digits.
fn shown(time: Duration) -> String {
    let millis = time.as_secs_f64() * 1e3;
    format!("{millis:.digits$} ms", digits = usize::from(millis < 10.0))
}

type Open = fn(&[std::path::PathBuf]) -> Session;

/// A client with one open document.
struct Editor {
    server: Texts<Open>,
    uri: String,
    text: String,
    /// The time from the message that opens the document to its diagnostics.
    opened: Duration,
}

impl Editor {
    fn new(path: &str, text: &str) -> Self {
        let mut server: Texts<Open> = Texts::new(|folders| {
            let mut session = Session::new(DiskStorage, umbragraph::registry(), with_templates([]));
            session.set_roots(folders);
            session
        });
        let encodings = json!({ "general": { "positionEncodings": ["utf-8"] } });
        let uri = format!("file://{path}");
        let folders = json!([{ "uri": format!("file://{}/pipelines", root()), "name": "pipelines" }]);
        server.handle(&request(
            "initialize",
            json!({ "capabilities": encodings, "workspaceFolders": folders }),
        ));
        let document = json!({ "uri": uri, "languageId": "jsonc", "version": 1, "text": text });
        let opens = notification("didOpen", json!({ "textDocument": document }));
        let start = Instant::now();
        server.handle(&opens);
        let published = server.tell();
        let opened = start.elapsed();
        assert!(published.is_empty(), "{published:?}");
        Self { server, uri, text: text.to_owned(), opened }
    }

    /// Replaces `removed` bytes at an offset. Returns the time of the edit and of the answer asked for at `asked`.
    fn after_edit(
        &mut self,
        edit: usize,
        removed: usize,
        by: &str,
        method: Option<&str>,
        asked: usize,
    ) -> Duration {
        let end = edit + removed;
        let range = json!({ "start": self.position(edit), "end": self.position(end) });
        self.text.replace_range(edit..end, by);
        let change = json!({ "textDocument": { "uri": self.uri, "version": 2 },
            "contentChanges": [{ "range": range, "text": by }] });
        let change = notification("didChange", change);
        let position = self.position(asked);
        let line = position["line"].as_u64().expect("a line");
        let seen = json!({ "start": { "line": line.saturating_sub(30), "character": 0 },
            "end": { "line": line + 30, "character": 0 } });
        let asks = json!({ "textDocument": { "uri": self.uri }, "position": position, "range": seen });
        let asks = method.map(|method| request(&format!("textDocument/{method}"), asks));
        let start = Instant::now();
        self.server.handle(&change);
        let answered = match &asks {
            Some(asks) => self.server.handle(asks),
            None => self.server.tell(),
        };
        let time = start.elapsed();
        let has_answer = |text: &String| text.contains("\"result\":");
        assert!(asks.is_none() || answered.iter().any(has_answer), "{asks:?}: {answered:?}");
        time
    }

    fn position(&self, offset: usize) -> Json {
        let before = &self.text[..offset];
        let start = before.rfind('\n').map_or(0, |at| at + 1);
        json!({ "line": before.matches('\n').count(), "character": offset - start })
    }
}

fn root() -> &'static str {
    env!("CARGO_MANIFEST_DIR").strip_suffix("/lsp").expect("the folder of the crate")
}

fn request(method: &str, params: Json) -> String {
    json!({ "jsonrpc": "2.0", "id": 1, "method": method, "params": params }).to_string()
}

fn notification(method: &str, params: Json) -> String {
    json!({ "jsonrpc": "2.0", "method": format!("textDocument/{method}"), "params": params }).to_string()
}

/// Returns a document as `umbragraph fmt` writes it.
fn formatted(text: &str) -> String {
    let mut sources = Sources::new();
    let file = sources.add("long.json", text);
    format::format(&sources, file).expect("a document").apply(text).expect("edits of the text")
}
