//! Guenter's eccentricity layers: three nested targets around the gaze, each sampled as coarsely as the acuity line allows
//! ([`crate::foveation::plan`], Guenter et al. 2012, §4), magnified and blended into the display's picture.
//!
//! Within 0.6 of the innermost radius the picture equals the reference exactly. Left out so far: jitter, temporal
//! reprojection, and outer layers at half rate (§4.2), so coarse layers alias as a single frame of theirs would.

use crate::contract::{
    DrawCost, DrawRequest, FrameCost, FrameInput, LINEAR_FORMAT, MakeError, RenderError, Renderer, Scene,
    SceneIdentity, View,
};
use crate::foveation::plan::{LayerPlan, optimise, slope_from_quality_index};
use crate::geometry::{Cone, GeometryUniform, PixelBox};
use crate::gpu::Gpu;
use crate::parameters::{number, text};
use crate::pass::{self, Extent};
use crate::timing::GpuTimer;
use experiments::catalogue::{
    DetailLaw, ParameterError, ParameterSchema, Parameters, RendererInfo, complete_parameters,
};
use experiments::display::Display;

pub(crate) const WGSL: &str = include_str!("layers.wgsl");

/// r1 / r2 of the blend between two layers (our reading of Guenter 2012, Fig. 5).
const BLEND_FROM: f64 = 0.6;

pub(crate) fn info() -> RendererInfo {
    RendererInfo {
        id: "layers".to_owned(),
        version: 2,
        about: "Three eccentricity layers around the gaze, optimised for an acuity line and blended smoothly."
            .to_owned(),
        source: "Guenter, Finch, Drucker, Tan, Snyder: Foveated 3D Graphics. ACM TOG 31(6), 2012".to_owned(),
        parameters: vec![
            ParameterSchema::number(
                "m",
                "°/cycle/°",
                0.0..=1.0,
                0.022,
                "Slope of the acuity line: how fast the detail limit grows with eccentricity.",
            ),
            ParameterSchema::number(
                "omega0_deg",
                "°/cycle",
                0.001..=1.0,
                1.0 / 48.0,
                "Detail limit at the fovea: intercept of the acuity line.",
            ),
            ParameterSchema::number(
                "quality_index",
                "",
                0.0..=100.0,
                0.0,
                "Guenter's quality index j, larger is finer; above 0 it sets the slope to 0.33/j in place of m.",
            ),
            ParameterSchema::choice(
                "restrict_s2",
                &["free", "2"],
                "Sampling factor of the middle layer: the optimum, or 2 as in Guenter's user study.",
            ),
        ],
        detail: DetailLaw::Line {
            m: "m".to_owned(),
            omega0: "omega0_deg".to_owned(),
            quality_index: Some("quality_index".to_owned()),
        },
    }
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    geometry: GeometryUniform,
    inner_rad: f32,
    middle_rad: f32,
    blend_from: f32,
    reserved: f32,
    /// Of the three layers: corner and display pixels per layer pixel.
    places: [[f32; 4]; 3],
    sizes: [[i32; 2]; 3],
    reserved2: [i32; 2],
}

struct Layers {
    display: Display,
    plan: LayerPlan,
    targets: [Option<wgpu::Texture>; 3],
    output: wgpu::Texture,
    output_view: wgpu::TextureView,
    pipeline: wgpu::RenderPipeline,
    /// What the output shows: scene, animation time and gaze. Cleared when the plan changes.
    shown: Option<(SceneIdentity, f64, [f64; 2])>,
    timer: GpuTimer,
}

fn planned(display: &Display, parameters: &Parameters) -> Result<LayerPlan, Vec<ParameterError>> {
    let restrict_s2 = text(parameters, "restrict_s2")?.parse().ok();
    let quality_index = number(parameters, "quality_index")?;
    let m = if quality_index > 0.0 { slope_from_quality_index(quality_index) } else { number(parameters, "m")? };
    Ok(optimise(display, m, number(parameters, "omega0_deg")?, 3, restrict_s2))
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Renderer>, MakeError> {
    let output = pass::linear_texture(gpu, "layers output", display.resolution_px());
    Ok(Box::new(Layers {
        display: display.clone(),
        plan: planned(display, parameters)?,
        targets: [None, None, None],
        output_view: pass::view(&output),
        output,
        pipeline: pass::pipeline(gpu, "layers", WGSL, "blend", LINEAR_FORMAT),
        shown: None,
        timer: GpuTimer::new(gpu),
    }))
}

/// The view of a layer that holds `bounds`, on a grid that is fixed to the display so that it does not swim with the gaze.
///
/// It reaches past the display's edges by less than one of its pixels.
fn layer_view(bounds: PixelBox, sampling_factor: f64) -> View {
    let span = |first: u32, end: u32| {
        let low = (f64::from(first) / sampling_factor).floor();
        let high = (f64::from(end) / sampling_factor).ceil();
        (low * sampling_factor, (high - low).max(1.0))
    };
    let (left, columns) = span(bounds.left, bounds.right);
    let (top, rows) = span(bounds.top, bounds.bottom);
    View {
        origin_px: [left, top],
        size_px: [columns * sampling_factor, rows * sampling_factor],
        target_px: [columns as u32, rows as u32],
    }
}

impl Layers {
    /// The view of each layer, `None` where the gaze is so far off that it does not touch the display.
    fn views(&self, gaze_deg: [f64; 2]) -> [Option<View>; 3] {
        let [right, bottom] = self.display.resolution_px();
        let whole = PixelBox { left: 0, top: 0, right, bottom };
        std::array::from_fn(|i| {
            let layer = self.plan.layers.get(i)?;
            let bounds = if i == 2 { whole } else { Cone::new(&self.display, gaze_deg, layer.radius_deg).bounds()? };
            Some(layer_view(bounds, layer.sampling_factor))
        })
    }

    fn radius_rad(&self, layer: usize) -> f32 {
        self.plan.layers.get(layer).map_or(0.0, |layer| layer.radius_deg.to_radians() as f32)
    }
}

impl Renderer for Layers {
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError> {
        frame.check()?;
        let unchanged = self.shown.is_some_and(|(identity, drawn_s, gaze_deg)| {
            identity == scene.identity()
                && gaze_deg == frame.gaze_deg
                && !scene.picture_changes(drawn_s, frame.animation_s)
        });
        if unchanged {
            return Ok(FrameCost { gpu_time_s: self.timer.last_s(), ..FrameCost::default() });
        }
        self.shown = None;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.timer.begin(gpu, &mut encoder);

        // Draw each layer into the corner of its own target.
        let views = self.views(frame.gaze_deg);
        let mut drawn = DrawCost::default();
        let mut target_views = Vec::with_capacity(3);
        for (view, slot) in views.iter().zip(&mut self.targets) {
            let size = view.as_ref().map_or([1, 1], |view| view.target_px);
            let target = pass::view(pass::at_least(gpu, slot, "layer", size, LINEAR_FORMAT));
            if let Some(view) = view {
                drawn += scene.draw(gpu, &mut encoder, &DrawRequest::of(*view, frame.animation_s), &target)?;
            }
            target_views.push(target);
        }

        // Put them together.
        let place = |view: &Option<View>| {
            view.as_ref().map_or([0.0, 0.0, 1.0, 1.0], |view| {
                let step = view.step_px();
                [view.origin_px[0], view.origin_px[1], step[0], step[1]].map(|x| x as f32)
            })
        };
        let uniform = Uniform {
            geometry: GeometryUniform::new(&self.display, frame.gaze_deg),
            inner_rad: self.radius_rad(0),
            middle_rad: self.radius_rad(1),
            blend_from: BLEND_FROM as f32,
            reserved: 0.0,
            places: [place(&views[0]), place(&views[1]), place(&views[2])],
            sizes: views.map(|view| view.map_or([1, 1], |view| view.target_px.map(|x| x as i32))),
            reserved2: [0; 2],
        };
        let layer_views: Vec<_> = target_views.iter().collect();
        let bind_group = pass::bind(gpu, &self.pipeline, &pass::uniform(gpu, &uniform), &layer_views);
        pass::draw(&mut encoder, &self.pipeline, &bind_group, &self.output_view, Extent::All);

        let gpu_time_s = self.timer.submit(gpu, encoder);
        gpu.check()?;
        self.shown = Some((scene.identity(), frame.animation_s, frame.gaze_deg));
        Ok(drawn.in_frame(gpu_time_s))
    }

    fn output(&self) -> &wgpu::Texture {
        &self.output
    }

    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Vec<ParameterError>> {
        let plan = planned(&self.display, &complete_parameters(&info().parameters, parameters)?)?;
        if plan != self.plan {
            self.plan = plan;
            self.shown = None;
        }
        Ok(())
    }
}
