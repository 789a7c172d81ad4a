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
//! shown, the picture is mirrored at the display's edges, and the Gaussian ends at 3.5 standard deviations. The passes in
//! between hold full floats; only the result is rounded to half floats (2.44e-4 at most below 1). Where the Gaussian is
//! wider than 1.6 px it is factored into two one-dimensional passes, wider than 3.5 px on a coarser grid; the first pass
//! then takes its covariance from its own pixel, which departs a little from the exact sum where the covariance changes
//! within the Gaussian (very wide filters far off the axis). `tests/pictures/ring.rs` compares with a direct
//! two-dimensional sum in f64, taken out to five standard deviations. Largest differences, in units of the display's
//! peak: 6.0e-4 for omega up to 4° on displays 30° and 73° wide; 1.2e-3 at 8° and 3.3e-3 at 20° on the latter.
//!
//! The amplitude at 1/omega is ½ to within 1.1 % for omega of four pixels and more. Below, sampling makes it depend on
//! direction: ½ along rows and columns, less on the diagonals (0.477 in the mean over directions at 2.6 px per cycle).

use crate::contract::{FrameCost, FrameInput, LINEAR_FORMAT, RenderError, Renderer, Scene};
use crate::foveation::low_pass::{
    CORRECTED_FROM_PX, CORRECTED_TO_PX, Covariance, TABLE_STEPS, TRUNCATION, effective_sigma_px, sigma_deg,
};
use crate::geometry::{Cone, GeometryUniform, PixelBox};
use crate::gpu::Gpu;
use crate::parameters::number;
use crate::pass::{self, Extent};
use crate::registry::RegistryError;
use crate::renderers::reference::ReferencePicture;
use crate::timing::GpuTimer;
use experiments::catalogue::{ParameterError, ParameterSchema, Parameters, RendererInfo, complete_parameters};
use experiments::display::Display;

pub(crate) const WGSL: &str = include_str!("ring.wgsl");

/// Between the passes sums must not be rounded to half floats, or two roundings would add up.
const WORKING_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Standard deviation, px, below which the two-dimensional sum is taken directly.
const DIRECT_BELOW_PX: f64 = 1.6;
/// Standard deviation, in steps of the coarser grid, that is kept at least.
const GRID_SIGMA: f64 = 2.5;
/// A coarser grid pays from this step on, px.
const SMALLEST_STEP_PX: f64 = 1.4;
/// Standard deviation of the low-pass before the coarser grid, in its steps: aliases stay below 1 %.
const SHRINK_SIGMA: f64 = 0.6;

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
    sigma_rad: f32,
    ring_rad: f32,
    half_width_rad: f32,
    edge_rad: f32,
    display_size: [i32; 2],
    grid_size: [i32; 2],
    grid_step: [f32; 2],
    shrink_variance: [f32; 2],
    truncation: f32,
    table_from_px: f32,
    table_to_px: f32,
    reserved: f32,
    table: [f32; TABLE_STEPS + 1],
}

/// The grid on which the wide filter works.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Method {
    /// The two-dimensional sum over the display's own pixels.
    Direct,
    /// Two passes over `size` samples that are `step_px` apart; the display's own pixels where that is 1.
    Separate { size: [u32; 2], step_px: [f64; 2], shrink_variance: [f64; 2] },
}

struct Ring {
    display: Display,
    settings: Settings,
    table: [f32; TABLE_STEPS + 1],
    reference: ReferencePicture,
    output: wgpu::Texture,
    output_view: wgpu::TextureView,
    /// Working textures, made when first needed and kept while large enough.
    coarse: Option<wgpu::Texture>,
    rows: Option<wgpu::Texture>,
    shrink: wgpu::RenderPipeline,
    along_rows: wgpu::RenderPipeline,
    ring: wgpu::RenderPipeline,
    ring_direct: wgpu::RenderPipeline,
    /// What the output shows.
    shown: Option<(Settings, [f64; 2])>,
    timer: GpuTimer,
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Renderer>, RegistryError> {
    let output = pass::linear_texture(gpu, "ring output", display.resolution_px());
    let table = std::array::from_fn(|i| {
        let share = i as f64 / TABLE_STEPS as f64;
        effective_sigma_px(CORRECTED_FROM_PX + share * (CORRECTED_TO_PX - CORRECTED_FROM_PX)) as f32
    });
    Ok(Box::new(Ring {
        display: display.clone(),
        settings: Settings::read(parameters)?,
        table,
        reference: ReferencePicture::new(gpu, display),
        output_view: pass::view(&output),
        output,
        coarse: None,
        rows: None,
        shrink: pass::pipeline(gpu, "ring shrink", WGSL, "shrink", WORKING_FORMAT),
        along_rows: pass::pipeline(gpu, "ring rows", WGSL, "along_rows", WORKING_FORMAT),
        ring: pass::pipeline(gpu, "ring", WGSL, "ring", LINEAR_FORMAT),
        ring_direct: pass::pipeline(gpu, "ring direct", WGSL, "ring_direct", LINEAR_FORMAT),
        shown: None,
        timer: GpuTimer::new(gpu),
    }))
}

impl Ring {
    /// How the filter is computed, from its narrowest place: the display's centre.
    fn method(&self) -> Method {
        let resolution = self.display.resolution_px();
        let pitch = self.display.pitch_mm();
        let sigma_rad = sigma_deg(self.settings.mar_deg).to_radians();
        let sigma_px = pitch.map(|pitch| sigma_rad * self.display.distance_mm() / pitch);
        if sigma_px[0].min(sigma_px[1]) < DIRECT_BELOW_PX {
            return Method::Direct;
        }
        let size: [u32; 2] = std::array::from_fn(|axis| {
            let step = sigma_px[axis] / GRID_SIGMA;
            let step = if step < SMALLEST_STEP_PX { 1.0 } else { step };
            ((f64::from(resolution[axis]) / step).ceil() as u32).clamp(1, resolution[axis])
        });
        let step_px: [f64; 2] = std::array::from_fn(|axis| f64::from(resolution[axis]) / f64::from(size[axis]));
        let shrink_variance = std::array::from_fn(|axis| {
            if size[axis] == resolution[axis] {
                0.0
            } else {
                (SHRINK_SIGMA * step_px[axis].min(sigma_px[axis])).powi(2)
            }
        });
        Method::Separate { size, step_px, shrink_variance }
    }

    fn uniform(&self, method: &Method, gaze_deg: [f64; 2]) -> Uniform {
        let resolution = self.display.resolution_px();
        let (grid_size, grid_step, shrink_variance) = match *method {
            Method::Direct => (resolution, [1.0; 2], [0.0; 2]),
            Method::Separate { size, step_px, shrink_variance } => (size, step_px, shrink_variance),
        };
        let settings = &self.settings;
        Uniform {
            geometry: GeometryUniform::new(&self.display, gaze_deg),
            sigma_rad: sigma_deg(settings.mar_deg).to_radians() as f32,
            ring_rad: settings.eccentricity_deg.to_radians() as f32,
            half_width_rad: (0.5 * settings.width_deg).to_radians() as f32,
            edge_rad: settings.edge_deg.max(1e-4).to_radians() as f32,
            display_size: resolution.map(|x| x as i32),
            grid_size: grid_size.map(|x| x as i32),
            grid_step: grid_step.map(|x| x as f32),
            shrink_variance: shrink_variance.map(|x| x as f32),
            truncation: TRUNCATION as f32,
            table_from_px: CORRECTED_FROM_PX as f32,
            table_to_px: CORRECTED_TO_PX as f32,
            reserved: 0.0,
            table: self.table,
        }
    }

    /// Records the filter over `bounds` of the output, which already shows the reference.
    fn filter(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, gaze_deg: [f64; 2], bounds: PixelBox) {
        let method = self.method();
        let uniform = pass::uniform(gpu, &self.uniform(&method, gaze_deg));
        let [width, height] = bounds.size();
        let shown = Extent::Rectangle([bounds.left, bounds.top, width, height]);
        let Method::Separate { size, step_px, shrink_variance } = method else {
            let bind_group = pass::bind(gpu, &self.ring_direct, &uniform, &[&self.reference.view]);
            pass::draw(encoder, &self.ring_direct, &bind_group, &self.output_view, shown);
            return;
        };

        // The part of the grid that the ring can reach.
        let needed = Extent::Rectangle(grid_rectangle(&self.display, self.settings.mar_deg, bounds, size, step_px));

        // Onto the coarser grid, unless that is the display's own.
        let shrinks = shrink_variance.iter().any(|&variance| variance > 0.0);
        let coarse_view = if shrinks {
            let target = pass::view(pass::at_least(gpu, &mut self.coarse, "ring coarse", size, WORKING_FORMAT));
            let bind_group = pass::bind(gpu, &self.shrink, &uniform, &[&self.reference.view]);
            pass::draw(encoder, &self.shrink, &bind_group, &target, needed);
            target
        } else {
            self.reference.view.clone()
        };

        // Along the rows, then along the slanted columns into the output.
        let rows_view = pass::view(pass::at_least(gpu, &mut self.rows, "ring rows", size, WORKING_FORMAT));
        let bind_group = pass::bind(gpu, &self.along_rows, &uniform, &[&coarse_view]);
        pass::draw(encoder, &self.along_rows, &bind_group, &rows_view, needed);
        let bind_group = pass::bind(gpu, &self.ring, &uniform, &[&rows_view, &self.reference.view]);
        pass::draw(encoder, &self.ring, &bind_group, &self.output_view, shown);
    }
}

/// The samples of a grid, `[left, top, width, height]`, within the filter's reach of `bounds`.
///
/// The filter is widest at one of the corners. What it reaches beyond the display is mirrored to within its reach of the
/// same edge, which the rectangle holds too.
fn grid_rectangle(display: &Display, mar_deg: f64, bounds: PixelBox, size: [u32; 2], step_px: [f64; 2]) -> [u32; 4] {
    let corners =
        [bounds.left, bounds.right].map(|x| [bounds.top, bounds.bottom].map(|y| [f64::from(x), f64::from(y)]));
    let reach = corners.iter().flatten().fold([0.0_f64; 2], |reach, &corner| {
        let here = Covariance::at(display, corner, mar_deg).reach_px();
        [reach[0].max(here[0]), reach[1].max(here[1])]
    });
    let span = |axis: usize, first: u32, end: u32| {
        // The slanted column leans by at most the reach along x, and cubic interpolation asks for two samples more.
        let low = ((f64::from(first) - reach[axis]) / step_px[axis]).floor() - 3.0;
        let high = ((f64::from(end) + reach[axis]) / step_px[axis]).ceil() + 3.0;
        let most = f64::from(size[axis]);
        let low = low.clamp(0.0, most - 1.0);
        (low as u32, (high.clamp(low + 1.0, most) - low) as u32)
    };
    let (left, width) = span(0, bounds.left, bounds.right);
    let (top, height) = span(1, bounds.top, bounds.bottom);
    [left, top, width, height]
}

impl Renderer for Ring {
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError> {
        frame.check()?;
        let wanted = Some((self.settings, frame.gaze_deg));
        if self.shown == wanted && !self.reference.is_stale(scene, frame.animation_s) {
            return Ok(FrameCost { gpu_time_s: self.timer.last_s(), ..FrameCost::default() });
        }
        self.shown = None;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.timer.begin(gpu, &mut encoder);
        let drawn = self.reference.update(gpu, &mut encoder, scene, frame.animation_s)?;
        pass::copy(&mut encoder, &self.reference.texture, &self.output);

        // The ring lies between two cones around the gaze.
        let settings = self.settings;
        let reach_deg = 0.5 * settings.width_deg + settings.edge_deg;
        let outer = Cone::new(&self.display, frame.gaze_deg, settings.eccentricity_deg + reach_deg);
        let mut filtered = 0;
        if let Some(bounds) = outer.bounds() {
            self.filter(gpu, &mut encoder, frame.gaze_deg, bounds);
            let hole_deg = settings.eccentricity_deg - reach_deg;
            let hole = if hole_deg > 0.0 { Cone::new(&self.display, frame.gaze_deg, hole_deg).pixels() } else { 0 };
            filtered = outer.pixels() - hole;
        }
        let gpu_time_s = self.timer.submit(gpu, encoder);
        gpu.check()?;
        self.shown = wanted;
        Ok(FrameCost { pixels_shaded: drawn.pixels_shaded + filtered, rays_traced: drawn.rays_traced, gpu_time_s })
    }

    fn output(&self) -> &wgpu::Texture {
        &self.output
    }

    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Vec<ParameterError>> {
        self.settings = Settings::read(&complete_parameters(&info().parameters, parameters)?)?;
        Ok(())
    }
}
