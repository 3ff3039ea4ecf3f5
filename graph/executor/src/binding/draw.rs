//! The draw contract at record time: what the host brings, and the render pass that it draws into.
//!
//! [`HostInterface`] describes the host's mesh storage in advance, without a device.

use std::collections::BTreeMap;

use umbragraph_pipeline::data::View;
use umbragraph_pipeline::draw::{HostInterface, PropertySet};
use umbragraph_pipeline::work::DrawOrder;

use umbragraph_compiler::Plan;

/// The interfaces that draw sources have declared, by geometry contract.
pub(crate) type Stated = BTreeMap<String, HostInterface>;

/// The sources of mesh layouts: the host's draw source, or the interfaces that an earlier draw source declared.
#[derive(Clone, Copy)]
pub(crate) struct Host<'a> {
    pub(crate) source: Option<&'a dyn DrawSource>,
    pub(crate) stated: &'a Stated,
}

impl<'a> Host<'a> {
    /// Returns the interface that the host declares for a geometry contract; `None` if the host declares none.
    pub(crate) fn stated(self, geometry: &str) -> Option<&'a HostInterface> {
        match self.source {
            Some(source) => source.interface(geometry),
            None => self.stated.get(geometry),
        }
    }

    /// Returns the interface of a geometry contract: as the host declares it, or else as the plan was made with.
    pub(crate) fn interface(self, plan: &'a Plan, geometry: &str) -> Option<&'a HostInterface> {
        self.stated(geometry).or_else(|| plan.pipeline.hosts.get(geometry))
    }
}

/// The host's meshes, materials and objects. The executor calls [`Self::draw`] for each view of each pass that draws
/// meshes.
pub trait DrawSource: wgpu::WasmNotSend + wgpu::WasmNotSync {
    /// Returns the host's mesh layout for a geometry contract; `None` if the layout of the plan (`Library::host`)
    /// holds.
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        let _ = geometry;
        None
    }

    /// Returns a number that grows whenever materials or bound buffers are replaced, so that bind groups are created
    /// again.
    fn generation(&self) -> u64 {
        0
    }

    /// Returns a number that grows whenever the result of a filter's draws changes: objects appear, vanish, move, or
    /// change shape or cut-out material. Passes with `"redraw": "changed"` then draw again. With `None` these passes
    /// draw in every frame.
    fn revision(&self, filter: &str) -> Option<u64> {
        let _ = filter;
        None
    }

    /// The number of materials; 0 if the host's shaders have none, or the host binds bind groups of its own.
    fn material_count(&self) -> u32 {
        0
    }

    /// The resource for a binding of a material in bind group 2; `None` if the host has none.
    fn material(&self, material: u32, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        let _ = (material, binding);
        None
    }

    /// The resource for a binding of an object in bind group 3. For a buffer of per-object blocks, return the entire
    /// buffer: dynamic offsets select the object.
    fn object(&self, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        let _ = binding;
        None
    }

    /// Returns the buffer for an import that was not given with `Executor::give`. Called in each record if the plan
    /// imports a buffer of this name. `None` if the host has none.
    ///
    /// # Errors
    /// The reason why the host cannot create the buffer; the record reports this reason.
    fn buffer(&self, name: &str) -> Option<Result<&wgpu::Buffer, String>> {
        let _ = name;
        None
    }

    /// Issues the draws of one view.
    fn draw(&self, pass: &mut dyn DrawPass);
}

/// A render pass in which a host issues draws. Attachments and the pipeline's own bindings are already set.
pub trait DrawPass {
    /// The geometry contract that is drawn.
    fn geometry(&self) -> &str;
    /// The filter that selects the host's draws for this pass.
    fn filter(&self) -> &str;
    /// The view that is drawn, for culling and sorting.
    fn view(&self) -> &View;
    /// The order in which the pass requests its draws.
    fn order(&self) -> DrawOrder {
        DrawOrder::default()
    }
    /// The level of detail that the pass requests in this view; 0 is the finest. Meshes with fewer levels use their
    /// last.
    fn detail(&self) -> u32 {
        0
    }
    /// Selects the pipeline for meshes with these properties. Returns `false` if the host's interface does not name
    /// this set of properties; then draw nothing.
    fn set_properties(&mut self, properties: PropertySet) -> bool;
    /// Binds a material by its index.
    fn set_material(&mut self, material: u32);
    /// Binds an object by its index in the host's buffers. Hosts that keep objects in arrays skip this call, since the
    /// instance index of a draw selects the object.
    fn set_object(&mut self, object: u32);
    /// Binds a bind group of the host's own for materials or objects, with the layout of the host's interface. Returns
    /// `false` if the interface has no such layout, or the shaders of the pass bind nothing there.
    fn set_bind_group(&mut self, index: u32, group: &wgpu::BindGroup, offsets: &[u32]) -> bool {
        let _ = (index, group, offsets);
        false
    }
    /// Reports that the draws of the pass could not be issued. The record reports the reason.
    fn fail(&mut self, reason: String) {
        let _ = reason;
    }
    /// The render pass, for vertex buffers, index buffers and draws. Leave bind groups and pipelines to the executor.
    fn render_pass(&mut self) -> &mut wgpu::RenderPass<'static>;
}
