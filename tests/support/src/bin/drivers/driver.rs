//! The drivers of a machine: how the command is told to draw with each, and where they are looked for.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A graphics driver, and the environment variables that select it.
pub(crate) struct Driver {
    /// The driver's name, which heads its section of the table.
    pub(crate) name: String,
    variables: Vec<(&'static str, String)>,
}

/// Folders in which Chromium and Chrome store SwiftShader.
const SWIFTSHADER: [&str; 4] =
    ["/usr/lib/chromium", "/usr/lib/chromium-browser", "/opt/google/chrome", "/opt/chromium"];

/// The possible manifests of Mesa's OpenGL driver. A machine has at most one of them.
const MESA_EGL: [&str; 2] =
    ["/usr/share/glvnd/egl_vendor.d/50_mesa.json", "/etc/glvnd/egl_vendor.d/50_mesa.json"];

/// Environment variables that would select another driver, and are therefore removed.
const CHOOSING: [&str; 9] = [
    "MESA_GL_VERSION_OVERRIDE",
    "MESA_GLES_VERSION_OVERRIDE",
    "UMBRAGRAPH_ADAPTER",
    "VK_DRIVER_FILES",
    "VK_ICD_FILENAMES",
    "WGPU_ADAPTER_NAME",
    "WGPU_BACKEND",
    "WGPU_POWER_PREF",
    "WGPU_VALIDATION",
];

impl Driver {
    /// Returns all known drivers whose files exist, the reference driver lavapipe first.
    pub(crate) fn all(program: &Path, folder: &Path) -> Vec<Self> {
        let vulkan = |manifest: PathBuf| {
            vec![("WGPU_BACKEND", "vulkan".to_owned()), ("VK_DRIVER_FILES", manifest.display().to_string())]
        };
        let opengl = |desktop: Option<&str>, es: Option<&str>| {
            let versions = [("MESA_GL_VERSION_OVERRIDE", desktop), ("MESA_GLES_VERSION_OVERRIDE", es)];
            let versions = versions.into_iter().filter_map(|(name, value)| Some((name, value?.to_owned())));
            let mesa = MESA_EGL.iter().find(|file| Path::new(file).exists());
            let mesa = mesa.map(|file| ("__EGL_VENDOR_LIBRARY_FILENAMES", (*file).to_owned()));
            std::iter::once(("WGPU_BACKEND", "gl".to_owned())).chain(mesa).chain(versions).collect()
        };
        let new = |name: &str, variables| Self { name: name.to_owned(), variables };
        let mut all = Vec::new();
        let lavapipe = manifest(Path::new("/usr/share/vulkan/icd.d"), "lvp_icd");
        all.extend(lavapipe.map(|file| new("lavapipe", vulkan(file))));
        let mut swiftshader =
            SWIFTSHADER.iter().filter_map(|folder| manifest(Path::new(folder), "vk_swiftshader_icd"));
        all.extend(swiftshader.next().map(|file| new("SwiftShader", vulkan(file))));
        all.push(new("OpenGL", opengl(None, None)));
        // Mesa gives an older version where it is told to.
        all.push(new("OpenGL ES 3.1", opengl(Some("3.1"), Some("3.1"))));
        all.push(new("OpenGL ES 3.0", opengl(Some("2.1"), Some("3.0"))));
        all.extend(Self::gpus(program, folder));
        all
    }

    /// Returns the adapters that are no software renderers, by their names. OpenGL does not report the kind of all of
    /// them.
    fn gpus(program: &Path, folder: &Path) -> Vec<Self> {
        let usual = Self { name: "all".to_owned(), variables: Vec::new() };
        let gpus = usual.adapters(program, folder).into_iter().filter(|adapter| adapter.kind != "Cpu");
        gpus.map(|Adapter { name, .. }| Self { variables: vec![("WGPU_ADAPTER_NAME", name.clone())], name })
            .collect()
    }

    /// Returns the command with the environment that selects this driver.
    pub(crate) fn command(&self, program: &Path) -> Command {
        let mut command = Command::new(program);
        for name in CHOOSING {
            command.env_remove(name);
        }
        command.env("WGPU_VALIDATION", "0").envs(self.variables.iter().map(|(name, value)| (name, value)));
        command
    }

    /// Returns the adapter of this driver; `None` if it has none.
    pub(crate) fn adapter(&self, program: &Path, folder: &Path) -> Option<Adapter> {
        self.adapters(program, folder).into_iter().next()
    }

    /// Returns the adapters of this driver. The list is cached in a folder, since creating it takes seconds.
    fn adapters(&self, program: &Path, folder: &Path) -> Vec<Adapter> {
        let file = folder.join(format!("{}_adapters.json", self.name.replace([' ', '/'], "_")));
        let bytes = std::fs::read(&file).ok().or_else(|| {
            let output = self.command(program).args(["adapters", "--format", "json"]).output().ok()?;
            let _ = std::fs::write(&file, &output.stdout);
            Some(output.stdout)
        });
        let list: Option<serde_json::Value> = bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok());
        let adapters = list.as_ref().and_then(|list| list.get("adapters")?.as_array());
        let described = |one: &serde_json::Value| {
            let text =
                |key: &str| one.get(key).and_then(|value| value.as_str()).unwrap_or_default().to_owned();
            let lacking = one.get("lacking").and_then(|list| list.as_array()).into_iter().flatten();
            let lacking = lacking.filter_map(|part| part.as_str().map(str::to_owned)).collect();
            Adapter { name: text("name"), kind: text("kind"), driver: text("driver"), lacking }
        };
        adapters.into_iter().flatten().map(described).collect()
    }
}

/// The description of an adapter by `umbragraph adapters`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Adapter {
    pub(crate) name: String,
    kind: String,
    pub(crate) driver: String,
    /// The parts of WebGPU's core mode that the adapter lacks.
    pub(crate) lacking: Vec<String>,
}

/// Returns the first manifest of a folder whose file name has the given prefix.
fn manifest(folder: &Path, begins: &str) -> Option<PathBuf> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).collect();
    files.sort();
    files.into_iter().find(|path| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        name.starts_with(begins) && name.ends_with(".json")
    })
}
