//! The calibration stimulus: full resolution except in a ring at one eccentricity around the gaze, where detail finer than
//! omega = `mar_deg` is removed by a Gaussian low-pass with amplitude ½ at 1/omega cycles per degree, in linear light.
//!
//! # What it measures, and what it does not
//! The coarsest detail limit that goes unnoticed *in this content at that eccentricity*: the threshold of an observer who
//! compares it with the reference. It is not clinical acuity: no letters or gratings are resolved, the threshold follows
//! the picture's own spectrum and contrast, and a display that cannot show the finer detail cannot reveal its absence.
//! The ring covers every direction at once, so the figure mixes the meridians.
//!
//! # How exact it is
//! The filter is round in visual angle (see [`crate::foveation::low_pass`]); the covariance is taken at each pixel that is
//! shown, the picture is mirrored at the display's edges, and the Gaussian ends at 3.5 standard deviations. The stages in
//! between hold full floats; only the result is rounded to half floats (2.44e-4 at most below 1). Where the Gaussian is
//! wider than 1.6 px it is factored into one-dimensional stages, wider than 2.8 px on a coarser grid; they take their
//! covariance from their own sample, which departs a little from the exact sum where the covariance changes within the
//! Gaussian (very wide filters far off the axis). `tests/pictures/ring.rs` compares with a direct two-dimensional sum in
//! f64, taken out to five standard deviations. Largest differences, in units of the display's peak: 6.0e-4 for omega up
//! to 4° on displays 30° and 73° wide; 1.5e-3 at 8° and 3.6e-3 at 20° on the latter.
//!
//! The amplitude at 1/omega is ½ to within 1.1 % for omega of four pixels and more. Below, sampling makes it depend on
//! direction: ½ along rows and columns, less on the diagonals (0.477 in the mean over directions at 2.6 px per cycle).
//!
//! # What it costs
//! The filtered picture does not depend on the gaze. What a frame needs of it is made once for a picture and an omega, and
//! a frame in which only the gaze has moved makes little more than the mixing of the two pictures in the ring.

use crate::contract::{DrawCost, FrameCost, FrameInput, LINEAR_FORMAT, MakeError, RenderError, Renderer, Scene};
use crate::geometry::{Cone, GeometryUniform, PixelBox};
use crate::gpu::Gpu;
use crate::parameters::number;
use crate::pass::{self, Extent};
use crate::renderers::low_passed::LowPassed;
use crate::renderers::reference::ReferencePicture;
use crate::timing::GpuTimer;
use experiments::catalogue::{
    DetailLaw, ParameterError, ParameterSchema, Parameters, RendererInfo, complete_parameters,
};
use experiments::display::Display;

pub(crate) const WGSL: &str = include_str!("ring.wgsl");

pub(crate) fn info() -> RendererInfo {
    RendererInfo {
        id: "ring".to_owned(),
        version: 1,
        about: "Full resolution, but detail finer than a limit is removed in a ring around the gaze (calibration)."
            .to_owned(),
        source: String::new(),
        parameters: vec![
            ParameterSchema::number("eccentricity_deg", "°", 0.0..=60.0, 10.0, "Middle of the ring; 0 is a disc."),
            ParameterSchema::number("width_deg", "°", 0.0..=60.0, 4.0, "Full width of the fully filtered part."),
            ParameterSchema::number("edge_deg", "°", 0.0..=20.0, 0.5, "Width of each soft edge outside it."),
            ParameterSchema::number(
                "mar_deg",
                "°/cycle",
                0.005..=20.0,
                0.5,
                "Detail limit omega: the amplitude falls to one half at 1/omega cycles per degree.",
            ),
        ],
        detail: DetailLaw::Ring {
            eccentricity: "eccentricity_deg".to_owned(),
            width: "width_deg".to_owned(),
            mar: "mar_deg".to_owned(),
        },
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Settings {
    eccentricity_deg: f64,
    width_deg: f64,
    edge_deg: f64,
    mar_deg: f64,
}

impl Settings {
    fn read(parameters: &Parameters) -> Result<Self, Vec<ParameterError>> {
        Ok(Self {
            eccentricity_deg: number(parameters, "eccentricity_deg")?,
            width_deg: number(parameters, "width_deg")?,
            edge_deg: number(parameters, "edge_deg")?,
            mar_deg: number(parameters, "mar_deg")?,
        })
    }
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    geometry: GeometryUniform,
    ring_rad: f32,
    half_width_rad: f32,
    edge_rad: f32,
    reserved: f32,
}

struct Ring {
    display: Display,
    settings: Settings,
    reference: ReferencePicture,
    low_passed: LowPassed,
    output: wgpu::Texture,
    output_view: wgpu::TextureView,
    pipeline: wgpu::RenderPipeline,
    /// What the output shows.
    shown: Option<(Settings, [f64; 2])>,
    /// Where the output may differ from the reference; `None` is everywhere.
    overlaid: Option<Vec<PixelBox>>,
    timer: GpuTimer,
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Renderer>, MakeError> {
    let output = pass::linear_texture(gpu, "ring output", display.resolution_px());
    Ok(Box::new(Ring {
        display: display.clone(),
        settings: Settings::read(parameters)?,
        reference: ReferencePicture::new(gpu, display),
        low_passed: LowPassed::new(gpu, display),
        output_view: pass::view(&output),
        output,
        pipeline: pass::pipeline(gpu, "ring", WGSL, "ring", LINEAR_FORMAT),
        shown: None,
        overlaid: None,
        timer: GpuTimer::new(gpu),
    }))
}

impl Ring {
    fn uniform(&self, gaze_deg: [f64; 2]) -> Uniform {
        let settings = &self.settings;
        Uniform {
            geometry: GeometryUniform::new(&self.display, gaze_deg),
            ring_rad: settings.eccentricity_deg.to_radians() as f32,
            half_width_rad: (0.5 * settings.width_deg).to_radians() as f32,
            edge_rad: settings.edge_deg.max(1e-4).to_radians() as f32,
            reserved: 0.0,
        }
    }
}

impl Renderer for Ring {
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError> {
        frame.check()?;
        let settings = self.settings;
        let wanted = Some((settings, frame.gaze_deg));
        let stale = self.reference.is_stale(scene, frame.animation_s);
        if self.shown == wanted && !stale {
            return Ok(FrameCost { gpu_time_s: self.timer.last_s(), ..FrameCost::default() });
        }
        self.shown = None;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.timer.begin(gpu, &mut encoder);

        // The output becomes the reference again, where it is not.
        let overlaid = self.overlaid.take().filter(|_| !stale);
        let drawn = self.reference.update(gpu, &mut encoder, scene, frame.animation_s)?;
        if stale {
            self.low_passed.forget();
        }
        match overlaid {
            Some(boxes) => pass::copy_boxes(&mut encoder, &self.reference.texture, &self.output, &boxes),
            None => pass::copy(&mut encoder, &self.reference.texture, &self.output),
        }

        // The ring lies between two cones around the gaze.
        let reach_deg = 0.5 * settings.width_deg + settings.edge_deg;
        let outer = Cone::new(&self.display, frame.gaze_deg, settings.eccentricity_deg + reach_deg);
        let hole_deg = settings.eccentricity_deg - reach_deg;
        let hole = (hole_deg > 0.0).then(|| Cone::new(&self.display, frame.gaze_deg, hole_deg));
        let boxes = outer.boxes_around(hole.as_ref());
        if !boxes.is_empty() {
            let view = &self.reference.view;
            let low_passed = self.low_passed.update(gpu, &mut encoder, view, settings.mar_deg, &boxes);
            let uniform = pass::uniform(gpu, &self.uniform(frame.gaze_deg));
            let bind_group = pass::bind(gpu, &self.pipeline, &uniform, &[&low_passed, view]);
            pass::draw(&mut encoder, &self.pipeline, &bind_group, &self.output_view, Extent::Boxes(&boxes));
        }
        self.overlaid = Some(boxes);
        let filtered = outer.pixels() - hole.map_or(0, |hole| hole.pixels());

        let gpu_time_s = self.timer.submit(gpu, encoder);
        gpu.check()?;
        self.shown = wanted;
        Ok(DrawCost { pixels_shaded: drawn.pixels_shaded + filtered, ..drawn }.in_frame(gpu_time_s))
    }

    fn output(&self) -> &wgpu::Texture {
        &self.output
    }

    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Vec<ParameterError>> {
        self.settings = Settings::read(&complete_parameters(&info().parameters, parameters)?)?;
        Ok(())
    }
}
