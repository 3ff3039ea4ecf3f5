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

/// The component type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Component {
    /// 32-bit floating point.
    F32,
    /// 32-bit unsigned.
    U32,
    /// 32-bit signed.
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

/// The type of a published value: a scalar, vector or matrix, or an array of such.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
pub struct ValueType {
    /// The component type.
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

    /// A scalar (one row) or vector.
    pub const fn vector(component: Component, rows: u32) -> Self {
        Self { component, rows, columns: 1, count: None }
    }

    /// An array of `count` such values.
    #[must_use]
    pub const fn array(self, count: u32) -> Self {
        Self { count: Some(count), ..self }
    }

    /// The number of 32-bit words of one element.
    pub const fn element_words(self) -> usize {
        (self.rows * self.columns) as usize
    }

    /// The number of 32-bit words of the whole value.
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

/// A value that a data resource has.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Published {
    /// The name by which shaders find it; of a member of a struct in an array `array.member`.
    pub name: String,
    /// Its type.
    pub value_type: ValueType,
    /// A description, with its unit, for the reference.
    #[serde(skip)]
    pub description: &'static str,
}

/// The shape of a data resource: its values, sizes and views.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct DataShape {
    /// The published values in the order in which they were declared.
    pub values: Vec<Published>,
    /// The maximum number of views that a frame can have.
    pub max_views: u32,
    /// The layers that an array has at least, if views are drawn into its layers.
    pub view_layers: u32,
    /// The width and height of the textures that the views are made for, in texels, if not any will do.
    pub view_extent: Option<[u32; 2]>,
    /// The published sizes, each with the value that the first plan is made for.
    pub sizes: Vec<(String, u32)>,
}

impl DataShape {
    /// Data with no published value.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a value, with what it is and its unit.
    #[must_use]
    pub fn value(mut self, name: &str, value_type: ValueType, description: &'static str) -> Self {
        self.values.push(Published { name: name.to_owned(), value_type, description });
        self
    }

    /// States the maximum number of views. Each of them can be drawn into a layer of its own, unless
    /// [`DataShape::view_layers`] says otherwise.
    #[must_use]
    pub fn views(self, max: u32) -> Self {
        Self { max_views: max, view_layers: max, ..self }
    }

    /// States the layers that an array has at least: fewer than views where several are drawn into one, or where their
    /// number is a published size.
    #[must_use]
    pub fn view_layers(self, view_layers: u32) -> Self {
        Self { view_layers, ..self }
    }

    /// States the width and height of the textures that the views are made for.
    #[must_use]
    pub fn view_extent(self, extent: [u32; 2]) -> Self {
        Self { view_extent: Some(extent), ..self }
    }

    /// Adds a size, with the value that the first plan is made for.
    #[must_use]
    pub fn size(mut self, name: &str, initial: u32) -> Self {
        self.sizes.push((name.to_owned(), initial));
        self
    }

    /// The index of a value.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.values.iter().position(|value| value.name == name)
    }
}

/// A point of view from which draws are made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct View {
    /// World to clip space, depth 0..1 (or 1..0 where `reverse`).
    pub clip_from_world: DMat4,
    /// World to view space (looks along −Z).
    pub view_from_world: DMat4,
    /// The position of the view, in world metres; for an orthographic view any point on its near plane.
    pub position: glam::DVec3,
    /// The unit direction in which it looks.
    pub forward: glam::DVec3,
    /// Whether depth runs from 1 (near) to 0 (far).
    pub reverse: bool,
    /// The layer of the attachments that the view draws into.
    pub layer: u32,
    /// The texels that the view draws into: x, y, width, height from the top left; `None` for the whole attachment.
    pub viewport: Option<[u32; 4]>,
}

impl View {
    /// A view of the first layer, all of it, with depth from 0 to 1.
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
        /// Sets the layer of the view.
        layer: u32,
        /// A view of a rectangle of texels, or of the whole attachment.
        viewport: Option<[u32; 4]>,
    }

    /// The values of the block `view` that each draw sees.
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

    /// Writes the values of [`View::shape`].
    pub fn publish(&self, data: &mut BlackboardData) {
        data.set_matrix("clip_from_world", &self.clip_from_world);
        data.set_matrix("view_from_world", &self.view_from_world);
        data.set_vec3("position", self.position.as_vec3());
        data.set_vec3("forward", self.forward.as_vec3());
        data.set_u32("layer", self.layer);
    }
}

/// The data that a CPU node publishes for one frame. Its storage is kept from frame to frame.
#[derive(Clone, Debug)]
pub struct BlackboardData {
    shape: DataShape,
    offsets: Vec<usize>,
    words: Vec<u32>,
    views: Vec<View>,
    /// The number of frames between draws of each view's changed meshes, for passes that keep views.
    cadences: Vec<u32>,
    /// The planned and the wanted value of each size.
    sizes: Vec<(u32, u32)>,
    rejected: Option<String>,
    notices: Diagnostics,
    /// The lights of the frame that the node has looked at, by their positions.
    read_lights: Vec<u32>,
}

impl BlackboardData {
    /// All values zero, no views.
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

    /// The shape of the data.
    pub fn shape(&self) -> &DataShape {
        &self.shape
    }

    /// The views of this frame.
    pub fn views(&self) -> &[View] {
        &self.views
    }

    /// Sets all values to zero and removes the views.
    pub fn clear(&mut self) {
        self.words.fill(0);
        self.views.clear();
        self.cadences.clear();
        self.rejected = None;
        self.read_lights.clear();
    }

    /// Marks a light of the frame, by its position, as used: lights that no node reads are reported.
    pub fn read_light(&mut self, position: usize) {
        self.read_lights.push(position as u32);
    }

    /// The lights that the node has read, by their positions in the frame.
    pub fn read_lights(&self) -> &[u32] {
        &self.read_lights
    }

    /// The maximum number of frames after which a pass that keeps a view draws its changed meshes, for each view.
    pub fn cadences(&self) -> &[u32] {
        &self.cadences
    }

    /// Adds a view. Beyond the declared maximum it is rejected, which [`BlackboardData::rejected`] tells.
    pub fn push_view(&mut self, view: View) {
        self.push_view_every(view, 1);
    }

    /// Adds a view whose changed draws may wait for up to `cadence` frames in a pass that keeps it.
    pub fn push_view_every(&mut self, view: View, cadence: u32) {
        if self.views.len() < self.shape.max_views as usize {
            self.views.push(view);
            self.cadences.push(cadence);
        } else {
            self.rejected = Some(format!("more than the {} declared views", self.shape.max_views));
        }
    }

    /// Why something that was set did not fit what was declared: a name, a type or a count.
    pub fn rejected(&self) -> Option<&str> {
        self.rejected.as_deref()
    }

    /// The size that the plan was made for; 0 if there is none of that name.
    pub fn planned_size(&self, name: &str) -> u32 {
        self.size_at(name).map_or(0, |at| self.sizes[at].0)
    }

    /// Says which size a plan should be made for.
    pub fn want_size(&mut self, name: &str, size: u32) {
        match self.size_at(name) {
            Some(at) => self.sizes[at].1 = size,
            None => self.rejected = Some(format!("the size \"{name}\", which was not declared")),
        }
    }

    /// The sizes by name: what the plan was made for, and what is wanted.
    pub fn sizes(&self) -> impl Iterator<Item = (&str, u32, u32)> {
        let names = self.shape.sizes.iter().map(|(name, _)| name.as_str());
        names.zip(&self.sizes).map(|(name, (planned, wanted))| (name, *planned, *wanted))
    }

    /// Says which sizes a plan was made for, from name and initial value; the executor does it for its plan.
    pub fn plan_sizes(&mut self, planned: impl Fn(&str, u32) -> u32) {
        for ((name, initial), size) in self.shape.sizes.iter().zip(&mut self.sizes) {
            let value = planned(name, *initial);
            *size = (value, value);
        }
    }

    fn size_at(&self, name: &str) -> Option<usize> {
        self.shape.sizes.iter().position(|(known, _)| known == name)
    }

    /// The notices of the node that publishes the data: limits that were reached, what was left out and why.
    pub fn notices(&self) -> &Diagnostics {
        &self.notices
    }

    /// Replaces what the node has to say. It stays from frame to frame, so a node says it once, when it changes.
    pub fn set_notices(&mut self, notices: Diagnostics) {
        self.notices = notices;
    }

    /// The words of a value, or `None` if there is none of that name.
    pub fn words(&self, name: &str) -> Option<&[u32]> {
        self.shape.find(name).and_then(|at| self.words_at(at))
    }

    /// The words of the value at an index of the shape.
    pub fn words_at(&self, index: usize) -> Option<&[u32]> {
        let start = *self.offsets.get(index)?;
        self.words.get(start..start + self.shape.values[index].value_type.words())
    }

    /// Sets a value from its words. An array may be set in part, from its start.
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

    /// Sets an `f32`, or an array of them.
    pub fn set_f32s(&mut self, name: &str, values: impl IntoIterator<Item = f32>) {
        self.set_words(name, values.into_iter().map(f32::to_bits));
    }

    /// Sets an `f32`.
    pub fn set_f32(&mut self, name: &str, value: f32) {
        self.set_f32s(name, [value]);
    }

    /// Sets a `u32`.
    pub fn set_u32(&mut self, name: &str, value: u32) {
        self.set_words(name, [value]);
    }

    /// Sets a `vec3<f32>`.
    pub fn set_vec3(&mut self, name: &str, value: Vec3) {
        self.set_f32s(name, value.to_array());
    }

    /// Sets an array of `vec4<f32>`.
    pub fn set_vec4s(&mut self, name: &str, values: impl IntoIterator<Item = Vec4>) {
        self.set_f32s(name, values.into_iter().flat_map(|value| value.to_array()));
    }

    /// Sets a `mat4x4<f32>`, rounded from `f64`.
    pub fn set_matrix(&mut self, name: &str, value: &DMat4) {
        self.set_matrices(name, [*value]);
    }

    /// Sets an array of `mat4x4<f32>`, rounded from `f64`.
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
