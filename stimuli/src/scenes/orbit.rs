//! A small courtyard, ray-cast in one shader: columns, plinths, mirrors and painted spheres on a paved floor under an
//! environment map, seen by a camera that circles it, pans, or stands still. The camera's rays pass through the display's own pixels, so a
//! degree in the scene is a degree on the display, whatever its size and distance.

use super::ViewUniform;
use crate::contract::{DrawCost, DrawRequest, MakeError, RenderError, Scene, SceneIdentity, View};
use crate::geometry::GeometryUniform;
use crate::gpu::Gpu;
use crate::parameters::{number, text};
use crate::pass::{self, Extent};
use crate::world::environment::Sun;
use crate::world::{Environment, Panorama, Sky};
use experiments::catalogue::{ParameterSchema, Parameters, SceneInfo};
use experiments::display::Display;
use glam::{DQuat, DVec3, Vec3, Vec4};
use std::f64::consts::TAU;

pub(crate) const WGSL: &str = concat!(include_str!("orbit.wgsl"), "\n", include_str!("orbit_motion.wgsl"));

/// Radiance that lights a white surface to about half the display's peak.
const EXPOSURE: f32 = 0.62;
pub(crate) fn info() -> SceneInfo {
    SceneInfo {
        id: "orbit".to_owned(),
        version: 1,
        about:
            "A ray-cast courtyard of columns and spheres under an environment map, seen by a circling, a panning or a \
                still camera."
                .to_owned(),
        parameters: vec![
            ParameterSchema::choice(
                "camera",
                &["fly", "pan", "static"],
                "The camera's motion: it circles the court, or stops at its start and looks left and right, or stands still.",
            ),
            ParameterSchema::number(
                "camera_speed",
                "°/s",
                -90.0..=90.0,
                6.0,
                "How fast the camera circles the court, or at most pans; at 0 the picture stands still.",
            ),
            ParameterSchema::number(
                "camera_start_deg",
                "°",
                0.0..=360.0,
                62.0,
                "Where on its circle the camera starts.",
            ),
        ],
        animated: true,
    }
}

const SPHERES: [[f32; 4]; 7] = [
    [0.0, 1.55, 0.0, 0.95],
    [-1.9, 0.55, 1.1, 0.55],
    [1.75, 0.45, 1.45, 0.45],
    [0.35, 0.30, 2.05, 0.30],
    [1.9, 1.30, -1.2, 0.50],
    [-1.75, 1.20, -1.5, 0.40],
    [-0.75, 0.22, 2.35, 0.22],
];
const SPHERE_COLOURS: [[f32; 4]; 7] = [
    [0.95, 0.93, 0.88, 0.92],
    [0.62, 0.10, 0.07, 0.05],
    [0.98, 0.74, 0.36, 0.85],
    [0.08, 0.26, 0.45, 0.05],
    [0.14, 0.36, 0.16, 0.05],
    [0.90, 0.62, 0.52, 0.80],
    [0.85, 0.82, 0.74, 0.05],
];
const BLOCK_MIDDLES: [[f32; 4]; 5] = [
    [0.0, 0.35, 0.0, 0.0],
    [1.9, 0.40, -1.2, 0.0],
    [-1.75, 0.40, -1.5, 0.0],
    [0.0, 0.05, 0.0, 0.0],
    [-2.75, 0.30, 0.35, 0.0],
];
const BLOCK_HALVES: [[f32; 4]; 5] = [
    [0.80, 0.25, 0.80, 0.0],
    [0.42, 0.40, 0.42, 0.0],
    [0.38, 0.40, 0.38, 0.0],
    [1.15, 0.05, 1.15, 0.0],
    [0.28, 0.30, 0.28, 0.0],
];
const COLUMNS: usize = 8;
/// Distance of the columns from the middle; the camera circles inside them.
const COLUMN_RING: f64 = 14.0;
/// Distance of the camera from the middle.
const CAMERA_RING: f64 = 11.0;
/// How far a panning camera looks to either side, degrees: some of the court stays in view on a display of 30°.
const PAN_DEG: f64 = 15.0;

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    geometry: GeometryUniform,
    view: ViewUniform,
    eye: Vec4,
    right: Vec4,
    up: Vec4,
    forward: Vec4,
    sun: Vec4,
    sun_light: Vec4,
    ambient: [Vec4; 9],
    spheres: [[f32; 4]; 7],
    sphere_colours: [[f32; 4]; 7],
    columns: [[f32; 4]; COLUMNS],
    block_middles: [[f32; 4]; 5],
    block_halves: [[f32; 4]; 5],
    /// From the camera of the time since which motion is asked for to this one, and that camera's axes.
    come: Vec4,
    earlier_right: Vec4,
    earlier_up: Vec4,
    earlier_forward: Vec4,
}

struct Orbit {
    identity: SceneIdentity,
    display: Display,
    pipeline: wgpu::RenderPipeline,
    motion_pipeline: wgpu::RenderPipeline,
    environment: wgpu::TextureView,
    sun: Sun,
    /// Light of the sky without the sun, in the nine functions of `ambient_light`.
    ambient: [Vec3; 9],
    motion: Motion,
    camera_start_deg: f64,
}

/// What the camera does: Guenter et al. 2012, §6, had it fly at six speeds, stop and pan, and stand still.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Motion {
    /// Circling the court, degrees per second.
    Fly(f64),
    /// Turning about its own vertical to and fro, degrees per second in the middle of the sweep.
    Pan(f64),
    Still,
}

impl Motion {
    fn read(parameters: &Parameters) -> Result<Self, MakeError> {
        let speed_deg_s = number(parameters, "camera_speed")?;
        Ok(match text(parameters, "camera")? {
            _ if speed_deg_s.abs() <= 0.0 => Self::Still,
            "static" => Self::Still,
            "pan" => Self::Pan(speed_deg_s),
            _ => Self::Fly(speed_deg_s),
        })
    }

    /// How far the camera has come on its circle, degrees.
    fn along_deg(self, animation_s: f64) -> f64 {
        if let Self::Fly(speed_deg_s) = self { speed_deg_s * animation_s } else { 0.0 }
    }

    /// How far it looks aside, degrees.
    fn aside_deg(self, animation_s: f64) -> f64 {
        if let Self::Pan(speed_deg_s) = self { PAN_DEG * (speed_deg_s / PAN_DEG * animation_s).sin() } else { 0.0 }
    }
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Scene>, MakeError> {
    let environment = Environment::of(Sky::Park.panorama(EXPOSURE)?);
    let Panorama { size, radiance } = &environment.panorama;
    // Half floats end at 65504; nothing that is shown comes near.
    let texels: Vec<[f32; 4]> = radiance.iter().map(|c| c.min(Vec3::splat(6e4)).extend(1.0).to_array()).collect();
    // A map without a sun gets light from high on one side, a third of its mean.
    let sun = environment.sun.unwrap_or_else(|| Sun {
        towards: Vec3::new(0.5, 0.75, 0.43).normalize(),
        colour: Vec3::splat(EXPOSURE / 3.0),
    });
    Ok(Box::new(Orbit {
        identity: SceneIdentity::new(),
        display: display.clone(),
        pipeline: pass::pipeline(gpu, "orbit", WGSL, "orbit", crate::LINEAR_FORMAT),
        motion_pipeline: pass::pipeline(gpu, "orbit's motion", WGSL, "motion", crate::LINEAR_FORMAT),
        environment: pass::view(&pass::half_texture(gpu, "environment", *size, &texels)),
        sun,
        ambient: environment.ambient,
        motion: Motion::read(parameters)?,
        camera_start_deg: number(parameters, "camera_start_deg")?,
    }))
}

/// Where the camera is, and the directions in which it sees right, up and ahead.
#[derive(Debug, Clone, Copy)]
struct Camera {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
}

impl Orbit {
    fn camera(&self, animation_s: f64) -> Camera {
        // The camera circles the court within its columns' ring and looks slightly down, bobbing once a turn and a half.
        let angle = (self.camera_start_deg + self.motion.along_deg(animation_s)).to_radians();
        let height = 1.75 + 0.25 * (1.5 * angle).sin();
        let eye = DVec3::new(CAMERA_RING * angle.cos(), height, CAMERA_RING * angle.sin());
        let ahead = (DVec3::new(0.0, 1.25, 0.0) - eye).normalize();
        let forward = DQuat::from_rotation_y(self.motion.aside_deg(animation_s).to_radians()) * ahead;
        let right = forward.cross(DVec3::Y).normalize();
        Camera { eye, right, up: right.cross(forward), forward }
    }

    fn uniform(&self, view: &View, animation_s: f64, since_s: f64) -> Uniform {
        let Camera { eye, right, up, forward } = self.camera(animation_s);
        let earlier = self.camera(since_s);
        let extend = |v: DVec3| v.as_vec3().extend(0.0);
        let column = |i: usize| {
            let angle = (i as f64 + 0.5) / COLUMNS as f64 * TAU;
            [(COLUMN_RING * angle.cos()) as f32, (COLUMN_RING * angle.sin()) as f32, 0.0, 0.0]
        };
        Uniform {
            geometry: GeometryUniform::new(&self.display, [0.0; 2]),
            view: ViewUniform::new(view),
            eye: extend(eye),
            right: extend(right),
            up: extend(up),
            forward: extend(forward),
            sun: self.sun.towards.extend(0.0),
            sun_light: self.sun.colour.extend(0.0),
            ambient: self.ambient.map(|c| c.extend(0.0)),
            spheres: SPHERES,
            sphere_colours: SPHERE_COLOURS,
            columns: std::array::from_fn(column),
            block_middles: BLOCK_MIDDLES,
            block_halves: BLOCK_HALVES,
            come: extend(eye - earlier.eye),
            earlier_right: extend(earlier.right),
            earlier_up: extend(earlier.up),
            earlier_forward: extend(earlier.forward),
        }
    }
}

impl Scene for Orbit {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        let view = &request.view;
        let since_s = request.motion.map_or(request.animation_s, |motion| motion.since_s);
        let uniform = pass::uniform(gpu, &self.uniform(view, request.animation_s, since_s));
        let bind_group = pass::bind(gpu, &self.pipeline, &uniform, &[&self.environment]);
        pass::draw(encoder, &self.pipeline, &bind_group, target, Extent::Corner(view.target_px));
        if let Some(motion) = request.motion {
            let bind_group = pass::bind(gpu, &self.motion_pipeline, &uniform, &[]);
            pass::draw(encoder, &self.motion_pipeline, &bind_group, motion.target, Extent::Corner(view.target_px));
        }
        super::tally_view(gpu, encoder, request);
        Ok(DrawCost { rays_traced: view.pixels(), ..DrawCost::of_pixels(view) })
    }

    fn picture_changes(&self, from_s: f64, to_s: f64) -> bool {
        self.motion != Motion::Still && from_s != to_s
    }

    fn identity(&self) -> SceneIdentity {
        self.identity
    }
}

#[cfg(test)]
mod tests;
