//! The codes of diagnostics about templates, axes and shaders.

umbragraph_text::codes! {
    /// A pass names a template that does not exist.
    TEMPLATE_UNKNOWN = "UG0500", "unknown template",
        "A pass names a template that does not exist. Templates are named by their path below the folder of templates, with `/` and with the ending: `lib/noise.wgsl.jinja`.";
    /// A template that minijinja cannot parse.
    TEMPLATE_SYNTAX = "UG0501", "template syntax",
        "The template is not well-formed minijinja: a tag is not closed, a block has no end, an expression is incomplete.\n\nTags are `{% if sscs %}`, `{{ taps }}` and `{# a comment #}`; a block tag alone on its line leaves no line behind.";
    /// A template reads a name that is neither an axis nor defined in the template.
    UNDECLARED_NAME = "UG0502", "undeclared name in a template",
        "A template reads a name that is neither one of its axes nor bound in the template by `set`, `for`, `macro` or `import`.\n\nA template sees its declared axes and nothing else, so a misspelt name is always found, also where a test or a default would have hidden it. Declare the axis in the file `NAME.axes.json` beside the template; where an included template reads it, add that template to `inherits`. A template that extends another, and has no such file, has the axes of that one.";
    /// A template includes, imports or extends a template that does not exist.
    INCLUDE_MISSING = "UG0503", "included template is missing",
        "A template includes, imports or extends another one that does not exist. Names are those of the template set (`lib/noise.wgsl.jinja`), never relative to the including file.";
    /// A template includes itself, directly or through other templates.
    INCLUDE_RECURSIVE = "UG0504", "recursive include",
        "A template includes itself, directly or through others, or a macro calls itself without end.";
    /// Rendering a template exceeds a limit of steps, output size or time.
    TEMPLATE_LIMIT = "UG0505", "template exceeds a limit",
        "Rendering a template is limited, so that none can hang or exhaust memory: 1,000,000 steps of the template engine, 4 MiB of WGSL, 1 MiB for one value, 1,024 words of one expression, 4,194,304 elements of values (or pieces of 64 bytes) that filters and checks of size go through, and a second at last.\n\nA template near these limits usually loops over the wrong range.";
    /// An expression of a template fails during rendering.
    TEMPLATE_EVALUATION = "UG0506", "template cannot be evaluated",
        "An expression of a template cannot be evaluated: operands of the wrong type, an unknown filter or test, a wrong number of arguments, or a value (a list, none) that cannot be written into WGSL.\n\nA boolean is written as `true` or `false`, an integer as its digits.";
    /// Two templates, or two files of axes, have the same name.
    TEMPLATE_TWICE = "UG0507", "template given twice",
        "Two templates, or two declarations of axes, have the same name. The second is ignored.";
    /// A `set` within a loop is lost at the end of its round.
    SET_LOST = "UG0508", "assignment in a loop is lost",
        "A `{% set %}` within `{% for %}` makes a variable of the round: behind the loop the variable has the value that it had before. Text behind the loop that reads it means the other value, probably.\n\n`namespace` keeps a value over rounds:\n\n```jinja\n{% set sum = namespace(value=0) %}\n{% for i in range(taps) %}{% set sum.value = sum.value + i %}{% endfor %}\n{{ sum.value }}\n```";
    /// The declaration of an axis is invalid.
    AXIS_DECLARATION = "UG0510", "axis declaration",
        "A declaration in `NAME.axes.json` is inconsistent: an empty range or enumeration, a default that is none of the axis's values, a condition on an axis that does not exist, or a combination of keys that means nothing.\n\n```json\n{ \"axes\": {\n    \"sscs\":   { \"type\": \"bool\", \"default\": false, \"requires\": [\"depth_prepass\"] },\n    \"filter\": { \"type\": \"enum\", \"values\": [\"hard\", \"pcf\"], \"default\": \"pcf\" },\n    \"taps\":   { \"type\": \"integer\", \"min\": 1, \"max\": 64, \"default\": 16 } } }\n```";
    /// A value is given for an axis that the template does not have.
    AXIS_UNKNOWN = "UG0511", "unknown axis",
        "A value is given for an axis that the template neither declares nor inherits. `umbragraph permutations --axes` lists the axes of each template.";
    /// A value is not one of its axis's values.
    AXIS_VALUE = "UG0512", "value outside its axis",
        "A value is given for an axis that is none of the values that the axis declares.";
    /// The chosen values violate a constraint.
    CONSTRAINT_VIOLATED = "UG0513", "constraint violated",
        "The chosen values break a constraint that is declared beside the template: a feature without another that it requires, two that exclude each other, or not exactly one of a group.";
    /// An inherited axis has two different declarations.
    AXES_CONFLICT = "UG0514", "axis declared twice differently",
        "A template inherits an axis that is declared with another type or other values than its own, or two inherited templates declare it differently. One name has one meaning: give one of them another name, or make the declarations alike.";
    /// A file of axes has no template, or inherits from a template that does not exist.
    AXES_ORPHAN = "UG0515", "axes without a template",
        "A file `NAME.axes.json` has no template `NAME.wgsl.jinja` beside it, or names a template under `inherits` that does not exist.";
    /// The constraints of a template leave no valid combination of axis values.
    CONSTRAINTS_CONTRADICT = "UG0516", "contradictory constraints",
        "The constraints of a template, together with the values that are fixed, leave no combination of values at all. The diagnostic lists a smallest set of constraints that clash: without any one of them there would be a combination.";
    /// An override axis does not fit its `override` declaration in the WGSL.
    AXIS_OVERRIDE = "UG0517", "override axis",
        "An axis with `\"as\": \"override\"` becomes a pipeline-overridable constant. The WGSL must declare `override NAME` with the fitting type (`bool` for a boolean axis, `i32` or `u32` for an integer axis), and the template must not read it as a variable.\n\nBindings, array sizes in uniforms, vectors and `case` selectors cannot depend on overrides; use a template axis there.";
    /// A template compares an axis with a value that the axis cannot have.
    AXIS_COMPARED = "UG0518", "comparison with no value of an axis",
        "A template compares an axis with a word or a number that is none of the values that the axis declares: `{% if filter == \"pfc\" %}`. Such a comparison has the same outcome always, so that text is missing from every variant, or stands in each.";
    /// A part of a template does not fit to the template that it extends or imports from.
    TEMPLATES_MISFIT = "UG0519", "template does not fit to another",
        "A template that extends another has a block that the other does not have, or WGSL outside of blocks; or a template imports a macro that the other does not have. The template engine drops such text silently.\n\nThe text of a template that extends another stands in blocks: `{% extends \"forward.wgsl.jinja\" %}{% block lighting %} … {% endblock %}`. A block of its own can stand within these.";
    /// The generated WGSL does not parse in naga.
    WGSL_SYNTAX = "UG0520", "WGSL does not parse",
        "The generated WGSL is not well-formed, or names something that does not exist. The place is that of the template text which the generated text came from; the generated line is shown beside it.";
    /// The generated WGSL fails naga's validation.
    WGSL_INVALID = "UG0521", "WGSL is invalid",
        "The generated WGSL is well-formed, but breaks a rule of the language, or needs a capability that the target profile does not have.";
    /// The WGSL becomes invalid once its overrides have values.
    WGSL_OVERRIDES = "UG0522", "WGSL fails with its overrides",
        "The module is valid, but not once its pipeline-overridable constants have their values.\n\nKnown with naga 30: a function-local `let v = vec3<f32>(..)` that is read by component fails in a module with any override. Write `const v = ..` there.";
    /// naga itself fails (panics) on the generated WGSL.
    WGSL_COMPILER = "UG0523", "shader compiler failed",
        "The shader compiler (naga) failed without a message of its own on this text. That is a defect of the compiler; the diagnostic says which template provokes it.";
    /// A WGSL module exceeds a size limit.
    WGSL_TOO_LARGE = "UG0524", "WGSL too large", "One module of WGSL is limited to 4 MiB, 8,192 declarations and 32,768 statements, one expression to 8,192 operators and one function to 8,192 branches. The shader compiler would overflow its stack, or take minutes, far beyond these.";
    /// A fragment input has no vertex output with the same location, type and interpolation.
    STAGES_MISMATCH = "UG0525", "stages do not fit together",
        "The fragment stage reads a variable that the vertex stage does not write, or writes with another type or interpolation. Every user-defined input of the fragment stage is an output of the vertex stage with the same `@location`, the same type and the same `@interpolate`; outputs that nothing reads are dropped.\n\nOne structure for both, returned by the one and taken by the other, cannot disagree with itself.";
    /// The condition of a branch or loop in a fragment stage depends on uniform buffers only.
    UNIFORM_BRANCH = "UG0526", "branch on uniforms alone",
        "A branch or loop of a fragment stage has a condition that depends on uniform buffers and on nothing else. Some drivers (Mesa's among them) compile the shader once more for each value of such a uniform, which is once for each material where the uniform belongs to the material, and seconds before the first frame.\n\nLet the value be a factor (`max(visibility, 1.0 - receives)`) or the condition of a `select`; make it an override, which chooses when the pipeline is made; or let something of the fragment take part in the condition, so that no driver tries.";
    /// An operation that needs uniform control flow is in non-uniform control flow.
    NON_UNIFORM = "UG0527", "control flow is not uniform",
        "A derivative, a sample whose level comes from derivatives (`textureSample`, `textureSampleBias`, `textureSampleCompare`), a barrier, `workgroupUniformLoad` or a subgroup operation stands where some invocations of a quad or workgroup may not come, because a condition before it depends on what differs between them: inputs of the stage, writable buffers, other derivatives. Browsers reject such a module; elsewhere its values are undefined there, so for other targets than `webgpu` it is a warning.\n\nThe analysis is that of WGSL's specification, which looks at the text alone. The diagnostic says which condition it is and where the difference comes from. Sample before the branch and choose with `select`, or name the level (`textureSampleLevel`, `textureSampleGrad`, `textureSampleCompareLevel`). Where all invocations of a quad are known to go the same way nevertheless, `@diagnostic(off, derivative_uniformity)` before the function says so; of barriers there is nothing to switch off.";
    /// A function call accesses one variable in two ways, by pointers or by name, and writes to it.
    POINTER_ALIAS = "UG0528", "memory reached in two ways",
        "A call passes one variable by two pointers, or by a pointer to a function that uses the variable by its name as well, and one of the two writes. WGSL forbids it, and browsers reject the module; elsewhere the outcome is undefined, so for other targets than `webgpu` it is a warning. Variables are taken whole: pointers to two elements of one array are pointers to one variable.\n\nPass a copy of the value, or let the function return what it would have written.";
    /// A module that exceeds a limit of a target profile.
    LIMIT_EXCEEDED = "UG0530", "limit of the target exceeded",
        "The module needs more than a device of the target profile guarantees: a bind group beyond the last one, too many textures in a stage, a uniform block too large, a workgroup too large. Validation does not see these; they are checked against the reflected interface.";
    /// The code generator of a target language rejects the module.
    BACKEND_REJECTS = "UG0531", "target language cannot express this",
        "The module is valid, but cannot be written in the language of the target (SPIR-V, MSL, HLSL, GLSL). GLSL, for one, cannot load from a depth texture.";
    /// Two variants of a template declare a binding differently.
    INTERFACE_CONFLICT = "UG0540", "variants disagree about a binding",
        "The layout of a pass is the union over its variants, so two variants of a template cannot have different things at one group and binding, nor one name at two places: a texture of another type, a buffer that one reads and the other writes. What lies within a block may differ from configuration to configuration; whoever fills it is compared with every variant.\n\nAn axis that is there to choose between layouts says so in `NAME.axes.json`; variants with different values of it are not compared:\n\n```json\n{ \"axes\": { \"multisampled\": { \"type\": \"bool\", \"default\": false, \"own_layout\": true } } }\n```";
    /// No generated WGSL depends on the axis.
    AXIS_DEAD = "UG0550", "axis without effect",
        "No text of the template depends on this axis: with any value, each reachable variant is the same.";
    /// Some lines of a template appear in no variant.
    LINES_DEAD = "UG0551", "template text in no variant",
        "No reachable variant contains this text: its condition can never hold under the declared axes and constraints.";
    /// A template has too many variants to validate all of them.
    PATHS_LIMIT = "UG0552", "too many variants",
        "The template has too many variants to prove each of them, and any of the others may fail. The limits are 65,536 paths, 32,768 distinct texts and 512 MiB of them. They are eight times as high where no template is the author's own. Of an axis with more than 16,384 values only the first, the default and the last are proven.\n\nDeclare a narrower range, fewer values, or constraints between axes. An integer that is only a size takes `\"prove\": \"ends\"`; a number or switch that the WGSL can read itself takes `\"as\": \"override\"`, and costs one text. Without `--all` only the values that pipelines reach are proven, with `--set NAME=VALUE` only one configuration.";
    /// No validated configuration of the pipeline contains the pass.
    PASS_UNPROVEN = "UG0553", "pass in no proven configuration",
        "Of the configurations of the pipeline that were loaded, none has this pass: its `when` never held, or its `for_each` had no rounds. So nothing of it is proven.\n\nConfigurations are gone through in full up to 4,096. Of more, each pass is seen with every combination of the settings on which it depends, if these are up to 4,096; else with single changes, pairs of changes, and for every condition a configuration in which it holds, if a search of 20,000 steps finds one. Of numbers with more than 256 values those are tried at which conditions change, and the ends.\n\nWhere some configuration may have the pass, this is an error: name one as a preset, which is always tried; or declare a smaller range. Where it is shown that none can, it is a warning: the condition contradicts the declarations.";
    /// The command of an external validator cannot be started.
    EXTERNAL_UNAVAILABLE = "UG0560", "external validator cannot be run",
        "The command of an external validator cannot be started. It is a program and its arguments; `{}` stands for the file with the WGSL.";
    /// An external validator rejects the generated WGSL.
    EXTERNAL_REJECTS = "UG0561", "external validator rejects the WGSL",
        "The named external validator does not accept the generated WGSL, though naga does.";
    /// An external validator exceeds its time limit.
    EXTERNAL_TIMEOUT = "UG0562", "external validator timed out",
        "The external validator did not end within its time limit and was stopped.";
}
