//! JPEG files for the decoder: the segments that define texels, without metadata.
//!
//! glTF ignores metadata (Exif, XMP, color profiles, comments), and the decoder's time for it grows with the square of
//! the number of its segments. Entropy-coded bytes between segments are copied. Source: ITU-T T.81, annex B.

/// Returns the JPEG file without metadata (the segments APP1 to APP13, APP15 and COM) and without stray bytes between
/// segments.
pub(super) fn without_metadata(bytes: &[u8]) -> Vec<u8> {
    let mut kept = Vec::with_capacity(bytes.len());
    let mut rest = bytes;
    while let Some(start) = rest.iter().position(|byte| *byte == 0xff) {
        rest = &rest[start..];
        let [_, marker, after @ ..] = rest else { return kept };
        let length = match marker {
            // A fill byte, or a stray one.
            0x00 | 0xff => {
                rest = &rest[1..];
                continue;
            }
            // Temporary, restarts, the start of the image: markers alone.
            0x01 | 0xd0..=0xd8 => 0,
            0xd9 => {
                kept.extend_from_slice(&rest[..2]);
                return kept;
            }
            _ => match after {
                [high, low, ..] => usize::from(u16::from_be_bytes([*high, *low])),
                _ => return kept,
            },
        };
        // What follows the header of a scan, or a restart, is entropy-coded up to the next marker.
        let segment = (2 + length).min(rest.len());
        let is_scan = matches!(marker, 0xda | 0xd0..=0xd7);
        let end = if is_scan { segment + entropy_coded(&rest[segment..]) } else { segment };
        if !matches!(marker, 0xe1..=0xed | 0xef | 0xfe) {
            kept.extend_from_slice(&rest[..end]);
        }
        rest = &rest[end..];
    }
    kept
}

/// The number of entropy-coded bytes before the next marker. In entropy-coded data, a byte 255 is followed by a zero
/// byte; in a marker it is not.
fn entropy_coded(bytes: &[u8]) -> usize {
    bytes.windows(2).position(|pair| pair[0] == 0xff && pair[1] != 0).unwrap_or(bytes.len())
}

#[cfg(test)]
mod tests {
    use super::without_metadata;

    #[test]
    fn metadata_goes_and_scans_stay_byte_for_byte() {
        let start = [0xff, 0xd8, 0xff, 0xe0, 0, 3, 7];
        let exif = [0xff, 0xe1, 0, 4, 1, 2];
        let scan = [0xff, 0xda, 0, 3, 9, 5, 0xff, 0, 6, 0xff, 0xd3, 8];
        let comment = [0xff, 0xff, 0xfe, 0, 2];
        let (stray, end) = ([4, 0xff, 0], [0xff, 0xd9]);
        let file = [&start[..], &exif, &stray, &scan, &comment, &scan, &end, &[1, 2, 3]].concat();
        assert_eq!(without_metadata(&file), [&start[..], &scan, &scan, &end].concat());
    }

    #[test]
    fn what_ends_early_ends_early() {
        let file = [0xff, 0xd8, 0xff, 0xc0, 0, 200, 1, 2];
        for length in 0..=file.len() {
            assert!(without_metadata(&file[..length]).len() <= length);
        }
        assert_eq!(without_metadata(&file), file);
        assert!(without_metadata(&[1, 2, 3]).is_empty());
    }
}
