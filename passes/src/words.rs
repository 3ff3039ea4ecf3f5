//! The words that applications share with the node kinds of this crate: properties of lights, and filters of draws.
//!
//! A light casts shadows if it has the property [`CAST_SHADOW`]. A pass draws the meshes that its filter names; the
//! pipelines that come with the crate use those of [`filters`].

use umbragraph_pipeline::frame::Light;

/// The property of a light in which things cast shadows.
pub const CAST_SHADOW: &str = "cast_shadow";

/// The property of a light whose shadows are refined where things touch, by what the picture shows.
pub const CONTACT_SHADOW: &str = "contact_shadow";

/// The properties of a light that say how hard its shadows are, in the order of their numbers in `light.shadow`, from
/// 1: one comparison, a filter of fixed width, one as wide as the penumbra.
pub const HARDNESS: [&str; 3] = ["hard_shadow", "soft_shadow", "pcss_shadow"];

/// The filters of draws.
pub mod filters {
    /// All draws.
    pub const ALL: &str = "all";
    /// Draws that are not blended.
    pub const OPAQUE: &str = "opaque";
    /// Draws that are blended over the opaque ones, back to front.
    pub const TRANSPARENT: &str = "transparent";
    /// Opaque draws that can move: drawn for motion vectors.
    pub const MOVING: &str = "moving";
    /// Draws that cast shadows.
    pub const CASTERS: &str = "casters";
    /// Casters that stay where they are: the maps of them are kept from frame to frame.
    pub const STATIC_CASTERS: &str = "static_casters";
    /// Casters that move: drawn over the maps that are kept.
    pub const DYNAMIC_CASTERS: &str = "dynamic_casters";
}

/// Properties of lights, as methods of [`Light`].
///
/// ```
/// use umbragraph_passes::words::LightProperties;
/// use umbragraph_pipeline::frame::Light;
///
/// let sun = Light::directional("sun", [-0.8, -0.7, -0.35], [1.0, 0.9, 0.8], 4.0).casts_shadow();
/// assert!(sun.has("cast_shadow"));
/// ```
pub trait LightProperties: Sized {
    /// Makes the light cast shadows ([`CAST_SHADOW`]).
    #[must_use]
    fn casts_shadow(self) -> Self;

    /// Makes the light cast shadows that are refined where things touch ([`CONTACT_SHADOW`]).
    #[must_use]
    fn casts_contact_shadow(self) -> Self;
}

impl LightProperties for Light {
    fn casts_shadow(self) -> Self {
        self.property(CAST_SHADOW)
    }

    fn casts_contact_shadow(self) -> Self {
        self.casts_shadow().property(CONTACT_SHADOW)
    }
}
