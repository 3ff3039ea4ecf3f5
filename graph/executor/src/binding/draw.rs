//! The draw contract at record time: what the host brings, and the render pass that it draws into.
//!
//! [`HostInterface`] describes the host's mesh storage in advance, without a device.

use std::collections::BTreeMap;

use umbragraph_pipeline::data::View;
use umbragraph_pipeline::draw::{HostInterface, PropertySet};
use umbragraph_pipeline::work::DrawOrder;

use umbragraph_compiler::Plan;

/// The interfaces that a draw source has stated, by geometry contract.
pub(crate) type Stated = BTreeMap<String, HostInterface>;

/// The sources of mesh storage: the host's draw source, or the storage that an earlier one declared.
#[derive(Clone, Copy)]
pub(crate) struct Host<'a> {
    pub(crate) source: Option<&'a dyn DrawSource>,
    pub(crate) stated: &'a Stated,
}

impl<'a> Host<'a> {
    /// The storage that the host declares for a geometry contract.
    pub(crate) fn stated(self, geometry: &str) -> Option<&'a HostInterface> {
        match self.source {
            Some(source) => source.interface(geometry),
            None => self.stated.get(geometry),
        }
    }

    /// The storage of a geometry contract: as the host states it, or else as the plan was made with.
    pub(crate) fn interface(self, plan: &'a Plan, geometry: &str) -> Option<&'a HostInterface> {
        self.stated(geometry).or_else(|| plan.pipeline.hosts.get(geometry))
    }
}

/// A host's meshes, as a pipeline draws them.
pub trait DrawSource: wgpu::WasmNotSend + wgpu::WasmNotSync {
    /// The host's storage of a geometry contract, where it is not what the plan was made with (`Library::host`).
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        let _ = geometry;
        None
    }

    /// Counts up whenever materials or the buffers behind bindings are replaced, so that bind groups are remade.
    fn generation(&self) -> u64 {
        0
    }

    /// Counts up whenever something that a filter lets through appears, vanishes, moves, or changes its shape or its
    /// material's holes, so that passes with `"redraw": "changed"` draw it again; without it they do so in every frame.
    fn revision(&self, filter: &str) -> Option<u64> {
        let _ = filter;
        None
    }

    /// The number of materials; none of hosts whose shaders have none, or that bind groups of their own.
    fn material_count(&self) -> u32 {
        0
    }

    /// The resource for a binding of group 2 of a material.
    fn material(&self, material: u32, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        let _ = (material, binding);
        None
    }

    /// The resource for a binding of group 3. Of a buffer of blocks, all of it: the module moves from object to object.
    fn object(&self, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        let _ = binding;
        None
    }

    /// The buffer for an import of this name that was not given with `Executor::give`; asked for in each record, and only
    /// if the plan imports it. `None` if the host has none.
    ///
    /// # Errors
    /// The reason why the host cannot make it, which the record reports.
    fn buffer(&self, name: &str) -> Option<Result<&wgpu::Buffer, String>> {
        let _ = name;
        None
    }

    /// Issues the draws of one view.
    fn draw(&self, pass: &mut dyn DrawPass);
}

/// A render pass in which a host issues draws; what the pass attaches and binds besides is in place already.
pub trait DrawPass {
    /// The geometry contract that is drawn.
    fn geometry(&self) -> &str;
    /// The filter: which of the host's draws.
    fn filter(&self) -> &str;
    /// The view, for culling and sorting.
    fn view(&self) -> &View;
    /// The order in which the pass wants its draws.
    fn order(&self) -> DrawOrder {
        DrawOrder::default()
    }
    /// The level of detail that the pass wants in this view, 0 the finest; of what has fewer levels the last.
    fn detail(&self) -> u32 {
        0
    }
    /// Chooses the pipeline for meshes with these properties. `false` if the set is not among those that the
    /// host's interface names; nothing may be drawn then.
    fn set_properties(&mut self, properties: PropertySet) -> bool;
    /// Binds a material.
    fn set_material(&mut self, material: u32);
    /// Binds an object by its position in the host's buffers. Hosts whose objects are arrays need not: the instances of
    /// a draw say which.
    fn set_object(&mut self, object: u32);
    /// Binds a bind group of the host's own, for material or object, of the layout that its interface says. `false`
    /// where the interface says none, or the shaders of the pass bind nothing there.
    fn set_bind_group(&mut self, index: u32, group: &wgpu::BindGroup, offsets: &[u32]) -> bool {
        let _ = (index, group, offsets);
        false
    }
    /// Says that the draws of the pass could not be issued, and why: the record reports it.
    fn fail(&mut self, reason: String) {
        let _ = reason;
    }
    /// The render pass, for vertex buffers, index buffers and draws. Bind groups and pipelines are the module's.
    fn render_pass(&mut self) -> &mut wgpu::RenderPass<'static>;
}
