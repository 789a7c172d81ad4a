//! A picture without detail finer than omega, made where it is asked for and kept there: the filter depends on the place on
//! the display and not on the gaze, so that a ring that follows the eye finds most of its pixels already made.
//!
//! Its shape is [`crate::foveation::low_pass`]'s. What it is made of depends on its width:
//! - narrow: one two-dimensional sum over the display's pixels;
//! - wider: along the rows, then along slanted columns;
//! - wider than a few pixels: shrunk onto a coarser grid by columns and by rows, filtered there as before, and enlarged by
//!   a cubic B-spline. Shrinking is a Gaussian and the spline nearly one, so their variances are taken off the filter's.
//!
//! Each stage remembers which tiles of its output are made. A sample depends on the reference picture, the display and
//! omega alone, so that it does not matter which were asked for before.

use crate::contract::LINEAR_FORMAT;
use crate::foveation::low_pass::{
    CORRECTED_FROM_PX, CORRECTED_TO_PX, Covariance, TABLE_STEPS, TRUNCATION, effective_sigma_px, sigma_deg,
};
use crate::geometry::{GeometryUniform, PixelBox};
use crate::gpu::Gpu;
use crate::pass::{self, Extent};
use crate::tiles::Tiles;
use experiments::display::Display;

pub(crate) const WGSL: &str = concat!(include_str!("gaussian.wgsl"), "\n", include_str!("low_passed.wgsl"));

/// Half floats would round at every stage, and the roundings would add up.
const WORKING_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Standard deviation, px, below which the two-dimensional sum is taken directly.
const DIRECT_BELOW_PX: f64 = 1.6;
/// Standard deviation, in steps of the coarser grid, that is kept at least.
const GRID_SIGMA: f64 = 2.0;
/// A coarser grid pays from this step on, px.
const SMALLEST_STEP_PX: f64 = 1.4;
/// Standard deviation of the low-pass before the coarser grid, in its steps: aliases stay below 1e-3.
const SHRINK_SIGMA: f64 = 0.7;
/// Variance of the uniform cubic B-spline, in steps squared.
const SPLINE_VARIANCE: f64 = 1.0 / 3.0;
/// Samples that the B-spline reads past the display's edge.
const SPLINE_MARGIN: u32 = 2;

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Uniform {
    gaussian: GaussianUniform,
    sigma_rad: f32,
    margin: f32,
    grid_size: [i32; 2],
    grid_step: [f32; 2],
    shrink_variance: [f32; 2],
    spent_variance: [f32; 2],
    reserved: [f32; 2],
}

/// `Gaussian` of `gaussian.wgsl`.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct GaussianUniform {
    geometry: GeometryUniform,
    display_size: [i32; 2],
    truncation: f32,
    reserved: f32,
    table_from_px: f32,
    table_to_px: f32,
    reserved2: [f32; 2],
    table: [f32; TABLE_STEPS + 1],
}

impl GaussianUniform {
    /// The filter's shape on `display`, with the eye turned to `gaze_deg`.
    pub(crate) fn new(display: &Display, gaze_deg: [f64; 2]) -> Self {
        let table = std::array::from_fn(|i| {
            let share = i as f64 / TABLE_STEPS as f64;
            effective_sigma_px(CORRECTED_FROM_PX + share * (CORRECTED_TO_PX - CORRECTED_FROM_PX)) as f32
        });
        Self {
            geometry: GeometryUniform::new(display, gaze_deg),
            display_size: display.resolution_px().map(|x| x as i32),
            truncation: TRUNCATION as f32,
            reserved: 0.0,
            table_from_px: CORRECTED_FROM_PX as f32,
            table_to_px: CORRECTED_TO_PX as f32,
            reserved2: [0.0; 2],
            table,
        }
    }
}

/// How the filter is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Method {
    kinds: &'static [Kind],
    /// Samples of the grid and display pixels between them; the display's own pixels unless it is coarser.
    grid_size: [u32; 2],
    step_px: [f64; 2],
    /// Variance of the low-pass before the grid, px².
    shrink_variance: [f64; 2],
    /// Variance of the enlargement after it, px².
    spline_variance: [f64; 2],
    /// Samples by which the filtered grid reaches past the display.
    margin: u32,
}

impl Method {
    /// The method for a detail limit, by the filter's narrowest place: the display's centre.
    fn new(display: &Display, mar_deg: f64) -> Self {
        let resolution = display.resolution_px();
        let sigma_rad = sigma_deg(mar_deg).to_radians();
        let sigma_px = display.pitch_mm().map(|pitch| sigma_rad * display.distance_mm() / pitch);
        let on_display = Self {
            kinds: &[Kind::Direct],
            grid_size: resolution,
            step_px: [1.0; 2],
            shrink_variance: [0.0; 2],
            spline_variance: [0.0; 2],
            margin: 0,
        };
        if sigma_px[0].min(sigma_px[1]) < DIRECT_BELOW_PX {
            return on_display;
        }
        let grid_size: [u32; 2] = std::array::from_fn(|axis| {
            let step = sigma_px[axis] / GRID_SIGMA;
            let step = if step < SMALLEST_STEP_PX { 1.0 } else { step };
            ((f64::from(resolution[axis]) / step).ceil() as u32).clamp(1, resolution[axis])
        });
        if grid_size == resolution {
            return Self { kinds: &[Kind::Rows, Kind::Columns], ..on_display };
        }
        let step_px: [f64; 2] = std::array::from_fn(|axis| f64::from(resolution[axis]) / f64::from(grid_size[axis]));
        let shrink_sigma_px =
            |axis: usize| if grid_size[axis] == resolution[axis] { 0.0 } else { SHRINK_SIGMA * step_px[axis] };
        Self {
            kinds: &[Kind::ShrinkColumns, Kind::ShrinkRows, Kind::Rows, Kind::Columns, Kind::Enlarge],
            grid_size,
            step_px,
            shrink_variance: std::array::from_fn(|axis| shrink_sigma_px(axis).powi(2)),
            spline_variance: step_px.map(|step| SPLINE_VARIANCE * step * step),
            margin: SPLINE_MARGIN,
        }
    }

    /// The size of what a stage makes.
    fn output_size(&self, kind: Kind, resolution: [u32; 2]) -> [u32; 2] {
        match kind {
            Kind::ShrinkColumns => [self.grid_size[0], resolution[1]],
            Kind::ShrinkRows | Kind::Rows => self.grid_size,
            Kind::Columns => self.grid_size.map(|x| x + 2 * self.margin),
            Kind::Enlarge | Kind::Direct => resolution,
        }
    }

    /// The samples of its source that a stage reads for `made` of its output.
    ///
    /// What it reads past an edge is mirrored to within its reach of the same edge, which the box holds too.
    fn read_by(&self, kind: Kind, made: PixelBox, source_size: [u32; 2], filter: &Filter<'_>) -> PixelBox {
        let margin = f64::from(self.margin);
        // Source samples per sample, source coordinate of the output's edge, and reach in source samples, on each axis.
        let (scale, origin, reach) = match kind {
            // They read the reference, which is whole.
            Kind::Direct | Kind::ShrinkColumns => ([1.0; 2], 0.0, [0.0; 2]),
            Kind::ShrinkRows => ([1.0, self.step_px[1]], 0.0, [0.0, TRUNCATION * self.shrink_variance[1].sqrt() + 1.0]),
            Kind::Rows => ([1.0; 2], 0.0, [self.reach(made, 0.0, filter)[0], 0.0]),
            Kind::Columns => ([1.0; 2], -margin, self.reach(made, margin, filter).map(|reach| reach + 2.0 * margin)),
            Kind::Enlarge => (self.step_px.map(|step| 1.0 / step), margin, [2.5; 2]),
        };
        let span = |axis: usize, first: u32, end: u32| {
            let low = (f64::from(first) * scale[axis] + origin - reach[axis]).floor();
            let high = (f64::from(end) * scale[axis] + origin + reach[axis]).ceil();
            let most = f64::from(source_size[axis]);
            let low = low.clamp(0.0, most - 1.0);
            (low as u32, high.clamp(low + 1.0, most) as u32)
        };
        let (left, right) = span(0, made.left, made.right);
        let (top, bottom) = span(1, made.top, made.bottom);
        PixelBox { left, top, right, bottom }
    }

    /// How far the filter reaches from within a box of the grid with its margin, in samples of the grid. It is widest at
    /// one of the corners; the slanted column leans by at most the reach along x, and cubic interpolation asks for two
    /// samples more.
    fn reach(&self, made: PixelBox, margin: f64, filter: &Filter<'_>) -> [f64; 2] {
        let mut reach = [0.0_f64; 2];
        for x in [made.left, made.right] {
            for y in [made.top, made.bottom] {
                let at_px = [(f64::from(x) - margin) * self.step_px[0], (f64::from(y) - margin) * self.step_px[1]];
                let here = Covariance::at(filter.display, at_px, filter.mar_deg).reach_px();
                reach = std::array::from_fn(|axis| reach[axis].max(here[axis] / self.step_px[axis] + 3.0));
            }
        }
        reach
    }
}

/// What is filtered how strongly.
struct Filter<'a> {
    display: &'a Display,
    mar_deg: f64,
}

/// What a stage does; see the shader's functions of the same names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Direct,
    ShrinkColumns,
    ShrinkRows,
    Rows,
    Columns,
    Enlarge,
}

/// Every kind with its entry, and whether it makes the result; the columns do where there is no coarser grid.
const KINDS: [(Kind, &str, bool); 7] = [
    (Kind::Direct, "direct", true),
    (Kind::ShrinkColumns, "shrink_columns", false),
    (Kind::ShrinkRows, "shrink_rows", false),
    (Kind::Rows, "along_rows", false),
    (Kind::Columns, "along_columns", false),
    (Kind::Columns, "along_columns", true),
    (Kind::Enlarge, "enlarge", true),
];

/// One kind of stage, ready to run: its pipeline, and its working texture, made when first needed and kept while large
/// enough.
struct Workshop {
    kind: Kind,
    is_last: bool,
    format: wgpu::TextureFormat,
    pipeline: wgpu::RenderPipeline,
    texture: Option<wgpu::Texture>,
}

/// A stage at one detail limit.
struct Stage {
    kind: Kind,
    is_last: bool,
    source_size: [u32; 2],
    tiles: Tiles,
    bind_group: wgpu::BindGroup,
    target: wgpu::TextureView,
}

/// The stages at one detail limit, from the reference to the filtered picture.
struct Chain {
    mar_deg: f64,
    method: Method,
    stages: Vec<Stage>,
    filtered: wgpu::TextureView,
}

/// The low-passed picture of one display.
pub(crate) struct LowPassed {
    display: Display,
    gaussian: GaussianUniform,
    workshops: Vec<Workshop>,
    chain: Option<Chain>,
}

impl LowPassed {
    /// Nothing made yet. The result is kept as full floats.
    pub(crate) fn new(gpu: &Gpu, display: &Display) -> Self {
        Self::kept_as(gpu, display, WORKING_FORMAT)
    }

    /// Nothing made yet. The result is kept as half floats, which takes half the memory and rounds once more.
    pub(crate) fn kept_as_halves(gpu: &Gpu, display: &Display) -> Self {
        Self::kept_as(gpu, display, LINEAR_FORMAT)
    }

    fn kept_as(gpu: &Gpu, display: &Display, result_format: wgpu::TextureFormat) -> Self {
        let workshop = |&(kind, entry, is_last): &(Kind, &str, bool)| {
            let format = if is_last { result_format } else { WORKING_FORMAT };
            let rounds = [("ROUNDS", f64::from(u8::from(format != WORKING_FORMAT)))];
            let pipeline = pass::pipeline_with(gpu, entry, WGSL, entry, format, &rounds);
            Workshop { kind, is_last, format, pipeline, texture: None }
        };
        Self {
            display: display.clone(),
            gaussian: GaussianUniform::new(display, [0.0; 2]),
            workshops: KINDS.iter().map(workshop).collect(),
            chain: None,
        }
    }

    /// Another one with the same pipelines and nothing made yet, for a second detail limit at the same time.
    pub(crate) fn another(&self) -> Self {
        let workshop = |w: &Workshop| Workshop { pipeline: w.pipeline.clone(), texture: None, ..*w };
        Self {
            display: self.display.clone(),
            gaussian: self.gaussian,
            workshops: self.workshops.iter().map(workshop).collect(),
            chain: None,
        }
    }

    /// Forgets what was made, because the reference picture is another.
    pub(crate) fn forget(&mut self) {
        for stage in self.chain.iter_mut().flat_map(|chain| &mut chain.stages) {
            stage.tiles.clear();
        }
    }

    /// Records what is missing of the low-passed `reference` in the boxes of `wanted`, and returns the picture, which holds
    /// it there and anything elsewhere.
    pub(crate) fn update(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        reference: &wgpu::TextureView,
        mar_deg: f64,
        wanted: &[PixelBox],
    ) -> wgpu::TextureView {
        let mut chain = match self.chain.take().filter(|chain| chain.mar_deg == mar_deg) {
            Some(chain) => chain,
            None => self.new_chain(gpu, reference, mar_deg),
        };

        // What each stage has to make, from the last one back.
        let filter = Filter { display: &self.display, mar_deg };
        let mut missing = Vec::with_capacity(chain.stages.len());
        let mut wanted = wanted.to_vec();
        for stage in chain.stages.iter_mut().rev() {
            let boxes = stage.tiles.take_missing(&wanted);
            wanted =
                boxes.iter().map(|&made| chain.method.read_by(stage.kind, made, stage.source_size, &filter)).collect();
            missing.push(boxes);
        }
        for (stage, boxes) in chain.stages.iter().zip(missing.iter().rev()) {
            let workshop = self.workshops.iter().find(|w| (w.kind, w.is_last) == (stage.kind, stage.is_last));
            if let Some(workshop) = workshop.filter(|_| !boxes.is_empty()) {
                pass::draw(encoder, &workshop.pipeline, &stage.bind_group, &stage.target, Extent::Boxes(boxes));
            }
        }
        self.chain.insert(chain).filtered.clone()
    }

    fn new_chain(&mut self, gpu: &Gpu, reference: &wgpu::TextureView, mar_deg: f64) -> Chain {
        let resolution = self.display.resolution_px();
        let method = Method::new(&self.display, mar_deg);
        let uniform = pass::uniform(gpu, &self.uniform(&method, mar_deg));
        let mut stages = Vec::with_capacity(method.kinds.len());
        let (mut source, mut source_size) = (reference.clone(), resolution);
        for (index, &kind) in method.kinds.iter().enumerate() {
            let size = method.output_size(kind, resolution);
            let is_last = index + 1 == method.kinds.len();
            let Some(workshop) = self.workshops.iter_mut().find(|w| (w.kind, w.is_last) == (kind, is_last)) else {
                continue;
            };
            let bind_group = pass::bind(gpu, &workshop.pipeline, &uniform, &[&source]);
            let target = pass::view(pass::at_least(gpu, &mut workshop.texture, "low-passed", size, workshop.format));
            stages.push(Stage {
                kind,
                is_last,
                source_size,
                tiles: Tiles::new(size),
                bind_group,
                target: target.clone(),
            });
            (source, source_size) = (target, size);
        }
        Chain { mar_deg, method, stages, filtered: source }
    }

    fn uniform(&self, method: &Method, mar_deg: f64) -> Uniform {
        let spent = |axis: usize| method.shrink_variance[axis] + method.spline_variance[axis];
        Uniform {
            gaussian: self.gaussian,
            sigma_rad: sigma_deg(mar_deg).to_radians() as f32,
            margin: method.margin as f32,
            grid_size: method.grid_size.map(|x| x as i32),
            grid_step: method.step_px.map(|x| x as f32),
            shrink_variance: method.shrink_variance.map(|x| x as f32),
            spent_variance: std::array::from_fn(|axis| spent(axis) as f32),
            reserved: [0.0; 2],
        }
    }
}
