//! Limits on the size of a scene.
//!
//! Loading takes memory in proportion to the size of the files, and a few GiB at most. Objects are counted before they
//! are parsed. All decoded data is charged to one budget before it is allocated; each byte that is read raises the
//! budget.

/// The maximum size in bytes of a scene file, and of each buffer or image file.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// The maximum size of the JSON document, in bytes.
pub const MAX_JSON_BYTES: usize = 256 << 20;

/// The maximum number of objects (opening braces) in the JSON document. A parsed object takes hundreds of bytes of
/// memory.
pub const MAX_OBJECTS: usize = 1 << 20;

/// The number of JSON objects that a document may have regardless of its size. Further objects need
/// [`BYTES_PER_OBJECT`] bytes each.
pub const FREE_OBJECTS: usize = 1 << 12;
/// The minimum number of bytes of JSON for each object beyond [`FREE_OBJECTS`].
pub const BYTES_PER_OBJECT: usize = 20;

/// The number of decoded bytes that a scene may have regardless of the size of its files.
pub const FREE_DECODED_BYTES: u64 = 64 << 20;
/// The number of additional decoded bytes allowed for each byte that is read. Decoded data can be larger than its
/// files, since primitives share vertices, and accessors of zeros need no bytes.
pub const DECODED_PER_BYTE: u64 = 1 << 6;
/// The number of additional decoded bytes allowed for each byte of an image file, since a uniform image compresses
/// well. Bytes of a buffer that several images share count once.
pub const DECODED_PER_IMAGE_BYTE: u64 = 1 << 12;

/// The maximum number of bytes of all decoded buffers, vertices, indices, key frames and texels together.
pub const MAX_DECODED_BYTES: u64 = 3 << 30;

/// The maximum number of texels along one side of an image.
pub const MAX_IMAGE_SIDE: u32 = 16_384;

/// The maximum number of texels of an image. Decoding may take about 16 bytes of memory per texel beyond the budget for
/// decoded bytes.
pub const MAX_IMAGE_TEXELS: u64 = 1 << 27;

/// The maximum number of draws of a scene: one for each primitive and level of detail of each drawn node.
pub const MAX_DRAWS: usize = 1 << 20;

/// The maximum distance of geometry, cameras and lights from the origin along each axis, in metres.
pub const MAX_DISTANCE: f64 = 1e9;

/// The maximum number of errors, and likewise of warnings, that are listed for one file.
pub const MAX_DIAGNOSTICS: usize = 200;
