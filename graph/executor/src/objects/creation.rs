//! Creating objects on the device: counted, and with the device's errors caught.
//!
//! wgpu reports errors of creation not at the call, but to the thread's innermost error scope; without a scope it calls
//! a handler that panics unless the host has set another. A [`Creation`] opens scopes when it creates its first object;
//! [`Creation::finish`] closes them. Their errors are available at once, except in a browser, where [`Caught`] holds
//! them until they arrive. A steady frame creates nothing, and so opens no scope. When a plan is instantiated, each
//! pass and each new texture or buffer has its own scopes, so that an error has a place.
//!
//! A lost device reports nothing to scopes, and new objects on it look valid. [`lost`] detects it: the memory of a new
//! buffer cannot be mapped. The test runs after the objects of each pass were created, since some drivers give up the device
//! over one shader; not in a steady frame. What later objects report follows from the loss, and is left out.
//!
//! Limits: in a browser the host learns of a lost device from its own callback alone.

use std::error::Error as _;
use std::future::Future;
use std::pin::Pin;
use std::task::{Context, Poll, Waker};

use crate::measure::statistics::Statistics;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use umbragraph_pipeline::pipeline::{Pass, Resource};

/// Creates objects on a device.
pub(crate) struct Creation<'a> {
    device: &'a wgpu::Device,
    statistics: &'a mut Statistics,
    scopes: Option<Scopes>,
    /// The pass or resource for which objects are created, named in errors.
    site: Site,
    caught: Caught,
    is_lost: bool,
}

/// The place of a pass or resource in its document, its JSON pointer and its name; `None` if no pass or resource is
/// known.
#[derive(Clone, Default)]
struct Site(Option<(Place, String, String)>);

impl Site {
    /// Replaces the error of a lost device by one that names the pass or resource.
    fn lost(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Some((place, pointer, name)) = &self.0 else { return diagnostic };
        let message = format!("the device was lost while the objects of \"{name}\" were created");
        Diagnostic::error(codes::DEVICE_LOST, place.clone(), message).pointer(pointer).help(
            "the driver may not take one of its shaders: try another adapter or backend, with a new device and executor",
        )
    }
}

/// Open error scopes. Fields are dropped in this order, which is the one in which scopes have to be popped.
struct Scopes {
    validation: wgpu::ErrorScopeGuard,
    internal: wgpu::ErrorScopeGuard,
    memory: wgpu::ErrorScopeGuard,
}

/// Defines methods that create an object on the device and count it.
macro_rules! creates {
    ($($name:ident: $create:ident($descriptor:ident) -> $object:ident, $count:ident;)*) => {$(
        pub(crate) fn $name(&mut self, descriptor: &wgpu::$descriptor<'_>) -> wgpu::$object {
            self.statistics.$count += 1;
            self.device().$create(descriptor)
        }
    )*};
}

impl<'a> Creation<'a> {
    pub(crate) fn new(device: &'a wgpu::Device, statistics: &'a mut Statistics) -> Self {
        Self {
            device,
            statistics,
            scopes: None,
            site: Site::default(),
            caught: Caught::default(),
            is_lost: false,
        }
    }

    /// Attributes all objects created from here on to a pass.
    pub(crate) fn begin_pass(&mut self, pass: &Pass) {
        self.begin(Site(Some((pass.place.into(), pass.pointer.clone(), pass.name.clone()))));
    }

    /// Attributes the objects that `create` creates to a resource.
    pub(crate) fn of_resource<T>(
        &mut self,
        resource: Option<&Resource>,
        create: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let Some(resource) = resource else { return create(self) };
        let site = (resource.place.into(), resource.pointer.clone(), resource.name.clone());
        let before = self.site.clone();
        self.begin(Site(Some(site)));
        let created = create(self);
        self.begin(before);
        created
    }

    fn begin(&mut self, site: Site) {
        self.close();
        self.site = site;
    }

    /// Returns an error if a texture of the host belongs to another device.
    pub(crate) fn import_error(
        &mut self,
        queue: &wgpu::Queue,
        name: &str,
        texture: &wgpu::Texture,
    ) -> Option<Diagnostic> {
        let scope = self.device().push_error_scope(wgpu::ErrorFilter::Validation);
        // Of no texels nothing is written; whose the texture is, is asked before all else.
        let nothing = wgpu::Extent3d { width: 0, height: 0, depth_or_array_layers: 0 };
        queue.write_texture(
            texture.as_image_copy(),
            &[],
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: None, rows_per_image: None },
            nothing,
        );
        let Poll::Ready(Some(error)) =
            Box::pin(scope.pop()).as_mut().poll(&mut Context::from_waker(Waker::noop()))
        else {
            return None;
        };
        if !causes(&error).contains("doesn't match") {
            return None;
        }
        let message = format!("the texture for \"{name}\" is of another device");
        let diagnostic = Diagnostic::error(codes::IMPORT, Place::Nowhere, message);
        Some(diagnostic.help("give the executor textures of the device that it was made with"))
    }

    /// Closes the error scopes, and returns the errors that they caught.
    pub(crate) fn finish(mut self) -> Caught {
        self.close();
        self.caught
    }

    fn close(&mut self) {
        let Some(scopes) = self.scopes.take() else { return };
        if self.is_lost {
            return;
        }
        let lost = lost(self.device);
        let Scopes { validation, internal, memory } = scopes;
        let outcomes: [Pin<Box<dyn Outcome>>; 3] =
            [Box::pin(validation.pop()), Box::pin(internal.pop()), Box::pin(memory.pop())];
        for outcome in outcomes {
            self.caught.add(self.site.clone(), outcome);
        }
        if let Some(lost) = lost {
            self.is_lost = true;
            self.caught.known.push(self.site.lost(lost));
        }
    }

    fn device(&mut self) -> &'a wgpu::Device {
        let device = self.device;
        self.scopes.get_or_insert_with(|| {
            let memory = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
            let internal = device.push_error_scope(wgpu::ErrorFilter::Internal);
            let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
            Scopes { validation, internal, memory }
        });
        device
    }

    pub(crate) fn texture(&mut self, descriptor: &wgpu::TextureDescriptor<'_>, bytes: u64) -> wgpu::Texture {
        self.statistics.textures += 1;
        self.statistics.bytes += bytes;
        self.device().create_texture(descriptor)
    }

    pub(crate) fn buffer(&mut self, descriptor: &wgpu::BufferDescriptor<'_>) -> wgpu::Buffer {
        self.statistics.buffers += 1;
        self.statistics.bytes += descriptor.size;
        self.device().create_buffer(descriptor)
    }

    pub(crate) fn view(
        &mut self,
        texture: &wgpu::Texture,
        descriptor: &wgpu::TextureViewDescriptor<'_>,
    ) -> wgpu::TextureView {
        self.statistics.views += 1;
        self.device();
        texture.create_view(descriptor)
    }

    pub(crate) fn import_view(
        &mut self,
        texture: &wgpu::Texture,
        descriptor: &wgpu::TextureViewDescriptor<'_>,
    ) -> wgpu::TextureView {
        self.statistics.import_views += 1;
        self.device();
        texture.create_view(descriptor)
    }

    pub(crate) fn shader_module(&mut self, label: &str, wgsl: &str) -> wgpu::ShaderModule {
        self.statistics.shader_modules += 1;
        self.device().create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(wgsl.into()),
        })
    }

    creates! {
        sampler: create_sampler(SamplerDescriptor) -> Sampler, samplers;
        bind_group_layout: create_bind_group_layout(BindGroupLayoutDescriptor) -> BindGroupLayout, layouts;
        pipeline_layout: create_pipeline_layout(PipelineLayoutDescriptor) -> PipelineLayout, layouts;
        render_pipeline: create_render_pipeline(RenderPipelineDescriptor) -> RenderPipeline, pipelines;
        compute_pipeline: create_compute_pipeline(ComputePipelineDescriptor) -> ComputePipeline, pipelines;
        bind_group: create_bind_group(BindGroupDescriptor) -> BindGroup, bind_groups;
    }
}

/// Returns an error if the device is lost.
pub(crate) fn lost(device: &wgpu::Device) -> Option<Diagnostic> {
    if cfg!(target_family = "wasm") {
        // A device that a browser has lost maps memory all the same.
        return None;
    }
    let probe = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("probe"),
        size: wgpu::COPY_BUFFER_ALIGNMENT,
        usage: wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: true,
    });
    let is_lost = probe.slice(..).get_mapped_range().is_err();
    is_lost.then(|| {
        Diagnostic::error(codes::DEVICE_LOST, Place::Nowhere, "the device is lost")
            .help("make a new device, and on it a new executor from the same plan")
    })
}

/// A future with the error that one error scope caught; `None` if it caught none.
trait Outcome: Future<Output = Option<wgpu::Error>> + wgpu::WasmNotSend {}

impl<T: Future<Output = Option<wgpu::Error>> + wgpu::WasmNotSend> Outcome for T {}

/// The errors that scopes have caught so far.
#[derive(Default)]
pub(crate) struct Caught {
    known: Diagnostics,
    /// The error scopes whose outcome the browser has not reported yet.
    #[cfg(target_arch = "wasm32")]
    late: Vec<(Site, Pin<Box<dyn Outcome>>)>,
}

impl Caught {
    /// Adds the error of a scope, if it caught one.
    fn add(&mut self, site: Site, mut outcome: Pin<Box<dyn Outcome>>) {
        match outcome.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(error) => self.known.extend(error.map(|error| diagnostic(&error, &site))),
            #[cfg(target_arch = "wasm32")]
            Poll::Pending => self.late.push((site, outcome)),
            #[cfg(not(target_arch = "wasm32"))]
            Poll::Pending => {}
        }
    }

    /// Takes the errors that are known by now; pending outcomes stay.
    pub(crate) fn known(&mut self) -> Diagnostics {
        #[cfg(target_arch = "wasm32")]
        for (site, outcome) in std::mem::take(&mut self.late) {
            self.add(site, outcome);
        }
        std::mem::take(&mut self.known)
    }

    /// Adds the errors that another creation caught.
    pub(crate) fn append(&mut self, other: Self) {
        self.known.extend(other.known);
        #[cfg(target_arch = "wasm32")]
        self.late.extend(other.late);
    }
}

fn diagnostic(error: &wgpu::Error, Site(site): &Site) -> Diagnostic {
    let help = match error {
        wgpu::Error::OutOfMemory { .. } => "make pictures and maps smaller, or free memory of the device",
        wgpu::Error::Validation { .. } => {
            "compare what the device offers with what the pipeline's profile promises"
        }
        wgpu::Error::Internal { .. } => "update the driver, or use another backend",
    };
    let place = site.as_ref().map_or(Place::Nowhere, |(place, ..)| place.clone());
    let message = match (error, site) {
        (wgpu::Error::OutOfMemory { .. }, Some((.., name))) => {
            format!("the device has not enough memory for \"{name}\"")
        }
        (wgpu::Error::OutOfMemory { .. }, None) => "the device has not enough memory".to_owned(),
        (_, Some((.., name))) => format!("the device rejected what \"{name}\" needs: {}", causes(error)),
        (_, None) => format!("the device rejected: {}", causes(error)),
    };
    let diagnostic = Diagnostic::error(codes::DEVICE, place, message);
    let diagnostic = match site {
        Some((_, pointer, _)) => diagnostic.pointer(pointer),
        None => diagnostic,
    };
    diagnostic.help(help)
}

/// An error's causes in one line, the first cause last.
pub(crate) fn causes(error: &wgpu::Error) -> String {
    let mut texts: Vec<String> = Vec::new();
    // A browser's error is one text.
    let mut cause = error.source().filter(|_| cfg!(not(target_family = "wasm")));
    while let Some(error) = cause {
        let text = error.to_string();
        if !texts.iter().any(|known| known.contains(&text)) {
            texts.push(text);
        }
        cause = error.source();
    }
    if texts.is_empty() { error.to_string() } else { texts.join(": ") }
}

/// Returns all diagnostics as `Err` if one of them is an error; otherwise drops them.
pub(crate) fn reject(diagnostics: Diagnostics) -> Result<(), Diagnostics> {
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok(()) }
}
