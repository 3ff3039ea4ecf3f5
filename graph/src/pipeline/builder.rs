//! [`PassBuilder`]: what a node kind sees while a pass is declared.
//!
//! Everything that a node kind says goes through here: expressions are evaluated, references looked up, shaders
//! compiled and their bindings matched by name. Each method takes the JSON pointer of the setting (relative to the
//! node kind's settings), so that a finding stands at its place; it reports the finding itself and returns `None`.

use std::collections::BTreeMap;

use super::binding::{Bind, BindObject};
use super::environment::Environment;
use super::load::Shared;
use super::modules::Wanted;
use super::program::{Program, ProgramBinding};
use super::{Part, ResourceKind, Usage, Use, Version, host_contract};
use crate::data::DataShape;
use crate::diagnostic::{Code, Diagnostic, codes, did_you_mean};
use crate::document;
use crate::expression::{self, Expression, ExpressionError, Fault, Scope as _, Value};
use crate::language::{Expr, Reference, TextureShape, Word};
use crate::shader::{AxisValue, AxisValues, TypeLayout};
use crate::source::Span;
use crate::work::{
    BlockLayout, BlockValues, BoundSlot, Deferred, ProgramHandle, ResourceHandle, Sampler, SlotSource,
    TextureView, Work,
};

/// Declares one pass.
pub struct PassBuilder<'a> {
    pub(super) shared: &'a mut Shared,
    pub(super) name: &'a str,
    pub(super) settings: &'a document::Value,
    /// The pointer of the settings in the document.
    pub(super) pointer: String,
    pub(super) uses: Vec<Use>,
    pub(super) environment: &'a Environment,
}

/// The proof that a pass said what it does; made by [`PassBuilder::produce`].
#[derive(Debug)]
pub struct Produced(pub(super) Work);

impl PassBuilder<'_> {
    /// The pass's name.
    pub fn name(&self) -> &str {
        self.name
    }

    /// Where a setting stands; for one that is not written, the object that lacks it.
    pub fn place(&self, pointer: &str) -> Span {
        self.settings.nearest(pointer).span
    }

    /// Reports a finding at a setting.
    pub fn report(&mut self, code: Code, pointer: &str, message: impl Into<String>, help: impl Into<String>) {
        let finding =
            Diagnostic::error(code, self.place(pointer), message).help(help).pointer(self.absolute(pointer));
        self.shared.diagnostics.push(finding);
    }

    /// Finishes the pass.
    pub fn produce(&self, work: Work) -> Produced {
        Produced(work)
    }

    /// Evaluates an expression over parameters and features.
    pub fn value(&mut self, expr: &Expr, pointer: &str) -> Option<Value> {
        let result = self.evaluate(expr);
        result.map_err(|error| self.expression_error(&error, pointer)).ok()
    }

    /// Evaluates an expression that yields a number.
    pub fn number(&mut self, expr: &Expr, pointer: &str) -> Option<f64> {
        match self.value(expr, pointer)? {
            Value::Number(number) => Some(number),
            other => self.wrong_type(pointer, "a number", other.kind_name()),
        }
    }

    /// Evaluates an expression that yields a whole number from 0.
    pub fn count(&mut self, expr: &Expr, pointer: &str) -> Option<u32> {
        let number = self.number(expr, pointer)?;
        if number.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&number) {
            return self.wrong_type(pointer, "a whole number from 0", &number.to_string());
        }
        Some(number as u32)
    }

    /// Evaluates an expression that yields a list of numbers (one number is a list of one).
    pub fn numbers(&mut self, expr: &Expr, pointer: &str) -> Option<Vec<f64>> {
        let value = self.value(expr, pointer)?;
        match value.numbers() {
            Some(numbers) => Some(numbers),
            None => self.wrong_type(pointer, "a list of numbers", value.kind_name()),
        }
    }

    /// Evaluates an expression that yields a boolean.
    pub fn boolean(&mut self, expr: &Expr, pointer: &str) -> Option<bool> {
        match self.value(expr, pointer)? {
            Value::Bool(value) => Some(value),
            other => self.wrong_type(pointer, "a boolean", other.kind_name()),
        }
    }

    /// A word, or the one that its expression yields.
    pub fn word<T: serde::de::DeserializeOwned + Clone + schemars::JsonSchema>(
        &mut self,
        word: &Word<T>,
        pointer: &str,
    ) -> Option<T> {
        let expr = match word {
            Word::Is(word) => return Some(word.clone()),
            Word::Computed(expr) => expr,
        };
        match self.evaluate(expr) {
            Ok(Value::Text(text)) => match serde_json::from_value(text.as_str().into()) {
                Ok(word) => Some(word),
                Err(_) => {
                    let message = format!("the expression yields \"{text}\", which is not known here");
                    self.report(
                        codes::UNKNOWN_WORD,
                        pointer,
                        message,
                        "the schema lists the words known here",
                    );
                    None
                }
            },
            Ok(other) => self.wrong_type(pointer, "a word", other.kind_name()),
            Err(error) => {
                // The equals sign in front is not part of the expression.
                let error = ExpressionError { range: error.range.start + 1..error.range.end + 1, ..error };
                self.expression_error(&error, pointer);
                None
            }
        }
    }

    /// An expression that may name sizes too; it is evaluated when they are known.
    pub fn deferred(&mut self, expr: &Expr, pointer: &str) -> Option<Deferred> {
        match expr.parse() {
            Ok(expression) => {
                let expression =
                    self.environment.close(&expression, &|name| self.shared.find(name).is_some());
                self.check_names(&expression, pointer)?;
                Some(Deferred { expression, place: self.place(pointer), pointer: self.absolute(pointer) })
            }
            Err(error) => {
                self.expression_error(&error, pointer);
                None
            }
        }
    }

    /// Names the data that this pass publishes.
    pub fn publish(&mut self, name: &str, pointer: &str, shape: DataShape) -> Option<ResourceHandle> {
        let place = self.place(pointer);
        let at = self.absolute(pointer);
        let name = &self.outside(name, pointer)?;
        let handle = self.shared.intern_data(name, place, &at);
        let resource = &mut self.shared.resources[handle.index()];
        match &mut resource.kind {
            ResourceKind::Data(published @ None) => {
                *published = Some(shape);
                resource.place = place;
                resource.pointer = at;
                self.add_use(handle, Part::WHOLE, Usage::HostWrite, Version::Newest, pointer);
                Some(handle)
            }
            ResourceKind::Data(Some(_)) => {
                let finding = Diagnostic::error(
                    codes::PUBLISHED_TWICE,
                    place,
                    format!("the data \"{name}\" is published by two passes"),
                )
                .related(resource.place, "it is published here too")
                .help("give one of the two another name")
                .pointer(at);
                self.shared.diagnostics.push(finding);
                None
            }
            _ => {
                let message = format!("\"{name}\" is {}, not host data", resource.kind_name());
                let finding = Diagnostic::error(codes::WRONG_RESOURCE, place, message)
                    .related(resource.place, "it is declared here")
                    .help("publish under a name that no texture or buffer has")
                    .pointer(at);
                self.shared.diagnostics.push(finding);
                None
            }
        }
    }

    /// Reads host data that another pass publishes.
    pub fn data(&mut self, name: &str, pointer: &str) -> Option<ResourceHandle> {
        let place = self.place(pointer);
        let at = self.absolute(pointer);
        let name = &self.outside(name, pointer)?;
        let handle = self.shared.intern_data(name, place, &at);
        let resource = &self.shared.resources[handle.index()];
        if matches!(resource.kind, ResourceKind::Broken) {
            return None;
        }
        if !matches!(resource.kind, ResourceKind::Data(_)) {
            let message = format!("\"{name}\" is {}, but host data is wanted here", resource.kind_name());
            self.report(
                codes::WRONG_RESOURCE,
                pointer,
                message,
                "name what a host pass publishes, such as a cascade fit",
            );
            return None;
        }
        if !self.uses.iter().any(|known| known.resource == handle) {
            self.add_use(handle, Part::WHOLE, Usage::HostRead, Version::Newest, pointer);
        }
        Some(handle)
    }

    /// Uses a texture that a reference names.
    pub fn texture(
        &mut self,
        reference: &str,
        part: Part,
        usage: Usage,
        pointer: &str,
    ) -> Option<ResourceHandle> {
        let (handle, version) = self.reference(reference, pointer)?;
        let resource = &self.shared.resources[handle.index()];
        if resource.texture().is_none() {
            let message =
                format!("\"{}\" is {}, but a texture is wanted here", resource.name, resource.kind_name());
            self.report(codes::WRONG_RESOURCE, pointer, message, "name a texture of \"resources\"");
            return None;
        }
        self.add_use(handle, part, usage, version, pointer);
        Some(handle)
    }

    /// A declared texture of which only the size is wanted: no use is recorded.
    pub fn declared_texture(&mut self, name: &str, pointer: &str) -> Option<ResourceHandle> {
        let (handle, _) = self.reference(name, pointer)?;
        let resource = &self.shared.resources[handle.index()];
        if resource.texture().is_none() {
            let message = format!("\"{name}\" is {}, but a texture is wanted here", resource.kind_name());
            self.report(codes::WRONG_RESOURCE, pointer, message, "name a texture of \"resources\"");
            return None;
        }
        Some(handle)
    }

    /// Uses a buffer that a reference names.
    pub fn buffer(&mut self, reference: &str, usage: Usage, pointer: &str) -> Option<ResourceHandle> {
        let (handle, version) = self.reference(reference, pointer)?;
        let resource = &self.shared.resources[handle.index()];
        if !matches!(resource.kind, ResourceKind::Buffer(_)) {
            let message =
                format!("\"{}\" is {}, but a buffer is wanted here", resource.name, resource.kind_name());
            self.report(codes::WRONG_RESOURCE, pointer, message, "name a buffer of \"resources\"");
            return None;
        }
        self.add_use(handle, Part::WHOLE, usage, version, pointer);
        Some(handle)
    }

    /// The program of a template. Its axes are what `axes` says, else the feature or parameter of the same name, else
    /// their defaults; `geometry` names the contract whose mesh properties are axes too.
    pub fn program(
        &mut self,
        template: &str,
        axes: &BTreeMap<String, Expr>,
        geometry: Option<&str>,
        pointer: &str,
    ) -> Option<ProgramHandle> {
        let shader_at = format!("{pointer}/shader");
        let Some(known) = self.shared.templates.axes(template).cloned() else {
            let finding = self
                .shared
                .templates
                .unknown(template, self.place(&shader_at))
                .pointer(self.absolute(&shader_at));
            self.shared.diagnostics.push(finding);
            return None;
        };
        let mut values = AxisValues::new();
        let mut fine = true;
        for (name, expr) in axes {
            let at = document::pointer_join(&format!("{pointer}/axes"), name);
            if known.get(name).is_none() {
                let names: Vec<&str> = known.iter().map(|axis| axis.name.as_str()).collect();
                let help = match did_you_mean(name, names.iter().copied()) {
                    Some(meant) => format!("did you mean \"{meant}\"?"),
                    None => format!("the axes of {template} are {}", names.join(", ")),
                };
                self.report(codes::UNKNOWN_AXIS, &at, format!("{template} has no axis \"{name}\""), help);
                fine = false;
                continue;
            }
            match self.value(expr, &at) {
                Some(value) => match axis_value(&value) {
                    Some(value) => {
                        values.insert(name.clone(), value);
                    }
                    None => {
                        self.wrong_type::<()>(&at, "a boolean, a whole number or a word", value.kind_name());
                        fine = false;
                    }
                },
                None => fine = false,
            }
        }
        for axis in known.iter() {
            if !values.contains_key(&axis.name)
                && let Some(value) = self.shared.scope.lookup(&axis.name).as_ref().and_then(axis_value)
            {
                values.insert(axis.name.clone(), value);
            }
        }
        let properties: Vec<String> = match geometry {
            None => Vec::new(),
            Some(geometry) => self
                .shared
                .geometry
                .get(geometry)
                .map(|contract| {
                    contract.variants.iter().filter(|name| known.get(name).is_some()).cloned().collect()
                })
                .unwrap_or_default(),
        };
        if !fine {
            return None;
        }
        let place = self.place(&shader_at);
        self.shared.modules.wanted.push(Wanted {
            pass: self.name.to_owned(),
            template: template.to_owned(),
            axes: values.clone(),
            properties: properties.clone(),
            place,
        });
        self.shared.program(template, values, properties, place, &self.absolute(&shader_at))
    }

    /// Matches the bindings of a program with what a pass binds, by name. Where `geometry` is given, groups 2 and 3
    /// are the host's and are checked against that contract, and a uniform block `view` is the view being drawn.
    pub fn bind(
        &mut self,
        program: ProgramHandle,
        bind: &BTreeMap<String, Bind>,
        geometry: Option<&str>,
        pointer: &str,
    ) -> Option<Vec<BoundSlot>> {
        let at = format!("{pointer}/bind");
        let program: Program = self.shared.programs[program.index()].clone();
        let mut fine = true;
        let mut unknown: Vec<&str> = Vec::new();
        for name in bind.keys() {
            if program.binding(name).is_none() && !self.shared.is_mentioned(&program.template, name) {
                let names: Vec<&str> = program.bindings.iter().map(|binding| binding.name.as_str()).collect();
                let help = match did_you_mean(name, names.iter().copied()) {
                    Some(meant) => format!("did you mean \"{meant}\"?"),
                    None => format!("its bindings are {}", names.join(", ")),
                };
                let message = format!("{} has no binding \"{name}\"", program.template);
                self.report(codes::UNKNOWN_BINDING, &document::pointer_join(&at, name), message, help);
                unknown.push(name);
                fine = false;
            }
        }
        let mut slots = Vec::new();
        for binding in &program.bindings {
            if geometry.is_some() && binding.group >= 2 {
                continue;
            }
            let here = document::pointer_join(&at, &binding.name);
            let misspelt =
                || unknown.iter().any(|name| did_you_mean(name, [binding.name.as_str()]).is_some());
            let source = match bind.get(&binding.name) {
                Some(bind) => self.slot(&program, binding, bind, &here),
                None if misspelt() => None,
                None => self.default_slot(binding, geometry, &program.template, &here),
            };
            match source {
                Some(source) => slots.push(BoundSlot {
                    group: binding.group,
                    binding: binding.entry.binding,
                    name: binding.name.clone(),
                    source,
                    place: self.place(&here),
                    pointer: self.absolute(&here),
                }),
                None => fine = false,
            }
        }
        if let Some(geometry) = geometry {
            fine &= host_contract::check(self, geometry, &program, pointer);
        }
        fine.then_some(slots)
    }

    fn default_slot(
        &mut self,
        binding: &ProgramBinding,
        geometry: Option<&str>,
        template: &str,
        here: &str,
    ) -> Option<SlotSource> {
        use wgpu_types::{BindingType, SamplerBindingType};
        match binding.entry.ty {
            BindingType::Buffer { .. } if geometry.is_some() && binding.name == "view" => {
                Some(SlotSource::View(BlockLayout::default()))
            }
            BindingType::Sampler(SamplerBindingType::Filtering) => {
                Some(SlotSource::Sampler(Sampler::default()))
            }
            BindingType::Sampler(SamplerBindingType::NonFiltering) => Some(SlotSource::Sampler(Sampler {
                filter: crate::work::Filter::Nearest,
                ..Sampler::default()
            })),
            BindingType::Sampler(SamplerBindingType::Comparison) => {
                let message =
                    format!("the comparison sampler \"{}\" of {template} is not bound", binding.name);
                self.report(
                    codes::UNBOUND,
                    here,
                    message,
                    "bind it: { \"sampler\": { \"compare\": \"less-equal\" } }",
                );
                None
            }
            _ => {
                let message =
                    format!("\"{}: {}\" of {template} is not bound", binding.name, binding.type_name);
                self.report(codes::UNBOUND, here, message, format!("add \"{}\" to \"bind\"", binding.name));
                None
            }
        }
    }

    fn slot(
        &mut self,
        program: &Program,
        binding: &ProgramBinding,
        bind: &Bind,
        here: &str,
    ) -> Option<SlotSource> {
        use wgpu_types::{BindingType, BufferBindingType, StorageTextureAccess};
        let wanted = |what: &str| format!("\"{}\" of {} is {what}", binding.name, program.template);
        match binding.entry.ty {
            BindingType::Texture { view_dimension, .. } => {
                self.texture_slot(bind, Usage::Sampled, view_dimension, here, &wanted("a texture"))
            }
            BindingType::StorageTexture { access, view_dimension, .. } => {
                let usage = match access {
                    StorageTextureAccess::WriteOnly => Usage::StorageWrite,
                    StorageTextureAccess::ReadOnly => Usage::StorageRead,
                    _ => Usage::StorageReadWrite,
                };
                self.texture_slot(bind, usage, view_dimension, here, &wanted("a storage texture"))
            }
            BindingType::Sampler(kind) => {
                let Bind::Object(BindObject::Sampler(sampler)) = bind else {
                    self.report(
                        codes::WRONG_RESOURCE,
                        here,
                        wanted("a sampler"),
                        "bind { \"sampler\": { } } with its settings",
                    );
                    return None;
                };
                let at = format!("{here}/sampler");
                let filter = match &sampler.filter {
                    Some(word) => self.word(word, &format!("{at}/filter"))?,
                    None if kind == wgpu_types::SamplerBindingType::NonFiltering => {
                        crate::work::Filter::Nearest
                    }
                    None => crate::work::Filter::Linear,
                };
                let address = match &sampler.address {
                    Some(word) => self.word(word, &format!("{at}/address"))?,
                    None => crate::work::Address::default(),
                };
                let compare = match &sampler.compare {
                    Some(word) => Some(self.word(word, &format!("{at}/compare"))?),
                    None => None,
                };
                let is_comparison = kind == wgpu_types::SamplerBindingType::Comparison;
                if compare.is_some() != is_comparison {
                    let (message, help) = if is_comparison {
                        (wanted("a comparison sampler"), "add \"compare\", such as \"less-equal\"")
                    } else {
                        (wanted("not a comparison sampler"), "remove \"compare\"")
                    };
                    self.report(codes::WRONG_RESOURCE, &at, message, help);
                    return None;
                }
                Some(SlotSource::Sampler(Sampler { filter, address, compare }))
            }
            BindingType::Buffer { ty, .. } => match bind {
                Bind::Object(BindObject::Values(values)) => {
                    let layout = binding.block.clone()?;
                    let at = format!("{here}/values");
                    self.block_values(&layout, values, &at, &program.template, true).map(SlotSource::Values)
                }
                Bind::Object(BindObject::Data(data)) => {
                    let layout = binding.block.clone()?;
                    let at = format!("{here}/data");
                    let values_at = format!("{at}/values");
                    let values =
                        self.block_values(&layout, &data.values, &values_at, &program.template, false);
                    let resource = self.data(&data.name, &format!("{at}/name"))?;
                    Some(SlotSource::Data { resource, layout: BlockLayout::default(), values: Some(values?) })
                }
                Bind::Name(name) => {
                    let written = self.environment.interpolate(name, &self.shared.scope).unwrap_or_default();
                    let resource = Reference::parse(&written).ok().and_then(|reference| {
                        self.shared.find(&self.environment.resource(reference.resource))
                    });
                    let is_buffer = resource.is_some_and(|handle| {
                        matches!(self.shared.resources[handle.index()].kind, ResourceKind::Buffer(_))
                    });
                    if is_buffer {
                        let usage = match ty {
                            BufferBindingType::Uniform => Usage::Uniform,
                            BufferBindingType::Storage { read_only: true } => Usage::StorageRead,
                            BufferBindingType::Storage { read_only: false } => Usage::StorageReadWrite,
                        };
                        return self.buffer(name, usage, here).map(SlotSource::Buffer);
                    }
                    let resource = self.data(name, here)?;
                    Some(SlotSource::Data { resource, layout: BlockLayout::default(), values: None })
                }
                Bind::Object(_) => {
                    let help = "bind the name of a buffer or of host data, or { \"values\": { } }";
                    self.report(codes::WRONG_RESOURCE, here, wanted("a buffer"), help);
                    None
                }
            },
            _ => {
                self.report(
                    codes::WRONG_RESOURCE,
                    here,
                    wanted("of a type that passes cannot bind"),
                    "use a texture, a buffer or a sampler",
                );
                None
            }
        }
    }

    fn texture_slot(
        &mut self,
        bind: &Bind,
        usage: Usage,
        dimension: wgpu_types::TextureViewDimension,
        here: &str,
        wanted: &str,
    ) -> Option<SlotSource> {
        let declared = match dimension {
            wgpu_types::TextureViewDimension::D2 => TextureShape::D2,
            wgpu_types::TextureViewDimension::D2Array => TextureShape::D2Array,
            wgpu_types::TextureViewDimension::Cube => TextureShape::Cube,
            wgpu_types::TextureViewDimension::CubeArray => TextureShape::CubeArray,
            wgpu_types::TextureViewDimension::D3 => TextureShape::D3,
            wgpu_types::TextureViewDimension::D1 => {
                self.report(
                    codes::WRONG_RESOURCE,
                    here,
                    "one-dimensional textures cannot be declared",
                    "use a two-dimensional one",
                );
                return None;
            }
        };
        let (name, part, shape, at) = match bind {
            Bind::Name(name) => (name, Part::WHOLE, None, here.to_owned()),
            Bind::Object(BindObject::Texture(texture)) => {
                let at = format!("{here}/texture");
                let mip = match &texture.mip {
                    Some(expr) => Some(self.count(expr, &format!("{at}/mip"))?),
                    None => None,
                };
                let layer = match &texture.layer {
                    Some(expr) => Some(self.count(expr, &format!("{at}/layer"))?),
                    None => None,
                };
                (&texture.name, Part { mip, layer }, texture.view, format!("{at}/name"))
            }
            Bind::Object(_) => {
                self.report(codes::WRONG_RESOURCE, here, wanted, "bind the name of a texture");
                return None;
            }
        };
        let resource = self.texture(name, part, usage, &at)?;
        Some(SlotSource::Texture(TextureView {
            resource,
            shape: shape.unwrap_or(declared),
            mip: part.mip.or((usage != Usage::Sampled).then_some(0)),
            layer: part.layer,
            depth_only: true,
        }))
    }

    /// Expressions for the members of a block: for all of them, or for those that other values leave.
    fn block_values(
        &mut self,
        layout: &TypeLayout,
        values: &BTreeMap<String, Expr>,
        at: &str,
        template: &str,
        all: bool,
    ) -> Option<BlockValues> {
        let TypeLayout::Struct { members, .. } = layout else {
            self.report(
                codes::WRONG_RESOURCE,
                at,
                "values are bound to a struct",
                "declare the uniform as a struct in the template",
            );
            return None;
        };
        let mut fine = true;
        let mut unknown: Vec<&str> = Vec::new();
        for name in values.keys().filter(|name| !members.iter().any(|member| member.name == **name)) {
            let names: Vec<&str> = members.iter().map(|member| member.name.as_str()).collect();
            // A member of another variant's block stands in the template; here it is merely not needed.
            if self.shared.is_mentioned(template, name) {
                continue;
            }
            let help = match did_you_mean(name, names.iter().copied()) {
                Some(meant) => format!("did you mean \"{meant}\"?"),
                None => format!("its members are {}", names.join(", ")),
            };
            self.report(
                codes::UNKNOWN_BINDING,
                &document::pointer_join(at, name),
                format!("the block has no member \"{name}\""),
                help,
            );
            unknown.push(name);
            fine = false;
        }
        let mut deferred = Vec::new();
        for member in members {
            let here = document::pointer_join(at, &member.name);
            match values.get(&member.name) {
                Some(expr) => match self.deferred(expr, &here) {
                    Some(expression) => deferred.push((member.name.clone(), expression)),
                    None => fine = false,
                },
                None if unknown.iter().any(|name| did_you_mean(name, [member.name.as_str()]).is_some()) => {
                    fine = false;
                }
                None if !all => {}
                None => {
                    let message = format!("the member \"{}\" of the block has no value", member.name);
                    self.report(codes::UNBOUND, at, message, format!("add \"{}\" here", member.name));
                    fine = false;
                }
            }
        }
        fine.then_some(BlockValues { layout: layout.clone(), expressions: deferred })
    }

    /// The geometry contract of a name.
    pub fn geometry(&mut self, name: &str, pointer: &str) -> Option<()> {
        if self.shared.geometry.contains_key(name) {
            return Some(());
        }
        let names: Vec<String> = self.shared.geometry.keys().cloned().collect();
        let help = match did_you_mean(name, names.iter().map(String::as_str)) {
            Some(meant) => format!("did you mean \"{meant}\"?"),
            None => format!(
                "\"geometry\" declares {}",
                if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
            ),
        };
        self.report(codes::UNKNOWN_GEOMETRY, pointer, format!("there is no geometry \"{name}\""), help);
        None
    }

    pub(crate) fn settings_do_not_decode(&mut self, error: &serde_json::Error) {
        self.report(
            codes::WRONG_TYPE,
            "",
            format!("the settings do not decode: {error}"),
            "compare them with the schema",
        );
    }

    fn evaluate(&self, expr: &Expr) -> Result<Value, ExpressionError> {
        let expression = self.environment.close(&expr.parse()?, &|name| self.shared.find(name).is_some());
        expression::evaluate(&expression, &self.shared.scope)
    }

    /// The name outside of what is named here, with expressions in braces replaced.
    fn outside(&mut self, name: &str, pointer: &str) -> Option<String> {
        match self.environment.interpolate(name, &self.shared.scope) {
            Ok(name) => Some(self.environment.resource(&name)),
            Err(error) => {
                self.expression_error(&error, pointer);
                None
            }
        }
    }

    pub(super) fn absolute(&self, pointer: &str) -> String {
        format!("{}{pointer}", self.pointer)
    }

    fn reference(&mut self, text: &str, pointer: &str) -> Option<(ResourceHandle, Version)> {
        let text = match self.environment.interpolate(text, &self.shared.scope) {
            Ok(text) => text,
            Err(error) => {
                self.expression_error(&error, pointer);
                return None;
            }
        };
        let reference = match Reference::parse(&text) {
            Ok(reference) => reference,
            Err(error) => {
                self.report(
                    codes::BAD_REFERENCE,
                    pointer,
                    format!("\"{text}\" is no reference"),
                    error.to_string(),
                );
                return None;
            }
        };
        let outside = self.environment.resource(reference.resource);
        let found = self.shared.find(&outside);
        if found
            .is_some_and(|handle| matches!(self.shared.resources[handle.index()].kind, ResourceKind::Broken))
        {
            return None;
        }
        let Some(handle) = found else {
            let names: Vec<String> =
                self.shared.resources.iter().map(|resource| resource.name.clone()).collect();
            let help = match did_you_mean(reference.resource, names.iter().map(String::as_str)) {
                Some(meant) => format!("did you mean \"{meant}\"?"),
                None => "declare it under \"resources\"".to_owned(),
            };
            self.report(
                codes::UNKNOWN_RESOURCE,
                pointer,
                format!("there is no resource \"{}\"", reference.resource),
                help,
            );
            return None;
        };
        let version = match (reference.version, self.environment.version(reference.resource)) {
            (Some(pass), _) => Version::WrittenBy(self.environment.pass(pass)),
            (None, Some(pass)) => Version::WrittenBy(pass.to_owned()),
            (None, None) => Version::Newest,
        };
        Some((handle, version))
    }

    fn add_use(
        &mut self,
        resource: ResourceHandle,
        part: Part,
        usage: Usage,
        version: Version,
        pointer: &str,
    ) {
        let place = self.place(pointer);
        let new = Use { resource, part, usage, version, place, pointer: self.absolute(pointer) };
        if !self.uses.contains(&new) {
            self.uses.push(new);
        }
    }

    fn wrong_type<T>(&mut self, pointer: &str, wanted: &str, found: &str) -> Option<T> {
        self.report(
            codes::EXPRESSION_TYPE,
            pointer,
            format!("{wanted} is wanted here, this is {found}"),
            format!("make the expression yield {wanted}"),
        );
        None
    }

    /// Finds names in a deferred expression that exist nowhere; their values come later.
    fn check_names(&mut self, expression: &Expression, pointer: &str) -> Option<()> {
        match self.shared.unknown_name(expression) {
            None => Some(()),
            Some(error) => {
                self.expression_error(&error, pointer);
                None
            }
        }
    }

    fn expression_error(&mut self, error: &ExpressionError, pointer: &str) {
        let value = self.settings.nearest(pointer);
        let raw = self.shared.sources_text(value.span);
        let finding = expression_finding(error, value, &raw).pointer(self.absolute(pointer));
        self.shared.diagnostics.push(finding);
    }
}

fn axis_value(value: &Value) -> Option<AxisValue> {
    match value {
        Value::Bool(value) => Some(AxisValue::Bool(*value)),
        Value::Number(number) if number.fract() == 0.0 && number.abs() < 9.0e15 => {
            Some(AxisValue::Integer(*number as i64))
        }
        Value::Text(text) => Some(AxisValue::Name(text.clone())),
        _ => None,
    }
}

/// The finding of an error in an expression; the place is inside the string where it is written without escapes.
pub(crate) fn expression_finding(error: &ExpressionError, value: &document::Value, raw: &str) -> Diagnostic {
    let verbatim = value.text().is_some_and(|text| raw.len() == text.len() + 2);
    let place = if verbatim && error.range != (0..0) {
        let end = error.range.end.max(error.range.start + 1);
        value.span.inside(error.range.start + 1..end + 1)
    } else {
        value.span
    };
    let code = match error.fault {
        Fault::Syntax => codes::EXPRESSION_SYNTAX,
        Fault::UnknownName => codes::EXPRESSION_NAME,
        Fault::Type => codes::EXPRESSION_TYPE,
        Fault::Arithmetic => codes::EXPRESSION_ARITHMETIC,
    };
    let finding = Diagnostic::error(code, place, error.message.clone());
    finding.help(error.help.clone().unwrap_or_else(|| match error.fault {
        Fault::Syntax => "expressions look like \"ceil(viewport.width / 16)\"".to_owned(),
        Fault::UnknownName => "expressions know parameters, features, resources and viewport".to_owned(),
        Fault::Type => "see `umbragraph explain UG0312` for the types of expressions".to_owned(),
        Fault::Arithmetic => "guard the operation, with max(…, 1) for one".to_owned(),
    }))
}
