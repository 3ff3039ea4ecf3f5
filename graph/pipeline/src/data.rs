//! Blackboard data: what nodes compute on the CPU and shaders read by name.
//!
//! A CPU node publishes a data resource: named, typed values ([`DataShape`]) and, where draws are to be made from
//! them, views. Values reach shaders through uniform or storage blocks of any layout: every member of a block is
//! matched *by its name* with a published value, its type is compared when the pipeline is checked, and the offsets
//! come from the shader's own reflection. So there is no struct that has to be kept alike on two sides.
//!
//! A node can also publish *sizes*: numbers such as the side of an atlas, which the sizes of resources can name
//! (`"size": ["=placement.side", "=placement.side"]`). A plan is made for one value of each, at first the initial one.
//! A node that wants another says so ([`BlackboardData::want_size`]); the executor tells the host, which plans again
//! when it likes (`PlanOptions::data_sizes`). Until then the node has to do with what was planned
//! ([`BlackboardData::planned_size`]).
//!
//! Values are kept as 32-bit words without padding, columns of matrices one after the other; the padding of a block
//! is applied when it is packed.

use glam::{DMat4, Mat4, Vec3, Vec4};

use umbragraph_text::diagnostic::Diagnostics;

/// The component type of a value that shaders read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Component {
    /// 32-bit floating point.
    F32,
    /// 32-bit unsigned integer.
    U32,
    /// 32-bit signed integer.
    I32,
}

impl std::fmt::Display for Component {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Component::F32 => "f32",
            Component::U32 => "u32",
            Component::I32 => "i32",
        })
    }
}

/// The type of a value that blackboard data publishes: a scalar, vector or matrix, or an array of one of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
pub struct ValueType {
    /// The type of each component.
    pub component: Component,
    /// The rows: 1 for a scalar, 2 to 4 for vectors and matrices.
    pub rows: u32,
    /// The columns: 1 for scalars and vectors.
    pub columns: u32,
    /// The number of elements of an array; `None` for a single value.
    pub count: Option<u32>,
}

impl ValueType {
    /// `f32`
    pub const F32: Self = Self::vector(Component::F32, 1);
    /// `u32`
    pub const U32: Self = Self::vector(Component::U32, 1);
    /// `vec2<f32>`
    pub const VEC2: Self = Self::vector(Component::F32, 2);
    /// `vec3<f32>`
    pub const VEC3: Self = Self::vector(Component::F32, 3);
    /// `vec4<f32>`
    pub const VEC4: Self = Self::vector(Component::F32, 4);
    /// `mat4x4<f32>`
    pub const MAT4: Self = Self { component: Component::F32, rows: 4, columns: 4, count: None };

    /// The type of a scalar (one row) or a vector (2 to 4 rows).
    pub const fn vector(component: Component, rows: u32) -> Self {
        Self { component, rows, columns: 1, count: None }
    }

    /// The type of an array of `count` values of this type.
    #[must_use]
    pub const fn array(self, count: u32) -> Self {
        Self { count: Some(count), ..self }
    }

    /// The number of 32-bit words of one element, without padding.
    pub const fn element_words(self) -> usize {
        (self.rows * self.columns) as usize
    }

    /// The number of 32-bit words of all elements, without padding.
    pub fn words(self) -> usize {
        self.element_words() * self.count.unwrap_or(1) as usize
    }
}

impl std::fmt::Display for ValueType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { component, rows, columns, .. } = self;
        let element = match (rows, columns) {
            (1, 1) => component.to_string(),
            (_, 1) => format!("vec{rows}<{component}>"),
            _ => format!("mat{columns}x{rows}<{component}>"),
        };
        match self.count {
            Some(count) => write!(f, "array<{element}, {count}>"),
            None => f.write_str(&element),
        }
    }
}

/// A named value that blackboard data publishes to shaders.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Published {
    /// The name by which shaders find the value; `array.member` for a member of a struct in an array.
    pub name: String,
    /// The type of the value.
    pub value_type: ValueType,
    /// A description of the value with its unit, for the reference documentation.
    #[serde(skip)]
    pub description: &'static str,
}

/// The shape of blackboard data, which a CPU pass publishes for other passes: its values, sizes and views.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct DataShape {
    /// The published values in the order in which they were declared.
    pub values: Vec<Published>,
    /// The maximum number of views that a frame can have.
    pub max_views: u32,
    /// The minimum number of layers of an array texture whose layers the views are drawn into.
    pub view_layers: u32,
    /// The width and height, in texels, of the textures that the views are drawn into; `None` if any size will do.
    pub view_extent: Option<[u32; 2]>,
    /// The published sizes, such as the side of an atlas in texels. Each has a name and the initial value for the first
    /// plan.
    pub sizes: Vec<(String, u32)>,
}

impl DataShape {
    /// Creates a shape without values, sizes and views.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a published value. `description` describes the value and its unit for the reference documentation.
    #[must_use]
    pub fn value(mut self, name: &str, value_type: ValueType, description: &'static str) -> Self {
        self.values.push(Published { name: name.to_owned(), value_type, description });
        self
    }

    /// Sets the maximum number of views of a frame. Each view has a layer of its own, unless [`DataShape::view_layers`]
    /// sets another number of layers.
    #[must_use]
    pub fn views(self, max: u32) -> Self {
        Self { max_views: max, view_layers: max, ..self }
    }

    /// Sets the minimum number of layers of an array texture that the views are drawn into. The number is less than
    /// that of views where several views share a layer, or where the number of layers is a published size.
    #[must_use]
    pub fn view_layers(self, view_layers: u32) -> Self {
        Self { view_layers, ..self }
    }

    /// Sets the width and height, in texels, of the textures that the views are drawn into.
    #[must_use]
    pub fn view_extent(self, extent: [u32; 2]) -> Self {
        Self { view_extent: Some(extent), ..self }
    }

    /// Adds a published size. `initial` is the value that the first plan is made for.
    #[must_use]
    pub fn size(mut self, name: &str, initial: u32) -> Self {
        self.sizes.push((name.to_owned(), initial));
        self
    }

    /// Returns the index in `values` of the value with this name, or `None` if there is none.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.values.iter().position(|value| value.name == name)
    }
}

/// A camera or light view from which draws are made, with its target layer and viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct View {
    /// The transform from world to clip space, with depth 0..1 (1..0 if `reverse`).
    pub clip_from_world: DMat4,
    /// The transform from world to view space, in which the view looks along −Z.
    pub view_from_world: DMat4,
    /// The position of the view, in world metres; for an orthographic view any point on its near plane.
    pub position: glam::DVec3,
    /// The unit direction in world space in which the view looks.
    pub forward: glam::DVec3,
    /// Whether depth runs from 1 (near) to 0 (far).
    pub reverse: bool,
    /// The layer of the attachments that the view draws into.
    pub layer: u32,
    /// The rectangle that the view draws into, in texels from the top left: x, y, width, height. `None` for the whole
    /// attachment.
    pub viewport: Option<[u32; 4]>,
}

impl View {
    /// Creates a view that draws into all of layer 0, with depth from 0 to 1.
    pub fn new(
        clip_from_world: DMat4,
        view_from_world: DMat4,
        position: glam::DVec3,
        forward: glam::DVec3,
    ) -> Self {
        Self { clip_from_world, view_from_world, position, forward, reverse: false, layer: 0, viewport: None }
    }

    umbragraph_text::setters! {
        /// Sets whether depth runs from 1 (near) to 0 (far).
        reverse: bool,
        /// Sets the layer of the attachments that the view draws into.
        layer: u32,
        /// Sets the rectangle that the view draws into, in texels (x, y, width, height); `None` for the whole
        /// attachment.
        viewport: Option<[u32; 4]>,
    }

    /// The members of the uniform block `view`, which every draw of a view can read.
    pub fn shape() -> DataShape {
        DataShape::new()
            .value("clip_from_world", ValueType::MAT4, "world to clip space, depth 0..1 (1..0 reversed)")
            .value("view_from_world", ValueType::MAT4, "world to view space, which looks along -z")
            .value(
                "position",
                ValueType::VEC3,
                "where the view stands, metres; of an orthographic one any point on its near plane",
            )
            .value("forward", ValueType::VEC3, "the unit direction in which it looks")
            .value("layer", ValueType::U32, "the layer of the attachments that it draws into")
    }

    /// Writes the view's matrices, position, direction and layer into `data`, which has the shape [`View::shape`].
    pub fn publish(&self, data: &mut BlackboardData) {
        data.set_matrix("clip_from_world", &self.clip_from_world);
        data.set_matrix("view_from_world", &self.view_from_world);
        data.set_vec3("position", self.position.as_vec3());
        data.set_vec3("forward", self.forward.as_vec3());
        data.set_u32("layer", self.layer);
    }
}

/// The blackboard data of a CPU node for one frame: values for shaders, sizes and views. Its memory is reused from
/// frame to frame.
#[derive(Clone, Debug)]
pub struct BlackboardData {
    shape: DataShape,
    offsets: Vec<usize>,
    words: Vec<u32>,
    views: Vec<View>,
    /// For each view, the number of frames that changed meshes may wait for a redraw, in a pass that keeps the view's
    /// texels.
    cadences: Vec<u32>,
    /// The value that the plan was made for and the wanted value, for each published size in the order of
    /// `shape.sizes`.
    sizes: Vec<(u32, u32)>,
    rejected: Option<String>,
    notices: Diagnostics,
    /// The indices of the lights that the node has read, in the frame's list of lights.
    read_lights: Vec<u32>,
}

impl BlackboardData {
    /// Creates data of a shape, with all values zero and no views.
    pub fn new(shape: DataShape) -> Self {
        let mut offsets = Vec::with_capacity(shape.values.len());
        let mut length = 0;
        for value in &shape.values {
            offsets.push(length);
            length += value.value_type.words();
        }
        let views = Vec::with_capacity(shape.max_views as usize);
        let cadences = Vec::with_capacity(shape.max_views as usize);
        let sizes = shape.sizes.iter().map(|(_, initial)| (*initial, *initial)).collect();
        Self {
            shape,
            offsets,
            words: vec![0; length],
            views,
            cadences,
            sizes,
            rejected: None,
            notices: Diagnostics::new(),
            read_lights: Vec::new(),
        }
    }

    /// The shape of the data: its declared values, sizes and views.
    pub fn shape(&self) -> &DataShape {
        &self.shape
    }

    /// The views that were added in this frame.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// Sets all values to zero, and removes the views, the rejection and the record of lights read.
    pub fn clear(&mut self) {
        self.words.fill(0);
        self.views.clear();
        self.cadences.clear();
        self.rejected = None;
        self.read_lights.clear();
    }

    /// Marks the light at index `position` of the frame's lights as used. Lights that no node reads are reported.
    pub fn read_light(&mut self, position: usize) {
        self.read_lights.push(position as u32);
    }

    /// The indices of the lights that the node has read, in the frame's list of lights.
    pub fn read_lights(&self) -> &[u32] {
        &self.read_lights
    }

    /// For each view, the number of frames that changed meshes may wait for a redraw, in a pass that keeps the view's
    /// texels.
    pub fn cadences(&self) -> &[u32] {
        &self.cadences
    }

    /// Adds a view of this frame. A view beyond the declared maximum is dropped, and [`BlackboardData::rejected`] then
    /// returns a message.
    pub fn push_view(&mut self, view: View) {
        self.push_view_every(view, 1);
    }

    /// Adds a view of this frame. In a pass that keeps the view's texels, changed draws may wait for up to `cadence`
    /// frames.
    pub fn push_view_every(&mut self, view: View, cadence: u32) {
        if self.views.len() < self.shape.max_views as usize {
            self.views.push(view);
            self.cadences.push(cadence);
        } else {
            self.rejected = Some(format!("more than the {} declared views", self.shape.max_views));
        }
    }

    /// The latest reason for which a value, size or view did not fit the declared shape; `None` if all of them fit.
    pub fn rejected(&self) -> Option<&str> {
        self.rejected.as_deref()
    }

    /// The value of a published size that the plan was made for; 0 if no size has this name.
    pub fn planned_size(&self, name: &str) -> u32 {
        self.size_at(name).map_or(0, |at| self.sizes[at].0)
    }

    /// Requests a value of a published size for the next plan. A name that was not declared is rejected.
    pub fn want_size(&mut self, name: &str, size: u32) {
        match self.size_at(name) {
            Some(at) => self.sizes[at].1 = size,
            None => self.rejected = Some(format!("the size \"{name}\", which was not declared")),
        }
    }

    /// The published sizes: the name of each, the value that the plan was made for, and the wanted value.
    pub fn sizes(&self) -> impl Iterator<Item = (&str, u32, u32)> {
        let names = self.shape.sizes.iter().map(|(name, _)| name.as_str());
        names.zip(&self.sizes).map(|(name, (planned, wanted))| (name, *planned, *wanted))
    }

    /// Sets the planned and the wanted value of every published size. `planned` returns the value for a name and an
    /// initial value; the executor calls this for its plan.
    pub fn plan_sizes(&mut self, planned: impl Fn(&str, u32) -> u32) {
        for ((name, initial), size) in self.shape.sizes.iter().zip(&mut self.sizes) {
            let value = planned(name, *initial);
            *size = (value, value);
        }
    }

    fn size_at(&self, name: &str) -> Option<usize> {
        self.shape.sizes.iter().position(|(known, _)| known == name)
    }

    /// Diagnostics of the CPU node that publishes the data: limits that were reached, and omissions with their reasons.
    pub fn notices(&self) -> &Diagnostics {
        &self.notices
    }

    /// Replaces the diagnostics of the CPU node. They are kept from frame to frame, so a node sets them only when they
    /// change.
    pub fn set_notices(&mut self, notices: Diagnostics) {
        self.notices = notices;
    }

    /// The 32-bit words of the value `name`; `None` if no value has this name.
    pub fn words(&self, name: &str) -> Option<&[u32]> {
        self.shape.find(name).and_then(|at| self.words_at(at))
    }

    /// The 32-bit words of the value at an index of the shape's values, or `None` if the index is out of range.
    pub fn words_at(&self, index: usize) -> Option<&[u32]> {
        let start = *self.offsets.get(index)?;
        self.words.get(start..start + self.shape.values[index].value_type.words())
    }

    /// Sets a value from its 32-bit words. An array may be set in part, from its start. An unknown name or too many
    /// words are an error of the node, which [`BlackboardData::rejected`] returns.
    pub fn set_words(&mut self, name: &str, words: impl IntoIterator<Item = u32>) {
        let Some(at) = self.shape.find(name) else {
            self.rejected = Some(format!("the value \"{name}\", which was not declared"));
            return;
        };
        let start = self.offsets[at];
        let length = self.shape.values[at].value_type.words();
        for (count, word) in words.into_iter().enumerate() {
            if count == length {
                self.rejected = Some(format!(
                    "more than the declared {} for \"{name}\"",
                    self.shape.values[at].value_type
                ));
                return;
            }
            self.words[start + count] = word;
        }
    }

    /// Sets a value from its `f32` components: a scalar, a vector, a matrix, or an array of these.
    pub fn set_f32s(&mut self, name: &str, values: impl IntoIterator<Item = f32>) {
        self.set_words(name, values.into_iter().map(f32::to_bits));
    }

    /// Sets an `f32` value by name.
    pub fn set_f32(&mut self, name: &str, value: f32) {
        self.set_f32s(name, [value]);
    }

    /// Sets a `u32` value by name.
    pub fn set_u32(&mut self, name: &str, value: u32) {
        self.set_words(name, [value]);
    }

    /// Sets a `vec3<f32>` value by name.
    pub fn set_vec3(&mut self, name: &str, value: Vec3) {
        self.set_f32s(name, value.to_array());
    }

    /// Sets a value that is an array of `vec4<f32>`, by name.
    pub fn set_vec4s(&mut self, name: &str, values: impl IntoIterator<Item = Vec4>) {
        self.set_f32s(name, values.into_iter().flat_map(|value| value.to_array()));
    }

    /// Sets a `mat4x4<f32>` value by name; the elements are rounded from `f64`.
    pub fn set_matrix(&mut self, name: &str, value: &DMat4) {
        self.set_matrices(name, [*value]);
    }

    /// Sets a value that is an array of `mat4x4<f32>`, by name; the elements are rounded from `f64`.
    pub fn set_matrices(&mut self, name: &str, values: impl IntoIterator<Item = DMat4>) {
        self.set_f32s(name, values.into_iter().flat_map(|value| Mat4::to_cols_array(&value.as_mat4())));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_declared_is_rejected_and_said() {
        let mut data = BlackboardData::new(DataShape::new().value("a", ValueType::F32.array(2), "").views(0));
        data.set_f32s("a", [1.0, 2.0]);
        assert_eq!(data.words("a"), Some([1f32.to_bits(), 2f32.to_bits()].as_slice()));
        assert_eq!(data.rejected(), None);
        data.set_f32s("a", [1.0, 2.0, 3.0]);
        assert!(data.rejected().unwrap().contains("array<f32, 2>"));
        data.clear();
        data.set_f32("b", 1.0);
        assert!(data.rejected().unwrap().contains("\"b\""));
    }
}
