//! A folder with a pipeline, a watcher of it, and frames.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use umbragraph::{Frame, Library, Options, Renderer, Watcher};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::scratch::ScratchFolder;

use crate::common::gpu::{empty_frame, read};

pub(crate) const SIZE: [u32; 2] = [24, 16];
/// Time for what should be shown to be shown.
const PATIENCE: Duration = Duration::from_secs(30);

/// A pipeline that fills the picture in a pass of its own and one of a subgraph, with values of a parameter file.
pub(crate) const FILES: &[(&str, &str)] = &[
    (
        "frame.json",
        r#"{
  "format": 1,
  "name": "watched",
  "include": ["values.json"],
  "resources": {
    "color": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "fill": { "fullscreen": { "shader": "fill.wgsl.jinja", "color": [{ "to": "&color" }], "axes": { "wide": true },
      "bind": { "params": { "values": { "level": "=level * 0.5" } } } } },
    "tinted": { "use": "tint.json", "with": { "image": "&color", "result": "&target" } }
  }
}
"#,
    ),
    (
        "values.json",
        r#"{
  "parameters": {
    "level": { "type": "f32", "default": 0.5, "min": 0.0, "max": 1.0, "unit": "1", "description": "The level." }
  }
}
"#,
    ),
    (
        "tint.json",
        r#"{
  "format": 1,
  "name": "tint",
  "inputs": { "image": "what is tinted", "result": "where it goes" },
  "passes": {
    "over": { "fullscreen": { "shader": "tint.wgsl.jinja", "bind": { "source": "&image" }, "color": [{ "to": "&result" }] } }
  }
}
"#,
    ),
    ("look.json", "{ \"format\": 1, \"parameters\": { \"level\": 0.75 } }\n"),
    (
        "shaders/fill.wgsl.jinja",
        r#"{% include "corner.wgsl.jinja" %}
struct Params { @align(16) level: f32 }
@group(0) @binding(0) var<uniform> params: Params;

@fragment fn fill(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    {% if wide %}
    let across = at.x / 24.0;
    {% else %}
    let across = 1.0;
    {% endif %}
    return vec4<f32>(params.level, across, 0.25, 1.0);
}
"#,
    ),
    ("shaders/fill.axes.json", "{ \"axes\": { \"wide\": { \"type\": \"bool\", \"default\": false } } }\n"),
    (
        "shaders/corner.wgsl.jinja",
        r#"@vertex fn corner(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(at & 1u) * 4.0 - 1.0, f32(at >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}
"#,
    ),
    (
        "shaders/tint.wgsl.jinja",
        r#"{% include "corner.wgsl.jinja" %}
@group(0) @binding(0) var source: texture_2d<f32>;

@fragment fn tint(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return textureLoad(source, vec2<i32>(at.xy), 0) * vec4<f32>(1.0, 0.75, 1.0, 1.0);
}
"#,
    ),
];

/// The ways in which editors write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// Over the old text.
    InPlace,
    /// To another file, which is renamed.
    Rename,
    /// After the old file is deleted.
    Again,
    /// In two pieces, with a part of the text on the disk in between.
    Pieces,
}

pub(crate) const WAYS: [Way; 4] = [Way::InPlace, Way::Rename, Way::Again, Way::Pieces];

/// A folder, a watcher and a renderer.
pub(crate) struct Stage {
    gpu: Gpu,
    pub(crate) folder: ScratchFolder,
    pub(crate) watcher: Watcher,
    pub(crate) renderer: Renderer,
    target: wgpu::Texture,
}

impl Stage {
    /// Nothing where there is no device.
    pub(crate) fn new(test: &str, files: &[(&str, &str)]) -> Option<Self> {
        let gpu = gpu::device()?;
        let folder = ScratchFolder::new(test);
        for (name, text) in files {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let watcher = Watcher::new(library(&folder), folder.join("frame.json")).unwrap();
        let watcher = watcher.parameters([folder.join("look.json")].into_iter().filter(|path| path.exists()));
        let renderer = Renderer::new(&gpu.device, &gpu.queue);
        let target = gpu.target(SIZE, wgpu::TextureFormat::Rgba8Unorm);
        Some(Self { gpu, folder, watcher, renderer, target })
    }

    pub(crate) fn write(&self, name: &str, text: &str, way: Way) {
        let path = self.folder.join(name);
        match way {
            Way::InPlace => std::fs::write(path, text).unwrap(),
            Way::Rename => {
                let other = path.with_extension("tmp~");
                std::fs::write(&other, text).unwrap();
                std::fs::rename(other, path).unwrap();
            }
            Way::Again => {
                std::fs::remove_file(&path).unwrap();
                std::fs::write(path, text).unwrap();
            }
            Way::Pieces => {
                let half = (0..=text.len() / 2).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
                std::fs::write(&path, &text[..half]).unwrap();
                std::thread::sleep(Duration::from_millis(5));
                std::fs::write(path, text).unwrap();
            }
        }
    }

    /// The picture of the next frame; nothing before the first plan.
    pub(crate) fn frame(&mut self) -> Option<Picture> {
        let options = Options::new(self.target.width(), self.target.height());
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("target", &self.target)];
        let input = empty_frame();
        let frame = Frame::new(&input).imports(&imports);
        let drawn = self.renderer.record_watched(&mut self.watcher, &options, &mut encoder, &frame);
        let is_drawn = drawn.unwrap_or_else(|error| panic!("{error}"));
        self.gpu.queue.submit([encoder.finish()]);
        is_drawn.then(|| read(&self.gpu, &self.target))
    }

    /// Gives the frames to come a target of another size.
    pub(crate) fn resize(&mut self, size: [u32; 2]) {
        self.target = self.gpu.target(size, wgpu::TextureFormat::Rgba8Unorm);
    }

    /// Draws frames until one is as it should be; that one.
    #[track_caller]
    pub(crate) fn until(&mut self, what: &str, is_right: impl Fn(&Watcher, &Picture) -> bool) -> Picture {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            if let Some(picture) = self.frame()
                && is_right(&self.watcher, &picture)
            {
                return picture;
            }
            std::thread::sleep(Duration::from_millis(4));
        }
        let error = self.watcher.error().map(ToString::to_string);
        panic!("not {what} after {PATIENCE:?}: {}", error.unwrap_or_else(|| "without an error".to_owned()));
    }

    /// The picture of a fresh start with the files as they are, or why there is none.
    pub(crate) fn fresh(&self) -> Result<Picture, String> {
        let mut watcher = Watcher::new(library(&self.folder), self.folder.join("frame.json")).unwrap();
        watcher =
            watcher.parameters([self.folder.join("look.json")].into_iter().filter(|path| path.exists()));
        let target = self.gpu.target(SIZE, wgpu::TextureFormat::Rgba8Unorm);
        let mut renderer = Renderer::new(&self.gpu.device, &self.gpu.queue);
        let input = empty_frame();
        let imports = [("target", &target)];
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            let mut encoder =
                self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let frame = Frame::new(&input).imports(&imports);
            let options = Options::new(SIZE[0], SIZE[1]);
            let drawn = renderer.record_watched(&mut watcher, &options, &mut encoder, &frame);
            if drawn.map_err(|error| error.to_string())? {
                self.gpu.queue.submit([encoder.finish()]);
                return Ok(read(&self.gpu, &target));
            }
            if let Some(error) = watcher.error() {
                return Err(error.to_string());
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        Err("nothing happens".to_owned())
    }
}

/// The texts of the files, by name.
pub(crate) fn texts() -> BTreeMap<&'static str, &'static str> {
    FILES.iter().copied().collect()
}

fn library(folder: &ScratchFolder) -> Library {
    let shaders: PathBuf = folder.join("shaders");
    let library = Library::new();
    if shaders.is_dir() { library.templates(shaders) } else { library }
}
