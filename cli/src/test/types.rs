//! The types of what asserts compare.
//!
//! WGSL has no functions over any type, so that each assert becomes code for its own. A first text, in which each
//! argument is the initial value of a variable, lets naga say the types. A number such as `1` is an `i32` by itself; it
//! takes the type of what it is compared with.

use std::collections::{BTreeSet, HashMap};

use naga::{Function, Module, ScalarKind, Type, TypeInner};

/// The type of a value in an assert: a scalar or a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    pub(super) kind: ScalarKind,
    /// The number of components, 1 for a scalar.
    pub(super) components: usize,
}

impl Shape {
    fn of(inner: &TypeInner) -> Option<Self> {
        let (scalar, components) = match inner {
            TypeInner::Scalar(scalar) => (scalar, 1),
            TypeInner::Vector { size, scalar } => (scalar, *size as usize),
            _ => return None,
        };
        (scalar.width == 4 || scalar.kind == ScalarKind::Bool)
            .then_some(Self { kind: scalar.kind, components })
    }

    fn scalar(self) -> &'static str {
        match self.kind {
            ScalarKind::Float | ScalarKind::AbstractFloat => "f32",
            ScalarKind::Uint => "u32",
            ScalarKind::Sint | ScalarKind::AbstractInt => "i32",
            ScalarKind::Bool => "bool",
        }
    }

    /// Returns the name of the type in WGSL.
    pub(super) fn name(self) -> String {
        self.named(self.scalar())
    }

    /// Returns the name of the type with the same number of components and another scalar type.
    pub(super) fn named(self, scalar: &str) -> String {
        match self.components {
            1 => scalar.to_owned(),
            count => format!("vec{count}<{scalar}>"),
        }
    }

    /// Returns a WGSL expression for the bits of a variable, as a `vec4<u32>`.
    pub(super) fn bits(self, variable: &str) -> String {
        let unsigned = self.named("u32");
        let bits = match self.kind {
            ScalarKind::Bool => format!("select({unsigned}(0u), {unsigned}(1u), {variable})"),
            _ => format!("bitcast<{unsigned}>({variable})"),
        };
        let zeros = ", 0u".repeat(4 - self.components);
        format!("vec4<u32>({bits}{zeros})")
    }

    /// Formats a value of the type from the bits of its components.
    pub(super) fn show(self, bits: [u32; 4]) -> String {
        let one = |bits: &u32| match self.kind {
            ScalarKind::Bool => (*bits != 0).to_string(),
            ScalarKind::Uint => bits.to_string(),
            ScalarKind::Sint | ScalarKind::AbstractInt => (*bits as i32).to_string(),
            ScalarKind::Float | ScalarKind::AbstractFloat => f32::from_bits(*bits).to_string(),
        };
        let all: Vec<String> = bits.iter().take(self.components).map(one).collect();
        if all.len() == 1 { all.concat() } else { format!("({})", all.join(", ")) }
    }
}

/// Finds the local variables whose names begin with a prefix. Returns their shapes, or a description of an unsupported
/// type.
pub(super) fn variables(module: &Module, prefix: &str) -> HashMap<String, Result<Shape, String>> {
    let mut found = HashMap::new();
    for function in functions(module) {
        for (_, variable) in function.local_variables.iter() {
            let Some(name) = variable.name.as_deref().filter(|name| name.starts_with(prefix)) else {
                continue;
            };
            let ty = &module.types[variable.ty];
            found.insert(name.to_owned(), Shape::of(&ty.inner).ok_or_else(|| in_words(ty)));
        }
    }
    found
}

fn in_words(ty: &Type) -> String {
    match (&ty.name, &ty.inner) {
        (Some(name), _) => format!("`{name}`"),
        (None, TypeInner::Matrix { .. }) => "a matrix".to_owned(),
        (None, TypeInner::Array { .. }) => "an array".to_owned(),
        (None, TypeInner::Pointer { .. }) => "a pointer".to_owned(),
        _ => "neither a scalar nor a vector of 32 bits".to_owned(),
    }
}

fn functions(module: &Module) -> impl Iterator<Item = &Function> {
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    module.functions.iter().map(|(_, function)| function).chain(entries)
}

/// Returns the common type of both sides of a comparison; `None` if they differ. An `i32` takes the other side's type,
/// since it may be an untyped literal.
pub(super) fn common(found: Shape, wanted: Shape) -> Option<Shape> {
    let is_number = |one: Shape| one.kind == ScalarKind::Sint;
    let shape = if is_number(found) { wanted } else { found };
    let fits = found.kind == wanted.kind || is_number(found) || is_number(wanted);
    (fits && found.components == wanted.components).then_some(shape)
}

/// Returns the names of the `override` constants that a module declares.
pub(super) fn overrides(module: &Module) -> BTreeSet<String> {
    module.overrides.iter().filter_map(|(_, each)| each.name.clone()).collect()
}

/// Returns the names of the bound resources that a function uses, directly or through calls.
pub(super) fn bindings(module: &Module, function: &str) -> Vec<String> {
    let mut open: Vec<_> = module
        .functions
        .iter()
        .filter(|(_, each)| each.name.as_deref() == Some(function))
        .map(|(handle, _)| handle)
        .collect();
    let (mut seen, mut found) = (BTreeSet::new(), BTreeSet::new());
    while let Some(handle) = open.pop() {
        if !seen.insert(handle) {
            continue;
        }
        let function = &module.functions[handle];
        for (_, expression) in function.expressions.iter() {
            match expression {
                naga::Expression::GlobalVariable(global) => {
                    let variable = &module.global_variables[*global];
                    found.extend(variable.binding.and(variable.name.clone()));
                }
                naga::Expression::CallResult(called) => open.push(*called),
                _ => {}
            }
        }
        calls(&function.body, &mut open);
    }
    found.into_iter().collect()
}

/// Adds the functions that statements of a block call. Calls without a result are found only here, since they appear in
/// no expression.
fn calls(block: &naga::Block, found: &mut Vec<naga::Handle<Function>>) {
    use naga::Statement as S;
    for statement in block {
        match statement {
            S::Call { function, .. } => found.push(*function),
            S::Block(inner) => calls(inner, found),
            S::If { accept, reject, .. } => [accept, reject].into_iter().for_each(|one| calls(one, found)),
            S::Switch { cases, .. } => cases.iter().for_each(|case| calls(&case.body, found)),
            S::Loop { body, continuing, .. } => {
                [body, continuing].into_iter().for_each(|one| calls(one, found));
            }
            _ => {}
        }
    }
}
