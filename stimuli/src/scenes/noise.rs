//! Noise. White: one independent grey value for each pixel of the display, uniform around half the peak. It is the scene
//! on which a filter's amplitude spectrum can be measured, and a real stimulus in its own right. Coloured: amplitudes that
//! fall with spatial frequency, as in natural pictures; see [`super::coloured`].

use super::ViewUniform;
use super::coloured::{self, TILE_PX};
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
        about:
            "Noise of mean half the peak in linear light: white, one independent grey value for each display pixel, or \
                with amplitudes that fall with spatial frequency."
                .to_owned(),
        parameters: vec![
            ParameterSchema::number("seed", "", 0.0..=4_294_967_295.0, 1.0, "Which noise; whole numbers."),
            ParameterSchema::number(
                "contrast",
                "",
                0.0..=1.0,
                1.0,
                "Width of the uniform distribution of values, as a share of the display's peak; 0 is a flat grey. Noise that \
                is not white is normally distributed, with a sixth of this as its standard deviation.",
            ),
            ParameterSchema::number(
                "spectrum_exponent",
                "",
                0.0..=2.0,
                0.0,
                "Exponent β of the amplitude spectrum 1/f^β: 0 is white noise, about 1 that of natural pictures. Above 0 \
                the noise repeats after 1024 pixels.",
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
    /// Noise that is not white.
    tile: Option<wgpu::TextureView>,
}

pub(crate) fn make(gpu: &Gpu, _: &Display, parameters: &Parameters) -> Result<Box<dyn Scene>, MakeError> {
    let seed = number(parameters, "seed")?.round() as u32;
    let contrast = number(parameters, "contrast")?;
    let exponent = number(parameters, "spectrum_exponent")?;
    let tile = (exponent > 0.0).then(|| {
        let greys: Vec<[f32; 4]> =
            coloured::tile(seed, exponent, contrast).iter().map(|&grey| [grey, grey, grey, 1.0]).collect();
        pass::view(&pass::half_texture(gpu, "coloured noise", [TILE_PX as u32; 2], &greys))
    });
    let entry = if tile.is_some() { "coloured" } else { "noise" };
    Ok(Box::new(Noise {
        identity: SceneIdentity::new(),
        pipeline: pass::pipeline(gpu, "noise", WGSL, entry, crate::LINEAR_FORMAT),
        seed,
        contrast: contrast as f32,
        tile,
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
        let bind_group = pass::bind(gpu, &self.pipeline, &pass::uniform(gpu, &uniform), self.tile.as_ref().as_slice());
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
