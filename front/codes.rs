//! The codes of diagnostics that the command and the viewer share.

#![allow(unreachable_pub)] // The macro serves libraries.

umbragraph_graph::codes! {
    /// A file that cannot be written.
    FILE_UNWRITABLE = "UG0004", "file cannot be written",
        "The output could not be written. Nothing is left half: output goes to a temporary file first, which is renamed when it is whole.";
    /// A camera path that no camera can follow.
    CAMERA_PATH = "UG0810", "unusable camera path",
        "The file of `--camera` has keys with a time, a position and a target, in strictly increasing order of their times; all numbers are finite, and no key looks straight up or down.";
    /// A machine without a usable adapter.
    NO_ADAPTER = "UG0801", "no graphics adapter",
        "No Vulkan, Metal, DX12 or GL adapter was found. On Debian and Ubuntu `apt install mesa-vulkan-drivers` gives a software one. Checking pipelines needs none.";
    /// Lights of the scene that no pass reads.
    UNREAD_LIGHTS = "UG0811", "lights without a part in the picture",
        "The scene has lights that no pass of the pipeline reads, such as spots and point lights where the pipeline lights with one directional light alone. A pipeline with a `light_list` takes every kind.";
    /// A picture for an imported texture that cannot be used.
    IMPORT_FILE = "UG0829", "unusable picture for an import",
        "`--import NAME=FILE` of `umbragraph render` and `umbragraph view` fills an imported texture that passes only read. The file is a PNG or JPEG, or an OpenEXR or Radiance picture for a float format; its size is that of the texture. Layers stand side by side or below one another.";
    /// An environment picture that cannot be used.
    ENVIRONMENT = "UG0815", "unusable environment",
        "`--environment FILE` of `umbragraph render` and `umbragraph view` takes an equirectangular picture, a Radiance .hdr or an OpenEXR .exr, for pipelines with an imported texture `environment` of the format rgba16float and a feature `environment`, such as pipelines/umbra.json. Where the feature is on, the picture has to be given.";
}
