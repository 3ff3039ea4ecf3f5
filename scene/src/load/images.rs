//! Textures and the decoding of their images.
//!
//! Only the images of textures that materials use are decoded, each once, and those of the same bytes once together. The format is told from the bytes; the MIME
//! type in the document is not trusted. Before any texel is decoded the size in the image's own header is held
//! against the limits.

use gltf::json::texture::{MagFilter, MinFilter, Sampler as JsonSampler, WrappingMode};
use gltf::json::validation::Checked;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;

use super::accessor::Accessors;
use super::limits::{DECODED_PER_IMAGE_BYTE, MAX_IMAGE_SIDE};
use super::report::Report;
use super::resource::{Resolver, resolve};
use crate::codes;
use crate::texture::{Filter, Image, Sampler, Texture, Wrap};

/// The images and textures behind the document's textures `wanted`; one texture for each, in that order. A texture
/// whose image cannot be read gets another one after a diagnostic: no scene comes of it.
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

/// Where the bytes of an image come from.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    File(String),
    /// A buffer, the first byte and how many.
    View(usize, u64, u64),
}

/// The images that were decoded, and the bytes of each buffer that were counted as those of images.
#[derive(Default)]
struct Sources {
    decoded: BTreeMap<Source, usize>,
    counted: BTreeMap<usize, usize>,
}

impl Sources {
    /// Where an image of the document comes from.
    fn of(&self, accessors: &Accessors<'_>, image: usize) -> Option<Source> {
        let json = accessors.root.images.get(image)?;
        if let Some(uri) = &json.uri {
            return Some(Source::File(uri.clone()));
        }
        let view = accessors.root.buffer_views.get(json.buffer_view?.value())?;
        Some(Source::View(view.buffer.value(), view.byte_offset.unwrap_or_default().0, view.byte_length.0))
    }

    /// Of the bytes of an image those that are not those of others: of a buffer as many as it has, in whatever views.
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
    let mut unknown = |property: &str| {
        let at = format!("/samplers/{index}/{property}");
        report.error(
            codes::BAD_VALUE,
            &at,
            format!("sampler {index} has an unknown {property}"),
            "see the glTF 2.0 specification, section 5.26",
        );
    };
    let mut wrap = |value: &Checked<WrappingMode>, property| match value {
        Checked::Valid(WrappingMode::Repeat) => Wrap::Repeat,
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::ClampToEdge,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::MirroredRepeat,
        Checked::Invalid => {
            unknown(property);
            Wrap::Repeat
        }
    };
    let (wrap_u, wrap_v) = (wrap(&json.wrap_s, "wrapS"), wrap(&json.wrap_t, "wrapT"));
    let magnify = match &json.mag_filter {
        Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
        Some(Checked::Valid(MagFilter::Linear)) | None => Filter::Linear,
        Some(Checked::Invalid) => {
            unknown("magFilter");
            Filter::Linear
        }
    };
    let (minify, mipmap) = match &json.min_filter {
        Some(Checked::Valid(filter)) => match filter {
            MinFilter::Nearest => (Filter::Nearest, None),
            MinFilter::Linear => (Filter::Linear, None),
            MinFilter::NearestMipmapNearest => (Filter::Nearest, Some(Filter::Nearest)),
            MinFilter::LinearMipmapNearest => (Filter::Linear, Some(Filter::Nearest)),
            MinFilter::NearestMipmapLinear => (Filter::Nearest, Some(Filter::Linear)),
            MinFilter::LinearMipmapLinear => (Filter::Linear, Some(Filter::Linear)),
        },
        None => (Filter::Linear, Some(Filter::Linear)),
        Some(Checked::Invalid) => {
            unknown("minFilter");
            (Filter::Linear, Some(Filter::Linear))
        }
    };
    Sampler { wrap_u, wrap_v, magnify, minify, mipmap }
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
        (Some(uri), _) => match resolve(uri, resolver) {
            Ok(bytes) => Cow::Owned(bytes),
            Err(error) => {
                let help = "put the file beside the document, or export the scene as one .glb file";
                report.error(codes::BAD_IMAGE, &format!("{at}/uri"), format!("image {index}: {error}"), help);
                return None;
            }
        },
        (None, Some(view)) => {
            Cow::Borrowed(accessors.view(view.value(), &format!("{at}/bufferView"), report)?)
        }
        (None, None) => {
            let message = format!("image {index} has neither a URI nor a buffer view");
            report.error(codes::BAD_IMAGE, &at, message, "export the scene with its textures");
            return None;
        }
    };
    let mut failed = |error: &dyn std::fmt::Display| {
        let message = format!("image {index} cannot be decoded: {error}");
        report.error(codes::BAD_IMAGE, &at, message, "use a PNG or JPEG image");
    };
    let reader = || image::ImageReader::new(Cursor::new(&*bytes)).with_guessed_format();
    let (width, height) =
        match reader().map_err(image::ImageError::IoError).and_then(image::ImageReader::into_dimensions) {
            Ok(size) => size,
            Err(error) => {
                failed(&error);
                return None;
            }
        };
    if width == 0 || height == 0 || width.max(height) > MAX_IMAGE_SIDE {
        let message = format!("image {index} has {width} × {height} texels");
        report.error(
            codes::TOO_LARGE,
            &at,
            message,
            format!("at most {MAX_IMAGE_SIDE} texels a side are read"),
        );
        return None;
    }
    report.allow(sources.new_bytes(accessors, index, bytes.len()), DECODED_PER_IMAGE_BYTE);
    // Mip levels take another third.
    if !report.charge(u64::from(width) * u64::from(height) * 4 * 4 / 3, &at) {
        return None;
    }
    match reader().map_err(image::ImageError::IoError).and_then(image::ImageReader::decode) {
        Ok(decoded) => {
            let rgba = decoded.into_rgba8().into_raw();
            Some(Image { name: json.name.clone().unwrap_or_default(), width, height, rgba })
        }
        Err(error) => {
            let message = format!("image {index} cannot be decoded: {error}");
            report.error(codes::BAD_IMAGE, &at, message, "use a PNG or JPEG image");
            None
        }
    }
}
