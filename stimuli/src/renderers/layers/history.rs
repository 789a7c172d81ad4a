//! Temporal reprojection of one layer (Guenter et al. 2012, §4.2, after Nehab et al. 2007): its accumulated picture is
//! kept, and each new drawing is averaged into it where the same surface is found there. The mathematics is in
//! `accumulate.wgsl`.

use super::settings::Settings;
use crate::contract::View;
use crate::gpu::Gpu;
use crate::pass::{self, Extent};

pub(crate) const WGSL: &str = include_str!("accumulate.wgsl");

/// Full floats: the average of many samples must not stand still because a step is below the rounding of half floats.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    step_px: [f32; 2],
    least_weight: f32,
    tolerance: f32,
    offset: [i32; 2],
    size: [i32; 2],
    earlier_size: [i32; 2],
    reserved: [i32; 2],
}

/// The accumulated pictures of one layer: the newest, and the one before, into which the next is written.
#[derive(Debug, Default)]
pub(super) struct History {
    pictures: [Option<wgpu::Texture>; 2],
    newest: usize,
    /// View and time of the newest; `None` where nothing may be used again.
    kept: Option<(View, f64)>,
}

impl History {
    pub(super) fn forget(&mut self) {
        self.kept = None;
    }

    /// The time since which motion is asked for at `animation_s`: that of the newest picture, or now where there is none.
    pub(super) fn since_s(&self, animation_s: f64) -> f64 {
        self.kept.map_or(animation_s, |(_, since_s)| since_s)
    }

    /// Records the averaging of `drawn`, a drawing of `view` (without its jitter), into the accumulated picture.
    #[expect(clippy::too_many_arguments, reason = "a drawing is these things")]
    pub(super) fn accumulate(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::RenderPipeline,
        settings: &Settings,
        (drawn, motion): (&wgpu::TextureView, &wgpu::TextureView),
        view: &View,
        animation_s: f64,
    ) {
        let step = view.step_px();
        // Both lie on the same grid, so that the way from one to the other is whole pixels.
        let earlier = self.kept.map(|(earlier, _)| {
            let cells = |axis: usize| ((view.origin_px[axis] - earlier.origin_px[axis]) / step[axis]).round() as i32;
            ([cells(0), cells(1)], earlier.target_px.map(|x| x as i32))
        });
        let (offset, earlier_size) = earlier.unwrap_or_default();
        let uniform = Uniform {
            step_px: step.map(|x| x as f32),
            least_weight: settings.history_weight as f32,
            tolerance: settings.depth_tolerance as f32,
            offset,
            size: view.target_px.map(|x| x as i32),
            earlier_size,
            reserved: [0; 2],
        };
        let [first, second] = &mut self.pictures;
        let (newest, next) = if self.newest == 0 { (first, second) } else { (second, first) };
        let earlier = pass::view(pass::at_least(gpu, newest, "history", [1, 1], FORMAT));
        let target = pass::view(pass::at_least(gpu, next, "history", super::roomy(gpu, view.target_px), FORMAT));
        let bind_group = pass::bind(gpu, pipeline, &pass::uniform(gpu, &uniform), &[drawn, motion, &earlier]);
        pass::draw(encoder, pipeline, &bind_group, &target, Extent::Corner(view.target_px));
        self.newest = 1 - self.newest;
        self.kept = Some((*view, animation_s));
    }

    /// The accumulated picture.
    pub(super) fn picture(&self) -> Option<&wgpu::Texture> {
        self.pictures.get(self.newest)?.as_ref()
    }
}

/// The pipeline of [`History::accumulate`].
pub(super) fn pipeline(gpu: &Gpu) -> wgpu::RenderPipeline {
    pass::pipeline(gpu, "accumulate", WGSL, "accumulate", FORMAT)
}
