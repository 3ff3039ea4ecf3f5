//! Textures and buffers that a pass names.

use crate::access::{SubresourceRange, Version};
use crate::pipeline::builder::PassBuilder;
use crate::pipeline::resource::{Resource, ResourceKind};
use crate::pipeline::resources::history;
use crate::pipeline::settings::evaluate::Evaluate;
use crate::work::{ResourceHandle, Subresource, TextureRegion};
use umbragraph_text::diagnostic::{Diagnostic, codes, list_of};
use umbragraph_text::language::{Expr, Ref, Reference, parse_format};

impl PassBuilder<'_> {
    /// Resolves a reference to a subresource range of a texture; returns `None` after a diagnostic.
    pub fn texture(
        &mut self,
        reference: &Ref,
        range: SubresourceRange,
        pointer: &str,
    ) -> Option<Subresource> {
        let (handle, version) = self.reference(reference, pointer)?;
        if self.shared.resources[handle.index()].texture().is_none() {
            return self.wrong_kind(handle, "texture", pointer);
        }
        Some(self.subresource(handle, range, version, pointer))
    }

    /// Resolves a reference to a texture of which only the size is used; returns `None` after a diagnostic.
    pub fn declared_texture(&mut self, reference: &Ref, pointer: &str) -> Option<ResourceHandle> {
        let whole = SubresourceRange::WHOLE;
        self.texture(reference, whole, pointer).map(|texture| texture.resource)
    }

    /// Returns `true` if a reference names a buffer.
    pub fn is_buffer(&self, reference: &Ref) -> bool {
        self.named(reference).is_some_and(|resource| matches!(resource.kind, ResourceKind::Buffer(_)))
    }

    /// Returns `true` if a reference names a texture.
    pub fn is_texture(&self, reference: &Ref) -> bool {
        self.named(reference).is_some_and(|resource| resource.texture().is_some())
    }

    /// The declared size in bytes of a buffer; `None` unless the declaration has a literal number.
    pub fn declared_bytes(&self, reference: &Ref) -> Option<u64> {
        match &self.named(reference)?.kind {
            ResourceKind::Buffer(buffer) => buffer.size.0.as_u64(),
            _ => None,
        }
    }

    /// The number of bytes that the texels of a region take in a buffer. `None` unless the declared sizes are literal
    /// numbers and rows need no padding.
    pub fn bytes_of_full_rows(&self, region: &TextureRegion) -> Option<u64> {
        let (range, mip_levels) = (region.texture.range, region.mip());
        let texture = self.shared.resources[region.texture.resource.index()].texture()?;
        let mut names = texture.format.names().iter();
        let format = names.next().filter(|_| names.next().is_none()).and_then(|name| parse_format(name))?;
        let block = u64::from(format.block_copy_size(Some(range.aspect.into()))?);
        let (block_width, block_height) = format.block_dimensions();
        let number = |value: Option<&serde_json::Value>| value?.as_u64();
        let [width, height] = [0, 1].map(|axis| number(texture.size.0.get(axis)));
        let layers = match (range.layer, &texture.layers) {
            (Some(run), _) => u64::from(run.count),
            (None, None) => 1,
            (None, Some(layers)) => layers.0.as_u64()?,
        };
        let volume = texture.view_dimension == Some(umbragraph_text::language::TextureShape::D3);
        if region.origin.is_some() || volume || texture.samples.is_some() {
            return None;
        }
        let mut all = 0u64;
        for mip in mip_levels.first..mip_levels.end().try_into().ok()? {
            let side = |length: u64| length.checked_shr(mip).unwrap_or(0).max(1);
            let row = side(width?).div_ceil(block_width.into()).checked_mul(block)?;
            if !row.is_multiple_of(wgpu_types::COPY_BYTES_PER_ROW_ALIGNMENT.into()) {
                return None;
            }
            let lines = side(height?).div_ceil(block_height.into());
            all = all.checked_add(row.checked_mul(lines)?.checked_mul(layers)?)?;
        }
        Some(all)
    }

    /// The resource that a reference names; `None` if there is none.
    fn named(&self, reference: &Ref) -> Option<&Resource> {
        let outside = self.environment.refer(&reference.0, &self.shared.scope).ok()?;
        let handle = self.shared.find(&outside.resource)?;
        Some(&self.shared.resources[handle.index()])
    }

    /// Resolves a reference to names outside of the subgraph; returns `None` after a diagnostic.
    pub(super) fn outside(&mut self, reference: &Ref, pointer: &str) -> Option<Reference> {
        if let Ok(expression) = Expr::parse_text(&reference.0) {
            self.fix(&expression, pointer);
        }
        let found = self.environment.refer(&reference.0, &self.shared.scope);
        found.map_err(|error| self.expression_error(&error, pointer)).ok()
    }

    /// Resolves a reference to all bytes of a buffer; returns `None` after a diagnostic.
    pub fn buffer(&mut self, reference: &Ref, pointer: &str) -> Option<Subresource> {
        self.buffer_named(reference, SubresourceRange::WHOLE, pointer)
    }

    pub(super) fn buffer_named(
        &mut self,
        reference: &Ref,
        range: SubresourceRange,
        pointer: &str,
    ) -> Option<Subresource> {
        let (handle, version) = self.reference(reference, pointer)?;
        if !matches!(self.shared.resources[handle.index()].kind, ResourceKind::Buffer(_)) {
            return self.wrong_kind(handle, "buffer", pointer);
        }
        Some(self.subresource(handle, range, version, pointer))
    }

    fn wrong_kind<T>(&mut self, handle: ResourceHandle, wanted: &str, pointer: &str) -> Option<T> {
        let resource = &self.shared.resources[handle.index()];
        let (name, kind) = (&resource.name, resource.kind_name());
        let message = format!("\"{name}\" is {kind}, but a {wanted} is wanted here");
        let help = format!("name a {wanted} of \"resources\"");
        self.reject(codes::WRONG_RESOURCE, pointer, message, help)
    }

    pub(super) fn reference(&mut self, reference: &Ref, pointer: &str) -> Option<(ResourceHandle, Version)> {
        let environment = self.environment;
        let outside = self.outside(reference, pointer)?;
        let found = self.shared.find(&outside.resource);
        if found
            .is_some_and(|handle| matches!(self.shared.resources[handle.index()].kind, ResourceKind::Broken))
        {
            return None;
        }
        let Some(handle) = found else {
            let name = environment.resource_inside(&outside.resource).unwrap_or(&outside.resource);
            if self.report_argument_error(name) {
                return None;
            }
            let resources = self.shared.resources.iter();
            let inside =
                |resource: &Resource| self.environment.resource_inside(&resource.name).map(str::to_owned);
            let names: Vec<String> = resources.filter_map(inside).collect();
            // What has the name outside is not seen here; no name inside is meant.
            let is_outside = self.shared.find(name).is_some();
            let names = names.iter().map(String::as_str).filter(|_| !is_outside);
            let names: Vec<&str> = names.collect();
            let inside_of: Vec<String> = self
                .shared
                .resources
                .iter()
                .filter(|one| one.name.rsplit_once('.').is_some_and(|(_, last)| last == name))
                .map(|one| format!("\"&{}\"", one.name))
                .collect();
            let message = match is_outside {
                true => format!("a subgraph does not see the resource \"{name}\" of the pipeline"),
                false => format!("there is no resource \"{name}\""),
            };
            self.report_unknown(
                codes::UNKNOWN_RESOURCE,
                pointer,
                message,
                name,
                &names,
                || match is_outside {
                    true => format!("declare \"{name}\" under its \"inputs\", and pass it through \"with\""),
                    false if !inside_of.is_empty() && environment.is_top() => {
                        format!("subgraphs have a resource of this name: write {}", list_of(&inside_of))
                    }
                    false => "declare it under \"resources\"".to_owned(),
                },
            );
            return None;
        };
        let back = outside.back;
        if back > 0 {
            if let Some(earlier) = history::earlier(self.shared, handle, back) {
                return Some((earlier, Version::Newest));
            }
            let (message, help) = history::beyond(self.shared, handle, back);
            let place = self.shared.resources[handle.index()].place;
            let diagnostic = Diagnostic::error(codes::HISTORY_READ, self.place(pointer), message)
                .related(place, "declared here")
                .help(help)
                .pointer(self.absolute(pointer));
            self.shared.diagnostics.push(diagnostic);
            return None;
        }
        Some((handle, outside.version.into()))
    }

    pub(super) fn subresource(
        &self,
        resource: ResourceHandle,
        range: SubresourceRange,
        version: Version,
        pointer: &str,
    ) -> Subresource {
        Subresource { resource, range, version, place: self.place(pointer), pointer: self.absolute(pointer) }
    }
}
