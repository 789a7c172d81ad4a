//! A flat picture in the display's middle, unscaled, with black around it: what pictures and frames of the user's are drawn
//! with.

use super::ViewUniform;
use crate::contract::{DrawCost, DrawRequest, LINEAR_FORMAT};
use crate::gpu::Gpu;
use crate::pass::{self, Extent};

pub(crate) const WGSL: &str = include_str!("centred.wgsl");

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    view: ViewUniform,
    corner: [i32; 2],
    size: [i32; 2],
}

/// Draws pictures of one size on a display of one size.
pub(crate) struct Centred {
    pipeline: wgpu::RenderPipeline,
    corner: [i32; 2],
    size: [i32; 2],
}

/// Display pixel of the top left corner of a picture in the middle.
pub(crate) fn corner_px(display_px: [u32; 2], size: [u32; 2]) -> [i32; 2] {
    std::array::from_fn(|axis| (display_px[axis] as i32 - size[axis] as i32).div_euclid(2))
}

impl Centred {
    pub(crate) fn new(gpu: &Gpu, display_px: [u32; 2], size: [u32; 2]) -> Self {
        Self {
            pipeline: pass::pipeline(gpu, "centred", WGSL, "centred", LINEAR_FORMAT),
            corner: corner_px(display_px, size),
            size: size.map(|x| x as i32),
        }
    }

    /// Records the drawing of `picture`.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        picture: &wgpu::TextureView,
        target: &wgpu::TextureView,
    ) -> DrawCost {
        let uniform = Uniform { view: ViewUniform::new(&request.view), corner: self.corner, size: self.size };
        let bind_group = pass::bind(gpu, &self.pipeline, &pass::uniform(gpu, &uniform), &[picture]);
        pass::draw(encoder, &self.pipeline, &bind_group, target, Extent::Corner(request.view.target_px));
        super::flat_picture_drawn(gpu, encoder, request)
    }
}
