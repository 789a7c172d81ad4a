//! The scene at the display's full resolution: what every foveated picture is compared with. A picture that does not
//! change is drawn once.

use crate::contract::{
    DrawCost, DrawRequest, FrameCost, FrameInput, MakeError, RenderError, Renderer, Scene, SceneIdentity, View,
};
use crate::gpu::Gpu;
use crate::pass;
use crate::timing::GpuTimer;
use experiments::catalogue::{DetailLaw, ParameterError, Parameters, RendererInfo, complete_parameters};
use experiments::display::Display;

pub(crate) fn info() -> RendererInfo {
    RendererInfo {
        id: "reference".to_owned(),
        version: 1,
        about: "The scene at the display's full resolution everywhere.".to_owned(),
        source: String::new(),
        parameters: Vec::new(),
        detail: DetailLaw::Full,
    }
}

/// The full-resolution picture of the last scene, drawn again only when it has changed.
pub(crate) struct ReferencePicture {
    pub(crate) texture: wgpu::Texture,
    pub(crate) view: wgpu::TextureView,
    drawn: Option<(SceneIdentity, f64)>,
}

impl ReferencePicture {
    pub(crate) fn new(gpu: &Gpu, display: &Display) -> Self {
        let texture = pass::linear_texture(gpu, "reference", display.resolution_px());
        Self { view: pass::view(&texture), texture, drawn: None }
    }

    /// Whether the picture held is not the one of `scene` at `animation_s`.
    pub(crate) fn is_stale(&self, scene: &dyn Scene, animation_s: f64) -> bool {
        self.drawn.is_none_or(|(identity, drawn_s)| {
            identity != scene.identity() || scene.picture_changes(drawn_s, animation_s)
        })
    }

    /// Records the drawing of the picture, if it is stale.
    pub(crate) fn update(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        scene: &mut dyn Scene,
        animation_s: f64,
    ) -> Result<DrawCost, RenderError> {
        if !self.is_stale(scene, animation_s) {
            return Ok(DrawCost::default());
        }
        self.drawn = None;
        let view = View::full([self.texture.width(), self.texture.height()]);
        let cost = scene.draw(gpu, encoder, &DrawRequest::of(view, animation_s), &self.view)?;
        self.drawn = Some((scene.identity(), animation_s));
        Ok(cost)
    }
}

struct Reference {
    picture: ReferencePicture,
    timer: GpuTimer,
}

pub(crate) fn make(gpu: &Gpu, display: &Display, _: &Parameters) -> Result<Box<dyn Renderer>, MakeError> {
    Ok(Box::new(Reference { picture: ReferencePicture::new(gpu, display), timer: GpuTimer::new(gpu) }))
}

impl Renderer for Reference {
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError> {
        frame.check()?;
        if !self.picture.is_stale(scene, frame.animation_s) {
            return Ok(FrameCost { gpu_time_s: self.timer.last_s(), ..FrameCost::default() });
        }
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.timer.begin(gpu, &mut encoder);
        let drawn = self.picture.update(gpu, &mut encoder, scene, frame.animation_s)?;
        let gpu_time_s = self.timer.submit(gpu, encoder);
        gpu.check()?;
        Ok(drawn.in_frame(gpu_time_s))
    }

    fn output(&self) -> &wgpu::Texture {
        &self.picture.texture
    }

    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Vec<ParameterError>> {
        complete_parameters(&info().parameters, parameters).map(|_| ())
    }
}
