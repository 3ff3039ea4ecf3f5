//! Random modules: helpers that take values and pointers, one entry point, branches and loops in one another, and in
//! them what needs uniform control flow.
//!
//! Whatever is drawn is well-formed for the types alone; whether it is uniform is left to chance. Conditions are drawn
//! from uniform and from differing values alike, so that about as many modules pass as fail.

use std::fmt::Write as _;

use umbragraph_test_support::random::Random;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Fragment,
    Compute,
    Subgroups,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    Float,
    Unsigned,
}

impl Type {
    fn name(self) -> &'static str {
        match self {
            Self::Float => "f32",
            Self::Unsigned => "u32",
        }
    }
}

/// A name in scope of the generated code.
#[derive(Clone, Debug)]
struct Name {
    name: String,
    ty: Type,
    /// The kind of assignable place; `None` if the name is read-only.
    place: Option<Place>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Variable,
    Pointer,
    Member,
}

#[derive(Clone, Debug)]
struct Helper {
    name: String,
    parameters: Vec<(Type, bool)>,
    result: Option<Type>,
}

/// Expressions that may differ between invocations at the start of an entry point.
const INPUTS: [&str; 4] = ["input.u", "input.f", "at.x", "local"];

struct Module<'r> {
    random: &'r mut Random,
    kind: Kind,
    text: String,
    helpers: Vec<Helper>,
    scope: Vec<Name>,
    names: usize,
    result: Option<Type>,
    is_entry: bool,
    aliases: bool,
    /// The remaining number of operations that need uniform control flow. It is low, since one violation can hide
    /// others.
    demanding: usize,
}

/// Generates a random module. With `aliases`, one variable may be passed twice in a call.
pub(super) fn module(random: &mut Random, kind: Kind, aliases: bool) -> String {
    let mut module = Module {
        random,
        kind,
        text: String::new(),
        helpers: Vec::new(),
        scope: Vec::new(),
        names: 0,
        result: None,
        is_entry: false,
        aliases,
        demanding: 0,
    };
    module.demanding = 1 + module.random.below(3);
    module.head();
    for _ in 0..module.random.below(3) {
        module.helper();
    }
    module.entry();
    module.text
}

impl Module<'_> {
    fn one_in(&mut self, of: usize) -> bool {
        self.random.below(of) == 0
    }

    fn line(&mut self, depth: usize, text: impl AsRef<str>) {
        let _ = writeln!(self.text, "{}{}", "    ".repeat(depth), text.as_ref());
    }

    fn fresh(&mut self, of: &str) -> String {
        self.names += 1;
        format!("{of}{}", self.names)
    }

    fn ty(&mut self) -> Type {
        if self.one_in(2) { Type::Float } else { Type::Unsigned }
    }

    fn head(&mut self) {
        if self.kind == Kind::Subgroups {
            self.line(0, "enable subgroups;");
        }
        if self.kind == Kind::Fragment && self.one_in(12) {
            let severity = ["off", "warning", "info", "error"][self.random.below(4)];
            self.line(0, format!("diagnostic({severity}, derivative_uniformity);"));
        }
        self.text.push_str(
            "struct Block { flag: u32, count: u32, scale: f32, list: array<vec4<f32>, 4> }
struct Pair { a: f32, b: u32 }
@group(0) @binding(0) var<uniform> block: Block;
@group(0) @binding(1) var<storage, read> numbers: array<u32>;
@group(0) @binding(2) var<storage, read_write> cells: array<u32>;
@group(0) @binding(3) var image: texture_2d<f32>;
@group(0) @binding(4) var plain: sampler;
@group(0) @binding(5) var depths: texture_depth_2d;
@group(0) @binding(6) var comparing: sampler_comparison;
@group(0) @binding(7) var written: texture_storage_2d<r32float, read_write>;
@group(0) @binding(8) var<storage, read_write> counter: atomic<u32>;
override chosen: bool = true;
const four = 4u;
var<private> own: f32;
",
        );
        if self.kind != Kind::Fragment {
            self.line(0, "var<workgroup> together: u32;\nvar<workgroup> several: array<u32, 4>;");
        }
    }

    fn helper(&mut self) {
        let name = self.fresh("helper");
        let parameters: Vec<(Type, bool)> =
            (0..self.random.below(4)).map(|_| (self.ty(), self.one_in(3))).collect();
        let result = (!self.one_in(3)).then(|| self.ty());
        self.scope.clear();
        let mut list = Vec::new();
        for (ty, is_pointer) in &parameters {
            let (name, of) = (self.fresh("p"), ty.name());
            list.push(if *is_pointer {
                format!("{name}: ptr<function, {of}>")
            } else {
                format!("{name}: {of}")
            });
            self.scope.push(Name { name, ty: *ty, place: is_pointer.then_some(Place::Pointer) });
        }
        let arrow = result.map_or(String::new(), |ty| format!(" -> {}", ty.name()));
        if self.kind == Kind::Fragment && self.one_in(10) {
            self.line(0, "@diagnostic(off, derivative_uniformity)");
        }
        self.line(0, format!("fn {name}({}){arrow} {{", list.join(", ")));
        (self.result, self.is_entry) = (result, false);
        self.body(0, false);
        if let Some(ty) = result {
            let value = self.value(ty, 2);
            self.line(1, format!("return {value};"));
        }
        self.line(0, "}");
        self.helpers.push(Helper { name, parameters, result });
    }

    fn entry(&mut self) {
        self.scope.clear();
        (self.result, self.is_entry) = (None, true);
        let value = |name: &str, ty| Name { name: name.to_owned(), ty, place: None };
        if self.kind == Kind::Fragment {
            self.scope = vec![
                value("input.u", Type::Float),
                value("input.f", Type::Unsigned),
                value("at.x", Type::Float),
            ];
            self.line(0, "struct Input { @location(0) u: f32, @location(1) @interpolate(flat) f: u32 }");
            self.line(0, "@fragment fn main(input: Input, @builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {");
            self.body(0, false);
            let value = self.value(Type::Float, 2);
            self.line(1, format!("return vec4<f32>({value});"));
        } else {
            self.scope = vec![
                value("local", Type::Unsigned),
                value("group.x", Type::Unsigned),
                value("many.y", Type::Unsigned),
            ];
            let groups = if self.one_in(2) {
                self.line(0, "struct Groups { @builtin(workgroup_id) id: vec3<u32>, @builtin(num_workgroups) many: vec3<u32> }");
                self.scope.push(value("groups.id.x", Type::Unsigned));
                ", groups: Groups"
            } else {
                self.line(0, "struct Mixed { @builtin(workgroup_id) id: vec3<u32>, @builtin(global_invocation_id) at: vec3<u32> }");
                self.scope.push(value("mixed.id.x", Type::Unsigned));
                ", mixed: Mixed"
            };
            let plain = if groups.contains("Groups") {
                self.scope.retain(|name| !name.name.starts_with("group.") && !name.name.starts_with("many."));
                ""
            } else {
                self.scope.retain(|name| !name.name.starts_with("group."));
                ", @builtin(num_workgroups) many: vec3<u32>"
            };
            self.line(0, format!("@compute @workgroup_size(8) fn main(@builtin(local_invocation_index) local: u32{plain}{groups}) {{"));
            self.body(0, false);
        }
        self.line(0, "}");
    }

    /// Generates the statements of a block. Names that are declared in the block leave the scope at its end.
    fn body(&mut self, depth: usize, in_loop: bool) {
        let known = self.scope.len();
        for _ in 0..1 + self.random.below(if depth == 0 { 6 } else { 2 }) {
            self.statement(depth + 1, in_loop);
        }
        self.scope.truncate(known);
    }

    fn statement(&mut self, depth: usize, in_loop: bool) {
        let deep = depth > 4;
        match self.random.below(if deep { 9 } else { 16 }) {
            0 | 1 => {
                let (ty, name) = (self.ty(), self.fresh("v"));
                let value = self.value(ty, 2);
                match self.random.below(4) {
                    0 => {
                        self.line(depth, format!("let {name} = {value};"));
                        self.scope.push(Name { name, ty, place: None });
                    }
                    1 => {
                        self.line(depth, format!("var {name}: Pair;"));
                        for (member, ty) in [("a", Type::Float), ("b", Type::Unsigned)] {
                            let name = format!("{name}.{member}");
                            self.scope.push(Name { name, ty, place: Some(Place::Member) });
                        }
                    }
                    _ => {
                        let of = ty.name();
                        let initial = if self.one_in(4) { String::new() } else { format!(" = {value}") };
                        self.line(depth, format!("var {name}: {of}{initial};"));
                        self.scope.push(Name { name, ty, place: Some(Place::Variable) });
                    }
                }
            }
            2 | 3 => {
                if let Some(to) = self.any(|name| name.place.is_some()) {
                    let value = self.value(to.ty, 2);
                    let op = ["=", "+=", "="][self.random.below(3)];
                    self.line(depth, format!("{} {op} {value};", reference(&to)));
                }
            }
            4 | 5 => self.demanding(depth),
            6 => self.called(depth),
            7 => match self.random.below(5) {
                0 => {
                    let value = self.value(Type::Unsigned, 1);
                    self.line(depth, format!("cells[{value}] = 1u;"));
                }
                1 => {
                    let value = self.value(Type::Float, 1);
                    self.line(depth, format!("own = {value};"));
                }
                2 => {
                    let value = self.value(Type::Float, 2);
                    self.line(depth, format!("_ = {value};"));
                }
                3 if self.kind == Kind::Fragment => {
                    let condition = self.condition(1);
                    self.line(depth, format!("if {condition} {{ discard; }}"));
                }
                _ => {
                    if let Some(of) = self.any(|name| name.place == Some(Place::Variable)) {
                        let name = self.fresh("to");
                        self.line(depth, format!("let {name} = &{};", of.name));
                        self.scope.push(Name { name, ty: of.ty, place: Some(Place::Pointer) });
                    }
                }
            },
            8 => {
                let condition = self.condition(2);
                let exit = match (in_loop, self.result, self.is_entry) {
                    (true, ..) if self.one_in(2) => {
                        if self.one_in(2) {
                            "break;".to_owned()
                        } else {
                            "continue;".to_owned()
                        }
                    }
                    (_, _, true) if self.kind == Kind::Fragment => "return vec4<f32>(0.5);".to_owned(),
                    (_, None, _) => "return;".to_owned(),
                    (_, Some(ty), _) => format!("return {};", self.value(ty, 1)),
                };
                self.line(depth, format!("if {condition} {{ {exit} }}"));
            }
            9..=11 => {
                let condition = self.condition(2);
                self.line(depth, format!("if {condition} {{"));
                self.body(depth, in_loop);
                if self.one_in(2) {
                    self.line(depth, "} else {");
                    self.body(depth, in_loop);
                }
                self.line(depth, "}");
            }
            12 => {
                let selector = self.value(Type::Unsigned, 2);
                self.line(depth, format!("switch {selector} {{"));
                for case in ["case 1u, 2u", "case 3u", "default"] {
                    self.line(depth + 1, format!("{case}: {{"));
                    self.body(depth + 1, in_loop);
                    if self.one_in(4) {
                        let condition = self.condition(1);
                        self.line(depth + 2, format!("if {condition} {{ break; }}"));
                    }
                    self.line(depth + 1, "}");
                }
                self.line(depth, "}");
            }
            13 => {
                let (name, until) = (self.fresh("n"), self.value(Type::Unsigned, 1));
                self.line(depth, format!("for (var {name} = 0u; {name} < {until}; {name}++) {{"));
                self.scope.push(Name { name, ty: Type::Unsigned, place: None });
                self.body(depth, true);
                self.scope.pop();
                self.line(depth, "}");
            }
            14 => {
                let condition = self.condition(2);
                self.line(depth, format!("while {condition} {{"));
                self.body(depth, true);
                self.line(depth, "}");
            }
            _ => {
                self.line(depth, "loop {");
                let condition = self.condition(2);
                let ends_within = self.one_in(2);
                if ends_within {
                    self.line(depth + 1, format!("if {condition} {{ break; }}"));
                }
                self.body(depth, true);
                self.line(depth + 1, "continuing {");
                let known = self.scope.len();
                if let Some(to) = self.any(|name| name.place.is_some()) {
                    let value = self.value(to.ty, 1);
                    self.line(depth + 2, format!("{} = {value};", reference(&to)));
                }
                if self.one_in(3) {
                    self.demanding(depth + 2);
                }
                if !ends_within {
                    let condition = self.condition(1);
                    self.line(depth + 2, format!("break if {condition};"));
                }
                self.scope.truncate(known);
                self.line(depth + 1, "}");
                self.line(depth, "}");
            }
        }
    }

    /// Writes an operation that needs uniform control flow.
    fn demanding(&mut self, depth: usize) {
        if self.demanding == 0 {
            return;
        }
        self.demanding -= 1;
        let name = self.fresh("r");
        let is_subgroup = self.kind == Kind::Subgroups && self.one_in(2);
        let (ty, text) = match self.kind {
            Kind::Fragment => {
                let at = self.value(Type::Float, 1);
                match self.random.below(6) {
                    0 => (Type::Float, format!("dpdx({at})")),
                    1 => (Type::Float, format!("fwidth({at})")),
                    2 => (Type::Float, format!("textureSample(image, plain, vec2<f32>({at})).x")),
                    3 => (Type::Float, format!("textureSampleBias(image, plain, vec2<f32>({at}), 1.0).y")),
                    4 => (
                        Type::Float,
                        format!("textureSampleCompare(depths, comparing, vec2<f32>({at}), 0.5)"),
                    ),
                    _ => (Type::Float, format!("textureSampleLevel(image, plain, vec2<f32>({at}), 0.0).x")),
                }
            }
            _ if is_subgroup => {
                let (value, by) = (self.value(Type::Unsigned, 1), self.value(Type::Unsigned, 1));
                match self.random.below(5) {
                    0 => (Type::Unsigned, format!("subgroupAdd({value})")),
                    1 => (Type::Unsigned, format!("subgroupBroadcastFirst({value})")),
                    2 => (Type::Unsigned, format!("subgroupShuffleXor({value}, {by})")),
                    3 => (Type::Unsigned, format!("subgroupShuffle({value}, {by})")),
                    _ => (Type::Unsigned, format!("subgroupBallot({value} > 1u).x")),
                }
            }
            _ => match self.random.below(4) {
                0 => (Type::Unsigned, "workgroupUniformLoad(&together)".to_owned()),
                1 => {
                    let at = self.value(Type::Unsigned, 1);
                    (Type::Unsigned, format!("workgroupUniformLoad(&several[{at} % 4u])"))
                }
                2 => return self.line(depth, "storageBarrier();"),
                _ => return self.line(depth, "workgroupBarrier();"),
            },
        };
        self.line(depth, format!("let {name} = {text};"));
        self.scope.push(Name { name, ty, place: None });
    }

    fn called(&mut self, depth: usize) {
        if self.helpers.is_empty() {
            return;
        }
        let helper = self.helpers[self.random.below(self.helpers.len())].clone();
        let Some(arguments) = self.arguments(&helper) else { return };
        let call = format!("{}({arguments})", helper.name);
        match helper.result {
            Some(ty) => {
                let name = self.fresh("r");
                self.line(depth, format!("let {name} = {call};"));
                self.scope.push(Name { name, ty, place: None });
            }
            None => self.line(depth, format!("{call};")),
        }
    }

    fn arguments(&mut self, helper: &Helper) -> Option<String> {
        let mut taken: Vec<String> = Vec::new();
        let mut list = Vec::new();
        for (ty, is_pointer) in &helper.parameters {
            if !is_pointer {
                list.push(self.value(*ty, 1));
                continue;
            }
            let aliases = self.aliases && self.one_in(2);
            let free = |name: &Name| {
                let known = taken.contains(&name.name);
                // What a pointer points to may be any variable of the function.
                let is_variable = name.place == Some(Place::Variable) || (aliases && name.place.is_some());
                name.ty == *ty && is_variable && (aliases || !known) && !name.name.contains('.')
            };
            let to = self.any(free)?;
            taken.push(to.name.clone());
            list.push(if to.place == Some(Place::Pointer) { to.name } else { format!("&{}", to.name) });
        }
        Some(list.join(", "))
    }

    fn any(&mut self, is_meant: impl Fn(&Name) -> bool) -> Option<Name> {
        let fitting: Vec<&Name> = self.scope.iter().filter(|name| is_meant(name)).collect();
        if fitting.is_empty() {
            return None;
        }
        let one = fitting[self.random.below(fitting.len())].clone();
        // What differs is not everywhere, or hardly a module would pass.
        if INPUTS.contains(&one.name.as_str()) && !self.one_in(3) { None } else { Some(one) }
    }

    fn condition(&mut self, depth: usize) -> String {
        if depth > 0 && self.one_in(3) {
            let (left, right) = (self.condition(depth - 1), self.condition(depth - 1));
            return format!("({left} {} {right})", ["&&", "||", "&", "|"][self.random.below(4)]);
        }
        match self.random.below(5) {
            0 => "chosen".to_owned(),
            1 => format!("({} > 0.5)", self.value(Type::Float, depth)),
            _ => {
                let (left, right) = (self.value(Type::Unsigned, depth), self.value(Type::Unsigned, 0));
                format!("({left} {} {right})", ["==", "<=", "!="][self.random.below(3)])
            }
        }
    }

    fn value(&mut self, ty: Type, depth: usize) -> String {
        if depth > 0 && self.one_in(3) {
            let (left, right) = (self.value(ty, depth - 1), self.value(ty, depth - 1));
            return match self.random.below(3) {
                0 => format!("({left} + {right})"),
                1 => format!("max({left}, {right})"),
                _ => format!("select({left}, {right}, {})", self.condition(depth - 1)),
            };
        }
        if depth > 0 && self.one_in(6) {
            let returning = |helper: &&Helper| {
                helper.result == Some(ty) && helper.parameters.iter().all(|(_, is_pointer)| !is_pointer)
            };
            let fitting: Vec<Helper> = self.helpers.iter().filter(returning).cloned().collect();
            if !fitting.is_empty() {
                let helper = fitting[self.random.below(fitting.len())].clone();
                if let Some(arguments) = self.arguments(&helper) {
                    return format!("{}({arguments})", helper.name);
                }
            }
        }
        if !self.one_in(3)
            && let Some(name) = self.any(|name| name.ty == ty)
        {
            return reference(&name);
        }
        match ty {
            Type::Float => match self.random.below(24) {
                0..=2 => "block.scale".to_owned(),
                3 => format!("block.list[{} % 4u].x", self.value(Type::Unsigned, 0)),
                4 => "own".to_owned(),
                5 => "textureLoad(written, vec2<i32>(1, 1)).x".to_owned(),
                6 => "textureLoad(image, vec2<i32>(1, 1), 0).x".to_owned(),
                7 if depth > 0 => format!("f32({})", self.value(Type::Unsigned, depth - 1)),
                _ => "0.25".to_owned(),
            },
            Type::Unsigned => match self.random.below(28) {
                0..=2 => "block.flag".to_owned(),
                3 => format!("numbers[{}]", self.value(Type::Unsigned, 0)),
                4 => "cells[1]".to_owned(),
                5 => "arrayLength(&cells)".to_owned(),
                6 => "four".to_owned(),
                7 => "atomicAdd(&counter, 1u)".to_owned(),
                8 if self.kind != Kind::Fragment => "together".to_owned(),
                9 if depth > 0 => format!("u32({})", self.value(Type::Float, depth - 1)),
                _ => "3u".to_owned(),
            },
        }
    }
}

fn reference(name: &Name) -> String {
    match name.place {
        Some(Place::Pointer) => format!("(*{})", name.name),
        _ => name.name.clone(),
    }
}
