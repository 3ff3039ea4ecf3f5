//! PNG pictures with a palette.
//!
//! A byte for each texel, a palette of at most 256 colours with alpha, and the data in stored (not compressed) blocks:
//! small enough for procedural textures, and the same bytes from every version of every compressor, since there is
//! none.

/// A colour of a palette: red, green and blue (sRGB-encoded), and alpha.
pub(crate) type Color = [u8; 4];

/// A PNG file of `width` × `height` pixels. The colour of a pixel is `palette[index(x, y)]`; row 0 is on top.
pub(crate) fn paletted(
    width: u32,
    height: u32,
    palette: &[Color],
    index: impl Fn(u32, u32) -> u8,
) -> Vec<u8> {
    let mut rows = Vec::with_capacity((width as usize + 1) * height as usize);
    for y in 0..height {
        rows.push(0);
        rows.extend((0..width).map(|x| index(x, y)));
    }
    let mut header = Vec::new();
    header.extend(width.to_be_bytes());
    header.extend(height.to_be_bytes());
    // Eight bits, with a palette, the one compression and filter method there is, not interlaced.
    header.extend([8, 3, 0, 0, 0]);
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    chunk(&mut file, b"IHDR", &header);
    chunk(&mut file, b"PLTE", &palette.iter().flat_map(|color| color[..3].to_vec()).collect::<Vec<u8>>());
    if palette.iter().any(|color| color[3] != 255) {
        chunk(&mut file, b"tRNS", &palette.iter().map(|color| color[3]).collect::<Vec<u8>>());
    }
    chunk(&mut file, b"IDAT", &stored(&rows));
    chunk(&mut file, b"IEND", &[]);
    file
}

/// A palette of `count` opaque colours, interpolated between equally spaced stops.
pub(crate) fn ramp(count: usize, stops: &[[u8; 3]]) -> Vec<Color> {
    let last = stops.len() - 1;
    let color = |at: usize| {
        let position = at as f64 / (count - 1) as f64 * last as f64;
        let (stop, t) =
            ((position as usize).min(last - 1), position - position.floor().min(last as f64 - 1.0));
        let mix = |part: usize| {
            let (from, to) = (f64::from(stops[stop][part]), f64::from(stops[stop + 1][part]));
            (from + (to - from) * t).round() as u8
        };
        [mix(0), mix(1), mix(2), 255]
    };
    (0..count).map(color).collect()
}

fn chunk(file: &mut Vec<u8>, kind: &[u8; 4], content: &[u8]) {
    file.extend((content.len() as u32).to_be_bytes());
    let start = file.len();
    file.extend(kind);
    file.extend(content);
    let checksum = !file[start..].iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(
            sum ^ u32::from(*byte),
            |sum, _| if sum & 1 == 1 { (sum >> 1) ^ 0xedb8_8320 } else { sum >> 1 },
        )
    });
    file.extend(checksum.to_be_bytes());
}

/// A zlib stream of `bytes` in stored (uncompressed) blocks.
fn stored(bytes: &[u8]) -> Vec<u8> {
    let mut stream = vec![0x78, 0x01];
    let blocks = bytes.chunks(65_535);
    let last = blocks.len() - 1;
    for (at, block) in blocks.enumerate() {
        let length = block.len() as u16;
        stream.push(u8::from(at == last));
        stream.extend(length.to_le_bytes());
        stream.extend((!length).to_le_bytes());
        stream.extend(block);
    }
    let (mut a, mut b) = (1_u32, 0_u32);
    for byte in bytes {
        a = (a + u32::from(*byte)) % 65_521;
        b = (b + a) % 65_521;
    }
    stream.extend((b << 16 | a).to_be_bytes());
    stream
}
