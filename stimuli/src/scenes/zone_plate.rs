//! A zone plate: rings around the display's centre whose spatial frequency grows in proportion to the angle r from the
//! centre, up to `highest_cpd` at `radius_deg` and no further. It holds every frequency in every orientation, so that
//! whatever a renderer does to detail shows as rings that fade, or as others that should not be there. It can move.
//!
//! Light is ½ (1 + c cos 2π(φ − moved)), linear, with φ = f r²/2R inside the radius R and f (r − R/2) beyond: r is the true
//! angle. Where a cycle is shorter than two display pixels along either axis the plate is grey. At larger steps a pixel is
//! the mean of the display pixels under it, in closed form for rings that are straight within it.

use super::ViewUniform;
use crate::contract::{DrawCost, DrawRequest, MakeError, RenderError, Scene, SceneIdentity};
use crate::geometry::GeometryUniform;
use crate::gpu::Gpu;
use crate::parameters::number;
use crate::pass::{self, Extent};
use experiments::catalogue::{ParameterSchema, Parameters, SceneInfo};
use experiments::display::Display;

pub(crate) const WGSL: &str = include_str!("zone_plate.wgsl");

pub(crate) fn info() -> SceneInfo {
    SceneInfo {
        id: "zone-plate".to_owned(),
        version: 1,
        about: "Rings whose spatial frequency grows with the angle from the display's centre, mean half the peak."
            .to_owned(),
        parameters: vec![
            ParameterSchema::number(
                "highest_cpd",
                "cycles/°",
                0.1..=100.0,
                12.0,
                "Spatial frequency at the radius and beyond.",
            ),
            ParameterSchema::number(
                "radius_deg",
                "°",
                0.0..=80.0,
                0.0,
                "Angle from the centre at which the highest frequency is reached; 0 is the display's nearer edge.",
            ),
            ParameterSchema::number("contrast", "", 0.0..=1.0, 1.0, "Michelson contrast of the rings."),
            ParameterSchema::number(
                "drift_hz",
                "Hz",
                -60.0..=60.0,
                0.0,
                "Rings that pass a place in a second, outward; below 0, inward.",
            ),
        ],
        animated: true,
    }
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    geometry: GeometryUniform,
    view: ViewUniform,
    highest_per_rad: f32,
    radius_rad: f32,
    contrast: f32,
    moved: f32,
}

struct ZonePlate {
    identity: SceneIdentity,
    pipeline: wgpu::RenderPipeline,
    display: Display,
    highest_cpd: f64,
    radius_deg: f64,
    contrast: f64,
    drift_hz: f64,
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Scene>, MakeError> {
    let radius_deg = number(parameters, "radius_deg")?;
    let [across_deg, up_deg] = display.half_field_deg();
    Ok(Box::new(ZonePlate {
        identity: SceneIdentity::new(),
        pipeline: pass::pipeline(gpu, "zone-plate", WGSL, "zone_plate", crate::LINEAR_FORMAT),
        display: display.clone(),
        highest_cpd: number(parameters, "highest_cpd")?,
        radius_deg: if radius_deg > 0.0 { radius_deg } else { across_deg.min(up_deg) },
        contrast: number(parameters, "contrast")?,
        drift_hz: number(parameters, "drift_hz")?,
    }))
}

impl Scene for ZonePlate {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        let view = &request.view;
        let uniform = Uniform {
            geometry: GeometryUniform::new(&self.display, [0.0; 2]),
            view: ViewUniform::new(view),
            highest_per_rad: self.highest_cpd.to_degrees() as f32,
            radius_rad: self.radius_deg.to_radians() as f32,
            contrast: self.contrast as f32,
            moved: (self.drift_hz * request.animation_s).rem_euclid(1.0) as f32,
        };
        let bind_group = pass::bind(gpu, &self.pipeline, &pass::uniform(gpu, &uniform), &[]);
        pass::draw(encoder, &self.pipeline, &bind_group, target, Extent::Corner(view.target_px));
        Ok(super::flat_picture_drawn(gpu, encoder, request))
    }

    fn picture_changes(&self, from_s: f64, to_s: f64) -> bool {
        from_s != to_s && self.drift_hz != 0.0
    }

    fn identity(&self) -> SceneIdentity {
        self.identity
    }
}
