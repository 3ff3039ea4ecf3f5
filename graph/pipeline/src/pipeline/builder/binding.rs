//! Bindings of a pass by the names of its shader, and the layout of blackboard data in a shader's blocks.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::data::{Component, DataShape, ValueType, View};
use crate::pipeline::builder::subresources::SubresourceRangeSettings;
use crate::pipeline::configuration::TypedPipeline;
use crate::pipeline::program::Program;
use crate::pipeline::resource::{Resource, ResourceKind};
use crate::work::{Address, BlockLayout, BlockRun, BlockValues, BoundSlot, Compare, Filter, SlotSource};
use umbragraph_shaders::{AxisValue, AxisValues, Member, Scalar, ScalarKind, TypeLayout};
use umbragraph_text::diagnostic::{list_of, suggested_name};
use umbragraph_text::language::{Expr, Ref, TextureShape, Word};

/// The value of one of the shader's bindings.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Bind {
    /// A texture, a buffer or blackboard data: a reference such as "&maps" or "&maps@blur".
    Name(Ref),
    /// An object, for every value that needs more than a reference.
    Object(BindObject),
}

/// The value of a binding that needs more than a reference.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BindObject {
    /// A subresource range of a texture.
    Texture(TextureBind),
    /// A subresource range of a buffer.
    Buffer(BufferBind),
    /// A sampler.
    Sampler(SamplerBind),
    /// The members of a uniform block, each with an expression.
    Values(ValuesBind),
    /// The members of a uniform block at given byte offsets, each with an expression.
    Block(BlockBind),
    /// Blackboard data, and expressions for members of the block that the data does not publish.
    Data(DataBind),
}

/// Expressions by the names of a block's members.
pub type ValuesBind = BTreeMap<String, Expr>;

/// The members of a uniform block, with the byte offsets that they must have.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlockBind {
    /// Expressions by the names of members.
    pub values: ValuesBind,
    /// The byte offsets of members, by name (unit: bytes). If the shader has a member at another offset, the diagnostic
    /// names the "@size" that moves the member.
    pub offsets: BTreeMap<String, u32>,
}

/// Blackboard data, and expressions for members of the block that the data does not publish.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DataBind {
    /// The blackboard data: a reference.
    pub name: Ref,
    /// Expressions by the names of members; they take precedence over values that the data publishes.
    #[serde(default)]
    pub values: ValuesBind,
}

/// A subresource range of a texture.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TextureBind {
    /// The texture: a reference.
    pub name: Ref,
    /// The subresource range.
    #[serde(flatten)]
    pub range: SubresourceRangeSettings,
    /// The format in which the shader reads the texture: the texture's format with or without "-srgb". By default the
    /// texture's own format.
    pub format: Option<String>,
    /// The view dimension; by default the one that the shader declares.
    pub view_dimension: Option<TextureShape>,
    /// The need of a written texture for earlier contents: "discard" if the shader writes all texels. By default,
    /// texels that the shader does not write keep their contents.
    pub contents: Option<Word<Contents>>,
}

/// Whether a writing access needs earlier contents.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Contents {
    /// Earlier contents are kept where the access does not write.
    Load,
    /// All of the contents are written; earlier contents are not needed.
    Discard,
}

/// A subresource range of a buffer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BufferBind {
    /// The buffer: a reference.
    pub name: Ref,
    /// The first byte of the range (unit: bytes); 0 by default.
    pub offset: Option<Expr>,
    /// The size of the range (unit: bytes); all of the buffer by default.
    pub size: Option<Expr>,
    /// The need of a written buffer for earlier contents: "load" by default, "discard" if the shader writes all bytes
    /// before it reads any.
    pub contents: Option<Word<Contents>>,
}

/// A sampler.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SamplerBind {
    /// The filter between texels; by default "linear", or "nearest" for a non-filtering sampler.
    pub filter: Option<Word<Filter>>,
    /// The address mode for coordinates outside of the texture; "clamp-to-edge" by default.
    pub address: Option<Word<Address>>,
    /// For a comparison sampler: the comparison of reference values with texels.
    pub compare: Option<Word<Compare>>,
    /// The maximum anisotropy (1 to 16): the number of samples of a texture that is viewed at a slant; 1 by default.
    pub max_anisotropy: Option<Expr>,
    /// The minimum level of detail (unit: mip levels); 0 by default.
    pub lod_min_clamp: Option<Expr>,
    /// The maximum level of detail (unit: mip levels); 32 by default.
    pub lod_max_clamp: Option<Expr>,
}

/// Returns the layout of blackboard data, or of the view, in the block that a slot binds it to. An error lists the
/// members that do not fit. `None` if the slot binds no data and no view, or if the data is not published.
pub(crate) fn block_layout(
    program: &Program,
    slot: &BoundSlot,
    resources: &[Resource],
) -> Option<Result<BlockLayout, Vec<String>>> {
    let block = program.binding_at(slot.group, slot.binding)?.block.as_ref()?;
    let match_block = |shape: &DataShape, name: &str, values: Option<&BlockValues>| {
        match_block(block, shape, name, values, &program.axes)
    };
    match &slot.source {
        SlotSource::View => Some(match_block(&View::shape(), "view", None)),
        SlotSource::Data { data, values } => {
            let known = resources.get(data.resource.index())?;
            let ResourceKind::Data(Some(shape)) = &known.kind else { return None };
            Some(match_block(shape, &known.name, values.as_ref()))
        }
        _ => None,
    }
}

impl TypedPipeline {
    /// Returns the layout of blackboard data, or of the view, in the block that a slot binds it to. `None` if the slot
    /// binds no data and no view, or if a member does not fit.
    pub fn block_layout(&self, program: &Program, slot: &BoundSlot) -> Option<BlockLayout> {
        block_layout(program, slot, &self.resources)?.ok()
    }

    /// The size in bytes of a block that the executor fills from a slot; `None` for other bindings.
    pub fn block_bytes(&self, program: &Program, slot: &BoundSlot) -> Option<u32> {
        match &slot.source {
            SlotSource::Values(values) => Some(values.layout.size()),
            _ => self.block_layout(program, slot).map(|layout| layout.size),
        }
    }
}

/// Matches the members of a block with published values by name.
///
/// A member takes a value of exactly its type. An array of scalars also fills a vector of as many components, since
/// uniform blocks cannot hold arrays of scalars. It also fills an array of `vec4`, whose last element may be filled in
/// part. Each member of an array of structs takes an array of its own, published as "array.member". Members that
/// `values` names are skipped.
///
/// # Errors
/// Returns a message for each member that no value fits.
fn match_block(
    block: &TypeLayout,
    shape: &DataShape,
    data_name: &str,
    values: Option<&BlockValues>,
    axes: &AxisValues,
) -> Result<BlockLayout, Vec<String>> {
    let TypeLayout::Struct { members, .. } = block else {
        return Err(vec![format!(
            "\"{data_name}\" is blackboard data, which is bound to a struct whose members name its values, and this is none"
        )]);
    };
    let mut runs = Vec::new();
    let mut errors = Vec::new();
    // The members whose arrays differ by their counts alone, by published and declared count.
    let mut counts: BTreeMap<(u32, u32), Vec<String>> = BTreeMap::new();
    let is_given =
        |name: &str| values.is_some_and(|values| values.expressions.iter().any(|(given, _)| given == name));
    for member in flattened(members).iter().filter(|member| !is_given(&member.name)) {
        let Some(index) = shape.find(&member.name) else {
            let names = shape.values.iter().map(|value| value.name.as_str());
            let help = match suggested_name(&member.name, names.clone()) {
                Some(suggested) => format!("did the template mean \"{suggested}\"?"),
                None => format!("it publishes {}", list_of(names)),
            };
            errors.push(format!("\"{data_name}\" publishes no \"{}\"; {help}", member.name));
            continue;
        };
        let value = shape.values[index].value_type;
        match member_runs(&member.layout, value, member.offset) {
            Some(placed) => runs.extend(placed.into_iter().map(|(word, count, offset)| BlockRun {
                value: index as u32,
                word,
                count,
                offset,
            })),
            None => match other_count(&member.layout, value) {
                Some(both) => counts.entry(both).or_default().push(format!("\"{}\"", member.name)),
                None => errors.push(format!(
                    "\"{}\" is published as {value}, but the shader declares {}",
                    member.name,
                    member.layout.spelling()
                )),
            },
        }
    }
    errors.extend(counts.into_iter().map(|((published, declared), names)| {
        let mut same = axes.iter().filter(|(_, value)| **value == AxisValue::Integer(declared.into()));
        let axis = same.next().filter(|_| same.next().is_none());
        let axis = axis.map_or(String::new(), |(name, _)| format!(" (the axis \"{name}\" is {declared})"));
        format!(
            "{} published with {published} elements, but the shader declares {declared}{axis}",
            if let [name] = &names[..] { format!("{name} is") } else { format!("{} are", list_of(&names)) }
        )
    }));
    // An array without a count at the end of a storage block is as long as what is published.
    let end = runs.iter().map(|run: &BlockRun| run.offset + run.count * 4).max().unwrap_or(0);
    let size = if end > block.size() { end.next_multiple_of(block.align().max(4)) } else { block.size() };
    if errors.is_empty() { Ok(BlockLayout { size, runs }) } else { Err(errors) }
}

/// The published and the declared number of elements of an array that would fit with another number; `None` for all
/// else.
fn other_count(layout: &TypeLayout, value: ValueType) -> Option<(u32, u32)> {
    let TypeLayout::Array { element, count, .. } = layout else { return None };
    let (published, declared) = (value.count?, (*count)?);
    let fits = element_type(element)? == ValueType { count: None, ..value } && published != declared;
    fits.then_some((published, declared))
}

/// Returns the members of a struct. An array of structs becomes an array for each member of its struct, named
/// "array.member".
fn flattened(members: &[Member]) -> Vec<Member> {
    let mut all = Vec::with_capacity(members.len());
    for member in members {
        let TypeLayout::Array { element, count, stride } = &member.layout else {
            all.push(member.clone());
            continue;
        };
        let TypeLayout::Struct { members: parts, .. } = &**element else {
            all.push(member.clone());
            continue;
        };
        all.extend(parts.iter().map(|part| Member {
            name: format!("{}.{}", member.name, part.name),
            offset: member.offset + part.offset,
            layout: TypeLayout::Array {
                element: Box::new(part.layout.clone()),
                count: *count,
                stride: *stride,
            },
        }));
    }
    all
}

/// Returns the runs of 32-bit words that copy a value to a block member at a byte offset. Each run has its first word
/// in the value, its number of words and its byte offset in the block. `None` if the types do not fit.
pub fn member_runs(layout: &TypeLayout, value: ValueType, offset: u32) -> Option<Vec<(u32, u32, u32)>> {
    let mut runs = Vec::new();
    if let TypeLayout::Array { element, count, stride } = layout {
        let element_type = element_type(element)?;
        let have = value.count?;
        if element_type == (ValueType { count: None, ..value }) {
            if count.is_some_and(|count| count != have) {
                return None;
            }
            for at in 0..have {
                push_element(
                    element,
                    element_type,
                    at * element_type.element_words() as u32,
                    offset + at * stride,
                    &mut runs,
                );
            }
            return Some(runs);
        }
        // Scalars, four to a vec4.
        let packed = ValueType::vector(value.component, 4);
        if value.element_words() != 1
            || element_type != packed
            || count.is_some_and(|count| count != have.div_ceil(4))
        {
            return None;
        }
        for at in 0..have.div_ceil(4) {
            runs.push((at * 4, (have - at * 4).min(4), offset + at * stride));
        }
        return Some(runs);
    }
    let own = element_type(layout)?;
    let as_vector = value.element_words() == 1
        && value.count == Some(own.rows)
        && own.columns == 1
        && own.component == value.component;
    if own != value && !as_vector {
        return None;
    }
    push_element(layout, own, 0, offset, &mut runs);
    Some(runs)
}

fn push_element(
    layout: &TypeLayout,
    element: ValueType,
    word: u32,
    offset: u32,
    runs: &mut Vec<(u32, u32, u32)>,
) {
    match layout {
        TypeLayout::Matrix { stride, .. } if *stride != element.rows * 4 => {
            for column in 0..element.columns {
                runs.push((word + column * element.rows, element.rows, offset + column * stride));
            }
        }
        _ => runs.push((word, element.element_words() as u32, offset)),
    }
}

/// The value type of a scalar, vector or matrix of 32-bit components; `None` for all other types.
pub fn element_type(layout: &TypeLayout) -> Option<ValueType> {
    let component = |scalar: &Scalar| match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => Some(Component::F32),
        (ScalarKind::Uint, 4) => Some(Component::U32),
        (ScalarKind::Sint, 4) => Some(Component::I32),
        _ => None,
    };
    match layout {
        TypeLayout::Scalar { scalar, .. } => Some(ValueType::vector(component(scalar)?, 1)),
        TypeLayout::Vector { scalar, components } => Some(ValueType::vector(component(scalar)?, *components)),
        TypeLayout::Matrix { scalar, rows, columns, .. } => {
            Some(ValueType { component: component(scalar)?, rows: *rows, columns: *columns, count: None })
        }
        _ => None,
    }
}
