//! Files and texts for others: a screenshot, a clip, a command line that draws the same picture.

use std::path::Path;
use std::time::Duration;

use umbragraph::executor::read_bytes;
use umbragraph::wgpu;

use crate::files;

/// The time between two frames of a clip.
pub(crate) const STEP: Duration = Duration::from_millis(50);

/// The most frames of a clip.
pub(crate) const MOST: usize = 200;

/// A picture of bytes: red, green, blue, alpha.
#[derive(Clone)]
pub(crate) struct Picture {
    size: [u32; 2],
    bytes: Vec<u8>,
}

impl Picture {
    /// Reads a texture of four bytes a texel once it is drawn.
    ///
    /// # Errors
    /// A device that cannot copy it, in words.
    pub(crate) fn read(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        texture: &wgpu::Texture,
    ) -> Result<Self, String> {
        let bytes = pollster::block_on(read_bytes(device, queue, texture)).map_err(|found| found.message)?;
        Ok(Self { size: [texture.width(), texture.height()], bytes })
    }

    /// Writes a PNG.
    ///
    /// # Errors
    /// A file that cannot be written, in words.
    pub(crate) fn write(&self, path: &Path) -> Result<String, String> {
        write(path, std::slice::from_ref(self))
    }
}

/// A clip that is recorded.
pub(crate) struct Clip {
    frames: Vec<Picture>,
}

impl Clip {
    pub(crate) fn new() -> Self {
        Self { frames: Vec::new() }
    }

    pub(crate) fn len(&self) -> usize {
        self.frames.len()
    }

    /// Takes in a frame; one of another size than the first is left out.
    pub(crate) fn push(&mut self, picture: Picture) {
        if self.frames.first().is_none_or(|first| first.size == picture.size) && self.frames.len() < MOST {
            self.frames.push(picture);
        }
    }

    /// Writes an APNG.
    ///
    /// # Errors
    /// No frame, a file that cannot be written, in words.
    pub(crate) fn write(&self, path: &Path) -> Result<String, String> {
        if self.frames.is_empty() {
            return Err("the clip has no frame: nothing was drawn meanwhile".to_owned());
        }
        write(path, &self.frames)
    }
}

/// Writes pictures of one size: one as a PNG, several as an APNG.
fn write(path: &Path, frames: &[Picture]) -> Result<String, String> {
    let [width, height] = frames.first().map_or([0; 2], |first| first.size);
    let mut file = Vec::new();
    let encoded = || -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::Fast);
        if frames.len() > 1 {
            encoder.set_animated(frames.len() as u32, 0)?;
            encoder.set_frame_delay(STEP.as_millis() as u16, 1000)?;
        }
        let mut writer = encoder.write_header()?;
        for frame in frames {
            // A picture is opaque, whatever its alpha is.
            let rgb: Vec<u8> =
                frame.bytes.chunks_exact(4).flat_map(|texel| [texel[0], texel[1], texel[2]]).collect();
            writer.write_image_data(&rgb)?;
        }
        writer.finish()
    };
    let mut encoded = encoded;
    encoded().map_err(|error| format!("the picture cannot be written: {error}"))?;
    files::replace(path, file)?;
    let what =
        if frames.len() > 1 { format!("{} frames", frames.len()) } else { format!("{width} × {height}") };
    Ok(format!("{}: {what}", path.display()))
}

/// A word of a command line, in quotes where a shell would take it apart.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_=./:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// A command line.
pub(crate) fn command_line(words: impl IntoIterator<Item = String>) -> String {
    words.into_iter().map(|word| quoted(&word)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_command_line_survive_a_shell() {
        let words = ["umbragraph", "--set", "far=[1, 2]", "it's"].map(str::to_owned);
        assert_eq!(command_line(words), "umbragraph --set 'far=[1, 2]' 'it'\\''s'");
    }

    #[test]
    fn a_clip_is_an_animation_of_frames_of_one_size() {
        let mut clip = Clip::new();
        for (shade, width) in [(10, 2), (20, 2), (30, 3)] {
            clip.push(Picture { size: [width, 1], bytes: vec![shade; 4 * width as usize] });
        }
        let path = std::env::temp_dir().join(format!("umbragraph-view-clip-{}.png", std::process::id()));
        clip.write(&path).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let reader = png::Decoder::new(file).read_info().unwrap();
        assert_eq!(reader.info().animation_control.map(|one| one.num_frames), Some(2));
        std::fs::remove_file(path).unwrap();
        assert!(Clip::new().write(Path::new("x")).is_err());
    }
}
