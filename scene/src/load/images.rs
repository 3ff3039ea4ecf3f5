//! Textures and the decoding of their images.
//!
//! Only images of textures that materials use are decoded, each once, and images with the same bytes once together. The
//! bytes identify the format; the document's MIME type is ignored. The size in the image's own header is checked before
//! any texel is decoded.

use gltf::json::texture::{MagFilter, MinFilter, Sampler as JsonSampler, WrappingMode};
use gltf::json::validation::Checked;
use std::borrow::Cow;
use std::collections::BTreeMap;
use umbragraph_pipeline::wgpu_types::{AddressMode, FilterMode, MipmapFilterMode};

use super::accessor::Accessors;
use super::decode::{DecodeError, Encoded};
use super::limits::{DECODED_PER_IMAGE_BYTE, MAX_IMAGE_SIDE, MAX_IMAGE_TEXELS};
use super::report::Report;
use super::resource::{Resolver, resolve_of};
use crate::codes;
use crate::texture::{Image, Sampler, Texture};

/// Reads the textures with the indices `wanted` and decodes their images. Returns one texture for each valid index, in
/// the order of `wanted`. An image that cannot be read is reported as an error; the image index of its texture is then
/// meaningless.
pub(super) fn read(
    accessors: &Accessors<'_>,
    wanted: &[usize],
    resolver: &dyn Resolver,
    report: &mut Report,
) -> (Vec<Image>, Vec<Texture>) {
    let root = accessors.root;
    let (mut images, mut places, mut sources) = (Vec::new(), BTreeMap::new(), Sources::default());
    let mut textures = Vec::with_capacity(wanted.len());
    for index in wanted {
        let Some(texture) = root.textures.get(*index) else { continue };
        let at = format!("/textures/{index}");
        let sampler = texture.sampler.and_then(|sampler| {
            let found = report.lookup(&root.samplers, sampler.value(), "sampler", &format!("{at}/sampler"));
            found.map(|json| read_sampler(sampler.value(), json, report))
        });
        let source = texture.source.value();
        let image = *places.entry(source).or_insert_with(|| {
            if report.lookup(&root.images, source, "image", &format!("{at}/source")).is_some() {
                let found = sources.of(accessors, source);
                let known = found.clone().and_then(|found| sources.decoded.get(&found).copied());
                if let Some(known) = known {
                    return known;
                }
                if let Some(image) = read_image(accessors, source, resolver, &mut sources, report) {
                    sources.decoded.extend(found.map(|found| (found, images.len())));
                    images.push(image);
                }
            }
            images.len().saturating_sub(1)
        });
        textures.push(Texture { image, sampler: sampler.unwrap_or_default() });
    }
    (images, textures)
}

/// The place from which the encoded bytes of an image are read.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    File(String),
    /// A byte range of a buffer: index of the buffer, byte offset, and number of bytes.
    View(usize, u64, u64),
}

/// The index of each decoded image by its source, and for each buffer the number of bytes already counted as image
/// data.
#[derive(Default)]
struct Sources {
    decoded: BTreeMap<Source, usize>,
    counted: BTreeMap<usize, usize>,
}

impl Sources {
    /// The source of the image with this index in the document. `None` if the image or its buffer view does not exist.
    fn of(&self, accessors: &Accessors<'_>, image: usize) -> Option<Source> {
        let json = accessors.root.images.get(image)?;
        if let Some(uri) = &json.uri {
            return Some(Source::File(uri.clone()));
        }
        let view = accessors.root.buffer_views.get(json.buffer_view?.value())?;
        Some(Source::View(view.buffer.value(), view.byte_offset.unwrap_or_default().0, view.byte_length.0))
    }

    /// The number of bytes of an image by which the budget for decoded data is raised. The bytes of a buffer count at
    /// most once, even if several images share them.
    fn new_bytes(&mut self, accessors: &Accessors<'_>, image: usize, bytes: usize) -> usize {
        match self.of(accessors, image) {
            Some(Source::View(buffer, ..)) => {
                let all = accessors.buffers.get(buffer).and_then(Option::as_ref).map_or(0, Vec::len);
                let counted = self.counted.entry(buffer).or_default();
                let new = bytes.min(all.saturating_sub(*counted));
                *counted += new;
                new
            }
            _ => bytes,
        }
    }
}

fn read_sampler(index: usize, json: &JsonSampler, report: &mut Report) -> Sampler {
    let mut wrap = |value: &Checked<WrappingMode>, property| match known(value, index, property, report) {
        Some(WrappingMode::Repeat) | None => AddressMode::Repeat,
        Some(WrappingMode::ClampToEdge) => AddressMode::ClampToEdge,
        Some(WrappingMode::MirroredRepeat) => AddressMode::MirrorRepeat,
    };
    let (wrap_u, wrap_v) = (wrap(&json.wrap_s, "wrapS"), wrap(&json.wrap_t, "wrapT"));
    let mag_filter = json.mag_filter.as_ref().and_then(|value| known(value, index, "magFilter", report));
    let magnify = match mag_filter {
        Some(MagFilter::Nearest) => FilterMode::Nearest,
        Some(MagFilter::Linear) | None => FilterMode::Linear,
    };
    let min_filter = json.min_filter.as_ref().and_then(|value| known(value, index, "minFilter", report));
    let (minify, mipmap) = match min_filter {
        Some(MinFilter::Nearest) => (FilterMode::Nearest, None),
        Some(MinFilter::Linear) => (FilterMode::Linear, None),
        Some(MinFilter::NearestMipmapNearest) => (FilterMode::Nearest, Some(MipmapFilterMode::Nearest)),
        Some(MinFilter::LinearMipmapNearest) => (FilterMode::Linear, Some(MipmapFilterMode::Nearest)),
        Some(MinFilter::NearestMipmapLinear) => (FilterMode::Nearest, Some(MipmapFilterMode::Linear)),
        Some(MinFilter::LinearMipmapLinear) | None => (FilterMode::Linear, Some(MipmapFilterMode::Linear)),
    };
    Sampler { wrap_u, wrap_v, magnify, minify, mipmap }
}

fn known<T: Copy>(value: &Checked<T>, index: usize, property: &str, report: &mut Report) -> Option<T> {
    let message = format!("sampler {index} has an unknown {property}");
    let help = "see the glTF 2.0 specification, section 5.26";
    report.known(value, &format!("/samplers/{index}/{property}"), message, help)
}

/// Decodes a PNG or JPEG picture to 8 bits per channel.
///
/// # Errors
/// A message that describes the defect.
pub fn image_from_slice(name: &str, bytes: &[u8]) -> Result<Image, String> {
    let encoded = Encoded::new(bytes).map_err(|error| error.to_string())?;
    let (width, height) = encoded.size();
    if is_too_large(width, height) {
        return Err(format!("it has {width} × {height} texels; {}", size_help()));
    }
    let rgba = encoded.rgba().map_err(|error| error.to_string())?;
    Ok(Image { name: name.to_owned(), width, height, rgba })
}

fn is_too_large(width: u32, height: u32) -> bool {
    let area = u64::from(width) * u64::from(height);
    area == 0 || width.max(height) > MAX_IMAGE_SIDE || area > MAX_IMAGE_TEXELS
}

fn size_help() -> String {
    format!("at most {MAX_IMAGE_SIDE} texels a side and {MAX_IMAGE_TEXELS} in all are read")
}

fn read_image(
    accessors: &Accessors<'_>,
    index: usize,
    resolver: &dyn Resolver,
    sources: &mut Sources,
    report: &mut Report,
) -> Option<Image> {
    let json = accessors.root.images.get(index)?;
    let at = format!("/images/{index}");
    let bytes = match (&json.uri, json.buffer_view) {
        (Some(uri), _) => {
            let object = format!("image {index}");
            Cow::Owned(resolve_of(uri, resolver, codes::BAD_IMAGE, &object, &at, report)?)
        }
        (None, Some(view)) => {
            Cow::Borrowed(accessors.view(view.value(), &format!("{at}/bufferView"), report)?)
        }
        (None, None) => {
            let message = format!("image {index} has neither a URI nor a buffer view");
            return report.reject(codes::BAD_IMAGE, &at, message, "export the scene with its textures");
        }
    };
    let failed = |error: DecodeError, report: &mut Report| {
        let message = format!("image {index} cannot be decoded: {error}");
        report.reject(codes::BAD_IMAGE, &at, message, "use a PNG or JPEG image")
    };
    let encoded = match Encoded::new(&bytes) {
        Ok(encoded) => encoded,
        Err(error) => return failed(error, report),
    };
    let (width, height) = encoded.size();
    if is_too_large(width, height) {
        let message = format!("image {index} has {width} × {height} texels");
        return report.reject(codes::TOO_LARGE, &at, message, size_help());
    }
    let area = u64::from(width) * u64::from(height);
    report.allow(sources.new_bytes(accessors, index, bytes.len()), DECODED_PER_IMAGE_BYTE);
    // Mip levels take another third.
    if !report.charge(area * 4 * 4 / 3, &at) {
        return None;
    }
    match encoded.rgba() {
        Ok(rgba) => Some(Image { name: json.name.clone().unwrap_or_default(), width, height, rgba }),
        Err(error) => failed(error, report),
    }
}
