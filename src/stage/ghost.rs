//! A renderer for tests that remembers: its picture moves on with every frame of a presentation, by more the further the
//! gaze is off the middle. A frame drawn too often, too rarely or in the wrong presentation is another picture.

use experiments::catalogue::{
    DetailLaw, ParameterError, ParameterSchema, Parameters, RendererInfo, complete_parameters,
};
use experiments::display::Display;
use std::sync::Arc;
use stimuli::{
    DrawRequest, FrameCost, FrameInput, Gpu, LINEAR_FORMAT, MakeError, Registry, RenderError, Renderer, Scene, View,
};

/// What is built in, and the renderer "ghost".
pub(crate) fn registry() -> Arc<Registry> {
    let mut registry = Registry::built_in();
    registry.add_renderer(info(), Arc::new(make)).expect("no other ghost");
    Arc::new(registry)
}

fn info() -> RendererInfo {
    RendererInfo {
        id: "ghost".to_owned(),
        version: 1,
        about: "A picture that moves on.".to_owned(),
        source: String::new(),
        parameters: vec![ParameterSchema::number("step_px", "px", 0.0..=10.0, 1.0, "How far it moves a frame.")],
        detail: DetailLaw::Unknown,
    }
}

struct Ghost {
    resolution_px: [u32; 2],
    output: wgpu::Texture,
    moved_px: f64,
}

fn make(gpu: &Gpu, display: &Display, _: &Parameters) -> Result<Box<dyn Renderer>, MakeError> {
    let [width, height] = display.resolution_px();
    let output = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("ghost"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: LINEAR_FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    Ok(Box::new(Ghost { resolution_px: [width, height], output, moved_px: 0.0 }))
}

impl Renderer for Ghost {
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError> {
        self.moved_px += 1.0 + frame.gaze_deg[0].abs().round();
        let view = View { origin_px: [self.moved_px, frame.frame_index as f64], ..View::full(self.resolution_px) };
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let target = self.output.create_view(&wgpu::TextureViewDescriptor::default());
        let drawn = scene.draw(gpu, &mut encoder, &DrawRequest::of(view, frame.animation_s), &target)?;
        gpu.queue.submit([encoder.finish()]);
        Ok(drawn.in_frame(None))
    }

    fn begin(&mut self) {
        self.moved_px = 0.0;
    }

    fn remembers(&self) -> bool {
        true
    }

    fn output(&self) -> &wgpu::Texture {
        &self.output
    }

    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Vec<ParameterError>> {
        complete_parameters(&info().parameters, parameters).map(|_| ())
    }
}
