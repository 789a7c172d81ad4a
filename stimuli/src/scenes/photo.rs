//! A photograph that covers the whole display in mirrored tiles, so that no tile has a visible border (as Tursun et al.
//! 2019, §5.1, extended their patches). Unscaled, every display pixel is exactly one pixel of the photograph.

use super::ViewUniform;
use crate::contract::{DrawCost, DrawRequest, MakeError, RenderError, Scene, SceneIdentity};
use crate::display_pass::linear_from_srgb8;
use crate::gpu::Gpu;
use crate::parameters::{number, text};
use crate::pass::{self, Extent};
use experiments::catalogue::{ParameterSchema, Parameters, SceneInfo};
use experiments::display::Display;

pub(crate) const WGSL: &str = include_str!("photo.wgsl");

/// Names of the shipped photographs.
pub(super) fn names() -> [&'static str; 4] {
    PHOTOGRAPHS.map(|(name, _)| name)
}

/// The shipped photographs, sRGB; their licences are in `assets/LICENSES.md`.
const PHOTOGRAPHS: [(&str, &[u8]); 4] = [
    ("gravel", include_bytes!("../../assets/photographs/gravel.png")),
    ("chelsea", include_bytes!("../../assets/photographs/chelsea.png")),
    ("coffee", include_bytes!("../../assets/photographs/coffee.png")),
    ("grass", include_bytes!("../../assets/photographs/grass.png")),
];

pub(crate) fn info() -> SceneInfo {
    SceneInfo {
        id: "photo".to_owned(),
        version: 1,
        about: "A photograph in mirrored tiles over the whole display.".to_owned(),
        parameters: vec![
            ParameterSchema::choice(
                "image",
                &names(),
                "Which photograph: gravel and grass have fine detail everywhere, chelsea and coffee are in colour.",
            ),
            ParameterSchema::number(
                "scale",
                "px/px",
                0.25..=16.0,
                1.0,
                "Display pixels per pixel of the photograph; at 1 nothing is interpolated.",
            ),
        ],
        animated: false,
    }
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    view: ViewUniform,
    tile_px: [f32; 2],
    scale: f32,
    reserved: f32,
}

struct Photo {
    identity: SceneIdentity,
    pipeline: wgpu::RenderPipeline,
    /// For targets of the display's own pixels.
    sampled: wgpu::RenderPipeline,
    photograph: wgpu::TextureView,
    tile_px: [f32; 2],
    scale: f32,
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Scene>, MakeError> {
    let photograph = Photograph::decode(text(parameters, "image")?)?;
    Ok(photograph.in_tiles(gpu, display, number(parameters, "scale")?))
}

/// A picture in linear light, RGBA from the top left row by row.
pub(super) struct Photograph {
    pub(super) name: &'static str,
    pub(super) size: [u32; 2],
    pub(super) linear: Vec<[f32; 4]>,
}

impl Photograph {
    /// The shipped photograph called `image`.
    pub(super) fn decode(image: &str) -> Result<Self, MakeError> {
        let (name, bytes) = PHOTOGRAPHS.into_iter().find(|(name, _)| *name == image).unwrap_or(PHOTOGRAPHS[0]);
        let decoded = image::load_from_memory_with_format(bytes, image::ImageFormat::Png)
            .map_err(|error| MakeError::Asset { name, reason: error.to_string() })?
            .into_rgb8();
        let linear: Vec<[f32; 4]> = decoded
            .pixels()
            .map(|p| [linear_from_srgb8(p[0]), linear_from_srgb8(p[1]), linear_from_srgb8(p[2]), 1.0])
            .collect();
        Ok(Self { name, size: [decoded.width(), decoded.height()], linear })
    }

    /// The scene that covers the display with it: the unmirrored tile in the middle, `scale` display pixels to a pixel.
    pub(super) fn in_tiles(&self, gpu: &Gpu, display: &Display, scale: f64) -> Box<dyn Scene> {
        let size = self.size;
        let unscaled = [("UNSCALED", f64::from(u8::from(scale == 1.0)))];
        let pipeline = |entry| pass::pipeline_with(gpu, entry, WGSL, entry, crate::LINEAR_FORMAT, &unscaled);
        Box::new(Photo {
            identity: SceneIdentity::new(),
            pipeline: pipeline("photo"),
            sampled: pipeline("photo_sampled"),
            photograph: pass::view(&pass::half_texture(gpu, self.name, size, &self.linear)),
            tile_px: std::array::from_fn(|axis| first_tile_px(display.resolution_px()[axis], size[axis], scale) as f32),
            scale: scale as f32,
        })
    }
}

/// Where the middle, unmirrored tile begins: centred on the display, at a whole pixel so that texels stay exact.
fn first_tile_px(display_px: u32, photograph_px: u32, scale: f64) -> f64 {
    (0.5 * (f64::from(display_px) - scale * f64::from(photograph_px))).floor()
}

impl Scene for Photo {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        let view = &request.view;
        let uniform = Uniform { view: ViewUniform::new(view), tile_px: self.tile_px, scale: self.scale, reserved: 0.0 };
        // With larger photograph pixels, too, one sample is enough; with smaller ones each pixel holds several.
        let at_pixels = view.step_px() == [1.0; 2] && self.scale >= 1.0;
        let pipeline = if at_pixels { &self.sampled } else { &self.pipeline };
        let bind_group = pass::bind(gpu, pipeline, &pass::uniform(gpu, &uniform), &[&self.photograph]);
        pass::draw(encoder, pipeline, &bind_group, target, Extent::Corner(view.target_px));
        Ok(super::flat_picture_drawn(gpu, encoder, request))
    }

    fn picture_changes(&self, _: f64, _: f64) -> bool {
        false
    }

    fn identity(&self) -> SceneIdentity {
        self.identity
    }
}
