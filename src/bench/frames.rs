//! The frames themselves: each renderer with a scene of its own, in turns with the others and timed, then once more and
//! counted on the GPU.

use super::{Entrant, Request, WARM_UP_FRAMES};
use crate::error::LabError;
use std::time::Instant;
use stimuli::contract::{
    DrawCost, DrawRequest, FrameCost, FrameInput, LayerCost, RenderError, Renderer, Scene, SceneIdentity, SceneLight,
};
use stimuli::gpu::Gpu;
use stimuli::registry;
use stimuli::surfaces::Surfaces;
use stimuli::tally::{DrawCount, Tallied, Tally};

/// A renderer and the scene that it draws.
pub(super) struct Contender {
    renderer: Box<dyn Renderer>,
    scene: Watched,
}

/// What one frame of one renderer cost.
#[derive(Debug, Clone, Default)]
pub(super) struct Frame {
    /// What the renderer says.
    pub(super) cost: FrameCost,
    /// What the scene says of all its drawings in the frame.
    pub(super) drawn: DrawCost,
    /// What was counted of each of those drawings; empty in the timed pass.
    pub(super) counts: Vec<DrawCount>,
    /// From the call to the end of its work on the GPU, seconds.
    pub(super) wall_s: f64,
    /// The renderer's layers.
    pub(super) layers: Vec<LayerCost>,
}

/// A scene that always moves and adds up what its drawings cost.
struct Watched {
    scene: Box<dyn Scene>,
    identity: SceneIdentity,
    drawn: DrawCost,
    tally: Option<Tally>,
}

impl Scene for Watched {
    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &DrawRequest<'_>,
        target: &wgpu::TextureView,
    ) -> Result<DrawCost, RenderError> {
        let cost = match &self.tally {
            Some(tally) => Tallied::new(self.scene.as_mut(), tally).draw(gpu, encoder, request, target),
            None => self.scene.draw(gpu, encoder, request, target),
        }?;
        self.drawn += cost;
        Ok(cost)
    }

    fn surfaces(&mut self) -> Option<&mut dyn Surfaces> {
        self.scene.surfaces()
    }

    fn light(&self) -> SceneLight {
        self.scene.light()
    }

    fn picture_changes(&self, from_s: f64, to_s: f64) -> bool {
        from_s != to_s || self.scene.picture_changes(from_s, to_s)
    }

    fn identity(&self) -> SceneIdentity {
        self.identity
    }
}

impl Contender {
    pub(super) fn new(gpu: &Gpu, request: &Request, entrant: &Entrant) -> Result<Self, LabError> {
        let scene = registry::make_scene(gpu, &request.display, &request.scene, &request.scene_parameters)?;
        let renderer = registry::make_renderer(gpu, &request.display, &entrant.renderer, &entrant.parameters)?;
        let scene = Watched { scene, identity: SceneIdentity::new(), drawn: DrawCost::default(), tally: None };
        Ok(Self { renderer, scene })
    }

    /// Begins anew: nothing that was drawn before is used again.
    fn begin(&mut self) {
        self.scene.identity = SceneIdentity::new();
        self.renderer.begin();
    }

    fn render(&mut self, gpu: &Gpu, input: &FrameInput) -> Result<Frame, LabError> {
        self.scene.drawn = DrawCost::default();
        let begin = Instant::now();
        let cost = self.renderer.render(gpu, &mut self.scene, input)?;
        gpu.wait()?;
        let wall_s = begin.elapsed().as_secs_f64();
        let layers = self.renderer.layer_costs().to_vec();
        Ok(Frame { cost, drawn: self.scene.drawn, counts: Vec::new(), wall_s, layers })
    }

    /// The same frame, counted; its times mean nothing.
    fn render_counted(&mut self, gpu: &Gpu, size_px: [u32; 2], input: &FrameInput) -> Result<Frame, LabError> {
        self.scene.tally = Some(Tally::new(gpu, size_px));
        let frame = self.render(gpu, input);
        let tally = self.scene.tally.take();
        let counts = tally.map(|tally| tally.counts(gpu)).transpose()?;
        Ok(Frame { counts: counts.map_or_else(Vec::new, |counts| counts.draws), ..frame? })
    }
}

/// The renderers in turns, timed: for each of them the frames that count.
pub(super) fn timed(
    gpu: &Gpu,
    request: &Request,
    contenders: &mut [Contender],
    step: &dyn Fn(),
) -> Result<Vec<Vec<Frame>>, LabError> {
    contenders.iter_mut().for_each(Contender::begin);
    let mut measured = vec![Vec::new(); contenders.len()];
    for index in 0..request.all_frames() {
        let input = input(request, index);
        // Another one begins each time, so that none always follows the same one.
        for turn in 0..contenders.len() {
            let who = (turn + index as usize) % contenders.len();
            let frame = contenders[who].render(gpu, &input)?;
            if index >= WARM_UP_FRAMES {
                measured[who].push(frame);
            }
            step();
        }
    }
    Ok(measured)
}

/// The same frames, counted.
pub(super) fn counted(
    gpu: &Gpu,
    request: &Request,
    contenders: &mut [Contender],
    step: &dyn Fn(),
) -> Result<Vec<Vec<Frame>>, LabError> {
    let size_px = request.display.resolution_px();
    let count = |contender: &mut Contender| {
        contender.begin();
        let mut frames = Vec::new();
        for index in 0..request.all_frames() {
            let input = input(request, index);
            if index < WARM_UP_FRAMES {
                contender.render(gpu, &input)?;
            } else {
                frames.push(contender.render_counted(gpu, size_px, &input)?);
            }
            step();
        }
        Ok(frames)
    };
    contenders.iter_mut().map(count).collect()
}

/// What a renderer is told of frame `index`.
fn input(request: &Request, index: u32) -> FrameInput {
    let t_s = f64::from(index) / request.fps;
    let gaze_deg = request.gaze.at(t_s);
    let before_deg = request.gaze.at((t_s - 1.0 / request.fps).max(0.0));
    FrameInput {
        gaze_deg,
        gaze_motion_deg_s: [0, 1].map(|axis| (gaze_deg[axis] - before_deg[axis]) * request.fps),
        frame_index: u64::from(index),
        animation_s: t_s,
    }
}
