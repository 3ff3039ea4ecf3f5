//! The frames of histories, and their rotation.
//!
//! Each history stands on one texture or buffer more than it keeps earlier frames. A record is a frame: it moves every
//! copy on by one, writes the one that was the oldest, and reads the others by their age. Several records in one
//! encoder or one submission are as many frames, in the order in which they were recorded, so encoders have to be
//! submitted in that order. A record in which toggles leave out every pass that writes a history is no frame to it:
//! what was written last stays the frame before. A record that fails moves nothing; one whose encoder is never
//! submitted has moved all the same, and what it would have written is not there: a reset helps.
//!
//! A history that is new, whose copies were made again (for another size, another format), or that was reset, begins
//! with its initial value: the next record clears every copy before its first pass, in its own encoder, so that records
//! before it are not disturbed. Textures are cleared by render passes, one for each mip and layer, stencil to zero,
//! buffers from a buffer that holds the value.

use super::textures::Textures;
use crate::objects::creation::Creation;
use umbragraph_compiler::Switches;
use umbragraph_compiler::{InitialValue, Physical, Plan};
use umbragraph_pipeline::work::{PassHandle, ResourceHandle};

/// The histories of a plan: resources whose contents of earlier frames remain readable.
#[derive(Default)]
pub(crate) struct Histories {
    list: Vec<History>,
    clears: Vec<Clear>,
}

struct History {
    name: String,
    resource: ResourceHandle,
    places: Vec<Physical>,
    initial: InitialValue,
    /// The number of places by which the copies have advanced since the first record, modulo their number.
    moved: usize,
    /// Whether the last record wrote the history; the next record then advances it.
    written: bool,
    /// `moved` and `written` before the current record.
    before: (usize, bool),
    is_fresh: bool,
    /// The passes that write the history.
    writers: Vec<PassHandle>,
}

/// One frame of a history, by its age. The texture or buffer that holds it changes with each record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turn {
    /// The index of the history in [`Histories`].
    pub(crate) history: usize,
    back: usize,
}

/// A command that sets one copy of a history to its initial value, recorded before the first pass.
enum Clear {
    Color(wgpu::TextureView, Option<u32>, wgpu::Color),
    Depth(wgpu::TextureView, f32),
    Zero(wgpu::Buffer),
    Fill { from: wgpu::Buffer, to: wgpu::Buffer },
}

impl Histories {
    /// Creates the histories of a plan. A history of the previous plan continues if all of its textures or buffers are
    /// reused.
    pub(crate) fn new(plan: &Plan, textures: &Textures, before: Option<(&Self, &Textures)>) -> Self {
        let list = plan.histories.iter().map(|(name, planned)| {
            let places = planned.places.clone();
            let known = before.and_then(|(before, old)| {
                let known = before.list.iter().find(|known| known.name == *name)?;
                let copies = known.places.iter().zip(&places);
                let kept = known.places.len() == places.len()
                    && copies.into_iter().all(|(was, is)| textures.is_same(*is, old, *was));
                kept.then_some(known)
            });
            History {
                name: name.clone(),
                resource: planned.handle,
                moved: known.map_or(places.len().saturating_sub(1), |known| known.moved),
                written: known.is_none_or(|known| known.written),
                before: (0, false),
                is_fresh: known.is_none_or(|known| known.is_fresh),
                writers: writers(plan, planned.handle),
                places,
                initial: planned.initial,
            }
        });
        Self { list: list.collect(), clears: Vec::new() }
    }

    /// Returns the frame of a history that a resource refers to; `None` for a resource without history.
    pub(crate) fn turn(&self, plan: &Plan, resource: ResourceHandle) -> Option<Turn> {
        let history = plan.pipeline.resource(resource).history?;
        let at = self.list.iter().position(|known| known.resource == history.of)?;
        Some(Turn { history: at, back: history.back as usize })
    }

    /// The textures or buffers of a history in the plan, one for each copy; empty for an unknown history.
    pub(crate) fn places(&self, turn: Turn) -> &[Physical] {
        self.list.get(turn.history).map(|history| history.places.as_slice()).unwrap_or_default()
    }

    /// Returns the index in `places` of the texture or buffer that holds a frame in the current record.
    pub(crate) fn position(&self, turn: Turn) -> usize {
        self.list.get(turn.history).map_or(0, |history| {
            let count = history.places.len().max(1);
            (turn.back + count - history.moved) % count
        })
    }

    /// The number of places by which a history has advanced. Objects made from its frames are valid for that state
    /// only.
    pub(crate) fn moved(&self, history: usize) -> usize {
        self.list.get(history).map_or(0, |history| history.moved)
    }

    /// Begins a record: rotates the copies of each history that the last record wrote. With `is_again` the record is
    /// the last frame once more: nothing rotates, and it overwrites what the last record wrote.
    pub(crate) fn advance(&mut self, plan: &Plan, switches: &Switches, is_again: bool) {
        for history in &mut self.list {
            history.before = (history.moved, history.written);
            if history.written && !is_again {
                history.moved = (history.moved + 1) % history.places.len().max(1);
            }
            let writes = history.writers.iter().any(|writer| switches.runs(plan, *writer));
            history.written = writes || (history.written && is_again);
        }
    }

    /// Undoes the last advance, after a record failed.
    pub(crate) fn retreat(&mut self) {
        self.clears.clear();
        for history in &mut self.list {
            (history.moved, history.written) = history.before;
        }
    }

    /// Restarts every history with its initial value in the next record.
    pub(crate) fn reset(&mut self) {
        for history in &mut self.list {
            history.is_fresh = true;
        }
    }

    /// Creates the views and buffers that clear new and reset histories.
    pub(crate) fn prepare(&mut self, creation: &mut Creation<'_>, queue: &wgpu::Queue, textures: &Textures) {
        self.clears.clear();
        for history in self.list.iter().filter(|history| history.is_fresh) {
            for place in &history.places {
                match (*place, history.initial) {
                    (Physical::Texture(at), initial) => {
                        if let Some(texture) = textures.texture(at) {
                            clear_texture(creation, &history.name, texture, initial, &mut self.clears);
                        }
                    }
                    (Physical::Buffer(at), InitialValue::Word(word)) => {
                        let Some(to) = textures.buffer(at) else { continue };
                        self.clears.push(if word == 0 {
                            Clear::Zero(to.clone())
                        } else {
                            let from = creation.buffer(&wgpu::BufferDescriptor {
                                label: Some(&history.name),
                                size: to.size(),
                                usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
                                mapped_at_creation: false,
                            });
                            let words = usize::try_from(to.size() / 4).unwrap_or(0);
                            queue.write_buffer(&from, 0, &word.to_le_bytes().repeat(words));
                            Clear::Fill { from, to: to.clone() }
                        });
                    }
                    _ => {}
                }
            }
        }
    }

    /// Records the clears of new and reset histories.
    pub(crate) fn record(&mut self, encoder: &mut wgpu::CommandEncoder) {
        for clear in self.clears.drain(..) {
            match clear {
                Clear::Color(view, depth_slice, color) => {
                    let attachment = wgpu::RenderPassColorAttachment {
                        view: &view,
                        depth_slice,
                        resolve_target: None,
                        ops: cleared_to(color),
                    };
                    drop(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                        label: Some("initial value of a history"),
                        color_attachments: &[Some(attachment)],
                        ..wgpu::RenderPassDescriptor::default()
                    }));
                }
                Clear::Depth(view, depth) => {
                    let format = view.texture().format();
                    drop(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                        label: Some("initial value of a history"),
                        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                            view: &view,
                            depth_ops: format.has_depth_aspect().then_some(cleared_to(depth)),
                            stencil_ops: format.has_stencil_aspect().then_some(cleared_to(0)),
                        }),
                        ..wgpu::RenderPassDescriptor::default()
                    }));
                }
                Clear::Zero(buffer) => encoder.clear_buffer(&buffer, 0, None),
                Clear::Fill { from, to } => encoder.copy_buffer_to_buffer(&from, 0, &to, 0, to.size()),
            }
        }
        for history in &mut self.list {
            history.is_fresh = false;
        }
    }
}

fn cleared_to<V>(value: V) -> wgpu::Operations<V> {
    wgpu::Operations { load: wgpu::LoadOp::Clear(value), store: wgpu::StoreOp::Store }
}

/// The passes of the plan that write a resource.
fn writers(plan: &Plan, resource: ResourceHandle) -> Vec<PassHandle> {
    let writes = |pass: &PassHandle| plan.writes(*pass, resource);
    plan.passes.iter().map(|planned| planned.handle).filter(writes).collect()
}

fn clear_texture(
    creation: &mut Creation<'_>,
    label: &str,
    texture: &wgpu::Texture,
    initial: InitialValue,
    clears: &mut Vec<Clear>,
) {
    let volume = texture.dimension() == wgpu::TextureDimension::D3;
    for mip in 0..texture.mip_level_count() {
        let slices = (texture.depth_or_array_layers() >> mip).max(1);
        let layers = if volume { 1 } else { texture.depth_or_array_layers() };
        for layer in 0..layers {
            let view = creation.view(
                texture,
                &wgpu::TextureViewDescriptor {
                    label: Some(label),
                    dimension: Some(if volume {
                        wgpu::TextureViewDimension::D3
                    } else {
                        wgpu::TextureViewDimension::D2
                    }),
                    base_mip_level: mip,
                    mip_level_count: Some(1),
                    base_array_layer: layer,
                    ..wgpu::TextureViewDescriptor::default()
                },
            );
            match initial {
                InitialValue::Color([r, g, b, a]) => {
                    let color = wgpu::Color { r, g, b, a };
                    if volume {
                        clears
                            .extend((0..slices).map(|slice| Clear::Color(view.clone(), Some(slice), color)));
                    } else {
                        clears.push(Clear::Color(view, None, color));
                    }
                }
                InitialValue::Depth(depth) => clears.push(Clear::Depth(view, depth as f32)),
                InitialValue::Word(_) => {}
            }
        }
    }
}
