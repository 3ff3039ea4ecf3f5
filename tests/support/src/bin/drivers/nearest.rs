//! A scene whose textures are sampled at the nearest texel of the largest level, so that no driver filters them.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use umbragraph_test_support::glb::container;

/// `NEAREST` of OpenGL, as glTF has it.
const NEAREST: u32 = 9728;

/// The file of such a scene in a folder.
///
/// # Errors
/// A file that cannot be read, written, or is no glTF binary.
pub(crate) fn scene(path: &Path, folder: &Path) -> Result<PathBuf, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", path.display());
    let to = folder.join(path.file_name().unwrap_or_default());
    if !to.exists() {
        let bytes = std::fs::read(path).map_err(failed)?;
        let bytes = with_nearest(&bytes).ok_or_else(|| format!("{} is no glTF binary", path.display()))?;
        // Several threads may write it: each a file of its own, and the last that is renamed stays.
        let own = folder.join(format!("{:?}.glb", std::thread::current().id()));
        std::fs::write(&own, bytes).and_then(|()| std::fs::rename(&own, &to)).map_err(failed)?;
    }
    Ok(to)
}

fn with_nearest(bytes: &[u8]) -> Option<Vec<u8>> {
    let length = u32::from_le_bytes(bytes.get(12..16)?.try_into().ok()?) as usize;
    let mut document: Value = serde_json::from_slice(bytes.get(20..20 + length)?).ok()?;
    let rest = bytes.get(20 + length..)?;
    for sampler in document.get_mut("samplers").and_then(Value::as_array_mut).into_iter().flatten() {
        sampler["magFilter"] = json!(NEAREST);
        sampler["minFilter"] = json!(NEAREST);
    }
    Some(container(&document.to_string(), rest.get(8..)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samplers_become_nearest_and_the_rest_stays() {
        let document = r#"{"samplers":[{"minFilter":9987}],"textures":[]}"#;
        let bytes = container(document, &[1, 2, 3, 4]);
        let changed = with_nearest(&bytes).unwrap();
        let text = String::from_utf8_lossy(&changed);
        assert!(text.contains(r#""minFilter":9728"#) && text.contains(r#""magFilter":9728"#), "{text}");
        assert_eq!(changed[8..12], (changed.len() as u32).to_le_bytes());
        assert!(changed.ends_with(&[1, 2, 3, 4]));
        assert_eq!(with_nearest(b"no scene"), None);
    }
}
