//! Searches Linux for a Vulkan driver that can work, without loading one.
//!
//! The search follows the Vulkan loader's own: JSON manifests in fixed folders and in the folders of the XDG variables,
//! or only the ones that `VK_DRIVER_FILES` (formerly `VK_ICD_FILENAMES`) names. A manifest alone proves little: its
//! library may be missing, or the machine may lack its hardware. So a driver counts if the library of its manifest
//! exists, and it needs no hardware or a GPU device node exists. The loader, `libvulkan.so.1`, must exist too.
//!
//! All files are looked up below a root folder and all variables through a function, so that tests can replace them.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The file system and environment variables in which to search for a Vulkan driver.
pub(crate) struct Machine<'a> {
    pub(crate) root: &'a Path,
    pub(crate) variable: &'a dyn Fn(&str) -> Option<OsString>,
}

/// The result of the search for a Vulkan driver.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum SearchResult {
    /// A usable driver, by the path of its manifest.
    Driver(PathBuf),
    /// A variable restricts the search to drivers that cannot work; installing another driver would not help.
    Restricted { variable: &'static str, value: String },
    /// A driver is installed, but the Vulkan loader library is not.
    NoLoader,
    /// No driver can work; contains the rejected manifests, each with the reason.
    NoDriver(Vec<String>),
}

const RESTRICTIONS: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];
const FIXED_FOLDERS: [&str; 6] = [
    "/usr/share/vulkan",
    "/etc/vulkan",
    "/usr/local/share/vulkan",
    "/usr/local/etc/vulkan",
    "/etc/xdg/vulkan",
    "/run/opengl-driver/share/vulkan",
];
const LIBRARY_FOLDERS: [&str; 8] = [
    "/usr/lib",
    "/usr/lib64",
    "/lib",
    "/lib64",
    "/usr/local/lib",
    "/usr/local/lib64",
    "/usr/lib/wsl/lib",
    "/run/opengl-driver/lib",
];
const LOADERS: [&str; 2] = ["libvulkan.so.1", "libvulkan.so"];
const SOFTWARE_DRIVERS: [&str; 3] = ["lvp_icd", "vk_swiftshader", "swrast"];

impl Machine<'_> {
    /// Searches for a usable driver.
    pub(crate) fn search(&self) -> SearchResult {
        let restriction = RESTRICTIONS
            .into_iter()
            .find_map(|name| Some((name, (self.variable)(name).filter(|value| !value.is_empty())?)));
        let manifests = match &restriction {
            Some((_, value)) => self.manifests_of(std::env::split_paths(value)),
            None => self.manifests_of(self.manifest_folders()),
        };
        let mut passed_over = Vec::new();
        for manifest in manifests {
            match self.obstacle(&manifest) {
                None if self.has_loader() => return SearchResult::Driver(manifest),
                None => return SearchResult::NoLoader,
                Some(obstacle) => passed_over.push(format!("{}: {obstacle}", manifest.display())),
            }
        }
        match restriction {
            Some((variable, value)) => {
                SearchResult::Restricted { variable, value: value.to_string_lossy().into_owned() }
            }
            None => SearchResult::NoDriver(passed_over),
        }
    }

    /// Returns a path of the machine below the root folder.
    fn at(&self, path: impl AsRef<Path>) -> PathBuf {
        let path = path.as_ref();
        self.root.join(path.strip_prefix("/").unwrap_or(path))
    }

    /// The names of the entries of a folder; empty if it does not exist.
    fn names_in(&self, folder: &Path) -> impl Iterator<Item = OsString> + use<> {
        let entries = std::fs::read_dir(self.at(folder)).into_iter().flatten().flatten();
        entries.map(|entry| entry.file_name())
    }

    fn manifest_folders(&self) -> Vec<PathBuf> {
        let mut folders: Vec<PathBuf> = FIXED_FOLDERS.iter().map(PathBuf::from).collect();
        for name in ["XDG_CONFIG_HOME", "XDG_CONFIG_DIRS", "XDG_DATA_HOME", "XDG_DATA_DIRS"] {
            if let Some(value) = (self.variable)(name) {
                folders.extend(std::env::split_paths(&value).map(|folder| folder.join("vulkan")));
            }
        }
        if let Some(home) = (self.variable)("HOME") {
            folders.push(Path::new(&home).join(".config/vulkan"));
            folders.push(Path::new(&home).join(".local/share/vulkan"));
        }
        folders.into_iter().map(|folder| folder.join("icd.d")).collect()
    }

    /// Returns the manifests among the given files and folders, as paths of the machine, sorted and without duplicates.
    fn manifests_of(&self, places: impl IntoIterator<Item = PathBuf>) -> Vec<PathBuf> {
        let mut manifests = Vec::new();
        for place in places {
            if self.at(&place).is_file() {
                manifests.push(place);
                continue;
            }
            let inside = self.names_in(&place).map(|name| place.join(name));
            manifests.extend(inside.filter(|path| path.extension().is_some_and(|one| one == "json")));
        }
        manifests.sort();
        manifests.dedup();
        manifests
    }

    /// Returns the reason why the driver of a manifest cannot work; `None` if it can.
    fn obstacle(&self, manifest: &Path) -> Option<String> {
        let text = match std::fs::read_to_string(self.at(manifest)) {
            Ok(text) => text,
            Err(error) => return Some(error.to_string()),
        };
        let Some(library) = library_path(&text) else {
            return Some("it names no library".to_owned());
        };
        if !self.has_library(manifest, &library) {
            return Some(format!("its library {library} is missing"));
        }
        let name = manifest.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let software = SOFTWARE_DRIVERS.iter().any(|driver| name.contains(driver));
        (!software && !self.has_graphics_processor())
            .then(|| "it needs a graphics processor, and there is none".to_owned())
    }

    /// Returns `true` if the library exists. As in the loader, a path with a slash is relative to the manifest's
    /// folder, any other to the system's library folders.
    fn has_library(&self, manifest: &Path, library: &str) -> bool {
        if library.contains('/') {
            let folder = manifest.parent().unwrap_or(Path::new("/"));
            return self.at(folder.join(library)).exists();
        }
        self.library_folders().iter().any(|folder| self.at(folder).join(library).exists())
    }

    fn has_loader(&self) -> bool {
        let folders = self.library_folders();
        LOADERS.iter().any(|loader| folders.iter().any(|folder| self.at(folder).join(loader).exists()))
    }

    fn library_folders(&self) -> Vec<PathBuf> {
        let mut folders: Vec<PathBuf> = LIBRARY_FOLDERS.iter().map(PathBuf::from).collect();
        if let Some(value) = (self.variable)("LD_LIBRARY_PATH") {
            folders.extend(std::env::split_paths(&value));
        }
        // Debian and its descendants keep libraries in a folder for each architecture.
        for parent in ["/usr/lib", "/lib"] {
            let of_architectures =
                self.names_in(Path::new(parent)).filter(|name| name.to_string_lossy().contains("-linux-"));
            folders.extend(of_architectures.map(|name| Path::new(parent).join(name)));
        }
        folders
    }

    fn has_graphics_processor(&self) -> bool {
        let fixed = ["/dev/nvidia0", "/dev/dxg", "/dev/kgsl-3d0", "/dev/mali0"];
        let is_render_node = |name: OsString| name.to_string_lossy().starts_with("renderD");
        self.names_in(Path::new("/dev/dri")).any(is_render_node)
            || fixed.iter().any(|node| self.at(node).exists())
    }
}

/// Returns the value of `library_path` in a manifest; `None` if it is missing.
fn library_path(manifest: &str) -> Option<String> {
    let (_, rest) = manifest.split_once("\"library_path\"")?;
    let rest = rest.trim_start().strip_prefix(':')?.trim_start().strip_prefix('"')?;
    let (path, _) = rest.split_once('"')?;
    Some(path.replace("\\/", "/"))
}

#[cfg(test)]
mod tests;
