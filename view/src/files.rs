//! Files that the window writes: whole or not at all, and never over one that somebody changed meanwhile.

use std::path::{Path, PathBuf};

use umbragraph::low_level::compose::read_bytes;
use umbragraph::low_level::source::MAX_FILE_BYTES;

/// Writes a file: to one beside it, which is then renamed.
///
/// # Errors
/// A folder that is not there or cannot be written to, in words.
pub(crate) fn replace(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("\"{}\" cannot be written: {error}", path.display());
    let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let mut beside = place.clone().into_os_string();
    beside.push(format!(".{}.part", std::process::id()));
    let beside = PathBuf::from(beside);
    let written = std::fs::write(&beside, contents).and_then(|()| {
        if let Ok(known) = place.metadata() {
            std::fs::set_permissions(&beside, known.permissions())?;
        }
        std::fs::rename(&beside, &place)
    });
    written.map_err(|error| {
        let _ = std::fs::remove_file(&beside);
        failed(error)
    })
}

/// The text of a regular file: a pipe may never end.
///
/// # Errors
/// A file that cannot be read, is too large or is no UTF-8, in words.
pub(crate) fn read(path: &Path) -> Result<String, String> {
    let failed = |reason: &str| format!("the file \"{}\" cannot be read: {reason}", path.display());
    let bytes = read_bytes(path, MAX_FILE_BYTES as u64).map_err(|error| failed(&error.to_string()))?;
    let bytes = bytes.ok_or_else(|| failed("it is larger than 64 MiB"))?;
    String::from_utf8(bytes).map_err(|_| failed("it is no UTF-8"))
}

/// Writes a text over one that is known, whose mark of byte order stays.
///
/// # Errors
/// A file that has another text by now, or cannot be written, in words.
pub(crate) fn replace_if(path: &Path, known: &str, text: &str) -> Result<(), String> {
    let present = read(path)?;
    let (mark, rest) = match present.strip_prefix('\u{feff}') {
        Some(rest) => ("\u{feff}", rest),
        None => ("", present.as_str()),
    };
    if rest != known {
        return Err(format!("\"{}\" was changed meanwhile; nothing is written", path.display()));
    }
    replace(path, format!("{mark}{text}"))
}

/// The first name of a row, `base-001.end` and so on, that no file has.
pub(crate) fn free(folder: &Path, base: &str, end: &str) -> PathBuf {
    let name = |number: u32| folder.join(format!("{base}-{number:03}.{end}"));
    (1..10_000).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(10_000))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_was_changed_meanwhile_is_left_alone() {
        let folder = std::env::temp_dir().join(format!("umbragraph-view-files-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = free(&folder, "file", "json");
        replace(&path, "\u{feff}one").unwrap();
        assert!(replace_if(&path, "two", "three").is_err());
        replace_if(&path, "one", "two").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "\u{feff}two");
        assert_eq!(free(&folder, "file", "json"), folder.join("file-002.json"));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
