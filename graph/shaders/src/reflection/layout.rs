//! Memory layouts of host-shareable types, with WGSL's offsets, sizes and strides.

use naga::proc::Layouter;
use naga::{ArraySize, Handle, Module, Type, TypeInner};

/// The kind of a scalar type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ScalarKind {
    /// A signed integer.
    Sint,
    /// An unsigned integer.
    Uint,
    /// A floating-point number.
    Float,
    /// A boolean; never in host-shareable memory.
    Bool,
}

impl ScalarKind {
    pub(super) fn new(kind: naga::ScalarKind) -> Self {
        match kind {
            naga::ScalarKind::Sint | naga::ScalarKind::AbstractInt => ScalarKind::Sint,
            naga::ScalarKind::Uint => ScalarKind::Uint,
            naga::ScalarKind::Float | naga::ScalarKind::AbstractFloat => ScalarKind::Float,
            naga::ScalarKind::Bool => ScalarKind::Bool,
        }
    }
}

/// A scalar type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct Scalar {
    /// The kind: integer, floating point or boolean.
    pub kind: ScalarKind,
    /// The size of a value in bytes.
    pub width: u32,
}

impl Scalar {
    pub(super) fn new(scalar: naga::Scalar) -> Self {
        Self { kind: ScalarKind::new(scalar.kind), width: u32::from(scalar.width) }
    }
}

/// The memory layout of a WGSL type.
#[derive(Clone, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TypeLayout {
    /// A scalar or an atomic scalar.
    Scalar {
        /// The type of the scalar.
        scalar: Scalar,
        /// Whether the WGSL type is `atomic<…>`.
        atomic: bool,
    },
    /// A vector of 2 to 4 components.
    Vector {
        /// The number of components: 2, 3 or 4.
        components: u32,
        /// The scalar type of a component.
        scalar: Scalar,
    },
    /// A matrix, stored column by column.
    Matrix {
        /// The number of columns.
        columns: u32,
        /// The number of rows.
        rows: u32,
        /// The scalar type of a component.
        scalar: Scalar,
        /// The distance between two columns in bytes.
        stride: u32,
    },
    /// An array of fixed or runtime-determined length.
    Array {
        /// The layout of an element.
        element: Box<TypeLayout>,
        /// The number of elements; `None` for a runtime-sized array or a length that an override decides.
        count: Option<u32>,
        /// The distance between two elements in bytes.
        stride: u32,
    },
    /// A structure with named members.
    Struct {
        /// The name of the structure in WGSL.
        name: String,
        /// The members in the order of their declaration.
        members: Vec<Member>,
        /// The size in bytes, including padding at the end. A runtime-sized array at the end counts as one element.
        size: u32,
        /// The alignment in bytes.
        align: u32,
    },
}

/// A member of a structure.
#[derive(Clone, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Member {
    /// The name of the member in WGSL.
    pub name: String,
    /// The byte offset from the start of the structure.
    pub offset: u32,
    /// The memory layout of the member.
    pub layout: TypeLayout,
}

impl TypeLayout {
    /// Returns the size of the type in bytes. An array without a fixed length counts as one element.
    pub fn size(&self) -> u32 {
        match self {
            TypeLayout::Scalar { scalar, .. } => scalar.width,
            TypeLayout::Vector { components, scalar } => components * scalar.width,
            TypeLayout::Matrix { columns, stride, .. } => columns * stride,
            TypeLayout::Array { count, stride, .. } => stride.saturating_mul(count.unwrap_or(1)),
            TypeLayout::Struct { size, .. } => *size,
        }
    }

    /// Returns the alignment of the type in bytes.
    pub fn align(&self) -> u32 {
        let vector = |components: u32, scalar: &Scalar| {
            if components == 2 { 2 * scalar.width } else { 4 * scalar.width }
        };
        match self {
            TypeLayout::Scalar { scalar, .. } => scalar.width,
            TypeLayout::Vector { components, scalar } => vector(*components, scalar),
            TypeLayout::Matrix { rows, scalar, .. } => vector(*rows, scalar),
            TypeLayout::Array { element, .. } => element.align(),
            TypeLayout::Struct { align, .. } => *align,
        }
    }

    /// Returns the type as written in WGSL: `vec3<f32>`, `array<Light, 4>` or the name of a structure.
    pub fn spelling(&self) -> String {
        let scalar = |scalar: &Scalar| {
            let letter = match scalar.kind {
                ScalarKind::Sint => 'i',
                ScalarKind::Uint => 'u',
                ScalarKind::Float => 'f',
                ScalarKind::Bool => return "bool".to_owned(),
            };
            format!("{letter}{}", scalar.width * 8)
        };
        match self {
            TypeLayout::Scalar { scalar: each, atomic: false } => scalar(each),
            TypeLayout::Scalar { scalar: each, atomic: true } => format!("atomic<{}>", scalar(each)),
            TypeLayout::Vector { components, scalar: each } => format!("vec{components}<{}>", scalar(each)),
            TypeLayout::Matrix { columns, rows, scalar: each, .. } => {
                format!("mat{columns}x{rows}<{}>", scalar(each))
            }
            TypeLayout::Array { element, count: Some(count), .. } => {
                format!("array<{}, {count}>", element.spelling())
            }
            TypeLayout::Array { element, count: None, .. } => format!("array<{}>", element.spelling()),
            TypeLayout::Struct { name, .. } => name.clone(),
        }
    }

    /// Returns the layout of a type; `None` for types without a memory layout, such as textures and samplers.
    pub(super) fn new(module: &Module, layouter: &Layouter, handle: Handle<Type>) -> Option<Self> {
        let ty = &module.types[handle];
        Some(match &ty.inner {
            TypeInner::Scalar(scalar) => TypeLayout::Scalar { scalar: Scalar::new(*scalar), atomic: false },
            TypeInner::Atomic(scalar) => TypeLayout::Scalar { scalar: Scalar::new(*scalar), atomic: true },
            TypeInner::Vector { size, scalar } => {
                TypeLayout::Vector { components: *size as u32, scalar: Scalar::new(*scalar) }
            }
            TypeInner::Matrix { columns, rows, scalar } => TypeLayout::Matrix {
                columns: *columns as u32,
                rows: *rows as u32,
                scalar: Scalar::new(*scalar),
                stride: if *rows as u32 == 2 { 2 } else { 4 } * u32::from(scalar.width),
            },
            TypeInner::Array { base, size, stride } => TypeLayout::Array {
                element: Box::new(Self::new(module, layouter, *base)?),
                count: match size {
                    ArraySize::Constant(count) => Some(count.get()),
                    ArraySize::Pending(_) | ArraySize::Dynamic => None,
                },
                stride: *stride,
            },
            TypeInner::Struct { members, span } => TypeLayout::Struct {
                name: ty.name.clone().unwrap_or_default(),
                members: members
                    .iter()
                    .map(|member| {
                        let layout = Self::new(module, layouter, member.ty)?;
                        Some(Member {
                            name: member.name.clone().unwrap_or_default(),
                            offset: member.offset,
                            layout,
                        })
                    })
                    .collect::<Option<_>>()?,
                size: *span,
                align: layouter[handle].alignment.round_up(1),
            },
            _ => return None,
        })
    }
}
