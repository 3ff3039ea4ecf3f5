//! The grammar: textures, a buffer, and passes one after the other, with their texts and what they do.

use std::fmt::Write as _;

use umbragraph_test_support::random::Random;

/// The sample type of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Seen {
    Float,
    Unsigned,
    Depth,
}

/// Formats, how shaders see them, and whether they are storage textures.
const FORMATS: &[(&str, Seen, bool)] = &[
    ("rgba8unorm", Seen::Float, true),
    ("rgba8unorm", Seen::Float, true),
    ("rgba16float", Seen::Float, true),
    ("rgba8unorm-srgb", Seen::Float, false),
    ("r16float", Seen::Float, false),
    ("rgba32float", Seen::Float, true),
    ("r32float", Seen::Float, true),
    ("rgba8uint", Seen::Unsigned, true),
    ("r32uint", Seen::Unsigned, true),
    ("depth32float", Seen::Depth, false),
    ("depth24plus", Seen::Depth, false),
    ("rg11b10ufloat", Seen::Float, false),
];

#[derive(Clone, Debug)]
pub(crate) struct Texture {
    pub(crate) name: String,
    pub(crate) format: &'static str,
    pub(crate) seen: Seen,
    is_storage: bool,
    pub(crate) is_array: bool,
    pub(crate) has_mips: bool,
    /// Whether nothing else has its memory, so that it begins with zeros.
    pub(crate) is_kept: bool,
    samples: usize,
    pub(crate) size: &'static str,
    is_written: bool,
    /// Whether the pass at hand reads it.
    is_read: bool,
}

/// A summand of a shader.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Term {
    /// A word of the buffer.
    Word(usize),
    /// The first texel of a texture's layer.
    Load { texture: usize, layer: usize, seen: Seen },
    /// A texture where the shader stands, with the level of detail that derivatives give or the first.
    Sample { texture: usize, has_level: bool },
}

/// A color attachment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub(crate) texture: usize,
    pub(crate) adds: bool,
    pub(crate) clears: bool,
}

/// The work of a pass.
#[derive(Clone, Debug)]
pub(crate) enum Deed {
    Fill {
        sum: Vec<Term>,
        /// Whether the right half of the picture has half of the sum.
        halves: bool,
        targets: Vec<Target>,
        /// A depth attachment and what it gets.
        depth: Option<(usize, f64)>,
    },
    /// So many invocations each way store their sum in a texture, or in the words.
    Store {
        sum: Vec<Term>,
        side: usize,
        texture: Option<usize>,
    },
    Copy {
        from: usize,
        to: usize,
    },
}

pub(crate) struct Drawn {
    pub(crate) document: String,
    pub(crate) templates: Vec<(String, String)>,
    pub(crate) textures: Vec<Texture>,
    pub(crate) deeds: Vec<Deed>,
}

struct Grammar<'r> {
    random: &'r mut Random,
    textures: Vec<Texture>,
    passes: Vec<String>,
    templates: Vec<(String, String)>,
    deeds: Vec<Deed>,
}

pub(crate) fn pipeline(random: &mut Random) -> Drawn {
    let mut grammar = Grammar {
        random,
        textures: Vec::new(),
        passes: Vec::new(),
        templates: Vec::new(),
        deeds: Vec::new(),
    };
    let mut resources = vec![
        r#""target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }"#
            .to_owned(),
        r#""words": { "buffer": { "size": 1024 } }"#.to_owned(),
    ];
    for at in 0..2 + grammar.random.below(3) {
        resources.push(grammar.texture(at));
    }
    let words = r#""empty": { "clear": { "buffer": "&words" }, "side_effect": true }"#;
    grammar.passes.push(words.to_owned());
    for at in 0..2 + grammar.random.below(4) {
        grammar.pass(at);
    }
    let document = format!(
        "{{ \"format\": 1, \"name\": \"random\",\n\"resources\": {{\n{} }},\n\"passes\": {{\n{} }} }}",
        resources.join(",\n"),
        grammar.passes.join(",\n")
    );
    let Grammar { textures, templates, deeds, .. } = grammar;
    Drawn { document, templates, textures, deeds }
}

impl Grammar<'_> {
    fn texture(&mut self, at: usize) -> String {
        let (format, seen, is_storage) = self.random.one_of(FORMATS);
        let size = self.random.one_of(&["[64, 64]", "[64, 64]", "[32, 64]", "\"=viewport\""]);
        let samples = if self.random.one_in(6) { 4 } else { 1 };
        let is_array = samples == 1 && self.random.one_in(5);
        let mut more = String::new();
        if samples > 1 {
            let _ = write!(more, ", \"samples\": {samples}");
        }
        let mut has_mips = false;
        if is_array {
            more += ", \"layers\": 2";
        } else if self.random.one_in(6) {
            more += ", \"mips\": 2";
            has_mips = true;
        }
        let is_kept = self.random.one_in(2);
        if is_kept {
            let lifetime = if samples == 1 && !["depth24plus", "rg11b10ufloat"].contains(&format) {
                "imported"
            } else {
                "persistent"
            };
            let _ = write!(more, ", \"lifetime\": \"{lifetime}\"");
        }
        let name = format!("t{at}");
        let text =
            format!("\"{name}\": {{ \"texture\": {{ \"format\": \"{format}\", \"size\": {size}{more} }} }}");
        self.textures.push(Texture {
            name,
            format,
            seen,
            is_storage,
            is_array,
            has_mips,
            is_kept,
            samples,
            size,
            is_written: false,
            is_read: false,
        });
        text
    }

    /// A texture of those for which something holds, or any now and then.
    fn any(&mut self, is_meant: impl Fn(&Texture) -> bool) -> Option<usize> {
        let is_wild = self.random.one_in(14);
        let fitting: Vec<usize> =
            (0..self.textures.len()).filter(|at| is_wild || is_meant(&self.textures[*at])).collect();
        (!fitting.is_empty()).then(|| self.random.one_of(&fitting))
    }

    fn pass(&mut self, at: usize) {
        self.textures.iter_mut().for_each(|texture| texture.is_read = false);
        let body = match self.random.below(6) {
            0 => self.compute(at),
            1 => self.copy(),
            _ => self.fullscreen(at),
        };
        let Some((body, deed)) = body else { return };
        self.deeds.push(deed);
        let after = match self.passes.len() {
            1 => "empty".to_owned(),
            _ => {
                let last = self.passes.last().and_then(|pass| pass.split('"').nth(1));
                last.unwrap_or_default().to_owned()
            }
        };
        self.passes.push(format!("\"p{at}\": {{ {body}, \"after\": [\"{after}\"], \"side_effect\": true }}"));
    }

    /// The bindings of a shader: their declarations, an expression that reads each, and the JSON that binds them.
    fn inputs(&mut self, shader: &mut String, has_derivatives: bool) -> (String, Vec<String>, Vec<Term>) {
        let (mut sum, mut bind, mut terms) = ("vec4<f32>(0.25)".to_owned(), Vec::new(), Vec::new());
        for at in 0..self.random.below(3) {
            let (first, second) = (4 * at, 4 * at + 1);
            if has_derivatives && self.random.one_in(4) {
                let _ =
                    writeln!(shader, "@group(0) @binding({first}) var<storage, read> words{at}: array<u32>;");
                let word = self.random.below(4);
                let _ = write!(sum, " + vec4<f32>(f32(words{at}[{word}]))");
                terms.push(Term::Word(word));
                bind.push(format!("\"words{at}\": \"&words\""));
                continue;
            }
            let Some(index) = self.any(|texture| texture.is_written) else { continue };
            self.textures[index].is_read = true;
            let texture = self.textures[index].clone();
            let seen = if self.random.one_in(12) {
                self.random.one_of(&[Seen::Float, Seen::Unsigned, Seen::Depth])
            } else {
                texture.seen
            };
            let (ty, zero) = match (seen, texture.samples > 1, texture.is_array) {
                (Seen::Float, true, _) => ("texture_multisampled_2d<f32>", "vec2<i32>(0), 0"),
                (Seen::Unsigned, true, _) => ("texture_multisampled_2d<u32>", "vec2<i32>(0), 0"),
                (Seen::Depth, true, _) => ("texture_depth_multisampled_2d", "vec2<i32>(0), 0"),
                (Seen::Float, _, true) => ("texture_2d_array<f32>", "vec2<i32>(0), 1, 0"),
                (Seen::Unsigned, _, true) => ("texture_2d_array<u32>", "vec2<i32>(0), 0, 0"),
                (Seen::Depth, _, true) => ("texture_depth_2d_array", "vec2<i32>(0), 0, 0"),
                (Seen::Float, ..) => ("texture_2d<f32>", "vec2<i32>(0), 0"),
                (Seen::Unsigned, ..) => ("texture_2d<u32>", "vec2<i32>(0), 0"),
                (Seen::Depth, ..) => ("texture_depth_2d", "vec2<i32>(0), 0"),
            };
            let _ = writeln!(shader, "@group(0) @binding({first}) var image{at}: {ty};");
            bind.push(format!("\"image{at}\": \"&{}\"", texture.name));
            let is_plain = ty == "texture_2d<f32>";
            if is_plain && self.random.one_in(2) {
                let filter = self.random.one_of(&["linear", "linear", "nearest"]);
                let _ = writeln!(shader, "@group(0) @binding({second}) var reader{at}: sampler;");
                bind.push(format!("\"reader{at}\": {{ \"sampler\": {{ \"filter\": \"{filter}\" }} }}"));
                let has_level = !(has_derivatives && self.random.one_in(2));
                terms.push(Term::Sample { texture: index, has_level });
                let read = if !has_level {
                    format!("textureSample(image{at}, reader{at}, uv)")
                } else {
                    format!("textureSampleLevel(image{at}, reader{at}, uv, 0.0)")
                };
                let _ = write!(sum, " + {read}");
            } else {
                let _ = write!(sum, " + vec4<f32>(textureLoad(image{at}, {zero}))");
                let layer = usize::from(ty == "texture_2d_array<f32>");
                terms.push(Term::Load { texture: index, layer, seen });
            }
        }
        (sum, bind, terms)
    }

    fn fullscreen(&mut self, at: usize) -> Option<(String, Deed)> {
        let mut shader = "{% include \"lib/fullscreen.wgsl.jinja\" %}\n".to_owned();
        let (sum, bind, terms) = self.inputs(&mut shader, true);
        let mut targets = Vec::new();
        let mut color = Vec::new();
        let (mut members, mut values) = (String::new(), Vec::new());
        let mut first: Option<Texture> = None;
        for location in 0..1 + usize::from(self.random.one_in(3)) {
            let beside = first.clone();
            let index = self.any(|texture| {
                texture.seen != Seen::Depth
                    && !texture.is_read
                    && texture.format != "rg11b10ufloat"
                    && beside.as_ref().is_none_or(|other| {
                        other.name != texture.name
                            && (other.size, other.samples) == (texture.size, texture.samples)
                    })
            })?;
            let texture = self.textures[index].clone();
            self.textures[index].is_written = true;
            let ty = match (texture.seen, self.random.one_in(16)) {
                (Seen::Unsigned, false) => "vec4<u32>",
                (_, false) => "vec4<f32>",
                _ => self.random.one_of(&["vec4<u32>", "f32", "vec2<f32>", "vec4<i32>"]),
            };
            let _ = write!(members, "@location({location}) c{location}: {ty}, ");
            values.push(match ty {
                "vec4<f32>" => "sum".to_owned(),
                "f32" => "sum.x".to_owned(),
                "vec2<f32>" => "sum.xy".to_owned(),
                ty => format!("{ty}(sum)"),
            });
            let adds = self.random.one_in(6);
            let blend = if adds { ", \"blend\": \"add\"" } else { "" };
            let layer = if texture.is_array { ", \"layer\": 1" } else { "" };
            let clears = self.random.one_in(3);
            let clear = if clears { ", \"clear\": [0, 0, 0, 1]" } else { "" };
            targets.push(Target { texture: index, adds, clears });
            color.push(format!("{{ \"to\": \"&{}\"{blend}{layer}{clear} }}", texture.name));
            first.get_or_insert(texture);
        }
        let (mut depth, mut to_depth) = (String::new(), None);
        if self.random.one_in(4) {
            let beside = first.clone();
            let index = self.any(|texture| {
                texture.seen == Seen::Depth
                    && !texture.is_read
                    && beside
                        .as_ref()
                        .is_none_or(|other| (other.size, other.samples) == (texture.size, texture.samples))
            });
            if let Some(index) = index {
                self.textures[index].is_written = true;
                let texture = &self.textures[index];
                let layer = if texture.is_array { ", \"layer\": 1" } else { "" };
                depth = format!(
                    ", \"depth\": {{ \"to\": \"&{}\"{layer}, \"clear\": 1, \"compare\": \"always\", \"write\": true }}",
                    texture.name
                );
                to_depth = Some((index, 0.0));
                if self.random.one_in(2) {
                    to_depth = Some((index, 0.5));
                    members += "@builtin(frag_depth) depth: f32, ";
                    values.push("0.5".to_owned());
                }
            }
        }
        let branch_of = self.random.below(12);
        let branch = match branch_of {
            0 => "if uv.x > 0.5 { sum += vec4<f32>(dpdx(uv.y)); }",
            1 => "if uv.x > 0.5 { sum *= 0.5; }",
            _ => "",
        };
        let _ = write!(
            shader,
            "struct Out {{ {members} }}\n@fragment fn paint(covered: Covered) -> Out {{\n    let uv = covered.uv;\n    var sum = {sum};\n    {branch}\n    return Out({});\n}}\n",
            values.join(", ")
        );
        let name = format!("own{at}.wgsl.jinja");
        self.templates.push((name.clone(), shader));
        let text = format!(
            "\"fullscreen\": {{ \"shader\": \"{name}\", \"bind\": {{ {} }}, \"color\": [{}]{depth} }}",
            bind.join(", "),
            color.join(", ")
        );
        Some((text, Deed::Fill { sum: terms, halves: branch_of == 1, targets, depth: to_depth }))
    }

    fn compute(&mut self, at: usize) -> Option<(String, Deed)> {
        let mut shader = String::new();
        let (sum, mut bind, terms) = self.inputs(&mut shader, false);
        let mut into = None;
        let over = if let Some(index) =
            self.any(|one| one.is_storage && !one.is_read && one.samples == 1 && !one.is_array)
        {
            let texture = self.textures[index].clone();
            self.textures[index].is_written = true;
            into = Some(index);
            let format = if self.random.one_in(14) { "rgba8unorm" } else { texture.format };
            let access = self.random.one_of(&["write", "write", "write", "read_write"]);
            let value = if texture.seen == Seen::Unsigned { "vec4<u32>(sum)" } else { "sum" };
            let _ =
                writeln!(shader, "@group(1) @binding(0) var result: texture_storage_2d<{format}, {access}>;");
            bind.push(format!("\"result\": \"&{}\"", texture.name));
            format!("textureStore(result, id.xy, {value});")
        } else {
            shader += "@group(1) @binding(0) var<storage, read_write> result: array<u32>;\n";
            bind.push("\"result\": \"&words\"".to_owned());
            "result[id.x] = u32(sum.x);".to_owned()
        };
        let side = self.random.one_of(&[8, 8, 8, 4, 16, 32]);
        let _ = write!(
            shader,
            "@compute @workgroup_size({side}, {side}) fn fill(@builtin(global_invocation_id) id: vec3<u32>) {{\n    let uv = vec2<f32>(id.xy) / 64.0;\n    var sum = {sum};\n    {over}\n}}\n"
        );
        let name = format!("own{at}.wgsl.jinja");
        self.templates.push((name.clone(), shader));
        let text = format!(
            "\"compute\": {{ \"shader\": \"{name}\", \"bind\": {{ {} }}, \"workgroups\": [8, 8, 1] }}",
            bind.join(", ")
        );
        Some((text, Deed::Store { sum: terms, side: 8 * side, texture: into }))
    }

    fn copy(&mut self) -> Option<(String, Deed)> {
        let from = self.any(|texture| texture.is_written)?;
        let of = self.textures[from].clone();
        let to = self.any(|texture| {
            texture.name != of.name
                && (texture.format, texture.size, texture.samples, texture.is_array)
                    == (of.format, of.size, of.samples, of.is_array)
        })?;
        self.textures[to].is_written = true;
        let into = &self.textures[to].name;
        let text = format!(
            "\"copy\": {{ \"from\": {{ \"name\": \"&{}\" }}, \"to\": {{ \"name\": \"&{into}\" }} }}",
            of.name
        );
        Some((text, Deed::Copy { from, to }))
    }
}
