//! Frames shown gaze-contingently: the reference around the gaze and coarser levels outside, or one level alone.
//!
//! Where one level gives way to the next is a radius each or, where the manifest says how fine each level is, follows from
//! an acuity line: a level begins where the line m e + omega0 (Guenter 2012, Eq. 1) has reached its detail, so that the
//! picture is never coarser than the line. From there it is laid over the finer ones with a smooth edge outwards. Up to the
//! first radius the picture is the reference, bit by bit.
//!
//! The cost is that of drawing the reference: the other engine's own is not known, and blending is not counted.

use super::{FrameStore, check_size, store};
use crate::contract::{DrawCost, FrameCost, FrameInput, LINEAR_FORMAT, MakeError, RenderError, Renderer, Scene};
use crate::geometry::GeometryUniform;
use crate::gpu::Gpu;
use crate::parameters::{number, text};
use crate::pass::{self, Extent};
use crate::renderers::reference::ReferencePicture;
use crate::scenes::centred::corner_px;
use crate::timing::GpuTimer;
use experiments::catalogue::{
    DetailLaw, ParameterError, ParameterKind, ParameterSchema, Parameters, RendererInfo, complete_parameters,
};
use experiments::display::Display;
use experiments::study::frames::{FOVEATED, Frames, MOST_LEVELS, REFERENCE};
use std::sync::Arc;

pub(crate) const WGSL: &str = include_str!("frames.wgsl");

/// Radius of a level that is never shown, degrees: beyond every angle.
const NEVER_DEG: f64 = 360.0;
/// Rows of four radii in the uniform.
const ROWS: usize = MOST_LEVELS.div_ceil(4);

/// What studies see of the renderer.
pub(crate) fn info(name: &str, frames: &Frames) -> RendererInfo {
    let mut shows = vec![FOVEATED.to_owned()];
    shows.extend(frames.levels.iter().map(|level| level.name.clone()));
    let mut parameters = vec![ParameterSchema {
        name: "show".to_owned(),
        about: "Every level where it belongs around the gaze, or one of them all over.".to_owned(),
        kind: ParameterKind::Choice { options: shows, default: FOVEATED.to_owned() },
    }];
    if frames.mars_deg().is_some() {
        parameters.push(ParameterSchema::number(
            "m",
            "°/cycle/°",
            0.0..=1.0,
            0.022,
            "Slope of the acuity line that decides where each level begins.",
        ));
        parameters.push(ParameterSchema::number(
            "omega0_deg",
            "°/cycle",
            0.001..=1.0,
            1.0 / 48.0,
            "Detail limit at the fovea: intercept of the acuity line.",
        ));
    } else {
        for level in 1..frames.levels.len() {
            let about = format!("Where {} begins.", frames.levels[level].name);
            let default = (5.0 * level as f64).min(90.0);
            parameters.push(ParameterSchema::number(&radius_name(level), "°", 0.0..=90.0, default, &about));
        }
    }
    parameters.push(ParameterSchema::number(
        "edge_deg",
        "°",
        0.0..=20.0,
        1.0,
        "Width of the smooth edges, which begin at the radii.",
    ));
    RendererInfo {
        id: name.to_owned(),
        version: 1,
        about: format!("Frames of {} levels, blended around the gaze.", frames.levels.len()),
        source: frames.source.clone(),
        parameters,
        detail: frames.mars_deg().map_or(DetailLaw::Unknown, |mars_deg| DetailLaw::Levels {
            show: "show".to_owned(),
            m: "m".to_owned(),
            omega0: "omega0_deg".to_owned(),
            levels: frames.levels.iter().map(|level| level.name.clone()).zip(mars_deg).collect(),
        }),
    }
}

fn radius_name(level: usize) -> String {
    format!("radius_{level}_deg")
}

#[derive(Debug, Clone, PartialEq)]
enum Show {
    /// Where each level beside the reference begins, degrees.
    Foveated(Vec<f64>),
    /// This level, 0 for the reference.
    Level(usize),
}

#[derive(Debug, Clone, PartialEq)]
struct Settings {
    show: Show,
    edge_deg: f64,
}

impl Settings {
    fn read(frames: &Frames, parameters: &Parameters) -> Result<Self, Vec<ParameterError>> {
        let edge_deg = number(parameters, "edge_deg")?;
        let name = text(parameters, "show")?;
        let name = if name == REFERENCE { frames.levels[0].name.as_str() } else { name };
        if let Some(level) = frames.levels.iter().position(|level| level.name == name) {
            return Ok(Self { show: Show::Level(level), edge_deg });
        }
        let radii_deg = match frames.mars_deg() {
            Some(mars_deg) => {
                let (m, omega0_deg) = (number(parameters, "m")?, number(parameters, "omega0_deg")?);
                mars_deg[1..].iter().map(|mar_deg| reached_at_deg(*mar_deg, m, omega0_deg)).collect()
            }
            None => (1..frames.levels.len())
                .map(|level| number(parameters, &radius_name(level)))
                .collect::<Result<_, _>>()?,
        };
        Ok(Self { show: Show::Foveated(radii_deg), edge_deg })
    }
}

/// The eccentricity at which the line m e + omega0 reaches a detail limit, degrees.
fn reached_at_deg(mar_deg: f64, m: f64, omega0_deg: f64) -> f64 {
    if mar_deg <= omega0_deg {
        0.0
    } else if m <= 0.0 {
        NEVER_DEG
    } else {
        ((mar_deg - omega0_deg) / m).min(NEVER_DEG)
    }
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    geometry: GeometryUniform,
    corner: [i32; 2],
    size: [i32; 2],
    count: i32,
    edge_rad: f32,
    reserved: [f32; 2],
    radii_rad: [[f32; 4]; ROWS],
}

struct FramesRenderer {
    display: Display,
    store: Arc<FrameStore>,
    schemas: Vec<ParameterSchema>,
    settings: Settings,
    reference: ReferencePicture,
    /// A layer for each level beside the reference, and the frame that is in it.
    levels: wgpu::Texture,
    levels_view: wgpu::TextureView,
    held: Vec<Option<u32>>,
    output: wgpu::Texture,
    output_view: wgpu::TextureView,
    pipeline: wgpu::RenderPipeline,
    /// What the output shows.
    shown: Option<(Settings, [f64; 2], u32)>,
    timer: GpuTimer,
}

pub(crate) fn make(
    gpu: &Gpu,
    display: &Display,
    store: &Arc<FrameStore>,
    info: &RendererInfo,
    parameters: &Parameters,
) -> Result<Box<dyn Renderer>, MakeError> {
    let frames = store.frames();
    check_size(frames, display, store)?;
    let layers = frames.levels.len().saturating_sub(1).max(1);
    let [width, height] = frames.size_px;
    let levels = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("frame levels"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers as u32 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: LINEAR_FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let output = pass::linear_texture(gpu, "frames output", display.resolution_px());
    Ok(Box::new(FramesRenderer {
        display: display.clone(),
        schemas: info.parameters.clone(),
        settings: Settings::read(frames, parameters)?,
        reference: ReferencePicture::new(gpu, display),
        levels_view: levels.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        }),
        levels,
        held: vec![None; layers],
        output_view: pass::view(&output),
        output,
        pipeline: pass::pipeline(gpu, "frames", WGSL, "foveated", LINEAR_FORMAT),
        shown: None,
        timer: GpuTimer::new(gpu),
        store: Arc::clone(store),
    }))
}

impl FramesRenderer {
    /// Brings a level beside the reference to `frame`.
    fn hold(&mut self, gpu: &Gpu, level: usize, frame: u32) -> Result<(), RenderError> {
        let slot = &mut self.held[level - 1];
        if *slot != Some(frame) {
            *slot = None;
            store::upload(gpu, &self.levels, level as u32 - 1, &*self.store.picture(level, frame)?);
            *slot = Some(frame);
        }
        Ok(())
    }

    fn uniform(&self, gaze_deg: [f64; 2]) -> Uniform {
        let frames = self.store.frames();
        let (radii_deg, edge_deg) = match &self.settings.show {
            Show::Foveated(radii_deg) => (radii_deg.clone(), self.settings.edge_deg),
            Show::Level(shown) => {
                let radius_deg = |level| if level == *shown { -1.0 } else { NEVER_DEG };
                ((1..frames.levels.len()).map(radius_deg).collect(), 0.0)
            }
        };
        let mut radii_rad = [[0.0; 4]; ROWS];
        for (slot, radius_deg) in radii_rad.iter_mut().flatten().zip(&radii_deg) {
            *slot = radius_deg.to_radians() as f32;
        }
        Uniform {
            geometry: GeometryUniform::new(&self.display, gaze_deg),
            corner: corner_px(self.display.resolution_px(), frames.size_px),
            size: frames.size_px.map(|x| x as i32),
            count: radii_deg.len() as i32,
            edge_rad: edge_deg.to_radians() as f32,
            reserved: [0.0; 2],
            radii_rad,
        }
    }
}

impl Renderer for FramesRenderer {
    fn render(&mut self, gpu: &Gpu, scene: &mut dyn Scene, frame: &FrameInput) -> Result<FrameCost, RenderError> {
        frame.check()?;
        let index = self.store.frames().at(frame.animation_s);
        let settings = self.settings.clone();
        let shows_reference = matches!(settings.show, Show::Foveated(_) | Show::Level(0));
        let stale = shows_reference && self.reference.is_stale(scene, frame.animation_s);
        let wanted = Some((settings.clone(), frame.gaze_deg, index));
        if self.shown == wanted && !stale {
            return Ok(FrameCost { gpu_time_s: self.timer.last_s(), ..FrameCost::default() });
        }
        self.shown = None;
        let used: Vec<usize> = match &settings.show {
            Show::Foveated(radii_deg) => (1..=radii_deg.len()).collect(),
            Show::Level(level) => vec![*level],
        };
        for &level in used.iter().filter(|&&level| level > 0) {
            self.hold(gpu, level, index)?;
        }

        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.timer.begin(gpu, &mut encoder);
        let mut drawn = DrawCost::default();
        if shows_reference {
            drawn += self.reference.update(gpu, &mut encoder, scene, frame.animation_s)?;
        }
        if settings.show == Show::Level(0) {
            pass::copy(&mut encoder, &self.reference.texture, &self.output);
        } else {
            let uniform = pass::uniform(gpu, &self.uniform(frame.gaze_deg));
            let views = [&self.reference.view, &self.levels_view];
            let bind_group = pass::bind(gpu, &self.pipeline, &uniform, &views);
            pass::draw(&mut encoder, &self.pipeline, &bind_group, &self.output_view, Extent::All);
        }
        let gpu_time_s = self.timer.submit(gpu, encoder);
        self.store.look_ahead(&used, index);
        gpu.check()?;
        self.shown = wanted;
        Ok(drawn.in_frame(gpu_time_s))
    }

    fn output(&self) -> &wgpu::Texture {
        &self.output
    }

    fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Vec<ParameterError>> {
        self.settings = Settings::read(self.store.frames(), &complete_parameters(&self.schemas, parameters)?)?;
        Ok(())
    }
}
