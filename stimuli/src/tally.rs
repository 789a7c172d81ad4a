//! Counting on the GPU what was shaded, instead of believing what is computed: pixels and runs of a shading function for
//! each draw, and for each display pixel how many runs fell on it, which is the heat map of `parafovea render`.
//!
//! [`Tallied`] is a scene that counts whatever draws it, so that no renderer needs to know that it is being counted.
//! Counting costs time; frames that are counted are not timed.

use crate::contract::{DrawCost, DrawRequest, LINEAR_FORMAT, RenderError, Scene, SceneIdentity, SceneLight, View};
use crate::gpu::{Gpu, GpuError};
use crate::pass::{self, Extent};
use std::sync::atomic::{AtomicU32, Ordering};

pub(crate) const WGSL: &str = concat!(include_str!("tally.wgsl"), "\n", include_str!("tally_view.wgsl"));

/// Draws that one tally tells apart; what is drawn beyond counts to the last.
const MOST_DRAWS: u32 = 64;

/// Counters on the GPU for the draws of one or more frames on one display.
#[derive(Debug)]
pub struct Tally {
    size_px: [u32; 2],
    totals: wgpu::Buffer,
    runs: wgpu::Buffer,
    draws: AtomicU32,
    pipeline: wgpu::RenderPipeline,
}

/// What a tally counted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Counts {
    /// Of each draw, in order.
    pub draws: Vec<DrawCount>,
    /// Of each display pixel, row by row from the top: runs of the shading function that fell on it.
    pub runs: Vec<u32>,
}

/// What was counted of one draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawCount {
    /// Pixels of the target that were drawn.
    pub pixels: u32,
    /// Runs of the shading function: more than pixels where surfaces hide others that were shaded before, and at edges.
    pub runs: u32,
}

impl Counts {
    /// Pixels of all draws.
    #[must_use]
    pub fn pixels(&self) -> u64 {
        self.draws.iter().map(|draw| u64::from(draw.pixels)).sum()
    }

    /// What was counted after `before`, which is of the same tally.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        // Counters of the GPU begin again at zero after 2^32, and so does their difference.
        let less = |now: u32, then: Option<u32>| now.wrapping_sub(then.unwrap_or(0));
        let draws = self.draws.iter().enumerate().map(|(i, now)| {
            let then = before.draws.get(i);
            DrawCount {
                pixels: less(now.pixels, then.map(|count| count.pixels)),
                runs: less(now.runs, then.map(|count| count.runs)),
            }
        });
        Self {
            draws: draws.collect(),
            runs: self.runs.iter().enumerate().map(|(i, &now)| less(now, before.runs.get(i).copied())).collect(),
        }
    }
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct TallyUniform {
    size: [u32; 2],
    draw: u32,
    reserved: u32,
}

#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct ViewUniform {
    origin_px: [f32; 2],
    step_px: [f32; 2],
    runs: u32,
    reserved: [u32; 7],
}

impl Tally {
    /// Counters at zero, for a display of `size_px`.
    #[must_use]
    pub fn new(gpu: &Gpu, size_px: [u32; 2]) -> Self {
        let counters = |label, count: u64| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: 4 * count.max(1),
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self {
            size_px,
            totals: counters("totals", u64::from(2 * MOST_DRAWS)),
            runs: counters("runs", u64::from(size_px[0]) * u64::from(size_px[1])),
            draws: AtomicU32::new(0),
            pipeline: pass::pipeline(gpu, "tally", WGSL, "count", LINEAR_FORMAT),
        }
    }

    /// Counts a view whose every pixel ran its shading function once.
    pub fn count_view(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, view: &View) {
        self.count(gpu, encoder, view, true);
    }

    /// Counts the pixels of a view; the runs are counted by the scene's own shader.
    pub(crate) fn count_pixels(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, view: &View) {
        self.count(gpu, encoder, view, false);
    }

    fn count(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, view: &View, runs: bool) {
        let uniform = ViewUniform {
            origin_px: view.origin_px.map(|x| x as f32),
            step_px: view.step_px().map(|x| x as f32),
            runs: u32::from(runs),
            reserved: [0; 7],
        };
        let target = pass::view(&pass::linear_texture(gpu, "counted", view.target_px));
        let bind_group = pass::bind(gpu, &self.pipeline, &pass::uniform(gpu, &uniform), &[]);
        let counters = self.bind(gpu, &self.pipeline.get_bind_group_layout(1));
        pass::draw_with(encoder, &self.pipeline, &[&bind_group, &counters], &target, Extent::Corner(view.target_px));
    }

    /// The counters as group 1 of a pipeline whose layout of that group is `layout`.
    pub(crate) fn bind(&self, gpu: &Gpu, layout: &wgpu::BindGroupLayout) -> wgpu::BindGroup {
        let draw = self.draws.load(Ordering::Relaxed).saturating_sub(1).min(MOST_DRAWS - 1);
        let uniform = pass::uniform(gpu, &TallyUniform { size: self.size_px, draw, reserved: 0 });
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("tally"),
            layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: self.totals.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 2, resource: self.runs.as_entire_binding() },
            ],
        })
    }

    /// Brings the counts back, waiting for the GPU.
    ///
    /// # Errors
    /// When the device fails.
    pub fn counts(&self, gpu: &Gpu) -> Result<Counts, GpuError> {
        let totals = words(gpu, &self.totals)?;
        let draws = self.draws.load(Ordering::Relaxed).min(MOST_DRAWS) as usize;
        Ok(Counts {
            draws: totals.chunks_exact(2).take(draws).map(|c| DrawCount { pixels: c[0], runs: c[1] }).collect(),
            runs: words(gpu, &self.runs)?,
        })
    }
}

fn words(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u32>, GpuError> {
    let bytes = crate::readback::buffer_bytes(gpu, buffer)?;
    Ok(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
}

/// A scene that counts what draws it.
pub struct Tallied<'a> {
    scene: &'a mut dyn Scene,
    tally: &'a Tally,
    identity: SceneIdentity,
}

impl<'a> Tallied<'a> {
    /// `scene`, counted into `tally`. It is another scene to renderers, so that nothing kept is taken for drawn.
    #[must_use]
    pub fn new(scene: &'a mut dyn Scene, tally: &'a Tally) -> Self {
        Self { scene, tally, identity: SceneIdentity::new() }
    }
}

impl std::fmt::Debug for Tallied<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tallied").field("tally", self.tally).finish_non_exhaustive()
    }
}

impl Scene for Tallied<'_> {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        self.tally.draws.fetch_add(1, Ordering::Relaxed);
        self.scene.draw(gpu, encoder, &DrawRequest { tally: Some(self.tally), ..*request }, target)
    }

    fn light(&self) -> SceneLight {
        self.scene.light()
    }

    fn picture_changes(&self, from_s: f64, to_s: f64) -> bool {
        self.scene.picture_changes(from_s, to_s)
    }

    fn identity(&self) -> SceneIdentity {
        self.identity
    }
}
