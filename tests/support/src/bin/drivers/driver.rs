//! The drivers of a machine: how the command is told to draw with each, and where they are looked for.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A driver, and the variables that choose it.
pub(crate) struct Driver {
    /// The name of its column.
    pub(crate) name: &'static str,
    variables: Vec<(&'static str, String)>,
}

/// Folders in which Chromium and Chrome keep SwiftShader.
const SWIFTSHADER: [&str; 4] =
    ["/usr/lib/chromium", "/usr/lib/chromium-browser", "/opt/google/chrome", "/opt/chromium"];

/// Variables that would choose something else.
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
    /// All drivers that are known, the reference first; without the ones whose files are not there.
    pub(crate) fn all() -> Vec<Self> {
        let vulkan = |manifest: PathBuf| {
            vec![("WGPU_BACKEND", "vulkan".to_owned()), ("VK_DRIVER_FILES", manifest.display().to_string())]
        };
        let opengl = |desktop: Option<&str>, es: Option<&str>| {
            let versions = [("MESA_GL_VERSION_OVERRIDE", desktop), ("MESA_GLES_VERSION_OVERRIDE", es)];
            let versions = versions.into_iter().filter_map(|(name, value)| Some((name, value?.to_owned())));
            std::iter::once(("WGPU_BACKEND", "gl".to_owned())).chain(versions).collect()
        };
        let mut all = Vec::new();
        let lavapipe = manifest(Path::new("/usr/share/vulkan/icd.d"), "lvp_icd");
        all.extend(lavapipe.map(|file| Self { name: "lavapipe", variables: vulkan(file) }));
        let mut swiftshader =
            SWIFTSHADER.iter().filter_map(|folder| manifest(Path::new(folder), "vk_swiftshader_icd"));
        all.extend(swiftshader.next().map(|file| Self { name: "SwiftShader", variables: vulkan(file) }));
        all.push(Self { name: "OpenGL", variables: opengl(None, None) });
        // Mesa gives an older version where it is told to.
        all.push(Self { name: "OpenGL ES 3.1", variables: opengl(Some("3.1"), Some("3.1")) });
        all.push(Self { name: "OpenGL ES 3.0", variables: opengl(Some("2.1"), Some("3.0")) });
        all
    }

    /// The command, told to draw with this driver.
    pub(crate) fn command(&self, program: &Path) -> Command {
        let mut command = Command::new(program);
        for name in CHOOSING {
            command.env_remove(name);
        }
        command.env("WGPU_VALIDATION", "0").envs(self.variables.iter().map(|(name, value)| (name, value)));
        command
    }

    /// The name of its adapter, and the driver's own words; `None` where it gives no adapter.
    pub(crate) fn adapter(&self, program: &Path) -> Option<(String, String)> {
        let output = self.command(program).args(["adapters", "--format", "json"]).output().ok()?;
        let list: serde_json::Value = serde_json::from_slice(&output.stdout).ok()?;
        let first = list.get("adapters")?.get(0)?;
        let text = |key: &str| first.get(key).and_then(|value| value.as_str()).map(str::to_owned);
        Some((text("name")?, text("driver").unwrap_or_default()))
    }
}

/// The first manifest of a folder whose name begins so.
fn manifest(folder: &Path, begins: &str) -> Option<PathBuf> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).collect();
    files.sort();
    files.into_iter().find(|path| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        name.starts_with(begins) && name.ends_with(".json")
    })
}
