//! The scenes, one Rust file and one WGSL file each. Add a line to [`crate::registry`] for a new one.

pub(crate) mod centred;
pub(crate) mod noise;
pub(crate) mod orbit;
pub(crate) mod patch;
pub(crate) mod photo;
pub(crate) mod picture;

use crate::contract::{DrawCost, DrawRequest, View};
use crate::gpu::Gpu;
use crate::pass;

/// `View` of the scene shaders: the place of a target pixel on the display is `origin + position * step`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct ViewUniform {
    origin_px: [f32; 2],
    step_px: [f32; 2],
}

impl ViewUniform {
    pub(crate) fn new(view: &View) -> Self {
        Self { origin_px: view.origin_px.map(|x| x as f32), step_px: view.step_px().map(|x| x as f32) }
    }
}

/// Counts a view whose every pixel was shaded once, where that is asked for.
pub(crate) fn tally_view(gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, request: &DrawRequest<'_>) {
    if let Some(tally) = request.tally {
        tally.count_view(gpu, encoder, &request.view);
    }
}

/// What every flat picture owes after it was drawn: that it has not moved, what was shaded, and its cost.
pub(crate) fn flat_picture_drawn(gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, request: &DrawRequest<'_>) -> DrawCost {
    if let Some(motion) = request.motion {
        pass::clear(encoder, motion.target, wgpu::Color { r: 0.0, g: 0.0, b: 1.0, a: 1.0 });
    }
    tally_view(gpu, encoder, request);
    DrawCost::of_pixels(&request.view)
}
