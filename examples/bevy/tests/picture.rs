//! The plugin draws the committed picture, and follows the pipeline's file.

use std::io::BufWriter;
use std::path::Path;

use umbragraph_bevy::scene::{SIZE, app, picture};

const FILE: &str = "cascades.graph.json";

#[test]
fn the_picture_is_the_committed_one_and_follows_the_file() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("assets");
    std::fs::create_dir_all(&folder).unwrap();
    let text = std::fs::read_to_string(Path::new("assets").join(FILE)).unwrap();
    let write = |text: &str| std::fs::write(folder.join(FILE), text).unwrap();
    write(&text);
    let mut app = app(folder.to_str().unwrap());
    let first = picture(&mut app, &[], 120).expect("a picture");
    compare(&first);

    // Bevy's asset server sees that the file changes, and the picture does.
    let dark = text.replace("[0.5, 0.62, 0.85]", "[0.0, 0.0, 0.0]").replace("[0.3, 0.26, 0.22]", "[0, 0, 0]");
    assert_ne!(dark, text);
    write(&dark);
    let without = picture(&mut app, &first, 60).expect("another picture");
    let black = |picture: &[u8]| picture.chunks(4).filter(|texel| texel[..3] == [0, 0, 0]).count();
    println!("{} black pixels, {} without ambient light", black(&first), black(&without));
    assert!(black(&first) < 100 && black(&without) > 5000);

    // Of a file that is broken, and of one that cannot be planned, errors are logged, and the picture stays.
    write("{ \"format\": ");
    assert_eq!(picture(&mut app, &without, 3), None);
    write(&text.replace("\"name\": \"bevy\"", "\"name\": \"bevy\", \"presetz\": {}"));
    assert_eq!(picture(&mut app, &without, 3), None);
    write(&text);
    assert!(picture(&mut app, &without, 60).expect("a picture again") == first);
}

/// Asserts that a picture matches the committed one. At most 0.1 % of the pixels may differ by more than 8 of 255, and
/// the mean difference may be 0.5 of 255. `UMBRAGRAPH_BLESS=1` overwrites the committed picture.
fn compare(drawn: &[u8]) {
    let save = |path: &Path| {
        let file = BufWriter::new(std::fs::File::create(path).unwrap());
        let mut encoder = png::Encoder::new(file, SIZE[0], SIZE[1]);
        encoder.set_color(png::ColorType::Rgba);
        encoder.write_header().unwrap().write_image_data(drawn).unwrap();
    };
    let expected = Path::new("tests/picture.png");
    if std::env::var_os("UMBRAGRAPH_BLESS").is_some() {
        save(expected);
    }
    let file = std::io::BufReader::new(std::fs::File::open(expected).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut texels = vec![0; drawn.len()];
    reader.next_frame(&mut texels).unwrap();
    let off: Vec<u8> = texels.iter().zip(drawn).map(|(a, b)| a.abs_diff(*b)).collect();
    let pixels = off.chunks(4).filter(|pixel| pixel.iter().any(|off| *off > 8)).count();
    let mean = off.iter().map(|off| f64::from(*off)).sum::<f64>() / off.len() as f64;
    println!("{pixels} pixels off by more than 8, {mean:.4} in the mean");
    if pixels * 1000 > off.len() / 4 || mean > 0.5 {
        save(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("picture.png"));
        panic!(
            "{pixels} pixels are off by more than 8, {mean:.4} in the mean; drawn: {}",
            env!("CARGO_TARGET_TMPDIR")
        );
    }
}
