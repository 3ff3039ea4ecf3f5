//! Color tables in the text format `.cube`: a line `LUT_3D_SIZE N`, then N × N × N lines of red, green and blue, of which
//! the red of the input runs fastest. As a picture the table is N wide and N × N high, a slice of blue below the other.
//!
//! Source: Adobe, *Cube LUT Specification*, version 1.0, 2013. Tables over other inputs than 0 to 1, and those of one
//! dimension, are rejected.

use super::super::environment::Colors;

/// The maximum number of texels along a side, as the specification has it.
const MAX_SIDE: usize = 256;

/// Returns `true` if a file names the size of a color table, which stands before its colors.
pub(super) fn is_cube(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1 << 14)];
    start.split(|byte| *byte == b'\n').any(|line| line.trim_ascii().starts_with(b"LUT_"))
}

/// Decodes a color table; alpha is 1.
///
/// # Errors
/// A message with the line that is no `.cube`.
pub(super) fn decode(bytes: &[u8]) -> Result<Colors, String> {
    let text = std::str::from_utf8(bytes).map_err(|error| format!("it is no text: {error}"))?;
    let mut side = None;
    let mut texels: Vec<[f32; 4]> = Vec::new();
    for (at, line) in text.lines().enumerate() {
        let line = line.trim();
        let wrong = |what: &str| format!("line {}: {what}, here stands \"{}\"", at + 1, shortened(line));
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            [] | ["TITLE", ..] => {}
            [first, ..] if first.starts_with('#') => {}
            ["LUT_3D_SIZE", size] => {
                let size = size.parse().ok().filter(|size| (2..=MAX_SIDE).contains(size));
                side = Some(size.ok_or_else(|| wrong("a size is a whole number from 2 to 256"))?);
            }
            ["LUT_1D_SIZE", ..] => {
                return Err(wrong("a table of one dimension is not supported: convert it to LUT_3D_SIZE"));
            }
            ["DOMAIN_MIN", inputs @ ..] if are_all(inputs, 0.0) => {}
            ["DOMAIN_MAX", inputs @ ..] if are_all(inputs, 1.0) => {}
            ["DOMAIN_MIN" | "DOMAIN_MAX", ..] => {
                return Err(wrong("inputs run from 0 0 0 to 1 1 1"));
            }
            words => {
                let side: usize = side.ok_or_else(|| wrong("colors come after LUT_3D_SIZE"))?;
                let [red, green, blue] =
                    color(words).ok_or_else(|| wrong("a color is three finite numbers"))?;
                if texels.len() == side * side * side {
                    return Err(wrong(&format!("a table of {side} × {side} × {side} colors ends before")));
                }
                texels.push([red, green, blue, 1.0]);
            }
        }
    }
    let side = side.ok_or("it has no line LUT_3D_SIZE")?;
    let (wanted, count) = (side * side * side, texels.len());
    match count == wanted {
        true => Ok(Colors { width: side, height: side * side, texels }),
        false => Err(format!("LUT_3D_SIZE {side} is {wanted} colors, and the file has {count}")),
    }
}

fn are_all(words: &[&str], wanted: f32) -> bool {
    words.len() == 3 && words.iter().all(|word| word.parse() == Ok(wanted))
}

fn color(words: &[&str]) -> Option<[f32; 3]> {
    let numbers = words.iter().map(|word| word.parse().ok().filter(|number: &f32| number.is_finite()));
    numbers.collect::<Option<Vec<f32>>>()?.try_into().ok()
}

fn shortened(line: &str) -> String {
    line.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "# warm\r\nTITLE \"warm\"\r\nLUT_3D_SIZE 2\r\nDOMAIN_MIN 0 0 0\r\nDOMAIN_MAX 1.0 1.0 1.0\r\n\r\n\
        0 0 0\r\n1 0 0\r\n0 1 0\r\n1 1 0\r\n0 0 1\r\n1 0 1\r\n0 1 1\r\n1 1 0.5\r\n";

    #[test]
    fn red_runs_fastest_and_blue_slices_stand_below_one_another() {
        assert!(is_cube(TABLE.as_bytes()));
        let colors = decode(TABLE.as_bytes()).expect("a table");
        assert_eq!((colors.width, colors.height), (2, 4));
        assert_eq!(colors.texels[1], [1.0, 0.0, 0.0, 1.0]);
        assert_eq!(colors.texels[2], [0.0, 1.0, 0.0, 1.0]);
        assert_eq!(colors.texels[7], [1.0, 1.0, 0.5, 1.0]);
    }

    #[test]
    fn broken_tables_are_rejected_with_their_line() {
        let cases = [
            ("1 1 0.5", "1 1", "line 14: a color is three finite numbers, here stands \"1 1\""),
            ("1 1 0.5", "1 1 nan", "line 14: a color is three finite numbers, here stands \"1 1 nan\""),
            ("1 1 0.5\r\n", "", "LUT_3D_SIZE 2 is 8 colors, and the file has 7"),
            (
                "1 1 0.5",
                "1 1 1\r\n0 0 0",
                "line 15: a table of 2 × 2 × 2 colors ends before, here stands \"0 0 0\"",
            ),
            (
                "SIZE 2",
                "SIZE 257",
                "line 3: a size is a whole number from 2 to 256, here stands \"LUT_3D_SIZE 257\"",
            ),
            (
                "MAX 1.0",
                "MAX 4.0",
                "line 5: inputs run from 0 0 0 to 1 1 1, here stands \"DOMAIN_MAX 4.0 1.0 1.0\"",
            ),
        ];
        for (known, broken, message) in cases {
            assert_eq!(decode(TABLE.replace(known, broken).as_bytes()), Err(message.to_owned()));
        }
    }
}
