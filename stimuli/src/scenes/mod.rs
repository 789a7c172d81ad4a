//! The scenes, one Rust file and one WGSL file each. Add a line to [`crate::registry`] for a new one.

pub(crate) mod noise;
pub(crate) mod orbit;
pub(crate) mod patch;
pub(crate) mod photo;

use crate::contract::View;

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
