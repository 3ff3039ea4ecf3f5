//! The host's textures of a plan: the picture, which the window shows, and others, which [`crate::given`] fills.
//!
//! The window shows the picture that the command would write, and rejects the same plans. A picture that is not one of
//! a screen is converted ([`crate::screen`]). A texture that the device cannot make is left out, so that the frame is
//! not recorded.

use eframe::egui;
use eframe::egui_wgpu::RenderState;
use umbragraph::diagnostic::Diagnostic;
use umbragraph::executor::imported_texture;
use umbragraph::low_level::compiler::PlannedResource;
use umbragraph::low_level::picture::{colors_of, is_of_screen, tone_mapping};
use umbragraph::{Plan, wgpu};

use crate::guard::guarded;
use crate::screen::Conversion;

/// The usages of host textures in addition to those of the plan.
pub(crate) const MORE: wgpu::TextureUsages = wgpu::TextureUsages::COPY_SRC
    .union(wgpu::TextureUsages::COPY_DST)
    .union(wgpu::TextureUsages::TEXTURE_BINDING);

/// The note of the viewer that the picture of a plan is tone mapped; `None` if it is not.
pub(crate) fn note(plan: &Plan) -> Option<Diagnostic> {
    let name = colors_of(plan, &[]).ok()?;
    tone_mapping(name, plan.resources.get(name)?.format?)
}

/// The picture of the screen, and its registration in egui.
struct Picture {
    texture: wgpu::Texture,
    id: egui::TextureId,
}

/// The host's textures for the imports of a plan, by resource name.
#[derive(Default)]
pub(crate) struct Targets {
    list: Vec<(String, wgpu::Texture)>,
    /// The conversion of the host's picture to that of the screen; `None` if they are one texture.
    conversion: Option<Conversion>,
    picture: Option<Picture>,
}

impl Targets {
    /// The names and textures in the form that `Frame::imports` takes.
    pub(crate) fn imports(&self) -> Vec<(&str, &wgpu::Texture)> {
        self.list.iter().map(|(name, texture)| (name.as_str(), texture)).collect()
    }

    /// Removes all textures, for a plan with other imports. The old picture is shown until there is a new one.
    pub(crate) fn clear(&mut self) {
        self.list.clear();
    }

    /// The egui texture of the picture and its size in texels; `None` before the first picture.
    pub(crate) fn shown(&self) -> Option<(egui::TextureId, [u32; 2])> {
        self.picture.as_ref().map(|one| (one.id, [one.texture.width(), one.texture.height()]))
    }

    /// Records the conversion of the picture, if it needs one.
    pub(crate) fn convert(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(conversion) = &self.conversion {
            conversion.record(encoder);
        }
    }

    /// The texture of the picture on the screen; `None` before the first picture.
    pub(crate) fn picture(&self) -> Option<&wgpu::Texture> {
        self.picture.as_ref().map(|one| &one.texture)
    }

    /// Creates the host's textures for the imports of a plan, the picture with `size` in texels.
    ///
    /// # Errors
    /// The plan has no picture, or the device cannot create a texture; the other textures are created.
    pub(crate) fn fit(&mut self, state: &RenderState, plan: &Plan, size: [u32; 2]) -> Result<(), Diagnostic> {
        let picture = colors_of(plan, &[]);
        let mut outcome = picture.as_ref().map(|_| ()).map_err(Clone::clone);
        for (name, resource) in plan.imports() {
            let is_picture = picture.as_ref() == Ok(&name);
            let known = self.list.iter().position(|(known, _)| known == name);
            let fits = known.is_some_and(|at| {
                let texture = &self.list[at].1;
                let wanted =
                    if is_picture { Some(size) } else { resource.size.map(|one| [one.width, one.height]) };
                let usages = resource.usages.unwrap_or(wgpu::TextureUsages::empty()) | MORE;
                wanted.is_none_or(|wanted| [texture.width(), texture.height()] == wanted)
                    && Some(texture.format()) == resource.format
                    && texture.usage().contains(usages)
                    && resource.size.is_none_or(|size| {
                        let own = [
                            texture.depth_or_array_layers(),
                            texture.mip_level_count(),
                            texture.sample_count(),
                        ];
                        own == [size.layers, size.mips, size.samples]
                    })
            });
            if fits {
                continue;
            }
            let what = format!("the texture \"{name}\"");
            let made = guarded(&state.device, &what, || {
                let texture = imported_texture(&state.device, plan, name, MORE)?;
                Some(if is_picture { sized(state, &texture, resource, size) } else { texture })
            });
            let texture = match made {
                Ok(Some(texture)) => texture,
                Ok(None) => continue,
                Err(reason) => {
                    outcome = outcome.and(Err(reason));
                    continue;
                }
            };
            if is_picture {
                outcome = outcome.and(self.show(state, &texture));
            }
            match known {
                Some(at) => self.list[at].1 = texture,
                None => self.list.push((name.to_owned(), texture)),
            }
        }
        outcome
    }

    /// Registers the picture in egui. Its texels are shown as display colours without sRGB conversion, whatever the
    /// format is.
    fn show(&mut self, state: &RenderState, texture: &wgpu::Texture) -> Result<(), Diagnostic> {
        let mut renderer = state.renderer.write();
        let known = self.picture.take().map(|picture| picture.id);
        let shown = guarded(&state.device, "the picture in the window", || {
            let (conversion, texture) = match is_of_screen(texture.format()) {
                true => (None, texture.clone()),
                false => {
                    let (conversion, texture) = Conversion::of(&state.device, texture);
                    (Some(conversion), texture)
                }
            };
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                format: Some(texture.format().remove_srgb_suffix()),
                usage: Some(wgpu::TextureUsages::TEXTURE_BINDING),
                ..Default::default()
            });
            let filter = wgpu::FilterMode::Linear;
            let id = match known {
                Some(id) => {
                    renderer.update_egui_texture_from_wgpu_texture(&state.device, &view, filter, id);
                    id
                }
                None => renderer.register_native_texture(&state.device, &view, filter),
            };
            (conversion, Picture { texture, id })
        });
        match shown {
            Ok((conversion, picture)) => (self.conversion, self.picture) = (conversion, Some(picture)),
            // It must not be painted; it is registered anew with the next one.
            Err(reason) => {
                if let Some(id) = known {
                    renderer.free_texture(&id);
                }
                return Err(reason);
            }
        }
        Ok(())
    }
}

/// Creates a texture for the picture with the format and usages of `like`, but with the size of the window's frame.
fn sized(
    state: &RenderState,
    like: &wgpu::Texture,
    resource: &PlannedResource,
    [width, height]: [u32; 2],
) -> wgpu::Texture {
    let mut view_formats = vec![like.format().remove_srgb_suffix()];
    view_formats.extend(resource.view_format.as_slice());
    state.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: like.format(),
        usage: like.usage(),
        view_formats: &view_formats,
    })
}
