//! Lines of text in pictures.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster};
use umbragraph_test_support::image::Picture;

/// The height of a line in texels.
pub const HEIGHT: u32 = 16;

const COLOR: [u8; 3] = [235, 225, 200];

/// Writes a line over a picture; `at` is its top left. Characters beyond ASCII are left out.
pub fn write(picture: &mut Picture, line: &str, [left, top]: [u32; 2]) {
    let mut left = left;
    for raster in
        line.chars().filter_map(|letter| get_raster(letter, FontWeight::Regular, RasterHeight::Size16))
    {
        for (y, row) in (top..).zip(raster.rows()) {
            for (x, covered) in (left..).zip(row) {
                let Some(pixel) = picture.pixel_mut(x, y) else { continue };
                for (channel, color) in pixel.iter_mut().zip(COLOR) {
                    let covered = u32::from(*covered);
                    *channel =
                        ((u32::from(*channel) * (255 - covered) + u32::from(color) * covered) / 255) as u8;
                }
            }
        }
        left += raster.width() as u32;
    }
}

/// Lays a picture over a sheet, without its alpha.
pub fn paste(sheet: &mut Picture, cell: &Picture, at: [u32; 2]) {
    for (index, pixel) in cell.rgba_pixels().enumerate() {
        let (x, y) = (index as u32 % cell.width(), index as u32 / cell.width());
        if let Some(target) = sheet.pixel_mut(at[0] + x, at[1] + y) {
            target.copy_from_slice(&pixel[..3]);
        }
    }
}
