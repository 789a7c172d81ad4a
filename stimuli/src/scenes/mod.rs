//! The scenes, one Rust file and one WGSL file each. Add a line to [`crate::registry`] for a new one.

pub(crate) mod atrium;
pub(crate) mod campbell_robson;
mod coloured;
pub(crate) mod engine_room;
pub(crate) mod grid_world;
pub(crate) mod noise;
pub(crate) mod orbit;
pub(crate) mod parts;
pub(crate) mod patch;
pub(crate) mod photo;
pub(crate) mod tunnel;
pub(crate) mod voxel_town;
#[cfg(test)]
mod worlds_tests;
pub(crate) mod zone_plate;

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

/// What is left of a wave of `per_px` cycles for each display pixel when the display pixels under a target pixel of
/// `step_px` are averaged: as many samples as there are, evenly spaced. 1 at the display's own pixels.
pub(crate) fn averaged(per_px: f64, step_px: f64) -> f64 {
    let samples = (step_px - 1e-3).ceil().max(1.0);
    let below = samples * (std::f64::consts::PI * per_px * step_px / samples).sin();
    if below.abs() < 1e-9 { 1.0 } else { (std::f64::consts::PI * per_px * step_px).sin() / below }
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
