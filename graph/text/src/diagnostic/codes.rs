//! The codes of the engine's own diagnostics.
//!
//! Ranges: 00 files and the command line, 01 documents, 02 the pipeline language, 03 resources and expressions,
//! 04 the graph and its plan, 05 templates and shaders, 06 the node kinds that come with the project, 07 scenes,
//! 08 devices and execution. A code is never reused for another meaning.

crate::codes! {
    /// A file that the command line, a pipeline or a template names, but that cannot be read.
    FILE_UNREADABLE = "UG0001", "file cannot be read",
        "A file that the command line, a pipeline or a template names does not exist, cannot be read, or is no regular file: a pipe or a device may never end.\n\nPaths inside a file are relative to the folder of that file.";
    /// A file that is not UTF-8.
    FILE_NOT_UTF8 = "UG0002", "file is not UTF-8",
        "Pipelines, parameter files and templates are UTF-8 text. The diagnostic points to the first byte that is not.";
    /// A file over the limit of 64 MiB of text or 1,500,000 values.
    FILE_TOO_LARGE = "UG0003", "file too large", "Pipelines, parameter files and templates are limited to 64 MiB of text and 1,500,000 values: what is larger was hardly written by a person, and is rejected before a tree is made of it.";
    /// A file that a document names, outside of the folders that the document may read.
    FILE_OUTSIDE = "UG0010", "file outside of what may be read",
        "Files that a document names (those that it extends or includes, subgraphs, templates, buffers and images of a scene) lie below the working folder, below the folder of the pipeline or scene that is named on the command line, or below a folder given with `--root FOLDER`. Links are followed before that is looked at. A file elsewhere is not opened, and whether it exists is not said.";
    /// One file that a pipeline names by two different paths.
    FILE_TWICE = "UG0011", "one file by two paths",
        "Two paths lead to the same file, by a link or by the folder that they begin with. What it says counts twice, and an unsaved text over one of the paths is over the other too.";
    /// Files that extend or include one another in a cycle, or too many files of one pipeline.
    FILE_CYCLE = "UG0007", "files in a cycle",
        "A file extends or includes another that, perhaps by a detour, extends or includes the first; or a pipeline is made of more files than allowed.";
    /// A `null` that deletes a member which the extended file does not have.
    DELETES_NOTHING = "UG0109", "deletes nothing",
        "`null` deletes what the extended file has under that key. Here there is nothing to delete: the key is misspelt, or nothing is extended.";
    /// An extension that inserts passes at an extension point which the pipeline does not declare.
    UNKNOWN_EXTENSION_POINT = "UG0210", "unknown extension point",
        "An extension puts passes at a point that the pipeline does not name under `extension_points`.";
    /// A target profile that does not exist.
    UNKNOWN_PROFILE = "UG0006", "unknown profile",
        "A target profile that does not exist is asked for, or claimed by a pipeline. The profiles are webgpu, webgpu-compat, vulkan, metal, dx12, gles and webgl2.";
    /// A name given on the command line that no declaration of the pipeline has.
    UNKNOWN_NAME = "UG0008", "unknown name",
        "`umbragraph why PIPELINE NAME` explains passes, resources, parameters, features, derived values, shared settings, toggles, presets, subgraphs, extension points and geometry by name; what a use of a subgraph or a round of a loop makes is named after it: `soft.down`, `down.0`. Nothing in the pipeline has the name that is asked for. With two names both are resources.";
    /// A source text that is not valid JSON.
    SYNTAX = "UG0101", "not JSON",
        "Pipelines are strict JSON (RFC 8259) with `//` and `/* */` comments. Trailing commas, single quotes, bare keys, hexadecimal numbers, NaN and nesting beyond 512 levels are rejected. The parser stops at the first such place.\n\nOf a `{` or `[` that is never closed the diagnostic points to the bracket: what it holds is indented, so the first line that is not stands behind its end.";
    /// A key that the schema does not allow in its object.
    UNKNOWN_KEY = "UG0102", "unknown key",
        "An object has a key that means nothing at its place. Nothing is ignored silently: a misspelt key would otherwise change nothing and say nothing.";
    /// A key that appears twice in one object, or a name that both a file and a file that it includes declare.
    DUPLICATE_KEY = "UG0103", "duplicate key",
        "A key appears twice in one object. Other readers of JSON take the first or the last of the two; here it is always a mistake.";
    /// A number that neither a 64-bit integer nor a 64-bit float can represent.
    NUMBER_RANGE = "UG0104", "number out of range",
        "A number is beyond what a 64-bit floating-point number holds, or is not written as JSON wants it.";
    /// A value whose type differs from the one that the schema requires.
    WRONG_TYPE = "UG0105", "wrong type",
        "A value has another type than its place wants: a string where a number belongs, an object where an array belongs. `umbragraph schema` prints what each place wants.";
    /// A required key that is missing.
    MISSING_KEY = "UG0106", "missing key", "An object lacks a key that it must have.";
    /// A string that is not a member of the enumeration expected there.
    UNKNOWN_WORD = "UG0107", "unknown word",
        "A place that takes one of a few words (a comparison, a blend mode) has another one; the schema lists them, with the names of the WebGPU specification. Or an expression compares a parameter or feature with a text that is none of its `values`: `mode == 'tow'` would be false for ever.";
    /// A number or list length outside the limits of the schema.
    OUT_OF_BOUNDS = "UG0108", "value out of bounds",
        "A number, or the length of a list, is outside what its place allows.";
    /// A file with a `format` version that this version of the engine does not support.
    OTHER_FORMAT = "UG0110", "file of another format",
        "The number under `\"format\"` of a pipeline, a part of one or a parameter file is not one that this version reads. A later version reads earlier formats too; an earlier one cannot know what a later format means, so it says nothing else of the file.";
    /// A name that is not a valid identifier, or is reserved.
    BAD_NAME = "UG0201", "bad name",
        "Names of parameters, features, resources and passes start with a letter and go on with letters, digits and underscores, so that expressions can use them. `viewport`, `true` and `false` are taken, and a feature and a parameter cannot share a name.";
    /// A parameter or feature that the pipeline does not declare.
    UNKNOWN_SETTING = "UG0202", "unknown parameter or feature",
        "A value is given for a parameter or feature that the pipeline does not declare, or a feature requires or excludes one that is not there.";
    /// A value whose type differs from the declared type of its parameter or feature.
    SETTING_TYPE = "UG0203", "wrong type of setting",
        "The value of a parameter or feature is not of the type that the pipeline declares. A boolean is `true` or `false`; on the command line `on` and `off` say the same (`--feature soft=off`).";
    /// A value or list length outside the range that its parameter declares.
    SETTING_RANGE = "UG0204", "setting out of range",
        "The value of a parameter is outside the range that the pipeline declares, or a list has too few or too many elements.";
    /// A list parameter whose elements are not in the declared strict order.
    SETTING_ORDER = "UG0205", "list out of order",
        "The elements of a list parameter have to increase (or decrease) strictly; distances, for one.";
    /// Features whose `requires` or `excludes` rules are violated.
    FEATURE_CONFLICT = "UG0206", "features contradict",
        "A feature that is on requires one that is off, or excludes one that is on; or it requires or excludes itself, which means nothing or that it can never be on.";
    /// A reference to a pass that does not exist, is switched off, or does not write the resource.
    UNKNOWN_PASS = "UG0207", "unknown pass",
        "`after`, or the version of a reference (`&name@pass`), names a pass that the pipeline does not have, that is switched off, or that does not write the resource.";
    /// A string that is not a valid reference to a resource or published data.
    BAD_REFERENCE = "UG0208", "bad reference",
        "A reference is an ampersand and the name of a resource or of published data, `&name`, or `&name@pass` for the version that a pass wrote. After an equals sign stands an expression that yields one: `=soft ? &blurred : &sharp`. Without its sign a string is a word.";
    /// A geometry contract that the pipeline does not declare under `geometry`.
    UNKNOWN_GEOMETRY = "UG0209", "unknown geometry",
        "A pass draws with a contract that \"geometry\" does not declare.";
    /// A `for_each` loop with invalid bounds or too many rounds.
    LOOP = "UG0211", "impossible loop",
        "`for_each` has one variable with a whole number (rounds from 0) or a list. A loop has at most 4,096 rounds, a pipeline at most 65,536 passes, and `after` between loops and subgraphs puts at most 1,048,576 pairs of passes in an order.";
    /// A subgraph that is not declared, or that uses itself.
    UNKNOWN_SUBGRAPH = "UG0212", "unknown subgraph",
        "`use` names a subgraph that `subgraphs` does not declare, or a subgraph uses itself. What ends with `.json`, or has a folder in it, is the path of a file that is one subgraph, relative to the file that says it: `\"use\": \"parts/blur.json\"`.";
    /// A preset that the pipeline does not declare.
    UNKNOWN_PRESET = "UG0213", "unknown preset", "A preset that the pipeline does not declare is asked for.";
    /// A toggle that the pipeline does not declare under `toggles`.
    UNKNOWN_TOGGLE = "UG0214", "unknown toggle",
        "A pass, a frame or the command line names a toggle that the pipeline does not declare under `toggles`. A pass has one toggle at most; `!name` means that it runs while the toggle is off.";
    /// A declared toggle that no pass uses.
    UNUSED_TOGGLE = "UG0215", "toggle without a pass",
        "A toggle is declared, but no pass has it: switching it changes nothing.";
    /// A `passthrough` fallback that cannot replace the resource of a toggled pass, such as one of another dimension.
    PASSTHROUGH = "UG0216", "impossible passthrough",
        "`passthrough` says what readers see instead of a resource in a frame without the passes that write it. That works for a resource that only passes of one and the same toggle write, and for one that is bound or copied from (not attached). The fallback has to be of the same kind: the same dimension, layers and samples, a format that the readers can use, buffers no smaller, blackboard data of the same shape.\n\nA pass that loads what a toggled pass makes fresh, and adds to it, cannot be served by another resource: give it the same toggle, or let the toggled pass load what an earlier pass made, so that without it the earlier contents stay.";
    /// A `one_of` group of features of which not exactly one is on.
    FEATURE_GROUP = "UG0217", "not one of a group",
        "Features with the same name under `one_of` form a group, and exactly one of them is on.\n\n```json\n\"features\": {\n  \"hard\": { \"type\": \"bool\", \"default\": true, \"one_of\": \"filter\" },\n  \"soft\": { \"type\": \"bool\", \"default\": false, \"one_of\": \"filter\" }\n}\n```\n\nWhoever switches one on (`--feature soft`, a preset, a parameter file) thereby switches those off that are on by default alone. Two that are both chosen, a group of which none is on, and a group with a single feature are errors. An enumeration is often the simpler way to say the same.";
    /// A required limit or device feature with an unknown name.
    UNKNOWN_LIMIT = "UG0218", "unknown limit or device feature",
        "A feature says under `required_features` which optional features of WebGPU it needs, by WebGPU's names (`float32-filterable`), and which parts of WebGPU's core mode that OpenGL or compatibility mode lack (`compute`, `cube-arrays`, `depth-buffer-copies`, `fragment-writable-storage`, `independent-blend`, `indirect`, `read-only-depth`, `sample-shading`, `view-formats`); and under `required_limits` what it needs of the target: limits of WebGPU of which more is better, by the names that wgpu gives them, such as `max_storage_buffers_per_shader_stage`. Storage buffers are also counted as `max_storage_buffers_in_vertex_stage` and `max_storage_buffers_in_fragment_stage`.";
    /// A feature that is switched on although the target lacks a limit or device feature that it requires.
    FEATURE_UNAVAILABLE = "UG0219", "feature unavailable",
        "A feature says under `required_limits` and `required_features` what it needs of the target.\n\n```json\n\"features\": {\n  \"storage\": { \"type\": \"bool\", \"default\": true, \"required_limits\": { \"max_storage_buffers_in_vertex_stage\": 1 } }\n}\n```\n\nWhere the target profile, or the device that a picture is rendered on, has less, the feature is off (an enumeration has its first word) though it is on by default or in the chosen preset; to switch it on by itself is an error. Profiles have no optional feature of WebGPU by themselves; `--profile webgpu+float32-filterable` is one that does, and so is a device. `umbragraph why PIPELINE FEATURE` shows where a value comes from.";
    /// A parameter, feature, derived value or group of shared settings that is never used.
    UNUSED_SETTING = "UG0220", "nothing uses it",
        "A parameter, feature or derived value is declared, but no expression mentions it and no template that a pass names has an axis of its name: with any value the pipeline is the same. Or no pass extends a group of shared settings. Usually its use was removed, or is still to be written.\n\nIt is a note, since a host can read parameters in code of its own.";
    /// A group of shared settings that is not declared, or that extends itself.
    UNKNOWN_SHARED_SETTINGS = "UG0221", "unknown shared settings",
        "A pass, or a group of shared settings, extends a group that is not declared under `shared_settings`, or that by a detour extends itself. A subgraph sees its own groups and those of the pipeline; a subgraph in a file of its own sees its own alone.";
    /// Derived values that depend on one another in a cycle.
    DERIVED_CYCLE = "UG0222", "derived value depends on itself",
        "The expression of a derived value names another whose expression, by a detour, names the first. Derived values may stand in any order, but each follows from parameters, features and others that do not follow from it.";
    /// A constraint of the pipeline that the current values violate.
    CONSTRAINT = "UG0223", "constraint does not hold",
        "A pipeline says under `constraints` which values of parameters, features and derived values go together, and what is wrong with others.\n\n```json\n\"constraints\": {\n  \"exponent_of_fp16\": {\n    \"holds\": \"=!half_precision || exponent <= 5.54\",\n    \"message\": \"squares of moments overflow fp16 with an exponent above 5.54\"\n  }\n}\n```\n\nWith `\"severity\": \"warning\"` the pipeline can be used all the same. The diagnostic names the values that the condition depends on, and where each was set.";
    /// A parameter that is to change from frame to frame although sizes, formats, variants or the graph depend on it.
    STRUCTURAL_PARAMETER = "UG0230", "structural parameter",
        "A parameter is asked for that cannot change from frame to frame, since sizes, formats, shader variants or overrides, states of pipelines or the graph's shape follow from it: the diagnostic names the first place where they do. `umbragraph plan --format json` and `umbragraph why` say it of every parameter. Plan again with another value; or let only members of blocks, settings of CPU passes, clear values, the stencil reference, the blend constant and counts of dispatches and draws follow from it.";
    /// A reference to a resource that the pipeline does not declare.
    UNKNOWN_RESOURCE = "UG0301", "unknown resource",
        "A reference names a resource that \"resources\" does not declare.";
    /// A resource of another kind (texture, buffer, sampler or data) than its use requires.
    WRONG_RESOURCE = "UG0302", "wrong kind of resource",
        "A place that takes a texture, a buffer, a sampler or blackboard data is given another of them.";
    /// Blackboard data that a pass reads but no pass publishes.
    NOT_PUBLISHED = "UG0303", "data is not published",
        "A pass reads blackboard data that no pass publishes. CPU passes (a camera, for one) name what they publish under `to`.";
    /// Blackboard data that two passes publish under one name.
    PUBLISHED_TWICE = "UG0304", "data is published twice", "Two passes publish blackboard data under one name.";
    /// A string that is not a valid expression.
    EXPRESSION_SYNTAX = "UG0310", "not an expression",
        "A string is no expression, or one that cannot be parsed. An expression is a string after an equals sign, such as `=viewport / 2`; without the sign a string is a word. Expressions have numbers, names, `+ - * / %`, comparisons, `&& || !`, `a ? b : c`, `[lists]`, `list[index]` and functions.";
    /// An unknown name in an expression.
    EXPRESSION_NAME = "UG0311", "unknown name in an expression",
        "Expressions know parameters, features, derived values, the functions of the language and, where sizes are known, resources (`maps`, `maps.width`) and `viewport`.\n\nA subgraph in a file of its own sees its own parameters, inputs and resources, and `viewport`; a parameter, feature or resource of the pipeline is passed to it through `with`.";
    /// An operand or result of the wrong type.
    EXPRESSION_TYPE = "UG0312", "wrong type in an expression",
        "Numbers, booleans, texts and lists do not turn into one another. Arithmetic works on numbers and, element by element, on lists of numbers.";
    /// An arithmetic operation without a finite result, or an index outside its list.
    EXPRESSION_ARITHMETIC = "UG0313", "no result",
        "A division by zero, a root of a negative number, an overflow or an index outside its list: there is no finite result.";
    /// A pass that sets an axis which its shader template does not declare.
    UNKNOWN_AXIS = "UG0602", "unknown axis",
        "A pass chooses a value for an axis that the template does not declare. Axes stand in `NAME.axes.json` beside the template.";
    /// An entry point that the shader does not have, or a pass that does not choose between several entry points of a
    /// stage.
    UNKNOWN_ENTRY_POINT = "UG0609", "unknown entry point",
        "A pass names under `entry_points` one that its shader does not have in that stage, or that one of its variants does not have; or names none where a stage has several; or its shader has none of a stage that the pass needs.";
    /// A binding or block member that no reachable variant of the shader declares.
    UNKNOWN_BINDING = "UG0603", "unknown binding",
        "`bind` has a name that no variant of the shader declares, or `values` one that the block has in none of them. What another variant has that the pipeline can reach is merely not needed in this one. What only variants have that the pass never takes, since its axes are fixed to other values, is an error too: nothing would ever read it.";
    /// A shader binding or block member for which the pass provides no value.
    UNBOUND = "UG0604", "binding without a value",
        "The shader declares a binding, or a member of a block, for which the pass gives nothing.";
    /// Blackboard data without the values that a CPU pass reads, or with other types.
    DATA_SHAPE = "UG0305", "blackboard data of another kind",
        "A CPU pass reads values of the blackboard data that it names, and another pass publishes data of that name, but without those values, or as other types. Usually the name is that of other data: a list of lights where a placement is wanted.";
    /// Blackboard data that lacks a member of the uniform or storage block to which the data is bound.
    BLOCK_MISMATCH = "UG0605", "block does not fit",
        "A uniform or storage block has a member for which the bound blackboard data publishes no value of that name and type. Offsets never matter: they come from the shader.";
    /// Shader variants or programs that declare the same binding differently.
    VARIANT_INTERFACE = "UG0606", "variants disagree",
        "Two variants of a program, or two programs that share blackboard data, declare one binding differently.";
    /// A shader that reads vertex inputs or bindings which the pipeline's `geometry` contract does not provide.
    HOST_CONTRACT = "UG0607", "geometry contract",
        "A shader that draws the host's meshes reads a vertex input, or a binding of group 2 or 3, that the pipeline's `geometry` does not provide, or not of that type.";
    /// Resource sizes that depend on one another in a cycle.
    SIZE_CYCLE = "UG0320", "size depends on itself",
        "The size of a resource names another resource whose size, by a detour, names the first.";
    /// A resource size that is zero or beyond the limits of the target profile.
    SIZE_LIMIT = "UG0321", "impossible size",
        "A width, height, layer, mip, sample or byte count is zero or beyond the limits of the target profile. A size that is not whole is rounded down first.";
    /// A string that is not the name of a texture format.
    FORMAT_UNKNOWN = "UG0322", "unknown texture format",
        "Texture formats have the names of the WebGPU specification: `depth32float`, `rgba16float`.";
    /// A texture for which no candidate format supports every use of the texture.
    FORMAT_USAGE = "UG0323", "format does not support the usage",
        "None of the format candidates of a texture supports every way in which the passes use it: as a depth or color attachment, storage, sampled with filtering, blended. The message says for each candidate why.";
    /// A resource, or a part of one, that a pass reads but no earlier pass writes.
    NEVER_WRITTEN = "UG0401", "read but never written",
        "A pass reads, or loads, a transient resource (or a subresource range of it) that no pass writes before. The memory of transient resources is shared, so it would find what another one left there.\n\nEach mip, layer, aspect and byte that is read counts: of a texture with four mips of which a pass writes two, a shader that samples all of them needs the other two written as well, or a view of the two (`\"source\": { \"texture\": { \"name\": \"&chain\", \"mip\": 0 } }`). A pass that both reads and writes (an attachment that it loads, storage that its shader may read, a box of a copy) needs all of it written as well, or says that it needs nothing (`\"contents\": \"discard\"`); storage that is only written keeps what is there, and needs nothing. Of a pass that no output needs, only a read of which nothing at all is written is told.\n\nA persistent resource, or a history, has memory of its own, and holds zeros or its initial value until a pass writes it: of what is read there and no pass ever writes, this is a warning.";
    /// Two passes that write the same part of a resource without a defined order.
    UNORDERED_WRITERS = "UG0402", "unordered writers",
        "Two passes write the same subresource range of a resource, and nothing says which of them goes first: no data flows from one to the other, no `after`, no version. Any choice would be a guess. A single writer that clears, and that nothing says is later, is ordered before those that load without being told; so are several of which no two clear the same.";
    /// Passes that depend on one another in a cycle.
    CYCLE = "UG0403", "cycle",
        "Passes wait for one another in a cycle. The related places show each step of a shortest cycle.";
    /// A pass that reads the same part of a texture that it writes.
    FEEDBACK = "UG0404", "reads what it writes",
        "A pass samples or copies from a subresource range of a texture that it also writes. No device allows that. Different mip levels or layers are fine, and so is a depth attachment that is only tested against.";
    /// Attachments of a pass with mismatched sizes, sample counts, ranges or shader outputs.
    ATTACHMENTS = "UG0405", "attachments do not fit",
        "The attachments of a pass differ in size or sample count, lie outside their texture, or do not fit the outputs of the fragment shader.";
    /// A workgroup count that is invalid or beyond the limits of the target profile.
    DISPATCH = "UG0406", "impossible dispatch",
        "A workgroup count is negative, not whole, or beyond the limits of the target profile.";
    /// A pipeline in which every pass is culled, since none has an external effect.
    NO_OUTPUT = "UG0407", "nothing comes out",
        "No pass writes an imported or persistent resource or has a side effect, so everything is culled.";
    /// A texture of the host application that a pass uses in a way not among the texture's usage flags.
    IMPORT_USAGE = "UG0408", "import used beyond its usage",
        "A pass uses a texture of the host's own in a way that the host did not create it for; the usages are told with the imports.";
    /// A texture, view, copy, attachment or block that breaks a rule of WebGPU.
    DEVICE_RULE = "UG0409", "no device allows this",
        "A texture, a view, a copy, an attachment or a block breaks a rule of WebGPU: cubes have six square layers, a texture with several samples has one layer and one mip level and is no volume, multisampled bindings see multisampled textures, a copy joins subresource ranges of one format and size (depth, stencil and several samples by whole layers, one aspect to or from a buffer only, a buffer or a mip level of a volume not onto itself), a full-screen pass into an array says which layer it writes, blocks of the host are read-only and within the profile's binding sizes, bind groups are numbered 0 to 3, the vertex stage writes no storage, storage textures are read and written in formats for which the profile guarantees it.";
    /// A read of contents that are missing in frames in which a pass with a toggle does not run.
    TOGGLED_AWAY = "UG0411", "nothing left without the toggle",
        "A pass reads, or the picture shows, what only a pass with a toggle writes; in a frame in which the toggle is switched the other way nothing would be there.\n\nFour ways out: give the reader the same toggle, so that it vanishes too; say under `passthrough` of the writer what the reader sees instead; let an earlier pass write the resource and the toggled one load it; or write it by a second pass with the opposite toggle (`!name`). Mips, layers, aspects and bytes count each for itself, as they do without toggles (UG0401). Of a pass that no output needs, only a read of which nothing at all is left is told.";
    /// A read of an attachment after a pass that discards its contents.
    DISCARDED = "UG0412", "read of what is discarded",
        "An attachment with `\"store\": \"discard\"` promises that nobody reads what it holds after its pass, so that a tiling device never writes it to memory; but a later pass of the frame does, or a pass of a later frame, since the texture is persistent or a history.\n\nWithout `store` an attachment is stored exactly where something reads it later, or where it outlives the frame. The key is for what outlives the frame and still is not needed: the depth of a host's own texture, for one.";
    /// A history resource without an `initial` value.
    HISTORY_INITIAL = "UG0430", "history without an initial value",
        "A resource with `\"lifetime\": \"history\"` keeps what earlier frames left. In the first frame, after a resize and after a reset there is no earlier frame, and `initial` says what is read then: a number or a colour for a texture, `{ \"f32\": 0 }`, `{ \"u32\": 0 }` or `{ \"i32\": 0 }` for each four bytes of a buffer.";
    /// A `frames` or `initial` setting that is invalid, or on a resource that is not a history.
    HISTORY_SETTING = "UG0431", "setting of a history",
        "`frames` and `initial` belong to resources with `\"lifetime\": \"history\"`. `frames` is a whole number from 1 to 8 that is known before the viewport is; `initial` is one number, or red, green, blue and alpha; for depth it is between 0 and 1.";
    /// A read of an earlier frame that the resource does not keep.
    HISTORY_READ = "UG0432", "frame that is not kept",
        "`&color@-2` is what the frame before the last left in `color`. Only a resource with `\"lifetime\": \"history\"` keeps earlier frames, and only as many as its `frames` says (1 without it).";
    /// A pass that writes the contents of an earlier frame, which can only be read.
    HISTORY_WRITE = "UG0433", "write of an earlier frame",
        "A pass writes `color@-1`. What earlier frames left is only read; this frame writes `color`, and the next one reads that as `color@-1`.";
    /// A history that no pass writes, or whose earlier frames no pass reads.
    HISTORY_UNUSED = "UG0434", "history without a use",
        "No pass writes a history, so that its initial value is all that is ever read; or no pass reads it frames back, so that a transient resource would do with less memory.";
    /// Vertex attributes or blocks of the host application that do not match the shader that reads them.
    HOST_INTERFACE = "UG0608", "host interface",
        "The host's vertex attributes or blocks (names, types, offsets) do not fit a shader that draws its meshes.";
    /// An imported texture that the host application did not provide, or whose format or size differs from the plan.
    IMPORT = "UG0802", "import missing",
        "The host did not give a texture for an imported resource, or one of another format or size than planned.";
    /// An error of the graphics device: out of memory, a lost device or a validation error.
    DEVICE = "UG0803", "device error",
        "The graphics device rejected or lost something: out of memory, a lost device, or a validation error. `check` runs each plan dry on wgpu without a driver; a validation error there is a rule of WebGPU that the pipeline breaks and for which there is no diagnostic of its own yet.";
    /// A graphics device that was lost and must be created anew.
    DEVICE_LOST = "UG0820", "device lost",
        "The graphics device was lost: its driver was reset or updated, it was unplugged, or the host destroyed it. Nothing can be made on it any more. The host makes a new device and, with the same plan, a new executor on it; histories and kept shadow maps begin anew.";
    /// Draws of the host application's draw source that panicked or were reported as failed.
    DRAW_FAILED = "UG0821", "draws failed",
        "The host's draw source panicked, or said that it failed (`DrawPass::fail`), while it drew the meshes of a pass. The rest of the frame is recorded, without what the pass would still have drawn; the next frame is possible.";
    /// A device without a texture capability, feature or limit that the plan needs.
    DEVICE_LIMIT = "UG0804", "device cannot run the plan",
        "A texture, a feature or a limit that the plan needs is beyond what this device offers.";
    /// A pipeline without an output texture that `umbragraph render` can write as an image.
    PICTURE = "UG0808", "no picture",
        "`umbragraph render` writes the one imported texture that passes write (or the one called `target`): of a format of colors, of the viewport's size, one layer, one sample. rgba8unorm and rgba8unorm-srgb are written to a PNG file as they are; of floats, colors above 0.8 are tone mapped, with a note. A file that ends in .exr has the numbers themselves. The viewer and scores take rgba8unorm and rgba8unorm-srgb alone.";
    /// A texture that `umbragraph render --capture` cannot write as an image.
    CAPTURE = "UG0809", "nothing to capture",
        "`umbragraph render --capture NAME[@PASS][:MIP,LAYER,FACE]=FILE` writes the contents of a texture or buffer, or of the version that one pass wrote. What does not exist, is culled, is a volume, has several samples a texel, or has a format without a picture cannot be captured. A buffer is written as .json, or as .csv if it is an array.";
    /// Frame input (a camera or light) with invalid values, which is left out of the frame.
    FRAME_INPUT = "UG0806", "unusable frame input",
        "The camera or a light of a frame has a value that is not finite, a direction that is not of unit length, or an empty depth range. The frame is recorded without it.";
    /// A CPU pass that publishes values, views or elements which it did not declare.
    BLACKBOARD = "UG0807", "undeclared blackboard data",
        "A CPU pass sets a value that it did not declare, or more views or elements than declared. That is a defect of the node kind.";
    /// A mesh filter of a draw pass that the host application's draw source does not support.
    UNKNOWN_FILTER = "UG0805", "unknown filter",
        "A draw pass has a `mesh_filter` that the host's draw source does not know, or the host states no filters. The plan lists the filters of a pipeline (`umbragraph plan --format json`). The bundled pipelines use `opaque`, `transparent`, `moving`, `casters`, `static_casters` and `dynamic_casters`. State the filters that the host tells apart with `HostInterface::filters`. In each pass, draw only the meshes that `DrawPass::filter` selects. If the host draws the same in all passes, call `HostInterface::any_filter`.";
}
