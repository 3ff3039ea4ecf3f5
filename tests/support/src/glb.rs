//! glTF binaries of documents that tests write themselves.

/// Returns the bytes of a binary glTF file with a JSON document and one buffer.
#[must_use]
pub fn container(document: &str, buffer: &[u8]) -> Vec<u8> {
    let (mut json, mut binary) = (document.as_bytes().to_vec(), buffer.to_vec());
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + binary.len();
    let mut bytes = b"glTF".to_vec();
    for word in [2, total as u32, json.len() as u32] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}
