//! Scores a rendered shadow mask against the ray-traced truth, as the tests do, and writes the differences.
//!
//! `cargo run --package umbragraph-test-support --example score -- SCENE PICTURE.png [DIFFERENCE.png]`
//!
//! Exit status: 0 where the limits for hard shadows are met, 1 where they are not, 2 where no score can be given.

use std::path::Path;
use std::process::ExitCode;

use umbragraph_test_support::image::Picture;
use umbragraph_test_support::truth::{BANDS, TruthError, TruthScene, check, difference_picture, evaluate};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (scene, picture, difference) = match arguments.as_slice() {
        [scene, picture] => (scene, picture, None),
        [scene, picture, difference] => (scene, picture, Some(difference)),
        _ => {
            eprintln!("usage: score SCENE PICTURE.png [DIFFERENCE.png]");
            return ExitCode::from(2);
        }
    };
    let Some(scene) = TruthScene::find(scene) else { return ExitCode::from(2) };
    match score(&scene, Path::new(picture), difference.map(Path::new)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn score(scene: &TruthScene, picture: &Path, difference: Option<&Path>) -> Result<bool, TruthError> {
    let picture = Picture::load(picture)?;
    let scores = evaluate(scene, &picture)?;
    if let Some(path) = difference {
        difference_picture(scene, &picture)?.save(path)?;
    }
    let number = |value: Option<f64>| value.map_or_else(|| "n/a".to_owned(), |value| format!("{value:.6}"));
    println!("both hit {}  hit in the picture only {}", number(scores.both_hit), scores.hit_in_picture_only);
    println!("band  pixels       iou  precision    recall      leak      acne");
    for (band, score) in BANDS.iter().zip(&scores.bands) {
        println!(
            "{band:>4} {:>7} {:>9} {:>10} {:>9} {:>9} {:>9}",
            score.pixels(),
            number(score.intersection_over_union()),
            number(score.precision()),
            number(score.recall()),
            number(score.leak()),
            number(score.acne()),
        );
    }
    if let Some(contact) = scores.contact {
        println!("contact {} pixels  leak {}", contact.pixels(), number(contact.leak()));
    }
    let verdict = check(&scores, &scene.hard_limits()?);
    println!("{}", verdict.as_ref().map_or_else(String::as_str, |()| "limits met"));
    Ok(verdict.is_ok())
}
