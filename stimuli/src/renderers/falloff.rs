//! Gaussian blur that grows with eccentricity: nothing is removed up to a radius r around the gaze, and beyond it the
//! picture is low-passed by a Gaussian of σ(θ) = k (θ − r) degrees (Tursun et al. 2019, §5, Eq. 14), in linear light.
//!
//! σ is in degrees of visual angle, not in pixels: the paper's largest, k (θ − r) = 0.135°, is 6.7 px on its first display.
//! Beyond 90° from the gaze, where nothing is seen, θ counts as 90°.
//!
//! # How it is made
//! The filter is the ring's: round in visual angle, its covariance taken at the pixel that is shown
//! ([`crate::foveation::low_pass`]), mirrored at the display's edges, ended at 3.5 standard deviations.
//! - Up to `SUMMED_TO_PX` it is summed at each pixel from the reference, with the pixel's own σ.
//! - Beyond, it is interpolated between low-passed pictures whose σ grow by the ratio `RATIO`: at each pixel a parabola in
//!   ln σ through the two around its σ and the next one. The pictures depend on the display and the scene alone, not on
//!   gaze, radius or rate. Each is made only in the tiles that are asked for, and kept while the scene stands still.
//!
//! # How exact it is
//! The parabola is off by at most 2.3e-3 of a grating's amplitude, at its worst frequency (computed for continuous
//! Gaussians): 1.2e-3 of the peak for a grating of full contrast. `tests/pictures/falloff.rs` compares with a direct
//! two-dimensional sum in f64, taken out to five standard deviations. Largest differences, in units of the peak, over the
//! shipped photographs: 1.4e-3 for k up to 0.02 and σ up to 7.7 px (root mean square at most 1.6e-4), 3.2e-3 for k = 0.1
//! and σ up to 40 px. On white noise of full contrast: 3.3e-3. Within the radius the picture is the reference, bit by bit.
//!
//! # What it costs
//! A frame in which only the gaze moves sums the pixels of small σ, makes the tiles that were never asked for, and mixes
//! three pictures elsewhere. Milliseconds on Mesa's software device (llvmpipe, two shared cores; a photograph;
//! `examples/frame_times.rs`): a picture's first frame, then with the gaze moving by tenths of a degree, then by 5°.
//!
//! | r, k | 960×540, 32 px per degree | 2560×1440, 50 px per degree |
//! | --- | --- | --- |
//! | 11°, 0.0017 | 29, 15, 29 | 2280, 220, 650 |
//! | 7°, 0.0035 | 260, 56, 130 | 3850, 250, 1430 |
//! | 4°, 0.0052 | 600, 68, 170 | 6040, 360, 1120 |
//!
//! A moving scene pays for the first frame every time. Each low-passed picture takes eight bytes per display pixel, and
//! its working pictures up to sixteen; there are eleven to each tenfold growth of σ, and only as many as the frame needs.

use crate::contract::{DrawCost, FrameCost, FrameInput, LINEAR_FORMAT, MakeError, RenderError, Renderer, Scene};
use crate::foveation::low_pass::SIGMA_PER_MAR;
use crate::geometry::{Cone, PixelBox};
use crate::gpu::Gpu;
use crate::parameters::number;
use crate::pass::{self, Extent};
use crate::renderers::low_passed::{GaussianUniform, LowPassed};
use crate::renderers::reference::ReferencePicture;
use crate::timing::GpuTimer;
use experiments::catalogue::{
    DetailLaw, ParameterError, ParameterSchema, Parameters, RendererInfo, complete_parameters,
};
use experiments::display::Display;

pub(crate) const WGSL: &str = concat!(include_str!("gaussian.wgsl"), "\n", include_str!("falloff.wgsl"));

/// Standard deviation, in pixels at the display's centre, up to which each pixel is summed for itself.
const SUMMED_TO_PX: f64 = 0.5;
/// Ratio of the standard deviations of neighbouring low-passed pictures.
const RATIO: f64 = 1.25;
/// Eccentricity beyond which σ grows no more, degrees.
const FARTHEST_DEG: f64 = 90.0;
/// Share by which the largest σ of a frame is taken larger, so that the shader's rounding never goes beyond it.
const SLACK: f64 = 1.001;

pub(crate) fn info() -> RendererInfo {
    RendererInfo {
        id: "gaussian-falloff".to_owned(),
        version: 1,
        about:
            "Full resolution up to a radius around the gaze; beyond it a Gaussian blur that grows with eccentricity."
                .to_owned(),
        source: "Tursun, Arabadzhiyska-Koleva, Wernikowski, Mantiuk, Seidel, Myszkowski, Didyk: \
                 Luminance-Contrast-Aware Foveated Rendering. ACM TOG 38(4), 2019"
            .to_owned(),
        parameters: vec![
            ParameterSchema::number("radius_deg", "°", 0.0..=60.0, 7.0, "Radius r of the untouched part."),
            ParameterSchema::number(
                "rate",
                "°/°",
                0.0..=0.1,
                0.0035,
                "Rate k: by how many degrees the Gaussian's standard deviation grows with each degree beyond r.",
            ),
        ],
        detail: DetailLaw::Gaussian { radius: "radius_deg".to_owned(), rate: "rate".to_owned() },
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Settings {
    radius_deg: f64,
    rate: f64,
}

impl Settings {
    fn read(parameters: &Parameters) -> Result<Self, Vec<ParameterError>> {
        Ok(Self { radius_deg: number(parameters, "radius_deg")?, rate: number(parameters, "rate")? })
    }

    /// σ_s(θ) of Eq. 14, degrees.
    fn sigma_deg(&self, eccentricity_deg: f64) -> f64 {
        (self.rate * (eccentricity_deg.min(FARTHEST_DEG) - self.radius_deg)).max(0.0)
    }

    /// The directions in which σ is at most `sigma_deg`.
    fn cone(&self, display: &Display, gaze_deg: [f64; 2], sigma_deg: f64) -> Cone {
        let radius_deg = self.radius_deg + sigma_deg / self.rate;
        if radius_deg < FARTHEST_DEG { Cone::new(display, gaze_deg, radius_deg) } else { Cone::everything(display) }
    }
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    gaussian: GaussianUniform,
    radius_rad: f32,
    rate: f32,
    from_rad: f32,
    to_rad: f32,
    ln_step: f32,
    reserved: [f32; 3],
}

struct Falloff {
    display: Display,
    settings: Settings,
    reference: ReferencePicture,
    /// The low-passed pictures from the narrowest on, as many as were needed so far.
    levels: Vec<LowPassed>,
    /// What further ones are made from; never made itself.
    blank: LowPassed,
    output: wgpu::Texture,
    output_view: wgpu::TextureView,
    summed: wgpu::RenderPipeline,
    interpolated: wgpu::RenderPipeline,
    /// What the output shows.
    shown: Option<(Settings, [f64; 2])>,
    timer: GpuTimer,
}

pub(crate) fn make(gpu: &Gpu, display: &Display, parameters: &Parameters) -> Result<Box<dyn Renderer>, MakeError> {
    let output = pass::linear_texture(gpu, "falloff output", display.resolution_px());
    Ok(Box::new(Falloff {
        display: display.clone(),
        settings: Settings::read(parameters)?,
        reference: ReferencePicture::new(gpu, display),
        levels: Vec::new(),
        blank: LowPassed::kept_as_halves(gpu, display),
        output_view: pass::view(&output),
        output,
        summed: pass::pipeline(gpu, "falloff", WGSL, "summed", LINEAR_FORMAT),
        interpolated: pass::pipeline(gpu, "falloff", WGSL, "interpolated", LINEAR_FORMAT),
        shown: None,
        timer: GpuTimer::new(gpu),
    }))
}

/// σ of low-passed picture `level`, degrees.
fn level_sigma_deg(display: &Display, level: usize) -> f64 {
    let pitch = display.pitch_mm();
    let pixel_deg = ((pitch[0] * pitch[1]).sqrt() / display.distance_mm()).to_degrees();
    SUMMED_TO_PX * pixel_deg * RATIO.powi(level as i32)
}

/// The largest eccentricity of any place on the display, degrees: that of a corner.
fn farthest_deg(display: &Display, gaze_deg: [f64; 2]) -> f64 {
    let [width, height] = display.resolution_px().map(f64::from);
    let gaze = crate::geometry::gaze_direction(display, gaze_deg);
    let angle = |corner: [f64; 2]| {
        let d = display.direction_from_mm(display.mm_from_px(corner));
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        let cos = d.iter().zip(gaze).map(|(a, b)| a * b).sum::<f64>() / length;
        cos.clamp(-1.0, 1.0).acos().to_degrees()
    };
    [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]].into_iter().map(angle).fold(0.0, f64::max)
}

impl Falloff {
    fn uniform(&self, gaze_deg: [f64; 2], from_deg: f64, to_deg: f64) -> Uniform {
        Uniform {
            gaussian: GaussianUniform::new(&self.display, gaze_deg),
            radius_rad: self.settings.radius_deg.to_radians() as f32,
            rate: self.settings.rate as f32,
            from_rad: from_deg.to_radians() as f32,
            to_rad: to_deg.to_radians() as f32,
            ln_step: RATIO.ln() as f32,
            reserved: [0.0; 3],
        }
    }

    /// Records the part of the picture that is summed from the reference, σ up to `to_deg`.
    fn sum(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, gaze_deg: [f64; 2], to_deg: f64, boxes: &[PixelBox]) {
        let uniform = pass::uniform(gpu, &self.uniform(gaze_deg, 0.0, to_deg));
        let bind_group = pass::bind(gpu, &self.summed, &uniform, &[&self.reference.view]);
        pass::draw(encoder, &self.summed, &bind_group, &self.output_view, Extent::Boxes(boxes));
    }

    /// Records the part of the picture whose σ lies between low-passed picture `level` and the next.
    fn interpolate(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        gaze_deg: [f64; 2],
        level: usize,
        boxes: &[PixelBox],
    ) {
        let sigma_deg = |level| level_sigma_deg(&self.display, level);
        while self.levels.len() < level + 3 {
            self.levels.push(self.blank.another());
        }
        let reference = &self.reference.view;
        let views: Vec<wgpu::TextureView> = (level..level + 3)
            .zip(&mut self.levels[level..])
            .map(|(level, low_passed)| {
                low_passed.update(gpu, encoder, reference, sigma_deg(level) / SIGMA_PER_MAR, boxes)
            })
            .collect();
        let views: Vec<_> = views.iter().collect();
        let uniform = pass::uniform(gpu, &self.uniform(gaze_deg, sigma_deg(level), sigma_deg(level + 1)));
        let bind_group = pass::bind(gpu, &self.interpolated, &uniform, &views);
        pass::draw(encoder, &self.interpolated, &bind_group, &self.output_view, Extent::Boxes(boxes));
    }
}

impl Renderer for Falloff {
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError> {
        frame.check()?;
        let (settings, gaze_deg) = (self.settings, frame.gaze_deg);
        let wanted = Some((settings, gaze_deg));
        let stale = self.reference.is_stale(scene, frame.animation_s);
        if self.shown == wanted && !stale {
            return Ok(FrameCost { gpu_time_s: self.timer.last_s(), ..FrameCost::default() });
        }
        self.shown = None;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.timer.begin(gpu, &mut encoder);
        let drawn = self.reference.update(gpu, &mut encoder, scene, frame.animation_s)?;
        if stale {
            self.levels.iter_mut().for_each(LowPassed::forget);
        }

        let largest_deg = SLACK * settings.sigma_deg(farthest_deg(&self.display, gaze_deg));
        let mut filtered = 0;
        if largest_deg <= 0.0 {
            pass::copy(&mut encoder, &self.reference.texture, &self.output);
        } else {
            // What is untouched, then outwards.
            let untouched = Cone::new(&self.display, gaze_deg, settings.radius_deg);
            filtered = self.display.pixels() - untouched.pixels();
            let boxes = untouched.boxes_around(None);
            pass::copy_boxes(&mut encoder, &self.reference.texture, &self.output, &boxes);
            let mut reached_deg = level_sigma_deg(&self.display, 0);
            let mut inner = settings.cone(&self.display, gaze_deg, reached_deg);
            self.sum(gpu, &mut encoder, gaze_deg, reached_deg, &inner.boxes_around(Some(&untouched)));
            let mut level = 0;
            while reached_deg < largest_deg {
                reached_deg = level_sigma_deg(&self.display, level + 1);
                let outer = settings.cone(&self.display, gaze_deg, reached_deg);
                let boxes = outer.boxes_around(Some(&inner));
                if !boxes.is_empty() {
                    self.interpolate(gpu, &mut encoder, gaze_deg, level, &boxes);
                }
                (inner, level) = (outer, level + 1);
            }
        }

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
