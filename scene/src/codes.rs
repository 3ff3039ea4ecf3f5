//! The codes of diagnostics in scene files: UG0700 to UG0799.

umbragraph_pipeline::codes! {
    /// The scene file does not exist or cannot be read.
    SCENE_UNREADABLE = "UG0700", "scene cannot be read",
        "The scene file does not exist, is a folder, or may not be read. Paths are relative to the current folder.";
    /// The file is neither JSON nor a complete binary glTF (`.glb`).
    BROKEN_CONTAINER = "UG0701", "broken glTF container",
        "A `.glb` file is a header of twelve bytes (`glTF`, the version 2, the length of the file) and chunks: first `JSON`, then at most one `BIN`. The lengths in the headers must fit the file. A file that was cut off while it was copied is found here.\n\nExport the file again, or copy it again in binary mode.";
    /// The JSON of the document cannot be parsed or has values of a wrong type.
    BROKEN_JSON = "UG0702", "broken glTF document",
        "The JSON chunk (or the `.gltf` file) is not JSON, lacks a required property, or has a value of a type that glTF 2.0 does not allow at its place. Parsing stops at the first such value, so mending it can bring up another.";
    /// The glTF version of the file is not 2.
    UNSUPPORTED_VERSION = "UG0703", "unsupported glTF version",
        "Only glTF 2.x is read. glTF 1.0 files can be converted by most modelling programs.";
    /// The document requires a glTF extension that the loader does not support.
    UNSUPPORTED_EXTENSION = "UG0704", "unsupported glTF extension",
        "The document lists an extension in `extensionsRequired` that this loader does not understand. Understood are `KHR_lights_punctual`, `KHR_materials_emissive_strength`, `KHR_materials_ior`, `KHR_materials_specular`, `KHR_materials_unlit`, `KHR_mesh_quantization`, `KHR_texture_transform` and `MSFT_lod`.\n\nCompressed geometry (`KHR_draco_mesh_compression`, `EXT_meshopt_compression`) has to be decompressed by a glTF tool first. Extensions that are used but not required are ignored.";
    /// An index in the document refers to a glTF object that does not exist.
    DANGLING_REFERENCE = "UG0705", "reference to nothing",
        "glTF objects refer to one another by index into the document's arrays. The index at this place is beyond the end of its array.";
    /// A buffer has no URI and no binary chunk for its bytes, or the file or data URI with its bytes cannot be read.
    MISSING_BUFFER = "UG0706", "missing buffer",
        "A buffer's bytes come from the binary chunk of the `.glb` file, a file beside the document, or a `data:` URI. The named source does not exist or cannot be read.\n\nA `.gltf` file has to be copied together with its `.bin` files and images.";
    /// A buffer has fewer bytes than its `byteLength` declares.
    BUFFER_TOO_SHORT = "UG0707", "buffer too short",
        "The buffer has fewer bytes than its `byteLength` says: it was probably cut off.";
    /// An accessor reaches beyond its buffer view, or a buffer view beyond its buffer.
    OUT_OF_BOUNDS = "UG0708", "accessor out of bounds",
        "A buffer view must lie inside its buffer, and an accessor (offset, stride, count) inside its view.";
    /// The type or component type of an accessor is not allowed for its use.
    WRONG_TYPE = "UG0709", "accessor of a wrong type",
        "The accessor's `type` or `componentType` is not one that glTF allows for this use, or it has no elements.";
    /// A primitive lacks positions, has only one of joints and weights, or has attributes with different numbers of
    /// elements.
    INCOMPLETE_PRIMITIVE = "UG0710", "incomplete primitive",
        "A primitive needs the attribute `POSITION`, and all its attributes must have the same number of elements. A skinned one needs `JOINTS_0` and `WEIGHTS_0`.";
    /// A vertex index of a primitive is beyond its vertices.
    INDEX_OUT_OF_RANGE = "UG0711", "index beyond the vertices",
        "An index of the primitive names a vertex beyond the end of its attributes.";
    /// A number in a vertex attribute, a transform or a key frame is NaN or infinite.
    NOT_FINITE = "UG0712", "value is not finite",
        "A position, normal, texture coordinate, matrix or key frame is NaN or infinite. No bounds, and so no shadow map, could be fitted around it.";
    /// The transform of a node is not finite, not affine, or moves content too far from the origin.
    BAD_TRANSFORM = "UG0713", "unusable transform",
        "A node's transform is not finite, is no affine transform, has a rotation of length zero, or places geometry, a camera or a light farther than a million kilometres from the origin.";
    /// The node hierarchy has a cycle or a node with two parents.
    NOT_A_TREE = "UG0714", "node hierarchy is not a tree",
        "Every node has at most one parent, and no node is its own ancestor.";
    /// The scene exceeds a size limit of the loader (see `load::limits`).
    TOO_LARGE = "UG0715", "scene too large",
        "Loading stays within fixed limits for bytes, objects, vertices, texels and draws, so that a broken or hostile file cannot exhaust memory. The limits are the constants of `umbragraph_scene::load::limits`.";
    /// The projection parameters of a camera are missing or invalid, or the transform of its node gives no view
    /// direction.
    BAD_CAMERA = "UG0716", "unusable camera",
        "A perspective camera needs a vertical field of view above 0 and below π, and a near plane above 0; an orthographic one a height above 0. The far plane must lie beyond the near plane.";
    /// The colour, intensity, range, direction or cone of a light is invalid.
    BAD_LIGHT = "UG0717", "unusable light",
        "A light needs a colour and intensity that are finite and not negative (so is their product), a range above 0 (none means infinite), and, unless it is a point, a direction: the −Z axis of its node, which a scale of zero destroys. A spot's cone has 0 ≤ inner < outer ≤ π/2.";
    /// An image cannot be read or decoded as PNG or JPEG.
    BAD_IMAGE = "UG0718", "image cannot be decoded",
        "Images are PNG or JPEG, in a buffer view, in a file beside the document, or in a `data:` URI.";
    /// A factor or the index of a texture coordinate set of a material is outside its valid range.
    BAD_MATERIAL = "UG0719", "material value out of range",
        "Colour factors, the alpha cutoff and the strength of emission must be finite and not negative; metallic, roughness and the strength of occlusion lie between 0 and 1. An index of refraction is 0 or at least 1. Textures use the texture coordinates TEXCOORD_0 or TEXCOORD_1.";
    /// The joints or inverse bind matrices of a skin are invalid, or do not match the mesh drawn with the skin.
    BAD_SKIN = "UG0720", "unusable skin",
        "A skin lists its joints (at least one, all existing nodes) and has one inverse bind matrix (affine) for each joint, or none at all. A mesh drawn with it may name only those joints.";
    /// The key times, the values or the target of an animation channel are invalid.
    BAD_ANIMATION = "UG0721", "unusable animation",
        "Key times must increase strictly and not be negative, and there is one value (three for cubic splines) for each. Rotations are unit quaternions; one of length zero turns nowhere.";
    /// A valid part of the document, such as points or lines, is ignored.
    LEFT_OUT = "UG0722", "part of the scene is left out",
        "The document has something that is valid, but not drawn: points, lines, a further animation or one without channels, an incomplete last triangle; a level of detail that does not correspond to its node; or transparent surfaces (alpha mode `BLEND`), where the pipeline has no pass that draws them.";
    /// The scene that the document shows by default has no triangles.
    EMPTY_SCENE = "UG0723", "nothing to draw",
        "The scene that the document shows by default has no triangles. The picture will be empty.";
    /// A property has a value that glTF 2.0 does not define, or a known `extras` property has a wrong type.
    BAD_VALUE = "UG0724", "value not known to glTF",
        "The property has a value that glTF 2.0 does not list, such as an unknown alpha mode, or an `extras` value that this project reads has another type.";
    /// The file has more errors than the loader lists.
    MORE_DIAGNOSTICS = "UG0725", "further diagnostics not shown",
        "A file has so many diagnostics that only the first ones are listed. Mend these first: the others are often of the same kind.";
    /// Morph targets or their weights do not match the mesh.
    BAD_MORPH = "UG0726", "unusable morph targets",
        "The primitives of a mesh have the same number of morph targets, each of them one displacement for each vertex; a mesh, or a node that shows it, has one weight for each target, a finite number.";
}

#[cfg(test)]
mod tests {
    use super::ALL;

    #[test]
    fn codes_are_unique_sorted_and_in_the_range_of_scenes() {
        assert!(ALL.windows(2).all(|pair| pair[0].id < pair[1].id));
        assert!(ALL.iter().all(|code| code.id.starts_with("UG07") && !code.page.is_empty()));
    }
}
