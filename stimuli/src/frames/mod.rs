//! Frames that another engine rendered: a scene (the reference frames in time) and a renderer (quality levels blended
//! around the gaze) from one folder, so that a Unity, Unreal or CUDA renderer can be tested with our protocols.
//!
//! The manifest's format is [`experiments::study::frames`]'s; [`store`] checks and decodes the files, [`renderer`] blends.
//! Frames are never scaled: one that is smaller than the display stands in its middle, black around it, and one that is
//! larger is refused.

mod renderer;
mod store;

#[cfg(test)]
pub(crate) use renderer::WGSL;
pub(crate) use renderer::{info as renderer_info, make as make_renderer};
pub(crate) use store::FrameStore;

use crate::contract::{DrawCost, DrawRequest, MakeError, RenderError, Scene, SceneIdentity};
use crate::gpu::Gpu;
use crate::pass;
use crate::scenes::centred::Centred;
use experiments::catalogue::SceneInfo;
use experiments::display::Display;
use experiments::study::frames::Frames;
use std::sync::Arc;

/// What studies see of the scene.
pub(crate) fn scene_info(name: &str, frames: &Frames) -> SceneInfo {
    let about = if frames.about.is_empty() { "Frames that another engine rendered." } else { &frames.about };
    SceneInfo {
        id: name.to_owned(),
        version: 1,
        about: about.to_owned(),
        parameters: Vec::new(),
        animated: frames.count > 1,
    }
}

/// Refuses frames that do not fit the display.
fn check_size(frames: &Frames, display: &Display, store: &FrameStore) -> Result<(), MakeError> {
    let ([width, height], [across, down]) = (frames.size_px, display.resolution_px());
    if width > across || height > down {
        return Err(MakeError::File {
            file: store.name(),
            reason: format!(
                "expected frames of at most {across}×{down} pixels, the display's own, since they are never scaled, \
                 found {width}×{height}"
            ),
        });
    }
    Ok(())
}

/// The reference frames as a scene.
pub(crate) fn make_scene(gpu: &Gpu, display: &Display, store: &Arc<FrameStore>) -> Result<Box<dyn Scene>, MakeError> {
    check_size(store.frames(), display, store)?;
    let size = store.frames().size_px;
    let texture = pass::linear_texture(gpu, "frame", size);
    Ok(Box::new(ReferenceFrames {
        identity: SceneIdentity::new(),
        centred: Centred::new(gpu, display.resolution_px(), size),
        view: pass::view(&texture),
        texture,
        held: None,
        store: Arc::clone(store),
    }))
}

struct ReferenceFrames {
    identity: SceneIdentity,
    store: Arc<FrameStore>,
    centred: Centred,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    /// The frame in the texture.
    held: Option<u32>,
}

impl Scene for ReferenceFrames {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        let frame = self.store.frames().at(request.animation_s);
        if self.held != Some(frame) {
            self.held = None;
            store::upload(gpu, &self.texture, 0, &*self.store.picture(0, frame)?);
            self.store.look_ahead(&[0], frame);
            self.held = Some(frame);
        }
        Ok(self.centred.draw(gpu, encoder, request, &self.view, target))
    }

    fn picture_changes(&self, from_s: f64, to_s: f64) -> bool {
        let frames = self.store.frames();
        frames.at(from_s) != frames.at(to_s)
    }

    fn identity(&self) -> SceneIdentity {
        self.identity
    }
}
