//! The codes of the diagnostics of this crate's node kinds.

umbragraph_pipeline::codes! {
    /// Far distances of cascades that are not finite, positive and increasing.
    CASCADE_FAR = "UG0610", "far distances of cascades",
        "A cascade fit needs far distances in metres along the view axis, above zero, finite, and each greater than the one before (also once they are rounded to 32 bits).\n\n```json\n\"cascades\": { \"to\": \"&sun\", \"far\": [10, 30, 80, 200], \"resolution\": 2048 }\n```";
    /// A number of cascades that is zero, too large, or larger than the number of far distances.
    CASCADE_COUNT = "UG0611", "number of cascades",
        "A cascade fit has 1 to 8 cascades. With the scheme \"explicit\" each has a far distance of its own, so there cannot be more cascades than far distances.";
    /// Settings of a split scheme that give no splits.
    CASCADE_SPLITS = "UG0612", "split scheme of cascades",
        "The schemes \"uniform\", \"logarithmic\" and \"practical\" divide the range from a near distance above zero to the last far distance, which has to lie beyond it; of further far distances only their number counts, where `count` does not say how many cascades there are. The weight lambda of the practical scheme lies between 0 (uniform) and 1 (logarithmic).";
    /// A cascade resolution that leaves no texels, or a list with fewer resolutions than cascades.
    CASCADE_RESOLUTION = "UG0613", "resolution of cascades",
        "The resolution is one whole number of texels for all cascades, or a list with one for each. Of a cascade's texels the border is taken off on both sides, and one more that snapping needs; something has to be left.";
    /// Cascade tiles that lie outside their map, overlap, or are too few.
    CASCADE_TILE = "UG0614", "tiles of cascades",
        "Cascades that share one map have a tile each: the texel of its top left corner, as [x, y]. Each tile lies inside the map with all its texels, and no two overlap, since they would overwrite one another's depth.\n\n```json\n\"tiles\": [[0, 0], [1024, 0], [0, 1024]], \"map\": [2048, 2048]\n```";
    /// A blend zone of cascades that is not a fraction between 0 and 1.
    CASCADE_BLEND = "UG0615", "blend zone of cascades",
        "The blend zone is a fraction between 0 (no blending) and 1 of each cascade's far distance or range.";
    /// An up vector without a direction, such as one of zeros.
    LIGHT_UP = "UG0616", "up vector of a light view",
        "The up vector is a list of three numbers, not all zero; [0, 1, 0] for scenes whose Y axis points up, [0, 0, 1] for those with Z.";
    /// A distance to extend the depth range of cascades that is out of range.
    CASCADE_DEPTH = "UG0617", "depth range of cascades",
        "The near plane of a cascade goes to the bounds of the casters (\"casters\") or so many metres beyond the slice; the far plane stands so many metres behind it. Both lie between 0 and 100,000 m.";
    /// A number of lights, shadow maps or views that is out of range.
    LIGHT_CAPACITY = "UG0618", "numbers of lights and shadow maps",
        "The numbers of lights, descriptors, cubes, layers and views of a frame are whole and at least one, since arrays of shaders and textures are made for them. Sides of an atlas and its tiles are powers of two from 16 to 8192 texels, and no minimum is larger than its maximum; the smallest tile fits into the smallest atlas. Near planes stand between 0.1 mm and 10 km.";
    /// Cascade settings that contradict a shadow placement.
    PLACEMENT = "UG0619", "settings beside a placement",
        "With a placement, the node kind shadow_atlas decides which lights have cascades and in which layers they lie. Settings that decide it otherwise stand in its way.";
    /// Lights that are left out because a frame has more than the light list holds.
    LIGHTS_LEFT_OUT = "UG0620", "lights that are left out",
        "A frame has more lights than the light list can hold. The least important are left out: importance grows with the part of the picture that a light reaches, its intensity and the host's priority.";
    /// Shadows that are reduced or left out because the shadow maps of a frame are full.
    SHADOWS_LEFT_OUT = "UG0621", "shadows that are reduced or left out",
        "A frame has more lights with shadows than the shadow atlas, its number of spots, the cubes, the layers, the descriptors or the views can hold. Spots get smaller tiles first; then the least important lights go without shadows. Each is named with the reason.";
    /// A frame with cascades for which the host gave no scene bounds.
    NO_BOUNDS = "UG0623", "frame without bounds",
        "Cascades reach towards the light as far as casters do, and with a camera whose far plane is at infinity as far as the scene does: the bounds of a frame tell both (`FrameInput::scene_bounds`, and `filter_bounds` of \"casters\" where they are another box). Without them casters count that stand between the light and what the camera sees within its range, which for a camera without a far plane is taken to be 1000 m.";
    /// A frame with shadow maps in which no light casts shadows.
    NO_CASTING_LIGHT = "UG0624", "no light casts shadows",
        "The pipeline draws shadow maps, but no light of the frame has the property \"cast_shadow\". Lights cast shadows if they say so: `Light::directional(...).casts_shadow()` with `umbragraph::prelude`, or `.property(\"cast_shadow\")`; in glTF scenes all do, unless `castShadow` is false. Cascades that name their light (`\"light\": \"sun\"`) need a directional light of this name.";
    /// A shadow filter whose width was bounded in texels, so that it is wider or narrower than requested.
    FILTER_BOUNDED = "UG0622", "filter bounded in texels",
        "Filters are measured in the world, so that the edges of shadows are equally wide in every map. A filter of less than a texel or two shows the texels, one of very many leaves gaps between its taps; so pipelines bound it in texels. Where a bound bites, the width is another one: in the cascades that are named, or, since the texels of spots and point lights grow with the distance, narrower within a distance and wider beyond one.";
}
