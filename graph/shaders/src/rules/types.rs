//! Types that WGSL does not let stand where they do: atomics that cannot be written, and what is beyond its limits.
//!
//! | rule | limit |
//! |---|---|
//! | elements of an array outside of storage | 65,535 |
//! | parameters of a function | 255 |
//! | members of a structure | 16,383 |
//! | selectors of a switch | 16,383 |
//! | types within types | 255 |
//! | arguments of an array's constructor | 32,767 |
//!
//! The limits are those of Chrome's compiler, which are the specification's or higher: what it takes, other browsers
//! may still refuse. Arrays whose size is an override belong to workgroup memory alone.
//!
//! Source: *WebGPU Shading Language*, "Limits" and "Types".

use std::collections::HashSet;

use naga::{
    AddressSpace, ArraySize, Binding, BuiltIn, Expression, Function, Handle, ImageClass, Interpolation,
    Module, Scalar, ScalarKind, Span, Statement, StorageAccess, StorageFormat, StructMember, Type, TypeInner,
    VectorSize,
};

use crate::codes;
use crate::written::ir;
use crate::written::rejection::Rejection;

const MAX_ELEMENTS: usize = 65_535;
const MAX_PARAMETERS: usize = 255;
const MAX_MEMBERS: usize = 16_383;
const MAX_CASES: usize = 16_383;
const MAX_NESTING: usize = 255;
const MAX_COMPONENTS: usize = 32_767;

/// Properties of a WGSL type that also cover its members and elements.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Parts {
    nesting: usize,
    /// The number of elements of the largest array in the type; 0 without arrays of fixed size.
    elements: u32,
    pub(super) has_atomics: bool,
    /// Whether the size of an array in the type depends on a pipeline-overridable constant.
    has_overrides: bool,
}

/// Returns the properties of each type of a module, indexed like the module's type arena.
pub(super) fn parts(module: &Module) -> Vec<Parts> {
    // Types stand behind those that they consist of.
    let mut all: Vec<Parts> = Vec::with_capacity(module.types.len());
    for (_, ty) in module.types.iter() {
        let of = |ty: Handle<Type>| all.get(ty.index()).copied().unwrap_or_default();
        let own = match &ty.inner {
            TypeInner::Array { base, size, .. } => {
                let base = of(*base);
                let (elements, is_override) = match size {
                    ArraySize::Constant(size) => (size.get(), false),
                    ArraySize::Pending(_) => (0, true),
                    ArraySize::Dynamic => (0, false),
                };
                Parts {
                    nesting: 1 + base.nesting,
                    elements: elements.max(base.elements),
                    has_overrides: is_override || base.has_overrides,
                    ..base
                }
            }
            TypeInner::Struct { members, .. } => {
                let join = |one: Parts, other: Parts| Parts {
                    nesting: one.nesting.max(other.nesting + 1),
                    elements: one.elements.max(other.elements),
                    has_atomics: one.has_atomics || other.has_atomics,
                    has_overrides: one.has_overrides || other.has_overrides,
                };
                members.iter().map(|member| of(member.ty)).fold(Parts::default(), join)
            }
            TypeInner::Vector { .. } => Parts { nesting: 1, ..Parts::default() },
            TypeInner::Matrix { .. } => Parts { nesting: 2, ..Parts::default() },
            TypeInner::Atomic(_) => Parts { has_atomics: true, ..Parts::default() },
            _ => Parts::default(),
        };
        all.push(own);
    }
    all
}

/// Returns rejections of types in a module that WGSL does not allow at their place, or that exceed its limits.
pub(crate) fn found(module: &Module) -> Vec<Rejection> {
    let mut check = Check { module, parts: parts(module), found: Vec::new() };
    check.types();
    check.variables();
    ir::functions(module).for_each(|function| check.function(function));
    check.found
}

/// Returns `true` if a type is allowed for a built-in value. naga only checks members that an entry point uses.
fn is_type_of(built_in: BuiltIn, ty: &TypeInner) -> bool {
    let scalar = |scalar| *ty == TypeInner::Scalar(scalar);
    let vector = |size, scalar| *ty == TypeInner::Vector { size, scalar };
    match built_in {
        BuiltIn::Position { .. } => vector(VectorSize::Quad, Scalar::F32),
        BuiltIn::FragDepth => scalar(Scalar::F32),
        BuiltIn::FrontFacing => scalar(Scalar::BOOL),
        BuiltIn::VertexIndex
        | BuiltIn::InstanceIndex
        | BuiltIn::SampleIndex
        | BuiltIn::SampleMask
        | BuiltIn::LocalInvocationIndex => scalar(Scalar::U32),
        BuiltIn::GlobalInvocationId
        | BuiltIn::LocalInvocationId
        | BuiltIn::WorkGroupId
        | BuiltIn::NumWorkGroups => vector(VectorSize::Tri, Scalar::U32),
        _ => true,
    }
}

/// Returns `true` if a value of the type can have a `@location`: a number, or a vector of numbers.
fn is_numeric(ty: &TypeInner) -> bool {
    matches!(ty, TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } if *scalar != Scalar::BOOL)
}

struct Check<'m> {
    module: &'m Module,
    parts: Vec<Parts>,
    found: Vec<Rejection>,
}

impl Check<'_> {
    fn reject(&mut self, message: String, place: Span, help: &str) {
        self.found.push(Rejection::new(codes::WGSL_INVALID, message, place).help(help));
    }

    fn beyond(&mut self, place: Span, what: &str, count: usize, allowed: usize, help: &str) {
        if count > allowed {
            self.reject(format!("{what} are {count}, but WGSL allows {allowed}"), place, help);
        }
    }

    fn parts(&self, ty: Handle<Type>) -> Parts {
        self.parts.get(ty.index()).copied().unwrap_or_default()
    }

    fn types(&mut self) {
        for (handle, ty) in self.module.types.iter() {
            let place = self.module.types.get_span(handle);
            if let TypeInner::Struct { members, .. } = &ty.inner {
                let help = "split the structure";
                self.beyond(place, "the members of the structure", members.len(), MAX_MEMBERS, help);
                for member in members {
                    let is_fitting = match &member.binding {
                        Some(Binding::BuiltIn(built_in)) => {
                            is_type_of(*built_in, &self.module.types[member.ty].inner)
                        }
                        Some(Binding::Location { .. }) => is_numeric(&self.module.types[member.ty].inner),
                        None => true,
                    };
                    if !is_fitting {
                        let name = member.name.as_deref().unwrap_or_default();
                        let message = format!("\"{name}\" has a type that cannot stand between stages there");
                        let help =
                            "locations take numbers and vectors of them, a built-in value its own type";
                        self.reject(message, place, help);
                    }
                }
                self.locations(members, place);
            }
            let nesting = self.parts(handle).nesting;
            if nesting == MAX_NESTING + 1 {
                self.beyond(place, "the types within this type", nesting, MAX_NESTING, "nest fewer types");
            }
        }
    }

    /// Rejects duplicate locations in a structure, and integers that are interpolated. naga only checks structures that
    /// an entry point uses.
    fn locations(&mut self, members: &[StructMember], place: Span) {
        let mut taken = HashSet::new();
        for member in members {
            let Some(Binding::Location { location, interpolation, blend_src, .. }) = member.binding else {
                continue;
            };
            let name = member.name.as_deref().unwrap_or_default();
            if !taken.insert((location, blend_src)) {
                let message = format!("\"{name}\" has @location({location}), which another member has");
                self.reject(message, place, "give each member a location of its own");
            }
            let is_integer = matches!(
                self.module.types[member.ty].inner.scalar_kind(),
                Some(ScalarKind::Sint | ScalarKind::Uint)
            );
            if is_integer && matches!(interpolation, Some(Interpolation::Linear | Interpolation::Perspective))
            {
                let message = format!("\"{name}\" is an integer, which is not interpolated");
                self.reject(message, place, "write @interpolate(flat)");
            }
        }
    }

    fn variables(&mut self) {
        for (handle, variable) in self.module.global_variables.iter() {
            let place = self.module.global_variables.get_span(handle);
            let name = variable.name.as_deref().unwrap_or_default();
            match variable.space {
                AddressSpace::Storage { access } => {
                    if access.contains(StorageAccess::ATOMIC) {
                        let message = format!("\"{name}\" has an access that WGSL does not have");
                        self.reject(message, place, "write \"read_write\"");
                    }
                    let is_read = !access.contains(StorageAccess::STORE);
                    if is_read && self.parts(variable.ty).has_atomics {
                        let message = format!("\"{name}\" holds atomics, but can only be read");
                        self.reject(message, place, "declare it with the access \"read_write\"");
                    }
                }
                AddressSpace::Handle => {
                    if let TypeInner::Image { class: ImageClass::Storage { format, access }, .. } =
                        self.module.types[variable.ty].inner
                        && (access.contains(StorageAccess::ATOMIC) || format == StorageFormat::R64Uint)
                    {
                        let message = format!("\"{name}\" has a format or an access that WGSL does not have");
                        self.reject(message, place, "use r32uint, or an atomic in a storage buffer");
                    }
                }
                _ => self.elements(variable.ty, &format!("the elements of \"{name}\""), place),
            }
        }
    }

    fn function(&mut self, function: &Function) {
        let first = function.body.span_iter().next().map_or(Span::UNDEFINED, |(_, span)| *span);
        let help = "put parameters into a structure";
        self.beyond(first, "the parameters of the function", function.arguments.len(), MAX_PARAMETERS, help);
        for argument in &function.arguments {
            let name = argument.name.as_deref().unwrap_or_default();
            let ty = match self.module.types[argument.ty].inner {
                TypeInner::Pointer { base, space } if !matches!(space, AddressSpace::Storage { .. }) => base,
                _ => argument.ty,
            };
            self.elements(ty, &format!("the elements of \"{name}\""), first);
            let is_local = |space| matches!(space, AddressSpace::Function | AddressSpace::Private);
            if let TypeInner::Pointer { base, space } = self.module.types[argument.ty].inner
                && is_local(space)
                && self.parts(base).has_atomics
            {
                let message = format!("the parameter \"{name}\" points to atomics of a function or a module");
                self.reject(
                    message,
                    first,
                    "atomics are in workgroup memory or in storage that can be written",
                );
            }
            if self.parts(argument.ty).has_overrides {
                let message = format!("the parameter \"{name}\" holds an array whose size is an override");
                self.reject(
                    message,
                    first,
                    "pass a pointer to the workgroup variable, or make it a constant",
                );
            }
        }
        for (handle, local) in function.local_variables.iter() {
            let name = local.name.as_deref().unwrap_or_default();
            let place = function.local_variables.get_span(handle);
            self.elements(local.ty, &format!("the elements of \"{name}\""), place);
        }
        for (handle, expression) in function.expressions.iter() {
            let place = function.expressions.get_span(handle);
            match expression {
                Expression::ZeroValue(ty) => self.elements(*ty, "the elements of the array", place),
                Expression::Compose { components, .. } => {
                    let help = "read the values from a buffer";
                    self.beyond(place, "the values of the array", components.len(), MAX_COMPONENTS, help);
                }
                _ => {}
            }
        }
        let mut blocks = vec![&function.body];
        while let Some(block) = blocks.pop() {
            for (statement, span) in block.span_iter() {
                blocks.extend(ir::blocks(statement));
                let Statement::Switch { cases, .. } = statement else { continue };
                self.beyond(*span, "the selectors of the switch", cases.len(), MAX_CASES, "use an array");
            }
        }
    }

    fn elements(&mut self, ty: Handle<Type>, what: &str, place: Span) {
        let elements = self.parts(ty).elements as usize;
        self.beyond(place, what, elements, MAX_ELEMENTS, "keep so many in a storage buffer");
    }
}
