//! Campbell and Robson's chart ("Application of Fourier analysis to the visibility of gratings", J. Physiol. 197, 1968): a
//! grating whose spatial frequency grows to the right and whose contrast falls towards the top, both in equal ratios, so
//! that the border of what is seen draws the observer's contrast sensitivity.
//!
//! With θ the horizontal angle of a column from the display's centre, θ₀ that of the left edge, K the angle from edge to
//! edge and ρ = f₁/f₀, the frequency is f₀ ρ^((θ − θ₀)/K) cycles per degree, and its integral over θ is the phase. Columns
//! are straight: in a row at elevation ε the angle of a pixel is smaller by cos ε, and the true frequency larger. Light is
//! ½ (1 + c sin 2πφ), linear. Where a cycle is shorter than two display pixels the chart is grey.

use crate::contract::{DrawCost, DrawRequest, MakeError, RenderError, Scene, SceneIdentity};
use crate::gpu::Gpu;
use crate::parameters::number;
use crate::pass::{self, Extent};
use experiments::catalogue::{ParameterError, ParameterSchema, Parameters, SceneInfo};
use experiments::display::Display;
use std::f64::consts::TAU;

pub(crate) const WGSL: &str = include_str!("campbell_robson.wgsl");

pub(crate) fn info() -> SceneInfo {
    let frequency = |name, default, about| ParameterSchema::number(name, "cycles/°", 0.01..=100.0, default, about);
    let contrast = |name, default, about| ParameterSchema::number(name, "", 0.0001..=1.0, default, about);
    SceneInfo {
        id: "campbell-robson".to_owned(),
        version: 1,
        about:
            "The contrast sensitivity chart: a grating of growing frequency and falling contrast, mean half the peak."
                .to_owned(),
        parameters: vec![
            frequency("lowest_cpd", 0.5, "Spatial frequency at the left edge."),
            frequency("highest_cpd", 30.0, "Spatial frequency at the right edge; below the lowest, it falls."),
            contrast("highest_contrast", 1.0, "Michelson contrast at the lower edge."),
            contrast("lowest_contrast", 0.002, "Michelson contrast at the upper edge."),
        ],
        animated: false,
    }
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    mean: [f32; 4],
}

struct Chart {
    identity: SceneIdentity,
    pipeline: wgpu::RenderPipeline,
    display: Display,
    cpd: [f64; 2],
    contrast: [f64; 2],
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Scene>, MakeError> {
    let pair = |names: [&str; 2]| -> Result<[f64; 2], Vec<ParameterError>> {
        Ok([number(parameters, names[0])?, number(parameters, names[1])?])
    };
    Ok(Box::new(Chart {
        identity: SceneIdentity::new(),
        pipeline: pass::pipeline(gpu, "campbell-robson", WGSL, "campbell_robson", crate::LINEAR_FORMAT),
        display: display.clone(),
        cpd: pair(["lowest_cpd", "highest_cpd"])?,
        contrast: pair(["highest_contrast", "lowest_contrast"])?,
    }))
}

impl Chart {
    /// Cycles between the left edge and the column at `x_px`.
    fn cycles(&self, x_px: f64) -> f64 {
        let half_deg = self.display.half_field_deg()[0];
        let from_edge_deg = self.display.deg_from_px([x_px, 0.0])[0] + half_deg;
        let across_deg = 2.0 * half_deg;
        let growth = (self.cpd[1] / self.cpd[0]).ln();
        if growth.abs() < 1e-9 {
            return self.cpd[0] * from_edge_deg;
        }
        self.cpd[0] * across_deg * (growth * from_edge_deg / across_deg).exp_m1() / growth
    }

    /// The wave in the column at `x_px`, averaged over the display pixels under a target pixel of `step_px`.
    fn wave(&self, x_px: f64, step_px: f64) -> f64 {
        let per_px = (self.cycles(x_px + 0.5) - self.cycles(x_px - 0.5)).abs();
        if per_px >= 0.5 {
            return 0.0;
        }
        let cycles = self.cycles(x_px);
        super::averaged(per_px, step_px) * (TAU * (cycles - cycles.floor())).sin()
    }

    /// The contrast in the row at `y_px`.
    fn contrast(&self, y_px: f64) -> f64 {
        let up = 1.0 - y_px / f64::from(self.display.resolution_px()[1]);
        (self.contrast[0] * (self.contrast[1] / self.contrast[0]).powf(up)).min(1.0)
    }
}

impl Scene for Chart {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        let view = &request.view;
        let step_px = view.step_px();
        // A column's wave and a row's contrast in double precision: as many values as the target's edges are long.
        let line = |label, axis: usize, value: &dyn Fn(f64) -> f64| {
            let place = |i: u32| view.origin_px[axis] + (f64::from(i) + 0.5) * step_px[axis];
            let values: Vec<[f32; 4]> = (0..view.target_px[axis]).map(|i| [value(place(i)) as f32; 4]).collect();
            pass::view(&pass::float_texture(gpu, label, [view.target_px[axis], 1], &values))
        };
        let wave = line("wave", 0, &|x_px| self.wave(x_px, step_px[0]));
        let contrast = line("contrast", 1, &|y_px| self.contrast(y_px));
        let uniform = pass::uniform(gpu, &Uniform { mean: [0.5; 4] });
        let bind_group = pass::bind(gpu, &self.pipeline, &uniform, &[&wave, &contrast]);
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
