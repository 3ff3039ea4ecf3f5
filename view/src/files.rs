//! Files of the window beside those that [`umbragraph::low_level::files`] writes: texts that are read, and names that
//! are not taken yet.

use std::path::{Path, PathBuf};

use umbragraph::low_level::compose::read_source;
use umbragraph::low_level::source::Sources;

/// Reads the text of a regular file, without a byte order mark.
///
/// # Errors
/// An error message if the file cannot be read, is too large or is not UTF-8.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    let mut sources = Sources::new();
    let file = read_source(path, &mut sources).map_err(|found| found.message)?;
    Ok(sources.get(file).map(|file| file.text().to_string()).unwrap_or_default())
}

/// The first of the paths `base-001.end`, `base-002.end` and so on at which no file exists.
pub(crate) fn free(folder: &Path, base: &str, end: &str) -> PathBuf {
    free_or(folder, base, end, |_| false)
}

/// The first of the paths `base-001.end` and so on at which no file exists, or whose file already has the contents
/// `text`.
pub(crate) fn free_or_same(folder: &Path, base: &str, end: &str, text: &str) -> PathBuf {
    free_or(folder, base, end, |path| read(path).is_ok_and(|present| present == text))
}

fn free_or(folder: &Path, base: &str, end: &str, is_usable: impl Fn(&Path) -> bool) -> PathBuf {
    let name = |number: u32| folder.join(format!("{base}-{number:03}.{end}"));
    (1..10_000).map(name).find(|path| !path.exists() || is_usable(path)).unwrap_or_else(|| name(10_000))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_free_or_its_file_has_the_text() {
        let folder = std::env::temp_dir().join(format!("umbragraph-view-files-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = free(&folder, "file", "json");
        std::fs::write(&path, "one").unwrap();
        assert_eq!(free(&folder, "file", "json"), folder.join("file-002.json"));
        assert_eq!(free_or_same(&folder, "file", "json", "one"), path);
        assert_eq!(free_or_same(&folder, "file", "json", "two"), folder.join("file-002.json"));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
