//! The search on machines that are folders.

use super::*;

/// A temporary root folder for one test.
struct Root(PathBuf);

impl Root {
    fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("xtask-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn with(self, path: &str, text: &str) -> Self {
        let path = self.0.join(path.trim_start_matches('/'));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
        self
    }

    /// Adds a manifest and the library that the manifest names.
    fn with_driver(self, manifest: &str, library: &str) -> Self {
        let text = format!(r#"{{ "ICD": {{ "api_version": "1.3", "library_path": "{library}" }} }}"#);
        self.with(library, "").with(manifest, &text)
    }

    fn with_loader(self) -> Self {
        self.with("/usr/lib/x86_64-linux-gnu/libvulkan.so.1", "")
    }

    fn search(&self, variables: &[(&str, &str)]) -> SearchResult {
        let variable = |name: &str| {
            variables.iter().find(|(candidate, _)| *candidate == name).map(|(_, value)| OsString::from(value))
        };
        Machine { root: &self.0, variable: &variable }.search()
    }
}

impl Drop for Root {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const LAVAPIPE: &str = "/usr/share/vulkan/icd.d/lvp_icd.x86_64.json";
const RADEON: &str = "/usr/share/vulkan/icd.d/radeon_icd.x86_64.json";
const LIBRARY: &str = "/usr/lib/x86_64-linux-gnu/libvulkan_some.so";

#[test]
fn a_bare_machine_has_no_driver() {
    let root = Root::new("bare");
    assert_eq!(root.search(&[]), SearchResult::NoDriver(Vec::new()));
}

#[test]
fn a_software_driver_needs_no_hardware() {
    let root = Root::new("software").with_loader().with_driver(LAVAPIPE, LIBRARY);
    assert_eq!(root.search(&[]), SearchResult::Driver(LAVAPIPE.into()));
}

#[test]
fn a_driver_without_the_loader_is_told_apart() {
    let root = Root::new("no-loader").with_driver(LAVAPIPE, LIBRARY);
    assert_eq!(root.search(&[]), SearchResult::NoLoader);
}

#[test]
fn a_hardware_driver_counts_only_with_its_hardware() {
    let root = Root::new("hardware").with_loader().with_driver(RADEON, LIBRARY);
    match root.search(&[]) {
        SearchResult::NoDriver(passed_over) => {
            assert_eq!(passed_over.len(), 1);
            assert!(passed_over[0].contains(RADEON) && passed_over[0].contains("graphics processor"));
        }
        other => panic!("{other:?}"),
    }
    let root = root.with("/dev/dri/renderD128", "");
    assert_eq!(root.search(&[]), SearchResult::Driver(RADEON.into()));
}

#[test]
fn a_manifest_whose_library_is_missing_is_passed_over() {
    let root = Root::new("no-library").with_loader().with_driver(LAVAPIPE, LIBRARY);
    std::fs::remove_file(root.0.join(LIBRARY.trim_start_matches('/'))).unwrap();
    let SearchResult::NoDriver(passed_over) = root.search(&[]) else { panic!() };
    assert!(passed_over[0].contains(LIBRARY), "{passed_over:?}");
}

#[test]
fn a_library_by_its_name_alone_is_sought_where_libraries_are() {
    let manifest = r#"{"ICD":{"library_path":"libvulkan_lvp.so"}}"#;
    let root = Root::new("by-name").with_loader().with(LAVAPIPE, manifest);
    assert!(matches!(root.search(&[]), SearchResult::NoDriver(_)));
    let root = root.with("/opt/mesa/libvulkan_lvp.so", "");
    assert_eq!(root.search(&[("LD_LIBRARY_PATH", "/opt/mesa")]), SearchResult::Driver(LAVAPIPE.into()));
    let root = root.with("/usr/lib64/libvulkan_lvp.so", "");
    assert_eq!(root.search(&[]), SearchResult::Driver(LAVAPIPE.into()));
}

#[test]
fn a_library_relative_to_its_manifest_is_found() {
    let manifest = r#"{"ICD":{"library_path":"../../../lib/libvulkan_lvp.so"}}"#;
    let root = Root::new("relative").with_loader().with("/usr/lib/libvulkan_lvp.so", "");
    let root = root.with(LAVAPIPE, manifest);
    assert_eq!(root.search(&[]), SearchResult::Driver(LAVAPIPE.into()));
}

#[test]
fn the_folders_of_the_environment_are_searched() {
    for (variable, value, folder) in [
        ("XDG_DATA_DIRS", "/nowhere:/opt/share", "/opt/share/vulkan/icd.d"),
        ("XDG_CONFIG_HOME", "/home/me/settings", "/home/me/settings/vulkan/icd.d"),
        ("HOME", "/home/me", "/home/me/.local/share/vulkan/icd.d"),
    ] {
        let manifest = format!("{folder}/lvp_icd.json");
        let root = Root::new(variable).with_loader().with_driver(&manifest, LIBRARY);
        assert!(matches!(root.search(&[]), SearchResult::NoDriver(_)), "{variable}");
        assert_eq!(root.search(&[(variable, value)]), SearchResult::Driver(manifest.into()), "{variable}");
    }
}

#[test]
fn named_drivers_replace_all_others() {
    let root = Root::new("named").with_loader().with_driver(LAVAPIPE, LIBRARY);
    for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        let restricted = SearchResult::Restricted { variable, value: "/none.json".to_owned() };
        assert_eq!(root.search(&[(variable, "/none.json")]), restricted);
        let both = format!("/none.json:{LAVAPIPE}");
        assert_eq!(root.search(&[(variable, &both)]), SearchResult::Driver(LAVAPIPE.into()));
        assert_eq!(root.search(&[(variable, "")]), SearchResult::Driver(LAVAPIPE.into()));
    }
}

#[test]
fn the_library_of_a_manifest_is_read_whatever_its_layout() {
    assert_eq!(library_path(r#"{"ICD":{"library_path":"a.so"}}"#).as_deref(), Some("a.so"));
    let spaced = "{ \"ICD\" : {\n \"library_path\"\n :\t\"\\/usr\\/lib\\/a.so\" } }";
    assert_eq!(library_path(spaced).as_deref(), Some("/usr/lib/a.so"));
    for broken in ["", "{}", r#"{"library_path"}"#, r#"{"library_path": 3}"#, r#"{"library_path": "a"#] {
        assert_eq!(library_path(broken), None, "{broken}");
    }
}
