//! The window under a display: a slider that is moved changes the picture, and nothing is planned or created for it.

use std::path::Path;
use std::process::Command;

#[test]
fn a_slider_changes_the_live_frame_and_nothing_is_created() {
    if std::env::var_os("DISPLAY").is_none() {
        println!("skipped: there is no display; `xvfb-run cargo test` brings one");
        return;
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let output =
        Command::new(env!("CARGO_BIN_EXE_umbragraph-egui")).arg("--photograph").arg(folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("nothing created: true"), "{said}");
    let [before, after] = ["before.png", "after.png"].map(|name| read(&folder.join(name)));
    // The right half shows the frame: it has many colors, and is brighter with more exposure.
    let colors = before.chunks(3).collect::<std::collections::HashSet<_>>().len();
    let light = |picture: &[u8]| picture.iter().map(|byte| u64::from(*byte)).sum::<u64>();
    println!("{colors} colors, light from {} to {}", light(&before), light(&after));
    assert!(colors > 1000 && light(&after) > light(&before) * 11 / 10);
}

/// Reads the right half of a PNG file as RGB bytes.
fn read(path: &Path) -> Vec<u8> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let width = reader.info().width as usize * 3;
    let mut bytes = vec![0; width * reader.info().height as usize];
    reader.next_frame(&mut bytes).unwrap();
    bytes.chunks(width).flat_map(|row| &row[width / 2 / 3 * 3..]).copied().collect()
}
