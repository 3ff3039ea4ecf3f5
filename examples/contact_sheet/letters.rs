//! Capital letters and digits of 3 by 5 cells.

use umbragraph_test_support::image::Picture;

/// Texels for each cell of a letter.
const SCALE: u32 = 2;

/// The cells of a letter, row by row from the top left.
fn cells(letter: char) -> &'static str {
    match letter {
        'A' => ".#.#.#####.##.#",
        'C' => ".###..#..#...##",
        'D' => "##.#.##.##.###.",
        'E' => "####..##.#..###",
        'F' => "####..##.#..#..",
        'G' => ".###..#.##.#.##",
        'H' => "#.##.#####.##.#",
        'I' => "###.#..#..#.###",
        'L' => "#..#..#..#..###",
        'M' => "#.########.##.#",
        'N' => "##.#.##.##.##.#",
        'O' => ".#.#.##.##.#.#.",
        'P' => "##.#.###.#..#..",
        'R' => "##.#.###.#.##.#",
        'S' => ".###...#...###.",
        'T' => "###.#..#..#..#.",
        'U' => "#.##.##.##.####",
        'V' => "#.##.##.##.#.#.",
        '1' => ".#.##..#..#.###",
        '2' => "###..#####..###",
        '3' => "###..####..####",
        '4' => "#.##.####..#..#",
        '5' => "####..###..####",
        '6' => "####..####.####",
        '7' => "###..#.#..#..#.",
        '9' => "####.####..####",
        _ => "...............",
    }
}

/// Writes a line; `at` is its top left.
pub(crate) fn write(picture: &mut Picture, line: &str, at: [u32; 2]) {
    for (place, letter) in (0u32..).zip(line.chars()) {
        for (index, cell) in (0u32..).zip(cells(letter).chars()) {
            if cell != '#' {
                continue;
            }
            let corner = [at[0] + SCALE * (4 * place + index % 3), at[1] + SCALE * (index / 3)];
            for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                if let Some(pixel) = picture.pixel_mut(corner[0] + x, corner[1] + y) {
                    pixel.copy_from_slice(&[235, 225, 200]);
                }
            }
        }
    }
}
