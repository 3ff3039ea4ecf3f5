//! Subresource ranges of resources: mip levels, layers and aspects of textures, bytes of buffers.
//!
//! Two accesses touch one another where their subresource ranges overlap: hazards, loads and stores are found range by
//! range. An index range is a range of whole numbers; nothing said means everything. The depth and the stencil of one
//! texture are subresource ranges of their own; a texture whose format has one of the two only has no such subresource
//! ranges, so its accesses name [`Aspect::All`].

use serde::Serialize;

use crate::access::usage::Usage;

use umbragraph_text::language::{TextureDeclaration, parse_format};

/// A range of successive mip levels, layers or bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub struct IndexRange<T> {
    /// The index of the first mip level or layer, or the offset of the first byte.
    pub first: T,
    /// The number of mip levels, layers or bytes.
    pub count: T,
}

impl<T: Copy + Into<u64>> IndexRange<T> {
    /// The index after the last mip level or layer, or the byte offset after the last byte, of the range.
    pub fn end(self) -> u64 {
        self.first.into().saturating_add(self.count.into())
    }

    fn overlaps(self, other: Self) -> bool {
        self.first.into() < other.end() && other.first.into() < self.end()
    }

    fn contains(self, other: Self) -> bool {
        self.first.into() <= other.first.into() && other.end() <= self.end()
    }
}

impl IndexRange<u32> {
    /// Creates a range of one mip level or layer, with the index `at`.
    pub const fn one(at: u32) -> Self {
        Self { first: at, count: 1 }
    }
}

umbragraph_text::webgpu_words! {
    /// The aspect of a texture that is used.
    #[derive(Default)]
    Aspect = wgpu_types::TextureAspect {
        /// All aspects of the format.
        #[default]
        All,
        /// The depth.
        DepthOnly,
        /// The stencil.
        StencilOnly,
    }
}

/// A part of a resource: mip levels, layers and aspect of a texture, or bytes of a buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub struct SubresourceRange {
    /// The mip levels of a texture; `None` for all.
    pub mip: Option<IndexRange<u32>>,
    /// The layers of a texture; `None` for all.
    pub layer: Option<IndexRange<u32>>,
    /// The aspect of a texture (depth, stencil or all).
    pub aspect: Aspect,
    /// The bytes of a buffer; `None` for all.
    pub bytes: Option<IndexRange<u64>>,
}

impl SubresourceRange {
    /// The range of a complete resource: all mip levels, layers, aspects and bytes.
    pub const WHOLE: Self = Self { mip: None, layer: None, aspect: Aspect::All, bytes: None };

    /// Creates a range of one mip level of one layer of a texture; `None` means all mip levels or all layers.
    pub fn of(mip: Option<u32>, layer: Option<u32>) -> Self {
        Self { mip: mip.map(IndexRange::one), layer: layer.map(IndexRange::one), ..Self::WHOLE }
    }

    /// Creates a range of `count` bytes of a buffer that starts at the byte offset `first`.
    pub const fn bytes(first: u64, count: u64) -> Self {
        Self { bytes: Some(IndexRange { first, count }), ..Self::WHOLE }
    }

    /// Restricts the range to one aspect.
    pub const fn aspect(self, aspect: Aspect) -> Self {
        Self { aspect, ..self }
    }

    /// Returns `true` if the two ranges have a subresource in common.
    pub fn overlaps(self, other: Self) -> bool {
        fn meet<T: Copy + Into<u64>>(a: Option<IndexRange<T>>, b: Option<IndexRange<T>>) -> bool {
            a.zip(b).is_none_or(|(a, b)| a.overlaps(b))
        }
        meet(self.mip, other.mip)
            && meet(self.layer, other.layer)
            && meet(self.bytes, other.bytes)
            && (self.aspect == Aspect::All || other.aspect == Aspect::All || self.aspect == other.aspect)
    }

    /// Returns `true` if `other` lies entirely within this range.
    pub fn contains(self, other: Self) -> bool {
        fn holds<T: Copy + Into<u64>>(a: Option<IndexRange<T>>, b: Option<IndexRange<T>>) -> bool {
            a.is_none_or(|a| b.is_some_and(|b| a.contains(b)))
        }
        holds(self.mip, other.mip)
            && holds(self.layer, other.layer)
            && holds(self.bytes, other.bytes)
            && (self.aspect == Aspect::All || self.aspect == other.aspect)
    }

    /// The four ranges that contain this range: its mip level or all levels, combined with its layer or all layers.
    /// This range must satisfy [`Self::is_plain`].
    pub fn plain_around(self) -> [Self; 4] {
        [self, Self { mip: None, ..self }, Self { layer: None, ..self }, Self::WHOLE]
    }

    /// Returns `true` if the range names at most one mip level and at most one layer, all aspects and no bytes.
    pub fn is_plain(self) -> bool {
        let plain = |run: Option<IndexRange<u32>>| run.is_none_or(|run| run.count == 1);
        plain(self.mip) && plain(self.layer) && self.aspect == Aspect::All && self.bytes.is_none()
    }
}

impl std::fmt::Display for SubresourceRange {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let run = |what: &str, run: Option<IndexRange<u32>>| {
            run.map(|run| match run.count {
                1 => format!("{what} {}", run.first),
                _ => format!("{what}s {} to {}", run.first, run.end().saturating_sub(1)),
            })
        };
        let aspect = match self.aspect {
            Aspect::All => None,
            Aspect::DepthOnly => Some("depth".to_owned()),
            Aspect::StencilOnly => Some("stencil".to_owned()),
        };
        let bytes = self.bytes.map(|run| format!("bytes {} to {}", run.first, run.end().saturating_sub(1)));
        let words: Vec<String> =
            [run("mip", self.mip), run("layer", self.layer), aspect, bytes].into_iter().flatten().collect();
        formatter.write_str(&words.join(", "))
    }
}

/// Normalises a range for comparison with other ranges. The resulting aspect is depth or stencil only if a possible
/// format of the texture has both aspects.
pub fn canonical(texture: &TextureDeclaration, range: SubresourceRange, usage: Usage) -> SubresourceRange {
    let mut formats = texture.format.names().iter().filter_map(|name| parse_format(name));
    let both = formats.any(|format| format.is_combined_depth_stencil_format());
    let aspect = match (usage.aspect(), range.aspect) {
        _ if !both => Aspect::All,
        (Aspect::All, Aspect::All) if usage == Usage::Sampled => Aspect::DepthOnly,
        (Aspect::All, aspect) | (aspect, _) => aspect,
    };
    range.aspect(aspect)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use umbragraph_test_support::property;

    fn range() -> impl Strategy<Value = SubresourceRange> {
        let run = || proptest::option::of((0u32..4, 1u32..4));
        let aspects = [Aspect::All, Aspect::DepthOnly, Aspect::StencilOnly];
        (run(), run(), 0usize..3).prop_map(move |(mip, layer, aspect)| {
            let run = |run: Option<(u32, u32)>| run.map(|(first, count)| IndexRange { first, count });
            SubresourceRange { mip: run(mip), layer: run(layer), aspect: aspects[aspect], bytes: None }
        })
    }

    /// The subresources of a range, in a texture with 8 mip levels, 8 layers, depth and stencil.
    fn members(range: SubresourceRange) -> Vec<(u32, u32, Aspect)> {
        let within = |run: Option<IndexRange<u32>>, at: u32| {
            run.is_none_or(|run| run.first <= at && at < run.first + run.count)
        };
        let mut all = Vec::new();
        for mip in 0..8 {
            for layer in 0..8 {
                for aspect in [Aspect::DepthOnly, Aspect::StencilOnly] {
                    if within(range.mip, mip)
                        && within(range.layer, layer)
                        && (range.aspect == Aspect::All || range.aspect == aspect)
                    {
                        all.push((mip, layer, aspect));
                    }
                }
            }
        }
        all
    }

    proptest! {
        #![proptest_config(property::config(256))]

        #[test]
        fn ranges_overlap_and_contain_as_their_subresources_do(a in range(), b in range()) {
            let (first, second) = (members(a), members(b));
            prop_assert_eq!(a.overlaps(b), first.iter().any(|one| second.contains(one)));
            prop_assert_eq!(a.contains(b), second.iter().all(|one| first.contains(one)));
        }
    }

    #[test]
    fn neighbouring_ranges_of_bytes_do_not_overlap() {
        assert!(!SubresourceRange::bytes(0, 256).overlaps(SubresourceRange::bytes(256, 256)));
        assert!(SubresourceRange::bytes(0, 257).overlaps(SubresourceRange::bytes(256, 256)));
        assert!(
            SubresourceRange::WHOLE.contains(SubresourceRange::bytes(4, 4))
                && !SubresourceRange::bytes(4, 4).contains(SubresourceRange::WHOLE)
        );
    }
}
