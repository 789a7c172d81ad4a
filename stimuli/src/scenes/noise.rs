//! White noise: one independent grey value for each pixel of the display, uniform around half the peak. It is the scene
//! on which a filter's amplitude spectrum can be measured, and a real stimulus in its own right.

use super::ViewUniform;
use crate::contract::{DrawCost, DrawRequest, MakeError, RenderError, Scene, SceneIdentity};
use crate::gpu::Gpu;
use crate::parameters::number;
use crate::pass::{self, Extent};
use experiments::catalogue::{ParameterSchema, Parameters, SceneInfo};
use experiments::display::Display;

pub(crate) const WGSL: &str = include_str!("noise.wgsl");

pub(crate) fn info() -> SceneInfo {
    SceneInfo {
        id: "noise".to_owned(),
        version: 1,
        about: "White noise: one independent grey value for each display pixel, mean half the peak in linear light."
            .to_owned(),
        parameters: vec![
            ParameterSchema::number("seed", "", 0.0..=4_294_967_295.0, 1.0, "Which noise; whole numbers."),
            ParameterSchema::number(
                "contrast",
                "",
                0.0..=1.0,
                1.0,
                "Width of the uniform distribution of values, as a share of the display's peak; 0 is a flat grey.",
            ),
        ],
        animated: false,
    }
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    view: ViewUniform,
    seed: u32,
    contrast: f32,
    reserved: [f32; 2],
}

struct Noise {
    identity: SceneIdentity,
    pipeline: wgpu::RenderPipeline,
    seed: u32,
    contrast: f32,
}

pub(crate) fn make(gpu: &Gpu, _: &Display, parameters: &Parameters) -> Result<Box<dyn Scene>, MakeError> {
    Ok(Box::new(Noise {
        identity: SceneIdentity::new(),
        pipeline: pass::pipeline(gpu, "noise", WGSL, "noise", crate::LINEAR_FORMAT),
        seed: number(parameters, "seed")?.round() as u32,
        contrast: number(parameters, "contrast")? as f32,
    }))
}

impl Scene for Noise {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        let view = &request.view;
        let uniform =
            Uniform { view: ViewUniform::new(view), seed: self.seed, contrast: self.contrast, reserved: [0.0; 2] };
        let bind_group = pass::bind(gpu, &self.pipeline, &pass::uniform(gpu, &uniform), &[]);
        pass::draw(encoder, &self.pipeline, &bind_group, target, Extent::Corner(view.target_px));
        Ok(super::flat_picture_drawn(gpu, encoder, request))
    }

    fn picture_changes(&self, _: f64, _: f64) -> bool {
        false
    }

    fn identity(&self) -> SceneIdentity {
        self.identity
    }
}
