//! Random edits of a document and a template under the running window, half of them broken.
//!
//! While a file is broken the window shows the last good frame, bit for bit. Once it is mended the window shows what a
//! fresh start shows. Each good edit has a number of its own in the document, and each broken one a word, so that the
//! test knows which edit the window has seen. `UMBRAGRAPH_VIEW_EDITS` is the number of edits.

use std::path::Path;

use serde_json::{Value, json};
use umbragraph::Library;

use crate::PIPELINE;
use crate::hand::Hand;
use crate::random::{Random, variable};
use crate::read_back::{Fresh, pixels};
use crate::x11::{BACKSPACE, HOME};

/// The valid contents of the pipeline document and its template.
struct Files {
    document: String,
    template: String,
}

impl Files {
    fn random(random: &mut Random, mark: u64) -> Self {
        let mut pick = |words: &[&str]| words[random.below(words.len() as u64) as usize].to_owned();
        let resolution = pick(&["64", "128", "256"]);
        let (veil, dead) = (pick(&["false", "true"]), pick(&["", "\"side_effect\": true,"]));
        let (shade, exposure) = (pick(&["0.0", "0.1", "0.2"]), pick(&["0.7", "1", "1.4"]));
        let tint = r#""tint": { "after": ["veil"], "fullscreen": { "shader": "tint.wgsl.jinja", "color": [{ "to": "&target", "blend": "add" }] } },"#;
        let document = PIPELINE
            .replace("\"default\": 256", &format!("\"default\": {resolution}"))
            .replace("{ \"default\": false", &format!("{{ \"default\": {veil}"))
            .replace("\"dead\": {", &format!("\"dead\": {{ {dead}"))
            .replace("\"passes\": {", &format!("\"passes\": {{ {tint}"))
            .replacen(
                "\"parameters\": {",
                &format!("\"parameters\": {{ \"mark\": {{ \"type\": \"f32\", \"default\": {mark} }}, \"exposure\": {{ \"default\": {exposure} }},"), 1,
            );
        let template = format!(
            "{{% include \"lib/fullscreen.wgsl.jinja\" %}}\n@fragment\nfn fill(covered: Covered) -> @location(0) vec4<f32> {{\n    return vec4<f32>(covered.uv * 0.1, {shade}, 1.0);\n}}\n"
        );
        Self { document, template }
    }

    fn write(&self, folder: &Path) {
        std::fs::write(folder.join("shaders/tint.wgsl.jinja"), &self.template).unwrap();
        std::fs::write(folder.join("own.json"), &self.document).unwrap();
    }

    /// Breaks one of the files, and returns a word that its diagnostics contain.
    fn break_one(&self, folder: &Path, random: &mut Random, at: u64) -> String {
        let word = format!("bad{at}");
        let key = format!("\"{word}\": 1, \"passes\": {{");
        let (document, template) = (folder.join("own.json"), folder.join("shaders/tint.wgsl.jinja"));
        match random.below(6) {
            0 => std::fs::write(&document, self.document.replace("\"passes\": {", &key)),
            1 => std::fs::write(&document, self.document.replace("&color\"", &format!("&{word}\""))),
            2 => std::fs::write(&document, self.document.replace("gradient.wgsl", &word)),
            3 => std::fs::write(&template, self.template.replace("covered.uv *", &format!("{word} *"))),
            4 => std::fs::write(&template, self.template.replace("lib/fullscreen", &word)),
            // As an editor that writes by rename.
            _ => std::fs::write(folder.join("new"), self.document.replace("\"add\"", &format!("\"{word}\"")))
                .and_then(|()| std::fs::rename(folder.join("new"), &document)),
        }
        .unwrap();
        word
    }
}

/// Closes the panel below the frame, whose height changes the frame's size.
fn close_below(hand: &mut Hand) {
    let key = match hand.state()["below"].as_str() {
        Some("Graph") => 'g',
        Some(_) => 'n',
        None => return,
    };
    hand.display.press(&[], u32::from(key));
    hand.wait("no panel", |state| state["below"].is_null());
}

/// The frame at time 0, drawn anew, as its size and RGB pixels.
fn picture(hand: &mut Hand) -> ([u32; 2], Vec<[u8; 3]>) {
    if hand.state()["playing"] == true {
        hand.display.press(&[], u32::from(' '));
        hand.wait("pause", |state| state["playing"] == false);
    }
    hand.display.press(&[], BACKSPACE);
    hand.wait("restart", |state| state["time"] == 0.0);
    loop {
        close_below(hand);
        let before = hand.state()["frames"].clone();
        hand.display.press(&[], HOME);
        hand.wait("another frame", |state| state["frames"] != before);
        hand.settle();
        let path = hand.folder.join("frame-001.png");
        let _ = std::fs::remove_file(&path);
        hand.screenshot();
        // The first error of an edit opens the notices, maybe only now.
        if hand.state()["below"].is_null() {
            return pixels(&path);
        }
    }
}

#[test]
fn random_edits_keep_or_renew_the_frame() {
    let (seed, count) = (variable("UMBRAGRAPH_SEED", 11), variable("UMBRAGRAPH_VIEW_EDITS", 20));
    println!("UMBRAGRAPH_SEED={seed} UMBRAGRAPH_VIEW_EDITS={count}");
    let mut random = Random::new(seed);
    let mut files = Files::random(&mut random, 0);
    let hand = Hand::start_with("edits", &files.document, |folder| {
        std::fs::create_dir(folder.join("shaders")).unwrap();
        files.write(folder);
        ["--scale", "0.25", "--templates", "shaders"].map(str::to_owned).to_vec()
    });
    let Some(mut hand) = hand else { return };
    let fresh = Fresh::new();
    let errors = |state: &Value| state["errors"].to_string();
    hand.settle();
    let mut good = picture(&mut hand);
    let mut broken = 0;
    for at in 1..=count {
        // Some edits fall into a running animation.
        if random.below(3) == 0 {
            hand.display.press(&[], u32::from(' '));
            hand.wait("play", |state| state["playing"] == true);
        }
        if random.below(2) == 0 {
            broken += 1;
            // The other file may be broken from before; only one is now.
            files.write(&hand.folder);
            let word = files.break_one(&hand.folder, &mut random, at);
            hand.wait(&word, |state| errors(state).contains(&word));
            assert!(picture(&mut hand) == good, "edit {at} of the seed {seed}: not the last good frame");
        } else {
            files = Files::random(&mut random, at);
            files.write(&hand.folder);
            hand.wait("mended files", |state| {
                state["planned"]["mark"] == json!(at) && state["errors"] == json!([])
            });
            good = picture(&mut hand);
            let library = Library::new().templates(hand.folder.join("shaders"));
            let expected = fresh.picture(&library, &hand.folder.join("own.json"), good.0);
            assert!(good.1 == expected, "edit {at} of the seed {seed}: not the picture of a fresh start");
        }
    }
    println!("{count} edits, {broken} of them broken");
    assert!(hand.is_running() && !hand.said().contains("panicked"), "{}", hand.said());
}
