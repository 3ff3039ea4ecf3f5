//! The bytes of a document's buffers.

use gltf::json::Root;

use super::limits::DECODED_PER_BYTE;
use super::report::Report;
use super::resource::{Resolver, resolve_of};
use crate::codes;

/// Reads the bytes of each buffer, cut to the declared length. Reports an error for a buffer that cannot be read; its
/// entry is `None`.
pub(super) fn read(
    root: &Root,
    binary: Option<&[u8]>,
    resolver: &dyn Resolver,
    report: &mut Report,
) -> Vec<Option<Vec<u8>>> {
    let mut one = |(index, buffer): (usize, &gltf::json::Buffer)| {
        let at = format!("/buffers/{index}");
        let mut bytes = match (&buffer.uri, binary) {
            (Some(uri), _) => {
                let object = format!("buffer {index}");
                let bytes = resolve_of(uri, resolver, codes::MISSING_BUFFER, &object, &at, report)?;
                report.allow(bytes.len(), DECODED_PER_BYTE);
                bytes
            }
            (None, Some(binary)) if index == 0 => binary.to_vec(),
            (None, _) => {
                let message = format!("buffer {index} has no URI, and there is no binary chunk for it");
                return report.reject(
                    codes::MISSING_BUFFER,
                    &at,
                    message,
                    "export the scene as one .glb file",
                );
            }
        };
        let length = buffer.byte_length.0;
        if (bytes.len() as u64) < length {
            return report.reject(
                codes::BUFFER_TOO_SHORT,
                &at,
                format!("buffer {index} should have {length} bytes, but has {}", bytes.len()),
                "the file was probably cut off; copy or export it again",
            );
        }
        bytes.truncate(length as usize);
        report.charge(length, &at).then_some(bytes)
    };
    root.buffers.iter().enumerate().map(&mut one).collect()
}
