//! Radiance pictures (.hdr): a text header, and rows of RGBE texels, run-length encoded or not.
//!
//! The format is that of G. Ward, "Real pixels", Graphics Gems II, 1991, and of the file `color.c` of Radiance.
//! Pictures are read whose rows go from top to bottom and from left to right (`-Y HEIGHT +X WIDTH`), in RGB; nearly all
//! are so.

/// A picture of linear RGB colors and alpha, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::front) struct Colors {
    pub(in crate::front) width: usize,
    pub(in crate::front) height: usize,
    pub(in crate::front) texels: Vec<[f32; 4]>,
}

/// The maximum width and height in pixels; 16k by 8k texels take 2 GiB.
pub(super) const MAX_SIDE: usize = 16384;

/// Decodes a Radiance `.hdr` file.
///
/// # Errors
/// A message that describes the defect.
pub(super) fn decode(bytes: &[u8]) -> Result<Colors, String> {
    let mut rest = bytes;
    let mut line = || -> Result<&[u8], String> {
        let end = rest.iter().position(|byte| *byte == b'\n').ok_or("the header has no end")?;
        let (line, after) = rest.split_at(end);
        rest = &after[1..];
        Ok(line.strip_suffix(b"\r").unwrap_or(line))
    };
    if !line()?.starts_with(b"#?") {
        return Err("it does not begin with \"#?\", as Radiance pictures do".to_owned());
    }
    loop {
        let entry = line()?;
        if entry.is_empty() {
            break;
        }
        if let Some(format) = entry.strip_prefix(b"FORMAT=")
            && format != b"32-bit_rle_rgbe"
        {
            let format = String::from_utf8_lossy(format);
            return Err(format!("its format is \"{format}\", and only \"32-bit_rle_rgbe\" is read"));
        }
    }
    let size = String::from_utf8_lossy(line()?).into_owned();
    let words: Vec<&str> = size.split_ascii_whitespace().collect();
    let side = |word: &str| word.parse::<usize>().ok().filter(|side| (1..=MAX_SIDE).contains(side));
    let sides = match words.as_slice() {
        ["-Y", height, "+X", width] => side(height).zip(side(width)),
        _ => None,
    };
    let (height, width) = sides.ok_or_else(|| {
        format!("its size is \"{size}\" instead of -Y HEIGHT +X WIDTH, at most {MAX_SIDE} each")
    })?;
    let mut texels = Vec::new();
    let mut row = vec![[0_u8; 4]; width];
    for index in 0..height {
        rest = read_row(rest, &mut row)
            .ok_or_else(|| format!("it ends, or is broken, in row {index} of {height}"))?;
        texels.extend(row.iter().map(|texel| linear(*texel)));
    }
    Ok(Colors { width, height, texels })
}

/// Decodes a row of texels and returns the remaining bytes; `None` if the data is invalid.
fn read_row<'a>(bytes: &'a [u8], row: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    let width = row.len();
    let is_new = bytes.len() >= 4
        && (8..32768).contains(&width)
        && bytes[..2] == [2, 2]
        && usize::from(bytes[2]) << 8 | usize::from(bytes[3]) == width;
    if !is_new {
        return read_old_row(bytes, row);
    }
    let mut rest = &bytes[4..];
    for channel in 0..4 {
        let mut at = 0;
        while at < width {
            let (&code, after) = rest.split_first()?;
            let run = usize::from(code);
            let count = if run > 128 { run - 128 } else { run };
            let texels = row.get_mut(at..at + count).filter(|_| count > 0)?;
            if run > 128 {
                let (&value, after) = after.split_first()?;
                texels.iter_mut().for_each(|texel| texel[channel] = value);
                rest = after;
            } else {
                let values = after.get(..count)?;
                texels.iter_mut().zip(values).for_each(|(texel, value)| texel[channel] = *value);
                rest = &after[count..];
            }
            at += count;
        }
    }
    Some(rest)
}

/// Decodes a row in the old encoding: plain texels, where 1, 1, 1 and a count repeat the previous texel.
fn read_old_row<'a>(mut bytes: &'a [u8], row: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    let (mut at, mut shift) = (0, 0);
    while at < row.len() {
        let (texel, after) = bytes.split_first_chunk::<4>()?;
        bytes = after;
        if texel[..3] == [1, 1, 1] && at > 0 {
            let count = usize::from(texel[3]).checked_shl(shift).filter(|_| shift < 24)?;
            let before = row[at - 1];
            row.get_mut(at..at + count)?.fill(before);
            (at, shift) = (at + count, shift + 8);
        } else {
            row[at] = *texel;
            (at, shift) = (at + 1, 0);
        }
    }
    Some(bytes)
}

/// Converts a texel of three mantissas and a shared exponent (RGBE) to a linear color with an alpha of 1.
fn linear([red, green, blue, exponent]: [u8; 4]) -> [f32; 4] {
    let scale = if exponent == 0 { 0.0 } else { f32::from(exponent) - 136.0 };
    let factor = if exponent == 0 { 0.0 } else { scale.exp2() };
    let [red, green, blue] = [red, green, blue].map(|mantissa| f32::from(mantissa) * factor);
    [red, green, blue, 1.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(size: &str, data: &[u8]) -> Vec<u8> {
        [format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").as_bytes(), data].concat()
    }

    #[test]
    fn plain_texels_are_mantissas_and_an_exponent() {
        let colors = decode(&file("-Y 1 +X 2", &[128, 64, 0, 129, 128, 128, 128, 136])).unwrap();
        assert_eq!(colors.texels, [[1.0, 0.5, 0.0, 1.0], [128.0, 128.0, 128.0, 1.0]]);
        assert_eq!((colors.width, colors.height), (2, 1));
    }

    #[test]
    fn runs_are_expanded_by_channel() {
        let runs = [2, 2, 0, 9, 137, 128, 137, 64, 9, 0, 1, 2, 3, 4, 5, 6, 7, 8, 137, 136];
        let colors = decode(&file("-Y 1 +X 9", &runs)).unwrap();
        assert_eq!(colors.texels[3], [128.0, 64.0, 3.0, 1.0]);
        assert_eq!(colors.texels[8], [128.0, 64.0, 8.0, 1.0]);
        let repeated = decode(&file("-Y 1 +X 4", &[128, 0, 0, 129, 1, 1, 1, 3])).unwrap();
        assert_eq!(repeated.texels, [[1.0, 0.0, 0.0, 1.0]; 4]);
    }

    #[test]
    fn broken_files_are_told_what_is_wrong() {
        for (bytes, said) in [
            (b"PNG".to_vec(), "no end"),
            (b"P6\n\n".to_vec(), "does not begin"),
            (file("+X 4 -Y 2", &[]), "its size is"),
            (file("-Y 0 +X 2", &[]), "its size is"),
            (file("-Y 2 +X 1", &[1, 2, 3, 128]), "row 1 of 2"),
            (file("-Y 1 +X 9", &[2, 2, 0, 9, 200, 1]), "row 0 of 1"),
            (file("-Y 1 +X 2", &[9, 9, 9, 9, 1, 1, 1, 9]), "row 0 of 1"),
            (b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n".to_vec(), "xyze"),
        ] {
            let error = decode(&bytes).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
