//! How large a scene may be.
//!
//! Loading a file of the largest size allowed takes a few GiB at most, whatever the file says: all that is decoded is
//! charged to one budget before it is allocated.

/// The largest scene, buffer or image file, in bytes.
pub const MAXIMUM_FILE_BYTES: u64 = 1 << 30;

/// The largest JSON document, in bytes.
pub const MAXIMUM_JSON_BYTES: usize = 256 << 20;

/// The most objects (opening braces) in the JSON document: each takes hundreds of bytes once it is parsed.
pub const MAXIMUM_OBJECTS: usize = 1 << 20;

/// The most bytes that buffers, vertices, indices, key frames and texels may take together once they are decoded.
pub const MAXIMUM_DECODED_BYTES: u64 = 3 << 30;

/// The most texels along one side of an image.
pub const MAXIMUM_IMAGE_SIDE: u32 = 16_384;

/// The most draws: primitives of shown nodes.
pub const MAXIMUM_DRAWS: usize = 1 << 20;

/// The farthest from the origin that geometry may lie, in metres.
pub const MAXIMUM_DISTANCE: f64 = 1e9;

/// The most findings that are listed for one file.
pub const MAXIMUM_FINDINGS: usize = 200;
