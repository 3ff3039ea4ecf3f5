//! Files and texts for others: a screenshot, a clip, a command line that draws the same picture.

use std::path::Path;
use std::time::{Duration, Instant};

use umbragraph::executor::read_bytes;
use umbragraph::low_level::files::replace;
use umbragraph::wgpu;

/// The time between two frames of a clip, 50 ms.
pub(crate) const STEP: Duration = Duration::from_millis(50);

/// The maximum number of frames of a clip.
pub(crate) const MOST: usize = 200;

/// The maximum number of bytes that the frames of a clip take in memory, 1 GiB.
const MOST_BYTES: usize = 1 << 30;

/// A picture with four bytes for each texel: red, green, blue, alpha.
#[derive(Clone)]
pub(crate) struct Picture {
    size: [u32; 2],
    bytes: Vec<u8>,
}

impl Picture {
    /// Reads back a texture with four bytes per texel, after the device has drawn it.
    ///
    /// # Errors
    /// An error message if the device cannot copy the texture.
    pub(crate) fn read(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        texture: &wgpu::Texture,
    ) -> Result<Self, String> {
        let bytes = pollster::block_on(read_bytes(device, queue, texture)).map_err(|found| found.message)?;
        Ok(Self { size: [texture.width(), texture.height()], bytes })
    }

    /// Writes the picture as a PNG file. Returns a notice for the user.
    ///
    /// # Errors
    /// An error message if the file cannot be written.
    pub(crate) fn write(&self, path: &Path) -> Result<String, String> {
        write(path, std::slice::from_ref(self), &[])
    }
}

/// A clip that is being recorded: pictures, each with its time.
///
/// While the animations play, these times are animation times, one step apart, however long a frame takes to draw.
/// While they are paused, these times are the moments at which the frames were drawn.
pub(crate) struct Clip {
    frames: Vec<Picture>,
    /// The times of the frames, in seconds from the first one.
    moments: Vec<f64>,
    /// The animation time of the last frame in seconds, and the moment when it was drawn; `None` before the first
    /// frame.
    last: Option<(f64, Instant)>,
}

impl Clip {
    pub(crate) fn new() -> Self {
        Self { frames: Vec::new(), moments: Vec::new(), last: None }
    }

    pub(crate) fn len(&self) -> usize {
        self.frames.len()
    }

    /// Returns `true` if the clip has no room for another frame.
    pub(crate) fn is_full(&self) -> bool {
        self.len() >= self.room(MOST_BYTES)
    }

    /// The maximum number of frames, of the size of the first one, that take at most `bytes`; at least 1.
    fn room(&self, bytes: usize) -> usize {
        let frame = self.frames.first().map_or(1, |first| first.bytes.len().max(1));
        (bytes / frame).clamp(1, MOST)
    }

    /// The step by which the animation time advances from `time` (in seconds). The step is zero until the last frame of
    /// the clip has that time.
    pub(crate) fn step_after(&self, time: f64) -> Duration {
        if self.last.is_some_and(|(last, _)| last == time) { STEP } else { Duration::ZERO }
    }

    /// Adds a frame with its animation time in seconds. A second frame of the same moment replaces the first. Frames of
    /// another size are ignored.
    pub(crate) fn push(&mut self, picture: Picture, time: f64, is_playing: bool) {
        if self.is_full() || self.frames.first().is_some_and(|first| first.size != picture.size) {
            return;
        }
        let passed = self.last.map_or(0.0, |(last, at)| {
            if is_playing { (time - last).max(0.0) } else { at.elapsed().as_secs_f64() }
        });
        if passed == 0.0 {
            self.frames.pop();
        } else {
            let before = self.moments.last().copied().unwrap_or_default();
            self.moments.push(before + passed);
        }
        if self.moments.is_empty() {
            self.moments.push(0.0);
        }
        self.frames.push(picture);
        self.last = Some((time, Instant::now()));
    }

    /// The display time of each frame, in milliseconds; one step for the last frame.
    fn delays(&self) -> Vec<u16> {
        let end = self.moments.last().map(|last| last + STEP.as_secs_f64());
        let ends = self.moments.iter().copied().skip(1).chain(end);
        let round = |moment: f64| (moment * 1e3).round();
        // Rounded as moments, so that a long clip does not drift.
        let delay =
            |(from, to): (&f64, f64)| (round(to) - round(*from)).clamp(1.0, f64::from(u16::MAX)) as u16;
        self.moments.iter().zip(ends).map(delay).collect()
    }

    /// Writes the clip as an APNG file. Returns a notice for the user.
    ///
    /// # Errors
    /// An error message if the clip has no frame or the file cannot be written.
    pub(crate) fn write(&self, path: &Path) -> Result<String, String> {
        if self.frames.is_empty() {
            return Err("the clip has no frame: nothing was drawn meanwhile".to_owned());
        }
        let said = write(path, &self.frames, &self.delays())?;
        Ok(if self.is_full() {
            format!("{said}; it ended since a clip has at most {MOST} frames and 1 GiB")
        } else {
            said
        })
    }
}

/// Writes pictures of the same size: one as a PNG, several as an APNG with their delays in milliseconds.
fn write(path: &Path, frames: &[Picture], delays: &[u16]) -> Result<String, String> {
    let [width, height] = frames.first().map_or([0; 2], |first| first.size);
    let mut file = Vec::new();
    let mut encoded = || -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(&mut file, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::Fast);
        if frames.len() > 1 {
            encoder.set_animated(frames.len() as u32, 0)?;
        }
        let mut writer = encoder.write_header()?;
        for (at, frame) in frames.iter().enumerate() {
            if let Some(delay) = delays.get(at).filter(|_| frames.len() > 1) {
                writer.set_frame_delay(*delay, 1000)?;
            }
            // A picture is opaque, whatever its alpha is.
            let rgb: Vec<u8> =
                frame.bytes.chunks_exact(4).flat_map(|texel| [texel[0], texel[1], texel[2]]).collect();
            writer.write_image_data(&rgb)?;
        }
        writer.finish()
    };
    encoded().map_err(|error| format!("the picture cannot be written: {error}"))?;
    replace(path, file).map_err(|found| found.message)?;
    let what =
        if frames.len() > 1 { format!("{} frames", frames.len()) } else { format!("{width} × {height}") };
    Ok(format!("{}: {what}", path.display()))
}

/// Quotes a word of a command line if a shell would split or expand it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_=./:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// Joins words into a command line, with quotes for a POSIX shell where needed.
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
    fn a_clip_has_the_delays_of_the_animation() {
        let picture = |shade, width| Picture { size: [width, 1], bytes: vec![shade; 4 * width as usize] };
        let mut clip = Clip::new();
        assert_eq!(clip.step_after(7.0), Duration::ZERO, "no frame yet");
        // The second frame shows the moment of the first, the last has another size.
        for (shade, width, time) in [(5, 2, 7.0), (10, 2, 7.0), (20, 2, 7.05), (30, 2, 7.2), (40, 3, 7.25)] {
            clip.push(picture(shade, width), time, true);
        }
        assert_eq!(clip.step_after(7.2), STEP);
        let path = std::env::temp_dir().join(format!("umbragraph-view-clip-{}.png", std::process::id()));
        clip.write(&path).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        assert_eq!(reader.info().animation_control.map(|one| one.num_frames), Some(3));
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let frames: Vec<_> = (0..3)
            .map(|_| {
                reader.next_frame(&mut bytes).unwrap();
                let control = reader.info().frame_control.unwrap();
                (bytes[0], u32::from(control.delay_num) * 1000 / u32::from(control.delay_den))
            })
            .collect();
        assert_eq!(frames, [(10, 50), (20, 150), (30, 50)]);
        std::fs::remove_file(path).unwrap();
        assert!(Clip::new().write(Path::new("x")).is_err());
    }

    #[test]
    fn a_clip_of_large_frames_has_fewer() {
        let mut clip = Clip::new();
        clip.push(Picture { size: [2, 1], bytes: vec![0; 8] }, 0.0, true);
        assert_eq!([clip.room(1 << 30), clip.room(100), clip.room(1)], [MOST, 12, 1]);
    }

    #[test]
    fn a_clip_of_a_still_animation_has_the_times_of_its_frames() {
        let mut clip = Clip::new();
        for pause in [0, 30] {
            std::thread::sleep(Duration::from_millis(pause));
            clip.push(Picture { size: [1, 1], bytes: vec![0; 4] }, 7.0, false);
        }
        assert!(clip.delays()[0] >= 30, "{:?}", clip.delays());
    }
}
