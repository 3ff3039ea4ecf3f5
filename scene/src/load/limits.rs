//! Limits on the size of a scene.
//!
//! Loading takes memory in proportion to the size of the files, and a few GiB at most. Objects are counted before they
//! are parsed. All decoded data is charged to one budget before it is allocated; each byte that is read raises the
//! budget.

/// The largest scene, buffer or image file, in bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// The largest JSON document, in bytes.
pub const MAX_JSON_BYTES: usize = 256 << 20;

/// The maximum number of objects (opening braces) in the JSON document: each takes hundreds of bytes once it is parsed.
pub const MAX_OBJECTS: usize = 1 << 20;

/// The objects of any document, and the bytes of JSON for each further one: one that says anything has as many.
pub const FREE_OBJECTS: usize = 1 << 12;
/// The fewest bytes of JSON for each object beyond [`FREE_OBJECTS`].
pub const BYTES_PER_OBJECT: usize = 20;

/// The decoded bytes that any scene may take.
pub const FREE_DECODED_BYTES: u64 = 64 << 20;
/// The additional decoded bytes for each byte that is read: primitives share vertices, and zeros need no bytes.
pub const DECODED_PER_BYTE: u64 = 1 << 6;
/// The additional decoded bytes for each byte of an image, which may have one color; bytes that several images share
/// count once.
pub const DECODED_PER_IMAGE_BYTE: u64 = 1 << 12;

/// The maximum number of bytes that buffers, vertices, indices, key frames and texels may take together once they are
/// decoded.
pub const MAX_DECODED_BYTES: u64 = 3 << 30;

/// The maximum number of texels along one side of an image.
pub const MAX_IMAGE_SIDE: u32 = 16_384;

/// The maximum number of texels of an image. While it is decoded it may take some 16 bytes for each beside what is
/// charged.
pub const MAX_IMAGE_TEXELS: u64 = 1 << 27;

/// The maximum number of draws: primitives of shown nodes.
pub const MAX_DRAWS: usize = 1 << 20;

/// The farthest from the origin that geometry may lie, in metres.
pub const MAX_DISTANCE: f64 = 1e9;

/// The maximum number of diagnostics that are listed for one file.
pub const MAX_DIAGNOSTICS: usize = 200;
