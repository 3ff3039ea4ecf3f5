//! Random edits of every file while frames run: no crash, the last good frame while the files are broken, and the
//! picture of a fresh start once they are mended.

use super::stage::{FILES, Stage, WAYS, texts};
use umbragraph_test_support::edits::edited;
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

/// The edits of an ordinary test; `cargo xtask soak` tries 240.
const EDITS: u32 = 24;

/// Numbers that are seen in the picture.
const VISIBLE: [(&str, &str); 4] = [
    ("frame.json", "0.5"),
    ("look.json", "0.75"),
    ("shaders/fill.wgsl.jinja", "0.25"),
    ("shaders/tint.wgsl.jinja", "0.75"),
];

#[test]
fn random_edits_show_a_fresh_start_or_the_last_frame() {
    let Some(mut stage) = Stage::new("random_edits", FILES) else { return };
    let mut random = Random(property::seed());
    let mut shown = stage.until("begun", |_, _| true);
    let (mut broken, mut other) = (0, 0);
    for at in 0..EDITS * property::times() {
        // Every third edit takes all of them back, in one go.
        let mended = at % 3 == 2;
        let (name, text) = random.one_of(FILES);
        let way = random.one_of(&WAYS);
        if mended {
            FILES.iter().for_each(|(name, text)| stage.write(name, text, way));
        } else if random.one_in(3) {
            let (name, from) = random.one_of(&VISIBLE);
            let text = texts()[name].replacen(from, &format!("0.{}", 1 + random.below(9)), 1);
            stage.write(name, &text, way);
        } else {
            stage.write(name, &edited(text, &mut random), way);
        }
        let what = format!("edit {at} of {name} ({way:?})");
        match stage.fresh() {
            Ok(fresh) => {
                let picture = stage.until(&what, |watcher, one| watcher.error().is_none() && *one == fresh);
                other += u32::from(picture != shown);
                shown = picture;
            }
            Err(_) => {
                assert!(!mended, "{what}");
                broken += 1;
                let picture = stage.until(&what, |watcher, _| watcher.error().is_some());
                assert_eq!(picture, shown, "{what}");
                for _ in 0..3 {
                    assert_eq!(stage.frame().as_ref(), Some(&shown), "{what}");
                }
            }
        }
    }
    println!("{broken} edits were broken, {other} changed the picture");
    assert!(broken > 0);
}
