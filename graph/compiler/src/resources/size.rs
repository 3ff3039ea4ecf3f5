//! Sizes: expressions over the viewport and other resources, evaluated when both are known.
//!
//! A size may name other resources, so resources are evaluated on demand; one whose size depends on itself is a
//! diagnostic. A width, height, layer or mip count that is not whole is rounded down; zero, or more than the profile's
//! limits allow, is a diagnostic.
//!
//! All expressions of one plan are evaluated in one scope, so one text has one value: each distinct text is parsed and
//! evaluated once. Sizes that lead through more than [`MAX_STEPS`] other resources are rejected.

use std::cell::{Cell, OnceCell, RefCell};
use std::collections::{BTreeMap, HashMap, HashSet};

use crate::request::texture_size::TextureSize;
use crate::resources::texture_rules;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_pipeline::document;
use umbragraph_pipeline::expression::{self, ExpressionError, Scope, Value};
use umbragraph_pipeline::language::{Expr, TextureShape};
use umbragraph_pipeline::pipeline::{
    Resource, ResourceKind, StaticScope, TypedPipeline, expression_diagnostic,
};
use umbragraph_pipeline::source::Sources;
use umbragraph_pipeline::work::{Deferred, ResourceHandle};

/// The maximum depth of sizes that refer to the sizes of other resources. It bounds the recursion of the evaluation.
const MAX_STEPS: u32 = 64;

/// The size of a resource: texture extent, buffer size in bytes, or none for blackboard (CPU) data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Size {
    Texture(TextureSize),
    Buffer(u64),
    Blackboard,
}

#[derive(Clone, Copy)]
enum State {
    Unknown,
    InProgress,
    Known(Size),
    Failed,
}

/// Evaluates sizes and other deferred expressions for one viewport.
pub(crate) struct Sizes<'a> {
    pipeline: &'a TypedPipeline,
    sources: &'a Sources,
    viewport: [u32; 2],
    scope: StaticScope,
    states: RefCell<Vec<State>>,
    diagnostics: RefCell<Diagnostics>,
    /// The sizes of imported textures, by resource index; `None` where the host gave no description.
    imported: Vec<Option<TextureSize>>,
    /// The sizes that CPU passes publish with blackboard data, by `DATA.SIZE`; sizes not listed keep their initial
    /// values.
    data_sizes: &'a BTreeMap<String, u32>,
    /// The values of expressions outside subgraphs that were evaluated so far, by expression source.
    values: RefCell<HashMap<&'a str, Value>>,
    names: OnceCell<HashMap<&'a str, ResourceHandle>>,
    steps: Cell<u32>,
    /// Live parameters, and what follows from them.
    live: HashSet<&'a str>,
}

impl<'a> Sizes<'a> {
    pub(crate) fn new(
        pipeline: &'a TypedPipeline,
        sources: &'a Sources,
        viewport: [u32; 2],
        imported: Vec<Option<TextureSize>>,
        data_sizes: &'a BTreeMap<String, u32>,
    ) -> Self {
        Self {
            data_sizes,
            pipeline,
            sources,
            viewport,
            scope: pipeline.scope(),
            states: RefCell::new(vec![State::Unknown; pipeline.resources.len()]),
            diagnostics: RefCell::new(Diagnostics::new()),
            imported,
            values: RefCell::new(HashMap::new()),
            names: OnceCell::new(),
            steps: Cell::new(0),
            live: live(pipeline),
        }
    }

    /// Returns `true` if a name is a live parameter, or a value that follows from a live parameter.
    pub(crate) fn is_live(&self, name: &str) -> bool {
        self.live.contains(name)
    }

    /// Removes and returns the diagnostics so far.
    pub(crate) fn take_diagnostics(&self) -> Diagnostics {
        std::mem::take(&mut *self.diagnostics.borrow_mut())
    }

    /// The size of a resource; `None` after a diagnostic.
    pub(crate) fn of(&self, handle: ResourceHandle) -> Option<Size> {
        // The frames of a history are all of one size, and what is wrong with it is said once.
        let handle = self.pipeline.resource(handle).history.map_or(handle, |history| history.of);
        let state = self.states.borrow()[handle.index()];
        let (why, help) = match state {
            State::Known(size) => return Some(size),
            State::Failed => return None,
            State::InProgress => {
                ("depends on itself".to_owned(), "give one of the resources a size of its own")
            }
            State::Unknown if self.steps.get() >= MAX_STEPS => {
                let why = format!("is reached over more than {MAX_STEPS} other resources");
                (why, "say the size with a parameter")
            }
            State::Unknown => {
                self.states.borrow_mut()[handle.index()] = State::InProgress;
                self.steps.set(self.steps.get() + 1);
                let size = self.evaluate_size(handle);
                self.steps.set(self.steps.get() - 1);
                let already_failed = matches!(self.states.borrow()[handle.index()], State::Failed);
                let state = size.filter(|_| !already_failed).map_or(State::Failed, State::Known);
                self.states.borrow_mut()[handle.index()] = state;
                return size.filter(|_| !already_failed);
            }
        };
        self.states.borrow_mut()[handle.index()] = State::Failed;
        let resource = self.pipeline.resource(handle);
        let message = format!("the size of \"{}\" {why}", resource.name);
        self.reject_at(codes::SIZE_CYCLE, resource, "/texture/size", message, help)
    }

    /// The size of a texture; `None` after a diagnostic, or if the resource is no texture.
    pub(crate) fn texture(&self, handle: ResourceHandle) -> Option<TextureSize> {
        match self.of(handle)? {
            Size::Texture(size) => Some(size),
            _ => None,
        }
    }

    /// Evaluates a deferred expression; `None` after a diagnostic, which points at the place of the expression.
    pub(crate) fn value(&self, deferred: &Deferred) -> Option<Value> {
        let Deferred { expression, place, pointer } = deferred;
        match expression::evaluate(expression, self) {
            Ok(value) => Some(value),
            Err(error) => {
                let raw = self.sources.text(*place).trim_matches('"');
                // A text with escapes reads otherwise than it is written.
                let text = if raw.contains('\\') { String::new() } else { raw.to_owned() };
                let value = document::Value { span: *place, kind: document::Kind::Text(text) };
                if let Some(diagnostic) = expression_diagnostic(&error, &value, pointer) {
                    self.reject(&error, diagnostic);
                }
                None
            }
        }
    }

    /// Reports an error of an expression, unless it only follows from another diagnostic.
    fn reject(&self, error: &ExpressionError, diagnostic: Diagnostic) {
        // A name that exists has no value only where its own declaration has a diagnostic, which is enough.
        let follows = error.unknown.as_ref().is_some_and(|unknown| {
            let name = unknown.name.as_str();
            let head = name.rsplit_once('.').map_or(name, |(head, _)| head);
            let handle = self.named(name).or_else(|| self.named(head));
            handle.is_some_and(|handle| self.of(handle).is_none())
        });
        if !follows {
            self.diagnostics.borrow_mut().push(diagnostic);
        }
    }

    fn evaluate_size(&self, handle: ResourceHandle) -> Option<Size> {
        let pipeline: &'a TypedPipeline = self.pipeline;
        let resource = pipeline.resource(handle);
        match &resource.kind {
            ResourceKind::Data(_) => Some(Size::Blackboard),
            ResourceKind::Broken => None,
            ResourceKind::Buffer(buffer) => {
                let bytes = self.number(resource, &buffer.size, "/buffer/size")?;
                let limit = self.pipeline.profile.limits.max_buffer_size as f64;
                if !(1.0..=limit).contains(&bytes) {
                    let message = format!("the buffer \"{}\" has {bytes} bytes", resource.name);
                    let help = format!("1 to {limit} are possible");
                    return self.reject_at(codes::SIZE_LIMIT, resource, "/buffer/size", message, &help);
                }
                Some(Size::Buffer((bytes as u64).next_multiple_of(4)))
            }
            ResourceKind::Texture(texture) => {
                if let Some(size) = self.imported.get(handle.index()).copied().flatten() {
                    return Some(Size::Texture(size));
                }
                let sides = self.value_of(resource, &texture.size, "/texture/size")?.numbers();
                let Some([width, height]) = sides.as_deref() else {
                    let message = format!("the size of \"{}\" is not a width and a height", resource.name);
                    let help = match sides.as_deref() {
                        Some([width, height, depth]) => format!(
                            "a volume is \"size\": [{width}, {height}], \"layers\": {depth}, \"view_dimension\": \"3d\""
                        ),
                        _ => "write [width, height], or \"=viewport\"".to_owned(),
                    };
                    return self.reject_at(codes::SIZE_LIMIT, resource, "/texture/size", message, &help);
                };
                let limits = &self.pipeline.profile.limits;
                let volume = texture.view_dimension == Some(TextureShape::D3);
                let (side, deep) = match volume {
                    true => (limits.max_texture_dimension_3d, limits.max_texture_dimension_3d),
                    false => (limits.max_texture_dimension_2d, limits.max_texture_array_layers),
                };
                let whole = |value: f64, limit: u32, what: &str, pointer: &str| -> Option<u32> {
                    let value = value.floor();
                    if (1.0..=f64::from(limit)).contains(&value) {
                        return Some(value as u32);
                    }
                    let message = format!("the {what} of \"{}\" is {value}", resource.name);
                    let help = match what {
                        "mip count" => format!("{width} by {height} texels have up to {limit} mips"),
                        "sample count" => "1 and 4 are possible".to_owned(),
                        "width" | "height" if value < 1.0 => {
                            "a side is at least one texel, as in \"=max(viewport.width / 4, 1)\"".to_owned()
                        }
                        _ => {
                            format!("1 to {limit} are possible on the profile {}", self.pipeline.profile.name)
                        }
                    };
                    self.reject_at(codes::SIZE_LIMIT, resource, pointer, message, &help)
                };
                if *width < 1.0 && *height < 1.0 {
                    let message = format!("the size of \"{}\" is {width} by {height}", resource.name);
                    let help = "a side is at least one texel, as in \"=max(viewport.width / 4, 1)\"";
                    return self.reject_at(codes::SIZE_LIMIT, resource, "/texture/size", message, help);
                }
                let width_whole = whole(*width, side, "width", "/texture/size");
                let height_whole = whole(*height, side, "height", "/texture/size");
                let optional = |expr: &'a Option<Expr>, limit: u32, what: &str, pointer: &str| match expr {
                    Some(expr) => whole(self.number(resource, expr, pointer)?, limit, what, pointer),
                    None => Some(1),
                };
                let layers = optional(&texture.layers, deep, "layer count", "/texture/layers");
                let samples = optional(&texture.samples, 4, "sample count", "/texture/samples");
                let (width, height, layers, samples) = (width_whole?, height_whole?, layers?, samples?);
                let max = width.max(height).max(if volume { layers } else { 1 }).ilog2() + 1;
                let mips = optional(&texture.mips, max, "mip count", "/texture/mips")?;
                if samples != 1 && samples != 4 {
                    let message = format!("the sample count of \"{}\" is {samples}", resource.name);
                    let help = "1 and 4 are possible";
                    return self.reject_at(codes::SIZE_LIMIT, resource, "/texture/samples", message, help);
                }
                if matches!(texture.view_dimension, Some(TextureShape::Cube | TextureShape::CubeArray))
                    && (layers % 6 != 0 || width != height)
                {
                    let message =
                        format!("the cube \"{}\" is {width} by {height} with {layers} layers", resource.name);
                    let help = "cubes are square and have six layers each";
                    return self.reject_at(codes::SIZE_LIMIT, resource, "/texture", message, help);
                }
                let size = TextureSize { width, height, layers, mips, samples };
                if let Some(rejected) = texture_rules::of_size(&resource.name, texture, size) {
                    let (pointer, message, help) = rejected;
                    return self.reject_at(codes::DEVICE_RULE, resource, pointer, message, help);
                }
                Some(Size::Texture(size))
            }
        }
    }

    /// The number that an expression of a resource yields; `None` after a diagnostic.
    pub(crate) fn number(&self, resource: &Resource, expr: &'a Expr, pointer: &str) -> Option<f64> {
        match self.value_of(resource, expr, pointer)? {
            Value::Number(number) => Some(number),
            other => {
                let message = format!("a number is wanted here, this is {}", other.kind_name());
                let help = "make the expression yield a number";
                self.reject_at(codes::EXPRESSION_TYPE, resource, pointer, message, help)
            }
        }
    }

    /// The value of an expression of a resource; `None` after a diagnostic.
    pub(crate) fn value_of(&self, resource: &Resource, expr: &'a Expr, pointer: &str) -> Option<Value> {
        if let Some(value) = literal(&expr.0) {
            return Some(value);
        }
        let text = expr.0.as_str();
        // At the top of a pipeline every name means one thing; inside a subgraph it depends on the instance.
        let text = text.filter(|_| resource.environment.is_top());
        if let Some(value) = text.and_then(|text| self.values.borrow().get(text).cloned()) {
            return Some(value);
        }
        let environment = &resource.environment;
        let value = expr.parse().and_then(|expression| {
            environment.check_words(&expression, self)?;
            let expression = environment.close(&expression, &|name| self.named(name).is_some());
            expression::evaluate(&expression, self)
        });
        let value = match value {
            Ok(value) => value,
            Err(mut error) => {
                let names = self.pipeline.resources.iter().map(|resource| resource.name.as_str());
                let unknown = error.unknown.as_ref();
                let argument_error =
                    unknown.and_then(|one| environment.argument_error(&one.name, names.clone()));
                environment.widen(&mut error, names);
                let value = resource.value.nearest(pointer);
                let pointer = format!("{}{pointer}", resource.pointer);
                let own = || Some(environment.told(expression_diagnostic(&error, value, &pointer)?));
                if let Some(diagnostic) = argument_error.or_else(own) {
                    self.reject(&error, diagnostic);
                }
                return None;
            }
        };
        if let Some(text) = text {
            self.values.borrow_mut().insert(text, value.clone());
        }
        Some(value)
    }

    fn named(&self, name: &str) -> Option<ResourceHandle> {
        self.names.get_or_init(|| self.by_name()).get(name).copied()
    }

    /// Returns the resource handles by name. If two resources have one name, the first counts.
    fn by_name(&self) -> HashMap<&'a str, ResourceHandle> {
        let pipeline: &'a TypedPipeline = self.pipeline;
        let mut names = HashMap::with_capacity(pipeline.resources.len());
        for handle in pipeline.resource_handles() {
            names.entry(pipeline.resource(handle).name.as_str()).or_insert(handle);
        }
        names
    }

    fn reject_at<T>(
        &self,
        code: umbragraph_pipeline::diagnostic::Code,
        resource: &Resource,
        pointer: &str,
        message: String,
        help: &str,
    ) -> Option<T> {
        let diagnostic = resource.error_at(pointer, code, message).help(help);
        self.diagnostics.borrow_mut().push(resource.environment.told(diagnostic));
        None
    }
}

/// Live parameters, and what follows from them.
fn live(pipeline: &TypedPipeline) -> HashSet<&str> {
    let parameters = pipeline.parameters.iter().filter(|(_, parameter)| parameter.structural.is_none());
    let mut live: HashSet<&str> = parameters.map(|(name, _)| name.as_str()).collect();
    for following in &pipeline.following {
        if following.expression.names().iter().any(|name| live.contains(name)) {
            live.insert(&following.name);
        }
    }
    live
}

/// Returns the value of a JSON number, or of a list of numbers; `None` for any other JSON value.
fn literal(value: &serde_json::Value) -> Option<Value> {
    match value {
        serde_json::Value::Number(number) => number.as_f64().map(Value::Number),
        serde_json::Value::Array(list) => list.iter().map(literal).collect::<Option<_>>().map(Value::List),
        _ => None,
    }
}

impl Scope for Sizes<'_> {
    fn lookup(&self, name: &str) -> Option<Value> {
        if let Some(value) = self.scope.lookup(name) {
            return Some(value);
        }
        let number = |value: u32| Value::Number(f64::from(value));
        let pair = |width: u32, height: u32| Value::List(vec![number(width), number(height)]);
        let [width, height] = self.viewport;
        match name {
            "viewport" => return Some(pair(width, height)),
            "viewport.width" => return Some(number(width)),
            "viewport.height" => return Some(number(height)),
            _ => {}
        }
        let (handle, property) = match (self.named(name), name.rsplit_once('.')) {
            (Some(handle), _) => (handle, None),
            (None, Some((head, tail))) => (self.named(head)?, Some(tail)),
            (None, None) => return None,
        };
        if let (ResourceKind::Data(Some(shape)), Some(property)) =
            (&self.pipeline.resource(handle).kind, property)
        {
            let (_, initial) = shape.sizes.iter().find(|(known, _)| known == property)?;
            return Some(number(self.data_sizes.get(name).copied().unwrap_or(*initial)));
        }
        match (self.of(handle)?, property) {
            (Size::Texture(size), None) => Some(pair(size.width, size.height)),
            (Size::Texture(size), Some("width")) => Some(number(size.width)),
            (Size::Texture(size), Some("height")) => Some(number(size.height)),
            (Size::Texture(size), Some("layers")) => Some(number(size.layers)),
            (Size::Texture(size), Some("mips")) => Some(number(size.mips)),
            (Size::Texture(size), Some("samples")) => Some(number(size.samples)),
            (Size::Buffer(bytes), None | Some("size")) => Some(Value::Number(bytes as f64)),
            _ => None,
        }
    }

    fn names(&self) -> Vec<String> {
        let mut names = self.scope.names();
        names.extend(self.pipeline.resources.iter().map(|resource| resource.name.clone()));
        names.extend(["viewport", "viewport.width", "viewport.height"].map(str::to_owned));
        names
    }

    fn is_broken(&self, name: &str) -> bool {
        self.scope.is_broken(name)
    }

    fn words(&self, name: &str) -> Option<&[String]> {
        self.scope.words(name)
    }

    fn members(&self, head: &str) -> Vec<String> {
        let known: &[&str] = match self.named(head).map(|handle| &self.pipeline.resource(handle).kind) {
            Some(ResourceKind::Texture(_)) => &["width", "height", "layers", "mips", "samples"],
            Some(ResourceKind::Buffer(_)) => &["size"],
            _ => return Vec::new(),
        };
        known.iter().map(|member| format!("{head}.{member}")).collect()
    }
}
