//! The words that applications share with the node kinds of this crate: properties of lights, and filters of draws.
//!
//! A light casts shadows if it has the property [`CAST_SHADOW`]. A pass draws the meshes that its filter names; the
//! pipelines that come with the crate use those of [`filters`].

use umbragraph_pipeline::frame::Light;

/// The name of the property of a light that casts shadows.
pub const CAST_SHADOW: &str = "cast_shadow";

/// The name of the property of a light with contact shadows: its shadows are refined near contacts, in screen space.
pub const CONTACT_SHADOW: &str = "contact_shadow";

/// The names of the properties that choose a light's shadow filter: one comparison, a filter of fixed width, or one as
/// wide as the penumbra. The number in `light.shadow` is the index plus 1.
pub const HARDNESS: [&str; 3] = ["hard_shadow", "soft_shadow", "pcss_shadow"];

/// The names of filters that choose meshes for draws.
pub mod filters {
    /// All draws.
    pub const ALL: &str = "all";
    /// Draws that are not blended.
    pub const OPAQUE: &str = "opaque";
    /// Draws that are blended over the opaque ones, back to front.
    pub const TRANSPARENT: &str = "transparent";
    /// Opaque draws that can move, for motion vectors.
    pub const MOVING: &str = "moving";
    /// Draws that cast shadows.
    pub const CASTERS: &str = "casters";
    /// Draws of casters that do not move; their shadow maps are kept from frame to frame.
    pub const STATIC_CASTERS: &str = "static_casters";
    /// Draws of casters that move, drawn over the kept shadow maps of static casters.
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

    /// Makes the light cast shadows that are refined near contacts ([`CONTACT_SHADOW`]).
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
