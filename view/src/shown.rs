//! The scene that is drawn, its pose, and its resources on the device.

use eframe::egui_wgpu::RenderState;
use umbragraph::Error;
use umbragraph::diagnostic::Diagnostics;
use umbragraph::frame::FrameInput;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::scene::{Pose, Scene};

use crate::guard::guarded;
use crate::stage::Shot;

/// A loaded scene, its pose, and its resources on the device.
pub(crate) struct Shown {
    pub(crate) scene: Scene,
    pose: Pose,
    pub(crate) meshes: SceneResources,
}

impl Shown {
    /// Uploads a scene.
    ///
    /// # Errors
    /// A scene that the device does not take.
    pub(crate) fn new(state: &RenderState, scene: Scene) -> Result<Self, Error> {
        let pose = scene.pose(0.0);
        let made = guarded(&state.device, "the scene", || {
            SceneResources::new(&state.device, &state.queue, &scene, &pose)
        });
        let made = made.map_err(Diagnostics::from).and_then(|made| made);
        let meshes = made.map_err(|found| Error::new(found, &Default::default()))?;
        Ok(Self { scene, pose, meshes })
    }

    /// The camera, lights and bounds of the frame with an index; also moves the meshes to their pose at the frame's
    /// time.
    pub(crate) fn input(&mut self, state: &RenderState, shot: &Shot<'_>, index: u64) -> FrameInput {
        let Self { scene, pose, meshes } = self;
        scene.pose_into(shot.time, pose);
        meshes.update(&state.queue, scene, pose);
        let [width, height] = shot.size;
        let input = scene.frame_input_of(pose, f64::from(width) / f64::from(height), shot.time);
        let camera = shot.view.map_or(input.camera, |view| view.camera(input.camera));
        input.camera(camera).index(index)
    }
}
